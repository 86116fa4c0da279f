"""The commands `diff` and `baseline accept`, and what `run --baseline` compares its results with."""

from __future__ import annotations

import json
import shlex
from collections import Counter
from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase
from pathlib import Path

from crosscheck.commands.console import say_if_torn
from crosscheck.errors import UsageError
from crosscheck.files import naming, refuse_unwritable, shown_path
from crosscheck.record import Line, is_left_out, read
from crosscheck.regression import shown
from crosscheck.regression.baseline import accept, is_baseline, read_baseline
from crosscheck.regression.difference import CATEGORIES, Difference, Entry, compare, within
from crosscheck.regression.results import Case, Key, Results, of_lines
from crosscheck.report.junit import Mark
from crosscheck.report.markdown import Section, append, of_server, page
from crosscheck.status import Status
from crosscheck.text import printable

#: Outcomes in the order in which they are counted.
_OUTCOMES = ("pass", "fail", "inconclusive", "error", "skip")


def results_at(path: Path) -> Results:
    """The results at a path: a directory of a run, a record, or a baseline. UsageError if there are none."""
    if is_baseline(path):
        return read_baseline(path).results
    found = of_lines(read(path), shown_path(path))
    say_if_torn(path)
    return found


def diff(old: Path, new: Path, beside: str, as_json: bool, summary: Path | None) -> int:
    """Prints what differs between two results, each category apart; returns the exit status.

    old, new: directories of runs, records, or baselines. beside: the engine that computing times of others are compared
    with. as_json: as one JSON document. summary: a file for it in Markdown; None: none, beside that of the CI server.
    UsageError if a result cannot be read, or the summary not be written.
    """
    _refuse_unwritable_summaries(summary)
    difference = compare(results_at(old), results_at(new), beside)
    if as_json:
        print(json.dumps(shown.as_json(difference), indent=1, ensure_ascii=False))
    else:
        for line in shown.lines(difference):
            print(printable(line))
    closing = [*difference.remarks, *filter(None, [difference.false_alarms])]
    append(page([f"**{shown.summary(difference)}**"], shown.sections(difference), closing), summary)
    return int(difference.status())


def _refuse_unwritable_summaries(summary: Path | None) -> None:
    """UsageError if a summary cannot be written, before anything is done. summary: a file of the user, or None."""
    for path in filter(None, (summary, of_server())):
        refuse_unwritable(path)


# -- the baseline of a run --------------------------------------------------------------------------------------------


class Against:
    """A baseline that a run is compared with.

    path: of the baseline. patterns, tier, engines: of the run; of other cases the baseline is not compared. engines:
    none: the run has all that are installed. UsageError if the baseline cannot be read.
    """

    def __init__(self, path: Path, patterns: Sequence[str], tier: str, engines: Sequence[str]) -> None:
        self._path = path
        self._baseline = read_baseline(path)
        self._patterns, self._tier, self._engines = patterns, tier, engines

    def difference(self, lines: Iterable[Line], directory: Path) -> Difference:
        """What differs between the baseline and a run, but for what a budget left out.

        lines: of the record of the run. directory: of the run.
        """
        kept = list(lines)
        run = of_lines([line for line in kept if not is_left_out(line)], shown_path(directory))
        left_out = of_lines([line for line in kept if is_left_out(line)], "").cases
        old = within(
            self._baseline.results,
            lambda key, case: key not in left_out and (key in run.cases or self._covers(key, case)),
        )
        return compare(old, run)

    def _covers(self, key: Key, case: Case) -> bool:
        """Whether the run was to have a case of the baseline."""
        name, engine = key
        wanted = not self._patterns or any(_matches(pattern, name) for pattern in self._patterns)
        tier = case.tier == self._tier or (case.tier, self._tier) == ("quick", "full")
        return wanted and tier and (not self._engines or engine in self._engines)

    def say(self, difference: Difference, directory: Path) -> None:
        """Prints the difference, and how it can be accepted. directory: of the run."""
        for line in shown.lines(difference):
            print(printable(line))
        if difference.entries:
            where = f"--baseline {shlex.quote(str(self._path))} --from {shlex.quote(str(directory))}"
            print(printable(f"what is meant: crosscheck baseline accept [CHECK ...] {where}"))


