"""Time steps and smooth forces, compiled and as plain Python: the same bits, or the same to rounding.

The quick variants ask for what other quick checks ask for, so that no kernel is compiled for them alone.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Literal

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.both_modes import EQUATION, interpretable, same_bits, same_to_rounding
from crosscheck.checks.stepping.fluids import OBSERVABLES, OPEN, PERIODIC, STEP, fluid, shaken
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.registry import engine_class
from crosscheck.faults import Fault
from crosscheck.scene import Box, Gravity, LennardJones, Method, Output, Scene, Spring, Wall, explicit
from crosscheck.verdict import Judged, worst

_BOUNDARIES: tuple[Literal["periodic", "wall"], ...] = ("wall", "periodic", "wall")
_DT = 0.02
#: Schemes that other checks of the quick tier compile for springs with damping, and for gravity.
_DAMPED = ("velocity_verlet", "beeman_pc", "gear5", "gear5_velocity")
_ORBITS = ("symplectic_euler", "verlet", "leapfrog", "velocity_verlet", "gear2", "gear5")
#: Of a force or an energy of Lennard-Jones particles, and of what some steps make of it.
_ROUNDINGS = 256.0
_WHY_FUSED = (
    "compiled code fuses products and sums: each of the dozen operations of a pair may round once less; those of 50 "
    "neighbours add up as a random walk, 7 times as much, and the forces of pairs cancel to a third of them"
)


def _schemes(laboratory: Laboratory, chosen: tuple[str, ...] = ()) -> list[Method]:
    """Those of `chosen` that the engine has; none chosen: all that step."""
    claims = engine_class(laboratory.engine).schemes
    stepping = [name for name, claim in claims.items() if claim.kind == "stepping"]
    return [Method(scheme=name, dt=_DT) for name in stepping if not chosen or name in chosen]


def _bodies(seed: int, number: int, dimension: int, spread: float = 1.0, **interaction: object) -> Scene:
    """Bodies at random places and velocities, of unlike masses, for ten steps."""
    rng = np.random.default_rng(seed)
    shape = (number, dimension)
    return Scene(
        name="bodies",
        dimension=dimension,  # type: ignore[arg-type]
        duration=10 * _DT,
        masses=tuple(rng.uniform(0.5, 2.0, number).tolist()),
        initial=explicit(spread * rng.normal(size=shape), rng.normal(size=shape)),
        output=Output(interval=5 * _DT, trajectory=True),
        **interaction,  # type: ignore[arg-type]
    )


def _judge_springs(laboratory: Laboratory, chosen: tuple[str, ...]) -> Judged:
    scene = _bodies(laboratory.seed(), 3, 2, spring=Spring(k=2.0, gamma=0.3))
    return worst([same_bits(laboratory, scene, method, method.scheme) for method in _schemes(laboratory, chosen)])


def _judge_orbits(laboratory: Laboratory, chosen: tuple[str, ...]) -> Judged:
    scene = _bodies(laboratory.seed(), 3, 2, gravity=Gravity())
    return worst([same_bits(laboratory, scene, method, method.scheme) for method in _schemes(laboratory, chosen)])


def _judge_many_bodies(laboratory: Laboratory) -> Judged:
    scene = _bodies(laboratory.seed(), 20, 3, 3.0, gravity=Gravity(softening=0.5))
    why = "compiled code adds the forces of pairs up in another order: a random walk of 20 roundings each, twice"
    return same_to_rounding(laboratory, scene, Method(scheme="velocity_verlet", dt=_DT), "20 bodies", 64.0, why)


def _moving(scene: Scene, seed: int) -> Scene:
    """Five steps of the scene, its particles shaken."""
    rng = np.random.default_rng(seed)
    placed = shaken(scene, 0.05, seed)
    start = placed.initial_state()
    output = Output(interval=STEP.step, trajectory=True, observables=OBSERVABLES, forces=True)
    start_again = explicit(start.positions, rng.normal(size=start.positions.shape))
    return placed.changed(initial=start_again, duration=5 * STEP.step, output=output)


def _judge_fluid(laboratory: Laboratory) -> Judged:
    scene = _moving(fluid(32, 0.8, 1.0, 1, cutoff=1.7), laboratory.seed())
    return same_to_rounding(laboratory, scene, STEP, "fluid", _ROUNDINGS, _WHY_FUSED)


def _judge_truncations(laboratory: Laboratory) -> Judged:
    return worst(
        [
            same_to_rounding(
                laboratory,
                _moving(fluid(32, 0.8, 1.0, 1, truncation=truncation), laboratory.seed()),
                STEP,
                truncation,
                _ROUNDINGS,
                _WHY_FUSED,
            )
            for truncation in ("shifted", "force_shifted")
        ]
    )


def _judge_mixture(laboratory: Laboratory) -> Judged:
    """Two species between walls, in the plane and in space."""
    judged = []
    for dimension, side in ((2, 6.5), (3, 4.0)):
        places = np.array(list(np.ndindex(*(5 if dimension == 2 else 3,) * dimension)))[:24] * 1.15 + 0.9
        kinds = np.arange(len(places)) % 2
        scene = Scene(
            name="mixture",
            dimension=dimension,  # type: ignore[arg-type]
            duration=0.0,
            masses=tuple((1.0 + kinds).tolist()),
            species=tuple(kinds.tolist()),
            lennard_jones=LennardJones(cutoff=2.0, length=(1.0, 0.9), epsilon=(1.0, 0.7), truncation="shifted"),
            box=Box(
                lengths=(side,) * dimension,
                boundaries=_BOUNDARIES[:dimension],
                wall=Wall(epsilon=1.0, sigma=0.7, cutoff=1.5),
            ),
            initial=explicit(places, np.zeros_like(places)),
        )
        moving = _moving(scene, laboratory.seed(f"{dimension}"))
        judged.append(same_to_rounding(laboratory, moving, STEP, f"mixture, {dimension}D", _ROUNDINGS, _WHY_FUSED))
    return worst(judged)


def _judge(laboratory: Laboratory, judge: Callable[[Laboratory], Judged]) -> Judged:
    return judge(laboratory)


_TRAJECTORY = frozenset({"positions", "velocities"})
_FLUIDS = frozenset({*OBSERVABLES, *_TRAJECTORY, "forces"})
_FORMS = frozenset({"lennard_jones.truncation=shifted", "lennard_jones.truncation=force_shifted"})


def _variant(name: str, judge: Callable[[Laboratory], Judged], needs: Needs, tier: str = "quick") -> Variant:
    return Variant(name, judge, tier, interpretable(needs))  # type: ignore[arg-type]


CHECKS = (
    Check(
        name="stepping/compiled",
        title="Schemes and smooth forces, compiled and as plain Python",
        equation=EQUATION,
        criterion="not one bit differs; where compiled code fuses or reorders, roundings of the largest number",
        citation="Allen & Tildesley, Computer Simulation of Liquids (1987)",
        judge=_judge,
        variants=(
            _variant("springs", partial(_judge_springs, chosen=_DAMPED), Needs("spring", observables=_TRAJECTORY)),
            _variant(
                "springs-every-scheme",
                partial(_judge_springs, chosen=()),
                Needs("spring", observables=_TRAJECTORY),
                "full",
            ),
            _variant("orbits", partial(_judge_orbits, chosen=_ORBITS), Needs("gravity", observables=_TRAJECTORY)),
            _variant(
                "orbits-every-scheme",
                partial(_judge_orbits, chosen=()),
                Needs("gravity", observables=_TRAJECTORY),
                "full",
            ),
            _variant("fluid", _judge_fluid, Needs("lennard_jones", words=PERIODIC, observables=_FLUIDS)),
            _variant("many-bodies", _judge_many_bodies, Needs("gravity", observables=_TRAJECTORY), "full"),
            _variant(
                "truncations",
                _judge_truncations,
                Needs("lennard_jones", words=PERIODIC | _FORMS, observables=_FLUIDS),
                "full",
            ),
            _variant(
                "mixture",
                _judge_mixture,
                Needs("lennard_jones", words=PERIODIC | OPEN | {"box.wall"}, observables=_FLUIDS),
                "full",
            ),
        ),
        needs=interpretable(Needs("spring")),
        faults=(
            (
                "fluid",
                Fault(
                    "moved-lanes",
                    "stepping/kernels/simd.py",
                    "return builder.load(builder.bitcast(pointer, _VECTOR.as_pointer()), align=8)",
                    "return builder.fadd(builder.load(builder.bitcast(pointer, _VECTOR.as_pointer()), align=8), "
                    "ir.Constant(_VECTOR, [1e-12] * WIDTH))",
                    "compiled code moves the particles of a tile by 1e-12",
                ),
            ),
        ),
    ),
)
