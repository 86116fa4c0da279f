"""Numbers as physicists write them: 1.2345(67), 3.2e-14."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

#: Shown for a number that a skip or an error has not produced.
ABSENT = "–"


def _tidy(text: str) -> str:
    """1e-05 -> 1e-5, 1e+20 -> 1e20, with an ASCII minus sign: numbers can be copied into code."""
    return re.sub(r"e([+-])0*(\d+)", lambda m: "e" + m[1].replace("+", "") + m[2], text)


def plain(value: float | None, digits: int = 4) -> str:
    """Significant digits, whole numbers below a million in full.

    value: the number; None gives `ABSENT`. digits: how many.
    """
    if value is None:
        return ABSENT
    if not math.isfinite(value):
        return "not finite"
    if value == round(value) and abs(value) < 1e6:
        return str(round(value))
    return _tidy(f"{value:.{digits}g}")


def to_tolerance(value: float | None, tolerance: float | None) -> str:
    """As many digits as it takes to see a tenth of the tolerance, at least three.

    value: the number. tolerance: absolute, in its unit. `plain` where one of them is missing, zero or not finite.
    """
    if value is None or not tolerance or not math.isfinite(tolerance) or not value or not math.isfinite(value):
        return plain(value)
    digits = math.floor(math.log10(abs(value))) - math.floor(math.log10(abs(tolerance))) + 2
    return plain(value, min(max(digits, 3), 16))


def with_uncertainty(value: float | None, uncertainty: float | None) -> str:
    """Value and standard uncertainty, of which two digits, in brackets: 1.2345(67), 1.20(35)e-14.

    value: the number. uncertainty: absolute, in its unit. `plain` where one of them is missing or not finite.
    """
    if value is None or not uncertainty or not math.isfinite(uncertainty) or not math.isfinite(value):
        return plain(value)
    # the uncertainty rounded first: 0.0996 is 10e-2, one place coarser than 9.96e-2
    mantissa, _, exponent = f"{uncertainty:.1e}".partition("e")
    last = int(exponent) - 1
    bracket = mantissa.replace(".", "")
    first = max(int(exponent), math.floor(math.log10(abs(value))) if value else int(exponent))
    if -4 <= first <= 5 and last <= 0:
        return f"{value:.{-last}f}({bracket})"
    scaled = value / 10.0**first if abs(first) < 300 else float(f"{value:.17e}".partition("e")[0])
    return f"{scaled:.{first - last}f}({bracket})e{first}"


def seconds(value: float | None) -> str:
    """A duration: 12 ms, 3.4 s, 5 min 06 s, 1 h 02 min.

    value: in seconds; None gives `ABSENT`.
    """
    if value is None:
        return ABSENT
    if not math.isfinite(value):
        return "not finite"
    if value < 0.0995:  # two digits of more are 100 ms
        return f"{value * 1e3:.2g} ms"
    if value < 100:
        return f"{value:.2g} s" if value < 10 else f"{value:.0f} s"
    minutes, rest = divmod(round(value), 60)
    if minutes < 60:
        return f"{minutes} min {rest:02d} s"
    return f"{minutes // 60} h {minutes % 60:02d} min"


def count(value: float | None) -> str:
    """A number of evaluations: 1200, 3.4e6.

    value: the number; None and 0 give `ABSENT`.
    """
    if not value:
        return ABSENT
    return f"{value:.0f}" if value < 1e5 else _tidy(f"{value:.2e}")


# -- the numbers of a judgement ------------------------------------------------------------------------------

#: A judgement as a record keeps it.
Judgement = Mapping[str, Any]


def measured(judgement: Judgement | None) -> str:
    """What was measured, with its uncertainty, or with the digits that its tolerance asks for.

    judgement: as the record keeps it; None gives `ABSENT`.
    """
    if judgement is None:
        return ABSENT
    if judgement["measured"] is None:
        return "not finite"
    if judgement["uncertainty"]:
        return with_uncertainty(judgement["measured"], judgement["uncertainty"])
    return to_tolerance(judgement["measured"], judgement["criterion"]["tolerance"])


def expected(judgement: Judgement | None) -> str:
    """The reference value with its uncertainty, or the limit of a bound with its sense.

    judgement: as the record keeps it; None gives `ABSENT`.
    """
    if judgement is None:
        return ABSENT
    criterion, value = judgement["criterion"], judgement["expected"]
    sign = {"at_least": "≥", "at_most": "≤"}.get(criterion["sense"])
    if sign is not None:
        return f"{sign} {plain(value)}"
    if judgement["expected_uncertainty"]:
        return with_uncertainty(value, judgement["expected_uncertainty"])
    return to_tolerance(value, criterion["tolerance"])


def deviation(judgement: Judgement | None) -> str:
    """The deviation in standard uncertainties or in tolerances.

    judgement: as the record keeps it; None gives `ABSENT`.
    """
    if judgement is None:
        return ABSENT
    statistical = judgement["criterion"]["kind"] == "statistical"
    value = judgement["sigmas" if statistical else "deviation"]
    if value is None:
        return "∞"
    return f"{plain(value, 3)} {'σ' if statistical else 'tol.'}"


def sensitivity(judgement: Judgement | None) -> str:
    """The smallest deviation that would have failed, relative unless zero is expected.

    judgement: as the record keeps it; None, or one without a sensitivity, gives `ABSENT`.
    """
    if judgement is None or judgement["sensitivity"] is None:
        return ABSENT
    return f"{plain(judgement['sensitivity'], 2)}{'' if judgement['expected'] else ' abs.'}"


def comparison(judgement: Judgement) -> str:
    """What was measured beside what was expected, in a line. judgement: as the record keeps it."""
    off = f"measured {measured(judgement)}, expected {expected(judgement)}, off by {deviation(judgement)}"
    return f"{judgement['quantity']}: {off}"