def marks(difference: Difference) -> dict[Key, Mark]:
    """What the cases of a run are shown as by other tools, where a baseline says more than their verdict.

    difference: between the baseline and the run.
    """
    by_case: dict[Key, list[Entry]] = {}
    for one in difference.entries:
        by_case.setdefault((one.case, one.engine), []).append(one)
    found = {}
    for key, entries in by_case.items():
        first = entries[0]  # they are in the order of the categories
        status = CATEGORIES[first.category].status
        text = "; ".join(f"{CATEGORIES[one.category].title}: {shown.where(one)}: {shown.what(one)}" for one in entries)
        if status in (Status.FAILED, Status.UNJUDGED):
            found[key] = Mark("failure" if status == Status.FAILED else "error", text)
        elif first.category == "known":
            found[key] = Mark("known", text)
    return found


def gone(difference: Difference, lines: Iterable[Line]) -> list[str]:
    """Sentences on cases of a baseline of which the run has no line.

    difference: between the baseline and the run. lines: of the run's record.
    """
    there = of_lines(lines, "").cases
    return [
        f"{CATEGORIES[one.category].title}: {shown.where(one)}: {shown.what(one)}"
        for one in difference.of("no_longer_tested")
        if (one.case, one.engine) not in there
    ]


def sections(difference: Difference | None) -> list[Section]:
    """The tables of a difference in a summary; None: none."""
    return [] if difference is None else list(shown.sections(difference))


# -- accept -----------------------------------------------------------------------------------------------------------


def accept_baseline(patterns: Sequence[str], engines: Sequence[str], baseline: Path, run: Path) -> int:
    """Writes the results of a run into a baseline, and prints what of them is not green; returns exit status 0.

    patterns: shell patterns of names of checks or cases of the run; none: all. engines: their names; none: all.
    baseline: the file, which is made if it is not there; lines of other cases stay as they are. run: directory of the
    run, or its record. UsageError if a pattern or an engine matches no case of the run, if the run had another seed
    than the baseline, or if a file cannot be read or written.
    """
    refuse_unwritable(baseline)
    before = read_baseline(baseline) if baseline.exists() else None
    results = of_lines(read(run), shown_path(run))
    say_if_torn(run)
    accepted = accept(before, results, _chosen(results, patterns, engines))
    baseline.parent.mkdir(parents=True, exist_ok=True)
    with naming(baseline):
        baseline.write_text(accepted.text, encoding="utf-8", newline="\n")
    counts = Counter(case.outcome for case in accepted.cases.values())
    listed = ", ".join(f"{counts[outcome]} {outcome}" for outcome in _OUTCOMES if counts[outcome])
    print(f"{shown_path(baseline)}: {listed} accepted; {accepted.added} lines added, {accepted.removed} removed")
    for (name, engine), case in sorted(accepted.cases.items()):
        if case.outcome != "pass":
            red = [quantity for quantity, number in case.numbers.items() if number.outcome != "pass"]
            reason = "; ".join(red) or case.message.partition("\n")[0]
            print(printable(f"  known from now on: {case.outcome} {name} [{engine}]: {reason}"))
    return int(Status.PASSED)


def _chosen(results: Results, patterns: Sequence[str], engines: Sequence[str]) -> list[Key]:
    """The cases of a run that match. UsageError if a pattern or an engine matches none."""
    for engine in engines:
        if not any(engine == of for _, of in results.cases):
            raise UsageError(f"{results.name}: the run has no case of the engine {engine}")
    keys = [key for key in results.cases if not engines or key[1] in engines]
    for pattern in patterns:
        if not any(_matches(pattern, name) for name, _ in keys):
            raise UsageError(f"{results.name}: the run has no case that matches {pattern}")
    return [key for key in keys if not patterns or any(_matches(pattern, key[0]) for pattern in patterns)]


def _matches(pattern: str, case: str) -> bool:
    """Whether a shell pattern matches the name of a case, or of its check, `group/phenomenon`, as for `run`."""
    return fnmatchcase(case, pattern) or fnmatchcase("/".join(case.split("/", 2)[:2]), pattern)
