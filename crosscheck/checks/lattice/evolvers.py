"""Three ways to move the same gas: bit planes, table look-up and NumPy."""

from __future__ import annotations

from crosscheck.checks.base import Check, Laboratory, quick
from crosscheck.checks.lattice.gases import LATTICE, filled, gas_scene
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references.lattice_models import MODELS
from crosscheck.scene import Method, Obstacle, Output
from crosscheck.verdict import Judged, round_off, worst

EVOLVERS = ("lattice_lookup", "lattice_planes", "lattice_numpy")


def _judge(laboratory: Laboratory, model: str) -> Judged:
    """The same sites from all evolvers, with all kinds of walls and a force."""
    seed = laboratory.seed()
    walls = (
        Obstacle(rows=(0, 0), rule="diffusive_y"),
        Obstacle(columns=(0, 0), rule="diffusive_x"),
        Obstacle(rows=(21, 21), rule="specular_y"),
        Obstacle(columns=(70, 70), rule="specular_x"),
        Obstacle(centre=(35.0, 9.0), radius=5.0),
    )
    output = Output(observables=("sites",))
    scene = gas_scene("walls", model, 30, 133, 100, filled(0.35, seed), output, obstacles=walls, force=-0.05)
    free = gas_scene("free", model, 30, 133, 100, filled(0.35, seed), output)
    judgements = []
    for one in (scene, free):
        first, *others = (laboratory.run(one, Method(scheme=scheme))["sites"] for scheme in EVOLVERS)
        judgements += [
            round_off(
                f"{one.name}: sites in which {scheme} differs from {EVOLVERS[0]}",
                float((other != first).sum()),
                0.5,
                "the random bits of a site are numbered, so all evolvers draw the same: not one bit may differ",
            )
            for scheme, other in zip(EVOLVERS[1:], others, strict=True)
        ]
    return worst(judgements, "100 steps of 30 x 133 sites; walls of every rule and a force, and free")


CHECKS = (
    Check(
        name="lattice/evolvers",
        title="Bit planes, table look-up and NumPy move the same gas",
        equation="s(t + 1) = C S s(t)",
        criterion="not one bit differs",
        citation="Frisch, Hasslacher & Pomeau, Phys. Rev. Lett. 56, 1505 (1986)",
        judge=_judge,
        variants=quick(*MODELS),
        faults=(
            (
                "fhp1",
                Fault(
                    "neighbour-word",
                    "lattice/kernels/words.py",
                    "(read(place + -1) >> 63)",
                    "(read(place + -2) >> 63)",
                    "bit planes take the bit at the edge of a word from the next but one",
                ),
            ),
        ),
        needs=Needs("lattice_gas", (LATTICE,), observables=frozenset({"sites"}), schemes=EVOLVERS),
    ),
)
