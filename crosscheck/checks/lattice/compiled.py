"""Lattice gases compiled and as plain Python: the same bits."""

from __future__ import annotations

from crosscheck.checks.base import Check, Laboratory, full, quick
from crosscheck.checks.both_modes import EQUATION, interpretable, same_bits
from crosscheck.checks.lattice.gases import LATTICE, filled, gas_scene
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references.lattice_models import MODELS
from crosscheck.scene import Method, Obstacle, Output
from crosscheck.verdict import Judged, worst

#: The compiled evolvers.
EVOLVERS = ("lattice_lookup", "lattice_planes")
#: Both lattices; models that draw no random bit for a collision, one and two.
QUICK = ("hpp", "fhp3", "fhp_saturated_identity")
_STEPS = 3


def _judge(laboratory: Laboratory, model: str) -> Judged:
    """Walls of every rule with a force, and free; more columns than a word of 64 has sites."""
    seed = laboratory.seed()
    walls = (
        Obstacle(rows=(0, 0), rule="diffusive_y"),
        Obstacle(columns=(0, 0), rule="diffusive_x"),
        Obstacle(rows=(5, 5), rule="specular_y"),
        Obstacle(columns=(66, 66), rule="specular_x"),
        Obstacle(centre=(35.0, 3.0), radius=2.0),
    )
    output = Output(observables=("sites", "populations"), interval=1, fields=(7, 2))
    free = gas_scene("free", model, 6, 70, _STEPS, filled(0.35, seed), output)
    pushed = output.model_copy(update={"observables": ("sites", "populations", "force_impulse")})
    walled = gas_scene("walls", model, 6, 70, _STEPS, filled(0.35, seed), pushed, obstacles=walls, force=-0.05)
    return worst(
        [
            same_bits(laboratory, scene, Method(scheme=scheme), f"{scheme}, {scene.name}")
            for scene in (walled, free)
            for scheme in EVOLVERS
        ],
        f"{_STEPS} steps of 6 x 70 sites",
    )


CHECKS = (
    Check(
        name="lattice/compiled",
        title="Bit planes and table look-up, compiled and as plain Python",
        equation=EQUATION,
        criterion="not one bit differs",
        citation="Frisch, Hasslacher & Pomeau, Phys. Rev. Lett. 56, 1505 (1986)",
        judge=_judge,
        variants=(*quick(*QUICK), *full(*(model for model in MODELS if model not in QUICK))),
        needs=interpretable(
            Needs("lattice_gas", (LATTICE,), observables=frozenset({"sites", "populations"}), schemes=EVOLVERS)
        ),
        faults=(
            (
                "fhp3",
                Fault(
                    "lost-lane",
                    "lattice/kernels/words.py",
                    "return wide(), lambda context, builder, sig, args: ir.Constant(_WIDE, list(range(WIDTH)))",
                    "return wide(), lambda context, builder, sig, args: ir.Constant(_WIDE, [0, 0, *range(2, WIDTH)])",
                    "compiled code draws the same random bits for the first two words of a row",
                ),
            ),
        ),
    ),
)
