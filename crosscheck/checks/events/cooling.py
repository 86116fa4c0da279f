"""Granular gases: homogeneous cooling of smooth and rough grains, oblique impacts, and inelastic collapse.

Literature: P. K. Haff, J. Fluid Mech. 134, 401 (1983); T. P. C. van Noije and M. H. Ernst, Granul. Matter 1, 57 (1998);
M. Huthmann and A. Zippelius, Phys. Rev. E 56, R6275 (1997); S. F. Foerster et al., Phys. Fluids 6, 1108 (1994);
S. McNamara and W. R. Young, Phys. Fluids A 4, 496 (1992); B. Bernu and R. Mazighi, J. Phys. A 23, 5745 (1990);
S. Luding and S. McNamara, Granul. Matter 1, 113 (1998). I. Goldhirsch and G. Zanetti, Phys. Rev. Lett. 70, 1619 (1993).
"""

from __future__ import annotations

import re
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, fixed, legacy_check
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.references import granular as reference
from crosscheck.references.granular import Body
from crosscheck.references.hard_spheres import Estimate, finite_collision_rate, number_density
from crosscheck.scene import (
    Box,
    Face,
    GrainFriction,
    HardSpheres,
    Lattice,
    Observable,
    Output,
    Scene,
    explicit,
)
from crosscheck.statistics import independent_mean, standard_error
from crosscheck.verdict import Judged, bounded, round_off, statistical, within, worst

Floats = NDArray[np.float64]

_LATTICES = {2: "square", 3: "sc"}
#: Longer than any run that ends at a count of collisions.
_FOR_EVER = 1e9


# -- cooling -----------------------------------------------------------------------------------------------------------


#: Independent starts of one gas; collisions of each particle before the measurement: smooth grains forget their Maxwell
#: start soon, while the spins of rough ones, at rest at the start, follow with exp(-s/10).
STARTS, WARM, ROUGH_WARM = 16, 10.0, 50.0
#: Length of the box in units of that at which vortices grow.
SHORT = 0.5
#: Intervals, equally many collisions long, that the measurement consists of.
INTERVALS = 12
#: (dimension, alpha): packing fraction. The more inelastic, the more dilute, so that a box shorter than the clustering
#: length still holds hundreds of grains.
PACKINGS = {
    (2, 0.99): 0.2, (2, 0.95): 0.05, (2, 0.9): 0.02, (2, 0.8): 0.01, (2, 0.7): 0.005,
    (3, 0.99): 0.2, (3, 0.95): 0.07, (3, 0.9): 0.04, (3, 0.8): 0.025, (3, 0.7): 0.02,
}  # fmt: skip
_MOST = 2500


def clustering_length(loss: float, density: float, dimension: int) -> float:
    """Box length above which shear modes grow against the cooling gas, in diameters: 2 pi sqrt(2 nu/zeta).

    A vortex of wave number k decays at nu k^2, the thermal speed at zeta/2 (Goldhirsch and Zanetti 1993). loss:
    -dln T/ds, zeta in units of a particle's collision rate. nu of a dilute gas (Chapman and Cowling, first
    approximation), hence k^2 = 2 pi n^2 loss for disks and 6.4 pi n^2 loss for spheres.
    """
    factor = 2.0 if dimension == 2 else 6.4
    return float(2 * np.pi / (density * (factor * np.pi * loss) ** 0.5))


def _number(loss: float, packing: float, dimension: int) -> int:
    density = number_density(packing, dimension)
    return int(min(density * (SHORT * clustering_length(loss, density, dimension)) ** dimension, _MOST))


