"""All-pairs gravity against REBOUND's `basic` gravity: `python benchmarks/gravity.py [N ...]`.

Both sides take whole leapfrog steps (drift, force, kick, drift; one force evaluation a step) of the same
bodies on one thread, in turns within one process; CPU time of the process, compilation apart. Pairs are
counted once: N (N - 1)/2 a step. The ratio is the median over the turns of REBOUND's time to ours.

H. Rein and S.-F. Liu, Astron. Astrophys. 537, A128 (2012).
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np
import rebound
from numba import njit

from refimpl.stepping.forces.generic import accelerate
from refimpl.stepping.forces.gravity import gravity

SIZES = (2, 3, 16, 64, 256, 1024, 2048, 4096)
TURNS = 9
PAIRS_PER_TURN = 2e7
DT = 1e-6  # bodies hardly move, so that every turn does the same work


@njit(error_model="numpy")
def leapfrog(force, r, v, dt, steps):  # type: ignore[no-untyped-def]
    """Moves `r` and `v`, in place, by drift, kick, drift."""
    for _ in range(steps):
        for q in range(r.size):
            r[q] += 0.5 * dt * v[q]
        a = accelerate(force, r, v)
        for q in range(r.size):
            v[q] += dt * a[q]
            r[q] += 0.5 * dt * v[q]


def rebound_simulation(mass: np.ndarray, positions: np.ndarray) -> rebound.Simulation:
    """The same bodies at rest, in REBOUND."""
    simulation = rebound.Simulation()
    simulation.integrator = "leapfrog"
    simulation.gravity = "basic"
    simulation.dt = DT
    for m, (x, y, z) in zip(mass, positions, strict=True):
        simulation.add(m=m, x=x, y=y, z=z)
    return simulation


def cpu_seconds(task: Callable[[], object]) -> float:
    start = time.process_time()
    task()
    return time.process_time() - start


def measure(n: int) -> None:
    """Prints one line of the table."""
    rng = np.random.default_rng(n)
    mass, positions = rng.random(n) / n, rng.normal(size=(n, 3))
    force, r, v = gravity(mass, 3), positions.ravel().copy(), np.zeros(3 * n)
    simulation = rebound_simulation(mass, positions)
    pairs = n * (n - 1) / 2
    steps = max(2, int(PAIRS_PER_TURN / (pairs + 20)))

    compiling = cpu_seconds(lambda: leapfrog(force, r, v, DT, 1))
    simulation.steps(1)
    ours, theirs = np.empty(TURNS), np.empty(TURNS)
    for turn in range(TURNS):
        ours[turn] = cpu_seconds(lambda: leapfrog(force, r, v, DT, steps))
        theirs[turn] = cpu_seconds(lambda: simulation.steps(steps))

    moved = np.array([particle.xyz for particle in simulation.particles]).ravel()
    if not np.allclose(r, moved, rtol=0, atol=1e-9):
        raise AssertionError(f"the two sides disagree by {np.abs(r - moved).max():g} at N = {n}")
    rates = [pairs * steps / np.median(seconds) / 1e9 for seconds in (ours, theirs)]
    nanoseconds = np.median(ours) / steps * 1e9
    ratio = np.median(theirs / ours)
    print(
        f"{n:6d} {rates[0]:14.4f} {rates[1]:14.4f} {ratio:8.2f} {nanoseconds:14.0f} {compiling:12.2f}",
        flush=True,
    )


def main() -> None:
    sizes = [int(argument) for argument in sys.argv[1:]] or SIZES
    print(f"refimpl against REBOUND {rebound.__version__}; leapfrog, CPU time, median of {TURNS} turns")
    print(f"{'N':>6} {'ours Gpair/s':>14} {'theirs':>14} {'ratio':>8} {'ours ns/step':>14} {'compile s':>12}")
    for n in sizes:
        measure(n)


if __name__ == "__main__":
    main()
