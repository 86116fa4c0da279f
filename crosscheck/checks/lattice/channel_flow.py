"""A forced channel at d = 1/2, where g = 0: its profile, and no slip at its walls."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, full
from crosscheck.checks.lattice.gases import LATTICE, filled, gas_scene, populations
from crosscheck.checks.lattice.waves import MEMBERS, shear_wave_viscosities, wavenumber
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import lattice_gas as known
from crosscheck.references.channel_flow import forced_profile
from crosscheck.references.lattice_channel import steady_channel
from crosscheck.references.lattice_models import VELOCITIES, Velocities, modes
from crosscheck.scene import Floats, Obstacle, Output
from crosscheck.statistics import independent_mean
from crosscheck.verdict import Judged, bounded, statistical, worst

ROWS, COLUMNS = 64, 512
#: Probability with which a particle is turned from -x to +x.
FORCE = 2.0**-13
#: Before the measurement, seven times the slowest decay, H^2/(pi^2 nu); then stretches of four such times, in steps.
STRETCHES, WARM, STEPS, EVERY = 36, 30_000, 16_000, 50


class _Channel(NamedTuple):
    """A gas between walls with this rule of reflection."""

    model: str
    rule: Literal["bounce_back", "diffusive_y"]


def _run(laboratory: Laboratory, channel: _Channel) -> Run:
    output = Output(interval=EVERY, observables=("populations", "force_impulse"), fields=(1, ROWS))
    scene = gas_scene(
        "channel",
        channel.model,
        ROWS,
        COLUMNS,
        WARM + STRETCHES * STEPS,
        filled(0.5, laboratory.seed()),
        output,
        obstacles=(Obstacle(rows=(0, 0), rule=channel.rule),),
        force=FORCE,
    )
    return laboratory.run(scene, LATTICE)


def _judge(laboratory: Laboratory, channel: _Channel) -> Judged:
    """nu j'' = -F(y), no slip, and nu that of the shear wave.

    The force pushes less where the gas moves, for it needs a particle to turn: its own profile F(y), counted exactly,
    is integrated twice.
    """
    name, velocities = channel.model, VELOCITIES[channel.model]
    run = _run(laboratory, channel)
    occupations = populations(run)[:, 0] / COLUMNS
    flow = occupations @ velocities.cartesian[:, 0]
    per, first = STEPS // EVERY, WARM // EVERY
    j = flow[first + 1 :].reshape(STRETCHES, per, ROWS).mean(axis=1)
    given = np.diff(run["force_impulse"][first::per], axis=0) / (COLUMNS * STEPS)
    step = velocities.row_height
    y = np.arange(ROWS) * step
    shape, total = forced_profile(given.mean(axis=0), step)
    fits = _fitted(shape, j)
    slip = _slip(fits, total)
    # Boltzmann's correction for the wavelength taken off
    k = wavenumber(name, ROWS)
    finite = modes(name, 0.5, (0.0, k)).shear_decay / k**2 - known.shear_viscosity(name, 0.5)
    decays, decays_error = independent_mean(shear_wave_viscosities(laboratory, name, 0.5, ROWS))
    wave = (decays - finite, decays_error)
    why = f"standard error of {STRETCHES} stretches of a steady flow"
    nu, nu_error = independent_mean(1 / fits[:, 0])
    length, length_error = independent_mean(slip)
    curved, curved_error = independent_mean(fits[:, 3] / 16 / j.max())
    boltzmann, bent = _boltzmann(channel)
    kept = abs(float(flow[-1].sum() - flow[first].sum())) / (float(given.sum()) * STEPS)
    judgements = [
        bounded("momentum that the gas keeps, of what the force gives", kept, 0.05,
                "steady: the walls take it all, but for its fluctuations and exp(-7) of the decay before",
                control=True),
        statistical("nu", nu, nu_error, *wave, f"{why}; the decay of a shear wave in the same gas",
                    samples=min(STRETCHES, MEMBERS), needed=0.08),
        statistical("momentum that the force gives, over 2 p f_-x (1 - f_+x)",
                    *independent_mean(given.sum(axis=1) / _asked_for(velocities, occupations[first + 1 :])), 1.0, 0.0,
                    f"{why}; p is what the scene asks for, f the mean occupations of the rows",
                    samples=STRETCHES, needed=0.02),
        statistical("departure from the profile, fourth power, over the maximum, less that of Boltzmann's equation",
                    curved - bent, curved_error, 0.0, 0.0,
                    f"{why}: nu j'' = -F, and what the square of the speed adds; off by as much again: correlations, "
                    "which Boltzmann's equation leaves out",
                    samples=STRETCHES, doubt=abs(bent), needed=0.1),
        statistical("slip length at the wall sites less that of Boltzmann's equation, links", length - boltzmann,
                    length_error, 0.0, 0.0,
                    f"{why}; off by half a mean free path, nu: particles that a wall sends back meet those again "
                    "that they have met; a wall half a link away must be seen",
                    samples=STRETCHES, doubt=wave[0], needed=0.45),
    ]  # fmt: skip
    variant = _name(channel)
    figure = Figure(
        "Channel flow at d = 0.5",
        "y",
        "momentum per site",
        series=(
            Series(variant, y.tolist(), j.mean(axis=0).tolist()),
            Series(f"{variant}: theory", y.tolist(), (shape / wave[0]).tolist(), theory=True),
        ),
    )
    note = f"Boltzmann's nu {known.shear_viscosity(name, 0.5):.4g}, slip length {boltzmann:.3f}, here {length:.3f}"
    return worst(judgements, note, (figure,))


def _asked_for(velocities: Velocities, occupations: Floats) -> Floats:
    """Momentum a site of the rows and step that this force gives to independent channels, (stretches,).

    occupations: mean ones of rows, (samples, rows, b).
    """
    forwards, backwards = (velocities.integers.index((sign * 2, 0)) for sign in (1, -1))
    f = occupations.reshape(STRETCHES, -1, ROWS, velocities.channels).mean(axis=1)[:, 1:]
    return np.asarray(2 * FORCE * (f[..., backwards] * (1 - f[..., forwards])).sum(axis=1))


def _fitted(shape: Floats, flow: Floats) -> Floats:
    """Coefficients of momentum per site (..., rows): of nu j = shape, of 1, of y, of the fourth power; (..., 4)."""
    inside = slice(3, ROWS - 2)  # rows beside the walls have a Knudsen layer
    unit = np.arange(ROWS) / ROWS - 0.5
    columns = np.stack([shape, np.ones(ROWS), unit, unit**4 - unit**2 / 4], axis=1)[inside]
    return np.asarray(np.linalg.lstsq(columns, flow[..., inside].T)[0].T)


def _slip(fits: Floats, total: float) -> Floats:
    """Flow at the wall sites over its gradient there, links; fits: (..., 4), total: force on the channel."""
    return np.asarray(fits[..., 1] / fits[..., 0] / (total / 2))


def _boltzmann(channel: _Channel) -> tuple[float, float]:
    """Slip length and fourth power over the maximum, of the steady flow of Boltzmann's equation under this force.

    Its layers at the walls move the place where j = 0; the square of the speed bends the profile.
    """
    steady = steady_channel(channel.model, 0.5, ROWS, channel.rule, FORCE)
    shape, total = forced_profile(steady.given, VELOCITIES[channel.model].row_height)
    fit = _fitted(shape, steady.flow)
    return float(_slip(fit, total)), float(fit[3] / 16 / steady.flow.max())


def _name(channel: _Channel) -> str:
    return f"{channel.model}-{'bounce' if channel.rule == 'bounce_back' else 'diffusive'}"


CHECKS = (
    Check(
        name="lattice/channel-flow",
        title="Forced channel at d = 1/2: its profile, without slip",
        equation="nu j'' = -F, j = F y (H - y)/(2 nu) for a uniform force",
        criterion="viscosity of the shear wave, the profile of the force, slip at the walls as in Boltzmann's equation",
        citation="Kadanoff, McNamara & Zanetti, Phys. Rev. A 40, 4527 (1989); "
        "Cornubert et al., Physica D 47, 241 (1991)",
        judge=_judge,
        variants=full(
            **{
                _name(channel): channel
                for model in ("fhp_saturated", "fhp3")
                for channel in (_Channel(model, "bounce_back"), _Channel(model, "diffusive_y"))
            }
        ),
        faults=(
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
        needs=Needs(
            "lattice_gas",
            (LATTICE,),
            words=frozenset({"lattice_gas.obstacles", "lattice_gas.obstacles.rows", "lattice_gas.force"}),
            observables=frozenset({"populations", "force_impulse"}),
        ),
    ),
)
