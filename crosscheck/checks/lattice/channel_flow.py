"""A forced channel at d = 1/2, where g = 0: its profile, and no slip at its walls."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, full
from crosscheck.checks.lattice.gases import LATTICE, filled, gas_scene, populations
from crosscheck.checks.lattice.waves import shear_wave_viscosities, wavenumber
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import lattice_gas as known
from crosscheck.references.channel_flow import forced_profile
from crosscheck.references.lattice_models import VELOCITIES, modes
from crosscheck.scene import Obstacle, Output
from crosscheck.statistics import independent_mean
from crosscheck.verdict import Judged, bounded, statistical, worst

ROWS, COLUMNS, FORCE = 64, 512, 2.0**-13
#: Before the measurement, seven times the slowest decay, H^2/(pi^2 nu); then stretches of two such times, in steps.
STRETCHES, WARM, STEPS, EVERY = 16, 30_000, 8000, 50


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
    flow = populations(run)[:, 0] @ velocities.cartesian[:, 0] / COLUMNS
    per, first = STEPS // EVERY, WARM // EVERY
    j = flow[first + 1 :].reshape(STRETCHES, per, ROWS).mean(axis=1)
    given = np.diff(run["force_impulse"][first::per], axis=0) / (COLUMNS * STEPS)
    # the probability asked for, of particles along -x where the channel +x is free; both come along their row
    plus, minus = (
        populations(run)[first:-1, 0, :, channel] / COLUMNS for channel in (0, int(velocities.cartesian[:, 0].argmin()))
    )
    asked = 2 * FORCE * (minus * (1 - plus)).reshape(STRETCHES, per, ROWS).mean(axis=1)
    push, push_error = independent_mean(given[:, 1:].sum(axis=1) / asked[:, 1:].sum(axis=1))
    step = velocities.row_height
    y = np.arange(ROWS) * step
    inside = slice(3, ROWS - 2)  # rows beside the walls have a Knudsen layer
    shape, total = forced_profile(given.mean(axis=0), step)
    unit = y / (ROWS * step) - 0.5
    columns_of_fit = np.stack([shape, np.ones(ROWS), unit, unit**4 - unit**2 / 4], axis=1)[inside]
    fits = np.linalg.lstsq(columns_of_fit, j[:, inside].T)[0].T
    slip = fits[:, 1] * fits[:, 0] ** -1 / (total / 2)
    # Boltzmann's correction for the wavelength taken off
    k = wavenumber(name, ROWS)
    finite = modes(name, 0.5, (0.0, k)).shear_decay / k**2 - known.shear_viscosity(name, 0.5)
    decays, decays_error = independent_mean(shear_wave_viscosities(laboratory, name, 0.5, ROWS))
    wave = (decays - finite, decays_error)
    why = f"standard error of {STRETCHES} stretches of a steady flow"
    nu, nu_error = independent_mean(1 / fits[:, 0])
    length, length_error = independent_mean(slip)
    curved, curved_error = independent_mean(fits[:, 3] / 16 / j.max())
    kept = abs(float(flow[-1].sum() - flow[first].sum())) / (float(given.sum()) * STEPS)
    judgements = [
        bounded("momentum that the gas keeps, of what the force gives", kept, 0.05,
                "steady: the walls take it all, but for its fluctuations and exp(-7) of the decay before",
                control=True),
        statistical("momentum given by the force, over that of its probability", push, push_error, 1.0, 0.0,
                    f"{why}; channels are independent", samples=STRETCHES, needed=0.02),
        statistical("nu", nu, nu_error, *wave, f"{why}; the decay of a shear wave in the same gas",
                    samples=STRETCHES, needed=0.1),
        statistical("departure from the profile, fourth power, over the maximum", curved, curved_error, 0.0, 0.0,
                    f"{why}: nu j'' = -F", samples=STRETCHES),
        statistical("slip length at the wall sites, links", length, length_error, 0.0, 0.5,
                    f"{why}; half a link, for a wall between two sites", samples=STRETCHES),
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
    return worst(judgements, f"Boltzmann's nu {known.shear_viscosity(name, 0.5):.4g}", (figure,))


def _name(channel: _Channel) -> str:
    return f"{channel.model}-{'bounce' if channel.rule == 'bounce_back' else 'diffusive'}"


CHECKS = (
    Check(
        name="lattice/channel-flow",
        title="Forced channel at d = 1/2: its profile, without slip",
        equation="nu j'' = -F, j = F y (H - y)/(2 nu) for a uniform force",
        criterion="viscosity of the shear wave, the profile of the force, zero flow at the wall sites",
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
