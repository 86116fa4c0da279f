"""Second virial coefficient of square wells, from the pressure of a dilute gas; diameter, mass and depth are 1."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, variants_of
from crosscheck.checks.events.gases import event_driven
from crosscheck.checks.events.square_wells import OBSERVABLES, WORDS, constant_energy, fluid, temperatures
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import square_well as reference
from crosscheck.references.square_well import WIDTH
from crosscheck.scene import Output
from crosscheck.statistics import correlated_mean
from crosscheck.verdict import Judged, statistical, worst

#: Range in density: B_2 n is a few per cent, and what follows B_3 n^2 is far below.
DILUTE = {2: 0.02, 3: 0.01}
DILUTE_NUMBER = {2: 1024, 3: 864}
DILUTE_TIME, DILUTE_SAMPLES = {2: 12000.0, 3: 6000.0}, 200


class _Gas(NamedTuple):
    """A dilute gas of square wells; temperature: None for that at which B_2 is zero."""

    dimension: int
    temperature: float | None


_TEMPERATURES = {"T1.5": 1.5, "boyle": None, "T6": 6.0}
_GASES = {f"{d}d-{name}": _Gas(d, t) for d in (2, 3) for name, t in _TEMPERATURES.items()}


def _judge(laboratory: Laboratory, gas: _Gas) -> Judged:
    """(Z - 1)/n of a dilute gas, minus B_3 n: B_2."""
    dimension = gas.dimension
    target = reference.boyle_temperature(WIDTH, dimension) if gas.temperature is None else gas.temperature
    density, number = DILUTE[dimension], DILUTE_NUMBER[dimension]
    # particles that enter wells gain their depth as kinetic energy: the gas starts colder by that
    gain = -2 / dimension * reference.dilute_energy(density, target, WIDTH, dimension).value
    scene = fluid(dimension, number, density, target - gain, laboratory.seed())
    duration = DILUTE_TIME[dimension]
    interval = duration / DILUTE_SAMPLES
    scene = scene.changed(duration=duration, output=Output(interval=interval, observables=OBSERVABLES))
    run = laboratory.run(scene, EVENT_DRIVEN)
    # the start, on a lattice, is left out: two dozen free times
    kept = slice(DILUTE_SAMPLES // 20, None)
    t = temperatures(scene, run)[kept]
    temperature = float(t.mean())
    z = np.diff(run["collisional_virial"])[kept] / (dimension * number * temperature * interval)
    measured = correlated_mean(z)
    core = float(reference.second_virial(np.inf, WIDTH, dimension))
    b3 = reference.third_virial(temperature, WIDTH, dimension)
    # pairs of N particles: N - 1 partners; B_4 n^3 is not known: as large as the cube of the absolute part of B_2
    pairs = 1 - 1 / number
    higher = reference.absolute_virial(temperature, WIDTH, dimension) ** 3 * density**2
    b2 = (measured.value / density - b3 * density) / pairs
    error = measured.error / density / core
    expected = 1 - float(reference.second_virial(temperature, WIDTH, dimension)) / core
    shown = float(reference.second_virial(temperature, WIDTH, dimension))
    curve = np.geomspace(1.2, 8, 60)
    theory = reference.second_virial(curve, WIDTH, dimension)
    coefficient = statistical(
        "1 - B_2/b, the part of the well",
        1 - b2 / core,
        error,
        expected,
        0.0,
        "standard error of correlated data; off by the term B_4 n^3, and 1/N of the well's part",
        samples=measured,
        doubt=higher / core + abs(expected) / number,
        needed=0.12,
        note=f"T = {temperature:.4f}: B_2 = {b2:.4f} (exact {shown:.4f}), statistical error "
        f"{measured.error / density:.4f}; B_3 n = {b3 * density:.4f} taken off, B_4 n^2 at most {higher:.4f}",
        figures=(
            Figure(
                f"second virial coefficient, {dimension} dimensions", "T", "B_2", series=(
                    Series(f"measured, T = {target:.3g}", [temperature], [b2], [core * error]),
                    Series("closed form", curve.tolist(), theory.tolist(), theory=True),
                ),
            ),
        ),
    )  # fmt: skip
    return worst([constant_energy(scene, run), coefficient])


CHECKS = (
    Check(
        name="events/square-well-virial-coefficient",
        title="Square wells: second virial coefficient from the pressure of a dilute gas",
        equation="Z - 1 = sum r_ij.dp_ij/(d N T t) = B_2 n + B_3 n^2, B_2 = b (1 - (lambda^d - 1)(exp(1/T) - 1))",
        criterion="within the standard error of correlated data, B_4 n^3 and 1/N",
        citation="Barker & Henderson, Rev. Mod. Phys. 48, 587 (1976)",
        judge=_judge,
        variants=variants_of(_GASES, "full"),
        needs=event_driven(WORDS, " ".join(OBSERVABLES)),
        faults=(
            (
                "3d-boyle",
                Fault(
                    "virial-of-the-core-only",
                    "events/kernels/measure.py",
                    "        _add(tallies, VIRIAL, impulse * distance)\n",
                    "        _add(tallies, VIRIAL, 0.7 * impulse * distance)\n",
                    "30 % of the well's part of the virial is missing",
                ),
            ),
        ),
    ),
)
