"""Foreign engines of soft grains, loop by loop: a right one, and wrong ones with one mistake each.

`Right` knows springs with dashpots in boxes with plane walls that do not move. The others are published kinds of
mistakes of codes of soft grains.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from crosscheck.engines.capabilities import capability
from crosscheck.engines.protocol import Claims, Run, sample_times, shapes
from crosscheck.engines.soft_spheres import ContactLaw, inertia_ratio, soft_spheres
from crosscheck.scene import Method, Scene

_WORDS = """
    dimension=2 dimension=3 masses[] acceleration hard_spheres.diameter[] hard_spheres.restitution hard_spheres.friction
    hard_spheres.friction.static hard_spheres.friction.sliding box.boundaries=periodic box.boundaries=open
    box.boundaries=hard box.faces box.faces.restitution box.faces.oscillation box.faces.oscillation.phase
    box.faces.friction box.faces.friction.static box.faces.friction.sliding method.contact method.contact.law=hooke
    method.contact.stiffness method.contact.friction=history method.contact.friction=dashpot method.contact.k_n
    method.contact.k_t method.contact.gamma_n method.contact.gamma_t method.contact.mu
"""
_OBSERVABLES = """
    positions velocities angular_velocities kinetic_energy rotational_energy contact_time collisional_virial
    wall_impulse
