"""Scenes: what is simulated, read from and written to TOML, with the initial state and the arrays engines need."""

from __future__ import annotations

import json
import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from numpy.typing import NDArray
from pydantic import ValidationError, model_validator

from crosscheck.errors import UsageError
from crosscheck.files import shown_path, unreadable
from crosscheck.scene.configuration import check_against, entries_from, read_configuration
from crosscheck.scene.hard_spheres import check_hard_spheres, check_hard_state, refuse_hard_spheres_entries
from crosscheck.scene.lattice_gas import check_lattice_gas, initial_occupations, initial_sites, wall_rules
from crosscheck.scene.messages import explain
from crosscheck.scene.observables import FRICTION, Matter, Observable, asked_for
from crosscheck.scene.parts import (
    INTERACTIONS,
    LEAST,
    Contact,
    Explicit,
    File,
    Floats,
    Kepler,
    Lattice,
    LennardJones,
    Occupations,
    SceneEntries,
)
from crosscheck.scene.sizes import refuse_large, refuse_large_start
from crosscheck.scene.starts import (
    State,
    apocentre,
    check_rows,
    lattice_sites,
    lattice_sites_inside,
    random_velocities,
    refuse_coincidence,
    refuse_not_finite,
)
from crosscheck.text import shortened

#: Matters of the observables that a scene with smooth forces, hard spheres or a lattice gas can ask for.
SMOOTH: tuple[Matter, ...] = ("any", "particles", "smooth_particles")
HARD: tuple[Matter, ...] = ("any", "particles", "hard_spheres")
GAS: tuple[Matter, ...] = ("any", "lattice_gas")


