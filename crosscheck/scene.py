"""WHAT is simulated: frozen, validated scenes <-> TOML. An absent entry means that the thing is not there.

Quantities are in the scene's own consistent units: reduced for Lennard-Jones, SI where a documented case is in SI.
"""

from __future__ import annotations

import difflib
import json
import math
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, Self, TypeAlias, get_args

import numpy as np
import tomli_w
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from crosscheck.errors import UsageError
from crosscheck.overlaps import find_overlap

Floats: TypeAlias = NDArray[Any]
Positive = Annotated[float, Field(gt=0)]
NonNegative = Annotated[float, Field(ge=0)]
Restitution = Annotated[float, Field(ge=0, le=1)]
Index = Annotated[int, Field(ge=0)]
Vector: TypeAlias = tuple[float, ...]
AXES = "xyz"
#: Particles that overlap by less, in diameters, touch: so much is left by a former run's clock, or a file's digits.
TOUCHING = 1e-9


class Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class Wall(Part):
    """12-6 walls on both faces of every axis whose boundary is "wall": 4 epsilon ((sigma/z)^12 - (sigma/z)^6).

    Cut, with the energy shifted to zero, at the distance `cutoff` from the face.
    """

    epsilon: Positive = 1.0
    sigma: Positive = 1.0
    cutoff: Positive


class Friction(Part):
    """Tangential rule of a contact: sticking, v'_ct = alpha_t v_ct, unless the impulse exceeds Coulomb's limit.

    tangential_restitution: alpha_t, +1 smooth, -1 perfectly rough (the opposite sign of the common beta). static,
    sliding: mu_s >= mu_k, ratios of the tangential to the normal impulse; absent: no limit, every contact sticks.
    """

    tangential_restitution: Annotated[float, Field(ge=-1, le=1)]
    static: NonNegative | None = None
    sliding: NonNegative | None = None

    @model_validator(mode="after")
    def _coulomb(self) -> Self:
        if (self.static is None) != (self.sliding is None):
            raise ValueError("static and sliding go together: give both, or neither for contacts that always stick")
        if self.static is not None and self.sliding is not None and self.sliding > self.static:
            raise ValueError(f"sliding = {self.sliding:g} exceeds static = {self.static:g}: make it smaller")
        return self


class GrainFriction(Friction):
    """Friction between grains, which then rotate. inertia: q in I = q m R^2; absent: 2/5 (3D) or 1/2 (2D)."""

    inertia: Positive | None = None


class Well(Part):
    """Square well (depth > 0) or shoulder (depth < 0) to `range` times the contact distance."""

    depth: float
    range: Annotated[float, Field(gt=1)]


class HardSpheres(Part):
    """Hard disks or spheres, which touch at the mean of their diameters; between collisions they fly freely.

    diameter: one, or one per species; particles of diameter 0 never hit each other. restitution: normal, of pairs.
    fixed: species that never move. contact_duration: t_c of the TC model (Luding & McNamara, Granular Matter 1, 113
    (1998)): a particle whose last collision is more recent collides elastically.
    """

    diameter: NonNegative | tuple[NonNegative, ...] = 1.0
    restitution: Restitution = 1.0
    fixed: tuple[Index, ...] | None = None
    contact_duration: Positive | None = None
    friction: GrainFriction | None = None
    well: Well | None = None

    @model_validator(mode="after")
    def _consistent(self) -> HardSpheres:
        if self.friction is not None and 0.0 in np.atleast_1d(self.diameter):
            raise ValueError("diameter = 0 with [hard_spheres.friction]: a point has no surface to rub: remove one")
        return self


class RandomPhase(Part):
    """Limit of a vibrating wall of small amplitude and high frequency: velocity `speed` sin(phase), phase at random.

    law: of the phase, "uniform", or "flux": weighted by the speed at which particle and wall approach.
    """

    speed: Positive
    law: Literal["uniform", "flux"] = "flux"


class Oscillation(Part):
    """Displacement into the box: amplitude cos(frequency t + phase), with the angular frequency."""

    amplitude: Positive
    frequency: Positive
    phase: float = 0.0


class Face(Part):
    """Rule of one face of a "hard" axis. Without entries: at rest, elastic and smooth.

    open: no wall on this side. restitution: a in v'_n = (1 + a) V_p - a v_n. At most one of velocity (V_p always, into
    the box: the sawtooth limit), random_phase, oscillation and temperature (a thermal wall: velocities are drawn anew).
    """

    open: bool = False
    restitution: Restitution = 1.0
    velocity: NonNegative | None = None
    random_phase: RandomPhase | None = None
    oscillation: Oscillation | None = None
    temperature: Positive | None = None
    friction: Friction | None = None

    @model_validator(mode="after")
    def _consistent(self) -> Face:
        motions = ("velocity", "random_phase", "oscillation", "temperature")
        given = [name for name in motions if getattr(self, name) is not None]
        if len(given) > 1:
            raise ValueError(f"give at most one of {', '.join(motions)}; found {' and '.join(given)}")
        if self.open and (given or self.friction is not None or self.restitution != 1.0):
            raise ValueError("open = true means that there is no wall: remove the other entries")
        if self.temperature is not None and (self.friction is not None or self.restitution != 1.0):
            raise ValueError("temperature: a thermal wall draws velocities anew: remove restitution and friction")
        return self


