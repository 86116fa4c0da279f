"""Small scenes of soft grains with given features: a crowd in which contacts begin, end and begin again."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crosscheck.pairs import Row, Rule
from crosscheck.scene import AXES, Contact, Method, Scene
from crosscheck.scene.parts import (
    Box,
    Cylinder,
    Explicit,
    Face,
    Friction,
    GrainFriction,
    HardSpheres,
    Oscillation,
    Output,
)

Floats = NDArray[np.float64]

#: Duration of a contact of two grains of mass 1 without damping, steps in it (few, for each step is judged by itself),
#: and steps of a run.
_CONTACT, _RESOLUTION, _STEPS = 0.1, 10, 45
#: Distance of neighbours in the crowd, over the largest diameter.
_PITCH = 1.04
#: Overlap with walls at the start, of a grain in their corner.
_FAINT = 1e-7
_STIFFNESS = float(np.pi**2 / 2 / _CONTACT**2)
#: Of "hertz", about as stiff at an overlap of 0.05 of the radius 0.5.
_HERTZ = 8.0 * _STIFFNESS
_RATE, _HERTZ_RATE = 6.0, 50.0
_WALLS = ("walls", "lower oscillates", "upper oscillates", "lower swings", "upper swings")


_OWN = ("own hooke", "own hertz", "moduli")
#: What the features of one scene must obey. Many small rules, not one: each is tried as soon as its features are
#: chosen, so that what cannot be is given up early.
RULES: tuple[Rule, ...] = (
    lambda row: row["dimension"] != "2" or row["crowd"] != "long in z",
    lambda row: row["dimension"] != "2" or row["z"] == "open",
    lambda row: row["dimension"] != "2" or row["cylinder"] not in ("about x", "about y"),
    *(lambda row, axis=axis: row["cylinder"] in ("none", f"about {axis}") or row[axis] == "open" for axis in AXES),
    lambda row: row["turning"] == "none" or row["cylinder"] != "none",
    lambda row: row["turning"] == "none" or row["surfaces"] != "smooth",
    lambda row: row["friction"] != "none" or row["inertia"] != "given",
    lambda row: row["friction"] != "none" or row["turning"] == "none",
    lambda row: row["friction"] != "none" or row["surfaces"] != "smooth",
    # has no closed form for a tangential restitution
    lambda row: row["friction"] == "none" or row["law"] != "hertz",
    lambda row: (
        row["surfaces"] == "like grains" or row["cylinder"] != "none" or any(row[axis] in _WALLS for axis in AXES)
    ),
    lambda row: row["surfaces"] != "others" or row["damping"] != "rates" or row["friction"] != "none",
    lambda row: row["damping"] != "rates" or row["law"] in _OWN,
    lambda row: "dashpot" not in row["friction"] or row["law"] != "moduli",
    lambda row: "dashpot" not in row["friction"] or row["law"] not in _OWN or row["damping"] == "rates",
    # along open axes
    lambda row: row["start"] != "one far away" or row["cylinder"] == "none",
    lambda row: row["start"] != "one far away" or any(row[axis] == "open" for axis in AXES[: int(row["dimension"])]),
    lambda row: row["start"] != "in other images" or any(row[axis] == "periodic" for axis in AXES),
)


def possible(row: Row) -> bool:
    """Whether there is a scene with these features. row: levels of all factors of `granular/audit`."""
    return all(rule(row) for rule in RULES)


def simple(factor: str, levels: tuple[str, ...]) -> tuple[str, ...]:
    """The levels of a factor in the few rows for engines that measure less.

    LAMMPS has no friction without a limit, but coefficients up to 1e4: it does not turn a stretch whose force along the
    normal is below 1e-6 of the normal force then, which differs from the law once in some thousand contacts.
    """
    fewer = {
        "law": ("hooke", "own hooke"),
        "x": ("open", "periodic"),
        "z": ("open", "walls"),
        "cylinder": ("none",),
        "turning": ("none",),
        "inertia": ("default",),
        "start": ("apart", "in contact"),
        "tallies": ("none", "all"),
        "y": ("open", "walls"),
        "motion": ("slow",),
        "crowd": ("compact", "long in x"),
        "surfaces": ("like grains", "others"),
        "grains": ("alike", "unlike masses and sizes"),
        "field": ("none", "oblique"),
        "damping": ("none", "restitution", "rates"),
        "friction": ("none", "limited spring", "limited dashpot"),
    }
    return fewer.get(factor, levels)


def common(factor: str, levels: tuple[str, ...]) -> tuple[str, ...]:
    """The levels of a factor in the rows for codes whose walls turn tangential springs, as LAMMPS's do.

    Friction has limits, see `simple`. Walls begin to swing where they stand still: LAMMPS moves others by their mean
    velocity over a step. Moments of inertia are those of balls and disks.
    """
    fewer = {
        "friction": ("none", "limited spring", "limited dashpot"),
        "x": ("open", "periodic", "lower swings"),
        "y": ("open", "walls", "upper swings"),
        "z": ("open", "walls", "lower swings"),
        "inertia": ("default",),
        "start": ("apart", "in contact", "in other images"),
        "motion": ("slow",),
        "crowd": ("compact", "long in y"),
        "grains": ("alike", "unlike masses and sizes"),
        "field": ("none", "oblique"),
        "tallies": ("none", "all", "kinetic_energy", "contact_time"),
    }
    return fewer.get(factor, levels)


#: What the rows of `common` must obey too: at a cylinder, R_eff of LAMMPS has the curvature of the wall.
COMMON_RULES: tuple[Rule, ...] = (
    *RULES,
    lambda row: row["cylinder"] == "none" or row["law"] not in ("hertz", "own hertz", "moduli"),
)


def audited_method(row: Row) -> Method:
    """Velocity Verlet with the contact of a row, without friction's words where there is none."""
    law, friction, damping = row["law"], row["friction"], row["damping"]
    rough = friction != "none"
    entries: dict[str, Any] = {}
    if law == "hooke":
        entries = {"stiffness": 1.1 * _STIFFNESS}
    elif law == "duration":
        entries = {"duration": _CONTACT}
    elif law == "hertz":
        entries = {"law": "hertz", "stiffness": _HERTZ}
    else:
        hertz = law != "own hooke"
        k = _HERTZ if hertz else _STIFFNESS
        entries = {"law": "hertz" if hertz else "hooke"}
        entries |= {"E": 1.2 * k, "nu": 0.3} if law == "moduli" else {"k_n": k}
        rate = _HERTZ_RATE if hertz else _RATE
        if damping == "rates":
            entries["gamma_n"] = rate
        if rough and (damping == "rates"):
            entries["gamma_t"] = 0.4 * rate
        if rough and "spring" in friction and law != "moduli":
            entries["k_t"] = 0.3 * k
        if "limited" in friction and law != "own hertz":
            entries["mu"] = 0.25
    entries["friction"] = "dashpot" if "dashpot" in friction else "history"
    return Method(scheme="velocity_verlet", dt=_CONTACT / _RESOLUTION, contact=Contact(**entries))


