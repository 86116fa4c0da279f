"""Which engines are asked for the energy of an elastic gas."""

from __future__ import annotations

import pytest

from crosscheck.checks.granular.restitution_limits import CHECKS
from crosscheck.engines.registry import engine_class
from crosscheck.runner import judging


@pytest.mark.parametrize(("engine", "judged"), [("refimpl", True), ("lammps", False)])
def test_the_gas_is_judged_where_potential_energy_is_declared(engine: str, judged: bool) -> None:
    names = [variant.name for variant in judging(CHECKS[0], engine, engine_class(engine))]
    assert names == ["towards-1", "towards-0", "zero"] + (["elastic-gas"] if judged else [])


def test_an_engine_without_soft_contacts_is_not_judged() -> None:
    assert judging(CHECKS[0], "rebound", engine_class("rebound")) == ()