class Cylinder(Part):
    """Circular wall (2D), or cylinder along `axis` (3D), about the middle of the box; turns at angular_velocity."""

    radius: Positive
    axis: Literal["x", "y", "z"] | None = None
    angular_velocity: float = 0.0
    restitution: Restitution = 1.0
    friction: Friction | None = None

    @model_validator(mode="after")
    def _consistent(self) -> Cylinder:
        if self.angular_velocity != 0 and self.friction is None:
            raise ValueError(
                f"angular_velocity = {self.angular_velocity:g}: a smooth wall drags nothing: add friction, or remove it"
            )
        return self


class Box(Part):
    """The domain [0, L) along each axis.

    Give `lengths`; or, for a cube (square) that holds the particles, their `density` or `packing_fraction` (volume of
    the hard spheres, or area of the disks, over that of the box). faces: rules of the faces "x-", "x+", "y-" ... of
    "hard" axes.
    """

    lengths: tuple[Positive, ...] | None = None
    density: Positive | None = None
    packing_fraction: Annotated[float, Field(gt=0, lt=1)] | None = None
    boundaries: tuple[Literal["periodic", "wall", "open", "hard"], ...] | None = None
    wall: Wall | None = None
    faces: dict[str, Face] | None = None
    cylinder: Cylinder | None = None

    @model_validator(mode="after")
    def _consistent(self) -> Box:
        if sum(size is not None for size in (self.lengths, self.density, self.packing_fraction)) != 1:
            raise ValueError("give exactly one of lengths, density and packing_fraction")
        if ("wall" in (self.boundaries or ())) != (self.wall is not None):
            raise ValueError('a boundary "wall" and the table [box.wall] go together: give both or neither')
        if {"wall", "open"} <= set(self.boundaries or ()):
            raise ValueError(
                'boundaries "wall" and "open" cannot be mixed in one box: make the open axis long and walled'
            )
        return self


class Spring(Part):
    """m a = -k r - gamma v about the origin; no gamma, no damping."""

    k: Positive
    gamma: NonNegative | None = None


class Gravity(Part):
    """Newton's gravity between all pairs; no softening unless given (a length)."""

    G: Positive = 1.0
    softening: Positive | None = None


class LennardJones(Part):
    """phi(r) = 4 epsilon ((sigma/r)^12 - (sigma/r)^6) to `cutoff`; `length` is sigma, or r_m = 2^(1/6) sigma.

    epsilon and length: one value, or one per species (mixed by Lorentz and Berthelot). truncation: "truncated" (plain),
    "shifted" (energy zero at the cutoff) or "force_shifted" (energy and force zero there). tail_corrections: add the
    long-range corrections, for g(r) = 1 beyond the cutoff, to energy and pressure.
    """

    epsilon: Positive | tuple[Positive, ...] = 1.0
    length: Positive | tuple[Positive, ...] = 1.0
    length_form: Literal["sigma", "r_m"] = "sigma"
    cutoff: Positive
    truncation: Literal["truncated", "shifted", "force_shifted"] = "truncated"
    tail_corrections: bool = False


class Explicit(Part):
    """Positions, velocities and angular velocities, one row a particle; both velocities default to rest.

    angular_velocities: rows of one number in the plane, three in space.
    """

    kind: Literal["explicit"] = "explicit"
    positions: tuple[Vector, ...]
    velocities: tuple[Vector, ...] | None = None
    angular_velocities: tuple[Vector, ...] | None = None


class Lattice(Part):
    """`number` sites of a lattice in the box, inside of its hard walls; no rotation.

    temperature: Maxwell velocities, total momentum zero, temperature exact; with fixed particles, of those that move,
    whose momentum is not removed. speed: instead, the same for all that move, directions at random.
    """

    kind: Literal["lattice"]
    structure: Literal["fcc", "sc", "square", "triangular"]
    number: Annotated[int, Field(gt=0)]
    temperature: NonNegative | None = None
    speed: NonNegative | None = None
    seed: Index

    @model_validator(mode="after")
    def _consistent(self) -> Lattice:
        if (self.temperature is None) == (self.speed is None):
            raise ValueError("give exactly one of temperature and speed")
        return self


class Kepler(Part):
    """Two bodies at apocentre on the x axis, centre of mass at rest at the origin."""

    kind: Literal["kepler"]
    semi_major_axis: Positive = 1.0
    eccentricity: Annotated[float, Field(ge=0, lt=1)]


class File(Part):
    """A configuration file: .npz with `positions` (N, d), or any format that ASE reads.

    Optional in .npz: `velocities` (N, d), `angular_velocities` (N, 1 | 3).
    """

    kind: Literal["file"]
    path: str


Initial: TypeAlias = Annotated[Explicit | Lattice | Kepler | File, Field(discriminator="kind")]
#: Of hard spheres only, and returned in `Run.tallies`; all but rotational_energy accumulate from the start of the run.
Tally = Literal[
    "collisions",
    "events",
    "collisional_virial",
    "dissipated_energy",
    "wall_impulse",
    "wall_energy",
    "wall_collisions",
    "wall_torque",
    "kinetic_energy_integral",
    "potential_energy_integral",
    "operation_counts",
    "rotational_energy",
]
TALLIES: tuple[str, ...] = get_args(Tally)
Observable = Literal["kinetic_energy", "potential_energy", "virial", Tally]


