from itertools import combinations

from hypothesis import given
from hypothesis import strategies as st

from crosscheck.pairs import Row, covering, pairs_of

FACTORS = st.dictionaries(
    st.sampled_from("abcdef"), st.lists(st.sampled_from("uvwx"), min_size=1, max_size=4, unique=True), min_size=2
)


@given(FACTORS, st.integers(0, 9))
def test_every_pair_of_levels_occurs(factors: dict[str, list[str]], seed: int) -> None:
    rows, never = covering(factors, seed=seed)
    found = set().union(*map(pairs_of, rows))
    assert not never
    assert found == {((p, a), (q, b)) for p, q in combinations(factors, 2) for a in factors[p] for b in factors[q]}


@given(FACTORS, st.integers(0, 9))
def test_no_row_is_invalid_and_what_is_left_out_is_named(factors: dict[str, list[str]], seed: int) -> None:
    first, second = list(factors)[:2]
    a, b = factors[first][-1], factors[second][-1]
    rows, never = covering(factors, lambda row: (row[first], row[second]) != (a, b), seed)
    assert ((first, a), (second, b)) in never
    assert all((row[first], row[second]) != (a, b) for row in rows)
    others = [pair for row in rows for pair in pairs_of(row)]
    every = {((p, x), (q, y)) for p, q in combinations(factors, 2) for x in factors[p] for y in factors[q]}
    assert set(others) | never == every


def test_the_rows_are_few_and_always_the_same() -> None:
    factors = dict.fromkeys("abcdefgh", ("no", "yes", "twice"))
    rows, _ = covering(factors)
    assert len(rows) <= 20  # nine at least, for the pairs of two factors
    assert rows == covering(factors)[0]


def test_factors_that_need_each_other_start_from_bases() -> None:
    factors = {
        "walls": ("none", "hard"),
        "friction": ("none", "grains"),
        "rough wall": ("no", "yes"),
        "side": ("-", "+"),
    }

    def valid(row: Row) -> bool:
        rough = row["rough wall"] == "no" or (row["walls"] == "hard" and row["friction"] == "grains")
        return rough and (row["side"] == "-" or row["walls"] == "hard")

    bases = ({}, {"walls": "hard"}, {"walls": "hard", "friction": "grains"})
    rows, never = covering(factors, valid, bases=bases)
    assert all(map(valid, rows))
    assert (("rough wall", "yes"), ("side", "+")) in set().union(*map(pairs_of, rows))
    assert never == {
        (("walls", "none"), ("rough wall", "yes")),
        (("friction", "none"), ("rough wall", "yes")),
        (("walls", "none"), ("side", "+")),
    }
