"""Lattice gases of `refimpl.lattice`, and their Boltzmann equation, behind the engine of `refimpl`."""

from __future__ import annotations

import time
from importlib import import_module
from typing import Any

import numpy as np

from crosscheck.engines.progress import Pace, stage
from crosscheck.engines.protocol import Cost, Run, shapes, timed
from crosscheck.engines.refimpl.continuation import Continuation
from crosscheck.engines.workers.cache import one_at_a_time
from crosscheck.scene import Floats, Method, Occupations, Scene
from crosscheck.scene.lattice_gas import gas_model

BOLTZMANN = "lattice_boltzmann"


def unsupported(scene: Scene, scheme: str) -> str | None:
    """None, or why this scheme cannot run the scene although it declares all of its words."""
    assert isinstance(scene.initial, Occupations)
    if scheme == BOLTZMANN and scene.initial.cells is not None:
        return f"'{BOLTZMANN}' moves mean occupations: remove initial.cells, which counts particles"
    return None


def run_lattice(scene: Scene, method: Method, evolver: str, ends: Continuation | None = None) -> Run:
    """Runs a lattice gas.

    scene: a scene of a lattice gas. method: scheme and threads. evolver: "module.Class" in `refimpl.lattice` that moves
    it. ends: from where the run goes on, and what it leaves; None: nothing of it.
    """
    from refimpl.compilation import INTERPRETED

    module, name = evolver.split(".")
    kind = getattr(import_module(f"refimpl.lattice.{module}"), name)
    gas = _initial_gas(scene, method, kind, ends)
    cost = Cost()
    started = time.perf_counter()
    stage("compiling kernels")
    with one_at_a_time(f"{method.scheme} {_kernel_features(scene)}"):
        gas.advance(0)  # compiles, or loads from the cache
        if not INTERPRETED:
            _observed(scene, gas, set(scene.output.observables))
    cost.compile = time.perf_counter() - started

    start = gas.time
    times = scene.samples()
    run = Run({name: np.zeros(shape) for name, shape in shapes(scene, times.size).items()}, cost=cost)
    run["time"] = times
    names = set(scene.output.observables) - {"sites"}
    pace = Pace(start + scene.duration, start)
    reversals = [start + step for step in (scene.lattice_gas.reversals or ())] if scene.lattice_gas else []
    for sample, moment in enumerate(times):
        with timed(cost):
            _advance(gas, start + int(moment), reversals, pace)
        for name, value in _observed(scene, gas, names).items():
            run[name][sample] = value
    with timed(cost):
        _advance(gas, start + int(scene.duration), reversals, pace)
    if "sites" in scene.output.observables:
        run["sites"] = gas.sites
    cost.steps = int(scene.duration)
    assert scene.lattice_gas is not None
    cost.site_updates = int(gas.passes.sum()) * scene.lattice_gas.columns
    cost.row_fetches = int(gas.fetches.sum()) if hasattr(gas, "fetches") else None
    if ends is not None:
        ends.leave(_state(gas))
    return run


def _state(gas: Any) -> dict[str, Any]:
    """What decides all that follows: time, and states or occupations; random numbers depend on time and site."""
    return {"time": gas.time, "f": gas.f} if hasattr(gas, "f") else {"time": gas.time, "sites": gas.sites}


def _initial_gas(scene: Scene, method: Method, kind: Any, ends: Continuation | None) -> Any:
    """The gas, an instance of the class `kind`, in the state in which the run starts."""
    from refimpl.lattice.gas import Forcing

    gas, initial, model = scene.lattice_gas, scene.initial, gas_model(scene)
    assert gas is not None
    assert isinstance(initial, Occupations)
    forcing = None
    if gas.force is not None:
        channel = 0 if gas.force >= 0 else model.velocities.image(-1, 1)[0]
        forcing = Forcing(channel, abs(gas.force))
    walls = scene.wall_rules()
    if method.scheme == BOLTZMANN:
        found = kind(model, scene.initial_occupations(), walls=walls, forcing=forcing)
        if ends is not None:
            found.time, found.f = ends.restored(_state(found)).values()
        return found
    seed = initial.seed if scene.seed is None else scene.seed
    time, sites = 0, scene.initial_sites()
    if ends is not None:
        time, sites = ends.restored({"time": time, "sites": sites}).values()
    more = {} if method.threads is None else {"threads": method.threads}
    found = kind(model, sites, seed=seed, walls=walls, forcing=forcing, **more)
    found.time = time
    return found


def _kernel_features(scene: Scene) -> str:
    """Name of the features that decide which kernel is compiled."""
    gas = scene.lattice_gas
    assert gas is not None
    drawn = any(obstacle.rule.startswith("diffusive") for obstacle in gas.obstacles)
    return f"{gas.model} {bool(gas.obstacles)} {drawn} {gas.force is not None}"


def _advance(gas: Any, moment: int, reversals: list[int], pace: Pace) -> None:
    """Advances the gas to step `moment`; reversals on the way are done, and removed from the list."""
    while gas.time < moment:
        until = min(moment, reversals[0]) if reversals else moment
        gas.advance(min(until - gas.time, pace.more(gas.time)))
        if reversals and gas.time == reversals[0]:
            gas.reverse()
            reversals.pop(0)


def _observed(scene: Scene, gas: Any, wanted: set[str]) -> dict[str, Floats]:
    """The wanted observables at the present step."""
    found: dict[str, Any] = {}
    if "populations" in wanted:
        across, down = scene.output.fields or (1, 1)
        found["populations"] = gas.populations(down, across).transpose(1, 0, 2)
    if "force_impulse" in wanted:
        assert scene.lattice_gas is not None
        assert scene.lattice_gas.force is not None
        # a particle that is turned from -x to +x changes its momentum by 2
        found["force_impulse"] = gas.impulses * 2 * np.copysign(1.0, scene.lattice_gas.force)
    if "h_function" in wanted:
        found["h_function"] = gas.h_function
    return found
