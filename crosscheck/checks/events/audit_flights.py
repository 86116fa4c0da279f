"""Flights in a field that barely reach a wall, or miss it, or bounce: a cylinder, a wall that oscillates."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, Variant
from crosscheck.checks.events.audit_crowd import in_rounding
from crosscheck.checks.events.gases import event_driven
from crosscheck.faults import Fault
from crosscheck.references.event_audit import audit
from crosscheck.scene import Box, Cylinder, Face, Floats, HardSpheres, Method, Oscillation, Output, Scene, explicit
from crosscheck.verdict import Judged, bounded, worst

#: Particles of a scene, and their diameter: so small that they hardly meet. Short in base two, as radius and sides are:
#: a particle can touch the cylinder without rounding.
_NUMBER, _DIAMETER = 50, 2.0**-10
#: A flight barely reaches a wall, or barely misses it, where its nearest point is so far from it at most.
_BARELY = 0.02
#: Places at which a flight is looked at to choose it.
_PLACES = 200
_RADIUS, _DURATION = 1.0, 2.0
#: Below its middle at the start: particles may begin there too.
_FLOOR = Oscillation(amplitude=0.3, frequency=3.0, phase=2.5)
#: At its highest place at the start; it comes back before a particle that rests there has fallen much.
_FAST = Oscillation(amplitude=0.25, frequency=1600.0)


class _Walls(NamedTuple):
    """dimension: of the scene. axis: of the cylinder; "" : in the plane. field: acceleration. floor: in its place.

    bounce: the field leads to the wall, which any flight reaches. rest: a particle rests on a fast floor at the start.
    """

    dimension: int
    axis: str
    field: tuple[float, ...]
    floor: bool = False
    bounce: bool = False
    rest: bool = False


def _across(walls: _Walls) -> list[int]:
    return [axis for axis in range(walls.dimension) if "xyz"[axis] != walls.axis]


def _box(walls: _Walls) -> Box:
    sides = (2.25, 3.0, 2.5)[: walls.dimension]
    if walls.floor:
        faces = {"y-": Face(oscillation=_FAST if walls.rest else _FLOOR)}
        return Box(lengths=sides, boundaries=("periodic", "hard", "periodic")[: walls.dimension], faces=faces)  # type: ignore[arg-type]
    boundaries = ["periodic"] * walls.dimension
    for axis in _across(walls):
        boundaries[axis] = "open"
    return Box(
        lengths=sides,
        boundaries=tuple(boundaries),  # type: ignore[arg-type]
        cylinder=Cylinder(radius=_RADIUS, axis=walls.axis or None),  # type: ignore[arg-type]
    )


def _gaps(walls: _Walls, middle: Floats, x: Floats, v: Floats, times: Floats) -> Floats:
    """Distances from the wall of flights, (flights, times)."""
    g = np.array(walls.field)

    def places(axis: int) -> Floats:
        return np.asarray(x[:, axis, None] + v[:, axis, None] * times + g[axis] * times**2 / 2)

    if walls.floor:
        floor = _FLOOR.amplitude * np.cos(_FLOOR.frequency * times + _FLOOR.phase)
        return np.asarray(places(1) - _DIAMETER / 2 - floor)
    first, second = (places(axis) - middle[axis] for axis in _across(walls))
    return np.asarray(_RADIUS - _DIAMETER / 2 - np.sqrt(first * first + second * second))


def _chosen(walls: _Walls, draw: Callable[[int], tuple[Floats, Floats]], middle: Floats) -> tuple[Floats, Floats]:
    """Starts of flights whose first approach to the wall comes to an end near it, or of any where they bounce."""
    times = np.linspace(0.0, _DURATION, _PLACES)
    places: list[Floats] = []
    velocities: list[Floats] = []
    while len(places) < _NUMBER:
        x, v = draw(2000)
        gaps = _gaps(walls, middle, x, v, times)
        turns = (gaps[:, 1:-1] <= gaps[:, :-2]) & (gaps[:, 1:-1] < gaps[:, 2:])
        first = np.argmax(turns, axis=1) + 1
        nearest = gaps[np.arange(len(gaps)), first]
        barely = turns.any(axis=1) & (np.abs(nearest) < _BARELY)
        good = (gaps[:, 0] > _BARELY) & (barely | walls.bounce)
        for place, velocity in zip(x[good], v[good], strict=True):
            if len(places) < _NUMBER and all(np.linalg.norm(place - other) > 2 * _DIAMETER for other in places):
                places.append(place)
                velocities.append(velocity)
    return np.array(places), np.array(velocities)


def _scene(walls: _Walls, seed: int) -> Scene:
    rng = np.random.default_rng(seed)
    box, d, duration = _box(walls), walls.dimension, 0.05 if walls.rest else _DURATION
    assert box.lengths is not None
    sides = np.array(box.lengths)
    middle = sides / 2

    def draw(number: int) -> tuple[Floats, Floats]:
        x = rng.uniform((0.0, -_FLOOR.amplitude if walls.floor else 0.0, 0.0)[:d], sides, (number, d))
        inside = x[:, 1] < 2.0 if walls.floor else np.linalg.norm((x - middle)[:, _across(walls)], axis=1) < _RADIUS
        return x[inside], rng.normal(scale=1.6, size=(number, d))[inside]

    if walls.rest:  # no gap, and no velocity: only the curvature says that the floor leaves it
        x, v = np.array([[1.0, _FAST.amplitude + _DIAMETER / 2]]), np.array([[0.5, 0.0]])
    else:
        x, v = _chosen(walls, draw, middle)
    if not walls.floor:  # the last one begins on the cylinder, outwards
        first = _across(walls)[0]
        x[-1] = middle
        x[-1, first] += _RADIUS - _DIAMETER / 2
        v[-1, first] = 0.5
    return Scene(
        name="flights",
        dimension=d,  # type: ignore[arg-type]
        duration=duration,
        hard_spheres=HardSpheres(diameter=_DIAMETER),
        box=box,
        acceleration=walls.field,
        initial=explicit(x, v),
        output=Output(interval=duration / 10, trajectory=True, trace=True),
    )


class _Draw(NamedTuple):
    """Flights near walls. turn: which of the engine's event-driven schemes follows them, from 0 on and around."""

    walls: _Walls
    turn: int = 0


