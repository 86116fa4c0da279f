"""Many small disks that gather in the well of a large one: full cells and long lists of partners, event by event."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full, quick
from crosscheck.checks.events.gases import event_driven
from crosscheck.faults import Fault
from crosscheck.references.event_audit import KINDS, Audit, audit
from crosscheck.scene import Box, HardSpheres, Output, Scene, Well, explicit
from crosscheck.verdict import Judged, Judgement, bounded, round_off, worst

#: Small disks; how many of them are in the well of the large one at once, at least; number of the large one.
SMALL, GATHERED, LARGE = 24, 20, 9
_DEPTH, _DIAMETERS, _MASSES = 0.5, (1.0, 6.0), (1.0, 40.0)
_LENGTHS = (26.0, 24.0)
#: Radius of the ring of small disks at the start, and the duration: the first ones rebound and leave.
_RING, _DURATION = 9.0, 8.0


#: Radius of a ring all of which is in the well of the large disk.
_WITHIN = 4.2
#: Words of these scenes.
CROWDED = "dimension=2 hard_spheres.diameter[] hard_spheres.well masses[] box.boundaries=periodic"


class _Start(NamedTuple):
    """seed: of the velocities. radius: of the ring at the start."""

    seed: int
    radius: float = _RING


def crowd(seed: int, radius: float = _RING) -> Scene:
    """A ring of small disks that move towards a large one in its middle, which attracts them, and they each other.

    seed: of their velocities. radius: of the ring at the start.
    """
    rng = np.random.default_rng(seed)
    angles = 2 * np.pi * np.arange(SMALL) / SMALL
    out = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    along = np.stack([-out[:, 1], out[:, 0]], axis=1)
    x = np.array(_LENGTHS) / 2 + radius * out
    v = -rng.uniform(0.95, 1.05, (SMALL, 1)) * out + rng.uniform(-0.05, 0.05, (SMALL, 1)) * along
    species = np.insert(np.zeros(SMALL, int), LARGE, 1)
    return Scene(
        name="crowd",
        dimension=2,
        duration=_DURATION,
        hard_spheres=HardSpheres(diameter=_DIAMETERS, well=Well(depth=_DEPTH, range=1.3)),
        box=Box(lengths=_LENGTHS),
        masses=tuple(np.array(_MASSES)[species].tolist()),
        species=tuple(species.tolist()),
        initial=explicit(
            np.insert(x, LARGE, np.array(_LENGTHS) / 2, axis=0), np.insert(v, LARGE, (0.02, -0.03), axis=0)
        ),
        output=Output(
            interval=_DURATION / 40, observables=("kinetic_energy", "potential_energy"), trajectory=True, trace=True
        ),
    )


#: Points on a lattice of so many a side, that shrinks by a third; sides of the box; a disk among them.
_POINTS, _BOX, _DISK = 16, 12.0, 2.0


def shrinking(seed: int) -> Scene:
    """Points that all move towards the middle of a lattice, so that all cells there fill alike; and a disk that is hit.

    seed: of what their places are off the lattice.
    """
    rng = np.random.default_rng(seed)
    places = np.stack(np.meshgrid(*[np.arange(_POINTS) + 0.5] * 2, indexing="ij"), axis=-1).reshape(-1, 2)
    x = (places + rng.uniform(-0.1, 0.1, places.shape)) * (_BOX / _POINTS)
    middle = np.array([_BOX / 2] * 2)
    x = x[np.linalg.norm(x - middle, axis=1) > 0.6 * _DISK]
    return Scene(
        name="shrinking",
        dimension=2,
        duration=0.3,
        hard_spheres=HardSpheres(diameter=(0.0, _DISK)),
        box=Box(lengths=(_BOX,) * 2),
        masses=(*(1.0,) * len(x), 50.0),
        species=(*(0,) * len(x), 1),
        initial=explicit(np.vstack([x, middle]), np.vstack([middle - x, [0.03, -0.02]])),
        output=Output(interval=0.1, observables=("kinetic_energy",), trajectory=True, trace=True),
    )


def in_rounding(found: Audit) -> list[Judgement]:
    """A judgement of each kind of deviation, in its rounding; found: by an audit."""
    return [
        round_off(f"{kind}: largest error, in its rounding", share, 1.0, KINDS.get(kind, "of its terms"),
                  note=found.where.get(kind, ""))
        for kind, share in found.shares.items()
    ]  # fmt: skip


def _judge(laboratory: Laboratory, start: _Start) -> Judged:
    scene = crowd(*start)
    run = laboratory.run(scene, EVENT_DRIVEN)
    found = audit(scene, run)
    judgements = in_rounding(found)
    bonds = -float(run["potential_energy"].min()) / _DEPTH
    why = "so many partners that tables which were laid out for an ordinary liquid are too small"
    judgements.append(bounded("pairs in their wells at once", bonds, GATHERED, why, at_least=True, control=True))
    return worst(judgements, f"{found.events} events, up to {bonds:.0f} pairs in their wells")


def _judge_shrinking(laboratory: Laboratory, _: str) -> Judged:
    scene = shrinking(laboratory.seed())
    found = audit(scene, laboratory.run(scene, EVENT_DRIVEN))
    return worst(in_rounding(found), f"{found.events} events among {scene.number} particles")


CHECKS = (
    Check(
        name="events/audit-shrinking",
        title="Points that gather, all cells alike, around a disk: every event against the definitions",
        equation="as events/audit",
        criterion="each number to its rounding",
        citation="Rapaport, J. Comput. Phys. 34, 184 (1980), on cells and their occupants",
        judge=_judge_shrinking,
        variants=quick("points"),
        needs=event_driven(
            "dimension=2 hard_spheres.diameter[] masses[] box.boundaries=periodic",
            "positions velocities kinetic_energy event_times event_partners event_positions event_velocities",
        ),
        interpreted=True,
        faults=(
            (
                "points",
                Fault(
                    "points-hit-nothing",
                    "events/kernels/loop.py",
                    "if s > 0.0 and (c > grid.near * s2",
                    "if s > 1.0 and (c > grid.near * s2",
                    "points and a disk of diameter 2, whose distance at contact is 1, pass through each other",
                ),
            ),
        ),
    ),
    Check(
        name="events/audit-crowd",
        title="Small disks that gather around a large one, in its well: every event against the definitions",
        equation="as events/audit",
        criterion="each number to its rounding",
        citation="Alder & Wainwright, J. Chem. Phys. 31, 459 (1959)",
        judge=_judge,
        # the event for which there is no room: in `refimpl`, the large disk is its first or its second partner
        variants=(
            *quick(first=_Start(3), second=_Start(10), gathered=_Start(3, _WITHIN)),
            *full(**{f"other-{seed}": _Start(seed, _RING if seed % 2 else _WITHIN) for seed in range(20, 28)}),
        ),
        needs=event_driven(
            CROWDED,
            "positions velocities kinetic_energy potential_energy "
            "event_times event_partners event_positions event_velocities",
        ),
        interpreted=True,
        faults=(
            (
                "first",
                Fault(
                    "partners-forgotten",
                    "events/simulation.py",
                    "bonds = np.pad(particles.bonds, ((0, 0), (0, particles.bonds.shape[1])))",
                    "bonds = np.pad(particles.bonds[:, ::-1], ((0, 0), (0, particles.bonds.shape[1])))[:, ::-1]\n"
                    "            bonds = np.ascontiguousarray(np.roll(bonds, 1, axis=1))",
                    "lists of partners in wells are moved when they get more room",
                ),
            ),
        ),
    ),
)
