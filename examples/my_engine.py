"""An engine of one's own, to be judged: velocity Verlet for springs and gravity, in plain numpy.

    crosscheck run --engine examples/my_engine.py:MyEngine

Copy it, and put a call of your code where `_forces` and the loop of `run` are. `docs/engines.md` has the rules.
"""

from __future__ import annotations

import numpy as np

from crosscheck.engines.capabilities import capability
from crosscheck.engines.protocol import Claims, Cost, Run, sample_times, timed
from crosscheck.scene import Floats, Method, Scene


class MyEngine:
    name = "mine"
    # What the suite holds the schemes to: order 2 in position and velocity; only order 1 with friction, since the
    # friction is taken at the half-step velocity; no drift of the energy.
    schemes = {"velocity_verlet": Claims(order=(2, 2), order_damped=(1, 1), symplectic=True)}

    # What it can do: which interactions, with which entries of a scene, measuring what. The suite refuses the rest,
    # also what the scene language learns after this was written. docs/reference/scene-words.md has all words.
    capabilities = (
        capability(
            "spring",
            "stepping",
            words="dimension=1 dimension=2 dimension=3 masses[] spring.gamma",
            observables="positions velocities forces kinetic_energy potential_energy",
        ),
        capability(
            "gravity",
            "stepping",
            words="dimension=1 dimension=2 dimension=3 masses[] gravity.G gravity.softening",
            observables="positions velocities forces kinetic_energy potential_energy",
        ),
    )

    def version(self) -> str:
        # An engine that wraps a package imports it here and in `run`, never at the top of the file: ImportError or
        # OSError from here mean "missing on this machine", and every check on it is then a skip with that reason.
        return f"1.0 (numpy {np.__version__})"

    def supports(self, scene: Scene, method: Method) -> str | None:
        # None, or why not, in words: what no declaration can say. A refusal is a skip with that reason.
        return None if scene.number <= 2000 else "all pairs are held in memory: at most 2000 particles"

    def run(self, scene: Scene, method: Method) -> Run:
        state = scene.initial_state()
        r, v, m = state.positions, state.velocities, state.masses[:, None]
        dt, steps = method.dt, scene.steps(method.dt)
        every = scene.every(dt) or max(steps, 1)  # steps from sample to sample; sample 0 is the start
        samples: list[tuple[Floats, Floats]] = [(r, v)]

        cost = Cost(steps=steps, evaluations=steps + 1)
        f = _forces(scene, r, v, m)
        with timed(cost):  # the integration alone, not the setting up
            for step in range(1, steps + 1):
                v_half = v + 0.5 * dt * f / m
                r = r + dt * v_half
                f = _forces(scene, r, v_half, m)
                v = v_half + 0.5 * dt * f / m
                if step % every == 0:
                    samples.append((r, v))

        positions, velocities = (np.array(column) for column in zip(*samples, strict=True))
        run = Run(time=sample_times(scene, method), final_positions=r, final_velocities=v, cost=cost)
        run.diverged = not bool(np.isfinite(r).all())
        # Only what the scene asks for is returned; all of it: a missing array is an error.
        if scene.output.trajectory:
            run["positions"], run["velocities"] = positions, velocities
        if "kinetic_energy" in scene.output.observables:
            run["kinetic_energy"] = 0.5 * np.sum(m * velocities**2, axis=(1, 2))
        if "potential_energy" in scene.output.observables:
            run["potential_energy"] = np.array(
                [_potential_energy(scene, positions_now, m) for positions_now in positions]
            )
        if scene.output.forces:
            run["forces"] = _forces(scene, r, v, m)
        return run


def _forces(scene: Scene, r: Floats, v: Floats, m: Floats) -> Floats:
    """Forces on all particles, (N, d)."""
    forces: Floats
    if scene.spring is not None:
        forces = -scene.spring.k * r - (scene.spring.gamma or 0.0) * v
    else:
        distance, masses = _distances(scene, r, m)
        apart = r[:, None, :] - r[None, :, :]
        forces = -np.sum((masses / distance**3)[:, :, None] * apart, axis=1)
    return forces


def _potential_energy(scene: Scene, r: Floats, m: Floats) -> float:
    if scene.spring is not None:
        return float(0.5 * scene.spring.k * np.sum(r**2))
    distance, masses = _distances(scene, r, m)
    return float(-0.5 * np.sum(masses / distance))  # every pair is there twice


def _distances(scene: Scene, r: Floats, m: Floats) -> tuple[Floats, Floats]:
    """Distances, softened where the scene says so, and G m_i m_j, (N, N); a body does not act on itself."""
    assert scene.gravity is not None
    square = np.sum((r[:, None, :] - r[None, :, :]) ** 2, axis=-1) + (scene.gravity.softening or 0.0) ** 2
    np.fill_diagonal(square, np.inf)
    return np.sqrt(square), scene.gravity.G * m * m.T
