"""The summary for a page of a CI server: what it says, that it cannot be broken, and how long it gets."""

from __future__ import annotations

from pathlib import Path

import pytest
import synthetic

from crosscheck.record import Line, read
from crosscheck.report import markdown
from crosscheck.report.markdown import MOST_BYTES, MOST_ROWS, VARIABLE, Section, append, of_run, page


@pytest.fixture
def lines(tmp_path: Path) -> list[Line]:
    return read(synthetic.write(tmp_path / "run"))


def test_a_run(lines: list[Line]) -> None:
    text = of_run(
        lines, [], "crosscheck run 'a/*'", "beside the baseline", [Section("new: 1", ("case",), [("a/b/c",)])]
    )
    head, counts, compared, *_ = text.split("\n\n")
    assert head == "## particle-crosscheck"
    assert counts == "**4 fail, 1 error, 2 inconclusive, 4 skip, 48 pass**"
    assert compared == "beside the baseline"
    slope = "order of the position error | 5.010(12) | 4 | 4.04 tol. |"
    assert f"\n| stepping/oscillator-damped/rk4 | refimpl | fail | {slope}" in text
    # every red judgement
    assert "| events/several/faulty | refimpl | fail | pressure | 1.500(10) | 1 | 50 σ |" in text
    assert "| events/several/faulty | refimpl | fail | share of fast particles | 0.02 | ≥ 0.04 | 2 tol. |" in text
    assert "| events/inelastic-collapse/hot | refimpl | error | refimpl was killed by signal 11 |" in text
    assert text.index("### Not green") < text.index("### new: 1") < text.index("<details><summary>Skipped")
    assert "| my\\_engine.py:Mine | 3 | Mine: no lattice gases |" in text
    assert "false alarms: 6 statistical judgements" in text
    assert text.endswith("<code>crosscheck run 'a/*'</code>\n")


def test_a_run_that_judged_nothing_says_why() -> None:
    text = of_run([], ["nothing was judged: lammps: ImportError"], "crosscheck run")
    assert "**nothing was judged**\n\nnothing was judged: lammps: ImportError\n" in text
    assert "###" not in text


def test_text_of_users_is_text(lines: list[Line]) -> None:
    """No tag, no column, no line and no style comes from a name or a message."""
    hostile = "<script>|`*_[x](y) \n\x1b & #~"
    text = of_run([line | {"variant": hostile, "message": hostile} for line in lines], [hostile], hostile)
    # stands in front of what would be read as more
    bare = text.replace("\\<", "").replace("\\|", "").replace("&lt;", "").replace("\\`", "")
    assert "<script" not in bare
    assert "\x1b" not in text
    assert text.count("\\\\n\\\\x1b &amp;") > 10
    for row in text.splitlines():
        if row.startswith("| "):
            assert row.replace("\\|", "").count("|") in (4, 8)


def test_of_long_tables_the_number_of_the_rest(lines: list[Line]) -> None:
    red = next(line for line in lines if line["outcome"] == "error")
    text = of_run([red | {"variant": str(number)} for number in range(MOST_ROWS + 7)], [], "crosscheck run")
    assert "\nand 7 more\n" in text
    assert text.count("\n| events") == MOST_ROWS


def test_a_summary_fits_on_the_page() -> None:
    sections = [Section(f"table {number}", ("x",), [("y" * 1000,)] * 100) for number in range(20)]
    text = page(["head"], sections, ["end"])
    assert MOST_BYTES / 2 < len(text.encode()) <= MOST_BYTES
    assert text.endswith("The rest does not fit on this page: the record has it.\n\nend\n")
    assert "table 3" in text


def test_it_is_appended_to_the_file_of_the_server(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    server, own = tmp_path / "server.md", tmp_path / "new" / "own.md"
    monkeypatch.delenv(VARIABLE, raising=False)
    append("nobody\n", None)
    monkeypatch.setenv(VARIABLE, str(server))
    server.write_text("before\n")
    append("one\n", own)
    append("two\n", own)
    assert server.read_text() == "before\none\ntwo\n"
    assert own.read_text() == "two\n"


def test_where_the_step_has_no_room_left_nothing_is_added(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """GitHub would drop all of it."""
    monkeypatch.setenv(VARIABLE, str(tmp_path / "server.md"))
    monkeypatch.setattr(markdown, "MOST_BYTES_OF_A_STEP", 10)
    append("12345\n", None)
    append("67890\n", None)
    append("abc\n", None)
    assert (tmp_path / "server.md").read_text() == "12345\nabc\n"
