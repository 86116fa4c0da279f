"""Standard error against run time of averages of hard disks: the pressure, and the rate at which grains cool.

Literature: P. K. Haff, J. Fluid Mech. 134, 401 (1983); S. Luding, Phys. Rev. E 63, 042201 (2001).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.events.cooling import RESTITUTION_SQUARED, finite_size
from crosscheck.checks.events.gases import LATTICE, event_driven
from crosscheck.checks.granular.gases import relaxed
from crosscheck.checks.performance.work_precision_averaging import CRITERION, FACTOR, averaged
from crosscheck.engines.protocol import Claims, Run
from crosscheck.faults import Fault
from crosscheck.references import granular
from crosscheck.references import hard_spheres as reference
from crosscheck.scene import Box, HardSpheres, Lattice, Method, Output, Scene
from crosscheck.statistics import independent_mean
from crosscheck.verdict import Judged, statistical, worst

_PACKING, _NUMBER = 0.4, 256
#: Collisions of a disk in the shortest run; rungs of the ladder.
_SHORTEST, _RUNGS = 10, 4
#: The cooling gas: restitution and packing fraction, collisions of a disk that are left out and measured, fewest disks.
_ALPHA, _DILUTE, _WARM, _MEASURED, _FEWEST = 0.9, 0.02, 10, 20, 36
_FOR_EVER = 1e9


def _schemes(schemes: Mapping[str, Claims]) -> Iterable[Variant]:
    """One variant per event-driven scheme that measures sums over collisions."""
    return (
        Variant(name, name, "full")
        for name, claims in schemes.items()
        if claims.kind == "event_driven" and not name.endswith("_naive")
    )


def _collisions(run: Run) -> float:
    return float(run["collisions"][-1])


def _judge_pressure(laboratory: Laboratory, scheme: str) -> Judged:
    """Z - 1 = sum r_ij.dp_ij/(d N T t) of 256 elastic disks, from runs of growing numbers of collisions."""
    counts = [_SHORTEST * _NUMBER // 2 * FACTOR**k for k in range(_RUNGS)]
    gas = Scene(
        name="work-precision-hard-disks",
        dimension=2,
        duration=_FOR_EVER,
        hard_spheres=HardSpheres(),
        box=Box(packing_fraction=_PACKING),
        initial=Lattice(kind="lattice", structure="square", number=_NUMBER, temperature=1.0, seed=0),
        output=Output(collisions=(counts[0],), observables=("collisional_virial", "collisions")),
    )
    method = Method(scheme=scheme)
    laboratory.demand(gas, method)
    starts: dict[int, Scene] = {}

    def one(count: float, member: int) -> tuple[float, Run]:
        if member not in starts:
            starts[member] = relaxed(laboratory, gas, f"state {member}", 8.0)
        output = gas.output.model_copy(update={"collisions": (int(count),)})
        run = laboratory.run(starts[member].changed(output=output), method)
        kinetic = 0.5 * float((starts[member].initial_state().velocities ** 2).sum())
        return float(run["collisional_virial"][-1]) / (2 * kinetic * float(run["time"][-1])), run

    found = averaged(counts, one)
    known = reference.finite_compressibility(_PACKING, _NUMBER, 2)
    excess, error = independent_mean(found.values[-1])
    # the momentum of the box is zero: 2K = d (N - 1) T, while the pressure has N T
    share = 1 - 1 / _NUMBER
    mean = statistical(
        "Z from the collisional virial, of the longest runs",
        1 + excess * share,
        error * share,
        known.value,
        0.0,
        "standard error of independent runs; the spread of published equations of state, for this N",
        samples=found.values.shape[1],
        doubt=known.doubt,
    )
    figure = found.figure(
        f"the pressure of {_NUMBER} hard disks, packing fraction {_PACKING:g}",
        scheme, laboratory.claims[scheme], "collisions", _collisions, "collisions",
    )  # fmt: skip
    return worst([found.exponent(), mean], found.merit(), (figure,))


def _judge_haff(laboratory: Laboratory, scheme: str) -> Judged:
    """Loss of ln T per collision of a disk, from gases of growing numbers of disks."""
    numbers = [_FEWEST * FACTOR**k for k in range(_RUNGS)]
    method = Method(scheme=scheme)

    def one(number: float, member: int) -> tuple[float, Run]:
        n = int(number)
        gas = Scene(
            name="work-precision-haff",
            dimension=2,
            duration=_FOR_EVER,
            hard_spheres=HardSpheres(restitution=_ALPHA),
            box=Box(packing_fraction=_DILUTE),
            initial=Lattice(
                kind="lattice", structure=LATTICE[2], number=n, temperature=1.0,  # type: ignore[arg-type]
                seed=laboratory.seed(f"{n}/{member}"),
            ),
            output=Output(
                collisions=(n // 2 * _WARM, n // 2 * (_WARM + _MEASURED)), observables=("kinetic_energy", "collisions")
            ),
        )  # fmt: skip
        run = laboratory.run(gas, method)
        energy = run["kinetic_energy"]
        return float(np.log(energy[1] / energy[2])) / _MEASURED, run

    found = averaged(numbers, one)
    a2 = granular.best_cumulant(_ALPHA, 2)
    per_collision = -float(np.log(granular.temperature_after(1.0, _ALPHA, 2, a2.value)))
    _, few = finite_size(numbers[-1], (1 - _ALPHA**2) / 2, _DILUTE, 2)
    loss, error = independent_mean(found.values[-1])
    mean = statistical(
        "loss of ln T per collision of a disk, of the largest gases",
        loss,
        error,
        per_collision,
        per_collision / 4 * a2.uncertainty,
        "standard error of independent gases; off by a_2, fluctuations and vortices of order 1/N",
        samples=found.values.shape[1],
        doubt=per_collision * (a2.doubt / 4 + few),
    )
    figure = found.figure(
        f"Haff's cooling of hard disks, restitution {_ALPHA:g}",
        scheme, laboratory.claims[scheme], "disks", _collisions, "collisions",
    )  # fmt: skip
    return worst([found.exponent(), mean], found.merit(), (figure,))


_VIRIAL = Fault(
    "virial-3-percent",
    "events/kernels/measure.py",
    "_add(tallies, VIRIAL, distance * (px * x + py * y + pz * z))",
    "_add(tallies, VIRIAL, 1.03 * distance * (px * x + py * y + pz * z))",
    "the collisional virial is 3 % too large",
)
CHECKS = (
    Check(
        name="performance/work-precision-hard-disk-pressure",
        title="Work and precision on the pressure of hard disks",
        equation="Z = 1 + sum r_ij.dp_ij/(d N T t)",
        criterion=CRITERION,
        citation="Luding, Phys. Rev. E 63, 042201 (2001); Wolff, Comput. Phys. Commun. 156, 143 (2004)",
        judge=_judge_pressure,
        variants=_schemes,
        faults=(("event_driven", _VIRIAL),),
        needs=event_driven("dimension=2 box.boundaries=periodic output.collisions", "collisions collisional_virial"),
        timing=True,
    ),
    Check(
        name="performance/work-precision-haff",
        title="Work and precision on Haff's cooling of inelastic disks",
        equation="T = T_0 exp(-(1 - alpha^2) s/d (1 + 3 a_2/16)/(1 - a_2/16)), s collisions of a disk",
        criterion=CRITERION,
        citation="Haff, J. Fluid Mech. 134, 401 (1983); van Noije & Ernst, Granul. Matter 1, 57 (1998)",
        judge=_judge_haff,
        variants=_schemes,
        faults=(("event_driven", RESTITUTION_SQUARED),),
        needs=event_driven(
            "dimension=2 box.boundaries=periodic hard_spheres.restitution output.collisions",
            "kinetic_energy collisions",
        ),
        timing=True,
    ),
)
