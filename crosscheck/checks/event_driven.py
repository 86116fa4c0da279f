"""The event-driven algorithm itself: against its specification, its cost per event, and hard cases."""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, fixed
from crosscheck.convergence import worst
from crosscheck.engines.base import Run
from crosscheck.faults import Fault
from crosscheck.overlaps import wrapped
from crosscheck.references import EPSILON
from crosscheck.scene import (
    Box,
    Cylinder,
    Explicit,
    Face,
    Floats,
    Friction,
    GrainFriction,
    HardSpheres,
    Lattice,
    Method,
    Observable,
    Oscillation,
    Output,
    Scene,
    Well,
    explicit,
)
from crosscheck.statistics import model_comparison, standard_error
from crosscheck.verdict import Figure, Judgement, Series, bounded, round_off

Boundary: TypeAlias = Literal["periodic", "wall", "open", "hard"]

_NAIVE = Method(scheme="event_driven_naive")
_CITATION = "Marin, Risso & Cordero, J. Comput. Phys. 103, 306 (1993); Marin & Cordero, CPC 92, 214 (1995)"
_SOTO = "Soto, Cordero & Risso, SCAT workshop, Valparaiso (2007)"


def spheres(number: int, density: float, seed: int, **more: object) -> Scene:
    """Elastic spheres, or disks with dimension = 2, on a lattice in a periodic box, at temperature 1."""
    entries: dict[str, object] = {
        "name": f"hard-spheres-{number}",
        "dimension": 3,
        "duration": 1.0,
        "hard_spheres": HardSpheres(),
        "box": Box(density=density),
    }
    entries |= more
    start = Lattice(
        kind="lattice",
        structure="fcc" if entries["dimension"] == 3 else "triangular",
        number=number,
        temperature=1.0,
        seed=seed,
    )
    return Scene(**{"initial": start, **entries})  # type: ignore[arg-type]


# -- the specification -----------------------------------------------------------------------------

#: Events that the two algorithms are compared over, and pair collisions in a window of the comparison.
COMPARED = 10_000
_GRAINS = 60
_ROUGH = GrainFriction(tangential_restitution=0.3, static=0.5, sliding=0.4)
_ROUGH_WALL = Friction(tangential_restitution=0.3, static=0.5, sliding=0.4)


def _feature_scenes(dimension: int, seed: int) -> dict[str, Scene]:
    """Scenes that use the features alone and together; the last one all that go together.

    Those that dissipate are shaken, and by a floor that does not dissipate: what settles collides without end.
    """
    d = dimension
    side = (_GRAINS / 0.25) ** (1 / 3) if d == 3 else (_GRAINS / 0.4) ** 0.5
    down = (0.0,) * (d - 1) + (-1.0,)
    floor = "z-" if d == 3 else "y-"
    box = Box(lengths=(side,) * d)
    wrapped: tuple[Boundary, ...] = ("periodic", "periodic", "hard")
    walled = wrapped[3 - d :]
    closed: tuple[Boundary, ...] = ("hard", "hard", "hard")
    around: tuple[Boundary, ...] = ("open", "open", "periodic")
    species = tuple(range(_GRAINS))
    sizes = np.random.default_rng(seed).uniform(0.6, 1.0, _GRAINS).tolist()
    masses = np.random.default_rng(seed + 1).uniform(0.5, 3.0, _GRAINS).tolist()

    def scene(**more: object) -> Scene:
        return spheres(_GRAINS, 0.3, seed, dimension=d, **{"box": box, **more})

    shaken = Face(oscillation=Oscillation(amplitude=0.1, frequency=12.0, phase=0.3))
    rough_shaken = shaken.model_copy(update={"friction": _ROUGH_WALL})
    cylinder = Cylinder(radius=0.5 * side, axis="z" if d == 3 else None, angular_velocity=0.5, friction=_ROUGH_WALL)
    return {
        "bare": scene(),
        "walls": scene(box=Box(lengths=(side,) * d, boundaries=closed[:d], faces={floor: Face(restitution=0.9)})),
        "mixture": scene(masses=tuple(masses), species=species, hard_spheres=HardSpheres(diameter=tuple(sizes))),
        "inelastic-gravity": scene(
            acceleration=down,
            box=Box(lengths=(side,) * d, boundaries=walled, faces={floor: shaken}),
            hard_spheres=HardSpheres(restitution=0.95),
        ),
        "rough": scene(hard_spheres=HardSpheres(restitution=0.95, friction=_ROUGH)),
        "well": scene(hard_spheres=HardSpheres(well=Well(depth=1.0, range=1.5))),
        "drum": scene(
            acceleration=(0.0, -1.0) if d == 2 else (0.0, -1.0, 0.0),
            box=Box(
                lengths=(side,) * d,
                boundaries=around[:d],
                cylinder=cylinder,
            ),
            hard_spheres=HardSpheres(friction=_ROUGH, diameter=0.7),
        ),
        "everything": scene(
            acceleration=down,
            masses=tuple(masses),
            species=species,
            box=Box(lengths=(side,) * d, boundaries=walled, faces={floor: rough_shaken}),
            hard_spheres=HardSpheres(diameter=tuple(sizes), restitution=0.95, friction=_ROUGH),
        ),
    }


