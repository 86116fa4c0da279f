"""When there is a line on the progress of a run, and what it says."""

import pytest

from crosscheck.simulate.progress import Lines, left, shown


def test_a_stage_is_named_once_it_takes_long():
    lines = Lines("refimpl")
    assert lines.line(1.0, "preparing the start", None) is None
    assert lines.line(3.5, "preparing the start", None) == "refimpl: preparing the start ..."
    assert lines.line(5.0, "preparing the start", None) is None
    assert lines.line(5.1, "compiling kernels", None) is None
    assert lines.line(7.2, "compiling kernels", None) == "refimpl: compiling kernels ..."
    assert lines.line(30.0, "compiling kernels", None) is None


def test_nothing_is_said_before_the_engine_does_something():
    """However long it takes to ask whether it can run the scene: a mistake is then the only line."""
    assert Lines("refimpl").line(100.0, "", None) is None


def test_lines_on_the_share_done_become_rare():
    lines, said = Lines("refimpl"), []
    for second in range(1, 1001):
        if lines.line(float(second), "running", second / 4000):
            said.append(second)
    assert said == [11, 21, 41, 81, 161, 321, 641]
    assert lines.line(2000.0, "running", 0.5) == "refimpl: 50.000% done, about 33.3 minutes left"


def test_a_short_run_says_nothing(capfd, tmp_path):
    file = tmp_path / "progress"
    with shown("refimpl", file):
        file.write_text("running\n0.5\n")
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize(
    ("share", "elapsed", "words"),
    [
        (0.0, 5.0, "time left unknown"),
        (0.5, 30.0, "about 30 seconds left"),
        (0.5, 600.0, "about 10 minutes left"),
        (0.1, 3600.0, "about 9 hours left"),
        (1e-3, 1000.0, "about 11.6 days left"),
        (1e-9, 10.0, "about 317 years left"),
    ],
)
def test_time_left(share, elapsed, words):
    assert left(share, elapsed) == words
