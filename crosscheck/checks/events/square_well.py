"""The square-well fluid: its energy, single pairs, the second virial coefficient, and liquid states.

Units: diameter, mass and depth of the well are 1.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Laboratory, fixed, legacy_check
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.references import square_well as reference
from crosscheck.scene import Box, Floats, HardSpheres, Lattice, Observable, Output, Scene, Well, explicit
from crosscheck.scene.overlaps import wrapped
from crosscheck.statistics import Mean, correlated_mean
from crosscheck.verdict import Judged, round_off, statistical, worst

WIDTH = reference.WIDTH
OBSERVABLES: tuple[Observable, ...] = (
    "kinetic_energy",
    "potential_energy",
    "events",
    "collisional_virial",
    "kinetic_energy_integral",
    "potential_energy_integral",
)


def fluid(dimension: int, number: int, density: float, temperature: float, seed: int, depth: float = 1.0) -> Scene:
    """A periodic cube (square) of particles that start on a lattice."""
    structure = "square" if dimension == 2 else "fcc"
    return Scene(
        name=f"square-well-{dimension}d-{number}",
        dimension=dimension,  # type: ignore[arg-type]
        duration=0.0,
        hard_spheres=HardSpheres(well=Well(depth=depth, range=WIDTH)),
        box=Box(density=density),
        initial=Lattice(kind="lattice", structure=structure, number=number, temperature=temperature, seed=seed),  # type: ignore[arg-type]
        output=Output(interval=1.0, observables=OBSERVABLES),
    )


def _pairs_inside(positions: Floats, length: float) -> int:
    """Pairs closer than the range of the well, nearest images; positions (N, d)."""
    from scipy.spatial import cKDTree

    lengths = np.full(positions.shape[1], length)
    tree = cKDTree(wrapped(positions, lengths), boxsize=lengths)
    return len(tree.query_pairs(WIDTH, output_type="ndarray"))


# -- energy ------------------------------------------------------------------------------------------------------------

#: dimension, particles, density, temperature at the start, depth.
ENERGIES = {"2d": (2, 196, 0.4, 1.0, 1.0), "3d": (3, 256, 0.5, 1.0, 1.0), "3d-shoulder": (3, 256, 0.3, 1.0, -1.0)}
ENERGY_SAMPLES, ENERGY_INTERVAL = 40, 2.5


def _judge_energy(laboratory: Laboratory, variant: str) -> Judged:
    """Total energy at every sample, and the wells' against the pairs counted in the recorded positions."""
    dimension, number, density, temperature, depth = ENERGIES[variant]
    scene = fluid(dimension, number, density, temperature, laboratory.seed(), depth)
    scene = scene.changed(
        duration=ENERGY_SAMPLES * ENERGY_INTERVAL,
        output=Output(interval=ENERGY_INTERVAL, observables=OBSERVABLES, trajectory=True),
    )
    run = laboratory.run(scene, EVENT_DRIVEN)
    kinetic, potential = _energies(run)
    lengths = scene.lengths()
    assert lengths is not None
    counted = np.array([_pairs_inside(frame, float(lengths[0])) for frame in run["positions"]])
    total = kinetic + potential
    events = float(run["events"][-1])
    change = abs(total - total[0]).max()
    # a pair that meets has a few times the mean kinetic energy, hence 4 of its roundings per event and partner
    unit = EPSILON * (kinetic.max() / number + abs(depth))
    energy = round_off(
        f"largest change of the energy in {events:.3g} events",
        float(change),
        8 * events * unit,
        "four roundings of the mean energy per event and partner",
        figures=(
            Figure(
                "energy a particle", "t", "energy", series=(
                    Series(f"{variant}: kinetic", run["time"].tolist(), (kinetic / number).tolist()),
                    Series(f"{variant}: wells", run["time"].tolist(), (potential / number).tolist()),
                    Series(f"{variant}: sum", run["time"].tolist(), (total / number).tolist(), theory=True),
                ),
            ),
        ),
    )  # fmt: skip
    wells = round_off(
        "largest difference between the wells' energy and -depth x pairs inside",
        float(abs(potential + depth * counted).max()),
        0.5 * abs(depth),
        "a whole number of pairs: none may be missing",
    )
    return worst([energy, wells], f"{counted.min()} to {counted.max()} pairs inside")


def _energies(run: Run) -> tuple[Floats, Floats]:
    return run["kinetic_energy"], run["potential_energy"]


