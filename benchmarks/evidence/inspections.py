"""How often `crosscheck inspect` is red of right trajectories, and which planted faults turn which property red.

    python benchmarks/evidence/inspections.py [--seeds K] [--kind NAME ...]

Right trajectories of equilibrium, K of each kind with seeds 0 to K - 1: Lennard-Jones fluids and hard spheres of one
and of two species by `refimpl`, hard disks between thermal walls, particles of Ornstein and Uhlenbeck (exact), waves of
a harmonic crystal (exact), velocities drawn anew in each frame, and files of them: wrapped, with six digits, without
velocities, short, or sampled densely. Each is inspected with its scene and without. Printed: runs, judgements, how many
are red or inconclusive, and the smallest p-value over the number of judgements, which is near 1 or above if p-values
are uniform.

Then the faults: each is planted in trajectories of several kinds and seeds; printed is how often the property meant
turns red, and what else does.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from crosscheck.engines.workers.pool import Pool
from crosscheck.inspect.inspection import Inspection, inspect_trajectory
from crosscheck.inspect.setting import Options
from crosscheck.scene import Scene
from crosscheck.trajectories.frames import Box, Rounding, Source
from crosscheck.trajectories.memory import in_memory


class Run(NamedTuple):
    """A trajectory as arrays: times (F,), positions and velocities (F, N, 3), constants (N,), sides (3,)."""

    times: np.ndarray
    positions: np.ndarray
    velocities: np.ndarray | None
    masses: np.ndarray
    types: np.ndarray | None
    diameters: np.ndarray | None
    sides: np.ndarray | None
    scene: Scene | None
    ensemble: str = "nve"
    temperature: float | None = None
    wrapped: bool = False
    digits: int | None = None
    periodic: tuple[bool, bool, bool] = (True, True, True)
    homogeneous: bool = True


# -- right trajectories ------------------------------------------------------------------------------------------

LIQUID = {
    "name": "liquid", "dimension": 3, "duration": 40.0, "box": {"density": 0.8442}, "lennard_jones": {"cutoff": 2.5},
    "initial": {"kind": "lattice", "structure": "fcc", "number": 108, "temperature": 1.5},
    "method": {"scheme": "velocity_verlet", "dt": 0.004}, "output": {"interval": 0.2, "trajectory": True},
}  # fmt: skip
SPHERES = {
    "name": "spheres", "dimension": 3, "duration": 40.0, "box": {"density": 0.5}, "hard_spheres": {},
    "initial": {"kind": "lattice", "structure": "fcc", "number": 108, "temperature": 1.0},
    "method": {"scheme": "event_driven"}, "output": {"interval": 0.2, "trajectory": True},
}  # fmt: skip
TWO = {"species": [0] * 54 + [1] * 54, "masses": [1.0] * 54 + [4.0] * 54}
SCENES: dict[str, dict[str, Any]] = {
    "liquid": LIQUID,
    "liquid of two masses": LIQUID | TWO,
    "liquid, shifted force": LIQUID | {"lennard_jones": {"cutoff": 2.5, "truncation": "force_shifted"}},
    "spheres": SPHERES,
    "spheres of two sizes": SPHERES | TWO | {"hard_spheres": {"diameter": [1.0, 0.6]}},
    "dilute spheres": SPHERES | {"box": {"density": 0.05}, "duration": 200.0,
        "output": {"interval": 1.0, "trajectory": True}},
    "disks": SPHERES | {"dimension": 2, "box": {"density": 0.4},
        "initial": {"kind": "lattice", "structure": "square", "number": 64, "temperature": 1.0}},
    "disks, thermal walls": SPHERES | {"dimension": 2, "duration": 400.0,
        "box": {"density": 0.2, "boundaries": ["periodic", "hard"],
                "faces": {"y-": {"temperature": 1.0}, "y+": {"temperature": 1.0}}},
        "initial": {"kind": "lattice", "structure": "square", "number": 32, "temperature": 1.0},
        "output": {"interval": 2.0, "trajectory": True}},
    "square wells": SPHERES | {"hard_spheres": {"well": {"depth": 1.0, "range": 1.5}}, "box": {"density": 0.4},
        "initial": SPHERES["initial"] | {"temperature": 2.0}},
    "dilute spheres, dense in time": SPHERES | {"box": {"density": 0.05}, "duration": 1.0,
        "output": {"interval": 0.01, "trajectory": True}},
    "liquid, dense in time": LIQUID | {"duration": 4.0, "output": {"interval": 0.02, "trajectory": True}},
    "spheres, dense in time": SPHERES | {"duration": 4.0, "output": {"interval": 0.02, "trajectory": True}},
    "spheres, sparse in time": SPHERES | {"duration": 400.0, "output": {"interval": 4.0, "trajectory": True}},
}  # fmt: skip


def simulated(pool: Pool, name: str, seed: int) -> Run:
    """A run of `refimpl`."""
    entries = json.loads(json.dumps(SCENES[name]))
    entries["initial"]["seed"] = seed
    scene = Scene.from_json(json.dumps(entries))
    run = pool.worker("refimpl").run(scene, scene.method)
    state = scene.own_start()
    d = scene.dimension
    space = [(0, 0), (0, 0), (0, 3 - d)]
    sides = np.zeros(3)
    sides[:d] = state.lengths
    periodic = np.zeros(3, dtype=bool)
    periodic[:d] = [one == "periodic" for one in scene.boundaries]
    return Run(
        run["time"], np.pad(run["positions"], space), np.pad(run["velocities"], space), state.masses, state.species,
        state.diameters, sides, scene, "nvt" if "thermal" in name else "nve", 1.0 if "thermal" in name else None,
        periodic=tuple(periodic.tolist()),
    )  # fmt: skip


def ornstein_uhlenbeck(seed: int, frames: int = 300, number: int = 64, dt: float = 0.5, friction: float = 1.0) -> Run:
    """Particles of masses 1 and 3 in a bath of T = 1.3, in a periodic box: exact positions and velocities."""
    rng = np.random.default_rng(seed)
    masses = np.where(np.arange(number) < number // 2, 1.0, 3.0)
    thermal = np.sqrt(1.3 / masses)[:, None]
    keep = np.exp(-friction * dt)
    # covariance of the velocity and of the displacement in dt (S. Chandrasekhar, Rev. Mod. Phys. 15, 1 (1943))
    vv = 1 - keep**2
    xv = (1 - keep) ** 2 / friction
    xx = 2 * dt / friction - (3 - 4 * keep + keep**2) / friction**2
    root = np.linalg.cholesky(np.array([[vv, xv], [xv, xx]]))
    sides = np.full(3, number ** (1 / 3))
    x = rng.uniform(0, sides, (number, 3))
    v = thermal * rng.normal(size=(number, 3))
    xs, vs = [x], [v]
    for _ in range(frames - 1):
        noise = np.einsum("ab,bij->aij", root, rng.normal(size=(2, number, 3)))
        x = x + v * (1 - keep) / friction + thermal * noise[1]
        v = keep * v + thermal * noise[0]
        xs.append(x)
        vs.append(v)
    types = np.where(masses == 1, "A", "B")
    times = dt * np.arange(frames)
    return Run(times, np.array(xs), np.array(vs), masses, types, None, sides, None, "nvt", 1.3)


def normals(seed: int, frames: int = 200, number: int = 40) -> Run:
    """An ideal gas whose velocities and positions are drawn anew in each frame."""
    rng = np.random.default_rng(seed)
    sides = np.full(3, 4.0)
    shape = (frames, number, 3)
    return Run(
        np.arange(float(frames)), rng.uniform(0, 4, shape), rng.normal(size=shape), np.ones(number), None, None, sides,
        None, "nvt", 1.0, wrapped=True,
    )  # fmt: skip


def free_flight(seed: int, frames: int = 200, number: int = 60) -> Run:
    """Particles that never meet: one sample of velocities, in all frames."""
    rng = np.random.default_rng(seed)
    sides = np.full(3, 4.0)
    v = rng.normal(size=(number, 3))
    v -= v.mean(axis=0)
    times = 0.05 * np.arange(frames)
    x = rng.uniform(0, 4, (number, 3)) + v * times[:, None, None]
    return Run(times, x, np.broadcast_to(v, x.shape).copy(), np.ones(number), None, None, sides, None)


def harmonic_crystal(seed: int, frames: int = 300, edge: int = 5) -> Run:
    """Particles on a cubic lattice, with springs between neighbours for each component: waves keep their energies.

    Exact: w^2 = 4 K sum sin^2(k_a/2) for the wave vector k, with energies and phases of the canonical ensemble.
    """
    rng = np.random.default_rng(seed)
    number = edge**3
    squares = np.sin(np.pi * np.arange(edge) / edge) ** 2
    w = 20 * np.sqrt(squares[:, None, None] + squares[:, None] + squares)[..., None]
    turns = np.where(w > 0, w, np.inf)  # the centre of mass is at rest
    drawn = np.fft.fftn(rng.normal(size=(2, edge, edge, edge, 3)), axes=(1, 2, 3)) * (w > 0)
    places, speeds = drawn[0] / turns, drawn[1]
    times = 0.37 * np.arange(frames)
    sites = np.stack(np.meshgrid(*[np.arange(float(edge))] * 3, indexing="ij"), axis=-1)
    x, v = np.empty((frames, number, 3)), np.empty((frames, number, 3))
    for k, time in enumerate(times):
        cosine, sine = np.cos(w * time), np.sin(w * time)
        moved = np.fft.ifftn(places * cosine + speeds / turns * sine, axes=(0, 1, 2)).real
        x[k] = (sites + moved).reshape(number, 3)
        v[k] = np.fft.ifftn(speeds * cosine - places * w * sine, axes=(0, 1, 2)).real.reshape(number, 3)
    sides = np.full(3, float(edge))
    return Run(times, x, v, np.ones(number), None, None, sides, None, homogeneous=False)


def wrapped(run: Run) -> Run:
    sides = np.where(np.array(run.periodic) & (run.sides > 0), run.sides, np.inf)
    folded = np.where(np.isfinite(sides), run.positions % np.where(np.isfinite(sides), sides, 1.0), run.positions)
    return run._replace(positions=folded, wrapped=True)


def rounded(run: Run, digits: int = 6) -> Run:
    def short(values: np.ndarray) -> np.ndarray:
        with np.errstate(divide="ignore"):
            scale = 10.0 ** (digits - 1 - np.floor(np.log10(np.abs(values) + (values == 0))))
        return np.round(values * scale) / scale

    return run._replace(positions=short(run.positions), velocities=short(run.velocities), digits=digits)


def shortened(run: Run, frames: int) -> Run:
    return run._replace(times=run.times[:frames], positions=run.positions[:frames], velocities=run.velocities[:frames])


def late(run: Run, frames: int) -> Run:
    """The last frames, as a file of them alone."""
    return run._replace(
        times=run.times[-frames:], positions=run.positions[-frames:], velocities=run.velocities[-frames:]
    )


MADE: dict[str, Callable[[Pool, int], Run]] = {
    **{name: lambda pool, seed, name=name: simulated(pool, name, seed) for name in SCENES},
    "Ornstein-Uhlenbeck": lambda pool, seed: ornstein_uhlenbeck(seed),
    "Ornstein-Uhlenbeck, dense in time": lambda pool, seed: ornstein_uhlenbeck(seed, frames=600, dt=0.05),
    "Ornstein-Uhlenbeck, short": lambda pool, seed: ornstein_uhlenbeck(seed, frames=25),
    "harmonic crystal": lambda pool, seed: harmonic_crystal(seed),
    "free flight": lambda pool, seed: free_flight(seed),
    "normals": lambda pool, seed: normals(seed),
    "normals, 600 particles": lambda pool, seed: normals(seed, 100, 600),
    "normals, 400 particles": lambda pool, seed: normals(seed, 400, 400),
    "normals, 10 particles": lambda pool, seed: normals(seed, 100, 10),
    "liquid, wrapped, six digits": lambda pool, seed: rounded(wrapped(simulated(pool, "liquid", seed))),
    "liquid, no velocities": lambda pool, seed: simulated(pool, "liquid", seed)._replace(velocities=None),
    "liquid, short": lambda pool, seed: late(simulated(pool, "liquid", seed), 30),
    "spheres, six digits": lambda pool, seed: rounded(simulated(pool, "spheres", seed)),
    "spheres, wrapped": lambda pool, seed: wrapped(simulated(pool, "spheres of two sizes", seed)),
    "spheres, short": lambda pool, seed: late(simulated(pool, "spheres", seed), 30),
}


def source_of(run: Run) -> Source:
    box = None if run.sides is None else Box(np.diag(run.sides), np.zeros(3), np.array(run.periodic))
    digits = run.digits
    rounding = {} if digits is None else {"rounding": Rounding(0.0, 0.5 * 10.0 ** (1 - digits), f"{digits} digits")}
    return in_memory(
        "run", run.times, run.positions, run.velocities, types=run.types, masses=run.masses, diameters=run.diameters,
        box=box, wrapping="wrapped" if run.wrapped else "unwrapped", **rounding,
    )  # fmt: skip


def inspected(run: Run, how: str) -> Inspection:
    """The inspection of a run of which nothing is "known", its "ensemble" is, or its "scene"."""
    source = source_of(run)
    # a file of few digits has its masses and diameters exactly
    for name in ("masses", "diameters"):
        source.rounding[name] = Rounding(0.0, 2.0**-53, "float64")
    if how == "scene":
        return inspect_trajectory(source, run.scene)
    hard = run.diameters is not None
    if how == "nothing":
        return inspect_trajectory(source, None, Options(hard=hard, homogeneous=run.homogeneous))
    temperature = None if run.temperature is None else repr(run.temperature)
    return inspect_trajectory(source, None, Options(ensemble=run.ensemble, temperature=temperature, hard=hard))


def inspections(run: Run) -> list[Inspection]:
    """In all ways that there are."""
    return [inspected(run, how) for how in ("nothing", "ensemble", *(() if run.scene is None else ("scene",)))]


# -- planted faults ----------------------------------------------------------------------------------------------


class Fault(NamedTuple):
    """A fault. property: which should be red. kinds: of trajectories. plant: what it does to a run."""

    name: str
    property: str
    kinds: tuple[str, ...]
    plant: Callable[[Run, np.random.Generator], Run]


def _velocities(run: Run, change: Callable[[np.ndarray], np.ndarray]) -> Run:
    return run._replace(velocities=change(run.velocities.copy()))


def _one_axis(run: Run, rng: np.random.Generator) -> Run:
    return _velocities(run, lambda v: v * np.array([1.0, 1.2, 1.0]))


def _one_axis_slightly(run: Run, rng: np.random.Generator) -> Run:
    return _velocities(run, lambda v: v * np.array([1.0, 1.02, 1.0]))


def _hot(run: Run, rng: np.random.Generator) -> Run:
    factors = np.where(run.types == np.unique(run.types)[0], 1.2, 1.0)
    return _velocities(run, lambda v: v * factors[:, None])


def _cold_bath(run: Run, rng: np.random.Generator) -> Run:
    return _velocities(run, lambda v: 0.95 * v)


def _ice_cube(run: Run, rng: np.random.Generator) -> Run:
    growth = np.linspace(0, 1, len(run.times))[:, None, None]
    return _velocities(run, lambda v: v * (1 - 0.3 * growth) + growth * np.array([1.2, 0.0, 0.0]))


def _kick(run: Run, rng: np.random.Generator) -> Run:
    def kicked(v: np.ndarray) -> np.ndarray:
        v[len(v) // 3 :, 0, 0] += 1e-6
        return v

    return _velocities(run, kicked)


def _heat(run: Run, rng: np.random.Generator) -> Run:
    return _velocities(run, lambda v: v * (1 + 1e-3 * np.linspace(0, 1, len(v)))[:, None, None])


def _heat_steps(run: Run, rng: np.random.Generator) -> Run:
    return _velocities(run, lambda v: v * (1 + 3e-3 * np.linspace(0, 1, len(v)))[:, None, None])


def _uniform(run: Run, rng: np.random.Generator) -> Run:
    def drawn(v: np.ndarray) -> np.ndarray:
        return rng.uniform(-1, 1, v.shape) * np.sqrt(3 / run.masses)[:, None] * (v != 0)

    return _velocities(run, drawn)


def _narrow(run: Run, rng: np.random.Generator) -> Run:
    """Velocities scaled to the same kinetic energy in each frame, as a simple thermostat does."""

    def scaled(v: np.ndarray) -> np.ndarray:
        squares = np.einsum("i,fia->f", run.masses, v**2)
        return v * np.sqrt(squares.mean() / squares)[:, None, None] * (1 + 0.01 * rng.normal(size=(len(v), 1, 1)))

    return _velocities(run, scaled)


def _repeat(run: Run, rng: np.random.Generator) -> Run:
    at = len(run.times) // 2
    x, v = run.positions.copy(), run.velocities.copy()
    x[at], v[at] = x[at - 1], v[at - 1]
    return run._replace(positions=x, velocities=v)


def _twice(run: Run, rng: np.random.Generator) -> Run:
    order = np.insert(np.arange(len(run.times)), 50, 49)
    return run._replace(times=run.times[order], positions=run.positions[order], velocities=run.velocities[order])


def _exchange(run: Run, rng: np.random.Generator) -> Run:
    order = np.arange(len(run.times))
    order[[60, 61]] = 61, 60
    return run._replace(times=run.times[order], positions=run.positions[order], velocities=run.velocities[order])


def _exchange_quietly(run: Run, rng: np.random.Generator) -> Run:
    changed = _exchange(run, rng)
    return changed._replace(times=run.times)


def _gap(run: Run, rng: np.random.Generator) -> Run:
    keep = np.delete(np.arange(len(run.times)), [70, 71])
    return run._replace(times=run.times[keep], positions=run.positions[keep], velocities=run.velocities[keep])


def _leap(run: Run, rng: np.random.Generator) -> Run:
    """One particle is an edge of the box away from half of the run on."""
    x = run.positions.copy()
    x[len(x) // 2 :, 5, 0] += run.sides[0]
    return run._replace(positions=x)


def _hop(run: Run, rng: np.random.Generator) -> Run:
    """One particle is 0.48 edges away in one frame."""
    x = run.positions.copy()
    x[len(x) // 2, 5, 0] += 0.48 * run.sides[0]
    return run._replace(positions=x)


def _outside(run: Run, rng: np.random.Generator) -> Run:
    """The particle nearest to the middle of a wrapped file's box is in the next image in one frame."""
    x = run.positions.copy()
    at = len(x) // 2
    x[at, np.argmin(np.abs(x[at, :, 0] - run.sides[0] / 2)), 0] += run.sides[0]
    return run._replace(positions=x)


