"""Gases of hard spheres by methods that come near to them: equilibrium states to start from, and how they converge.

Soft spheres touch for t_c, so they are late by some t_c at every collision, and hold part of the energy in their
contacts: what they measure differs from hard spheres by a power series in omega t_c, omega the collision rate of a
particle, without a constant term. A search for collisions after each step dt is late by dt/2 in the mean.

Literature: N. Mitarai and H. Nakanishi, Phys. Rev. E 67, 021301 (2003); S. Luding, Nonlinearity 22, R101 (2009).
"""

from __future__ import annotations

import math

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Laboratory
from crosscheck.checks.granular.soft_grains import REFERENCE
from crosscheck.convergence import ORDER_TOLERANCE
from crosscheck.engines.protocol import Run
from crosscheck.figure import Figure, Series
from crosscheck.scene import Box, Floats, HardSpheres, Lattice, Output, Scene, explicit
from crosscheck.scene.overlaps import wrapped
from crosscheck.statistics import independent_mean
from crosscheck.verdict import Judged, bounded, order, statistical, worst

#: dt/t_c. A contact begins and ends anywhere between two steps, which changes its restitution by gamma dt at most, with
#: mean zero; what is left is of order (dt/t_c)^2: halving dt changes T at k = 1e7 by less than 1e-3.
RESOLUTION = 0.025


def relaxed(laboratory: Laboratory, scene: Scene, purpose: str, time: float) -> Scene:
    """The scene with another initial state, in equilibrium: that of elastic hard spheres, run from its lattice.

    laboratory: runs them, event-driven, on the reference engine. scene: hard spheres that start on a lattice in a box.
    purpose: gives the lattice's velocities a seed of their own. time: of that run.
    """
    assert isinstance(scene.initial, Lattice)
    lattice = scene.initial.model_copy(update={"seed": laboratory.seed(purpose)})
    before = scene.changed(initial=lattice, hard_spheres=HardSpheres(), duration=time, output=Output())
    run = laboratory.run(before, EVENT_DRIVEN, engine=REFERENCE)
    lengths, box = scene.lengths(), scene.box
    assert lengths is not None
    assert box is not None
    return scene.changed(
        initial=explicit(wrapped(run["final_positions"], scene.periods()), run["final_velocities"]),
        box=Box(lengths=tuple(lengths.tolist()), boundaries=box.boundaries),
    )


def energies(run: Run) -> Floats:
    """Kinetic energy of `run` at the samples, (samples,)."""
    return run["kinetic_energy"]


def convergence(
    quantity: str,
    engine: str,
    label: str,
    x: Floats,
    found: list[Floats],
    exact: Floats,
    power: float,
    why: str,
    figures: tuple[Figure, ...] = (),
) -> Judged:
    """Departure from 1 of `found` over `exact`, of the same states, as a power of 1/x, and what is left at the end.

    quantity: what found/exact is, in words. engine: name of that which ran them. label: what x (n,) is. found: for each
    x, the values of the first states; the first x is drawn, but lies beyond the range of one power, and is not fitted.
    exact: of all states. power: the expected one, for the reason `why`. figures: further ones.
    """
    departures, errors = [], []
    for values in found:
        mean, error = independent_mean(values - exact[: len(values)])
        scale = float(exact[: len(values)].mean())
        departures.append(mean / scale)
        errors.append(error / scale)
    d, u = np.array(departures), np.array(errors)
    p, u_p, factor = _power_law(x[1:], d[1:], u[1:])
    law = factor * x**-p
    figure = Figure(
        f"Hard limit: {quantity}",
        label,
        f"|{quantity} - 1|",
        "log",
        "log",
        (
            Series(engine, x.tolist(), abs(d).tolist(), u.tolist()),
            Series(f"{engine}: power {-p:.3f}", x.tolist(), abs(law).tolist(), theory=True),
        ),
    )
    before = ", ".join(f"{a:g}: {b:.5f}({c:.5f})" for a, b, c in zip(x[:-1], d[:-1], u[:-1], strict=True))
    tolerance = ORDER_TOLERANCE * power
    return worst(
        [
            order(f"power of 1/x in {quantity} - 1", p, power, tolerance, why, uncertainty=u_p),
            bounded(
                "standard error of that power",
                u_p,
                tolerance,
                "the power is known well enough to be judged",
                control=True,
            ),
            statistical(
                f"{quantity} at the end",
                float(1 + d[-1]),
                float(u[-1]),
                float(1 + law[-1]),
                0.0,
                "standard error over initial states, the same for both",
                samples=len(found[-1]),
                needed=0.02,
            ),
        ],
        f"{quantity} - 1 before the end, at x = {label}: {before}",
        (figure, *figures),
    )


def _power_law(k: Floats, d: Floats, u: Floats) -> tuple[float, float, float]:
    """p with its standard error, and a, in d = a k^(-p), weighted."""
    from scipy.optimize import curve_fit

    def law(log_k: Floats, log_a: float, p: float) -> Floats:
        return np.asarray(np.exp(log_a - p * log_k))

    # first guess: the power 1/2 through the first point, whose sign the law has everywhere
    sign = math.copysign(1.0, d[0])
    guess = (math.log(abs(d[0])) + 0.5 * math.log(k[0]), 0.5)
    (log_a, p), covariance = curve_fit(law, np.log(k), sign * d, guess, u, absolute_sigma=True)
    return float(p), float(covariance[1, 1] ** 0.5), sign * math.exp(log_a)
