"""Elastic disks and spheres between two thermal walls."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full
from crosscheck.checks.events.driven import (
    OBSERVABLES,
    STEADY,
    STRETCHES,
    curve,
    energy_budget,
    field,
    field_figure,
    last,
    run_on,
    steady_mean,
    temperature,
)
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Frame, Series
from crosscheck.references.conduction import beyond_enskog, enskog_conductivity, fourier_profile
from crosscheck.references.hard_spheres import collision_rate, compressibility, number_correction, packing_fraction
from crosscheck.references.speeds import maxwell_mean_speed
from crosscheck.scene import Box, Face, Floats, HardSpheres, Lattice, Output, Scene
from crosscheck.statistics import mean_of_stretches
from crosscheck.verdict import Judged, Judgement, bounded, statistical, worst


def _slab(dimension: Literal[2, 3], seed: int) -> Scene:
    """Elastic disks or spheres between walls at T = 4 and 1, periodic sideways, 0.2 a unit of volume."""
    lengths = (60.0, 30.0) if dimension == 2 else (30.0, 8.0, 8.0)
    number = round(0.2 * math.prod(lengths))
    return Scene(
        name=f"slab-{dimension}d",
        dimension=dimension,
        duration=2000.0 if dimension == 2 else 400.0,
        hard_spheres=HardSpheres(),
        box=Box(
            lengths=lengths,
            boundaries=("hard", "periodic") if dimension == 2 else ("hard", "periodic", "periodic"),
            faces={"x-": Face(temperature=4.0), "x+": Face(temperature=1.0)},
        ),
        initial=Lattice(
            kind="lattice", structure="square" if dimension == 2 else "sc", number=number, temperature=2.0, seed=seed
        ),
        output=Output(
            interval=2000.0 if dimension == 2 else 400.0,
            observables=OBSERVABLES,
            fields=(12, 6) if dimension == 2 else (12, 1, 1),
        ),
    )


#: Cells along x, and those next to either wall that are left out: the gas slips there.
_CELLS, _EDGE = 12, 2


class _Profiles(NamedTuple):
    """Of every stretch: T and n of the cells, heat flux and pressure where cells meet, heat through the two walls."""

    temperature: Floats
    density: Floats
    heat: Floats
    pressure: Floats
    walls: Floats


def _profiles(scene: Scene, runs: list[Run], lengths: Floats) -> _Profiles:
    area, step = float(np.prod(lengths[1:])), lengths[0] / _CELLS
    beside = tuple(range(2, 1 + scene.dimension))
    mass, momentum, kinetic = (field(runs, name).sum(axis=beside) for name in ("mass", "momentum", "kinetic"))
    scale = area * scene.duration
    return _Profiles(
        temperature(mass, momentum, kinetic),
        mass / scene.duration / (area * step),
        field(runs, "flux_energy")[:, 0].sum(axis=beside)[:, 1:] / scale,
        field(runs, "flux_momentum")[:, 0].sum(axis=beside)[:, 1:, 0] / scale,
        last(runs, "wall_energy")[:, :2] * [1, -1] / scale,
    )


def _judge_heat(laboratory: Laboratory, dimension: Literal[2, 3]) -> Judged:
    """Flux and pressure are uniform; the flux is -kappa dT/dx with Enskog's conductivity."""
    scene = _slab(dimension, laboratory.seed())
    runs = run_on(laboratory, scene, STRETCHES, scene.duration)
    lengths = scene.lengths()
    assert lengths is not None
    found = _profiles(scene, runs, lengths)
    hot, heat, pressure = found.temperature, found.heat, found.pressure
    step = lengths[0] / _CELLS
    x = np.arange(1, _CELLS) * step
    lever = (x - x.mean()) / np.sum((x - x.mean()) ** 2) * lengths[0]
    q = float(heat.mean())
    judgements = [
        energy_budget(runs),
        steady_mean(heat @ lever / q, "change of the heat flux from wall to wall, over the flux", 0.0, 0.1),
        steady_mean(
            found.walls.mean(axis=1) / heat.mean(axis=1), "heat through the walls over the flux inside", 1.0, 0.05
        ),
        steady_mean(
            pressure @ lever / pressure.mean(), "change of the pressure from wall to wall, over the pressure", 0.0, 0.02
        ),
        _pressure(found, step, dimension, scene.number),
        _conductivity(found, lengths, dimension),
        bounded(
            "rise of T from one cell to the next towards the cold wall, largest",
            float(np.diff(hot.mean(axis=0)).max()),
            0.0,
            "temperature falls all the way",
        ),
    ]
    figures = _profile_figures(found, lengths[0], dimension)
    if dimension == 2:
        frame = Frame(0.0, lengths[0], 0.0, lengths[1], ("left", "right"))
        total = [field(runs, name).sum(axis=0) for name in ("mass", "momentum", "kinetic")]
        cell = STRETCHES * scene.duration * float(np.prod(lengths)) / total[0].size
        figures += [
            field_figure("Heat conduction: temperature, cells", temperature(*total), frame, "T"),
            field_figure("Heat conduction: density, cells", total[0] / cell, frame, "n"),
        ]
    jumps = 4.0 - (1.5 * hot[:, 0] - 0.5 * hot[:, 1]).mean(), (1.5 * hot[:, -1] - 0.5 * hot[:, -2]).mean() - 1.0
    note = f"q = {q:.4g}, p = {pressure.mean():.4g}, jumps of T at the walls about {jumps[0]:.2g} and {jumps[1]:.2g}"
    return worst(judgements, note, tuple(figures))


