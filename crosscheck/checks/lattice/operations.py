"""What a lattice gas computes in a step: each site once; and how often it fetches its rows from memory."""

from __future__ import annotations

from crosscheck.checks.base import Check, Laboratory, quick
from crosscheck.checks.lattice.gases import LATTICE, filled, gas_scene, methods_for
from crosscheck.checks.operations import EQUATION, as_known, counted, counting, exactly
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.scene import Output
from crosscheck.verdict import Judged, worst

_ROWS, _COLUMNS, _STEPS = 24, 70, 24
#: Rows that bit planes fetch for these steps: two blocks of 12 steps, each of which fetches 22 rows, and then 24.
_FETCHED = {"lattice_planes": 92}


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
        if method.scheme in _FETCHED:
            judgements += as_known(laboratory, cost, {"row_fetches": _FETCHED[method.scheme]})
    return worst(
        judgements,
        f"{_STEPS} steps of {_ROWS} x {_COLUMNS} sites",
    )


CHECKS = (
    Check(
        name="lattice/operations",
        title="Sites computed in a step of a lattice gas, and rows fetched",
        equation=EQUATION,
        criterion="rows x columns x steps, exactly; rows fetched: 5 % around the known number of the engine",
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
                    "                for level in range(levels):\n",
                    "                for level in [*range(levels), *range(levels)]:\n",
                    "bit planes are computed twice in a step",
                ),
            ),
            (
                "fhp1",
                Fault(
                    "a-step-a-pass",
                    "lattice/bitplanes.py",
                    "    if block < 2:\n        return",
                    "    if block > 0:\n        return",
                    "bit planes pass through memory once in each step",
                ),
            ),
        ),
    ),
)
