"""Decay of shear waves: the viscosity, beside Boltzmann's and that of the fluctuations at rest."""

from __future__ import annotations

from crosscheck.checks.base import Check, Laboratory
from crosscheck.checks.lattice.gases import FHP, ISOTROPIC, LATTICE, State, at_densities
from crosscheck.checks.lattice.green_kubo import against_green_kubo, equal_times, first_step, fluctuations
from crosscheck.checks.lattice.waves import (
    DENSITIES,
    SHEAR,
    amplitude_at_start,
    density_figure,
    shear_waves,
    viscosities,
    wavenumber,
)
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references import lattice_gas as known
from crosscheck.references.lattice_models import VELOCITIES, modes
from crosscheck.verdict import Judged, worst


def _judge(laboratory: Laboratory, state: State) -> Judged:
    """nu from the decay of a shear wave, beside Boltzmann's and Green-Kubo's; and the first step, which is exact."""
    name, density = state
    theory = known.shear_viscosity(name, density)
    rows = 256 if theory > 0.3 else 128
    k = wavenumber(name, rows)
    at_k = modes(name, density, (0.0, k)).shear_decay
    signals = shear_waves(laboratory, name, density, rows)
    measured = viscosities(signals, name, density, rows)
    c = VELOCITIES[name].cartesian
    stresses = [c[:, 0] * c[:, 1], (c[:, 0] ** 2 - c[:, 1] ** 2) / 2]
    rest = fluctuations(laboratory, name, density, stresses, rows)
    wave, note = against_green_kubo("nu", measured, (at_k / k**2, theory), rest, at_k)
    figure = density_figure(
        "Shear viscosity over density", "nu", name, density, measured, lambda d: known.shear_viscosity(name, d)
    )
    judgements = [
        amplitude_at_start(signals, VELOCITIES[name].channels * density * SHEAR, "shear wave"),
        equal_times(rest, "shear"),
        first_step(name, rest, "shear"),
        wave,
    ]
    return worst(judgements, f"{note}; {rows} rows, u0 = {SHEAR:g}", (figure,))


CHECKS = (
    Check(
        name="lattice/shear-viscosity",
        title="Decay of shear waves: viscosity beside Boltzmann's and Green-Kubo's",
        equation="u_x(y, t) = u_0 sin(k y) exp(-nu k^2 t), nu = (1/lambda - 1/2)/4",
        criterion="first step of the stress exactly 1 - lambda; nu that of the fluctuations at rest",
        citation=FHP
        + "; Henon, Complex Systems 1, 762 (1987); Kadanoff, McNamara & Zanetti, Phys. Rev. A 40, 4527 (1989)",
        judge=_judge,
        variants=at_densities(ISOTROPIC, DENSITIES),
        faults=(
            (
                "fhp_saturated-d0.5",
                Fault(
                    "cold-head-on",
                    "lattice/models.py",
                    "            outcomes[state] = cycle if identity",
                    "            outcomes[state] = (state,) if state in (9, 18, 36) else cycle if identity",
                    "head-on pairs of six bits pass through each other",
                ),
            ),
        ),
        needs=Needs("lattice_gas", (LATTICE,), observables=frozenset({"populations"})),
    ),
)