def _overlap(run: Run, rng: np.random.Generator) -> Run:
    """Two particles overlap by 1e-6 in one frame: the nearest pair is moved together."""
    x = run.positions.copy()
    at = len(x) // 2
    apart = x[at][:, None] - x[at][None]
    apart -= np.rint(apart / run.sides) * run.sides if np.all(run.sides) else 0
    distance = np.linalg.norm(apart, axis=2) + 1e9 * np.eye(len(x[at]))
    contact = (run.diameters[:, None] + run.diameters) / 2
    i, j = np.unravel_index(np.argmin(distance - contact), distance.shape)
    x[at, i] -= apart[i, j] * (1 - contact[i, j] * (1 - 1e-6) / distance[i, j])
    return run._replace(positions=x)


def _coincide(run: Run, rng: np.random.Generator) -> Run:
    x = run.positions.copy()
    x[40, 3] = x[40, 4]
    return run._replace(positions=x)


def _wrong_box(run: Run, rng: np.random.Generator) -> Run:
    return run._replace(sides=run.sides * 1.3, scene=None)


def _wrong_unit(run: Run, rng: np.random.Generator) -> Run:
    return _velocities(run, lambda v: 1.2 * v)


def _wrong_mass(run: Run, rng: np.random.Generator) -> Run:
    masses = run.masses.copy()
    masses[7] *= 1.001
    return run._replace(masses=masses)


