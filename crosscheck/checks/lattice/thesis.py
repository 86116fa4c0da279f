"""Two experiments of a thesis of 1991 on lattice gases: as described, by its own method, and by a correct one.

What it reports, what a run of the same set-up gives, and why they differ: docs/lattice.md.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, full
from crosscheck.checks.lattice.gases import LATTICE, NO_COLLISIONS, filled, gas_scene, populations
from crosscheck.checks.lattice.waves import first_guess, shear_wave_viscosities, standing_wave
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import lattice_gas as known
from crosscheck.references import lattice_thesis as reported
from crosscheck.references.channel_flow import channel_sound
from crosscheck.references.lattice_models import VELOCITIES, modes
from crosscheck.scene import Floats, Obstacle, Output, Wave
from crosscheck.statistics import independent_mean
from crosscheck.verdict import Judged, Judgement, bounded, statistical, worst

_SOURCE = "Pliego Diaz, thesis, UNAM (1991), sec. 4.3"
RUNS, EVERY, CELL, SAMPLES = 10, 10, 5, 1024
#: The model of the second experiment: its table has two outcomes at most, so the state that enters is not among them.
FHP = "fhp_saturated"


class Box(NamedTuple):
    """Density of the columns of cells of a lattice gas in a box.

    times: of the samples, (samples,), steps. strips: density of each column of cells in excess of the mean, (runs,
    samples, cells along x). columns: of sites of the lattice, along x.
    """

    times: Floats
    strips: Floats
    columns: int


def _experiment(
    laboratory: Laboratory, model: str, columns: int, rows: int, density: float, wave: Wave, box: bool = True
) -> Box:
    """10 runs of 10300 steps, density every 10 steps in the 10 middle cells of each column.

    box: wall sites on all four edges; otherwise they are periodic.
    """
    edges = (
        Obstacle(rows=(0, 0)),
        Obstacle(rows=(rows - 1, rows - 1)),
        Obstacle(columns=(0, 0)),
        Obstacle(columns=(columns - 1, columns - 1)),
    )
    across, down = columns // CELL, rows // CELL
    output = Output(interval=EVERY, observables=("populations",), fields=(across, down))
    middle = slice(down // 2 - 5, down // 2 + 5)
    found = []
    for run in range(RUNS):
        start = filled(density, laboratory.seed(str(run)), waves=(wave,), cells=CELL)
        scene = gas_scene("box", model, rows, columns, 10300, start, output, obstacles=edges if box else ())
        counts = populations(laboratory.run(scene, LATTICE)).sum(axis=3)
        found.append(counts[:, :, middle].mean(axis=2) / (CELL**2 * VELOCITIES[model].channels) - density)
    return Box(np.arange(len(found[0])) * float(EVERY), np.array(found), columns)


def _peak(signal: Floats, samples: int = SAMPLES) -> int:
    """Bin of the largest line of the discrete Fourier transform, the mean left out."""
    return 1 + int(np.abs(np.fft.rfft(signal[:samples] - signal[:samples].mean()))[1:].argmax())


def _cosine(box: Box, number: float) -> Floats:
    """Projection on cos(number pi x/L), (runs, samples), x of the cells' middles and L between the wall sites."""
    x = (np.arange(box.strips.shape[2]) + 0.5) * CELL - 0.5
    shape = np.cos(number * math.pi * x / (box.columns - 1))
    return box.strips @ shape * 2 / shape.size


def _fits(times: Floats, signals: Floats, damping: float, frequency: float) -> Floats:
    """Damping and frequency of each run, (runs, 2)."""
    return np.array([standing_wave(times, signal, damping, frequency) for signal in signals])


# -- experiment 1 ----------------------------------------------------------------------------------------


def _judge_hpp(laboratory: Laboratory, walls: bool) -> Judged:
    return _hpp_box(laboratory) if walls else _hpp_periodic(laboratory)


