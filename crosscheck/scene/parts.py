"""The tables of a scene as pydantic models, one class a table, each with the checks of its own entries.

Every word of the scene language is declared here once, with its unit and meaning in the string below it. From there
they go into the JSON Schema, the reference page (`crosscheck.documents`) and the hints of error messages.
"""

from __future__ import annotations

from itertools import chain
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, TypeAlias, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from crosscheck.errors import UsageError
from crosscheck.scene import observables
from crosscheck.text import printable

Floats: TypeAlias = NDArray[Any]
#: Sizes of the numbers in a scene. Squares, cubes and products of two of them are far from the ends of the doubles,
#: 1e-308 and 1e308, so that areas, volumes and energies neither vanish nor overflow; SI units are well within.
LEAST, LARGEST = 1e-100, 1e100


def _not_tiny(number: float) -> float:
    """`number`, which may be divided by; ValueError if it is so small that its inverse cube overflows."""
    if number < LEAST:
        raise ValueError(f"out of range: the smallest number above 0 is {LEAST:g} here: take other units")
    return number


Positive = Annotated[float, Field(gt=0), AfterValidator(_not_tiny)]
NonNegative = Annotated[float, Field(ge=0)]
Restitution = Annotated[float, Field(ge=0, le=1)]
#: An index that every engine can hold, in 32 bits with a sign.
Index = Annotated[int, Field(ge=0, le=2**31 - 1)]
#: A number that a double holds exactly.
Count = Annotated[int, Field(gt=0, le=2**53)]
#: A seed that fits into 64 bits with a sign.
Seed = Annotated[int, Field(ge=0, le=2**63 - 1)]
Vector: TypeAlias = tuple[float, ...]
AXES = "xyz"


class Part(BaseModel):
    """A table of a scene: frozen; unknown keys, NaN and infinities are refused, as are numbers above 1e100.

    The string below an entry says "[unit] what it is; absent: what holds without it". [1] is a number without a unit;
    an entry that is no quantity (a name, a switch, a table) has no unit. Temperatures are energies: k_B = 1.
    """

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, allow_inf_nan=False, use_attribute_docstrings=True
    )

    @model_validator(mode="after")
    def _in_range(self) -> Self:
        for name, value in self.__dict__.items():
            if isinstance(value, float):
                largest = abs(value)
            elif isinstance(value, tuple) and value:
                numbers = chain.from_iterable(value) if isinstance(value[0], tuple) else iter(value)
                first = next(numbers, None)
                # the entries of a list are all of one type
                largest = max(abs(first), max(map(abs, numbers), default=0.0)) if isinstance(first, float) else 0.0
            else:
                continue
            if largest > LARGEST:
                raise ValueError(f"{name}: {largest:g} is out of range: the largest number is {LARGEST:g} here")
        return self


class Interaction(Part):
    """A table that is an interaction, of which a scene has exactly one."""


class Wall(Part):
    """12-6 walls on both faces of every axis whose boundary is "wall": 4 epsilon ((sigma/z)^12 - (sigma/z)^6).

    z is the distance from the face. The potential is cut, and its energy shifted to zero, at z = cutoff.
    """

    epsilon: Positive = 1.0
    """[energy] Depth epsilon of the minimum."""
    sigma: Positive = 1.0
    """[length] Distance sigma at which the uncut potential is zero."""
    cutoff: Positive
    """[length] Distance from the face beyond which the wall exerts no force."""


class Friction(Part):
    """Tangential rule of a collision: sticking, v'_ct = alpha_t v_ct, unless the impulse exceeds Coulomb's limit.

    v_ct and v'_ct are the tangential velocities of the two surfaces at the point of contact, before and after. A
    tangential impulse above `static` times the normal one is replaced by `sliding` times the normal one.
    """

    tangential_restitution: Annotated[float, Field(ge=-1, le=1)]
    """[1] alpha_t: 1 for smooth surfaces, -1 for perfectly rough ones (the opposite sign of the common beta)."""
    static: NonNegative | None = None
    """[1] Coefficient of static friction mu_s; absent: no limit, every contact sticks."""
    sliding: NonNegative | None = None
    """[1] Coefficient of sliding friction mu_k, at most mu_s, and given together with it; absent: no limit."""

    @model_validator(mode="after")
    def _coulomb(self) -> Self:
        if (self.static is None) != (self.sliding is None):
            raise ValueError("static and sliding go together: give both, or neither for contacts that always stick")
        if self.static is not None and self.sliding is not None and self.sliding > self.static:
            raise ValueError(f"sliding = {self.sliding:g} exceeds static = {self.static:g}: make it smaller")
        return self


