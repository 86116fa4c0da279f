"""Rough inelastic disks that fall down a channel with rough walls."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full
from crosscheck.checks.events.driven import (
    OBSERVABLES,
    STRETCHES,
    curve,
    energy_budget,
    field,
    last,
    run_on,
    steady_mean,
    temperature,
)
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references.under_gravity import channel_stress
from crosscheck.scene import Box, Face, Friction, GrainFriction, HardSpheres, Lattice, Output, Scene
from crosscheck.verdict import Judged, worst


def _channel(seed: int, pull: float) -> Scene:
    """Rough inelastic disks that fall between two rough walls, periodic along the fall; pull: acceleration along it."""
    wall = Face(restitution=0.9, friction=Friction(tangential_restitution=0.0))
    return Scene(
        name="channel",
        dimension=2,
        duration=1000.0,
        acceleration=(pull, 0.0),
        hard_spheres=HardSpheres(
            restitution=0.9, friction=GrainFriction(tangential_restitution=0.5, static=0.3, sliding=0.3)
        ),
        box=Box(lengths=(26.0, 13.0), boundaries=("periodic", "hard"), faces={"y-": wall, "y+": wall}),
        initial=Lattice(kind="lattice", structure="square", number=130, temperature=1.0, seed=seed),
        output=Output(interval=1000.0, observables=OBSERVABLES, fields=(1, 12)),
    )


def _judge_channel(laboratory: Laboratory, pull: float) -> Judged:
    """Drag against weight, the power of gravity against the losses, and the profile of the shear stress."""
    scene = _channel(laboratory.seed(), pull)
    runs = run_on(laboratory, scene, STRETCHES, 400.0)
    number = scene.number
    drag = last(runs, "wall_impulse")[:, 2:4, 0].sum(axis=1) / scene.duration
    momentum = field(runs, "momentum")[:, 0, :, 0]
    work = pull * momentum.sum(axis=1)
    lost = last(runs, "dissipated_energy") - last(runs, "wall_energy").sum(axis=1)
    mass = field(runs, "mass")[:, 0] / scene.duration
    stress = field(runs, "flux_momentum")[:, 1, 0, 1:, 0] / scene.duration
    share = channel_stress(mass, number, pull)
    slope = (stress * share).sum(axis=1) / (share**2).sum(axis=1)
    judgements = [
        energy_budget(runs),
        steady_mean(drag / (pull * number), "drag of both walls over the weight", 1.0, 0.03),
        steady_mean(lost / work.mean(), "power lost in pairs and at walls over that of gravity", 1.0, 0.05),
        steady_mean(slope, "shear stress over the weight between there and the middle", 1.0, 0.1),
    ]
    speed = momentum / scene.duration / mass
    hot = temperature(field(runs, "mass")[:, 0], field(runs, "momentum")[:, 0], field(runs, "kinetic")[:, 0])
    y = (np.arange(12) + 0.5) * 13.0 / 12
    figures = (
        Figure("Channel: velocity", "y", "velocity along the fall", series=(curve("channel", y, speed),)),
        Figure("Channel: temperature", "y", "T", series=(curve("channel", y, hot),)),
        Figure(
            "Channel: shear stress",
            "y",
            "stress per length",
            series=(
                curve("channel", y[1:] - 13.0 / 24, stress / 26.0),
                Series("weight", (y[1:] - 13.0 / 24).tolist(), (share.mean(axis=0) / 26.0).tolist(), theory=True),
            ),
        ),
    )
    note = f"mean speed {speed.mean():.4g}, {int(last(runs, 'collisions').sum())} collisions"
    return worst(judgements, note, figures)


CHECKS = (
    Check(
        name="events/pipe-flow",
        title="Rough inelastic disks fall down a channel with rough walls: momentum and energy in the steady state",
        equation="drag of the walls = M g; g.p = dissipation in pairs and at walls; stress(y) = g (mass below - M/2)",
        criterion="round-off for the budget of the run; standard error of stretches for the rest",
        citation="R. Soto, P. Cordero and D. Risso, SCAT workshop, Valparaiso (2007); J. T. Jenkins and M. W. Richman, "
        "J. Fluid Mech. 171, 53 (1986)",
        judge=_judge_channel,
        faults=(
            (
                "channel",
                Fault(
                    "drag-cut",
                    "events/kernels/measure.py",
                    "_add_to_wall(tallies, face, 0, -px)",
                    "_add_to_wall(tallies, face, 0, -0.9 * px)",
                    "walls are told of nine tenths of the momentum along x that they get",
                ),
            ),
        ),
        variants=full(channel=0.1),
        needs=Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=frozenset(
                {
                    "acceleration",
                    "box.boundaries=hard",
                    "box.boundaries=periodic",
                    "box.faces",
                    "box.faces.friction",
                    "box.faces.restitution",
                    "dimension=2",
                    "hard_spheres.friction",
                    "hard_spheres.friction.sliding",
                    "hard_spheres.friction.static",
                    "hard_spheres.restitution",
                    "output.fields",
                }
            ),
            observables=frozenset(OBSERVABLES),
        ),
    ),
)
