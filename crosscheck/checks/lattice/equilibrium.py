"""A moving gas relaxes to the Fermi-Dirac distribution."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import Check, Laboratory
from crosscheck.checks.lattice.gases import (
    FHP,
    LATTICE,
    NO_COLLISIONS,
    ONE_OUTCOME,
    State,
    at_densities,
    away,
    filled_channels,
    gas_scene,
    populations,
    started,
)
from crosscheck.engines.capabilities import Needs
from crosscheck.figure import Figure, Series
from crosscheck.references.lattice_models import MODELS, VELOCITIES, fermi_dirac, low_speed_equilibrium
from crosscheck.scene import Output
from crosscheck.statistics import correlated_mean
from crosscheck.verdict import Judged, bounded, statistical, worst


def _judge(laboratory: Laboratory, state: State) -> Judged:
    """Populations of a gas that starts away from equilibrium, against Fermi-Dirac at the same mass and momentum."""
    name, density = state
    velocities = VELOCITIES[name]
    size, stretches = 128, 192
    # the same mass and momentum, but another distribution: halfway to that with the fewest channels filled
    asked = away(name, fermi_dirac(name, density, (0.2, 0.1)))
    start = filled_channels(asked, laboratory.seed())
    scene = gas_scene(
        "relaxation", name, size, size, 200 + 50 * stretches, start, Output(interval=50, observables=("populations",))
    )
    counts = populations(laboratory.run(scene, LATTICE))[:, 0, 0] / size**2
    settled = counts[4:]
    rho = float(settled[0].sum())
    velocity = settled[0] @ velocities.cartesian / rho
    # for the exact mass and momentum of this gas: the expected value has no error
    expected = fermi_dirac(name, rho / velocities.channels, velocity)
    judgements = []
    for i in range(velocities.channels):
        mean = correlated_mean(settled[:, i])
        judgements.append(
            statistical(
                f"f_{i}",
                mean.value,
                mean.error,
                float(expected[i]),
                0.0,
                f"standard error of {len(settled)} correlated samples; off by 1/N of fixed mass and momentum",
                samples=mean,
                doubt=1.0 / size**2,
                needed=0.02,
            )
        )
    errors = [judgement.uncertainty or 0.0 for judgement in judgements]
    departure = np.abs(counts[0] - expected).max()
    judgements.append(
        bounded(
            "departure at the start, over the largest error",
            float(departure / max(1e-12, *errors)),
            20.0,
            "else the gas had nothing to relax",
            at_least=True,
            control=True,
        )
    )
    axis = [float(i) for i in range(velocities.channels)]
    figure = Figure(
        f"Equilibrium populations at u = (0.2, 0.1), d = {density:g}",
        "channel",
        "mean occupation",
        series=(
            Series(name, axis, settled.mean(axis=0).tolist(), error=errors),
            Series(f"{name}: Fermi-Dirac", axis, expected.tolist(), theory=True),
        ),
    )
    expansion = low_speed_equilibrium(name, rho / velocities.channels, velocity)
    judged: list[Judged] = [*judgements, started(counts[0], asked, name, size**2)]
    return worst(judged, f"the expansion to u^2 is off by {np.abs(expansion - expected).max():.2g}", (figure,))


CHECKS = (
    Check(
        name="lattice/equilibrium",
        title="A moving gas relaxes to the Fermi-Dirac distribution",
        equation="f_i = 1/(1 + exp(h + q.c_i))",
        criterion="every channel within its standard error",
        citation="Hardy, Pomeau & de Pazzis, J. Math. Phys. 14, 1746 (1973); " + FHP,
        judge=_judge,
        variants=at_densities(MODELS, (0.2, 0.4)),
        faults=(("fhp_saturated-d0.2", ONE_OUTCOME), ("hpp-d0.2", NO_COLLISIONS)),
        needs=Needs("lattice_gas", (LATTICE,), observables=frozenset({"populations"})),
    ),
)
