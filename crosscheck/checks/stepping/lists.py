"""Neighbour lists in use: energies at every step of runs in which pairs come and go, by sums over all pairs.

A run that records states may make its lists anew for each of them. So the energies are recorded without states, and
compared with those along the path that the scheme's recurrence takes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.stepping.audit import (
    Expected,
    Ledger,
    asking,
    audit_energies,
    audit_samples,
    audit_steps,
    run_or_refuse,
)
from crosscheck.checks.stepping.faults import STALE_LISTS
from crosscheck.engines.capabilities import Needs, words
from crosscheck.faults import Fault
from crosscheck.scene import Box, LennardJones, Method, Scene, explicit
from crosscheck.verdict import Judged

_SCHEME = "velocity_verlet"


class Motion(NamedTuple):
    """A scene in which pairs come and go.

    dt: time step. steps: of the run. every: steps between recorded states. scheme: by which it moves. again: steps that
    an engine may take again since its lists are too small.
    """

    scene: Scene
    dt: float
    steps: int
    every: int
    scheme: str = _SCHEME
    again: int = 0


def _grid(rng: np.random.Generator, counts: tuple[int, ...], spacing: float) -> np.ndarray:
    """Places of a lattice, each displaced by up to 0.12 of its spacing, (N, d)."""
    places = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, len(counts)) + 0.5
    return np.asarray((places + rng.uniform(-0.12, 0.12, places.shape)) * spacing)


def _scene(name: str, sides: tuple[float, ...], x: np.ndarray, v: np.ndarray, **entries: object) -> Scene:
    given = {"lennard_jones": LennardJones(cutoff=2.2), "box": Box(lengths=sides), **entries}
    return Scene(name=name, dimension=len(sides), duration=0.0, initial=explicit(x, v), **given)  # type: ignore[arg-type]


def _motions() -> dict[str, Motion]:
    rng = np.random.default_rng(21)
    # rows that stream past each other, on top of a drift through the box: pairs meet that no list held before
    flat = _grid(rng, (9, 3), 1.25)
    against = np.where(flat[:, 1:] // 1.25 == 1, -1.0, 1.0) * (14.0, 0.0) + (7.0, 2.0)
    streams = _scene("streams", (11.3, 3.9), flat, against)
    block = _grid(rng, (2, 6, 2), 1.3)
    turn = np.where(block[:, 2:] // 1.3 == 1, -1.0, 1.0) * (0.0, 17.0, 0.0) + (-5.0, 3.0, 0.0)
    slab = _scene(
        "slab",
        (2.6, 7.9, 5.2),
        block,
        turn,
        box=Box(lengths=(2.6, 7.9, 5.2), boundaries=("periodic", "periodic", "open")),
    )
    # layers that part along an open axis, while pairs meet along the others: the grid of cells grows with them
    parting = slab.changed(name="parting", initial=explicit(block, turn * 0.5 + (block - 1.3) * (0.0, 0.0, 40.0)))
    # so fast along x that their grid needs more room than was laid out for it
    flight = parting.changed(
        name="flight",
        box=Box(lengths=(5.2, 7.9, 2.6), boundaries=("open", "periodic", "periodic")),
        initial=explicit(block[:, ::-1], (turn * 0.5 + (block - 1.3) * (0.0, 0.0, 8000.0))[:, ::-1]),
    )
    # one particle crosses the box half-way between two rows of others
    rows = np.array([[0.7 + 1.3 * i, y] for y in (0.8, 3.2) for i in range(12)] + [[0.3, 2.03]])
    speed = np.zeros_like(rows)
    speed[-1] = 57.0, 0.0
    fast = _scene("fast", (15.9, 9.6), rows, speed, lennard_jones=LennardJones(cutoff=1.7))
    # two pairs in a box like a thread: a grid of cubes would have more cells than there is room for
    middles, way = np.array([[1.0, 40.0, 1.5], [3.0, 3980.0, 2.5]]), np.array([[0.3, 0.4, 0.3], [0.4, -0.3, 0.35]])
    pairs = np.concatenate([middles + way, middles - way])
    thread = _scene("thread", (4.0, 4000.0, 4.5), pairs, np.concatenate([way, -way]) * 3.0)
    # far apart in a wide box, and on their way to one place: lists outgrow their memory in mid-run
    sparse = _grid(rng, (4, 4, 4), 4.2)
    species = tuple(i % 2 for i in range(len(sparse)))
    closing = _scene(
        "closing",
        (190.0, 180.0, 170.0),
        sparse,
        (8.4 - sparse) * 7.0,
        species=species,
        masses=tuple(1.0 + 0.03 * i for i in range(len(sparse))),
        lennard_jones=LennardJones(cutoff=2.6, epsilon=(1.0, 0.5), length=(1.0, 0.85), truncation="shifted"),
    )
    dense = _grid(rng, (4, 4, 4), 1.15)
    kinds = tuple(i % 2 for i in range(len(dense)))
    drop = closing.changed(
        name="drop", species=kinds, masses=1.0, initial=explicit(dense + 3.0, rng.normal(scale=25.0, size=dense.shape))
    )
    return {
        "streams": Motion(streams, 0.004, 36, 9),
        "slab": Motion(slab, 0.004, 32, 8),
        "parting": Motion(parting, 0.004, 32, 8),
        "flight": Motion(flight, 0.004, 16, 8),
        "fast-particle": Motion(fast, 0.004, 36, 12),
        "thread": Motion(thread, 0.004, 6, 3),
        "closing-in": Motion(closing, 0.0095, 10, 5),
        "drop": Motion(drop, 0.004, 2, 1),
        # lists outgrow their memory where the energies of the start are asked for, and in the first of two evaluations
        "drop-euler": Motion(drop, 0.004, 1, 1, "euler"),
        "drop-beeman": Motion(drop, 0.004, 1, 1, "beeman"),
        # and, in mid-run, where the energies of a state are asked for before its forces are: a step is taken again
        "closing-in-euler": Motion(closing, 0.0095, 10, 5, "modified_euler", 2),
    }


def _judge(laboratory: Laboratory, motion: Motion) -> Judged:
    scene, dt, steps, every, scheme, _ = motion
    scene, method = scene.changed(duration=steps * dt), Method(scheme=scheme, dt=dt)
    ledger = Ledger()
    silent = asking(laboratory.engine, scene, dt, trajectory=False)
    run = run_or_refuse(laboratory, ledger, silent, method)
    if run is not None:
        expected = Expected(scene, scheme, dt, steps)
        audit_energies(ledger, silent, expected, run, 1, "no states recorded")
        audit_steps(ledger, expected, run, steps, 1, "no states recorded", motion.again)
        recorded = asking(laboratory.engine, scene, every * dt)
        run = laboratory.run(recorded, method)
        audit_samples(ledger, recorded, run, f"every {every} steps")
        audit_steps(ledger, expected, run, steps, every, f"every {every} steps", motion.again)
    return ledger.findings()


def _needs(motion: Motion) -> Needs:
    return Needs("lennard_jones", words=words(motion.scene), schemes=(motion.scheme,))


_LISTS = "stepping/kernels/neighbours.py"

CHECKS = (
    Check(
        name="stepping/lennard-jones-lists",
        title="Energies at every step while pairs come and go: streams, parting layers, a closing cloud",
        equation="U, W, K at r_n, v_n of velocity Verlet, by sums over all pairs and images",
        criterion="each within bounds of rounding: of coordinates, terms and sums, and of velocity Verlet in doubles",
        citation="Verlet, Phys. Rev. 159, 98 (1967); Allen & Tildesley, Computer Simulation of Liquids (1987), 5.3",
        judge=_judge,
        # "parting" has all that "slab" has, and more
        variants=tuple(
            Variant(name, motion, "full" if name == "slab" else "quick", _needs(motion))
            for name, motion in _motions().items()
        ),
        faults=(
            ("streams", STALE_LISTS),
            (
                "streams",
                Fault(
                    "list-of-twice-the-skin",
                    _LISTS,
                    "limit2 = (0.5 * CLOSE * SAFE * neighbours.skin) ** 2",
                    "limit2 = (2.0 * CLOSE * SAFE * neighbours.skin) ** 2",
                    "the close lists are kept until a particle has moved twice their skin",
                ),
            ),
            (
                "drop",
                Fault(
                    "slots-without-species",
                    "stepping/forces/lennard_jones.py",
                    "counters=force.counters.copy())",
                    "counters=force.counters)",
                    "after the lists of a mixture have been enlarged, particles have no size",
                ),
            ),
        ),
        needs=Needs("lennard_jones"),
        interpreted=True,
    ),
)
