"""The reference implementations of `refimpl` as an engine."""

from __future__ import annotations

import time
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from crosscheck.engines import soft_spheres
from crosscheck.engines.base import Claims, Cost, Run, sample_times, timed
from crosscheck.engines.cache import one_at_a_time
from crosscheck.scene import Floats, Method, Scene, State
from refimpl.stepping.schemes import SCHEMES

if TYPE_CHECKING:
    from refimpl.stepping.integrate import Integration

NAIVE = "event_driven_naive"
#: Event-driven schemes, and the queue of events that `refimpl.events` calls by that name.
SCHEDULERS = {
    "event_driven": "tree",
    "event_driven_lists": "lists",
    "event_driven_calendar": "calendar",
    NAIVE: "naive",
}
#: Schemes of lattice gases, and the class of `refimpl.lattice` that moves them.
EVOLVERS = {
    "lattice_planes": "bitplanes.PlaneGas",
    "lattice_lookup": "lookup.LookupGas",
    "lattice_numpy": "plain.PlainGas",
    "lattice_boltzmann": "boltzmann.BoltzmannLattice",
}
#: Schemes that move soft grains: the stretch of a contact grows once a step, at the new time.
GRAINS = ("velocity_verlet", "leapfrog", "verlet", "symplectic_euler")
#: What can be told from the states of the naive algorithm.
_PLAIN = ("kinetic_energy", "potential_energy", "rotational_energy", "collisions", "events")


class RefimplEngine:
    name = "refimpl"
    schemes = {name: Claims(s.order, s.order_damped, s.symplectic, s.reversible) for name, s in SCHEMES.items()} | {
        name: Claims(None, events=True) for name in SCHEDULERS
    }
    schemes |= {name: Claims(None, lattice=True) for name in EVOLVERS}

    def version(self) -> str:
        import numba

        from crosscheck import __version__

        return f"{__version__} (numba {numba.__version__})"

    def supports(self, scene: Scene, method: Method) -> str | None:
        if method.scheme not in self.schemes:
            return f"no scheme '{method.scheme}'"
        if (scene.lattice_gas is not None) != (method.scheme in EVOLVERS):
            return f"lattice gases, and only they, are moved by {_names(EVOLVERS)}; found '{method.scheme}'"
        if scene.lattice_gas is not None:
            from crosscheck.engines.refimpl_lattice import unsupported

            return unsupported(scene, method.scheme)
        if method.contact is not None and method.scheme in SCHEDULERS:
            return f"method.contact is for schemes with time steps: {_names(GRAINS)}"
        if scene.hard_spheres is not None and method.scheme not in SCHEDULERS:
            if method.contact is not None and method.scheme not in GRAINS:
                return f"soft grains need a scheme that asks for the force once a step: {_names(GRAINS)}"
            return soft_spheres.unsupported(scene, method)
        if scene.hard_spheres is None and method.scheme in SCHEDULERS:
            return f"'{method.scheme}' is for [hard_spheres] only: take a scheme with time steps"
        if method.scheme == NAIVE and scene.hard_spheres is not None:
            unknown: list[str] = [name for name in scene.output.observables if name not in _PLAIN]
            if scene.output.fields is not None:
                unknown.append("fields")
            if unknown:
                return f"'{NAIVE}' is the plain algorithm, which does not measure {', '.join(unknown)}"
        return None

    def run(self, scene: Scene, method: Method) -> Run:
        if scene.lattice_gas is not None:
            from crosscheck.engines.refimpl_lattice import run_lattice

            return run_lattice(scene, method.scheme, EVOLVERS[method.scheme])
        if scene.hard_spheres is not None and method.contact is not None:
            from crosscheck.engines.refimpl_grains import run_grains

            return run_grains(scene, method)
        if scene.hard_spheres is not None:
            from crosscheck.engines.refimpl_events import run_events

            return run_events(scene, SCHEDULERS[method.scheme])
        return _run_steps(scene, method)


