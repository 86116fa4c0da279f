"""Hard cases of event-driven hard spheres: grazing, simultaneous, dense, unequal, perfectly inelastic, long."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TypeAlias

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, variants_of
from crosscheck.checks.events.gases import event_driven, spheres
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.references.hard_walls import between_walls
from crosscheck.scene import Box, Explicit, Floats, HardSpheres, Observable, Output, Scene, explicit
from crosscheck.scene.overlaps import wrapped
from crosscheck.verdict import Judged, bounded, round_off, worst


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


def _overlaps_and_energy(scene: Scene, run: Run, what: str, elastic: bool = True) -> Judged:
    """No overlap at a sample or a collision, and the energy of elastic grains is kept, but for rounding."""
    lengths, sizes = scene.lengths(), scene.diameters()
    assert lengths is not None
    assert sizes is not None
    deepest = max(_overlap(scene, positions) for positions in run["positions"])
    # positions are kept on a grid of 2^-51 of the box, and times are rounded to it over a flight
    rounding = 32 * EPSILON * float(lengths.max() / sizes.min())
    # samples are unwrapped: a position far from the box is rounded more coarsely
    coarse = 32 * EPSILON * float(max(lengths.max(), np.abs(run["positions"]).max()) / sizes.mean())
    struck = float(run["deepest_overlap"][-1])
    judgements = [
        round_off(f"{what}: deepest overlap, in diameters", deepest, coarse, "32 roundings of a coordinate"),
        # a missed collision shows as a deep overlap
        round_off(f"{what}: deepest overlap at a collision", struck, rounding, "32 roundings of a coordinate"),
    ]
    if elastic:
        collisions = float(run["collisions"][-1])
        judgements.append(
            round_off(
                f"{what}: relative change of the energy",
                float(np.abs(run["kinetic_energy"] / run["kinetic_energy"][0] - 1).max()),
                4 * EPSILON * max(1.0, 2 * collisions / scene.number),
                "four roundings at each collision of a particle, all to one side: rounding has a bias, docs/events.md",
            )
        )
    return worst(judgements, f"{run['collisions'][-1]:.0f} collisions")


_RECORD: tuple[Observable, ...] = ("kinetic_energy", "collisions", "deepest_overlap")


def _recorded(samples: int, duration: float) -> Output:
    return Output(interval=duration / samples, observables=_RECORD, trajectory=True)


def _judge_grazing(laboratory: Laboratory) -> Judged:
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
        wrong += int(run["collisions"][-1] != (miss < 0))
    return bounded(
        "grazing pairs with a wrong number of collisions",
        float(wrong),
        0.0,
        f"{len(ladder)} pairs, a collision only below sigma",
    )


def _judge_cradle(laboratory: Laboratory) -> Judged:
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
                float(np.abs(run["final_velocities"] - expected).max()),
                4 * row * EPSILON,
                "four roundings at each of the impacts of the row",
            ),
            bounded("impacts beyond one a pair", float(run["collisions"][-1]) - (row - 1), 0.0, "exact"),
        ],
        "20 touching disks",
    )


def _judge_simultaneous(laboratory: Laboratory) -> Judged:
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
            _overlaps_and_energy(scene, run, "columns"),
            bounded("impacts too many or few", abs(float(run["collisions"][-1]) - expected), 0.0, "exact"),
        ],
        "1024 disks",
    )


def _judge_crystal(laboratory: Laboratory, dimension: int, fraction: float) -> Judged:
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
    return _overlaps_and_energy(scene, run, f"packing fraction {fraction}")


def _judge_ratio(laboratory: Laboratory, sizes: tuple[float, float], masses: tuple[float, float]) -> Judged:
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
    return _overlaps_and_energy(scene, laboratory.run(scene, EVENT_DRIVEN), f"sizes {sizes}, masses {masses}")


def _judge_plastic(laboratory: Laboratory) -> Judged:
    """Restitution 0, with the TC model (Luding & McNamara 1998): pairs that stay in contact, and clusters of them."""
    scene = spheres(
        400,
        0.3,
        laboratory.seed() % 2**31,
        dimension=2,
        hard_spheres=HardSpheres(restitution=0.0, contact_duration=1e-4),
        duration=1e9,
        output=Output(collisions=tuple(2000 * k for k in range(1, 11)), observables=_RECORD, trajectory=True),
    )
    return _overlaps_and_energy(scene, laboratory.run(scene, EVENT_DRIVEN), "restitution 0", elastic=False)


#: Collisions of the long run: about 1e8 events with the passages between cells.
LONG = 70_000_000


def _judge_long(laboratory: Laboratory) -> Judged:
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
    return _overlaps_and_energy(scene, laboratory.run(scene, EVENT_DRIVEN), "1e8 events")


def _judge_clock(laboratory: Laboratory) -> Judged:
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
    # equal disks exchange velocities: each runs to and fro between its wall and the middle, 499 long, speed 1
    room = (length - 2.0) / 2
    expected = 0.5 + between_walls(run["time"] + 249.75, room)
    error = np.abs(run["positions"][:, 0, 0] - expected).max()
    flights = duration / room
    return round_off(
        "error of a position at t = 1e9",
        float(error),
        float(4 * EPSILON * length * np.sqrt(flights) * 10 + EPSILON * duration),
        "four roundings of a coordinate at each of 2e6 impacts, as a random walk, tenfold; one of the sample's time",
    )


#: What each variant judges.
Case: TypeAlias = Callable[[Laboratory], Judged]
_CASES: dict[str, Case] = {
    "grazing": _judge_grazing,
    "cradle": _judge_cradle,
    "simultaneous": _judge_simultaneous,
    "packing-0.70-3d": partial(_judge_crystal, dimension=3, fraction=0.70),
    "packing-0.88-2d": partial(_judge_crystal, dimension=2, fraction=0.88),
    "size-ratio-50": partial(_judge_ratio, sizes=(50.0, 1.0), masses=(50.0, 1.0)),
    "mass-ratio-1e6": partial(_judge_ratio, sizes=(5.0, 1.0), masses=(1e6, 1.0)),
    "restitution-0": _judge_plastic,
    "long": _judge_long,
    "clock": _judge_clock,
}


def _judge(laboratory: Laboratory, case: Case) -> Judged:
    return case(laboratory)


CHECKS = (
    Check(
        name="events/robustness",
        title="Hard cases: grazing, simultaneous, dense, unequal, perfectly inelastic, long",
        equation="|r_i - r_j| >= sigma_ij at all times; sum m v^2/2 = const for elastic grains",
        criterion="overlaps, energies and closed forms to rounding",
        citation="Luding & McNamara, Granular Matter 1, 113 (1998); Lubachevsky, J. Comput. Phys. 94, 255 (1991)",
        judge=_judge,
        variants=variants_of(_CASES, "full"),
        needs=event_driven("box.boundaries=periodic", "positions velocities kinetic_energy collisions deepest_overlap"),
        faults=(
            (
                "packing-0.70-3d",
                Fault(
                    "missed-neighbours",
                    "events/kernels/loop.py",
                    "x0, x1, y0, y1, z0, z1 = cx - 1, cx + 1,",
                    "x0, x1, y0, y1, z0, z1 = cx - 1, cx,",
                    "particles in the cells to the right are not searched",
                ),
            ),
            (
                "clock",
                Fault(
                    "clock-in-single-steps",
                    "events/simulation.py",
                    "        self._base = two_sum(*self._base, shift)",
                    "        self._base = (self._base[0] + shift * (1 + 1e-12), 0.0)",
                    "the base of the clock runs ahead by a part in 1e12",
                ),
            ),
        ),
    ),
)
