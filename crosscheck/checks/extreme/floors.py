"""Grains over floors at extremes: fields of 1e-12 and 1e12, and floors that vibrate at 1e-6 to 1e12."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN
from crosscheck.checks.extreme.matrix import Bound, Case, Trial, Value, extreme_check, for_each
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.scene import Box, Face, HardSpheres, Oscillation, Output, Scene, explicit

#: The traced scenes need a fast algorithm or a naive one: both write traces.
_BOTH = (EVENT_DRIVEN, "event_driven_naive")
_WORDS = frozenset(
    {"dimension=2", "box.boundaries=hard", "box.boundaries=periodic", "box.faces", "box.faces.open", "acceleration"}
)
_RADIUS, _HEIGHT = 0.5, 2.0

# -- fields ------------------------------------------------------------------------------------------------------------

_PLACE, _HITS = "error of the height at the end, over the drop", "impacts, too many or few"
#: Bounces of the run, in flights from floor to floor: it ends on the way down.
_BOUNCES = 6.8


def _bouncing(trial: Trial, g: float) -> Mapping[str, float]:
    """An elastic ball from rest: y = h - g s^2/2, s the time from the last apex."""
    fall = (2 * _HEIGHT / g) ** 0.5
    duration = fall + 2 * fall * _BOUNCES
    scene = Scene(
        name="bouncing",
        dimension=2,
        duration=duration,
        acceleration=(0.0, -g),
        hard_spheres=HardSpheres(),
        box=Box(lengths=(4.0, 8.0), boundaries=("periodic", "hard"), faces={"y+": Face(open=True)}),
        initial=explicit(np.array([[2.0, _RADIUS + _HEIGHT]]), np.zeros((1, 2))),
        output=Output(interval=duration, trace=True),
    )
    run = trial.run(scene, None)
    since = (duration + fall) % (2 * fall) - fall
    height = _HEIGHT - 0.5 * g * since**2
    return {
        _PLACE: abs(float(run["final_positions"][0, 1]) - _RADIUS - height) / _HEIGHT,
        _HITS: abs(float(len(run["event_times"])) - int(_BOUNCES + 1)),
    }


def _field_case(g: float) -> Case:
    # at the floor a rounding of the time of an impact, over the fall, is one of the place over the drop, twice
    rounding = 64 * EPSILON * (1 + 2 * _BOUNCES)
    return Case(
        f"g-{g:g}",
        f"a ball that bounces in a field of {g:g}, {_BOUNCES:g} times",
        lambda trial: _bouncing(trial, g),
        for_each(
            _BOTH,
            Value(_PLACE, 0.0, rounding, "64 roundings of a place and of the time, at each impact"),
            Value(_HITS, 0.0, 0.5, "a count: exact"),
        ),
        needs=Needs("hard_spheres", (EVENT_DRIVEN,), words=_WORDS),
    )


# -- floors ------------------------------------------------------------------------------------------------------------

_GAP, _GAIN = "error of the place of an impact, over its rounding", "error of the velocity after it, over its rounding"
_BELOW, _NUMBER = "depth below the floor at a sample, over its rounding", "impacts"
_TIME, _SAMPLES = 16.0, 64


def _vibrating(trial: Trial, amplitude: float, frequency: float) -> Mapping[str, float]:
    """Each impact is on the floor, y - R = A cos(w t), and v' = 2 V - v with V = -A w sin(w t)."""
    scene = Scene(
        name="vibrating",
        dimension=2,
        duration=_TIME,
        acceleration=(0.0, -1.0),
        hard_spheres=HardSpheres(),
        box=Box(
            lengths=(4.0, 64.0),
            boundaries=("periodic", "hard"),
            faces={
                "y-": Face(oscillation=Oscillation(amplitude=amplitude, frequency=frequency)),
                "y+": Face(open=True),
            },
        ),
        initial=explicit(np.array([[2.0, _RADIUS + 1.0 + amplitude]]), np.zeros((1, 2))),
        output=Output(interval=_TIME / _SAMPLES, trajectory=True, trace=True),
    )
    run = trial.run(scene, None)
    times, y = run["event_times"], run["event_positions"][:, 0, 1] - _RADIUS
    after = run["event_velocities"][:, 0, 1]
    # between impacts the ball falls freely: the velocity before each follows from that after the one before
    starts = np.concatenate([[0.0], after[:-1]])
    before = starts - np.diff(np.concatenate([[0.0], times]))
    late = 16 * EPSILON * _TIME  # of the time of an impact, and of the phase over the frequency
    speed, size = float(abs(after).max()), 16 * EPSILON * 64.0
    gap = abs(y - amplitude * np.cos(frequency * times)) / (size + amplitude * frequency * late + speed * late)
    plate = -amplitude * frequency * np.sin(frequency * times)
    unit = size + 2 * amplitude * frequency**2 * late + 4 * late
    sampled = run["positions"][:, 0, 1] - _RADIUS - amplitude * np.cos(frequency * run["time"])
    return {
        _GAP: float(gap.max()),
        _GAIN: float((abs(after - 2 * plate + before) / unit).max()),
        _BELOW: float(np.maximum(0.0, -sampled / (size + (amplitude * frequency + speed) * late)).max()),
        _NUMBER: float(len(times)),
    }


def _floor_case(name: str, amplitude: float, frequency: float, impacts: int) -> Case:
    why = "rounding of the time of an impact, 16 eps of the run's, and of a place of the box"
    return Case(
        f"floor-{name}",
        f"a floor of amplitude {amplitude:g} and angular frequency {frequency:g}",
        lambda trial: _vibrating(trial, amplitude, frequency),
        for_each(
            _BOTH,
            Bound(_GAP, 1.0, why),
            Bound(_GAIN, 1.0, why),
            Bound(_BELOW, 1.0, why),
            Bound(_NUMBER, float(impacts), "else nothing is judged", at_least=True),
        ),
        needs=Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=_WORDS | {"box.faces.oscillation"},
            observables=frozenset({"event_times", "event_positions", "event_velocities"}),
        ),
    )


CHECKS = (
    extreme_check(
        "floors",
        "A ball over a floor: fields of 1e-12 and 1e12, and floors from one period in 1e7 to 1e12 in a fall",
        "y'' = -g; v' = 2 V - v on the floor y = A cos(w t)",
        "Luck & Mehta, Phys. Rev. E 48, 3988 (1993)",
        (
            *(_field_case(g) for g in (1e-12, 1e12)),
            _floor_case("slow", 0.25, 1e-6, 4),
            _floor_case("fast", 1e-9, 1e9, 3),
            _floor_case("very-fast", 1e-12, 1e12, 3),
            _floor_case("large", 4.0, 2.0, 1),
        ),
        Needs("hard_spheres", (EVENT_DRIVEN,), words=_WORDS, observables=frozenset({"positions", "event_times"})),
        (
            (
                "floor-fast/event_driven",
                Fault(
                    "floor-of-half-the-speed",
                    "events/rules.py",
                    "    push = (1.0 + alpha) * (own - v) / inverse\n",
                    "    own = 0.999 * own\n    push = (1.0 + alpha) * (own - v) / inverse\n",
                    "floors move a part in a thousand too slowly",
                ),
            ),
        ),
    ),
)
