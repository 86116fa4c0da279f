"""Lattice gases in the plane: where each particle arrives, and what a site may then become.

An auditor of runs, by coordinates of sites and velocity vectors as real numbers: it follows no bit of a word and shifts
no row. Units: links and steps. The site in column x of row y is at (x, y) on the square lattice and at
(x + (y mod 2)/2, y sqrt(3)/2) on the triangular one; channel i of n moving ones has the unit velocity at the angle
2 pi i/n, counter-clockwise from +x, and the last of seven is at rest. Both directions are periodic.

A step brings each particle to the site at its place plus its velocity. Then a site changes its state s, bit i for
channel i, into t with the probability M_st: at fluid sites the force and the collision, at wall sites the reflection.

Literature: U. Frisch et al., Complex Systems 1, 649 (1987); P. Cornubert, D. d'Humieres and C. D. Levermore, Physica D
47, 241 (1991) (walls); L. P. Kadanoff, G. R. McNamara and G. Zanetti, Phys. Rev. A 40, 4527 (1989) (force).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosscheck.references.lattice_models import mean_collision, states, transitions
from crosscheck.scene.parts import Obstacle

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: Far above the rounding of coordinates, far below a link.
_SAME_PLACE = 1e-6
#: Signs of the x and y component of a velocity after a wall; two of them: each with probability 1/2, one draw a site.
_SIGNS = {
    "bounce_back": ((-1, -1),),
    "specular_x": ((-1, 1),),
    "specular_y": ((1, -1),),
    "diffusive_x": ((-1, 1), (-1, -1)),
    "diffusive_y": ((1, -1), (-1, -1)),
}


@cache
def velocities(model: str) -> Floats:
    """c_i, (b, 2), in links per step.

    model: a name of `lattice_models.MODELS`, else KeyError.
    """
    moving, resting = {"hpp": (4, 0), "fhp2": (6, 1), "fhp3": (6, 1)}.get(model, (6, 0))
    angles = 2 * math.pi * np.arange(moving) / moving
    return np.concatenate([np.column_stack([np.cos(angles), np.sin(angles)]), np.zeros((resting, 2))])


class Lattice:
    """Sites of a lattice gas in the plane, numbered row by row, and where the particles that leave them arrive.

    model: a name of `lattice_models.MODELS`. rows, columns: numbers of sites; rows even on the triangular lattice.
    places: (rows, columns, 2), links. box: (2,), its sides, links. ValueError if a particle arrives at no site.
    """

    def __init__(self, model: str, rows: int, columns: int) -> None:
        from scipy.spatial import cKDTree

        height, shift = (1.0, 0.0) if model == "hpp" else (math.sqrt(3) / 2, 0.5)
        row = np.arange(rows)[:, None]
        x, y = np.broadcast_arrays(np.arange(columns) + shift * (row % 2), height * row)
        self.model, self.rows, self.columns = model, rows, columns
        self.places: Floats = np.stack([x, y], axis=-1)
        self.box: Floats = np.array([float(columns), height * rows])
        start = self._inside(self.places.reshape(-1, 2))
        tree = cKDTree(start, boxsize=self.box)
        reached = []
        for velocity in velocities(model):
            distance, site = tree.query(self._inside(start + velocity))
            if np.max(distance) > _SAME_PLACE:
                raise ValueError(f"{rows} x {columns} sites of {model}: a particle arrives between sites")
            reached.append(site)
        #: (b, sites): the site that a particle of channel i arrives at from each site
        self._reached: Integers = np.array(reached)

    def _inside(self, places: Floats) -> Floats:
        """The periodic image from 0 to below the sides of the box; what rounding has put beside an edge is on it."""
        moved = np.mod(places + _SAME_PLACE, self.box) - _SAME_PLACE
        return np.asarray(np.maximum(moved, 0.0))

    def arrivals(self, occupations: Floats) -> Floats:
        """Occupations (..., rows, columns, b) after propagation; occupations: those before, of the same shape."""
        flat = occupations.reshape(*occupations.shape[:-3], self.rows * self.columns, -1)
        found = np.zeros_like(flat)
        for i, reached in enumerate(self._reached):
            found[..., reached, i] = flat[..., i]
        return found.reshape(occupations.shape)

    def walls(self, obstacles: Iterable[Obstacle]) -> NDArray[np.str_]:
        """The rule at each site, (rows, columns), "" where there is no wall.

        obstacles: as scenes have them; where they overlap, the last one counts.
        """
        found = np.full((self.rows, self.columns), "", dtype="<U12")
        for obstacle in obstacles:
            found[self._covered(obstacle)] = obstacle.rule
        return found

    def _covered(self, obstacle: Obstacle) -> NDArray[np.bool_]:
        """The sites of an obstacle, (rows, columns)."""
        if obstacle.centre is not None and obstacle.radius is not None:
            distances = [math.dist(place, obstacle.centre) for place in self.places.reshape(-1, 2).tolist()]
            return np.reshape(distances, (self.rows, self.columns)) <= obstacle.radius
        row, column = np.ogrid[: self.rows, : self.columns]
        covered = np.zeros((self.rows, self.columns), dtype=bool)
        if obstacle.sites is not None:
            for x, y in obstacle.sites:
                covered |= (column == x) & (row == y)
            return covered
        for stretch, place in ((obstacle.columns, column), (obstacle.rows, row)):
            covered |= False if stretch is None else (place < stretch[0]) | (place > stretch[1])
        return ~covered


# -- what a site may become ------------------------------------------------------------------------------


def images(model: str, sign_x: int, sign_y: int) -> tuple[int, ...]:
    """The channel of (sign_x c_ix, sign_y c_iy) for each channel i, found among the vectors.

    model: a name of `lattice_models.MODELS`.
    """
    c = velocities(model)
    distances = np.linalg.norm((c * [sign_x, sign_y])[:, None] - c, axis=-1)
    return tuple(int(i) for i in distances.argmin(axis=1))


def reflection(model: str, rule: str) -> Floats:
    """M_st of a wall, (2^b, 2^b). model: a name of `lattice_models.MODELS`. rule: of a scene's obstacle."""
    bits = states(model)
    found = np.zeros((len(bits), len(bits)))
    for signs in _SIGNS[rule]:
        moved = np.zeros_like(bits)
        moved[:, list(images(model, *signs))] = bits
        found[np.arange(len(bits)), numbers(moved)] += 1 / len(_SIGNS[rule])
    return found