_FEATURES = tuple(_feature_scenes(2, 0))


def _judge_specification(laboratory: Laboratory, variant: str) -> Judgement:
    """Windows of a run against algorithm v1.0, started from the run's own state at the window's start."""
    dimension, _, feature = variant.partition("-")
    scene = _feature_scenes(int(dimension[0]), laboratory.seed() % 2**31)[feature]
    trial = laboratory.run(scene.changed(duration=10.0, output=_counted(10.0)), EVENT_DRIVEN)
    rate = (float(trial.tallies["collisions"][-1]) + float(np.sum(trial.tallies["wall_collisions"][-1]))) / 10.0
    # half a collision of each particle in a window: rounding has no time to grow
    window = 0.25 * _GRAINS / rate
    windows = int(np.ceil(COMPARED / (rate * window)))
    run = laboratory.run(scene.changed(duration=windows * window, output=_counted(window)), EVENT_DRIVEN)
    assert run.positions is not None
    assert run.velocities is not None
    apart, compared, counts = 0.0, 0.0, 0
    for k in range(windows):
        spins = None if run.angular_velocities is None else run.angular_velocities[k]
        start = _shifted(scene, float(run.time[k])).changed(
            initial=explicit(wrapped(run.positions[k], scene.periods()), run.velocities[k], spins),
            duration=window,
            output=Output(interval=window, observables=("collisions",)),
        )
        known = laboratory.run(start, _NAIVE, engine="refimpl")
        apart = max(apart, float(np.abs(known.final_velocities - run.velocities[k + 1]).max()))
        counts += int(known.tallies["collisions"][-1] != np.diff(run.tallies["collisions"][k : k + 2])[0])
        compared += float(known.tallies["collisions"][-1]) + float(
            np.sum(run.tallies["wall_collisions"][k + 1] - run.tallies["wall_collisions"][k])
        )
        if counts or not apart < 1e-6 or compared >= COMPARED:  # the rest tells nothing more
            break
    return round_off(
        f"largest difference of a velocity over {k + 1} windows, {compared:.0f} events",
        apart + counts,
        _growth(scene),
        "rounding of positions and times, times five at each of the collisions of a particle in a window (seven at "
        "most), times ten from positions to velocities",
        note="" if not counts else f"the numbers of collisions differ in window {k}",
    )


def _growth(scene: Scene) -> float:
    # a flight l <= 1 after an error d of the position at contact: 2 d l/sigma, with sigma >= 0.6
    lengths = scene.lengths()
    assert lengths is not None
    return float(EPSILON * 4 * lengths.max() * 5.0**7 * 10)


def _counted(interval: float) -> Output:
    return Output(interval=interval, observables=("collisions", "wall_collisions"), trajectory=True)


def _shifted(scene: Scene, time: float) -> Scene:
    """The scene with the phase that its shaken floor has at this time."""
    assert scene.box is not None
    faces = {}
    for name, face in (scene.box.faces or {}).items():
        if face.oscillation is not None:
            phase = (face.oscillation.phase + face.oscillation.frequency * time) % (2 * np.pi)
            face = face.model_copy(update={"oscillation": face.oscillation.model_copy(update={"phase": phase})})
        faces[name] = face
    return scene.changed(box=scene.box.model_copy(update={"faces": faces})) if faces else scene


