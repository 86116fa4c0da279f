"""Checks of hard spheres: of entries that contradict each other, and of initial states that are impossible."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from crosscheck.errors import UsageError
from crosscheck.scene.observables import TABLE, named
from crosscheck.scene.overlaps import find_overlap
from crosscheck.scene.parts import (
    AXES,
    Box,
    Cylinder,
    Explicit,
    Floats,
    Friction,
    HardSpheres,
    Kepler,
    Lattice,
    SceneEntries,
)
from crosscheck.scene.starts import State, wall_strokes
from crosscheck.text import shortened

#: Overlaps below this fraction of the diameter are accepted as contacts: the end of an event-driven run, and the digits
#: of a file, leave rounding errors of this order.
TOUCHING = 1e-9


def refuse_hard_spheres_entries(scene: SceneEntries) -> None:
    """ValueError if an entry that only hard spheres have is given. scene: all entries, of another interaction."""
    box, output, initial = scene.box, scene.output, scene.initial
    entries = {
        "acceleration": scene.acceleration is not None,
        "seed": scene.seed is not None,
        "box.packing_fraction": box is not None and box.packing_fraction is not None,
        'a boundary "hard"': "hard" in scene.boundaries,
        "[box.faces]": box is not None and box.faces is not None,
        "[box.cylinder]": box is not None and box.cylinder is not None,
        "initial.angular_velocities": isinstance(initial, Explicit) and initial.angular_velocities is not None,
        "output.collisions": output.collisions is not None,
        "output.fields": output.fields is not None,
        "output.trace": output.trace,
        **{f"output.observables: '{name}'": name in output.observables for name in named("hard_spheres")},
    }
    for entry, given in entries.items():
        if given:
            raise ValueError(f"{entry} goes with [hard_spheres] only, for now: remove it")


def check_hard_spheres(scene: SceneEntries, spheres: HardSpheres) -> None:
    """ValueError if entries of a scene of hard spheres contradict each other.

    scene: all entries. spheres: the table [hard_spheres].
    """
    if scene.acceleration is not None:
        if len(scene.acceleration) != scene.dimension:
            raise ValueError(f"acceleration needs {scene.dimension} components, found {len(scene.acceleration)}")
        if spheres.fixed is not None:
            raise ValueError("acceleration and hard_spheres.fixed: fixed particles do not fall: remove one of them")
    if isinstance(scene.initial, Kepler):
        raise ValueError("initial.kind = 'kepler' needs [gravity]")
    _check_species(scene, spheres)
    most = 1.0 if scene.dimension == 2 else 2 / 3
    friction = spheres.friction
    if friction is not None and friction.inertia is not None and friction.inertia > most:
        raise ValueError(
            f"hard_spheres.friction.inertia = {friction.inertia:g} is more than that of a hollow grain, {most:.4g}: "
            "it is q in I = q m R^2"
        )
    if friction is None and isinstance(scene.initial, Explicit) and scene.initial.angular_velocities is not None:
        raise ValueError(
            "initial.angular_velocities: smooth grains do not rotate: add [hard_spheres.friction], or remove them"
        )
    if scene.box is not None:
        _check_walls(scene, scene.box)
    _check_hard_output(scene)


def _check_species(scene: SceneEntries, spheres: HardSpheres) -> None:
    species = set(scene.species or ())
    if isinstance(spheres.diameter, tuple):
        number = len(spheres.diameter)
        if scene.species is None and number != 1:
            raise ValueError(f"hard_spheres.diameter has {number} values, one per species: add species")
        if number != 1 and max(species, default=0) >= number:
            raise ValueError(f"species {max(species)} has no hard_spheres.diameter: there are {number} values")
    for fixed in spheres.fixed or ():
        if fixed not in species:
            raise ValueError(f"hard_spheres.fixed: there is no particle of species {fixed}")
    if species and species <= set(spheres.fixed or ()):
        raise ValueError("hard_spheres.fixed: all particles are fixed, nothing moves: remove a species")


def _check_walls(scene: SceneEntries, box: Box) -> None:
    if "wall" in scene.boundaries:
        raise ValueError('box.boundaries: a "wall" is for [lennard_jones]; that of hard spheres is called "hard"')
    names = [f"{axis}{side}" for axis in AXES[: scene.dimension] for side in "-+"]
    for name, face in (box.faces or {}).items():
        where = f'box.faces."{shortened(name)}"'
        if name not in names:
            raise ValueError(f"{where}: there is no such face; the faces are {', '.join(names)}")
        boundary = scene.boundaries[AXES.index(name[0])]
        if boundary != "hard":
            raise ValueError(f'{where}: box.boundaries says "{boundary}" along {name[0]}: make it "hard", or remove it')
        _check_wall_friction(scene, where, face.friction)
    if box.cylinder is not None:
        _check_cylinder(scene, box.cylinder)
    drawn = any(face is not None and (face.random_phase or face.temperature) for face in scene.faces)
    if drawn and scene.seed is None and not isinstance(scene.initial, Lattice):
        raise ValueError("seed is missing: walls with temperature or random_phase draw random numbers: add seed = 0")


def _check_wall_friction(scene: SceneEntries, where: str, friction: Friction | None) -> None:
    if friction is not None and scene.spin_dimension == 0:
        raise ValueError(f"{where}.friction: smooth grains have no friction at walls: add [hard_spheres.friction]")


def _check_cylinder(scene: SceneEntries, cylinder: Cylinder) -> None:
    if scene.dimension == 2 and cylinder.axis is not None:
        raise ValueError(f"box.cylinder.axis = '{cylinder.axis}': in the plane it is a circle: remove axis")
    if scene.dimension == 3 and cylinder.axis is None:
        raise ValueError('box.cylinder.axis is missing: add it, one of "x", "y", "z"')
    for axis in scene.across:
        if scene.boundaries[axis] != "open":
            raise ValueError(
                f'box.boundaries: along {AXES[axis]}, across the cylinder, it must be "open", found '
                f'"{scene.boundaries[axis]}"'
            )
    _check_wall_friction(scene, "box.cylinder", cylinder.friction)


def _check_hard_output(scene: SceneEntries) -> None:
    output = scene.output
    if "virial" in output.observables:
        raise ValueError("output.observables: hard spheres have no 'virial': 'collisional_virial' is that of impulses")
    if output.forces:
        raise ValueError("output.forces: hard spheres exert impulses, not forces: remove it")
    there = {"hard_spheres.friction": scene.spin_dimension > 0, "box.cylinder": bool(scene.across)}
    for name in output.observables:
        requires = TABLE[name].requires
        if requires is not None and not there[requires[0]]:
            raise ValueError(f"output.observables: '{name}' needs [{requires[0]}]: {requires[1]}")
    if output.fields is not None:
        if scene.box is None:
            raise ValueError("output.fields divides a box into cells: add [box]")
        if len(output.fields) != scene.dimension:
            raise ValueError(f"output.fields needs {scene.dimension} entries, found {len(output.fields)}")


def check_hard_state(
    scene: SceneEntries,
    spheres: HardSpheres,
    state: State,
    fixed: NDArray[np.bool_],
    periods: Floats,
    soft: bool = False,
) -> None:
    """UsageError if particles overlap, are beyond a wall, or are fixed but have a velocity, or if the box is too small.

    scene: all entries. spheres: the table [hard_spheres]. state: the initial state. fixed: (N,), particles that never
    move. periods: sides of the box along periodic axes, 0 along the others, (d,), length. soft: contacts are soft, so
    that particles may overlap with each other and with walls, by less than the (smaller) radius.
    """
    assert state.diameters is not None
    for name, vectors in (("velocities", state.velocities), ("angular_velocities", state.angular_velocities)):
        if vectors is not None and vectors[fixed].any():
            i = int(np.flatnonzero(fixed & (vectors != 0).any(axis=1))[0])
            raise UsageError(f"initial.{name}[{i}] is not zero: the particle is of a fixed species; make it zero")
    rounding = TOUCHING * float(state.diameters.max() or np.abs(state.positions).max())
    if state.lengths is not None:
        contact = float(state.diameters.max()) * (spheres.well.range if spheres.well is not None else 1.0)
        for axis, period in enumerate(periods.tolist()):
            if 0 < period <= 2 * contact:
                raise UsageError(
                    f"box: its length {period:.6g} along {AXES[axis]}, which is periodic, must exceed two contact "
                    f"ranges, {2 * contact:.6g}: take a larger box"
                )
        _refuse_beyond_walls(scene, state, rounding, soft)
    overlap = find_overlap(state.positions, state.diameters, fixed, periods, rounding, soft)
    if overlap is not None:
        lattice = isinstance(scene.initial, Lattice)
        smaller = float(state.diameters[[overlap.i, overlap.j]].min()) / 2
        much = f" by more than the smaller of their radii, {smaller:.6g}" if soft else ""
        raise UsageError(
            f"particles {overlap.i} and {overlap.j} overlap{much}: their centres are "
            f"{overlap.distance:.9g} apart, and their contact distance is {overlap.contact:.9g} "
            f"(gap {overlap.distance - overlap.contact:.3g}): "
            + ("take fewer particles, smaller ones or a larger box" if lattice else "move one of them")
        )


def _refuse_beyond_walls(scene: SceneEntries, state: State, rounding: float, soft: bool) -> None:
    # a soft grain may reach beyond a wall by its radius: its centre is inside
    reach, much = (0.0, ", more than its radius") if soft else (1.0, "")
    assert scene.box is not None
    assert state.lengths is not None
    assert state.diameters is not None
    radii = state.diameters / 2
    strokes = wall_strokes(scene.faces)
    room = state.lengths - strokes.sum(axis=1) - reach * state.diameters.max()
    for axis in np.flatnonzero((room < 0) & strokes.any(axis=1)).tolist():
        raise UsageError(
            f"box.faces: the walls that oscillate along {AXES[axis]} leave no room for the largest particle: "
            "take smaller amplitudes or a larger box"
        )
    for index, face in enumerate(scene.faces):
        if face is None:
            continue
        axis, upper = divmod(index, 2)
        x, length, stroke = state.positions[:, axis], float(state.lengths[axis]), face.oscillation
        wall = 0.0 if stroke is None else stroke.amplitude * math.cos(stroke.phase)
        gaps = (length - x if upper else x) - wall - reach * radii
        i = int(gaps.argmin())
        if gaps[i] < -rounding:
            raise UsageError(
                f"particle {i} is beyond the wall {AXES[axis]}{'-+'[upper]} by {(1 - reach) * radii[i] - gaps[i]:.3g}"
                f"{much}: its centre must be at least {wall + reach * radii[i]:.6g} from "
                f"{AXES[axis]} = {length if upper else 0.0:g}; it is at {x[i]:.9g}"
            )
    if scene.box.cylinder is not None:
        across, radius = list(scene.across), scene.box.cylinder.radius
        if (2 * radius > state.lengths[across] * (1 + TOUCHING)).any():
            raise UsageError(
                f"box.cylinder.radius = {radius:g} does not fit into the box: make box.lengths across it at least "
                f"{2 * radius:g}"
            )
        distances = np.linalg.norm(state.positions[:, across] - state.lengths[across] / 2, axis=1)
        gaps = radius - distances - reach * radii
        i = int(gaps.argmin())
        if gaps[i] < -rounding:
            raise UsageError(
                f"particle {i} is beyond the cylinder by {(1 - reach) * radii[i] - gaps[i]:.3g}{much}: "
                f"its centre must be within {radius - reach * radii[i]:.6g} of the axis; it is {distances[i]:.9g} away"
            )
