"""SciPy's solvers of ordinary differential equations as an engine: springs and gravity, to a tolerance.

The classes RK45, DOP853, Radau and LSODA of `scipy.integrate`, in the loop of `solve_ivp`, with forces in numpy: what a
user would write in their place.

Literature: P. Virtanen et al., Nat. Methods 17, 261 (2020); J. R. Dormand and P. J. Prince, J. Comput. Appl. Math. 6,
19 (1980); E. Hairer, S. P. Norsett and G. Wanner, Solving Ordinary Differential Equations I, section II.5 (1993), and
II, section IV.8 (1996); A. C. Hindmarsh, in Scientific Computing, ed. R. S. Stepleman (1983); L. Petzold, SIAM J. Sci.
Stat. Comput. 4, 136 (1983).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from crosscheck.engines.capabilities import capability
from crosscheck.engines.progress import report
from crosscheck.engines.protocol import Claims, Cost, Run, sample_times, timed
from crosscheck.scene import Floats, Method, Scene, State

#: Below this relative tolerance the solvers take another one: 100 times the spacing of doubles.
_FINEST = 100 * float(np.finfo(np.float64).eps)
#: So many steps that move a run by less than this share of its duration would take years to end it.
_STUCK = (10_000, 1e-6)
#: Evaluations from one report of the progress to the next.
_BETWEEN_REPORTS = 256


class ScipyEngine:
    """`method.tolerance` is the relative tolerance; the absolute one is `tolerance` times the size of the scene.

    The size of the positions is the largest distance from the centre of mass (springs: from the origin) at the start;
    that of the velocities is the largest speed there, or what the largest acceleration gives over that distance.
    Samples come from the dense output of the step that they fall into, whose order is lower than that of the step: 4
    of RK45, 7 of DOP853, 3 of Radau, and of LSODA that of the step. The end is the end of a step. `cost.evaluations`
    counts all calls of the forces, those of numerical Jacobians too.
    """

    name = "scipy"
    schemes = {name: Claims(kind="adaptive") for name in ("RK45", "DOP853", "Radau", "LSODA")}
    capabilities = (
        capability(
            "spring",
            "adaptive",
            words="dimension=1 dimension=2 dimension=3 masses[] spring.gamma",
            observables="positions velocities forces kinetic_energy potential_energy virial",
        ),
        capability(
            "gravity",
            "adaptive",
            words="dimension=2 dimension=3 masses[] masses=0 gravity.G gravity.softening",
            observables="positions velocities forces kinetic_energy potential_energy virial",
        ),
    )

    def version(self) -> str:
        import scipy

        return str(scipy.__version__)

    def supports(self, scene: Scene, method: Method) -> str | None:
        if method.tolerance is not None and method.tolerance < _FINEST:
            return f"method.tolerance = {method.tolerance:g} is below what doubles allow: give {_FINEST:.3g} or more"
        return None

    def run(self, scene: Scene, method: Method) -> Run:
        import scipy.integrate

        state = scene.initial_state()
        forces = _forces(scene, state.masses)
        units, allowed = _units(method, state, forces)
        times, cost = sample_times(scene, method), Cost()
        shape = (2, *state.positions.shape)
        end = scene.duration / units.time
        now = before = 0.0

        def derivative(_: float, y: Floats) -> Floats:
            cost.evaluations += 1
            if cost.evaluations % _BETWEEN_REPORTS == 0:
                report(now / end)
            r, v = y.reshape(shape)
            a = forces.accelerations(units.length * r, units.speed * v)
            return np.concatenate((v, a * (units.time / units.speed)), axis=None)

        y = np.concatenate((state.positions / units.length, state.velocities / units.speed), axis=None)
        samples = np.full((times.size, y.size), np.nan)
        samples[0], taken, stopped = y, 1, ""
        with timed(cost), np.errstate(all="ignore"):  # states that are not finite are looked for below
            solver = None
            if end > 0:
                solve = getattr(scipy.integrate, method.scheme)
                solver = solve(derivative, 0.0, y, end, rtol=method.allowed, atol=allowed)
            while solver is not None and solver.status == "running":
                message = solver.step()
                if solver.status == "failed":
                    stopped = f"SciPy's {method.scheme}: {message or 'the step failed'}"
                    break
                cost.steps, y, now = cost.steps + 1, solver.y, solver.t
                reached = times.size if now >= end else int(np.searchsorted(times / units.time, now, side="right"))
                if reached > taken:
                    samples[taken:reached] = solver.dense_output()(times[taken:reached] / units.time).T
                    taken = reached
                if not np.isfinite(y).all():
                    break
                if cost.steps % _STUCK[0] == 0:
                    share = (now - before) / end
                    if share < _STUCK[1]:
                        stopped = (
                            f"SciPy's {method.scheme}: {_STUCK[0]} steps took it {share:.1g} of the duration further"
                        )
                        break
                    before = now
        if solver is not None and solver.status == "finished" and times[-1] == scene.duration:
            samples[-1] = y  # a step ends there
        scale = np.repeat((units.length, units.speed), y.size // 2)
        return _as_run(scene, forces, times, scale * samples, scale * y, cost, stopped)


class _Units(NamedTuple):
    """Units that a run is computed in, powers of two: they round nothing. length, speed, time: in the scene's own."""

    length: float
    speed: float
    time: float