def _names(names: Iterable[str]) -> str:
    return ", ".join(f"'{name}'" for name in names)


def integrated(
    scene: Scene,
    method: Method,
    force: Any,
    r: Floats,
    v: Floats,
    *,
    trajectory: bool,
    thermo: bool,
    last: int | None = None,
) -> tuple[Integration, Cost]:
    """The step loop over the scene's duration, compiled apart; arguments as of `refimpl.stepping.integrate`."""
    from numba import typeof

    from refimpl.stepping.integrate import compile_steps, integrate

    dt, cost = method.step, Cost()
    steps, every = scene.steps(dt), scene.every(dt)
    started = time.perf_counter()
    forces_type = str(typeof(force))
    with one_at_a_time(forces_type):
        integrate(method.scheme, force, r, v, dt, 0, thermo=thermo)  # compiles the forces
    if steps:
        with one_at_a_time(f"{type(SCHEMES[method.scheme].record).__name__} {thermo} {forces_type}"):
            compile_steps(method.scheme, force, r, v, dt, thermo=thermo)
    cost.compile = time.perf_counter() - started

    with timed(cost):
        done = integrate(
            method.scheme, force, r, v, dt, steps, every=every, trajectory=trajectory, last=last, thermo=thermo
        )
    cost.steps, cost.evaluations = done.steps, done.evaluations
    return done, cost


def _run_steps(scene: Scene, method: Method) -> Run:
    from refimpl.stepping.integrate import acceleration

    state, output = scene.initial_state(), scene.output
    r, v = state.positions.ravel(), state.velocities.ravel()
    done, cost = integrated(
        scene,
        method,
        _force(scene, state),
        r,
        v,
        trajectory=output.trajectory,
        thermo=bool(output.observables),
    )

    def rows(flat: Floats) -> Floats:
        return flat.reshape(*flat.shape[:-1], scene.number, scene.dimension)

    run = Run(
        time=sample_times(scene, method),
        final_positions=rows(done.r),
        final_velocities=rows(done.v),
        diverged=done.diverged,
        cost=cost,
    )
    if done.positions is not None and done.velocities is not None:
        run.positions, run.velocities = rows(done.positions), rows(done.velocities)
    if done.thermo is not None:
        for column, name in enumerate(("kinetic_energy", "potential_energy", "virial")):
            if name in output.observables:
                setattr(run, name, done.thermo[:, column])
    if output.forces:
        a, _ = acceleration(done.force, done.r, done.v)
        run.forces = rows(a) * state.masses[:, None]
    return run


def _force(scene: Scene, state: State) -> Any:
    """The force record of `refimpl` for a scene."""
    if scene.spring is not None:
        from refimpl.stepping.forces.spring import spring

        masses = np.unique(state.masses)
        if masses.size > 1:
            raise ValueError("[spring] takes one mass for all particles")
        return spring(scene.spring.k, float(masses[0]), scene.spring.gamma)
    if scene.gravity is not None:
        from refimpl.stepping.forces.gravity import gravity

        return gravity(state.masses, scene.dimension, scene.gravity.G, scene.gravity.softening)
    from refimpl.stepping.forces.lennard_jones import Walls, lennard_jones

    lj, box = scene.lennard_jones, scene.box
    assert lj is not None
    wall = None if box is None else box.wall
    one_mass = bool((state.masses == state.masses[0]).all())
    return lennard_jones(
        number=scene.number,
        dimension=scene.dimension,
        lengths=None if state.lengths is None else tuple(state.lengths.tolist()),
        periodic=tuple(boundary == "periodic" for boundary in scene.boundaries),
        species=state.species,
        epsilon=lj.epsilon,
        sigma=lj.length,
        length_form=lj.length_form,
        cutoff=lj.cutoff,
        truncation=lj.truncation,
        mass=float(state.masses[0]) if one_mass else state.masses,
        walls=None if wall is None else Walls(wall.epsilon, wall.sigma, wall.cutoff),
    )
