"""What walls draw at random: thermal ones and those of random phase, for every face, mass and velocity before.

Each draw is made a uniform number by its own distribution function, so that all masses, temperatures and velocities are
judged together; then it may depend on nothing. Points that never meet hit the walls one by one.

Literature: R. Tehver et al., Phys. Rev. E 57, R17 (1998); S. McNamara and J.-L. Barrat, Phys. Rev. E 55, 7767 (1997);
M. Rosenblatt, Ann. Math. Stat. 23, 470 (1952).
"""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, Variant
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.references.random_rules import (
    flux_of_maxwell,
    independent,
    maxwell_component,
    random_phase,
    repeats,
    uniform,
    uniform_in_groups,
)
from crosscheck.scene import AXES, Floats, Scene
from crosscheck.scene.parts import Box, Explicit, Face, HardSpheres, Output, RandomPhase
from crosscheck.verdict import Judged, Judgement, bounded, by_chance, round_off, worst

_CHANCE = "-ln of the probability that a right code deviates as much: exponential, as that one is uniform"
#: Smaller probabilities are as good as none.
LEAST = 1e-300
#: Seeds below this are small: of two neighbours among them few bits are set, and fewer differ.
SMALL_SEEDS = 64
#: Temperatures of the lower and upper walls of each axis, and masses of the particles in turn.
_TEMPERATURES = {"x": (0.7, 1.9), "y": (1.4, 0.6), "z": (0.9, 2.3)}
_MASSES = (0.5, 3.0, 1.3)
#: Points between two thermal walls, their distance, and flights of each (of the mean mass and temperature).
_POINTS, _WIDTH, _FLIGHTS = 9, 1.6, 100.0
#: No normal velocity of that many standard deviations is drawn: once in 1e8.
_FASTEST = 6.0
#: Side of the box along the walls: long, so that cells are large, and few are crossed.
_LENGTH = 40.0
#: Samples, in each of which a point meets each wall of random phase once; by face, largest velocities of the walls and
#: their restitutions.
_VISITS = 100
_SPEEDS = (0.7, 1.3, 1.0, 0.5, 1.6, 0.9)
_RESTITUTIONS = (1.0, 0.8, 0.6, 0.9, 1.0, 0.7)
#: Restitution of two walls between which points fly to and fro, and samples.
_RETURN, _RETURN_SAMPLES = 0.9, 700


class _Thermal(NamedTuple):
    """dimension: 2 or 3. flights: of each point, of the mean mass and temperature."""

    dimension: int
    flights: float = _FLIGHTS


class Hits(NamedTuple):
    """What walls gave, one row a hit, in the order of particles and then of time.

    particle: numbers. face: of the hit, see `face_names`. before, after: velocities (hits, d), those along the normal
    at the place `axis` counted into the box.
    """

    particle: NDArray[np.int64]
    face: NDArray[np.int64]
    before: Floats
    after: Floats


def hits_between(run: Run, axis: int) -> Hits:
    """The hits of points that fly between the two walls across an axis, from samples shorter than any flight.

    run: with its trajectory. axis: of the walls. A velocity is constant between hits: where it changes there was one.
    """
    v = run["velocities"].transpose(1, 0, 2)
    particle, sample = np.nonzero((v[:, 1:] != v[:, :-1]).any(axis=2))
    before, after = v[particle, sample].copy(), v[particle, sample + 1].copy()
    upper = before[:, axis] > 0
    before[upper, axis] *= -1
    after[upper, axis] *= -1
    return Hits(particle, 2 * axis + upper, before, after)


def _needs(face: str) -> Needs:
    words = f"dimension=2 dimension=3 masses[] hard_spheres.diameter box.boundaries=periodic box.boundaries=hard {face}"
    return Needs(
        "hard_spheres",
        (EVENT_DRIVEN,),
        frozenset(f"box.faces {words}".split()),
        frozenset({"positions", "velocities", "wall_collisions", "wall_energy", "wall_impulse"}),
    )


def chance(name: str, probability: float) -> Judgement:
    """The judgement that what was drawn is not too improbable.

    name: of what was tested. probability: that a right code deviates as much.
    """
    from scipy.stats import expon

    return by_chance(f"-ln of the probability of {name}", -math.log(max(probability, LEAST)), expon, _CHANCE)