class GrainFriction(Friction):
    """Friction between grains; with this table they rotate."""

    inertia: Positive | None = None
    """[1] q in the moment of inertia I = q m R^2; absent: 2/5 in space (a ball), 1/2 in the plane (a disk)."""


class Well(Part):
    """Square well around hard spheres: the potential is -depth from contact to `range` times the contact distance."""

    depth: float
    """[energy] Positive: an attractive well; negative: a repulsive shoulder."""
    range: Annotated[float, Field(gt=1)]
    """[1] Outer edge of the well, in units of the contact distance."""


class HardSpheres(Interaction):
    """Hard disks (2D) or spheres (3D). Two touch at the mean of their diameters; between collisions they fly freely.

    The normal velocity after a collision is v'_n = -restitution v_n.
    """

    diameter: NonNegative | tuple[NonNegative, ...] = 1.0
    """[length] One for all, or one per species; particles of diameter 0 never hit each other."""
    restitution: Restitution = 1.0
    """[1] Coefficient of normal restitution between particles; 1 is elastic."""
    fixed: tuple[Index, ...] | None = None
    """Species whose particles never move; absent: all move."""
    contact_duration: Positive | None = None
    """[time] t_c of the TC model (Luding & McNamara, Granular Matter 1, 113 (1998)): a particle that collided less than
    t_c ago collides elastically; absent: every collision has the restitution."""
    friction: GrainFriction | None = None
    """Friction between particles; absent: they are smooth and do not rotate."""
    well: Well | None = None
    """Square well around each particle; absent: none."""

    @model_validator(mode="after")
    def _consistent(self) -> HardSpheres:
        if self.friction is not None and 0.0 in np.atleast_1d(self.diameter):
            raise ValueError("diameter = 0 with [hard_spheres.friction]: a point has no friction: remove one of them")
        return self


class RandomPhase(Part):
    """A vibrating wall in the limit of small amplitude and high frequency.

    It stays in place; its velocity at a collision is speed sin(phase), with a phase drawn anew for each collision.
    """

    speed: Positive
    """[length/time] Largest speed of the wall."""
    law: Literal["uniform", "flux"] = "flux"
    """Distribution of the phase: uniform, or weighted by the speed at which particle and wall approach ("flux")."""


class Oscillation(Part):
    """A wall that oscillates: its displacement into the box is amplitude cos(frequency t + phase)."""

    amplitude: Positive
    """[length] Largest displacement."""
    frequency: Positive
    """[1/time] Angular frequency, 2 pi over the period."""
    phase: float = 0.0
    """[rad] Phase at t = 0."""


class Face(Part):
    """Wall of hard spheres on one face of a "hard" axis. Without entries it is at rest, elastic and smooth.

    v'_n = (1 + a) V_p - a v_n, with the restitution a and the velocity V_p of the wall along its normal. At most one of
    velocity, random_phase, oscillation and temperature.
    """

    open: bool = False
    """true: no wall on this side."""
    restitution: Restitution = 1.0
    """[1] Coefficient of normal restitution a; 1 is elastic."""
    velocity: NonNegative | None = None
    """[length/time] Velocity V_p into the box at every collision, of a wall that stays in place (the limit of a
    vibration by a sawtooth of small amplitude); absent: at rest."""
    random_phase: RandomPhase | None = None
    """Velocity of a vibration with random phase; absent: none."""
    oscillation: Oscillation | None = None
    """Oscillation of finite amplitude; absent: none."""
    temperature: Positive | None = None
    """[energy] A thermal wall: the velocity after a collision is drawn anew at this temperature; absent: not
    thermal."""
    friction: Friction | None = None
    """Friction of particles on this wall; absent: smooth."""

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
    """Circular wall (2D), or cylinder along `axis` (3D), about the middle of the box, with hard spheres inside.

    The axes across it must be "open".
    """

    radius: Positive
    """[length] Radius of the wall."""
    axis: Literal["x", "y", "z"] | None = None
    """Axis of the cylinder in space; absent: in the plane, where it is a circle."""
    angular_velocity: float = 0.0
    """[1/time] Angular velocity; positive turns the first of the two axes across the cylinder towards the second (in
    the plane: counter-clockwise). It needs friction."""
    restitution: Restitution = 1.0
    """[1] Coefficient of normal restitution; 1 is elastic."""
    friction: Friction | None = None
    """Friction of particles on the wall; absent: smooth."""

    @model_validator(mode="after")
    def _consistent(self) -> Cylinder:
        if self.angular_velocity != 0 and self.friction is None:
            raise ValueError(
                f"angular_velocity = {self.angular_velocity:g}: a smooth wall exerts no torque: "
                "add friction, or remove it"
            )
        return self