def _friction(row: Row, alpha_t: float, sliding: float) -> dict[str, Any] | None:
    """Entries of a friction; alpha_t: tangential restitution, above 0. sliding: of the limit."""
    if row["friction"] == "none":
        return None
    entries: dict[str, Any] = {"tangential_restitution": alpha_t if "dashpot" in row["friction"] else -alpha_t}
    if "limited" in row["friction"] and row["law"] not in ("own hooke", "moduli"):
        entries |= {"static": sliding, "sliding": sliding}
    return entries


def _surface(row: Row) -> dict[str, Any]:
    """Entries of all walls of a row."""
    entries: dict[str, Any] = {}
    restitution = 0.7 if row["damping"] == "restitution" else 1.0
    friction = _friction(row, 0.35, 0.3)
    if row["surfaces"] == "others":
        restitution = 0.85 if row["damping"] != "rates" else 1.0
        friction = _friction(row, 0.6, 0.15)
    entries["restitution"] = restitution
    if friction is not None and row["surfaces"] != "smooth":
        entries["friction"] = Friction(**friction)
    return entries


def _face(row: Row, axis: int, upper: bool) -> Face:
    level, surface = row[AXES[axis]], _surface(row)
    if level == ("upper oscillates" if upper else "lower oscillates"):
        moves = Oscillation(amplitude=0.06, frequency=9.0 + 2 * axis, phase=0.7 - 1.3 * upper + 0.4 * axis)
        surface["oscillation"] = moves
    if level == ("upper swings" if upper else "lower swings"):
        surface["oscillation"] = Oscillation(amplitude=0.05, frequency=11.0 - axis, phase=np.pi * (axis != upper))
    return Face(**surface)


def _crowd(row: Row, rng: np.random.Generator, diameters: Floats, cells: list[int]) -> Floats:
    """Places about the origin (N, d), a little off those of a lattice."""
    d = len(cells)
    sites = np.array(list(product(*(range(n) for n in cells))), dtype=float)
    places = _PITCH * (sites - (np.array(cells) - 1) / 2)
    places += rng.uniform(-0.015, 0.015, places.shape)
    if row["start"] == "in contact":
        places *= 0.93
    return places[: diameters.size].reshape(-1, d)


