"""Budgets of cells from fields that are made up."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.checks.events.fields_budget import cell_budgets, through_faces
from crosscheck.engines.protocol import Run


def test_what_comes_in_through_faces_adds_up_to_nothing_and_goes_to_the_right_cell() -> None:
    flux = np.random.default_rng(1).normal(size=(2, 4, 5))
    assert through_faces(flux).sum() == pytest.approx(0.0, abs=1e-12)
    flux = np.zeros((2, 4, 5))
    flux[0, 2, 3] = 1.0  # through the lower face along x: out of cell 1, into cell 2
    found = through_faces(flux)
    assert (found[2, 3], found[1, 3]) == (1.0, -1.0)
    assert np.count_nonzero(found) == 2


def test_cell_budgets_see_a_change_without_a_cause() -> None:
    names = ("mass", "momentum", "energy")
    shapes = {"mass": (2, 3), "momentum": (2, 3, 2), "energy": (2, 3)}
    t = {f"field_{when}_{name}": np.ones(shapes[name]) for when in ("initial", "final") for name in names}
    t |= {f"field_flux_{name}": np.zeros((2, *shapes[name])) for name in names}
    t |= {"field_mass": np.zeros((2, 3)), "field_momentum": np.zeros((2, 3, 2)), "field_dissipation": np.zeros((2, 3))}
    t |= {"field_wall_momentum": np.zeros((2, 3, 2)), "field_wall_energy": np.zeros((2, 3))}
    run = Run(t)
    assert max(cell_budgets(run, np.array([0.0, -1.0])).values()) == 0.0
    run["field_final_energy"] = t["field_final_energy"] + np.eye(2, 3) * 0.1
    assert cell_budgets(run, np.array([0.0, -1.0]))["energy"] == pytest.approx(0.1 / 1.1)
