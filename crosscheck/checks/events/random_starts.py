"""Random starts as an engine takes them over: velocities of a temperature or of a speed, for unlike masses.

Literature: J. C. Maxwell, Phil. Mag. 19, 19 (1860); Archimedes' theorem, for which a component of a random direction in
space is uniform.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full, quick
from crosscheck.checks.events.random_walls import chance
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.references.random_rules import (
    independent,
    maxwell_component,
    random_direction_component,
    repeats,
    uniform,
    uniform_in_groups,
)
from crosscheck.scene import Scene
from crosscheck.scene.parts import Box, HardSpheres, Lattice
from crosscheck.verdict import Judged, Judgement, bounded, round_off, worst

_NUMBER, _MASSES = 500, (0.5, 3.0, 1.3, 1.0)
_TEMPERATURE, _SPEED = 1.7, 2.3
_WORDS = "dimension=2 dimension=3 masses[] hard_spheres.diameter hard_spheres.fixed box.boundaries=periodic"


class _Start(NamedTuple):
    """dimension: 2 or 3. fixed: whether every fifth point never moves. speed: one for all, or a temperature."""

    dimension: int
    fixed: bool = False
    speed: bool = False


def _scene(start: _Start, seed: int) -> Scene:
    entries: dict[str, Any] = {"speed": _SPEED} if start.speed else {"temperature": _TEMPERATURE}
    structure: Any = "square" if start.dimension == 2 else "sc"
    return Scene(
        name="a random start",
        dimension=start.dimension,  # type: ignore[arg-type]
        duration=0.0,
        masses=tuple(_MASSES[i % len(_MASSES)] for i in range(_NUMBER)),
        species=tuple(int(i % 5 == 0) for i in range(_NUMBER)) if start.fixed else None,
        hard_spheres=HardSpheres(diameter=0.0, fixed=(1,) if start.fixed else None),
        box=Box(lengths=(7.0, 5.0, 6.0)[: start.dimension]),
        initial=Lattice(kind="lattice", structure=structure, number=_NUMBER, seed=seed, **entries),
    )


def _judge(laboratory: Laboratory, start: _Start) -> Judged:
    scenes = [_scene(start, laboratory.seed(name)) for name in ("one", "other")]
    one, other = (laboratory.run(scene, EVENT_DRIVEN)["final_velocities"] for scene in scenes)
    mass, moves = np.array(scenes[0].masses), np.ones(_NUMBER, dtype=bool)
    judged: list[Judgement] = []
    if start.fixed:
        moves = np.arange(_NUMBER) % 5 != 0
        judged.append(bounded("largest velocity of fixed points", float(abs(one[~moves]).max()), 0.0, "they are fixed"))
    v, w, mass, d = one[moves], other[moves], mass[moves], start.dimension
    rounding = EPSILON * _NUMBER
    if start.speed:
        speeds = np.linalg.norm(v, axis=1)
        error = float(abs(speeds - _SPEED).max())
        judged.append(round_off("largest error of a speed", error, 8 * EPSILON * _SPEED, "rounding of its components"))
        u, other_u = (random_direction_component(x / _SPEED, d) for x in (v, w))
    else:
        # the momentum of all is taken off, and with it the energy of one
        count = len(v) if start.fixed else len(v) - 1
        energy, expected = float((mass[:, None] * v**2).sum() / 2), d / 2 * count * _TEMPERATURE
        judged.append(
            round_off("error of the kinetic energy", energy - expected, rounding * expected, "a sum of N squares")
        )
        if not start.fixed:
            size = float((mass[:, None] * abs(v)).sum())
            judged.append(
                round_off("largest total momentum", float(abs(mass @ v).max()), rounding * size, "a sum of N momenta")
            )
        u, other_u = (maxwell_component(x, _TEMPERATURE, mass[:, None]) for x in (v, w))
    number = np.arange(len(v), dtype=float)
    for k in range(d):
        judged += [
            chance(f"component {k}", uniform(u[:, k])),
            chance(f"component {k} by mass", uniform_in_groups(u[:, k], mass)),
            chance(f"component {k} by the particle", independent(u[:, k], number)),
            chance(f"component {k} by the particle before", independent(u[1:, k], u[:-1, k])),
            chance(f"component {k} by another seed", independent(u[:, k], other_u[:, k])),
        ]
        if not start.speed:  # else they are not independent
            judged += [chance(f"component {k} by component {m}", independent(u[:, k], u[:, m])) for m in range(k)]
    none = "no two draws are the same double"
    judged.append(bounded("components that are equal", float(repeats(np.concatenate([v, w]))), 0.0, none))
    return worst(judged, f"{len(v)} points that move")


CHECKS = (
    Check(
        name="events/random-starts",
        title="Random velocities of a start, of a temperature or of a speed",
        equation="sum m v^2/2 = d (N - 1) T/2, sum m v = 0, Gaussian components of variance T/m; |v| = v0",
        criterion="sums to rounding; Kolmogorov-Smirnov and chi^2 of independence, red twice beyond the 1e-3 quantile",
        citation="Maxwell, Phil. Mag. 19, 19 (1860)",
        judge=_judge,
        variants=(
            *quick(**{"temperature-3d": _Start(3), "speed-2d": _Start(2, speed=True)}),
            *full(
                **{
                    "temperature-2d": _Start(2),
                    "temperature-fixed": _Start(3, fixed=True),
                    "speed-3d": _Start(3, speed=True),
                }
            ),
        ),
        needs=Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=frozenset(_WORDS.split()),
        ),
        faults=(
            (
                "temperature-3d",
                Fault(
                    "velocities-of-single-precision",
                    "events/simulation.py",
                    "np.array(positions, dtype=np.float64), np.array(velocities, dtype=np.float64)",
                    "np.array(positions, dtype=np.float64), np.array(velocities, dtype=np.float32).astype(np.float64)",
                    "the velocities of the start are rounded to single precision",
                ),
            ),
        ),
        interpreted=True,
    ),
)
