"""What the cases consist of: the table is complete, fresh, and read as it was written."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.budget import counting, loads
from crosscheck.budget.loads import CaseLoad, Load
from crosscheck.engines.refimpl import RefimplEngine
from crosscheck.engines.workers.pool import Pool

#: Of each kind of scheme and interaction, cases that take a fraction of a second, and one that names another engine.
SAMPLE = (
    "events/audit-samples/small-2d",
    "events/ideal-gas/n0.05-N64",
    "granular/few-steps/duration",
    "lattice/audit/rows-1",
    "stepping/gravity-steps/velocity_verlet",
    "stepping/lennard-jones-steps/velocity_verlet",
    "stepping/lennard-jones-trajectory/against-lammps",
    "stepping/restart-gravity/schemes",
)


def test_each_case_was_counted_and_nothing_else() -> None:
    names = {case.name for case in counting.cases()}
    assert sorted(names - set(loads.table())) == [], "count them: python -m crosscheck.budget PATTERN ..."
    assert sorted(set(loads.table()) - names) == [], "these do not exist any more: python -m crosscheck.budget"


def test_the_file_is_sorted_and_each_line_comes_back() -> None:
    path = Path(loads.__file__).with_name(loads.FILE)
    lines = path.read_text(encoding="utf-8").splitlines()
    names = [loads.as_case(line)[0] for line in lines]
    assert names == sorted(set(names))
    assert [loads.as_line(*loads.as_case(line)) for line in lines] == lines


@pytest.fixture(scope="module")
def pool() -> Iterator[Pool]:
    pool = Pool(time_limit=300)
    yield pool
    pool.close()


@pytest.mark.parametrize("name", SAMPLE)
def test_the_table_is_fresh(name: str, pool: Pool) -> None:
    """A check that was changed must be counted again."""
    (case,) = counting.cases([name])
    found, known = counting.counted(case, pool), loads.table()[name]
    assert found is not None
    assert [one._replace(units=0) for one in found.loads] == [one._replace(units=0) for one in known.loads]
    for one, other in zip(found.loads, known.loads, strict=True):
        # collisions of a chaotic run differ from processor to processor
        assert one.units == pytest.approx(other.units, rel=0.2 if one.kind == "event_driven" else 0.0)


def test_a_check_that_runs_another_engine_first_is_not_charged_for_that() -> None:
    """The melt is refimpl's, which is also the engine that the case was counted with."""
    (load,) = loads.table()["stepping/lennard-jones-equation-of-state/rho0.3-T2.5-N108"].loads
    assert (load.runs, load.units) == (1, 8001)


def test_a_case_that_was_not_counted_is_as_large_as_the_largest_of_its_check() -> None:
    table = loads.table()
    largest = max(
        (name for name in table if name.startswith("events/ideal-gas/")), key=lambda n: table[n].loads[0].units
    )
    assert loads.load_of("events/ideal-gas", "of-another-version") == table[largest]
    assert loads.load_of("events/unheard-of", "x") is None


@given(st.integers(0, 2**24))
def test_sizes_are_told_apart_by_a_quarter_of_an_octave(size: int) -> None:
    rounded = loads.rounded_size(size)
    assert rounded in loads.SIZES
    assert max(rounded, size, 1) / min(rounded, max(size, 1)) <= 2**0.25


@given(st.integers(1, 10))
def test_an_engine_with_fewer_schemes_does_a_share(schemes: int) -> None:
    load = Load("hard_spheres", "event_driven", 64, schemes, 1, 100)
    assert loads.share(load, RefimplEngine) == min(1.0, 5 / schemes)
    assert loads.classes([load, load]) == {("hard_spheres", "event_driven")}


def test_counting_again_changes_what_was_asked_for_alone(tmp_path: Path) -> None:
    path = tmp_path / loads.FILE
    name = "stepping/lennard-jones-steps/velocity_verlet"
    known = loads.table()[name]
    kept = loads.as_line("events/ideal-gas/n0.05", loads.table()["events/ideal-gas/n0.05"])
    slow = loads.as_line(name, known._replace(elsewhere=77.0))
    gone = loads.as_line("events/gone/x", CaseLoad("refimpl", (), 1.0))
    path.write_text(f"{kept}\n{gone}\n{slow}\n", encoding="utf-8")
    (told,) = counting.count(path, [name])
    # what depends on the machine stays where the rest is the same
    assert path.read_text(encoding="utf-8").splitlines() == [kept, slow]
    assert told == slow