def vortex_excess(number: int, length: float, dimension: int) -> float:
    """Relative energy of the flow beyond equilibrium's, (d - 1)/(d N) sum over k of 1/((k/k*)^2 - 1), k* = 2 pi/L*.

    length: of the box, in units of the clustering length L*. A shear mode decays, against the thermal speed, at
    nu k^2 - zeta/2, while noise feeds it as in equilibrium. Over the longest modes, k L/2 pi up to 2: an estimate.
    """
    axes = np.meshgrid(*[np.arange(-2, 3)] * dimension)
    squares = np.sum(np.square(axes), axis=0)
    squares = squares[(squares > 0) & (squares <= 4)] / length**2
    return float((dimension - 1) / (dimension * number) * np.sum(1 / (squares - 1)))


class _Cooling(NamedTuple):
    """Of every start: times (starts, samples), translational and rotational temperatures; collisions per particle."""

    number: int
    times: Floats
    temperatures: Floats
    rotational: Floats
    collisions: Floats

    def rates(self) -> Floats:
        """-dT/dt/T^(3/2) of each start, mean over the intervals: 2 d(T^(-1/2))/dt."""
        return np.asarray((2 * np.diff(self.temperatures**-0.5) / np.diff(self.times)).mean(axis=1))

    def losses(self) -> Floats:
        """-dln T/ds of each start."""
        t = self.temperatures
        return np.asarray(np.log(t[:, 0] / t[:, -1]) / (self.collisions[-1] - self.collisions[0]))


def _cool(
    laboratory: Laboratory, dimension: int, alpha: float, friction: GrainFriction | None, packing: float, loss: float,
    span: float, warm: float,
) -> _Cooling:  # fmt: skip
    """Lets gases cool for `warm` collisions a particle, and then for `span` more, which are measured."""
    number = _number(loss, packing, dimension)
    wanted = number / 2 * (warm + span * np.arange(INTERVALS + 1) / INTERVALS)
    counts = wanted.round().astype(int)
    observables: list[Observable] = ["kinetic_energy", "dissipated_energy", "collisions"]
    if friction:
        observables.append("rotational_energy")
    times, kinetic, rotational = [], [], []
    for start in range(STARTS):
        seed = laboratory.seed(str(start))
        scene = Scene(
            name="cooling",
            dimension=dimension,  # type: ignore[arg-type]
            duration=_FOR_EVER,
            hard_spheres=HardSpheres(restitution=alpha, friction=friction),
            box=Box(packing_fraction=packing),
            initial=Lattice(
                kind="lattice",
                structure=_LATTICES[dimension],  # type: ignore[arg-type]
                number=number,
                temperature=1.0,
                seed=seed,
            ),
            output=Output(collisions=tuple(counts.tolist()), observables=tuple(observables)),
        )
        run = laboratory.run(scene, EVENT_DRIVEN)
        spin = run["rotational_energy"] if friction else np.zeros_like(run["kinetic_energy"])
        times.append(run["time"][1:])
        kinetic.append((run["kinetic_energy"] - spin)[1:])
        rotational.append(spin[1:])
    freedoms = dimension * (number - 1)
    turning = reference.rotational_freedoms(dimension) * number
    return _Cooling(
        number,
        np.array(times),
        2 * np.array(kinetic) / freedoms,
        2 * np.array(rotational) / turning,
        2 * counts / number,
    )


def _cumulant(alpha: float, dimension: int) -> Estimate:
    """Simulated where it is known, else linear theory, which is off by up to 0.007 there."""
    known = reference.FOURTH_CUMULANTS.get((dimension, alpha))
    return known or Estimate(reference.fourth_cumulant(alpha, dimension), 0.004)