class Output(Part):
    """What is recorded; nothing is taken that is not named here.

    Samples at the start and at every `interval` of time; or, of hard spheres, right after the pair collisions counted
    in `collisions`, at the last of which the run ends. fields: a grid of cells over the box, on which the hydrodynamic
    fields of hard spheres are measured over the whole run.
    """

    interval: Positive | None = None
    collisions: tuple[Annotated[int, Field(gt=0)], ...] | None = None
    observables: tuple[Observable, ...] = ()
    trajectory: bool = False
    forces: bool = False  # on every particle, at the end
    fields: tuple[Annotated[int, Field(gt=0)], ...] | None = None

    @model_validator(mode="after")
    def _consistent(self) -> Output:
        if self.collisions is not None:
            if self.interval is not None:
                raise ValueError("interval and collisions both say when to record: remove one")
            if not self.collisions:
                raise ValueError("collisions is empty: give the counts after which to record, as [100, 200]")
            for before, after in zip(self.collisions, self.collisions[1:], strict=False):
                if after <= before:
                    raise ValueError(f"collisions must increase: found {after} after {before}")
        return self


class Method(Part):
    """HOW it is integrated: the scheme's name and its time step, which event-driven schemes have not."""

    scheme: str
    dt: Positive | None = None

    @property
    def step(self) -> float:
        """dt; UsageError without one."""
        if self.dt is None:
            raise UsageError(f"method.dt is missing: scheme '{self.scheme}' takes time steps: add dt, as in dt = 0.005")
        return self.dt


class State(NamedTuple):
    """The initial state of N particles in d dimensions.

    positions, velocities (N, d); masses (N,); species (N,) or None; lengths (d,) or None; of hard spheres: diameters
    (N,), and, if they rotate, angular_velocities (N, 1) in the plane, (N, 3) in space.
    """

    positions: Floats
    velocities: Floats
    masses: Floats
    species: NDArray[np.int64] | None
    lengths: Floats | None
    diameters: Floats | None = None
    angular_velocities: Floats | None = None


