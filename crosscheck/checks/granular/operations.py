"""Operations of soft grains: evaluations of the force, pairs of the list, lists made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.granular.soft_grains import LISTS, soft_needs
from crosscheck.checks.operations import CRITERION, EQUATION, as_known, at_most, counted, counting, exactly
from crosscheck.faults import Fault
from crosscheck.scene import Box, Contact, HardSpheres, Lattice, Method, Output, Scene, explicit
from crosscheck.verdict import Judged, worst

_GRAINS, _STEPS, _DT = 144, 50, 0.005
#: The wide lists reach 0.3 diameters beyond the contact; the first one has too little room, and is made twice. The
#: close ones reach a tenth of that, which the fastest disk crosses in two steps.
_KNOWN = {"pair_tests": 720, "list_builds": 3, "list_prunings": 26, "list_tests": 9776}
#: Without a box they spread, and cells follow them.
_KNOWN_OPEN = {"pair_tests": 651, "list_builds": 3, "list_prunings": 26, "list_tests": 8979}
#: More cells than spheres are halved along the longer sides, and a layer has one cell across.
_KNOWN_LAYER = {"list_builds": 10, "list_prunings": 50, "list_tests": 252}


class _Case(NamedTuple):
    """scene: of soft grains. known: counts of `refimpl`."""

    scene: Scene
    known: Mapping[str, float]


def _scene(open_: bool) -> Scene:
    """Disks from the same start whatever the seed: counts are known of it."""
    return Scene(
        name=f"soft-disks-{_GRAINS}",
        dimension=2,
        duration=_STEPS * _DT,
        hard_spheres=HardSpheres(),
        box=Box(density=0.7, boundaries=("open", "open") if open_ else None),
        initial=Lattice(kind="lattice", structure="square", number=_GRAINS, temperature=0.25, seed=3),
        output=Output(),
    )


def _layer() -> Scene:
    """Few spheres side by side, far apart, in a layer that is thinner than they are."""
    places = np.stack([*np.meshgrid(10.0 * np.arange(12), 10.0 * np.arange(12)), 0.1 * np.eye(12)], axis=-1)
    return Scene(
        name="layer",
        dimension=3,
        duration=_STEPS * _DT,
        hard_spheres=HardSpheres(),
        initial=explicit(places.reshape(-1, 3), np.random.default_rng(3).normal(size=(_GRAINS, 3)) * [2.0, 2.0, 0.5]),
    )


def _judge(laboratory: Laboratory, case: _Case) -> Judged:
    method = Method(scheme="velocity_verlet", dt=_DT, contact=Contact(stiffness=1e3))
    cost = laboratory.run(case.scene, method).cost
    builds, pairs = counted(cost, "list_builds"), _GRAINS * (_GRAINS - 1) / 2
    lists = builds + (cost.list_prunings or 0)
    # grains within a list: six in contact, twelve more between them and the next ones, from one side
    why_list = "a list holds the grains nearly in contact, not those two diameters away"
    judged = [
        exactly("evaluations of the force", cost.evaluations, _STEPS + 1),
        at_most("lists made, over steps", builds / _STEPS, 0.5, "a list is good for several steps"),
        at_most("distances for a list, over all pairs", counted(cost, "list_tests") / (lists * pairs), 0.25, "cells"),
        at_most("pairs of the list a grain", counted(cost, "pair_tests") / (_GRAINS * cost.evaluations), 9.0, why_list),
    ]
    return worst([*judged, *as_known(laboratory, cost, case.known)], f"{_STEPS} steps of {_GRAINS} grains")


ALL_PAIRS = Fault(
    "all-pairs",
    LISTS,
    "cells[k] = max(1, int(min(number, extent / reach)))",
    "cells[k] = 1",
    "lists are made from all pairs",
)

CHECKS = (
    Check(
        name="granular/operations",
        title="Operations of time steps of soft grains",
        equation=EQUATION,
        criterion=CRITERION,
        citation="Allen & Tildesley, Computer Simulation of Liquids (1987), section 5.3",
        judge=_judge,
        variants=(
            Variant("velocity_verlet", _Case(_scene(False), _KNOWN)),
            Variant("open", _Case(_scene(True), _KNOWN_OPEN), needs=soft_needs("box.boundaries=open")),
            Variant("layer", _Case(_layer(), _KNOWN_LAYER), needs=soft_needs("dimension=3 box.boundaries=open")),
        ),
        needs=replace(counting(soft_needs()), schemes=("velocity_verlet",)),
        interpreted=True,
        faults=(
            (
                "velocity_verlet",
                ALL_PAIRS,
            ),
        ),
    ),
)
