"""Homogeneous cooling of smooth grains: Haff's law."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full, small
from crosscheck.checks.events.cooling import MOST, RESTITUTION_SQUARED, STARTS, Cooling, cool, finite_size
from crosscheck.engines.capabilities import Needs
from crosscheck.figure import Figure, Series
from crosscheck.references import granular as reference
from crosscheck.references.hard_spheres import finite_collision_rate
from crosscheck.statistics import independent_mean, standard_error
from crosscheck.verdict import Judged, statistical, worst

#: Collisions of each particle before the measurement: their Maxwell distribution at the start relaxes soon.
WARM = 10.0
#: (dimension, alpha): packing fraction. The more inelastic, the more dilute, so that a box shorter than the clustering
#: length still holds hundreds of grains.
PACKINGS = {
    (2, 0.99): 0.2, (2, 0.95): 0.05, (2, 0.9): 0.02, (2, 0.8): 0.01, (2, 0.7): 0.005,
    (3, 0.99): 0.2, (3, 0.95): 0.07, (3, 0.9): 0.04, (3, 0.8): 0.025, (3, 0.7): 0.02,
}  # fmt: skip


class _Gas(NamedTuple):
    """Grains.

    alpha: coefficient of restitution. most: how many there may be. needed: relative deviations of the loss per
    collision, and of the rate in time, that must be seen.
    """

    dimension: int
    alpha: float
    most: int = MOST
    needed: tuple[float, float] = (0.035, 0.05)


def _judge_haff(laboratory: Laboratory, case: _Gas) -> Judged:
    """The loss of temperature by collisions counted, and by time."""
    dimension, alpha, most, needed = case
    packing, loss = PACKINGS[dimension, alpha], (1 - alpha**2) / dimension
    gas = cool(laboratory, dimension, alpha, None, packing, loss, min(2.8 / loss, 150.0), WARM, most)
    a2, rate = reference.best_cumulant(alpha, dimension), finite_collision_rate(packing, gas.number, dimension)
    length, few = finite_size(gas.number, loss, packing, dimension)
    per_collision = -float(np.log(reference.temperature_after(1.0, alpha, dimension, a2.value)))
    zeta = reference.cooling_rate(alpha, dimension, rate.value, a2.value)
    shape, off = 3 / 16 * a2.uncertainty, 3 / 16 * a2.doubt
    why = (
        f"standard error over {STARTS} gases, and that of a_2 where it was simulated; off by a_2 where it was not, g "
        "at contact, fluctuations and vortices of order 1/N"
    )
    loss_mean, rate_mean = independent_mean(gas.losses()), independent_mean(gas.rates())
    by_count = statistical(
        "loss of ln T per collision of a particle",
        *loss_mean, per_collision, per_collision * 4 / 3 * shape, why,
        samples=STARTS, doubt=per_collision * (4 / 3 * off + few), needed=needed[0],
    )  # fmt: skip
    by_time = statistical(
        "Haff's cooling rate at T = 1",
        *rate_mean, zeta, zeta * shape, why,
        samples=STARTS, doubt=zeta * (off + rate.doubt / rate.value + 1.5 * few), needed=needed[1],
        figures=_haff_figures(gas, f"{dimension}D, alpha = {alpha:g}", rate.value, zeta, per_collision),
    )  # fmt: skip
    return worst(
        [by_count, by_time],
        f"N = {gas.number}, packing fraction {packing:g}, box {length:.2f} of the clustering length",
    )


def _haff_figures(gas: Cooling, label: str, rate: float, zeta: float, loss: float) -> tuple[Figure, ...]:
    """T(t)/T(t_1) with time in collision times at t_1, and T against collisions.

    rate: of collisions of a particle at T = 1; zeta: Haff's rate there; loss: of ln T per collision, in theory.
    """
    first = gas.temperatures[:, :1]
    x = (rate * first**0.5 * (gas.times - gas.times[:, :1])).mean(axis=0)
    ratio = gas.temperatures / first
    y, error = ratio.mean(axis=0), standard_error(ratio)
    fine = np.geomspace(x[1] / 20, x[-1], 60)
    s = gas.collisions - gas.collisions[0]
    return (
        Figure(
            "Haff's law", "time / initial time between collisions", "T/T_0", "log", "log",
            (
                Series(label, x[1:].tolist(), y[1:].tolist(), error[1:].tolist()),
                Series(f"{label}, Haff", fine.tolist(), reference.haff(fine, 1.0, zeta / rate).tolist(), theory=True),
            ),
        ),
        Figure(
            "temperature against collisions", "collisions of a particle", "T/T_0", "linear", "log",
            (
                Series(label, s.tolist(), y.tolist(), error.tolist()),
                Series(f"{label}, theory", s.tolist(), np.exp(-loss * s).tolist(), theory=True),
            ),
        ),
    )  # fmt: skip


HAFF = Check(
    name="events/haff",
    title="Homogeneous cooling of smooth grains: Haff's law",
    equation="T = T_0/(1 + zeta_0 t/2)^2 = T_0 exp(-(1 - alpha^2) s/d (1 + 3 a_2/16)/(1 - a_2/16)), "
    "zeta = (1 - alpha^2) w/d (1 + 3 a_2/16)",
    criterion=f"{STARTS} gases shorter than half the clustering length, after {WARM:g} collisions a particle",
    citation="Haff, J. Fluid Mech. 134, 401 (1983); van Noije & Ernst, Granul. Matter 1, 57 (1998)",
    judge=_judge_haff,
    # the quick tier audits each impact
    variants=(*full(**{"2d-0.9": _Gas(2, 0.9)}), small("2d-0.9-N100", _Gas(2, 0.9, 100, (0.08, 0.1)), "2d-0.9")),
    needs=Needs(
        "hard_spheres",
        (EVENT_DRIVEN,),
        words=frozenset({"box.boundaries=periodic", "hard_spheres.restitution", "output.collisions"}),
        observables=frozenset({"kinetic_energy", "dissipated_energy", "collisions"}),
    ),
    faults=(("2d-0.9", RESTITUTION_SQUARED), ("2d-0.9-N100", RESTITUTION_SQUARED)),
)
#: The same gases at other restitutions, and spheres: a check of its own, because its name seeds its cases.
SERIES = replace(
    HAFF,
    name="events/haff-series",
    variants=full(**{f"{d}d-{alpha:g}": _Gas(d, alpha) for d, alpha in PACKINGS if (d, alpha) != (2, 0.9)}),
    faults=(("2d-0.99", RESTITUTION_SQUARED),),
)
CHECKS = (HAFF, SERIES)