# -- one pair ----------------------------------------------------------------------------------------------------------


class Pair(NamedTuple):
    """Relative position and velocity of two particles of mass 1, and the events that they went through."""

    position: Floats
    velocity: Floats
    entered: int = 0
    left: int = 0
    reflected: int = 0
    hits: int = 0


def pair_path(position: Floats, velocity: Floats, duration: float, depth: float = 1.0) -> Pair:
    """Relative motion of one pair for `duration`: free flight, elastic core at 1, edge at `WIDTH` by the reference."""
    r, v, left_over = np.array(position, dtype=np.float64), np.array(velocity, dtype=np.float64), duration
    inside = bool(r @ r < WIDTH**2)
    counts = {"entered": 0, "left": 0, "reflected": 0, "hits": 0}
    while True:
        b, w = float(r @ v), float(v @ v)
        to_core = _first_contact(b, w, float(r @ r) - 1.0)
        to_edge = (
            _last_contact(b, w, float(r @ r) - WIDTH**2) if inside else _first_contact(b, w, float(r @ r) - WIDTH**2)
        )
        span = min(to_core, to_edge) if inside else to_edge
        if span > left_over:
            return Pair(r + v * left_over, v, **counts)
        r, left_over = r + v * span, left_over - span
        n = r / np.sqrt(r @ r)
        u = float(v @ n)
        if inside and to_core < to_edge:
            after = -u
            counts["hits"] += 1
        elif inside:
            crossing = reference.leaving(u, depth)
            after, inside = crossing
            counts["reflected" if inside else "left"] += 1
        else:
            after, inside = reference.entering(u, depth)
            counts["entered"] += 1
        v = v + (after - u) * n


def _first_contact(b: float, w: float, c: float) -> float:
    """Smaller root of w t^2 + 2 b t + c = 0 for an approach from outside."""
    square = b * b - w * c
    return max(c / (np.sqrt(square) - b), 0.0) if b < 0 and square > 0 else np.inf


def _last_contact(b: float, w: float, c: float) -> float:
    """The positive root from inside, c <= 0."""
    root = np.sqrt(b * b - w * min(c, 0.0))
    if b > 0:
        return max(-min(c, 0.0) / (b + root), 0.0)
    return float((root - b) / w) if w > 0 else np.inf


PAIRS, PAIR_SPACING, PAIR_TIME = 64, 24.0, 5.0


def pair_starts(dimension: int, seed: int) -> tuple[Floats, Floats]:
    """Relative positions and velocities, (pairs, d): a third outside and approaching, the others in the well.

    Those inside have a binding energy or an excess of up to the depth: half of them can never leave.
    """
    rng = np.random.default_rng(seed)
    n = rng.normal(size=(PAIRS, dimension))
    n /= np.linalg.norm(n, axis=1)[:, None]
    side = rng.normal(size=(PAIRS, dimension))
    side -= (side * n).sum(1)[:, None] * n
    side /= np.linalg.norm(side, axis=1)[:, None]
    outside = np.arange(PAIRS) < PAIRS // 3
    distance = np.where(outside, 2.5, rng.uniform(1.05, 1.45, PAIRS))
    impact = np.where(outside, rng.uniform(0, 1.45, PAIRS), rng.uniform(0, 0.9, PAIRS) * distance)
    speed = np.where(outside, rng.uniform(0.5, 2.5, PAIRS), 2 * np.sqrt(rng.uniform(0.1, 1.9, PAIRS)))
    along = -np.sqrt(1 - (impact / distance) ** 2)
    velocity = speed[:, None] * (along[:, None] * n + (impact / distance)[:, None] * side)
    return distance[:, None] * n, velocity