class Scene(Part):
    """A scene: dimension, particles, one interaction, box, initial state, duration and output.

    acceleration: a uniform field, of hard spheres. seed: of what walls draw during the run (thermal velocities, random
    phases); absent: that of the initial lattice.
    """

    name: str
    dimension: Literal[1, 2, 3]
    duration: NonNegative
    masses: Positive | tuple[NonNegative, ...] = 1.0
    species: tuple[Index, ...] | None = None
    acceleration: Vector | None = None
    seed: Index | None = None
    spring: Spring | None = None
    lennard_jones: LennardJones | None = None
    gravity: Gravity | None = None
    hard_spheres: HardSpheres | None = None
    box: Box | None = None
    initial: Initial
    output: Output = Output()
    method: Method | None = None

    @model_validator(mode="after")
    def _consistent(self) -> Scene:
        interactions = ("spring", "lennard_jones", "gravity", "hard_spheres")
        given = [name for name in interactions if getattr(self, name) is not None]
        if len(given) != 1:
            found = " and ".join(given) or "none"
            names = ", ".join(f"[{name}]" for name in interactions)
            raise ValueError(f"give exactly one of {names}; found {found}")
        if given[0] in ("lennard_jones", "hard_spheres") and self.dimension == 1:
            raise ValueError(f"[{given[0]}] needs dimension 2 or 3")
        if self.gravity is None and isinstance(self.masses, tuple) and 0.0 in self.masses:
            raise ValueError("masses: a particle without mass moves with [gravity] only; give it one")
        if self.box is not None:
            for key in ("lengths", "boundaries"):
                value = getattr(self.box, key)
                if value is not None and len(value) != self.dimension:
                    raise ValueError(f"box.{key} needs {self.dimension} entries, found {len(value)}")
        if self.box is not None and self.lennard_jones is None and self.hard_spheres is None:
            raise ValueError(
                "[box] goes with [lennard_jones] or [hard_spheres]; springs and gravity act in open space: remove [box]"
            )
        if isinstance(self.initial, Explicit):
            _check_rows(self.initial, self.dimension)
        if isinstance(self.initial, Lattice) and self.box is None:
            raise ValueError("initial.kind = 'lattice' fills a box: add [box]")
        recorded = self.output.observables or self.output.trajectory
        if self.output.interval is None and self.output.collisions is None and recorded:
            raise ValueError("output.interval is missing: say how often to record")
        if self.hard_spheres is None:
            _refuse_hard_spheres_entries(self)
        else:
            _check_hard_spheres(self, self.hard_spheres)
        return self

    # -- reading and writing -----------------------------------------------------------------------

    @classmethod
    def from_json(cls, text: str, where: str = "scene") -> Scene:
        """The scene in a JSON text; UsageError names the path of every wrong key."""
        try:
            return cls.model_validate_json(text)
        except ValidationError as error:
            raise UsageError(_explain(error, where)) from None

    @classmethod
    def load(cls, path: str | Path) -> Scene:
        """The scene in a TOML file, with `initial.kind = "file"` read into it."""
        path = Path(path)
        try:
            table = tomllib.loads(path.read_text(encoding="utf-8"))
        except OSError as error:
            raise UsageError(f"{path}: cannot be read ({error.strerror}); give the path of a scene file") from None
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
            raise UsageError(f"{path}: not valid TOML: {error}") from None
        scene = cls.from_json(json.dumps(table, default=str), str(path))
        if isinstance(scene.initial, File):
            scene = scene.changed(initial=_read_configuration(path.parent / scene.initial.path, scene.dimension))
        return scene

    def to_json(self) -> str:
        return self.model_dump_json(exclude_none=True)

    def to_toml(self) -> str:
        """TOML that `load` reads back to an equal scene."""
        return tomli_w.dumps(json.loads(self.to_json()))

    def changed(self, **changes: Any) -> Scene:
        """A validated copy with some entries replaced."""
        return Scene.from_json(self.model_copy(update=changes).to_json())

    # -- what engines need -------------------------------------------------------------------------

    @property
    def number(self) -> int:
        """Number of particles."""
        if isinstance(self.initial, Explicit):
            return len(self.initial.positions)
        if isinstance(self.initial, Lattice):
            return self.initial.number
        return 2

    @property
    def boundaries(self) -> tuple[str, ...]:
        """Of each axis; periodic where a box does not say."""
        if self.box is None:
            return ("open",) * self.dimension
        return self.box.boundaries or ("periodic",) * self.dimension

    def lengths(self) -> Floats | None:
        if self.box is None:
            return None
        if self.box.lengths is not None:
            return np.array(self.box.lengths)
        if self.box.packing_fraction is not None:
            diameters = self.diameters()
            assert diameters is not None
            unit = math.pi / 4 if self.dimension == 2 else math.pi / 6
            volume = unit * float((diameters**self.dimension).sum()) / self.box.packing_fraction
            if volume == 0:
                fraction = self.box.packing_fraction
                raise UsageError(f"box.packing_fraction = {fraction:g} needs particles with a diameter: give density")
        else:
            assert self.box.density is not None
            volume = self.number / self.box.density
        return np.full(self.dimension, volume ** (1.0 / self.dimension))

    def samples(self) -> Floats:
        """Times at which an event-driven run is recorded.

        The start and every `output.interval` up to the duration; without one, start and end. With `output.collisions`,
        the start and a NaN per count: the run tells when it was.
        """
        output = self.output
        if output.collisions is not None:
            return np.concatenate([[0.0], np.full(len(output.collisions), np.nan)])
        if output.interval is None:
            return np.array([0.0, self.duration])
        ratio = self.duration / output.interval
        whole = round(ratio) if abs(ratio - round(ratio)) <= 1e-9 * max(1.0, ratio) else math.floor(ratio)
        return np.minimum(np.arange(whole + 1) * output.interval, self.duration)

    def diameters(self) -> Floats | None:
        """Of the hard spheres, (N,); None in other scenes."""
        if self.hard_spheres is None:
            return None
        of_species = np.atleast_1d(self.hard_spheres.diameter)
        if of_species.size == 1:
            return np.full(self.number, of_species[0])
        return of_species[self._species()]

    def fixed(self) -> NDArray[np.bool_]:
        """Which particles never move, (N,)."""
        species = None if self.hard_spheres is None else self.hard_spheres.fixed
        if species is None:
            return np.zeros(self.number, dtype=bool)
        return np.isin(self._species(), species)

    def _species(self) -> NDArray[np.int64]:
        """Of each particle; UsageError if their number is not that of the particles."""
        species = np.array(self.species or (), dtype=np.int64)
        if species.size != self.number:
            raise UsageError(f"species: {species.size} values for {self.number} particles; give one per particle")
        return species

    @property
    def faces(self) -> tuple[Face | None, ...]:
        """The plane walls of hard spheres, one entry a face, x-, x+, y-, y+ ...; None: no wall on this side."""
        rules = {} if self.box is None or self.box.faces is None else self.box.faces
        faces = [
            rules.get(f"{axis}{side}", Face()) if boundary == "hard" else None
            for axis, boundary in zip(AXES, self.boundaries, strict=False)
            for side in "-+"
        ]
        return tuple(None if face is None or face.open else face for face in faces)

    @property
    def across(self) -> tuple[int, ...]:
        """The two axes across the cylinder; none without one."""
        if self.box is None or self.box.cylinder is None:
            return ()
        return tuple(axis for axis in range(self.dimension) if AXES[axis] != self.box.cylinder.axis)

    @property
    def spin_dimension(self) -> int:
        """Components of an angular velocity: 0 if nothing rotates, 1 in the plane, 3 in space."""
        if self.hard_spheres is None or self.hard_spheres.friction is None:
            return 0
        return 1 if self.dimension == 2 else 3

    def volume(self) -> float:
        """Volume (area) of the box; UsageError without one."""
        lengths = self.lengths()
        if lengths is None:
            raise UsageError(f"scene {self.name}: there is no [box], hence no volume")
        return float(np.prod(lengths))

    def steps(self, dt: float) -> int:
        """duration/dt, a whole number."""
        return whole_steps(self.duration, dt, "duration")

    def every(self, dt: float) -> int | None:
        """Steps between samples, a whole number; None if nothing is recorded."""
        if self.output.interval is None or not (self.output.observables or self.output.trajectory):
            return None
        every = whole_steps(self.output.interval, dt, "output.interval")
        if every == 0:
            raise UsageError("output.interval is shorter than method.dt: record less often or take a smaller dt")
        return every

    def initial_state(self) -> State:
        """The initial state, the same for every engine.

        UsageError if counts disagree, if particles coincide or, of hard spheres, overlap or are not inside their walls.
        """
        lengths = self.lengths()
        n = self.number
        masses = np.full(n, self.masses) if isinstance(self.masses, float) else np.array(self.masses)
        if masses.size != n:
            raise UsageError(f"masses: {masses.size} values for {n} particles; give one, or one per particle")
        species = None if self.species is None else self._species()
        diameters, fixed = self.diameters(), self.fixed()
        spins = np.zeros((n, self.spin_dimension)) if self.spin_dimension else None
        if isinstance(self.initial, Explicit):
            positions = np.array(self.initial.positions)
            given = self.initial.velocities
            velocities = np.zeros_like(positions) if given is None else np.array(given)
            if self.initial.angular_velocities is not None:
                spins = np.array(self.initial.angular_velocities)
        elif isinstance(self.initial, Lattice):
            assert lengths is not None
            if diameters is None:
                positions = _lattice(self.initial, lengths)
            else:
                positions = _lattice_inside(self.initial, self, lengths, float(diameters.max()) / 2)
            velocities = _random_velocities(self.initial, masses, self.dimension, fixed)
        elif isinstance(self.initial, Kepler):
            positions, velocities = _apocentre(self.initial, masses, self.gravity, self.dimension)
        else:
            raise UsageError("initial.kind = 'file' is read by Scene.load: load the scene from its file")
        state = State(positions, velocities, masses, species, lengths, diameters, spins)
        if self.hard_spheres is not None:
            _check_hard_state(self, self.hard_spheres, state, fixed)
        elif self.spring is None:
            _refuse_coincidence(positions, lengths, [b == "periodic" for b in self.boundaries])
        return state


