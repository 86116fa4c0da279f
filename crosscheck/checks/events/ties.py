"""Events of one particle at one time: which of them comes first is the algorithm's choice, and a run says so."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, variants_of
from crosscheck.checks.events.gases import event_driven
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.scene import Box, Floats, HardSpheres, Method, Output, Scene, explicit
from crosscheck.verdict import Judged, Judgement, bounded, worst

_DURATION = 24.0
#: Events at the same time as another one of a particle, the fewest and the most of them, and the time of the first, see
#: `_groups`.
_FEWEST, _MOST, _FIRST = 10, 11, 1.0


def _groups() -> tuple[Floats, Floats]:
    """Disks of diameter 1 in a box of 64 by 32; all numbers are exact in binary. Positions and velocities, (N, 2).

    Two disks meet one at rest between them, at t = 1 and others at t = 5: the third event of such a row, and the
    second, have a disk of the first. At t = 2 a disk reaches the floor as another one reaches it from above: whichever
    comes first, there are four events, three of which share a disk with one before. Two disks that touch are hit from
    both sides at t = 1: of five events three are ties, or four if one disk's impact goes through the row first. No ties are a pair that meets alone at t = 1,
    and a disk that meets two walls at once in a corner, in either order with the same end.
    """
    disks = [
        *(((10.0 + x, 8.0), (-v, 0.0)) for x, v in ((-2.0, -1.0), (0.0, 0.0), (2.0, 1.0))),
        *(((12.0 + x, 20.0), (-v, 0.0)) for x, v in ((-6.0, -1.0), (0.0, 0.0), (6.0, 1.0))),
        ((50.0, 2.5), (0.0, -1.0)),
        ((50.0, 5.5), (0.0, -2.0)),
        *(((20.0 + x, 26.0), (v, 0.0)) for x, v in ((0.0, 1.0), (2.0, 0.0), (3.0, 0.0), (5.0, -1.0))),
        ((30.0, 12.0), (1.0, 0.0)),
        ((33.0, 12.0), (-1.0, 0.0)),
        ((62.5, 30.5), (0.5, 0.5)),
    ]
    positions, velocities = zip(*disks, strict=True)
    return np.array(positions), np.array(velocities)


def _scene(positions: Floats, velocities: Floats) -> Scene:
    return Scene(
        name="ties",
        dimension=2,
        duration=_DURATION,
        hard_spheres=HardSpheres(),
        box=Box(lengths=(64.0, 32.0), boundaries=("hard", "hard")),
        initial=explicit(positions, velocities),
        output=Output(interval=_DURATION / 8, observables=("collisions",)),
    )


def _said(run: Run) -> tuple[int, float]:
    """The number of ties, and the time of the first, of the run's remark; 0 and not-a-number without one."""
    found = [re.search(r"^(\d+) events? .* same time.* t = ([^ ,:]+)", text) for text in run.remarks]
    numbers = [(int(one[1]), float(one[2])) for one in found if one is not None]
    return numbers[0] if numbers else (0, float("nan"))


def _judge(laboratory: Laboratory, _: str) -> Judged:
    positions, velocities = _groups()
    moved = positions.copy()
    moved[:, 0] += 2.0**-20 * np.arange(len(moved)) ** 2  # no two events are at one time any more
    moved[7, 1] += 2.0**-20
    judged: list[Judgement] = []
    for scheme, claims in laboratory.claims.items():
        if claims.kind != EVENT_DRIVEN:
            continue
        number, first = _said(laboratory.run(_scene(positions, velocities), Method(scheme=scheme)))
        alone, _never = _said(laboratory.run(_scene(moved, velocities), Method(scheme=scheme)))
        judged += [
            bounded(
                f"{scheme}: ties that the run remarks, too many or few",
                float(max(_FEWEST - number, number - _MOST, 0)),
                0.0,
                "exact",
            ),
            bounded(f"{scheme}: time of the first of them, error", abs(first - _FIRST), 0.0, "exact in binary"),
            bounded(f"{scheme}: ties remarked where there are none", float(alone), 0.0, "exact"),
        ]
    return worst(judged, f"{len(positions)} disks")


CHECKS = (
    Check(
        name="events/ties",
        title="Events of one particle at one time are remarked",
        equation="|t_a - t_b| within rounding, of two events of a particle with different partners",
        criterion="exact: counted by hand, in binary numbers",
        citation="Lubachevsky, J. Comput. Phys. 94, 255 (1991)",
        judge=_judge,
        variants=variants_of({"groups": "all"}),
        faults=(
            (
                "groups",
                Fault(
                    "ties-with-the-same-partner-alone",
                    "events/kernels/loop.py",
                    "    simultaneous[0] += 1.0\n",
                    "    simultaneous[0] = 1.0\n",
                    "of several ties, only one is counted",
                ),
            ),
        ),
        needs=replace(event_driven("box.boundaries=hard"), promises=("ties",)),
        interpreted=True,
    ),
)
