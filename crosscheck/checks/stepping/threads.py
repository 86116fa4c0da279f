"""Forces that threads share: the bits of one thread, whatever their number."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from crosscheck.checks.base import Check, Laboratory, variants_of
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.scene import Gravity, Method, Scene, explicit
from crosscheck.verdict import Judged, round_off, worst

_SCHEME, _STEP, _STEPS = "velocity_verlet", 2.0**-7, 200


def _cloud(seed: int) -> Scene:
    """Bodies enough for two threads to share the pairs of."""
    rng = np.random.default_rng(seed)
    return Scene(
        name="cloud",
        dimension=3,
        duration=_STEPS * _STEP,
        masses=tuple(rng.uniform(0.5, 1.5, 600).tolist()),
        gravity=Gravity(G=0.01, softening=0.3),
        initial=explicit(rng.normal(size=(600, 3)), rng.normal(size=(600, 3))),
    )


def _judge(laboratory: Laboratory, scene_of: Callable[[int], Scene]) -> Judged:
    """Final states with two and three threads beside that with one."""
    scene = scene_of(laboratory.seed())
    one, *others = (laboratory.run(scene, Method(scheme=_SCHEME, dt=_STEP, threads=threads)) for threads in (1, 2, 3))
    return worst(
        [
            round_off(
                f"coordinates and velocities that {threads} threads change",
                float(sum((run[name] != one[name]).sum() for name in ("final_positions", "final_velocities"))),
                0.5,
                "what a thread computes depends on its piece of the work alone: not one bit may differ",
            )
            for threads, run in zip((2, 3), others, strict=True)
        ],
        f"{scene.number} particles, {_STEPS} steps",
    )


CHECKS = (
    Check(
        name="stepping/threads",
        title="Forces shared by threads: not one bit depends on their number",
        equation="r_i'' = f_i/m_i",
        criterion="no bit differs",
        citation="Pall & Hess, Comput. Phys. Commun. 184, 2641 (2013), of forces by tiles",
        judge=_judge,
        variants=variants_of({"gravity": _cloud}),
        faults=(
            (
                "gravity",
                Fault(
                    "helpers-forget-the-last-tile",
                    "stepping/kernels/gravity.py",
                    "_take_pieces(work.rows, work.sums, work.flags, n, z, softening)",
                    "_take_pieces(work.rows, work.sums, work.flags, n - WIDTH, z, softening)",
                    "threads that help leave out the last eight bodies",
                ),
            ),
        ),
        needs=Needs(
            "gravity",
            words=frozenset({"dimension=3", "gravity.G", "gravity.softening", "masses[]", "method.threads"}),
            schemes=(_SCHEME,),
        ),
    ),
)
