"""Random scenes and methods over the scene language, as tables: most are valid, some contradict themselves.

Few particles and few steps: what is tried is which entries go together, not physics.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import strategies as st

from crosscheck.scene.observables import TABLE
from crosscheck.scene.parts import INTERACTIONS

Table = dict[str, Any]
#: Time step, and the most steps.
STEP, STEPS = 0.0078125, 12
SCHEMES = {
    "stepping": ("velocity_verlet", "verlet", "gear4", "leapfrog", "whfast", "ias15"),
    "hard_spheres": (
        "event_driven",
        "event_driven_naive",
        "event_driven_lists",
        "event_driven_calendar",
        "event_driven_neighbours",
        "velocity_verlet",
        "collisions_direct",
        "collisions_tree",
        "collisions_line",
    ),
    "lattice_gas": ("lattice_planes", "lattice_lookup", "lattice_numpy", "lattice_boltzmann"),
}
_size = st.floats(0.25, 3.0).map(lambda x: round(x, 3))


def _maybe(values: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return st.none() | values


@st.composite
def _table(draw: st.DrawFn, required: Table, optional: Table) -> Table:
    """A table with the required entries, and each of the optional ones every other time."""
    table = {name: draw(values) for name, values in required.items()}
    return table | {name: draw(values) for name, values in optional.items() if draw(st.booleans())}


def _choice(*values: Any) -> st.SearchStrategy[Any]:
    return st.sampled_from(values)


@st.composite
def _output(draw: st.DrawFn, matters: set[str], dimension: int) -> Table:
    names = [name for name, row in TABLE.items() if row.matter in matters and row.asked == "observables"]
    output: Table = {"observables": draw(st.lists(_choice(*names), unique=True, max_size=4))}
    if "hard_spheres" in matters and draw(st.integers(0, 3)) == 0:
        output["collisions"] = draw(_choice([1], [1, 3], [2, 40]))
    else:
        output["interval"] = STEP * draw(st.integers(1, 4))
    output["trajectory"] = draw(st.booleans())
    if "smooth_particles" in matters:
        output["forces"] = draw(st.booleans())
    if "hard_spheres" in matters and draw(st.integers(0, 2)) == 0:
        output["fields"] = draw(st.lists(st.integers(1, 3), min_size=dimension, max_size=dimension))
    return output


@st.composite
def _explicit(draw: st.DrawFn, number: int, dimension: int, room: list[float], spins: bool) -> Table:
    """Places of a grid that fills `room`, displaced a little, in random order."""
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    edge = int(np.ceil(number ** (1 / dimension)))
    places = rng.permutation(np.stack(np.meshgrid(*[np.arange(edge)] * dimension), -1).reshape(-1, dimension))[:number]
    shaken = rng.uniform(-0.05, 0.05, places.shape)
    boxes_away = rng.integers(-1, 2, places.shape) * draw(_choice(0, 0, 2, 10**7))
    positions = ((places + 0.5 + shaken) / edge + boxes_away) * np.array(room)
    initial: Table = {"kind": "explicit", "positions": positions.tolist()}
    if draw(st.booleans()):
        initial["velocities"] = (rng.normal(size=places.shape) * draw(_choice(0.0, 1.0, 30.0))).tolist()
    if spins and draw(st.booleans()):
        initial["angular_velocities"] = rng.normal(size=(number, 1 if dimension == 2 else 3)).tolist()
    return initial


@st.composite
def _particles(draw: st.DrawFn, table: Table, dimension: int, room: list[float], *, kinds: int, spins: bool) -> None:
    """Adds initial state, masses and species to the table of a scene."""
    number = draw(st.integers(1, 7))
    structures = {2: ("square", "triangular"), 3: ("fcc", "sc")}.get(dimension, ("square",))
    if "box" in table and draw(st.booleans()):
        start = {draw(_choice("temperature", "speed")): draw(_choice(0.0, 1.0))}
        table["initial"] = {
            "kind": "lattice",
            "structure": draw(_choice(*structures)),
            "number": number,
            "seed": 3,
            **start,
        }
    else:
        table["initial"] = draw(_explicit(number, dimension, room, spins))
    if draw(st.booleans()):
        table["masses"] = draw(_size | st.lists(_size, min_size=number, max_size=number))
    if kinds > 1 or draw(st.integers(0, 3)) == 0:
        table["species"] = [i % draw(_choice(kinds, kinds, 2)) for i in range(number)]


@st.composite
def _smooth(draw: st.DrawFn, interaction: str) -> Table:
    dimension = draw(st.integers(1, 3) if interaction != "lennard_jones" else st.integers(2, 3))
    table: Table = {"dimension": dimension}
    room, kinds = [draw(st.floats(0.8, 7.0)) for _ in range(dimension)], 1
    if interaction == "spring":
        table["spring"] = draw(_table({"k": _size}, {"gamma": _size | st.just(0.0)}))
    elif interaction == "gravity":
        table["gravity"] = draw(_table({}, {"G": _size, "softening": _size}))
    else:
        kinds = draw(_choice(1, 1, 2))
        per_species = _size if kinds == 1 else st.lists(_size, min_size=kinds, max_size=kinds)
        optional = {
            "epsilon": per_species,
            "length": per_species,
            "length_form": _choice("sigma", "r_m"),
            "truncation": _choice("truncated", "shifted", "force_shifted"),
            "tail_corrections": st.booleans(),
        }
        table["lennard_jones"] = draw(_table({"cutoff": _choice(2.5, 0.9, 6.0)}, optional))
        if draw(st.integers(0, 3)):
            ends = draw(st.lists(_choice("periodic", "open", "wall"), min_size=dimension, max_size=dimension))
            table["box"] = {"lengths": room, "boundaries": ends}
            if "wall" in ends:
                table["box"]["wall"] = draw(_table({"cutoff": _size}, {"epsilon": _size, "sigma": _size}))
    draw(_particles(table, dimension, room, kinds=kinds, spins=False))
    if interaction == "gravity" and draw(st.integers(0, 3)) == 0:
        table["masses"] = (1.0, draw(_choice(0.0, 0.5)))
        table["initial"] = {"kind": "kepler", "eccentricity": draw(_choice(0.0, 0.6))}
        table.pop("species", None)
    if interaction == "gravity" and isinstance(table.get("masses"), list) and draw(st.booleans()):
        table["masses"][0] = 0.0
    table["output"] = draw(_output({"particles", "smooth_particles"}, dimension))
    return table


@st.composite
def _friction(draw: st.DrawFn, *, inertia: bool = False) -> Table:
    friction: Table = {"tangential_restitution": draw(_choice(-1.0, -0.3, 0.4, 1.0))}
    if draw(st.booleans()):
        friction |= {"static": 0.5, "sliding": draw(_choice(0.5, 0.2, 0.0))}
    if inertia and draw(st.booleans()):
        friction["inertia"] = draw(_choice(0.3, 0.5))
    return friction


@st.composite
def _hard(draw: st.DrawFn) -> Table:
    dimension, kinds = draw(st.integers(2, 3)), draw(_choice(1, 1, 2))
    rough, plain = draw(st.booleans()), draw(st.booleans())
    rough &= not plain
    one = _choice(0.3, 0.1) if rough else _choice(0.3, 0.1, 0.0)
    spheres: Table = draw(
        _table(
            {"diameter": one if kinds == 1 else st.lists(one, min_size=2, max_size=2)},
            {"restitution": _choice(0.0, 0.5, 1.0)},
        )
    )
    rare = st.integers(0, 4).map(lambda n: n == 0 and not plain)
    if rough:
        spheres["friction"] = draw(_friction(inertia=True))
    if draw(rare):
        spheres["well"] = {"depth": draw(_choice(0.5, -0.5)), "range": draw(_choice(1.5, 1.1))}
    if draw(rare):
        spheres["contact_duration"] = 0.01
    if draw(rare):
        spheres["fixed"] = [0]
    table: Table = {"dimension": dimension, "hard_spheres": spheres}
    room = [draw(st.floats(1.0, 5.0)) for _ in range(dimension)]
    if draw(st.integers(0, 4)):
        table["box"] = draw(_container(dimension, room, rough))
    if draw(st.booleans()):
        table["seed"] = 5
    if draw(rare):
        table["acceleration"] = [0.0] * (dimension - 1) + [-1.0]
    draw(_particles(table, dimension, room, kinds=kinds, spins=rough))
    table["output"] = draw(_output({"particles", "hard_spheres"}, dimension))
    return table


@st.composite
def _container(draw: st.DrawFn, dimension: int, room: list[float], rough: bool) -> Table:
    ends = draw(st.lists(_choice("periodic", "open", "hard"), min_size=dimension, max_size=dimension))
    friction = _friction()
    box: Table = {"lengths": room}
    if draw(st.integers(0, 4)) == 0:
        axis = draw(_choice(*"xyz"[:dimension]))
        across = [k for k in range(dimension) if dimension == 2 or "xyz"[k] != axis]
        for k in across:
            ends[k] = "open"
        box["cylinder"] = draw(
            _table(
                {"radius": st.just(0.5 * min(room[k] for k in across))},
                {"restitution": _choice(0.0, 0.8)} | ({"friction": friction} if rough else {}),
            )
        )
        box["cylinder"] |= {"axis": axis} if dimension == 3 else {}
        if "friction" in box["cylinder"]:
            box["cylinder"]["angular_velocity"] = draw(_choice(0.0, 2.0))
    moves = {
        "velocity": _choice(0.0, 0.5),
        "random_phase": st.fixed_dictionaries({"speed": _size}),
        "oscillation": st.fixed_dictionaries({"amplitude": st.just(0.01), "frequency": _size, "phase": _size}),
        "temperature": _size,
    }
    faces = {}
    for k, end in enumerate(ends):
        for side in "-+":
            if end == "hard" and draw(st.booleans()):
                surface = {"restitution": _choice(0.0, 0.5, 1.0)} | ({"friction": friction} if rough else {})
                face = draw(_table({}, surface))
                kind = draw(_choice(None, None, "open", *moves))
                if kind == "open":
                    face = {"open": True}
                elif kind is not None:
                    face = {**(face if kind != "temperature" else {}), kind: draw(moves[kind])}
                faces["xyz"[k] + side] = face
    return box | {"boundaries": ends} | ({"faces": faces} if faces else {})


@st.composite
def _lattice_gas(draw: st.DrawFn) -> Table:
    model = draw(_choice("hpp", "fhp1", "fhp2", "fhp3", "fhp_saturated", "fhp_saturated_identity"))
    columns, rows = draw(_choice(1, 4, 6, 70)), draw(_choice(2, 4, 6, 1))
    obstacle = st.one_of(
        st.fixed_dictionaries({"columns": st.just([0, columns // 2])}),
        st.fixed_dictionaries({"rows": st.just([0, 0])}),
        st.fixed_dictionaries({"centre": st.just([1.0, 1.0]), "radius": _choice(0.2, 1.5)}),
        st.fixed_dictionaries({"sites": st.just([[0, 0], [columns - 1, rows - 1]])}),
    )
    rule = _choice("bounce_back", "specular_x", "specular_y", "diffusive_x", "diffusive_y")
    obstacles = st.lists(st.builds(lambda where, what: {**where, "rule": what}, obstacle, rule), max_size=2)
    gas = draw(
        _table(
            {"model": st.just(model), "columns": st.just(columns), "rows": st.just(rows)},
            {"obstacles": obstacles, "force": _choice(0.0, 0.1, -0.5), "reversals": _choice([2], [1, 3])},
        )
    )
    wave = st.fixed_dictionaries({
        "of": _choice("density", "velocity_x"), "amplitude": _choice(0.01, 0.3), "mode": _choice([1, 0], [2, 1]),
    })  # fmt: skip
    uniform: Table = draw(_table(
        {"density": _choice(0.0, 0.2, 1.0, [0.3] * rows)},
        {"velocity_x": _choice(0.0, 0.1, [0.05] * rows), "velocity_y": _choice(0.1),
         "waves": st.lists(wave, max_size=2), "cells": _choice(1, 2)},
    ))  # fmt: skip
    channels = {"hpp": 4, "fhp1": 6, "fhp2": 7, "fhp3": 7}.get(model, 6)
    start = draw(_choice(uniform, uniform, {"channels": [0.25] * channels}))
    output: Table = {"interval": float(draw(st.integers(1, 4)))}
    names = [name for name, row in TABLE.items() if row.matter == "lattice_gas"]
    output["observables"] = draw(st.lists(_choice(*names), unique=True))
    if draw(st.booleans()):
        output["fields"] = draw(_choice([1, 1], [2, 2], [columns, rows]))
    return {
        "dimension": 2,
        "lattice_gas": gas,
        "initial": {"kind": "occupations", "seed": 1, **start},
        "output": output,
        "seed": 4,
    }


@st.composite
def runs(
    draw: st.DrawFn, interactions: tuple[str, ...] = INTERACTIONS, schemes: dict[str, tuple[str, ...]] = SCHEMES
) -> tuple[Table, Table]:
    """(scene, method): tables as of a scene file.

    interactions: to choose from. schemes: likewise, of "stepping" interactions, "hard_spheres" and "lattice_gas".
    """
    interaction = draw(_choice(*interactions))
    steps = draw(st.integers(0, 3)) * 4
    if interaction == "lattice_gas":
        table, scheme = draw(_lattice_gas()), draw(_choice(*schemes["lattice_gas"]))
        return {"name": "random", "duration": float(steps), **table}, {"scheme": scheme}
    hard = interaction == "hard_spheres"
    table = draw(_hard() if hard else _smooth(interaction))
    scheme = draw(_choice(*schemes["hard_spheres" if hard else "stepping"]))
    method: Table = {"scheme": scheme}
    if not scheme.startswith("event"):
        method["dt"] = STEP
    if hard and scheme == "velocity_verlet" and draw(st.integers(0, 7)):
        method["contact"] = draw(
            _table(
                {"friction": _choice("history", "dashpot"), "law": _choice("hooke", "hertz")},
                {},
            )
        )
        hertz = method["contact"]["law"] == "hertz"
        method["contact"] |= {"stiffness": 100.0} if hertz or draw(st.booleans()) else {"duration": 0.1}
    return {"name": "random", "duration": STEP * steps, **table}, method
