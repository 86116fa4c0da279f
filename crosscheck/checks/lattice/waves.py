"""Waves in lattice gases: how they are prepared, projected and fitted; what the checks of transport share."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from crosscheck.checks.base import Laboratory
from crosscheck.checks.lattice.gases import LATTICE, filled, gas_scene, populations
from crosscheck.engines.protocol import Kind
from crosscheck.figure import Figure, Series
from crosscheck.references.lattice_models import VELOCITIES, modes
from crosscheck.scene import Floats, Method, Output, Wave
from crosscheck.statistics import independent_mean
from crosscheck.verdict import Judgement, statistical

DENSITIES = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
#: Gases of one state, prepared and moved with different random numbers.
MEMBERS = 16
#: Velocity of shear waves at the start, links per step.
SHEAR = 0.1
BY_MEMBERS = f"standard error of {MEMBERS} gases"


class Signals(NamedTuple):
    """Amplitudes of the first mode along y.

    times: (samples,), steps. values: 2/N sum q exp(-i k y) of each gas, (members, samples), complex.
    """

    times: Floats
    values: Any


def wavenumber(model: str, rows: int) -> float:
    """k of one wavelength on so many rows, 1/links; model: name of the gas."""
    return 2 * math.pi / (rows * VELOCITIES[model].row_height)


def measure_mode(
    laboratory: Laboratory,
    name: str,
    density: float,
    waves: tuple[Wave, ...],
    quantity: Floats,
    *,
    rows: int,
    columns: int,
    steps: int,
    every: int,
    flow: float = 0.0,
    members: int = MEMBERS,
    method: Method | Kind = LATTICE,
) -> Signals:
    """Lets waves along y evolve, and projects sum_i quantity_i n_i of the rows on the first mode.

    laboratory: runs the gases. name: of the model. density: d. waves: at the start. quantity: (b,), one value a
    channel. rows, columns: of the lattice. steps: of the run, cut down to a multiple of `every`, the interval of
    samples. flow: velocity along y, links per step. members: number of gases.
    method: or a kind of scheme.
    """
    k = wavenumber(name, rows)
    phases = np.exp(-1j * k * np.arange(rows) * VELOCITIES[name].row_height)
    steps -= steps % every
    found = []
    for member in range(members):
        start = filled(density, laboratory.seed(f"{rows}/{member}"), waves=waves, velocity_y=flow)
        output = Output(interval=every, observables=("populations",), fields=(1, rows))
        scene = gas_scene("wave", name, rows, columns, steps, start, output)
        counts = populations(laboratory.run(scene, method))[:, 0]
        found.append(counts @ quantity @ phases * 2 / (rows * columns))
    return Signals(np.arange(0, steps + 1, every), np.array(found))


def amplitude_at_start(signals: Signals, asked: float, label: str) -> Judgement:
    """The amplitude that the waves start with, which fits of rates divide by, is that asked for.

    signals: of the gases. asked: sum_i quantity_i n_i a site of the wave. label: of the wave, in words.
    """
    value, error = independent_mean(signals.values[:, 0].real)
    return statistical(
        f"{label}: amplitude at the start, over that asked for",
        value / asked,
        error / asked,
        1.0,
        0.0,
        f"standard error of {len(signals.values)} gases, filled in local equilibrium",
        samples=len(signals.values),
    )


def mass(model: str) -> Floats:
    """1 for each channel of `model`, (b,)."""
    return np.ones(VELOCITIES[model].channels)


def transverse_momentum(model: str) -> Floats:
    """c_ix of each channel of `model`, (b,): momentum across a wave vector along y, links per step."""
    return VELOCITIES[model].cartesian[:, 0]


def decay_rate(times: Floats, signal: Any, guess: float) -> float:
    """alpha of a exp(-alpha t), by least squares; the first sample, still relaxing, is left out. NaN if none fits.

    times, signal: (samples,), of which the real part counts. guess: of alpha, where the search begins.
    """
    t, s = times[1:], signal.real[1:]
    return float(_fitted(lambda t, a, alpha: a * np.exp(-alpha * t), t, s, (s[0], guess))[1])


def _fitted(curve: Callable[..., Floats], times: Floats, signal: Floats, start: tuple[float, ...]) -> Floats:
    """Parameters of the curve nearest to the signal; NaN where the search finds none."""
    from scipy.optimize import OptimizeWarning, curve_fit

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", OptimizeWarning)  # of the covariance, which is not used
        try:
            found, _ = curve_fit(curve, times, signal, p0=start)
        except RuntimeError:
            return np.full(len(start), np.nan)
    return np.asarray(found)


def standing_wave(times: Floats, signal: Any, damping: float, frequency: float) -> tuple[float, float]:
    """alpha and omega of a exp(-alpha t) cos(omega t + phi), by least squares. NaN if none fits.

    times, signal: (samples,), of which the real part counts. damping, frequency: where the search begins.
    """

    def wave(t: Floats, a: float, alpha: float, omega: float, phi: float) -> Floats:
        return a * np.exp(-alpha * t) * np.cos(omega * t + phi)

    s = signal.real
    _, alpha, omega, _ = _fitted(wave, times, s, (s[0], damping, frequency, 0.0)).tolist()
    return alpha, omega


def shear_waves(laboratory: Laboratory, name: str, density: float, rows: int) -> Signals:
    """Momentum of shear waves as they decay, one wavelength on these rows, u0 = `SHEAR`.

    laboratory: runs the gases. name: of the model. density: d.
    """
    rate = modes(name, density, (0.0, wavenumber(name, rows))).shear_decay
    steps = int(min(1.5 / rate, 6000))
    return measure_mode(
        laboratory,
        name,
        density,
        (Wave(of="velocity_x", amplitude=SHEAR, mode=(0.0, 1.0)),),
        transverse_momentum(name),
        rows=rows,
        columns=131072 // rows,
        steps=steps,
        every=max(1, steps // 60),
    )


def viscosities(signals: Signals, name: str, density: float, rows: int) -> list[float]:
    """nu (links^2 per step) of each gas from the decay of its shear wave.

    signals: of `shear_waves` of this gas. name: of the model. density: d. rows: one wavelength.
    """
    k = wavenumber(name, rows)
    rate = modes(name, density, (0.0, k)).shear_decay
    return [decay_rate(signals.times, s, rate) / k**2 for s in signals.values]


def shear_wave_viscosities(laboratory: Laboratory, name: str, density: float, rows: int) -> list[float]:
    """nu (links^2 per step) of each gas from the decay of its shear wave, one wavelength on these rows, u0 = `SHEAR`.

    laboratory: runs the gases. name: of the model. density: d.
    """
    return viscosities(shear_waves(laboratory, name, density, rows), name, density, rows)


def density_figure(
    title: str,
    label: str,
    name: str,
    density: float,
    measured: list[float],
    theory: Callable[[float], float],
) -> Figure:
    """The mean of what was measured at one density, and the curve of the theory.

    title: of the figure. label: of the quantity. name: of the model. density: d. measured: of each gas. theory: the
    quantity as a function of d.
    """
    value, u = independent_mean(measured)
    axis = np.linspace(0.08, 0.62, 55)
    return Figure(
        title,
        "d",
        label,
        y_scale="log",
        series=(
            Series(name, [density], [value], error=[u]),
            Series(f"{name}: Boltzmann", axis.tolist(), [theory(d) for d in axis.tolist()], theory=True),
        ),
    )