def whole_steps(span: float, dt: float, name: str) -> int:
    """span/dt as an integer; UsageError with the nearest dt that divides it, if none does to 1e-9."""
    ratio = span / dt
    if ratio > 2**53:
        raise UsageError(f"{name} = {span:g} is too many steps of method.dt = {dt:g} to be counted: take a larger dt")
    steps = round(ratio)
    if abs(ratio - steps) > 1e-9 * max(1.0, ratio):
        mend = span / max(1, steps)
        raise UsageError(f"{name} = {span:g} is not a whole number of steps of method.dt = {dt:g}; try dt = {mend!r}")
    return steps


def explicit(positions: Floats, velocities: Floats, angular_velocities: Floats | None = None) -> Explicit:
    """Arrays of shape (N, d), and (N, 1 | 3) for the angular velocities, as an initial state."""

    def rows(array: Floats) -> tuple[Vector, ...]:
        return tuple(map(tuple, array.tolist()))

    return Explicit(
        positions=rows(positions),
        velocities=rows(velocities),
        angular_velocities=None if angular_velocities is None else rows(angular_velocities),
    )


def _check_rows(initial: Explicit, dimension: int) -> None:
    if not initial.positions:
        raise ValueError("initial.positions is empty: give at least one particle")
    table = {
        "positions": (initial.positions, dimension),
        "velocities": (initial.velocities, dimension),
        "angular_velocities": (initial.angular_velocities, 1 if dimension == 2 else 3),
    }
    for name, (rows, components) in table.items():
        if rows is None:
            continue
        if len(rows) != len(initial.positions):
            raise ValueError(f"initial.{name} has {len(rows)} rows for {len(initial.positions)} particles")
        for i, row in enumerate(rows):
            if len(row) != components:
                raise ValueError(f"initial.{name}[{i}] has {len(row)} components in dimension {dimension}")


def _refuse_hard_spheres_entries(scene: Scene) -> None:
    """ValueError where an entry that only hard spheres have is given without them."""
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
        **{f"output.observables: '{name}'": name in output.observables for name in TALLIES},
    }
    for entry, given in entries.items():
        if given:
            raise ValueError(f"{entry} goes with [hard_spheres] only, for now: remove it")


def _check_hard_spheres(scene: Scene, spheres: HardSpheres) -> None:
    """ValueError where entries of a scene of hard spheres disagree."""
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


def _check_species(scene: Scene, spheres: HardSpheres) -> None:
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


def _check_walls(scene: Scene, box: Box) -> None:
    if "wall" in scene.boundaries:
        raise ValueError('box.boundaries: a "wall" is for [lennard_jones]; that of hard spheres is called "hard"')
    names = [f"{axis}{side}" for axis in AXES[: scene.dimension] for side in "-+"]
    for name, face in (box.faces or {}).items():
        where = f'box.faces."{name}"'
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


def _check_wall_friction(scene: Scene, where: str, friction: Friction | None) -> None:
    if friction is not None and scene.spin_dimension == 0:
        raise ValueError(f"{where}.friction: smooth grains do not rub on walls: add [hard_spheres.friction]")