def _judge(laboratory: Laboratory, draw: _Draw) -> Judged:
    scene = _scene(draw.walls, laboratory.seed())
    schemes = [name for name, claims in laboratory.claims.items() if claims.kind == EVENT_DRIVEN]
    found = audit(scene, laboratory.run(scene, Method(scheme=schemes[draw.turn % len(schemes)])))
    judgements = in_rounding(found)
    # 25 +- 3.5 reach it, at least
    few = "half of the flights reach the wall by chance; what does not happen is not judged"
    judgements.append(bounded("events", float(found.events), scene.number / 5, few, at_least=True, control=True))
    return worst(judgements, f"{found.events} events of {scene.number} flights")


_CYLINDER = "box.cylinder box.boundaries=open"
_SPACE = "dimension=3 box.boundaries=periodic"
_FLOORS = "dimension=2 box.boundaries=periodic box.boundaries=hard box.faces box.faces.oscillation.phase"
#: Walls, and the words of their scenes, by name of the variant.
_ALL = {
    "circle": (_Walls(2, "", (0.7, -1.9)), f"dimension=2 {_CYLINDER}"),
    "cylinder-x": (_Walls(3, "x", (0.4, 0.9, -1.7)), f"box.cylinder.axis=x {_CYLINDER} {_SPACE}"),
    "floor": (_Walls(2, "", (0.2, 1.5), True), _FLOORS),
    "bounces": (_Walls(2, "", (0.2, -9.0), True, True), _FLOORS),
    "rest": (_Walls(2, "", (0.0, -9.0), True, rest=True), _FLOORS),
}
#: Draws of flights of the full tier, of each kind of walls.
_OTHERS = 4


def _variants() -> tuple[Variant, ...]:
    return tuple(
        Variant(
            f"{name}-{turn}" if turn else name, _Draw(walls, turn), "full" if turn else "quick", event_driven(words)
        )
        for name, (walls, words) in _ALL.items()
        for turn in range(1 + _OTHERS)
    )


CHECKS = (
    Check(
        name="events/audit-flights",
        title="Flights in a field that barely reach a wall, or miss it, or bounce: every event against the definitions",
        equation="|r + v t + g t^2/2| = R - s/2; y + v t + g t^2/2 - s/2 = A cos(omega t + phi): the first t",
        criterion="each number to its rounding",
        citation="Poschel & Schwager, Computational Granular Dynamics (2005), ch. 3",
        judge=_judge,
        variants=_variants(),
        needs=event_driven(
            "acceleration", "positions velocities event_times event_partners event_positions event_velocities"
        ),
        interpreted=True,
        faults=(
            (
                "circle",
                Fault(
                    "turning-point",
                    "events/prediction.py",
                    "b0, b1, b2, b3 = a1, 2.0 * a2, 3.0 * a3, 4.0 * a4",
                    "b0, b1, b2, b3 = a1, 2.0 * a2, 3.0 * a3, a4",
                    "the times at which a flight is nearest to the cylinder are wrong",
                ),
            ),
        ),
    ),
)
