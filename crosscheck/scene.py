"""WHAT is simulated: frozen, validated scenes <-> TOML. An absent entry means that the thing is not there.

Quantities are in the scene's own consistent units: reduced for Lennard-Jones, SI where a documented case is in SI.
"""

from __future__ import annotations

import difflib
import json
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, TypeAlias

import numpy as np
import tomli_w
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from crosscheck.errors import UsageError

Floats: TypeAlias = NDArray[Any]
Positive = Annotated[float, Field(gt=0)]
NonNegative = Annotated[float, Field(ge=0)]
Vector: TypeAlias = tuple[float, ...]


class Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class Wall(Part):
    """12-6 walls on both faces of every axis whose boundary is "wall": 4 epsilon ((sigma/z)^12 - (sigma/z)^6).

    Cut, with the energy shifted to zero, at the distance `cutoff` from the face.
    """

    epsilon: Positive = 1.0
    sigma: Positive = 1.0
    cutoff: Positive


class Box(Part):
    """The domain [0, L) along each axis. Give `lengths`, or `density` for a cube (square) that holds the particles."""

    lengths: tuple[Positive, ...] | None = None
    density: Positive | None = None
    boundaries: tuple[Literal["periodic", "wall", "open"], ...] | None = None
    wall: Wall | None = None

    @model_validator(mode="after")
    def _consistent(self) -> Box:
        if (self.lengths is None) == (self.density is None):
            raise ValueError("give exactly one of lengths and density")
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
    """Positions and velocities, one row a particle; velocities default to rest."""

    kind: Literal["explicit"] = "explicit"
    positions: tuple[Vector, ...]
    velocities: tuple[Vector, ...] | None = None


class Lattice(Part):
    """`number` sites of a lattice in the box; Maxwell velocities, total momentum zero, temperature exact."""

    kind: Literal["lattice"]
    structure: Literal["fcc", "sc", "square", "triangular"]
    number: Annotated[int, Field(gt=0)]
    temperature: NonNegative
    seed: Annotated[int, Field(ge=0)]


class Kepler(Part):
    """Two bodies at apocentre on the x axis, centre of mass at rest at the origin."""

    kind: Literal["kepler"]
    semi_major_axis: Positive = 1.0
    eccentricity: Annotated[float, Field(ge=0, lt=1)]


class File(Part):
    """A configuration file: .npz with `positions` (N, d) and optional `velocities`, or any format that ASE reads."""

    kind: Literal["file"]
    path: str


Initial: TypeAlias = Annotated[Explicit | Lattice | Kepler | File, Field(discriminator="kind")]
Observable = Literal["kinetic_energy", "potential_energy", "virial"]


class Output(Part):
    """What is recorded every `interval` of time (start included); nothing is taken that is not named here."""

    interval: Positive | None = None
    observables: tuple[Observable, ...] = ()
    trajectory: bool = False
    forces: bool = False  # on every particle, at the end


class Method(Part):
    """HOW it is integrated: the scheme's name and the time step."""

    scheme: str
    dt: Positive


class State(NamedTuple):
    """positions, velocities (N, d); masses (N,); species (N,) or None; lengths (d,) or None."""

    positions: Floats
    velocities: Floats
    masses: Floats
    species: NDArray[np.int64] | None
    lengths: Floats | None


class Scene(Part):
    """A scene: dimension, particles, one interaction, box, initial state, duration and output."""

    name: str
    dimension: Literal[1, 2, 3]
    duration: NonNegative
    masses: Positive | tuple[NonNegative, ...] = 1.0
    species: tuple[Annotated[int, Field(ge=0)], ...] | None = None
    spring: Spring | None = None
    lennard_jones: LennardJones | None = None
    gravity: Gravity | None = None
    box: Box | None = None
    initial: Initial
    output: Output = Output()
    method: Method | None = None

    @model_validator(mode="after")
    def _consistent(self) -> Scene:
        given = [name for name in ("spring", "lennard_jones", "gravity") if getattr(self, name) is not None]
        if len(given) != 1:
            found = " and ".join(given) or "none"
            raise ValueError(f"give exactly one of [spring], [lennard_jones], [gravity]; found {found}")
        if self.lennard_jones is not None and self.dimension == 1:
            raise ValueError("[lennard_jones] needs dimension 2 or 3")
        if self.gravity is None and isinstance(self.masses, tuple) and 0.0 in self.masses:
            raise ValueError("masses: a particle without mass moves with [gravity] only; give it one")
        if self.box is not None:
            for key in ("lengths", "boundaries"):
                value = getattr(self.box, key)
                if value is not None and len(value) != self.dimension:
                    raise ValueError(f"box.{key} needs {self.dimension} entries, found {len(value)}")
        if self.box is not None and self.lennard_jones is None:
            raise ValueError("[box] goes with [lennard_jones]; springs and gravity act in open space: remove [box]")
        if isinstance(self.initial, Explicit):
            _check_rows(self.initial, self.dimension)
        if isinstance(self.initial, Lattice) and self.box is None:
            raise ValueError("initial.kind = 'lattice' fills a box: add [box]")
        if self.output.interval is None and (self.output.observables or self.output.trajectory):
            raise ValueError("output.interval is missing: say how often to record")
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
        assert self.box.density is not None
        return np.full(self.dimension, (self.number / self.box.density) ** (1.0 / self.dimension))

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
        """The initial state, the same for every engine; UsageError if particles coincide or counts disagree."""
        lengths = self.lengths()
        n = self.number
        masses = np.full(n, self.masses) if isinstance(self.masses, float) else np.array(self.masses)
        if masses.size != n:
            raise UsageError(f"masses: {masses.size} values for {n} particles; give one, or one per particle")
        species = None if self.species is None else np.array(self.species, dtype=np.int64)
        if species is not None and species.size != n:
            raise UsageError(f"species: {species.size} values for {n} particles; give one per particle")
        if isinstance(self.initial, Explicit):
            positions = np.array(self.initial.positions)
            given = self.initial.velocities
            velocities = np.zeros_like(positions) if given is None else np.array(given)
        elif isinstance(self.initial, Lattice):
            assert lengths is not None
            positions = _lattice(self.initial, lengths)
            velocities = _maxwell_velocities(self.initial, masses, self.dimension)
        elif isinstance(self.initial, Kepler):
            positions, velocities = _apocentre(self.initial, masses, self.gravity, self.dimension)
        else:
            raise UsageError("initial.kind = 'file' is read by Scene.load: load the scene from its file")
        if self.spring is None:
            _refuse_coincidence(positions, lengths, [b == "periodic" for b in self.boundaries])
        return State(positions, velocities, masses, species, lengths)


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