def _tallied(scene: Scene, run: Run, hits: Hits, masses: Floats) -> list[Judgement]:
    """All hits were seen, and the tallies of the walls are sums over them."""
    faces = run["wall_collisions"].shape[1]
    counts = np.bincount(hits.face, minlength=faces)
    mass, rounding = masses[hits.particle], EPSILON * len(hits.face)
    energies = mass / 2 * ((hits.after**2).sum(axis=1) - (hits.before**2).sum(axis=1))
    by_face = np.bincount(hits.face, energies, minlength=faces)
    scale = float(abs(energies).sum())
    impulse = np.zeros((faces, scene.dimension))
    # `before` and `after` count the normal into the box: at upper faces the other way round
    given = mass[:, None] * (hits.before - hits.after)
    rows = np.arange(len(hits.face))
    given[rows, hits.face // 2] *= np.where(hits.face % 2 == 0, 1.0, -1.0)
    np.add.at(impulse, hits.face, given)
    why = "sums over the hits that the samples show, rounded at each"
    return [
        bounded("hits that the samples do not show", float(abs(counts - run["wall_collisions"][-1]).sum()), 0.0,
                "a sample takes less time than the fastest flight", control=True),
        round_off("largest error of the energy of a wall", float(abs(by_face - run["wall_energy"][-1]).max()),
                  rounding * scale, why),
        round_off("largest error of the momentum of a wall", float(abs(impulse - run["wall_impulse"][-1]).max()),
                  rounding * float(abs(given).sum()), why),
    ]  # fmt: skip


# -- thermal walls -----------------------------------------------------------------------------------------------------


def _masses(number: int) -> Floats:
    return np.array([_MASSES[i % len(_MASSES)] for i in range(number)])


def thermal_scene(dimension: int, axis: int, seed: int, flights: float = _FLIGHTS) -> Scene:
    """Points between two thermal walls, periodic along the other axes; sampled faster than the fastest flies across.

    dimension: 2 or 3. axis: of the walls. seed: of the walls' draws, and of the start. flights: of a point of mean
    mass and temperature.
    """
    rng = np.random.default_rng(seed)
    masses, temperatures = _masses(_POINTS), _TEMPERATURES[AXES[axis]]
    lengths = np.full(dimension, _LENGTH)
    lengths[axis] = _WIDTH
    fastest = _FASTEST * (max(temperatures) / masses.min()) ** 0.5
    interval = _WIDTH / fastest
    samples = round(flights * _WIDTH / interval)
    boundaries: Any = tuple("hard" if k == axis else "periodic" for k in range(dimension))
    faces = {f"{AXES[axis]}{side}": Face(temperature=t) for side, t in zip("-+", temperatures, strict=True)}
    return Scene(
        name=f"points between thermal walls along {AXES[axis]}",
        dimension=dimension,  # type: ignore[arg-type]
        duration=samples * interval,
        masses=tuple(masses.tolist()),
        seed=seed,
        hard_spheres=HardSpheres(diameter=0.0),
        box=Box(lengths=tuple(lengths.tolist()), boundaries=boundaries, faces=faces),
        initial=Explicit(
            positions=tuple(map(tuple, (rng.uniform(0.01, 0.99, (_POINTS, dimension)) * lengths).tolist())),
            velocities=tuple(map(tuple, rng.normal(size=(_POINTS, dimension)).tolist())),
        ),
        output=Output(
            interval=interval, trajectory=True, observables=("wall_collisions", "wall_energy", "wall_impulse")
        ),
    )


def _thermal_draws(hits: Hits, axis: int, masses: Floats) -> Floats:
    """The draws as uniform numbers, (hits, d), the normal one first."""
    temperature = np.array(_TEMPERATURES[AXES[axis]])[hits.face % 2]
    mass = masses[hits.particle]
    along = [k for k in range(hits.after.shape[1]) if k != axis]
    draws = [np.where(hits.after[:, axis] > 0, flux_of_maxwell(hits.after[:, axis], temperature, mass), np.nan)]
    draws += [maxwell_component(hits.after[:, k], temperature, mass) for k in along]
    return np.stack(draws, axis=1)


def _judge_thermal(laboratory: Laboratory, walls: _Thermal) -> Judged:
    dimension = walls.dimension
    masses, draws, hits, judged = _masses(_POINTS), [], [], []
    for axis in range(dimension):
        scene = thermal_scene(dimension, axis, laboratory.seed(AXES[axis]), walls.flights)
        run = laboratory.run(scene, EVENT_DRIVEN)
        found = hits_between(run, axis)
        judged += _tallied(scene, run, found, masses)
        draws.append(_thermal_draws(found, axis, masses))
        hits.append(found)
    u, incoming = np.concatenate(draws), np.concatenate([np.linalg.norm(one.before, axis=1) for one in hits])
    normal = np.concatenate([one.before[:, axis] for axis, one in enumerate(hits)])
    particle = np.concatenate([one.particle + _POINTS * axis for axis, one in enumerate(hits)])
    face = np.concatenate([one.face for one in hits])
    same = np.flatnonzero(particle[1:] == particle[:-1])
    names = ["normal component", *(f"component {k} along the wall" for k in range(1, dimension))]
    for k, name in enumerate(names):
        judged += [
            chance(f"the {name}", uniform(u[:, k])),
            chance(f"the {name} by face and mass", uniform_in_groups(u[:, k], face * 3 + particle % _POINTS % 3)),
            chance(f"the {name} by the speed before", independent(u[:, k], incoming)),
            chance(f"the {name} by the normal velocity before", independent(u[:, k], normal)),
            chance(f"the {name} by its number", independent(u[:, k], np.arange(len(u), dtype=float))),
            chance(f"the {name} by the one of the hit before", independent(u[same + 1, k], u[same, k])),
            chance(f"the {name} by all of the hit before", independent(u[same + 1, k], u[same].sum(axis=1))),
            *(chance(f"the {name} by the {names[m]}", independent(u[:, k], u[:, m])) for m in range(k)),
        ]
    return worst([*judged, _unrepeated(u)], f"{len(u)} hits on {2 * dimension} faces, three masses")


def _unrepeated(draws: Floats) -> Judgement:
    return bounded("draws that are the same number as another one", float(repeats(draws)), 0.0,
                   "of some thousand doubles no two are equal by chance")  # fmt: skip


def _judge_seeds(laboratory: Laboratory, value: None) -> Judged:
    masses, seeds = _masses(_POINTS), [laboratory.seed(name) for name in ("one", "other")]
    scene = thermal_scene(2, 0, seeds[0], _FLIGHTS / 2)
    small = laboratory.seed("small") % SMALL_SEEDS
    runs = [
        laboratory.run(scene.changed(seed=seed), EVENT_DRIVEN)
        for seed in (seeds[0], seeds[0], seeds[1], small, small + 1)
    ]
    found = [hits_between(run, 0) for run in runs]
    draws = [_thermal_draws(one, 0, masses) for one in found]
    same = float(abs(runs[0]["velocities"] - runs[1]["velocities"]).max())
    judged = [bounded("difference of two runs with the same seed", same, 0.0, "the draws follow from the seed alone")]
    for one, other, name in ((0, 2, "two seeds"), (3, 4, "seeds that differ by 1")):
        a, b = _same_hits(found[one], found[other])
        first, second = draws[one][a], draws[other][b]
        judged += [chance(f"draws {k} for {name}", independent(first[:, k], second[:, k])) for k in range(2)]
        judged.append(_unrepeated(np.concatenate([first, second])))
    # particle by particle, at the same number of the hit
    number = _numbers(found[0])
    pairs = [
        (i, j)
        for count in range(int(number.max()))
        for i, j in zip(np.flatnonzero(number == count)[:-1], np.flatnonzero(number == count)[1:], strict=True)
    ]
    first, second = (np.array(part) for part in zip(*pairs, strict=True))
    judged += [
        chance(
            f"draws {k} of a particle by those of the one before", independent(draws[0][second, k], draws[0][first, m])
        )
        for k in range(2)
        for m in range(2)
    ]
    return worst(judged, f"{len(draws[0])} hits a seed")


def _numbers(hits: Hits) -> NDArray[np.int64]:
    """The number of each hit among those of its particle, from 0."""
    starts = np.searchsorted(hits.particle, hits.particle)
    return np.asarray(np.arange(hits.particle.size) - starts)


def _same_hits(one: Hits, other: Hits) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows of the hits with the same particle and number in both."""
    first, second = (hits.particle * 100000 + _numbers(hits) for hits in (one, other))
    _, a, b = np.intersect1d(first, second, return_indices=True)
    return a, b


# -- walls of random phase ---------------------------------------------------------------------------------------------


def visits_scene(dimension: int, law: Literal["uniform", "flux"], seed: int) -> tuple[Scene, Floats, NDArray[np.int64]]:
    """Points that meet walls of random phase, each in its own sample; with their normal velocities, and faces.

    dimension: 2 or 3. law: of the phases. seed: of the walls, and of the velocities. In the middle of each sample one
    point arrives at each face, in a box so large that it meets no other wall.
    """
    rng, number = np.random.default_rng(seed), _VISITS * 2 * dimension
    faces = np.arange(number) % (2 * dimension)
    top = np.array(_SPEEDS)[faces]
    incoming = -top * np.exp(rng.uniform(np.log(0.05), np.log(4.0), number))
    arrivals = (np.arange(number) // (2 * dimension) + 0.5) / _VISITS
    length = 200.0 * max(_SPEEDS)
    positions = np.full((number, dimension), length / 2)
    velocities = np.zeros((number, dimension))
    inwards = np.where(faces % 2 == 0, 1.0, -1.0)
    rows = np.arange(number)
    positions[rows, faces // 2] = np.where(faces % 2 == 0, 0.0, length) - inwards * incoming * arrivals
    velocities[rows, faces // 2] = inwards * incoming
    positions += 0.45 * length * rng.uniform(-1.0, 1.0, positions.shape) * (velocities == 0)
    walls = {
        f"{AXES[face // 2]}{'-+'[face % 2]}": Face(
            restitution=_RESTITUTIONS[face], random_phase=RandomPhase(speed=_SPEEDS[face], law=law)
        )
        for face in range(2 * dimension)
    }
    hard: Any = ("hard",) * dimension
    scene = Scene(
        name=f"visits to walls of random phase, {law}",
        dimension=dimension,  # type: ignore[arg-type]
        duration=1.0,
        masses=tuple(_masses(number).tolist()),
        seed=seed,
        hard_spheres=HardSpheres(diameter=0.0),
        box=Box(lengths=(length,) * dimension, boundaries=hard, faces=walls),
        initial=Explicit(
            positions=tuple(map(tuple, positions.tolist())), velocities=tuple(map(tuple, velocities.tolist()))
        ),
        output=Output(interval=1 / _VISITS, observables=("wall_collisions",)),
    )
    return scene, incoming, faces


def _visit_draws(
    run: Run, law: Literal["uniform", "flux"], incoming: Floats, faces: NDArray[np.int64], seed: int
) -> tuple[Floats, NDArray[np.float64]]:
    """The draws at the first hit of each visit as uniform numbers, and the hits of each visit.

    After a draw so far away from the particle that it does not leave the wall it hits again at once. Then the first
    draw is known to be below a v/(1 + a), and a number below that is taken at random in its place.
    """
    rows = np.arange(faces.size)
    counts = np.diff(run["wall_collisions"], axis=0)[rows // (faces.max() + 1), faces]
    inwards = np.where(faces % 2 == 0, 1.0, -1.0)
    outgoing = inwards * run["final_velocities"][rows, faces // 2]
    a, top = np.array(_RESTITUTIONS)[faces], np.array(_SPEEDS)[faces]
    single = random_phase((outgoing + a * incoming) / (1 + a), incoming, top, law)
    below = random_phase(np.maximum(a * incoming / (1 + a), -top), incoming, top, law)
    several = below * np.random.default_rng(seed).random(faces.size)
    return np.where(counts == 1, single, several), counts


def _judge_phase(laboratory: Laboratory, law: Literal["uniform", "flux"]) -> Judged:
    draws, speeds, faces, missed, again, astray = [], [], [], 0.0, 0, 0.0
    for dimension in (2, 3):
        scene, incoming, face = visits_scene(dimension, law, laboratory.seed(f"visits in {dimension}"))
        run = laboratory.run(scene, EVENT_DRIVEN)
        u, counts = _visit_draws(run, law, incoming, face, laboratory.seed("ties"))
        missed += float(abs(run["wall_collisions"][-1].sum() - counts.sum()) + (counts == 0).sum())
        again += int((counts > 1).sum())
        draws.append(u)
        speeds.append(-incoming / np.array(_SPEEDS)[face])
        faces.append(face + 6 * dimension)
        along = run["final_velocities"].copy()
        along[np.arange(face.size), face // 2] = 0.0
        astray = max(astray, float(abs(along).max()))
    u, speed, face = np.concatenate(draws), np.concatenate(speeds), np.concatenate(faces)
    control = "each point meets its wall in its own sample, and no other wall"
    judged = [
        bounded("visits without a hit, and hits without a visit", missed, 0.0, control, control=True),
        bounded("largest velocity along a smooth wall", astray, 0.0, "the impulse is along the normal"),
        chance("the phase", uniform(u)),
        chance("the phase of slow points", uniform(u[speed < 1])),
        chance("the phase of fast points", uniform(u[speed > 1.5])),
        chance("the phase by face", uniform_in_groups(u, face)),
        chance("the phase by the velocity before", independent(u, speed)),
        chance("the phase by the particle before", independent(u[1:], u[:-1])),
        chance("the phase by its number", independent(u, np.arange(u.size, dtype=float))),
        _unrepeated(u),
        *_returns(laboratory, law),
    ]
    return worst(judged, f"{u.size} visits, {again} of them with several hits at once")


def _returns(laboratory: Laboratory, law: Literal["uniform", "flux"]) -> list[Judgement]:
    """Points that fly to and fro between two walls: one hit of a particle after the other.

    Of a particle of the velocity v >= (1 + a)/a V0 no draw is so far away that it hits again at once.
    """
    rng, top, width = np.random.default_rng(laboratory.seed("returns")), 1.0, 10.0
    interval = width / (12 * top)
    wall = Face(restitution=_RETURN, random_phase=RandomPhase(speed=top, law=law))
    v = np.stack([rng.choice([-1.0, 1.0], _POINTS) * rng.uniform(3.0, 6.0, _POINTS), rng.normal(size=_POINTS)], axis=1)
    scene = Scene(
        name=f"points between walls of random phase, {law}",
        dimension=2,
        duration=_RETURN_SAMPLES * interval,
        seed=laboratory.seed("walls"),
        hard_spheres=HardSpheres(diameter=0.0),
        box=Box(lengths=(width, 4 * width), boundaries=("hard", "periodic"), faces={"x-": wall, "x+": wall}),
        initial=Explicit(
            positions=tuple(map(tuple, (rng.uniform(0.1, 0.9, (_POINTS, 2)) * [width, 4 * width]).tolist())),
            velocities=tuple(map(tuple, v.tolist())),
        ),
        output=Output(interval=interval, trajectory=True, observables=("wall_collisions",)),
    )
    hits = hits_between(laboratory.run(scene, EVENT_DRIVEN), 0)
    fast = hits.before[:, 0] <= -(1 + _RETURN) / _RETURN * top
    walls = (hits.after[:, 0] + _RETURN * hits.before[:, 0]) / (1 + _RETURN)
    u = random_phase(walls, hits.before[:, 0], np.full(walls.size, top), law)
    both = np.flatnonzero((hits.particle[1:] == hits.particle[:-1]) & fast[1:] & fast[:-1])
    number = _numbers(hits).astype(float)
    return [
        chance("the phase at later hits", uniform(u[fast])),
        chance("the phase by the number of the hit", independent(u[fast], number[fast] + 1e-6 * u[fast])),
        chance("the phase by that of the hit before", independent(u[both + 1], u[both])),
        _unrepeated(u[fast]),
    ]


CHECKS = (
    Check(
        name="events/random-walls",
        title="What thermal walls and walls of random phase draw, whatever came in",
        equation="p(v_n) ~ v_n exp(-m v_n^2/2T), Gaussian along the wall; V = V0 cos(phi), V > v, or weighted by V - v",
        criterion="Kolmogorov-Smirnov and chi^2 of independence, red twice beyond the 1e-3 quantile",
        citation="Tehver et al., Phys. Rev. E 57, R17 (1998); McNamara & Barrat, Phys. Rev. E 55, 7767 (1997)",
        judge=lambda laboratory, case: case[0](laboratory, case[1]),
        variants=(
            Variant("thermal-2d", (_judge_thermal, _Thermal(2)), needs=_needs("box.faces.temperature")),
            Variant("thermal-3d", (_judge_thermal, _Thermal(3)), needs=_needs("box.faces.temperature")),
            Variant("thermal-long", (_judge_thermal, _Thermal(3, 1000.0)), "full", _needs("box.faces.temperature")),
            Variant("seeds", (_judge_seeds, None), needs=_needs("box.faces.temperature")),
            *(
                Variant(
                    f"phase-{law}",
                    (_judge_phase, law),
                    needs=_needs(f"box.faces.random_phase box.faces.random_phase.law={law} box.faces.restitution"),
                )
                for law in ("uniform", "flux")
            ),
        ),
        needs=_needs(""),
        faults=(
            (
                "thermal-3d",
                Fault(
                    "same-draw-along-the-wall",
                    "events/rules.py",
                    "return normal, size * math.cos(angle), size * math.sin(angle)",
                    "return normal, size * math.cos(angle), size * math.cos(angle)",
                    "a thermal wall gives both components along it the same value",
                ),
            ),
            (
                "phase-flux",
                Fault(
                    "flux-without-the-particle",
                    "events/rules.py",
                    "chance * (abs(top) - v) < own - v",
                    "chance * abs(top) < own",
                    "the weight of a phase is the wall's velocity, not that at which they approach",
                ),
            ),
        ),
        interpreted=True,
    ),
)
