"""Sums over 1e10 events: wherever a sum stands, what is added to it must not lose digits.

A run of 1e10 events takes hours; but what makes its sums lose digits is that they are 1e10 times as large as what is
added. Here a heavy particle makes a sum so large by one event, and light ones then add to it, event by event.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN
from crosscheck.checks.extreme.matrix import Case, Trial, Value, extreme_check, for_each
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.scene import Box, Face, HardSpheres, Output, Scene, explicit

#: What one event adds, and how often; the sum before is so many times as large.
_EVENTS, _LOADED = 200, 1e10
_FAST = (EVENT_DRIVEN,)

# -- momentum given to a wall ------------------------------------------------------------------------------------------

_IMPULSE, _COUNT = "error of the impulse on the wall, over the first one", "hits of the wall, too many or few"
#: A heavy point hits the floor once and is away until the end; a light one bounces with this speed.
_LIGHT = 0.7


def _on_floor(trial: Trial) -> Mapping[str, float]:
    """Elastic points on a floor, g = 1: a bounce of speed u gives 2 m u, and lasts 2 u."""
    duration = 2 * _LIGHT * (_EVENTS + 0.25)
    high = 2.0 * duration
    heavy = _LOADED * _LIGHT / high
    scene = Scene(
        name="on-a-floor",
        dimension=2,
        duration=duration,
        acceleration=(0.0, -1.0),
        masses=(heavy, 1.0),
        hard_spheres=HardSpheres(diameter=0.0),
        box=Box(lengths=(4.0, 4.0), boundaries=("periodic", "hard"), faces={"y+": Face(open=True)}),
        initial=explicit(np.array([[1.0, 1.0], [3.0, 0.5 * _LIGHT**2]]), np.array([[0.0, -high], [0.0, 0.0]])),
        output=Output(interval=duration, observables=("wall_impulse", "wall_collisions")),
    )
    run = trial.run(scene, None)
    first = 2 * heavy * (high**2 + 2.0) ** 0.5
    # the light one falls half a bounce, then bounces: hits at u, 3 u, 5 u ...
    expected = -(first + _EVENTS * 2 * _LIGHT)
    return {
        _IMPULSE: abs(float(run["wall_impulse"][-1, 2, 1]) - expected) / first,
        _COUNT: abs(float(run["wall_collisions"][-1, 2]) - (_EVENTS + 1)),
    }


# -- energy lost in collisions, and the virial -------------------------------------------------------------------------

_LOST, _VIRIAL = "error of the energy lost, over the first loss", "error of the virial, over the first one"
_MET = "collisions, too many or few"
#: Restitution of all pairs, side of the box, and mass and speed of a heavy disk, which meets a fixed one once, and
#: loses 9e9 times as much as a light one does each time that it meets another fixed one.
_ALPHA, _SIDE, _HEAVY, _SLOW = 0.7, 8.0, 2.0**55, 2.0**-8
#: A wall of velocity 1 turns the speed u into u + 2, and a collision into alpha u: this one is kept.
_KEPT = 2 / (1 - _ALPHA)


def _in_lanes(trial: Trial) -> Mapping[str, float]:
    """A heavy disk in one lane; in another one a light one, which a wall drives at a fixed disk again and again."""
    room = 4.0
    duration = (room / _KEPT + room / (_ALPHA * _KEPT)) * _EVENTS
    scene = Scene(
        name="lanes",
        dimension=2,
        duration=duration,
        masses=(_HEAVY, 1.0, 1.0, 1.0),
        species=(0, 1, 0, 1),
        hard_spheres=HardSpheres(diameter=(1.0, 1.0), restitution=_ALPHA, fixed=(1,)),
        box=Box(lengths=(_SIDE, 6.0), boundaries=("hard", "periodic"), faces={"x-": Face(velocity=1.0)}),
        initial=explicit(
            np.array([[4.4921875, 1.5], [5.5, 1.5], [2.5, 4.5], [5.5, 4.5]]),
            np.array([[_SLOW, 0.0], [0.0, 0.0], [_KEPT, 0.0], [0.0, 0.0]]),
        ),
        output=Output(interval=duration, observables=("dissipated_energy", "collisional_virial", "collisions")),
    )
    run = trial.run(scene, None)
    # a mass m of speed u loses m u^2 (1 - alpha^2)/2, and gives the virial (1 + alpha) m u
    first, each = (0.5 * m * u**2 * (1 - _ALPHA**2) for m, u in ((_HEAVY, _SLOW), (1.0, _KEPT)))
    pushed, push = ((1 + _ALPHA) * m * u for m, u in ((_HEAVY, _SLOW), (1.0, _KEPT)))
    return {
        _LOST: abs(float(run["dissipated_energy"][-1]) - first - _EVENTS * each) / first,
        _VIRIAL: abs(float(run["collisional_virial"][-1]) - pushed - _EVENTS * push) / pushed,
        _MET: abs(float(run["collisions"][-1]) - (_EVENTS + 1)),
    }


CHECKS = (
    extreme_check(
        "sums",
        "Sums over 1e10 events: what is added to a sum 1e10 times as large loses no digits",
        "S = sum_k x_k, |error of S| <= eps |S| however many the terms",
        "Neumaier, ZAMM 54, 39 (1974); Higham, Accuracy and Stability of Numerical Algorithms (2002), section 4.3",
        (
            Case(
                "impulse",
                f"impulse on a floor: one hit of {_LOADED:.0e}, then {_EVENTS} of 1",
                _on_floor,
                for_each(
                    _FAST,
                    Value(_IMPULSE, 0.0, 4 * EPSILON, "four roundings of the first impulse and of the sum, no more"),
                    Value(_COUNT, 0.0, 0.5, "a count: exact"),
                ),
                needs=Needs(
                    "hard_spheres",
                    (EVENT_DRIVEN,),
                    words=frozenset({"acceleration", "box.faces.open", "hard_spheres.diameter"}),
                    observables=frozenset({"wall_impulse", "wall_collisions"}),
                ),
            ),
            Case(
                "losses",
                f"energy lost and virial: one collision of 9e9 and 2e13, then {_EVENTS} of 1",
                _in_lanes,
                for_each(
                    _FAST,
                    Value(_LOST, 0.0, 4 * EPSILON, "four roundings of the first loss and of the sum, no more"),
                    Value(
                        _VIRIAL,
                        0.0,
                        16 * EPSILON,
                        "a rounding of a place of the box, and four of the first term and the sum",
                    ),
                    Value(_MET, 0.0, 0.5, "a count: exact"),
                ),
                needs=Needs(
                    "hard_spheres",
                    (EVENT_DRIVEN,),
                    words=frozenset({"box.faces.velocity", "hard_spheres.restitution", "hard_spheres.fixed"}),
                    observables=frozenset({"dissipated_energy", "collisional_virial", "collisions"}),
                ),
            ),
        ),
        Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=frozenset({"dimension=2", "masses[]", "box.boundaries=hard", "box.boundaries=periodic", "box.faces"}),
        ),
        (
            (
                "impulse/event_driven",
                Fault(
                    "sums-without-their-rest",
                    "events/kernels/measure.py",
                    "    tallies.wall_rests[face, column] += _lacking(tallies.walls[face, column], more, total)\n",
                    "",
                    "what sums of a wall lack by rounding is not kept",
                ),
            ),
            (
                "losses/event_driven",
                Fault(
                    "losses-without-their-rest",
                    "events/kernels/measure.py",
                    "    tallies.rests[entry] += _lacking(tallies.sums[entry], more, total)\n",
                    "",
                    "what other sums lack by rounding is not kept",
                ),
            ),
        ),
    ),
)
