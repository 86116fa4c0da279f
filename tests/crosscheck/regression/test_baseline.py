"""The file of what is known: what is written is read back, lines merge, and what is no line is said with its number."""

from __future__ import annotations

import subprocess
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
import synthetic
from hypothesis import given
from hypothesis import strategies as st
from two_results import ENGINE, KEY, bound, by_tolerance, judged, results, statistical

from crosscheck.errors import UsageError
from crosscheck.record import read
from crosscheck.regression.baseline import (
    FORM,
    Baseline,
    accept,
    is_baseline,
    lines_of,
    read_baseline,
    same_text,
    text_of,
)
from crosscheck.regression.change import change
from crosscheck.regression.results import Case, Number, Results, of_lines
from crosscheck.text import printable


@pytest.fixture
def run(tmp_path: Path) -> Results:
    return of_lines(read(synthetic.write(tmp_path / "run")), "run")


def written(directory: Path, text: str) -> Path:
    path = directory / "baseline.txt"
    path.write_text(text, encoding="utf-8", newline="\n")
    return path


def again(directory: Path, run: Results) -> Baseline:
    """A baseline of a run, written and read."""
    return read_baseline(written(directory, accept(None, run, run.cases).text))


# -- text -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("number", "line"),
    [
        (
            statistical(1.0960359, 0.00019025, expected=1.0963568, freedom=11),
            "pass\t1.09604(19)\t1.096357\tstatistical 11",
        ),
        (
            statistical(2.00347, 0.00985, expected=1.9996, expected_uncertainty=0.00065, freedom=23),
            "pass\t2.0035(98)\t1.99960(65)\tstatistical 23",
        ),
        (statistical(2.5, 0.0, expected=2.25, freedom=None), "pass\t2.5\t2.25\tstatistical"),
        (by_tolerance(4.4e-16, tolerance=2.2e-12, kind="round_off"), "pass\t0\t0\tround_off 2.2e-12"),
        (by_tolerance(2e-3, "fail", 2.2e-12, "round_off"), "fail\t0.002\t0\tround_off 2.2e-12"),
        (by_tolerance(3.01234, "fail", 0.25), "fail\t3.012\t0\torder 0.25"),
        (by_tolerance(None, "fail", 0.25), "fail\tnot finite\t0\torder 0.25"),
        (bound(0.0369612345, 0.99), "pass\t0.03696\t<= 0.99\tbound"),
        (bound(17.0, 3.0, sense="at_least"), "pass\t17\t>= 3\tbound"),
    ],
)
def test_a_number_has_the_digits_that_matter(number: Number, line: str) -> None:
    lines = lines_of(results(judged(x=number)))[KEY]
    assert lines == [f"a/b/c\tmine\tquick\tx\t{line}"]


def test_cases_that_are_not_judged_have_one_line_and_operations_one() -> None:
    cases = {
        ("a/b/skipped", ENGINE): Case("full", "skip", "a long reason, which may change"),
        ("a/b/broken", ENGINE): Case("quick", "error", "a trace"),
        ("a/b/counted", ENGINE): Case(
            "quick", "pass", numbers={"x": bound(1.0, 2.0)}, counters={"steps": 9, "events": 7}, refused=2
        ),
    }
    text = text_of(3, [line for lines in lines_of(Results("run", cases, 3)).values() for line in lines])
    assert text.splitlines()[1:] == [
        "a/b/broken\tmine\tquick\t-\terror",
        "a/b/counted\tmine\tquick\toperations\tcounted\tevents=7 refused=2 steps=9",
        "a/b/counted\tmine\tquick\tx\tpass\t1\t<= 2\tbound",
        "a/b/skipped\tmine\tfull\t-\tskip",
    ]
    assert text.startswith(f"# particle-crosscheck baseline, form {FORM}, seed 3; case engine tier quantity")


def test_the_same_results_give_the_same_file(run: Results, tmp_path: Path) -> None:
    """In whatever order; no time, machine or version is in it."""
    text = accept(None, run, run.cases).text
    cases = dict(reversed(list(run.cases.items())))
    assert accept(None, Results("other", cases, run.seed, provenance={"cpu": "b"}), cases).text == text
    for word in ("CPU", "numpy", "2026", "signal 11"):
        assert word not in text
    lines = text.splitlines()
    assert lines[1:] == sorted(lines[1:])


def test_what_is_written_is_read(run: Results, tmp_path: Path) -> None:
    found = again(tmp_path, run).results
    assert (found.seed, found.rounded) == (7, True)
    assert found.cases.keys() == run.cases.keys()
    for key, case in run.cases.items():
        other = found.cases[key]
        assert (other.tier, other.outcome) == (case.tier, case.outcome)
        assert other.numbers.keys() == case.numbers.keys()
        if case.judged:
            assert (other.counters, other.refused) == (case.counters, case.refused)
        assert all(same_text(one, case.numbers[name]) for name, one in other.numbers.items())


