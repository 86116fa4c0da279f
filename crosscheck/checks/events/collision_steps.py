"""Few hard spheres by a search for collisions after each time step: every step against the definition."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant, quick
from crosscheck.checks.operations import exactly
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Claims
from crosscheck.references import EPSILON
from crosscheck.references.collision_steps import Spheres, after_steps
from crosscheck.scene import Box, Floats, HardSpheres, Method, Output, Scene, explicit
from crosscheck.verdict import Judged, bounded, round_off, worst

#: Steps between samples, samples, and steps after the last sample.
_EVERY, _SAMPLES, _REST = 8, 25, 3
#: Roundings of a coordinate, and of a speed, that a sample may be off after the steps since the one before.
_ROUNDINGS = 64
#: Share of the intervals between samples that may be left out, since three spheres are together in them.
_CROWDED = 0.5


class _Crowd(NamedTuple):
    """Spheres on a grid, displaced at random.

    grid: their number along each axis. spacing: of the grid, length. periodic: in a box of that size, in which they
    begin anywhere, in other boxes too; otherwise without one, and flying to the middle. point: whether the first has
    no size. restitution: of all pairs. dt: time. fast: speed of the last one along x; it is light, so that the others
    stay slow. None: it is like the others.
    """

    grid: tuple[int, ...]
    spacing: float
    periodic: bool
    point: bool
    restitution: float
    dt: float
    fast: float | None = None


_CROWDS = {
    "disks in two squares": _Crowd((6, 3), 0.05, True, False, 0.8, 2.0**-10),
    "disks without a box": _Crowd((3, 4), 20.0, False, True, 1.0, 0.4),
    "spheres in two cubes": _Crowd((2, 2, 4), 2.5, True, True, 0.5, 0.04),
    "spheres without a box": _Crowd((2, 3, 2), 300.0, False, False, 1.0, 6.0),
    # 0.37 of a side in each step
    "a fast sphere": _Crowd((2, 2, 2), 3.0, True, False, 1.0, 0.05, fast=44.4),
}


def _scene(name: str, crowd: _Crowd, seed: int) -> Scene:
    rng = np.random.default_rng(seed)
    lengths = np.multiply(crowd.grid, crowd.spacing)
    places = np.stack(np.meshgrid(*map(np.arange, crowd.grid), indexing="ij"), axis=-1).reshape(-1, len(crowd.grid))
    number = len(places)
    diameters = rng.uniform(0.25, 0.55, number) * crowd.spacing
    diameters[0] *= not crowd.point
    x = (places + rng.uniform(0.4, 0.6, places.shape)) * crowd.spacing
    velocities = rng.normal(size=places.shape)
    if crowd.periodic:
        x += lengths * rng.integers(-2, 3, places.shape)
    else:
        velocities = 0.3 * velocities + (lengths / 2 - x) / crowd.spacing
    masses = rng.uniform(0.5, 2.0, number)
    if crowd.fast is not None:
        velocities[-1, 0], masses[-1] = crowd.fast, 1e-3
    velocities *= 1.0 if crowd.fast is not None else 0.02 * crowd.spacing / crowd.dt
    return Scene(
        name=name.replace(" ", "-"),
        dimension=len(crowd.grid),  # type: ignore[arg-type]
        duration=(_EVERY * _SAMPLES + _REST) * crowd.dt,
        masses=tuple(masses.tolist()),
        species=tuple(range(number)),
        hard_spheres=HardSpheres(diameter=tuple(diameters.tolist()), restitution=crowd.restitution),
        box=Box(lengths=tuple(lengths.tolist())) if crowd.periodic else None,
        initial=explicit(x, velocities),
        output=Output(interval=_EVERY * crowd.dt, observables=("kinetic_energy", "collisions"), trajectory=True),
    )


def _judge(laboratory: Laboratory, scheme: str) -> Judged:
    return worst([_judged(laboratory, scheme, name, crowd) for name, crowd in _CROWDS.items()])


def _judged(laboratory: Laboratory, scheme: str, name: str, crowd: _Crowd) -> Judged:
    """Each sample, from the one before it."""
    scene = _scene(name, crowd, laboratory.seed(name))
    state = scene.initial_state()
    assert state.diameters is not None
    spheres = Spheres(state.masses.tolist(), state.diameters.tolist(), crowd.restitution, scene.periods().tolist())
    run = laboratory.run(scene, Method(scheme=scheme, dt=crowd.dt))
    x = np.concatenate([run["positions"], run["final_positions"][None]])
    v = np.concatenate([run["velocities"], run["final_velocities"][None]])
    # a sphere may have all of the energy
    fastest = float(np.sqrt(2 * run["kinetic_energy"][0] / state.masses.min()))
    far, fast, counts, impulses, judged = [0.0], [0.0], [0.0], 0, 0
    before = state.positions, state.velocities
    for k in range(_SAMPLES + 1):
        steps = _EVERY if k < _SAMPLES else _REST
        moved = after_steps(spheres, *before, crowd.dt, steps)
        before = x[k + 1], v[k + 1]
        impulses += moved.impulses
        if moved.crowded:
            continue
        judged += 1
        # of the normal: a rounding of the places, over the distance; the next impulse turns what that has displaced
        turned = _rounding(x[k : k + 2]) / moved.closest
        grown = (1 + fastest * steps * crowd.dt / moved.closest) ** max(moved.most - 1, 0)
        slips = _ROUNDINGS * fastest * (EPSILON + turned) * grown
        far.append(_share(x[k + 1] - moved.positions, _ROUNDINGS * _rounding(x[k : k + 2]) + slips * steps * crowd.dt))
        fast.append(_share(v[k + 1] - moved.velocities, slips))
        if k < _SAMPLES:
            counts.append(abs(run["collisions"][k + 1] - run["collisions"][k] - moved.impulses))
    energy = 0.5 * np.einsum("n,snd->s", state.masses, run["velocities"] ** 2)
    judged_energy = float(np.abs(run["kinetic_energy"] / energy - 1).max())
    start = max(
        _share(x[0] - state.positions, 4 * _rounding(x[0])), _share(v[0] - state.velocities, 4 * _rounding(v[0]))
    )
    why = "64 roundings of a coordinate, and of a normal, over the steps between two samples"
    return worst(
        [
            round_off(f"{name}: the start, in units of its rounding", start, 1.0, "4 roundings of a coordinate"),
            round_off(f"{name}: places, in units of their rounding", max(far), 1.0, why),
            round_off(f"{name}: velocities, in units of their rounding", max(fast), 1.0, why),
            exactly(f"{name}: most collisions too many or too few between two samples", max(counts), 0),
            exactly(f"{name}: steps", run.cost.steps, _EVERY * _SAMPLES + _REST),
            round_off(
                f"{name}: kinetic energy over that of the velocities, less 1",
                judged_energy,
                4 * scene.number * EPSILON,
                "4 roundings a particle",
            ),
            bounded(
                f"{name}: intervals with three spheres together",
                1 - judged / (_SAMPLES + 1),
                _CROWDED,
                "the others are judged",
            ),
            bounded(f"{name}: 1 over collisions", 1 / max(impulses, 1e-9), 0.5, "fewer would judge nothing"),
        ]
    )


def _rounding(x: Floats) -> float:
    return EPSILON * float(np.abs(x).max())


def _share(difference: Floats, bound: float) -> float:
    return float(np.abs(difference).max()) / bound


def _schemes(schemes: Mapping[str, Claims]) -> tuple[Variant, ...]:
    return quick(*(name for name, claims in schemes.items() if claims.kind == "collision_search"))


CHECKS = (
    Check(
        name="events/collision-steps",
        title="Few hard spheres by a search for collisions after each time step: every step, computed again",
        equation="x' = x + v dt; v_n' = -alpha v_n where r < sigma and v_n < 0",
        criterion="places and velocities to round-off, from sample to sample; impulses counted exactly",
        citation="Rein & Liu, Astron. Astrophys. 537, A128 (2012)",
        judge=_judge,
        variants=_schemes,
        needs=Needs(
            "hard_spheres",
            ("collision_search",),
            frozenset(
                [
                    "dimension=2",
                    "dimension=3",
                    "masses[]",
                    "hard_spheres.diameter[]",
                    "hard_spheres.restitution",
                    "box.boundaries=periodic",
                    "box.boundaries=open",
                ]
            ),
            frozenset({"positions", "velocities", "kinetic_energy", "collisions"}),
            promises=("impulses_after_steps",),
        ),
        # of refimpl, which has no such scheme; mutants of the engines' adapters show what it sees
        faults=(),
    ),
)