def audited_scene(row: Row, seed: int, potential: bool) -> Scene:
    """A scene with the features of a row, recorded at each step.

    seed: of places and velocities. potential: whether to ask for the potential energy.
    """
    d = int(row["dimension"])
    rng = np.random.default_rng(seed)
    cells = _cells(row, d)
    number = int(np.prod(cells))
    species = np.arange(number) % 3 // 2
    sizes = (1.0, 0.8) if "sizes" in row["grains"] else (1.0, 1.0)
    diameters = np.array(sizes)[species]
    masses = rng.uniform(0.6, 2.0, number) if "masses" in row["grains"] else np.ones(number)
    places = _crowd(row, rng, diameters, cells)
    velocities = rng.normal(scale=0.8, size=(number, d)) - 0.8 * places
    lengths = _PITCH * np.array(cells, dtype=float) + 0.03
    boundaries: list[Any] = []
    for axis in range(d):
        level = row[AXES[axis]]
        boundaries.append("hard" if level in _WALLS else level)
        if level == "open":
            lengths[axis] += 1.0
        if level == "periodic":  # no particle meets two images of another one
            lengths[axis] = max(lengths[axis], 2.07)
        if level in ("open", "periodic") and row["motion"] == "fast" and row["cylinder"] == "none":
            velocities[:, axis] += 5.0 - axis
    cylinder = None
    if row["cylinder"] != "none":
        axis_name = row["cylinder"][-1]
        across = [axis for axis in range(d) if AXES[axis] != axis_name]
        radius = float((np.linalg.norm(places[:, across], axis=1) + diameters / 2).max()) + 0.02
        lengths[across] = 2 * radius + np.array([0.3, 0.5])
        turns = {"none": 0.0, "forwards": 1.7, "backwards": -1.3}[row["turning"]]
        cylinder = Cylinder(radius=radius, axis=None if d == 2 else axis_name, angular_velocity=turns, **_surface(row))  # type: ignore[arg-type]
    places = places + lengths / 2
    for axis in range(d):
        if row[AXES[axis]] == "periodic" and row["start"] == "in other images":
            places[:, axis] += lengths[axis] * rng.integers(-2, 3, number)
        if row[AXES[axis]] == "open" and row["start"] == "one far away":
            places[0, axis] -= 60.0 + 20.0 * axis
        if row[AXES[axis]] in _WALLS and row["start"] == "apart":
            places[0, axis] = diameters[0] / 2 - _FAINT
    return Scene(
        name="audited grains",
        dimension=d,  # type: ignore[arg-type]
        duration=_STEPS * _CONTACT / _RESOLUTION,
        masses=tuple(masses.tolist()) if "masses" in row["grains"] else 1.0,
        species=tuple(species.tolist()) if "sizes" in row["grains"] else None,
        acceleration=_field(row, d),
        hard_spheres=_spheres(row, sizes),
        box=Box(
            lengths=tuple(lengths.tolist()),
            boundaries=tuple(boundaries),
            faces=_faces(row, d),
            cylinder=cylinder,
        ),
        initial=_start(row, rng, places, velocities),
        output=Output(
            interval=_CONTACT / _RESOLUTION,
            trajectory=True,
            observables=_observables(row, potential, cylinder is not None),
        ),
    )


def _cells(row: Row, d: int) -> list[int]:
    """Sites of the crowd along each axis; a long one needs several cells of a pair list."""
    if row["crowd"] == "compact":
        return [3, 2] if d == 2 else [2, 2, 2]
    axis = AXES.index(row["crowd"][-1])
    cells = [2, 1, 6][:d] if axis == 2 else [6, 2, 1][:d]
    return [2, 6, 1][:d] if axis == 1 else cells


def _field(row: Row, d: int) -> tuple[float, ...] | None:
    if row["field"] == "none":
        return None
    return tuple([0.0, -3.0, 0.0][:d]) if row["field"] == "along one axis" else tuple([1.5, -2.5, 2.0][:d])


def _spheres(row: Row, sizes: tuple[float, float]) -> HardSpheres:
    friction = _friction(row, 0.35, 0.3)
    q = {"inertia": 0.31} if row["inertia"] == "given" else {}
    return HardSpheres(
        diameter=sizes if "sizes" in row["grains"] else sizes[0],
        restitution=0.7 if row["damping"] == "restitution" else 1.0,
        friction=None if friction is None else GrainFriction(**friction, **q),
    )


def _faces(row: Row, d: int) -> dict[str, Face] | None:
    walled = [axis for axis in range(d) if row[AXES[axis]] in _WALLS]
    faces = {f"{AXES[axis]}{'-+'[upper]}": _face(row, axis, bool(upper)) for axis in walled for upper in (0, 1)}
    return faces or None


def _start(row: Row, rng: np.random.Generator, places: Floats, velocities: Floats) -> Explicit:
    spins = None
    if row["friction"] != "none":
        spins = rng.normal(scale=2.0, size=(len(places), 1 if places.shape[1] == 2 else 3))
    return Explicit(
        positions=tuple(map(tuple, places.tolist())),
        velocities=tuple(map(tuple, velocities.tolist())),
        angular_velocities=None if spins is None else tuple(map(tuple, spins.tolist())),
    )


def _observables(row: Row, potential: bool, cylinder: bool) -> tuple[str, ...]:
    if row["tallies"] == "none":
        return ()
    if row["tallies"] in ("kinetic_energy", "contact_time"):
        return (row["tallies"],)
    names = ["kinetic_energy", "contact_time", "collisional_virial", "wall_impulse"]
    names += ["rotational_energy"] if row["friction"] != "none" else []
    names += ["potential_energy"] if potential else []
    names += ["wall_torque"] if cylinder else []
    return tuple(names)
