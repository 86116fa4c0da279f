"""Event-driven hard spheres at their extremes: grazing, touching, at one time, collapsing."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN
from crosscheck.checks.events.rows import reported_time
from crosscheck.checks.extreme.matrix import (
    RAN,
    SENTENCE,
    Answer,
    Bound,
    Case,
    Measured,
    Trial,
    Value,
    extreme_check,
    for_each,
)
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.references.collapse import BouncingBall
from crosscheck.references.first_impact import after_impact, first_impact
from crosscheck.scene import (
    Box,
    Explicit,
    Face,
    Floats,
    HardSpheres,
    Output,
    Scene,
    explicit,
)

#: The engine's first event-driven scheme, and the naive algorithm, which shares nothing with it but the rules.
_BOTH = (EVENT_DRIVEN, "event_driven_naive")
_ALL = (EVENT_DRIVEN, "event_driven_lists", "event_driven_calendar", "event_driven_naive")
_WALLS = frozenset({"box.boundaries=hard", "box.boundaries=periodic"})
_SIDE = 16.0


def _disks(
    places: Sequence[Sequence[float]],
    velocities: Sequence[Sequence[float]],
    duration: float,
    restitution: float = 1.0,
    side: float | None = _SIDE,
    **more: Any,
) -> Scene:
    """Disks of diameter and mass 1 in a periodic square, or in open space."""
    entries: dict[str, Any] = {
        "name": "disks",
        "dimension": 2,
        "duration": duration,
        "hard_spheres": HardSpheres(restitution=restitution),
        "box": None if side is None else Box(lengths=(side, side)),
        "initial": explicit(np.array(places), np.array(velocities)),
        "output": Output(interval=duration, observables=("collisions",), trajectory=True),
    }
    return Scene(**(entries | more))


# -- grazing and touching ----------------------------------------------------------------------------------------------

_HITS = "collisions"
_AFTER = "largest error of a velocity"
#: Impact parameters over the diameter, less 1, that are told apart from 0: 2^-40.
_DEPTH = 2.0**-40


def _grazing(trial: Trial, less: float) -> Mapping[str, float]:
    """One flies past another at the distance 1 - less."""
    places, velocities = ((4.0, 4.0), (8.0, 5.0 - less)), ((1.0, 0.0), (0.0, 0.0))
    run = trial.run(_disks(places, velocities, 8.0), None)
    apart, towards = np.array(places[1]) - np.array(places[0]), np.array(velocities[1]) - np.array(velocities[0])
    impact = first_impact(apart.tolist(), towards.tolist(), 1.0, (0.0, 0.0), 8.0)
    expected: Any = velocities if impact is None else after_impact(impact, *velocities)
    return {_HITS: float(run["collisions"][-1]), _AFTER: float(abs(run["final_velocities"] - np.array(expected)).max())}


def _grazing_case(name: str, less: float, hits: float) -> Case:
    # a rounding of the place, 4 eps of the box, turns the normal by itself over the root of the depth
    rounding = 16 * EPSILON * _SIDE * (1 + (2 * _DEPTH) ** 0.5 / _DEPTH if less > 0 else 1)
    return Case(
        name,
        f"a disk passes another one at 1 {'-' if less > 0 else '+'} {abs(less):.2g} diameters",
        lambda trial: _grazing(trial, less),
        for_each(
            _BOTH,
            Value(_HITS, hits, 0.5, "a count: exact"),
            Value(_AFTER, 0.0, rounding * (2 * _DEPTH) ** 0.5 if less > 0 else EPSILON, _WHY_GRAZING),
        ),
    )


_WHY_GRAZING = "16 roundings of a place turn the normal by that over the root of the depth, times the speed along it"


def _touching(trial: Trial, speeds: tuple[float, float]) -> Mapping[str, float]:
    """Two that touch at the start."""
    run = trial.run(_disks(((4.0, 4.0), (5.0, 4.0)), ((speeds[0], 0.0), (speeds[1], 0.0)), 2.0), None)
    closing = speeds[0] > speeds[1]
    expected = np.array(speeds[::-1] if closing else speeds)
    return {
        _HITS: float(run["collisions"][-1]),
        _AFTER: float(abs(run["final_velocities"] - np.stack([expected, np.zeros(2)], axis=1)).max()),
    }


_TOUCHING = {"rest": (0.0, 0.0), "closing": (1.0, 0.0), "parting": (-1.0, 0.0)}

# -- several events at one time ----------------------------------------------------------------------------------------

#: Places and velocities of pairs far from each other, all of which meet at t = 1; and an order of the particles.
_PAIRS = 8
_ORDER = (11, 4, 2, 13, 0, 7, 15, 9, 1, 14, 3, 12, 8, 6, 5, 10)
_SHUFFLED = "numbers that differ when the particles are given in another order"


def _pairs() -> tuple[Floats, Floats]:
    y = 2.0 * np.arange(_PAIRS) + 1.0
    x = np.concatenate([np.stack([np.full(_PAIRS, 4.0), y], axis=1), np.stack([np.full(_PAIRS, 7.0), y], axis=1)])
    v = np.zeros_like(x)
    v[:_PAIRS, 0], v[_PAIRS:, 0] = 1.0, -1.0
    return x, v


def _in_any_order(trial: Trial) -> Measured:
    """Pairs that meet at one time, in two orders of the particles."""
    x, v = _pairs()
    order = np.array(_ORDER)

    def end(places: Floats, velocities: Floats) -> tuple[str, Floats]:
        answer, run = trial.answer(lambda: _disks(places.tolist(), velocities.tolist(), 3.0))
        if run is None:
            return answer, np.full((len(x), 4), np.nan)
        return answer, np.concatenate([run["final_positions"], run["final_velocities"]], axis=1)

    (answer, first), (other, second) = end(x, v), end(x[order], v[order])
    return Measured(
        {_SHUFFLED: float(np.count_nonzero(first[order] != second))},
        answer if answer == other else f"{answer}; {other}",
    )


def _row_at_once(trial: Trial) -> Measured:
    """A disk that is hit from both sides at one time: the order decides, and the run says so."""
    answer, run = trial.answer(
        lambda: _disks(((-2.0, 0.0), (0.0, 0.0), (2.0, 0.0)), ((1.0, 0.0), (0.0, 0.0), (-1.0, 0.0)), 3.0, side=None)
    )
    kinetic = math.nan if run is None else 0.5 * float((run["final_velocities"] ** 2).sum())
    return Measured({_ENERGY: kinetic}, answer)


_ENERGY = "kinetic energy at the end"
_SAID = (
    "remarked: 2 events took place at the same time, within rounding, as another one of the same particle, the first "
    "at t = 1: which of them comes first depends on the order in which the particles are given, and so may all that "
    "follows."
)

# -- restitutions of 0 and nearly 1, and collapse ----------------------------------------------------------------------

_LOST = "share of the relative speed that is lost"


def _restitution(trial: Trial, alpha: float) -> Mapping[str, float]:
    """Two disks head-on."""
    run = trial.run(_disks(((4.0, 4.0), (7.0, 4.0)), ((1.0, 0.0), (-1.0, 0.0)), 4.0, restitution=alpha), None)
    return {_LOST: 1 - float(run["final_velocities"][1, 0] - run["final_velocities"][0, 0]) / 2}


def _alpha_case(name: str, alpha: float, text: str) -> Case:
    return Case(
        name,
        f"two disks head-on, restitution {text}",
        lambda trial: _restitution(trial, alpha),
        for_each(_BOTH, Value(_LOST, 1 - alpha, 4 * EPSILON, "four roundings of a velocity")),
    )


_REST, _HEIGHT, _BOUNCE = "time of rest", 0.5, 0.5


def _comes_to_rest(trial: Trial) -> Measured:
    """A ball on a floor, restitution 1/2."""
    answer, run = trial.answer(
        lambda: Scene(
            name="ball",
            dimension=2,
            duration=8.0,
            acceleration=(0.0, -1.0),
            hard_spheres=HardSpheres(diameter=0.25),
            box=Box(
                lengths=(4.0, 4.0),
                boundaries=("periodic", "hard"),
                faces={"y-": Face(restitution=_BOUNCE), "y+": Face(open=True)},
            ),
            initial=Explicit(positions=((2.0, 0.125 + _HEIGHT),)),
        )
    )
    return Measured({_REST: math.nan if run is None else reported_time(run)}, answer)


_EMPTY = "refused: scene: initial.positions is empty: give at least one particle"
_SMALL = "refused: box: its length 2 along x, which is periodic, must exceed two contact ranges, 2: take a larger box"
_INSIDE = (
    "refused: particles 0 and 1 overlap: their centres are 0.75 apart, and their contact distance is 1 (gap -0.25): "
    "move one of them"
)


def _answered(trial: Trial, places: Sequence[Sequence[float]], side: float) -> Measured:
    """What is said of disks at rest at these places."""
    answer, _ = trial.answer(
        lambda: Scene(
            name="disks",
            dimension=2,
            duration=1.0,
            hard_spheres=HardSpheres(),
            box=Box(lengths=(side, side)),
            initial=Explicit(positions=tuple(tuple(place) for place in places)),
        )
    )
    return Measured({}, answer)


def _refusals() -> tuple[Case, ...]:
    starts: dict[str, tuple[str, Sequence[Sequence[float]], float, str]] = {
        "no-particle": ("N = 0", (), _SIDE, _EMPTY),
        "box-two-diameters": ("N = 1 in a periodic box of two diameters", ((1.0, 1.0),), 2.0, _SMALL),
        "overlap-half-a-radius": ("an overlap of half a radius", ((4.0, 4.0), (4.75, 4.0)), _SIDE, _INSIDE),
    }
    return tuple(
        Case(
            name,
            what,
            partial(_answered, places=places, side=side),
            for_each(_ALL, Answer(words, SENTENCE)),
        )
        for name, (what, places, side, words) in starts.items()
    )


_CASES = (
    *_refusals(),
    _grazing_case("grazing-hit", _DEPTH, 1.0),
    _grazing_case("grazing-miss", -_DEPTH, 0.0),
    _grazing_case("grazing-exactly", 0.0, 0.0),
    *(
        Case(
            f"touching-{name}",
            f"two disks that touch at the start, {name}",
            partial(_touching, speeds=speeds),
            for_each(
                _ALL,
                Value(_HITS, float(speeds[0] > speeds[1]), 0.5, "a count: exact"),
                Value(_AFTER, 0.0, EPSILON, "no rounding, of numbers short in base two"),
            ),
        )
        for name, speeds in _TOUCHING.items()
    ),
    Case(
        "at-once-apart",
        f"{_PAIRS} pairs, far from each other, that meet at one time",
        _in_any_order,
        for_each(
            _ALL,
            Bound(_SHUFFLED, 0.0, "events that share no particle: their order decides nothing, bit for bit"),
            Answer(RAN, "there is nothing to remark: no particle has two events at one time"),
        ),
    ),
    Case(
        "at-once-in-a-row",
        "a disk hit from both sides at one time",
        _row_at_once,
        for_each(
            _ALL,
            Value(_ENERGY, 1.0, 16 * EPSILON, "elastic impacts: four roundings of a velocity at each of three"),
            Answer(_SAID, SENTENCE),
        ),
        needs=Needs("hard_spheres", (EVENT_DRIVEN,), promises=("remarks_on_order",)),
    ),
    _alpha_case("restitution-0", 0.0, "0"),
    _alpha_case("restitution-1e-12", 1e-12, "1e-12"),
    _alpha_case("restitution-nearly-1", 1 - 1e-12, "1 - 1e-12"),
    Case(
        "collapse",
        "a ball comes to rest on a floor: infinitely many impacts until t = 3",
        _comes_to_rest,
        for_each(
            (EVENT_DRIVEN, "event_driven_lists", "event_driven_calendar", "event_driven_naive"),
            Value(
                _REST,
                BouncingBall(_HEIGHT, _BOUNCE, 1.0).rest,
                3 * (8 * EPSILON) ** 0.5,
                "a rounding of the height is a flight of its root",
            ),
            Answer("stopped", "the engine says that the run ended, in words that name the time"),
        ),
        needs=Needs("hard_spheres", (EVENT_DRIVEN,), words=_WALLS | {"acceleration", "box.faces.restitution"}),
    ),
)

CHECKS = (
    extreme_check(
        "hard-spheres",
        "Event-driven disks and spheres: grazing, touching, at one time, collapsing",
        "|r_i - r_j| >= sigma at all times; v'_n = -alpha v_n",
        "Lubachevsky, J. Comput. Phys. 94, 255 (1991); McNamara & Young, Phys. Fluids A 4, 496 (1992)",
        _CASES,
        Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=frozenset({"dimension=2", "box.boundaries=periodic", "hard_spheres.restitution"}),
            observables=frozenset({"positions", "velocities", "collisions"}),
        ),
        (
            (
                "restitution-nearly-1/event_driven",
                Fault(
                    "restitution-in-single-precision",
                    "events/rules.py",
                    "    normal = -(1.0 + alpha) * gn * mass\n",
                    "    normal = -(1.0 + np.float32(alpha)) * gn * mass\n",
                    "the restitution is kept in single precision",
                ),
            ),
        ),
    ),
)
