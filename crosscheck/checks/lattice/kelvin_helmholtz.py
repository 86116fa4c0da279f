"""Two shear layers roll up: growth of a wave."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, full
from crosscheck.checks.lattice.flow_fields import MODEL, mean_velocity, vorticity_map
from crosscheck.checks.lattice.gases import LATTICE, filled, gas_scene, populations
from crosscheck.checks.lattice.waves import shear_wave_viscosities
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import lattice_gas as known
from crosscheck.references.lattice_models import VELOCITIES
from crosscheck.references.shear_layer import disturbance, double_layer, largest_growth
from crosscheck.scene import Floats, Output, Wave
from crosscheck.statistics import independent_mean
from crosscheck.verdict import Judged, bounded, statistical, worst

DENSITY, WIDTH, ROWS, COLUMNS = 0.3, 60.0, 960, 832
STEP = VELOCITIES[MODEL].row_height
HEIGHT = ROWS * STEP
WAVENUMBER = 2 * math.pi / COLUMNS
EVERY, MEMBERS, BLOCKS = 500, 10, (26, 40)


class _Layers(NamedTuple):
    """Speed of the flow on either side (links per step), and steps of the run."""

    speed: float
    steps: int

    @property
    def amplitude(self) -> float:
        """Of the wave at the start, links per step."""
        return 0.05 * self.speed

    @property
    def flow(self) -> Floats:
        """U of each row, links per step."""
        return double_layer(np.arange(ROWS) * STEP, HEIGHT, self.speed, WIDTH)


def _measure(laboratory: Laboratory, layers: _Layers, shape: Any) -> tuple[Floats, Floats]:
    """Amplitude of the wave over that of the theory, (members, samples); and the mean of the last fields.

    The velocity across the layers is projected on the shape that the theory gives it at each time, (samples, blocks): a
    mean of |v| would count the fluctuations in.
    """
    x = (np.arange(BLOCKS[0]) + 0.5) * COLUMNS / BLOCKS[0] - 0.25
    shares, last = [], np.zeros(0)
    for member in range(MEMBERS):
        start = filled(
            DENSITY,
            laboratory.seed(str(member)),
            velocity_x=tuple(layers.flow.tolist()),
            waves=(Wave(of="velocity_y", amplitude=layers.amplitude, mode=(1.0, 0.0)),),
        )
        output = Output(interval=EVERY, observables=("populations",), fields=BLOCKS)
        scene = gas_scene("layers", MODEL, ROWS, COLUMNS, layers.steps, start, output)
        velocity = mean_velocity(populations(laboratory.run(scene, LATTICE)))
        v = np.einsum("txy,x->ty", velocity[..., 1], np.exp(-1j * WAVENUMBER * x)) * 2 / BLOCKS[0]
        shares.append((shape.conj() * v).sum(axis=1).real / (np.abs(shape) ** 2).sum(axis=1))
        last = velocity[-1] / MEMBERS + (last if member else 0.0)
    return np.array(shares), last


def _judge(laboratory: Laboratory, layers: _Layers) -> Judged:
    """Growth of a wave on two tanh layers, against the linearised vorticity equation of the spreading flow."""
    speed = layers.speed
    times = np.arange(0, layers.steps + 1, EVERY, dtype=float)
    # viscosity grows with the wavelength, by the long-time tail; the layers' is longer than these
    (nu, _), (shorter, _) = (
        independent_mean(shear_wave_viscosities(laboratory, MODEL, DENSITY, size)) for size in (512, 128)
    )
    g = known.galilean_factor(MODEL, DENSITY)
    shape, other = (
        _in_blocks(disturbance(layers.flow, STEP, WAVENUMBER, value, g, layers.amplitude, times), BLOCKS[1])
        for value in (nu, shorter + 2 * (nu - shorter))
    )
    shares, last = _measure(laboratory, layers, shape)
    expected, changed = (np.sqrt((np.abs(one) ** 2).mean(axis=1)) for one in (shape, other))
    measured = shares * expected
    # from 1.5 times the first amplitude to a quarter of the flow's speed: beyond it the wave is no longer small
    window = (expected > 1.5 * expected[0]) & (expected < speed / 4)
    rates = [_rate(times[window], one[window]) for one in measured]
    rate, rate_error = independent_mean(rates)
    theory = _rate(times[window], expected[window])
    inviscid = largest_growth(g * speed, WIDTH)
    mach = speed / known.SOUND_SPEED[MODEL]
    begun, begun_error = independent_mean(shares[:, 0])
    judgements = [
        statistical(
            "amplitude of the wave at the start, over that asked for",
            begun,
            begun_error,
            1.0,
            0.0,
            f"standard error of {MEMBERS} gases, filled in local equilibrium",
            samples=MEMBERS,
        ),
        statistical(
            "growth rate",
            rate,
            rate_error,
            theory,
            0.0,
            f"standard error of {MEMBERS} gases; half of the Mach number squared, as the theory is incompressible, and "
            "what as much more viscosity changes as there is between shear waves of 128 and 512 rows; to be told from "
            "the growth without viscosity",
            samples=MEMBERS,
            doubt=theory * mach**2 / 2 + abs(theory - _rate(times[window], changed[window])),
            needed=inviscid / theory - 1,
        ),
        bounded(
            "growth of the wave in this time",
            float(measured[:, window][:, -1].mean() / measured[:, 0].mean()),
            2.0,
            "else nothing has grown",
            at_least=True,
            control=True,
        ),
    ]
    figures = (
        _growth_figure(speed, times, measured, expected),
        vorticity_map(f"Kelvin-Helmholtz layers, U = {speed:g}, mean of the gases", last, (float(COLUMNS), HEIGHT), 2),
    )
    note = (
        f"Re = g U delta/nu = {g * speed * WIDTH / nu:.0f}, k delta = {WAVENUMBER * WIDTH:.3f}; without viscosity "
        f"{inviscid:.3g} at most"
    )
    return worst(judgements, note, figures)


def _growth_figure(speed: float, times: Floats, measured: Floats, expected: Floats) -> Figure:
    """Mean and standard error of the gases' amplitudes, (members, samples), beside the theory's, (samples,)."""
    return Figure(
        "Kelvin-Helmholtz: growth of the wave",
        "step",
        "|v_k|/U",
        y_scale="log",
        series=(
            Series(
                f"U = {speed:g}",
                times.tolist(),
                (measured.mean(axis=0) / speed).tolist(),
                error=(measured.std(axis=0, ddof=1) / speed / MEMBERS**0.5).tolist(),
            ),
            Series(f"U = {speed:g}: linear theory", times.tolist(), (expected / speed).tolist(), theory=True),
        ),
    )


def _in_blocks(v: Any, blocks: int) -> Any:
    """v (times, rows) averaged over equal blocks of rows."""
    return v.reshape(len(v), blocks, -1).mean(axis=2)


def _rate(times: Floats, values: Floats) -> float:
    """Slope of the logarithm; NaN where a value is not positive."""
    if not (values > 0).all():
        return math.nan
    return float(np.polyfit(times, np.log(values), 1)[0])


CHECKS = (
    Check(
        name="lattice/kelvin-helmholtz",
        title="Two shear layers roll up: growth of a wave",
        equation="d zeta/dt = -i k g U zeta + i k g U'' phi + nu (d^2/dy^2 - k^2) zeta",
        criterion="growth rate of the linear theory of the spreading flow",
        citation="Michalke, J. Fluid Mech. 19, 543 (1964); Drazin & Reid, Hydrodynamic Stability, Cambridge (1981)",
        judge=_judge,
        variants=full(**{"U0.2": _Layers(0.2, 20_000), "U0.15": _Layers(0.15, 26_000)}),
        faults=(
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
        needs=Needs("lattice_gas", (LATTICE,), observables=frozenset({"populations"})),
    ),
)