class Scene(SceneEntries):
    """A scene, frozen and validated: what is simulated, independent of the time step.

    Its entries are those of `SceneEntries`. ValueError if they contradict each other; `load`, `from_json` and `changed`
    turn it into a UsageError that names the entry.
    """

    @model_validator(mode="after")
    def _consistent(self) -> Scene:
        given = [name for name in INTERACTIONS if getattr(self, name) is not None]
        if len(given) != 1:
            found = " and ".join(given) or "none"
            names = ", ".join(f"[{name}]" for name in INTERACTIONS)
            raise ValueError(f"give exactly one of {names}; found {found}")
        if given[0] in ("lennard_jones", "hard_spheres") and self.dimension == 1:
            raise ValueError(f"[{given[0]}] needs dimension 2 or 3")
        if self.gravity is None and isinstance(self.masses, tuple) and min(self.masses, default=1.0) < LEAST:
            raise ValueError(
                f"masses: a particle without mass moves with [gravity] only; give it one of at least {LEAST:g}"
            )
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
            check_rows(self.initial, self.dimension)
        if isinstance(self.initial, Lattice) and self.box is None:
            raise ValueError("initial.kind = 'lattice' fills a box: add [box]")
        recorded = set(self.output.observables) - {"sites"} or self.output.trajectory
        if self.output.interval is None and self.output.collisions is None and recorded:
            raise ValueError("output.interval is missing: say how often to record")
        if self.lennard_jones is not None:
            _check_species(self, self.lennard_jones)
        check_lattice_gas(self)
        if self.lattice_gas is not None:
            return self
        if self.hard_spheres is None:
            refuse_hard_spheres_entries(self)
        else:
            check_hard_spheres(self, self.hard_spheres)
        return self

    # -- reading and writing -----------------------------------------------------------------------

    @classmethod
    def from_json(cls, text: str, where: str = "scene") -> Scene:
        """The scene in a JSON text.

        text: of the JSON. where: what the messages start with, such as the path of a file. UsageError with a line for
        each mistake: the path of the key, and how to mend it.
        """
        try:
            return cls.model_validate_json(text)
        except ValidationError as error:
            raise UsageError(explain(error, where, cls)) from None

    @classmethod
    def load(cls, path: str | Path) -> Scene:
        """The scene in a TOML file; an initial state in another file is read too.

        path: of the TOML file. UsageError if a file cannot be read, or with a line for each mistake in it.
        """
        path = Path(path)
        reason = unreadable(path)
        if reason:
            raise UsageError(f"{shown_path(path)}: cannot be read ({reason}); give the path of a scene file")
        try:
            table = tomllib.loads(path.read_bytes().decode("utf-8-sig"))
            initial = table.get("initial")
            if isinstance(initial, dict) and "positions" in initial:
                initial.setdefault("kind", Explicit.model_fields["kind"].default)
            text = json.dumps(table, default=str)
        except ValueError as error:  # of the encoding, the text, or a number with more digits than Python converts
            raise UsageError(f"{shown_path(path)}: not valid TOML: {shortened(str(error), 300)}") from None
        except RecursionError:
            raise UsageError(f"{shown_path(path)}: not valid TOML: tables or lists are nested too deeply") from None
        scene = cls.from_json(text, shown_path(path))
        if isinstance(scene.initial, File):
            place = path.parent / scene.initial.path
            reason = unreadable(place)
            if reason:
                raise UsageError(f"initial.path = {shown_path(place)}: cannot be read as a configuration ({reason})")
            found = read_configuration(place)
            try:
                scene = scene.changed(**entries_from(found, scene, place))
            except ValidationError as error:
                raise UsageError(explain(error, f"initial.path = {shown_path(place)}", cls)) from None
            check_against(found, scene, place, lengths=scene.lengths(), diameters=scene.diameters())
        return scene

    def to_json(self) -> str:
        """JSON that `from_json` reads back to an equal scene."""
        return self.model_dump_json(exclude_none=True)

    def to_toml(self) -> str:
        """TOML that `load` reads back to an equal scene."""
        return tomli_w.dumps(json.loads(self.to_json()))

    def changed(self, **changes: Any) -> Scene:
        """A validated copy. changes: new values of entries, by name. UsageError if it is not a valid scene."""
        return Scene.from_json(self.model_copy(update=changes).to_json())

    # -- what engines need -------------------------------------------------------------------------

    @property
    def interaction(self) -> str:
        """The table of the interaction: one of `INTERACTIONS`."""
        return next(name for name in INTERACTIONS if getattr(self, name) is not None)

    @property
    def matters(self) -> tuple[Matter, ...]:
        """The matters of the observables that this scene can ask for."""
        return {"hard_spheres": HARD, "lattice_gas": GAS}.get(self.interaction, SMOOTH)

    def asked(self) -> dict[str, Observable]:
        """The observables that a run of this scene returns, by name."""
        output = self.output
        asked = asked_for(
            self.matters,
            output.observables,
            trajectory=output.trajectory,
            forces=output.forces,
            fields=output.fields is not None,
            trace=output.trace,
        )
        return {name: row for name, row in asked.items() if row.requires != FRICTION or self.spin_dimension}

    def lengths(self) -> Floats | None:
        """Sides of the box, (d,), length; None without a box.

        UsageError if they do not follow from density or packing_fraction: because all diameters are 0, or the volume is
        no number.
        """
        if self.box is None:
            return None
        if self.box.lengths is not None:
            return np.array(self.box.lengths)
        if self.box.packing_fraction is not None:
            diameters = self.diameters()
            assert diameters is not None
            unit = math.pi / 4 if self.dimension == 2 else math.pi / 6
            with np.errstate(over="ignore"):
                volume = unit * float((diameters**self.dimension).sum()) / self.box.packing_fraction
            if volume == 0:
                fraction = self.box.packing_fraction
                raise UsageError(f"box.packing_fraction = {fraction:g} needs particles with a diameter: give density")
        else:
            assert self.box.density is not None
            volume = self.number / self.box.density
        if not math.isfinite(volume):
            raise UsageError("box: its volume is beyond all numbers: give a larger density or packing fraction")
        return np.full(self.dimension, volume ** (1.0 / self.dimension))

    def periods(self) -> Floats:
        """Sides of the box along periodic axes, 0 along the others, (d,), length."""
        lengths = self.lengths()
        return np.where(np.array(self.boundaries) == "periodic", 0.0 if lengths is None else lengths, 0.0)

    def samples(self) -> Floats:
        """Times (samples,) at which an event-driven run is recorded.

        0 and every `output.interval` up to the duration; without an interval, 0 and the duration. With
        `output.collisions`, 0 and a NaN per count, since their times are a result of the run.
        """
        output = self.output
        if output.collisions is not None:
            return np.concatenate([[0.0], np.full(len(output.collisions), np.nan)])
        if output.interval is None:
            return np.array([0.0, self.duration])
        ratio = self.duration / output.interval
        refuse_large(16 * ratio, f"output.interval: {ratio:.4g} samples", "record less often")
        whole = round(ratio) if abs(ratio - round(ratio)) <= 1e-9 * max(1.0, ratio) else math.floor(ratio)
        return np.minimum(np.arange(whole + 1) * output.interval, self.duration)

    def diameters(self) -> Floats | None:
        """Diameters of the hard spheres, (N,), length; None in other scenes. UsageError if species do not fit."""
        if self.hard_spheres is None:
            return None
        of_species = np.atleast_1d(self.hard_spheres.diameter)
        if of_species.size == 1:
            return np.full(self.number, of_species[0])
        return of_species[self._species()]

    def fixed(self) -> NDArray[np.bool_]:
        """Which particles never move, (N,). UsageError if species do not fit."""
        species = None if self.hard_spheres is None else self.hard_spheres.fixed
        if species is None:
            return np.zeros(self.number, dtype=bool)
        return np.isin(self._species(), species)

    def _species(self) -> NDArray[np.int64]:
        """Species of each particle, (N,); UsageError if there are more or fewer."""
        species = np.array(self.species or (), dtype=np.int64)
        if species.size != self.number:
            raise UsageError(f"species: {species.size} values for {self.number} particles; give one per particle")
        return species

    def volume(self) -> float:
        """Volume of the box, length^d; UsageError without a box."""
        lengths = self.lengths()
        if lengths is None:
            raise UsageError(f"scene {self.name}: there is no [box], hence no volume")
        return float(np.prod(lengths))

    def steps(self, dt: float) -> int:
        """duration/dt; UsageError if it is not a whole number. dt: time step, time."""
        return whole_steps(self.duration, dt, "duration")

    def every(self, dt: float) -> int | None:
        """Steps between samples; None if nothing is recorded. dt: time step, time.

        UsageError if output.interval is not a whole number of steps, or is shorter than one.
        """
        if self.output.interval is None or not (self.output.observables or self.output.trajectory):
            return None
        every = whole_steps(self.output.interval, dt, "output.interval")
        if every == 0:
            raise UsageError("output.interval is shorter than method.dt: record less often or take a smaller dt")
        return every

    def initial_sites(self) -> NDArray[np.uint8]:
        """States of the sites of a lattice gas, (rows, columns): bit i says that channel i is occupied.

        UsageError if density or velocity are out of range, an obstacle is not on the lattice, or the memory too small.
        """
        refuse_large_start(self)
        return initial_sites(self)

    def initial_occupations(self) -> Floats:
        """Mean occupations of the channels of a lattice gas, (rows, columns, channels).

        UsageError if density or velocity are out of range, an obstacle is not on the lattice, or the memory too small.
        """
        refuse_large_start(self)
        return initial_occupations(self)

    def check_start(self) -> None:
        """UsageError if there is no initial state: see `initial_sites` and `own_start`."""
        if self.lattice_gas is not None:
            self.initial_sites()
        else:
            self.own_start()

    def own_start(self) -> State:
        """The initial state for the scene's own method, which may allow contacts: see `initial_state`."""
        return self.initial_state(None if self.method is None else self.method.contact)

    def wall_rules(self) -> NDArray[np.uint8] | None:
        """Rules of the wall sites of a lattice gas, (rows, columns), the constants of `refimpl.lattice.gas`.

        0 where there is no wall; None without obstacles. UsageError if an obstacle is not on the lattice.
        """
        return wall_rules(self)

    def initial_state(self, contact: Contact | None = None) -> State:
        """The initial state of the particles, the same for every engine.

        contact: of the method, if hard spheres are run as soft ones: these may overlap at the start, as grains at rest
        on each other do. UsageError if numbers of masses or species do not fit, if two particles are at the same place
        (springs: they may be), if hard spheres overlap or are not inside their walls, if soft ones overlap by more than
        the smaller of their radii, if a number overflows, or if there are more particles than the memory holds.
        """
        refuse_large_start(self)
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
                positions = lattice_sites(self.initial, lengths)
            else:
                positions = lattice_sites_inside(self.initial, self, lengths, float(diameters.max()) / 2)
            velocities = random_velocities(self.initial, masses, self.dimension, fixed)
        elif isinstance(self.initial, Kepler):
            positions, velocities = apocentre(self.initial, masses, self.gravity, self.dimension)
        elif isinstance(self.initial, Occupations):
            positions = velocities = np.zeros((0, self.dimension))
        else:
            raise UsageError("initial.kind = 'file' is read by Scene.load: load the scene from its file")
        state = State(positions, velocities, masses, species, lengths, diameters, spins)
        refuse_not_finite(state)
        if self.hard_spheres is not None:
            check_hard_state(self, self.hard_spheres, state, fixed, self.periods(), soft=contact is not None)
        elif self.spring is None:
            refuse_coincidence(positions, lengths, [b == "periodic" for b in self.boundaries])
        return state


