"""Velocity sets and collision tables by enumeration, in integers and fractions: nothing here is to within a tolerance.

The thesis is that of the suite's lattice-gas experiments (1991); its appendix D compares momenta summed from cosines.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from refimpl.lattice.models import MODELS, Model, build
from refimpl.lattice.velocities import SQUARE, TRIANGULAR, TRIANGULAR_REST, VelocitySet

SETS = {"square": SQUARE, "triangular": TRIANGULAR, "triangular with rest": TRIANGULAR_REST}
every_model = pytest.mark.parametrize("model", MODELS.values(), ids=MODELS.keys())
every_set = pytest.mark.parametrize("velocities", SETS.values(), ids=SETS.keys())


def probability(model: Model, s: int, t: int) -> Fraction:
    """A(s -> t)."""
    return Fraction(model.outcomes[s].count(t), len(model.outcomes[s]))


def isometries(velocities: VelocitySet) -> set[tuple[int, ...]]:
    """Point group of the lattice, as permutations of the channels: of a turn by one link, and of a reflection."""
    movers = velocities.channels - len(velocities.rest)
    turn = (*((i + 1) % movers for i in range(movers)), *velocities.rest)
    group = fresh = {tuple(range(velocities.channels))}
    while fresh:
        fresh = {tuple(g[i] for i in p) for p in fresh for g in (turn, velocities.image(1, -1))} - group
        group = group | fresh
    return group


def permuted(state: int, channels: tuple[int, ...]) -> int:
    """The state whose channel channels[i] holds what channel i held."""
    return sum((state >> i & 1) << j for i, j in enumerate(channels))


def occupations(state: int, channels: int) -> list[int]:
    return [state >> i & 1 for i in range(channels)]


def changes(model: Model) -> np.ndarray:
    """s' - s of all that can happen, (n, b)."""
    found = [
        np.subtract(occupations(t, model.channels), occupations(s, model.channels))
        for s in model.active
        for t in model.outcomes[s]
    ]
    return np.array(found)


# -- velocities --------------------------------------------------------------------------------------------------------


@every_set
def test_velocities_are_opposite_in_pairs_and_distinct(velocities: VelocitySet) -> None:
    assert len(set(velocities.integers)) == velocities.channels
    assert {(-a, -b) for a, b in velocities.integers} == set(velocities.integers)
    assert velocities.states == 2**velocities.channels


def test_velocities_go_round_counter_clockwise() -> None:
    for velocities, movers in ((SQUARE, 4), (TRIANGULAR, 6), (TRIANGULAR_REST, 6)):
        angles = 2 * np.pi * np.arange(movers) / movers
        links = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        np.testing.assert_allclose(velocities.cartesian[:movers], links, atol=1e-15)
        np.testing.assert_array_equal(velocities.cartesian[movers:], 0)
        assert velocities.rest == tuple(range(movers, velocities.channels))


@every_set
def test_columns_follow_positions(velocities: VelocitySet) -> None:
    """A site plus c_i is the site arrived at, in the integers of the set: x is 2 column + row mod 2 with half rows."""

    def place(row: int, column: int) -> tuple[int, int]:
        return (2 * column + row % 2, row) if velocities.half_rows else (column, row)

    for row, (i, (a, b)) in product(range(-3, 4), enumerate(velocities.integers)):
        x, y = place(row - b, 5 - velocities.column_shift(i, row))
        assert (x + a, y + b) == place(row, 5)


@pytest.mark.parametrize(("velocities", "order"), [(SQUARE, 8), (TRIANGULAR, 12), (TRIANGULAR_REST, 12)])
def test_isometries_are_the_point_group(velocities: VelocitySet, order: int) -> None:
    group = isometries(velocities)
    assert len(group) == order
    assert all(tuple(p[i] for i in q) in group for p in group for q in group)
    c = np.array(velocities.integers) * ((1, 1) if velocities is SQUARE else (1, 3))
    products = np.array(velocities.integers) @ c.T
    for p in group:
        np.testing.assert_array_equal(products[np.ix_(p, p)], products)
    assert {velocities.image(sx, sy) for sx in (1, -1) for sy in (1, -1)} <= group


@every_set
def test_images_reverse_components(velocities: VelocitySet) -> None:
    for sx, sy in product((1, -1), repeat=2):
        image = velocities.image(sx, sy)
        assert [velocities.integers[i] for i in image] == [(sx * a, sy * b) for a, b in velocities.integers]


def test_a_permutation_of_a_state() -> None:
    assert permuted(0b0011, (1, 2, 3, 0)) == 0b0110
    for velocities in SETS.values():
        for p, s in product(isometries(velocities), range(velocities.states)):
            turned = permuted(s, p)
            assert occupations(s, velocities.channels) == [turned >> j & 1 for j in p]


# -- what every table keeps --------------------------------------------------------------------------------------------


@every_model
def test_mass_and_momentum_are_conserved(model: Model) -> None:
    for s, found in enumerate(model.outcomes):
        for t in found:
            assert model.velocities.mass(t) == model.velocities.mass(s)
            assert model.velocities.momentum(t) == model.velocities.momentum(s)


@every_model
def test_probabilities_and_semi_detailed_balance(model: Model) -> None:
    states = range(model.velocities.states)
    table = [[probability(model, s, t) for t in states] for s in states]
    assert all(sum(row) == 1 for row in table)
    assert all(sum(column) == 1 for column in zip(*table, strict=True))
    # these tables have more: detailed balance
    assert all(table[s][t] == table[t][s] for s in states for t in range(s))


