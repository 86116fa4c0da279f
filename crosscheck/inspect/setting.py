"""What is known of a trajectory before its frames are looked at: particles, ensemble, clock, what is conserved."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from crosscheck.compare.differences import informed, spacing
from crosscheck.compare.growth import EPSILON
from crosscheck.errors import UsageError
from crosscheck.files import shown_path
from crosscheck.inspect.kelvin import in_energy
from crosscheck.scene import AXES, Method, Scene
from crosscheck.simulate.conserved import changes_energy, changes_momentum, has_potential, turns
from crosscheck.trajectories.frames import Box, Floats, Frame, Integers, Source, first_line

#: What a trajectory is taken for: in equilibrium, of an ensemble that is not known; canonical; at constant energy, so
#: closed; not in equilibrium.
Ensemble = Literal["equilibrium", "nvt", "nve", "none"]
ENSEMBLES: tuple[Ensemble, ...] = get_args(Ensemble)
#: The same in words.
TAKEN: dict[Ensemble, str] = {
    "equilibrium": "in equilibrium, of an ensemble that is not known",
    "nvt": "in equilibrium, canonical",
    "nve": "closed and in equilibrium, at constant energy",
    "none": "not in equilibrium",
}
#: Fewest particles of which statistical mechanics is asked: orbits of fewer need not visit all states.
FEWEST = 10
#: Why nothing is judged of equilibrium.
NOT_IN_EQUILIBRIUM = "it is not taken to be in equilibrium (--ensemble none, or what the scene says)"
_UNKNOWN = "nothing says that the system is closed (--ensemble nve, or --scene, would)"


class Options(NamedTuple):
    """What the user says of a trajectory.

    ensemble: None: that of the scene, without a scene "equilibrium". temperature: k_B T in mass velocity^2 of the file,
    or in kelvin, as "300K"; None: not known. masses: type -> mass, for files that state none. hard: particles with
    diameters must not overlap. homogeneous: g(r) must go to 1. constraints: number of degrees of freedom that are
    constrained, as those of rigid bonds.
    skip: share of the frames at the start that is left out of equilibrium statistics. arithmetic: "double" or "single",
    of the run.
    """

    ensemble: Ensemble | None = None
    temperature: str | None = None
    masses: Mapping[str, float] = {}
    hard: bool = False
    homogeneous: bool = False
    constraints: int = 0
    skip: float = 0.2
    arithmetic: str = "double"


class Clock(NamedTuple):
    """Times of the frames. values: (F,), of the frames in the order of the file. name: "time", "step" or "frame".
    same_unit: whether a velocity times a difference of these times is a length of the file."""

    values: Floats
    name: str
    same_unit: bool


class Conserved(NamedTuple):
    """What is conserved: of each quantity "", or why nothing says so.

    momentum: along each axis, (3,). angular_momentum, kinetic_energy, energy: of all particles.
    """

    momentum: tuple[str, str, str]
    angular_momentum: str
    kinetic_energy: str
    energy: str


@dataclass(frozen=True)
class Setting:
    """A trajectory, and what is known of it.

    source: its frames. scene: what was run; None: not known. box: that of the scene, else of the first frame; None:
    there is none. first: its first frame. ensemble: what it is taken for. temperature: k_B T that it should have, mass
    velocity^2 of the file; None: not known. axes: numbers of those along which particles move. species: of each
    particle, (N,), counted from 0, and names: of them. masses: (N,), mass; None: not known. diameters: (N,), length;
    None: not known, or of no meaning. hard: particles must not overlap. homogeneous: g(r) must go to 1. moving: (N,),
    those that are not fixed. constraints: number of constrained degrees of freedom. begin: number of the first frame of
    equilibrium statistics. clock: times of the frames. conserved: see there. epsilon: distance from one number to the
    next, relative, in the run's arithmetic. remarks: whole sentences on what was assumed.
    """

    source: Source
    scene: Scene | None
    box: Box | None
    first: Frame
    ensemble: Ensemble
    temperature: float | None
    axes: tuple[int, ...]
    species: Integers
    names: tuple[str, ...]
    masses: Floats | None
    diameters: Floats | None
    hard: bool
    homogeneous: bool
    moving: NDArray[np.bool_]
    constraints: int
    begin: int
    clock: Clock
    conserved: Conserved
    epsilon: float
    remarks: tuple[str, ...] = field(default=())

    def boxed(self, frame: Frame) -> Frame:
        """A frame with the box of the scene, or of the first frame, where it says nothing of its own. frame: of it."""
        return frame._replace(box=self.box) if frame.box is None else informed(frame, self.box)

    @cached_property
    def number(self) -> int:
        """Number of particles that move."""
        return int(np.count_nonzero(self.moving))

    @cached_property
    def moving_masses(self) -> Floats:
        """Masses of the particles that move, (n,)."""
        assert self.masses is not None
        return self.masses[self.moving]

    @cached_property
    def spacing(self) -> float:
        """Distance of neighbours, length: that of the particles of the first frame spread over its box."""
        return spacing(self.first)

    @property
    def freedoms(self) -> int:
        """Degrees of freedom of the motion about the centre of mass."""
        return len(self.axes) * (self.number - 1) - self.constraints

    @property
    def open_space(self) -> bool:
        """Whether there is no wall, and no axis is periodic."""
        box = self.first.box
        if self.scene is not None:
            return set(self.scene.boundaries) == {"open"} and not self.scene.across
        return box is None

    @property
    def rotations(self) -> int:
        """How many degrees of freedom a rotation of all particles may take, whose energy is not thermal."""
        return (1 if len(self.axes) == 2 else 3) if self.open_space and len(self.axes) > 1 else 0

    @property
    def unequal_masses(self) -> bool:
        """Whether masses differ."""
        return self.masses is not None and bool(np.ptp(self.moving_masses) > 0)

    def no_velocities(self) -> str:
        """Why velocities say nothing here: they, or the masses, are not in the file; "" if they do."""
        if self.first.velocities is None:
            return "the file holds no velocities"
        if self.masses is None:
            return "the file states no masses for its types (--mass TYPE=MASS or --scene would)"
        return ""

    def no_equilibrium(self) -> str:
        """Why statistics of velocities in equilibrium cannot be said; "" if they can."""
        reason = self.no_velocities()
        if reason:
            return reason
        if self.number < FEWEST:
            return f"{self.number} particles move, and statistical mechanics is asked of {FEWEST} or more"
        frames = len(self.source) - self.begin
        if frames < 4:
            return f"there are {frames} frames after the start that is left out, and a mean with an error needs 4"
        return NOT_IN_EQUILIBRIUM if self.ensemble == "none" else ""

    def steps_to(self, index: int) -> float:
        """Number of time steps from the first frame to frame `index`; where the file does not tell, 1000 a frame."""
        steps = self.source.steps
        if steps is not None and steps[-1] > steps[0]:
            return max(float(steps[index] - steps[0]), 1.0)
        return _STEPS * max(index, 1)


#: Steps from frame to frame, where the file does not tell: few programs write every thousandth step or less often.
_STEPS = 1000.0


def setting_of(source: Source, scene: Scene | None, options: Options) -> Setting:
    """What is known of a trajectory.

    source: its frames. scene: what was run; None: not known. options: what the user says. UsageError if the scene, or
    what the user says, does not fit the file.
    """
    first = _read(source, 0)
    if scene is not None:
        _check_scene(source, scene, first)
        box = box_of(scene)
        first = first._replace(box=box) if first.box is None else informed(first, box)
    second = _second(source, first)
    remarks = []
    species, names = _species(first, scene)
    masses, said = _masses(source, first, scene, options, names, species)
    remarks += said
    moving = np.ones(len(first.ids), dtype=bool)
    if scene is not None:
        moving = ~scene.fixed()
    elif first.velocities is not None and np.array_equal(first.ids, second.ids) and second.velocities is not None:
        still = [(one == 0).all(axis=1) for one in (first.velocities, second.velocities)]
        still.append((first.positions == second.positions).all(axis=1))
        fixed = np.logical_and.reduce(still)
        if fixed.any() and not fixed.all():
            moving = ~fixed
            remarks.append(
                f"{np.count_nonzero(fixed)} particles are at rest in the first two frames: they are left out."
            )
    diameters, hard = first.diameters, options.hard
    if scene is not None and scene.hard_spheres is not None:
        diameters = scene.diameters()
        hard = scene.method is None or scene.method.contact is None
    if hard and diameters is None:
        raise UsageError(f"--hard: {shown_path(source.path)} states no diameters: leave it out, or give --scene")
    ensemble = options.ensemble or ("equilibrium" if scene is None else _ensemble(scene))
    temperature = None
    if options.temperature is not None:
        temperature = _temperature(options.temperature, source, unknown_masses=bool(said))
    elif scene is not None and options.ensemble in (None, "nvt"):
        temperature = _wall_temperature(scene)
    count = len(source)
    return Setting(
        source,
        scene,
        first.box if scene is None else box,
        first,
        ensemble,
        temperature,
        _axes(first, second, scene),
        species,
        names,
        masses,
        diameters,
        hard,
        options.homogeneous,
        moving,
        options.constraints,
        int(np.ceil(options.skip * count)),
        _clock(source, scene),
        _conserved(scene, first, ensemble, diameters),
        EPSILON[options.arithmetic],
        tuple(remarks),
    )


def _read(source: Source, index: int) -> Frame:
    """A frame; UsageError if it cannot be read, for nothing can be said then."""
    try:
        return source.read(index)
    except (ValueError, OSError, EOFError) as error:
        raise UsageError(
            f"{shown_path(source.path)}: frame {index} (counted from 0) cannot be read ({first_line(error)})"
        ) from None


def _second(source: Source, first: Frame) -> Frame:
    """The second frame; the first where there is none, or it cannot be read, which is told later."""
    try:
        return source.read(1) if len(source) > 1 else first
    except (ValueError, OSError, EOFError):
        return first


def box_of(scene: Scene) -> Box | None:
    """The box of a scene in space; None: it has none. scene: what was run."""
    lengths = scene.lengths()
    if lengths is None:
        return None
    edges, periodic = np.zeros(3), np.zeros(3, dtype=bool)
    edges[: scene.dimension] = lengths
    periodic[: scene.dimension] = np.array(scene.boundaries) == "periodic"
    return Box(np.diag(edges), np.zeros(3), periodic)


def _check_scene(source: Source, scene: Scene, first: Frame) -> None:
    if scene.lattice_gas is not None:
        raise UsageError(f"scene {scene.name}: a lattice gas has no trajectory of particles: take another scene")
    if scene.number != len(first.ids):
        raise UsageError(
            f"{shown_path(source.path)}: it has {len(first.ids)} particles, and scene {scene.name} has {scene.number}: "
            "give the scene of this run"
        )


def _axes(first: Frame, second: Frame, scene: Scene | None) -> tuple[int, ...]:
    """Numbers of the axes along which particles are spread, or move."""
    if scene is not None:
        return tuple(range(scene.dimension))
    moves = np.zeros(3, dtype=bool)
    for frame in (first, second):
        moves |= np.ptp(frame.positions, axis=0) > 0
        if frame.velocities is not None:
            moves |= (frame.velocities != 0).any(axis=0)
    if first.positions.shape == second.positions.shape:
        moves |= (first.positions != second.positions).any(axis=0)
    return tuple(int(axis) for axis in np.flatnonzero(moves)) or (0, 1, 2)


def _species(first: Frame, scene: Scene | None) -> tuple[Integers, tuple[str, ...]]:
    types = first.types
    if scene is not None and scene.species is not None:
        types = np.array(scene.species)
    if types is None:
        return np.zeros(len(first.ids), dtype=np.int64), ("all",)
    names, numbers = np.unique(types, return_inverse=True)
    return numbers.astype(np.int64), tuple(map(str, names)) if len(names) > 1 else ("all",)


def _masses(
    source: Source,
    first: Frame,
    scene: Scene | None,
    options: Options,
    names: tuple[str, ...],
    species: Integers,
) -> tuple[Floats | None, list[str]]:
    """Masses (N,), and what is to be said of them."""
    number = len(first.ids)
    if options.masses:
        types = np.zeros(number) if first.types is None else first.types
        known = sorted({str(one) for one in types}) if first.types is not None else ["all"]
        missing = [name for name in known if name not in options.masses]
        unknown = [name for name in options.masses if name not in known]
        if missing or unknown:
            raise UsageError(
                f"--mass: {shown_path(source.path)} has the types {', '.join(known)}: give one for each of them"
            )
        return np.array([options.masses[str(one) if first.types is not None else "all"] for one in types]), []
    if scene is not None:
        return np.broadcast_to(np.asarray(scene.masses, dtype=np.float64), (number,)).copy(), []
    if first.masses is not None:
        return first.masses, []
    if len(names) == 1:
        return np.ones(number), ["the file states no masses: they are taken as 1."]
    return None, []


def _ensemble(scene: Scene) -> Ensemble:
    """What the words of a scene make of its runs."""
    if scene.lennard_jones is None and scene.hard_spheres is None:
        return "none"  # springs and planets: regular motion
    spheres = scene.hard_spheres
    if spheres is not None and float(np.min(np.atleast_1d(spheres.diameter))) == 0:
        return "none"  # points never meet: they keep the velocities that they have
    if any(boundary == "open" for axis, boundary in enumerate(scene.boundaries) if axis not in scene.across):
        return "none"  # particles fly away
    takes = changes_energy(scene, _method(scene))
    if not takes:
        return "none" if scene.acceleration is not None else "nve"
    return "nvt" if set(takes) == {"box.faces.temperature"} and _wall_temperature(scene) is not None else "none"


def _wall_temperature(scene: Scene) -> float | None:
    """The temperature of the thermal walls, if it is one; the other walls may be elastic and at rest."""
    found = {face.temperature for face in scene.faces if face is not None and face.temperature is not None}
    return found.pop() if len(found) == 1 else None


def _method(scene: Scene) -> Method:
    return scene.method or Method(scheme="any")


def _temperature(text: str, source: Source, *, unknown_masses: bool) -> float:
    """k_B T in the file's mass velocity^2, from a number in that unit or in kelvin; then masses must be known."""
    match = re.fullmatch(r"([0-9.eE+-]+?)\s*(K?)", text.strip())
    try:
        value = float(match[1]) if match else float("nan")
    except ValueError:
        value = float("nan")
    if not 0 < value < float("inf"):
        raise UsageError(f"--temperature {text}: give a number above 0 in mass velocity^2 of the file, or as 300K")
    if match is None or not match[2]:
        return value
    if unknown_masses:
        raise UsageError(f"--temperature {text}: {shown_path(source.path)} states no masses: give --mass TYPE=MASS")
    return in_energy(value, source)


