"""Closed forms of lattice gases against the collisions they follow from: by `lattice_models` and by `refimpl`."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.references import lattice_gas as known
from crosscheck.references.lattice_models import VELOCITIES, linearised_collision, modes
from refimpl.lattice import theory
from refimpl.lattice.models import MODELS

FHP = tuple(name for name in MODELS if name != "hpp")
densities = st.floats(0.01, 0.99)


# -- closed forms ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", MODELS)
@given(d=densities)
def test_relaxation_rate(name: str, d: float) -> None:
    c = MODELS[name].velocities.cartesian
    stress = c[:, 0] ** 2 - c[:, 1] ** 2 if name == "hpp" else c[:, 0] * c[:, 1]
    assert known.relaxation_rate(name, d) == pytest.approx(theory.relaxation_rate(MODELS[name], d, stress), rel=1e-9)


@pytest.mark.parametrize("name", FHP)
@given(d=densities)
def test_viscosities_and_galilean_factor(name: str, d: float) -> None:
    model = MODELS[name]
    # differences of nearly equal terms where a viscosity passes through zero
    near = {"rel": 1e-9, "abs": 1e-9}
    assert known.shear_viscosity(name, d) == pytest.approx(theory.shear_viscosity(model, d), **near)
    assert known.bulk_viscosity(name, d) == pytest.approx(theory.bulk_viscosity(model, d), **near)
    assert known.galilean_factor(name, d) == pytest.approx(theory.galilean_factor(model.velocities, d), **near)


@pytest.mark.parametrize("name", MODELS)
def test_speed_of_sound(name: str) -> None:
    assert known.SOUND_SPEED[name] == pytest.approx(theory.sound_speed(MODELS[name].velocities), rel=1e-15)


#: nu at d = 0.1 ... 0.6: FHP-I, II, III, and all collisions without and with the state that enters.
VISCOSITIES = {
    "fhp1": (1.01812, 0.68880, 0.68485, 0.83951, 1.20833, 2.04514),
    "fhp2": (0.39460, 0.26878, 0.29389, 0.41084, 0.67500, 1.29031),
    "fhp3": (0.31732, 0.14816, 0.09877, 0.08005, 0.07500, 0.08005),
    "fhp_saturated": (0.65968, 0.26957, 0.15445, 0.10961, 0.09722, 0.10961),
    "fhp_saturated_identity": (1.14921, 0.54849, 0.36693, 0.29503, 0.27500, 0.29503),
}


@pytest.mark.parametrize("name", FHP)
def test_table_of_viscosities(name: str) -> None:
    found = [known.shear_viscosity(name, d) for d in (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)]
    np.testing.assert_allclose(found, VISCOSITIES[name], rtol=0, atol=5.1e-6)


def test_what_there_is_not() -> None:
    with pytest.raises(ValueError, match="HPP is not isotropic and has no shear viscosity"):
        known.shear_viscosity("hpp", 0.3)
    with pytest.raises(KeyError):
        known.relaxation_rate("fhp", 0.3)


# -- against the models as they are printed ----------------------------------------------------------------------------


@pytest.mark.parametrize("name", MODELS)
@given(d=densities)
def test_relaxation_rate_is_an_eigenvalue_of_the_collisions(name: str, d: float) -> None:
    c = VELOCITIES[name].cartesian
    stress = c[:, 0] ** 2 - c[:, 1] ** 2 if name == "hpp" else c[:, 0] * c[:, 1]
    found = linearised_collision(name, np.full(len(c), d)) @ stress
    np.testing.assert_allclose(found, -known.relaxation_rate(name, d) * stress, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", MODELS)
def test_speed_of_sound_is_that_of_the_velocities(name: str) -> None:
    assert known.SOUND_SPEED[name] == pytest.approx(math.sqrt((VELOCITIES[name].cartesian ** 2).mean()), rel=1e-15)


@pytest.mark.parametrize("name", MODELS)
def test_long_sound_is_damped_by_the_longitudinal_viscosity(name: str) -> None:
    k = 2 * math.pi / (4000 * VELOCITIES[name].row_height)
    for density in (0.2, 0.5):
        damping = theory.modes(MODELS[name], density, (0.0, k)).sound_damping
        assert 2 * damping / k**2 == pytest.approx(known.longitudinal_viscosity(name, density), rel=1e-3)
        found = modes(name, density, (0.0, k))
        assert 2 * found.sound_damping / k**2 == pytest.approx(known.longitudinal_viscosity(name, density), rel=1e-3)
        assert found.sound_frequency / k == pytest.approx(known.SOUND_SPEED[name], rel=1e-5)


@pytest.mark.parametrize("name", FHP)
def test_long_shear_waves_have_the_viscosity_and_drift_with_g(name: str) -> None:
    k, u = 2 * math.pi / (4000 * VELOCITIES[name].row_height), 1e-3
    for density in (0.2, 0.4):
        found = modes(name, density, (0.0, k), (0.0, u))
        assert found.shear_decay / k**2 == pytest.approx(known.shear_viscosity(name, density), rel=1e-3)
        assert found.shear_frequency / (k * u) == pytest.approx(known.galilean_factor(name, density), rel=1e-3)
