"""Dense periodic gases on fields: impulses that go round corners of cells, small and wide, and round the box."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, Variant
from crosscheck.checks.events.audit_crowd import in_rounding
from crosscheck.checks.events.gases import event_driven
from crosscheck.engines.capabilities import words
from crosscheck.faults import Fault
from crosscheck.references.event_audit import audit
from crosscheck.scene import Box, HardSpheres, Output, Scene, explicit
from crosscheck.verdict import Judged, bounded, worst

#: Of the collisions of a run so many go through two faces or more, one of them an end of the box.
_CORNERS = 3


class _Gas(NamedTuple):
    """Spheres on a lattice of so many a side, whose sites have these sides; cells of fields, and collisions of a run.

    Where a cell holds several sites, an algorithm that searches cells of its own has several of these in each.
    """

    sites: tuple[int, ...]
    spacing: tuple[float, ...]
    cells: tuple[int, ...]
    collisions: int = 150


_GASES = {
    "2d": _Gas((3, 4), (1.21, 1.33), (3, 4)),
    "2d-wide": _Gas((4, 4), (1.21, 1.33), (2, 2), 400),
    "3d": _Gas((3, 3, 4), (1.25, 1.19, 1.31), (3, 3, 4)),
}


def _scene(gas: _Gas, seed: int) -> Scene:
    """Unlike masses and sizes, dissipation, and a start in other images."""
    rng = np.random.default_rng(seed)
    lengths = np.multiply(gas.sites, gas.spacing)
    places = np.stack(np.meshgrid(*map(np.arange, gas.sites), indexing="ij"), axis=-1).reshape(-1, len(gas.sites))
    number = len(places)
    x = (places + rng.uniform(0.45, 0.55, places.shape)) * gas.spacing + lengths * rng.integers(-1, 2, places.shape)
    return Scene(
        name="corners",
        dimension=len(gas.sites),  # type: ignore[arg-type]
        duration=1e3,
        hard_spheres=HardSpheres(diameter=(1.0, 0.9), restitution=0.97),
        box=Box(lengths=tuple(lengths.tolist())),
        masses=tuple(rng.uniform(0.5, 2.0, number).tolist()),
        species=tuple((np.arange(number) % 2).tolist()),
        initial=explicit(x, np.asarray(rng.normal(size=x.shape))),
        output=Output(collisions=(gas.collisions,), trace=True, fields=gas.cells),
    )


def _round_corners(scene: Scene, partners: np.ndarray, positions: np.ndarray) -> int:
    """Collisions along whose line of centres two axes or more leave a cell, one of them through an end of the box."""
    lengths, cells = np.asarray(scene.lengths()), np.asarray(scene.output.fields)
    pairs = positions[(partners >= 0).all(axis=1)]
    inside = pairs - lengths * np.floor(pairs / lengths)
    blocks = np.floor(inside / lengths * cells)
    crossed = blocks[:, 0] != blocks[:, 1]
    ends = abs(inside[:, 0] - inside[:, 1]) > lengths / 2
    return int(((crossed.sum(axis=1) > 1) & (crossed & ends).any(axis=1)).sum())


def _judge(laboratory: Laboratory, gas: _Gas) -> Judged:
    scene = _scene(gas, laboratory.seed())
    run = laboratory.run(scene, EVENT_DRIVEN)
    found = audit(scene, run)
    corners = _round_corners(scene, run["event_partners"], run["event_positions"])
    why = "what does not happen is not judged"
    control = bounded(
        "collisions round a corner at an end of the box", corners, _CORNERS, why, at_least=True, control=True
    )
    return worst([*in_rounding(found), control], f"{found.events} events, {corners} of them round corners")


CHECKS = (
    Check(
        name="events/audit-corners",
        title="Impulses that go through several faces of cells, and round the box: fields against the trace",
        equation="momentum and energy go along the line of centres, through each face that it crosses",
        criterion="each number to its rounding",
        citation="Irving & Kirkwood, J. Chem. Phys. 18, 817 (1950)",
        judge=_judge,
        variants=tuple(
            Variant(name, gas, needs=event_driven(" ".join(words(_scene(gas, 0))))) for name, gas in _GASES.items()
        ),
        needs=event_driven("", "event_times event_partners event_positions event_velocities"),
        interpreted=True,
        faults=(
            (
                "2d",
                Fault(
                    "down-and-round-the-box",
                    "events/kernels/measure.py",
                    "return place - stride if here > 0 else place + (shape[axis] - 1) * stride",
                    "return place - stride if here > 0 else place",
                    "an impulse that leaves the lowest cell downwards is not in the highest one then",
                ),
            ),
        ),
    ),
)
