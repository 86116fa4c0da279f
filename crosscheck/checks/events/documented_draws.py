"""Random walls that draw as `crosscheck.references.splitmix` writes: every velocity, to rounding.

A generator with a term left out still passes all tests of chance; but the same scene and seed then give another run.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, quick
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.references.splitmix import phase_velocity, thermal_velocity
from crosscheck.scene import AXES, Box, Face, HardSpheres, Output, RandomPhase, Scene, explicit
from crosscheck.verdict import Judged, bounded, round_off, worst

#: Points, sides of the box, duration, masses in turn; events, at least.
_POINTS, _LENGTHS, _DURATION, _MASSES, _EVENTS = 7, (1.7, 2.1, 1.3), 25.0, (0.5, 3.0, 1.3), 100
_WORDS = (
    "dimension=2 dimension=3 masses[] hard_spheres.diameter box.boundaries=hard box.faces box.faces.restitution "
    "box.faces.temperature box.faces.random_phase box.faces.random_phase.law=uniform box.faces.random_phase.law=flux"
)
_FACES = {
    "x-": Face(temperature=0.7),
    "x+": Face(temperature=1.9),
    "y-": Face(temperature=1.1),
    "y+": Face(random_phase=RandomPhase(speed=0.9, law="uniform"), restitution=0.9),
    "z-": Face(random_phase=RandomPhase(speed=1.3, law="flux"), restitution=0.8),
    "z+": Face(temperature=1.6),
}


def _scene(dimension: int, seed: int) -> Scene:
    rng = np.random.default_rng(seed)
    lengths = np.array(_LENGTHS[:dimension])
    hard: Any = ("hard",) * dimension
    return Scene(
        name="points between random walls",
        dimension=dimension,  # type: ignore[arg-type]
        duration=_DURATION,
        masses=tuple(_MASSES[i % len(_MASSES)] for i in range(_POINTS)),
        seed=seed,
        hard_spheres=HardSpheres(diameter=0.0),
        box=Box(
            lengths=tuple(lengths.tolist()),
            boundaries=hard,
            faces={name: face for name, face in _FACES.items() if AXES.index(name[0]) < dimension},
        ),
        initial=explicit(rng.uniform(0.1, 0.9, (_POINTS, dimension)) * lengths, rng.normal(size=(_POINTS, dimension))),
        output=Output(trace=True),
    )


def _errors(scene: Scene, run: Run) -> list[float]:
    """The largest error of a component after each event, over the largest velocity there."""
    v, hits = scene.initial_state().velocities.copy(), [0] * scene.number
    masses, seed, found = np.asarray(scene.masses), scene.seed, []
    assert seed is not None
    for (i, partner), velocities in zip(run["event_partners"].astype(int), run["event_velocities"], strict=True):
        axis, upper = divmod(-1 - int(partner), 2)
        face, sign, expected = scene.faces[-1 - int(partner)], -1.0 if upper else 1.0, v[i].copy()
        assert face is not None
        incoming = sign * float(v[i, axis])
        if face.temperature is not None:
            drawn = thermal_velocity(seed, int(i), hits[i], math.sqrt(face.temperature / masses[i]))
            expected[axis] = sign * drawn[0]
            others = [(axis + k) % 3 for k in (1, 2)] if scene.dimension == 3 else [1 - axis]
            for other, value in zip(others, drawn[1:], strict=False):
                expected[other] = value
        else:
            phase, a = face.random_phase, face.restitution
            assert phase is not None
            own = phase_velocity(seed, int(i), hits[i], phase.speed, incoming, phase.law)
            expected[axis] = sign * ((1 + a) * own - a * incoming)
        size = max(float(np.abs(expected).max()), float(np.abs(v[i]).max()))
        found.append(float(np.abs(velocities[0] - expected).max()) / size)
        hits[i] += 1
        v[i] = velocities[0]
    return found


def _judge(laboratory: Laboratory, dimension: int) -> Judged:
    scene = _scene(dimension, laboratory.seed())
    errors = _errors(scene, laboratory.run(scene, EVENT_DRIVEN))
    where = int(np.argmax(errors)) if errors else 0
    why = "roundings of logarithm, root, cosine and products, and of the angle 2 pi u, which is some units large"
    return worst(
        [
            round_off("largest error of a velocity that a wall gives", max(errors, default=math.nan), 32 * EPSILON, why,
                      note=f"event {where}"),
            bounded("hits", float(len(errors)), _EVENTS, "what has few events judges little", at_least=True,
                    control=True),
        ],
        f"{len(errors)} hits",
    )  # fmt: skip


CHECKS = (
    Check(
        name="events/documented-draws",
        title="Random walls that promise to draw by SplitMix64: every velocity that they give",
        equation="u = hash(seed, particle, hits, draw); v_n = sqrt(-2 T/m ln u); V = V0 cos(2 pi u)",
        criterion="each velocity to its rounding",
        citation="Steele, Lea & Flood, ACM SIGPLAN Notices 49 (10), 453 (2014)",
        judge=_judge,
        variants=quick(**{"2d": 2, "3d": 3}),
        needs=Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=frozenset(_WORDS.split()),
            observables=frozenset({"event_partners", "event_velocities"}),
            promises=("documented_draws",),
        ),
        interpreted=True,
        faults=(
            (
                "3d",
                Fault(
                    "half-a-finaliser",
                    "random_bits.py",
                    "return z ^ (z >> _S31)  # type",
                    "return z  # type",
                    "the last term of the hash is missing: its bits look as random as before",
                ),
            ),
        ),
    ),
)
