"""Which frames of two trajectories belong together, and what keeps them from being compared."""

from __future__ import annotations

from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from crosscheck.compare.units import factor, is_reduced
from crosscheck.errors import UsageError
from crosscheck.files import shown_path
from crosscheck.trajectories.frames import Floats, Integers, Series, Source

#: By what frames are matched.
Clock = Literal["time", "step", "order"]
#: Times of 32 bits, and times that a code has summed up in them, differ by units of the last of these bits.
TIME_ROUNDING = 2.0**-21


class Pairing(NamedTuple):
    """K pairs of frames. first, second: numbers of the frames, (K,), in the order of their clock.

    clock: by what they are matched. times: (K,), of the first trajectory, in its unit; of clocks other than time, the
    step or the number of the frame. steps: (K,), or None. length, velocity, spin, time: what the second trajectory's
    numbers are multiplied by to be in the units of the first. remarks: whole sentences.
    """

    first: Integers
    second: Integers
    clock: Clock
    times: Floats
    steps: Integers | None
    length: float
    velocity: float
    spin: float
    time: float
    remarks: tuple[str, ...]


def pair(one: Source, other: Source) -> Pairing:
    """The frames of two trajectories that belong together: by time, by step, or else by their order.

    one, other: the trajectories. Duplicated and unordered frames are told, and of duplicates the last one is taken.
    UsageError if their units cannot be converted, or if no frames belong together.
    """
    factors = {}
    for quantity in ("length", "velocity", "time"):
        units = getattr(other.units, quantity), getattr(one.units, quantity)
        found = factor(*units)
        if quantity == "time" and (units[0] == "step") != (units[1] == "step"):
            found = float("nan")  # steps on one side, times on the other: matched otherwise
        if found is None:
            raise UsageError(
                f"{shown_path(other.path)}: its {quantity} is in {units[0]}, that of {shown_path(one.path)} in "
                f"{units[1]}: these cannot be compared; convert one of them"
            )
        factors[quantity] = found
    remarks = []
    if is_reduced(one.units.length) != is_reduced(other.units.length) and one.units.length and other.units.length:
        remarks.append("one file is in reduced units, the other is not: numbers are taken as they stand.")
    for quantity in ("length", "velocity"):
        if factors[quantity] != 1:
            remarks.append(
                f"the {quantity} of {other.path.name} is converted from {getattr(other.units, quantity)} to"
                f" {getattr(one.units, quantity)}."
            )
    clock, here, there = _clock(one, other, factors["time"])
    if clock == "order" and max(len(one), len(other)) > 1:
        remarks.append("their frames state no times or steps that can be compared: they are matched by their order.")
    first, second, told = _common(one.path, here, other.path, there, clock)
    remarks += told
    steps = None if one.steps is None else one.steps[first]
    return Pairing(
        first,
        second,
        clock,
        here[first],
        steps,
        factors["length"],
        factors["velocity"],
        _of_spins(one, other, factors),
        factors["time"],
        tuple(remarks),
    )


def _of_spins(one: Source, other: Source, factors: dict[str, float]) -> float:
    """The factor of angular velocities, 1/time, in the unit of time that velocities have: a file may have steps in
    place of times."""
    named = all(source.units.length and source.units.velocity for source in (one, other))
    return factors["velocity"] / factors["length"] if named else 1.0


def matched_rows(one: Series, other: Series) -> tuple[Integers, Integers, list[str]]:
    """Numbers of the rows of two tables that are of the same time, and whole sentences on what is left out.

    one, other: the tables. UsageError if no row of one is of the time of a row of the other.
    """
    return _common(one.path, one.time, other.path, other.time, "time")


def _common(one: Path, here: Floats, other: Path, there: Floats, clock: str) -> tuple[Integers, Integers, list[str]]:
    """Numbers of the frames at the same times, and sentences on those that are in no order, double, or alone."""
    remarks, chosen = [], []
    for path, values in ((one, here), (other, there)):
        order, told = _ordered(values, path)
        remarks += told
        chosen.append(order)
    first, second = _matched(here, there, *chosen)
    if not len(first):
        raise UsageError(
            f"{shown_path(one)} and {shown_path(other)}: no frame of one has the {clock} of a frame of the other "
            f"({_span(here)} and {_span(there)}): compare runs with common output times"
        )
    for path, order, taken in ((one, chosen[0], first), (other, chosen[1], second)):
        left = len(order) - len(taken)
        if left:
            remarks.append(f"{left} of {len(order)} frames of {path.name} have no counterpart.")
    return first, second, remarks


def _clock(one: Source, other: Source, time_factor: float) -> tuple[Clock, Floats, Floats]:
    """By what frames are matched, and that of each frame; steps that stand in place of times are no times."""
    timed = [np.isfinite(source.times).all() and source.units.time != "step" for source in (one, other)]
    if all(timed) and np.isfinite(time_factor):
        return "time", one.times, other.times * time_factor
    if one.steps is not None and other.steps is not None:
        return "step", one.steps.astype(np.float64), other.steps.astype(np.float64)
    return "order", np.arange(len(one), dtype=np.float64), np.arange(len(other), dtype=np.float64)


def _ordered(values: Floats, path: Path) -> tuple[Integers, list[str]]:
    """Numbers of the frames in the order of their clock, the last one of several at one time; and what to say of it."""
    order = np.argsort(values, kind="stable")
    told = []
    if (np.diff(values) < 0).any():
        at = int(np.flatnonzero(np.diff(values) < 0)[0]) + 1
        told.append(f"{path.name}: frame {at} (counted from 0) is earlier than the one before: frames are sorted.")
    ordered = values[order]
    last = np.append(np.diff(ordered) > _close(ordered[1:]), True)
    if not last.all():
        at = int(np.flatnonzero(~last)[0])
        told.append(
            f"{path.name}: frames {order[at]} and {order[at + 1]} (counted from 0) are of one time"
            f" ({ordered[at]:g}), and {int((~last).sum()) - 1} more are duplicates: the last of each is taken."
        )
    return order[last], told


def _close(times: Floats) -> Floats:
    """The largest difference of two times that are the same."""
    return np.asarray(TIME_ROUNDING * np.abs(times))


def _matched(here: Floats, there: Floats, mine: Integers, others: Integers) -> tuple[Integers, Integers]:
    """Numbers of the frames at the same times. here, there: clocks. mine, others: frames in the order of them."""
    place = np.searchsorted(there[others], here[mine])
    first, second = [], []
    for frame, at in zip(mine, place, strict=True):
        near = [others[k] for k in (at - 1, at) if 0 <= k < len(others)]
        best = min(near, key=lambda k: abs(there[k] - here[frame]))
        if abs(there[best] - here[frame]) <= TIME_ROUNDING * abs(here[frame]):
            first.append(frame)
            second.append(best)
    return np.array(first, dtype=np.int64), np.array(second, dtype=np.int64)


def _span(values: Floats) -> str:
    return f"{np.min(values):g} to {np.max(values):g}"
