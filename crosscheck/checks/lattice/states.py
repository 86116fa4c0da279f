"""Lattice gases: what holds exactly (conservation, evolvers, reversal), equilibrium, pressure tensor, H theorem.

Units: links and steps; d is the mean occupation of a channel.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from crosscheck.checks.base import Laboratory, reference_check
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.scene import Floats, LatticeGas, Method, Obstacle, Occupations, Output, Scene, Wave
from crosscheck.statistics import correlated_mean, independent_mean
from crosscheck.verdict import Judged, bounded, round_off, statistical, worst
from refimpl.lattice.models import MODELS, Model
from refimpl.lattice.theory import (
    collision_term,
    entropy_density,
    fermi_dirac,
    low_speed_equilibrium,
    momentum_flux,
)

PLANES, LOOKUP, NUMPY, BOLTZMANN = (
    Method(scheme=f"lattice_{name}") for name in ("planes", "lookup", "numpy", "boltzmann")
)
NAMES = tuple(MODELS)
ISOTROPIC = tuple(name for name in NAMES if name != "hpp")
FHP = "Frisch et al., Complex Systems 1, 649 (1987)"

#: Faults of the tables, which several checks must see.
NO_COLLISIONS = Fault(
    "no-collisions",
    "lattice/models.py",
    "            outcomes[state] = cycle if identity",
    "            outcomes[state] = (state,) if velocities.channels < 7 else cycle if identity",
    "six-bit and HPP particles never collide",
)
ONE_OUTCOME = Fault(
    "one-outcome",
    "lattice/models.py",
    "            outcomes[state] = cycle if identity",
    "            outcomes[state] = (members[0],) if len(members) > 1 else cycle if identity",
    "all states of a class turn into its first one: no semi-detailed balance",
)


def gas_scene(
    name: str, model: str, rows: int, columns: int, steps: int, initial: Occupations, output: Output, **gas: Any
) -> Scene:
    """A lattice gas; what `gas` says goes into [lattice_gas]."""
    return Scene(
        name=name,
        dimension=2,
        duration=steps,
        lattice_gas=LatticeGas(model=model, rows=rows, columns=columns, **gas),
        initial=initial,
        output=output,
    )


def filled(density: float | tuple[float, ...], seed: int, **more: Any) -> Occupations:
    return Occupations(kind="occupations", density=density, seed=seed, **more)


def populations(run: Run) -> Floats:
    """Particles (samples, blocks along x, along y, b)."""
    return run["populations"]


def momentum(model: Model, counts: Floats) -> Floats:
    """Sum of c_i over the particles, (..., 2), in units of `velocities.unit`: whole numbers."""
    return counts @ np.array(model.velocities.integers, dtype=float)


# -- exact ---------------------------------------------------------------------------------------------


def _judge_conservation(laboratory: Laboratory, variant: str) -> Judged:
    """Whole numbers: mass and momentum of a periodic gas; with smooth walls and a force, those along the walls."""
    model = MODELS[variant]
    seed = laboratory.seed()
    periodic = gas_scene(
        "periodic",
        variant,
        64,
        200,
        200,
        filled(0.3, seed, velocity_x=0.1, velocity_y=0.05),
        Output(interval=10, observables=("populations",)),
    )
    smooth = (Obstacle(rows=(0, 0), rule="specular_y"), Obstacle(rows=(40, 40), rule="specular_y"))
    channel = gas_scene(
        "channel",
        variant,
        64,
        200,
        200,
        filled(0.3, seed),
        Output(interval=10, observables=("populations", "force_impulse")),
        obstacles=smooth,
        force=0.01,
    )
    lost = 0.0
    for method in (PLANES, LOOKUP):
        whole = populations(laboratory.run(periodic, method)).sum(axis=(1, 2))
        pushed = laboratory.run(channel, method)
        forced = populations(pushed).sum(axis=(1, 2))
        given = pushed["force_impulse"].sum(axis=1) / model.velocities.unit[0]
        along = momentum(model, forced)[:, 0]
        for values in (whole.sum(axis=1), *momentum(model, whole).T, forced.sum(axis=1), along - given):
            lost = max(lost, float(np.ptp(values)))
    return round_off(
        "largest change of mass or momentum, in particles",
        lost,
        0.5,
        "whole numbers: the smallest error is 1",
        note=f"200 steps of {variant}, two evolvers, periodic, and in a forced channel with smooth walls",
    )


def _judge_evolvers(laboratory: Laboratory, variant: str) -> Judged:
    """The same sites from bit planes, table look-up and NumPy, with all kinds of walls and a force."""
    seed = laboratory.seed()
    walls = (
        Obstacle(rows=(0, 0), rule="diffusive_y"),
        Obstacle(columns=(0, 0), rule="diffusive_x"),
        Obstacle(rows=(21, 21), rule="specular_y"),
        Obstacle(columns=(70, 70), rule="specular_x"),
        Obstacle(centre=(35.0, 9.0), radius=5.0),
    )
    output = Output(observables=("sites",))
    scene = gas_scene("walls", variant, 30, 133, 100, filled(0.35, seed), output, obstacles=walls, force=-0.05)
    free = gas_scene("free", variant, 30, 133, 100, filled(0.35, seed), output)
    differ = 0
    for one in (scene, free):
        sites = [laboratory.run(one, method)["sites"] for method in (LOOKUP, PLANES, NUMPY)]
        differ += sum(int((other != sites[0]).sum()) for other in sites[1:])
    return round_off(
        "sites in which the evolvers differ",
        float(differ),
        0.5,
        "the random bits of a site are numbered, so all evolvers draw the same: not one bit may differ",
        note=f"{variant}: 100 steps of 30 x 133 sites, free, and with walls of every rule and a force",
    )


def _judge_reversal(laboratory: Laboratory, variant: str) -> Judged:
    """HPP to the number of steps and back: the identical lattice."""
    steps = int(variant)
    obstacles = (
        Obstacle(rows=(0, 0), rule="specular_y"),
        Obstacle(centre=(100.0, 60.0), radius=20.0),
        Obstacle(columns=(150, 151), rows=(10, 90)),
    )
    there = gas_scene(
        "there",
        "hpp",
        128,
        200,
        0,
        filled(0.3, laboratory.seed(), velocity_x=0.2),
        Output(observables=("sites",)),
        obstacles=obstacles,
    )
    start, half, back = (
        laboratory.run(
            there.changed(
                duration=time,
                lattice_gas=LatticeGas(model="hpp", rows=128, columns=200, obstacles=obstacles, reversals=reversals),
            ),
            PLANES,
        )["sites"]
        for time, reversals in ((0, None), (steps, None), (2 * steps, (steps, 2 * steps)))
    )
    changed = int((half != start).sum())
    return worst(
        [
            round_off(
                "sites that differ after the way back", float((back != start).sum()), 0.5, "deterministic: not one bit"
            ),
            bounded("sites that differ half-way", changed, start.size / 4, "else nothing has moved", at_least=True),
        ],
        f"{steps} steps forward and back, 128 x 200 sites with obstacles",
    )


# -- equilibrium -----------------------------------------------------------------------------------------


def named_density(variant: str) -> tuple[str, float]:
    """Model and density of a variant such as fhp1-d0.3."""
    name, density = variant.rsplit("-d", 1)
    return name, float(density)


def at_densities(names: tuple[str, ...], densities: tuple[float, ...]) -> tuple[str, ...]:
    """Variants that `named_density` reads."""
    return tuple(f"{name}-d{density:g}" for name in names for density in densities)


def _judge_equilibrium(laboratory: Laboratory, variant: str) -> Judged:
    """Populations of a gas that starts away from equilibrium, against Fermi-Dirac at the same mass and momentum."""
    name, density = named_density(variant)
    model = MODELS[name]
    target = fermi_dirac(model.velocities, density, (0.2, 0.1))
    # the same mass and momentum, but another distribution: halfway to that with the fewest channels filled
    moved = _away(model, target)
    size, stretches = 128, 64
    start = Occupations(kind="occupations", channels=tuple(moved.tolist()), seed=laboratory.seed())
    scene = gas_scene(
        "relaxation", name, size, size, 200 + 50 * stretches, start, Output(interval=50, observables=("populations",))
    )
    counts = populations(laboratory.run(scene, PLANES))[:, 0, 0] / size**2
    settled = counts[4:]
    rho = float(settled[0].sum())
    velocity = settled[0] @ model.velocities.cartesian / rho
    # mass and momentum of this very gas are what they are: no error in the expectation
    expected = fermi_dirac(model.velocities, rho / model.channels, velocity)
    judgements = []
    for i in range(model.channels):
        mean = correlated_mean(settled[:, i])
        judgements.append(
            statistical(
                f"f_{i}",
                mean.value,
                mean.error,
                float(expected[i]),
                1.0 / size**2,
                f"standard error of {len(settled)} correlated samples; 1/N of fixed mass and momentum",
                samples=mean.independent,
                needed=0.02,
            )
        )
    expansion = low_speed_equilibrium(model.velocities, rho / model.channels, velocity)
    judgements.append(
        bounded(
            "departure at the start, over the largest error",
            float(np.abs(counts[0] - expected).max() / max(1e-12, *(j.uncertainty or 0.0 for j in judgements))),
            20.0,
            "else the gas had nothing to relax",
            at_least=True,
        )
    )
    axis = [float(i) for i in range(model.channels)]
    figure = Figure(
        f"Equilibrium populations at u = (0.2, 0.1), d = {density:g}",
        "channel",
        "mean occupation",
        series=(
            Series(name, axis, settled.mean(axis=0).tolist(), error=[j.uncertainty or 0.0 for j in judgements[:-1]]),
            Series(f"{name}: Fermi-Dirac", axis, expected.tolist(), theory=True),
        ),
    )
    note = f"the expansion to u^2 is off by {np.abs(expansion - expected).max():.2g}"
    return worst(judgements, note, (figure,))


def _away(model: Model, f: Floats) -> Floats:
    """Occupations with the mass and the momentum of f, as far from it as half of the room allows."""
    charges = np.vstack([np.ones(model.channels), model.velocities.cartesian.T])
    # a direction that changes neither mass nor momentum
    direction = np.linalg.svd(charges)[2][-1]
    room = np.where(direction > 0, (1 - f) / np.maximum(direction, 1e-30), f / np.maximum(-direction, 1e-30)).min()
    return f + 0.5 * room * direction


def _judge_pressure(laboratory: Laboratory, variant: str) -> Judged:
    """Momentum flux of a uniform flow in several directions: its anisotropic part over rho u^2, against the theory.

    A flow at the angle a has P_xx - P_yy = rho g u^2 cos 2a and P_xy = rho g u^2 sin(2a)/2 if the tensor is isotropic;
    of HPP P_xy = 0, and g_HPP = 2 G(rho) = 2 (2 - rho)/(4 - rho).
    """
    name, density = named_density(variant)
    model, size, samples = MODELS[name], 1024, 60
    angles = np.radians([0.0, 15.0, 30.0, 45.0])
    speed = 0.2
    judgements, measured, errors, theory = [], [], [], []
    for angle in angles.tolist():
        u = (speed * math.cos(angle), speed * math.sin(angle))
        start = filled(density, laboratory.seed(f"{angle:.3f}"), velocity_x=u[0], velocity_y=u[1])
        scene = gas_scene(
            "flow", name, size, size, 50 * samples, start, Output(interval=50, observables=("populations",))
        )
        counts = populations(laboratory.run(scene, PLANES))[:, 0, 0] / size**2
        rho = float(counts[0].sum())
        velocity = counts[0] @ model.velocities.cartesian / rho
        flux = momentum_flux(model.velocities, counts)
        exact = momentum_flux(model.velocities, fermi_dirac(model.velocities, rho / model.channels, velocity))
        scale = rho * speed**2
        for quantity, values, expected in (
            ("P_xx - P_yy", (flux[:, 0, 0] - flux[:, 1, 1]) / scale, float(exact[0, 0] - exact[1, 1]) / scale),
            ("P_xy", flux[:, 0, 1] / scale, float(exact[0, 1]) / scale),
        ):
            if name == "hpp" and quantity == "P_xy":
                judgements.append(round_off("P_xy of HPP", float(np.abs(values).max()), EPSILON, "c_x c_y = 0"))
                continue
            mean = correlated_mean(values)
            judgements.append(
                statistical(
                    f"{quantity} at {math.degrees(angle):.0f} deg, over rho u^2",
                    mean.value,
                    mean.error,
                    expected,
                    1.0 / size,
                    f"standard error of {len(values)} correlated samples; 1/N of fixed momentum over u^2",
                    samples=mean.independent,
                )
            )
            if quantity == "P_xx - P_yy":
                measured.append(mean.value)
                errors.append(mean.error)
                theory.append(expected)
    figure = Figure(
        f"Anisotropic part of the momentum flux, d = {density:g}",
        "direction of the flow (degrees)",
        "(P_xx - P_yy)/(rho u^2)",
        series=(
            Series(name, np.degrees(angles).tolist(), measured, error=errors),
            Series(f"{name}: equilibrium", np.degrees(angles).tolist(), theory, theory=True),
        ),
    )
    return worst(judgements, f"u = {speed:g}, {size} x {size} sites", (figure,))


# -- H theorem -------------------------------------------------------------------------------------------


def _judge_h(laboratory: Laboratory, variant: str) -> Judged:
    """H never increases: of the Boltzmann iteration at every step, of an ensemble of gases within its error."""
    name, kind = variant.rsplit("-", 1)
    return _h_of_ensemble(laboratory, name) if kind == "ensemble" else _h_of_boltzmann(laboratory, name)


def _h_of_boltzmann(laboratory: Laboratory, name: str) -> Judged:
    model, rows, columns, steps = MODELS[name], 16, 16, 400
    f = _away(model, fermi_dirac(model.velocities, 0.3, (0.1, 0.05)))
    waves = gas_scene(
        "waves",
        name,
        rows,
        columns,
        steps,
        filled(
            0.35,
            laboratory.seed(),
            waves=(
                Wave(of="density", amplitude=0.2, mode=(1.0, 2.0)),
                Wave(of="velocity_x", amplitude=0.2, mode=(0.0, 1.0)),
            ),
        ),
        Output(interval=1, observables=("h_function",)),
    )
    skewed = waves.changed(initial=Occupations(kind="occupations", channels=tuple(f.tolist()), seed=0))
    rises, falls, curves = [], [], []
    for label, scene in (("waves", waves), ("one site's state, everywhere", skewed)):
        h = laboratory.run(scene, BOLTZMANN)["h_function"]
        rises.append(float(np.diff(h).max() / abs(h[0])))
        falls.append(float((h[0] - h[-1]) / abs(h[0])))
        curves.append(Series(f"{name}, {label}", list(range(1, steps + 1)), ((h[:-1] - h[-1]) / abs(h[0])).tolist()))
    return worst(
        [
            bounded(
                "largest rise of H in a step, over |H|",
                max(rises),
                rows * columns * model.channels * EPSILON,
                "a unit of rounding for each channel of the sum",
                figures=(
                    Figure(
                        "H of the Boltzmann iteration", "step", "(H - H_end)/|H|", y_scale="log", series=tuple(curves)
                    ),
                ),
            ),
            bounded("smallest fall of H in all, over |H|", min(falls), 1e-3, "else nothing relaxed", at_least=True),
        ],
        f"{steps} steps of {rows} x {columns} sites, and locally: the same state at every site",
    )


def _h_of_ensemble(laboratory: Laboratory, name: str) -> Judged:
    """Sites of a uniform gas are an ensemble: H of the mean occupations falls to that of Fermi-Dirac.

    The first step starts from independent channels, so the Boltzmann equation gives its fall exactly. Later ones have
    correlations, of which the theorem knows nothing: particles that meet again.
    """
    model, size, steps, members = MODELS[name], 512, 30, 16
    f = _away(model, fermi_dirac(model.velocities, 0.3, (0.1, 0.05)))
    first, rises, ends, falls = [], [], [], []
    for member in range(members):
        start = Occupations(kind="occupations", channels=tuple(f.tolist()), seed=laboratory.seed(str(member)))
        scene = gas_scene("ensemble", name, size, size, steps, start, Output(interval=1, observables=("populations",)))
        counts = populations(laboratory.run(scene, PLANES))[:, 0, 0] / size**2
        h = entropy_density(counts)
        after = counts[0] + collision_term(model, counts[0])
        rho = counts[0].sum()
        last = fermi_dirac(model.velocities, rho / model.channels, counts[0] @ model.velocities.cartesian / rho)
        first.append((h[0] - h[1]) - float(h[0] - entropy_density(after)))
        rises.append(np.diff(h))
        ends.append(h[-1] - float(entropy_density(last)))
        falls.append(h[0] - h[-1])
    fall, step = float(np.mean(falls)), np.mean(rises, axis=0)
    mean, error = independent_mean(first)
    end, end_error = independent_mean(ends)
    floor = model.channels / size**2
    judgements = [
        statistical(
            "fall of H in the first step, less that of the Boltzmann equation, per site",
            mean,
            error,
            0.0,
            floor,
            f"standard error of {members} gases; b/N of the fluctuations of the means",
            samples=members,
        ),
        bounded(
            "largest rise of the ensemble's H in a step, over its whole fall",
            float(step.max()) / fall,
            1e-3,
            "particles that meet again, outside the theorem: in HPP after four steps, 2e-4",
        ),
        statistical(
            "H at the end above that of Fermi-Dirac, per site",
            end,
            end_error,
            0.0,
            floor + 1e-3 * fall,
            f"standard error of {members} gases; b/N, and 1e-3 of the fall for what is not yet relaxed",
            samples=members,
        ),
    ]
    return worst(judgements, f"{members} gases of {size} x {size} sites; H falls by {fall:.4g} per site")


_AT = (0.2, 0.4)

CHECKS = (
    reference_check(
        "lattice/conservation",
        "Mass and momentum of lattice gases, in whole particles",
        "sum_i s_i, sum_i c_i s_i",
        "not one particle, nor a unit of momentum",
        FHP,
        _judge_conservation,
        NAMES,
        (
            (
                "fhp_saturated",
                Fault(
                    "momentum-y-forgotten",
                    "lattice/models.py",
                    "velocities.momentum(state), label",
                    "velocities.momentum(state)[0], label",
                    "collisions need not keep the momentum along y",
                ),
            ),
        ),
    ),
    reference_check(
        "lattice/evolvers",
        "Bit planes, table look-up and NumPy move the same gas",
        "s(t + 1) = C S s(t)",
        "not one bit differs",
        "Frisch, Hasslacher & Pomeau, Phys. Rev. Lett. 56, 1505 (1986)",
        _judge_evolvers,
        NAMES,
        (
            (
                "fhp1",
                Fault(
                    "neighbour-word",
                    "lattice/kernels/words.py",
                    "aside = builder.add(index, ir.Constant(_LANE, -shift))",
                    "aside = builder.add(index, ir.Constant(_LANE, -2 * shift))",
                    "bit planes take the bit at the edge of a word from the next but one",
                ),
            ),
        ),
        tier="quick",
    ),
    reference_check(
        "lattice/reversal",
        "HPP runs backwards to where it came from",
        "(R C)(C S)^n (R C)(C S)^n = 1",
        "the identical lattice",
        "Hardy, de Pazzis & Pomeau, Phys. Rev. A 13, 1949 (1976)",
        _judge_reversal,
        ("10000",),
        (
            (
                "10000",
                Fault(
                    "half-reversal",
                    "lattice/gas.py",
                    "self._set(mirrors[BOUNCE_BACK, after]",
                    "self._set(mirrors[REVERSE_X, after]",
                    "the reversal leaves the velocities along y alone",
                ),
            ),
        ),
        tier="quick",
    ),
    reference_check(
        "lattice/equilibrium",
        "A moving gas relaxes to the Fermi-Dirac distribution",
        "f_i = 1/(1 + exp(h + q.c_i))",
        "every channel within its standard error",
        "Hardy, Pomeau & de Pazzis, J. Math. Phys. 14, 1746 (1973); " + FHP,
        _judge_equilibrium,
        at_densities(NAMES, _AT),
        (("fhp_saturated-d0.2", ONE_OUTCOME), ("hpp-d0.2", NO_COLLISIONS)),
    ),
    reference_check(
        "lattice/pressure-tensor",
        "Momentum flux of a uniform flow: isotropic for FHP, not for HPP",
        "P_ab = c^2/2 rho delta_ab + rho G(rho) T_abcd u_c u_d",
        "within the standard error of the exact equilibrium",
        "Frisch et al., Complex Systems 1, 649 (1987), sec. 5; Wolfram, J. Stat. Phys. 45, 471 (1986)",
        _judge_pressure,
        at_densities(NAMES, (0.2,)),
        (("fhp_saturated-d0.2", ONE_OUTCOME),),
    ),
    reference_check(
        "lattice/h-theorem",
        "H of the lattice Boltzmann iteration, and of an ensemble of gases, never increases",
        "H = sum f ln f + (1 - f) ln(1 - f)",
        "no rise beyond rounding, or beyond the noise of the ensemble",
        FHP + ", appendix F (M. Henon)",
        _judge_h,
        tuple(f"{name}-{kind}" for name in NAMES for kind in ("boltzmann", "ensemble")),
        (("fhp_saturated-boltzmann", ONE_OUTCOME), ("fhp_saturated-ensemble", ONE_OUTCOME)),
    ),
)
