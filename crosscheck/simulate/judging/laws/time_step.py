"""The result does not depend on the time step: halved until positions and energy change by less than a tolerance."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from crosscheck.convergence import ORDER_TOLERANCE
from crosscheck.figure import Figure, Series
from crosscheck.simulate.judging.ladder import ABOVE, LINEAR, Ladder, first_extras, ladder
from crosscheck.simulate.judging.law import Law, none_there
from crosscheck.simulate.judging.smoothness import claimed_order, jump
from crosscheck.simulate.judging.trial import Extra, Trial
from crosscheck.verdict import Judged, Judgement, bounded, round_off, worst

#: How near to a whole number an order is that has settled.
_WHOLE = 0.1


def _excuse(trial: Trial) -> str | None:
    if trial.method.dt is None:
        return f"scheme {trial.method.scheme} has no time step to be halved"
    if trial.broken:
        return trial.broken
    if not first_extras(trial):
        return "the run has too few steps"
    return None


def _extra(trial: Trial) -> Iterable[Extra]:
    return first_extras(trial)


def _judge(trial: Trial) -> Judged:
    """The order of the changes on halving dt, and whether they fall below the tolerance."""
    found = ladder(trial)
    if found is None:
        why = "the states of the beginning are compared"
        return none_there("beginnings that can be compared", why)
    judged = [_converged("positions", found, found.changes, trial)]
    if found.energies:
        judged.append(_converged("energy", found, found.energies, trial))
    order = _order(trial, found)
    shown = ", ".join(f"{one:.2f}" for one in found.orders)
    figure = Figure(
        "changes on halving dt", "dt", "largest relative change", "log", "log",
        tuple(
            Series(f"{name}, {trial.planned.label}", list(found.steps[:-1]), list(values))
            for name, values in (("positions", found.changes), ("energy", found.energies))
            if any(values)
        ),
    )  # fmt: skip
    until = f"until t = {found.until:g} of {trial.scene.duration:g}"
    if found.horizon < len(found.rounding):
        until += ", where dt and dt/2 part: after that single paths mean nothing"
    notes = [until, f"positions relative to the {found.unit}", *([order] if isinstance(order, str) else [])]
    notes += [f"orders {shown}"] if shown else []
    return worst([*([order] if isinstance(order, Judgement) else []), *judged], "; ".join(notes), (figure,))


def _converged(what: str, found: Ladder, changes: tuple[float, ...], trial: Trial) -> Judgement:
    """Whether the last change is below the tolerance; if not, it takes more halvings."""
    enough = 0.0
    for dt, change in zip(reversed(found.steps[:-1]), reversed(changes), strict=True):
        if change > trial.tolerance:
            break
        enough = dt
    judged = bounded(
        f"change of the {what} on halving the smallest dt, relative",
        changes[-1],
        trial.tolerance,
        "the tolerance that was asked for",
        note=f"below it from dt = {enough:g} on" if enough else "not below it for any dt that was tried",
    )
    return judged if judged.outcome == "pass" else replace(judged, outcome="inconclusive")


def _order(trial: Trial, found: Ladder) -> Judgement | str:
    """The order of the changes of positions, at least that of the scheme; or why it is not judged."""
    claimed, orders, late = claimed_order(trial), found.orders, jump(trial.scene)
    if claimed is None:
        return f"scheme {trial.method.scheme} claims no order"
    if not found.usable:
        return round_off(
            "change of the positions on halving dt, relative: all are rounding errors",
            max(found.changes),
            ABOVE * found.floor,
            f"{ABOVE:g} times what rounding at each step makes, as it grows in a twin",
        )
    if late is not None:
        return f"the order is irregular, for forces act up to a step too late ({late})"
    if not orders:
        return "the order does not show: smaller steps change rounding errors alone"
    judged = bounded(
        "order of the changes of positions in dt",
        orders[-1],
        claimed - ORDER_TOLERANCE,
        f"order {claimed} of {trial.method.scheme}; orders are whole numbers",
        at_least=True,
    )
    if judged.outcome == "fail" and not _settled(orders, claimed):
        note = "not the same whole number from one halving to the next: take a smaller dt"
        return replace(judged, outcome="inconclusive", note=note)
    return judged


def _settled(orders: list[float], claimed: int) -> bool:
    """Whether the last two orders say that the scheme is of another order, a whole number from 1 to below `claimed`."""
    whole = round(orders[-1])
    return 1 <= whole < claimed and len(orders) > 1 and all(abs(one - whole) <= _WHOLE for one in orders[-2:])


LAWS = (
    Law(
        "time-step",
        f"|x(dt) - x(dt/2)| ~ dt^p, as long as it is below {LINEAR:g} of the length of the scene",
        _excuse,
        _judge,
        extra=_extra,
    ),
)
