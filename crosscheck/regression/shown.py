"""A difference as lines for a terminal, as Markdown, and as JSON. docs/regression.md has the form of the JSON."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from typing import Any

from crosscheck.regression.difference import CATEGORIES, Difference, Entry
from crosscheck.regression.results import Number
from crosscheck.report import numbers
from crosscheck.report.markdown import Section

#: Raised when a field of the JSON changes its meaning or goes.
FORM = 1
#: Findings of a category that are not printed one by one beyond so many: what is well goes by its number alone.
_MOST, _MOST_GOOD = 50, 5
#: Names of cases that are printed of several of one check.
_VARIANTS = 3
_GOOD = ("fewer_operations", "faster", "fixed", "newly_tested", "nearer")


def lines(difference: Difference) -> Iterator[str]:
    """The lines of a difference for a terminal: what was compared, and each category that is not empty."""
    yield summary(difference)
    for category, kind in CATEGORIES.items():
        found = difference.of(category)
        if not found:
            continue
        most = _MOST_GOOD if category in _GOOD else _MOST
        groups = _groups(found)
        yield f"{kind.title}: {len(found)}"
        yield from (f"  {where(*group)}: {what(group[0])}" for group in groups[:most])
        if len(groups) > most:
            yield f"  and {sum(map(len, groups[most:]))} more"
    yield from difference.remarks
    if difference.false_alarms:
        yield difference.false_alarms


def summary(difference: Difference) -> str:
    """What was compared by a difference, in one sentence."""
    if not difference.cases:
        return f"{difference.new} beside {difference.old}: no case was judged in both"
    return (
        f"{difference.new} beside {difference.old}: {difference.judgements} judgements of {difference.cases} cases "
        f"compared, {difference.same} the same number to the {'digits kept' if difference.rounded else 'last bit'}"
    )


def sections(difference: Difference) -> Iterator[Section]:
    """The tables of a difference for a page in Markdown, a category each."""
    for category, kind in CATEGORIES.items():
        found = difference.of(category)
        rows = [
            (_cases(group), group[0].engine, group[0].quantity, *map(_number, group[0][4:6]), _remark(group[0]))
            for group in _groups(found)
        ]
        if rows:
            head = ("case", "engine", "quantity", "before", "now", "")
            yield Section(f"{kind.title}: {len(found)}", head, rows, folded=category in _GOOD)


def _groups(found: list[Entry]) -> list[list[Entry]]:
    """The entries, with those together of whole cases of one check and engine of which there is the same to say."""
    groups: dict[tuple[str, ...], list[Entry]] = {}
    for one in found:
        check = one.case if one.quantity else "/".join(one.case.split("/", 2)[:2])
        groups.setdefault((check, one.engine, one.quantity, one.message), []).append(one)
    return list(groups.values())


def _cases(group: list[Entry]) -> str:
    """The case of a group of entries; of several, the check and the names of the first variants."""
    if len(group) == 1:
        return group[0].case or "all cases"
    check = "/".join(group[0].case.split("/", 2)[:2])
    variants = [one.case.removeprefix(f"{check}/") for one in group]
    more = f" and {len(variants) - _VARIANTS} more" if len(variants) > _VARIANTS else ""
    return f"{check}: {', '.join(variants[:_VARIANTS])}{more}"


def where(*group: Entry) -> str:
    """What entries are of: case, engine and quantity. group: one, or several of whole cases of a check and engine."""
    place = f"{_cases(list(group))} [{group[0].engine}]"
    return f"{place} {group[0].quantity}" if group[0].quantity else place


def what(entry: Entry) -> str:
    """The numbers and the message of an entry."""
    old, new = _number(entry.old), _number(entry.new)
    change = f"{old} -> {new}" if old and new else new or old
    return "; ".join(filter(None, (change, _remark(entry))))


def _remark(entry: Entry) -> str:
    share, old, new = entry.share, entry.old, entry.new
    moved = ""
    # where the outcome is another one, that says it
    told = old is not None and new is not None and (old.outcome == new.outcome or entry.category == "changed")
    if told and share is not None and share > 1:
        moved = f"moved by {_times(share)} what two right runs differ by at most"
    return "; ".join(filter(None, (moved, entry.message)))


def _times(share: float) -> str:
    return f"{numbers.plain(share, 3)} times" if math.isfinite(share) else "more than"


def _number(number: Number | None) -> str:
    """Outcome, measured and expected value of a number."""
    if number is None:
        return ""
    judgement = number.judgement
    expected = numbers.expected(judgement)
    limit = expected if number.sense != "both" else f"of {expected}"
    tolerance = f" ± {numbers.plain(number.tolerance, 2)}" if number.sense == "both" and number.tolerance else ""
    return f"{number.outcome} {numbers.measured(judgement)} ({limit}{tolerance})"


def as_json(difference: Difference, allow_inconclusive: bool = False) -> dict[str, Any]:
    """The difference for scripts: see docs/regression.md. allow_inconclusive: see `Difference.status`."""
    status = difference.status(allow_inconclusive)
    counts = Counter(one.category for one in difference.entries)
    return {
        "form": FORM,
        "old": difference.old,
        "new": difference.new,
        "status": int(status),
        "compared": {
            "cases": difference.cases,
            "judgements": difference.judgements,
            "same": difference.same,
            "by_standard_errors": difference.errors,
        },
        "counts": {category: counts[category] for category in CATEGORIES},
        "entries": [_entry(one) for one in difference.entries],
        "remarks": [*difference.remarks, *filter(None, [difference.false_alarms])],
    }


def _entry(one: Entry) -> dict[str, Any]:
    return {
        "category": one.category,
        "case": one.case,
        "engine": one.engine,
        "quantity": one.quantity,
        "old": None if one.old is None else one.old._asdict(),
        "new": None if one.new is None else one.new._asdict(),
        "share": one.share if one.share is not None and math.isfinite(one.share) else None,
        "message": one.message,
    }