def push(model: str, force: float) -> Floats:
    """M_st of the force alone, (2^b, 2^b): a particle along -x turns to +x, if that channel is empty.

    model: a name of `lattice_models.MODELS`. force: the probability of it; negative: from +x to -x.
    """
    bits = states(model)
    along, against = _push_channels(model, force)
    able = (bits[:, against] > 0) & (bits[:, along] == 0)
    turned = bits.copy()
    turned[able, against], turned[able, along] = 0.0, 1.0
    found = np.diag(np.where(able, 1 - abs(force), 1.0))
    found[able.nonzero()[0], numbers(turned[able])] += abs(force)
    return found


def _push_channels(model: str, force: float) -> tuple[int, int]:
    """The channel that a pushed particle gets into, and the one that it leaves."""
    along_x = velocities(model)[:, 0]
    plus, minus = int(along_x.argmax()), int(along_x.argmin())
    return (plus, minus) if force >= 0 else (minus, plus)


def pushable(model: str, force: float) -> NDArray[np.bool_]:
    """Which states (2^b,) the force can act on.

    model: a name of `lattice_models.MODELS`. force: its sign counts.
    """
    along, against = _push_channels(model, force)
    bits = states(model)
    return np.asarray((bits[:, against] > 0) & (bits[:, along] == 0))


def outcomes(model: str, rule: str, force: float | None, *, reversed_after: bool = False) -> Floats:
    """M_st of a site, (2^b, 2^b): the probability that it leaves the arrived state s as t.

    model: a name of `lattice_models.MODELS`. rule: of a wall, or "" for a fluid site. force: of the scene. None: none.
    reversed_after: after the step the velocities are reversed half-way between two steps: another collision or
    reflection, and all velocities reversed.
    """
    here = reflection(model, rule) if rule else transitions(model)
    found = here if rule or force is None else push(model, force) @ here
    return found @ here @ reflection(model, "bounce_back") if reversed_after else found


def numbers(occupations: ArrayLike) -> Integers:
    """Numbers of states, (...); occupations: (..., b) of 0 and 1."""
    bits = np.asarray(occupations)
    return np.asarray(bits.astype(np.int64) @ (1 << np.arange(bits.shape[-1])))


# -- runs ------------------------------------------------------------------------------------------------


class Motion(NamedTuple):
    """Steps of a gas as states: what arrives at each site, and what is there after the step.

    arrived, after: (steps, rows, columns), numbers of states.
    """

    arrived: Integers
    after: Integers


def motion(lattice: Lattice, trajectory: Floats) -> Motion:
    """The steps of `trajectory`, (steps + 1, rows, columns, b) occupations of 0 and 1, on `lattice`."""
    return Motion(numbers(lattice.arrivals(trajectory[:-1])), numbers(trajectory[1:]))