def _judge_pairs(laboratory: Laboratory, variant: str) -> Judged:
    """Pairs too far apart to meet others, each against its own path from event to event."""
    dimension = int(variant[0])
    relative, velocity = pair_starts(dimension, laboratory.seed())
    side = int(np.ceil(PAIRS ** (1 / dimension)))
    places = np.stack(np.meshgrid(*[np.arange(side)] * dimension), -1).reshape(-1, dimension)[:PAIRS] + 0.5
    centres = np.repeat(PAIR_SPACING * places, 2, axis=0)
    signs = np.tile([0.5, -0.5], PAIRS)[:, None]
    length = side * PAIR_SPACING
    scene = fluid(dimension, 2, 0.01, 0.0, 0).changed(
        duration=PAIR_TIME,
        box=Box(lengths=(length,) * dimension),
        initial=explicit(centres + signs * np.repeat(relative, 2, 0), signs * np.repeat(velocity, 2, 0)),
        output=Output(interval=0.05, observables=OBSERVABLES, trajectory=True),
    )
    run = laboratory.run(scene, EVENT_DRIVEN)
    positions, velocities = run["final_positions"], run["final_velocities"]
    found = np.hstack([positions[::2] - positions[1::2], velocities[::2] - velocities[1::2]])
    expected, growth, seen = np.empty_like(found), np.empty(PAIRS), np.zeros(4, np.int64)
    shift = 1e-8
    for k in range(PAIRS):
        path = pair_path(relative[k], velocity[k], PAIR_TIME)
        expected[k] = np.concatenate(path[:2])
        seen += path[2:]
        twins = [
            np.concatenate(pair_path(relative[k] + dr, velocity[k] + dv, PAIR_TIME)[:2])
            for dr, dv in _disturbances(dimension, shift)
        ]
        growth[k] = max(1.0, max(abs(twin - expected[k]).max() for twin in twins) / shift)
    # a position is rounded to the box's last digit at every event; the path multiplies that by `growth`
    errors = abs(found - expected).max(axis=1)
    tolerance = 4 * EPSILON * length * growth * (1 + seen.sum() / PAIRS)
    path_error = round_off(
        "largest error of a pair's final place and velocity, in its own rounding",
        float((errors / tolerance).max()),
        1.0,
        "4 roundings of the box's length per event, times the growth of a disturbance of 1e-8 along the pair's path",
        note=f"largest error {errors.max():.1e}, growth of a disturbance {np.median(growth):.1f} (median)",
    )
    binding = 0.25 * (velocity**2).sum(axis=1) - 1.0
    bound = (np.linalg.norm(relative, axis=1) < WIDTH) & (binding < 0)
    separation = np.linalg.norm(run["positions"][:, ::2] - run["positions"][:, 1::2], axis=2)[:, bound]
    captive = round_off(
        "how far pairs without the energy to part got beyond the edge",
        max(float(separation.max()) - WIDTH, 0.0),
        4 * EPSILON * length,
        "rounding of a position in the box",
    )
    names = ("captures", "escapes", "reflections inside", "core hits")
    counted = ", ".join(f"{number} {name}" for name, number in zip(names, seen, strict=True))
    return worst([path_error, captive], f"{PAIRS} pairs, {bound.sum()} of them bound for ever; {counted}")


def _disturbances(dimension: int, shift: float) -> list[tuple[Floats, Floats]]:
    zero = np.zeros(dimension)
    steps = shift * np.eye(dimension)
    return [(step, zero) for step in steps] + [(zero, step) for step in steps]


# -- second virial coefficient -----------------------------------------------------------------------------------------

#: Range in density: B_2 n is a few per cent, and what follows B_3 n^2 is far below.
DILUTE = {2: 0.02, 3: 0.01}
DILUTE_NUMBER = {2: 1024, 3: 864}
DILUTE_TIME, DILUTE_SAMPLES = {2: 8000.0, 3: 6000.0}, 200
BOYLE = "boyle"
TEMPERATURES = ("T1.5", BOYLE, "T6")


def third_virial(temperature: float, width: float, dimension: int) -> float:
    """B_3 = -(1/3) integral of f(r_12) f(r_13) f(r_23), f = exp(1/T) - 1 in the well and -1 in the core.

    f = g Theta(lambda) - (1 + g) Theta(1) is a sum of balls, whose convolutions are overlaps of two balls: one integral
    over r_12 remains. Barker and Henderson, Rev. Mod. Phys. 48, 587 (1976).
    """
    from scipy.integrate import quad

    g = float(np.expm1(1 / temperature))
    balls = ((g, width), (-(1 + g), 1.0))
    surface = 2 * np.pi if dimension == 2 else 4 * np.pi

    def integrand(r: float) -> float:
        mayer = -1.0 if r < 1 else g
        chain = sum(a * b * _overlap(r, p, q, dimension) for a, p in balls for b, q in balls)
        return surface * r ** (dimension - 1) * mayer * chain

    inner, _ = quad(integrand, 0, 1, epsabs=1e-11, epsrel=1e-10, points=[width - 1])
    outer, _ = quad(integrand, 1, width, epsabs=1e-11, epsrel=1e-10)
    return float(-(inner + outer) / 3)