class Box(Part):
    """The domain [0, L) along each axis. Give exactly one of lengths, density and packing_fraction."""

    lengths: tuple[Positive, ...] | None = None
    """[length] L along each axis; absent: a square or cube of the density or packing fraction."""
    density: Positive | None = None
    """[1/length^d] Number density N/V in d dimensions; absent: follows from the lengths."""
    packing_fraction: Annotated[float, Field(gt=0, lt=1), AfterValidator(_not_tiny)] | None = None
    """[1] Volume (2D: area) of the hard spheres over that of the box; absent: follows from the lengths."""
    boundaries: tuple[Literal["periodic", "wall", "open", "hard"], ...] | None = None
    """One per axis: periodic; "wall", a 12-6 wall of a Lennard-Jones fluid; "hard", a wall of hard spheres; or open.
    Absent: periodic along all."""
    wall: Wall | None = None
    """Potential of the boundaries "wall"; absent: there are none."""
    faces: dict[str, Face] | None = None
    """Walls of hard axes by the names of their faces, "x-", "x+", "y-" ...; absent: at rest, elastic and smooth."""
    cylinder: Cylinder | None = None
    """Circular or cylindrical wall of hard spheres; absent: none."""

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


class Spring(Interaction):
    """Damped harmonic oscillators about the origin, independent of each other: m a = -k r - gamma v."""

    k: Positive
    """[mass/time^2] Spring constant k."""
    gamma: NonNegative | None = None
    """[mass/time] Friction coefficient gamma; absent: no damping."""


class Gravity(Interaction):
    """Newton's gravity between all pairs: phi(r) = -G m_i m_j/sqrt(r^2 + softening^2)."""

    G: Positive = 1.0
    """[length^3/(mass time^2)] Constant of gravity."""
    softening: Positive | None = None
    """[length] Softening length; absent: none, phi(r) = -G m_i m_j/r."""


class LennardJones(Interaction):
    """The 12-6 pair potential phi(r) = 4 epsilon ((sigma/r)^12 - (sigma/r)^6), cut at r = cutoff.

    Between species: sigma_ij = (sigma_i + sigma_j)/2 and epsilon_ij = sqrt(epsilon_i epsilon_j) (Lorentz and
    Berthelot).
    """

    epsilon: Positive | tuple[Positive, ...] = 1.0
    """[energy] Depth of the potential, one for all or one per species."""
    length: Positive | tuple[Positive, ...] = 1.0
    """[length] sigma or r_m, as `length_form` says, one for all or one per species."""
    length_form: Literal["sigma", "r_m"] = "sigma"
    """Which length is given: sigma, where phi = 0, or r_m = 2^(1/6) sigma, where phi is smallest."""
    cutoff: Positive
    """[length] Distance beyond which pairs do not interact."""
    truncation: Literal["truncated", "shifted", "force_shifted"] = "truncated"
    """Plain cut, energy shifted to zero at the cutoff, or energy and force shifted to zero there."""
    tail_corrections: bool = False
    """true: add the long-range corrections, with g(r) = 1 beyond the cutoff, to potential energy and virial; for
    truncation "truncated" in a periodic box."""


