"""Momentum flux of a uniform flow: isotropic for FHP gases, not for HPP."""

from __future__ import annotations

import math

import numpy as np

from crosscheck.checks.base import Check, Laboratory
from crosscheck.checks.lattice.gases import (
    LATTICE,
    ONE_OUTCOME,
    State,
    at_densities,
    filled,
    gas_scene,
    populations,
    started,
)
from crosscheck.engines.capabilities import Needs
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.references.lattice_models import MODELS, VELOCITIES, fermi_dirac, momentum_flux
from crosscheck.scene import Floats, Output
from crosscheck.statistics import correlated_mean
from crosscheck.verdict import Findings, Judged, Judgement, round_off, statistical, worst

SIZE, SAMPLES, SPEED = 1024, 120, 0.2
#: Steps between samples: the stress forgets itself within some five.
EVERY = 25


def _flow(laboratory: Laboratory, state: State, angle: float) -> tuple[Floats, Floats, Findings]:
    """(P_xx - P_yy, P_xy) over rho u^2 of a flow at this angle, measured (2, samples) and at equilibrium (2,).

    Also: whether the gas has at the start the rho and u that both are divided by.
    """
    name, density = state
    u = (SPEED * math.cos(angle), SPEED * math.sin(angle))
    start = filled(density, laboratory.seed(f"{angle:.3f}"), velocity_x=u[0], velocity_y=u[1])
    output = Output(interval=EVERY, observables=("populations",))
    scene = gas_scene("flow", name, SIZE, SIZE, EVERY * SAMPLES, start, output)
    counts = populations(laboratory.run(scene, LATTICE))[:, 0, 0] / SIZE**2
    rho = float(counts[0].sum())
    velocity = counts[0] @ VELOCITIES[name].cartesian / rho
    flux = momentum_flux(name, counts)
    exact = momentum_flux(name, fermi_dirac(name, rho / VELOCITIES[name].channels, velocity))
    scale = rho * SPEED**2
    measured, expected = (
        np.stack([(p[..., 0, 0] - p[..., 1, 1]) / scale, p[..., 0, 1] / scale]) for p in (flux, exact)
    )
    return measured, expected, started(counts[0], fermi_dirac(name, density, u), name, SIZE**2)


def _against(label: str, values: Floats, expected: float) -> Judgement:
    mean = correlated_mean(values)
    return statistical(
        label,
        mean.value,
        mean.error,
        expected,
        0.0,
        f"standard error of {len(values)} correlated samples; off by 1/N of fixed momentum over u^2",
        samples=mean,
        doubt=1.0 / (SIZE * SPEED) ** 2,
    )


def _judge(laboratory: Laboratory, state: State) -> Judged:
    """The anisotropic part of the momentum flux over rho u^2, in several directions.

    A flow at the angle a has P_xx - P_yy = rho g u^2 cos 2a and P_xy = rho g u^2 sin(2a)/2 if the tensor is isotropic;
    of HPP P_xy = 0, and g_HPP = 2 G(rho) = 2 (2 - rho)/(4 - rho).
    """
    angles = np.radians([0.0, 15.0, 30.0, 45.0])
    judgements: list[Judged] = []
    differences, theory = [], []
    for angle in angles.tolist():
        (normal, shear), expected, start = _flow(laboratory, state, angle)
        direction = f"at {math.degrees(angle):.0f} deg"
        differences.append(_against(f"P_xx - P_yy {direction}, over rho u^2", normal, float(expected[0])))
        theory.append(float(expected[0]))
        judgements += [start, differences[-1]]
        if state.model == "hpp":
            judgements.append(round_off(f"P_xy of HPP {direction}", float(np.abs(shear).max()), EPSILON, "c_x c_y = 0"))
        else:
            judgements.append(_against(f"P_xy {direction}, over rho u^2", shear, float(expected[1])))
    figure = Figure(
        f"Anisotropic part of the momentum flux, d = {state.density:g}",
        "direction of the flow (degrees)",
        "(P_xx - P_yy)/(rho u^2)",
        series=(
            Series(
                state.model,
                np.degrees(angles).tolist(),
                [one.measured or 0.0 for one in differences],
                error=[one.uncertainty or 0.0 for one in differences],
            ),
            Series(f"{state.model}: equilibrium", np.degrees(angles).tolist(), theory, theory=True),
        ),
    )
    return worst(judgements, f"u = {SPEED:g}, {SIZE} x {SIZE} sites", (figure,))


CHECKS = (
    Check(
        name="lattice/pressure-tensor",
        title="Momentum flux of a uniform flow: isotropic for FHP, not for HPP",
        equation="P_ab = c^2/2 rho delta_ab + rho G(rho) T_abcd u_c u_d",
        criterion="within the standard error of the exact equilibrium",
        citation="Frisch et al., Complex Systems 1, 649 (1987), sec. 5; Wolfram, J. Stat. Phys. 45, 471 (1986)",
        judge=_judge,
        variants=at_densities(MODELS, (0.2,)),
        faults=(("fhp_saturated-d0.2", ONE_OUTCOME),),
        needs=Needs("lattice_gas", (LATTICE,), observables=frozenset({"populations"})),
    ),
)
