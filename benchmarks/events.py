"""Speed of event-driven dynamics: collisions per CPU second and time per event, N = 1e2 ... 1e6, one thread.

    python benchmarks/events.py [case ...]        default: all; see CASES
    python benchmarks/events.py spheres --sizes 1e4,1e6

Each gas is first brought to equilibrium (10 collisions a particle; 4 at 1e6). Then blocks of events are timed, the
schedulers in turn, and the median block counts; compilation is apart. Beside it stand DynamO's collisions per CPU
second where they are known (measured on one core of such a machine; Bannerman, Sargant and Lue, J. Comput. Chem. 32,
3329 (2011)); a collision of a square well is any event at its core or its edge.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from statistics import median
from typing import Any

import numpy as np

from refimpl.events.model import Face, Well, hard_spheres
from refimpl.events.simulation import Simulation

BLOCKS = 5
DENSITY = 0.5
#: Collisions per CPU second of DynamO, by case and number of particles.
DYNAMO = {
    "spheres": {1_372: 138e3, 10_976: 132e3, 97_556: 68e3, 1_000_188: 55e3},
    "square-well": {1_372: 74e3, 10_976: 67e3, 97_556: 33e3},
    "disks": {1_600: 232e3},
}
DYNAMO["grains"] = DYNAMO["spheres"]


def fcc(number: int, density: float = DENSITY) -> tuple[np.ndarray, float]:
    """Whole fcc cells, as near to `number` as they get."""
    cells = max(2, round((number / 4) ** (1 / 3)))
    basis = np.array([[0, 0, 0], [0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5]])
    grid = np.stack(np.meshgrid(*[np.arange(cells)] * 3, indexing="ij"), -1).reshape(-1, 1, 3)
    positions = (grid + basis + 0.25).reshape(-1, 3)
    length = (len(positions) / density) ** (1 / 3)
    return positions * length / cells, length


def maxwell(shape: tuple[int, ...], temperature: float = 1.0) -> np.ndarray:
    velocities = np.random.default_rng(1).normal(size=shape) * math.sqrt(temperature)
    return velocities - velocities.mean(axis=0)


def spheres(number: int, **more: Any) -> Simulation:
    positions, length = fcc(number)
    model = hard_spheres(lengths=(length,) * 3, periodic=(True,) * 3)
    return Simulation(model, positions, maxwell(positions.shape), **more)


def square_well(number: int, **more: Any) -> Simulation:
    positions, length = fcc(number)
    model = hard_spheres(lengths=(length,) * 3, periodic=(True,) * 3, well=Well(1.0, 1.5))
    return Simulation(model, positions, maxwell(positions.shape, 2.0), **more)


def disks(number: int, **more: Any) -> Simulation:
    side = max(3, round(math.sqrt(number)))
    grid = np.stack(np.meshgrid(np.arange(side), np.arange(side), indexing="ij"), -1).reshape(-1, 2)
    length = math.sqrt(side * side / DENSITY)
    model = hard_spheres(lengths=(length,) * 2, periodic=(True,) * 2)
    return Simulation(model, (grid + 0.5) * length / side, maxwell(grid.shape), **more)


def grains(number: int, **more: Any) -> Simulation:
    """Two species, restitution, a field, and walls on all sides."""
    positions, length = fcc(number)
    kinds = np.arange(len(positions)) % 2
    scale = (length - 1.0) / length
    model = hard_spheres(
        lengths=(length,) * 3,
        periodic=(False,) * 3,
        diameters=np.where(kinds == 0, 1.0, 0.9),
        masses=np.where(kinds == 0, 1.0, 0.7),
        restitution=0.999,
        acceleration=(0.0, 0.0, -0.01),
        faces=[Face()] * 6,
    )
    return Simulation(model, 0.5 + positions * scale, maxwell(positions.shape), **more)


CASES: dict[str, Callable[..., Simulation]] = {
    "spheres": spheres,
    "square-well": square_well,
    "disks": disks,
    "grains": grains,
}


def measure(case: str, number: int, schedulers: tuple[str, ...]) -> None:
    """One line for each scheduler."""
    gases = {}
    for scheduler in schedulers:
        started = time.perf_counter()
        gases[scheduler] = gas = CASES[case](number, scheduler=scheduler)
        gas.run(until=0.0)
        compiled = time.perf_counter() - started
        gas.run(collisions=(10 if gas.number < 500_000 else 4) * gas.number)
        print(f"# {case} {scheduler}: ready after {compiled:.1f} s, in equilibrium at t = {gas.time:.4g}", flush=True)
    # changes of state at cores, edges and walls alike: DynamO's events
    rates: dict[str, list[tuple[float, float]]] = {scheduler: [] for scheduler in schedulers}
    block = int(min(max(200_000, gases[schedulers[0]].number), 1_000_000))
    for _ in range(BLOCKS):
        for scheduler, gas in gases.items():
            before, events, interactions = gas.collisions, gas.events, gas.interactions
            started = time.process_time()
            gas.run(collisions=before + block)
            cpu = time.process_time() - started
            rates[scheduler].append(((gas.interactions - interactions) / cpu, cpu / (gas.events - events)))
    for scheduler, gas in gases.items():
        rate, per_event = (median(column) for column in zip(*rates[scheduler], strict=True))
        peer = DYNAMO.get(case, {}).get(gas.number)
        beside = f"{rate / peer:6.1f} x DynamO" if peer else ""
        print(
            f"{case:12} {scheduler:9} N = {gas.number:8d}  {rate / 1e6:6.3f} M collisions/s  "
            f"{1e9 * per_event:6.0f} ns/event  {gas.memory() / gas.number:5.0f} bytes/particle {beside}",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="*", default=list(CASES), help=", ".join(CASES))
    parser.add_argument("--sizes", help="comma-separated; default 1e2 to 1e6")
    parser.add_argument("--schedulers", default="tree,lists,calendar")
    arguments = parser.parse_args()
    sizes = [1e2, 1372, 10976, 97556, 1000188] if arguments.sizes is None else arguments.sizes.split(",")
    for case in arguments.cases:
        for size in sizes:
            measure(case, int(float(size)), tuple(arguments.schedulers.split(",")))


if __name__ == "__main__":
    main()