def _check_species(scene: SceneEntries, fluid: LennardJones) -> None:
    """ValueError unless each species has an epsilon and a length, where these are given one per species."""
    for name, values in (("epsilon", fluid.epsilon), ("length", fluid.length)):
        if not isinstance(values, tuple):
            continue
        if not values:
            raise ValueError(f"lennard_jones.{name} is empty: give one value, or one per species")
        if len(values) > 1 and scene.species is None:
            raise ValueError(f"lennard_jones.{name} has {len(values)} values, one per species: add species")
        highest = max(scene.species or (0,))
        if len(values) > 1 and highest >= len(values):
            raise ValueError(f"species {highest} has no lennard_jones.{name}: there are {len(values)} values")


def whole_steps(span: float, dt: float, name: str) -> int:
    """span/dt, which must be a whole number to within 1e-9 of it. span, dt: time. name: of the span, for the message.

    UsageError otherwise, with the nearest dt that divides the span.
    """
    ratio = span / dt
    if ratio > 2**53:
        raise UsageError(f"{name} = {span:g} is too many steps of method.dt = {dt:g} to be counted: take a larger dt")
    steps = round(ratio)
    if abs(ratio - steps) > 1e-9 * max(1.0, ratio):
        mend = span / max(1, steps)
        raise UsageError(f"{name} = {span:g} is not a whole number of steps of method.dt = {dt:g}; try dt = {mend!r}")
    return steps
