"""Event-driven dynamics compiled and as plain Python: the same bits.

The quick variants ask for what other quick checks ask for, so that no kernel is compiled for them alone.
"""

from __future__ import annotations

from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full, quick
from crosscheck.checks.both_modes import EQUATION, interpretable, same_bits
from crosscheck.checks.events.gases import TALLIES, event_driven, gas, spheres
from crosscheck.engines.protocol import Kind
from crosscheck.faults import Fault
from crosscheck.scene import (
    Box,
    Cylinder,
    Face,
    Friction,
    GrainFriction,
    HardSpheres,
    Method,
    Observable,
    Oscillation,
    Output,
    RandomPhase,
    Scene,
    Well,
)
from crosscheck.verdict import Judged

Boundary: TypeAlias = Literal["periodic", "wall", "open", "hard"]
_WALLED: tuple[Boundary, ...] = ("hard", "hard", "periodic")
_AROUND: tuple[Boundary, ...] = ("open", "open", "periodic")
_MOST: tuple[Observable, ...] = (
    *TALLIES,
    "dissipated_energy",
    "wall_energy",
    "deepest_overlap",
    "operation_counts",
    "events",
)


class _Feature(NamedTuple):
    """A kind of scene, in two or three dimensions, and how it is run."""

    dimension: int
    kind: str
    method: Method | Kind = EVENT_DRIVEN


def _scene(feature: _Feature, seed: int) -> Scene:
    """Some 200 to 1000 events."""
    d = feature.dimension
    output = Output(interval=1.0, trajectory=True, observables=TALLIES)
    if feature.kind == "gas":
        return gas(d, 27 if d == 3 else 16, 0.4, seed, output, 3.0)
    if feature.kind == "hard-walls":
        return gas(d, 16, 0.3, seed, output, 6.0, hard=True)
    if feature.kind == "grains":
        lost = output.model_copy(update={"observables": ("kinetic_energy", "dissipated_energy", "collisions")})
        grains = HardSpheres(restitution=0.9)
        return spheres(18, 0.5, seed, dimension=d, duration=3.0, hard_spheres=grains, output=lost)
    every = Output(interval=1.0, trajectory=True, observables=_MOST)
    if feature.kind == "wells":
        well = HardSpheres(well=Well(depth=1.0, range=1.4))
        return spheres(18, 0.3, seed, dimension=d, duration=3.0, hard_spheres=well, output=every)
    return _drum(d, seed, every) if feature.kind == "drum" else _everything(d, seed, every)


def _everything(dimension: int, seed: int, output: Output) -> Scene:
    """Unlike rough grains in a field, with all kinds of walls that go together, and fields measured."""
    d, number, side = dimension, 16, 7.0 if dimension == 2 else 5.0
    rng = np.random.default_rng(seed)
    law = Friction(tangential_restitution=0.3, static=0.5, sliding=0.4)
    faces = {
        "x-": Face(random_phase=RandomPhase(speed=0.5, law="flux"), friction=law),
        "x+": Face(temperature=1.0),
        "y-": Face(oscillation=Oscillation(amplitude=0.1, frequency=12.0, phase=0.3), restitution=0.9),
    }
    return spheres(
        number,
        0.3,
        seed,
        dimension=d,
        duration=2.0,
        box=Box(lengths=(side,) * d, boundaries=_WALLED[:d], faces=faces),
        acceleration=(0.0, -1.0, 0.0)[:d],
        masses=tuple(rng.uniform(0.5, 3.0, number).tolist()),
        species=tuple(range(number)),
        hard_spheres=HardSpheres(
            diameter=tuple(rng.uniform(0.6, 1.0, number).tolist()),
            restitution=0.95,
            contact_duration=1e-3,
            friction=GrainFriction(tangential_restitution=0.3, static=0.5, sliding=0.4),
        ),
        output=output.model_copy(update={"fields": (2,) * d}),
    ).changed(seed=seed)


def _drum(dimension: int, seed: int, output: Output) -> Scene:
    """Rough grains in a drum that turns."""
    d, side = dimension, 7.0
    law = Friction(tangential_restitution=0.3, static=0.5, sliding=0.4)
    cylinder = Cylinder(radius=0.5 * side, axis="z" if d == 3 else None, angular_velocity=0.5, friction=law)
    observables = (*output.observables, "wall_torque")
    return spheres(
        12,
        0.3,
        seed,
        dimension=d,
        duration=2.0,
        box=Box(lengths=(side,) * d, boundaries=_AROUND[:d], cylinder=cylinder),
        acceleration=(0.0, -1.0, 0.0)[:d],
        hard_spheres=HardSpheres(
            diameter=0.7, friction=GrainFriction(tangential_restitution=0.3, static=0.5, sliding=0.4)
        ),
        output=output.model_copy(update={"observables": observables}),
    )


def _judge(laboratory: Laboratory, feature: _Feature) -> Judged:
    scene = _scene(feature, laboratory.seed() % 2**31)
    return same_bits(laboratory, scene, feature.method, feature.kind)


CHECKS = (
    Check(
        name="events/compiled",
        title="The event loop compiled and as plain Python",
        equation=EQUATION,
        criterion="not one bit differs",
        citation="Marin, Risso & Cordero, J. Comput. Phys. 103, 306 (1993)",
        judge=_judge,
        variants=(
            *quick(
                **{
                    "gas-3d": _Feature(3, "gas"),
                    "hard-walls-2d": _Feature(2, "hard-walls"),
                }
            ),
            *full(
                **{"grains-2d": _Feature(2, "grains")},
                **{f"{kind}-{d}d": _Feature(d, kind) for kind in ("everything", "drum", "wells") for d in (2, 3)},
                **{
                    queue: _Feature(3, "gas", Method(scheme=f"event_driven_{queue}")) for queue in ("lists", "calendar")
                },
                neighbours=_Feature(2, "gas", Method(scheme="event_driven_neighbours")),
            ),
        ),
        needs=interpretable(event_driven(observables=" ".join(_MOST))),
        faults=(
            (
                "gas-3d",
                Fault(
                    "reordered-sums",
                    "events/kernels/compiled.py",
                    '_ALL: dict[str, Any] = {"_nrt": False, ',
                    '_ALL: dict[str, Any] = {"_nrt": False, "fastmath": True, ',
                    "compiled code may reorder and fuse sums",
                ),
            ),
        ),
    ),
)
