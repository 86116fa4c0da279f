"""The hard-sphere limit: soft spheres that stiffen, beside the event-driven gas that they are to become.

Soft spheres touch for t_c, so they are late by some t_c at every collision, and hold part of the energy in their
contacts: what they measure differs from hard spheres by a power series in omega t_c, omega the collision rate of a
particle, without a constant term.

Literature: N. Mitarai and H. Nakanishi, Phys. Rev. E 67, 021301 (2003); S. Luding, Nonlinearity 22, R101 (2009).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Laboratory, fixed, legacy_check, soft
from crosscheck.checks.events.cooling import RESTITUTION_SQUARED
from crosscheck.convergence import ORDER_TOLERANCE, WHY_ORDER
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references.hard_spheres import collision_rate, compressibility
from crosscheck.scene import Box, Floats, HardSpheres, Lattice, Method, Observable, Output, Scene, explicit
from crosscheck.scene.overlaps import wrapped
from crosscheck.statistics import independent_mean
from crosscheck.verdict import Judged, bounded, order, statistical, worst

#: dt/t_c. A contact begins and ends anywhere between two steps, which changes its restitution by gamma dt at most, with
#: mean zero; what is left is of order (dt/t_c)^2: halving dt changes T at k = 1e7 by less than 1e-3.
RESOLUTION = 0.025


def relaxed(laboratory: Laboratory, scene: Scene, purpose: str, time: float) -> Scene:
    """The scene from an equilibrium state: elastic hard spheres have run from its lattice for a time."""
    assert isinstance(scene.initial, Lattice)
    lattice = scene.initial.model_copy(update={"seed": laboratory.seed(purpose)})
    before = scene.changed(initial=lattice, hard_spheres=HardSpheres(), duration=time, output=Output())
    run = laboratory.run(before, EVENT_DRIVEN, engine="refimpl")
    lengths, box = scene.lengths(), scene.box
    assert lengths is not None
    assert box is not None
    return scene.changed(
        initial=explicit(wrapped(run["final_positions"], scene.periods()), run["final_velocities"]),
        box=Box(lengths=tuple(lengths.tolist()), boundaries=box.boundaries),
    )


# -- cooling -----------------------------------------------------------------------------------------------------------

ALPHA = 0.8
#: Stiffnesses, in units of m T/sigma^2 at the start, and the number of initial states that each is run from.
STIFFNESSES = {1e3: 48, 1e4: 48, 1e5: 48, 1e6: 32, 1e7: 12}
#: By dimension: packing fraction and time, in which a particle collides about 3 times.
_GASES = {2: (0.5, 0.4), 3: (0.3, 0.5)}


def cooling_gas(dimension: int) -> Scene:
    """1000 smooth inelastic disks or spheres in a periodic box, T = 1 at the start."""
    fraction, time = _GASES[dimension]
    return Scene(
        name="cooling",
        dimension=2 if dimension == 2 else 3,
        duration=time,
        hard_spheres=HardSpheres(restitution=ALPHA),
        box=Box(packing_fraction=fraction),
        initial=Lattice(
            kind="lattice", structure="square" if dimension == 2 else "sc", number=1000, temperature=1.0, seed=0
        ),
        output=Output(interval=time / 8, observables=("kinetic_energy",)),
    )


def energies(run: Run) -> Floats:
    return run["kinetic_energy"]


def _judge_cooling(laboratory: Laboratory, variant: str) -> Judged:
    """T of soft over T of hard spheres, from the same states: power of the stiffness with which they converge."""
    gas = cooling_gas(2 if variant == "disks" else 3)
    starts = [relaxed(laboratory, gas, f"state {i}", 2.0) for i in range(max(STIFFNESSES.values()))]
    hard = [energies(laboratory.run(start, EVENT_DRIVEN, engine="refimpl")) for start in starts]
    times = np.linspace(0.0, gas.duration, len(hard[0]))
    curves = [_temperature_curve("event-driven", times, np.mean(hard, axis=0), gas)]
    soft_ends = []
    for stiffness, number in STIFFNESSES.items():
        method = soft(stiffness=stiffness, resolution=RESOLUTION)
        runs = [energies(laboratory.run(start, method)) for start in starts[:number]]
        curves.append(
            _temperature_curve(f"k = {stiffness:.0e}, {laboratory.engine}", times, np.mean(runs, axis=0), gas)
        )
        soft_ends.append(np.array(runs)[:, -1])
    temperatures = Figure(f"Cooling {variant}: T(t)", "t", "T", series=tuple(curves))
    return _convergence(
        f"T(k)/T of {variant}",
        laboratory.engine,
        "stiffness k sigma^2/(m T)",
        np.array(list(STIFFNESSES)),
        soft_ends,
        np.array(hard)[:, -1],
        0.5,
        f"t_c goes with k^(-1/2), and the first power of t_c leads: {WHY_ORDER}, of t_c",
        (temperatures,),
    )


def _temperature_curve(label: str, times: Floats, energy: Floats, gas: Scene) -> Series:
    temperature = 2 * energy / (gas.dimension * gas.number)
    return Series(label, times.tolist(), temperature.tolist(), theory=label == "event-driven")


def _convergence(
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

    found: for each x, the values of the first states; the first x is drawn, but beyond the first power.
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
    values_of = ", ".join(f"{a:g}: {b:.5f}({c:.5f})" for a, b, c in zip(x, d, u, strict=True))
    tolerance = ORDER_TOLERANCE * power
    return worst(
        [
            order(f"power of 1/x in {quantity} - 1", p, power, tolerance, why, uncertainty=u_p),
            bounded("standard error of that power", u_p, tolerance, "the power is known well enough to be judged"),
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
        f"{quantity} - 1 at x = {label}: {values_of}",
        (figure, *figures),
    )


def _power_law(k: Floats, d: Floats, u: Floats) -> tuple[float, float, float]:
    """p with its standard error, and a, in d = a k^(-p), weighted."""
    from scipy.optimize import curve_fit

    def law(log_k: Floats, log_a: float, p: float) -> Floats:
        return np.asarray(np.exp(log_a - p * log_k))

    # a guess from the softest, and a sign for all: a difference of either sign is one of its own
    sign = math.copysign(1.0, d[0])
    guess = (math.log(abs(d[0])) + 0.5 * math.log(k[0]), 0.5)
    (log_a, p), covariance = curve_fit(law, np.log(k), sign * d, guess, u, absolute_sigma=True)
    return float(p), float(covariance[1, 1] ** 0.5), sign * math.exp(log_a)


# -- pressure and collision rate of an elastic gas ---------------------------------------------------------------------

DURATIONS = (0.08, 0.04, 0.02, 0.01)
REPLICAS = 24
_PACKING = 0.4
_MEASURED: tuple[Observable, ...] = ("kinetic_energy", "collisional_virial", "contact_time", "wall_impulse")


def _elastic_gas(walled: bool) -> Scene:
    """400 elastic disks, T = 1."""
    return Scene(
        name="elastic-gas",
        dimension=2,
        duration=20.0,
        hard_spheres=HardSpheres(),
        box=Box(packing_fraction=_PACKING, boundaries=("hard", "hard") if walled else None),
        initial=Lattice(kind="lattice", structure="square", number=400, temperature=1.0, seed=0),
        output=Output(interval=1.0, observables=_MEASURED),
    )


def _thermal(run: Run, number: int) -> float:
    """<K>/N = T of disks."""
    return float(np.trapezoid(energies(run), run["time"])) / float(run["time"][-1]) / number


def _compressibility(run: Run, scene: Scene, duration: float) -> float:
    """Z = 1 + W/(2 N T) of disks."""
    virial = run["collisional_virial"][-1] / run["time"][-1]
    return 1 + float(virial) / (2 * scene.number * _thermal(run, scene.number))


def _rate(run: Run, scene: Scene, duration: float) -> float:
    """Collisions of a particle, over T^(1/2); of soft spheres the time that pairs touch, over t_c."""
    tallies = run
    count = tallies["collisions"][-1] if "collisions" in tallies else tallies["contact_time"][-1] / duration
    return 2 * float(count / run["time"][-1]) / scene.number / math.sqrt(_thermal(run, scene.number))


def _wall_pressure(run: Run, scene: Scene, duration: float) -> float:
    """Force on the walls over their length and over n T."""
    lengths = scene.lengths()
    assert lengths is not None
    impulse = run["wall_impulse"][-1]
    force = sum(abs(float(impulse[face, face // 2])) for face in range(4)) / float(run["time"][-1])
    return force / (2 * lengths.sum()) / (scene.number / lengths.prod() * _thermal(run, scene.number))


def _judge_limit(laboratory: Laboratory, variant: str) -> Judged:
    """A quantity of soft spheres at several t_c, by a parabola to t_c = 0, against the event-driven one."""
    measure: Callable[[Run, Scene, float], float] = _QUANTITIES[variant]
    gas = _elastic_gas(variant == "wall-pressure")
    starts = [relaxed(laboratory, gas, f"state {i}", 5.0) for i in range(REPLICAS)]
    counted = Output(interval=gas.output.interval, observables=(*_MEASURED, "collisions"))
    hard = []
    for start in starts:
        scene = start.changed(output=counted)
        hard.append(measure(laboratory.run(scene, EVENT_DRIVEN, engine="refimpl"), scene, math.nan))
    values, errors = [], []
    for duration in DURATIONS:
        method = soft(duration=duration, resolution=2 * RESOLUTION)
        found = [measure(laboratory.run(start, method), start, duration) for start in starts]
        mean, error = independent_mean(found)
        values.append(mean)
        errors.append(error)
    expected, u_expected = independent_mean(hard)
    t, y, u = np.array(DURATIONS), np.array(values), np.array(errors)
    parabola, covariance = np.polyfit(t, y, 2, w=1 / u, cov="unscaled")
    limit, u_limit = float(parabola[2]), float(covariance[2, 2] ** 0.5)
    smooth = np.linspace(0.0, DURATIONS[0], 41)
    figure = Figure(
        f"Hard limit of the {_NAMES[variant]}",
        "t_c",
        _NAMES[variant],
        series=(
            Series(f"soft, {laboratory.engine}", list(DURATIONS), values, errors),
            Series(
                f"parabola, {laboratory.engine}",
                smooth.tolist(),
                np.polyval(parabola, smooth).tolist(),
                theory=True,
            ),
            Series("event-driven", [0.0], [expected], [u_expected]),
        ),
    )
    theory = _theory(variant)
    more = f"; theory {theory:.5g}" if theory is not None else ""
    note = ", ".join(f"t_c {a:g}: {b:.4f}({c:.4f})" for a, b, c in zip(t, y, u, strict=True))
    return statistical(
        f"{_NAMES[variant]} of soft disks at t_c = 0",
        limit,
        u_limit,
        expected,
        u_expected,
        f"standard error over {REPLICAS} states, of the parabola's value at 0 and of the event-driven gas",
        samples=REPLICAS,
        needed=0.03,
        note=f"event-driven {expected:.5g}({u_expected:.2g}){more}; {note}",
        figures=(figure,),
    )


_QUANTITIES: dict[str, Any] = {"pressure": _compressibility, "collision-rate": _rate, "wall-pressure": _wall_pressure}
_NAMES = {
    "pressure": "compressibility factor",
    "collision-rate": "collision rate over T^(1/2)",
    "wall-pressure": "wall pressure over n T",
}


def _theory(variant: str) -> float | None:
    """Of the infinite system."""
    if variant == "pressure":
        return compressibility(_PACKING, 2).value
    if variant == "collision-rate":
        return collision_rate(_PACKING, 2).value
    return None


# -- hard spheres by time steps ----------------------------------------------------------------------------------------

#: Steps of REBOUND's search for collisions, and the states that each is run from.
STEPS = (0.2, 0.1, 0.05, 0.025, 0.0125)
_SEARCHES = 64


def _judge_search(laboratory: Laboratory, variant: str) -> Judged:
    """REBOUND, whose collisions are up to a step late, against the event-driven gas: whichever of them is judged."""
    elastic = variant == "collision-rate"
    gas = Scene(
        name="search",
        dimension=2,
        duration=2.0,
        hard_spheres=HardSpheres(restitution=1.0 if elastic else ALPHA),
        box=Box(packing_fraction=0.3),
        initial=Lattice(kind="lattice", structure="square", number=400, temperature=1.0, seed=0),
        output=Output(interval=2.0, observables=("kinetic_energy", "collisions")),
    )

    def measured(run: Run) -> float:
        return float(run["collisions"][-1] if elastic else energies(run)[-1])

    starts = [relaxed(laboratory, gas, f"state {i}", 5.0) for i in range(_SEARCHES)]
    hard = [measured(laboratory.run(start, EVENT_DRIVEN, engine="refimpl")) for start in starts]
    found = []
    for dt in STEPS:
        method = Method(scheme="collisions_tree", dt=dt)
        found.append(np.array([measured(laboratory.run(start, method, engine="rebound")) for start in starts]))
    return _convergence(
        "number of collisions over event-driven" if elastic else "T over event-driven",
        "rebound",
        "1/dt",
        1 / np.array(STEPS),
        found,
        np.array(hard),
        1.0,
        f"collisions are late by dt/2 in the mean: {WHY_ORDER}",
    )


_LATE = Fault(
    "late-contacts",
    "stepping/kernels/contacts.py",
    "reach2[found] = touch * touch",
    "reach2[found] = 0.96 * touch * touch",
    "grains push each other only once they overlap by two per cent, also when they are stiff",
)

CHECKS = (
    legacy_check(
        name="granular/cooling",
        title="Inelastic gas: temperature of soft spheres of growing stiffness, beside the event-driven one",
        equation="T(k)/T - 1 = a k^(-1/2), k in m T/sigma^2",
        criterion="the fitted power of 1/k is 1/2 (of t_c: 1) within half a quarter; the stiffest agrees within errors",
        citation="Mitarai & Nakanishi, Phys. Rev. E 67, 021301 (2003); Luding, Nonlinearity 22, R101 (2009)",
        judge=_judge_cooling,
        variants=fixed("disks", "spheres"),
        faults=(
            (
                "disks",
                Fault(
                    "damping-of-the-mass",
                    "stepping/kernels/contacts.py",
                    "return coefficient * np.sqrt(mass * law[STIFFNESS] * scale)",
                    "return 0.98 * coefficient * np.sqrt(mass * law[STIFFNESS] * scale)",
                    "the dashpot is 2 % too weak: the restitution is 0.8036 instead of 0.8",
                ),
            ),
        ),
        engines=("refimpl", "lammps"),
        tier="full",
    ),
    legacy_check(
        name="granular/hard-limit",
        title="Elastic disks: pressure, collision rate and wall pressure of soft ones, taken to the hard limit",
        equation="Z = 1 + <sum r_ij.F_ij>/(2 N T); omega = 2 <contacts>/(N t_c); p = <force>/length",
        criterion="the parabola in t_c meets the event-driven value at t_c = 0, within standard errors",
        citation="Mitarai & Nakanishi, Phys. Rev. E 67, 021301 (2003)",
        judge=_judge_limit,
        variants=fixed(*_QUANTITIES),
        faults=(("pressure", _LATE),),
        engines=("refimpl", "lammps"),
        tier="full",
    ),
    legacy_check(
        name="granular/collision-search",
        title="Hard disks in REBOUND, which looks for collisions after each step, beside event-driven ones",
        equation="nu(dt)/nu - 1, T(dt)/T - 1 ~ dt",
        criterion="the fitted power of dt is 1 within a quarter; the smallest step agrees within errors",
        citation="Rein & Liu, Astron. Astrophys. 537, A128 (2012)",
        judge=_judge_search,
        variants=fixed("collision-rate", "cooling"),
        faults=(("cooling", RESTITUTION_SQUARED),),
        engines=("refimpl", "rebound"),
        tier="full",
    ),
)
