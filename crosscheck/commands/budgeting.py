"""What `run --budget` says: of speeds, of what was chosen, and of what was left out."""

from __future__ import annotations

from crosscheck.budget.plan import Budget, measure
from crosscheck.record import Line, case_name, is_left_out
from crosscheck.runner import Case
from crosscheck.verdict import LEFT_OUT

#: Cases that are named among those left out: the cheapest.
_NAMED = 3


def within(seconds: float, cases: list[Case], jobs: int, began: float) -> Budget:
    """Measures speeds, and chooses among the cases what ends in time; prints both.

    seconds: of the run. jobs: cases at a time. began: when the run did, on the clock `time.monotonic`.
    """
    speeds = measure(cases, seconds, lambda text: print(text, flush=True))
    budget = Budget(cases, speeds, seconds, jobs, began)
    print(budget.said, flush=True)
    return budget


def summary_of_left_out(lines: list[Line]) -> str:
    """A sentence on the cases that there was no time for: how many, what they would take, and those worth a name.

    lines: of the record; "" if there are none.
    """
    left = sorted((line for line in lines if is_left_out(line)), key=_predicted)
    if not left:
        return ""
    begun = [line for line in left if line["cost"].get("seconds")]
    others = [line for line in left if line not in begun]
    known = [line for line in others if "predicted" in line["cost"]]
    total = sum(_predicted(line) for line in known)
    judged = {line["check"] for line in lines if line["outcome"] not in ("skip", "error")}
    lost = sorted({line["check"] for line in left} - judged)
    parts = [f"{LEFT_OUT}: {len(left)} case{'s' if len(left) > 1 else ''}, predicted {total:.3g} s"]
    if known:
        parts.append("cheapest: " + ", ".join(f"{_name(line)} {_predicted(line):.2g} s" for line in known[:_NAMED]))
    if begun:
        parts.append("not finished: " + ", ".join(f"{_name(line)} ({_times(line)})" for line in begun))
    if lost:
        parts.append(f"checks of which nothing was judged: {', '.join(lost)}")
    return "; ".join(parts)


def _name(line: Line) -> str:
    return f"{case_name(line)} [{line['engine']}]"


def _times(line: Line) -> str:
    return line["message"].partition("not finished ")[2]


def _predicted(line: Line) -> float:
    return float(line["cost"].get("predicted", float("inf")))
