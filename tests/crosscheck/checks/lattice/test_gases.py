"""Starting states, names of variants and schemes that the checks of lattice gases share."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from crosscheck.checks.base import Laboratory
from crosscheck.checks.lattice.gases import (
    State,
    at_densities,
    away,
    boltzmann_method,
    gas_scene,
    methods_for,
    started,
)
from crosscheck.engines.registry import engine_class
from crosscheck.errors import Unsupported
from crosscheck.references.lattice_models import MODELS, VELOCITIES, fermi_dirac
from crosscheck.scene import Method, Obstacle, Occupations, Output

START = Occupations(kind="occupations", density=0.3, seed=1)

# -- starting states ---------------------------------------------------------------------------------------------------


@given(data=st.data())
def test_occupations_away_from_equilibrium(data: st.DataObject) -> None:
    name = data.draw(st.sampled_from(MODELS))
    velocities = VELOCITIES[name]
    f = data.draw(arrays(np.float64, velocities.channels, elements=st.floats(0.01, 0.99)))
    moved = away(name, f)
    assert (moved >= 0).all()
    assert (moved <= 1).all()
    charges = np.vstack([np.ones(velocities.channels), velocities.cartesian.T])
    np.testing.assert_allclose(charges @ moved, charges @ f, atol=1e-13)
    # twice as far, one channel is empty or full
    twice = 2 * moved - f
    np.testing.assert_allclose(np.minimum(twice, 1 - twice).min(), 0, atol=1e-12)


# -- names, scenes and schemes -----------------------------------------------------------------------------------------


def test_names_of_variants() -> None:
    variants = at_densities(("hpp", "fhp1"), (0.1, 0.25))
    assert tuple(one.name for one in variants) == ("hpp-d0.1", "hpp-d0.25", "fhp1-d0.1", "fhp1-d0.25")
    assert {one.tier for one in variants} == {"full"}


@given(name=st.sampled_from(MODELS), density=st.integers(1, 99).map(lambda percent: percent / 100))
def test_variants_hold_their_states(name: str, density: float) -> None:
    (variant,) = at_densities((name,), (density,))
    assert variant.value == State(name, density)
    model, number = variant.name.rsplit("-d", 1)
    assert (model, float(number)) == (name, density)


def test_rows_and_columns_of_a_scene() -> None:
    scene = gas_scene("gas", "hpp", 3, 5, 7, START, Output(), force=0.1)
    assert scene.initial_sites().shape == (3, 5)
    assert (scene.duration, scene.lattice_gas.force) == (7, 0.1)


def test_schemes_that_a_scene_can_be_given_to() -> None:
    """Those that count particles; of an engine without lattice gases, none."""
    walls = (Obstacle(rows=(0, 0)),)
    output = Output(interval=1, observables=("force_impulse",))
    scene = gas_scene("gas", "hpp", 4, 4, 1, START, output, force=0.1, obstacles=walls)
    expected = [Method(scheme=f"lattice_{name}") for name in ("planes", "lookup", "numpy")]
    assert methods_for("refimpl", scene) == expected
    assert methods_for("ase", scene) == []


def test_the_scheme_that_moves_mean_occupations() -> None:
    def laboratory(engine: str) -> Laboratory:
        return Laboratory(engine, dict(engine_class(engine).schemes), None, "case")  # type: ignore[arg-type]

    assert boltzmann_method(laboratory("refimpl")) == Method(scheme="lattice_boltzmann")
    with pytest.raises(Unsupported, match="ase: no lattice scheme with h_function"):
        boltzmann_method(laboratory("ase"))


def test_what_a_gas_starts_with_is_seen_to_be_wrong() -> None:
    """Independent channels of the occupations asked for pass; a momentum that is too large does not."""
    sites, f = 128**2, fermi_dirac("fhp2", 0.3, (0.2, 0.1))
    drawn = (np.random.default_rng(3).random((sites, f.size)) < f).mean(axis=0)
    right = started(drawn, f, "fhp2", sites)
    assert [one.outcome for one in right.judgements] == ["pass"] * 3
    wrong = started(drawn, fermi_dirac("fhp2", 0.3, (0.17, 0.1)), "fhp2", sites)
    assert [one.outcome for one in wrong.judgements] == ["pass", "fail", "pass"]
