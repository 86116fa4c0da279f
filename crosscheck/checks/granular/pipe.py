"""Rough disks that fall down a channel with rough walls: mass flux, event-driven and soft.

Literature: J. T. Jenkins and M. W. Richman, J. Fluid Mech. 171, 53 (1986); S. Luding et al., Phys. Rev. E 50, 4113
(1994).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full, soft
from crosscheck.checks.events.driven import run_whole, snapshot_figure
from crosscheck.checks.granular.driven import (
    Profile,
    against,
    against_duration,
    curves,
    hard_limit,
    listed,
    profile,
    trajectory,
)
from crosscheck.checks.granular.soft_grains import CONTACTS, REFERENCE, soft_needs
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Frame
from crosscheck.scene import Box, Face, Friction, GrainFriction, HardSpheres, Lattice, Output, Scene
from crosscheck.statistics import Mean, correlated_mean
from crosscheck.verdict import Judged, worst

_DURATIONS = (0.08, 0.04)
_WARM_UP = 200.0
_WIDTH = 8.0


def _pipe(seed: int, duration: float) -> Scene:
    """Rough inelastic disks that fall between two rough walls; all contacts stick, so that the laws have one limit."""
    wall = Face(restitution=0.9, friction=Friction(tangential_restitution=0.5))
    return Scene(
        name="pipe",
        dimension=2,
        duration=duration,
        acceleration=(0.1, 0.0),
        hard_spheres=HardSpheres(restitution=0.9, friction=GrainFriction(tangential_restitution=0.5)),
        box=Box(lengths=(12.0, _WIDTH), boundaries=("periodic", "hard"), faces={"y-": wall, "y+": wall}),
        initial=Lattice(kind="lattice", structure="square", number=48, temperature=1.0, seed=seed),
        output=Output(interval=1.0, trajectory=True),
    )


class _Pipe(NamedTuple):
    """Mass flux, <v_y^2>, and the velocity along the fall over the width."""

    flux: Mean
    temperature: Mean
    velocity: Profile


def _measured_pipe(run: Run) -> _Pipe:
    positions, velocities = trajectory(run, round(_WARM_UP))
    along, across = velocities[..., 0], velocities[..., 1]
    edges = np.linspace(0.5, _WIDTH - 0.5, 8)
    density = positions.shape[1] / 12.0
    return _Pipe(
        correlated_mean(density * along.mean(axis=1)),
        correlated_mean((across**2).mean(axis=1)),
        profile(positions[..., 1], along, edges),
    )


def _judge_pipe(laboratory: Laboratory, _: str) -> Judged:
    runs = [
        _measured_pipe(
            run_whole(
                laboratory,
                _pipe(laboratory.seed(f"soft-{part}"), 10000.0),
                soft(duration=t_c, resolution=1 / 40, friction="dashpot"),
            )
        )
        for part, t_c in enumerate(_DURATIONS)
    ]
    event_run = run_whole(laboratory, _pipe(laboratory.seed("event-driven"), 30000.0), EVENT_DRIVEN, REFERENCE)
    hard = _measured_pipe(event_run)
    fluxes, hot = [run.flux for run in runs], [run.temperature for run in runs]
    judgements = [
        against("mass flux", hard_limit(_DURATIONS, fluxes), hard.flux, 0.05),
        against("<v_y^2>", hard_limit(_DURATIONS, hot), hard.temperature, 0.08),
    ]
    y = 0.5 + (np.arange(7) + 0.5) * (_WIDTH - 1) / 7
    engine = laboratory.engine
    profiles = [run.velocity.means(run.velocity.mean) for run in runs]
    figures = (
        against_duration("Pipe: mass flux", "mass a unit of time", engine, _DURATIONS, fluxes, hard.flux),
        against_duration("Pipe: temperature across", "<v_y^2>", engine, _DURATIONS, hot, hard.temperature),
        Figure(
            "Pipe: velocity",
            "y",
            "velocity along the fall",
            series=curves(engine, y, _DURATIONS, profiles, hard.velocity.means(hard.velocity.mean)),
        ),
        snapshot_figure(
            "Pipe: grains",
            event_run,
            Frame(0.0, 12.0, 0.0, _WIDTH, ("bottom", "top")),
            12.0,
            event_run["final_velocities"][:, 0],
            "velocity along the fall",
        ),
    )
    note = f"flux: {listed(_DURATIONS, fluxes)}; <v_y^2>: {listed(_DURATIONS, hot)}"
    return worst(judgements, note, figures)


CHECKS = (
    Check(
        name="granular/pipe",
        title="Rough disks fall down a channel with rough walls: mass flux, event-driven and soft",
        equation="flux = (1/L) sum v_x; soft: flux + O(t_c)",
        criterion="standard errors of correlated series; soft ones taken to t_c = 0 along a straight line",
        citation="J. T. Jenkins and M. W. Richman, J. Fluid Mech. 171, 53 (1986); S. Luding et al., Phys. Rev. E 50, "
        "4113 (1994)",
        judge=_judge_pipe,
        variants=full("channel"),
        needs=soft_needs(
            "dimension=2 method.contact.duration method.contact.friction=dashpot "
            "hard_spheres.restitution hard_spheres.friction acceleration box.boundaries=hard "
            "box.faces.friction",
            "positions velocities",
        ),
        faults=(
            (
                "channel",
                Fault(
                    "little-drag",
                    CONTACTS,
                    "return _times(-share, u), stretch",
                    "return _times(-0.7 * share, u), stretch",
                    "the tangential dashpot is seven tenths of what it should be",
                ),
            ),
        ),
    ),
)
