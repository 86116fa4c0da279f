"""Units by name: what numbers of one file are multiplied by to be in the unit of another."""

from __future__ import annotations

from scipy import constants

#: In SI units.
_SI = {
    "m": 1.0,
    "cm": 1e-2,
    "um": 1e-6,
    "nm": 1e-9,
    "Angstrom": 1e-10,
    "Bohr": constants.physical_constants["Bohr radius"][0],
    "s": 1.0,
    "us": 1e-6,
    "ns": 1e-9,
    "ps": 1e-12,
    "fs": 1e-15,
    "atu": constants.physical_constants["atomic unit of time"][0],
    "LAMMPS-electron-time": constants.physical_constants["Bohr radius"][0]
    * (constants.atomic_mass / constants.physical_constants["Hartree energy"][0]) ** 0.5,
    "ASE-time": constants.angstrom * (constants.atomic_mass / constants.electron_volt) ** 0.5,
}


def factor(unit: str, into: str) -> float | None:
    """What numbers in `unit` are multiplied by to be in `into`; 1 if both have one name, or one has none.

    unit, into: names as in `trajectories.frames.Units`, also of quotients. Reduced units (sigma, tau) are whatever the
    other file's are. None: they cannot be compared.
    """
    if unit == into or not unit or not into or is_reduced(unit) or is_reduced(into):
        return 1.0
    here, there = _value(unit), _value(into)
    return None if here is None or there is None else here / there


def is_reduced(unit: str) -> bool:
    """Whether a unit is one of the reduced units of Lennard-Jones particles. unit: its name."""
    return unit.partition("/")[0] in ("sigma", "tau")


def _value(unit: str) -> float | None:
    parts = [_SI.get(part) for part in unit.split("/")]
    if any(part is None for part in parts):
        return None
    value = parts[0]
    for part in parts[1:]:
        value /= part  # type: ignore[operator]
    return value
