"""Events at one time whose order decides what follows: an engine that promises to remark on them counts them."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, variants_of
from crosscheck.checks.events.gases import event_driven
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.scene import Box, HardSpheres, Method, Output, Scene, explicit
from crosscheck.verdict import Judged, Judgement, bounded, round_off, worst

#: Beads around a disk, their distance from it and from the walls at the start, in surfaces, and their speed.
_BEADS, _GAP, _SPEED = 7, 1.5, 1.0
#: Time at which the beads meet the disk, and another at which a ball meets a wall and another ball.
_MEET, _WALL = _GAP / _SPEED, 1.0
#: Two events nearer in time than this are at one time: in these scenes others are 1e-3 apart or more.
_ONE_TIME = 1e-9
_LENGTHS = (16.0, 12.0)


def _ring() -> Scene:
    """Beads that fly at a disk in their middle, all at one distance."""
    angles = 2 * np.pi * (np.arange(_BEADS) + 0.3) / _BEADS
    way = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    x, v = np.array([6.0, 6.0]) + (1.2 + _GAP) * way, -_SPEED * way
    return Scene(
        name="ring",
        dimension=2,
        duration=2 * _MEET,
        hard_spheres=HardSpheres(diameter=(2.0, 0.4)),
        box=Box(lengths=_LENGTHS, boundaries=("hard", "hard")),
        species=(0, *(1,) * _BEADS),
        masses=(5.0, *(1.0,) * _BEADS),
        initial=explicit(np.vstack([[[6.0, 6.0]], x]), np.vstack([[[0.0, 0.0]], v])),
        output=Output(interval=2 * _MEET, trace=True),
    )


def _beside_a_wall() -> Scene:
    """Two balls, one after the other, that meet a wall and another ball at one time; and one in a corner, where no
    order counts."""
    x = [[3.0, 1.5], [3.0, 3.5], [7.0, 10.0], [7.0, 7.5], [10.5, 9.0]]
    v = [[0.0, -1.0], [0.0, -2.0], [0.0, 1.0], [0.0, 2.0], [4.0, 2.0]]
    return Scene(
        name="beside-a-wall",
        dimension=2,
        duration=1.6 * _WALL,
        hard_spheres=HardSpheres(diameter=1.0),
        box=Box(lengths=_LENGTHS, boundaries=("hard", "hard")),
        initial=explicit(np.array(x), np.array(v)),
        output=Output(interval=1.6 * _WALL, trace=True),
    )


def _rows() -> Scene:
    """Rows of disks that are hit from both ends at one time: of three, twice, and of four, whose inner two touch.

    In the row of four, the two in the middle meet after an event each, at one time, that they had with others.
    """
    three = ((-2.0, 1.0), (0.0, 0.0), (2.0, -1.0))
    four = ((-2.5, 1.0), (-0.5, 0.0), (0.5, 0.0), (2.5, -1.0))
    disks = [
        *(((5.0 + x, 2.0), (v, 0.0)) for x, v in three),
        *(((5.0 + 1.5 * x, 5.0), (v, 0.0)) for x, v in three),
        *(((6.0 + x, 8.0), (v, 0.0)) for x, v in four),
        *(((12.0 + x, 10.0), (v, 0.0)) for x, v in ((-1.5, 1.0), (1.5, -1.0))),  # alone: no order
    ]
    return Scene(
        name="rows",
        dimension=2,
        duration=2.5,
        hard_spheres=HardSpheres(diameter=1.0),
        box=Box(lengths=_LENGTHS, boundaries=("hard", "hard")),
        initial=explicit(np.array([x for x, _ in disks]), np.array([v for _, v in disks])),
        output=Output(interval=2.5, trace=True),
    )


def _late() -> Scene:
    """A row of three that is hit from both ends at once, early in a run of a hundred later events."""
    return Scene(
        name="late",
        dimension=2,
        duration=1300.0,
        hard_spheres=HardSpheres(diameter=1.0),
        box=Box(lengths=(61.3, 3.0), boundaries=("hard", "hard")),
        initial=explicit(
            np.array([[4.0, 1.5], [6.5, 1.5], [9.0, 1.5]]), np.array([[1.0, 0.0], [0.0, 0.0], [-1.0, 0.0]])
        ),
        output=Output(interval=1300.0, trace=True),
    )


def _counted(run: Run, number: int) -> tuple[int, float]:
    """Events of the trace in which one of `number` particles had another one, with another partner, at the same time.

    Also the time of the first of them; NaN without any. All walls are one partner.
    """
    times, partners = np.full(number, -np.inf), np.full(number, -1)
    count, first = 0, np.nan
    for time, (i, j) in zip(run["event_times"].tolist(), run["event_partners"].astype(int).tolist(), strict=True):
        pairs = [(i, j), (j, i)] if j >= 0 else [(i, -1)]
        if any(time - times[one] < _ONE_TIME and partners[one] != other for one, other in pairs):
            first = first if count else time
            count += 1
        for one, other in pairs:
            times[one], partners[one] = time, other
    return count, first


def _remarked(run: Run) -> tuple[int, float]:
    """Number of such events that the engine remarks on, and the time of the first; 0 and NaN without a remark."""
    for remark in run.remarks:
        found = re.search(r"^(\d+) events?\b.*t = ([-+.\de]+)", remark)
        if found:
            return int(found[1]), float(found[2])
    return 0, np.nan


def _judge(laboratory: Laboratory, scene: Scene) -> Judged:
    judged: list[Judgement] = []
    for name, claims in laboratory.claims.items():
        method = Method(scheme=name)
        if claims.kind != EVENT_DRIVEN or laboratory.refusal(scene, method) is not None:
            continue
        run = laboratory.run(scene, method)
        count, first = _counted(run, scene.number)
        number, when = _remarked(run)
        none = laboratory.run(scene.changed(duration=0.5, output=Output(interval=0.5, trace=True)), method)
        judged += [
            bounded(f"{name}: events at one time", float(count), 1.0, "else nothing is judged", at_least=True,
                    control=True),
            round_off(f"{name}: such events remarked on, too many or few", float(abs(number - count)), 0.5,
                      "a count: exact"),
            # a remark has twelve digits
            round_off(f"{name}: time of the first", abs(when - first), 1e-11 + 8 * EPSILON, "twelve digits"),
            round_off(f"{name}: remarks on a run without", float(len(none.remarks)), 0.5, "a count: exact"),
        ]  # fmt: skip
    return worst(judged)


CHECKS = (
    Check(
        name="events/order",
        title="Events at one time whose order decides: the engine says how many there were, and when the first",
        equation="t_k - t_l < rounding, k and l with a particle in common and other partners",
        criterion="as many as the trace has, the first at its time; none where there are none",
        citation="Lubachevsky, J. Comput. Phys. 94, 255 (1991)",
        judge=_judge,
        variants=variants_of({"ring": _ring(), "wall": _beside_a_wall(), "rows": _rows(), "late": _late()}),
        needs=replace(
            event_driven(
                "dimension=2 box.boundaries=hard hard_spheres.diameter[] masses[]", "event_times event_partners"
            ),
            promises=("remarks_on_order",),
        ),
        interpreted=True,
        faults=(
            (
                "ring",
                Fault(
                    "order-unnoticed",
                    "events/kernels/loop.py",
                    "    tied = (age_i < resolution and _last_with(ints, i) != _code(j)) or (",
                    "    tied = (age_i < resolution and _last_with(ints, i) != _code(j)) and (",
                    "of events at one time, those are not noticed in which one particle has had no other",
                ),
            ),
        ),
    ),
)
