"""Operations of soft grains: evaluations of the force, pairs of the list, lists made."""

from __future__ import annotations

from dataclasses import replace

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.granular.soft_grains import CONTACTS, soft_needs
from crosscheck.checks.operations import CRITERION, EQUATION, as_known, at_most, counted, counting, exactly
from crosscheck.faults import Fault
from crosscheck.scene import Box, Contact, HardSpheres, Lattice, Method, Output, Scene
from crosscheck.verdict import Judged, worst

_GRAINS, _STEPS, _DT = 144, 50, 0.005
#: Lists reach 0.3 diameters beyond the contact; the first one has too little room, and is made twice.
_KNOWN = {"pair_tests": 11388, "list_builds": 10, "list_tests": 7827}
#: Without a box they spread, and cells follow them.
_KNOWN_OPEN = {"pair_tests": 9948, "list_builds": 12, "list_tests": 8937}


def _scene(open_: bool) -> Scene:
    """Disks from the same start whatever the seed: counts are known of it."""
    return Scene(
        name=f"soft-disks-{_GRAINS}",
        dimension=2,
        duration=_STEPS * _DT,
        hard_spheres=HardSpheres(),
        box=Box(density=0.7, boundaries=("open", "open") if open_ else None),
        initial=Lattice(kind="lattice", structure="square", number=_GRAINS, temperature=4.0, seed=3),
        output=Output(),
    )


def _judge(laboratory: Laboratory, open_: bool) -> Judged:
    method = Method(scheme="velocity_verlet", dt=_DT, contact=Contact(stiffness=1e3))
    cost = laboratory.run(_scene(open_), method).cost
    builds, pairs = counted(cost, "list_builds"), _GRAINS * (_GRAINS - 1) / 2
    # grains within a list: six in contact, twelve more between them and the next ones, from one side
    why_list = "a list holds the grains nearly in contact, not those two diameters away"
    judged = [
        exactly("evaluations of the force", cost.evaluations, _STEPS + 1),
        at_most("lists made, over steps", builds / _STEPS, 0.5, "a list is good for several steps"),
        at_most("distances for a list, over all pairs", counted(cost, "list_tests") / (builds * pairs), 0.25, "cells"),
        at_most("pairs of the list a grain", counted(cost, "pair_tests") / (_GRAINS * cost.evaluations), 9.0, why_list),
    ]
    known = _KNOWN_OPEN if open_ else _KNOWN
    return worst([*judged, *as_known(laboratory, cost, known)], f"{_STEPS} steps of {_GRAINS} disks")


CHECKS = (
    Check(
        name="granular/operations",
        title="Operations of time steps of soft grains",
        equation=EQUATION,
        criterion=CRITERION,
        citation="Allen & Tildesley, Computer Simulation of Liquids (1987), section 5.3",
        judge=_judge,
        variants=(
            Variant("velocity_verlet", False),
            Variant("open", True, needs=soft_needs("box.boundaries=open")),
        ),
        needs=replace(counting(soft_needs()), schemes=("velocity_verlet",)),
        interpreted=True,
        faults=(
            (
                "velocity_verlet",
                Fault(
                    "all-pairs",
                    CONTACTS,
                    "cells[k] = max(1, int(min(number, extent / reach)))",
                    "cells[k] = 1",
                    "lists are made from all pairs",
                ),
            ),
        ),
    ),
)
