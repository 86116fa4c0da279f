"""Event-driven runs until t = 1e12: the clock must not lose digits, whatever it says."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN
from crosscheck.checks.extreme.matrix import Case, Trial, Value, extreme_check, for_each
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.references.hard_walls import between_walls
from crosscheck.references.long_wait import driven_flight
from crosscheck.scene import Box, Face, HardSpheres, Output, Scene, explicit

_WALLS = frozenset({"box.boundaries=hard", "box.boundaries=periodic"})
_LATE = "error of the place at the end"
_IMPACTS = "impacts on walls, too many or few"
#: A speed at which a disk reaches the wall at t = 7 2^37 = 9.6e11; the wall's velocity, the room, and the time after.
_CREEP, _PUSH, _ROOM, _FROM, _THEN = 2.0**-38, 1.0, 7.0, 3.5, 3000.0
#: Restitution of the other wall, which bounds the speed, by 4.
_FAR = 0.5


def _woken(trial: Trial) -> Mapping[str, float]:
    """A disk creeps to a wall for 1e12, is pushed, and flies to and fro."""
    duration = _FROM / _CREEP + _THEN
    scene = Scene(
        name="woken",
        dimension=2,
        duration=duration,
        hard_spheres=HardSpheres(),
        box=Box(
            lengths=(_ROOM + 1.0, 4.0),
            boundaries=("hard", "periodic"),
            faces={"x-": Face(velocity=_PUSH), "x+": Face(restitution=_FAR)},
        ),
        initial=explicit(np.array([[0.5 + _FROM, 2.0]]), np.array([[-_CREEP, 0.0]])),
        output=Output(interval=duration, trace=True),
    )
    run = trial.run(scene, None)
    flight = driven_flight(_FROM, -_CREEP, _PUSH, _ROOM, _FAR, duration)
    return {
        _LATE: abs(float(run["final_positions"][0, 0]) - 0.5 - float(flight.place)),
        _IMPACTS: abs(float(len(run["event_times"])) - flight.impacts),
    }


def _expected_woken() -> tuple[Value, ...]:
    flight = driven_flight(_FROM, -_CREEP, _PUSH, _ROOM, _FAR, _FROM / _CREEP + _THEN)
    # times to cross the box at the speed of the wall count as one
    rounding = 16 * EPSILON * (_ROOM + 1.0) * flight.impacts * abs(float(flight.velocity))
    return (
        Value(_LATE, 0.0, rounding, "16 roundings of a place of the box, or of the flight's time, at each impact"),
        Value(_IMPACTS, 0.0, 0.5, "a count: exact"),
    )


#: A speed, the room of two disks, and the time, in which each meets the other a hundred times.
_SLOW, _LONG_ROOM, _UNTIL = 2.0**-24, 998.0, 2.0**40


def _slow(trial: Trial) -> Mapping[str, float]:
    """Two disks that meet again and again, until t = 1e12: the time of each collision is known in closed form."""
    scene = Scene(
        name="slow",
        dimension=2,
        duration=_UNTIL,
        hard_spheres=HardSpheres(),
        box=Box(lengths=(_LONG_ROOM + 2.0, 10.0), boundaries=("hard", "periodic")),
        initial=explicit(np.array([[250.5, 5.0], [749.5, 5.0]]), np.array([[_SLOW, 0.0], [-_SLOW, 0.0]])),
        output=Output(interval=_UNTIL / 16, trajectory=True),
    )
    run = trial.run(scene, None)
    # equal disks exchange velocities: each runs to and fro between its wall and the middle
    expected = 0.5 + between_walls(_SLOW * run["time"] + 250.0, _LONG_ROOM / 2)
    return {_LATE: float(abs(run["positions"][:, 0, 0] - expected).max())}


_WHY_SLOW = "64 roundings of a place of the box at each impact, as a random walk, and one of the sample's time"

CHECKS = (
    extreme_check(
        "clocks",
        "Event-driven disks at t = 1e12: woken after so long, and meeting until then",
        "x(t) in rational numbers; a triangular wave",
        "Knuth, The Art of Computer Programming, vol. 2 (1997), 4.2.2",
        (
            Case(
                "clock-1e12-woken",
                "a disk creeps to a moving wall until t = 1e12, and then flies to and fro",
                _woken,
                for_each((EVENT_DRIVEN, "event_driven_naive"), *_expected_woken()),
                needs=Needs(
                    "hard_spheres",
                    (EVENT_DRIVEN,),
                    words=_WALLS | {"box.faces.velocity", "box.faces.restitution"},
                    observables=frozenset({"event_times"}),
                ),
            ),
            Case(
                "clock-1e12",
                "two slow disks that meet until t = 1e12, a hundred times",
                _slow,
                for_each(
                    (EVENT_DRIVEN, "event_driven_lists"),
                    Value(
                        _LATE,
                        0.0,
                        64 * EPSILON * 1000.0 * (_SLOW * _UNTIL / 499.0) ** 0.5 + EPSILON * _SLOW * _UNTIL,
                        _WHY_SLOW,
                    ),
                ),
                needs=Needs("hard_spheres", (EVENT_DRIVEN,), words=_WALLS),
            ),
        ),
        Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=_WALLS | {"dimension=2"},
            observables=frozenset({"positions", "velocities"}),
        ),
        (
            (
                "clock-1e12-woken/event_driven",
                Fault(
                    "clock-of-one-number",
                    "events/simulation.py",
                    "        self._base = two_sum(*self._base, shift)",
                    "        self._base = (self._base[0] + shift, 0.0)",
                    "the base of the clock is one number, and loses what is below its rounding",
                ),
            ),
        ),
    ),
)
