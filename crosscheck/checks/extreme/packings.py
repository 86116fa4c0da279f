"""Event-driven spheres near close packing, and so dilute that a free path is thousands of boxes."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Tier
from crosscheck.checks.events.gases import spheres
from crosscheck.checks.extreme.matrix import Bound, Case, Trial, extreme_check, for_each
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.scene import Box, Output, Scene

#: Collisions that take less time than to compile the loop for them.
_FEW = 1000
_OVERLAP = "deepest overlap at a collision, in diameters"
_DRIFT = "relative change of the energy"
_DEEP = Bound(_OVERLAP, 32 * EPSILON * 64, "32 roundings of a coordinate, in boxes that count as 64 diameters or less")


def _dense(trial: Trial, scene: Scene, collisions: int) -> Mapping[str, float]:
    """A crystal, for so many collisions: few of them as plain Python."""
    output = Output(collisions=(collisions,), observables=("kinetic_energy", "collisions", "deepest_overlap"))
    few = None if collisions <= _FEW else False
    run = trial.laboratory.run(scene.changed(duration=1e4, output=output), EVENT_DRIVEN, interpreted=few)
    return {
        _OVERLAP: float(run["deepest_overlap"][-1]),
        _DRIFT: float(abs(run["kinetic_energy"][-1] / run["kinetic_energy"][0] - 1)),
    }


def _crystal(trial: Trial, fraction: float, dimension: int, cells: int) -> Scene:
    """Spheres on a face-centred cubic lattice of cells^3 cells, or disks on a triangular one, in a box of its shape."""
    seed = trial.laboratory.seed() % 2**31
    if dimension == 3:
        number = 4 * cells**3
        return spheres(number, 1.0, seed, box=Box(packing_fraction=fraction))
    columns, rows = 6 * cells, 7 * cells + cells % 2
    spacing = (math.pi / (2 * 3**0.5 * fraction)) ** 0.5
    box = Box(lengths=(columns * spacing, rows * spacing * 3**0.5 / 2))
    return spheres(columns * rows, 1.0, seed, dimension=2, box=box)


def _dense_case(name: str, fraction: float, dimension: int, cells: int, collisions: int, tier: Tier) -> Case:
    number = 4 * cells**3 if dimension == 3 else 6 * cells * (7 * cells + cells % 2)
    why = "four roundings at each collision of a particle, all to one side: rounding has a bias, docs/events.md"
    return Case(
        name,
        f"packing fraction {fraction} in {dimension}D, {number} particles, {collisions} collisions",
        lambda trial: _dense(trial, _crystal(trial, fraction, dimension, cells), collisions),
        for_each((EVENT_DRIVEN,), _DEEP, Bound(_DRIFT, 4 * EPSILON * 2 * collisions / number, why)),
        tier,
        Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=frozenset({f"dimension={dimension}"}),
            observables=frozenset({"deepest_overlap", "kinetic_energy"}),
        ),
    )


_CONTACT = "error of the contact distance at a collision, over its rounding"


def _dilute(trial: Trial, density: float, collisions: int) -> Mapping[str, float]:
    """A gas whose free path is thousands of boxes."""
    scene = spheres(
        108,
        density,
        trial.laboratory.seed() % 2**31,
        duration=1e12,
        output=Output(collisions=tuple(range(1, collisions + 1)), trajectory=True),
    )
    lengths = scene.lengths()
    assert lengths is not None
    run = trial.laboratory.run(scene, EVENT_DRIVEN, interpreted=False)
    x = run["positions"][1:]
    errors = []
    for places in x:
        apart = places[:, None, :] - places[None, :, :]
        apart -= lengths * np.round(apart / lengths)
        errors.append(abs(np.linalg.norm(apart, axis=2)[np.triu_indices(len(places), 1)].min() - 1.0))
    # unwrapped positions are rounded as the flight is
    rounding = 64 * EPSILON * float(lengths[0]) + 4 * EPSILON * abs(x).max(axis=(1, 2))
    return {_CONTACT: float((np.array(errors) / rounding).max())}


CHECKS = (
    extreme_check(
        "packings",
        "Spheres at a packing of 0.72, disks at 0.90, and a gas of n sigma^3 = 1e-9",
        "|r_i - r_j| >= sigma at all times; sum m v^2/2 = const",
        "Lubachevsky, J. Comput. Phys. 94, 255 (1991); Alder & Wainwright, J. Chem. Phys. 31, 459 (1959)",
        (
            _dense_case("packing-0.72", 0.72, 3, 2, 100, "quick"),
            _dense_case("packing-0.90", 0.90, 2, 1, 200, "quick"),
            _dense_case("packing-0.72-many", 0.72, 3, 5, 200_000, "full"),
            _dense_case("packing-0.90-many", 0.90, 2, 4, 200_000, "full"),
            Case(
                "density-1e-9",
                "a gas of n sigma^3 = 1e-9, whose free path is 5e4 boxes",
                lambda trial: _dilute(trial, 1e-9, 4),
                for_each(
                    (EVENT_DRIVEN,),
                    Bound(
                        _CONTACT, 1.0, "64 roundings of a coordinate: of positions, and of a clock that crosses the box"
                    ),
                ),
                "full",
                Needs("hard_spheres", (EVENT_DRIVEN,), words=frozenset({"dimension=3"})),
            ),
        ),
        Needs("hard_spheres", (EVENT_DRIVEN,), words=frozenset({"box.boundaries=periodic"})),
        (
            (
                "packing-0.72/event_driven",
                Fault(
                    "missed-neighbours",
                    "events/kernels/loop.py",
                    "x0, x1, y0, y1, z0, z1 = cx - 1, cx + 1,",
                    "x0, x1, y0, y1, z0, z1 = cx - 1, cx,",
                    "particles in the cells to the right are not searched",
                ),
            ),
        ),
    ),
)
