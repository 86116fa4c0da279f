"""Scenes of springs, gravity and Lennard-Jones for the step loop of `refimpl.stepping`."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import numpy as np

from crosscheck.engines.progress import Pace, stage
from crosscheck.engines.protocol import Cost, Run, sample_times, timed
from crosscheck.engines.refimpl.continuation import Continuation
from crosscheck.engines.workers.cache import one_at_a_time
from crosscheck.scene import Floats, Method, Scene, State

if TYPE_CHECKING:
    from refimpl.stepping.integrate import Integration


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
    ends: Continuation | None = None,
) -> tuple[Integration, Cost]:
    """Integrates over the duration of `scene`; the result of `refimpl.stepping.integrate.integrate`, and the cost.

    Compilation is done before, and is not part of the cost of the integration. scene: gives duration and interval.
    method: scheme and dt. force: a force record of `refimpl`. r, v: flat coordinates and velocities, (n,). trajectory,
    thermo: whether to record the states, and the energies and the virial, at the samples. last: record so many of the
    last coordinates instead of all; None: all. ends: from where the run goes on, and what it leaves; None: nothing
    of it. UsageError if dt does not divide duration and interval.
    """
    from numba import typeof

    from refimpl.stepping.integrate import compile_steps, integrate, scheme_of

    dt, cost, kept = method.step, Cost(), method.compensated
    steps, every = scene.steps(dt), scene.every(dt)
    started = time.perf_counter()
    forces_type = str(typeof(force))
    stage("compiling kernels")
    with one_at_a_time(forces_type):
        integrate(method.scheme, force, r, v, dt, 0, thermo=thermo, compensated=kept)  # compiles the forces
    if steps:
        with one_at_a_time(f"{type(scheme_of(method.scheme, kept).record).__name__} {thermo} {forces_type}"):
            compile_steps(method.scheme, force, r, v, dt, thermo=thermo, compensated=kept)
    cost.compile = time.perf_counter() - started
    state = None
    if ends is not None and ends.start is not None:
        like = integrate(method.scheme, force, r, v, dt, 0, compensated=kept).state
        state = ends.restored(like, growing=("force",))

    with timed(cost):
        done = integrate(
            method.scheme,
            force,
            r,
            v,
            dt,
            steps,
            every=every,
            trajectory=trajectory,
            last=last,
            thermo=thermo,
            pace=Pace(steps).more,
            state=state,
            compensated=kept,
        )
    if ends is not None and not done.diverged:
        ends.leave(done.state)
    cost.steps, cost.evaluations = done.steps, done.evaluations
    for name, count in done.operations.items():
        setattr(cost, name, count)
    return done, cost


def run_steps(scene: Scene, method: Method, ends: Continuation | None = None) -> Run:
    """Runs a scene of springs, gravity or Lennard-Jones particles.

    scene, method: as for `Engine.run`. ends: from where the run goes on, and what it leaves; None: nothing of it.
    UsageError if dt does not divide duration and interval.
    """

    from refimpl.stepping.integrate import acceleration

    state, output = scene.initial_state(), scene.output
    r, v = state.positions.ravel(), state.velocities.ravel()
    done, cost = integrated(
        scene,
        method,
        force_record(scene, state, method.threads or 1),
        r,
        v,
        trajectory=output.trajectory,
        thermo=bool(output.observables),
        ends=ends,
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
        run["positions"], run["velocities"] = rows(done.positions), rows(done.velocities)
    if done.thermo is not None:
        for column, name in enumerate(("kinetic_energy", "potential_energy", "virial")):
            if name in output.observables:
                run[name] = done.thermo[:, column]
    if output.forces:
        a, _ = acceleration(done.force, done.r, done.v)
        run["forces"] = rows(a) * state.masses[:, None]
    return run


def unsupported_fluid(scene: Scene) -> str | None:
    """None, or why `refimpl` cannot compute the forces of a scene of [lennard_jones]: too many images in a short box.

    UsageError if the initial state of the scene is impossible.
    """
    from refimpl.stepping.kernels.neighbours import TooManyImages

    state = scene.initial_state()
    try:
        force_record(scene, state)
    except TooManyImages as error:
        return str(error)
    return None


def force_record(scene: Scene, state: State, threads: int = 1) -> Any:
    """The force record of `refimpl` for a scene.

    state: its initial state, which gives masses, species and the box. threads: that share its work, where it has them.
    """
    if scene.spring is not None:
        from refimpl.stepping.forces.spring import spring

        return spring(scene.spring.k, np.repeat(state.masses, scene.dimension), scene.spring.gamma)
    if scene.gravity is not None:
        from refimpl.stepping.forces.gravity import gravity

        return gravity(state.masses, scene.dimension, scene.gravity.G, scene.gravity.softening, threads)
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
        species=state.species if np.size(lj.epsilon) > 1 or np.size(lj.length) > 1 else None,
        epsilon=lj.epsilon,
        sigma=lj.length,
        length_form=lj.length_form,
        cutoff=lj.cutoff,
        truncation=lj.truncation,
        mass=float(state.masses[0]) if one_mass else state.masses,
        walls=None if wall is None else Walls(wall.epsilon, wall.sigma, wall.cutoff),
        threads=threads,
    )
