"""Logs of LAMMPS: several runs, all styles, and what stands among the output."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from truth import Truth

from crosscheck.errors import UsageError
from crosscheck.trajectories.frames import Series
from crosscheck.trajectories.reading import open_results

START = "LAMMPS (22 Jul 2025)\nunits lj\n"
PER = "Per MPI rank memory allocation (min/avg/max) = 3.1 | 3.1 | 3.1 Mbytes\n"
END = "Loop time of 0.0035 on 1 procs for 100 steps with 108 atoms\n\nPerformance: 1 tau/day\n"
ONE = "   Step          Temp          c_p[1]\n"


def opened(tmp_path: Path, text: str) -> Series:
    (tmp_path / "log.lammps").write_text(text)
    found = open_results(tmp_path / "log.lammps")
    assert isinstance(found, Series)
    return found


def test_all_styles_in_one_log(lammps: Truth) -> None:
    found = open_results(lammps.path("log.lj"))
    assert isinstance(found, Series)
    assert found.time.tolist() == pytest.approx(np.arange(11) * 0.1, abs=1e-14)
    assert found.remarks == ()
    assert set(found.columns) == {"Temp", "TotEng", "Press", "c_more[1]"}
    kinetic = 0.5 * (lammps.of("lj", "v") ** 2 * ([[2.5]] * 20 + [[1.0]] * 88)).sum(axis=(1, 2))
    temperature = kinetic / (1.5 * 107)  # LAMMPS takes away the motion of the centre
    assert np.allclose(found.columns["Temp"][:5], temperature, rtol=5e-8)
    # the last runs printed the same quantities with 4 decimals, and with 15 digits
    assert found.rounding["Temp"].absolute == 5e-5
    assert np.abs(np.diff(found.columns["TotEng"])).max() < 0.05


def test_runs_follow_each_other_and_share_a_row(tmp_path: Path) -> None:
    first = PER + ONE + "  0  1.5  nan\n  10  1.25  -inf\n" + END
    second = ONE + "  10  1.25  3\n  20  1.75  4\n" + END  # after `pre no`: without the line before
    found = opened(tmp_path, START + first + second)
    assert found.time.tolist() == [0, 10, 20]
    assert found.columns["Temp"].tolist() == [1.5, 1.25, 1.75]
    assert found.columns["c_p[1]"].tolist() == pytest.approx([np.nan, 3, 4], nan_ok=True)
    assert found.remarks == ("it states steps and no times (thermo_style with the keyword time would).",)


def test_warnings_and_words_among_the_output(tmp_path: Path) -> None:
    rows = "  0  1.5  1\nWARNING: Dangerous (../x.cpp:1)\nmy fix says hello\n  10  1.25  2\nanother one\n"
    for before in (PER, PER + "WARNING: late\n"):
        found = opened(tmp_path, START + before + ONE + "WARNING: early\n" + rows + END)
        assert found.columns["c_p[1]"].tolist() == [1, 2]
        assert "'my fix says hello' stands among the output, and 1 more lines." in found.remarks


@pytest.mark.parametrize("cut", ["  20  1.7", "  20  1.75  3.2", "ERROR: Lost atoms\nLast command: run 100\n"])
def test_a_run_that_was_killed_has_its_rows(tmp_path: Path, cut: str) -> None:
    found = opened(tmp_path, START + PER + ONE + "  0  1.5  1\n  10  1.25  2\n" + cut)
    assert found.time.tolist() == [0, 10]


def test_styles_multi_and_yaml(tmp_path: Path) -> None:
    head = "------------ Step {} ----- CPU =  0.01 (sec) -------------\n"
    multi = head.format(0) + "Time = 0 Temp =  1.5000\nc_p[1]   =   2.00\n" + head.format(10)
    multi += "Time = 0.1 Temp =  1.2500\nc_p[1]   =   nan\n" + head.format(20) + "Time = 0.2 Temp = 1.0000\n"
    found = opened(tmp_path, START + PER + multi)
    assert found.time.tolist() == [0, 0.1]  # the last sample was cut
    assert found.columns["Temp"].tolist() == [1.5, 1.25]
    yaml = "---\nkeywords: ['Step', 'Time', 'Temp', 'c_p[1]', ]\ndata:\n"
    yaml += "  - [10, 0.1, .nan, -.inf, ]\n  - [20, 0.2, 1.5, 3, ]\n"
    both = opened(tmp_path, START + PER + multi + END + PER + yaml + "...\n" + END)
    assert both.time.tolist() == [0, 0.1, 0.2]
    assert both.columns["Temp"].tolist() == pytest.approx([1.5, np.nan, 1.5], nan_ok=True)


def test_columns_that_some_runs_lack_are_said(tmp_path: Path) -> None:
    second = PER + "   Step   Temp\n  10  1.0\n" + END
    found = opened(tmp_path, START + PER + ONE + "  0  1.5  1\n" + END + second)
    assert list(found.columns) == ["Temp"]
    assert any("c_p[1]: this is not read" in remark for remark in found.remarks)


def test_echoes_and_tables_are_no_output(tmp_path: Path) -> None:
    text = "thermo_style custom Step Temp\nSection |  min time  Step\n1 2\nStep Temp\nnot numbers\n"
    found = opened(tmp_path, START + text + PER + ONE + "  0  1.5  1\n" + END)
    assert found.time.tolist() == [0]
    assert opened(tmp_path, START + "Step Temp E \n  0 1.5 2\n  5 1 1\n" + END).time.tolist() == [0, 5]  # before 2022


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (START, "there is no thermodynamic output"),
        (START + PER + ONE + END, "there is no thermodynamic output"),
    ],
)
def test_what_cannot_be_read_is_one_line(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(UsageError, match=message) as caught:
        opened(tmp_path, text)
    assert "\n" not in str(caught.value)
    assert "log.lammps" in str(caught.value)
