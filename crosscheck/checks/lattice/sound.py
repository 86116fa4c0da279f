"""Standing sound waves: frequency and damping."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory
from crosscheck.checks.lattice.gases import FHP, LATTICE, NO_COLLISIONS, State, at_densities
from crosscheck.checks.lattice.green_kubo import against_green_kubo, equal_times, first_step, fluctuations
from crosscheck.checks.lattice.waves import (
    BY_MEMBERS,
    DENSITIES,
    MEMBERS,
    Signals,
    amplitude_at_start,
    density_figure,
    mass,
    measure_mode,
    standing_wave,
    wavenumber,
)
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import lattice_gas as known
from crosscheck.references.lattice_models import MODELS, VELOCITIES, green_kubo, modes
from crosscheck.references.lattice_wave import sound_wave
from crosscheck.scene import Floats, Wave
from crosscheck.statistics import independent_mean
from crosscheck.verdict import Judged, statistical, worst

#: Amplitudes of the waves whose speed and whose damping is measured, relative to d.
_QUIET, _LOUD = 0.05, 0.1
#: By so much of it times the square of the relative amplitude frequencies change, at most (docs/lattice.md).
_SLOWER = 0.02


class _Sound(NamedTuple):
    """Standing waves of wave number k (1/links): damping and frequency of each gas, (members, 2), per step."""

    k: float
    fits: Floats
    signals: Signals


def _sound(laboratory: Laboratory, state: State, amplitude: float, rows: int, columns: int, steps: int) -> _Sound:
    """Runs standing waves and fits them; amplitude: relative to d; rows: one wavelength."""
    name, density = state
    k = wavenumber(name, rows)
    guess = modes(name, density, (0.0, k))
    waves = (Wave(of="density", amplitude=amplitude * density, mode=(0.0, 1.0)),)
    every = max(1, int(2 * math.pi / guess.sound_frequency) // 16)
    signals = measure_mode(
        laboratory, name, density, waves, mass(name), rows=rows, columns=columns, steps=steps, every=every
    )
    fits = [standing_wave(signals.times, s, guess.sound_damping, guess.sound_frequency) for s in signals.values]
    return _Sound(k, np.array(fits), signals)


def _judge_speed(laboratory: Laboratory, state: State) -> Judged:
    """omega/k of standing waves on 256 and 512 rows, less Boltzmann's at this k, extrapolated to waves without end."""
    name, density = state
    deviations, errors = [], []
    for rows in (256, 512):
        k, fits, signals = _sound(laboratory, state, _QUIET, rows, 1024, 6 * rows)
        value, u = independent_mean(fits[:, 1] / k)
        deviations.append(value - modes(name, density, (0.0, k)).sound_frequency / k)
        errors.append(u)
    # halving k leaves a quarter of a deviation of order k^2. HPP keeps the momentum of each row, its sound is that of
    # one dimension, where frequencies deviate by k^(3/2): 2^(-1/2) is left
    remains = 0.25 if name != "hpp" else math.sqrt(0.5)
    share = remains / (1 - remains)
    left = share * (deviations[0] - deviations[1])
    c_s = known.SOUND_SPEED[name]
    value, u = c_s + deviations[1] - left, math.hypot((1 + share) * errors[1], share * errors[0])
    figures = (
        Figure(
            "Sound speed over density",
            "d",
            "c",
            series=(
                Series(name, [density], [value], error=[u]),
                Series(f"{name}: c_s", [0.08, 0.62], [c_s] * 2, theory=True),
            ),
        ),
    )
    speed = statistical(
        "c = omega/k of waves without end",
        value,
        u,
        c_s,
        0.0,
        f"{BY_MEMBERS} on 256 and 512 rows; by what the amplitude changes; of FHP, by as much as the longer waves "
        "deviate, for the power of k is an assumption",
        samples=MEMBERS,
        doubt=_SLOWER * _QUIET**2 * c_s + (0.0 if name == "hpp" else abs(left)),
        needed=None if name == "hpp" else 0.02,
        figures=figures,
    )
    asked = _QUIET * density * VELOCITIES[name].channels
    by_rows = " and ".join(f"{deviation:.2g}({error:.1g})" for deviation, error in zip(deviations, errors, strict=True))
    note = f"on 256 and 512 rows, c is off Boltzmann's by {by_rows}"
    return worst([amplitude_at_start(signals, asked, "sound on 512 rows"), speed], note)


def _judge_attenuation(laboratory: Laboratory, state: State) -> Judged:
    """2 alpha/k^2 = nu + zeta/rho of a standing wave, beside Boltzmann's and Green-Kubo's; the first step is exact."""
    name, density = state
    rows = 128
    k = wavenumber(name, rows)
    at_k = modes(name, density, (0.0, k))
    steps = int(min(1.2 / at_k.sound_damping, 4000))
    _, fits, signals = _sound(laboratory, state, _LOUD, rows, 1024, steps)
    measured = (2 * fits[:, 0] / k**2).tolist()
    velocities = VELOCITIES[name]
    weights = velocities.cartesian[:, 1] ** 2 - known.SOUND_SPEED[name] ** 2
    rest = fluctuations(laboratory, name, density, [weights], rows)
    omega = float(fits[:, 1].mean())
    at_rest = green_kubo(name, density, weights, omega)
    linear = 2 * at_k.sound_damping / k**2
    loud = sound_wave(name, density, _LOUD, rows, signals.times)
    steepened = 2 * standing_wave(signals.times, loud, at_k.sound_damping, at_k.sound_frequency)[0] / k**2 - linear
    wave, note = against_green_kubo(
        "nu + zeta/rho", measured, (linear, at_rest), rest, 2 * at_k.sound_damping, omega, steepened
    )
    judgements = [equal_times(rest, "sound"), wave]
    if not velocities.rest:  # with a rest particle two rates mix in this moment
        judgements.append(first_step(name, rest, "sound"))
    figures = [
        density_figure(
            "Sound attenuation over density",
            "2 alpha/k^2",
            name,
            density,
            measured,
            lambda d: known.longitudinal_viscosity(name, d),
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


_NEEDS = Needs("lattice_gas", (LATTICE,), observables=frozenset({"populations"}))

CHECKS = (
    Check(
        name="lattice/sound-speed",
        title="Standing sound waves: frequency over wave number",
        equation="c^2 = <c_i^2>/D; with the viscous correction of Boltzmann's modes at this k",
        criterion="within the standard error",
        citation=FHP,
        judge=_judge_speed,
        variants=at_densities(MODELS, DENSITIES),
        faults=(
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
        needs=_NEEDS,
    ),
    Check(
        name="lattice/sound-attenuation",
        title="Standing sound waves: damping beside Boltzmann's and Green-Kubo's",
        equation="alpha = (k^2/2)(nu + zeta/rho)",
        criterion="first step of the stress exactly 1 - lambda; damping that of the fluctuations at rest",
        citation=FHP + "; Henon, Complex Systems 1, 762 (1987)",
        judge=_judge_attenuation,
        variants=at_densities(MODELS, DENSITIES),
        faults=(("hpp-d0.5", NO_COLLISIONS),),
        needs=_NEEDS,
    ),
)
