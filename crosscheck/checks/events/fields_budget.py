"""Mass, momentum and energy of every cell: content against fluxes, walls, field and dissipation."""

from __future__ import annotations

from typing import Literal

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full
from crosscheck.checks.events.driven import OBSERVABLES, energy_defect, run_whole
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Run
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
    Oscillation,
    Output,
    Scene,
    Well,
)
from crosscheck.scene.overlaps import wrapped
from crosscheck.verdict import Judged, round_off, worst


def through_faces(flux: Floats) -> Floats:
    """Net inflow into each cell through its faces, (nx, ny(, nz), ...).

    flux: along each axis, through the lower face of each cell, (d, nx, ny(, nz), ...).
    """
    return np.asarray(sum(flux[axis] - np.roll(flux[axis], -1, axis) for axis in range(len(flux))))


def cell_budgets(run: Run, acceleration: Floats) -> dict[str, float]:
    """Defect of mass, momentum and energy in the worst cell, over the largest term of that budget.

    Mass: change = in through faces; momentum: also from walls, and g times the time integral of mass; energy: also
    from walls, g . (time integral of momentum), less the dissipated. run: with fields. acceleration: g, (d,).
    """
    terms = {
        "mass": [through_faces(run["field_flux_mass"])],
        "momentum": [
            through_faces(run["field_flux_momentum"]),
            run["field_wall_momentum"],
            run["field_mass"][..., None] * acceleration,
        ],
        "energy": [
            through_faces(run["field_flux_energy"]),
            run["field_wall_energy"],
            run["field_momentum"] @ acceleration,
            -run["field_dissipation"],
        ],
    }
    defects = {}
    for name, parts in terms.items():
        before, after = run[f"field_initial_{name}"], run[f"field_final_{name}"]
        size = max(float(np.abs(part).max()) for part in (*parts, before, after))
        defects[name] = float(np.abs(after - before - sum(parts)).max()) / size
    return defects


def _cell_totals(run: Run, scene: Scene) -> dict[str, float]:
    """Difference of each sum over cells from the same quantity of the whole system, relative to its size.

    run: with fields and two samples, the first and the last. scene: that of the run.
    """
    state = scene.initial_state()
    g = np.zeros(scene.dimension) if scene.acceleration is None else np.array(scene.acceleration)
    positions, masses = run["final_positions"], state.masses
    lengths, shape = state.lengths, run["field_mass"].shape
    assert lengths is not None
    inside = wrapped(positions, scene.periods())
    edges = [np.linspace(0.0, length, count + 1) for length, count in zip(lengths, shape, strict=True)]
    field_energy = -float(masses @ positions @ g)
    content = run["kinetic_energy"][-1] + run["potential_energy"][-1]
    total_momentum = masses @ run["final_velocities"]
    cells = tuple(range(scene.dimension))
    pairs: dict[str, tuple[Floats, Floats]] = {
        "mass in cells": (run["field_final_mass"], np.histogramdd(inside, edges, weights=masses)[0]),
        "mass, time integral": (run["field_mass"].sum(), masses.sum() * scene.duration),
        "momentum": (run["field_final_momentum"].sum(axis=cells), total_momentum),
        "energy": (run["field_final_energy"].sum() + field_energy, content),
        "kinetic energy, time integral": (
            run["field_kinetic"].sum() + run["field_rotational"].sum(),
            run["kinetic_energy_integral"][-1],
        ),
        "dissipation": (run["field_dissipation"].sum(), run["dissipated_energy"][-1]),
        "collisions": (run["field_collisions"].sum(), run["collisions"][-1]),
        "energy from walls": (run["field_wall_energy"].sum(), run["wall_energy"][-1].sum()),
        "momentum from walls": (run["field_wall_momentum"].sum(axis=cells), -run["wall_impulse"][-1].sum(axis=0)),
    }
    # sums whose terms cancel (momentum, energy) are compared relative to the size of their terms
    sizes = {
        "momentum": float(np.abs(masses[:, None] * run["final_velocities"]).sum()),
        "energy": abs(run["kinetic_energy"][-1]) + abs(field_energy),
        "dissipation": float(run["kinetic_energy"][-1]),
        "energy from walls": float(run["kinetic_energy"][-1] + np.abs(run["wall_energy"][-1]).sum()),
        "momentum from walls": float(1.0 + np.abs(run["wall_impulse"][-1]).sum()),
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


def square_well() -> Scene:
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


_WHY = "every event rounds each sum that it adds to by a unit of the last place of its size, at worst all alike"


def _judge_budget(laboratory: Laboratory, scene: Scene) -> Judged:
    """Every cell's budget over the run, sums over all cells, and the energy of the whole."""
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
    judgements += [
        round_off(f"sum over cells: {name}; relative defect", error, tolerance, _WHY)
        for name, error in _cell_totals(run, scene).items()
    ]
    defect, size = energy_defect(run)
    judgements.append(round_off("energy of the whole: defect of its budget", defect / size, tolerance, _WHY))
    return worst(judgements, f"{events} events, {run['field_mass'].size} cells")


CHECKS = (
    Check(
        name="events/fields-budget",
        title="Mass, momentum and energy of every cell: content, fluxes, walls, field and dissipation",
        equation="final - initial = sum over faces of what came in + walls + g int(m) dt, g.int(p) dt - dissipated",
        criterion="round-off, one unit of the largest term per event",
        citation="J. H. Irving and J. G. Kirkwood, J. Chem. Phys. 18, 817 (1950); D. Risso and P. Cordero, J. Stat. "
        "Phys. 82, 1453 (1996)",
        judge=_judge_budget,
        variants=full(**{"2d": _grains(2), "3d": _grains(3), "well": square_well()}),
        needs=Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=frozenset({"acceleration", "box.boundaries=hard", "box.boundaries=periodic", "output.fields"}),
            observables=frozenset(OBSERVABLES),
        ),
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
    ),
)
