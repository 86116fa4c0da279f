"""Lennard-Jones fluids that the checks of this group share: scenes, needs, and state variables at the samples."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Laboratory
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Run
from crosscheck.scene import Box, Floats, Lattice, LennardJones, Method, Observable, Output, Scene, explicit
from crosscheck.verdict import Judgement, bounded

OBSERVABLES: tuple[Observable, ...] = ("kinetic_energy", "potential_energy", "virial")
STEP = Method(scheme="velocity_verlet", dt=0.005)
#: What every engine of such fluids must know, in a periodic cube and in open space.
_WORDS = {"dimension=3", "lennard_jones.length_form=sigma", "lennard_jones.truncation=truncated"}
PERIODIC = frozenset({*_WORDS, "box.boundaries=periodic"})
OPEN = frozenset({*_WORDS, "box.boundaries=open"})
TRAJECTORIES = Needs(
    "lennard_jones",
    words=PERIODIC,
    observables=frozenset({"positions", "velocities"}),
    schemes=(STEP.scheme,),
)
#: Forces, energy and virial of a configuration, from a run of no time.
STATICS = Needs("lennard_jones", observables=frozenset({*OBSERVABLES, "forces"}), schemes=(STEP.scheme,))
#: Averages: runs too long for an engine that does not promise its speed.
AVERAGES = Needs(
    "lennard_jones",
    words=PERIODIC,
    observables=frozenset(OBSERVABLES),
    schemes=(STEP.scheme,),
    promises=("long_runs",),
)

LISTS = "Allen & Tildesley, Computer Simulation of Liquids (1987), chapters 1, 2 and 5"
POTENTIAL = "phi = 4 epsilon ((sigma/r)^12 - (sigma/r)^6), F = -phi'(r) r_ij/r, W = sum r_ij . F_ij"
#: Line of the kernel of Lennard-Jones pairs in which faults are planted.
FORCE_TERM = "f = q2 * q2 * (q2 * q * repulsion - attraction)"


def fluid(
    number: int,
    density: float,
    temperature: float,
    seed: int,
    *,
    cutoff: float = 2.5,
    truncation: str = "truncated",
    duration: float = 0.0,
) -> Scene:
    """A periodic cube of Lennard-Jones particles that starts on a face-centred cubic lattice.

    number: of particles. density, temperature, cutoff, duration: in reduced units. seed: of the velocities. truncation:
    the form of the potential at the cutoff, as in `LennardJones`.
    """
    return Scene(
        name=f"lennard-jones-{number}",
        dimension=3,
        duration=duration,
        lennard_jones=LennardJones(cutoff=cutoff, truncation=truncation),  # type: ignore[arg-type]
        box=Box(density=density),
        initial=Lattice(kind="lattice", structure="fcc", number=number, temperature=temperature, seed=seed),
    )


# -- one configuration -------------------------------------------------------------------------------------------------


def shaken(scene: Scene, amplitude: float, seed: int) -> Scene:
    """The scene with every particle displaced at random, at rest, asking for forces, energy and virial.

    amplitude: standard deviation of each coordinate (length). seed: of the displacements.
    """
    state = scene.initial_state()
    rng = np.random.default_rng(seed)
    positions = state.positions + rng.normal(scale=amplitude, size=state.positions.shape)
    box = scene.box
    assert box is not None
    lengths = scene.lengths()
    assert lengths is not None
    if box.wall is not None:
        # no closer to a wall than 0.8 of its sigma
        positions = np.clip(positions, 0.8 * box.wall.sigma, lengths - 0.8 * box.wall.sigma)
    return scene.changed(
        initial=explicit(positions, np.zeros_like(positions)),
        box=Box(lengths=tuple(lengths.tolist()), boundaries=box.boundaries, wall=box.wall),
        output=Output(interval=STEP.step, observables=OBSERVABLES, forces=True),
    )


# -- averages ----------------------------------------------------------------------------------------------------------


class StatePoint(NamedTuple):
    """A state of the fluid: `density` and `temperature`, in reduced units; steps: of the run for averages.

    The thinner the fluid, the longer its temperature is correlated: the steps give some hundred independent averages.
    number: of particles. needed: relative deviation of averages that must be seen.
    """

    density: float
    temperature: float
    steps: int
    number: int = 500
    needed: float = 0.05


STATE_POINTS = {
    "rho0.8-T1.0": StatePoint(0.8, 1.0, 8000),
    "rho0.5-T2.0": StatePoint(0.5, 2.0, 12000),
    "rho0.3-T2.5": StatePoint(0.3, 2.5, 16000),
}
#: So few particles that codes without lists move them, in a box that is wider than two cutoffs.
FEW_PARTICLES = StatePoint(0.3, 2.5, 8000, 108, 0.1)
#: Samples whose average is one value of `series`. T and U fluctuate fast, and by a tenth of that slowly, for the waves
#: of the box last long: the correlation of samples all but vanishes after 5 of them, returns to 0.08 after 20, and is
#: gone after 75. A sum that ends at the first dip misses half of it: errors were a third too small, drifts were found
#: where there are none. Averages over 5 have no dip.
STRETCH = 5
#: Runs for averages: cutoff, method, steps between samples.
CUTOFF, AVERAGE = 3.0, Method(scheme="velocity_verlet", dt=0.004)
AVERAGE_EVERY = 10


def _temperature_of(scene: Scene, kinetic: Floats | float) -> Floats | float:
    """2 K/(d (N - 1)): the total momentum is zero and does not take part."""
    return 2 * kinetic / (scene.dimension * (scene.number - 1))


def equilibrated(laboratory: Laboratory, point: StatePoint) -> Scene:
    """A liquid at the state `point`: melted by `refimpl`, velocities scaled ten times, then run on unscaled.

    laboratory: runs it, once its engine has said that it can run what is returned.
    """
    density, temperature, steps, number, _ = point
    scene = fluid(number, density, 2 * temperature, laboratory.seed(), cutoff=CUTOFF, duration=100 * AVERAGE.step)
    averaged = Output(interval=AVERAGE_EVERY * AVERAGE.step, observables=OBSERVABLES)
    laboratory.demand(scene.changed(output=averaged), AVERAGE)
    for _ in range(10):
        run = laboratory.run(scene, AVERAGE, engine="refimpl")
        kinetic = 0.5 * (run["final_velocities"] ** 2).sum()
        scale = np.sqrt(temperature / _temperature_of(scene, kinetic))
        scene = scene.changed(initial=explicit(run["final_positions"], scale * run["final_velocities"]))
    run = laboratory.run(scene.changed(duration=500 * AVERAGE.step), AVERAGE, engine="refimpl")
    return scene.changed(
        initial=explicit(run["final_positions"], run["final_velocities"]),
        duration=steps * AVERAGE.step,
        output=averaged,
    )


def energy_kept(scene: Scene, run: Run, engine: str) -> Judgement:
    """The energy of `run` stays where it is; scene: that run, of particles of mass 1. engine: that ran it.

    Where the potential is cut off, U jumps by phi(r_c) with each pair that comes or goes, and their number fluctuates
    less than that of independent pairs would, by its square root (Poisson). The integrator's own oscillation is a tenth
    of that.
    """
    model = scene.lennard_jones
    volume, kinetic = scene.volume(), float(run["kinetic_energy"].mean())
    assert model is not None
    assert volume is not None
    cutoff = float(model.cutoff)
    pairs = 0.5 * scene.number * (scene.number / volume) * 4 / 3 * np.pi * cutoff**3
    jump = 4 * (cutoff**-6 - cutoff**-12)
    energy = run["kinetic_energy"] + run["potential_energy"]
    return bounded(
        f"departure of the energy from its mean, largest, over that of K ({engine})",
        float(np.abs(energy - energy.mean()).max()) / kinetic,
        float(5 * np.sqrt(pairs) * jump) / kinetic,
        "five standard deviations of the number of pairs within the cutoff, times the jump of the potential there",
        control=True,
    )


def series(scene: Scene, run: Run) -> dict[str, Floats]:
    """T, u = U/N and p, averages over `STRETCH` samples each, (samples // STRETCH,), without long-range corrections.

    scene: that `run` is of. The first sample, the start, is left out.
    """
    sampled = {
        "T": np.asarray(_temperature_of(scene, run["kinetic_energy"])),
        "u": run["potential_energy"] / scene.number,
        "p": (2 * run["kinetic_energy"] + run["virial"]) / (scene.dimension * scene.volume()),
    }
    return {name: values[1:].reshape(-1, STRETCH).mean(axis=1) for name, values in sampled.items()}
