"""Hard disks by a search for collisions after each time step, beside event-driven ones.

Literature: H. Rein and S.-F. Liu, Astron. Astrophys. 537, A128 (2012).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, variants_of
from crosscheck.checks.events.cooling import RESTITUTION_SQUARED
from crosscheck.checks.granular.gases import convergence, energies, relaxed
from crosscheck.checks.granular.soft_grains import REFERENCE
from crosscheck.convergence import WHY_ORDER
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Run
from crosscheck.scene import Box, HardSpheres, Lattice, Method, Output, Scene
from crosscheck.verdict import Judged

#: Steps of the search (time), and the states that each is run from.
STEPS = (0.2, 0.1, 0.05, 0.025, 0.0125)
_STATES = 64
#: Engine that an event-driven one is judged beside; and its fastest scheme, a search by a tree.
_SEARCHER, _TREE = "rebound", "collisions_tree"


def _collisions(run: Run) -> float:
    return float(run["collisions"][-1])


def _last_energy(run: Run) -> float:
    return float(energies(run)[-1])


class _Gas(NamedTuple):
    """A gas of this restitution, and what is measured of it at its end."""

    quantity: str
    restitution: float
    measure: Callable[[Run], float]


_GASES = {
    "collision-rate": _Gas("number of collisions over event-driven", 1.0, _collisions),
    "cooling": _Gas("T over event-driven", 0.8, _last_energy),
}


def _judge_search(laboratory: Laboratory, gas: _Gas) -> Judged:
    """Collisions that are found after a step are up to a step late.

    An engine that searches for them is judged beside the event-driven reference; an event-driven one beside REBOUND.
    """
    searches = [name for name, claims in laboratory.claims.items() if claims.kind == "collision_search"]
    searcher, scheme = (None, _TREE if _TREE in searches else searches[0]) if searches else (_SEARCHER, _TREE)
    scene = Scene(
        name="search",
        dimension=2,
        duration=2.0,
        hard_spheres=HardSpheres(restitution=gas.restitution),
        box=Box(packing_fraction=0.3),
        initial=Lattice(kind="lattice", structure="square", number=400, temperature=1.0, seed=0),
        output=Output(interval=2.0, observables=("kinetic_energy", "collisions")),
    )
    reference = REFERENCE if searches else None
    laboratory.demand(scene, Method(scheme=scheme, dt=STEPS[0]) if searches else EVENT_DRIVEN)
    starts = [relaxed(laboratory, scene, f"state {i}", 5.0) for i in range(_STATES)]
    hard = [gas.measure(laboratory.run(start, EVENT_DRIVEN, engine=reference)) for start in starts]
    found = []
    for dt in STEPS:
        method = Method(scheme=scheme, dt=dt)
        found.append(np.array([gas.measure(laboratory.run(start, method, engine=searcher)) for start in starts]))
    return convergence(
        gas.quantity,
        searcher or laboratory.engine,
        "1/dt",
        1 / np.array(STEPS),
        found,
        np.array(hard),
        1.0,
        f"collisions are late by dt/2 in the mean: {WHY_ORDER}",
    )


_NEEDS = Needs(
    "hard_spheres",
    ("collision_search", EVENT_DRIVEN),
    frozenset({"dimension=2", "box.boundaries=periodic"}),
    frozenset({"kinetic_energy", "collisions"}),
)
CHECKS = (
    Check(
        name="granular/collision-search",
        title="Hard disks of a code that looks for collisions after each step, beside event-driven ones",
        equation="nu(dt)/nu - 1, T(dt)/T - 1 ~ dt",
        criterion="the fitted power of dt is 1 within a quarter; the smallest step agrees within errors",
        citation="Rein & Liu, Astron. Astrophys. 537, A128 (2012)",
        judge=_judge_search,
        variants=variants_of(_GASES, "full"),
        needs=_NEEDS,
        faults=(("cooling", RESTITUTION_SQUARED),),
    ),
)