@every_model
def test_tables_are_invariant_under_isometries(model: Model) -> None:
    for p in isometries(model.velocities):
        for s, found in enumerate(model.outcomes):
            assert sorted(permuted(t, p) for t in found) == sorted(model.outcomes[permuted(s, p)])


#: (active states, whether particles and holes follow the same rules)
KNOWN = {
    "hpp": (2, True),
    "fhp1": (5, False),
    "fhp2": (22, False),
    "fhp3": (76, True),
    "fhp_saturated": (20, True),
    "fhp_saturated_identity": (20, True),
}


@pytest.mark.parametrize("name", MODELS)
def test_particle_hole_duality(name: str) -> None:
    model = MODELS[name]
    full = model.velocities.states - 1
    same = [
        sorted(full ^ t for t in found) == sorted(model.outcomes[full ^ s]) for s, found in enumerate(model.outcomes)
    ]
    assert all(same) == KNOWN[name][1]


@every_model
def test_collisions_keep_nothing_else_that_is_a_sum_over_particles(model: Model) -> None:
    """Thesis (3.8): the solutions of sum_i (s'_i - s_i) a_i = 0 are spanned by 1, c_x, c_y."""
    assert np.linalg.matrix_rank(changes(model)) == model.channels - 3
    kept = np.array([(1, *c) for c in model.velocities.integers])
    assert np.linalg.matrix_rank(kept) == 3
    assert not (changes(model) @ kept).any()


# -- the single tables -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", MODELS)
def test_number_of_active_states(name: str) -> None:
    assert len(MODELS[name].active) == KNOWN[name][0]


def test_hpp_is_deterministic_and_its_own_inverse() -> None:
    hpp = MODELS["hpp"]
    assert hpp.deterministic
    assert not any(model.deterministic for model in MODELS.values() if model is not hpp)
    after = [t for (t,) in hpp.outcomes]
    assert [after[t] for t in after] == list(range(16))
    assert {s: after[s] for s in hpp.active} == {0b0101: 0b1010, 0b1010: 0b0101}


def test_fhp1_turns_pairs_and_triples() -> None:
    fhp1 = MODELS["fhp1"]
    expected = {9: {18, 36}, 18: {9, 36}, 36: {9, 18}, 21: {42}, 42: {21}}
    assert {s: set(fhp1.outcomes[s]) for s in fhp1.active} == expected
    assert all(len(set(found)) == len(found) for model in MODELS.values() for found in model.outcomes)


def test_fhp2_adds_spectators_and_the_resting_particle() -> None:
    fhp1, fhp2 = MODELS["fhp1"], MODELS["fhp2"]
    rest = 1 << 6
    expected = {s: set(fhp1.outcomes[s]) for s in fhp1.active}
    expected |= {s | rest: {t | rest for t in fhp1.outcomes[s]} for s in fhp1.active}
    for i in range(6):
        one, two = rest | 1 << i, 1 << (i + 1) % 6 | 1 << (i - 1) % 6
        expected |= {one: {two}, two: {one}}
    assert {s: set(fhp2.outcomes[s]) for s in fhp2.active} == expected


def test_fhp3_exchanges_the_resting_particle_only_with_momentum() -> None:
    fhp3 = MODELS["fhp3"]
    for s in fhp3.active:
        for t in fhp3.outcomes[s]:
            assert fhp3.velocities.momentum(s) != (0, 0) or s >> 6 == t >> 6


@pytest.mark.parametrize("name", ["fhp_saturated", "fhp_saturated_identity"])
def test_classes_of_the_saturated_table(name: str) -> None:
    model = MODELS[name]
    classes = {frozenset((s, *model.outcomes[s])) for s in model.active}
    assert classes == {
        frozenset(members)
        for members in (
            (9, 18, 36),
            (27, 45, 54),
            (21, 42),
            (11, 38),
            (13, 22),
            (19, 37),
            (25, 52),
            (26, 44),
            (41, 50),
        )
    }
    includes = name == "fhp_saturated_identity"
    assert all((s in model.outcomes[s]) == includes for s in model.active)
    assert probability(model, 9, 18) == (Fraction(1, 3) if includes else Fraction(1, 2))
    assert probability(model, 1, 1) == 1


def test_a_label_restricts_collisions() -> None:
    frozen = build("frozen", TRIANGULAR, lambda velocities, state: state)
    assert frozen.active == ()
    assert frozen.deterministic


@pytest.mark.parametrize(
    ("angles", "sums", "found"),
    [(np.float64, np.float64, 0), (np.float64, np.float32, 22), (np.float32, np.float32, 0)],
)
def test_momenta_in_floats_find_too_few_collisions(
    angles: type[np.floating], sums: type[np.floating], found: int
) -> None:
    """Thesis, appendix D, taken literally: cosines and sines are summed and compared with "=".

    Single precision hides the round-off of the cosines if they come from double, and only then, in most cases.
    """
    exact = MODELS["fhp_saturated"]
    assert sum(len(exact.outcomes[s]) for s in exact.active) == 26
    turns = [angles(2 * np.pi * i / 6) for i in range(6)]

    def literal(state: int) -> tuple[int, np.floating, np.floating]:
        px = py = sums(0)
        for i, turn in enumerate(turns):
            if state >> i & 1:
                px, py = px + sums(np.cos(turn)), py + sums(np.sin(turn))
        return state.bit_count(), px, py

    logic = [literal(s) for s in range(64)]
    assert sum(logic[s] == logic[t] for s, t in product(range(64), repeat=2) if s != t) == found