def _check_cylinder(scene: Scene, cylinder: Cylinder) -> None:
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


def _check_hard_output(scene: Scene) -> None:
    output = scene.output
    if "virial" in output.observables:
        raise ValueError("output.observables: hard spheres have no 'virial': 'collisional_virial' is that of impulses")
    if output.forces:
        raise ValueError("output.forces: hard spheres exert impulses, not forces: remove it")
    if "rotational_energy" in output.observables and scene.spin_dimension == 0:
        raise ValueError(
            "output.observables: 'rotational_energy' needs [hard_spheres.friction]: smooth grains do not rotate"
        )
    if "wall_torque" in output.observables and not scene.across:
        raise ValueError("output.observables: 'wall_torque' needs [box.cylinder]")
    if output.fields is not None:
        if scene.box is None:
            raise ValueError("output.fields divides a box into cells: add [box]")
        if len(output.fields) != scene.dimension:
            raise ValueError(f"output.fields needs {scene.dimension} entries, found {len(output.fields)}")


def _check_hard_state(scene: Scene, spheres: HardSpheres, state: State, fixed: NDArray[np.bool_]) -> None:
    """UsageError where the initial state of hard spheres is impossible."""
    assert state.diameters is not None
    for name, vectors in (("velocities", state.velocities), ("angular_velocities", state.angular_velocities)):
        if vectors is not None and vectors[fixed].any():
            i = int(np.flatnonzero(fixed & (vectors != 0).any(axis=1))[0])
            raise UsageError(f"initial.{name}[{i}] is not zero: the particle is of a fixed species; make it zero")
    rounding = TOUCHING * float(state.diameters.max() or np.abs(state.positions).max())
    periods = np.zeros(scene.dimension)
    if state.lengths is not None:
        contact = float(state.diameters.max()) * (spheres.well.range if spheres.well is not None else 1.0)
        for axis, boundary in enumerate(scene.boundaries):
            length = float(state.lengths[axis])
            if boundary == "periodic":
                periods[axis] = length
                if length <= 2 * contact:
                    raise UsageError(
                        f"box: its length {length:.6g} along {AXES[axis]}, which is periodic, must exceed two contact "
                        f"ranges, {2 * contact:.6g}: take a larger box"
                    )
        _refuse_beyond_walls(scene, state, rounding)
    overlap = find_overlap(state.positions, state.diameters, fixed, periods, rounding)
    if overlap is not None:
        lattice = isinstance(scene.initial, Lattice)
        raise UsageError(
            f"particles {overlap.i} and {overlap.j} overlap: their centres are {overlap.distance:.9g} apart, and their "
            f"contact distance is {overlap.contact:.9g} (gap {overlap.distance - overlap.contact:.3g}): "
            + ("take fewer particles, smaller ones or a larger box" if lattice else "move one of them")
        )


def _strokes(scene: Scene) -> Floats:
    """Amplitudes of the faces' oscillations, (d, 2)."""
    strokes = [0.0 if face is None or face.oscillation is None else face.oscillation.amplitude for face in scene.faces]
    return np.reshape(strokes, (-1, 2))


def _refuse_beyond_walls(scene: Scene, state: State, rounding: float) -> None:
    assert scene.box is not None
    assert state.lengths is not None
    assert state.diameters is not None
    radii = state.diameters / 2
    room = state.lengths - _strokes(scene).sum(axis=1) - state.diameters.max()
    for axis in np.flatnonzero((room < 0) & _strokes(scene).any(axis=1)).tolist():
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
        gaps = (length - x if upper else x) - wall - radii
        i = int(gaps.argmin())
        if gaps[i] < -rounding:
            raise UsageError(
                f"particle {i} is beyond the wall {AXES[axis]}{'-+'[upper]} by {-gaps[i]:.3g}: its centre must be at "
                f"least {wall + radii[i]:.6g} from {AXES[axis]} = {length if upper else 0.0:g}; it is at {x[i]:.9g}"
            )
    if scene.box.cylinder is not None:
        across, radius = list(scene.across), scene.box.cylinder.radius
        if (2 * radius > state.lengths[across] * (1 + TOUCHING)).any():
            raise UsageError(
                f"box.cylinder.radius = {radius:g} does not fit into the box: make box.lengths across it at least "
                f"{2 * radius:g}"
            )
        distances = np.linalg.norm(state.positions[:, across] - state.lengths[across] / 2, axis=1)
        gaps = radius - distances - radii
        i = int(gaps.argmin())
        if gaps[i] < -rounding:
            raise UsageError(
                f"particle {i} is beyond the cylinder by {-gaps[i]:.3g}: its centre must be within "
                f"{radius - radii[i]:.6g} of the axis; it is {distances[i]:.9g} away"
            )


def _refuse_coincidence(positions: Floats, lengths: Floats | None, periodic: Iterable[bool]) -> None:
    wrapped = positions.copy()
    if lengths is not None:
        for axis, wraps in enumerate(periodic):
            if wraps:
                wrapped[:, axis] %= lengths[axis]
    order = np.lexsort(wrapped.T)
    same = np.flatnonzero((np.diff(wrapped[order], axis=0) == 0).all(axis=1))
    if same.size:
        i, j = sorted(order[same[0] : same[0] + 2])
        raise UsageError(f"particles {i} and {j} are at the same place: move one of them")


