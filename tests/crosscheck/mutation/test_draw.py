"""Mutants are drawn uniformly over lines, the same ones for the same seed."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from crosscheck.errors import UsageError
from crosscheck.mutation.draw import Population, compiled, draw, population
from crosscheck.mutation.operators import OPERATORS


def synthetic(tmp_path: Path, text: str) -> Population:
    (tmp_path / "module.py").write_text(text)
    return Population("refimpl", tmp_path, ("module.py",), OPERATORS)


def test_the_same_seed_gives_the_same_mutants() -> None:
    among = population("refimpl", ["events/rules"])
    first, second, other = draw(among, 12, 3), draw(among, 12, 3), draw(among, 12, 4)
    assert first == second
    assert first != other
    assert draw(among, 5, 3) == first[:5]
    assert len({one.after for one in first}) == 12


def test_each_line_is_as_likely_as_every_other(tmp_path: Path) -> None:
    # one line with many mutations, three with few
    among = synthetic(
        tmp_path, "def f(a, b):\n    a = (a + 1.5) * (b - 2.5) / 3.5\n    a += b\n    a += 3\n    a += 4\n"
    )
    lines = Counter(draw(among, 1, seed)[0].mutation.line for seed in range(400))
    assert set(lines) == {2, 3, 4, 5}
    assert all(60 < number < 140 for number in lines.values()), lines  # 100 each, within 4.6 standard errors


def test_what_compiles_to_the_same_is_not_drawn(tmp_path: Path) -> None:
    among = synthetic(tmp_path, '"""2"""\n\n\ndef f(a):\n    return a[0:1]\n')
    before = compiled((tmp_path / "module.py").read_text())
    assert all(compiled(one.after) != before for one in draw(among, 50, 0))
    assert compiled('"""one"""\na = 1  # b\n') == compiled('"""another"""\n\na = 1\n')
    assert compiled("a = 1\n") != compiled("a = 1.0\n")


def test_a_population_that_is_exhausted_gives_fewer(tmp_path: Path) -> None:
    assert len(draw(synthetic(tmp_path, "a = 3\n"), 10, 0)) == 2


def test_files_are_chosen_by_patterns() -> None:
    assert set(population("refimpl", ["events/kernels"]).files) < set(population("refimpl", ["events"]).files)
    assert population("refimpl", ["stepping/schemes"]).files == ("stepping/schemes.py",)
    assert population("adapters", ["lammps"]).files == population("adapters", ["engines/lammps/*"]).files
    with pytest.raises(UsageError, match=r"--module nothing: no file of refimpl matches"):
        population("refimpl", ["nothing"])
    with pytest.raises(UsageError, match="--population other: unknown; take refimpl, adapters, performance"):
        population("other")


def test_a_diff_shows_one_change() -> None:
    one = draw(population("refimpl", ["events/rules"]), 1, 0)[0]
    lines = one.diff(0).splitlines()
    assert lines[0] == "--- refimpl/events/rules.py"
    before, after = one.lines
    assert before in one.before
    assert after in one.after
    assert before != after
