"""Time integrals of kinetic and potential energy, exact at events, against dense samples."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full
from crosscheck.checks.events.driven import OBSERVABLES, column, run_whole
from crosscheck.checks.events.fields_budget import square_well
from crosscheck.checks.events.over_floor import FLOOR
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.scene import Box, HardSpheres, Lattice, Output, Scene
from crosscheck.statistics import correlated_mean
from crosscheck.verdict import Judged, Judgement, bounded, round_off, statistical, worst


def _judge_column(laboratory: Laboratory) -> Judged:
    """Between wall hits U is a parabola, so the error of the trapezoidal rule has a bound without free numbers."""
    number, step, steps = 100, 0.02, 5000
    scene = column(number, 50.0, 5.0, step * steps, laboratory.seed())
    scene = scene.changed(output=Output(interval=step, observables=OBSERVABLES, fields=(1, 20)))
    run = run_whole(laboratory, scene)
    hits = abs(float(run["wall_impulse"][-1, FLOOR, 1]))
    limit = number * scene.duration * step**2 / 12 + hits * step**2 / 8
    judgements = []
    for name, sampled in (("potential", run["potential_energy"]), ("kinetic", run["kinetic_energy"])):
        exact = run[f"{name}_energy_integral"][-1]
        quadrature = step * (sampled.sum() - 0.5 * (sampled[0] + sampled[-1]))
        judgements.append(
            bounded(
                f"time integral of the {name} energy: exact - trapezoidal rule of {steps} samples",
                abs(exact - quadrature),
                limit,
                "U'' = -M g^2 between hits, a hit bends U by g |dp|: M g^2 T dt^2/12 + g sum |dp| dt^2/8",
                note=f"integral {exact:.6g}",
            )
        )
    total = run["potential_energy_integral"][-1] + run["kinetic_energy_integral"][-1]
    energy = run["kinetic_energy"][0] + run["potential_energy"][0]
    judgements.append(_constant_energy(total, energy, run, scene.duration))
    return worst(judgements)


def _constant_energy(integral: float, energy: float, run: Run, duration: float) -> Judgement:
    """The time integral of K + U is E t where nothing is lost."""
    return round_off(
        "time integral of K + U over E t, less 1: elastic",
        abs(integral / (energy * duration) - 1),
        EPSILON * float(run["events"][-1]),
        "every event rounds each sum that it adds to by a unit of the last place of its size, at worst all alike",
    )


def _judge_free(laboratory: Laboratory) -> Judged:
    """Elastic, without a field: K is a constant."""
    scene = Scene(
        name="free",
        dimension=2,
        duration=50.0,
        hard_spheres=HardSpheres(),
        box=Box(packing_fraction=0.3),
        initial=Lattice(kind="lattice", structure="square", number=200, temperature=1.0, seed=laboratory.seed()),
        output=Output(interval=10.0, observables=OBSERVABLES),
    )
    run = run_whole(laboratory, scene)
    judgement = _constant_energy(
        run["kinetic_energy_integral"][-1], float(run["kinetic_energy"][0]), run, scene.duration
    )
    return worst([judgement], f"{int(run['collisions'][-1])} collisions")


def _judge_well(laboratory: Laboratory) -> Judged:
    """Wells make U jump: the error of dense samples is random, with mean 0, and independent from block to block."""
    block, blocks = 50, 200
    scene = square_well()
    assert isinstance(scene.initial, Lattice)
    step = 0.02
    scene = scene.changed(
        duration=step * block * blocks,
        initial=scene.initial.model_copy(update={"seed": laboratory.seed()}),
        output=Output(interval=step, observables=OBSERVABLES, fields=scene.output.fields),
    )
    run = run_whole(laboratory, scene)
    judgements = []
    for name, sampled in (("potential", run["potential_energy"]), ("kinetic", run["kinetic_energy"])):
        exact = np.diff(run[f"{name}_energy_integral"]) / step
        middle = 0.5 * (sampled[1:] + sampled[:-1])
        gap = correlated_mean((exact - middle).reshape(blocks, block).mean(axis=1))
        average = float(exact.mean())
        judgements.append(
            statistical(
                f"mean {name} energy, exact integral",
                average,
                0.0,
                average - gap.value,
                gap.error,
                f"mean of {middle.size} dense samples, its error from {blocks} blocks",
                samples=gap,
                needed=5e-3,
            )
        )
    total = run["potential_energy_integral"][-1] + run["kinetic_energy_integral"][-1]
    energy = float(run["kinetic_energy"][0] + run["potential_energy"][0])
    judgements.append(_constant_energy(total, energy, run, scene.duration))
    return worst(judgements, f"{int(run['events'][-1])} events")


CHECKS = (
    Check(
        name="events/exact-averages",
        title="Time integrals of kinetic and potential energy, exact at events, against dense samples",
        equation="int U dt with U = -sum m g.x: parabolas between wall hits; K + U = E where nothing is lost",
        criterion="bound of the trapezoidal rule; mean error of samples within its standard error; round-off for E t",
        citation="M. Marin, D. Risso and P. Cordero, J. Comput. Phys. 109, 306 (1993)",
        judge=lambda laboratory, judge: judge(laboratory),
        variants=full(column=_judge_column, free=_judge_free, well=_judge_well),
        needs=Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=frozenset({"box.boundaries=periodic", "dimension=2"}),
            observables=frozenset(OBSERVABLES),
        ),
        faults=(
            (
                "column",
                Fault(
                    "walls-do-not-lift",
                    "events/kernels/measure.py",
                    "_add(tallies, RISE, _along(model.acceleration, px, py, pz))",
                    "_add(tallies, RISE, 0.999 * _along(model.acceleration, px, py, pz))",
                    "the moment of the field takes a thousandth too little from wall hits",
                ),
            ),
            (
                "well",
                Fault(
                    "wells-half-counted",
                    "events/kernels/measure.py",
                    "sums[WELLS] -= bound",
                    "sums[WELLS] -= 0.5 * bound",
                    "the energy of the wells follows half of its changes",
                ),
            ),
        ),
    ),
)
