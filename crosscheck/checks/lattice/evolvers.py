"""Three ways to move the same gas: bit planes, table look-up and NumPy."""

from __future__ import annotations

from typing import NamedTuple

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.lattice.gases import LATTICE, filled, gas_scene
from crosscheck.checks.lattice.recording import recorded
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references.lattice_models import MODELS
from crosscheck.scene import Method, Obstacle, Output
from crosscheck.verdict import Judged, round_off, worst

STEPS = 10
EVOLVERS = ("lattice_lookup", "lattice_planes", "lattice_numpy")
#: Models whose bit planes the quick tier compiles for walls and a force, and for neither: as `lattice/audit` does.
DRIVEN, FREE = ("fhp3",), ("fhp_saturated",)


class _Case(NamedTuple):
    """A model; with walls of all kinds and a force, free, or both."""

    model: str
    driven: bool
    free: bool


def _judge(laboratory: Laboratory, case: _Case) -> Judged:
    """The same sites from all evolvers, and what one of them does by the auditor: agreement alone proves nothing."""
    seed = laboratory.seed()
    walls = (
        Obstacle(rows=(0, 0), rule="diffusive_y"),
        Obstacle(columns=(0, 0), rule="diffusive_x"),
        Obstacle(rows=(11, 11), rule="specular_y"),
        Obstacle(columns=(70, 70), rule="specular_x"),
        Obstacle(centre=(35.0, 5.0), radius=3.0),
    )
    start = filled(0.35, seed)
    judgements = []
    for name, wanted, gas in (
        ("walls", case.driven, {"obstacles": walls, "force": -0.05}),
        ("free", case.free, {}),
    ):
        if not wanted:
            continue
        scene = gas_scene(name, case.model, 14, 133, STEPS, start, Output(), **gas)
        first, *others = (recorded(laboratory, scene, Method(scheme=scheme)) for scheme in EVOLVERS)
        judgements.append(
            round_off(
                f"{name}: sites that {EVOLVERS[0]} moves otherwise than the rules say",
                first.forbidden.number,
                0.5,
                "coordinates say where each particle arrives, the definition of the model what it may become",
                note=first.forbidden.first,
            )
        )
        judgements += [
            round_off(
                f"{name}: sites in which {scheme} differs from {EVOLVERS[0]}",
                float((other.trajectory != first.trajectory).any(axis=-1).sum()),
                0.5,
                "the random bits of a site are numbered, so all evolvers draw the same: not one bit may differ",
            )
            for scheme, other in zip(EVOLVERS[1:], others, strict=True)
        ]
    return worst(judgements, f"{STEPS} steps of 14 x 133 sites")


CHECKS = (
    Check(
        name="lattice/evolvers",
        title="Bit planes, table look-up and NumPy move the same gas, by the rules",
        equation="s(t + 1) = C S s(t)",
        criterion="not one bit differs",
        citation="Frisch, Hasslacher & Pomeau, Phys. Rev. Lett. 56, 1505 (1986)",
        judge=_judge,
        variants=(
            *(Variant(name, _Case(name, name in DRIVEN, name in FREE)) for name in (*DRIVEN, *FREE)),
            *(Variant(f"{name}-all", _Case(name, True, True), "full") for name in MODELS),
        ),
        faults=(
            (
                "fhp3",
                Fault(
                    "neighbour-word",
                    "lattice/kernels/words.py",
                    "(read(place + -1) >> 63)",
                    "(read(place + -2) >> 63)",
                    "bit planes take the bit at the edge of a word from the next but one",
                ),
            ),
        ),
        needs=Needs("lattice_gas", (LATTICE,), observables=frozenset({"populations"}), schemes=EVOLVERS),
        interpreted=True,
    ),
)