def _hpp_box(laboratory: Laboratory) -> Judged:
    """As described: sin(2 pi x/L) between rigid ends is a sum of cosines, the first of which is the largest."""
    columns = 305
    wave = Wave(of="density", amplitude=0.1, mode=(1.0, 0.0), phase=-math.pi / 2)
    box = _experiment(laboratory, "hpp", columns, 95, 0.5, wave)
    length = columns - 1
    k = math.pi / length
    guess, theory = first_guess("hpp", 0.5, (k, 0.0)), modes("hpp", 0.5, (k, 0.0))
    peaks = {_peak(run[:, strip]) for run in box.strips for strip in (15, 45)}
    first = _cosine(box, 1)
    fits = _fits(box.times, first, guess.sound_damping, guess.sound_frequency)
    speed, u = independent_mean(fits[:, 1] / k)
    damping, u_damping = independent_mean(2 * fits[:, 0] / k**2)
    expected = theory.sound_frequency / k
    shares = reported.half_sine_modes(3)
    share, u_share = independent_mean(_cosine(box, 3)[:, 0] / first[:, 0])
    half_node = 0.5 / length
    judgements = [
        bounded(
            "Fourier peaks of the strips, distance from bins 12 and 36",
            float(max(min(abs(peak - 12), abs(peak - 36)) for peak in peaks)),
            0.0,
            "periods 861 and 287 of the first and third cosine lie in these bins of width 1/10240",
        ),
        statistical(
            "third cosine over the first, at the start",
            share,
            u_share,
            float(shares[2] / shares[0]),
            0.02,
            "Fourier series of the sine on the box; 2 % for cells of 5 sites, which are not a continuum",
            samples=RUNS,
        ),
        statistical(
            "c of the first cosine",
            speed,
            u,
            expected,
            expected * half_node,
            f"standard error of {RUNS} runs; half a site in the length of the box",
            samples=RUNS,
            needed=0.02,
        ),
        statistical(
            "2 alpha/k^2",
            damping,
            u_damping,
            2 * theory.sound_damping / k**2,
            0.05 * 2 * theory.sound_damping / k**2,
            f"standard error of {RUNS} runs; 5 % beyond Boltzmann, as in a periodic box",
            samples=RUNS,
        ),
    ]
    note = (
        f"thesis: period {reported.HPP[0]}, c {reported.HPP[1]}. Its method here: bins {sorted(peaks)} of 10240 steps, "
        f"periods {', '.join(f'{10 * SAMPLES / peak:.1f}' for peak in sorted(peaks))}. "
        f"Period of the first cosine: {2 * math.pi / fits[:, 1].mean():.1f}"
    )
    return worst(judgements, note, (_curve("HPP box, d = 0.5", "crest, cell 15", box, 15),))


def _hpp_periodic(laboratory: Laboratory) -> Judged:
    """With periodic edges the sine is a mode: bin 24; read as the index of an array that starts with 1, bin 25."""
    columns = 305
    k = 2 * math.pi / columns
    guess, theory = first_guess("hpp", 0.5, (k, 0.0)), modes("hpp", 0.5, (k, 0.0))
    peaks: set[int] = set()
    speeds = []
    for amplitude in (0.1, 0.05):
        wave = Wave(of="density", amplitude=amplitude, mode=(1.0, 0.0), phase=-math.pi / 2)
        gas = _experiment(laboratory, "hpp", columns, 95, 0.5, wave, box=False)
        if amplitude == 0.1:
            peaks = {_peak(run[:, strip]) for run in gas.strips for strip in (15, 45)}
        x = (np.arange(gas.strips.shape[2]) + 0.5) * CELL - 0.5
        signal = gas.strips @ np.sin(k * x) * 2 / x.size
        speeds.append(_fits(gas.times, signal, guess.sound_damping, guess.sound_frequency)[:, 1] / k)
    # half the amplitude has a quarter of the shift
    speed, u = independent_mean((4 * speeds[1] - speeds[0]) / 3)
    period = reported.HPP[0]
    judgements = [
        bounded(
            "Fourier peaks of the strips, distance from bin 24",
            float(max(abs(peak - 24) for peak in peaks)),
            0.0,
            f"period {2 * math.pi / theory.sound_frequency:.1f} lies in bin 24 of width 1/10240",
        ),
        bounded(
            "thesis's period off 10240/25, relative",
            abs(period / (10 * SAMPLES / 25) - 1),
            0.5 / 25,
            "half a bin: the thesis's number is that of bin 24 counted from 1",
            control=True,
        ),
        statistical(
            "c of the sine, at vanishing amplitude",
            speed,
            u,
            theory.sound_frequency / k,
            0.0,
            f"standard error of {RUNS} runs, extrapolated from amplitudes 0.1 and 0.05; Boltzmann at this k",
            samples=RUNS,
            needed=0.02,
        ),
    ]
    note = (
        f"thesis: period {period}, c {reported.HPP[1]}; here bins {sorted(peaks)}, "
        f"c = {speeds[0].mean():.5f} at the thesis's amplitude"
    )
    return worst(judgements, note)