def _inner(found: _Profiles) -> tuple[range, list[tuple[float, float]]]:
    """Numbers of the cells that have another one on their right, away from the walls; n and T where the two meet."""
    hot, density = found.temperature.mean(axis=0), found.density.mean(axis=0)
    inner = range(_EDGE, _CELLS - 1 - _EDGE)
    return inner, [(0.5 * (density[i] + density[i + 1]), 0.5 * (hot[i] + hot[i + 1])) for i in inner]


def _pressure(found: _Profiles, step: float, dimension: int, number: int) -> Judgement:
    """The momentum flux between cells over n T Z of what the cells hold: n and T, which the flux is compared with."""
    inner, states = _inner(found)
    z = [compressibility(packing_fraction(n, dimension), dimension) for n, _ in states]
    # each stretch by its own n and T, with which its pressure varies
    n, t = (0.5 * (one[:, inner] + one[:, np.array(inner) + 1]) for one in (found.density, found.temperature))
    factor = np.vectorize(lambda x: compressibility(packing_fraction(x, dimension), dimension).value)
    ratio = mean_of_stretches((found.pressure[:, inner] / (n * t * factor(n))).mean(axis=1))
    # of second order in the gradient over a mean free path, as are the normal stresses of a gas that conducts heat
    slopes = np.diff(found.temperature.mean(axis=0))[inner] / step
    paths = [maxwell_mean_speed(dimension) / collision_rate(packing_fraction(n, dimension), dimension).value
             for n, _ in states]  # fmt: skip
    second = max((path * slope / t) ** 2 for path, slope, (_, t) in zip(paths, slopes, states, strict=True))
    few = max(
        number_correction(packing_fraction(n, dimension), number, dimension) / one.value
        for (n, _), one in zip(states, z, strict=True)
    )
    doubt = max(one.doubt / one.value for one in z) + second + few
    return statistical(
        "pressure between cells over n T Z of their density and temperature",
        ratio.value,
        ratio.error,
        1.0,
        0.0,
        f"{STEADY}; off by the equation of state, the square of the gradient over a free path, {second:.1g}, and the "
        f"fixed number of particles, {few:.1g}",
        samples=ratio,
        doubt=float(doubt),
        needed=0.02,
    )


def _conductivity(found: _Profiles, lengths: Floats, dimension: int) -> Judgement:
    """The flux over -kappa dT/dx between neighbouring cells, with the Enskog kappa of their mean state."""
    hot, step = found.temperature, lengths[0] / _CELLS
    inner, states = _inner(found)
    theory = np.array([enskog_conductivity(float(n), float(t), dimension) for n, t in states])
    gradient = np.array([(hot[:, i] - hot[:, i + 1]) / step for i in inner]).T
    ratio = mean_of_stretches(found.heat.mean(axis=1) / (gradient * theory).mean(axis=1))
    doubt = max(beyond_enskog(float(n), float(t), dimension, float(lengths.max())) for n, t in states)
    return statistical(
        "conductivity over Enskog's",
        ratio.value,
        ratio.error,
        1.0,
        0.0,
        f"{STEADY}; off by the long-time tail that Enskog leaves out, {doubt:.1%}; cells next to the walls left out",
        samples=ratio,
        doubt=doubt,
        needed=0.15,
    )


def _profile_figures(found: _Profiles, length: float, dimension: int) -> list[Figure]:
    """Temperature, with Fourier's law, density and heat flux along x; length: from wall to wall."""
    hot, density = found.temperature, found.density
    step, label = length / _CELLS, f"{dimension}D"
    middle = (np.arange(_CELLS) + 0.5) * step
    flux = float(found.heat.mean())
    x, theory = fourier_profile(middle, density.mean(axis=0), hot.mean(axis=0), flux, length / 2, dimension)
    fourier = Series(
        f"{label}, Fourier with Enskog's conductivity", x[::20].tolist(), theory[::20].tolist(), theory=True
    )
    places = np.concatenate([[0.0], np.arange(1, _CELLS) * step, [length]])
    fluxes = np.column_stack([found.walls[:, 0], found.heat, found.walls[:, 1]])
    return [
        Figure("Heat conduction: temperature", "x", "T", series=(curve(label, middle, hot), fourier)),
        Figure("Heat conduction: density", "x", "n", series=(curve(label, middle, density),)),
        Figure("Heat conduction: heat flux", "x", "q", series=(curve(label, places, fluxes),)),
    ]


CHECKS = (
    Check(
        name="events/heat-conduction",
        title="Elastic disks and spheres between two thermal walls: flux, pressure, temperature, conductivity",
        equation="q = -kappa dT/dx, uniform; kappa of Enskog: lambda_0 b n (1/y + 3/2 + 0.8718 y) for disks",
        criterion="standard error of stretches; for the conductivity also the long-time tail that Enskog leaves out",
        citation="D. M. Gass, J. Chem. Phys. 54, 1898 (1971); B. J. Alder, D. M. Gass and T. E. Wainwright, J. Chem. "
        "Phys. 53, 3813 (1970); D. Risso and P. Cordero, J. Stat. Phys. 82, 1453 (1996)",
        judge=_judge_heat,
        faults=(
            (
                "2d",
                Fault(
                    "slow-carriers",
                    "events/kernels/measure.py",
                    "energy += 0.5 * mass * v * v",
                    "energy += 0.4 * mass * v * v",
                    "particles carry too little of their kinetic energy through the faces of cells",
                ),
            ),
        ),
        variants=full(**{"2d": 2, "3d": 3}),
        needs=Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=frozenset(
                {
                    "box.boundaries=hard",
                    "box.boundaries=periodic",
                    "box.faces",
                    "box.faces.temperature",
                    "output.fields",
                }
            ),
            observables=frozenset(OBSERVABLES),
        ),
    ),
)
