"""Sound in a channel of a lattice gas: what its boundary layers do to it, and what of that is known."""

from __future__ import annotations

import math
from typing import NamedTuple

from crosscheck.checks.base import Laboratory
from crosscheck.checks.lattice.waves import shear_wave_viscosities, wavenumber
from crosscheck.references import lattice_gas as known
from crosscheck.references.channel_flow import channel_sound, lagging_viscosity
from crosscheck.references.lattice_channel import slip_length
from crosscheck.references.lattice_models import VELOCITIES, modes
from crosscheck.statistics import independent_mean


class Layers(NamedTuple):
    """What damps and slows sound in a channel with bounce-back walls.

    model: name of the gas. k: wave number of the sound, 1/links. height: between the side walls, links. boltzmann: the
    gas's viscosity in the Boltzmann equation; viscosity, error: in waves that decay as fast as the sound swings;
    longer: in waves twice as long. slip: at the walls, by the Boltzmann equation, links.
    """

    model: str
    k: float
    height: float
    boltzmann: float
    viscosity: float
    error: float
    longer: float
    slip: float

    def sound(self, share: float = 0.5, change: float = 0.0, slip: float = 0.0) -> complex:
        """Rate of the sound; share: of the long-time tail; change: of the viscosity; slip: further one, links.

        The walls cut the tail off, at a depth like that of the layers: between none of it and that of free waves.
        """
        tail = lagging_viscosity(self.viscosity, self.longer) - self.boltzmann
        nu = self.boltzmann + share * tail + change
        return channel_sound(known.SOUND_SPEED[self.model], nu, self.k, self.height, self.slip + slip)

    @property
    def doubtful(self) -> float:
        """Slip that is in doubt, links: one and a half mean free paths, 2 nu each at speed 1.

        Particles that a wall sends back the way they came meet those again that they have met: Boltzmann's equation
        leaves that out.
        """
        return 3 * self.viscosity

    def off(self) -> tuple[float, float]:
        """By how much damping and frequency may be off: half of the tail, and the slip either way."""
        middle = self.sound()
        tails = [self.sound(share) - middle for share in (0.0, 1.0)]
        slips = [self.sound(slip=sign * self.doubtful) - middle for sign in (-1, 1)]
        return (
            max(abs(one.real) for one in tails) + max(abs(one.real) for one in slips),
            max(abs(one.imag) for one in tails) + max(abs(one.imag) for one in slips),
        )


def boundary_layers(laboratory: Laboratory, model: str, density: float, k: float, height: float) -> Layers:
    """The viscosity of boundary layers, sqrt(2 nu/omega) thick: that of waves which decay with the rate omega.

    Long-time tails make it grow with the length of the wave. Such a wave is as long as the layers are deep, to a
    factor. laboratory: runs the waves. model: name of the gas. density: d. k: wave number of the sound, 1/links.
    height: between the side walls, links.
    """
    omega, boltzmann = known.SOUND_SPEED[model] * k, known.shear_viscosity(model, density)
    waves = [
        2 * round(factor * math.pi / math.sqrt(omega / boltzmann) / VELOCITIES[model].row_height)
        for factor in (1.0, 2.0)
    ]
    (nu, error), (longer, _) = (
        independent_mean(shear_wave_viscosities(laboratory, model, density, rows)) for rows in waves
    )
    # what the Boltzmann equation has for so short a wave, which is of another order in k, is taken off
    short, long = (
        modes(model, density, (0.0, wavenumber(model, rows))).shear_decay / wavenumber(model, rows) ** 2 - boltzmann
        for rows in waves
    )
    slip = slip_length(model, density, "bounce_back")
    return Layers(model, k, height, boltzmann, nu - short, error, longer - long, slip)
