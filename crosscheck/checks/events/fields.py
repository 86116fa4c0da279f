"""Exact averages and the fields on cells: the budget of every cell, and integrals against dense samples (E16, E18)."""

from __future__ import annotations

from typing import Literal

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Laboratory, fixed, legacy_check
from crosscheck.engines.protocol import Kind, Run
from crosscheck.errors import EngineError
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.scene import (
    Box,
    Face,
    Floats,
    Friction,
    GrainFriction,
    HardSpheres,
    Lattice,
    Method,
    Observable,
    Oscillation,
    Output,
    Scene,
    Well,
    explicit,
)
from crosscheck.scene.overlaps import wrapped
from crosscheck.statistics import correlated_mean
from crosscheck.verdict import Judged, Judgement, bounded, round_off, statistical, worst

#: Asked for by all driven scenes, so that they share their kernels.
OBSERVABLES: tuple[Observable, ...] = (
    "kinetic_energy",
    "potential_energy",
    "events",
    "collisions",
    "dissipated_energy",
    "wall_impulse",
    "wall_energy",
    "kinetic_energy_integral",
    "potential_energy_integral",
)


# -- runs in a row ---------------------------------------------------------------------------------


def run_whole(
    laboratory: Laboratory, scene: Scene, method: Method | Kind = EVENT_DRIVEN, engine: str | None = None
) -> Run:
    """The scene for all of its duration; EngineError if it ended early, by inelastic collapse, or diverged."""
    run = laboratory.run(scene, method, engine)
    if run.stopped or run.diverged:
        raise EngineError(f"scene {scene.name} ended early: {run.stopped or 'diverged'}")
    return run


def run_on(laboratory: Laboratory, scene: Scene, stretches: int, warm_up: float) -> list[Run]:
    """The scene for its duration, `stretches` times, each from the end of the one before, after a time `warm_up`.

    Fields are measured over each stretch anew, which gives them standard errors.
    """
    run = run_whole(laboratory, scene.changed(duration=warm_up, output=Output(), seed=laboratory.seed("warm-up")))
    found = []
    for stretch in range(stretches):
        start = explicit(run["final_positions"], run["final_velocities"], run.get("final_angular_velocities"))
        run = run_whole(laboratory, scene.changed(initial=start, seed=laboratory.seed(f"stretch-{stretch}")))
        found.append(run)
    return found


