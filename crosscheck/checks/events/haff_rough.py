"""Homogeneous cooling of rough grains: rotational against translational temperature."""

from __future__ import annotations

from typing import NamedTuple

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full
from crosscheck.checks.events.cooling import STARTS, cool, finite_size
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import granular as reference
from crosscheck.references.hard_spheres import finite_collision_rate
from crosscheck.scene import GrainFriction
from crosscheck.statistics import independent_mean, standard_error
from crosscheck.verdict import Judged, statistical, worst

#: Collisions of each particle before the measurement: spins, at rest at the start, follow with exp(-s/10).
ROUGH_WARM = 50.0
#: Collisions of each particle in the measurement: long enough that 16 gases tell the ratio to a hundredth.
ROUGH_SPAN = 45.0
#: dimension: packing fraction, dilute enough for a thousand disks in a short box.
ROUGH_PACKINGS = {2: 0.005, 3: 0.02}


class _Rough(NamedTuple):
    """The dimension, q = I/(m R^2), and the coefficients of normal and tangential restitution."""

    dimension: int
    q: float
    alpha: float
    alpha_t: float


def _judge_rough(laboratory: Laboratory, case: _Rough) -> Judged:
    """The ratio of temperatures that the gas settles to, and its loss of temperature there."""
    dimension, q, alpha, alpha_t = case
    ratio, packing = reference.ROUGH_RATIOS[case], ROUGH_PACKINGS[dimension]
    closure = reference.rough_ratio(alpha, alpha_t, q, dimension)
    # of the whole energy, and so of either temperature, in the homogeneous state
    losses = [-reference.rough_rates(1.0, x, alpha, alpha_t, q, dimension)[0] for x in (ratio.value, closure)]
    friction = GrainFriction(tangential_restitution=alpha_t, inertia=q)
    gas = cool(laboratory, dimension, alpha, friction, packing, max(losses), ROUGH_SPAN, ROUGH_WARM)
    measured = gas.rotational / gas.temperatures
    _, few = finite_size(gas.number, max(losses), packing, dimension)
    why = f"standard error over {STARTS} independent gases"
    x, label = gas.collisions, f"{dimension}d, alpha = {alpha:g}, alpha_t = {alpha_t:g}"
    figure = Figure(
        "rotational over translational temperature", "collisions of a particle", "T_rot/T_tr", "linear", "linear",
        (
            Series(label, x.tolist(), measured.mean(axis=0).tolist(), standard_error(measured).tolist()),
            Series(f"{label}, Boltzmann equation", [x[0], x[-1]], [ratio.value] * 2, theory=True),
        ),
    )  # fmt: skip
    settles = statistical(
        "T_rot/T_tr of the homogeneous cooling state",
        *independent_mean(measured.mean(axis=1)), ratio.value, ratio.uncertainty,
        f"{why}; expected: direct simulation of the Boltzmann equation, off by 0.5 % and terms of order 1/N",
        samples=STARTS, doubt=ratio.doubt + ratio.value * few, needed=0.05, figures=(figure,),
    )  # fmt: skip
    decays = statistical(
        "loss of ln T per collision of a particle",
        *independent_mean(gas.losses()), losses[0], 0.0,
        f"{why}; expected: Maxwellian rates at the simulated ratio, off by what the closure's own ratio changes",
        samples=STARTS, doubt=abs(losses[1] - losses[0]) + losses[0] * few, needed=0.04,
    )  # fmt: skip
    rate = finite_collision_rate(packing, gas.number, dimension)
    by_time = statistical(
        "cooling rate at T_tr = 1",
        *independent_mean(gas.rates()), losses[0] * rate.value, 0.0,
        f"{why}; expected: the same rates with Enskog's collision rate, off by the same and 1 % of it (the cumulants)",
        samples=STARTS, doubt=rate.value * (abs(losses[1] - losses[0]) + losses[0] * (1.5 * few + 0.01)), needed=0.08,
    )  # fmt: skip
    return worst([settles, decays, by_time], f"N = {gas.number}; the Maxwellian closure has T_rot/T_tr = {closure:.4f}")


CHECKS = (
    Check(
        name="events/haff-rough",
        title="Homogeneous cooling of rough grains: rotational against translational temperature",
        equation="dln T_rot/dt = dln T_tr/dt, constant alpha and alpha_t",
        criterion=f"{STARTS} gases, against direct simulation of the Boltzmann equation",
        citation="Huthmann & Zippelius, Phys. Rev. E 56, R6275 (1997); Santos et al., Phys. Fluids 23, 030604 (2011)",
        judge=_judge_rough,
        variants=full(
            **{
                f"{c.dimension}d-alpha{c.alpha:g}-alpha_t{c.alpha_t:g}": c
                for c in (_Rough(*one) for one in reference.ROUGH_RATIOS)
            }
        ),
        needs=Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=frozenset(
                {
                    "box.boundaries=periodic",
                    "hard_spheres.friction",
                    "hard_spheres.friction.inertia",
                    "hard_spheres.restitution",
                    "output.collisions",
                }
            ),
            observables=frozenset({"kinetic_energy", "dissipated_energy", "collisions", "rotational_energy"}),
        ),
        faults=(
            (
                "3d-alpha0.9-alpha_t0",
                Fault(
                    "inertia-of-the-contact",
                    "events/rules.py",
                    "stick = (1.0 - alpha_t) * inertia / (1.0 + inertia) * mass",
                    "stick = (1.0 - alpha_t) * inertia / (1.0 + 2.0 * inertia) * mass",
                    "the tangential impulse has the wrong effective mass",
                ),
            ),
        ),
    ),
)
