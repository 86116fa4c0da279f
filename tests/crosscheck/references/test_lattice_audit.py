"""Lattices in the plane by coordinates: by hand, and beside the shifts and masks of `refimpl`."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lattice_gases import table_of

from crosscheck.references.lattice_audit import (
    Lattice,
    Motion,
    coins,
    forbidden,
    mean_step,
    motion,
    numbers,
    outcomes,
    push,
    pushable,
    pushes,
    reflection,
    velocities,
)
from crosscheck.references.lattice_models import MODELS, VELOCITIES, momenta, states
from crosscheck.scene import LatticeGas, Obstacle, Occupations, Scene
from refimpl.lattice import gas as rules
from refimpl.lattice.boltzmann import BoltzmannLattice
from refimpl.lattice.gas import Forcing
from refimpl.lattice.models import MODELS as TABLES
from refimpl.lattice.plain import PlainGas

every_model = pytest.mark.parametrize("model", MODELS)
RULES = ("bounce_back", "specular_x", "specular_y", "diffusive_x", "diffusive_y")


def lattices(model: str) -> st.SearchStrategy[tuple[int, int]]:
    rows = st.integers(1, 4) if model == "hpp" else st.integers(1, 3).map(lambda half: 2 * half)
    return st.tuples(rows, st.integers(1, 70))


# -- by hand -----------------------------------------------------------------------------------------------------------


@every_model
def test_velocities_are_those_of_the_models(model: str) -> None:
    np.testing.assert_allclose(velocities(model), VELOCITIES[model].cartesian, atol=1e-15)


@pytest.mark.parametrize(
    ("channel", "place", "arrives"),
    # (row, column) on 4 rows of 5: odd rows lie half a link to the right
    [
        (0, (0, 4), (0, 0)),
        (1, (0, 2), (1, 2)),
        (1, (1, 4), (2, 0)),
        (2, (0, 0), (1, 4)),
        (2, (1, 2), (2, 2)),
        (3, (3, 0), (3, 4)),
        (4, (0, 0), (3, 4)),
        (4, (1, 2), (0, 2)),
        (5, (0, 4), (3, 4)),
        (5, (3, 4), (2, 0)),
        (6, (3, 4), (3, 4)),
    ],
)
def test_where_a_particle_arrives(channel: int, place: tuple[int, int], arrives: tuple[int, int]) -> None:
    n = np.zeros((4, 5, 7))
    n[(*place, channel)] = 1
    found = Lattice("fhp3", 4, 5).arrivals(n)
    assert np.argwhere(found).tolist() == [[*arrives, channel]]


def test_rows_that_do_not_fit_leave_particles_between_sites() -> None:
    with pytest.raises(ValueError, match="3 x 5 sites of fhp1: a particle arrives between sites"):
        Lattice("fhp1", 3, 5)


def test_states_of_walls() -> None:
    """A particle along 60 degrees, channel 1: back to 4; mirrored to 2 or 5."""
    going = {rule: np.flatnonzero(reflection("fhp1", rule)[1 << 1]).tolist() for rule in RULES}
    assert going["bounce_back"] == [1 << 4]
    assert going["specular_x"] == [1 << 2]
    assert going["specular_y"] == [1 << 5]
    assert going["diffusive_x"] == [1 << 2, 1 << 4]
    assert going["diffusive_y"] == [1 << 4, 1 << 5]


# -- laws --------------------------------------------------------------------------------------------------------------


@every_model
@pytest.mark.parametrize("force", [None, 0.0, 0.3, -0.3, 1.0, -1.0])
@pytest.mark.parametrize("rule", ["", *RULES])
def test_probabilities(model: str, rule: str, force: float | None) -> None:
    found = outcomes(model, rule, force)
    np.testing.assert_allclose(found.sum(axis=1), 1, rtol=1e-15)
    bits = states(model)
    np.testing.assert_allclose(found @ bits.sum(axis=1), bits.sum(axis=1), rtol=1e-14)
    if not rule:
        gained = found @ momenta(model, bits) - momenta(model, bits)
        unit = VELOCITIES[model].unit[0]
        given_ = 2 * (force or 0.0) * pushable(model, force or 1.0) / unit
        np.testing.assert_allclose(gained, np.column_stack([given_, np.zeros(len(bits))]), atol=1e-13)


@every_model
def test_a_reversal_undoes_a_step_of_walls(model: str) -> None:
    """Another reflection, and all velocities reversed."""
    back = reflection(model, "bounce_back")
    np.testing.assert_array_equal(outcomes(model, "specular_y", None, reversed_after=True), back)


# -- beside refimpl ----------------------------------------------------------------------------------------------------


@every_model
def test_collisions_are_those_of_the_tables(model: str) -> None:
    np.testing.assert_allclose(outcomes(model, "", None), table_of(TABLES[model]), rtol=1e-15)


@given(model=st.sampled_from(MODELS), data=st.data())
def test_a_single_particle_arrives_where_refimpl_moves_it(model: str, data: st.DataObject) -> None:
    rows, columns = data.draw(lattices(model))
    row, column = data.draw(st.integers(0, rows - 1)), data.draw(st.integers(0, columns - 1))
    channel = data.draw(st.integers(0, len(velocities(model)) - 1))
    sites = np.zeros((rows, columns), dtype=np.uint8)
    sites[row, column] = 1 << channel
    gas = PlainGas(TABLES[model], sites)
    gas.advance(1)
    n = np.zeros((rows, columns, len(velocities(model))))
    n[row, column, channel] = 1
    np.testing.assert_array_equal(numbers(Lattice(model, rows, columns).arrivals(n)), gas.sites)


OBSTACLES = (
    Obstacle(rows=(0, 0), rule="diffusive_y"),
    Obstacle(columns=(2, 3), rows=(0, 2), rule="specular_x"),
    Obstacle(centre=(5.3, 2.0), radius=1.5),
    Obstacle(sites=((0, 0), (8, 3)), rule="specular_y"),
    Obstacle(columns=(10, 10), rule="diffusive_x"),
)


@every_model
def test_a_gas_among_walls_and_its_mean_occupations(model: str) -> None:
    lattice = Lattice(model, 4, 12)
    scene = Scene(
        name="walls",
        dimension=2,
        duration=1,
        lattice_gas=LatticeGas(model=model, rows=4, columns=12, obstacles=OBSTACLES),
        initial=Occupations(kind="occupations", density=0.5, seed=1),
    )
    walls, codes = lattice.walls(OBSTACLES), scene.wall_rules()
    assert codes is not None
    for rule in ("", *RULES):
        np.testing.assert_array_equal(walls == rule, codes == (getattr(rules, rule.upper()) if rule else 0))
    table = TABLES[model]
    forcing = Forcing(table.velocities.image(-1, 1)[0], 0.3)
    gas = PlainGas(table, scene.initial_sites(), walls=codes, forcing=forcing, seed=1)
    frames, turned = [gas.sites], [gas.impulses.copy()]
    for _ in range(20):
        gas.advance(1)
        frames.append(gas.sites)
        turned.append(gas.impulses.copy())
    trajectory = (np.array(frames)[..., None] >> np.arange(table.channels) & 1).astype(float)
    found = motion(lattice, trajectory)
    assert forbidden(lattice, walls, -0.3, found) == (0, "")
    assert forbidden(lattice, walls, 0.3, found).number > 0
    np.testing.assert_array_equal(pushes(lattice, walls, -0.3, found).after.sum(axis=2), np.diff(turned, axis=0))
    tossed = coins(lattice, walls, found)
    assert (tossed.after <= tossed.arrived).all()
    if model != "hpp":  # in whose empty walls nothing moves along them
        assert 0 < tossed.after.sum() < tossed.arrived.sum()

    f = np.random.default_rng(1).random((4, 12, table.channels))
    mean = BoltzmannLattice(table, f, walls=codes, forcing=forcing)
    mean.advance(1)
    np.testing.assert_allclose(mean_step(lattice, walls, -0.3, f), mean.f, rtol=0, atol=1e-14)


def test_what_no_rule_allows_is_named() -> None:
    lattice = Lattice("fhp1", 2, 3)
    arrived = np.zeros((1, 2, 3), dtype=np.int64)
    after = arrived.copy()
    arrived[0, 1, 2] = after[0, 1, 2] = 0b001001  # a head-on pair that passes
    after[0, 0, 0] = 1  # a particle from nowhere
    found = forbidden(lattice, lattice.walls(()), None, Motion(arrived, after))
    assert found == (2, "step 1, column 0, row 0 (fluid): arrived no particle, left with channels 0")
    after[0, 0, 0] = 0
    assert (
        "column 2, row 1 (fluid): arrived channels 0 3"
        in forbidden(lattice, lattice.walls(()), None, Motion(arrived, after)).first
    )


@pytest.mark.parametrize("model", ["hpp", "fhp3"])
def test_a_force_of_certainty_turns_all(model: str) -> None:
    found = push(model, 1.0)
    able = pushable(model, 1.0)
    assert set(np.unique(found)) == {0.0, 1.0}
    np.testing.assert_array_equal(np.diag(found) == 0, able)
