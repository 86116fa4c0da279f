"""Flows that lattice gases were made for: a vortex street behind a plate, and a Kelvin-Helmholtz layer.

With the factor g(rho) in front of the advection, g u takes the place of the velocity in Reynolds and Strouhal numbers.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from crosscheck.checks.base import Laboratory, reference_check
from crosscheck.checks.lattice.states import PLANES, filled, gas_scene, populations
from crosscheck.checks.lattice.transport import shear_wave_viscosities
from crosscheck.faults import Fault
from crosscheck.figure import FieldMap, Figure, Frame, Series
from crosscheck.references import lattice_gas as known
from crosscheck.references.shear_layer import disturbance, double_layer
from crosscheck.scene import Floats, Obstacle, Output, Wave
from crosscheck.statistics import independent_mean
from crosscheck.verdict import Judged, bounded, statistical, worst
from refimpl.lattice.models import MODELS

MODEL = "fhp3"


def _velocity(counts: Floats) -> Floats:
    """Mean velocity of blocks, (..., 2); NaN where there is nothing."""
    mass = counts.sum(axis=-1)
    with np.errstate(invalid="ignore"):
        return counts @ MODELS[MODEL].velocities.cartesian / np.where(mass > 0, mass, np.nan)[..., None]


def _picture(title: str, velocity: Floats, size: tuple[float, float], coarse: int) -> Figure:
    """Vorticity of blocks [ix, iy] with arrows of the velocity on blocks `coarse` times as large."""
    width, height = size
    nx, ny = velocity.shape[:2]
    filled_in = np.nan_to_num(velocity)
    vorticity = np.gradient(filled_in[..., 1], width / nx, axis=0) - np.gradient(filled_in[..., 0], height / ny, axis=1)
    limit = float(np.quantile(np.abs(vorticity), 0.98))
    blocks = filled_in.reshape(nx // coarse, coarse, ny // coarse, coarse, 2).mean(axis=(1, 3))
    arrows = (blocks[..., 0].T.tolist(), blocks[..., 1].T.tolist())
    frame = Frame(0.0, width, 0.0, height, ())
    field = FieldMap(vorticity.T.tolist(), frame, "vorticity", (-limit, limit), arrows, "velocity")
    return Figure(title, "x", "y", map=field)


# -- vortex street ---------------------------------------------------------------------------------------


def _judge_street(laboratory: Laboratory, variant: str) -> Judged:
    """A plate across the flow sheds vortices in turn: frequency by the velocity across the wake behind it.

    The wake comes back to the plate through the periodic ends. A honeycomb of smooth plates along the flow, without
    drag, takes its vortices away, as in a wind tunnel.
    """
    density = float(variant.removeprefix("d"))
    model, rows, columns, plate, block = MODELS[MODEL], 1024, 2048, 128, 16
    step = model.velocities.row_height
    half, middle, place = int(plate / step / 2), rows // 2, columns // 4 + 64
    speed, warm, steps, every = 0.28, 20_000, 44_000, 100
    scene = gas_scene(
        "plate",
        MODEL,
        rows,
        columns,
        warm + steps,
        filled(
            density,
            laboratory.seed(),
            velocity_x=speed,
            waves=(Wave(of="velocity_y", amplitude=0.08, mode=(4.0, 0.0)),),
        ),
        Output(interval=every, observables=("populations",), fields=(columns // block, rows // block)),
        obstacles=(
            Obstacle(columns=(place, place + 3), rows=(middle - half, middle + half - 1)),
            *(Obstacle(columns=(0, 159), rows=(row, row), rule="specular_y") for row in range(0, rows, 16)),
        ),
        force=6e-5,
    )
    velocity = _velocity(populations(laboratory.run(scene, PLANES)))[warm // every :]
    behind, centre = (place + 2 * plate) // block, middle // block
    signals = [
        np.nanmean(velocity[:, at - 1 : at + 2, centre - 1 : centre + 1, 1], axis=(1, 2))
        for at in (behind, behind + plate // block)
    ]
    times = np.arange(len(signals[0])) * float(every)
    frequencies, shares = zip(*(_line(times, signal) for signal in signals), strict=True)
    mean_speed = float(np.nanmean(velocity[..., 0]))
    g = known.galilean_factor(MODEL, density)
    nu, _ = independent_mean(shear_wave_viscosities(laboratory, MODEL, density, 128))
    strouhal = frequencies[0] * plate / (g * mean_speed)
    reynolds = g * mean_speed * plate / nu
    blockage = plate / (rows * step)
    judgements = [
        bounded(
            "share of the line in the variance of the velocity across the wake",
            min(shares),
            0.5,
            "a street is periodic: noise, and a wake that meets itself, have no line with half of the variance",
            at_least=True,
        ),
        bounded(
            "velocity across the wake, rms, over that of the flow",
            float(signals[0].std()) / mean_speed,
            0.4,
            "vortices turn the wake by as much as the flow itself; the push at the start was a fifth of it",
            at_least=True,
        ),
        bounded(
            "frequencies at two places, relative difference",
            abs(frequencies[0] / frequencies[1] - 1),
            1 / (frequencies[0] * times[-1]) / 2,
            "one street: half of the width of a line in the time of the measurement",
        ),
        statistical(
            "Strouhal number f D/(g U)",
            strouhal,
            strouhal / (frequencies[0] * times[-1]) / 10,
            0.16 / (1 - blockage / 2),
            0.02,
            "line width over ten, its ratio of signal to noise; 0.14 ... 0.18 of normal plates, up to 1/(1 - blockage) "
            "times as much in a row of them",
            samples=frequencies[0] * times[-1] * 2,
        ),
    ]
    size = (float(columns), rows * step)
    figures = (
        _picture(f"Vortex street behind a plate, d = {density:g}", velocity[-1], size, 8),
        Figure(
            "Velocity across the wake",
            "step",
            "v_y",
            series=(Series(f"d = {density:g}", times[::4].tolist(), signals[0][::4].tolist()),),
        ),
    )
    note = (
        f"Re = g U D/nu = {reynolds:.0f}, U = {mean_speed:.3f}, period {1 / frequencies[0]:.0f}, "
        f"blockage {blockage:.2f}"
    )
    return worst(judgements, note, figures)


def _line(times: Floats, signal: Floats) -> tuple[float, float]:
    """Frequency of the strongest line, and the share of its fundamental in the variance."""
    from scipy.optimize import minimize_scalar

    centred = signal - signal.mean()

    def fit(frequency: float) -> float:
        waves = np.stack([np.cos(2 * np.pi * frequency * times), np.sin(2 * np.pi * frequency * times)], axis=1)
        left = centred - waves @ np.linalg.lstsq(waves, centred)[0]
        return float(left @ left)

    spectrum = np.abs(np.fft.rfft(centred * np.hanning(centred.size), 8 * centred.size))
    axis = np.fft.rfftfreq(8 * centred.size, times[1])
    first = axis[int(spectrum.argmax())]
    width = 1 / times[-1]
    best = minimize_scalar(
        fit, bounds=(first - width / 2, first + width / 2), method="bounded", options={"xatol": 1e-6 * width}
    )
    return float(best.x), 1 - fit(float(best.x)) / float(centred @ centred)


# -- Kelvin-Helmholtz ------------------------------------------------------------------------------------


def _judge_layer(laboratory: Laboratory, variant: str) -> Judged:
    """Growth of a wave on two tanh layers, against the linearised vorticity equation of the spreading flow.

    The velocity across the layers is projected on the shape that the theory gives it at each time: a mean of |v| would
    count the fluctuations in.
    """
    density, speed, width = 0.3, float(variant.removeprefix("U")), 60.0
    model, rows, columns = MODELS[MODEL], 960, 832
    step = model.velocities.row_height
    height = rows * step
    k = 2 * math.pi / columns
    flow = double_layer(np.arange(rows) * step, height, speed, width)
    amplitude = 0.05 * speed
    every, members, blocks = 500, 10, (26, 40)
    steps = 20_000 if speed > 0.15 else 26_000
    times = np.arange(0, steps + 1, every, dtype=float)
    # viscosity grows with the wavelength, by the long-time tail; the layers' is longer than these
    (nu, _), (shorter, _) = (
        independent_mean(shear_wave_viscosities(laboratory, MODEL, density, size)) for size in (512, 128)
    )
    g = known.galilean_factor(MODEL, density)
    shape, other = (
        _in_blocks(disturbance(flow, step, k, value, g, amplitude, times), blocks[1])
        for value in (nu, shorter + 2 * (nu - shorter))
    )
    x = (np.arange(blocks[0]) + 0.5) * columns / blocks[0] - 0.25
    shares, last = [], np.zeros(0)
    for member in range(members):
        start = filled(
            density,
            laboratory.seed(str(member)),
            velocity_x=tuple(flow.tolist()),
            waves=(Wave(of="velocity_y", amplitude=amplitude, mode=(1.0, 0.0)),),
        )
        output = Output(interval=every, observables=("populations",), fields=blocks)
        scene = gas_scene("layers", MODEL, rows, columns, steps, start, output)
        velocity = _velocity(populations(laboratory.run(scene, PLANES)))
        v = np.einsum("txy,x->ty", velocity[..., 1], np.exp(-1j * k * x)) * 2 / blocks[0]
        shares.append((shape.conj() * v).sum(axis=1).real / (np.abs(shape) ** 2).sum(axis=1))
        last = velocity[-1] / members + (last if member else 0.0)
    expected, changed = (np.sqrt((np.abs(one) ** 2).mean(axis=1)) for one in (shape, other))
    measured = np.array(shares) * expected
    # from where the layers prevail to a quarter of the flow's speed: beyond it the wave is no longer small
    window = (expected > 1.5 * expected[0]) & (expected < speed / 4)
    rates = [_rate(times[window], one[window]) for one in measured]
    rate, rate_error = independent_mean(rates)
    theory = _rate(times[window], expected[window])
    mach = speed / known.SOUND_SPEED[MODEL]
    judgements = [
        statistical(
            "growth rate",
            rate,
            rate_error,
            theory,
            math.hypot(theory * mach**2 / 2, theory - _rate(times[window], changed[window])),
            f"standard error of {members} gases; half of the Mach number squared, as the theory is incompressible, and "
            "what as much more viscosity changes as there is between shear waves of 128 and 512 rows",
            samples=members,
            needed=0.5,
        ),
        bounded(
            "growth of the wave in this time",
            float(measured[:, window][:, -1].mean() / measured[:, 0].mean()),
            2.0,
            "else nothing has grown",
            at_least=True,
        ),
    ]
    figures = (
        Figure(
            "Kelvin-Helmholtz: growth of the wave",
            "step",
            "|v_k|/U",
            y_scale="log",
            series=(
                Series(
                    f"U = {speed:g}",
                    times.tolist(),
                    (measured.mean(axis=0) / speed).tolist(),
                    error=(measured.std(axis=0, ddof=1) / speed / members**0.5).tolist(),
                ),
                Series(f"U = {speed:g}: linear theory", times.tolist(), (expected / speed).tolist(), theory=True),
            ),
        ),
        _picture(f"Kelvin-Helmholtz layers, U = {speed:g}, mean of the gases", last, (float(columns), height), 2),
    )
    inviscid = 0.1897 * g * speed / width
    note = (
        f"Re = g U delta/nu = {g * speed * width / nu:.0f}, k delta = {k * width:.3f}; without viscosity "
        f"{inviscid:.3g} at most"
    )
    return worst(judgements, note, figures)


def _in_blocks(v: Any, blocks: int) -> Any:
    """v (times, rows) averaged over equal blocks of rows."""
    return v.reshape(len(v), blocks, -1).mean(axis=2)


def _rate(times: Floats, values: Floats) -> float:
    """Slope of the logarithm; NaN where a value is not positive."""
    if not (values > 0).all():
        return math.nan
    return float(np.polyfit(times, np.log(values), 1)[0])


CHECKS = (
    reference_check(
        "lattice/vortex-street",
        "A plate across the flow sheds a vortex street",
        "St = f D/(g U)",
        "one line in the spectrum; a Strouhal number as of normal plates",
        "Najjar & Balachandar, J. Fluid Mech. 370, 101 (1998); Fage & Johansen, Proc. R. Soc. A 116, 170 (1927)",
        _judge_street,
        ("d0.2", "d0.3"),
        (
            (
                "d0.3",
                Fault(
                    "no-plate",
                    "lattice/kernels/planes.py",
                    "solid = flip_x | flip_y\n",
                    "solid = flip_x & ~flip_x\n",
                    "bit planes do not see bounce-back walls",
                ),
            ),
        ),
    ),
    reference_check(
        "lattice/kelvin-helmholtz",
        "Two shear layers roll up: growth of a wave",
        "d zeta/dt = -i k g U zeta + i k g U'' phi + nu (d^2/dy^2 - k^2) zeta",
        "growth rate of the linear theory of the spreading flow",
        "Michalke, J. Fluid Mech. 19, 543 (1964); Drazin & Reid, Hydrodynamic Stability, Cambridge (1981)",
        _judge_layer,
        ("U0.2", "U0.15"),
        (
            (
                "U0.2",
                Fault(
                    "free-streaming",
                    "lattice/models.py",
                    "            outcomes[state] = cycle if identity",
                    "            outcomes[state] = (state,) if members else cycle if identity",
                    "particles never collide: nothing rolls up",
                ),
            ),
        ),
    ),
)