def _lost(run: Run, rng: np.random.Generator) -> Run:
    x = run.positions.copy()
    x[-1, 2, 1] = np.nan
    return run._replace(positions=x)


FLUIDS = ("liquid", "spheres", "disks")
FAULTS = (
    Fault("velocities along y times 1.2", "equipartition", (*FLUIDS, "Ornstein-Uhlenbeck"), _one_axis),
    Fault("velocities along y times 1.02", "equipartition", ("normals, 400 particles",), _one_axis_slightly),
    Fault("velocities of one species times 1.2", "equipartition", ("liquid of two masses", "Ornstein-Uhlenbeck"), _hot),
    Fault("velocities times 0.95, T known", "temperature", ("Ornstein-Uhlenbeck", "normals"), _cold_bath),
    Fault("flying ice cube", "common motion", (*FLUIDS, "Ornstein-Uhlenbeck"), _ice_cube),
    Fault("a momentum of 1e-6 from a third on", "momentum", FLUIDS, _kick),
    Fault("velocities grow by 1e-3", "energy", ("spheres", "disks", "square wells"), _heat),
    Fault("velocities grow by 3e-3, of steps", "energy", ("liquid", "liquid, shifted force"), _heat_steps),
    Fault("velocities uniform", "Maxwell's distribution", (*FLUIDS, "Ornstein-Uhlenbeck", "normals"), _uniform),
    Fault("K of 1 % scatter at given T", "total kinetic energy", ("Ornstein-Uhlenbeck", "normals"), _narrow),
    Fault("a frame with the state of the one before", "repeated frames", FLUIDS, _repeat),
    Fault("a frame twice", "time axis", FLUIDS, _twice),
    Fault("two frames exchanged", "time axis", FLUIDS, _exchange),
    Fault("two frames exchanged, times are not", "order of frames",
          (*FLUIDS, "liquid, dense in time", "spheres, sparse in time"), _exchange_quietly),
    Fault("two frames missing", "time axis", FLUIDS, _gap),
    Fault("a particle moves by an edge", "images of the box", FLUIDS, _leap),
    Fault("a wrong image in a wrapped file", "images of the box",
          ("liquid, wrapped, six digits", "spheres, wrapped"), _outside),
    Fault("a particle is 0.48 edges away in a frame", "jumps", ("liquid", "spheres", "liquid, no velocities"), _hop),
    Fault("an overlap of 1e-6", "overlaps", ("spheres", "disks", "spheres of two sizes"), _overlap),
    Fault("two particles in one place", "overlaps", ("liquid", "Ornstein-Uhlenbeck"), _coincide),
    Fault("edges of the box 1.3 times as long", "radial distribution", ("normals, 600 particles",), _wrong_box),
    Fault("velocities in a unit 1.2 times as large", "velocities against displacements",
          ("liquid, dense in time", "spheres, dense in time", "Ornstein-Uhlenbeck, dense in time"), _wrong_unit),
    Fault("a mass 1.001 times as large", "set-up", FLUIDS, _wrong_mass),
    Fault("a position that is not a number", "frames", FLUIDS, _lost),
)  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=100, help="number of seeds of each kind")
    parser.add_argument("--kind", action="append", default=[], help="kind of trajectory; repeatable; default: all")
    parser.add_argument("--faults", type=int, default=5, help="number of seeds of each planted fault")
    options = parser.parse_args()
    pool = Pool()
    try:
        if options.seeds:
            _rates(pool, options.kind or list(MADE), options.seeds)
        if options.faults:
            _faults(pool, options.faults, options.kind)
    finally:
        pool.close()