class Forbidden(NamedTuple):
    """number: of changes of a site that no rule allows. first: where and what the first one is, or ""."""

    number: int
    first: str


def forbidden(
    lattice: Lattice,
    walls: NDArray[np.str_],
    force: float | None,
    found: Motion,
    reversals: Sequence[int] = (),
) -> Forbidden:
    """Sites that leave a step in a state which the arrived one cannot become.

    lattice: the sites. walls: of `Lattice.walls`. force: of the scene. found: the steps. reversals: steps after which
    the velocities are reversed.
    """
    wrong = np.zeros(found.after.shape, dtype=bool)
    for rule in np.unique(walls).tolist():
        here = walls == rule
        for step in range(len(found.after)):
            allowed = _allowed(lattice.model, rule, force, step + 1 in reversals)
            wrong[step, here] = ~allowed[found.arrived[step][here], found.after[step][here]]
    number = int(wrong.sum())
    if not number:
        return Forbidden(0, "")
    step, row, column = (int(k) for k in np.argwhere(wrong)[0])
    before, then = (_channels(lattice.model, int(s[step, row, column])) for s in found)
    place = walls[row, column] or "fluid"
    return Forbidden(
        number, f"step {step + 1}, column {column}, row {row} ({place}): arrived {before}, left with {then}"
    )


@cache
def _allowed(model: str, rule: str, force: float | None, reversed_after: bool) -> NDArray[np.bool_]:
    return np.asarray(outcomes(model, rule, force, reversed_after=reversed_after) > 0)


def _channels(model: str, state: int) -> str:
    filled = [str(i) for i in range(len(velocities(model))) if state >> i & 1]
    return f"channels {' '.join(filled)}" if filled else "no particle"


def pushes(lattice: Lattice, walls: NDArray[np.str_], force: float, found: Motion) -> Motion:
    """What the force has done: `arrived` is 1 at fluid sites where it can turn a particle, `after` 1 where it has.

    A collision keeps the momentum of a site, so the change along x, 2 for a turned particle, is the force's alone.

    lattice: the sites. walls: of `Lattice.walls`. force: of the scene; its sign counts. found: the steps.
    """
    along_x = states(lattice.model) @ velocities(lattice.model)[:, 0]
    change = (along_x[found.after] - along_x[found.arrived]) * math.copysign(0.5, force)
    fluid = walls == ""
    return Motion(
        (pushable(lattice.model, force)[found.arrived] & fluid).astype(np.int64),
        np.rint(np.where(fluid, change, 0.0)).astype(np.int64),
    )


def coins(lattice: Lattice, walls: NDArray[np.str_], found: Motion) -> Motion:
    """What diffusive walls have drawn: `arrived` is 1 at sites where it shows, `after` 1 where all went straight back.

    lattice: the sites. walls: of `Lattice.walls`. found: the steps.
    """
    drawn, back = (np.zeros(found.after.shape, dtype=np.int64) for _ in range(2))
    for rule in ("diffusive_x", "diffusive_y"):
        here = walls == rule
        if here.any():
            arrived, after = found.arrived[:, here], found.after[:, here]
            drawn[:, here] = (_allowed(lattice.model, rule, None, False).sum(axis=1) == 2)[arrived]
            reverse = reflection(lattice.model, "bounce_back").argmax(axis=1)
            back[:, here] = drawn[:, here] * (reverse[arrived] == after)
    return Motion(drawn, back)


def draws_of(probability: float) -> Floats:
    """M_st, (2, 2), of `pushes` and `coins`: state 1 gives 1 with this `probability`, and state 0 gives 0."""
    return np.array([[1.0, 0.0], [1 - probability, probability]])


def mean_step(lattice: Lattice, walls: NDArray[np.str_], force: float | None, occupations: Floats) -> Floats:
    """Mean occupations (rows, columns, b) after a step, of channels that are independent before each change.

    lattice: the sites. walls: of `Lattice.walls`. force: of the scene, None: none. occupations: those before.
    """
    arrived = lattice.arrivals(occupations)
    for rule in np.unique(walls).tolist():
        here = walls == rule
        f = arrived[here]
        if rule:
            turned = np.zeros_like(f)
            for signs in _SIGNS[rule]:
                turned[:, list(images(lattice.model, *signs))] += f / len(_SIGNS[rule])
            arrived[here] = turned
            continue
        if force is not None:
            along, against = _push_channels(lattice.model, force)
            moved = abs(force) * f[:, against] * (1 - f[:, along])
            f[:, against] -= moved
            f[:, along] += moved
        arrived[here] = f + mean_collision(lattice.model, f)
    return arrived