finite = st.floats(allow_nan=False, allow_infinity=False, width=32).map(float)
positive = st.floats(1e-30, 1e30)


@st.composite
def numbers(draw: Any) -> Number:
    outcome = draw(st.sampled_from(["pass", "fail", "inconclusive"]))
    measured = draw(st.none() | finite)
    kind = draw(st.sampled_from(["statistical", "round_off", "order", "at_most", "at_least", "by_chance"]))
    if kind == "statistical":
        more = {"expected": draw(finite), "expected_uncertainty": draw(st.just(0.0) | positive)}
        freedom = draw(st.none() | st.floats(1, 1e6))
        return statistical(measured, draw(st.just(0.0) | positive), outcome, freedom=freedom, **more)
    if kind in ("round_off", "order"):
        return by_tolerance(measured, outcome, draw(positive), kind)
    limit = draw(finite)
    if kind == "by_chance":
        return Number(outcome, "statistical", "at_most", measured, None, limit, None, limit, None)
    return bound(measured, limit, outcome, kind)


@given(numbers(), st.text(max_size=20), st.text(max_size=20))
def test_every_number_is_read_as_it_was_written(number: Number, quantity: str, variant: str) -> None:
    key = (printable(f"a/b/{variant}"), ENGINE)
    run = Results("run", {key: judged(**{printable(quantity): number})}, 0)
    with TemporaryDirectory() as directory:
        (found,) = again(Path(directory), run).results.cases[key].numbers.values()
    assert same_text(found, number)
    assert (found.outcome, found.kind, found.sense) == (number.outcome, number.kind, number.sense)
    assert (found.measured is None) == (number.measured is None)
    share = change(found, number, 1e-5, True)
    assert share is None or share < 0.1 or number.outcome == "fail", "rounding is far below what counts as a change"


# -- reading --------------------------------------------------------------------------------------------------

