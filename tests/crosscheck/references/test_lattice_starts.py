"""Starts of lattice gases: fields by hand, and equilibria that are recognised."""

from __future__ import annotations

import math

import numpy as np
import pytest

from crosscheck.references.lattice_audit import Lattice
from crosscheck.references.lattice_models import MODELS, fermi_dirac, low_speed_equilibrium
from crosscheck.references.lattice_starts import Fields, deviation_from_equilibrium, fields, numbers_of_cells
from crosscheck.scene import Occupations, Wave


def test_a_wave_across_shifted_rows() -> None:
    wave = Wave(of="velocity_x", amplitude=0.1, mode=(1.0, 2.0), phase=0.5)
    initial = Occupations(kind="occupations", density=(0.2, 0.3, 0.4, 0.5), velocity_y=0.01, waves=(wave,), seed=0)
    density, velocity = fields(Lattice("fhp1", 4, 6), initial)
    np.testing.assert_array_equal(density, np.repeat([[0.2], [0.3], [0.4], [0.5]], 6, axis=1))
    np.testing.assert_array_equal(velocity[..., 1], 0.01)
    # the site in column 2 of row 3 is at (2.5, 3 sqrt(3)/2) in a box of 6 x 4 sqrt(3)/2
    assert velocity[3, 2, 0] == pytest.approx(0.1 * math.cos(2 * math.pi * (2.5 / 6 + 2 * 3 / 4) + 0.5), rel=1e-14)
    assert velocity[2, 2, 0] == pytest.approx(0.1 * math.cos(2 * math.pi * (2 / 6 + 2 * 2 / 4) + 0.5), rel=1e-14)


@pytest.mark.parametrize("model", MODELS)
def test_equilibria_are_recognised(model: str) -> None:
    asked = Fields(np.array([0.1, 0.3, 0.8]), np.array([[0.1, 0.05], [-0.2, 0.1], [0.0, 0.05]]))
    f = fermi_dirac(model, *asked)
    assert max(deviation_from_equilibrium(model, f, asked)) < 1e-15
    # one to second order has the right sums and the wrong form; an equilibrium of another density the right form
    low = np.array([low_speed_equilibrium(model, d, u) for d, u in zip(*asked, strict=True)])
    sums, form = deviation_from_equilibrium(model, low, asked)
    assert sums < 1e-15
    assert form > 1e-6
    sums, form = deviation_from_equilibrium(model, fermi_dirac(model, asked.density * 1.001, asked.velocity), asked)
    assert sums > 1e-5
    assert form < 1e-15


def test_numbers_of_cells() -> None:
    initial = Occupations(
        kind="occupations", density=0.4, cells=2, waves=(Wave(of="density", amplitude=0.2, mode=(0.5, 0.0)),), seed=0
    )
    # densities 0.6, 0.4 and 0.2 from the first cell to the last, 16 channels a cell
    assert numbers_of_cells("hpp", 4, 6, initial).tolist() == [[10, 6, 3], [10, 6, 3]]
    with pytest.raises(ValueError, match="no numbers of cells"):
        numbers_of_cells("hpp", 4, 6, Occupations(kind="occupations", density=0.4, seed=0))