#: Rules of a wall site of a lattice gas; x and y: of the wall's normal.
WallRule = Literal["bounce_back", "specular_x", "specular_y", "diffusive_x", "diffusive_y"]


class Obstacle(Part):
    """Wall sites of a lattice gas: a block (columns, rows or both), a disk (centre, radius), or a list of sites."""

    columns: tuple[Index, Index] | None = None
    """First and last column of a block, both included, counted from 0; absent, with rows: all columns."""
    rows: tuple[Index, Index] | None = None
    """First and last row of a block, both included, counted from 0; absent, with columns: all rows."""
    centre: tuple[float, float] | None = None
    """[link] Centre (x, y) of a disk; row r is at y = r times the distance of rows. Absent: no disk."""
    radius: Positive | None = None
    """[link] Radius of the disk; sites on its rim belong to it. Absent: no disk."""
    sites: tuple[tuple[Index, Index], ...] | None = None
    """Single sites, each (column, row); absent: a block or disk."""
    rule: WallRule = "bounce_back"
    """What happens to particles that arrive: sent back (no slip), reflected ("specular": smooth), or with the normal
    velocity reversed and the tangential one reversed with probability 1/2 ("diffusive"). The letter is the axis of the
    wall's normal."""

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


class LatticeGas(Interaction):
    """A lattice gas on rows x columns sites, periodic along both axes.

    The unit of length is the link, that of time the step, that of mass a particle. HPP: Hardy, Pomeau & de Pazzis, J.
    Math. Phys. 14, 1746 (1973); FHP: Frisch, Hasslacher & Pomeau, Phys. Rev. Lett. 56, 1505 (1986).
    """

    model: str
    """Name of the collision model, one of `refimpl.lattice.models`."""
    columns: Count
    """Number of sites in a row."""
    rows: Count
    """Number of rows; even on a triangular lattice."""
    obstacles: tuple[Obstacle, ...] = ()
    """Wall sites; where obstacles overlap, the last one counts. Absent: none."""
    force: Annotated[float, Field(ge=-1, le=1)] | None = None
    """[1/step] Probability that a particle in channel -x of a site is turned to +x, if that channel is empty; negative:
    from +x to -x. Absent: no force."""
    reversals: tuple[Count, ...] | None = None
    """[step] Steps after which all velocities are reversed, half-way between two steps; absent: never."""


class Wave(Part):
    """amplitude cos(2 pi (mode_x x/L_x + mode_y y/L_y) + phase), added to the density or a velocity component."""

    of: Literal["density", "velocity_x", "velocity_y"]
    """The field to which the wave is added."""
    amplitude: float
    """[as the field] Amplitude of the wave."""
    mode: tuple[float, float]
    """[1] Number of periods along x and along y."""
    phase: float = 0.0
    """[rad] Phase at the origin."""


