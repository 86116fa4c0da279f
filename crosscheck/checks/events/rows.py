"""Rows of particles that collapse: three that approach each other, and N thrown at a wall or at a fixed particle."""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

from crosscheck.engines.protocol import Run
from crosscheck.references.collapse import THREE_PARTICLE_COLLAPSE, wall_collapse
from crosscheck.scene import Box, Face, Floats, HardSpheres, Output, Scene, explicit


def reported_time(run: Run) -> float:
    """Time of the inelastic collapse that ended `run`, read from the reason that the engine reports.

    NaN if no collapse is reported, or if the report names no particle.
    """
    found = re.search(r"particles? \d+.*t = ([-+.\de]+)", run.stopped)
    return float(found[1]) if found else np.nan


def reported_partners(run: Run) -> frozenset[int]:
    """Numbers of the particles whose collapse ended `run`, read from the reason that the engine reports."""
    found = re.search(r"particles? (\d+)(?: and (\d+))?", run.stopped)
    return frozenset(int(one) for one in (found.groups() if found else ()) if one is not None)


class Row(NamedTuple):
    """Particles in a row along x.

    gaps: between surfaces, (N - 1,), with a wall (N,). velocities: along x, (N,). wall: there is one before the first.
    limit: restitution below which they collapse. below, above: restitutions next to the limit. fixed: a particle that
    never moves is in the place of the wall.
    """

    gaps: Floats
    velocities: Floats
    wall: bool
    limit: float
    below: float
    above: float
    fixed: bool = False


def _thrown(number: int, fixed: bool = False) -> Row:
    """`number` particles with equal velocities towards a wall, or a fixed particle."""
    limit = wall_collapse(number)
    gaps = np.linspace(1.0, 0.9 + 0.1 * number, number)
    return Row(gaps, np.full(number, -1.0), True, limit, 0.97 * limit, 1.03 * limit, fixed)


#: The velocities of the three are those in the frame of their centre of mass, so that they may shrink without rounding.
ROWS = {
    "three": Row(np.array([1.0, 1.3]), np.array([14.0, -1.0, -13.0]) / 15, False, THREE_PARTICLE_COLLAPSE, 0.07, 0.073),
    **{f"wall-{number}": _thrown(number) for number in (2, 3, 5)},
    "fixed-2": _thrown(2, fixed=True),
}


def row_scene(row: Row, alpha: float, duration: float, contact_duration: float | None = None) -> Scene:
    """Disks of diameter 1 in a row along x; x = 0 is a wall, or touches a fixed disk, or there is none; others are far.

    row: gaps and velocities at the start. alpha: restitution of all impacts. duration: of the run. contact_duration:
    t_c of the TC model; None without it.
    """
    gaps, velocities = row.gaps[row.wall and not row.fixed :], row.velocities
    start = 4.0
    if row.fixed:
        start, velocities = 0.5, np.insert(velocities, 0, 0.0)
    elif row.wall:
        start = 0.5 + row.gaps[0]
    x = start + np.concatenate([[0.0], np.cumsum(1 + gaps)])
    number = x.size
    length = float(x[-1] + 4.0)
    return Scene(
        name="row",
        dimension=2,
        duration=duration,
        hard_spheres=HardSpheres(
            restitution=alpha, contact_duration=contact_duration, fixed=(1,) if row.fixed else None
        ),
        species=(1,) + (0,) * (number - 1) if row.fixed else None,
        box=Box(
            lengths=(length, 4.0),
            boundaries=("hard", "hard"),
            faces={
                "x-": Face(restitution=alpha) if row.wall and not row.fixed else Face(open=True),
                "x+": Face(open=True),
            },
        ),
        initial=explicit(np.stack([x, np.full(number, 2.0)], axis=1), np.stack([velocities, np.zeros(number)], axis=1)),
        output=Output(interval=duration, observables=("collisions", "wall_collisions", "kinetic_energy")),
    )
