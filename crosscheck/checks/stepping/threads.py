"""Forces that threads share: the bits of one thread, whatever their number."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant, variants_of
from crosscheck.checks.stepping.fluids import PERIODIC, fluid
from crosscheck.engines.capabilities import Needs, words
from crosscheck.faults import Fault
from crosscheck.scene import Box, Gravity, LennardJones, Method, Output, Scene, Wall, explicit
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


def _liquid(seed: int) -> Scene:
    """A liquid whose lists are made anew again and again; its energies are asked for on the way."""
    return _asking(fluid(1372, 0.8442, 1.4, seed, duration=_STEPS * _STEP))


def _mixture(seed: int) -> Scene:
    """Two species of unlike masses in the plane, between walls along one axis."""
    rng = np.random.default_rng(seed)
    places = np.stack(np.meshgrid(np.arange(30), np.arange(30), indexing="ij"), axis=-1).reshape(-1, 2) + 0.5
    species = rng.integers(0, 2, len(places))
    return _asking(
        Scene(
            name="mixture",
            dimension=2,
            duration=_STEPS * _STEP,
            masses=tuple((1.0 + 0.5 * species).tolist()),
            species=tuple(species.tolist()),
            lennard_jones=LennardJones(cutoff=2.5, epsilon=(1.0, 0.5), length=(1.0, 0.9), truncation="shifted"),
            box=Box(
                lengths=(36.0, 36.0), boundaries=("wall", "periodic"), wall=Wall(epsilon=1.0, sigma=0.5, cutoff=2.5)
            ),
            initial=explicit(1.2 * places, rng.normal(size=places.shape)),
        )
    )


def _asking(scene: Scene) -> Scene:
    return scene.changed(output=Output(interval=scene.duration / 4, observables=("potential_energy", "virial")))


def _judge(laboratory: Laboratory, scene_of: Callable[[int], Scene]) -> Judged:
    """Final states, and what was asked for on the way, with two and three threads beside those with one."""
    scene = scene_of(laboratory.seed())
    one, *others = (laboratory.run(scene, Method(scheme=_SCHEME, dt=_STEP, threads=threads)) for threads in (1, 2, 3))
    names = ("final_positions", "final_velocities", *scene.output.observables)
    return worst(
        [
            round_off(
                f"coordinates, velocities and energies that {threads} threads change",
                float(sum((run[name] != one[name]).sum() for name in names)),
                0.5,
                "what a thread computes depends on its piece of the work alone: not one bit may differ",
            )
            for threads, run in zip((2, 3), others, strict=True)
        ],
        f"{scene.number} particles, {_STEPS} steps",
    )


def _needs(asked: set[str]) -> Needs:
    """What a scene with these words asks for."""
    return Needs(
        "lennard_jones",
        words=frozenset(asked),
        observables=frozenset({"potential_energy", "virial"}),
        schemes=(_SCHEME,),
    )


_KERNEL = "stepping/kernels/lennard_jones.py"

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
    Check(
        name="stepping/lennard-jones-threads",
        title="Lennard-Jones forces and lists shared by threads: not one bit depends on their number",
        equation="r_i'' = f_i/m_i",
        criterion="no bit differs",
        citation="Pall & Hess, Comput. Phys. Commun. 184, 2641 (2013), of forces by tiles",
        judge=_judge,
        variants=(
            Variant("liquid", _liquid, needs=_needs({*PERIODIC, "method.threads"})),
            Variant("walled-mixture", _mixture, needs=_needs({*words(_mixture(0)), "method.threads"})),
        ),
        faults=(
            (
                "liquid",
                Fault(
                    "helpers-leave-out-lists",
                    _KERNEL,
                    "piece = work_on_lists(force.neighbours, kind, piece, r)",
                    "piece_done(shared.flags)\n                piece = next_piece(shared.flags)",
                    "threads that help take pieces of the work on lists and do nothing",
                ),
            ),
            (
                "liquid",
                Fault(
                    "a-late-helper-has-old-coordinates",
                    _KERNEL,
                    "kind, r = shared.task[KIND], doubles_at(shared.task[COORDINATES], number)",
                    "kind, r = shared.task[KIND], force.neighbours.built",
                    "threads that help see the coordinates of when the lists were made",
                ),
            ),
            (
                "walled-mixture",
                Fault(
                    "helpers-leave-out-forces",
                    _KERNEL,
                    "piece = _work(force, kind, piece, r, doubles_at(shared.task[RESULT], number))",
                    "piece_done(shared.flags)\n                piece = next_piece(shared.flags)",
                    "threads that help take pieces of the work on forces and do nothing",
                ),
            ),
        ),
        needs=Needs("lennard_jones"),
    ),
)