_BASES = {
    "fcc": [[0, 0, 0], [0, 0.5, 0.5], [0.5, 0, 0.5], [0.5, 0.5, 0]],
    "sc": [[0, 0, 0]],
    "square": [[0, 0]],
    "triangular": [[0, 0], [0.5, 0.5]],
}


def _lattice(initial: Lattice, lengths: Floats) -> Floats:
    basis, counts = _unit_cells(initial, lengths, initial.number)
    sites = ((_cells(counts)[:, None, :] + basis + 0.25) / counts * lengths).reshape(-1, lengths.size)
    return _spread(sites, initial.number)


def _unit_cells(initial: Lattice, lengths: Floats, number: int) -> tuple[Floats, NDArray[np.int64]]:
    """The basis, and how many unit cells along each axis have at least `number` sites."""
    basis = np.array(_BASES[initial.structure])
    if basis.shape[1] != lengths.size:
        raise UsageError(
            f"initial.structure = '{initial.structure}' fills {basis.shape[1]} dimensions, "
            f"the scene has {lengths.size}: take another structure"
        )
    # unit cells as near to their ideal shape as the box allows; sites are left empty at the end
    cell = np.ones(lengths.size)
    if initial.structure == "triangular":
        cell[1] = 3**0.5
    edge = (np.prod(lengths / cell) * len(basis) / number) ** (1.0 / lengths.size)
    counts = np.maximum(1, np.floor(lengths / (cell * edge) + 1e-9)).astype(int)
    while np.prod(counts) * len(basis) < number:
        counts[np.argmax(lengths / (cell * counts))] += 1
    return basis, counts


def _cells(counts: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, counts.size)


def _spread(sites: Floats, number: int) -> Floats:
    """`number` of the sites, evenly out of their order."""
    keep = np.linspace(0, len(sites) - 1, number).round().astype(int)
    return np.ascontiguousarray(sites[keep])


