"""REBOUND as an engine: gravity by leap-frog, WHFast and IAS15; hard spheres by its searches for collisions.

Literature: H. Rein and S.-F. Liu, Astron. Astrophys. 537, A128 (2012); H. Rein and D. Tamayo, Mon. Not. R. Astron. Soc.
452, 376 (2015), WHFast; H. Rein and D. S. Spiegel, Mon. Not. R. Astron. Soc. 446, 1424 (2015), IAS15.
"""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np

from crosscheck.engines.capabilities import capability
from crosscheck.engines.progress import report
from crosscheck.engines.protocol import Claims, Cost, Run, sample_times, strides, timed
from crosscheck.engines.rebound.collisions import run_collisions, unsupported
from crosscheck.scene import Floats, Method, Scene

#: Schemes of hard spheres, and REBOUND's name of the search for collisions.
SEARCHES = {"collisions_direct": "direct", "collisions_line": "line", "collisions_tree": "tree"}


class ReboundEngine:
    """Gravity between all pairs, and smooth hard spheres (see `crosscheck.engines.rebound.collisions`).

    leapfrog: drift, kick, drift: position Verlet, not velocity Verlet.
    whfast: Kepler motion of each body about those before it (Jacobi coordinates: the first is meant to dominate)
    alternates with the other attractions; two bodies it solves exactly.
    ias15: adaptive, of order 15. `method.dt` is its first trial step; `cost.steps` counts the steps that it took, and
    `cost.evaluations` is 0, since REBOUND does not give the number of iterations.
    """

    name = "rebound"
    schemes = {
        "leapfrog": Claims((2, 2), None, symplectic=True, reversible=True),
        "whfast": Claims((2, 2), None, symplectic=True),
        "ias15": Claims(None, None),
    } | {name: Claims(kind="collision_search") for name in SEARCHES}
    capabilities = (
        capability(
            "gravity",
            "stepping",
            words="dimension=2 dimension=3 masses[] masses=0 gravity.G gravity.softening",
            observables="positions velocities forces kinetic_energy potential_energy virial",
        ),
        capability(
            "hard_spheres",
            "collision_search",
            words="""
                dimension=2 dimension=3 masses[] hard_spheres.diameter hard_spheres.diameter[] hard_spheres.restitution
                box.boundaries=periodic box.boundaries=open
            """,
            observables="positions velocities kinetic_energy collisions",
        ),
    )

    #: Thousands of steps of some hundred bodies take seconds.
    promises = ("long_runs", "impulses_after_steps")

    def version(self) -> str:
        import rebound

        return str(rebound.__version__)

    def supports(self, scene: Scene, method: Method) -> str | None:
        if scene.gravity is None:
            return unsupported(scene)
        if scene.gravity.softening is not None:
            if method.scheme == "whfast":
                return "WHFast solves Kepler's problem, which has no softening"
            if {"potential_energy", "virial"} & set(scene.output.observables):
                return "REBOUND's energy does not contain the softening"
        if method.scheme == "whfast":
            masses = np.atleast_1d(scene.masses)
            if scene.number < 2:
                return "WHFast needs at least two bodies"
            if masses[0] <= 0:
                return "WHFast needs a first body with mass, about which the others orbit"
        return None

    def run(self, scene: Scene, method: Method) -> Run:
        if method.scheme in SEARCHES:
            return run_collisions(scene, method, SEARCHES[method.scheme])
        state = scene.initial_state()
        simulation = _simulation(scene, state.positions, state.velocities, state.masses)
        simulation.integrator = method.scheme
        simulation.dt = method.step
        steps, every = strides(scene, method)
        times = sample_times(scene, method)
        shape = (times.size, scene.number, scene.dimension)
        output = scene.output
        cost = Cost()

        positions, velocities = np.full(shape, np.nan), np.full(shape, np.nan)
        total = np.full(times.size, np.nan)
        needs_states = output.trajectory or "kinetic_energy" in output.observables
        needs_energy = bool({"potential_energy", "virial"} & set(output.observables))

        def record(sample: int) -> None:
            if needs_states or needs_energy:
                positions[sample], velocities[sample] = _state(simulation, scene)
            if needs_energy:
                total[sample] = simulation.energy()

        record(0)
        with timed(cost):
            for sample in range(1, times.size):
                _advance(simulation, method, every, times[sample])
                record(sample)
                report(sample * every / steps)
            if steps % every:
                _advance(simulation, method, steps % every, steps * method.step)
        cost.steps = int(simulation.steps_done)
        cost.evaluations = 0 if method.scheme == "ias15" else cost.steps

        final_positions, final_velocities = _state(simulation, scene)
        run = Run(time=times, final_positions=final_positions, final_velocities=final_velocities, cost=cost)
        run.diverged = not bool(np.isfinite([run["final_positions"], run["final_velocities"]]).all())
        if output.trajectory:
            run["positions"], run["velocities"] = positions, velocities
        kinetic = 0.5 * np.einsum("n,snd,snd->s", state.masses, velocities, velocities)
        if "kinetic_energy" in output.observables:
            run["kinetic_energy"] = kinetic
        if "potential_energy" in output.observables:
            run["potential_energy"] = total - kinetic
        if "virial" in output.observables:
            run["virial"] = total - kinetic  # of 1/r^2 forces: r_ij . F_ij is the potential energy of the pair
        if output.forces:
            run["forces"] = _forces(scene, run["final_positions"], state.masses)
        return run


def _simulation(scene: Scene, positions: Floats, velocities: Floats, masses: Floats) -> Any:
    """A simulation with the bodies of the scene and their gravity."""
    import rebound

    assert scene.gravity is not None
    simulation = rebound.Simulation()
    simulation.G = scene.gravity.G
    simulation.softening = scene.gravity.softening or 0.0
    for r, v, m in zip(positions.tolist(), velocities.tolist(), masses.tolist(), strict=True):
        place = dict(zip(("x", "y", "z"), r, strict=False)) | dict(zip(("vx", "vy", "vz"), v, strict=False))
        simulation.add(m=m, **place)
    return simulation


def _advance(simulation: Any, method: Method, steps: int, time: float) -> None:
    """Takes these steps; ias15, which chooses its own, integrates to this time."""
    if method.scheme == "ias15":
        simulation.integrate(time, exact_finish_time=1)
    else:
        simulation.steps(steps)
        simulation.synchronize()


def _state(simulation: Any, scene: Scene) -> tuple[Floats, Floats]:
    """Positions and velocities, (N, d)."""
    positions, velocities = np.empty((2, scene.number, 3))
    simulation.serialize_particle_data(xyz=positions, vxvyvz=velocities)
    return positions[:, : scene.dimension], velocities[:, : scene.dimension]


def _forces(scene: Scene, positions: Floats, masses: Floats) -> Floats:
    """Forces at the positions, from a fresh simulation: the integrators leave other accelerations in the particles."""
    import rebound

    simulation = _simulation(scene, positions, np.zeros_like(positions), masses)
    rebound.clibrebound.reb_simulation_update_acceleration(ctypes.byref(simulation))
    accelerations = np.array([(p.ax, p.ay, p.az) for p in simulation.particles])
    return masses[:, None] * accelerations[:, : scene.dimension]
