"""A slow engine, to be judged within a budget: a Lennard-Jones fluid by velocity Verlet in plain numpy, all N^2 pairs.

    crosscheck run --engine examples/plain_lennard_jones.py:PlainLennardJones --budget 60

`docs/slow-codes.md` says what such a code is judged by.
"""

from __future__ import annotations

import numpy as np

from crosscheck.engines.capabilities import capability
from crosscheck.engines.protocol import Claims, Cost, Run, sample_times, strides, timed
from crosscheck.scene import Floats, LennardJones, Method, Scene

OBSERVABLES = ("kinetic_energy", "potential_energy", "virial")


class PlainLennardJones:
    name = "plain Lennard-Jones"
    schemes = {"velocity_verlet": Claims(order=(2, 2), symplectic=True, reversible=True)}
    capabilities = (
        capability(
            "lennard_jones",
            "stepping",
            words="dimension=2 dimension=3 box.boundaries=periodic box.boundaries=open masses[] "
            "lennard_jones.epsilon lennard_jones.length lennard_jones.length_form=sigma "
            "lennard_jones.truncation=truncated lennard_jones.truncation=shifted",
            observables=f"positions velocities forces {' '.join(OBSERVABLES)}",
        ),
    )

    def version(self) -> str:
        return f"1.0 (numpy {np.__version__})"

    def supports(self, scene: Scene, method: Method) -> str | None:
        periods = scene.periods()
        assert scene.lennard_jones is not None
        if scene.number > 1500:
            return "all pairs are held in memory: at most 1500 particles"
        if (periods[periods > 0] < 2 * scene.lennard_jones.cutoff).any():
            return "nearest images only: a periodic box must be two cutoffs wide"
        return None

    def run(self, scene: Scene, method: Method) -> Run:
        assert scene.lennard_jones is not None
        state = scene.initial_state()
        r, v, m, dt = state.positions, state.velocities, state.masses[:, None], method.step
        steps, every = strides(scene, method)
        pairs = Pairs(scene.lennard_jones, scene.periods())
        cost = Cost(steps=steps, evaluations=steps + 1)
        forces, energy, virial = pairs.sums(r)
        samples = [(r, v, energy, virial)]
        with timed(cost), np.errstate(all="ignore"):
            for step in range(1, steps + 1):
                v = v + 0.5 * dt * forces / m
                r = r + dt * v
                forces, energy, virial = pairs.sums(r)
                v = v + 0.5 * dt * forces / m
                if step % every == 0:
                    samples.append((r, v, energy, virial))
        positions, velocities, energies, virials = (np.array(column) for column in zip(*samples, strict=True))
        run = Run(time=sample_times(scene, method), final_positions=r, final_velocities=v, cost=cost)
        run.diverged = not bool(np.isfinite(r).all() and np.isfinite(v).all())
        kinetic = 0.5 * np.sum(m * velocities**2, axis=(1, 2))
        found = dict(zip(OBSERVABLES, (kinetic, energies, virials), strict=True))
        found |= {"positions": positions, "velocities": velocities, "forces": forces}
        for name in scene.asked():
            if name in found:
                run[name] = found[name]
        return run


class Pairs:
    """Sums over all pairs: phi = 4 epsilon [(sigma/r)^12 - (sigma/r)^6] up to the cutoff."""

    def __init__(self, fluid: LennardJones, periods: Floats) -> None:
        self.epsilon, self.sigma = float(np.atleast_1d(fluid.epsilon)[0]), float(np.atleast_1d(fluid.length)[0])
        self.cutoff, self.periods = fluid.cutoff, periods
        six = (self.sigma / self.cutoff) ** 6
        self.shift = 4 * self.epsilon * (six * six - six) if fluid.truncation == "shifted" else 0.0

    def sums(self, r: Floats) -> tuple[Floats, float, float]:
        """Forces (N, d), potential energy, and virial, the sum over pairs of r_ij . F_ij."""
        d = r[:, None, :] - r[None, :, :]
        d -= self.periods * np.rint(d / np.where(self.periods > 0, self.periods, 1.0))
        square = np.einsum("ijk,ijk->ij", d, d)
        np.fill_diagonal(square, np.inf)
        within = square < self.cutoff**2
        six = np.where(within, self.sigma**6 / square**3, 0.0)
        work = 24 * self.epsilon * (2 * six * six - six)  # -r phi'(r)
        forces = np.einsum("ij,ijk->ik", work / square, d)
        energy = 0.5 * float(np.sum(4 * self.epsilon * (six * six - six) - self.shift * within))
        return forces, energy, 0.5 * float(work.sum())
