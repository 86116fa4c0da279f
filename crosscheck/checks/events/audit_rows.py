"""Small scenes of hard spheres in which every pair of compatible features occurs, for the auditor of events."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from crosscheck.checks.events.units import in_units
from crosscheck.pairs import Pair, Row, Rule, covering
from crosscheck.scene import (
    AXES,
    Box,
    Cylinder,
    Face,
    Floats,
    Friction,
    GrainFriction,
    HardSpheres,
    Output,
    Scene,
    Well,
    explicit,
)
from crosscheck.scene.observables import TABLE

#: Features of scenes of hard spheres and their levels, the first of which is the absence or the plain form. "scheme":
#: the engine's first, second ... event-driven one. "walls": the kind of that face, "side", of every hard axis on which
#: it is, by other numbers on each; the other face is at rest. "box": its sides in contact ranges; "none": open space.
FACTORS: dict[str, tuple[str, ...]] = {
    "dimension": ("2", "3"),
    "scheme": ("first", "second", "third", "fourth"),
    "box": ("wide", "small", "dilute", "none"),
    "species": ("one", "unlike", "points"),
    "fixed": ("no", "yes"),
    "restitution": ("1", "0.9", "0.4"),
    "friction": ("none", "sticks", "limited", "reverses"),
    "well": ("none", "shallow", "deep", "shoulder", "high shoulder"),
    "contact duration": ("none", "some"),
    "field": ("none", "first axis", "last axis", "oblique"),
    "x": ("periodic", "hard", "open"),
    "y": ("periodic", "hard", "open"),
    "z": ("periodic", "hard", "open"),
    "walls": ("plain", "inelastic", "moving", "oscillating", "uniform phase", "flux phase", "thermal", "open"),
    "side": ("-", "+", "both"),
    "wall friction": ("none", "sticks", "limited"),
    "cylinder": ("none", "x", "y", "z"),
    "turning": ("no", "forwards", "backwards"),
    "start": ("inside", "images away"),
    "measured": ("sums", "trace alone", "fields"),
    "samples": ("times", "collisions"),
}
#: Observables of rows that measure sums.
SUMS = (
    "kinetic_energy", "potential_energy", "collisions", "events", "collisional_virial", "dissipated_energy",
    "wall_impulse", "wall_energy", "wall_collisions", "kinetic_energy_integral", "potential_energy_integral",
    "deepest_overlap", "contact_time",
)  # fmt: skip
#: Diameters of species, mass of a particle where all are alike, and range of wells.
SIZES, MASS = (1.1, 0.8, 0.95), 1.7
WELLS = {
    "shallow": Well(depth=0.4, range=1.25), "deep": Well(depth=2.5, range=1.6), "shoulder": Well(depth=-0.5, range=1.4),
    "high shoulder": Well(depth=-1e4, range=1.03),
}  # fmt: skip
FRICTIONS: dict[str, dict[str, float]] = {
    "sticks": {"tangential_restitution": 0.3},
    "limited": {"tangential_restitution": 0.2, "static": 0.5, "sliding": 0.35},
    "reverses": {"tangential_restitution": -0.8, "static": 2.0, "sliding": 1.5, "inertia": 0.6},
}
FIELDS = {
    ("first axis", 2): (0.35, 0.0), ("first axis", 3): (0.35, 0.0, 0.0),
    ("last axis", 2): (0.0, -0.3), ("last axis", 3): (0.0, 0.0, -0.3),
    ("oblique", 2): (-0.25, 0.3), ("oblique", 3): (-0.2, 0.3, 0.25),
}  # fmt: skip
FACES: dict[str, dict[str, Any]] = {
    "plain": {},
    "inelastic": {"restitution": 0.7},
    "moving": {"restitution": 0.9, "velocity": 0.5},
    "oscillating": {"restitution": 0.95, "oscillation": {"amplitude": 0.12, "frequency": 6.0, "phase": 0.7}},
    "uniform phase": {"restitution": 0.9, "random_phase": {"speed": 0.8, "law": "uniform"}},
    "flux phase": {"restitution": 0.9, "random_phase": {"speed": 0.8, "law": "flux"}},
    "thermal": {"temperature": 1.9},
    "open": {"open": True},
}
#: Numbers of a face are smaller by this factor from one axis to the next, and on the upper side.
_NEXT, _UPPER = 0.93, 0.86
#: Sides of the box by level, in contact ranges: unlike along all axes.
SIDES = {
    "wide": (5.6, 5.1, 4.4), "small": (2.03, 2.2, 2.1), "dilute": (13.0, 11.0, 12.0),
}  # fmt: skip
#: Events that a row is meant to have, and its longest duration. With the high shoulder, whose depth an engine may take
#: for a measure of speeds, it is at least so long that a clock which is renewed after some crossings of the box is.
EVENTS, LONGEST, RENEWED = 180.0, 16.0, 10.0
#: Units of length and time of every other row.
UNITS = (0.37, 1.9)


def _axes(row: Row) -> str:
    return "xy" if row["dimension"] == "2" else "xyz"


def _some(row: Row, kind: str) -> bool:
    """Whether some axis of the row is of this kind."""
    return any(row[axis] == kind for axis in _axes(row))


def _bounded(row: Row) -> int:
    """Axes along which the particles cannot move round the box."""
    return sum(row[axis] != "periodic" for axis in _axes(row))


#: Which features of a row go together.
RULES: tuple[Rule, ...] = (
    lambda row: row["dimension"] == "3" or (row["z"] == "periodic" and row["cylinder"] in ("none", "z")),
    lambda row: row["cylinder"] == "none" or row["box"] in ("wide", "dilute"),
    lambda row: row["cylinder"] == "none" or all(row[axis] == "open" for axis in _axes(row) if axis != row["cylinder"]),
    lambda row: row["box"] != "none" or row["measured"] != "fields",
    lambda row: row["box"] != "none" or not (_some(row, "hard") or _some(row, "periodic")),
    lambda row: row["measured"] != "fields" or row["box"] in ("wide", "dilute"),
    # clear of the walls on their way, there would be no room
    lambda row: row["box"] != "small" or row["walls"] != "oscillating" or _bounded(row) < 2,
    lambda row: row["species"] != "points" or row["box"] != "small",
    lambda row: row["species"] != "points" or (row["friction"] == "none" and row["well"] == "none"),
    lambda row: row["fixed"] == "no" or row["field"] == "none",
    lambda row: (row["walls"] == "plain" and row["side"] == "-") or _some(row, "hard"),
    lambda row: row["wall friction"] == "none" or row["friction"] != "none",
    lambda row: row["wall friction"] == "none" or row["cylinder"] != "none" or row["walls"] not in ("thermal", "open"),
    lambda row: row["wall friction"] == "none" or row["cylinder"] != "none" or _some(row, "hard"),
    lambda row: row["turning"] == "no" or (row["cylinder"] != "none" and row["wall friction"] != "none"),
    lambda row: row["start"] == "inside" or _some(row, "periodic"),
)


def valid(row: Row) -> bool:
    """Whether the features of a row go together."""
    return all(rule(row) for rule in RULES)


@cache
def rows(table: int = 1) -> tuple[list[Row], set[Pair]]:
    """Rows of `FACTORS` in which every pair of compatible levels occurs, and the pairs that do not go together.

    table: another one has other rows, without the fourth scheme: where it is the naive algorithm of `refimpl`, each
    event costs as all pairs, and boxes hardly longer than a particle many steps, with a rounding each.
    """
    factors = FACTORS if table == 1 else FACTORS | {"scheme": FACTORS["scheme"][:3]}
    return covering(factors, RULES, seed=table)


def row_scene(row: Row, number: int) -> Scene:
    """The scene of a row, in other units where its number is odd. number: seeds its start."""
    scene = _scene(row, number)
    return in_units(scene, *UNITS) if number % 2 else scene


def _scene(row: Row, number: int) -> Scene:
    rng = np.random.default_rng(number)
    d = int(row["dimension"])
    well = WELLS.get(row["well"])
    reach = SIZES[0] * (1.0 if well is None else well.range)
    lengths = np.array(SIDES.get(row["box"], SIDES["wide"])[:d]) * reach
    boundaries = tuple(row[axis] for axis in AXES[:d])
    species, diameters, masses = _particles(row, lengths, rng)
    spheres = HardSpheres(
        diameter=_of_species(row) if row["species"] != "one" else SIZES[0],
        restitution=float(row["restitution"]),
        fixed=(max(species),) if row["fixed"] == "yes" else None,
        contact_duration=0.15 if row["contact duration"] == "some" else None,
        friction=GrainFriction(**FRICTIONS[row["friction"]]) if row["friction"] != "none" else None,
        well=well,
    )
    fixed = np.array(species) == max(species) if row["fixed"] == "yes" else np.zeros(len(species), bool)
    x = _places(row, lengths, diameters, rng)
    # towards the middle of open axes: they would fly off before they have met
    inwards = np.where(np.array(boundaries) == "open", 1.2 * (x - x.mean(axis=0)), 0.0)
    v = np.where(fixed[:, None], 0.0, (rng.normal(size=x.shape) - inwards))
    if row["cylinder"] != "none" and row["field"] == "none":
        v[0] = 0.0  # at rest, it never gets to the cylinder by itself
    spins = np.where(fixed[:, None], 0.0, rng.normal(size=(len(x), 1 if d == 2 else 3)))
    if row["start"] == "images away":
        x += np.where(np.array(boundaries) == "periodic", rng.integers(-2, 3, x.shape) * lengths, 0.0)
    duration = _duration(row, lengths, len(x))
    return Scene(
        name="-".join(str(level) for level in (number, *row.values())).replace(" ", "_")[:190],
        dimension=d,  # type: ignore[arg-type]
        duration=duration,
        hard_spheres=spheres,
        box=None if row["box"] == "none" else _box(row, lengths, boundaries),
        acceleration=None if row["field"] == "none" else FIELDS[row["field"], d],
        masses=masses,
        species=species if row["species"] != "one" or row["fixed"] == "yes" else None,
        seed=number,
        initial=explicit(x, v, spins if spheres.friction is not None else None),
        output=_output(row, d, duration),
    )


def _particles(row: Row, lengths: Floats, rng: np.random.Generator) -> tuple[tuple[int, ...], Floats, Any]:
    """Species, diameters (N,) and masses."""
    room = float(np.prod(lengths / SIZES[0])) * (0.4 if row["cylinder"] != "none" else 1.0)
    least, most = {"small": (3, 8), "dilute": (9, 9), "none": (14, 14)}.get(row["box"], (5, 12))
    n = int(np.clip(0.22 * room, least, most))
    kinds = {"one": 1, "unlike": 3, "points": 4}[row["species"]]
    unlike, species = kinds > 1, np.arange(n) % kinds
    if row["fixed"] == "yes":
        # the last one among them, or not
        species = np.where(np.arange(n) % 4 == (2 if n % 2 else (n - 1) % 4), kinds, species)
        kinds += 1
    diameters = np.array(_of_species(row))[species] if unlike else np.full(n, SIZES[0])
    masses = MASS if not unlike else tuple(rng.uniform(0.6, 3.0, n).tolist())
    return tuple(species.tolist()), diameters, masses


def _of_species(row: Row) -> tuple[float, ...]:
    """Diameters of the species, the fixed one last."""
    points = (0.0,) if row["species"] == "points" else ()
    return (*SIZES, *points, *((0.9,) if row["fixed"] == "yes" else ()))


def _box(row: Row, lengths: Floats, boundaries: tuple[str, ...]) -> Box:
    friction = None
    if row["wall friction"] != "none":
        friction = Friction(**FRICTIONS[row["wall friction"]])
    faces = {}
    for k, (axis, boundary) in enumerate(zip(AXES, boundaries, strict=False)):
        for side in "-+" if boundary == "hard" else "":
            faces[f"{axis}{side}"] = Face(restitution=0.95)
            if row["side"] in (side, "both"):
                law = friction if row["walls"] not in ("thermal", "open") else None
                factor = _NEXT**k * (_UPPER if side == "+" and row["side"] == "both" else 1.0)
                faces[f"{axis}{side}"] = Face(**_times(FACES[row["walls"]], factor), friction=law)
    cylinder = None
    if row["cylinder"] != "none":
        across = [k for k in range(lengths.size) if AXES[k] != row["cylinder"]]
        cylinder = Cylinder(
            radius=float(lengths[across].min()) / 2,
            axis=row["cylinder"] if lengths.size == 3 else None,  # type: ignore[arg-type]
            angular_velocity={"no": 0.0, "forwards": 0.8, "backwards": -0.6}[row["turning"]],
            # a grain that loses speed to the cylinder alone comes to slide along it: infinitely many events
            restitution=1.0 if row["restitution"] == "1" else 0.9,
            friction=friction,
        )
    return Box(lengths=tuple(lengths.tolist()), boundaries=boundaries, faces=faces or None, cylinder=cylinder)  # type: ignore[arg-type]


def _times(entry: Any, factor: float) -> Any:
    """The entries of a face, with all numbers times a factor."""
    if isinstance(entry, dict):
        return {name: _times(part, factor) for name, part in entry.items()}
    return entry * factor if isinstance(entry, float) else entry


def _places(row: Row, lengths: Floats, diameters: Floats, rng: np.random.Generator) -> Floats:
    """Positions without overlaps, (N, d), one after the other; clear of walls that oscillate."""
    d, radii = lengths.size, diameters / 2
    periodic = np.array([row[axis] == "periodic" for axis in AXES[:d]])
    across = [k for k in range(d) if AXES[k] != row["cylinder"]]
    clear = 0.13 if row["walls"] == "oscillating" else 0.0
    extent = lengths
    placed = np.zeros((0, d))
    while len(placed) < len(diameters):
        i = len(placed)
        for _ in range(1000):
            margin = np.where(periodic, 0.0, radii[i] + clear)
            x = rng.uniform(margin, extent - margin)
            away = x[across] - lengths[across] / 2
            if row["cylinder"] != "none" and math.hypot(*away) > lengths[across].min() / 2 - radii[i]:
                continue
            gaps = placed - x
            gaps -= np.where(periodic, lengths * np.round(gaps / lengths), 0.0)
            if ((gaps**2).sum(axis=1) > (radii[:i] + radii[i]) ** 2).all():
                placed = np.vstack([placed, x])
                break
        else:  # no room is left for this one: begin anew
            placed = np.zeros((0, d))
    return placed if row["box"] != "none" else placed - 3.0


def _duration(row: Row, lengths: Floats, n: int) -> float:
    """About the time of `EVENTS` events by kinetic theory."""
    d = lengths.size
    target = 2 * SIZES[0] if d == 2 else math.pi * SIZES[0] ** 2
    rate = 0.5 * n * n * target * 1.8 / float(np.prod(lengths))
    hard = [length for axis, length in zip(AXES, lengths, strict=False) if row[axis] == "hard"]
    rate += n * sum(0.8 / length for length in hard)
    if row["cylinder"] != "none":
        rate += n * 2.0 / float(lengths.min())
    if row["well"] != "none":
        rate *= 2.0
    least = RENEWED if row["well"] == "high shoulder" else 0.0
    return float(np.clip(EVENTS / rate, least, LONGEST))


def _output(row: Row, d: int, duration: float) -> Output:
    counts = (1, 2, 4, 7, 12)
    sampled: dict[str, Any] = {"interval": duration / 7} if row["samples"] == "times" else {"collisions": counts}
    if row["measured"] == "trace alone":
        return Output(trace=True, **sampled)
    names = [*SUMS]
    names += ["rotational_energy"] if row["friction"] != "none" else []
    names += ["wall_torque"] if row["cylinder"] != "none" else []
    fields = {"wide": (2, 3, 2), "dilute": (4, 1, 5)}.get(row["box"], ())[:d]
    return Output(
        observables=tuple(name for name in TABLE if name in names),
        trajectory=True,
        trace=True,
        fields=fields if row["measured"] == "fields" else None,
        **sampled,
    )