def explicit(positions: Floats, velocities: Floats) -> Explicit:
    """Arrays of shape (N, d) as an initial state."""
    return Explicit(positions=tuple(map(tuple, positions.tolist())), velocities=tuple(map(tuple, velocities.tolist())))


def _check_rows(initial: Explicit, dimension: int) -> None:
    if not initial.positions:
        raise ValueError("initial.positions is empty: give at least one particle")
    rows = {"positions": initial.positions, "velocities": initial.velocities or initial.positions}
    for name, vectors in rows.items():
        if len(vectors) != len(initial.positions):
            raise ValueError(f"initial.{name} has {len(vectors)} rows for {len(initial.positions)} particles")
        for i, vector in enumerate(vectors):
            if len(vector) != dimension:
                raise ValueError(f"initial.{name}[{i}] has {len(vector)} components in dimension {dimension}")


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
    edge = (np.prod(lengths / cell) * len(basis) / initial.number) ** (1.0 / lengths.size)
    counts = np.maximum(1, np.floor(lengths / (cell * edge) + 1e-9)).astype(int)
    while np.prod(counts) * len(basis) < initial.number:
        counts[np.argmax(lengths / (cell * counts))] += 1
    cells = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, lengths.size)
    sites = ((cells[:, None, :] + basis + 0.25) / counts * lengths).reshape(-1, lengths.size)
    keep = np.linspace(0, len(sites) - 1, initial.number).round().astype(int)
    return np.ascontiguousarray(sites[keep])


def _maxwell_velocities(initial: Lattice, masses: Floats, dimension: int) -> Floats:
    rng = np.random.default_rng(initial.seed)
    velocities = rng.normal(size=(masses.size, dimension)) / np.sqrt(masses)[:, None]
    if masses.size < 2 or initial.temperature == 0:
        return np.zeros_like(velocities)
    velocities -= (masses[:, None] * velocities).sum(axis=0) / masses.sum()
    kinetic = 0.5 * (masses[:, None] * velocities**2).sum()
    return velocities * np.sqrt(0.5 * dimension * (masses.size - 1) * initial.temperature / kinetic)


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
    try:
        if path.suffix == ".npz":
            with np.load(path) as arrays:
                positions = np.asarray(arrays["positions"], dtype=np.float64)
                velocities = np.asarray(arrays.get("velocities", np.zeros_like(positions)), dtype=np.float64)
        else:
            import ase.io

            atoms = ase.io.read(path)
            assert not isinstance(atoms, list)
            positions, velocities = atoms.get_positions(), atoms.get_velocities()
        positions, velocities = positions[:, :dimension], velocities[:, :dimension]
    except Exception as error:
        raise UsageError(f"initial.path = {path}: cannot be read as a configuration ({error})") from None
    if not (np.isfinite(positions).all() and np.isfinite(velocities).all()):
        raise UsageError(f"initial.path = {path}: holds values that are not finite")
    return explicit(positions, velocities)


# -- errors in words -------------------------------------------------------------------------------


_PARTS: dict[str, type[Part]] = {
    "box": Box,
    "wall": Wall,
    "spring": Spring,
    "gravity": Gravity,
    "lennard_jones": LennardJones,
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
            near, hint = _hint(str(place[-1]), str(place[-2]) if len(place) > 1 else "")
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


def _hint(key: str, table: str) -> tuple[str, str]:
    """The key that was meant, if there is one near in this table, and what to do."""
    part = {**_PARTS, **_KINDS}.get(table, Scene)
    near = difflib.get_close_matches(key, part.model_fields, 1)
    if near:
        return near[0], f"did you mean '{near[0]}'?"
    owners = [f"[{name}]" for name, other in _PARTS.items() if key in other.model_fields]
    return "", f"it belongs in {' or '.join(owners)}" if owners else "remove it"
