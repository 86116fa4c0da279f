"""Error against run time of averages of hard disks: the pressure, and the rate at which grains cool.

Event-driven runs have a standard error alone. Disks that are soft, and move by time steps, err by their softness too:
by some omega t_c, omega their rate of collisions and t_c the time that a contact takes. Both shrink best together, so
t_c falls with the square root of what is averaged over, and the error of a run, by its root mean square about what hard
disks have, with work^(-1/3).

Literature: P. K. Haff, J. Fluid Mech. 134, 401 (1983); S. Luding, Phys. Rev. E 63, 042201 (2001).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, Variant, soft
from crosscheck.checks.events.cooling import RESTITUTION_SQUARED, finite_size
from crosscheck.checks.events.gases import LATTICE, duration_of, event_driven
from crosscheck.checks.granular.gases import relaxed
from crosscheck.checks.granular.soft_grains import CONTACTS, soft_needs
from crosscheck.checks.performance.work_precision_averaging import CRITERION, FACTOR, Averages, averaged
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Claims, Run
from crosscheck.faults import Fault
from crosscheck.references import granular
from crosscheck.references import hard_spheres as reference
from crosscheck.scene import Box, HardSpheres, Lattice, Method, Output, Scene
from crosscheck.statistics import independent_mean
from crosscheck.verdict import Judged, Judgement, statistical, worst

_PACKING, _NUMBER = 0.4, 256
#: Collisions of a disk in the shortest run; rungs of the ladder.
_SHORTEST, _RUNGS = 10, 4
#: The cooling gas: restitution and packing fraction, collisions of a disk that are left out and measured, fewest disks.
_ALPHA, _DILUTE, _WARM, _MEASURED, _FEWEST = 0.9, 0.02, 10, 20, 36
_FOR_EVER = 1e9
#: Soft disks: scheme; rungs; omega t_c in the shortest runs, of the pressure, and at the start of the smallest gas that
#: cools; dt/t_c of both. A contact begins anywhere between two steps: what is left of that is of order (dt/t_c)^2.
_SOFT, _SOFT_RUNGS = "velocity_verlet", 3
_TOUCHING, _TOUCHING_COOLING, _RESOLUTION, _RESOLUTION_COOLING = 0.08, 0.04, 0.05, 0.1
#: Samples of the kinetic energy, from which the mean of soft disks is taken.
_SAMPLES = 200


def _schemes(schemes: Mapping[str, Claims]) -> Iterable[Variant]:
    """One variant per event-driven scheme that measures sums over collisions, and soft disks by one scheme."""
    for name, claims in schemes.items():
        if claims.kind == "event_driven" and not name.endswith("_naive"):
            yield Variant(name, name, "full", needs=event_driven("output.collisions", "collisions"))
        elif name == _SOFT:
            soft_disks = soft_needs("method.contact.duration", "contact_time kinetic_energy")
            yield Variant(name, name, "full", needs=soft_disks)


def _collisions(run: Run) -> float:
    return float(run["collisions"][-1])


def _judge_pressure(laboratory: Laboratory, scheme: str) -> Judged:
    """Z - 1 = sum r_ij.dp_ij/(d N T t) of 256 elastic disks, from runs of growing numbers of collisions."""
    if scheme == _SOFT:
        return _judge_soft_pressure(laboratory)
    counts = _counts(_RUNGS)
    gas = _gas(_FOR_EVER, Output(collisions=(counts[0],), observables=("collisional_virial", "collisions")))
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
    mean = _compressibility(found, 0.0, "")
    figure = found.figure(_PRESSURE, scheme, laboratory.claims[scheme], "collisions", _collisions, "collisions")
    return worst([found.exponent(), mean], found.merit(), (figure,))


_PRESSURE = f"the pressure of {_NUMBER} hard disks, packing fraction {_PACKING:g}"
#: The momentum of the box is zero: 2K = d (N - 1) T, while the pressure has N T.
_SHARE = 1 - 1 / _NUMBER


def _counts(rungs: int) -> list[int]:
    """Collisions in the runs of each rung."""
    return [_SHORTEST * _NUMBER // 2 * FACTOR**k for k in range(rungs)]


def _gas(duration: float, output: Output) -> Scene:
    """256 elastic disks on a lattice, T = 1."""
    return Scene(
        name="work-precision-hard-disks",
        dimension=2,
        duration=duration,
        hard_spheres=HardSpheres(),
        box=Box(packing_fraction=_PACKING),
        initial=Lattice(kind="lattice", structure="square", number=_NUMBER, temperature=1.0, seed=0),
        output=output,
    )


def _compressibility(found: Averages, softness: float, why: str) -> Judgement:
    """The judgement that the longest runs have the pressure of hard disks.

    softness: relative, that soft disks may err by in Z - 1. why: it may be so.
    """
    known = reference.finite_compressibility(_PACKING, _NUMBER, 2)
    excess, error = independent_mean(found.values[-1])
    return statistical(
        "Z from the collisional virial, of the longest runs",
        1 + excess * _SHARE,
        error * _SHARE,
        known.value,
        0.0,
        f"standard error of independent runs; the spread of published equations of state, for this N{why}",
        samples=found.values.shape[1],
        doubt=known.doubt + (known.value - 1) * softness,
    )


def _judge_soft_pressure(laboratory: Laboratory) -> Judged:
    """The same of disks that touch for t_c: their mean kinetic energy, and the virial of their forces."""
    counts = _counts(_SOFT_RUNGS)
    rate = reference.collision_rate(_PACKING, 2, 1.0).value
    touching = [_TOUCHING * (counts[0] / count) ** 0.5 for count in counts]
    durations = [duration_of(count, _NUMBER, _PACKING, 2) for count in counts]
    methods = [soft(duration=share / rate, resolution=_RESOLUTION) for share in touching]
    gases = [
        _gas(t, Output(interval=t / _SAMPLES, observables=("collisional_virial", "kinetic_energy"))) for t in durations
    ]
    laboratory.demand(gases[0], methods[0])
    starts: dict[int, Scene] = {}

    def one(count: float, member: int) -> tuple[float, Run]:
        k = counts.index(int(count))
        if member not in starts:
            starts[member] = relaxed(laboratory, gases[0], f"state {member}", 8.0)
        scene = starts[member].changed(duration=durations[k], output=gases[k].output)
        run = laboratory.run(scene, methods[k])
        kinetic = float(run["kinetic_energy"].mean())
        return float(run["collisional_virial"][-1]) / (2 * kinetic * durations[k]), run

    known = reference.finite_compressibility(_PACKING, _NUMBER, 2).value
    found = averaged(counts, one, expected=(known - 1) / _SHARE)
    mean = _compressibility(found, touching[-1], _WHY_SOFT)
    figure = found.figure(
        _PRESSURE, f"soft, {_SOFT}", laboratory.claims[_SOFT], "collisions", lambda run: run.cost.steps, "steps"
    )
    return worst([found.exponent(), mean], f"{found.merit()}, omega t_c = {touching[-1]:.3g}", (figure,))


_WHY_SOFT = "; soft disks err by omega t_c"


def _judge_haff(laboratory: Laboratory, scheme: str) -> Judged:
    """Loss of ln T per collision of a disk, from gases of growing numbers of disks."""
    if scheme == _SOFT:
        return _judge_soft_haff(laboratory)
    method = Method(scheme=scheme)

    def one(number: float, member: int) -> tuple[float, Run]:
        n = int(number)
        ends = (n // 2 * _WARM, n // 2 * (_WARM + _MEASURED))
        output = Output(collisions=ends, observables=("kinetic_energy", "collisions"))
        run = laboratory.run(_cooling(laboratory, n, member, _FOR_EVER, output), method)
        energy = run["kinetic_energy"]
        return float(np.log(energy[1] / energy[2])) / _MEASURED, run

    found = averaged(_numbers(_RUNGS), one)
    figure = found.figure(_COOLING, scheme, laboratory.claims[scheme], "disks", _collisions, "collisions")
    return worst([found.exponent(), _loss(found, 0.0, "")], found.merit(), (figure,))


_COOLING = f"Haff's cooling of hard disks, restitution {_ALPHA:g}"


def _numbers(rungs: int) -> list[int]:
    """Disks in the gases of each rung."""
    return [_FEWEST * FACTOR**k for k in range(rungs)]


def _cooling(laboratory: Laboratory, number: int, member: int, duration: float, output: Output) -> Scene:
    """A dilute gas of disks that lose energy, from a lattice of its own velocities, T = 1."""
    return Scene(
        name="work-precision-haff",
        dimension=2,
        duration=duration,
        hard_spheres=HardSpheres(restitution=_ALPHA),
        box=Box(packing_fraction=_DILUTE),
        initial=Lattice(
            kind="lattice", structure=LATTICE[2], number=number, temperature=1.0,  # type: ignore[arg-type]
            seed=laboratory.seed(f"{number}/{member}"),
        ),
        output=output,
    )  # fmt: skip


def _per_collision() -> float:
    """The expected loss of ln T per collision of a disk."""
    return -float(np.log(granular.temperature_after(1.0, _ALPHA, 2, granular.best_cumulant(_ALPHA, 2).value)))


def _loss(found: Averages, softness: float, why: str) -> Judgement:
    """The judgement that the largest gases lose what hard disks do; softness, why: as in `_compressibility`."""
    a2, expected = granular.best_cumulant(_ALPHA, 2), _per_collision()
    _, few = finite_size(int(found.amounts[-1]), (1 - _ALPHA**2) / 2, _DILUTE, 2)
    loss, error = independent_mean(found.values[-1])
    return statistical(
        "loss of ln T per collision of a disk, of the largest gases",
        loss,
        error,
        expected,
        expected / 4 * a2.uncertainty,
        f"standard error of independent gases; off by a_2, fluctuations and vortices of order 1/N{why}",
        samples=found.values.shape[1],
        doubt=expected * (a2.doubt / 4 + few + softness),
    )


def _judge_soft_haff(laboratory: Laboratory) -> Judged:
    """The same of soft disks, whose collisions are the time that pairs touch over t_c."""
    numbers, expected = _numbers(_SOFT_RUNGS), _per_collision()
    rate = reference.collision_rate(_DILUTE, 2, 1.0).value
    touching = [_TOUCHING_COOLING * (numbers[0] / number) ** 0.5 for number in numbers]
    # dT/dt = -loss omega T^(3/2)
    warm, end = (2 / (expected * rate) * float(np.expm1(expected * s / 2)) for s in (_WARM, _WARM + _MEASURED))
    first = round(warm / end * _SAMPLES)
    output = Output(interval=end / _SAMPLES, observables=("kinetic_energy", "contact_time"))

    def one(number: float, member: int) -> tuple[float, Run]:
        n = int(number)
        t_c = touching[numbers.index(n)] / rate
        method = soft(duration=t_c, resolution=_RESOLUTION_COOLING)
        run = laboratory.run(_cooling(laboratory, n, member, end, output), method)
        energy, contacts = run["kinetic_energy"], run["contact_time"]
        collisions = 2 * float(contacts[-1] - contacts[first]) / (n * t_c)
        return float(np.log(energy[first] / energy[-1])) / collisions, run

    found = averaged(numbers, one, expected=expected)
    figure = found.figure(
        _COOLING, f"soft, {_SOFT}", laboratory.claims[_SOFT], "disks", lambda run: run.cost.steps, "steps"
    )
    merit = f"{found.merit()}, omega t_c = {touching[-1]:.3g} at the start"
    return worst([found.exponent(), _loss(found, touching[-1], _WHY_SOFT)], merit, (figure,))


def _either(observables: str, words: str = "") -> Needs:
    """What is asked of engines of either kind; observables, words: entries of `Needs`, separated by spaces."""
    return Needs(
        "hard_spheres",
        (EVENT_DRIVEN, "stepping"),
        words=frozenset(f"dimension=2 box.boundaries=periodic {words}".split()),
        observables=frozenset(observables.split()),
    )


_SOFT_VIRIAL = Fault(
    "virial-of-contacts-too-large",
    CONTACTS,
    "virial += distance * normal",
    "virial += 1.2 * distance * normal",
    "the virial of soft contacts is a fifth too large",
)
_SOFT_DASHPOT = Fault(
    "dashpot-nine-tenths",
    CONTACTS,
    "* scale * delta - _damping(law[DAMPING], law, model, mass, scale) * approach",
    "* scale * delta - 0.9 * _damping(law[DAMPING], law, model, mass, scale) * approach",
    "the normal dashpot is nine tenths of what the restitution asks for",
)
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
        faults=(("event_driven", _VIRIAL), (_SOFT, _SOFT_VIRIAL)),
        needs=_either("collisional_virial"),
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
        faults=(("event_driven", RESTITUTION_SQUARED), (_SOFT, _SOFT_DASHPOT)),
        needs=_either("kinetic_energy", "hard_spheres.restitution"),
        timing=True,
    ),
)
