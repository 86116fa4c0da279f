"""A column of beads falls on a floor: hard and soft, with gaps above and below v t_c.

Literature: S. Luding, E. Clement, A. Blumen, J. Rajchenbach and J. Duran, Phys. Rev. E 49, 1634 (1994) and
50, 4113 (1994).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, soft, variants_of
from crosscheck.checks.events.driven import run_whole
from crosscheck.checks.granular.soft_grains import CONTACTS, REFERENCE, soft_needs
from crosscheck.convergence import ORDER_TOLERANCE, WHY_ORDER, fitted_order
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.references.soft_chain import soft_chain
from crosscheck.scene import Box, Explicit, Face, HardSpheres, Output, Scene
from crosscheck.verdict import Judged, bounded, order, within, worst

_BEADS, _RESTITUTION, _FALL = 8, 0.95, 2.0
#: Gaps far above v t_c, and the t_c of the soft columns.
_GAP = 0.1
_APART = (0.02, 0.01, 0.005, 0.0025)
#: Gaps over v t_c.
_RATIOS = (0.003, 0.01, 0.03, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
#: t_c of the columns whose gaps are compared with it.
_TOUCHING = 0.002


def _column(gap: float, duration: float) -> Scene:
    """Beads above each other that fall from rest, the lowest by `_FALL`, onto a floor; gravity 1."""
    return Scene(
        name="bouncing-column",
        dimension=2,
        duration=duration,
        acceleration=(0.0, -1.0),
        hard_spheres=HardSpheres(restitution=_RESTITUTION),
        box=Box(
            lengths=(10.0, 100.0),
            boundaries=("open", "hard"),
            faces={"y-": Face(restitution=_RESTITUTION), "y+": Face(open=True)},
        ),
        initial=Explicit(positions=tuple((0.0, 0.5 + _FALL + i * (1 + gap)) for i in range(_BEADS))),
        output=Output(interval=duration, trajectory=True),
    )


class Column(NamedTuple):
    """Of beads of mass 1 and diameter 1 under gravity 1: `energy` and `height` of the centre of mass.

    energy: K + U, with U = 0 where all beads lie on the floor. height: above the floor.
    """

    energy: float
    height: float


def column_state(heights: ArrayLike, speeds: ArrayLike) -> Column:
    """Energy and centre of mass of beads of diameter 1.

    heights: of their centres above the floor, (N,), lengths; speeds: (N,), velocities.
    """
    y, v = np.asarray(heights, dtype=np.float64), np.asarray(speeds, dtype=np.float64)
    number = len(y)
    return Column(float(0.5 * np.sum(v**2) + y.sum() - number**2 / 2), float(y.mean()))


def _column_after(run: Run) -> Column:
    return column_state(run["final_positions"][:, 1], run["final_velocities"][:, 1])


def _judge_apart(laboratory: Laboratory) -> Judged:
    """Gaps of 0.1, far above v t_c: two cascades of 28 impacts each, then one common flight, near its top at t = 4."""
    scene, speed = _column(_GAP, 4.0), math.sqrt(2 * _FALL)
    runs = [_column_after(run_whole(laboratory, scene, soft(duration=t_c, resolution=1 / 400))) for t_c in _APART]
    hard = _column_after(run_whole(laboratory, scene, EVENT_DRIVEN, REFERENCE))
    judgements, curves = [], []
    for name in ("energy", "height"):
        expected = getattr(hard, name)
        errors = [abs(getattr(run, name) - expected) for run in runs]
        slope = fitted_order(_APART, errors, 1e4 * EPSILON * expected)
        judgements.append(
            order(
                f"order of the {name} after the impact in t_c",
                slope.value,
                1.0,
                ORDER_TOLERANCE,
                WHY_ORDER,
                uncertainty=slope.error,
            )
        )
        curves.append(Series(f"{name}, {laboratory.engine}", list(_APART), errors))
    figure = Figure("Bouncing column: soft less event-driven", "t_c", "difference", "log", "log", series=tuple(curves))
    note = (
        f"event-driven: energy {hard.energy:.7g}, height {hard.height:.7g}; soft at t_c = {_APART[-1]:g}: energy "
        f"{runs[-1].energy:.7g}, height {runs[-1].height:.7g}; gap/(v t_c) from "
        f"{_GAP / (speed * _APART[0]):.3g} to {_GAP / (speed * _APART[-1]):.3g}"
    )
    return worst(judgements, note, (figure,))


def _judge_touching(laboratory: Laboratory) -> Judged:
    """Gaps from far below v t_c to above: the energy kept 0.25 after the lowest bead has met the floor."""
    speed = math.sqrt(2 * _FALL)
    after = 0.25
    event_driven, chains = [], []
    found: dict[int, list[float]] = {100: [], 200: []}
    for ratio in _RATIOS:
        gap = ratio * speed * _TOUCHING
        scene = _column(gap, speed + after)
        before = _BEADS * _FALL + gap * _BEADS * (_BEADS - 1) / 2
        for steps, kept in found.items():
            kept.append(
                _column_after(run_whole(laboratory, scene, soft(duration=_TOUCHING, resolution=1 / steps))).energy
                / before
            )
        event_driven.append(_column_after(run_whole(laboratory, scene, EVENT_DRIVEN, REFERENCE)).energy / before)
        chain = column_state(*soft_chain(_BEADS, _RESTITUTION, _TOUCHING, gap, speed, after))
        chains.append(chain.energy / before)
    coarse, fine = (np.array(kept) for kept in found.values())
    tolerance = float(np.abs(coarse - fine).max())
    why = "largest change when dt is halved, which is at least what is left of an error of the first order or above"
    judgements: list[Judged] = [
        within("order", f"share of the energy kept, at gap/(v t_c) = {ratio:g}", float(kept), chain, tolerance, why)
        for ratio, kept, chain in zip(_RATIOS, fine, chains, strict=True)
    ]
    judgements.append(
        bounded(
            f"share lost at gap/(v t_c) = {_RATIOS[0]:g} over the event-driven",
            float((1 - fine[0]) / (1 - event_driven[0])),
            1.0,
            "beads that touch at once detach before they have lost all (Luding et al. 1994)",
        )
    )
    figure = Figure(
        "Bouncing column: energy kept",
        "gap/(v t_c)",
        "energy after the impact over that before",
        x_scale="log",
        series=(
            Series(f"soft, {laboratory.engine}", list(_RATIOS), fine.tolist()),
            Series("event-driven", list(_RATIOS), event_driven),
            Series("Runge-Kutta", list(_RATIOS), chains, theory=True),
        ),
    )
    kept_hard = ", ".join(f"{ratio:g}: {kept:.4f}" for ratio, kept in zip(_RATIOS, event_driven, strict=True))
    return worst(judgements, f"kept by event-driven beads, at gap/(v t_c) = {kept_hard}", (figure,))


def _judge_column(laboratory: Laboratory, judge: Callable[[Laboratory], Judged]) -> Judged:
    return judge(laboratory)


CHECKS = (
    Check(
        name="granular/bouncing-column",
        title="A column of beads falls on a floor: hard and soft, with gaps above and below v t_c",
        equation="gap >> v t_c: E_soft - E_hard -> 0 as t_c; gap << v t_c: the soft column loses less",
        criterion="order 1 in t_c; energy kept as by an adaptive Runge-Kutta method, to the change when dt is halved",
        citation="S. Luding, E. Clement, A. Blumen, J. Rajchenbach and J. Duran, Phys. Rev. E 49, 1634 (1994) and 50, "
        "4113 (1994)",
        judge=_judge_column,
        variants=variants_of({"apart": _judge_apart, "touching": _judge_touching}, "full"),
        needs=soft_needs(
            "dimension=2 method.contact.duration hard_spheres.restitution acceleration "
            "box.boundaries=hard box.faces.restitution",
        ),
        faults=(
            (
                "apart",
                Fault(
                    "weak-dashpot",
                    CONTACTS,
                    "delta - _damping(law[DAMPING], law, model, mass, scale) * approach",
                    "delta - 0.8 * _damping(law[DAMPING], law, model, mass, scale) * approach",
                    "the normal dashpot is four fifths of what the restitution asks for",
                ),
            ),
        ),
    ),
)
