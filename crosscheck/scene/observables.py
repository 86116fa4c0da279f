"""The table of observables: everything that a run can be asked for, declared once.

The scene language (which names `output.observables` takes), the check of what an engine returns, the shapes of arrays,
the headers of CSV files, the capabilities of engines and the generated documentation read this table.

To add one: a row of `TABLE`. If it follows from the states of single samples, its `derive` computes it for every engine
that gives these; otherwise an engine measures it, and declares it among its capabilities.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from numpy.typing import NDArray

Floats = NDArray[Any]

#: The matter of an observable: of which scenes it is one. Of any; of those with particles; of those with smooth forces;
#: of hard spheres (soft contacts or not); of lattice gases.
Matter = Literal["any", "particles", "smooth_particles", "hard_spheres", "lattice_gas"]
#: How a scene asks for it: not at all (every run has it), by `output.trajectory`, `output.forces`, `output.fields`,
#: `output.trace`, or by its name in `output.observables`.
Asked = Literal["always", "trajectory", "forces", "fields", "trace", "observables"]
#: Axes of the arrays, and what they are called in the generated documentation.
AXIS_NAMES = {
    "sample": "samples",
    "particle": "N",
    "axis": "d",
    "spin": "1 or 3",
    "face": "faces",
    "operation": "operations",
    "grid": "cells along x, y ...",
    "block": "blocks along x, y",
    "channel": "b",
    "row": "rows",
    "column": "columns",
    "event": "events",
    "partner": "2",
}
#: Columns of "operation_counts".
OPERATIONS = (
    "tree_comparisons",
    "list_moves",
    "predictions",
    "cell_crossings",
    "invalid_events",
    "wall_events",
    "renewals",
    "list_builds",
    "list_tests",
)


@dataclass(frozen=True)
class Observable:
    """One row of the table.

    name: in a run, `run[name]`. matter: see `Matter`. axes: of its array, names of `AXIS_NAMES`. unit: in terms of the
    scene's own units. meaning: one sentence, with the equation. cumulative: summed or integrated from the start of the
    run to the sample; else the value at the sample. asked: how a scene asks for it. refusable: an engine need not
    measure it; if false, every engine returns it. requires: a table of the scene without which it has no meaning, and
    why.
    derive: (masses (N,), samples by name) -> array, of an observable that follows from the samples `needs`; None:
    measured by the engine.
    """

    name: str
    matter: Matter
    axes: tuple[str, ...]
    unit: str
    meaning: str
    cumulative: bool = False
    asked: Asked = "observables"
    refusable: bool = True
    requires: tuple[str, str] | None = None
    needs: tuple[str, ...] = ()
    derive: Callable[[Floats, Mapping[str, Floats]], Floats] | None = None

    @property
    def shape(self) -> str:
        """The shape in words, as "(samples, N, d)"."""
        return f"({', '.join(AXIS_NAMES[axis] for axis in self.axes)}{',' if len(self.axes) == 1 else ''})"


def _hard(name: str, axes: tuple[str, ...], unit: str, meaning: str, **more: Any) -> Observable:
    return Observable(name, "hard_spheres", axes, unit, meaning, **{"cumulative": True, **more})


def _field(name: str, axes: tuple[str, ...], unit: str, meaning: str, *, cumulative: bool = True) -> Observable:
    return Observable(name, "hard_spheres", axes, unit, meaning, cumulative, asked="fields")


def _event(name: str, axes: tuple[str, ...], unit: str, meaning: str, **more: Any) -> Observable:
    return Observable(name, "hard_spheres", ("event", *axes), unit, meaning, False, "trace", **more)


#: What observables of the rotation require.
FRICTION = ("hard_spheres.friction", "smooth grains do not rotate")
_CYLINDER = ("box.cylinder", "there is no axis to turn about")
_STATES = ("sample", "particle", "axis")
_SPINS = ("sample", "particle", "spin")

_ROWS = (
    Observable("time", "any", ("sample",), "time", "times of the samples, the start included", False, "always",
               refusable=False),
    Observable("final_positions", "particles", ("particle", "axis"), "length", "positions at the end, unwrapped", False,
               "always", refusable=False),
    Observable("final_velocities", "particles", ("particle", "axis"), "length/time", "velocities at the end", False,
               "always", refusable=False),
    _hard("final_angular_velocities", ("particle", "spin"), "1/time", "angular velocities at the end", cumulative=False,
          asked="always", refusable=False, requires=FRICTION),
    Observable("positions", "particles", _STATES, "length", "positions, unwrapped, in the scene's order", False,
               "trajectory"),
    Observable("velocities", "particles", _STATES, "length/time", "velocities", False, "trajectory"),
    _hard("angular_velocities", _SPINS, "1/time", "angular velocities", cumulative=False, asked="trajectory",
          requires=FRICTION),
    Observable("forces", "smooth_particles", ("particle", "axis"), "force", "forces on the particles at the end", False,
               "forces"),
    Observable("kinetic_energy", "particles", ("sample",), "energy",
               "sum of m v^2/2, and of I omega^2/2 where grains rotate"),
    Observable("potential_energy", "particles", ("sample",), "energy",
               "of the interaction, of the truncation asked for, without tail corrections; of walls and fields too"),
    Observable("virial", "smooth_particles", ("sample",), "energy", "sum over pairs of r_ij . F_ij"),
    Observable("momentum", "particles", ("sample", "axis"), "momentum", "sum of m v", needs=("velocities",),
               derive=lambda masses, samples: masses @ samples["velocities"]),
    _hard("collisions", ("sample",), "none", "number of collisions of pairs"),
    _hard("events", ("sample",), "none", "number of events of all kinds"),
    _hard("collisional_virial", ("sample",), "energy time",
          "sum over impulses of r_ij . dp_ij, positive for repulsion, wells included"),
    _hard("dissipated_energy", ("sample",), "energy", "energy lost in collisions of pairs"),
    _hard("wall_impulse", ("sample", "face", "axis"), "momentum", "momentum given by the particles to each face"),
    _hard("wall_energy", ("sample", "face"), "energy", "energy given by each face to the particles"),
    _hard("wall_collisions", ("sample", "face"), "none", "number of collisions with each face"),
    _hard("wall_torque", ("sample",), "angular momentum",
          "angular impulse about the cylinder's axis, given by it to the particles",
          requires=_CYLINDER),
    _hard("kinetic_energy_integral", ("sample",), "energy time", "kinetic energy, integrated over time, exactly"),
    _hard("potential_energy_integral", ("sample",), "energy time", "potential energy, integrated over time, exactly"),
    _hard("deepest_overlap", ("sample",), "none",
          "largest (s - r)/s of a pair at its collision so far, s its contact distance"),
    _hard("operation_counts", ("sample", "operation"), "none", f"operations of the algorithm: {', '.join(OPERATIONS)}"),
    _hard("rotational_energy", ("sample",), "energy", "sum of I omega^2/2", cumulative=False, requires=FRICTION),
    _hard("contact_time", ("sample",), "time",
          "number of pairs in contact, integrated over time; 0 of hard spheres, collisions times t_c of soft ones"),
    _event("event_times", (), "time",
           "times of all events that change velocities, in their order: collisions, edges of wells, walls"),
    _event("event_partners", ("partner",), "none",
           "numbers of the two particles; of a wall, the second is -1 - face, the faces in the order of wall_impulse"),
    _event("event_positions", ("partner", "axis"), "length",
           "positions of the two at the event, unwrapped; 0 of a wall"),
    _event("event_velocities", ("partner", "axis"), "length/time",
           "velocities of the two after the event; 0 of a wall"),
    _event("event_angular_velocities", ("partner", "spin"), "1/time",
           "angular velocities of the two after the event; 0 of a wall", requires=FRICTION),
    Observable("populations", "lattice_gas", ("sample", "block", "channel"), "none",
               "particles of each channel in each block of output.fields; means, if the scheme moves mean occupations"),
    Observable("force_impulse", "lattice_gas", ("sample", "row"), "momentum",
               "momentum along x given by the force to each row", cumulative=True,
               requires=("lattice_gas.force", "nothing else gives it momentum")),
    Observable("h_function", "lattice_gas", ("sample",), "none",
               "sum of f ln f + (1 - f) ln(1 - f) over all channels"),
    Observable("sites", "lattice_gas", ("row", "column"), "none",
               "states of the sites at the end; bit i says that channel i is occupied"),
    _field("field_mass", ("grid",), "mass time", "mass in each cell, integrated over the run"),
    _field("field_momentum", ("grid", "axis"), "momentum time", "momentum in each cell, integrated over the run"),
    _field("field_kinetic", ("grid",), "energy time", "energy of translation in each cell, integrated over the run"),
    _field("field_rotational", ("grid",), "energy time", "energy of rotation in each cell, integrated over the run"),
    _field("field_flux_mass", ("axis", "grid"), "mass", "mass through the lower face of each cell, positive upwards"),
    _field("field_flux_momentum", ("axis", "grid", "axis"), "momentum",
           "momentum through the lower face of each cell, carried and by collisions"),
    _field("field_flux_energy", ("axis", "grid"), "energy",
           "energy through the lower face of each cell, carried and by collisions"),
    _field("field_dissipation", ("grid",), "energy", "energy lost in collisions, by cell"),
    _field("field_collisions", ("grid",), "none", "number of collisions, by cell"),
    _field("field_wall_momentum", ("grid", "axis"), "momentum", "momentum given by walls, by cell"),
    _field("field_wall_energy", ("grid",), "energy", "energy given by walls, by cell"),
    *(
        _field(f"field_{when}_{name}", axes, unit, f"{name} in each cell at the {word}", cumulative=False)
        for when, word in (("initial", "start"), ("final", "end"))
        for name, axes, unit in (
            ("mass", ("grid",), "mass"),
            ("momentum", ("grid", "axis"), "momentum"),
            ("energy", ("grid",), "energy"),
        )
    ),
)  # fmt: skip
#: Every observable, by name.
TABLE: dict[str, Observable] = {row.name: row for row in _ROWS}
#: What `output.observables` may name.
NAMED: tuple[str, ...] = tuple(row.name for row in _ROWS if row.asked == "observables")


def named(matter: Matter) -> tuple[str, ...]:
    """Names that `output.observables` may hold of this matter alone."""
    return tuple(name for name in NAMED if TABLE[name].matter == matter)


def asked_for(matters: tuple[Matter, ...], observables: tuple[str, ...], **switches: bool) -> dict[str, Observable]:
    """The rows of the table that a scene asks for, by name, in the order of the table.

    matters: those of the scene. observables: names in `output.observables`. switches: trajectory, forces, fields,
    trace: whether they are asked for.
    """
    return {
        row.name: row
        for row in TABLE.values()
        if row.matter in matters
        and (row.asked == "always" or (row.name in observables if row.asked == "observables" else switches[row.asked]))
    }


def lengths(axes: tuple[str, ...], sizes: Mapping[str, tuple[int, ...]]) -> tuple[int, ...]:
    """Shape of an array with these axes. sizes: numbers of elements along each axis by name, several for a grid."""
    return tuple(int(n) for axis in axes for n in sizes[axis])
