"""An elastic gas of soft disks, taken to the hard limit: pressure, collision rate and wall pressure.

Literature: N. Mitarai and H. Nakanishi, Phys. Rev. E 67, 021301 (2003); S. Luding, Nonlinearity 22, R101 (2009).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, soft, variants_of
from crosscheck.checks.granular.gases import RESOLUTION, energies, relaxed
from crosscheck.checks.granular.soft_grains import LISTS, REFERENCE, soft_needs
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references.hard_spheres import Estimate, collision_rate, compressibility
from crosscheck.scene import Box, Floats, HardSpheres, Lattice, Observable, Output, Scene
from crosscheck.statistics import independent_mean
from crosscheck.verdict import Judged, Judgement, statistical, worst

#: Contact times, and the number of initial states.
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
    count = run["collisions"][-1] if "collisions" in run else run["contact_time"][-1] / duration
    return 2 * float(count / run["time"][-1]) / scene.number / math.sqrt(_thermal(run, scene.number))


def _wall_pressure(run: Run, scene: Scene, duration: float) -> float:
    """Force on the walls over their length and over n T."""
    lengths = scene.lengths()
    assert lengths is not None
    impulse = run["wall_impulse"][-1]
    force = sum(abs(float(impulse[face, face // 2])) for face in range(4)) / float(run["time"][-1])
    return force / (2 * lengths.sum()) / (scene.number / lengths.prod() * _thermal(run, scene.number))


class _Quantity(NamedTuple):
    """What is measured of a run, given its scene and t_c; walled: else periodic; theory: of infinite systems."""

    name: str
    measure: Callable[[Run, Scene, float], float]
    walled: bool = False
    theory: Callable[[float, int], Estimate] | None = None


QUANTITIES = {
    "pressure": _Quantity("compressibility factor", _compressibility, theory=compressibility),
    "collision-rate": _Quantity("collision rate over T^(1/2)", _rate, theory=collision_rate),
    "wall-pressure": _Quantity("wall pressure over n T", _wall_pressure, walled=True),
}


class _Limit(NamedTuple):
    """Values (durations,) of soft spheres with their errors, and the parabola through them, whose first is at 0.

    expected, error: of the event-driven gas. at_zero: error of the parabola's value at 0.
    """

    values: list[float]
    errors: list[float]
    parabola: Floats
    at_zero: float
    expected: float
    error: float


def _limit(found: Floats, hard: Floats) -> _Limit:
    """found: of soft spheres, (durations, states). hard: of hard spheres, (states,)."""
    means = [independent_mean(values) for values in found]
    values, errors = [mean for mean, _ in means], [error for _, error in means]
    t, u = np.array(DURATIONS), np.array(errors)
    powers = np.vander(t, 3, increasing=True)
    covariance = np.linalg.inv(powers.T / u**2 @ powers)
    parabola = covariance @ (powers.T / u**2 @ np.array(values))
    return _Limit(values, errors, parabola, float(covariance[0, 0] ** 0.5), *independent_mean(hard))


def _against_hard(name: str, limit: _Limit, needed: float, figures: tuple[Figure, ...] = ()) -> Judgement:
    return statistical(
        f"{name} of soft disks at t_c = 0",
        float(limit.parabola[0]),
        limit.at_zero,
        limit.expected,
        limit.error,
        f"standard error over {REPLICAS} states, of the parabola's value at 0 and of the event-driven gas",
        samples=REPLICAS,
        needed=needed,
        figures=figures,
    )


def _judge_limit(laboratory: Laboratory, quantity: _Quantity) -> Judged:
    """A quantity of soft spheres at several t_c, by a parabola to t_c = 0, against the event-driven one.

    So is the temperature, which the quantity is divided by.
    """
    measure, gas = quantity.measure, _elastic_gas(quantity.walled)
    laboratory.demand(gas, soft(duration=DURATIONS[0], resolution=2 * RESOLUTION))
    starts = [relaxed(laboratory, gas, f"state {i}", 5.0) for i in range(REPLICAS)]
    counted = Output(interval=gas.output.interval, observables=(*_MEASURED, "collisions"))

    def both(run: Run, scene: Scene, duration: float) -> tuple[float, float]:
        return measure(run, scene, duration), _thermal(run, scene.number)

    hard = []
    for start in starts:
        scene = start.changed(output=counted)
        hard.append(both(laboratory.run(scene, EVENT_DRIVEN, engine=REFERENCE), scene, math.nan))
    found = []
    for duration in DURATIONS:
        method = soft(duration=duration, resolution=2 * RESOLUTION)
        found.append([both(laboratory.run(start, method), start, duration) for start in starts])
    soft_values, hard_values = np.array(found), np.array(hard)
    limit, thermal = (_limit(soft_values[:, :, i], hard_values[:, i]) for i in (0, 1))
    smooth = np.linspace(0.0, DURATIONS[0], 41)
    figure = Figure(
        f"Hard limit of the {quantity.name}",
        "t_c",
        quantity.name,
        series=(
            Series(f"soft, {laboratory.engine}", list(DURATIONS), limit.values, limit.errors),
            Series(
                f"parabola, {laboratory.engine}",
                smooth.tolist(),
                np.polyval(limit.parabola[::-1], smooth).tolist(),
                theory=True,
            ),
            Series("event-driven", [0.0], [limit.expected], [limit.error]),
        ),
    )
    measured = zip(DURATIONS, limit.values, limit.errors, strict=True)
    note = ", ".join(f"t_c {a:g}: {b:.4f}({c:.4f})" for a, b, c in measured)
    if quantity.theory is not None:
        note += f"; theory of an infinite system {quantity.theory(_PACKING, 2).value:.5g}"
    judgements = [_against_hard(quantity.name, limit, 0.03, (figure,)), _against_hard("temperature", thermal, 0.02)]
    return worst(judgements, note)


_LATE = Fault(
    "late-contacts",
    LISTS,
    "reach2[found] = touch * touch",
    "reach2[found] = 0.96 * touch * touch",
    "grains push each other only once they overlap by two per cent, also when they are stiff",
)

CHECKS = (
    Check(
        name="granular/hard-limit",
        title="Elastic disks: pressure, collision rate and wall pressure of soft ones, taken to the hard limit",
        equation="Z = 1 + <sum r_ij.F_ij>/(2 N T); omega = 2 <contacts>/(N t_c); p = <force>/length",
        criterion="the parabola in t_c meets the event-driven value at t_c = 0, within standard errors",
        citation="Mitarai & Nakanishi, Phys. Rev. E 67, 021301 (2003)",
        judge=_judge_limit,
        variants=variants_of(QUANTITIES, "full"),
        needs=soft_needs("method.contact.duration", "kinetic_energy collisional_virial contact_time wall_impulse"),
        faults=(("pressure", _LATE),),
    ),
)