def _judge_haff(laboratory: Laboratory, variant: str) -> Judged:
    dimension, alpha = int(variant[0]), float(variant[3:])
    packing, loss = PACKINGS[dimension, alpha], (1 - alpha**2) / dimension
    gas = _cool(laboratory, dimension, alpha, None, packing, loss, min(2.8 / loss, 150.0), WARM)
    a2, rate = _cumulant(alpha, dimension), finite_collision_rate(packing, gas.number, dimension)
    limit = clustering_length(loss, number_density(packing, dimension), dimension)
    length = (gas.number / number_density(packing, dimension)) ** (1 / dimension) / limit
    few = 1 / gas.number + vortex_excess(gas.number, length, dimension)
    per_collision = -float(np.log(reference.temperature_after(1.0, alpha, dimension, a2.value)))
    zeta = reference.cooling_rate(alpha, dimension, rate.value, a2.value)
    shape = 3 / 16 * a2.uncertainty
    why = f"standard error over {STARTS} gases; expected: a_2, g at contact, fluctuations and vortices of order 1/N"
    loss_mean, rate_mean = independent_mean(gas.losses()), independent_mean(gas.rates())
    by_count = statistical(
        "loss of ln T per collision of a particle",
        *loss_mean, per_collision, per_collision * float(np.hypot(4 / 3 * shape, few)), why,
        samples=STARTS, needed=0.05,
    )  # fmt: skip
    by_time = statistical(
        "Haff's cooling rate at T = 1",
        *rate_mean, zeta, zeta * float(np.linalg.norm([shape, rate.uncertainty / rate.value, 1.5 * few])), why,
        samples=STARTS, needed=0.05,
        figures=_haff_figures(gas, f"{dimension}D, alpha = {alpha:g}", rate.value, zeta, per_collision),
    )  # fmt: skip
    return worst(
        [by_count, by_time],
        f"N = {gas.number}, packing fraction {packing:g}, box {length:.2f} of the clustering length",
    )


def _haff_figures(gas: _Cooling, label: str, rate: float, zeta: float, loss: float) -> tuple[Figure, ...]:
    """T(t)/T(t_1) with time in collision times at t_1, and T against collisions."""
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


#: (dimension): dilute enough for a thousand disks in a short box.
ROUGH_PACKINGS = {2: 0.005, 3: 0.02}
_ROUGH = {
    f"{d}d-alpha{alpha:g}-alpha_t{alpha_t:g}": (d, q, alpha, alpha_t) for d, q, alpha, alpha_t in reference.ROUGH_RATIOS
}


def _judge_rough(laboratory: Laboratory, variant: str) -> Judged:
    dimension, q, alpha, alpha_t = case = _ROUGH[variant]
    ratio, packing = reference.ROUGH_RATIOS[case], ROUGH_PACKINGS[dimension]
    closure = reference.rough_ratio(alpha, alpha_t, q, dimension)
    # of the whole energy, and so of either temperature, in the homogeneous state
    losses = [-reference.rough_rates(1.0, x, alpha, alpha_t, q, dimension)[0] for x in (ratio.value, closure)]
    friction = GrainFriction(tangential_restitution=alpha_t, inertia=q)
    gas = _cool(laboratory, dimension, alpha, friction, packing, max(losses), 30.0, ROUGH_WARM)
    measured = gas.rotational / gas.temperatures
    density = number_density(packing, dimension)
    length = (gas.number / density) ** (1 / dimension) / clustering_length(max(losses), density, dimension)
    few = 1 / gas.number + vortex_excess(gas.number, length, dimension)
    why = f"standard error over {STARTS} independent gases"
    x = gas.collisions
    figure = Figure(
        "rotational over translational temperature", "collisions of a particle", "T_rot/T_tr", "linear", "linear",
        (
            Series(variant, x.tolist(), measured.mean(axis=0).tolist(), standard_error(measured).tolist()),
            Series(f"{variant}, Boltzmann equation", [x[0], x[-1]], [ratio.value] * 2, theory=True),
        ),
    )  # fmt: skip
    settles = statistical(
        "T_rot/T_tr of the homogeneous cooling state",
        *independent_mean(measured.mean(axis=1)), ratio.value, float(np.hypot(ratio.uncertainty, ratio.value * few)),
        f"{why}; expected: direct simulation of the Boltzmann equation, and terms of order 1/N",
        samples=STARTS, needed=0.06, figures=(figure,),
    )  # fmt: skip
    decays = statistical(
        "loss of ln T per collision of a particle",
        *independent_mean(gas.losses()), losses[0], abs(losses[1] - losses[0]) + losses[0] * few,
        f"{why}; expected: Maxwellian rates at the simulated ratio, uncertain by what the closure's own ratio changes",
        samples=STARTS, needed=0.25,
    )  # fmt: skip
    return worst([settles, decays], f"N = {gas.number}; the Maxwellian closure has T_rot/T_tr = {closure:.4f}")