def _overlap(r: float, p: float, q: float, dimension: int) -> float:
    """Volume (area) common to two balls (disks) of radii p and q whose centres are r apart."""
    if r >= p + q:
        return 0.0
    if r <= abs(p - q):
        least = min(p, q)
        return np.pi * least**2 if dimension == 2 else 4 / 3 * np.pi * least**3
    if dimension == 3:
        return float(np.pi * (p + q - r) ** 2 * (r * r + 2 * r * (p + q) - 3 * (p - q) ** 2) / (12 * r))
    one = np.arccos((r * r + p * p - q * q) / (2 * r * p))
    two = np.arccos((r * r + q * q - p * p) / (2 * r * q))
    return float(p * p * (one - np.sin(2 * one) / 2) + q * q * (two - np.sin(2 * two) / 2))


def _judge_virial(laboratory: Laboratory, variant: str) -> Judged:
    """(Z - 1)/n of a dilute gas, minus B_3 n: B_2."""
    dimension, name = int(variant[0]), variant.split("-")[1]
    target = reference.boyle_temperature(WIDTH, dimension) if name == BOYLE else float(name[1:])
    density, number = DILUTE[dimension], DILUTE_NUMBER[dimension]
    # pairs that form give up their depth: the gas starts colder by that
    gain = -2 / dimension * reference.dilute_energy(density, target, WIDTH, dimension).value
    scene = fluid(dimension, number, density, target - gain, laboratory.seed())
    duration = DILUTE_TIME[dimension]
    interval = duration / DILUTE_SAMPLES
    scene = scene.changed(duration=duration, output=Output(interval=interval, observables=OBSERVABLES))
    run = laboratory.run(scene, EVENT_DRIVEN)
    # the start, on a lattice, is left out: two dozen free times
    kept = slice(DILUTE_SAMPLES // 20, None)
    t = _temperatures(scene, run)[kept]
    temperature = float(t.mean())
    z = np.diff(run["collisional_virial"])[kept] / (dimension * number * temperature * interval)
    measured = correlated_mean(z)
    core = float(reference.second_virial(np.inf, WIDTH, dimension))
    b3 = third_virial(temperature, WIDTH, dimension)
    # pairs of N particles: N - 1 partners; B_4 n^3 is not known: as large as the cube of the absolute part of B_2
    pairs = 1 - 1 / number
    size = core * (1 + (WIDTH**dimension - 1) * float(np.expm1(1 / temperature)))
    higher = size**3 * density**2
    b2 = (measured.value / density - b3 * density) / pairs
    doubt = float(np.hypot(measured.error / density, higher)) / core
    expected = 1 - float(reference.second_virial(temperature, WIDTH, dimension)) / core
    shown = float(reference.second_virial(temperature, WIDTH, dimension))
    curve = np.geomspace(1.2, 8, 60)
    theory = reference.second_virial(curve, WIDTH, dimension)
    return statistical(
        "1 - B_2/b, the part of the well",
        1 - b2 / core,
        doubt,
        expected,
        abs(expected) / number,
        "standard error of correlated data, the term B_4 n^3, and 1/N of the well's part",
        samples=measured.independent,
        needed=0.1,
        note=f"T = {temperature:.4f}: B_2 = {b2:.4f} (exact {shown:.4f}), statistical error "
        f"{measured.error / density:.4f}; B_3 n = {b3 * density:.4f} taken off, B_4 n^2 at most {higher:.4f}",
        figures=(
            Figure(
                f"second virial coefficient, {dimension} dimensions", "T", "B_2", series=(
                    Series(f"measured {name}", [temperature], [b2], [core * doubt]),
                    Series("closed form", curve.tolist(), theory.tolist(), theory=True),
                ),
            ),
        ),
    )  # fmt: skip


def _temperatures(scene: Scene, run: Run) -> Floats:
    """Averages over each interval of 2 K/(d (N - 1)), total momentum zero."""
    freedoms = scene.dimension * (scene.number - 1)
    return np.asarray(2 * np.diff(run["kinetic_energy_integral"]) / (freedoms * np.diff(run["time"])))


# -- liquid states -----------------------------------------------------------------------------------------------------

#: Index into `reference.STATES`, number of particles.
LIQUIDS = {
    "n0.1-T2.0": (0, 256),
    "n0.3-T1.5": (1, 256),
    "n0.5-T2.0": (3, 256),
    "n0.7-T1.5": (2, 256),
    "n0.7-T1.5-N864": (2, 864),
}
#: Duration of a production run of 256 particles; of more, shorter in proportion.
LIQUID_TIME, LIQUID_SAMPLES = 200.0, 200
#: The two production runs are this much above and below the temperature asked for.
BRACKET = 0.04


def _rescaled(laboratory: Laboratory, scene: Scene, temperature: float, rounds: int, span: float) -> Scene:
    """Runs of `span`, after each of which the velocities are scaled to the temperature."""
    for _ in range(rounds):
        run = laboratory.run(
            scene.changed(duration=span, output=Output(interval=span, observables=OBSERVABLES)), EVENT_DRIVEN
        )
        kinetic = 0.5 * float((run["final_velocities"] ** 2).sum())
        factor = np.sqrt(1.5 * (scene.number - 1) * temperature / kinetic)
        scene = scene.changed(initial=explicit(run["final_positions"], factor * run["final_velocities"]))
    return scene


class _Production(NamedTuple):
    """Averages over intervals: temperature, energy of the wells a particle, Z with the ideal part 1."""

    temperature: Floats
    energy: Floats
    compressibility: Floats


def _produced(laboratory: Laboratory, scene: Scene, duration: float) -> _Production:
    interval = duration / LIQUID_SAMPLES
    scene = scene.changed(duration=duration, output=Output(interval=interval, observables=OBSERVABLES))
    run = laboratory.run(scene, EVENT_DRIVEN)
    t = _temperatures(scene, run)
    energy = np.diff(run["potential_energy_integral"]) / (interval * scene.number)
    # with the mean temperature: the virial of an interval is not divided by what fluctuates with it
    z = 1 + np.diff(run["collisional_virial"]) / (3 * scene.number * t.mean() * interval)
    return _Production(t, energy, z)


def _judge_liquid(laboratory: Laboratory, variant: str) -> Judged:
    """Two runs at constant energy about the temperature; energy and Z on the line through them, at that temperature."""
    index, number = LIQUIDS[variant]
    point = reference.STATES[index]
    scene = fluid(3, number, point.density, 1.5 * point.temperature, laboratory.seed())
    scene = _rescaled(laboratory, scene, point.temperature, 10, 4.0)
    duration = LIQUID_TIME * 256 / number
    runs = [
        _produced(laboratory, _rescaled(laboratory, scene, factor * point.temperature, 6, 4.0), duration)
        for factor in (1 - BRACKET, 1 + BRACKET)
    ]
    energy, slope = _at(runs, point.temperature, "energy")
    z, _ = _at(runs, point.temperature, "compressibility")
    t, capacity = point.temperature, 1.5 + slope
    # <T> at constant E is not the canonical T: u(T) differs by -T^2 c'/(2 N c), c' of the size 2 u'/T
    ensemble = 1 / 256 * t * abs(slope) / capacity
    means = [[float(series.mean()) for series in run] for run in runs]
    judgements = [
        statistical(
            f"u at T = {t:g}",
            energy.value,
            energy.error,
            point.energy.value,
            float(np.hypot(point.energy.uncertainty, ensemble)),
            "standard errors of correlated data, and 1/N between constant energy and constant temperature",
            samples=energy.independent,
            needed=0.04,
        ),
        statistical(
            f"Z at T = {t:g}",
            z.value,
            z.error,
            point.compressibility.value,
            point.compressibility.uncertainty,
            "standard error of correlated data, and 1 % of g at contact and at the edge behind the reference",
            samples=z.independent,
            needed=0.2,
        ),
    ]
    found = "; ".join(f"T = {one[0]:.4f}, u = {one[1]:.4f}, Z = {one[2]:.4f}" for one in means)
    return worst(judgements, f"N = {number}, du/dT = {slope:.2f}: {found}")


def _at(runs: list[_Production], temperature: float, name: str) -> tuple[Mean, float]:
    """A quantity at the temperature, from both runs, each moved along the line through them; and its slope.

    At constant energy a quantity and the temperature fluctuate together: the series that is averaged has both.
    """
    values = [np.asarray(getattr(run, name)) for run in runs]
    t = [float(run.temperature.mean()) for run in runs]
    slope = float((values[1].mean() - values[0].mean()) / (t[1] - t[0]))
    moved = [correlated_mean(y - slope * (run.temperature - temperature)) for y, run in zip(values, runs, strict=True)]
    weights = np.array([t[1] - temperature, temperature - t[0]]) / (t[1] - t[0])
    value = sum(w * one.value for w, one in zip(weights, moved, strict=True))
    error = float(np.hypot(*(w * one.error for w, one in zip(weights, moved, strict=True))))
    return Mean(float(value), error, min(one.independent for one in moved)), slope


_ALDER = "Alder & Wainwright, J. Chem. Phys. 31, 459 (1959)"
_HENDERSON = "Barker & Henderson, Rev. Mod. Phys. 48, 587 (1976)"

CHECKS = (
    legacy_check(
        name="events/square-well-energy",
        title="Square wells: the energy over many events, and the pairs inside",
        equation="K + U = const, U = -depth x number of pairs closer than 1.5",
        criterion="change <= 8 events x rounding of the mean energy; U exact, pairs counted in the positions",
        citation=_ALDER,
        judge=_judge_energy,
        variants=fixed(*ENERGIES),
        faults=(
            (
                "3d",
                Fault(
                    "bond-kept",
                    "events/rules.py",
                    "            bonds[i, 0] -= 1\n            return",
                    "            bonds[i, 0] -= i % 50 != 7\n            return",
                    "some particles keep the bond with a partner that has left the well",
                ),
            ),
            (
                "3d-shoulder",
                Fault(
                    "edge-gains-energy",
                    "events/rules.py",
                    "return math.copysign(math.sqrt(square), gn), not inside",
                    "return math.copysign(math.sqrt(square), gn) * 1.0000001, not inside",
                    "a pair that passes the edge of its well gains 1e-7 of its speed",
                ),
            ),
        ),
        tier="full",
    ),
    legacy_check(
        name="events/square-well-pairs",
        title="Single pairs in a square well: capture, escape, reflection inside, core",
        equation="u'^2 = u^2 + 4 epsilon/m inwards, u^2 - 4 epsilon/m outwards, u' = -u where that is negative",
        criterion="final place and velocity to the rounding of the path; pairs without the energy to part never do",
        citation=_ALDER,
        judge=_judge_pairs,
        variants=fixed("2d", "3d"),
        faults=(
            (
                "3d",
                Fault(
                    "no-reflection",
                    "events/rules.py",
                    "    if square < 0.0:\n        return -gn, inside",
                    "    if square < -0.5:\n        return -gn, inside\n    square = abs(square)",
                    "pairs that miss a little energy leave their well",
                ),
            ),
        ),
        tier="full",
    ),
    legacy_check(
        name="events/square-well-virial-coefficient",
        title="Square wells: second virial coefficient from the pressure of a dilute gas",
        equation="Z - 1 = sum r_ij.dp_ij/(d N T t) = B_2 n + B_3 n^2, B_2 = b (1 - (lambda^d - 1)(exp(1/T) - 1))",
        criterion="within the standard error of correlated data, B_4 n^3 and 1/N",
        citation=_HENDERSON,
        judge=_judge_virial,
        variants=fixed(*(f"{d}d-{t}" for d in (2, 3) for t in TEMPERATURES)),
        faults=(
            (
                f"3d-{BOYLE}",
                Fault(
                    "virial-of-the-core-only",
                    "events/kernels/measure.py",
                    "        sums[VIRIAL] += impulse * distance\n",
                    "        sums[VIRIAL] += 0.7 * impulse * distance\n",
                    "30 % of the well's part of the virial is missing",
                ),
            ),
        ),
        tier="full",
    ),
    legacy_check(
        name="events/square-well-liquid",
        title="Square-well liquid: energy and pressure against Monte Carlo at constant temperature",
        equation="u(T), Z = 1 + sum r_ij.dp_ij/(3 N T t), T = 2 <K>/(3 (N - 1)); range 1.5",
        criterion="within the standard errors of correlated data and of the reference",
        citation=f"own Monte Carlo, 256 particles, 9000 sweeps; {_HENDERSON}",
        judge=_judge_liquid,
        variants=fixed(*LIQUIDS),
        faults=(
            (
                "n0.7-T1.5",
                Fault(
                    "shallow-well",
                    "events/rules.py",
                    "square = gn * gn + (-twice_depth if inside else twice_depth)",
                    "square = gn * gn + 0.8 * (-twice_depth if inside else twice_depth)",
                    "the wells act as if they were a fifth shallower",
                ),
            ),
        ),
        tier="full",
    ),
)
