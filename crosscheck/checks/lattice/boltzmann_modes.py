"""Small waves in the lattice Boltzmann equation: viscosities and sound speed as k goes to 0."""

from __future__ import annotations

import math
from typing import Any

from crosscheck.checks.base import Check, Laboratory
from crosscheck.checks.lattice.gases import FHP, LATTICE, State, at_densities, boltzmann_method
from crosscheck.checks.lattice.waves import (
    mass,
    measure_mode,
    standing_wave,
    transverse_momentum,
    wavenumber,
)
from crosscheck.convergence import extrapolate
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references import lattice_gas as known
from crosscheck.references.lattice_models import MODELS, modes
from crosscheck.scene import Wave
from crosscheck.verdict import Judged, Judgement, bounded, worst

AMPLITUDE = 1e-6


def _judge(laboratory: Laboratory, state: State) -> Judged:
    """Decay of small waves in the nonlinear iteration: k^2 nu, c_s k and k^2 (nu + zeta/rho)/2, as k goes to 0."""
    name, density = state
    # waves long beside the mean free path, which is that of slow relaxation
    scale = 1 if known.relaxation_rate(name, density) > 0.6 else 4
    sizes = tuple(scale * rows for rows in (32, 64, 128))
    c_s, gamma = known.SOUND_SPEED[name], known.longitudinal_viscosity(name, density)
    method = boltzmann_method(laboratory)
    shear, sound, damping = [], [], []
    for rows in sizes:
        k = wavenumber(name, rows)
        guess = modes(name, density, (0.0, k))
        # the slowest mode that is not hydrodynamic has fallen to rounding
        settled = 8 + int(math.log(1e-8) / math.log(max(guess.kinetic, 1e-6)))
        common: dict[str, Any] = {"rows": rows, "columns": 2, "members": 1, "every": 1, "method": method}
        if name != "hpp":
            waves = (Wave(of="velocity_x", amplitude=AMPLITUDE, mode=(0.0, 1.0)),)
            signals = measure_mode(
                laboratory, name, density, waves, transverse_momentum(name), steps=settled + 100, **common
            )
            s = signals.values[0].real
            rate = -math.log(s[-1] / s[settled]) / 100
            shear.append(rate / (k**2 * known.shear_viscosity(name, density)) - 1)
        waves = (Wave(of="density", amplitude=AMPLITUDE, mode=(0.0, 1.0)),)
        steps = settled + int(1.5 * 2 * math.pi / guess.sound_frequency)
        signals = measure_mode(laboratory, name, density, waves, mass(name), steps=steps, **common)
        alpha, omega = standing_wave(
            signals.times[settled:], signals.values[0][settled:], guess.sound_damping, guess.sound_frequency
        )
        sound.append(omega / (c_s * k) - 1)
        damping.append(2 * alpha / (gamma * k**2) - 1)
    judgements = []
    for label, errors in (("nu", shear), ("c_s", sound), ("nu + zeta/rho", damping)):
        if errors:
            judgements.append(_vanishes(label, [wavenumber(name, rows) for rows in sizes], errors))
    return worst(judgements, f"{', '.join(map(str, sizes))} rows")


def _vanishes(label: str, wavenumbers: list[float], errors: list[float]) -> Judgement:
    """Relative deviations at three wave numbers, extrapolated over k^2 to k = 0."""
    limit = extrapolate(wavenumbers, errors)
    return bounded(
        f"{label} as k -> 0, relative deviation",
        abs(float(limit.value)),
        max(limit.error, AMPLITUDE),
        "what the extrapolation over k^2 changes when the coarsest lattice is left out; at least the amplitude, 1e-6",
    )


CHECKS = (
    Check(
        name="lattice/boltzmann-modes",
        title="Small waves in the lattice Boltzmann equation: viscosities and sound speed as k goes to 0",
        equation="nu = (1/lambda - 1/2)/4, c_s, zeta/rho",
        criterion="relative deviation zero after extrapolation over k^2",
        citation=FHP,
        judge=_judge,
        variants=at_densities(MODELS, (0.2, 0.5)),
        faults=(
            (
                "fhp2-d0.2",
                Fault(
                    "no-spectators",
                    "lattice/models.py",
                    "velocities.mass(state) - resting <= 3:",
                    "velocities.mass(state) - resting <= 3 - 2 * resting:",
                    "in FHP-II head-on pairs and triples do not collide beside a resting particle",
                ),
            ),
        ),
        needs=Needs("lattice_gas", (LATTICE,), observables=frozenset({"populations", "h_function"})),
    ),
)