# -- oblique impacts ---------------------------------------------------------------------------------------------------

#: Pairs, one angle of impact each; distance between pairs, and times of contact and of the end.
PAIRS, APART, CONTACT, END = 60, 8.0, 0.5, 1.0
_ALPHA, _ALPHA_T, _STATIC, _SLIDING = 0.8, -0.5, 0.5, 0.3
_DIAMETERS = (1.0, 0.6)


class _Pair(NamedTuple):
    """Two bodies that touch at time `CONTACT` in the places `touching`; n points from the second to the first."""

    bodies: tuple[Body, Body]
    species: tuple[int, int]
    normal: Floats
    touching: Floats


def _pairs(dimension: int, seed: int) -> list[_Pair]:
    """Angles of incidence of the contact velocity, of size 1, from 0 to 90 degrees; directions and spins at random."""
    rng = np.random.default_rng(seed)
    plane = np.array([1.0, 1.0, float(dimension == 3)])
    q, made = 0.4 if dimension == 3 else 0.5, []
    side = int(np.ceil(PAIRS ** (1 / dimension)))
    for k in range(PAIRS):
        angle = (k + 0.5) / PAIRS * np.pi / 2
        normal, other = (rng.normal(size=(2, 3))) * plane
        normal /= np.linalg.norm(normal)
        tangent = other - (other @ normal) * normal
        tangent /= np.linalg.norm(tangent)
        species = (k % 2, k // 2 % 2)
        radii = [_DIAMETERS[one] / 2 for one in species]
        spins = rng.normal(size=(2, 3)) * (1 - plane if dimension == 2 else 1)
        masses = rng.uniform(0.5, 2.0, 2)
        slow = 0.1 * rng.normal(size=3) * plane
        fast = slow + np.sin(angle) * tangent - np.cos(angle) * normal
        fast += np.cross(radii[0] * spins[0] + radii[1] * spins[1], normal)
        place = APART * np.array([k % side, k // side % side, k // side**2]) * plane
        bodies = tuple(
            Body(float(mass), radius, velocity, spin, q)
            for mass, radius, velocity, spin in zip(masses, radii, (fast, slow), spins, strict=True)
        )
        touching = np.array([place + sum(radii) * normal, place])
        made.append(_Pair((bodies[0], bodies[1]), species, normal, touching))
    return made


def _impacts(pairs: list[_Pair], dimension: int) -> Scene:
    bodies = [body for pair in pairs for body in pair.bodies]
    velocities = np.array([body.velocity for body in bodies])
    places = np.concatenate([pair.touching for pair in pairs]) - CONTACT * velocities
    spins = np.array([body.spin for body in bodies])
    return Scene(
        name="oblique-impacts",
        dimension=dimension,  # type: ignore[arg-type]
        duration=END,
        masses=tuple(body.mass for body in bodies),
        species=tuple(one for pair in pairs for one in pair.species),
        hard_spheres=HardSpheres(
            diameter=_DIAMETERS,
            restitution=_ALPHA,
            friction=GrainFriction(tangential_restitution=_ALPHA_T, static=_STATIC, sliding=_SLIDING),
        ),
        initial=explicit(places[:, :dimension], velocities[:, :dimension], spins[:, 2:] if dimension == 2 else spins),
    )


def _spatial(rows: Floats, spin: bool = False) -> Floats:
    """(N, 1 | 2 | 3) as (N, 3); the one component of a spin is the third."""
    missing = 3 - rows.shape[1]
    return np.pad(rows, ((0, 0), (missing, 0) if spin else (0, missing)))


def _judge_oblique(laboratory: Laboratory, variant: str) -> Judged:
    dimension = int(variant[0])
    pairs = _pairs(dimension, laboratory.seed())
    run = laboratory.run(_impacts(pairs, dimension), EVENT_DRIVEN)
    places, velocities = _spatial(run["final_positions"]), _spatial(run["final_velocities"])
    spins = _spatial(run["final_angular_velocities"], spin=True)
    errors, lost, sliding, points = [], [], 0, []
    for k, pair in enumerate(pairs):
        one, two = pair.bodies
        found = slice(2 * k, 2 * k + 2)
        expected = reference.impact(one, two, pair.normal, _ALPHA, _ALPHA_T, _STATIC, _SLIDING)
        sliding += expected.sliding
        after = [
            body._replace(velocity=v, spin=w)
            for body, v, w in zip(pair.bodies, velocities[found], spins[found], strict=True)
        ]
        radii = np.array([one.radius, two.radius])[:, None]
        # near grazing, a rounding of the place along the path is one of the normal times 1/cos
        graze = abs(reference.contact_velocity(one, two, pair.normal) @ pair.normal)
        errors += [graze * (velocities[found] - expected.velocities), graze * radii * (spins[found] - expected.spins)]
        before = pair.touching - CONTACT * np.array([one.velocity, two.velocity])
        lost.append(_moments(after, places[found]) - _moments([one, two], before))
        points.append(_impact_point(pair, after))
    size = float(np.ptp([pair.touching for pair in pairs]))
    # a rounding of the coordinates turns the normal of the smallest grains by so much
    turn = EPSILON * size / min(_DIAMETERS)
    scale = max(float(np.linalg.norm(body.velocity)) for pair in pairs for body in pair.bodies)
    like = round_off(
        "largest error of velocities and of R w, times the cosine of the angle of impact",
        float(abs(np.array(errors)).max()),
        16 * turn * scale,
        "rounding of the places at contact: it turns the normal, by which every component changes",
        figures=(_impact_figure(np.array(points).T, dimension),),
    )
    kept = round_off(
        "largest change of a pair's momentum or angular momentum",
        float(abs(np.array(lost)).max()),
        16 * EPSILON * (scale * size + scale),
        "rounding of m r x v, with r from the corner of the arrangement",
    )
    return worst([like, kept], f"{PAIRS} impacts, {sliding} of which slide")


def _moments(bodies: list[Body], places: Floats) -> Floats:
    """Momentum and angular momentum of two bodies, (6,)."""
    momenta = np.array([body.mass * body.velocity for body in bodies])
    turning = np.cross(places, momenta) + [body.inertia * body.spin for body in bodies]
    return np.concatenate([momenta.sum(axis=0), turning.sum(axis=0)])


def _impact_point(pair: _Pair, after: list[Body]) -> tuple[float, float]:
    """Tangential over normal contact velocity: before, and along the same direction after."""
    before = reference.contact_velocity(*pair.bodies, pair.normal)
    normal = float(before @ pair.normal)
    slip = before - normal * pair.normal
    size = float(np.linalg.norm(slip))
    rebound = reference.contact_velocity(after[0], after[1], pair.normal)
    return size / -normal, float(rebound @ slip) / size / -normal


def _impact_figure(points: Floats, dimension: int) -> Figure:
    """Foerster's plot: sticking is a line through the origin, sliding one of slope 1."""
    q = 0.4 if dimension == 3 else 0.5
    limit = reference.sliding_limit(_ALPHA, _ALPHA_T, _STATIC, q)
    shown = points[:, points[0] < 4 * limit]
    slid = np.array([limit, 4 * limit])
    theory = (
        Series(f"{dimension}D, sticking", [0.0, limit], [0.0, _ALPHA_T * limit], theory=True),
        Series(
            f"{dimension}D, sliding", slid.tolist(), (slid - _SLIDING * (1 + _ALPHA) * (1 + 1 / q)).tolist(),
            theory=True,
        ),
    )  # fmt: skip
    return Figure(
        "oblique impacts", "tangential / normal contact velocity before", "the same after", "linear", "linear",
        (Series(f"{dimension}D", shown[0].tolist(), shown[1].tolist()), *theory),
    )  # fmt: skip


# -- inelastic collapse ------------------------------------------------------------------------------------------------


class Line(NamedTuple):
    """Collisions on a line: numbers of pairs and with the wall, times of all, largest closing gap after each.

    collapsed: whether they go on for ever, to a finite time.
    """

    pairs: int
    wall: int
    times: Floats
    gaps: Floats
    collapsed: bool


def line_collisions(gaps: ArrayLike, velocities: ArrayLike, alpha: float, wall: bool) -> Line:
    """Like particles on a line, from gaps and relative velocities alone: no precision is lost as they shrink.

    velocities: of all particles. gaps: between neighbours; with `wall`, first that between the wall at rest, of the
    same restitution, and the first particle. Long double. It is a collapse if the velocities have shrunk to 1e-200 and
    particles still approach.
    """
    real = np.longdouble
    gap, half = np.array(gaps, dtype=real), (1 + real(alpha)) / 2
    speed = np.diff(np.array([0.0] * wall + list(np.asarray(velocities)), dtype=real))
    now, hits = real(0), [0, 0]
    times: list[float] = []
    largest: list[float] = []

    def result(collapsed: bool) -> Line:
        return Line(hits[0], hits[1], np.array(times), np.array(largest), collapsed)

    while True:
        closing = speed < 0
        if not closing.any():
            return result(False)
        if abs(speed[closing]).max() < 1e-200:
            return result(True)
        spans = np.where(closing, gap / np.where(closing, -speed, 1), np.inf)
        k = int(spans.argmin())
        now, gap = now + spans[k], gap + speed * spans[k]
        gap[k], approach = 0, speed[k]
        speed[k] = -real(alpha) * approach
        at_wall = wall and k == 0
        if k > 0:
            speed[k - 1] += half * approach
        if k + 1 < speed.size:
            speed[k + 1] += (2 * half if at_wall else half) * approach
        hits[at_wall] += 1
        times.append(float(now))
        largest.append(float(gap[speed < 0].max(initial=0)))


def reported_time(run: Run) -> float:
    """Time of the inelastic collapse that ended the run; not a number if none is reported, or without a particle."""
    found = re.search(r"particles? \d+.*t = ([-+.\de]+)", run.stopped)
    return float(found[1]) if found else np.nan


def _row(gaps: Floats, velocities: Floats, alpha: float, wall: bool, **more: Any) -> Scene:
    """Disks of diameter 1 in a row along x; x = 0 is a wall, or there is none; walls far above and below."""
    number = velocities.size
    start = 0.5 + gaps[0] if wall else 4.0
    x = start + np.concatenate([[0.0], np.cumsum(1 + gaps[wall:])])
    length = float(x[-1] + 4.0)
    return Scene(
        name="row",
        dimension=2,
        hard_spheres=HardSpheres(restitution=alpha, contact_duration=more.pop("contact_duration", None)),
        box=Box(
            lengths=(length, 4.0),
            boundaries=("hard", "hard"),
            faces={"x-": Face(restitution=alpha) if wall else Face(open=True), "x+": Face(open=True)},
        ),
        initial=explicit(np.stack([x, np.full(number, 2.0)], axis=1), np.stack([velocities, np.zeros(number)], axis=1)),
        output=Output(interval=more["duration"], observables=("collisions", "wall_collisions", "kinetic_energy")),
        **more,
    )


#: Of three particles in the frame of their centre of mass, so that velocities may shrink without rounding.
_THREE = np.array([14.0, -1.0, -13.0]) / 15
_THREE_GAPS = np.array([1.0, 1.3])


def _start(variant: str) -> tuple[Floats, Floats, bool, float]:
    """Gaps, velocities, whether there is a wall, and the restitution below which they collapse."""
    if variant == "three":
        return _THREE_GAPS, _THREE, False, reference.THREE_PARTICLE_COLLAPSE
    number = int(variant.removeprefix("wall-"))
    gaps = np.linspace(1.0, 0.9 + 0.1 * number, number)
    return gaps, np.full(number, -1.0), True, reference.wall_collapse(number)


def _judge_collapse(laboratory: Laboratory, variant: str) -> Judged:
    gaps, velocities, wall, limit = _start(variant)
    below, above = (0.07, 0.073) if variant == "three" else (0.97 * limit, 1.03 * limit)
    exact = line_collisions(gaps, velocities, below, wall)
    run = laboratory.run(_row(gaps, velocities, below, wall, duration=2 * float(exact.times[-1])), EVENT_DRIVEN)
    time, stopped = reported_time(run), run.stopped
    rounding = 4 * EPSILON * float(np.sum(gaps) + velocities.size)
    left = exact.times[-1] - exact.times
    tolerance = float(np.sum(left * np.minimum(1.0, rounding / np.maximum(exact.gaps, 1e-300))))
    found = within(
        "round_off", f"time of the collapse at alpha = {below:.4g}", time, float(exact.times[-1]),
        tolerance,
        "four roundings of the coordinates change each gap, and the time left from there, in proportion",
    )  # fmt: skip
    sound = line_collisions(gaps, velocities, above, wall)
    run = laboratory.run(_row(gaps, velocities, above, wall, duration=2 * float(sound.times[-1])), EVENT_DRIVEN)
    hits = run["collisions"][-1] + run["wall_collisions"][-1].sum()
    none = within(
        "round_off", f"collisions until all part at alpha = {above:.4g}", float(hits), sound.pairs + sound.wall, 0.5,
        "a count: exact",
    )  # fmt: skip
    return worst([found, none], f"limit {limit:.5f}; below it '{stopped}', above it '{run.stopped}'")


#: t_c of the TC model, far below the time between collisions before the collapse.
_CONTACT_DURATION = 1e-6


def _judge_contact_duration(laboratory: Laboratory, variant: str) -> Judged:
    """The same rows with the TC model go on to their end."""
    gaps, velocities, wall, limit = _start(variant)
    alpha, duration = 0.9 * limit, 20.0
    scene = _row(gaps, velocities, alpha, wall, duration=duration, contact_duration=_CONTACT_DURATION)
    run = laboratory.run(scene, EVENT_DRIVEN)
    energy = run["kinetic_energy"]
    last = float(run["time"][np.isfinite(energy)][-1])
    carries_on = within(
        "round_off", "time reached", last, duration, EPSILON * duration, "the run must end at its duration",
        note=run.stopped,
    )  # fmt: skip
    falls = bounded("kinetic energy at the end over that at the start", float(energy[-1] / energy[0]), 1.0, "it falls")
    return worst([carries_on, falls], f"alpha = {alpha:.4g}, t_c = {_CONTACT_DURATION:g}")


# -- the checks --------------------------------------------------------------------------------------------------------

RESTITUTION_SQUARED = Fault(
    "restitution-squared",
    "events/rules.py",
    "normal = -(1.0 + alpha) * gn * mass",
    "normal = -(1.0 + alpha * alpha) * gn * mass",
    "pairs rebound with the square of the restitution",
)


def _haff_check(name: str, tier: Any, variants: tuple[str, ...]) -> Check:
    return legacy_check(
        name=name,
        title="Homogeneous cooling of smooth grains: Haff's law",
        equation="T = T_0/(1 + zeta_0 t/2)^2 = T_0 exp(-(1 - alpha^2) s/d (1 + 3 a_2/16)/(1 - a_2/16)), "
        "zeta = (1 - alpha^2) w/d (1 + 3 a_2/16)",
        criterion=f"{STARTS} gases shorter than half the clustering length, after {WARM:g} collisions a particle",
        citation="Haff, J. Fluid Mech. 134, 401 (1983); van Noije & Ernst, Granul. Matter 1, 57 (1998)",
        judge=_judge_haff,
        variants=fixed(*variants),
        faults=((variants[0], RESTITUTION_SQUARED),),
        tier=tier,
    )


CHECKS = (
    _haff_check("events/haff", "quick", ("2d-0.9",)),
    _haff_check("events/haff-series", "full", tuple(f"{d}d-{a:g}" for d, a in PACKINGS if (d, a) != (2, 0.9))),
    legacy_check(
        name="events/haff-rough",
        title="Homogeneous cooling of rough grains: rotational against translational temperature",
        equation="dln T_rot/dt = dln T_tr/dt, constant alpha and alpha_t",
        criterion=f"{STARTS} gases, against direct simulation of the Boltzmann equation",
        citation="Huthmann & Zippelius, Phys. Rev. E 56, R6275 (1997); Santos et al., Phys. Fluids 23, 030604 (2011)",
        judge=_judge_rough,
        variants=fixed(*_ROUGH),
        faults=(
            (
                next(iter(_ROUGH)),
                Fault(
                    "inertia-of-the-contact",
                    "events/rules.py",
                    "stick = (1.0 - alpha_t) * inertia / (1.0 + inertia) * mass",
                    "stick = (1.0 - alpha_t) * inertia / (1.0 + 2.0 * inertia) * mass",
                    "the tangential impulse has the wrong effective mass",
                ),
            ),
        ),
        tier="full",
    ),
    legacy_check(
        name="events/oblique-impact",
        title="Oblique impacts of rough grains: from sticking to sliding",
        equation="J_n = (1 + alpha) mu |g_n|; |J_t| = (1 - alpha_t) q/(1 + q) mu |g_t|, or mu_k J_n if above mu_s J_n",
        criterion="each velocity and spin of 60 pairs of unlike sizes and masses, to rounding",
        citation="Walton, in Particulate Two-Phase Flow (1993); Foerster et al., Phys. Fluids 6, 1108 (1994)",
        judge=_judge_oblique,
        variants=fixed("2d", "3d"),
        faults=(
            (
                "2d",
                Fault(
                    "coulomb-on-velocities",
                    "events/rules.py",
                    "if stick * slip > static * normal:",
                    "if (1.0 - alpha_t) * mass * slip > static * normal:",
                    "Coulomb's law compares the changes of the contact velocity, not the impulses",
                ),
            ),
        ),
        tier="full",
    ),
    legacy_check(
        name="events/inelastic-collapse",
        title="Inelastic collapse on a line: three particles, and N thrown at a wall",
        equation="alpha < 7 - 4 sqrt 3; alpha < tan^2(pi/4 (1 - 1/N))",
        criterion="found below the limit, with its time and particles; none above, and the exact number of collisions",
        citation="McNamara & Young, Phys. Fluids A 4, 496 (1992); Bernu & Mazighi, J. Phys. A 23, 5745 (1990)",
        judge=_judge_collapse,
        variants=fixed("three", "wall-2", "wall-3", "wall-5"),
        faults=(("wall-5", RESTITUTION_SQUARED),),
        tier="full",
    ),
    legacy_check(
        name="events/contact-duration",
        title="The TC model carries a run through an inelastic collapse",
        equation="alpha = 1 for who has collided less than t_c ago",
        criterion="the run reaches its end with a finite number of collisions and less energy",
        citation="Luding & McNamara, Granul. Matter 1, 113 (1998)",
        judge=_judge_contact_duration,
        variants=fixed("three", "wall-5"),
        faults=(
            (
                "wall-5",
                Fault(
                    "no-contact-duration",
                    "events/rules.py",
                    "return age < contact_duration",
                    "return age < 0.0 * contact_duration",
                    "the TC model is never elastic",
                ),
            ),
        ),
        tier="full",
    ),
)