"""


class Right:
    """Velocity Verlet, forces at the half-step's velocities."""

    name = "loops"
    schemes = {"velocity_verlet": Claims((2, 2), (1, 1))}
    capabilities = (capability("hard_spheres", "stepping", words=_WORDS, observables=_OBSERVABLES),)

    friction_of_partner = torque = damping = reaction = 1.0
    forgets = turns = True

    def version(self) -> str:
        return "1"

    def supports(self, scene: Scene, method: Method) -> str | None:
        moving = any(face is not None and face.oscillation is not None for face in scene.faces)
        return "walls that move" if moving else None

    def reach(self, one: float, other: float) -> float:
        """Contact distance of two radii."""
        return one + other

    def run(self, scene: Scene, method: Method) -> Run:
        assert method.contact is not None
        self.laws, self.scene, dt = soft_spheres(scene, method.contact), scene, method.step
        self.by_mass, self.history = self.laws.by_mass, method.contact.friction == "history"
        state, d = scene.initial_state(method.contact), scene.dimension
        assert state.diameters is not None
        self.radii, self.masses, self.periods = state.diameters / 2, state.masses, scene.periods()
        self.lengths, self.stretches = scene.lengths(), {}
        r, v, w = (np.zeros((scene.number, 3)) for _ in range(3))
        r[:, :d], v[:, :d] = state.positions, state.velocities
        if state.angular_velocities is not None:
            w[:, 3 - scene.spin_dimension :] = state.angular_velocities
        self.inertias = inertia_ratio(scene) * self.masses * self.radii**2
        times = sample_times(scene, method)
        wanted = shapes(scene, times.size)
        samples: dict[str, list[Any]] = {name: [] for name in wanted}
        sums = [0.0, 0.0, np.zeros((2 * d, 3))]
        rates, old = self.forces(r, v, w, 0.0), None
        for step in range(times.size):
            if step:
                old = rates
                v, w = v + dt / 2 * rates[0], w + dt / 2 * rates[1]
                r = r + dt * v
                rates = self.forces(r, v, w, dt)
                v, w = v + dt / 2 * rates[0], w + dt / 2 * rates[1]
                sums = [s + dt / 2 * (a + b) for s, a, b in zip(sums, old[2:], rates[2:], strict=True)]
            turning = float((self.inertias[:, None] * w**2).sum() / 2)
            moving = float((self.masses[:, None] * v**2).sum() / 2)
            now = {
                "positions": r[:, :d],
                "velocities": v[:, :d],
                "angular_velocities": w[:, 3 - scene.spin_dimension :],
                "kinetic_energy": moving + turning,
                "rotational_energy": turning,
                "contact_time": sums[0],
                "collisional_virial": sums[1],
                "wall_impulse": np.array(sums[2])[:, :d],
            }
            for name in samples.keys() & now.keys():
                samples[name].append(now[name])
        run = Run({name: np.array(values) for name, values in samples.items() if values}, time=times)
        for name in ("positions", "velocities", "angular_velocities"):
            if f"final_{name}" in wanted:
                run[f"final_{name}"] = run[name][-1]
        return run

    def forces(self, r: Any, v: Any, w: Any, elapsed: float) -> list[Any]:
        """Accelerations, angular accelerations, number of contacts, virial, and forces on the faces."""
        field = np.zeros(3)
        field[: self.scene.dimension] = 0.0 if self.scene.acceleration is None else self.scene.acceleration
        a, turn, on_faces = np.tile(field, (len(r), 1)), np.zeros_like(w), np.zeros((2 * self.scene.dimension, 3))
        contacts, virial = 0, 0.0
        for i in range(len(r)):
            for j in range(i):
                apart = r[i] - r[j]
                for axis, period in enumerate(self.periods):
                    if period > 0:
                        apart[axis] -= period * round(apart[axis] / period)
                distance = float(np.sqrt(apart @ apart))
                delta = self.reach(self.radii[i], self.radii[j]) - distance
                mass = self.masses[i] * self.masses[j] / (self.masses[i] + self.masses[j])
                n, roll = apart / distance, self.radii[i] * w[i] + self.radii[j] * w[j]
                f_n, f_t = self.contact((i, j), self.laws.pair, delta, mass, n, v[i] - v[j], roll, elapsed)
                if delta > 0:
                    contacts, virial = contacts + 1, virial + distance * f_n
                shorter = delta / 2 if self.laws.granular else 0.0
                for one, sign, friction in ((i, 1.0, 1.0), (j, -1.0, self.friction_of_partner)):
                    share = 1.0 if one == i else self.reaction
                    a[one] += sign * share * (f_n * n + friction * f_t) / self.masses[one]
                    arm = self.torque * (self.radii[one] - shorter)
                    turn[one] -= arm * np.cross(n, f_t) / self.inertias[one]
            for face, law in enumerate(self.laws.faces):
                if law is None:
                    continue
                axis, upper = divmod(face, 2)
                n = np.zeros(3)
                n[axis] = -1.0 if upper else 1.0
                delta = self.radii[i] - (self.lengths[axis] - r[i, axis] if upper else r[i, axis])
                f_n, f_t = self.contact(
                    (i, -1 - face), law, delta, self.masses[i], n, v[i], self.radii[i] * w[i], elapsed
                )
                a[i] += (f_n * n + f_t) / self.masses[i]
                turn[i] -= self.torque * self.radii[i] * np.cross(n, f_t) / self.inertias[i]
                on_faces[face] -= f_n * n + f_t
        return [a, turn, float(contacts), virial, on_faces]

    def contact(
        self,
        pair: tuple[int, int],
        law: ContactLaw,
        delta: float,
        mass: float,
        n: Any,
        g: Any,
        roll: Any,
        elapsed: float,
    ) -> tuple[float, Any]:
        """Normal force, and tangential force as a vector."""
        if delta <= 0:
            if self.forgets:
                self.stretches.pop(pair, None)
            return 0.0, np.zeros(3)
        scale = mass if self.by_mass else math.sqrt(mass * law.stiffness)
        f_n = law.stiffness * delta - self.damping * law.damping * scale * float(g @ n)
        if law.friction == 0 or not self.scene.spin_dimension:
            return f_n, np.zeros(3)
        u = g - (g @ n) * n - np.cross(roll, n)
        dashpot, limit = law.tangential_damping * scale, law.friction * abs(f_n)
        if not self.history:
            size = dashpot * float(np.linalg.norm(u))
            return f_n, -u * dashpot * min(1.0, limit / size if size > 0 else 1.0)
        xi = self.stretches.get(pair, np.zeros(3))
        if self.laws.granular and elapsed and self.turns:
            least = 1e-10 * limit if math.isfinite(limit) else 0.0
            flat = xi - (xi @ n) * n
            if abs(xi @ n) * law.tangential_stiffness > least and flat.any():
                xi = flat * np.linalg.norm(xi) / np.linalg.norm(flat)
        xi = xi + elapsed * u
        begun = xi.any()
        if not self.laws.granular and elapsed and self.turns:
            xi = xi - (xi @ n) * n
        f_t = -law.tangential_stiffness * xi - dashpot * u
        size = float(np.linalg.norm(f_t))
        if size > limit:
            f_t = f_t * limit / size if begun else np.zeros(3)
            if begun and law.tangential_stiffness > 0:
                xi = -(f_t + dashpot * u) / law.tangential_stiffness
        self.stretches[pair] = xi
        return f_n, f_t


class FrictionOfOneSign(Right):
    """Friction pushes both grains the same way."""

    friction_of_partner = -1.0


class NoTorque(Right):
    """Friction does not turn the grains."""

    torque = 0.0


class NoReaction(Right):
    """The second grain of a pair feels nothing."""

    reaction = 0.0


class NeverForgets(Right):
    """A contact that begins again has the stretch of the one before."""

    forgets = False


class NeverTurns(Right):
    """Stretches keep their direction when the contact turns."""

    turns = False


class TwiceDamped(Right):
    """The dashpot of a restitution without the half of the reduced mass."""

    damping = 2.0


class LargestReach(Right):
    """Unlike grains touch at the larger diameter."""

    def reach(self, one: float, other: float) -> float:
        return 2 * max(one, other)
