"""k_B T of 300 K in the units of files, against numbers of textbooks."""

from __future__ import annotations

from dataclasses import replace

import pytest
from inspected import flying

from crosscheck.errors import UsageError
from crosscheck.inspect.kelvin import in_energy
from crosscheck.trajectories.frames import Units


@pytest.mark.parametrize(
    ("velocity", "expected"),
    [
        ("m/s", 4.1419e-21),
        ("cm/s", 4.1419e-14),  # erg
        ("nm/ps", 2.4943),  # kJ/mol: R T
        ("Angstrom/ps", 249.43),  # 10 J/mol
        ("Angstrom/fs", 2.4943e-4),
        ("Angstrom/ASE-time", 0.025852),  # eV
        ("um/us", 4.1419e-6),  # pg um^2/us^2 = 1e-15 J
        ("nm/ns", 4.1419),  # ag nm^2/ns^2 = 1e-21 J
        ("Bohr/LAMMPS-electron-time", 300 * 3.1668e-6),  # hartree
    ],
)
def test_300_kelvin(velocity: str, expected: float) -> None:
    source = replace(flying(), units=Units("", "", velocity))
    assert in_energy(300.0, source) == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("velocity", ["", "sigma/tau", "furlong/fortnight"])
def test_units_that_are_not_known_are_refused(velocity: str) -> None:
    source = replace(flying(), units=Units("", "", velocity))
    with pytest.raises(UsageError, match="states no units of mass and velocity"):
        in_energy(300.0, source)
