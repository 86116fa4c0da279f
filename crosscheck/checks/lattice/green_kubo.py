"""Transport coefficients from the fluctuations of gases at rest (Green-Kubo), beside those of waves.

The Boltzmann theory takes the particles that meet for independent. In two dimensions they are not: the stress
correlations of the gas decay slowly (long-time tails), and viscosities exceed Boltzmann's by up to a factor of two at
low density. The fluctuations of the stress at rest measure that without a wave; their first step is exact.

Literature: L. P. Kadanoff, G. R. McNamara and G. Zanetti, Phys. Rev. A 40, 4527 (1989).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Laboratory
from crosscheck.checks.lattice.gases import LATTICE, filled, gas_scene, populations
from crosscheck.checks.lattice.waves import BY_MEMBERS, MEMBERS
from crosscheck.references import lattice_gas as known
from crosscheck.references.lattice_models import VELOCITIES
from crosscheck.scene import Floats, Output
from crosscheck.statistics import independent_mean
from crosscheck.verdict import Judgement, statistical

#: Steps over which the stress is correlated.
LAGS = 256


class Fluctuations(NamedTuple):
    """Autocorrelation C(t) of sum_i w_i n_i in gases at rest, over the exact C(0).

    density: d, the mean of these gases. first: C(0) and C(1) about the mean of the ensemble, zero, (gases, 2).
    correlation: C by lag about the mean of each gas, (gases, lags): what a gas conserves would never decay otherwise.
    ratio: C(0) over the variance of the momentum.
    """

    density: float
    first: Floats
    correlation: Floats
    ratio: float

    def diffusivity(self, frequency: float) -> Floats:
        """Transport coefficient (sum_0^t C cos(omega t) - C(0)/2)/chi of each gas by the last lag t, (gases, lags).

        frequency: omega, per step.
        """
        waves = np.cos(frequency * np.arange(LAGS))
        return self.ratio * (np.cumsum(self.correlation * waves, axis=1) - 0.5)


def fluctuations(laboratory: Laboratory, name: str, density: float, weights: list[Floats], size: int) -> Fluctuations:
    """Runs `MEMBERS` gases at rest, size x size sites, and correlates the equivalent moments `weights`, each (b,).

    laboratory: runs them on the engine under judgement. name: of the model. density: d.
    """
    velocities, steps, sites = VELOCITIES[name], 12_500, size * size
    output = Output(interval=1, observables=("populations",))
    c_y = velocities.cartesian[:, 1]
    densities, first, sums = [], np.zeros((MEMBERS, 2)), np.zeros((MEMBERS, LAGS))
    for member in range(MEMBERS):
        start = filled(density, laboratory.seed(f"rest/{size}/{member}"))
        scene = gas_scene("rest", name, size, size, steps, start, output)
        counts = populations(laboratory.run(scene, LATTICE))[:, 0, 0]
        d = float(counts[0].sum()) / (sites * velocities.channels)
        densities.append(d)
        for w in weights:
            series = counts @ w
            scale = sites * d * (1 - d) * float(w @ w) * len(weights)
            first[member] += (series @ series / len(series) / scale, series[1:] @ series[:-1] / (steps * scale))
            spectrum = np.abs(np.fft.rfft(series - series.mean(), 2 * len(series))) ** 2
            sums[member] += np.fft.irfft(spectrum)[:LAGS] / (len(series) - np.arange(LAGS)) / scale
    ratio = float(weights[0] @ weights[0]) / float(c_y @ c_y)
    return Fluctuations(float(np.mean(densities)), first, sums, ratio)


def equal_times(found: Fluctuations, label: str) -> Judgement:
    """C(0) is that of independent channels, by which all of C is divided.

    found: measured in gases at rest. label: of the moment, in words.
    """
    value, u = independent_mean(found.first[:, 0])
    return statistical(
        f"{label}: C(0) of the stress over that of independent channels",
        value,
        u,
        1.0,
        0.0,
        f"{BY_MEMBERS}; exact in equilibrium",
        samples=MEMBERS,
        needed=0.1,
    )


def first_step(name: str, found: Fluctuations, label: str) -> Judgement:
    """C(1)/C(0) = 1 - lambda, exactly: before the first collision the channels of a gas at rest are independent.

    name: of the model. found: measured in gases at rest, of a moment that relaxes with the rate of the shear stress.
    label: of the moment, in words.
    """
    # C(1) - slope (C(0) - 1): a slope near C(1) removes the scatter of C(0); any slope leaves the mean as it is
    slope = 1 - known.relaxation_rate(name, found.density)
    difference, u = independent_mean(found.first[:, 1] - slope * found.first[:, 0])
    return statistical(
        f"{label}: C(1)/C(0) of the stress",
        slope + difference,
        u,
        slope,
        0.0,
        f"{BY_MEMBERS}; 1 - lambda is exact for independent channels",
        samples=MEMBERS,
    )


def against_green_kubo(
    label: str,
    measured: list[float],
    boltzmann: tuple[float, float],
    found: Fluctuations,
    rate: float,
    frequency: float = 0.0,
    loud: float = 0.0,
) -> tuple[Judgement, str]:
    """A transport coefficient measured by a wave against that of the fluctuations; and a note with Boltzmann's values.

    label: of the coefficient. measured: of each gas, links^2 per step. boltzmann: the coefficient by the Boltzmann
    equation, of waves of this k, and of gases at rest at this frequency. found: the fluctuations of gases at rest.
    rate: of the wave's decay, per step; two modes of its lattice decay at least at half of it, so the stress is
    correlated over 2/rate steps at most. Where noise outweighs the tail, the sum ends earlier. frequency: of the wave,
    per step. loud: what its amplitude adds to the coefficient, by the Boltzmann equation.
    """
    cumulated = found.diffusivity(frequency)

    def to(lag: int) -> tuple[float, float, float]:
        value, error = independent_mean(cumulated[:, lag])
        return value, error, abs(value - float(cumulated[:, lag // 4].mean()))

    longest = min(LAGS - 1, max(32.0, 2 / rate))
    until = min([lag for lag in (32, 64, 128, LAGS - 1) if lag <= longest], key=lambda lag: math.hypot(*to(lag)[1:]))
    green_kubo, error, tail = to(until)
    value, u = independent_mean(measured)
    # a wave of this length is damped by so much more than one without end of the same frequency
    finite = boltzmann[0] - boltzmann[1]
    # what the amplitude adds depends on the coefficient itself, of which Boltzmann's equation is off by this share
    off = abs(green_kubo / boltzmann[1] - 1)
    judgement = statistical(
        label,
        value,
        u,
        green_kubo + finite + loud,
        error,
        f"{BY_MEMBERS}; Green-Kubo to lag {until}, off by what its last two doublings add (where a wave cuts the "
        "long-time tail off is known to a factor only), by the correction for the wavelength, and by the share of that "
        "for the amplitude by which Boltzmann's equation is off",
        samples=MEMBERS,
        doubt=tail + abs(finite) + off * abs(loud),
    )
    note = (
        f"Boltzmann at this k {boltzmann[0]:.4g} (without end {boltzmann[1]:.4g}, of this amplitude "
        f"{boltzmann[0] + loud:.4g}), "
        f"Green-Kubo alone {green_kubo:.4g}({error:.2g})"
    )
    return judgement, note