def _judge_schedulers(laboratory: Laboratory, variant: str) -> Judgement:
    """Final states of two schedulers after 1e5 collisions: not a bit may differ."""
    dimension = int(variant[0])
    scene = spheres(
        1000,
        0.5,
        laboratory.seed() % 2**31,
        dimension=dimension,
        hard_spheres=HardSpheres(restitution=0.999),
        duration=1e6,
        output=Output(collisions=(100_000,), observables=("collisions",)),
    )
    runs = [
        laboratory.run(scene, Method(scheme=f"event_driven{name}"), engine="refimpl")
        for name in ("", "_lists", "_calendar")
    ]
    differing = sum(
        int(np.sum(run.final_positions != runs[0].final_positions) + np.sum(run.time != runs[0].time))
        for run in runs[1:]
    )
    return bounded(
        "numbers that differ between the tree, the lists and the calendar queue",
        float(differing),
        0.0,
        "a pair's time is a function of the two states alone: no scheduler enters, not even by rounding",
        note=f"100000 collisions of 1000 particles, to t = {runs[0].time[-1]:.6g}",
    )


# -- cost ------------------------------------------------------------------------------------------

SIZES = tuple(2**k for k in range(8, 18))
_MARGIN = 10.0
_WHY_MARGIN = (
    "BIC of the next best of the laws minus that of this one; above 10: very strong (Kass & Raftery, J. Am. Stat. "
    "Assoc. 90, 773 (1995))"
)


