"""A shear wave in a flow drifts with g(rho) U: lattice gases are not Galilean invariant."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import Check, Laboratory
from crosscheck.checks.lattice.gases import FHP, ISOTROPIC, LATTICE, NO_COLLISIONS, State, at_densities
from crosscheck.checks.lattice.waves import (
    BY_MEMBERS,
    DENSITIES,
    MEMBERS,
    amplitude_at_start,
    measure_mode,
    transverse_momentum,
    wavenumber,
)
from crosscheck.engines.capabilities import Needs
from crosscheck.figure import Figure, Series
from crosscheck.references import lattice_gas as known
from crosscheck.references.lattice_models import VELOCITIES, modes
from crosscheck.scene import Wave
from crosscheck.statistics import independent_mean
from crosscheck.verdict import Judged, statistical, worst


def _judge(laboratory: Laboratory, state: State) -> Judged:
    """A shear wave in a flow U along its wave vector drifts with g(rho) U, not with U."""
    name, density = state
    rows, flow, amplitude = 256, 0.1, 0.025
    k = wavenumber(name, rows)
    boltzmann = modes(name, density, (0.0, k), (0.0, flow))
    steps = int(min(1.2 / boltzmann.shear_decay, 2000))
    signals = measure_mode(
        laboratory,
        name,
        density,
        (Wave(of="velocity_x", amplitude=amplitude, mode=(0.0, 1.0)),),
        transverse_momentum(name),
        rows=rows,
        columns=2048,
        steps=steps,
        every=max(1, steps // 60),
        flow=flow,
    )
    drifts = []
    for s in signals.values:
        # weights: the amplitude, by which the noise of the phase falls
        slope = np.polyfit(signals.times[1:], np.unwrap(np.angle(s[1:])), 1, w=abs(s[1:]))[0]
        drifts.append(-slope / (k * flow))
    value, u = independent_mean(drifts)
    expected = float(np.round(boltzmann.shear_frequency / (k * flow), 12))  # 0 at d = 1/2, but for rounding
    axis = np.linspace(0.08, 0.62, 55).tolist()
    figure = Figure(
        "Advection: g over density",
        "d",
        "g",
        series=(
            Series(name, [density], [value], error=[u]),
            Series(f"{name}: theory", axis, [known.galilean_factor(name, d) for d in axis], theory=True),
        ),
    )
    judgement = statistical(
        "g = drift/(k U)",
        value,
        u,
        expected,
        0.0,
        f"{BY_MEMBERS}; Boltzmann at this k and U, the wave's amplitude squared for its own nonlinearity",
        samples=MEMBERS,
        doubt=amplitude**2,
        figures=(figure,),
    )
    asked = VELOCITIES[name].channels * density * amplitude
    note = f"U = {flow:g}; g(rho), as k and U go to 0, is {known.galilean_factor(name, density):.4f}"
    return worst([amplitude_at_start(signals, asked, "shear wave in a flow"), judgement], note)


CHECKS = (
    Check(
        name="lattice/advection",
        title="A shear wave in a flow drifts with g(rho) U",
        equation="g = D/(D + 2) (b - 2 rho)/(b - rho), with a rest particle 7/6 of it",
        criterion="within the standard error",
        citation=FHP,
        judge=_judge,
        variants=at_densities(ISOTROPIC, DENSITIES),
        faults=(("fhp1-d0.2", NO_COLLISIONS),),
        needs=Needs("lattice_gas", (LATTICE,), observables=frozenset({"populations"})),
    ),
)