# -- experiment 2 ----------------------------------------------------------------------------------------


def _judge_fhp(laboratory: Laboratory, density: float) -> Judged:
    """Period, sound speed and 'viscosity' of the thesis, and of the same runs; the wave feels the side walls."""
    columns, rows = 295, 100
    wave = Wave(of="density", amplitude=0.1, mode=(0.5, 0.0))
    box = _experiment(laboratory, FHP, columns, rows, density, wave)
    length, height = columns - 1, (rows - 1) * math.sqrt(3) / 2
    true, true_error = independent_mean(shear_wave_viscosities(laboratory, FHP, density, 128))
    boltzmann = known.shear_viscosity(FHP, density)
    speed_of_sound, k = known.SOUND_SPEED[FHP], math.pi / length
    channel = channel_sound(speed_of_sound, true, k, height)
    thin = channel_sound(speed_of_sound, boltzmann, k, height)
    peaks = {_peak(box.strips[:, :, strip].mean(axis=0)) for strip in (8, 50)}
    fits = _fits(box.times, _cosine(box, 1), -channel.real, channel.imag)
    alpha, u_alpha = independent_mean(fits[:, 0])
    speed, u_speed = independent_mean(fits[:, 1] / k)
    # the walls' place is known to half a link on either side, and the gas's viscosity as it differs from Boltzmann's
    wall = 1 / height
    nonlinear = (0.1 / density) ** 2 / 16
    judgements = [
        bounded(
            "Fourier peaks of the strips, distance from bin 12",
            float(max(abs(peak - 12) for peak in peaks)),
            0.0,
            "the period, 857 ... 899, lies in bin 12 of width 1/10240 at every density",
        ),
        statistical(
            "alpha of the first cosine, per step",
            alpha,
            u_alpha,
            -channel.real,
            math.hypot((channel - thin).real, channel.real * wall, channel.real * nonlinear),
            f"standard error of {RUNS} runs; boundary layers on both side walls, uncertain by the part of nu beyond "
            "Boltzmann's, a link in the width, and the square of the amplitude over d",
            samples=RUNS,
        ),
        statistical(
            "c = omega/k of the first cosine",
            speed,
            u_speed,
            channel.imag / k,
            math.hypot((channel - thin).imag / k, (channel.imag / k - speed_of_sound) * wall,
                       speed * 0.5 / length, speed * nonlinear),
            f"standard error of {RUNS} runs; boundary layers, half a site in the length, the square of the amplitude",
            samples=RUNS,
        ),
        _thesis_viscosity(density, alpha, u_alpha, length),
    ]  # fmt: skip
    scale = 2 * length**2 / math.pi**2
    note = (
        f"thesis: period {reported.FHP[0]}, c {reported.FHP[1]}, nu {_viscosities(density)}. Its method here: bin "
        f"{sorted(peaks)}, period {10 * SAMPLES / min(peaks):.1f} (bin 13, counted from 1: {10 * SAMPLES / 13:.1f}); "
        f"nu per step {alpha * scale:.2f}. By a shear wave nu = {true:.3f}({true_error:.1g}), Boltzmann {boltzmann:.3f}"
    )
    figure = _viscosity_figure(density, alpha * scale, u_alpha * scale, (true, true_error))
    return worst(judgements, note, (figure, _curve(f"FHP box, d = {density:g}", "crest, cell 8", box, 8)))


