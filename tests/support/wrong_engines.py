"""Small engines for smooth forces, one right and the others each with one bug that simulation codes have had.

All pairs and images in plain numpy, velocity Verlet. Named as `tests/support/wrong_engines.py:Right`.
"""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np

from crosscheck.engines.capabilities import capability
from crosscheck.engines.protocol import Claims, Cost, Run, sample_times
from crosscheck.scene import Floats, Method, Scene

_ALL = "positions velocities forces kinetic_energy potential_energy virial"


class Right:
    """The engine without a bug. The methods below `run` are what the others change."""

    name = "right"
    schemes = {"velocity_verlet": Claims(order=(2, 2), symplectic=True, reversible=True)}
    capabilities = (
        capability(
            "gravity",
            "stepping",
            words="dimension=2 dimension=3 masses[] gravity.G gravity.softening",
            observables=_ALL,
        ),
        capability(
            "lennard_jones",
            "stepping",
            words="""
                dimension=2 dimension=3 masses[] box.boundaries=periodic box.boundaries=open lennard_jones.epsilon
                lennard_jones.length lennard_jones.length_form=sigma lennard_jones.truncation=truncated
                lennard_jones.truncation=shifted
            """,
            observables=_ALL,
        ),
    )

    def version(self) -> str:
        return "1"

    def supports(self, scene: Scene, method: Method) -> str | None:
        return None

    def run(self, scene: Scene, method: Method) -> Run:
        state, dt = scene.initial_state(), method.step
        r, v, m = state.positions, state.velocities, state.masses[:, None]
        steps = scene.steps(dt)
        every = scene.every(dt) or max(steps, 1)
        f, energy, virial = self.pairs(scene, r)
        half, samples = v, [(r, v, energy, virial)]
        for step in range(1, steps + 1):
            half = v + 0.5 * dt * f / self.inertia(m)
            r = r + dt * half
            f, energy, virial = self.pairs(scene, r)
            v = half + 0.5 * dt * f / self.inertia(m)
            if step % every == 0:
                samples.append((r, self.reported(v, half), energy, virial))
        positions, velocities, energies, virials = (np.array(column) for column in zip(*samples, strict=True))
        run = Run(
            time=sample_times(scene, method),
            final_positions=r,
            final_velocities=self.reported(v, half) if steps else v,
            cost=Cost(steps=steps, evaluations=steps + 1),
        )
        measured = {
            "kinetic_energy": 0.5 * np.sum(m * velocities**2, axis=(1, 2)),
            "potential_energy": energies,
            "virial": virials,
        }
        run.update({name: measured[name] for name in scene.output.observables})
        if scene.output.trajectory:
            run["positions"], run["velocities"] = positions, velocities
        if scene.output.forces:
            run["forces"] = f
        return run

    def inertia(self, m: Floats) -> Floats:
        return m

    def reported(self, v: Floats, half: Floats) -> Floats:
        return v

    def pairs(self, scene: Scene, r: Floats) -> tuple[Floats, float, float]:
        """Forces, energy and virial."""
        number = len(r)
        apart = self.images(scene, r[:, None] - r[None])
        s = (apart**2).sum(axis=-1)
        s[0, np.arange(number), np.arange(number)] = np.inf
        energy, force = self.gravity(scene, s) if scene.gravity is not None else self.lennard_jones(scene, s)
        force = self.known(force)
        forces = (force[..., None] * apart).sum(axis=(0, 2))
        finite = np.where(np.isfinite(s), s, 0.0)
        return self.total(forces, float(energy.sum()) / 2, float((force * finite).sum()) / 2, scene)

    def total(self, forces: Floats, energy: float, virial: float, scene: Scene) -> tuple[Floats, float, float]:
        return forces, energy, virial

    def known(self, force: Floats) -> Floats:
        """The forces of the pairs that count, (images, N, N)."""
        return force

    def shells(self, cutoff: float, side: float) -> int:
        return int(np.ceil(cutoff / side))

    def images(self, scene: Scene, apart: Floats) -> Floats:
        """(images, N, N, d), the nearest image first."""
        if scene.lennard_jones is None:
            return apart[None]
        sides, cutoff = scene.periods(), scene.lennard_jones.cutoff
        turns = np.rint(np.divide(apart, sides, out=np.zeros_like(apart), where=sides > 0))
        shells = [self.shells(cutoff, side) if side > 0 else 0 for side in sides]
        boxes = sorted(product(*(range(-n, n + 1) for n in shells)), key=lambda box: sum(map(abs, box)))
        return np.asarray(apart - turns * sides + np.array(boxes)[:, None, None, :] * sides)

    def gravity(self, scene: Scene, s: Floats) -> tuple[Floats, Floats]:
        """Energy of each pair, and force over distance."""
        assert scene.gravity is not None
        rho = np.sqrt(s + (scene.gravity.softening or 0.0) ** 2)
        strength = scene.gravity.G * np.multiply.outer(scene.initial_state().masses, scene.initial_state().masses)
        return -strength / rho, -strength / self.cube(rho, s)

    def cube(self, rho: Floats, s: Floats) -> Floats:
        return rho**3

    def lennard_jones(self, scene: Scene, s: Floats) -> tuple[Floats, Floats]:
        lj: Any = scene.lennard_jones
        near = s < lj.cutoff**2
        q3 = lj.length**6 / np.where(near, s, 1.0) ** 3
        c3 = (lj.length / lj.cutoff) ** 6
        shift = 4 * lj.epsilon * (c3**2 - c3) if lj.truncation == "shifted" else 0.0
        energy = 4 * lj.epsilon * (q3**2 - q3) - self.shift(shift)
        force = 24 * lj.epsilon * (2 * q3**2 - q3) / np.where(near, s, 1.0)
        return np.where(near, energy, 0.0), np.where(near, force, 0.0)

    def shift(self, at_cutoff: float) -> float:
        return at_cutoff


