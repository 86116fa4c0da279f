"""What the exit status of a command says: green only if something was judged, and nothing was found."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from enum import IntEnum

from crosscheck.record import Line, is_left_out
from crosscheck.verdict import FALSE_ALARM_OF_A_RUN, LEFT_OUT


class Status(IntEnum):
    """Exit status of every command. The others after a signal are 128 and its number.

    FAILED: a number is not what it must be, or a run ended early: the physics is wrong. USAGE: bad usage or input, or
    a file that cannot be read or written. INCONCLUSIVE: too little was measured to decide. UNJUDGED: nothing was
    judged, or something could not run: an engine that is missing, crashed or gave no answer.
    """

    PASSED = 0
    FAILED = 1
    USAGE = 2
    INCONCLUSIVE = 3
    UNJUDGED = 4
    INTERRUPTED = 130
    PIPE_CLOSED = 141


def decisive(*held: Status) -> Status:
    """Of several that hold, the one that counts: the first of FAILED, UNJUDGED, INCONCLUSIVE, else PASSED.

    held: none: PASSED.
    """
    return next((one for one in (Status.FAILED, Status.UNJUDGED, Status.INCONCLUSIVE) if one in held), Status.PASSED)


#: The status of a run by an outcome that is among its verdicts.
_OF_OUTCOMES = {"fail": Status.FAILED, "error": Status.UNJUDGED, "inconclusive": Status.INCONCLUSIVE}


def of(lines: Sequence[Line], unjudged: Sequence[str], allow_inconclusive: bool) -> Status:
    """The status of a run that went to its end.

    lines: of the record, of all of its cases. unjudged: see `unjudged`. allow_inconclusive: such verdicts count as
    passed.
    """
    allowed = {"inconclusive"} if allow_inconclusive else set()
    held = [_OF_OUTCOMES.get(outcome, Status.PASSED) for outcome in {line["outcome"] for line in lines} - allowed]
    return decisive(*held, *([Status.UNJUDGED] if unjudged else []))


def unjudged(lines: Sequence[Line], engines: Sequence[str]) -> list[str]:
    """Sentences on what was not judged: nothing at all, or nothing of one of `engines`, which the user has named.

    lines: of the record, of all cases of the run.
    """
    if all(line["outcome"] == "skip" for line in lines):
        return [f"nothing was judged: {_why(lines)}"]
    found = []
    for engine in dict.fromkeys(engines):
        own = [line for line in lines if line["engine"] == engine]
        if all(line["outcome"] == "skip" for line in own):
            found.append(f"nothing was judged of {engine}: {_why(own)}")
    return found


def false_alarms(lines: Sequence[Line]) -> str:
    """A sentence on how often a run would be red although all codes are right: the sum over statistical judgements.

    lines: of the record, of all cases of the run; "" if none was judged statistically, or an older version did.
    """
    rates = [rate for line in lines for one in line["judgements"] if (rate := one.get("false_alarm"))]
    if not rates:
        return ""
    total = sum(rates)
    each = f"{min(rates):.2g}" if min(rates) == max(rates) else f"{min(rates):.2g} to {max(rates):.2g}"
    promise = "below the" if total <= FALSE_ALARM_OF_A_RUN else "more than the"
    return (
        f"false alarms: {len(rates)} statistical judgements, each red with the probability {each} of a right code: "
        f"{total:.1g} for the run, {promise} {FALSE_ALARM_OF_A_RUN:g} that are promised"
    )


def _why(skipped: Sequence[Line]) -> str:
    if not skipped:
        return "no check that was asked for matches what it declares (docs/engines.md)"
    reasons = (LEFT_OUT if is_left_out(line) else str(line["message"]) for line in skipped)
    (reason, _), *others = Counter(reasons).most_common()
    more = f", and {len(others)} more" if others else ""
    return f"{len(skipped)} skipped ({reason}{more})"
