"""Two experiments of a thesis of 1991 on lattice gases: as described, by its own method, and by a correct one.

What it reports, what a run of the same set-up gives, and why they differ: docs/lattice.md.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, full
from crosscheck.checks.lattice.boundary_layers import Layers, boundary_layers
from crosscheck.checks.lattice.gases import LATTICE, NO_COLLISIONS, filled, gas_scene, populations
from crosscheck.checks.lattice.waves import (
    mass,
    measure_mode,
    standing_wave,
)
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.references import lattice_gas as known
from crosscheck.references import lattice_thesis as reported
from crosscheck.references.lattice_models import VELOCITIES, Modes, modes
from crosscheck.scene import Floats, Obstacle, Output, Wave
from crosscheck.statistics import independent_mean
from crosscheck.verdict import Judged, Judgement, bounded, round_off, statistical, worst

_SOURCE = "Pliego Diaz, thesis, UNAM (1991), sec. 4.3"
RUNS, EVERY, CELL, SAMPLES = 10, 10, 5, 1024
#: Runs of the correct methods, and of each of their amplitudes.
MANY = 40
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
    down = rows // CELL
    return _runs(laboratory, model, (rows, columns), density, wave, box, range(RUNS), 10300, down, down // 2 - 5)


def _whole(
    laboratory: Laboratory, model: str, columns: int, rows: int, density: float, wave: Wave, steps: int, box: bool
) -> Box:
    """`MANY` runs of so many steps, density every 10 steps of whole columns of cells; box: as in `_experiment`."""
    runs = [f"{wave.amplitude:g}/{box}/{run}" for run in range(MANY)]
    return _runs(laboratory, model, (rows, columns), density, wave, box, runs, steps, 1, 0)


def _runs(
    laboratory: Laboratory, model: str, sites: tuple[int, int], density: float, wave: Wave, box: bool,
    runs: Iterable[object], steps: int, down: int, first: int,
) -> Box:  # fmt: skip
    """Density of the strips in `down` blocks along y, without `first` of them at either end.

    sites: of the lattice along y and x. runs: what tells the seeds of the runs apart.
    """
    rows, columns = sites
    edges = (
        Obstacle(rows=(0, 0)),
        Obstacle(rows=(rows - 1, rows - 1)),
        Obstacle(columns=(0, 0)),
        Obstacle(columns=(columns - 1, columns - 1)),
    )
    output = Output(interval=EVERY, observables=("populations",), fields=(columns // CELL, down))
    channels = CELL * rows // down * VELOCITIES[model].channels
    found = []
    for run in runs:
        start = filled(density, laboratory.seed(str(run)), waves=(wave,), cells=CELL)
        scene = gas_scene("box", model, rows, columns, steps, start, output, obstacles=edges if box else ())
        counts = populations(laboratory.run(scene, LATTICE)).sum(axis=3)
        found.append(counts[:, :, first : down - first].mean(axis=2) / channels - density)
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
    """As described: sin(2 pi x/L) between rigid ends is a sum of cosines, the first of which is the largest.

    By the correct method a cosine is one half of a wave in a periodic gas of twice the length, and moves like it.
    """
    columns, rows = 305, 95
    wave = Wave(of="density", amplitude=0.1, mode=(1.0, 0.0), phase=-math.pi / 2)
    box = _experiment(laboratory, "hpp", columns, rows, 0.5, wave)
    length = columns - 1
    k = math.pi / length
    theory = modes("hpp", 0.5, (k, 0.0))
    peaks = {_peak(run[:, strip]) for run in box.strips for strip in (15, 45)}
    first = _cosine(box, 1)
    started = _start_of_the_sine(columns)
    begun, shares = [first[:, 0], _cosine(box, 3)[:, 0]], reported.half_sine_modes(3)
    cosine, twin = _hpp_cosine(laboratory, rows, columns, theory), _hpp_twin(laboratory, rows, columns, theory)
    (speed, u), (twin_speed, twin_u) = independent_mean(cosine[:, 1] / k), independent_mean(twin[:, 1] / k)
    (damping, u_damping), (twin_damping, u_twin) = (independent_mean(2 * one[:, 0] / k**2) for one in (cosine, twin))
    judgements = [
        bounded(
            "Fourier peaks of the strips, distance from bins 12 and 36",
            float(max(min(abs(peak - 12), abs(peak - 36)) for peak in peaks)),
            0.0,
            "periods 861 and 287 of the first and third cosine lie in these bins of width 1/10240",
        ),
        *(
            round_off(
                f"{label} cosine at the start, less that of cells with whole numbers of particles",
                float(abs(found - expected).max()),
                64 * EPSILON,
                "the same numbers in all runs; sums of 61 cells",
                note=f"{expected:.5g}, of a continuum {0.1 * shares[n]:.5g}",
            )
            for label, n, found, expected in zip(("first", "third"), (0, 2), begun, started, strict=True)
        ),
        statistical(
            "c of the first cosine",
            speed,
            u,
            twin_speed,
            twin_u,
            f"standard errors of {MANY} runs; a wave of a periodic gas twice as long; a quarter of a site at both "
            "ends, as particles turn at a wall site in the step in which they have reached it",
            samples=MANY,
            doubt=twin_speed * 0.5 / length,
            needed=0.005,
        ),
        statistical(
            "2 alpha/k^2",
            damping,
            u_damping,
            twin_damping,
            u_twin,
            f"standard errors of {MANY} runs; a wave of a periodic gas twice as long",
            samples=MANY,
            needed=0.2,
        ),
    ]
    note = (
        f"thesis: period {reported.HPP[0]}, c {reported.HPP[1]}. Its method here: bins {sorted(peaks)} of 10240 steps, "
        f"periods {', '.join(f'{10 * SAMPLES / peak:.1f}' for peak in sorted(peaks))}. Period of the first cosine: "
        f"{2 * math.pi / cosine[:, 1].mean():.1f}. Boltzmann's 2 alpha/k^2: {2 * theory.sound_damping / k**2:.4g}"
    )
    return worst(judgements, note, (_curve("HPP box, d = 0.5", "crest, cell 15", box, 15),))


def _hpp_cosine(laboratory: Laboratory, rows: int, columns: int, start: Modes) -> Floats:
    """Damping and frequency of the first cosine in a box that starts with it, (runs, 2); start: where fits begin."""
    wave = Wave(of="density", amplitude=0.1, mode=(0.5, 0.0))
    box = _whole(laboratory, "hpp", columns, rows, 0.5, wave, 10300, True)
    return _fits(box.times, _cosine(box, 1), start.sound_damping, start.sound_frequency)


def _hpp_twin(laboratory: Laboratory, rows: int, columns: int, start: Modes) -> Floats:
    """The same of one wave in a periodic gas whose length is twice that between the walls of the box.

    It runs along y: on the square lattice both axes are alike.
    """
    wave = Wave(of="density", amplitude=0.1, mode=(0.0, 1.0))
    signals = measure_mode(
        laboratory, "hpp", 0.5, (wave,), mass("hpp"), rows=2 * (columns - 1), columns=rows, steps=10300, every=EVERY,
        members=MANY,
    )  # fmt: skip
    return _fits(signals.times, signals.values, start.sound_damping, start.sound_frequency)


def _start_of_the_sine(columns: int) -> tuple[float, float]:
    """First and third cosine of cells that hold whole numbers of particles, as near to a sine as these allow."""
    cells = columns // CELL
    channels = CELL**2 * VELOCITIES["hpp"].channels
    wanted = 0.5 + 0.1 * np.sin(2 * math.pi * np.arange(cells) / (cells - 1))
    strips = np.rint(channels * wanted) / channels - 0.5
    x = (np.arange(cells) + 0.5) * CELL - 0.5
    first, third = (float(strips @ np.cos(n * math.pi * x / (columns - 1))) * 2 / cells for n in (1, 3))
    return first, third


def _hpp_periodic(laboratory: Laboratory) -> Judged:
    """With periodic edges the sine is a mode: bin 24; read as the index of an array that starts with 1, bin 25."""
    columns = 305
    k = 2 * math.pi / columns
    theory = modes("hpp", 0.5, (k, 0.0))
    peaks: set[int] = set()
    speeds = []
    for amplitude in (0.1, 0.05):
        wave = Wave(of="density", amplitude=amplitude, mode=(1.0, 0.0), phase=-math.pi / 2)
        gas = _experiment(laboratory, "hpp", columns, 95, 0.5, wave, box=False)
        if amplitude == 0.1:
            peaks = {_peak(run[:, strip]) for run in gas.strips for strip in (15, 45)}
        x = (np.arange(gas.strips.shape[2]) + 0.5) * CELL - 0.5
        signal = gas.strips @ np.sin(k * x) * 2 / x.size
        speeds.append(_fits(gas.times, signal, theory.sound_damping, theory.sound_frequency)[:, 1] / k)
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


def _sound_of_the_box(laboratory: Laboratory, density: float, columns: int, rows: int, rate: complex) -> Floats:
    """Damping and frequency of the first cosine as its amplitude goes to 0, (runs, 2); rate: where fits begin.

    Two amplitudes, whose shifts are as their squares; the larger is no larger than the thesis's, nor half of d.
    """
    steps = EVERY * round(min(10300.0, 3 / -rate.real) / EVERY)
    found = []
    for amplitude in (0.5, 1.0):
        wave = Wave(of="density", amplitude=amplitude * min(0.1, density / 2), mode=(0.5, 0.0))
        box = _whole(laboratory, FHP, columns, rows, density, wave, steps, True)
        found.append(_fits(box.times, _cosine(box, 1), -rate.real, rate.imag))
    return (4 * found[0] - found[1]) / 3


def _judge_fhp(laboratory: Laboratory, density: float) -> Judged:
    """Period, sound speed and 'viscosity' of the thesis, and of the same runs; the wave feels the side walls."""
    columns, rows = 295, 100
    wave = Wave(of="density", amplitude=0.1, mode=(0.5, 0.0))
    box = _experiment(laboratory, FHP, columns, rows, density, wave)
    length, height = columns - 1, (rows - 1) * math.sqrt(3) / 2
    k = math.pi / length
    layers = boundary_layers(laboratory, FHP, density, k, height)
    channel = layers.sound()
    peaks = {_peak(box.strips[:, :, strip].mean(axis=0)) for strip in (8, 50)}
    fits = _fits(box.times, _cosine(box, 1), -channel.real, channel.imag)
    right = _sound_of_the_box(laboratory, density, columns, rows, channel)
    judgements = [
        bounded(
            "Fourier peaks of the strips, distance from bin 12",
            float(max(abs(peak - 12) for peak in peaks)),
            0.0,
            "the period, 857 ... 899, lies in bin 12 of width 1/10240 at every density",
        ),
        *_against_layers(layers, length, right),
        _thesis_viscosity(density, *independent_mean(fits[:, 0]), length),
    ]
    scale = 2 * length**2 / math.pi**2
    alpha, u_alpha = independent_mean(fits[:, 0])
    true = (layers.viscosity, layers.error)
    note = (
        f"thesis: period {reported.FHP[0]}, c {reported.FHP[1]}, nu {_viscosities(density)}. Its method here: bin "
        f"{sorted(peaks)}, period {10 * SAMPLES / min(peaks):.1f} (bin 13, counted from 1: {10 * SAMPLES / 13:.1f}); "
        f"nu per step {alpha * scale:.2f}. By a shear wave nu = {true[0]:.3f}({true[1]:.1g}), in one twice as long "
        f"{layers.longer:.3f}, Boltzmann {known.shear_viscosity(FHP, density):.3f}"
    )
    figure = _viscosity_figure(density, alpha * scale, u_alpha * scale, true)
    return worst(judgements, note, (figure, _curve(f"FHP box, d = {density:g}", "crest, cell 8", box, 8)))


def _against_layers(layers: Layers, length: float, right: Floats) -> list[Judgement]:
    """Damping and speed of the first cosine, (runs, 2), against sound with boundary layers on both side walls."""
    k, channel = layers.k, layers.sound()
    noise = layers.sound(change=layers.error / 2) - channel
    alpha, u_alpha = independent_mean(right[:, 0])
    speed, u_speed = independent_mean(right[:, 1] / k)
    damping_off, frequency_off = layers.off()
    why = (
        f"standard errors of {MANY} runs at each of two amplitudes, and of nu; boundary layers on both side walls, off "
        "by half of the long-time tail, which walls cut off, and by 1.5 mean free paths of slip, "
        f"{layers.doubtful:.2g} links"
    )
    return [
        statistical(
            "alpha of the first cosine, per step",
            alpha,
            u_alpha,
            -channel.real,
            abs(noise.real),
            why,
            samples=MANY,
            doubt=damping_off,
            needed=0.4,
        ),
        statistical(
            "c = omega/k of the first cosine",
            speed,
            u_speed,
            channel.imag / k,
            abs(noise.imag) / k,
            f"{why}, and half a site in the length; the thesis's own must be seen to be wrong",
            samples=MANY,
            doubt=frequency_off / k + channel.imag / k * 0.5 / length,
            needed=reported.FHP[1] * k / channel.imag - 1,
        ),
    ]


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
        0.0,
        "standard error; the thesis's own 15 %, and its two figures; its slopes are per sample of 10 steps",
        samples=RUNS,
        doubt=0.15 * float(number.mean()) + float(np.ptp(number)) / 2,
        needed=0.4,
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
