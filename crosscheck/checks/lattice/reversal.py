"""HPP without random numbers: its motion can be reversed."""

from __future__ import annotations

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.lattice.gases import LATTICE, filled, gas_scene
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.scene import LatticeGas, Obstacle, Output
from crosscheck.verdict import Judged, bounded, round_off, worst


def _judge(laboratory: Laboratory, steps: int) -> Judged:
    """HPP for this number of steps and back: the identical lattice."""
    obstacles = (
        Obstacle(rows=(0, 0), rule="specular_y"),
        Obstacle(centre=(100.0, 60.0), radius=20.0),
        Obstacle(columns=(150, 151), rows=(10, 90)),
    )
    there = gas_scene(
        "there",
        "hpp",
        128,
        200,
        0,
        filled(0.3, laboratory.seed(), velocity_x=0.2),
        Output(observables=("sites",)),
        obstacles=obstacles,
    )
    start, half, back = (
        laboratory.run(
            there.changed(
                duration=time,
                lattice_gas=LatticeGas(model="hpp", rows=128, columns=200, obstacles=obstacles, reversals=reversals),
            ),
            LATTICE,
        )["sites"]
        for time, reversals in ((0, None), (steps, None), (2 * steps, (steps, 2 * steps)))
    )
    differ = float((back != start).sum())
    judgements = [
        round_off("sites that differ after the way back", differ, 0.5, "deterministic: not one bit"),
        bounded(
            "sites that differ half-way",
            int((half != start).sum()),
            start.size / 4,
            "else nothing has moved",
            at_least=True,
            control=True,
        ),
    ]
    return worst(judgements, f"{steps} steps forward and back, 128 x 200 sites with obstacles")


CHECKS = (
    Check(
        name="lattice/reversal",
        title="HPP without random numbers is reversible: steps forward and back restore the lattice",
        equation="(R C)(C S)^n (R C)(C S)^n = 1",
        criterion="the identical lattice",
        citation="Hardy, de Pazzis & Pomeau, Phys. Rev. A 13, 1949 (1976)",
        judge=_judge,
        variants=(Variant("10000", 10_000),),
        faults=(
            (
                "10000",
                Fault(
                    "half-reversal",
                    "lattice/gas.py",
                    "self._set(mirrors[BOUNCE_BACK, after]",
                    "self._set(mirrors[REVERSE_X, after]",
                    "the reversal leaves the velocities along y alone",
                ),
            ),
        ),
        needs=Needs(
            "lattice_gas",
            (LATTICE,),
            words=frozenset({"lattice_gas.obstacles", "lattice_gas.reversals"}),
            observables=frozenset({"sites"}),
        ),
    ),
)
