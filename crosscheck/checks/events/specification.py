"""The event-driven algorithm against its specification, the naive algorithm of refimpl, feature by feature."""

from __future__ import annotations

from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, variants_of
from crosscheck.checks.events.gases import event_driven, spheres
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.scene import (
    Box,
    Cylinder,
    Face,
    Friction,
    GrainFriction,
    HardSpheres,
    Method,
    Oscillation,
    Output,
    Scene,
    Well,
    explicit,
)
from crosscheck.scene.overlaps import wrapped
from crosscheck.verdict import Judged, bounded, round_off, worst

Boundary: TypeAlias = Literal["periodic", "wall", "open", "hard"]

#: Pair and wall collisions that the two algorithms are compared over.
COMPARED = 10_000
NAIVE = Method(scheme="event_driven_naive")
_GRAINS = 60
_ROUGH = GrainFriction(tangential_restitution=0.3, static=0.5, sliding=0.4)
_ROUGH_WALL = Friction(tangential_restitution=0.3, static=0.5, sliding=0.4)


class _Feature(NamedTuple):
    """A scene of `_feature_scenes`, by its name, in two or three dimensions."""

    dimension: int
    name: str


def _feature_scenes(dimension: int, seed: int) -> dict[str, Scene]:
    """Scenes that use the features alone and together; the last one all that go together.

    Those that dissipate are shaken by a floor that does not dissipate: grains that settle collide without end.
    """
    d = dimension
    side = (_GRAINS / 0.25) ** (1 / 3) if d == 3 else (_GRAINS / 0.4) ** 0.5
    down = (0.0,) * (d - 1) + (-1.0,)
    floor = "z-" if d == 3 else "y-"
    box = Box(lengths=(side,) * d)
    above_floor: tuple[Boundary, ...] = ("periodic", "periodic", "hard")
    walled = above_floor[3 - d :]
    closed: tuple[Boundary, ...] = ("hard", "hard", "hard")
    around: tuple[Boundary, ...] = ("open", "open", "periodic")
    species = tuple(range(_GRAINS))
    sizes = np.random.default_rng(seed).uniform(0.6, 1.0, _GRAINS).tolist()
    masses = np.random.default_rng(seed + 1).uniform(0.5, 3.0, _GRAINS).tolist()

    def scene(**more: object) -> Scene:
        return spheres(_GRAINS, 0.3, seed, dimension=d, **{"box": box, **more})

    shaken = Face(oscillation=Oscillation(amplitude=0.1, frequency=12.0, phase=0.3))
    rough_shaken = shaken.model_copy(update={"friction": _ROUGH_WALL})
    cylinder = Cylinder(radius=0.5 * side, axis="z" if d == 3 else None, angular_velocity=0.5, friction=_ROUGH_WALL)
    return {
        "bare": scene(),
        "walls": scene(box=Box(lengths=(side,) * d, boundaries=closed[:d], faces={floor: Face(restitution=0.9)})),
        "mixture": scene(masses=tuple(masses), species=species, hard_spheres=HardSpheres(diameter=tuple(sizes))),
        "inelastic-gravity": scene(
            acceleration=down,
            box=Box(lengths=(side,) * d, boundaries=walled, faces={floor: shaken}),
            hard_spheres=HardSpheres(restitution=0.95),
        ),
        "rough": scene(hard_spheres=HardSpheres(restitution=0.95, friction=_ROUGH)),
        "well": scene(hard_spheres=HardSpheres(well=Well(depth=1.0, range=1.5))),
        "drum": scene(
            acceleration=(0.0, -1.0) if d == 2 else (0.0, -1.0, 0.0),
            box=Box(lengths=(side,) * d, boundaries=around[:d], cylinder=cylinder),
            hard_spheres=HardSpheres(friction=_ROUGH, diameter=0.7),
        ),
        "everything": scene(
            acceleration=down,
            masses=tuple(masses),
            species=species,
            box=Box(lengths=(side,) * d, boundaries=walled, faces={floor: rough_shaken}),
            hard_spheres=HardSpheres(diameter=tuple(sizes), restitution=0.95, friction=_ROUGH),
        ),
    }


_FEATURES = {f"{d}d-{name}": _Feature(d, name) for d in (2, 3) for name in _feature_scenes(2, 0)}