def _clock(source: Source, scene: Scene | None) -> Clock:
    units = source.units
    dt = None if scene is None or scene.method is None else scene.method.dt
    if np.isfinite(source.times).all() and units.time != "step":
        same = units.velocity in ("", f"{units.length}/{units.time}")
        return Clock(source.times, "time", same)
    if source.steps is not None and dt is not None:
        return Clock(np.asarray(source.steps * dt, dtype=np.float64), "time", True)
    if source.steps is not None:
        return Clock(source.steps.astype(np.float64), "step", False)
    return Clock(np.arange(len(source), dtype=np.float64), "frame", False)


def _conserved(scene: Scene | None, first: Frame, ensemble: Ensemble, diameters: Floats | None) -> Conserved:
    if scene is not None:
        return _conserved_in(scene)
    if ensemble != "nve":
        return Conserved((_UNKNOWN, _UNKNOWN, _UNKNOWN), _UNKNOWN, _UNKNOWN, _UNKNOWN)
    walls = ["", "", ""]
    if first.box is not None:
        for axis in range(3):
            if first.box.vectors[axis].any() and not first.box.periodic[axis]:
                walls[axis] = f"the box is not periodic along {AXES[axis]}, and a wall may take it up"
    angular = "" if first.box is None else "a box is not isotropic"
    unknown = "the interaction is not known (--scene states it)"
    return Conserved((walls[0], walls[1], walls[2]), angular, unknown, unknown)


def _conserved_in(scene: Scene) -> Conserved:
    """What the words of a scene say."""
    method, spheres = _method(scene), scene.hard_spheres
    takers = [_taker(scene, method, axis) for axis in range(3)]
    momentum = ["" if word is None else f"[{word}] takes momentum" for word in takers]
    takes = changes_energy(scene, method)
    energy = f"[{takes[0]}] takes or gives energy" if takes else ""
    turning = turns(scene, method)
    angular = f"[{turning}] takes it" if isinstance(turning, str) else ""
    if spheres is not None and spheres.friction is not None:
        angular = angular or "rough grains exchange it with their spins"
    kinetic = energy or ("there is a potential energy" if has_potential(scene, method) else "")
    if spheres is not None and method.contact is not None:
        energy = energy or "the energy of soft contacts is not computed"
    return Conserved((momentum[0], momentum[1], momentum[2]), angular, kinetic, energy)


def _taker(scene: Scene, method: Method, axis: int) -> str | None:
    """The word that takes momentum along an axis, a uniform field among them; None: nothing does."""
    if axis >= scene.dimension:
        return None
    if scene.acceleration is not None and scene.acceleration[axis] != 0:
        return "acceleration"
    return changes_momentum(scene, method, axis)
