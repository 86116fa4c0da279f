"""Sites that a lattice gas computes in a step: each one once."""

from __future__ import annotations

from crosscheck.checks.base import Check, Laboratory, quick
from crosscheck.checks.lattice.gases import LATTICE, filled, gas_scene, methods_for
from crosscheck.checks.operations import EQUATION, counted, counting, exactly
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.scene import Output
from crosscheck.verdict import Judged, worst

_ROWS, _COLUMNS, _STEPS = 6, 70, 5


def _judge(laboratory: Laboratory, model: str) -> Judged:
    output = Output(interval=_STEPS, observables=("populations",))
    scene = gas_scene("sites", model, _ROWS, _COLUMNS, _STEPS, filled(0.3, laboratory.seed()), output)
    judgements = []
    for method in methods_for(laboratory.engine, scene):
        cost = laboratory.run(scene, method).cost
        sites = counted(cost, "site_updates")
        judgements += [
            exactly(f"{method.scheme}: sites computed", sites, _ROWS * _COLUMNS * _STEPS),
            exactly(f"{method.scheme}: steps", cost.steps, _STEPS),
        ]
    return worst(
        judgements,
        f"{_STEPS} steps of {_ROWS} x {_COLUMNS} sites",
    )


CHECKS = (
    Check(
        name="lattice/operations",
        title="Sites computed in a step of a lattice gas",
        equation=EQUATION,
        criterion="rows x columns x steps, exactly",
        citation="Frisch, Hasslacher & Pomeau, Phys. Rev. Lett. 56, 1505 (1986)",
        judge=_judge,
        variants=quick("fhp1"),
        needs=counting(Needs("lattice_gas", (LATTICE,), observables=frozenset({"populations"}))),
        interpreted=True,
        faults=(
            (
                "fhp1",
                Fault(
                    "second-pass",
                    "lattice/kernels/planes.py",
                    "        for row in range(first, last):\n            below",
                    "        for row in [*range(first, last), *range(first, last)]:\n            below",
                    "bit planes are computed twice in a step",
                ),
            ),
        ),
    ),
)
