"""How often `compare` is wrong: seeded pairs of runs that differ by rounding alone, and of runs with a bug.

    python benchmarks/evidence/comparisons.py [SEEDS]

Lennard-Jones particles, and hard disks or spheres; number, temperature, packing and output interval follow from the
seed. Files of 64 bits, of 32 bits, and of six digits. Prints how often each class was found, and all pairs that were
called different though they differ in a last bit alone, or the same in all bits though one has a bug.
"""

from __future__ import annotations

import math
import sys
from collections import Counter
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from crosscheck.compare.trajectories import compare_trajectories
from crosscheck.engines.refimpl import RefimplEngine
from crosscheck.scene import Method, Scene
from crosscheck.scene.starts import explicit
from crosscheck.trajectories.frames import DOUBLE, SINGLE, Box, Floats, Rounding
from crosscheck.trajectories.memory import InMemory, in_memory

DT = 0.005
DIFFERENT = ("different_dynamics", "different_setup", "different_statistics")
SAME = ("same_bits", "same_within_rounding", "chaos_only")
FILES: dict[str, tuple[Callable[[Floats], Floats], Rounding]] = {
    "64 bits": (lambda x: x, DOUBLE),
    "32 bits": (lambda x: x.astype(np.float32).astype(np.float64), SINGLE),
    "6 digits": (np.vectorize(lambda one: float(f"{one:g}")), Rounding(0.0, 5e-6, "6 significant digits")),
}


class Case(NamedTuple):
    """Two runs of one scene. name: of what is different. bug: whether it is more than rounding. first, second: the
    runs."""

    name: str
    bug: bool
    scene: Scene
    first: dict[str, Floats]
    second: dict[str, Floats]


def run(scene: Scene, dt: float | None = None) -> dict[str, Floats]:
    """What a run of the scene recorded."""
    assert scene.method is not None
    method = scene.method if dt is None else Method(scheme=scene.method.scheme, dt=dt)
    return dict(RefimplEngine().run(scene, method))


def kicked(scene: Scene, at: float, particle: int, kick: float) -> dict[str, Floats]:
    """A run in which one velocity changes by `kick` at the time `at`."""
    first = run(scene.changed(duration=at))
    velocities = first["velocities"][-1].copy()
    velocities[particle, 1] += kick
    start = explicit(first["positions"][-1], velocities)
    rest = run(scene.changed(initial=start, duration=scene.duration - at))
    joined = {name: np.concatenate([first[name], rest[name][1:]]) for name in ("positions", "velocities")}
    return joined | {"time": np.concatenate([first["time"], at + rest["time"][1:]])}


def liquid(seed: int, rng: np.random.Generator) -> list[Case]:
    """Pairs of runs of Lennard-Jones particles."""
    number = int(rng.choice([32, 108]))
    scene = Scene.model_validate(
        {
            "name": "liquid", "dimension": 3, "duration": 14.0, "box": {"density": 0.8442},
            "lennard_jones": {"cutoff": 1.6 if number == 32 else 2.5, "truncation": "shifted"},
            "initial": {
                "kind": "lattice", "structure": "fcc", "number": number, "seed": seed,
                "temperature": float(rng.uniform(0.7, 2.0)),
            },
            "method": {"scheme": "velocity_verlet", "dt": DT},
            "output": {"interval": float(rng.choice([0.1, 0.25, 0.5])), "trajectory": True},
        }
    )  # fmt: skip
    start, particle = scene.own_start(), int(rng.integers(number))
    positions = start.positions.copy()
    positions[particle] = np.nextafter(positions[particle], 99)
    other = scene.changed(initial=explicit(positions, start.velocities))
    base, kick = run(scene), float(rng.choice([1e-2, 1e-4, 1e-7]))
    return [
        Case("liquid, last bit", False, scene, base, run(other)),
        Case("liquid, half the step", True, scene, base, run(scene, DT / 2)),
        Case("liquid, kick", True, scene, base, kicked(scene, 6.0, particle, kick)),
        Case("liquid, kick after the last bit", True, scene, base, kicked(other, 6.0, particle, 0.1)),
    ]


def spheres(seed: int, rng: np.random.Generator) -> list[Case]:
    """Pairs of runs of hard disks or spheres."""
    dimension, number = int(rng.choice([2, 3])), int(rng.choice([36, 108]))
    volume = math.pi / (4 if dimension == 2 else 6)
    scene = Scene.model_validate(
        {
            "name": "spheres", "dimension": dimension, "duration": 8.0, "hard_spheres": {},
            "box": {"density": float(rng.uniform(0.1, 0.45)) / volume},
            "initial": {
                "kind": "lattice", "structure": "triangular" if dimension == 2 else "fcc", "number": number,
                "seed": seed, "temperature": 1.0,
            },
            "method": {"scheme": "event_driven"},
            "output": {"interval": float(rng.choice([0.05, 0.1, 0.2])), "trajectory": True},
        }
    )  # fmt: skip
    start, particle = scene.own_start(), int(rng.integers(number))
    velocities = start.velocities.copy()
    velocities[0] = np.nextafter(velocities[0], 99)
    base = run(scene)
    return [
        Case(
            "spheres, last bit", False, scene, base, run(scene.changed(initial=explicit(start.positions, velocities)))
        ),
        Case("spheres, kick", True, scene, base, kicked(scene, 3.0, particle, 1e-3)),
    ]


def trajectory(case: Case, arrays: dict[str, Floats], file: str, steps: bool) -> InMemory:
    """A run as a file would hold it."""
    missing = 3 - case.scene.dimension
    rounded, rounding = FILES[file]
    positions, velocities = (
        rounded(np.pad(arrays[name], ((0, 0), (0, 0), (0, missing)))) for name in ("positions", "velocities")
    )
    lengths = case.scene.own_start().lengths
    assert lengths is not None
    box = Box(np.diag(np.pad(lengths, (0, missing))), np.zeros(3), np.arange(3) < case.scene.dimension)
    number = np.rint(arrays["time"] / DT).astype(np.int64) if steps else None
    return in_memory(case.name, arrays["time"], positions, velocities, steps=number, box=box, rounding=rounding)


def main(seeds: int) -> int:
    """Compares all pairs; returns how many are wrong."""
    counts: Counter[tuple[str, str, str]] = Counter()
    wrong = 0
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        for case in (*liquid(seed, rng), *spheres(seed, rng)):
            steps = seed % 2 == 0 and case.scene.lennard_jones is not None
            for file in FILES:
                pair = [trajectory(case, arrays, file, steps) for arrays in (case.first, case.second)]
                found = compare_trajectories(pair[0], pair[1])
                counts[case.name, file, found.classed] += 1
                if (not case.bug and found.classed in DIFFERENT) or (
                    case.bug and file == "64 bits" and found.classed in SAME
                ):
                    wrong += 1
                    print(f"seed {seed}, {case.name}, {file}: {found.sentence}", flush=True)
    for (name, file, classed), count in sorted(counts.items()):
        print(f"{name:32} {file:9} {classed:22} {count:4}")
    print(f"{wrong} wrong")
    return wrong


if __name__ == "__main__":
    sys.exit(bool(main(int(sys.argv[1]) if len(sys.argv) > 1 else 100)))
