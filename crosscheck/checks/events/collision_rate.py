"""Collision rate of a particle among periodic disks and spheres, many and few; sigma = m = T = 1."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, small, variants_of
from crosscheck.checks.events.gases import TALLIES, event_driven, rates, run_periodic
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import hard_spheres as reference
from crosscheck.references.speeds import maxwell_mean_speed
from crosscheck.statistics import correlated_mean
from crosscheck.verdict import Judged, statistical


class _Gas(NamedTuple):
    """A periodic gas.

    eta: packing fraction; number: of particles. collisions: of pairs in its run. needed: relative deviation of the rate
    that must be seen.
    """

    dimension: int
    eta: float
    number: int
    collisions: float = 2e6
    needed: float = 0.01


#: Other states than those of the equation of state; the small ones test the dependence on N.
_GASES = {
    **{f"disks-eta{eta:g}": _Gas(2, eta, 1024) for eta in (0.02, 0.15, 0.35, 0.55)},
    # to order 1/N alone, which is rough for 16
    "disks-eta0.3-N16": _Gas(2, 0.3, 16, needed=0.03),
    **{f"spheres-n{n:g}": _Gas(3, reference.packing_fraction(n, 3), 1000) for n in (0.2, 0.4, 0.6, 0.8)},
    "spheres-n0.4-N64": _Gas(3, reference.packing_fraction(0.4, 3), 64),
}


def _judge(laboratory: Laboratory, gas: _Gas) -> Judged:
    d, eta, number, collisions, needed = gas
    run = run_periodic(laboratory, d, eta, number, collisions)
    rate = correlated_mean(2 * rates(run, run["collisions"]) / number)
    known, infinite = reference.finite_collision_rate(eta, number, d), reference.collision_rate(eta, d)
    path = maxwell_mean_speed(d) / rate.value
    dilute = infinite.value / reference.contact_value(eta, d).value
    x = np.linspace(0.005, 0.65 if d == 2 else reference.packing_fraction(0.9, 3), 50)
    law = [reference.contact_value(e, d).value for e in x]
    figure = Figure(
        "collision rate, " + ("disks" if d == 2 else "spheres"), "eta", "rate over that of Boltzmann's gas", "linear",
        "log", (
            Series(f"N = {number}", [eta], [rate.value / dilute], [rate.error / dilute]),
            Series("Enskog, g at contact", x.tolist(), law, theory=True),
        ),
    )  # fmt: skip
    return statistical(
        "collisions of a particle per time",
        rate.value,
        rate.error,
        known.value,
        0.0,
        "standard error of correlated blocks; how far the reference is off for this N",
        samples=rate,
        doubt=known.doubt,
        needed=needed,
        note=f"N = {number}, mean free path {path:.4g}; infinite N: {infinite.value:.5g}",
        figures=(figure,),
    )


def _larger_disks(percent: int) -> Fault:
    return Fault(
        f"disks-{percent}-percent",
        "events/prediction.py",
        "        return diameter\n    return radii[i] + radii[j]",
        f"        return {1 + percent / 100} * diameter\n    return radii[i] + radii[j]",
        f"particles of one size collide at a distance {percent} % too large",
    )


CHECKS = (
    Check(
        name="events/collision-rate",
        title="Collision rate of a particle among periodic disks and spheres against Enskog's, many and few particles",
        equation="omega = 2 n sigma g sqrt(pi T/m) (2D), 4 n sigma^2 g sqrt(pi T/m) (3D), times the corrections for N",
        criterion="within the errors of correlated blocks and of the reference, corrected for finite N",
        citation="Chapman & Cowling (1970), chapter 16; Lebowitz & Percus, Phys. Rev. 122, 1675 (1961)",
        judge=_judge,
        variants=(
            *variants_of(_GASES, "full"),
            small("disks-eta0.35-N64", _Gas(2, 0.35, 64, 2e4, 0.08), "disks-eta0.35"),
        ),
        needs=event_driven("box.boundaries=periodic", " ".join(TALLIES)),
        faults=(("disks-eta0.35", _larger_disks(1)), ("disks-eta0.35-N64", _larger_disks(5))),
    ),
)
