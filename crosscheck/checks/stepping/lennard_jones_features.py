"""Lennard-Jones scenes in which every pair of features occurs: each judged by sums over all pairs, step by step.

`FACTORS` are the features with their levels, the first one of each its absence; `rows` combines them.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from crosscheck.checks.base import Check, FeatureRows
from crosscheck.checks.stepping.audit import Features, audit_rows, parts_of
from crosscheck.checks.stepping.faults import pair_fault
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.pairs import Pair, Row
from crosscheck.scene import Box, Floats, LennardJones, Scene, Wall, explicit

#: Features of scenes of Lennard-Jones particles and their levels.
FACTORS: dict[str, tuple[str, ...]] = {
    "dimension": ("3", "2"),
    "boundaries": (
        *("periodic", "open", "open first", "open last", "open middle"),
        *("walls", "wall first", "wall middle", "wall last"),
    ),
    # of the first or last periodic axis, in cutoffs: below two, a pair may meet twice; below one, a particle itself
    "shortest side": ("long", "first < 2", "last < 2", "first < 1", "last < 1"),
    "truncation": ("truncated", "shifted", "force_shifted"),
    "species": ("one", "unlike", "unlike epsilon", "unlike length"),
    "length form": ("sigma", "r_m"),
    "masses": ("1", "equal", "unlike"),
    "place": ("in the box", "periods away", "thousands of periods away"),
    "particles": ("1 tile", "1 particle", "2 tiles"),
}
#: Number of variants.
CHUNKS = 6
#: No length of a scene is 1, and some sides of boxes are shorter than 1; energies follow, so that nothing moves far.
_UNIT = 0.37
_SIGMA, _CUTOFF, _ENERGY = 1.1 * _UNIT, 2.4 * _UNIT, _UNIT**2


def _boundaries(row: Row) -> tuple[str, ...]:
    """Boundaries along the axes of a row's box."""
    d = int(row["dimension"])
    kind, _, place = row["boundaries"].partition(" ")
    if not place:
        return ({"walls": "wall"}.get(kind, kind),) * d
    axis = {"first": 0, "middle": d // 2, "last": d - 1}[place]
    return tuple(kind if k == axis else "periodic" for k in range(d))


def _short_axis(row: Row) -> int | None:
    """The axis along which a row's box is short; None if it is nowhere, or could not be."""
    periodic = [axis for axis, kind in enumerate(_boundaries(row)) if kind == "periodic"]
    if row["shortest side"] == "long" or not periodic:
        return None
    return periodic[0 if row["shortest side"].startswith("first") else -1]


def _valid(row: Row) -> bool:
    if row["shortest side"] != "long" and _short_axis(row) is None:
        return False
    return row["place"] == "in the box" or row["boundaries"] != "walls"


def _places(rng: np.random.Generator, room: Floats, periodic: Floats, number: int) -> Floats:
    """At most so many random places in `room`, (d,), none nearer than 0.9 sigma to another or its images."""
    found: list[Floats] = []
    for _ in range(400):
        x = rng.uniform(0.0, room)
        apart = [x - y for y in found]
        near = [np.where(periodic, a - room * np.rint(a / room), a) for a in apart]
        if all(np.linalg.norm(a) > 0.9 * _SIGMA for a in near):
            found.append(x)
        if len(found) == number:
            break
    return np.array(found)


def scene_of(row: Row, seed: int) -> Scene:
    """The scene of a row, without what it records. row: of `rows`. seed: of the places and velocities."""
    rng = np.random.default_rng(seed)
    d, boundaries = int(row["dimension"]), _boundaries(row)
    sides = _UNIT * np.array([5.9, 6.6, 5.3] if d == 3 else [6.1, 7.3])
    short = _short_axis(row)
    if short is not None:
        # still longer than a particle
        sides[short] = {"1": 0.62, "2": 1.31}[row["shortest side"][-1]] * _CUTOFF
    walled, periodic = (np.array([kind == name for kind in boundaries]) for name in ("wall", "periodic"))
    margin = np.where(walled, 0.85 * _UNIT, 0.0)
    room = sides - 2 * margin
    number = {"1 particle": 1, "1 tile": 7, "2 tiles": 13}[row["particles"]]
    x = _places(rng, room, periodic, number) + margin
    number = len(x)
    turns = {"in the box": 0, "periods away": 3, "thousands of periods away": 6000}[row["place"]]
    # each particle by whole sides of its own, and along open axes all together
    x = x + np.where(periodic, rng.integers(-turns, turns + 1, x.shape) * sides, 0.0)
    x = x + np.where(periodic | walled, 0.0, -1.7 * _UNIT * turns)
    masses: Any = {"1": 1.0, "equal": 2.3, "unlike": tuple(rng.uniform(0.3, 3.0, number).tolist())}[row["masses"]]
    kinds = {"one": (1, 1), "unlike": (3, 3), "unlike epsilon": (2, 1), "unlike length": (1, 2)}[row["species"]]
    epsilon = tuple(_ENERGY * part for part in (1.3, 0.6, 0.9)[: kinds[0]])
    length = tuple(_SIGMA * part for part in (1.0, 0.85, 0.93)[: kinds[1]])
    return Scene(
        name="pairs-of-features",
        dimension=d,  # type: ignore[arg-type]
        duration=0.0,
        masses=masses if row["masses"] != "unlike" or number > 1 else masses[0],
        species=tuple(int(k) for k in (1 + np.arange(number)) % max(kinds)) if max(kinds) > 1 else None,
        lennard_jones=LennardJones(
            epsilon=epsilon if kinds[0] > 1 else epsilon[0],
            length=length if kinds[1] > 1 else length[0],
            length_form=row["length form"],  # type: ignore[arg-type]
            truncation=row["truncation"],  # type: ignore[arg-type]
            cutoff=_CUTOFF,
        ),
        box=Box(
            lengths=tuple(sides.tolist()),
            boundaries=boundaries,  # type: ignore[arg-type]
            wall=Wall(epsilon=0.7 * _ENERGY, sigma=0.95 * _UNIT, cutoff=1.9 * _UNIT) if walled.any() else None,
        ),
        initial=explicit(x, _UNIT * rng.normal(size=x.shape)),
    )


FEATURES = Features(FACTORS, _valid, scene_of, dt=0.004, steps=3, seed=1)


def rows() -> tuple[list[Row], set[Pair]]:
    """Rows in which every pair of levels occurs, and the pairs that no scene can have: a short side where no axis is
    periodic, another place between walls on all sides."""
    return FEATURES.rows


CHECKS = (
    Check(
        name="stepping/lennard-jones-features",
        title="Lennard-Jones particles with every pair of features: energies, virial, forces and steps",
        equation="sums over all pairs and images: phi cut, shifted, force-shifted; mixtures; walls; m_i a_i = F_i",
        criterion="each within bounds of rounding: of coordinates, terms and sums, and of velocity Verlet in doubles",
        citation="Allen & Tildesley, Computer Simulation of Liquids (1987), sections 1.3-1.5, 2.4 and 5.2; rows of all "
        "pairs: Cohen, Dalal, Fredman & Patton, IEEE Trans. Softw. Eng. 23, 437 (1997)",
        judge=audit_rows,
        variants=parts_of(FEATURES, CHUNKS),
        faults=(
            (
                "rows-0",
                pair_fault(
                    "mixing-rule-geometric",
                    "attraction = strength * load_splat(strengths, j) * splat(24.0) * length6",
                    "attraction = strength * strength * splat(24.0) * length6",
                    "unlike pairs take the epsilon of one partner",
                ),
            ),
            (
                "rows-1",
                Fault(
                    "mass-of-the-slot",
                    "stepping/kernels/lennard_jones.py",
                    "+ wall, mass, masses, particle)",
                    "+ wall, mass, masses, tile * WIDTH + lane)",
                    "forces are divided by the mass of the particle with the number of the slot",
                ),
            ),
        ),
        needs=Needs("lennard_jones"),
        interpreted=True,
        features=FeatureRows(FACTORS, rows),
    ),
)