def _viscosities(density: float) -> str:
    crest, trough = reported.VISCOSITY[density]
    return f"{crest:g} and {trough:g}"


def _thesis_viscosity(density: float, alpha: float, u_alpha: float, length: float) -> Judgement:
    """What the thesis takes for nu: 2 L^2/pi^2 times the decay between two samples. alpha: per step; length: links."""
    scale = 2 * length**2 / math.pi**2
    number = np.array(reported.VISCOSITY[density])
    return statistical(
        "2 (10 alpha) L^2/pi^2, the thesis's nu",
        10 * alpha * scale,
        10 * u_alpha * scale,
        float(number.mean()),
        0.15 * float(number.mean()),
        "standard error; the thesis's own 15 %: its slopes are per sample of 10 steps",
        samples=RUNS,
    )


def _viscosity_figure(density: float, value: float, error: float, shear: tuple[float, float]) -> Figure:
    """value, error: 2 alpha L^2/pi^2 per step, links^2. shear: nu of a shear wave and its error."""
    axis = sorted(reported.VISCOSITY)
    return Figure(
        "'Viscosity' of the thesis's box, and the gas's",
        "d",
        "nu",
        y_scale="log",
        series=(
            Series("thesis, crest", axis, [reported.VISCOSITY[d][0] for d in axis], theory=True),
            Series("its method here, per sample", [density], [10 * value], error=[10 * error]),
            Series("the same per step", [density], [value], error=[error]),
            Series("shear wave", [density], [shear[0]], error=[shear[1]]),
            Series("Boltzmann", axis, [known.shear_viscosity(FHP, d) for d in axis], theory=True),
        ),
    )


def _curve(title: str, label: str, box: Box, strip: int) -> Figure:
    mean = box.strips[:, ::4, strip].mean(axis=0)
    return Figure(
        f"{title}: density of a strip",
        "step",
        "d - d_0",
        series=(Series(label, box.times[::4].tolist(), mean.tolist()),),
    )


_NEEDS = Needs(
    "lattice_gas",
    (LATTICE,),
    words=frozenset({"lattice_gas.obstacles", "lattice_gas.obstacles.columns", "lattice_gas.obstacles.rows"}),
    observables=frozenset({"populations"}),
)

CHECKS = (
    Check(
        name="lattice/thesis-hpp",
        title="Thesis, experiment 1: sound of HPP in a box, and with periodic edges",
        equation="c = 2 L/T, T of the first cosine",
        criterion="c of the correct method within its standard error; the thesis's peaks replicated, "
        "its period explained",
        citation=_SOURCE,
        judge=_judge_hpp,
        variants=full(box=True, periodic=False),
        faults=(("box", NO_COLLISIONS),),
        needs=_NEEDS,
    ),
    Check(
        name="lattice/thesis-fhp",
        title="Thesis, experiment 2: sound of FHP in a box, its period, sound speed and viscosity",
        equation="s^2/(1 - tanh(q)/q) + nu k^2 s + c^2 k^2 = 0, q = (H/2)(s/nu)^(1/2)",
        criterion="damping and frequency of a channel with no-slip walls; the thesis's numbers replicated "
        "by its method",
        citation=_SOURCE + "; Kirchhoff, Ann. Phys. 210, 177 (1868)",
        judge=_judge_fhp,
        variants=full(**{f"d{density:g}": density for density in sorted(reported.VISCOSITY)}),
        faults=(
            (
                "d0.5",
                Fault(
                    "smooth-walls",
                    "lattice/kernels/planes.py",
                    "bounced = reflected(model, found, flip_x, flip_y)",
                    "bounced = reflected(model, found, flip_x & ~flip_y, flip_y)",
                    "bounce-back walls of bit planes reverse the velocity along y alone: no wall drag",
                ),
            ),
        ),
        needs=_NEEDS,
    ),
)
