"""`supports` and `run` on random scenes: a run of the right shapes or a refusal in words, never another exception."""

from __future__ import annotations

import json
from collections.abc import Iterator

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_scenes import INTERACTIONS, SCHEMES, Table, runs

from crosscheck.engines.workers.pool import Worker
from crosscheck.errors import Unsupported, UsageError
from crosscheck.scene import Method, Scene

STEPPING = ("gravity", "lennard_jones", "spring", "hard_spheres")
#: Schemes of `refimpl` by the kind of scene.
READABLE = {
    "stepping": ("velocity_verlet", "verlet", "gear4", "leapfrog"),
    "hard_spheres": ("event_driven_naive", "velocity_verlet", "leapfrog"),
    "lattice_gas": ("lattice_lookup", "lattice_numpy", "lattice_boltzmann"),
}


@pytest.fixture(scope="module", params=["ase", "rebound"])
def other(request: pytest.FixtureRequest) -> Iterator[Worker]:
    worker = Worker(request.param, time_limit=60)
    yield worker
    worker.close()


def try_out(worker: Worker, tables: tuple[Table, Table]) -> None:
    table, method = tables
    try:
        scene, how = Scene.from_json(json.dumps(table)), Method.model_validate_json(json.dumps(method))
        reason = worker.supports(scene, how)
    except UsageError as error:
        assert str(error)  # noqa: PT017
        return
    try:
        # the worker checks the arrays: names and shapes of all that is asked for, and of nothing else
        run = worker.run(scene, how)
    except UsageError as error:
        assert str(error)  # noqa: PT017
    except Unsupported as refusal:
        assert reason, "supports said yes"
        assert reason in str(refusal)  # noqa: PT017
    else:
        assert reason is None
        assert set(run) == set(scene.asked())


@settings(max_examples=60)
@given(runs(("spring", "gravity", "hard_spheres", "lattice_gas"), READABLE))
def test_refimpl_as_plain_python(interpreted: Worker, tables: tuple[Table, Table]) -> None:
    try_out(interpreted, tables)


@settings(max_examples=25)
@given(runs(("lennard_jones",), {**SCHEMES, "stepping": ("velocity_verlet",)}))
def test_fluids_of_refimpl(interpreted: Worker, tables: tuple[Table, Table]) -> None:
    """One species without its own truncation, masses and walls; any box, any output."""
    table, method = tables
    fluid = {name: value for name, value in table["lennard_jones"].items() if name in ("cutoff", "tail_corrections")}
    ends = ["periodic" if end == "wall" else end for end in table.get("box", {}).get("boundaries", ())]
    box = {"box": {"lengths": table["box"]["lengths"], "boundaries": ends}} if ends else {}
    output = {**table["output"], "observables": ["kinetic_energy", *table["output"]["observables"]]}
    kept = {name: table[name] for name in ("name", "dimension", "duration", "initial", "species") if name in table}
    output["observables"] = list(dict.fromkeys(output["observables"]))
    try_out(interpreted, ({**kept, **box, "lennard_jones": fluid, "output": output}, method))


@settings(max_examples=60)
@given(runs(STEPPING, {**SCHEMES, "stepping": ("velocity_verlet",), "hard_spheres": ("velocity_verlet",)}))
def test_lammps(lammps: Worker, tables: tuple[Table, Table]) -> None:
    try_out(lammps, tables)


@settings(max_examples=40)
@given(data=st.data())
def test_other_engines(other: Worker, data: st.DataObject) -> None:
    own = {"ase": ("lennard_jones",), "rebound": ("gravity", "hard_spheres")}[other.engine]
    schemes = {
        "stepping": {"ase": ("velocity_verlet",), "rebound": ("leapfrog", "whfast", "ias15")}[other.engine],
        "hard_spheres": ("collisions_direct", "collisions_tree", "collisions_line"),
    }
    try_out(other, data.draw(runs(own, {**SCHEMES, **schemes})))


@settings(max_examples=40)
@given(runs(INTERACTIONS))
def test_what_is_refused_is_refused_before_anything_runs(lammps: Worker, tables: tuple[Table, Table]) -> None:
    """Scenes and schemes of all kinds, most of which LAMMPS has not."""
    try_out(lammps, tables)
