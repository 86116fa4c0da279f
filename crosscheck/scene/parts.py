"""The words of a scene: its tables and their entries, each with what it demands of itself."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, model_validator

from crosscheck.errors import UsageError
from crosscheck.scene import observables

Floats: TypeAlias = NDArray[Any]
Positive = Annotated[float, Field(gt=0)]
NonNegative = Annotated[float, Field(ge=0)]
Restitution = Annotated[float, Field(ge=0, le=1)]
Index = Annotated[int, Field(ge=0)]
Vector: TypeAlias = tuple[float, ...]
AXES = "xyz"


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


#: Rules of a wall site of a lattice gas; x and y: of the wall's normal.
WallRule = Literal["bounce_back", "specular_x", "specular_y", "diffusive_x", "diffusive_y"]


class Obstacle(Part):
    """Wall sites of a lattice gas: a block, a disk, or a list of sites.

    columns, rows: first and last of a block, both; each defaults to all. centre, radius: in links, row r being at
    height r times the distance of rows. sites: (column, row). rule: no slip, smooth, or diffusive.
    """

    columns: tuple[Index, Index] | None = None
    rows: tuple[Index, Index] | None = None
    centre: tuple[float, float] | None = None
    radius: Positive | None = None
    sites: tuple[tuple[Index, Index], ...] | None = None
    rule: WallRule = "bounce_back"

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if (self.centre is None) != (self.radius is None):
            raise ValueError("centre and radius go together: give both for a disk, or neither")
        block = self.columns is not None or self.rows is not None
        if block + (self.centre is not None) + (self.sites is not None) != 1:
            raise ValueError("give one of: columns and rows (or one of them), centre and radius, sites")
        if self.sites == ():
            raise ValueError("sites is empty: give at least one (column, row)")
        for name in ("columns", "rows"):
            ends = getattr(self, name)
            if ends is not None and ends[0] > ends[1]:
                raise ValueError(f"{name} = {list(ends)}: the first exceeds the last; swap them")
        return self


class LatticeGas(Part):
    """A lattice gas of this model (see `refimpl.lattice.models`) on rows x columns sites, periodic along both axes.

    Unit of length is the link, of time the step. force: probability in a step that a site's particle in the channel -x
    goes over to +x, if that is empty; negative: the other way. reversals: steps after which all velocities are
    reversed, half-way between two steps.
    """

    model: str
    columns: Annotated[int, Field(gt=0)]
    rows: Annotated[int, Field(gt=0)]
    obstacles: tuple[Obstacle, ...] = ()
    force: Annotated[float, Field(ge=-1, le=1)] | None = None
    reversals: tuple[Annotated[int, Field(gt=0)], ...] | None = None


class Wave(Part):
    """amplitude cos(2 pi (mode_x x/L_x + mode_y y/L_y) + phase), added to the density or a velocity component."""

    of: Literal["density", "velocity_x", "velocity_y"]
    amplitude: float
    mode: tuple[float, float]
    phase: float = 0.0


class Occupations(Part):
    """A lattice gas in local equilibrium (Fermi-Dirac), each channel filled at random with its mean occupation.

    density: mean occupation of a channel, d = rho/b; density and velocities: one number, or one per row. channels:
    instead of them, the mean occupation of each channel. cells: instead of drawing channels one by one, blocks of cells
    x cells sites get exactly round(d b cells^2) particles, placed at random; x/L and y/L of the waves then count cells,
    0 for the first and 1 for the last.
    """

    kind: Literal["occupations"]
    density: float | tuple[float, ...] | None = None
    velocity_x: float | tuple[float, ...] = 0.0
    velocity_y: float | tuple[float, ...] = 0.0
    channels: tuple[Annotated[float, Field(ge=0, le=1)], ...] | None = None
    waves: tuple[Wave, ...] = ()
    cells: Annotated[int, Field(gt=0)] | None = None
    seed: Index

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if (self.density is None) == (self.channels is None):
            raise ValueError("give exactly one of density and channels")
        moving = self.velocity_x != 0 or self.velocity_y != 0
        if self.channels is not None and (moving or self.waves or self.cells is not None):
            raise ValueError("channels say it all: remove velocity_x, velocity_y, waves and cells")
        if self.cells is not None and (moving or any(wave.of != "density" for wave in self.waves)):
            raise ValueError("cells have a number of particles, no velocity: remove cells, or the velocities")
        return self


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


Initial: TypeAlias = Annotated[Explicit | Lattice | Kepler | File | Occupations, Field(discriminator="kind")]
if TYPE_CHECKING:
    Observable: TypeAlias = str
else:
    Observable = Literal[observables.NAMED]


class Output(Part):
    """What is recorded; nothing is taken that is not named here.

    Samples at the start and at every `interval` of time; or, of hard spheres, right after the pair collisions counted
    in `collisions`, at the last of which the run ends. fields: a grid of cells over the box, on which the hydrodynamic
    fields of hard spheres are measured over the whole run; of lattice gases, blocks along x and y, for `populations`.
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


class Contact(Part):
    """What a method with time steps makes of hard spheres: spheres that overlap, and push each other apart.

    law: of the overlap delta, F = k delta ("hooke") or k sqrt(R_eff delta) delta ("hertz"), with a dashpot that gives
    the scene's restitution. stiffness: k; or, of "hooke", duration: t_c, for which two grains of the smallest mass
    touch, t_c^2 = (pi^2 + ln^2 alpha) m/(2 k). friction: a tangential spring that remembers its stretch ("history") or
    a tangential dashpot ("dashpot"), either up to Coulomb's limit. resolution: dt/t_c, in place of `dt`, which is then
    the largest step up to it that divides the time between samples.
    """

    law: Literal["hooke", "hertz"] = "hooke"
    stiffness: Positive | None = None
    duration: Positive | None = None
    friction: Literal["history", "dashpot"] = "history"
    resolution: Positive | None = None

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if (self.stiffness is None) == (self.duration is None):
            raise ValueError("give exactly one of stiffness and duration")
        if self.law == "hertz" and (self.duration is not None or self.resolution is not None):
            raise ValueError('law = "hertz": grains touch longer the slower they are: give stiffness, and method.dt')
        return self


class Method(Part):
    """HOW it is integrated: the scheme's name and its time step, which event-driven schemes have not.

    contact: how hard spheres touch, of schemes that let them overlap.
    """

    scheme: str
    dt: Positive | None = None
    contact: Contact | None = None

    @model_validator(mode="after")
    def _one_step(self) -> Self:
        if self.dt is not None and self.contact is not None and self.contact.resolution is not None:
            raise ValueError("dt and contact.resolution both say how long a step is: remove one")
        return self

    @property
    def step(self) -> float:
        """dt; UsageError without one."""
        if self.dt is None:
            raise UsageError(f"method.dt is missing: scheme '{self.scheme}' takes time steps: add dt, as in dt = 0.005")
        return self.dt
