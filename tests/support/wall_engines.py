"""Engines of points that never meet, between walls that draw at random: a right one, and wrong ones.

Points are followed one by one, with the random numbers of numpy in their order.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from crosscheck.engines.protocol import Run
from crosscheck.scene import Face, Scene


class Right:
    """A run of `scene`: hits exactly, samples by free flight."""

    def run(self, scene: Scene) -> Run:
        state, times, d = scene.initial_state(), scene.samples(), scene.dimension
        assert state.lengths is not None
        shape = (times.size, scene.number, d)
        r, v = np.empty(shape), np.empty(shape)
        counts, energy, push = (np.zeros((times.size, 2 * d, *more)) for more in ((), (), (d,)))
        seed = scene.seed or 0
        for i in range(scene.number):
            self.random = np.random.default_rng([seed, i])
            x, u, now = state.positions[i].copy(), state.velocities[i].copy(), 0.0
            mass, sample = float(state.masses[i]), 0
            while True:
                wait, face = self.next_wall(scene, state.lengths, x, u)
                while sample < times.size and times[sample] <= now + wait:
                    r[sample, i], v[sample, i] = x + u * (times[sample] - now), u
                    sample += 1
                if sample == times.size:
                    break
                x, now = x + u * wait, now + wait
                axis, upper = divmod(face, 2)
                x[axis] = state.lengths[axis] if upper else 0.0
                wall = scene.faces[face]
                assert wall is not None
                after = self.after(wall, axis, -1.0 if upper else 1.0, u, mass)
                counts[sample:, face] += 1
                energy[sample:, face] += mass / 2 * (after @ after - u @ u)
                push[sample:, face] += mass * (u - after)
                u = after
        tallies = {"wall_collisions": counts, "wall_energy": energy, "wall_impulse": push}
        return Run(tallies, time=times, positions=r, velocities=v, final_positions=r[-1], final_velocities=v[-1])

    def next_wall(self, scene: Scene, lengths: Any, x: Any, u: Any) -> tuple[float, int]:
        best = math.inf, -1
        for axis in range(scene.dimension):
            for upper in (0, 1):
                if scene.faces[2 * axis + upper] is not None and (u[axis] > 0 if upper else u[axis] < 0):
                    wait = ((lengths[axis] if upper else 0.0) - x[axis]) / u[axis]
                    best = min(best, (max(wait, 0.0), 2 * axis + upper))
        return best

    def after(self, wall: Face, axis: int, inwards: float, u: Any, mass: float) -> Any:
        new = u.copy()
        if wall.temperature is not None:
            width = math.sqrt(wall.temperature / mass)
            new = self.along(u, width)
            new[axis] = inwards * self.normal(width)
            return new
        assert wall.random_phase is not None
        v = inwards * u[axis]
        own = self.wall(wall.random_phase.speed, v, wall.random_phase.law)
        new[axis] = inwards * ((1 + wall.restitution) * own - wall.restitution * v)
        return new

    def along(self, u: Any, width: float) -> Any:
        return self.random.normal(scale=width, size=u.size)

    def normal(self, width: float) -> float:
        return width * math.sqrt(2 * self.random.exponential())

    def wall(self, top: float, v: float, law: str) -> float:
        while True:
            own = top * math.cos(self.random.uniform(0, 2 * math.pi))
            if own > v and (law == "uniform" or self.random.random() * (top - v) < own - v):
                return own


class NotTheFlux(Right):
    """The normal velocity is that of the gas, not of those that pass a plane."""

    def normal(self, width: float) -> float:
        return abs(float(self.random.normal(scale=width)))


class NoMass(Right):
    """Every particle gets the velocities of the mass 1."""

    def after(self, wall: Face, axis: int, inwards: float, u: Any, mass: float) -> Any:
        return super().after(wall, axis, inwards, u, 1.0)


class Slips(Right):
    """The velocity along a thermal wall stays."""

    def along(self, u: Any, width: float) -> Any:
        return u.copy()


class OneDraw(Right):
    """A particle gets the same random numbers at every hit."""

    def after(self, wall: Face, axis: int, inwards: float, u: Any, mass: float) -> Any:
        start = self.random.bit_generator.state
        new = super().after(wall, axis, inwards, u, mass)
        self.random.bit_generator.state = start
        return new


class UniformForFlux(Right):
    """The phase is not weighted with the speed of approach."""

    def wall(self, top: float, v: float, law: str) -> float:
        return super().wall(top, v, "uniform")


class FluxOfTheWall(Right):
    """The phase is weighted with the speed of the wall alone."""

    def wall(self, top: float, v: float, law: str) -> float:
        while True:
            own = top * math.cos(self.random.uniform(0, 2 * math.pi))
            if own > v and self.random.random() * 2 * top < own + top:
                return own