class Occupations(Part):
    """A lattice gas in local equilibrium (Fermi-Dirac), each channel filled at random with its mean occupation.

    Give either `density`, with velocities and waves, or the mean occupation of each of the `channels`.
    """

    kind: Literal["occupations"]
    """Says that the initial state is this one."""
    density: float | tuple[float, ...] | None = None
    """[1] Mean occupation of a channel, d = rho/b, with rho particles per site and b channels; one, or one per row.
    Absent: `channels` are given."""
    velocity_x: float | tuple[float, ...] = 0.0
    """[link/step] Mean velocity along x; one, or one per row."""
    velocity_y: float | tuple[float, ...] = 0.0
    """[link/step] Mean velocity along y; one, or one per row."""
    channels: tuple[Annotated[float, Field(ge=0, le=1)], ...] | None = None
    """[1] Mean occupation of each channel, the same at all sites; absent: `density` is given."""
    waves: tuple[Wave, ...] = ()
    """Waves added to density and velocities; absent: none."""
    cells: Count | None = None
    """Edge, in sites, of cells in which the number of particles is exactly round(d b cells^2), at random places; the
    x/L and y/L of waves are then 0 in the first cell and 1 in the last. Absent: every channel is drawn
    independently."""
    seed: Seed
    """Seed of the random numbers of the start."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if (self.density is None) == (self.channels is None):
            raise ValueError("give exactly one of density and channels")
        moving = self.velocity_x != 0 or self.velocity_y != 0
        if self.channels is not None and (moving or self.waves or self.cells is not None):
            raise ValueError("channels gives all mean occupations: remove velocity_x, velocity_y, waves and cells")
        if self.cells is not None and (moving or any(wave.of != "density" for wave in self.waves)):
            raise ValueError("cells fixes numbers of particles, not velocities: remove cells, or the velocities")
        return self


class Explicit(Part):
    """Positions and velocities of all particles, one row a particle."""

    kind: Literal["explicit"] = "explicit"
    """Says that the initial state is this one; absent: it is, if `positions` are given."""
    positions: tuple[Vector, ...]
    """[length] One row of d coordinates per particle."""
    velocities: tuple[Vector, ...] | None = None
    """[length/time] One row of d components per particle; absent: at rest."""
    angular_velocities: tuple[Vector, ...] | None = None
    """[1/time] One row per particle, of one number in the plane and three in space, where grains have friction; absent:
    no rotation."""


class Lattice(Part):
    """Particles on the sites of a lattice that fills the box inside its hard walls, with random velocities, no
    rotation.

    Give exactly one of temperature and speed.
    """

    kind: Literal["lattice"]
    """Says that the initial state is this one."""
    structure: Literal["fcc", "sc", "square", "triangular"]
    """Face-centred or simple cubic (3D), square or triangular (2D)."""
    number: Count
    """Number of particles; surplus sites are left empty, evenly spread."""
    temperature: NonNegative | None = None
    """[energy] Maxwell velocities, scaled to exactly this temperature at total momentum zero; where some particles are
    fixed, it is that of the others, and their momentum is not removed. Absent: `speed` is given."""
    speed: NonNegative | None = None
    """[length/time] The same speed for all particles that move, in random directions; absent: `temperature` is
    given."""
    seed: Seed
    """Seed of the random velocities."""

    @model_validator(mode="after")
    def _consistent(self) -> Lattice:
        if (self.temperature is None) == (self.speed is None):
            raise ValueError("give exactly one of temperature and speed")
        return self


class Kepler(Part):
    """Two bodies at apocentre on the x axis, moving along y, with their centre of mass at rest at the origin."""

    kind: Literal["kepler"]
    """Says that the initial state is this one."""
    semi_major_axis: Positive = 1.0
    """[length] Semi-major axis of the relative orbit."""
    eccentricity: Annotated[float, Field(ge=0, lt=1)]
    """[1] Eccentricity of the orbit; 0 is a circle."""


class File(Part):
    """A configuration file: .npz, .xyz, .extxyz, a LAMMPS dump, or an ASE .traj; the last frame of several.

    Its numbers are taken as they stand, in the scene's units. Masses and species that the scene leaves out come from
    the file; box, masses, species and diameters that both state must agree. An .npz holds `positions` (N, d); optional
    are `velocities` (N, d), `angular_velocities` (N, 1 in the plane, 3 in space), `masses`, `species`, `diameters` (N,)
    and `lengths` (d,).
    """

    kind: Literal["file"]
    """Says that the initial state is this one."""
    path: str
    """Path of the file, relative to the scene file."""


Initial: TypeAlias = Annotated[Explicit | Lattice | Kepler | File | Occupations, Field(discriminator="kind")]
if TYPE_CHECKING:
    Observable: TypeAlias = str
else:
    Observable = Literal[observables.NAMED]


class Output(Part):
    """What is recorded. Nothing is recorded that is not named here.

    Samples are taken at the start and at every `interval`, or at the counts of `collisions`.
    """

    interval: Positive | None = None
    """[time] Time between samples; absent: no samples, or those of `collisions`."""
    collisions: tuple[Count, ...] | None = None
    """Of hard spheres, in place of `interval`: increasing numbers of pair collisions, right after which a sample is
    taken; the run ends at the last of them. Absent: samples at every `interval`."""
    observables: tuple[Observable, ...] = ()
    """Names of what is measured; absent: nothing."""
    trajectory: bool = False
    """true: positions and velocities of all particles at each sample."""
    forces: bool = False
    """true: the force on every particle at the end of the run."""
    trace: bool = False
    """true: every event that changes velocities of hard spheres, with the states of its partners after it."""
    fields: tuple[Count, ...] | None = None
    """Number of cells along each axis. Of hard spheres, the hydrodynamic fields are averaged in them over the whole
    run; of a lattice gas, they are the blocks of the observable "populations". Absent: no fields; one block."""

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
    """Contact law of soft spheres, by which a method with time steps approaches hard ones.

    Spheres that overlap by delta repel each other with F = s k delta - eta_n v_n, s = 1 ("hooke") or sqrt(R_eff delta)
    ("hertz"), where 1/R_eff = 1/R_i + 1/R_j, and 1/m_eff = 1/m_i + 1/m_j below; a wall has no curvature, and infinite
    mass. Give exactly one of stiffness, duration, k_n and E. With `stiffness` or `duration` all else follows from the
    restitutions and the friction of the scene. With `k_n` or `E` the contact has coefficients of its own, the same for
    pairs and walls: those of LAMMPS's styles gran/hooke, gran/hooke/history, gran/hertz/history and granular
    hertz/material with tangential mindlin.
    """

    law: Literal["hooke", "hertz"] = "hooke"
    """Elastic force as a function of the overlap."""
    stiffness: Positive | None = None
    """[mass/time^2; hertz: mass/(length time^2)] The constant k of the law; absent: another entry gives it."""
    duration: Positive | None = None
    """[time] Of "hooke": the time t_c for which two particles of the smallest mass m touch,
    t_c^2 = (pi^2 + ln^2 alpha) m/(2 k), with the restitution alpha. Absent: another entry gives the stiffness."""
    friction: Literal["history", "dashpot"] = "history"
    """Tangential force up to Coulomb's limit: a spring that remembers its stretch ("history") or a dashpot."""
    resolution: Positive | None = None
    """[1] Of "hooke": dt/t_c, in place of `method.dt`, which is then the largest step up to this one that divides the
    time between samples. Absent: `method.dt` is given."""
    k_n: Positive | None = None
    """[mass/time^2; hertz: mass/(length time^2)] Normal stiffness k, with coefficients of one's own. Absent: another
    entry gives it."""
    k_t: Positive | None = None
    """[as k_n] Stiffness of the tangential spring, F_t = -s k_t xi - eta_t u with its stretch xi and the slip u; beside
    k_n, where grains have friction with "history". Absent: no friction, "dashpot", or it follows from E and nu."""
    E: Positive | None = None
    """[mass/(length time^2)] Young's modulus E of grains and walls, of "hertz" (Hertz and Mindlin): with nu,
    k_n = 2 E/(3 (1 - nu^2)) and k_t = 2 E/((1 + nu) (2 - nu)). Absent: another entry gives the stiffness."""
    nu: Annotated[float, Field(gt=-1, le=0.5)] | None = None
    """[1] Poisson's ratio nu of grains and walls, with E. Absent: E is absent too."""
    gamma_n: NonNegative | None = None
    """[1/time; hertz: 1/(length time)] Normal damping, eta_n = s gamma_n m_eff; beside k_n or E. Absent: it follows
    from the restitutions of the scene."""
    gamma_t: NonNegative | None = None
    """[as gamma_n] Tangential damping, eta_t = s gamma_t m_eff; beside gamma_n. Absent: none."""
    mu: NonNegative | None = None
    """[1] Coefficient of friction, |F_t| <= mu |F_n|, of all contacts with friction; beside k_n or E. Absent: that of
    the scene's friction, "sliding"."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        given = [name for name in ("stiffness", "duration", "k_n", "E") if getattr(self, name) is not None]
        if len(given) != 1:
            found = " and ".join(given) or "none"
            raise ValueError(f"give exactly one of stiffness, duration, k_n and E (with nu); found {found}")
        if self.law == "hertz" and (self.duration is not None or self.resolution is not None):
            raise ValueError(
                'law = "hertz": contacts last longer the slower the grains: give stiffness, k_n or E, and method.dt'
            )
        own = [name for name in ("k_t", "nu", "gamma_n", "gamma_t", "mu") if getattr(self, name) is not None]
        if own and given[0] in ("stiffness", "duration"):
            raise ValueError(
                f"{given[0]} and {own[0]}: with {given[0]} all else follows from the restitution and the friction of "
                f"the scene: remove {' and '.join(own)}, or give k_n (hertz: or E and nu) in place of {given[0]}"
            )
        self._own_coefficients()
        return self

    def _own_coefficients(self) -> None:
        """ValueError if coefficients contradict each other."""
        if (self.E is None) != (self.nu is None):
            raise ValueError("E and nu go together: give both, or neither")
        if self.E is not None and self.law != "hertz":
            raise ValueError('E and nu are moduli of law = "hertz" (Hertz and Mindlin): add it, or give k_n')
        if self.E is not None and self.k_t is not None:
            raise ValueError("E and k_t: the tangential stiffness follows from E and nu: remove k_t, or give k_n for E")
        if self.gamma_t is not None and self.gamma_n is None:
            raise ValueError("gamma_t needs gamma_n: add it, as gamma_n = 0.0 for no normal damping")
        if self.friction == "dashpot" and (self.k_t is not None or self.E is not None):
            raise ValueError(
                'friction = "dashpot" has no tangential spring: give k_n and gamma_t, without k_t, E and nu; or '
                'friction = "history"'
            )

    @property
    def own(self) -> bool:
        """Whether the contact has coefficients of its own, and does not follow the scene's restitution alone."""
        return self.k_n is not None or self.E is not None


