"""Lattice gases: sound, viscosity, advection and channel flow against the Boltzmann theory and what lies beyond it.

The theory takes the particles that meet for independent. In two dimensions they are not: the stress of the gas forgets
slowly (long-time tails), and viscosities exceed Boltzmann's by up to a factor of two at low density. What the gas says
of that without a wave are the fluctuations of its stress at rest (Green-Kubo); their first step is exact.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from crosscheck.checks.base import Laboratory, reference_check
from crosscheck.checks.lattice.states import (
    BOLTZMANN,
    FHP,
    ISOTROPIC,
    NAMES,
    NO_COLLISIONS,
    PLANES,
    at_densities,
    filled,
    gas_scene,
    named_density,
    populations,
)
from crosscheck.convergence import extrapolate
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import lattice_gas as known
from crosscheck.scene import Floats, Method, Obstacle, Output, Wave
from crosscheck.statistics import independent_mean
from crosscheck.verdict import Judged, Judgement, bounded, statistical, worst
from refimpl.lattice.models import MODELS, Model
from refimpl.lattice.theory import modes, relaxation_rate

DENSITIES = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
#: Gases of one state, prepared and moved with different random numbers.
MEMBERS = 16
_BY_MEMBERS = f"standard error of {MEMBERS} gases"


class Signals(NamedTuple):
    """Amplitudes of the first mode along y, (members, samples): 2/N sum q exp(-i k y). times (samples,)."""

    times: Floats
    values: Any


def wavenumber(model: Model, rows: int) -> float:
    return 2 * math.pi / (rows * model.velocities.row_height)


def measure_mode(
    laboratory: Laboratory,
    name: str,
    density: float,
    waves: tuple[Wave, ...],
    quantity: Callable[[Model], Floats],
    *,
    rows: int,
    columns: int,
    steps: int,
    every: int,
    flow: float = 0.0,
    members: int = MEMBERS,
    method: Method = PLANES,
) -> Signals:
    """Lets waves along y evolve, and projects sum_i quantity_i n_i of the rows on the first mode."""
    model = MODELS[name]
    k = wavenumber(model, rows)
    phases = np.exp(-1j * k * np.arange(rows) * model.velocities.row_height)
    steps -= steps % every
    found = []
    for member in range(members):
        start = filled(density, laboratory.seed(f"{rows}/{member}"), waves=waves, velocity_y=flow)
        output = Output(interval=every, observables=("populations",), fields=(1, rows))
        scene = gas_scene("wave", name, rows, columns, steps, start, output)
        counts = populations(laboratory.run(scene, method))[:, 0]
        found.append(counts @ quantity(model) @ phases * 2 / (rows * columns))
    return Signals(np.arange(0, steps + 1, every), np.array(found))


def _mass(model: Model) -> Floats:
    return np.ones(model.channels)


def _across(model: Model) -> Floats:
    """Momentum across the wave vector."""
    return model.velocities.cartesian[:, 0]


def decay_rate(times: Floats, signal: Any, guess: float) -> float:
    """alpha of a exp(-alpha t), by least squares; the first sample, still relaxing, is left out. NaN if none fits."""
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
    """alpha and omega of a exp(-alpha t) cos(omega t + phi), by least squares from these guesses. NaN if none fits."""

    def wave(t: Floats, a: float, alpha: float, omega: float, phi: float) -> Floats:
        return a * np.exp(-alpha * t) * np.cos(omega * t + phi)

    s = signal.real
    _, alpha, omega, _ = _fitted(wave, times, s, (s[0], damping, frequency, 0.0)).tolist()
    return alpha, omega


# -- Green-Kubo ------------------------------------------------------------------------------------------


class Fluctuations(NamedTuple):
    """Of sum_i w_i n_i in gases at rest, C(t) over C(0), which is exact. density: the mean of these very gases.

    first: C(0) and C(1), (gases, 2), about the mean of the ensemble, zero. correlation: C by lag, (gases, lags), about
    the mean of each gas, for what one gas conserves never decays. ratio: C(0) over the variance of the momentum.
    """

    density: float
    first: Floats
    correlation: Floats
    ratio: float

    def diffusivity(self, frequency: float) -> Floats:
        """The transport coefficient (sum_0^t C cos(omega t) - C(0)/2)/chi by the last lag, (gases, lags)."""
        waves = np.cos(frequency * np.arange(LAGS))
        return self.ratio * (np.cumsum(self.correlation * waves, axis=1) - 0.5)


LAGS = 256


def fluctuations(laboratory: Laboratory, name: str, density: float, weights: list[Floats], size: int) -> Fluctuations:
    """Runs gases at rest, size x size sites, and correlates the equivalent moments `weights`."""
    model, steps, sites = MODELS[name], 12_500, size * size
    output = Output(interval=1, observables=("populations",))
    c_y = model.velocities.cartesian[:, 1]
    densities, first, sums = [], np.zeros((MEMBERS, 2)), np.zeros((MEMBERS, LAGS))
    for member in range(MEMBERS):
        start = filled(density, laboratory.seed(f"rest/{size}/{member}"))
        counts = populations(laboratory.run(gas_scene("rest", name, size, size, steps, start, output), PLANES))[:, 0, 0]
        d = float(counts[0].sum()) / (sites * model.channels)
        densities.append(d)
        for w in weights:
            series = counts @ w
            scale = sites * d * (1 - d) * float(w @ w) * len(weights)
            first[member] += (series @ series / len(series) / scale, series[1:] @ series[:-1] / (steps * scale))
            spectrum = np.abs(np.fft.rfft(series - series.mean(), 2 * len(series))) ** 2
            sums[member] += np.fft.irfft(spectrum)[:LAGS] / (len(series) - np.arange(LAGS)) / scale
    ratio = float(weights[0] @ weights[0]) / float(c_y @ c_y)
    return Fluctuations(float(np.mean(densities)), first, sums, ratio)


def _first_step(model: Model, found: Fluctuations, weights: Floats, label: str) -> Judgement:
    """C(1)/C(0) = 1 - lambda, exactly: before the first collision the channels of a gas at rest are independent."""
    slope = 1 - relaxation_rate(model, found.density, weights)
    # C(1) - slope C(0): the scatter of C(0) itself drops out
    difference, u = independent_mean(found.first[:, 1] - slope * found.first[:, 0])
    return statistical(
        f"{label}: C(1)/C(0) of the stress",
        slope + difference,
        u,
        slope,
        0.0,
        f"{_BY_MEMBERS}; 1 - lambda is exact for independent channels",
        samples=MEMBERS,
    )


def _against_green_kubo(
    label: str,
    measured: list[float],
    boltzmann: tuple[float, float],
    found: Fluctuations,
    rate: float,
    frequency: float = 0.0,
) -> tuple[Judgement, str]:
    """A coefficient measured by a wave against that of the fluctuations, of its frequency; and a note of all values.

    boltzmann: at this k and at k = 0. rate: of the wave's decay; two modes of its lattice decay at least at half of
    it, so the stress remembers no longer than 2/rate. Where noise has the better of the tail, the sum ends earlier.
    """
    cumulated = found.diffusivity(frequency)

    def to(lag: int) -> tuple[float, float, float]:
        value, error = independent_mean(cumulated[:, lag])
        return value, error, abs(value - float(cumulated[:, lag // 4].mean()))

    longest = min(LAGS - 1, max(32.0, 2 / rate))
    until = min([lag for lag in (32, 64, 128, LAGS - 1) if lag <= longest], key=lambda lag: math.hypot(*to(lag)[1:]))
    green_kubo, error, tail = to(until)
    value, u = independent_mean(measured)
    # a wave as long as this is damped differently by so much; of sound, part of it is that of the frequency
    finite = boltzmann[0] - boltzmann[1]
    judgement = statistical(
        label,
        value,
        u,
        green_kubo + finite,
        math.hypot(error, tail, finite),
        f"{_BY_MEMBERS}; Green-Kubo to lag {until}, uncertain by what its last two doublings add (where a wave cuts "
        "the long-time tail off is known to a factor only) and by the correction for the wavelength",
        samples=MEMBERS,
    )
    note = (
        f"Boltzmann {boltzmann[1]:.4g} (at this k {boltzmann[0]:.4g}), measured {value:.4g}({u:.2g}), "
        f"Green-Kubo {green_kubo:.4g}({error:.2g})"
    )
    return judgement, note


# -- shear -----------------------------------------------------------------------------------------------


def shear_wave_viscosities(laboratory: Laboratory, name: str, density: float, rows: int) -> list[float]:
    """nu of each gas from the decay of its shear wave, one wavelength on these rows, u0 = 0.1."""
    model = MODELS[name]
    k = wavenumber(model, rows)
    rate = modes(model, density, (0.0, k)).shear_decay
    steps = int(min(1.5 / rate, 6000))
    signals = measure_mode(
        laboratory,
        name,
        density,
        (Wave(of="velocity_x", amplitude=0.1, mode=(0.0, 1.0)),),
        _across,
        rows=rows,
        columns=131072 // rows,
        steps=steps,
        every=max(1, steps // 60),
    )
    return [decay_rate(signals.times, s, rate) / k**2 for s in signals.values]


def _judge_shear(laboratory: Laboratory, variant: str) -> Judged:
    """nu from the decay of a shear wave, beside Boltzmann's and Green-Kubo's; and the first step, which is exact."""
    name, density = named_density(variant)
    model = MODELS[name]
    theory = known.shear_viscosity(name, density)
    rows = 256 if theory > 0.3 else 128
    k = wavenumber(model, rows)
    at_k = modes(model, density, (0.0, k)).shear_decay
    measured = shear_wave_viscosities(laboratory, name, density, rows)
    c = model.velocities.cartesian
    stresses = [c[:, 0] * c[:, 1], (c[:, 0] ** 2 - c[:, 1] ** 2) / 2]
    rest = fluctuations(laboratory, name, density, stresses, rows)
    wave, note = _against_green_kubo("nu", measured, (at_k / k**2, theory), rest, at_k)
    figure = _density_figure(
        "Shear viscosity over density", "nu", name, density, measured, lambda d: known.shear_viscosity(name, d)
    )
    return worst([_first_step(model, rest, stresses[0], "shear"), wave], f"{note}; {rows} rows, u0 = 0.1", (figure,))


def _density_figure(
    title: str,
    label: str,
    name: str,
    density: float,
    measured: list[float],
    theory: Callable[[float], float],
) -> Figure:
    """The point of this verdict, the mean of what was measured, and the curve of the theory."""
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


# -- sound -----------------------------------------------------------------------------------------------


def _sound(
    laboratory: Laboratory, name: str, density: float, amplitude: float, rows: int, columns: int, steps: int
) -> Any:
    """Damping and frequency of standing waves, (members, 2), and the theory's at this k. amplitude: over d."""
    model = MODELS[name]
    k = wavenumber(model, rows)
    theory = modes(model, density, (0.0, k))
    waves = (Wave(of="density", amplitude=amplitude * density, mode=(0.0, 1.0)),)
    every = max(1, int(2 * math.pi / theory.sound_frequency) // 16)
    signals = measure_mode(
        laboratory, name, density, waves, _mass, rows=rows, columns=columns, steps=steps, every=every
    )
    fits = [standing_wave(signals.times, s, theory.sound_damping, theory.sound_frequency) for s in signals.values]
    return k, theory, np.array(fits), signals


def _judge_sound_speed(laboratory: Laboratory, variant: str) -> Judged:
    """omega/k of a standing wave on 512 rows against theory; the deviation on 256 rows tells that of order k^2."""
    name, density = named_density(variant)
    deviations, speeds = [], []
    for rows in (256, 512):
        k, theory, fits, _ = _sound(laboratory, name, density, 0.05, rows, 1024, 6 * rows)
        value, u = independent_mean(fits[:, 1] / k)
        speeds.append((value, u, theory.sound_frequency / k))
        deviations.append(value - theory.sound_frequency / k)
    value, u, expected = speeds[1]
    # halving k leaves a quarter of a deviation of order k^2. HPP keeps the momentum of each row, its sound is that of
    # one dimension, where frequencies deviate by k^(3/2): 2^(-1/2) is left
    remains = 0.25 if name != "hpp" else math.sqrt(0.5)
    left = abs(deviations[0] - deviations[1]) * remains / (1 - remains)
    figures = (
        Figure(
            "Sound speed over density",
            "d",
            "c",
            series=(
                Series(name, [density], [value], error=[u]),
                Series(f"{name}: c_s", [0.08, 0.62], [known.SOUND_SPEED[name]] * 2, theory=True),
            ),
        ),
    )
    return statistical(
        "c = omega/k",
        value,
        u,
        expected,
        left,
        f"{_BY_MEMBERS}; Boltzmann at this k, uncertain by what the change from 256 to 512 rows says is left",
        samples=MEMBERS,
        needed=None if name == "hpp" else 0.02,
        note=f"c_s {known.SOUND_SPEED[name]:.5f}, with the viscous correction {expected:.5f}; "
        f"256 rows: {speeds[0][0]:.5f}({speeds[0][1]:.1g})",
        figures=figures,
    )


def _judge_attenuation(laboratory: Laboratory, variant: str) -> Judged:
    """2 alpha/k^2 = nu + zeta/rho of a standing wave, beside Boltzmann's and Green-Kubo's; the first step is exact."""
    name, density = named_density(variant)
    model = MODELS[name]
    rows = 128
    k = wavenumber(model, rows)
    at_k = modes(model, density, (0.0, k)).sound_damping
    steps = int(min(1.2 / at_k, 4000))
    _, _, fits, signals = _sound(laboratory, name, density, 0.1, rows, 1024, steps)
    measured = (2 * fits[:, 0] / k**2).tolist()
    c = model.velocities.cartesian
    weights = c[:, 1] ** 2 - known.SOUND_SPEED[name] ** 2
    rest = fluctuations(laboratory, name, density, [weights], rows)
    theory = longitudinal(name, density)
    omega = float(fits[:, 1].mean())
    wave, note = _against_green_kubo("nu + zeta/rho", measured, (2 * at_k / k**2, theory), rest, 2 * at_k, omega)
    judgements = [wave]
    if not model.velocities.rest:  # with a rest particle two rates mix in this moment
        judgements.append(_first_step(model, rest, weights, "sound"))
    figures = [
        _density_figure(
            "Sound attenuation over density",
            "2 alpha/k^2",
            name,
            density,
            measured,
            lambda d: longitudinal(name, d),
        )
    ]
    if density == 0.5:
        mean = signals.values.real.mean(axis=0) / signals.values.real[:, 0].mean()
        figures.append(
            Figure(
                f"Standing sound wave, {rows} rows, d = 0.5",
                "step",
                "amplitude",
                series=(Series(name, signals.times.tolist(), mean.tolist()),),
            )
        )
    return worst(judgements, note, tuple(figures))


def longitudinal(name: str, density: float) -> float:
    """nu + zeta/rho of Boltzmann; of HPP along an axis, (1/lambda - 1/2)/2."""
    if name == "hpp":
        return (1 / known.relaxation_rate(name, density) - 0.5) / 2
    return known.shear_viscosity(name, density) + known.bulk_viscosity(name, density)


# -- Boltzmann iteration ---------------------------------------------------------------------------------


def _judge_boltzmann(laboratory: Laboratory, variant: str) -> Judged:
    """Decay of small waves in the nonlinear iteration: k^2 nu, c_s k and k^2 (nu + zeta/rho)/2, as k goes to 0."""
    name, density = named_density(variant)
    model = MODELS[name]
    # waves long beside the mean free path, which is that of slow relaxation
    scale = 1 if known.relaxation_rate(name, density) > 0.6 else 4
    sizes = tuple(scale * rows for rows in (32, 64, 128))
    c_s, gamma = known.SOUND_SPEED[name], longitudinal(name, density)
    shear, sound, damping = [], [], []
    for rows in sizes:
        k = wavenumber(model, rows)
        theory = modes(model, density, (0.0, k))
        # the slowest mode that is not hydrodynamic has fallen to rounding
        kinetic = float(np.sort(np.abs(theory.eigenvalues))[-4])
        settled = 8 + int(math.log(1e-8) / math.log(max(kinetic, 1e-6)))
        small = 1e-6
        common: dict[str, Any] = {"rows": rows, "columns": 2, "members": 1, "every": 1, "method": BOLTZMANN}
        if name != "hpp":
            waves = (Wave(of="velocity_x", amplitude=small, mode=(0.0, 1.0)),)
            s = measure_mode(laboratory, name, density, waves, _across, steps=settled + 100, **common).values[0].real
            rate = -math.log(s[-1] / s[settled]) / 100
            shear.append(rate / (k**2 * known.shear_viscosity(name, density)) - 1)
        waves = (Wave(of="density", amplitude=small, mode=(0.0, 1.0)),)
        steps = settled + int(1.5 * 2 * math.pi / theory.sound_frequency)
        signals = measure_mode(laboratory, name, density, waves, _mass, steps=steps, **common)
        alpha, omega = standing_wave(
            signals.times[settled:], signals.values[0][settled:], theory.sound_damping, theory.sound_frequency
        )
        sound.append(omega / (c_s * k) - 1)
        damping.append(2 * alpha / (gamma * k**2) - 1)
    judgements = []
    for label, errors in (("nu", shear), ("c_s", sound), ("nu + zeta/rho", damping)):
        if errors:
            judgements.append(_vanishes(label, [wavenumber(model, rows) for rows in sizes], errors))
    return worst(judgements, f"{', '.join(map(str, sizes))} rows, amplitude 1e-6")


def _vanishes(label: str, wavenumbers: list[float], errors: list[float]) -> Judgement:
    """Relative deviations at three wave numbers, extrapolated over k^2 to k = 0."""
    limit = extrapolate(wavenumbers, errors)
    return bounded(
        f"{label} as k -> 0, relative deviation",
        abs(float(limit.value)),
        max(limit.error, 1e-6),
        "what the extrapolation over k^2 changes when the coarsest lattice is left out; at least the amplitude, 1e-6",
    )


# -- advection -------------------------------------------------------------------------------------------


def _judge_advection(laboratory: Laboratory, variant: str) -> Judged:
    """A shear wave in a flow U along its wave vector drifts with g(rho) U, not with U."""
    name, density = named_density(variant)
    model = MODELS[name]
    rows, flow, amplitude = 256, 0.1, 0.025
    k = wavenumber(model, rows)
    theory = modes(model, density, (0.0, k), (0.0, flow))
    steps = int(min(1.2 / theory.shear_decay, 2000))
    signals = measure_mode(
        laboratory,
        name,
        density,
        (Wave(of="velocity_x", amplitude=amplitude, mode=(0.0, 1.0)),),
        _across,
        rows=rows,
        columns=2048,
        steps=steps,
        every=max(1, steps // 60),
        flow=flow,
    )
    drifts = []
    for s in signals.values:
        # weights: the amplitude, by which the noise of the phase falls
        slope = np.polyfit(signals.times[1:], np.unwrap(np.angle(s[1:])), 1, w=abs(s[1:]))[0]
        drifts.append(-slope / (k * flow))
    value, u = independent_mean(drifts)
    expected = theory.shear_frequency / (k * flow)
    plain = known.galilean_factor(name, density)
    axis = np.linspace(0.08, 0.62, 55).tolist()
    figure = Figure(
        "Advection: g over density",
        "d",
        "g",
        series=(
            Series(name, [density], [value], error=[u]),
            Series(f"{name}: theory", axis, [known.galilean_factor(name, d) for d in axis], theory=True),
        ),
    )
    return statistical(
        "g = drift/(k U)",
        value,
        u,
        expected,
        amplitude**2,
        f"{_BY_MEMBERS}; Boltzmann at this k and U, the wave's amplitude squared for its own nonlinearity",
        samples=MEMBERS,
        note=f"g(rho) {plain:.4f}; at U = {flow:g} and this k {expected:.4f}",
        figures=(figure,),
    )


# -- channel ---------------------------------------------------------------------------------------------


def _judge_poiseuille(laboratory: Laboratory, variant: str) -> Judged:
    """A forced channel at d = 1/2, where g = 0: nu j'' = -F(y), no slip, and nu as the shear wave has it.

    The force pushes less where the gas moves, for it needs a particle to turn: its own profile F(y), counted exactly,
    is integrated twice.
    """
    name, wall = variant.rsplit("-", 1)
    model, rows, columns = MODELS[name], 64, 512
    # seven times the slowest decay, H^2/(pi^2 nu), and stretches of two
    stretches, warm, steps = 16, 30_000, 8000
    output = Output(interval=50, observables=("populations", "force_impulse"), fields=(1, rows))
    scene = gas_scene(
        "channel",
        name,
        rows,
        columns,
        warm + stretches * steps,
        filled(0.5, laboratory.seed()),
        output,
        obstacles=(Obstacle(rows=(0, 0), rule="bounce_back" if wall == "bounce" else "diffusive_y"),),
        force=2.0**-13,
    )
    run = laboratory.run(scene, PLANES)
    flow = populations(run)[:, 0] @ model.velocities.cartesian[:, 0] / columns
    per, first = steps // 50, warm // 50
    j = flow[first + 1 :].reshape(stretches, per, rows).mean(axis=1)
    given = np.diff(run["force_impulse"][first::per], axis=0) / (columns * steps)
    step = model.velocities.row_height
    height = rows * step
    y = np.arange(rows) * step
    inside = slice(3, rows - 2)  # rows beside the walls have a Knudsen layer
    # G'' = -F, G = 0 at the wall's row and at its image
    stress = np.cumsum(given.mean(axis=0) * step)
    shape = -np.cumsum(np.concatenate([[0.0], stress[:-1]])) * step
    shape += y / height * -(shape[-1] - stress[-1] * step)
    unit = y / height - 0.5
    columns_of_fit = np.stack([shape, np.ones(rows), unit, unit**4 - unit**2 / 4], axis=1)[inside]
    fits = np.linalg.lstsq(columns_of_fit, j[:, inside].T)[0].T
    slip = fits[:, 1] * fits[:, 0] ** -1 / (stress[-1] / 2)
    # Boltzmann's correction for the wavelength taken off
    k = wavenumber(model, rows)
    finite = modes(model, 0.5, (0.0, k)).shear_decay / k**2 - known.shear_viscosity(name, 0.5)
    decays, decays_error = independent_mean(shear_wave_viscosities(laboratory, name, 0.5, rows))
    wave = (decays - finite, decays_error)
    why = f"standard error of {stretches} stretches of a steady flow"
    nu, nu_error = independent_mean(1 / fits[:, 0])
    length, length_error = independent_mean(slip)
    curved, curved_error = independent_mean(fits[:, 3] / 16 / j.max())
    kept = abs(float(flow[-1].sum() - flow[first].sum())) / (float(given.sum()) * steps)
    judgements = [
        bounded("momentum that the gas keeps, of what the force gives", kept, 0.05,
                "steady: the walls take it all, but for its fluctuations and exp(-7) of the decay before"),
        statistical("nu", nu, nu_error, *wave, f"{why}; the decay of a shear wave in the same gas",
                    samples=stretches, needed=0.1),
        statistical("departure from the profile, fourth power, over the maximum", curved, curved_error, 0.0, 0.0,
                    f"{why}: nu j'' = -F", samples=stretches),
        statistical("slip length at the wall sites, links", length, length_error, 0.0, 0.5,
                    f"{why}; half a link, for a wall between two sites", samples=stretches),
    ]  # fmt: skip
    figure = Figure(
        "Channel flow at d = 0.5",
        "y",
        "momentum per site",
        series=(
            Series(variant, y.tolist(), j.mean(axis=0).tolist()),
            Series(f"{variant}: theory", y.tolist(), (shape / wave[0]).tolist(), theory=True),
        ),
    )
    return worst(judgements, f"Boltzmann's nu {known.shear_viscosity(name, 0.5):.4g}", (figure,))


CHECKS = (
    reference_check(
        "lattice/shear-viscosity",
        "Decay of shear waves: viscosity beside Boltzmann's and Green-Kubo's",
        "u_x(y, t) = u_0 sin(k y) exp(-nu k^2 t), nu = (1/lambda - 1/2)/4",
        "first step of the stress exactly 1 - lambda; nu as the fluctuations at rest have it",
        FHP + "; Henon, Complex Systems 1, 762 (1987); Kadanoff, McNamara & Zanetti, Phys. Rev. A 40, 4527 (1989)",
        _judge_shear,
        at_densities(ISOTROPIC, DENSITIES),
        (
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
    ),
    reference_check(
        "lattice/sound-speed",
        "Standing sound waves: frequency over wave number",
        "c^2 = <c_i^2>/D; with the viscous correction of Boltzmann's modes at this k",
        "within the standard error",
        FHP,
        _judge_sound_speed,
        at_densities(NAMES, DENSITIES),
        (
            (
                "fhp3-d0.5",
                Fault(
                    "rest-never-meets",
                    "lattice/models.py",
                    "return _resting(velocities, state) if velocities.momentum(state) == (0, 0) else None",
                    "return _resting(velocities, state)",
                    "in FHP-III resting particles take no part in collisions: the sound is that of six bits",
                ),
            ),
        ),
    ),
    reference_check(
        "lattice/sound-attenuation",
        "Standing sound waves: damping beside Boltzmann's and Green-Kubo's",
        "alpha = (k^2/2)(nu + zeta/rho)",
        "first step of the stress exactly 1 - lambda; damping as the fluctuations at rest have it",
        FHP + "; Henon, Complex Systems 1, 762 (1987)",
        _judge_attenuation,
        at_densities(NAMES, DENSITIES),
        (("hpp-d0.5", NO_COLLISIONS),),
    ),
    reference_check(
        "lattice/boltzmann-modes",
        "Small waves in the lattice Boltzmann equation: viscosities and sound speed as k goes to 0",
        "nu = (1/lambda - 1/2)/4, c_s, zeta/rho",
        "relative deviation zero after extrapolation over k^2",
        FHP,
        _judge_boltzmann,
        at_densities(NAMES, (0.2, 0.5)),
        (
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
    ),
    reference_check(
        "lattice/advection",
        "A shear wave in a flow drifts with g(rho) U",
        "g = D/(D + 2) (b - 2 rho)/(b - rho), with a rest particle 7/6 of it",
        "within the standard error",
        FHP,
        _judge_advection,
        at_densities(ISOTROPIC, DENSITIES),
        (("fhp1-d0.2", NO_COLLISIONS),),
    ),
    reference_check(
        "lattice/channel-flow",
        "Forced channel at d = 1/2: its profile, without slip",
        "nu j'' = -F, j = F y (H - y)/(2 nu) for a uniform force",
        "viscosity of the shear wave, the profile of the force, zero flow at the wall sites",
        "Kadanoff, McNamara & Zanetti, Phys. Rev. A 40, 4527 (1989); Cornubert et al., Physica D 47, 241 (1991)",
        _judge_poiseuille,
        ("fhp_saturated-bounce", "fhp_saturated-diffusive", "fhp3-bounce", "fhp3-diffusive"),
        (
            (
                "fhp_saturated-bounce",
                Fault(
                    "walls-slip",
                    "lattice/kernels/planes.py",
                    "bounced = reflected(model, found, flip_x, flip_y)",
                    "bounced = reflected(model, found, flip_x & ~flip_x, flip_y)",
                    "walls of bit planes reverse the velocity across them only",
                ),
            ),
        ),
    ),
)
