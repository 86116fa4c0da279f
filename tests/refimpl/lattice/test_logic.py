"""Programs of collision tables, run on all rows of their truth tables at once: bit `row` of an integer each."""

from __future__ import annotations

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from refimpl.lattice.logic import Program, draws, program
from refimpl.lattice.models import MODELS
from refimpl.lattice.velocities import SQUARE

Table = tuple[tuple[int, ...], ...]
RANDOM_BITS = {"hpp": 0, "fhp1": 1, "fhp2": 1, "fhp3": 1, "fhp_saturated": 1, "fhp_saturated_identity": 2}
#: Operations of a program.
LONGEST = {"hpp": 5, "fhp1": 40, "fhp2": 200, "fhp3": 200, "fhp_saturated": 50, "fhp_saturated_identity": 65}


def evaluated(logic: Program) -> list[int]:
    """Truth tables of all values: inputs, then results."""
    rows = range(1 << logic.inputs)
    everywhere = (1 << len(rows)) - 1
    values = [sum((row >> i & 1) << row for row in rows) for i in range(logic.inputs)]
    for name, a, b in logic.operations:
        x, y = values[a], values[b]
        values.append(
            {
                "and": x & y,
                "or": x | y,
                "xor": x ^ y,
                "andnot": x & ~y & everywhere,
                "ornot": (x | ~y) & everywhere,
                "not": ~x & everywhere,
            }[name]
        )
    return values


def chosen(found: tuple[int, ...], bits: int) -> int | None:
    """What these random bits make of a state with the outcomes `found`; None: draw again."""
    used = next(n for n in range(9) if 1 << n >= len(found))
    code = bits % (1 << used)
    return found[code] if code < len(found) else None


def assert_computes(logic: Program, table: Table) -> None:
    channels = len(logic.toggles)
    values = evaluated(logic)
    assert logic.inputs == channels + logic.draws
    for row in range(1 << logic.inputs):
        state, bits = row % (1 << channels), row >> channels
        expected = chosen(table[state], bits)
        again = logic.rejected is not None and values[logic.rejected] >> row & 1 == 1
        assert again == (expected is None)
        if expected is not None:
            toggled = sum((values[t] >> row & 1) << i for i, t in enumerate(logic.toggles) if t is not None)
            assert state ^ toggled == expected


def always_toggled(table: Table, bits: int) -> bool:
    """Whether some channel changes for every state and all random bits."""
    kept = 0
    for state, found in enumerate(table):
        for r in range(1 << bits):
            after = chosen(found, r)
            kept |= ~((state if after is None else after) ^ state)
    return kept & (len(table) - 1) != len(table) - 1


@pytest.mark.parametrize("name", MODELS)
def test_the_program_of_a_model_is_its_table(name: str) -> None:
    assert_computes(program(MODELS[name].outcomes), MODELS[name].outcomes)


@pytest.mark.parametrize("name", MODELS)
def test_random_bits_number_the_outcomes(name: str) -> None:
    logic, bits = program(MODELS[name].outcomes), RANDOM_BITS[name]
    assert logic.draws == draws(MODELS[name].outcomes) == bits
    # three outcomes are the only number here that is no power of two
    assert (logic.rejected is not None) == (name == "fhp_saturated_identity")


@st.composite
def tables(draw: st.DrawFn) -> Table:
    """Any number of outcomes up to five, each set of them a permutation."""
    channels = draw(st.integers(2, 4))
    states = range(1 << channels)
    permutations = draw(st.lists(st.permutations(states), min_size=1, max_size=5 if channels < 4 else 3))
    numbers = draw(st.lists(st.integers(1, len(permutations)), min_size=len(states), max_size=len(states)))
    return tuple(tuple(p[s] for p in permutations[:n]) for s, n in zip(states, numbers, strict=True))


@settings(max_examples=30)
@given(table=tables())
def test_the_program_of_any_table_is_the_table(table: Table) -> None:
    assume(not always_toggled(table, draws(table)))
    assert_computes(program(table), table)


@settings(max_examples=15)
@given(table=st.permutations(range(32)))
def test_the_program_of_any_permutation_is_the_permutation(table: list[int]) -> None:
    outcomes = tuple((state,) for state in table)
    assume(not always_toggled(outcomes, 0))
    assert_computes(program(outcomes), outcomes)


def test_what_never_changes_needs_no_operation() -> None:
    assert program(tuple((s,) for s in range(16))) == Program(4, 0, (), (None,) * 4, None)


@pytest.mark.parametrize("name", MODELS)
def test_programs_are_short(name: str) -> None:
    assert len(program(MODELS[name].outcomes).operations) <= LONGEST[name]


@pytest.mark.parametrize("channel", range(SQUARE.channels))
def test_a_channel_that_every_state_toggles(channel: int) -> None:
    with pytest.raises(ValueError, match="toggles a channel of every state conserves nothing"):
        program(tuple((s ^ 1 << channel,) for s in range(SQUARE.states)))
