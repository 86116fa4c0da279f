"""Scenes of hard spheres for REBOUND, which moves them by time steps and looks for collisions after each.

All spheres fly freely for dt. Then the pairs that overlap and approach get the impulse of a smooth collision,

    v_n' = -alpha v_n,   n along the centres at that moment,

one after the other in random order. So a pair collides up to dt late, at a distance r < s, s its contact distance, and
with the normal of other points of the spheres: trajectories err by order dt. A grazing pair passes unseen if no step
ends between its first contact and its closest approach. The collision rate nu of an elastic gas of disks with the
contact value chi of its pair distribution errs by

    dnu/nu = -(d ln chi/d ln s) <v_n> dt/(2 s) - <v^2> dt^2/(6 s^2) + ...,   <v_n> = sqrt(pi T/m),   <v^2> = 6 T/m:

pairs come closer by v_n dt/2 in the mean, as smaller disks would, which takes from chi, but not from the cross-section;
and v^2 dt^2/(6 s^2) of the pairs with relative speed v pass unseen (means over the collisions).

"direct" tries all pairs, each of them twice: from both sides, so that a pair that a third sphere drives together again
may collide twice in a step. "tree" finds the same pairs with an octree; of unequal spheres, some from the larger one's
side only. "line" lists, once, the pairs whose paths during the step overlapped at any time; but REBOUND's resolution
"hardsphere" passes over those that do not overlap any more, so it finds no more collisions than the others.

Literature: H. Rein and S.-F. Liu, Astron. Astrophys. 537, A128 (2012).
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np

from crosscheck.engines.protocol import Cost, Run, sample_times, strides, timed
from crosscheck.scene import Floats, Lattice, Method, Scene

#: Root boxes along an axis: the tree search looks through all of them for every sphere.
MOST_ROOT_BOXES = 64
_AXES_OF_SPACE = 3


def unsupported(scene: Scene) -> str | None:
    """None, or the reason why REBOUND cannot run this scene of hard spheres."""
    spheres = scene.hard_spheres
    assert spheres is not None
    if len(set(scene.boundaries)) > 1:
        return "REBOUND's boundaries are periodic along all axes, or open along all"
    if spheres.restitution == 0 and "collisions" in scene.output.observables:
        return "with restitution 0 it counts a pair again at every step until the spheres have slid apart"
    diameters, lengths = scene.diameters(), scene.lengths()
    assert diameters is not None
    if np.count_nonzero(diameters == 0) > 1:
        return "two points that meet collide: at most one diameter may be 0"
    if "periodic" in scene.boundaries and lengths is not None and root_boxes(lengths) is None:
        return f"the box must consist of equal cubes (squares), at most {MOST_ROOT_BOXES} along an axis"
    return None


def root_boxes(lengths: Floats) -> tuple[float, tuple[int, ...]] | None:
    """Edge of the largest cubes (squares) that make up the box, and their numbers along the axes; None: too many."""
    ratios = [Fraction(length / lengths.min()).limit_denominator(MOST_ROOT_BOXES) for length in lengths.tolist()]
    parts = math.lcm(*(ratio.denominator for ratio in ratios))
    numbers = tuple(int(ratio * parts) for ratio in ratios)
    edge = float(lengths.min()) / parts
    # roundings: of the box's own lengths, of the quotient, of the edge, and of REBOUND's product
    exact = np.allclose(np.multiply(numbers, edge), lengths, rtol=4 * np.finfo(float).eps, atol=0)
    return (edge, numbers) if exact and max(numbers) <= MOST_ROOT_BOXES else None


def run_collisions(scene: Scene, method: Method, search: str) -> Run:
    """Runs a scene of hard spheres by time steps, with REBOUND's collision search of this name."""
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

    REBOUND's space is that of a box about the origin: `origin` is its middle. In the plane, z = 0.
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
        # of the order in which collisions are resolved; by default it is the clock's
        self.simulation.rand_seed = (seed or 0) % 2**32
        restitution = spheres.restitution
        if restitution < 1:
            self.simulation.coefficient_of_restitution = lambda simulation, speed: restitution
        if self.dimension == 2:
            self.simulation.pre_timestep_modifications = self._flatten

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
            # the octree's box is larger than the spheres can reach
            self.origin = (state.positions.max(axis=0) + state.positions.min(axis=0)) / 2
            farthest = scene.duration * self._fastest(state.velocities)
            self.simulation.root_size = 4 * (float(np.abs(state.positions - self.origin).max()) + farthest) or 1.0
        places = state.positions - self.origin
        if self.lengths is not None:
            places -= self.images * self.lengths
        still = np.zeros((scene.number, _AXES_OF_SPACE - self.dimension))
        rows = np.hstack([places, still, state.velocities, still]).tolist()
        for row, m, diameter in zip(rows, state.masses.tolist(), state.diameters.tolist(), strict=True):
            entries = dict(zip(("x", "y", "z", "vx", "vy", "vz"), row, strict=True))
            self.simulation.add(m=m, r=diameter / 2, **entries)

    def advance(self, steps: int) -> None:
        """Takes so many steps. In a periodic box no sphere moves far enough between two looks to be mistaken."""
        if self.lengths is None:
            self.simulation.steps(steps)
            return
        while steps > 0:
            before, velocities = self._wrapped()
            farthest = self._fastest(velocities) * self.dt
            room = float(self.lengths.min()) / 4
            stretch = steps if farthest * steps <= room else max(1, int(room / farthest))
            # of a single step the flight is known, however far it goes: collisions come after it
            flight = velocities * self.dt if stretch == 1 else 0.0
            self.simulation.steps(stretch)
            after, _ = self._wrapped()
            self.images += np.rint((before + flight - after) / self.lengths)
            steps -= stretch

    def state(self) -> tuple[Floats, Floats]:
        """Positions, unwrapped, and velocities, (N, d)."""
        positions, velocities = self._wrapped()
        if self.lengths is not None:
            positions += self.images * self.lengths
        return positions + self.origin, velocities

    def _fastest(self, velocities: Floats) -> float:
        """What no sphere's speed exceeds from now on: with all of the energy, which does not grow."""
        energy = 0.5 * float(self.masses @ (velocities**2).sum(axis=1))
        return math.sqrt(2 * energy / float(self.masses.min()))

    def _wrapped(self) -> tuple[Floats, Floats]:
        positions, velocities = np.empty((2, self.masses.size, _AXES_OF_SPACE))
        self.simulation.serialize_particle_data(xyz=positions, vxvyvz=velocities)
        return positions[:, : self.dimension], velocities[:, : self.dimension]

    def _resolve(self, simulation: Any, collision: Any) -> int:
        """REBOUND's resolution "hardsphere", which counts an impulse even if it is 0: of pairs that rest in contact."""
        spheres = [simulation.contents._particles[index] for index in (collision.p1, collision.p2)]
        before = [(sphere.vx, sphere.vy, sphere.vz) for sphere in spheres]
        outcome = self._hardsphere(simulation, collision)
        self.collisions += before != [(sphere.vx, sphere.vy, sphere.vz) for sphere in spheres]
        return outcome

    def _flatten(self, _: Any) -> None:
        """Back into the plane: REBOUND turns a normal by sine and cosine of pi, whose rounding errors leave it.

        Spheres out of the plane are scattered out of it, further at every collision, as fast as trajectories diverge.
        """
        state = np.empty((self.masses.size, 2 * _AXES_OF_SPACE))
        self.simulation.serialize_particle_data(xyzvxvyvz=state)
        state[:, [2, 5]] = 0.0
        self.simulation.set_serialized_particle_data(xyzvxvyvz=state)