def _judge(laboratory: Laboratory, feature: _Feature) -> Judged:
    """Windows of a run against the naive algorithm, started from the run's own state at the window's start."""
    scene = _feature_scenes(feature.dimension, laboratory.seed() % 2**31)[feature.name]
    trial = laboratory.run(scene.changed(duration=10.0, output=_counted(10.0)), EVENT_DRIVEN)
    rate = (float(trial["collisions"][-1]) + float(np.sum(trial["wall_collisions"][-1]))) / 10.0
    # half a collision of each particle in a window: rounding has no time to grow
    window = 0.25 * _GRAINS / rate
    windows = int(np.ceil(COMPARED / (rate * window)))
    run = laboratory.run(scene.changed(duration=windows * window, output=_counted(window)), EVENT_DRIVEN)
    apart, compared, differing = 0.0, 0.0, 0
    for k in range(windows):
        spins = run["angular_velocities"][k] if "angular_velocities" in run else None
        start = _shifted(scene, float(run["time"][k])).changed(
            initial=explicit(wrapped(run["positions"][k], scene.periods()), run["velocities"][k], spins),
            duration=window,
            output=Output(interval=window, observables=("collisions",)),
        )
        known = laboratory.run(start, NAIVE, engine="refimpl")
        apart = max(apart, float(np.abs(known["final_velocities"] - run["velocities"][k + 1]).max()))
        differing += int(known["collisions"][-1] != np.diff(run["collisions"][k : k + 2])[0])
        walls = float(np.sum(run["wall_collisions"][k + 1] - run["wall_collisions"][k]))
        compared += float(known["collisions"][-1]) + walls
        if differing or not apart < 1e-6 or compared >= COMPARED:  # later windows tell nothing more
            break
    judgements = [
        round_off(
            "largest difference of a velocity",
            apart,
            _growth(scene),
            "rounding of positions and times, times five at each of the collisions of a particle in a window (seven at "
            "most), times ten from positions to velocities",
        ),
        bounded("windows with another number of collisions", float(differing), 0.0, "exact"),
    ]
    return worst(judgements, f"{k + 1} windows, {compared:.0f} collisions of pairs and with walls")


def _growth(scene: Scene) -> float:
    # a flight l <= 1 after an error d of the position at contact: 2 d l/sigma, with sigma >= 0.6
    lengths = scene.lengths()
    assert lengths is not None
    return float(EPSILON * 4 * lengths.max() * 5.0**7 * 10)


def _counted(interval: float) -> Output:
    return Output(interval=interval, observables=("collisions", "wall_collisions"), trajectory=True)


def _shifted(scene: Scene, time: float) -> Scene:
    """The scene with the phase that its shaken floor has at this time."""
    assert scene.box is not None
    faces = {}
    for name, face in (scene.box.faces or {}).items():
        if face.oscillation is not None:
            phase = (face.oscillation.phase + face.oscillation.frequency * time) % (2 * np.pi)
            face = face.model_copy(update={"oscillation": face.oscillation.model_copy(update={"phase": phase})})
        faces[name] = face
    return scene.changed(box=scene.box.model_copy(update={"faces": faces})) if faces else scene


CHECKS = (
    Check(
        name="events/specification",
        title="The fast algorithm against the naive one, over 10000 collisions, feature by feature",
        equation="predict all pairs, take the earliest, advance all particles, collide",
        criterion="same collisions; velocities to rounding and its growth over half a collision a particle",
        citation="Soto, Cordero & Risso, SCAT workshop, Valparaiso (2007)",
        judge=_judge,
        variants=variants_of(_FEATURES, "full"),
        needs=event_driven(observables="positions velocities collisions wall_collisions"),
        faults=(
            (
                "3d-bare",
                Fault(
                    "stale-partner",
                    "events/kernels/loop.py",
                    "if ints[j, COUNT] != ints[i, PARTNER_COUNT]:",
                    "if ints[j, COUNT] > ints[i, PARTNER_COUNT] + 1:",
                    "an event whose partner has collided once since is taken for valid",
                ),
            ),
            (
                "2d-mixture",
                Fault(
                    "half-contact-distance",
                    "events/kernels/loop.py",
                    "return splat(radii[i]) + elements(radii, ids, q)",
                    "return splat(0.999) * (splat(radii[i]) + elements(radii, ids, q))",
                    "the cells' prediction takes particles for smaller by a thousandth",
                ),
            ),
        ),
    ),
)