class Method(Part):
    """How the scene is integrated: the scheme, and its time step or tolerance."""

    scheme: str
    """Name of the scheme, one of those of the engine that runs the scene."""
    dt: Positive | None = None
    """[time] Time step; it must divide `duration` and `output.interval`. Absent: the scheme is event-driven or a
    lattice gas, or `tolerance` or `contact.resolution` is given."""
    tolerance: Annotated[float, Field(gt=0, lt=1), AfterValidator(_not_tiny)] | None = None
    """[1] Of schemes that choose their own time steps: estimated error of a step that is allowed, relative to each
    coordinate and to the size of the scene. Absent: `dt` is given, or the scheme takes no time steps."""
    contact: Contact | None = None
    """Contact law of hard spheres, for schemes that let them overlap; absent: they never overlap."""
    threads: Annotated[int, Field(ge=1, le=1024)] | None = None
    """[1] Number of threads that share a run, for schemes that are declared to take it (`method.threads`); no bit of a
    result may depend on it. Absent: one."""
    compensated: bool = False
    """true: positions and velocities keep what their sums over the steps lose by rounding (compensated summation)."""

    @model_validator(mode="after")
    def _one_step(self) -> Self:
        if self.dt is not None and self.contact is not None and self.contact.resolution is not None:
            raise ValueError("dt and contact.resolution both say how long a step is: remove one")
        if self.dt is not None and self.tolerance is not None:
            raise ValueError("dt and tolerance both say how long a step is: remove one")
        return self

    @property
    def step(self) -> float:
        """dt, in units of time; UsageError without one."""
        if self.dt is None:
            raise UsageError(f"method.dt is missing: scheme '{self.scheme}' takes time steps: add dt, as in dt = 0.005")
        return self.dt

    @property
    def allowed(self) -> float:
        """tolerance, of an error relative to its coordinate; UsageError without one."""
        if self.tolerance is None:
            raise UsageError(
                f"method.tolerance is missing: scheme '{self.scheme}' chooses its own time steps: add tolerance, as in "
                "tolerance = 1e-9"
            )
        return self.tolerance


