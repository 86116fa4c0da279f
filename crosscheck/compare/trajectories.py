"""Compares two trajectories: what they are to each other, and all that this rests on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from crosscheck.compare.differences import Difference, Gap, frames_of, gaps, nearest_image, roundings_of, spacing
from crosscheck.compare.growth import Growth, Rate, Separation, chaos_line, growth
from crosscheck.compare.momentum import momentum_parting
from crosscheck.compare.outcome import Class, Evidence, Mode, classify, moment
from crosscheck.compare.pairing import Clock, Pairing, pair
from crosscheck.compare.samples import FEWEST, START, Tested, compare_samples
from crosscheck.compare.setup import different_setup
from crosscheck.trajectories.frames import DOUBLE, Floats, Frame, Source

#: A start that differs by no more than this, in distances of neighbours, is one that was disturbed or rounded: the
#: separation then grows as small ones do over half the digits of a double.
_DISTURBANCE = DOUBLE.relative**0.5
#: Neighbours that are named, and particles that are drawn.
_NAMED, _DRAWN = 3, 40


@dataclass(frozen=True)
class Neighbourhood:
    """Particles around the one that is farthest from itself, where two runs part.

    pair: number of the pair of frames. particle: its id. ids: (n,) of the particles, this one first. first, second:
    their positions in both runs relative to this particle in the first, (n, 3), length. radius: of a circle that stands
    for a particle.
    """

    pair: int
    particle: int
    ids: list[int]
    first: Floats
    second: Floats
    radius: float


@dataclass(frozen=True)
class Comparison:
    """Two trajectories, and what they are to each other.

    first, second: their names. formats: of the files. classed, sentence: see `outcome.classify`. clock: by what frames
    are matched. gaps: of each pair of frames. setup: what is different in the set-up. bits, beyond: the first component
    whose bits differ, and the first one beyond the files' rounding. separation, growth: see there. line: the largest
    separation that rounding and chaos explain, (K,), or None. tested: statistics. neighbourhood: where they part.
    remarks: whole sentences on the files and their frames. particles: in the first frame of the first. steps: of the
    frames, or None.
    """

    first: str
    second: str
    formats: tuple[str, str]
    classed: Class
    sentence: str
    clock: Clock
    gaps: list[Gap]
    setup: list[str]
    bits: Difference | None
    beyond: Difference | None
    separation: Separation
    growth: Growth | None
    line: Floats | None
    tested: list[Tested] | None
    neighbourhood: Neighbourhood | None
    remarks: tuple[str, ...]
    particles: int
    steps: list[int] | None

    def when(self, pair: int) -> str:
        """The moment of a pair of frames, in words. pair: its number."""
        return moment(self.clock, self.gaps[pair].time, None if self.steps is None else self.steps[pair])


def compare_trajectories(
    one: Source,
    other: Source,
    mode: Mode = "chaos",
    *,
    arithmetic: str = "double",
    rate: Rate | None = None,
    tolerance: float | None = None,
    progress: Callable[[int, int], Any] = lambda done, total: None,
) -> Comparison:
    """Compares two trajectories; two frames are in memory at a time, and a few numbers of each.

    one, other: the trajectories. mode: the standard that is asked for; with "exact" and "tolerance", statistics are not
    looked at. arithmetic: "double" or "single", of the runs. rate: growth rate of separations,
    where it was measured by other runs; None: it follows from the separation. tolerance: with mode "tolerance", a
    distance that counts as the same, in the unit of the first; None: what the files' rounding allows. progress: is told
    the number of frames done, and of all.

    UsageError if nothing can be compared.
    """
    pairing = pair(one, other)
    total = len(pairing.first)
    first, second = frames_of(one, other, pairing, 0)
    setup = different_setup(first, second, roundings_of(one, other, pairing))
    found: list[Gap] = []
    for gap in gaps(one, other, pairing):
        found.append(gap)
        progress(len(found), total)
    steps = None if pairing.steps is None else [int(step) for step in pairing.steps]
    separation = _separation(one, other, first, pairing, found, arithmetic)
    within = [gap.beyond is None if tolerance is None else _close(gap, tolerance) for gap in found]
    start = not within[0] and pairing.times[0] == separation.origin and not _disturbed(found[0], separation)
    lost = next((k for k, gap in enumerate(found) if any(gap.missing) and not any(found[0].missing)), None)
    broken = next((k for k, gap in enumerate(found) if not gap.finite), None)
    parts = not all(within) and not setup and not start
    grown = growth(separation, rate) if parts and broken is None and "positions" in found[0].rms else None
    if grown is not None and grown.kind in ("rounding", "chaos", "unclear"):
        moved = momentum_parting(found, steps, arithmetic)
        if moved is not None:
            grown = grown._replace(kind="momentum", parting=moved)
    tested = None
    if mode == "statistics" or (mode == "chaos" and parts):
        # of other starts, as of seeds, statistics alone can be the same
        begin = START if mode == "statistics" else _begin(separation, grown)
        if not all(within) and not setup and broken is None and (1 - begin) * total >= FEWEST:
            tested = compare_samples(one, other, pairing, begin)
    place = None
    if grown is not None and grown.parting is not None:
        place = _neighbourhood(one, other, pairing, grown.parting.frame, found[grown.parting.frame])
    if tolerance is not None:
        found = [gap._replace(beyond=None) if near else gap for gap, near in zip(found, within, strict=True)]
    near = [] if place is None else place.ids[1 : 1 + _NAMED]
    classed, sentence = classify(
        Evidence(setup, found, grown, tested, start, near, steps, lost, broken, pairing.clock), mode
    )
    return Comparison(
        str(one.path),
        str(other.path),
        (one.format, other.format),
        classed,
        sentence,
        pairing.clock,
        found,
        setup,
        next((gap.differing for gap in found if gap.differing is not None), None),
        next((gap.beyond for gap in found if gap.beyond is not None), None),
        separation,
        grown,
        None if grown is None else chaos_line(separation, grown),
        tested,
        place,
        (*(f"{source.path.name}: {text}" for source in (one, other) for text in source.remarks), *pairing.remarks),
        len(first.ids),
        steps,
    )


def _close(gap: Gap, tolerance: float) -> bool:
    return gap.largest.get("positions", 0.0) <= tolerance and not any(gap.missing)


def _separation(
    one: Source, other: Source, first: Frame, pairing: Pairing, found: list[Gap], arithmetic: str
) -> Separation:
    """Separations of positions and velocities, and the scales that they are measured by."""
    values, floor = (
        np.array([getattr(gap, name).get("positions", np.nan) for gap in found]) for name in ("rms", "floor")
    )
    velocities = velocity_floor = None
    if pairing.clock == "time" and all("velocities" in gap.rms for gap in found):
        velocities = np.array([gap.rms["velocities"] for gap in found])
        velocity_floor = np.array([gap.floor["velocities"] for gap in found])
    step = 1.0 if pairing.clock == "step" else None
    if pairing.clock == "time" and pairing.steps is not None and pairing.steps[-1] > pairing.steps[0]:
        step = float((pairing.times[-1] - pairing.times[0]) / (pairing.steps[-1] - pairing.steps[0]))
    origin = float(pairing.times[0])
    if pairing.clock == "time":
        origin = min(origin, float(one.times.min()), float(other.times.min()) * pairing.time)
    apart = 0.0
    if origin == pairing.times[0]:
        apart = max(found[0].rms.get("velocities", 0.0) - found[0].floor.get("velocities", 0.0), 0.0)
    extent = max(gap.extent for gap in found)
    near = spacing(first)
    return Separation(
        times=pairing.times,
        values=values,
        floor=floor,
        velocities=velocities,
        velocity_floor=velocity_floor,
        number=len(first.ids),
        speed=_speed(found[0]) if pairing.clock == "time" else None,
        extent=extent,
        spacing=near,
        step=step,
        origin=origin,
        start_velocity=apart,
        arithmetic=arithmetic,
    )


def _speed(gap: Gap) -> float | None:
    """Root mean square speed in a frame, if both files state velocities."""
    kinetic = [value for value in gap.kinetic if value is not None]
    return (2 * max(kinetic)) ** 0.5 if len(kinetic) == 2 else None


def _disturbed(gap: Gap, separation: Separation) -> bool:
    """Whether the first frame differs by no more than a disturbance, in positions and in velocities."""
    scales = {"positions": separation.spacing, "velocities": _speed(gap) or 0.0}
    return all(
        gap.largest[name] <= _DISTURBANCE * scale + gap.most[name]
        for name, scale in scales.items()
        if name in gap.largest
    )


def _begin(separation: Separation, grown: Growth | None) -> float:
    """Share of the frames before statistics count: the start, and the time up to the horizon of chaos."""
    after = 0.0
    if grown is not None and grown.kind == "chaos":
        far = np.flatnonzero(separation.values > separation.spacing)
        after = 1.0 if not far.size else float(far[0]) / len(separation.values)
    return max(START, after)


def _neighbourhood(one: Source, other: Source, pairing: Pairing, at: int, gap: Gap) -> Neighbourhood:
    """The particles around the one that is farthest from itself in a pair of frames."""
    first, second = frames_of(one, other, pairing, at)
    particle = gap.farthest["positions"]
    centre = first.positions[int(np.flatnonzero(first.ids == particle)[0])]
    apart = [first.positions - centre, second.positions - centre]
    if first.box is not None:
        apart = [nearest_image(one_side, first.box) for one_side in apart]
    order = np.argsort(np.linalg.norm(apart[0], axis=1), kind="stable")[:_DRAWN]
    ids = [int(first.ids[k]) for k in order]
    rows = np.searchsorted(second.ids, ids)
    rows = np.minimum(rows, len(second.ids) - 1)
    there = np.where((second.ids[rows] == ids)[:, None], apart[1][rows], np.nan)
    radius = spacing(first) / 2
    if first.diameters is not None:
        radius = float(np.mean(first.diameters)) / 2
    return Neighbourhood(at, particle, ids, apart[0][order], there, radius)
