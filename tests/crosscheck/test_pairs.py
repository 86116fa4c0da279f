from itertools import combinations

from hypothesis import given
from hypothesis import strategies as st

from crosscheck.pairs import covering, pairs_of

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
    rows, never = covering(factors, (lambda row: (row[first], row[second]) != (a, b),), seed)
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


def test_a_pair_that_needs_a_chain_of_other_levels_is_found() -> None:
    factors = {"a": ("no", "yes"), "b": ("no", "yes"), "c": ("no", "yes"), "d": ("no", "yes"), "e": ("no", "yes")}

    def chain(row: dict[str, str]) -> bool:
        return all(row[one] == "no" or row[other] == "yes" for one, other in ("ab", "bc", "cd"))

    rows, never = covering(factors, (chain,))
    assert all(map(chain, rows))
    assert (("a", "yes"), ("e", "yes")) in set().union(*map(pairs_of, rows))
    assert never == {((one, "yes"), (other, "no")) for one, other in ("ab", "ac", "ad", "bc", "bd", "cd")}
