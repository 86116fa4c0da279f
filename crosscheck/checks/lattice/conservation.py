"""Lattice gases keep mass and momentum, in whole particles."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import Check, Laboratory, full
from crosscheck.checks.lattice.gases import FHP, LATTICE, filled, gas_scene, methods_for, populations
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references.lattice_models import MODELS, VELOCITIES, momenta
from crosscheck.scene import Floats, Obstacle, Output
from crosscheck.verdict import Judged, round_off, worst


def _range(values: Floats) -> float:
    """Largest change of any column over the samples, (samples, ...)."""
    return float(np.ptp(values, axis=0).max())


def _judge(laboratory: Laboratory, model: str) -> Judged:
    """Mass and momentum of a periodic gas; with smooth walls and a force, those along the walls."""
    seed = laboratory.seed()
    periodic = gas_scene(
        "periodic",
        model,
        64,
        200,
        200,
        filled(0.3, seed, velocity_x=0.1, velocity_y=0.05),
        Output(interval=10, observables=("populations",)),
    )
    smooth = (Obstacle(rows=(0, 0), rule="specular_y"), Obstacle(rows=(40, 40), rule="specular_y"))
    channel = gas_scene(
        "channel",
        model,
        64,
        200,
        200,
        filled(0.3, seed),
        Output(interval=10, observables=("populations", "force_impulse")),
        obstacles=smooth,
        force=0.01,
    )
    changes = []
    methods = methods_for(laboratory.engine, channel)
    for method in methods:
        free = populations(laboratory.run(periodic, method)).sum(axis=(1, 2))
        pushed = laboratory.run(channel, method)
        forced = populations(pushed).sum(axis=(1, 2))
        given = pushed["force_impulse"].sum(axis=1) / VELOCITIES[model].unit[0]
        along = momenta(model, forced)[:, 0]
        changes.append(
            (
                _range(free.sum(axis=1)),
                _range(momenta(model, free)),
                _range(forced.sum(axis=1)),
                _range(along - given),
            )
        )
    quantities = (
        "change of mass, periodic",
        "change of momentum, periodic",
        "change of mass, channel",
        "change of momentum along the channel, less what the force gave",
    )
    judgements = [
        round_off(f"{quantity}, in particles", max(values), 0.5, "whole numbers: the smallest error is 1")
        for quantity, values in zip(quantities, zip(*changes, strict=True), strict=True)
    ]
    return worst(judgements, f"200 steps, the largest of {', '.join(method.scheme for method in methods)}")


CHECKS = (
    Check(
        name="lattice/conservation",
        title="Mass and momentum of lattice gases, in whole particles",
        equation="sum_i s_i, sum_i c_i s_i",
        criterion="no change by a single particle or unit of momentum",
        citation=FHP,
        judge=_judge,
        variants=full(*MODELS),
        faults=(
            (
                "fhp_saturated",
                Fault(
                    "momentum-y-forgotten",
                    "lattice/models.py",
                    "velocities.momentum(state), label",
                    "velocities.momentum(state)[0], label",
                    "collisions need not keep the momentum along y",
                ),
            ),
        ),
        needs=Needs(
            "lattice_gas",
            (LATTICE,),
            words=frozenset(
                {
                    "dimension=2",
                    "lattice_gas.obstacles",
                    "lattice_gas.obstacles.rows",
                    "lattice_gas.obstacles.rule=specular_y",
                    "lattice_gas.force",
                }
            ),
            observables=frozenset({"populations", "force_impulse"}),
        ),
    ),
)