def temperature(mass: Floats, momentum: Floats, kinetic: Floats) -> Floats:
    """T = m (<v^2> - <v>^2)/d from the fields' time integrals, of particles of mass 1; NaN in cells that stayed empty.

    momentum has its d components last.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = momentum / mass[..., None]
        square = 2 * kinetic / mass - np.sum(mean**2, axis=-1)
    return np.asarray(square / momentum.shape[-1])


def energy_defect(run: Run) -> tuple[float, float]:
    """Largest |change of K + U - (from walls - dissipated in pairs)| over the samples, and the largest term."""
    energy = run["kinetic_energy"] + run["potential_energy"]
    supplied, lost = run["wall_energy"].sum(axis=1), run["dissipated_energy"]
    defect = energy - energy[0] - (supplied - lost)
    sizes = [np.abs(term).max() for term in (run["kinetic_energy"], run["potential_energy"], supplied, lost)]
    return float(np.abs(defect).max()), float(max(sizes))


# -- the budget of every cell ----------------------------------------------------------------------


def _through_faces(flux: Floats) -> Floats:
    """What comes in through the two faces of each cell along every axis; flux: (d, nx, ny(, nz), ...)."""
    return np.asarray(sum(flux[axis] - np.roll(flux[axis], -1, axis) for axis in range(len(flux))))


def cell_budgets(run: Run, acceleration: Floats) -> dict[str, float]:
    """Defect of mass, momentum and energy in the worst cell, over the largest term of that budget.

    mass: change = in through faces; momentum: also from walls, and g times the time integral of mass; energy: also
    from walls, g . (time integral of momentum), less the dissipated.
    """
    t = run
    terms = {
        "mass": [_through_faces(t["field_flux_mass"])],
        "momentum": [
            _through_faces(t["field_flux_momentum"]),
            t["field_wall_momentum"],
            t["field_mass"][..., None] * acceleration,
        ],
        "energy": [
            _through_faces(t["field_flux_energy"]),
            t["field_wall_energy"],
            t["field_momentum"] @ acceleration,
            -t["field_dissipation"],
        ],
    }
    defects = {}
    for name, parts in terms.items():
        before, after = t[f"field_initial_{name}"], t[f"field_final_{name}"]
        size = max(float(np.abs(part).max()) for part in (*parts, before, after))
        defects[name] = float(np.abs(after - before - sum(parts)).max()) / size
    return defects


def cell_totals(run: Run, scene: Scene) -> dict[str, float]:
    """Defects of the sums over cells from what is known otherwise, each over its own size; run: two samples."""
    state, t = scene.initial_state(), run
    g = np.zeros(scene.dimension) if scene.acceleration is None else np.array(scene.acceleration)
    positions, masses = run["final_positions"], state.masses
    lengths, shape = state.lengths, t["field_mass"].shape
    assert lengths is not None
    inside = wrapped(positions, scene.periods())
    edges = [np.linspace(0.0, length, count + 1) for length, count in zip(lengths, shape, strict=True)]
    field_energy = -float(masses @ positions @ g)
    content = run["kinetic_energy"][-1] + run["potential_energy"][-1]
    total_momentum = masses @ run["final_velocities"]
    cells = tuple(range(scene.dimension))
    pairs: dict[str, tuple[Floats, Floats]] = {
        "mass in cells": (t["field_final_mass"], np.histogramdd(inside, edges, weights=masses)[0]),
        "mass, time integral": (t["field_mass"].sum(), masses.sum() * scene.duration),
        "momentum": (t["field_final_momentum"].sum(axis=cells), total_momentum),
        "energy": (t["field_final_energy"].sum() + field_energy, content),
        "kinetic energy, time integral": (
            t["field_kinetic"].sum() + t["field_rotational"].sum(),
            t["kinetic_energy_integral"][-1],
        ),
        "dissipation": (t["field_dissipation"].sum(), t["dissipated_energy"][-1]),
        "collisions": (t["field_collisions"].sum(), t["collisions"][-1]),
        "energy from walls": (t["field_wall_energy"].sum(), t["wall_energy"][-1].sum()),
        "momentum from walls": (t["field_wall_momentum"].sum(axis=cells), -t["wall_impulse"][-1].sum(axis=0)),
    }
    # what passes zero (momentum, energy) is measured by what has gone through it
    sizes = {
        "momentum": float(np.abs(masses[:, None] * run["final_velocities"]).sum()),
        "energy": abs(run["kinetic_energy"][-1]) + abs(field_energy),
        "dissipation": float(run["kinetic_energy"][-1]),
        "energy from walls": float(run["kinetic_energy"][-1] + np.abs(t["wall_energy"][-1]).sum()),
        "momentum from walls": float(1.0 + np.abs(t["wall_impulse"][-1]).sum()),
    }
    return {
        name: float(np.abs(one - other).max()) / max(float(np.abs(other).max()), sizes.get(name, 0.0))
        for name, (one, other) in pairs.items()
    }


def _grains(dimension: Literal[2, 3]) -> Scene:
    """Rough inelastic grains of two sizes and masses in a field that is along no axis; a floor that moves, a lid."""
    number = 150 if dimension == 2 else 250
    lengths = (16.0, 20.0) if dimension == 2 else (8.0, 10.0, 12.0)
    rough = Friction(tangential_restitution=0.3, static=0.4, sliding=0.3)
    floor, lid = "xyz"[dimension - 1] + "-", "xyz"[dimension - 1] + "+"
    faces = {
        floor: Face(restitution=0.95, oscillation=Oscillation(amplitude=0.2, frequency=15.0), friction=rough)
        if dimension == 2
        else Face(temperature=8.0),
        lid: Face(restitution=0.8, friction=rough),
    }
    return Scene(
        name=f"budget-{dimension}d",
        dimension=dimension,
        duration=200.0,
        acceleration=(0.2, -0.5) if dimension == 2 else (0.1, 0.2, -0.5),
        masses=tuple(1.0 if i % 3 else 0.5 for i in range(number)),
        species=tuple(0 if i % 3 else 1 for i in range(number)),
        hard_spheres=HardSpheres(
            diameter=(1.0, 0.75),
            restitution=0.9,
            friction=GrainFriction(tangential_restitution=0.2, static=0.5, sliding=0.4),
        ),
        box=Box(
            lengths=lengths,
            boundaries=("periodic", "hard") if dimension == 2 else ("periodic", "periodic", "hard"),
            faces=faces,
        ),
        initial=Lattice(
            kind="lattice", structure="square" if dimension == 2 else "sc", number=number, temperature=3.0, seed=1
        ),
        output=Output(interval=200.0, observables=OBSERVABLES, fields=(8, 10) if dimension == 2 else (4, 5, 6)),
    )


def _square_well() -> Scene:
    """Elastic disks with wells that fall in a box with a floor and a lid."""
    return Scene(
        name="budget-well",
        dimension=2,
        duration=200.0,
        acceleration=(0.0, -0.1),
        hard_spheres=HardSpheres(well=Well(depth=1.0, range=1.5)),
        box=Box(lengths=(18.0, 20.0), boundaries=("periodic", "hard")),
        initial=Lattice(kind="lattice", structure="square", number=120, temperature=1.0, seed=1),
        output=Output(interval=200.0, observables=OBSERVABLES, fields=(6, 8)),
    )


_BUDGETS = {"2d": _grains(2), "3d": _grains(3), "well": _square_well()}
_WHY = "every event rounds each sum that it adds to by a unit of the last place of its size, at worst all alike"


def _judge_budget(laboratory: Laboratory, variant: str) -> Judged:
    scene = _BUDGETS[variant]
    assert isinstance(scene.initial, Lattice)
    scene = scene.changed(initial=scene.initial.model_copy(update={"seed": laboratory.seed()}))
    run = run_whole(laboratory, scene)
    g = np.array(scene.acceleration)
    events = int(run["events"][-1])
    tolerance = EPSILON * events
    judgements = [
        round_off(f"{name} of the worst cell: defect of its budget, over the largest term", error, tolerance, _WHY)
        for name, error in cell_budgets(run, g).items()
    ]
    totals = cell_totals(run, scene)
    name = max(totals, key=lambda key: totals[key])
    judgements.append(round_off(f"sum over cells, worst: {name}; relative defect", totals[name], tolerance, _WHY))
    defect, size = energy_defect(run)
    judgements.append(round_off("energy of the whole: defect of its budget", defect / size, tolerance, _WHY))
    return worst(judgements, f"{events} events, {run['field_mass'].size} cells")


# -- exact averages --------------------------------------------------------------------------------


def column(number: int, width: float, kinetic: float, duration: float, seed: int) -> Scene:
    """Elastic disks under gravity 1 on an elastic floor at rest, periodic sideways, open above; size, mass 1."""
    return Scene(
        name="column",
        dimension=2,
        duration=duration,
        acceleration=(0.0, -1.0),
        hard_spheres=HardSpheres(),
        box=Box(lengths=(width, 8 * kinetic), boundaries=("periodic", "hard"), faces={"y+": Face(open=True)}),
        initial=Lattice(kind="lattice", structure="square", number=number, temperature=kinetic, seed=seed),
        output=Output(interval=duration, observables=OBSERVABLES),
    )


def _judge_integrals(laboratory: Laboratory, variant: str) -> Judged:
    return {"column": _judge_column, "free": _judge_free, "well": _judge_well}[variant](laboratory)


def _judge_column(laboratory: Laboratory) -> Judged:
    """Between wall hits U is a parabola, so the error of the trapezoidal rule has a bound without free numbers."""
    number, step, steps = 100, 0.02, 5000
    scene = column(number, 50.0, 5.0, step * steps, laboratory.seed())
    scene = scene.changed(output=Output(interval=step, observables=OBSERVABLES, fields=(1, 20)))
    run = run_whole(laboratory, scene)
    hits = abs(float(run["wall_impulse"][-1, 2, 1]))
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
    return worst(judgements, f"potential energy integral {run['potential_energy_integral'][-1]:.6g}")


def _constant_energy(integral: float, energy: float, run: Run, duration: float) -> Judgement:
    return round_off(
        "time integral of K + U over E t, less 1: elastic",
        abs(integral / (energy * duration) - 1),
        EPSILON * float(run["events"][-1]),
        _WHY,
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
    scene = _BUDGETS["well"]
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
                samples=gap.independent,
                needed=5e-3,
            )
        )
    total = run["potential_energy_integral"][-1] + run["kinetic_energy_integral"][-1]
    energy = float(run["kinetic_energy"][0] + run["potential_energy"][0])
    judgements.append(_constant_energy(total, energy, run, scene.duration))
    return worst(judgements, f"{int(run['events'][-1])} events")


CHECKS = (
    legacy_check(
        name="events/fields-budget",
        title="Mass, momentum and energy of every cell: content, fluxes, walls, field and dissipation",
        equation="final - initial = sum over faces of what came in + walls + g int(m) dt, g.int(p) dt - dissipated",
        criterion="round-off, one unit of the largest term per event",
        citation="J. H. Irving and J. G. Kirkwood, J. Chem. Phys. 18, 817 (1950); D. Risso and P. Cordero, J. Stat. "
        "Phys. 82, 1453 (1996)",
        judge=_judge_budget,
        variants=fixed(*_BUDGETS),
        faults=(
            (
                "2d",
                Fault(
                    "energy-not-through-the-contact",
                    "events/kernels/measure.py",
                    "energy = 0.5 * (lost_i - lost_j)",
                    "energy = 0.5 * lost_i",
                    "the energy that a contact carries from one cell to the next is that of one partner alone",
                ),
            ),
            (
                "3d",
                Fault(
                    "stress-through-no-face",
                    "events/kernels/measure.py",
                    "fields.flux_momentum[axis, through, 2] += sign * pz",
                    "fields.flux_momentum[axis, through, 2] += 0.0",
                    "the third component of the momentum that contacts carry is lost",
                ),
            ),
            (
                "well",
                Fault(
                    "unbound-flux",
                    "events/kernels/measure.py",
                    "return -0.5 * well.depth * bonds[i, 0]",
                    "return 0.0",
                    "a particle takes its kinetic energy alone into the next cell, not its half of its wells",
                ),
            ),
        ),
        tier="full",
    ),
    legacy_check(
        name="events/exact-averages",
        title="Time integrals of kinetic and potential energy, exact at events, against dense samples",
        equation="int U dt with U = -sum m g.x: parabolas between wall hits; K + U = E where nothing is lost",
        criterion="bound of the trapezoidal rule; mean error of samples within its standard error; round-off for E t",
        citation="M. Marin, D. Risso and P. Cordero, J. Comput. Phys. 109, 306 (1993)",
        judge=_judge_integrals,
        variants=fixed("column", "free", "well"),
        faults=(
            (
                "column",
                Fault(
                    "walls-do-not-lift",
                    "events/kernels/measure.py",
                    "sums[RISE] += _along(model.acceleration, px, py, pz)",
                    "sums[RISE] += 0.999 * _along(model.acceleration, px, py, pz)",
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
        tier="full",
    ),
)