def _rates(pool: Pool, kinds: list[str], seeds: int) -> None:
    print("| trajectory | inspections | judgements | red | inconclusive | least p times judgements |")
    print("|---|---|---|---|---|---|", flush=True)
    for kind in kinds:
        counts: Counter[str] = Counter()
        red: Counter[str] = Counter()
        least = np.inf
        for seed in range(seeds):
            for inspection in inspections(MADE[kind](pool, seed)):
                counts["inspections"] += 1
                for found in inspection.found:
                    for one in found.told.judgements:
                        counts["judgements"] += 1
                        counts[one.outcome] += 1
                        if one.outcome == "fail":
                            red[f"{found.property.name}: {one.quantity} (seed {seed})"] += 1
                        if one.p_value is not None and one.freedom is not None:
                            counts["tested"] += 1
                            least = min(least, one.p_value)
        smallest = f"{least * counts['tested']:.2g}" if counts["tested"] else ""
        numbers = (counts[name] for name in ("inspections", "judgements", "fail", "inconclusive"))
        print(f"| {kind} | {' | '.join(map(str, numbers))} | {smallest} |", flush=True)
        for name, number in red.items():
            print(f"    red: {number} {name}", flush=True)


def _faults(pool: Pool, seeds: int, kinds: list[str]) -> None:
    print("\n| fault | trajectory | property | red | also red |")
    print("|---|---|---|---|---|", flush=True)
    for fault in FAULTS:
        for kind in fault.kinds:
            if kinds and kind not in kinds:
                continue
            seen, others = 0, Counter[str]()
            for seed in range(seeds):
                run = fault.plant(MADE[kind](pool, seed), np.random.default_rng(seed))
                names = {
                    found.property.name
                    for inspection in inspections(run)
                    for found in inspection.found
                    if any(one.outcome == "fail" for one in found.told.judgements)
                }
                seen += fault.property in names
                others.update(names - {fault.property})
            also = ", ".join(f"{name} ({number})" for name, number in others.most_common())
            print(f"| {fault.name} | {kind} | {fault.property} | {seen} of {seeds} | {also} |", flush=True)


if __name__ == "__main__":
    main()