def _title(name: str) -> str:
    """`name`, if it can stand in one line of a file and above a picture; else ValueError."""
    if name != printable(name):
        raise ValueError("a name is one line of text without control characters")
    if len(name) > LONGEST_NAME:
        raise ValueError(f"a name of {len(name)} characters is too long: take at most {LONGEST_NAME}")
    return name


#: Characters of the longest name: what can still be read above a picture.
LONGEST_NAME = 200


class SceneEntries(Part):
    """A scene: dimension, particles, one interaction, box, initial state, duration and output.

    All quantities are in one consistent system of units, which the scene chooses: reduced units, or SI. Give exactly
    one interaction.
    """

    # The checks of hard spheres and lattice gases compare entries of different tables. They take this class, so that
    # `Scene`, which calls them, is imported by nothing that it imports.

    name: Annotated[str, AfterValidator(_title)]
    """Name of the scene, for messages and files: one line, of at most 200 characters."""
    dimension: Literal[1, 2, 3]
    """Dimension d of space."""
    duration: NonNegative
    """[time] Simulated time."""
    masses: Positive | tuple[NonNegative, ...] = 1.0
    """[mass] One for all, or one per particle. With gravity a mass may be 0: a test particle."""
    species: tuple[Index, ...] | None = None
    """Species of each particle, counted from 0; absent: all are of one."""
    acceleration: Vector | None = None
    """[length/time^2] Uniform field that acts on hard spheres, d components; absent: none."""
    seed: Seed | None = None
    """Seed of the random numbers drawn during the run: of hard spheres, by thermal walls and random phases; of a
    lattice gas, by collisions, diffusive walls and the force. Absent: the seed of the initial state."""
    spring: Spring | None = None
    """Interaction: harmonic oscillators; absent: another one."""
    lennard_jones: LennardJones | None = None
    """Interaction: a Lennard-Jones fluid; absent: another one."""
    gravity: Gravity | None = None
    """Interaction: Newton's gravity; absent: another one."""
    hard_spheres: HardSpheres | None = None
    """Interaction: hard disks or spheres, granular or elastic; absent: another one."""
    lattice_gas: LatticeGas | None = None
    """Interaction: a lattice gas; absent: another one."""
    box: Box | None = None
    """The domain, of a Lennard-Jones fluid or hard spheres; absent: open space."""
    initial: Initial
    """The initial state; its `kind` says which of the tables below it is."""
    output: Output = Output()
    """What is recorded; absent: only the state at the end."""
    method: Method | None = None
    """How the scene is integrated; needed to run the scene from its file. Absent: checks bring methods of their own."""

    @property
    def number(self) -> int:
        """Number of particles; 0 for a lattice gas, whose particles are not told apart."""
        if isinstance(self.initial, Occupations):
            return 0
        if isinstance(self.initial, Explicit):
            return len(self.initial.positions)
        if isinstance(self.initial, Lattice):
            return self.initial.number
        return 2

    @property
    def boundaries(self) -> tuple[str, ...]:
        """Kind of boundary along each axis, d names; without a box "open", in a box that does not say "periodic"."""
        if self.box is None:
            return ("open",) * self.dimension
        return self.box.boundaries or ("periodic",) * self.dimension

    @property
    def faces(self) -> tuple[Face | None, ...]:
        """The plane walls of hard spheres, 2d entries x-, x+, y-, y+ ...; None where there is no wall."""
        rules = {} if self.box is None or self.box.faces is None else self.box.faces
        faces = [
            rules.get(f"{axis}{side}", Face()) if boundary == "hard" else None
            for axis, boundary in zip(AXES, self.boundaries, strict=False)
            for side in "-+"
        ]
        return tuple(None if face is None or face.open else face for face in faces)

    @property
    def across(self) -> tuple[int, ...]:
        """Indices of the two axes across the cylinder; empty without a cylinder."""
        if self.box is None or self.box.cylinder is None:
            return ()
        return tuple(axis for axis in range(self.dimension) if AXES[axis] != self.box.cylinder.axis)

    @property
    def spin_dimension(self) -> int:
        """Components of an angular velocity: 0 if nothing rotates, 1 in the plane, 3 in space."""
        if self.hard_spheres is None or self.hard_spheres.friction is None:
            return 0
        return 1 if self.dimension == 2 else 3


#: Names of the interactions, of which a scene has exactly one.
INTERACTIONS: tuple[str, ...] = tuple(
    name
    for name, field in SceneEntries.model_fields.items()
    if any(isinstance(kind, type) and issubclass(kind, Interaction) for kind in get_args(field.annotation))
)
