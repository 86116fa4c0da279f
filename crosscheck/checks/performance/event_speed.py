"""Speed of event-driven hard spheres beside the fastest programs of others, where their binaries are at hand.

Both start from the same state in equilibrium; collisions per CPU second are compared in turns, and the collision rates,
which must be those of one gas, within their standard errors.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, Variant
from crosscheck.checks.events.gases import event_driven, spheres
from crosscheck.checks.performance.event_peers import Spheres, Stretch, binary, dynamo_stretch, edmd_stretch
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.scene import HardSpheres, Observable, Output, Scene, Well, explicit
from crosscheck.scene.observables import OPERATIONS
from crosscheck.statistics import mean_of_stretches
from crosscheck.verdict import Judged, bounded, statistical, worst

#: Turns of each program, and samples of its collision rate; the median ratio counts, so that a disturbed turn does not.
TURNS = 11
#: The share of the goal that is asked for.
ASKED = 0.9
#: Collisions of a particle until the lattice has melted, as those of pairs over N.
SETTLING = 10
#: Rows of the trace and samples cost time: collisions alone.
_ALONE: tuple[Observable, ...] = ("collisions",)
#: Events that are none of both partners' states: they do not change a velocity.
_OWN = ("cell_crossings", "invalid_events", "renewals", "list_builds")


class _Gas(NamedTuple):
    """A gas beside a peer: its name, the goal, packing fraction, number; and its law of collisions."""

    peer: str
    goal: float
    packing: float
    number: int
    law: HardSpheres = HardSpheres()


def _start(laboratory: Laboratory, gas: _Gas) -> tuple[Scene, Spheres]:
    """The gas in equilibrium, as a scene and as peers get it."""
    density = gas.packing * 6 / math.pi
    melt = spheres(gas.number, density, laboratory.seed() % 2**31, duration=1e6, hard_spheres=gas.law)
    settled = Output(collisions=(SETTLING * melt.number,), observables=_ALONE)
    end = laboratory.run(melt.changed(output=settled), EVENT_DRIVEN)
    side = (melt.number / density) ** (1 / 3)
    x, v = end["final_positions"] % side, end["final_velocities"]
    well = gas.law.well
    peer = Spheres(x, v, side, gas.law.restitution or 1.0, None if well is None else (well.depth, well.range))
    return melt.changed(initial=explicit(x, v)), peer


def _ours(laboratory: Laboratory, scene: Scene, collisions: int) -> Stretch:
    run = laboratory.run(scene.changed(output=Output(collisions=(collisions,), observables=_ALONE)), EVENT_DRIVEN)
    return Stretch(collisions, run.cost.cpu, float(run["time"][-1]))


def _changes_per_collision(laboratory: Laboratory, scene: Scene, collisions: int) -> float:
    """Events that change velocities, over collisions: at the edges of wells there are others."""
    counted = Output(
        collisions=(collisions // 10, collisions), observables=("collisions", "events", "operation_counts")
    )
    run = laboratory.run(scene.changed(output=counted), EVENT_DRIVEN)
    own = run["operation_counts"][:, [OPERATIONS.index(name) for name in _OWN]].sum(axis=1)
    changes = np.diff(run["events"] - own)[-1]
    return float(changes / np.diff(run["collisions"])[-1])


def _judge(laboratory: Laboratory, gas: _Gas) -> Judged:
    edmd = gas.peer == "EDMD"
    path = binary("edmd", "CROSSCHECK_EDMD") if edmd else binary("dynarun", "CROSSCHECK_DYNARUN")
    scene, start = _start(laboratory, gas)
    collisions = max(300_000, 2 * scene.number)
    changes = 1.0 if gas.law.well is None else _changes_per_collision(laboratory, scene, collisions)
    ours: list[Stretch] = []
    theirs: list[Stretch] = []
    for turn in range(TURNS + 1):
        mine = _ours(laboratory, scene, collisions)
        if edmd:
            other = edmd_stretch(path, start, SETTLING * gas.number, max(mine.cpu, 0.5))
        else:
            other = dynamo_stretch(path, start, round(collisions * changes))
        if turn:  # the first turn warms caches
            ours.append(mine._replace(events=round(mine.events * changes)))
            theirs.append(other)
        run = laboratory.run(scene.changed(duration=mine.time, output=Output(interval=mine.time)), EVENT_DRIVEN)
        scene = scene.changed(initial=explicit(run["final_positions"] % start.side, run["final_velocities"]))
        start = start._replace(positions=run["final_positions"] % start.side, velocities=run["final_velocities"])
    ratios = np.array([a.events / a.cpu / (b.events / b.cpu) for a, b in zip(ours, theirs, strict=True)])
    rates = [mean_of_stretches([s.events / s.time / scene.number for s in found]) for found in (ours, theirs)]
    per_second = [float(np.median([s.events / s.cpu for s in found])) for found in (ours, theirs)]
    return worst(
        [
            bounded(
                f"collisions per CPU second, ratio to {gas.peer}",
                float(np.median(ratios)),
                ASKED * gas.goal,
                f"{ASKED:g} of the goal, {gas.goal:g}; median of {TURNS} alternated turns, "
                f"of {ratios.min():.2f} ... {ratios.max():.2f}",
                at_least=True,
                note=f"{per_second[0]:.3g} and {per_second[1]:.3g} per CPU second",
            ),
            statistical(
                f"collisions per particle and time, ours and {gas.peer}'s",
                rates[0].value,
                rates[0].error,
                rates[1].value,
                rates[1].error,
                "one gas in one state",
                samples=rates,
                # a thermostat, or another total momentum: temperatures differ by some 1/N
                doubt=2.0 / scene.number * rates[1].value,
            ),
        ]
    )


def _gases() -> dict[str, _Gas]:
    found = {}
    for number in (1372, 10976, 97556):
        for packing in (0.26, 0.35, 0.45):
            found[f"edmd-{packing:g}-N{number}"] = _Gas("EDMD", 1.3, packing, number)
        found[f"dynamo-0.26-N{number}"] = _Gas("DynamO", 8.0, 0.26, number)
    for number in (1372, 10976):
        wells = HardSpheres(well=Well(depth=1.0, range=1.5))
        found[f"dynamo-wells-N{number}"] = _Gas("DynamO", 5.0, 0.26, number, wells)
        found[f"dynamo-grains-N{number}"] = _Gas("DynamO", 5.0, 0.26, number, HardSpheres(restitution=0.999999))
    return found


def _words(law: HardSpheres) -> Needs | None:
    """What a law of collisions asks of an engine beside what all gases ask."""
    if law.well is not None:
        return event_driven("hard_spheres.well")
    return None if law.restitution is None else event_driven("hard_spheres.restitution")


CHECKS = (
    Check(
        name="performance/event-speed",
        title="Hard spheres: speed beside EDMD and DynamO",
        equation="collisions/CPU seconds",
        criterion=f"{ASKED:g} of 1.3 times EDMD, of 8 times DynamO, of 5 times for wells and grains, median of {TURNS} "
        "alternated turns, one thread, compilation apart; the same collision rate",
        citation="Smallenburg, EPJ E 45, 22 (2022); Bannerman, Sargant & Lue, J. Comput. Chem. 32, 3329 (2011)",
        judge=_judge,
        variants=tuple(Variant(name, gas, "full", _words(gas.law)) for name, gas in _gases().items()),
        needs=Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=frozenset(
                {
                    "dimension=3",
                    "box.boundaries=periodic",
                    "output.collisions",
                    "hard_spheres.restitution",
                    "hard_spheres.well",
                }
            ),
            observables=frozenset({"collisions", "events", "operation_counts"}),
            promises=("speed",),
        ),
        faults=(
            (
                "edmd-0.45-N1372",
                Fault(
                    "no-lists",
                    "events/simulation.py",
                    "return 2 * (in_cells - in_list) * x * (1 + x / 5) > 2 * PRICE",
                    "return False",
                    "dense gases have no lists of neighbours",
                ),
            ),
        ),
        timing=True,
    ),
)