HEAD = f"# particle-crosscheck baseline, form {FORM}, seed 0\n"
LINE = "a/b/c\tmine\tquick\tx\tpass\t1\t<= 2\tbound\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", ":1: not a baseline: it begins with ''"),
        ("hello\n", ":1: not a baseline: it begins with 'hello'"),
        (HEAD.replace("form 1", "form 2"), ":1: a baseline of form 2, this version reads 1"),
        (HEAD.replace("seed 0", "seed x"), ":1: not a baseline"),
        (HEAD + LINE + "<<<<<<< HEAD\n", ":3: not a line of a baseline: the mark of a merge conflict"),
        (HEAD + LINE + LINE, ":3: not a line of a baseline: the same quantity is in line 2"),
        (HEAD + LINE + "a b c\n", ":3: not a line of a baseline: it has 1 fields parted by tabs"),
        (HEAD + LINE.replace("quick", "slow"), ":2: not a line of a baseline: tier 'slow'"),
        (HEAD + LINE + LINE.replace("quick", "full").replace("x", "y"), ":3: not a line of a baseline: tier 'full'"),
        (HEAD + LINE.replace("pass", "green"), ":2: not a line of a baseline: outcome 'green'"),
        (HEAD + LINE.replace("\tbound", ""), ":2: not a line of a baseline: it has 7 fields parted by tabs, not 8"),
        (HEAD + LINE.replace("bound", "bind"), ":2: not a line of a baseline: criterion 'bind'"),
        (HEAD + LINE.replace("bound", "bound 3"), ":2: not a line of a baseline: criterion 'bound 3'"),
        (HEAD + LINE.replace("<= 2", "2"), ":2: not a line of a baseline: criterion 'bound'"),
        (HEAD + LINE.replace("\t1\t", "\tone\t"), ":2: not a line of a baseline: 'one' is not a number"),
        (HEAD + LINE.replace("\t1\t", "\tnan\t"), ":2: not a line of a baseline: 'nan' is not a number"),
        (HEAD + LINE.replace("\t1\t", "\t1e999\t"), ":2: not a line of a baseline: '1e999' is too large"),
        (HEAD + LINE + "a/b/c\tmine\tquick\t-\tskip\n", ":3: not a line of a baseline: a case 'skip' has one line"),
        (HEAD + "a/b/c\tmine\tquick\t-\tskip\n" + LINE, ":3: not a line of a baseline: a case 'skip' has one line"),
        (
            HEAD + "a/b/c\tmine\tquick\toperations\tcounted\tsteps\n",
            ":2: not a line of a baseline: 'steps': a number of",
        ),
        (
            HEAD + "a/b/c\tmine\tquick\toperations\tcounted\n",
            ":2: not a line of a baseline: a line of operations has 6",
        ),
    ],
)
def test_what_is_no_line_is_said_with_its_number(tmp_path: Path, text: str, message: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(UsageError) as error:
        read_baseline(path)
    assert str(error.value).startswith(f"{path}{message}")
    assert "\n" not in str(error.value)


def test_bytes_that_are_no_text(tmp_path: Path) -> None:
    path = tmp_path / "baseline.txt"
    path.write_bytes(HEAD.encode() + b"\xff")
    with pytest.raises(UsageError, match=r"not a baseline: not UTF-8 \(byte \d+\)"):
        read_baseline(path)


@given(st.data())
def test_a_damaged_file_is_read_or_refused(data: Any) -> None:
    text = HEAD + LINE + "a/b/c\tmine\tquick\toperations\tcounted\tsteps=9\na/b/d\tmine\tfull\t-\terror\n"
    place = data.draw(st.integers(0, len(text)))
    damaged = text[:place] + data.draw(st.text(max_size=5)) + text[place + data.draw(st.integers(0, 9)) :]
    with TemporaryDirectory() as directory:
        path = Path(directory) / "baseline.txt"
        path.write_bytes(damaged.encode("utf-8", errors="surrogatepass"))
        with suppress(UsageError):
            read_baseline(path)


def test_lines_may_end_as_on_other_systems_and_comments_stay(tmp_path: Path) -> None:
    text = HEAD + "# known since the change of units\n\n" + LINE
    found = read_baseline(written(tmp_path, text.replace("\n", "\r\n")))
    assert found.results.cases[KEY].numbers["x"].measured == 1
    assert "# known since the change of units\n" in accept(found, results(None), []).text


def test_a_file_that_is_not_there_says_how_to_make_it(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"no baseline \(No such file or directory\); make one from a run: crosscheck"):
        read_baseline(tmp_path / "nowhere.txt")


def test_what_a_baseline_is(tmp_path: Path) -> None:
    assert is_baseline(written(tmp_path, HEAD))
    assert not is_baseline(written(tmp_path, "{}"))
    assert not is_baseline(tmp_path)
    assert not is_baseline(tmp_path / "nowhere")


# -- edits ----------------------------------------------------------------------------------------------------


def test_only_the_accepted_cases_change(run: Results, tmp_path: Path) -> None:
    before = again(tmp_path, run)
    keys = [key for key in run.cases if key[0].startswith("events/several")]
    changed = {key: judged(z=bound(1.0, 2.0)) for key in run.cases}
    found = accept(before, Results("run", changed, 7), keys)
    old, new = (
        [line for line in text.splitlines() if "several" not in line]
        for text in ((tmp_path / "baseline.txt").read_text(), found.text)
    )
    assert old == new
    assert [line.split("\t")[3] for line in found.text.splitlines() if "several" in line] == ["z", "z"]
    # five judgements and a line of operations of each; of the new cases one line
    assert (found.added, found.removed) == (2, 12)
    assert set(found.cases) == set(keys)


def test_accepting_again_changes_nothing(run: Results, tmp_path: Path) -> None:
    before = again(tmp_path, run)
    found = accept(before, run, run.cases)
    assert (found.added, found.removed) == (0, 0)
    assert found.text == (tmp_path / "baseline.txt").read_text()


def test_a_run_of_another_seed_is_not_accepted(run: Results, tmp_path: Path) -> None:
    before = again(tmp_path, run)
    with pytest.raises(UsageError, match=r"baseline.txt: of seed 7, and the run in other of seed 8; run with --seed 7"):
        accept(before, Results("other", run.cases, 8), run.cases)
    with pytest.raises(UsageError, match="its lines are of several seeds"):
        accept(None, Results("other", run.cases, None), run.cases)


def test_git_merges_what_two_people_accepted(tmp_path: Path) -> None:
    """Each another case: no conflict, and the merged file is that of both."""
    base = {(f"a/b/{letter}", ENGINE): judged(x=bound(1.0, 9.0), y=by_tolerance(0.0)) for letter in "abcdefgh"}
    ours = base | {("a/b/b", ENGINE): judged(x=bound(2.0, 9.0), y=by_tolerance(0.0))}
    theirs = base | {("a/b/g", ENGINE): judged(x=bound(3.0, 9.0))}
    texts = {}
    for name, cases in (("base", base), ("ours", ours), ("theirs", theirs)):
        run = Results("run", cases, 0)
        texts[name] = tmp_path / name
        texts[name].write_text(accept(None, run, run.cases).text)
    words = ["git", "merge-file", "-p", *(str(texts[name]) for name in ("ours", "base", "theirs"))]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    both = Results("run", ours | {key: theirs[key] for key in theirs if key[0] == "a/b/g"}, 0)
    assert done.stdout == accept(None, both, both.cases).text
