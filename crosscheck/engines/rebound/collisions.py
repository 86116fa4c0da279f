"""Scenes of hard spheres for REBOUND, which moves them by time steps and looks for collisions after each.

All spheres fly freely for dt. Then the pairs that overlap and approach get the impulse of a smooth collision,

    v_n' = -alpha v_n,   n along the centres at that moment,

one after the other in random order. So a pair collides up to dt late, at a distance r < s, s its contact distance, and
with a normal that is not the one at contact: trajectories have errors of order dt. A grazing collision is missed if no
step ends between first contact and closest approach. The collision rate nu of an elastic gas of disks with the contact
value chi of its pair distribution has the error

    dnu/nu = -(d ln chi/d ln s) <v_n> dt/(2 s) - <v^2> dt^2/(6 s^2) + ...,   <v_n> = sqrt(pi T/m),   <v^2> = 6 T/m:

pairs come closer by v_n dt/2 on average, as smaller disks would, which reduces chi, but not the cross-section; and the
fraction v^2 dt^2/(6 s^2) of the collisions at relative speed v is missed (averages are over the collisions).

"direct" tests every pair twice, as (i, j) and as (j, i), so that a pair that a third sphere pushes together again may
collide twice in a step. "tree" finds the same pairs with an octree; of unequal spheres, some as (larger, smaller) only.
"line" lists, once, the pairs whose paths during the step overlapped at any time; but REBOUND's resolution "hardsphere"
skips those that no longer overlap, so it finds no more collisions than the others.

Literature: H. Rein and S.-F. Liu, Astron. Astrophys. 537, A128 (2012).
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np

from crosscheck.engines.progress import report
from crosscheck.engines.protocol import Cost, Run, sample_times, strides, timed
from crosscheck.scene import Floats, Lattice, Method, Scene

#: Root boxes along an axis: the tree search looks through all of them for every sphere.
MOST_ROOT_BOXES = 64
_AXES_OF_SPACE = 3


def unsupported(scene: Scene) -> str | None:
    """None, or the reason why REBOUND cannot run this scene of hard spheres although it declares all of its words."""
    spheres = scene.hard_spheres
    assert spheres is not None
    if len(set(scene.boundaries)) > 1:
        return "REBOUND's boundaries are periodic along all axes, or open along all"
    if spheres.restitution == 0 and "collisions" in scene.output.observables:
        return "with restitution 0 it counts a pair again at every step as long as the spheres touch"
    diameters, lengths = scene.diameters(), scene.lengths()
    assert diameters is not None
    if np.count_nonzero(diameters == 0) > 1:
        return "in REBOUND two particles of diameter 0 may collide: at most one diameter may be 0"
    if "periodic" in scene.boundaries and lengths is not None and root_boxes(lengths) is None:
        return f"the box must consist of equal cubes (squares), at most {MOST_ROOT_BOXES} along an axis"
    return None


def root_boxes(lengths: Floats) -> tuple[float, tuple[int, ...]] | None:
    """Edge of the largest cubes (squares) of which the box consists, and their numbers along the axes.

    lengths: sides of the box, (d,), length. None if there are more than MOST_ROOT_BOXES along an axis.
    """
    ratios = [Fraction(length / lengths.min()).limit_denominator(MOST_ROOT_BOXES) for length in lengths.tolist()]
    parts = math.lcm(*(ratio.denominator for ratio in ratios))
    numbers = tuple(int(ratio * parts) for ratio in ratios)
    edge = float(lengths.min()) / parts
    # rounding errors: of the box's lengths, of the quotient, of the edge, and of REBOUND's product
    exact = np.allclose(np.multiply(numbers, edge), lengths, rtol=4 * np.finfo(float).eps, atol=0)
    return (edge, numbers) if exact and max(numbers) <= MOST_ROOT_BOXES else None


def run_collisions(scene: Scene, method: Method, search: str) -> Run:
    """Runs a scene of hard spheres by time steps.

    scene: accepted by `unsupported`. method: gives dt. search: REBOUND's name of a collision search, a value of
    `engine.SEARCHES`. UsageError if dt is missing, or does not divide duration and interval.
    """
    cost, times, output = Cost(), sample_times(scene, method), scene.output
    steps, every = strides(scene, method)
    gas = _Gas(scene, method, search)
    shape = (times.size, scene.number, scene.dimension)
    positions, velocities = np.full(shape, np.nan), np.full(shape, np.nan)
    collisions = np.full(times.size, np.nan)

    def record(sample: int) -> None:
        positions[sample], velocities[sample] = gas.state()
        collisions[sample] = gas.collisions

    record(0)
    with timed(cost):
        for sample in range(1, times.size):
            gas.advance(every)
            record(sample)
            report(sample * every / steps)
        gas.advance(steps % every)
    cost.steps, cost.events = steps, gas.collisions

    final_positions, final_velocities = gas.state()
    run = Run(time=times, final_positions=final_positions, final_velocities=final_velocities, cost=cost)
    run.diverged = not bool(np.isfinite([run["final_positions"], run["final_velocities"]]).all())
    if output.trajectory:
        run["positions"], run["velocities"] = positions, velocities
    if "kinetic_energy" in output.observables:
        run["kinetic_energy"] = 0.5 * np.einsum("n,snd,snd->s", gas.masses, velocities, velocities)
    if "collisions" in output.observables:
        run["collisions"] = collisions
    return run


class _Gas:
    """REBOUND's simulation of a scene, with unwrapped positions and the number of its collisions.

    REBOUND's box is centred at 0: `origin` is the scene's position of its centre. In the plane, z = 0.
    """

    def __init__(self, scene: Scene, method: Method, search: str) -> None:
        import rebound

        state, spheres = scene.initial_state(), scene.hard_spheres
        assert spheres is not None
        assert state.diameters is not None
        self.masses, self.dimension, self.dt = state.masses, scene.dimension, method.step
        self.images = np.zeros_like(state.positions)
        self.simulation: Any = rebound.Simulation()
        self.simulation.integrator, self.simulation.dt = "leapfrog", self.dt
        self.simulation.gravity = "none"
        self.simulation.collision, self.simulation.collision_resolve = search, self._resolve
        self.collisions, self._hardsphere = 0, rebound.clibrebound.reb_collision_resolve_hardsphere
        seed = scene.initial.seed if scene.seed is None and isinstance(scene.initial, Lattice) else scene.seed
        # seed of the order in which collisions are resolved; REBOUND's default is the time of day
        self.simulation.rand_seed = (seed or 0) % 2**32
        restitution = spheres.restitution
        if restitution < 1:
            self.simulation.coefficient_of_restitution = lambda simulation, speed: restitution
        if self.dimension == 2:
            self.simulation.pre_timestep_modifications = self._project_onto_plane

        self.lengths = state.lengths if "periodic" in scene.boundaries else None
        if self.lengths is not None:
            found = root_boxes(self.lengths)
            assert found is not None
            self.simulation.root_size, numbers = found
            for axis, number in zip("xyz", numbers, strict=False):
                setattr(self.simulation, f"N_root_{axis}", number)
                setattr(self.simulation, f"N_ghost_{axis}", 1)
            self.simulation.boundary = "periodic"
            self.origin = self.lengths / 2
            self.images = np.floor(state.positions / self.lengths)
        else:
            # the octree's box contains all that the spheres can reach
            self.origin = (state.positions.max(axis=0) + state.positions.min(axis=0)) / 2
            farthest = scene.duration * self._fastest(state.velocities)
            self.simulation.root_size = 4 * (float(np.abs(state.positions - self.origin).max()) + farthest) or 1.0
        wrapped_positions = state.positions - self.origin
        if self.lengths is not None:
            wrapped_positions -= self.images * self.lengths
        zeros = np.zeros((scene.number, _AXES_OF_SPACE - self.dimension))
        rows = np.hstack([wrapped_positions, zeros, state.velocities, zeros]).tolist()
        for row, m, diameter in zip(rows, state.masses.tolist(), state.diameters.tolist(), strict=True):
            entries = dict(zip(("x", "y", "z", "vx", "vy", "vz"), row, strict=True))
            self.simulation.add(m=m, r=diameter / 2, **entries)

    def advance(self, steps: int) -> None:
        """Takes this number of steps.

        In a periodic box it stops so often that no sphere moves more than a quarter of a side: more could not be
        unwrapped.
        """
        if self.lengths is None:
            self.simulation.steps(steps)
            return
        while steps > 0:
            before, velocities = self._wrapped()
            farthest = self._fastest(velocities) * self.dt
            limit = float(self.lengths.min()) / 4
            taken = steps if farthest * steps <= limit else max(1, int(limit / farthest))
            # a single step may be longer: its displacement is known, since collisions come after the flight
            flight = velocities * self.dt if taken == 1 else 0.0
            self.simulation.steps(taken)
            after, _ = self._wrapped()
            self.images += np.rint((before + flight - after) / self.lengths)
            steps -= taken

    def state(self) -> tuple[Floats, Floats]:
        """Positions, unwrapped, and velocities, (N, d)."""
        positions, velocities = self._wrapped()
        if self.lengths is not None:
            positions += self.images * self.lengths
        return positions + self.origin, velocities

    def _fastest(self, velocities: Floats) -> float:
        """Upper bound of all later speeds: that of the lightest sphere with all of the energy, which does not grow."""
        energy = 0.5 * float(self.masses @ (velocities**2).sum(axis=1))
        return math.sqrt(2 * energy / float(self.masses.min()))

    def _wrapped(self) -> tuple[Floats, Floats]:
        positions, velocities = np.empty((2, self.masses.size, _AXES_OF_SPACE))
        self.simulation.serialize_particle_data(xyz=positions, vxvyvz=velocities)
        return positions[:, : self.dimension], velocities[:, : self.dimension]

    def _resolve(self, simulation: Any, collision: Any) -> int:
        """REBOUND's resolution "hardsphere"; only impulses that change a velocity are counted as collisions.

        REBOUND's own counter also counts the zero impulses of pairs at rest in contact.
        """
        spheres = [simulation.contents._particles[index] for index in (collision.p1, collision.p2)]
        before = [(sphere.vx, sphere.vy, sphere.vz) for sphere in spheres]
        outcome = self._hardsphere(simulation, collision)
        self.collisions += before != [(sphere.vx, sphere.vy, sphere.vz) for sphere in spheres]
        return outcome

    def _project_onto_plane(self, _: Any) -> None:
        """Sets z and v_z to 0.

        REBOUND rotates normals with the sine and cosine of pi, whose rounding errors lead out of the plane and then
        grow at every collision, as fast as neighbouring trajectories diverge.
        """
        state = np.empty((self.masses.size, 2 * _AXES_OF_SPACE))
        self.simulation.serialize_particle_data(xyzvxvyvz=state)
        state[:, [2, 5]] = 0.0
        self.simulation.set_serialized_particle_data(xyzvxvyvz=state)