def _lattice_inside(initial: Lattice, scene: Scene, lengths: Floats, radius: float) -> Floats:
    """Sites for particles of this radius inside hard walls, between which the lattice is compressed where need be."""
    assert scene.box is not None
    cylinder = scene.box.cylinder
    margins = radius + _strokes(scene).max(axis=1)
    across = np.isin(np.arange(scene.dimension), scene.across)
    room = lengths
    if cylinder is not None:
        if cylinder.radius <= radius:
            raise UsageError(f"box.cylinder.radius = {cylinder.radius:g} must exceed that of the particles, {radius:g}")
        room = np.where(across, 2 * (cylinder.radius - radius), lengths)
        margins = np.where(across, (lengths - room) / 2, margins)
    bounded = np.array([boundary == "hard" for boundary in scene.boundaries]) | across
    narrow = bounded & (lengths < 2 * margins)
    if narrow.any():
        axis = int(narrow.argmax())
        raise UsageError(
            f"box: {lengths[axis]:.6g} along {AXES[axis]} is too narrow for a particle of diameter {2 * radius:g} "
            "between its walls: take a larger box"
        )

    def sites(number: int) -> Floats:
        basis, counts = _unit_cells(initial, room, number)
        cells = _cells(counts)[:, None, :] + basis
        # between walls: in the middle, and no nearer to a wall than a particle's surface may be
        last = counts - 1 + basis.max(axis=0)
        width = np.minimum(last / counts * room, lengths - 2 * margins)
        between = (lengths - width) / 2 + width * cells / np.where(last > 0, last, 1)
        return np.where(bounded, between, (cells + 0.25) / counts * lengths).reshape(-1, scene.dimension)

    number, found = initial.number, sites(initial.number)
    while cylinder is not None:
        distances = np.linalg.norm((found - lengths / 2)[:, across], axis=1)
        found = found[distances <= cylinder.radius - radius]
        if len(found) >= initial.number:
            break
        number += max(1, number // 20)
        found = sites(number)
    return _spread(found, initial.number)


def _random_velocities(initial: Lattice, masses: Floats, dimension: int, fixed: NDArray[np.bool_]) -> Floats:
    """Of one temperature or one speed; the fixed ones' are zero, and then the others' total momentum is not."""
    rng = np.random.default_rng(initial.seed)
    velocities = rng.normal(size=(masses.size, dimension))
    velocities[fixed] = 0.0
    if initial.temperature is None:
        norms = np.linalg.norm(velocities, axis=1, keepdims=True)
        return (initial.speed or 0.0) * np.divide(velocities, norms, out=velocities, where=norms > 0)
    velocities /= np.sqrt(masses)[:, None]
    freedom = masses.size - 1 if not fixed.any() else np.count_nonzero(~fixed)
    if freedom == 0 or initial.temperature == 0:
        return np.zeros_like(velocities)
    if not fixed.any():
        velocities -= (masses[:, None] * velocities).sum(axis=0) / masses.sum()
    kinetic = 0.5 * (masses[:, None] * velocities**2).sum()
    return velocities * np.sqrt(0.5 * dimension * freedom * initial.temperature / kinetic)


def _apocentre(initial: Kepler, masses: Floats, gravity: Gravity | None, dimension: int) -> tuple[Floats, Floats]:
    if gravity is None or dimension == 1:
        raise UsageError("initial.kind = 'kepler' needs [gravity] and dimension 2 or 3")
    a, e, total = initial.semi_major_axis, initial.eccentricity, masses.sum()
    if total == 0:
        raise UsageError("masses: one of the two bodies of initial.kind = 'kepler' needs a mass")
    r, v = np.zeros((2, dimension)), np.zeros((2, dimension))
    share = np.array([-masses[1], masses[0]]) / total
    r[:, 0] = share * a * (1 + e)
    v[:, 1] = share * np.sqrt(gravity.G * total * (1 - e) / (a * (1 + e)))
    return r, v


def _read_configuration(path: Path, dimension: int) -> Explicit:
    spins = None
    try:
        if path.suffix == ".npz":
            with np.load(path) as arrays:
                positions = np.asarray(arrays["positions"], dtype=np.float64)
                velocities = np.asarray(arrays.get("velocities", np.zeros_like(positions)), dtype=np.float64)
                if "angular_velocities" in arrays:
                    spins = np.asarray(arrays["angular_velocities"], dtype=np.float64)
        else:
            import ase.io

            atoms = ase.io.read(path)
            assert not isinstance(atoms, list)
            positions, velocities = atoms.get_positions(), atoms.get_velocities()
        positions, velocities = positions[:, :dimension], velocities[:, :dimension]
    except Exception as error:
        raise UsageError(f"initial.path = {path}: cannot be read as a configuration ({error})") from None
    for name, vectors in (("positions", positions), ("velocities", velocities), ("angular_velocities", spins)):
        if vectors is not None and not np.isfinite(vectors).all():
            raise UsageError(f"initial.path = {path}: {name} holds values that are not finite")
    if spins is not None and spins.ndim != 2:
        raise UsageError(f"initial.path = {path}: angular_velocities needs two dimensions, found {spins.ndim}")
    return explicit(positions, velocities, spins)


# -- errors in words -------------------------------------------------------------------------------


_PARTS: dict[str, type[Part]] = {
    "box": Box,
    "wall": Wall,
    "spring": Spring,
    "gravity": Gravity,
    "lennard_jones": LennardJones,
    "hard_spheres": HardSpheres,
    "hard_spheres.friction": GrainFriction,
    "friction": Friction,
    "well": Well,
    "faces": Face,
    "random_phase": RandomPhase,
    "oscillation": Oscillation,
    "cylinder": Cylinder,
    "output": Output,
    "method": Method,
}
_KINDS: dict[str, type[Part]] = {"explicit": Explicit, "lattice": Lattice, "kepler": Kepler, "file": File}
#: How pydantic names the forms of "one value, or one per particle" in the place of an error.
_FORMS = ("constrained-float", "tuple[constrained-float, ...]")


def _explain(error: ValidationError, where: str) -> str:
    """A line for every mistake: the path of the key, what is wrong with it, and the mend."""
    lines: list[str] = []
    meant: set[str] = set()
    # unknown keys first: a key that is misspelt is not missing as well
    for problem in sorted(error.errors(), key=lambda problem: problem["type"] != "extra_forbidden"):
        place, kind, found = problem["loc"], problem["type"], problem["input"]
        # of "one value, or one per particle", the form that was not given has nothing to say
        if place[-1:] == _FORMS[1:] or (place[-1:] == _FORMS[:1] and isinstance(found, list)):
            continue
        keys = [str(part) for part in place if part not in (*_KINDS, *_FORMS)]
        path = ".".join(keys)
        if kind == "extra_forbidden":
            near, hint = _hint(str(place[-1]), [str(part) for part in place[:-1]])
            meant.add(".".join([*keys[:-1], near]))
            lines.append(f"unknown key '{path}'; {hint}")
        elif kind == "missing":
            if path not in meant:
                lines.append(f"'{path}' is missing: add it")
        elif kind == "union_tag_not_found":
            lines.append(f"'{path}.kind' is missing: add it, one of {', '.join(_KINDS)}")
        elif kind == "union_tag_invalid":
            lines.append(f"{path}.kind: Input should be one of {', '.join(_KINDS)} (found {problem['ctx']['tag']!r})")
        else:
            message = problem["msg"].removeprefix("Value error, ")
            value = f" (found {found!r})" if path and isinstance(found, str | int | float | bool) else ""
            lines.append(f"{path + ': ' if path else ''}{message}{value}")
    return "\n".join(f"{where}: {line}" for line in dict.fromkeys(lines))


def _hint(key: str, place: list[str]) -> tuple[str, str]:
    """The key that was meant, if there is one near in the table at this place, and what to do."""
    parts = {**_PARTS, **_KINDS}
    table = "faces" if place[-2:-1] == ["faces"] else ".".join(place[-2:])
    part = parts.get(table) or parts.get("".join(place[-1:]), Scene)
    near = difflib.get_close_matches(key, part.model_fields, 1)
    if near:
        return near[0], f"did you mean '{near[0]}'?"
    owners = [f"[{name}]" for name, other in _PARTS.items() if key in other.model_fields]
    if key in Scene.model_fields:
        owners.append("the scene itself, above the first table")
    return "", f"it belongs in {' or '.join(owners)}" if owners else "remove it"
