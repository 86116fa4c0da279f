"""Starts of lattice gases: the equilibrium, the waves and the numbers of particles that a scene asks for.

Mean occupations are judged to rounding, where a scheme has them, over the whole range of densities and velocities;
particles by chi^2 of their numbers in blocks, and exactly where a cell has a fixed number.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from crosscheck.checks.base import Check, Laboratory, full, quick
from crosscheck.checks.lattice.gases import FHP, LATTICE, gas_scene
from crosscheck.checks.lattice.recording import Recorded, lattice_methods, recorded
from crosscheck.engines.capabilities import Needs
from crosscheck.errors import Unsupported
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.references.lattice_audit import velocities
from crosscheck.references.lattice_draws import as_normal, largest_correlation
from crosscheck.references.lattice_models import fermi_dirac
from crosscheck.references.lattice_starts import Fields, deviation_from_equilibrium, fields, numbers_of_cells
from crosscheck.scene import Method, Obstacle, Occupations, Output, Wave
from crosscheck.verdict import Judged, Judgement, by_chance, round_off, worst

ROWS, COLUMNS, CELL = 60, 48, 4
WAVES = (
    Wave(of="density", amplitude=0.15, mode=(1.0, 2.0), phase=0.4),
    Wave(of="density", amplitude=0.05, mode=(-2.0, 3.0)),
    Wave(of="velocity_x", amplitude=0.1, mode=(3.0, 1.0), phase=1.0),
    Wave(of="velocity_y", amplitude=0.1, mode=(1.0, -1.0)),
)
WALLS = (Obstacle(rows=(7, 8), columns=(3, 40)),)


def _whole_range(model: str, seed: int) -> Occupations:
    """A density and a velocity a row: almost empty to almost full, at rest to 0.98 of what is sure to be possible."""
    row = np.arange(ROWS)
    density = 0.01 + 0.98 * row / (ROWS - 1)
    c, angle = velocities(model), 0.1 + 2.4 * row
    along = np.stack([np.cos(angle), np.sin(angle)])
    # most momentum along a direction: the channels that are filled are those furthest along it
    projected = -np.sort(-(c @ along), axis=0)
    filled = np.clip(len(c) * density - np.arange(len(c))[:, None], 0, 1)
    most = (projected * filled).sum(axis=0) / (len(c) * density)
    # the possible velocities form polygons of at least four corners: 2^(-1/2) of that is within
    u = 0.98 * (7 * row % 10 / 9) * most / 2**0.5 * along
    return Occupations(
        kind="occupations",
        seed=seed,
        density=tuple(density.tolist()),
        velocity_x=tuple(u[0].tolist()),
        velocity_y=tuple(u[1].tolist()),
    )


def _starts(model: str, seed: int) -> Iterable[tuple[str, Occupations, tuple[Obstacle, ...]]]:
    waves: dict[str, Any] = {"kind": "occupations", "seed": seed, "waves": WAVES}
    rising = tuple(0.3 + 0.2 * k / ROWS for k in range(ROWS))
    yield "waves", Occupations(density=0.4, velocity_x=-0.05, velocity_y=0.1, **waves), WALLS
    yield "values of rows, and waves", Occupations(density=rising, velocity_x=0.1, **waves), ()


def _judge(laboratory: Laboratory, model: str) -> Judged:
    judgements: list[Judgement] = []
    for method in lattice_methods(laboratory.engine):
        seed = laboratory.seed(method.scheme)
        starts = [*_starts(model, seed), ("whole range", _whole_range(model, seed), ())]
        for label, initial, walls in starts:
            scene = gas_scene(label, model, ROWS, COLUMNS, 0, initial, Output(), obstacles=walls)
            try:
                found = recorded(laboratory, scene, method)
            except Unsupported:
                continue
            name = f"{method.scheme}, {label}"
            if not found.whole:
                judgements += _of_means(name, found, initial)
            elif label != "whole range":  # for which the references solve no equilibrium
                judgements += _of_particles(name, found, initial)
        judgements += _of_cells(laboratory, model, method)
    if not judgements:
        raise Unsupported(f"{laboratory.engine}: no lattice scheme can run these scenes")
    return worst(judgements, f"starts of {ROWS} x {COLUMNS} sites")


def _empty_walls(name: str, found: Recorded) -> Judgement:
    solid = float(np.abs(found.trajectory[0][found.walls != ""]).sum())
    return round_off(f"{name}: particles in walls", solid, 1e-300, "walls start empty: exactly none")


def _of_means(name: str, found: Recorded, initial: Occupations) -> list[Judgement]:
    fluid, f = found.walls == "", found.trajectory[0]
    asked = fields(found.lattice, initial)
    here = Fields(asked.density[fluid], asked.velocity[fluid])
    sums, form = deviation_from_equilibrium(found.lattice.model, f[fluid], here)
    rounding = 4 * f.shape[-1] * EPSILON
    return [
        _empty_walls(name, found),
        round_off(
            f"{name}: mass or momentum of a site over b, less those asked for",
            sums,
            rounding,
            "sums over the channels, each with a few roundings",
        ),
        round_off(
            f"{name}: change of an occupation that makes ln f/(1 - f) linear in the velocity",
            form,
            rounding,
            "an occupation and its logarithm, each with a few roundings",
        ),
    ]


def _of_particles(name: str, found: Recorded, initial: Occupations) -> list[Judgement]:
    """Numbers in strips along rows, along columns, and where the density lies between two values; and any order."""
    fluid, n = found.walls == "", found.trajectory[0]
    from scipy.stats import chi2, halfnorm

    asked = fields(found.lattice, initial)
    f = fermi_dirac(found.lattice.model, asked.density, asked.velocity)
    least, groupings = (
        1.0,
        (
            np.arange(ROWS)[:, None] // 4,
            np.arange(COLUMNS) // 4,
            np.digitize(asked.density, (0.3, 0.4, 0.5)),
        ),
    )
    for grouping in groupings:
        groups = np.broadcast_to(grouping, fluid.shape)
        parts = [(groups == group) & fluid for group in np.unique(groups[fluid])]
        away = np.array([(n - f)[here].sum(axis=0) for here in parts])
        variances = np.array([(f * (1 - f))[here].sum(axis=0) for here in parts])
        least = min(least, float(chi2.sf((away**2 / variances).sum(), away.size)))
    scores = np.where(fluid[..., None], (n - f) / np.sqrt(f * (1 - f)), 0.0).transpose(2, 0, 1)
    order = largest_correlation(scores, np.broadcast_to(fluid, scores.shape).astype(np.float64))
    channel, row, column = order.distance
    return [
        _empty_walls(name, found),
        by_chance(
            f"{name}: numbers of particles in strips and by density",
            as_normal(least, len(groupings)),
            halfnorm,
            f"the largest of {len(groupings)} chi^2, as a normal variable of the same probability",
        ),
        by_chance(
            f"{name}: largest correlation of two places",
            order.largest,
            halfnorm,
            f"the largest of {order.distances} distances, as one normal variable of the same probability",
            note=f"{channel} channels, {row} rows and {column} columns apart",
        ),
    ]


def _of_cells(laboratory: Laboratory, model: str, method: Method) -> Iterable[Judgement]:
    """Fixed numbers in cells, at random places."""
    from scipy.stats import chi2

    initial = Occupations(kind="occupations", seed=laboratory.seed("cells"), density=0.4, cells=CELL, waves=WAVES[:2])
    scene = gas_scene("cells", model, ROWS, COLUMNS, 0, initial, Output(), obstacles=WALLS)
    try:
        n = recorded(laboratory, scene, method).trajectory[0]
    except Unsupported:
        return
    cells = n.reshape(ROWS // CELL, CELL, COLUMNS // CELL, CELL, -1)
    expected = numbers_of_cells(model, ROWS, COLUMNS, initial)
    name = f"{method.scheme}, cells"
    yield round_off(
        f"{name}: number of a cell, less the one asked for",
        float(np.abs(cells.sum(axis=(1, 3, 4)) - expected).max()),
        0.5,
        "whole numbers",
    )
    # each place in a cell is filled with the same probability, and a full one leaves fewer for the others
    size = cells[0, :, 0].size
    share = expected / size
    away = cells.sum(axis=(0, 2)) - share.sum()
    square = float((away**2).sum() / (share * (1 - share)).sum() * (size - 1) / size)
    yield by_chance(
        f"{name}: particles at each place of a cell",
        square,
        chi2(size - 1),
        f"chi^2 of {size} places",
    )


CHECKS = (
    Check(
        name="lattice/starts",
        title="Starts of lattice gases: equilibria, oblique waves and fixed numbers",
        equation="f_i = 1/(1 + exp(h + q.c_i))",
        criterion="mean occupations to rounding, numbers of particles by chi^2, those of cells exactly",
        citation=FHP,
        judge=_judge,
        variants=(*quick("hpp", "fhp3"), *full("fhp1", "fhp2")),
        faults=(
            (
                "fhp3",
                Fault(
                    "rows-not-shifted",
                    "lattice/gas.py",
                    "    shift = 0.5 * (row % 2) if v.half_rows else 0.0 * row",
                    "    shift = 0.0 * row",
                    "waves do not know that odd rows are shifted by half a link",
                ),
            ),
            (
                "fhp3",
                Fault(
                    "loose-equilibrium",
                    "lattice/equilibrium.py",
                    "left = left[(reach > 1e-8) & ",
                    "left = left[(reach > 1e-3) & ",
                    "equilibria are solved to 1e-6 or so",
                ),
            ),
            (
                "hpp",
                Fault(
                    "cells-rounded-down",
                    "lattice/gas.py",
                    "filled = order < np.rint(density * size)[..., None]",
                    "filled = order < np.floor(density * size)[..., None]",
                    "numbers of particles in cells are rounded down",
                ),
            ),
        ),
        needs=Needs("lattice_gas", (LATTICE,), observables=frozenset({"populations"})),
        interpreted=True,
    ),
)
