"""Temperatures in kelvin as energies of a file: k_B T in units of its mass and velocity."""

from __future__ import annotations

from scipy import constants

from crosscheck.compare.units import factor, is_reduced
from crosscheck.errors import UsageError
from crosscheck.files import shown_path
from crosscheck.trajectories.frames import Source

#: Unit of the velocity of a file -> its unit of mass, in kg: of LAMMPS's units si, cgs, micro and nano, by the
#: documentation of its command `units`. All other files whose units are known have masses in u.
_MASSES = {"m/s": 1.0, "cm/s": 1e-3, "um/us": 1e-15, "nm/ns": 1e-21}


def in_energy(kelvin: float, source: Source) -> float:
    """k_B T in the mass velocity^2 of a file. kelvin: T. source: the file. UsageError if its units are not known."""
    velocity = source.units.velocity
    metres = None if not velocity or is_reduced(velocity) else factor(velocity, "m/s")
    if metres is None:
        raise UsageError(
            f"--temperature: {shown_path(source.path)} states no units of mass and velocity: give k_B T in those that "
            "it has"
        )
    return kelvin * constants.Boltzmann / (_MASSES.get(velocity, constants.atomic_mass) * metres**2)