class _Forces(NamedTuple):
    """What acts in a scene. accelerations: of r and v, (N, d) each. energy, virial: of r, (N, d). masses: (N,). centre:
    whether sizes are measured from the centre of mass, not from the origin.
    """

    accelerations: Callable[[Floats, Floats], Floats]
    energy: Callable[[Floats], float]
    virial: Callable[[Floats], float]
    masses: Floats
    centre: bool


def _forces(scene: Scene, masses: Floats) -> _Forces:
    if scene.spring is not None:
        return _springs(scene.spring.k, scene.spring.gamma or 0.0, masses)
    gravity = scene.gravity
    assert gravity is not None
    return _attraction(gravity.G, gravity.softening or 0.0, masses)


def _springs(k: float, gamma: float, masses: Floats) -> _Forces:
    rate, friction = k / masses[:, None], gamma / masses[:, None]
    return _Forces(
        lambda r, v: -(rate * r + friction * v),
        lambda r: 0.5 * k * float((r * r).sum()),
        lambda r: -k * float((r * r).sum()),
        masses,
        False,
    )


def _attraction(G: float, softening: float, masses: Floats) -> _Forces:
    i, j = np.triu_indices(masses.size, 1)
    others = np.arange(masses.size)

    def squares(r: Floats) -> tuple[Floats, Floats]:
        apart = r[None, :, :] - r[:, None, :]
        square = (apart * apart).sum(axis=2) + softening * softening
        square[others, others] = np.inf
        return apart, square

    def accelerations(r: Floats, v: Floats) -> Floats:
        apart, square = squares(r)
        return np.asarray(G * ((masses / (square * np.sqrt(square)))[:, :, None] * apart).sum(axis=1))

    def energy(r: Floats) -> float:
        _, square = squares(r)
        return -G * float((masses[i] * masses[j] / np.sqrt(square[i, j])).sum())

    def virial(r: Floats) -> float:
        _, square = squares(r)
        s = square[i, j]
        return -G * float((masses[i] * masses[j] * (s - softening * softening) / (s * np.sqrt(s))).sum())

    return _Forces(accelerations, energy, virial, masses, True)


def _units(method: Method, state: State, forces: _Forces) -> tuple[_Units, Floats]:
    """Units of the size of the scene, since SciPy chooses its first step by sizes that have none; and, in these, the
    absolute tolerance of each coordinate and velocity, (2 N d,).
    """
    r, v = state.positions, state.velocities
    if forces.centre:
        r, v = r - np.average(r, axis=0, weights=forces.masses), v - np.average(v, axis=0, weights=forces.masses)
    length = float(np.linalg.norm(r, axis=1).max(initial=0.0))
    speed = float(np.linalg.norm(v, axis=1).max(initial=0.0))
    force = float(np.linalg.norm(forces.accelerations(state.positions, state.velocities), axis=1).max(initial=0.0))
    speed = max(speed, (force * length) ** 0.5) or 1.0
    if length == 0.0:  # all at the origin: as far as they come before they are turned
        length = speed**2 / force if force else 1.0
    near = [2.0 ** round(math.log2(size)) for size in (length, speed)]
    sizes = np.repeat((length / near[0], speed / near[1]), r.size)
    return _Units(near[0], near[1], near[0] / near[1]), np.asarray(method.allowed * sizes)


def _as_run(scene: Scene, forces: _Forces, times: Floats, samples: Floats, y: Floats, cost: Cost, stopped: str) -> Run:
    """The run. samples: (samples, 2 N d). y: the last state, (2 N d,). stopped: why before the end, or ""."""
    shape = (scene.number, scene.dimension)
    r, v = samples.reshape(-1, 2, *shape).swapaxes(0, 1)
    final = y.reshape(2, *shape)
    diverged = not bool(np.isfinite(y).all())
    run = Run(
        time=times,
        final_positions=final[0],
        final_velocities=final[1],
        diverged=diverged,
        stopped="" if diverged else stopped,
        cost=cost,
    )
    if scene.output.trajectory:
        run["positions"], run["velocities"] = r.copy(), v.copy()
    measures: Mapping[str, Callable[[int], float]] = {
        "kinetic_energy": lambda sample: 0.5 * float(forces.masses @ (v[sample] ** 2).sum(axis=1)),
        "potential_energy": lambda sample: forces.energy(r[sample]),
        "virial": lambda sample: forces.virial(r[sample]),
    }
    for name, measure in measures.items():
        if name in scene.output.observables:
            run[name] = np.array([measure(sample) for sample in range(times.size)])
    if scene.output.forces:
        run["forces"] = forces.masses[:, None] * forces.accelerations(*final)
    return run
