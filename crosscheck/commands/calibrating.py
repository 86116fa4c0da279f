"""The command `calibrate`: statistical cases with many seeds, and what their p-values say."""

from __future__ import annotations

import math
import shlex
import sys
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from crosscheck import runner
from crosscheck.calibration import Calibration, calibration
from crosscheck.checks.base import TIERS
from crosscheck.commands.console import that_pay
from crosscheck.engines.registry import engine_names
from crosscheck.engines.workers.ending import TIME_LIMIT
from crosscheck.errors import UsageError
from crosscheck.files import naming, refuse_unwritable
from crosscheck.status import Status, decisive
from crosscheck.verdict import Judgement, Verdict

#: Probability that a right suite is found to be badly calibrated, over all quantities of one call.
_FALSE_ALARM = 1e-3
_HEAD = (
    "| case | quantity | seeds | freedom | about | mean p | KS | suspicious | inconclusive | seen |",
    "|---|---|---|---|---|---|---|---|---|---|",
)


def calibrate(
    patterns: list[str],
    tier: str,
    engine_list: list[str],
    seeds: int,
    jobs: int | None,
    out: Path,
    time_limit: float = TIME_LIMIT,
) -> int:
    """Judges cases with the seeds 0 to `seeds` - 1 of the suite, prints and writes a table; returns the exit status.

    patterns: shell patterns of names of checks or cases; none: all. tier: one of `TIERS`. engine_list: names, or
    path.py:Class; none: all installed. seeds: how many, 5 at least. jobs: runs at a time; None: one per core. out: file
    for the table, in Markdown. time_limit: seconds that one call of an engine may take. The status is FAILED if
    p-values of a quantity are too small to be uniform (of right codes once in 1000 calls), else UNJUDGED if a case had
    no verdict, or nothing is judged statistically, else PASSED: too large ones cost sensitivity, but raise no false
    alarm. Cases of which the first seed judges nothing statistically are left out. UsageError for an unknown tier,
    fewer than 5 seeds, or if no case matches.
    """
    if tier not in TIERS:
        raise UsageError(f"--tier {tier}: unknown; take {', '.join(TIERS[:-1])} or {TIERS[-1]}")
    if seeds < 5:
        raise UsageError(f"--seeds {seeds}: too few to tell what their p-values are like; take 5 or more")
    refuse_unwritable(out)
    cases = [case for case in runner.select(patterns, tier, engine_list or engine_names()) if not case.timing]
    rows: list[tuple[str, Calibration]] = []
    troubles: list[str] = []
    print("\n".join(_HEAD), flush=True)
    with ThreadPoolExecutor(that_pay(jobs, seeds)) as pool:
        for case in cases:
            name = f"{case.name} [{case.engine}]"
            first = runner.judge(case, 0, time_limit=time_limit, repeat=False)
            if first.outcome != "error" and not _statistical(first):
                continue
            rest = pool.map(lambda seed, case=case: runner.judge(case, seed, None, time_limit, False), range(1, seeds))
            verdicts = [first, *rest]
            troubles += [f"{name}: {one.message.splitlines()[0]}" for one in verdicts if one.outcome == "error"]
            for found in _calibrations(verdicts):
                rows.append((name, found))
                print(_row(name, found), flush=True)
            _write(out, rows, troubles)  # after each case: a run that is ended early leaves what it has
    runner.close_pools()
    if not rows and not troubles:
        print("crosscheck: nothing is judged statistically in these cases; see `crosscheck show`", file=sys.stderr)
        return int(Status.UNJUDGED)
    summary, calibrated = _summary([found for _, found in rows], troubles)
    print(summary)
    return int(decisive(*([] if calibrated else [Status.FAILED]), *([Status.UNJUDGED] if troubles else [])))


def _write(out: Path, rows: list[tuple[str, Calibration]], troubles: list[str]) -> None:
    """Writes the command, the table and what it says."""
    command = shlex.join(["crosscheck", *sys.argv[1:]])
    table = "\n".join([*_HEAD, *(_row(name, found) for name, found in rows)])
    summary, _ = _summary([found for _, found in rows], troubles)
    with naming(out):
        out.write_text(f"`{command}`\n\n{table}\n\n{summary}\n", encoding="utf-8")


def _statistical(verdict: Verdict) -> dict[str, Judgement]:
    """The statistical judgements of a verdict with finite numbers, by their number and quantity."""
    found = () if verdict.findings is None else verdict.findings.judgements
    return {
        f"{number} {one.quantity}": one
        for number, one in enumerate(found)
        if one.criterion.kind == "statistical" and one.sigmas is not None and math.isfinite(one.sigmas)
    }


def _calibrations(verdicts: list[Verdict]) -> list[Calibration]:
    """Of each quantity that at least two of the verdicts judge, and that differs between them."""
    by_quantity: dict[str, list[Judgement]] = defaultdict(list)
    for verdict in verdicts:
        for key, one in _statistical(verdict).items():
            by_quantity[key].append(one)
    return [calibration(judged) for judged in by_quantity.values() if len({one.measured for one in judged}) > 1]


def _row(name: str, found: Calibration) -> str:
    cells = (
        name,
        found.quantity.replace("|", "\\|"),
        found.seeds,
        "–" if found.freedom is None else f"{found.freedom:.3g}",
        found.about + (", discrete" if found.discrete else ""),
        f"{found.mean:.2f}",
        f"{found.uniform:.2g}",
        found.suspicious,
        found.inconclusive,
        "–" if found.seen is None else f"{found.seen:.2f}",
    )
    return "| " + " | ".join(map(str, cells)) + " |"


def _summary(found: list[Calibration], troubles: list[str]) -> tuple[str, bool]:
    """What the table says, in words, and whether all p-values are as large as those of right codes."""
    runs = sum(one.seeds for one in found)
    limit = _FALSE_ALARM / max(len(found), 1)
    uneven = [one for one in found if one.uniform < limit and not one.discrete]
    bad, careful = [one for one in uneven if one.mean < 0.5], [one for one in uneven if one.mean >= 0.5]
    seen = [one.seen for one in found if one.seen is not None]
    lines = [
        f"{len(found)} quantities, {runs} judgements: {sum(one.suspicious for one in found)} suspicious, "
        f"{sum(one.inconclusive for one in found)} inconclusive; p-values of {len(bad)} too small, of "
        f"{len(careful)} too large to be uniform (KS below {limit:.1g})"
        + (f"; a deviation of the sensitivity is seen in {100 * sum(seen) / len(seen):.0f} %" if seen else ""),
        *(f"p-values too small: {one.quantity}" for one in bad),
        *(f"p-values too large: {one.quantity}" for one in careful),
        *dict.fromkeys(troubles),
    ]
    return "\n".join(lines), not bad