def _judge_tree(laboratory: Laboratory, variant: str) -> Judgement:
    """Exact comparisons per event against N: which law fits them best."""
    scheme = "event_driven_lists" if variant == "lists" else "event_driven"
    costs, errors, other, times = [], [], [], []
    for number in SIZES:
        scene = spheres(number, 0.5, laboratory.seed() % 2**31, duration=1e6)
        batches = 20
        size = max(number // 4, 500)
        counts = tuple(4 * number + size * k for k in range(batches + 1))
        output = Output(collisions=counts, observables=("operation_counts", "events"))
        run = laboratory.run(scene.changed(output=output), Method(scheme=scheme))
        operations, events = np.diff(run.tallies["operation_counts"][1:], axis=0), np.diff(run.tallies["events"][1:])
        per_event = operations / events[:, None]
        costs.append(per_event[:, 0].mean())
        errors.append(float(standard_error(per_event[:, 0])))
        other.append(per_event[:, 1:3].mean(axis=0))
        times.append(run.cost.cpu / run.cost.events)
    fits = model_comparison(SIZES, costs, errors)
    best = min((name for name in fits if name != "log N"), key=lambda name: fits[name].bic)
    margin = fits[best].bic - fits["log N"].bic
    a, b = fits["log N"].coefficients
    local = np.array(other)
    n = np.array(SIZES, dtype=float)
    figures = (
        Figure(
            "Operations per event against the number of particles",
            "N",
            "operations per event",
            x_scale="log",
            series=(
                Series(f"comparisons, {variant}", list(map(float, SIZES)), [float(c) for c in costs], errors),
                Series(f"{a:.2f} + {b:.3f} ln N", n.tolist(), (a + b * np.log(n)).tolist(), theory=True),
                Series(f"list moves, {variant}", n.tolist(), local[:, 0].tolist()),
                Series(f"pairs examined / 10, {variant}", n.tolist(), (local[:, 1] / 10).tolist()),
            ),
        ),
        Figure(
            "CPU time per event",
            "N",
            "microseconds",
            x_scale="log",
            series=(Series(variant, n.tolist(), [1e6 * t for t in times]),),
        ),
    )
    return bounded(
        f"how much better log N explains the comparisons than {best}",
        float(margin),
        _MARGIN,
        _WHY_MARGIN,
        at_least=True,
        note=f"comparisons = {a:.3f} + {b:.4f} ln N, {b * np.log(2):.3f} a doubling",
        figures=figures,
    )


def _judge_calendar(laboratory: Laboratory, variant: str) -> Judgement:
    """Exact comparisons per event of the calendar queue, the start included: they must not grow."""
    sizes, batches = SIZES[:7], 20
    costs, errors = [], []
    for number in sizes:
        scene = spheres(number, 0.5, laboratory.seed() % 2**31, duration=1e6)
        counts = tuple(10 * number // batches * k for k in range(1, batches + 1))
        output = Output(collisions=counts, observables=("operation_counts", "events"))
        run = laboratory.run(scene.changed(output=output), Method(scheme="event_driven_calendar"))
        comparisons, events = run.tallies["operation_counts"][:, 0], run.tallies["events"]
        costs.append(float(comparisons[-1] / events[-1]))
        later = np.diff(comparisons[1:]) / np.diff(events[1:])  # of equilibrium: the start scatters in no known way
        errors.append(float(standard_error(later)))
    n = np.array(sizes, dtype=float)
    slope, covariance = np.polyfit(np.log2(n), costs, 1, w=1 / np.array(errors), cov="unscaled")
    return bounded(
        "growth of the comparisons per event at each doubling of N",
        float(slope[0]),
        3 * float(np.sqrt(covariance[0, 0])),
        "three standard errors of the slope, one-sided: false alarm 0.1 %; a tree adds one comparison",
        note=f"{costs[0]:.3f} comparisons per event at N = {sizes[0]}, {costs[-1]:.3f} at {sizes[-1]}",
        figures=(
            Figure(
                "Comparisons per event of the calendar queue",
                "N",
                "comparisons per event",
                x_scale="log",
                series=(Series("calendar", n.tolist(), costs, errors),),
            ),
        ),
    )


def _judge_naive(laboratory: Laboratory, variant: str) -> Judgement:
    """CPU time per event of algorithm v1.0 against N."""
    sizes = (128, 256, 512, 1024, 2048)
    times, errors = [], []
    for number in sizes:
        scene = spheres(number, 0.5, laboratory.seed() % 2**31, duration=1e6)
        taken = []
        for _ in range(5):
            output = Output(collisions=(200_000 // number,), observables=("collisions",))
            run = laboratory.run(scene.changed(output=output), _NAIVE)
            taken.append(run.cost.cpu / run.cost.events)
        times.append(float(np.median(taken)))
        errors.append(float(standard_error(taken)) + 0.01 * times[-1])
    fits = model_comparison(sizes, times, errors, laws=("constant", "log N", "N", "N^2"))
    best = min((name for name in fits if name != "N^2"), key=lambda name: fits[name].bic)
    slope, covariance = np.polyfit(np.log(sizes[1:]), np.log(times[1:]), 1, cov="unscaled")
    spread = 1.96 * float(np.sqrt(covariance[0, 0])) * float(np.max(np.array(errors) / np.array(times)))
    return bounded(
        f"how much better N^2 explains the time per event than {best}",
        float(fits[best].bic - fits["N^2"].bic),
        _MARGIN,
        _WHY_MARGIN,
        at_least=True,
        note=f"exponent {slope[0]:.3f} +- {spread:.3f} (95 %) between N = {sizes[1]} and {sizes[-1]}",
        figures=(
            Figure(
                "CPU time per event, naive",
                "N",
                "microseconds",
                x_scale="log",
                y_scale="log",
                series=(Series("v1.0", list(map(float, sizes)), [1e6 * t for t in times], [1e6 * e for e in errors]),),
            ),
        ),
    )


# -- hard cases ------------------------------------------------------------------------------------


def _overlap(scene: Scene, positions: Floats) -> float:
    """Deepest overlap of two particles, in mean diameters; 0 for none."""
    from scipy.spatial import cKDTree

    lengths, sizes = scene.lengths(), scene.diameters()
    assert lengths is not None
    assert sizes is not None
    periods = scene.periods()
    x = wrapped(positions, periods)
    pairs = cKDTree(x, boxsize=periods).query_pairs(float(sizes.max()), output_type="ndarray")
    if not len(pairs):
        return 0.0
    gap = x[pairs[:, 0]] - x[pairs[:, 1]]
    gap -= periods * np.round(gap / lengths)
    touch = 0.5 * (sizes[pairs[:, 0]] + sizes[pairs[:, 1]])
    return float(max(0.0, (touch - np.linalg.norm(gap, axis=1)).max()) / sizes.mean())


def _energy_error(run: Run) -> float:
    assert run.kinetic_energy is not None
    return float(np.abs(run.kinetic_energy / run.kinetic_energy[0] - 1).max())


def _sound(scene: Scene, run: Run, what: str, elastic: bool = True) -> Judgement:
    """Nobody overlaps at a sample or a collision, and the energy of elastic grains is kept, but for rounding."""
    lengths, sizes = scene.lengths(), scene.diameters()
    assert run.positions is not None
    assert lengths is not None
    assert sizes is not None
    deepest = max(_overlap(scene, positions) for positions in run.positions)
    # positions lie on a grid of 2^-51 of the box, and times are rounded to it over a flight
    rounding = 32 * EPSILON * float(lengths.max() / sizes.min())
    # a sample is not wrapped: what has gone far is rounded as coarsely
    coarse = 32 * EPSILON * float(max(lengths.max(), np.abs(run.positions).max()) / sizes.mean())
    struck = float(run.tallies["deepest_overlap"][-1])
    judgements = [
        round_off(f"{what}: deepest overlap, in diameters", deepest, coarse, "32 roundings of a coordinate"),
        # who was not seen in time is struck too deep
        round_off(f"{what}: deepest overlap at a collision", struck, rounding, "32 roundings of a coordinate"),
    ]
    if elastic:
        collisions = float(run.tallies["collisions"][-1])
        judgements.append(
            round_off(
                f"{what}: relative change of the energy",
                _energy_error(run),
                4 * EPSILON * max(1.0, 2 * collisions / scene.number),
                "four roundings at each collision of a particle, all to one side: rounding has a bias, docs/events.md",
            )
        )
    if run.stopped:
        judgements.append(bounded(f"{what}: {run.stopped}", 1.0, 0.0, "the run goes on to its end"))
    return worst(judgements, f"{run.tallies['collisions'][-1]:.0f} collisions")


_RECORD: tuple[Observable, ...] = ("kinetic_energy", "collisions", "deepest_overlap")


def _recorded(samples: int, duration: float) -> Output:
    return Output(interval=duration / samples, observables=_RECORD, trajectory=True)


def _judge_grazing(laboratory: Laboratory) -> Judgement:
    """Pairs that miss or touch by a part in 1e3 ... 1e13: a collision if and only if they come closer than sigma."""
    wrong = 0
    ladder = [sign * 10.0**-k for k in range(3, 14) for sign in (-1, 1)]
    for miss in ladder:
        scene = spheres(
            2,
            1.0,
            1,
            box=Box(lengths=(40.0, 40.0, 40.0)),
            initial=Explicit(
                positions=((10.0, 20.0, 20.0), (20.0, 21.0 + miss, 20.0)), velocities=((1.0, 0.0, 0.0), (0.0, 0.0, 0.0))
            ),
            duration=20.0,
            output=Output(interval=20.0, observables=_RECORD, trajectory=True),
        )
        run = laboratory.run(scene, EVENT_DRIVEN)
        wrong += int(run.tallies["collisions"][-1] != (miss < 0))
    return bounded("grazing pairs judged wrongly", float(wrong), 0.0, f"{len(ladder)} pairs, a hit below sigma alone")


def _judge_cradle(laboratory: Laboratory) -> Judgement:
    """Newton's cradle: a row of touching disks passes the velocity on to the last one, at once."""
    row = 20
    positions = tuple((3.0 + 1.0 * k + (0.0 if k else -1.5), 5.0) for k in range(row))
    velocities = tuple((1.0 if k == 0 else 0.0, 0.0) for k in range(row))
    scene = spheres(
        row,
        1.0,
        1,
        dimension=2,
        box=Box(lengths=(60.0, 10.0)),
        initial=Explicit(positions=positions, velocities=velocities),
        duration=10.0,
        output=_recorded(2, 10.0),
    )
    run = laboratory.run(scene, EVENT_DRIVEN)
    expected = np.zeros((row, 2))
    expected[-1, 0] = 1.0
    return worst(
        [
            round_off(
                "velocity that is not the last disk's",
                float(np.abs(run.final_velocities - expected).max()),
                4 * row * EPSILON,
                "four roundings at each of the impacts of the row",
            ),
            bounded("impacts beyond one a pair", float(run.tallies["collisions"][-1]) - (row - 1), 0.0, "exact"),
        ],
        "20 touching disks",
    )


def _judge_simultaneous(laboratory: Laboratory) -> Judgement:
    """A square lattice whose columns all close in on each other: N/2 impacts at one time, again and again."""
    side = 32
    grid = np.stack(np.meshgrid(np.arange(side), np.arange(side), indexing="ij"), axis=-1).reshape(-1, 2)
    velocities = np.zeros_like(grid, dtype=float)
    velocities[:, 0] = np.where(grid[:, 0] % 2 == 0, 1.0, -1.0)
    scene = spheres(
        side * side,
        1.0,
        1,
        dimension=2,
        box=Box(lengths=(1.5 * side, 1.5 * side)),
        initial=explicit(1.5 * grid + 0.75, velocities),
        duration=10.0,
        output=_recorded(10, 10.0),
    )
    run = laboratory.run(scene, EVENT_DRIVEN)
    # a pair closes its gap of 1/2 at relative speed 2, then goes back through the next gap
    expected = side * side / 2 * int((10.0 + 0.25) / 0.5)
    return worst(
        [
            _sound(scene, run, "columns"),
            bounded("impacts too many or few", abs(float(run.tallies["collisions"][-1]) - expected), 0.0, "exact"),
        ],
        "1024 disks",
    )


def _judge_crystal(laboratory: Laboratory, dimension: int, fraction: float) -> Judgement:
    """A crystal at the highest packing: many collisions in a small room."""
    if dimension == 3:
        number, scene = 500, spheres(500, 1.0, laboratory.seed() % 2**31, box=Box(packing_fraction=fraction))
    else:
        # rows of a triangular lattice: the box keeps its shape
        columns, rows = 24, 28
        number = columns * rows
        spacing = float(np.sqrt(np.pi / (2 * np.sqrt(3) * fraction)))
        box = Box(lengths=(columns * spacing, rows * spacing * 3**0.5 / 2))
        scene = spheres(number, 1.0, laboratory.seed() % 2**31, dimension=2, box=box)
    counts = tuple(number * 20 * k for k in range(1, 11))
    output = Output(collisions=counts, observables=_RECORD, trajectory=True)
    run = laboratory.run(scene.changed(duration=1e4, output=output), EVENT_DRIVEN)
    return _sound(scene, run, f"packing fraction {fraction}")


def _judge_ratio(laboratory: Laboratory, sizes: tuple[float, float], masses: tuple[float, float]) -> Judgement:
    """A few large, heavy disks among many small, light ones."""
    rng = np.random.default_rng(laboratory.seed())
    big, side = 4, 4.2 * sizes[0]
    small = min(2000, int(0.25 * side**2))
    box = np.array([side, side])
    large = np.array([[1.0, 1.0], [3.2, 1.0], [1.0, 3.2], [3.2, 3.2]]) * side / 4.2
    spots = [*large]
    diameters = np.array([sizes[0]] * big + [sizes[1]] * small)
    grid = int(side / 1.05)
    for cell in rng.permutation(grid * grid):
        if len(spots) == big + small:
            break
        spot = (np.array(divmod(int(cell), grid)) + 0.5) * side / grid
        gap = large - spot
        gap -= box * np.round(gap / box)
        if np.linalg.norm(gap, axis=1).min() > 0.5 * (sizes[0] + sizes[1]):
            spots.append(spot)
    scene = spheres(
        len(spots),
        1.0,
        1,
        dimension=2,
        box=Box(lengths=(side, side)),
        species=tuple([0] * big + [1] * (len(spots) - big)),
        masses=tuple([masses[0]] * big + [masses[1]] * (len(spots) - big)),
        hard_spheres=HardSpheres(diameter=sizes),
        initial=explicit(np.array(spots), rng.normal(size=(len(spots), 2)) / np.sqrt(diameters)[:, None]),
        duration=1e4,
        output=Output(collisions=tuple(2000 * k for k in range(1, 11)), observables=_RECORD, trajectory=True),
    )
    return _sound(scene, laboratory.run(scene, EVENT_DRIVEN), f"sizes {sizes}, masses {masses}")


def _judge_dead(laboratory: Laboratory) -> Judgement:
    """Restitution 0, with the TC model: pairs that stay in contact, and clusters of them."""
    scene = spheres(
        400,
        0.3,
        laboratory.seed() % 2**31,
        dimension=2,
        hard_spheres=HardSpheres(restitution=0.0, contact_duration=1e-4),
        duration=1e9,
        output=Output(collisions=tuple(2000 * k for k in range(1, 11)), observables=_RECORD, trajectory=True),
    )
    return _sound(scene, laboratory.run(scene, EVENT_DRIVEN), "restitution 0", elastic=False)


#: Collisions of the long run: about 1e8 events with the passages between cells.
LONG = 70_000_000


def _judge_long(laboratory: Laboratory) -> Judgement:
    """1e8 events: overlaps at 4000 samples and at every collision, and the energy."""
    samples = 4000
    scene = spheres(
        256,
        0.5,
        laboratory.seed() % 2**31,
        duration=1e9,
        output=Output(collisions=tuple(LONG // samples * k for k in range(1, samples + 1)), observables=_RECORD,
                      trajectory=True),
    )  # fmt: skip
    return _sound(scene, laboratory.run(scene, EVENT_DRIVEN), "1e8 events")


def _judge_clock(laboratory: Laboratory) -> Judgement:
    """Two disks that meet every 1000 units of time, to t = 1e9: the time of each collision is known in closed form."""
    length, duration = 1000.0, 1e9
    start = spheres(
        2,
        1.0,
        1,
        dimension=2,
        box=Box(lengths=(length, 10.0), boundaries=("hard", "periodic")),
        initial=Explicit(positions=((250.25, 5.0), (749.75, 5.0)), velocities=((1.0, 0.0), (-1.0, 0.0))),
        duration=duration,
        output=Output(interval=duration / 10, observables=_RECORD, trajectory=True),
    )
    run = laboratory.run(start, EVENT_DRIVEN)
    assert run.positions is not None
    # equal disks exchange velocities: each runs to and fro between its wall and the middle, 499 long, speed 1
    room = (length - 2.0) / 2
    phase = (run.time + 249.75) % (2 * room)
    expected = 0.5 + np.where(phase < room, phase, 2 * room - phase)
    error = np.abs(run.positions[:, 0, 0] - expected).max()
    flights = duration / room
    return round_off(
        "error of a position at t = 1e9",
        float(error),
        float(4 * EPSILON * length * np.sqrt(flights) * 10 + EPSILON * duration),
        "four roundings of a coordinate at each of 2e6 impacts, as a random walk, tenfold; one of the sample's time",
    )


_CASES = {
    "grazing": _judge_grazing,
    "cradle": _judge_cradle,
    "simultaneous": _judge_simultaneous,
    "packing-0.70-3d": lambda laboratory: _judge_crystal(laboratory, 3, 0.70),
    "packing-0.88-2d": lambda laboratory: _judge_crystal(laboratory, 2, 0.88),
    "size-ratio-50": lambda laboratory: _judge_ratio(laboratory, (50.0, 1.0), (50.0, 1.0)),
    "mass-ratio-1e6": lambda laboratory: _judge_ratio(laboratory, (5.0, 1.0), (1e6, 1.0)),
    "restitution-0": _judge_dead,
    "long": _judge_long,
    "clock": _judge_clock,
}


def _judge_case(laboratory: Laboratory, variant: str) -> Judgement:
    return _CASES[variant](laboratory)


_LINEAR = """        def scan(queue: Any, counts: Any) -> int:
            number = queue.keys.size // 2
            found = 0
            for k in range(1, number):
                tick(counts, COMPARISONS, 1)
                if queue.keys[number + k] < queue.keys[number + found]:
                    found = k
            return np.int64(found)

        return scan"""

LINEAR_SCAN = Fault(
    "linear-scan",
    "events/kernels/schedule.py",
    "        return lambda queue, counts: np.int64(queue.nodes[1])",
    _LINEAR,
    "the earliest event is looked for in a row, not in the tree",
)

CHECKS = (
    Check(
        name="events/specification",
        title="The fast algorithm against the naive one, over 10000 events, feature by feature",
        equation="predict all pairs, take the earliest, advance everybody, collide (v1.0)",
        criterion="same collisions; velocities to rounding and its growth over half a collision a particle",
        citation=_SOTO,
        judge=_judge_specification,
        variants=fixed(*(f"{d}d-{feature}" for d in (2, 3) for feature in _FEATURES)),
        faults=(
            (
                "3d-bare",
                Fault(
                    "stale-partner",
                    "events/kernels/loop.py",
                    "if ints[j, COUNT] != ints[i, PARTNER_COUNT]:",
                    "if ints[j, COUNT] > ints[i, PARTNER_COUNT] + 1:",
                    "an event whose partner has collided once since is taken for valid",
                ),
            ),
            (
                "2d-mixture",
                Fault(
                    "half-contact-distance",
                    "events/kernels/loop.py",
                    "size = contact_distance(diameter, radii, i, j)\n        c =",
                    "size = 0.999 * contact_distance(diameter, radii, i, j)\n        c =",
                    "the cells' prediction takes particles for smaller by a thousandth",
                ),
            ),
        ),
        tier="full",
    ),
    Check(
        name="events/schedulers",
        title="The tree, the documented lists and the calendar queue give the same events",
        equation="t_ij = f(r_i, v_i, tau_i, r_j, v_j, tau_j)",
        criterion="not one bit of the state differs after 100000 collisions",
        citation=f"{_CITATION}; Brown, Commun. ACM 31, 1220 (1988); Paul, J. Comput. Phys. 221, 615 (2007)",
        judge=_judge_schedulers,
        variants=fixed("3d", "2d"),
        faults=(
            (
                "3d",
                Fault(
                    "calendar-bucket",
                    "events/kernels/schedule.py",
                    "if queue.day[i] <= today:",
                    "if queue.day[i] <= today + 8 * queue.heads.size:",
                    "the calendar takes events of later rounds for today's",
                ),
            ),
        ),
        tier="full",
    ),
    Check(
        name="events/cost",
        title="Operations per event against the number of particles: O(log N)",
        equation="comparisons per event = a + b ln N",
        criterion=f"log N explains the exact counts better than constant, sqrt N and N: BIC by {_MARGIN:g} at least",
        citation=_CITATION,
        judge=_judge_tree,
        variants=fixed("tree", "lists"),
        faults=(
            (
                "tree",
                LINEAR_SCAN,
            ),
        ),
        tier="full",
        timing=True,
    ),
    Check(
        name="events/cost-calendar",
        title="Comparisons per event of the calendar queue against the number of particles: O(1)",
        equation="comparisons per event = a",
        criterion="from the start on, no growth with N beyond three standard errors",
        citation="Brown, Commun. ACM 31, 1220 (1988); Paul, J. Comput. Phys. 221, 615 (2007)",
        judge=_judge_calendar,
        variants=fixed("spheres"),
        faults=(
            (
                "spheres",
                Fault(
                    "wake-by-queue",
                    "events/kernels/loop.py",
                    "if unpredicted < rows.shape[0]:",
                    "if unpredicted < 0:",
                    "the queue is asked who wakes next: all N wait in one bucket",
                ),
            ),
        ),
        tier="full",
    ),
    Check(
        name="events/cost-naive",
        title="Time per event of the naive algorithm: O(N^2)",
        equation="t = a + b N^2",
        criterion=f"N^2 explains the CPU time better than constant, log N and N: BIC by {_MARGIN:g} at least",
        citation=_SOTO,
        judge=_judge_naive,
        variants=fixed("v1.0"),
        faults=(
            (
                "v1.0",
                Fault(
                    "few-partners",
                    "events/naive.py",
                    "for j in range(i + 1, rows.shape[0]):",
                    "for j in range(i + 1, min(i + 9, rows.shape[0])):",
                    "only eight partners are looked at: linear, and wrong",
                ),
            ),
        ),
        tier="full",
        timing=True,
    ),
    Check(
        name="events/robustness",
        title="Hard cases: grazing, simultaneous, dense, unequal, dead, long",
        equation="|r_i - r_j| >= sigma_ij at all times; sum m v^2/2 = const for elastic grains",
        criterion="overlaps, energies and closed forms to rounding",
        citation="Luding & McNamara, Granular Matter 1, 113 (1998); Lubachevsky, J. Comput. Phys. 94, 255 (1991)",
        judge=_judge_case,
        variants=fixed(*_CASES),
        faults=(
            (
                "packing-0.70-3d",
                Fault(
                    "missed-neighbours",
                    "events/kernels/loop.py",
                    "x0, x1, y0, y1, z0, z1 = cx - 1, cx + 1,",
                    "x0, x1, y0, y1, z0, z1 = cx - 1, cx,",
                    "particles in the cells to the right are not seen",
                ),
            ),
            (
                "clock",
                Fault(
                    "clock-in-single-steps",
                    "events/simulation.py",
                    "            self._base = _two_sum(*self._base, shift)",
                    "            self._base = (self._base[0] + shift * (1 + 1e-12), 0.0)",
                    "the base of the clock runs ahead by a part in 1e12",
                ),
            ),
        ),
        tier="full",
    ),
)
