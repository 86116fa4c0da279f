"""H never increases: of the lattice Boltzmann iteration at every step, of an ensemble of gases within its error."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.lattice.gases import (
    FHP,
    LATTICE,
    ONE_OUTCOME,
    away,
    boltzmann_method,
    filled,
    filled_channels,
    gas_scene,
    populations,
    started,
)
from crosscheck.engines.capabilities import Needs
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.references.lattice_models import MODELS, VELOCITIES, entropy_density, fermi_dirac, mean_collision
from crosscheck.scene import Output, Wave
from crosscheck.statistics import independent_mean
from crosscheck.verdict import Judged, bounded, statistical, worst


class _Case(NamedTuple):
    """A model, moved as mean occupations by the Boltzmann equation, or as an ensemble of gases."""

    model: str
    ensemble: bool


def _judge(laboratory: Laboratory, case: _Case) -> Judged:
    return _of_ensemble(laboratory, case.model) if case.ensemble else _of_boltzmann(laboratory, case.model)


def _of_boltzmann(laboratory: Laboratory, name: str) -> Judged:
    """Of mean occupations: waves, and the same state at every site."""
    rows, columns, steps = 16, 16, 400
    f = away(name, fermi_dirac(name, 0.3, (0.1, 0.05)))
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
    skewed = waves.changed(initial=filled_channels(f, 0))
    method = boltzmann_method(laboratory)
    judgements, curves = [], []
    for label, scene in (("waves", waves), ("one site's state, everywhere", skewed)):
        h = laboratory.run(scene, method)["h_function"]
        judgements += [
            bounded(
                f"{label}: largest rise of H in a step, over |H|",
                float(np.diff(h).max() / abs(h[0])),
                rows * columns * VELOCITIES[name].channels * EPSILON,
                "a unit of rounding for each channel of the sum",
            ),
            bounded(
                f"{label}: fall of H in all, over |H|",
                float((h[0] - h[-1]) / abs(h[0])),
                1e-3,
                "else nothing relaxed",
                at_least=True,
                control=True,
            ),
        ]
        curves.append(Series(f"{name}, {label}", list(range(1, steps + 1)), ((h[:-1] - h[-1]) / abs(h[0])).tolist()))
    figure = Figure("H of the Boltzmann iteration", "step", "(H - H_end)/|H|", y_scale="log", series=tuple(curves))
    return worst(judgements, f"{steps} steps of {rows} x {columns} sites", (figure,))


def _of_ensemble(laboratory: Laboratory, name: str) -> Judged:
    """Sites of a uniform gas are an ensemble: H of the mean occupations falls to that of Fermi-Dirac.

    The first step starts from independent channels, so the Boltzmann equation gives its fall exactly. Later ones have
    correlations, since particles meet again; the theorem does not hold for these.
    """
    size, steps, members = 512, 30, 16
    velocities = VELOCITIES[name]
    f = away(name, fermi_dirac(name, 0.3, (0.1, 0.05)))
    first, rises, ends, falls, starts = [], [], [], [], []
    for member in range(members):
        start = filled_channels(f, laboratory.seed(str(member)))
        scene = gas_scene("ensemble", name, size, size, steps, start, Output(interval=1, observables=("populations",)))
        counts = populations(laboratory.run(scene, LATTICE))[:, 0, 0] / size**2
        h = entropy_density(counts)
        after = counts[0] + mean_collision(name, counts[0])
        rho = counts[0].sum()
        last = fermi_dirac(name, rho / velocities.channels, counts[0] @ velocities.cartesian / rho)
        starts.append(counts[0])
        first.append((h[0] - h[1]) - float(h[0] - entropy_density(after)))
        rises.append(np.diff(h))
        ends.append(h[-1] - float(entropy_density(last)))
        falls.append(h[0] - h[-1])
    # a wrong gas may rise: what it is compared with is the size of its whole change
    fall, step = abs(float(np.mean(falls))), np.mean(rises, axis=0)
    mean, error = independent_mean(first)
    end, end_error = independent_mean(ends)
    floor = velocities.channels / size**2
    judgements: list[Judged] = [
        started(np.mean(starts, axis=0), f, name, members * size**2),
        statistical(
            "fall of H in the first step, less that of the Boltzmann equation, per site",
            mean,
            error,
            0.0,
            0.0,
            f"standard error of {members} gases; off by b/N of the fluctuations of the means",
            samples=members,
            doubt=floor,
        ),
        bounded(
            "largest rise of the ensemble's H in a step, over its whole change",
            float(step.max()) / fall,
            1e-3,
            "particles that meet again, outside the theorem: in HPP after four steps, 2e-4",
        ),
        statistical(
            "H at the end above that of Fermi-Dirac, per site",
            end,
            end_error,
            0.0,
            0.0,
            f"standard error of {members} gases; off by b/N, and 1e-3 of the fall for what is not yet relaxed",
            samples=members,
            doubt=floor + 1e-3 * fall,
        ),
    ]
    return worst(judgements, f"{members} gases of {size} x {size} sites; H changes by {fall:.4g} per site")


CHECKS = (
    Check(
        name="lattice/h-theorem",
        title="H of the lattice Boltzmann iteration, and of an ensemble of gases, never increases",
        equation="H = sum f ln f + (1 - f) ln(1 - f)",
        criterion="no rise beyond rounding, or beyond the noise of the ensemble",
        citation=FHP + ", appendix F (M. Henon)",
        judge=_judge,
        variants=tuple(
            Variant(f"{name}-{'ensemble' if ensemble else 'boltzmann'}", _Case(name, ensemble), "full")
            for name in MODELS
            for ensemble in (False, True)
        ),
        faults=(("fhp_saturated-boltzmann", ONE_OUTCOME), ("fhp_saturated-ensemble", ONE_OUTCOME)),
        # an engine that counts particles alone is judged by its ensembles, and the other cases are skipped
        needs=Needs("lattice_gas", (LATTICE,), observables=frozenset({"populations"})),
    ),
)