class SoftenedPower(Right):
    """The softened force falls with the wrong power: r/(rho^2 r) in place of r/rho^3."""

    name = "softened-power"

    def cube(self, rho: Floats, s: Floats) -> Floats:
        return np.asarray(rho**2 * np.sqrt(s))


class NearestImage(Right):
    """The nearest image alone, in whatever box."""

    name = "nearest-image"

    def shells(self, cutoff: float, side: float) -> int:
        return 0


class ListOnce(Right):
    """The pairs within the cutoff at the start, for the whole run."""

    name = "list-once"

    def run(self, scene: Scene, method: Method) -> Run:
        self._listed: Floats | None = None
        return super().run(scene, method)

    def known(self, force: Floats) -> Floats:
        if self._listed is None or self._listed.shape != force.shape:
            self._listed = force != 0
        return np.where(self._listed, force, 0.0)


class CutWithoutShift(Right):
    """The potential is cut where a shifted one is asked for."""

    name = "cut-without-shift"

    def shift(self, at_cutoff: float) -> float:
        return 0.0


class VirialOfSpace(Right):
    """In the plane the virial comes from a pressure of three dimensions."""

    name = "virial-of-space"

    def total(self, forces: Floats, energy: float, virial: float, scene: Scene) -> tuple[Floats, float, float]:
        return forces, energy, virial * (2 / 3 if scene.dimension == 2 else 1)


class VirialSign(Right):
    """The virial has the sign of sum r . grad U."""

    name = "virial-sign"

    def total(self, forces: Floats, energy: float, virial: float, scene: Scene) -> tuple[Floats, float, float]:
        return forces, energy, -virial


class HalfStepVelocities(Right):
    """Reports the velocities half a step earlier."""

    name = "half-step-velocities"

    def reported(self, v: Floats, half: Floats) -> Floats:
        return half


class MassOfAnother(Right):
    """Each force is divided by the mass of the next particle."""

    name = "mass-of-another"

    def inertia(self, m: Floats) -> Floats:
        return np.roll(m, 1, axis=0)


class OneSided(Right):
    """The later partner of each pair feels nothing."""

    name = "one-sided"

    def known(self, force: Floats) -> Floats:
        return np.triu(force)


class EnergyTwice(Right):
    """Every pair's energy is counted twice."""

    name = "energy-twice"

    def total(self, forces: Floats, energy: float, virial: float, scene: Scene) -> tuple[Floats, float, float]:
        return forces, 2 * energy, virial
