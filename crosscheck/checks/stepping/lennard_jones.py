"""The Lennard-Jones fluid: one configuration to round-off, trajectories until chaos, energy drift, and averages."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import Laboratory, fixed, legacy_check, legacy_schemes_with
from crosscheck.convergence import ORDER_TOLERANCE, WHY_ORDER
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.references import lennard_jones as reference
from crosscheck.scene import Box, Floats, Lattice, LennardJones, Method, Observable, Output, Scene, Wall, explicit
from crosscheck.statistics import correlated_mean, fitted_order, standard_error
from crosscheck.verdict import Judged, Judgement, bounded, order, round_off, statistical, worst

OBSERVABLES: tuple[Observable, ...] = ("kinetic_energy", "potential_energy", "virial")
_STILL = Method(scheme="velocity_verlet", dt=0.005)


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
    """A periodic cube of Lennard-Jones particles that starts on a face-centred cubic lattice."""
    return Scene(
        name=f"lennard-jones-{number}",
        dimension=3,
        duration=duration,
        lennard_jones=LennardJones(cutoff=cutoff, truncation=truncation),  # type: ignore[arg-type]
        box=Box(density=density),
        initial=Lattice(kind="lattice", structure="fcc", number=number, temperature=temperature, seed=seed),
    )


def _shaken(scene: Scene, amplitude: float, seed: int) -> Scene:
    """The scene with every particle displaced at random, at rest, asking for forces, energy and virial."""
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
        output=Output(interval=_STILL.step, observables=OBSERVABLES, forces=True),
    )


# -- one configuration ----------------------------------------------------------------------------------


def _forms() -> dict[str, Scene]:
    base = fluid(500, 0.8, 0.0, 0)
    half = tuple(int(kind) for kind in np.arange(500) % 2)
    lattice2 = Lattice(kind="lattice", structure="triangular", number=400, temperature=0.0, seed=0)
    walls = Box(lengths=(9.0, 8.0, 11.0), boundaries=("periodic", "periodic", "wall"), wall=Wall(cutoff=2.5))
    return {
        "truncated": base,
        "shifted": fluid(500, 0.8, 0.0, 0, truncation="shifted"),
        "force-shifted": fluid(500, 0.8, 0.0, 0, truncation="force_shifted"),
        "r_m": base.changed(lennard_jones=LennardJones(cutoff=2.5, length=1.1, length_form="r_m")),
        "mixture": base.changed(
            species=half, lennard_jones=LennardJones(cutoff=2.5, epsilon=(1.0, 0.5), length=(1.0, 0.88))
        ),
        "2d": base.changed(dimension=2, box=Box(density=0.8), initial=lattice2),
        "walls": base.changed(box=walls),
    }


class _Static:
    """Forces, energy and virial of a run of no steps."""

    def __init__(self, run: Run) -> None:
        self.forces, self.energy, self.virial = run["forces"], run["potential_energy"][0], run["virial"][0]


def _compare(measured: _Static, other: _Static | reference.PairSum, sums: reference.PairSum, against: str) -> Judgement:
    """Largest relative difference of forces, energy and virial, each relative to the sum of its terms' sizes."""
    scale = np.maximum(sums.force_scale, sums.force_scale.mean())[:, None]
    errors = {
        "force": float((abs(measured.forces - other.forces) / scale).max()),
        "energy": abs(measured.energy - other.energy) / sums.energy_scale,
        "virial": abs(measured.virial - other.virial) / sums.virial_scale,
    }
    name = max(errors, key=lambda key: errors[key])
    return round_off(
        f"largest relative difference from {against} ({name})",
        errors[name],
        2 * sums.sensitivity * EPSILON,
        "rounding of the coordinates, through f ~ r^-13, in each of the two",
        note="relative differences: " + ", ".join(f"{key} {value:.1e}" for key, value in errors.items()),
    )


def _judge_forms(laboratory: Laboratory, variant: str) -> Judged:
    scene = _shaken(_forms()[variant], 0.05, laboratory.seed())
    sums = reference.pair_sum(scene)
    return _compare(_Static(laboratory.run(scene, _STILL)), sums, sums, "a direct pair sum")


def _judge_configuration(laboratory: Laboratory, variant: str) -> Judged:
    scene = _shaken(fluid(4000, 0.8442, 0.0, 0), 0.05, laboratory.seed())
    sums = reference.pair_sum(scene)
    other = laboratory.run(scene, _STILL, engine=variant.removeprefix("against-"))
    return _compare(_Static(laboratory.run(scene, _STILL)), _Static(other), sums, variant.removeprefix("against-"))


# -- trajectories ---------------------------------------------------------------------------------------

#: Small enough for many starts; the box is just twice the cutoff.
TRAJECTORY = fluid(108, 0.8442, 1.44, 0)
TRAJECTORY_STEPS, TRAJECTORY_EVERY, STARTS = 2400, 20, 12
EARLY_STEPS = 20
DISTURBANCE = 1e-13


def _separation(one: Run, two: Run) -> Floats:
    return np.sqrt(((one["positions"] - two["positions"]) ** 2).mean(axis=(1, 2)))


def _start(seed: int) -> Scene:
    initial = TRAJECTORY.initial
    assert isinstance(initial, Lattice)
    return TRAJECTORY.changed(
        initial=initial.model_copy(update={"seed": seed}),
        duration=TRAJECTORY_STEPS * _STILL.step,
        output=Output(interval=TRAJECTORY_EVERY * _STILL.step, trajectory=True),
    )


def _judge_early(laboratory: Laboratory, variant: str) -> Judged:
    """The first 20 steps, one by one: only rounding may separate the two."""
    scene = _start(laboratory.seed()).changed(
        duration=EARLY_STEPS * _STILL.step, output=Output(interval=_STILL.step, trajectory=True)
    )
    run = laboratory.run(scene, _STILL)
    other = laboratory.run(scene, _STILL, engine=variant.removeprefix("against-"))
    separation = _separation(run, other)
    lengths = scene.lengths()
    assert lengths is not None
    return round_off(
        f"rms separation from {variant.removeprefix('against-')} after {EARLY_STEPS} steps",
        float(separation[-1]),
        4 * EPSILON * float(lengths.max()) * EARLY_STEPS,
        "four roundings of a coordinate a step, and no time for chaos",
        figures=(
            Figure(
                "separation, step by step", "step", "rms separation", "linear", "log",
                (Series("two engines", list(range(1, EARLY_STEPS + 1)), separation[1:].tolist()),),
            ),
        ),
    )  # fmt: skip


def _growth_rate(time: Floats, separation: Floats) -> float:
    """Slope of ln(separation) between 1e-12, clear of rounding, and 1e-4, clear of saturation; NaN if it jumps."""
    window = (separation > 1e-12) & (separation < 1e-4)
    return float(np.polyfit(time[window], np.log(separation[window]), 1)[0]) if window.sum() > 3 else np.nan


def _horizon(time: Floats, separation: Floats) -> float:
    """When the separation first exceeds 1e-6."""
    return float(time[np.flatnonzero(separation > 1e-6)[0]])


def _judge_growth(laboratory: Laboratory, variant: str) -> Judged:
    """Two engines must part as one parts from itself when disturbed by 1e-13: at the same rate, and no sooner."""
    other = variant.removeprefix("against-")
    rates, horizons = np.empty((2, STARTS)), np.empty((2, STARTS))
    curves = []
    for number in range(STARTS):
        scene = _start(laboratory.seed(str(number)))
        state = scene.initial_state()
        rng = np.random.default_rng(laboratory.seed(f"{number} disturbance"))
        positions = state.positions + DISTURBANCE * rng.normal(size=state.positions.shape)
        run = laboratory.run(scene, _STILL)
        apart = _separation(run, laboratory.run(scene, _STILL, engine=other))
        twin = _separation(run, laboratory.run(scene.changed(initial=explicit(positions, state.velocities)), _STILL))
        rates[:, number] = [_growth_rate(run["time"], part) for part in (apart, twin)]
        horizons[:, number] = [_horizon(run["time"], part) for part in (apart, twin)]
        if number == 0:
            shown = slice(1, None, 3)
            for label, values in ((f"{laboratory.engine} and {other}", apart), ("disturbed by 1e-13", twin)):
                curves.append(Series(label, run["time"][shown].tolist(), values[shown].tolist()))
    means, errors = rates.mean(axis=1), standard_error(rates.T)
    rate = statistical(
        f"growth rate of the separation from {other}",
        float(means[0]),
        float(errors[0]),
        float(means[1]),
        float(errors[1]),
        f"standard error over {STARTS} independent starts",
        samples=STARTS,
        needed=1.0,
        figures=(Figure("separation of trajectories", "t", "rms separation", "linear", "log", tuple(curves)),),
    )
    sooner = bounded(
        "mean time until a separation of 1e-6",
        float(horizons[0].mean()),
        float(horizons[1].mean()),
        f"that of a run disturbed by {DISTURBANCE:g}, three decades above the rounding of two right engines",
        at_least=True,
    )
    return worst([rate, sooner], f"{STARTS} starts")


# -- energy drift ---------------------------------------------------------------------------------------


def _drop(number: int, density: float, temperature: float, seed: int) -> Scene:
    """A cube cut out of a lattice, in open space; all pairs interact."""
    state = fluid(number, density, temperature, seed, cutoff=0.5).initial_state()
    assert state.lengths is not None
    return Scene(
        name=f"drop-{number}",
        dimension=3,
        duration=0.5,
        lennard_jones=LennardJones(cutoff=30.0),
        box=Box(lengths=(60.0, 60.0, 60.0), boundaries=("open", "open", "open")),
        initial=explicit(state.positions + 30.0 - state.lengths / 2, state.velocities),
    )


#: Time steps by nominal order: first-order schemes are asymptotic only at much smaller ones.
DRIFT_STEPS = {1: (0.001, 0.0005, 0.00025, 0.000125), 2: (0.004, 0.002, 0.001, 0.0005)}


def _judge_energy_error(laboratory: Laboratory, scheme: str) -> Judged:
    """Rms of E(t) - E(0) a particle over a time unit of a hot drop, the cutoff beyond it, so that E is smooth."""
    claims = laboratory.claims[scheme]
    assert claims.order is not None
    # melted first: on a lattice the forces nearly cancel, which hides the error
    melt = _drop(108, 0.8, 2.0, laboratory.seed())
    start = laboratory.run(melt, _STILL, engine="refimpl")
    # the higher derivatives that Gear's schemes start from are zero here, which leaves order 2
    nominal = min(*claims.order, 2)
    scene = melt.changed(
        initial=explicit(start["final_positions"], start["final_velocities"]),
        duration=1.0,
        output=Output(interval=0.02, observables=("kinetic_energy", "potential_energy")),
    )
    errors = []
    for dt in DRIFT_STEPS[nominal]:
        run = laboratory.run(scene, Method(scheme=scheme, dt=dt))
        energy = (run["kinetic_energy"] + run["potential_energy"]) / scene.number
        errors.append(float(np.sqrt(((energy - energy[0]) ** 2).mean())))
    slope = fitted_order(DRIFT_STEPS[nominal], errors, 1e3 * EPSILON)
    curve = Series(scheme, list(DRIFT_STEPS[nominal]), errors)
    return order(
        "order of the energy error",
        slope.value,
        nominal,
        max(ORDER_TOLERANCE, 2 * slope.error),
        f"{WHY_ORDER}; or twice the departure of the local slopes",
        uncertainty=slope.error,
        figures=(Figure("energy error of the drop", "dt", "rms of E - E0 a particle", "log", "log", (curve,)),),
    )


# -- averages -------------------------------------------------------------------------------------------

#: density and temperature; cutoff, time step, steps of the production run and steps between samples.
STATE_POINTS = {"rho0.8-T1.0": (0.8, 1.0), "rho0.5-T2.0": (0.5, 2.0), "rho0.3-T2.5": (0.3, 2.5)}
CUTOFF, AVERAGE_DT, AVERAGE_STEPS, AVERAGE_EVERY, PARTICLES = 3.0, 0.004, 4000, 10, 500


def _temperature(scene: Scene, kinetic: Floats | float) -> Floats | float:
    """2 K/(d (N - 1)): the total momentum is zero and does not take part."""
    return 2 * kinetic / (scene.dimension * (scene.number - 1))


def _equilibrated(laboratory: Laboratory, point: str) -> Scene:
    """A liquid at the state point: melted by `refimpl`, velocities scaled ten times, then left alone."""
    density, temperature = STATE_POINTS[point]
    method = Method(scheme="velocity_verlet", dt=AVERAGE_DT)
    scene = fluid(PARTICLES, density, 2 * temperature, laboratory.seed(), cutoff=CUTOFF, duration=100 * AVERAGE_DT)
    for _ in range(10):
        run = laboratory.run(scene, method, engine="refimpl")
        kinetic = 0.5 * (run["final_velocities"] ** 2).sum()
        scale = np.sqrt(temperature / _temperature(scene, kinetic))
        scene = scene.changed(initial=explicit(run["final_positions"], scale * run["final_velocities"]))
    run = laboratory.run(scene.changed(duration=500 * AVERAGE_DT), method, engine="refimpl")
    return scene.changed(
        initial=explicit(run["final_positions"], run["final_velocities"]),
        duration=AVERAGE_STEPS * AVERAGE_DT,
        output=Output(interval=AVERAGE_EVERY * AVERAGE_DT, observables=OBSERVABLES),
    )


def _series(scene: Scene, run: Run) -> dict[str, Floats]:
    """T, u = U/N and p at every sample, without long-range corrections."""
    return {
        "T": np.asarray(_temperature(scene, run["kinetic_energy"])),
        "u": run["potential_energy"] / scene.number,
        "p": (2 * run["kinetic_energy"] + run["virial"]) / (scene.dimension * scene.volume()),
    }


def _judge_equation_of_state(laboratory: Laboratory, point: str) -> Judged:
    """u and p at the temperature that the run has, against the equations of state."""
    scene = _equilibrated(laboratory, point)
    density = STATE_POINTS[point][0]
    series = _series(scene, laboratory.run(scene, Method(scheme="velocity_verlet", dt=AVERAGE_DT)))
    t = correlated_mean(series["T"])
    tail = reference.tail(density, CUTOFF)
    known = reference.equation_of_state(t.value, density)
    warmer = reference.equation_of_state(1.01 * t.value, density)
    judgements = []
    for name, correction, field, size in (
        ("u", tail.energy, "energy", abs(known.energy)),
        ("p", tail.pressure, "pressure", density * t.value),
    ):
        expected, gap = getattr(known, field), getattr(known, f"{field}_uncertainty")
        # u, p and T fluctuate together: the error is that of the series with the temperature's share taken out
        slope = (getattr(warmer, field) - expected) / (0.01 * t.value)
        mean = correlated_mean(series[name] - slope * (series["T"] - t.value))
        judgements.append(
            statistical(
                f"{name} at T = {t.value:.4f}",
                mean.value + correction,
                mean.error,
                expected,
                # a finite system at constant energy differs by 1/N in the quantity, and in what its temperature is
                float(np.sqrt(gap**2 + (size / PARTICLES) ** 2 + (slope * t.value / PARTICLES) ** 2)),
                "error of correlated data, half the gap between two equations of state, 1/N of it and of T",
                samples=mean.independent,
                needed=0.05 if name == "u" else None,
            )
        )
    return worst(judgements, f"T = {t.value:.4f} +- {t.error:.4f}")


def _judge_averages(laboratory: Laboratory, variant: str) -> Judged:
    """T, u and p of two engines that start from one state: the same energy, hence the same averages."""
    point, _, other = variant.partition("-against-")
    scene = _equilibrated(laboratory, point)
    method = Method(scheme="velocity_verlet", dt=AVERAGE_DT)
    ours, theirs = (
        {name: correlated_mean(values) for name, values in _series(scene, run).items()}
        for run in (laboratory.run(scene, method), laboratory.run(scene, method, engine=other))
    )
    judgements = [
        statistical(
            f"{name} ({laboratory.engine} against {other})",
            ours[name].value,
            ours[name].error,
            theirs[name].value,
            theirs[name].error,
            "standard errors of two correlated series",
            samples=min(ours[name].independent, theirs[name].independent),
            needed=0.05 if name != "p" else None,
        )
        for name in ("T", "u", "p")
    ]
    return worst(judgements, f"{AVERAGE_STEPS} steps of {PARTICLES} particles")


_KERNEL = "stepping/kernels/lennard_jones.py"
_FORCE_TERM = "f = q2 * q2 * (q2 * q * repulsion - attraction)"
_LISTS = "Allen & Tildesley, Computer Simulation of Liquids (1987), chapters 1, 2 and 5"
_POTENTIAL = "phi = 4 epsilon ((sigma/r)^12 - (sigma/r)^6), F = -phi'(r) r_ij/r, W = sum r_ij . F_ij"


def _kernel_fault(name: str, old: str, new: str, breaks: str) -> Fault:
    return Fault(name, _KERNEL, old, new, breaks)


CHECKS = (
    legacy_check(
        name="stepping/lennard-jones-forms",
        title="Forces, energy and virial in every form of the potential, against a direct pair sum",
        equation=f"{_POTENTIAL}; truncated, shifted, force-shifted; sigma and r_m = 2^(1/6) sigma; mixtures; walls; 2D",
        criterion="largest difference, relative to the sum of the terms' sizes, <= 2 x 14 (L/r_min) eps",
        citation=_LISTS,
        judge=_judge_forms,
        variants=fixed(*_forms()),
        faults=(
            (
                "mixture",
                _kernel_fault(
                    "mixing-rule",
                    "length = size + load_splat(sizes, j)",
                    "length = size + size",
                    "unlike pairs take the size of one partner",
                ),
            ),
            (
                "force-shifted",
                _kernel_fault(
                    "force-shift-sign",
                    "f = f + _slope_at_cutoff(",
                    "f = f - _slope_at_cutoff(",
                    "the force shift has the wrong sign",
                ),
            ),
        ),
        engines=("refimpl", "lammps", "ase"),
    ),
    legacy_check(
        name="stepping/lennard-jones-configuration",
        title="Forces, energy and virial of one configuration of 4000 particles, engine against engine",
        equation=_POTENTIAL,
        criterion="largest difference, relative to the sum of the terms' sizes, <= 2 x 14 (L/r_min) eps",
        citation=_LISTS,
        judge=_judge_configuration,
        variants=fixed("against-lammps", "against-ase"),
        faults=(
            (
                "against-lammps",
                _kernel_fault(
                    "repulsion-1e-9",
                    _FORCE_TERM,
                    "f = q2 * q2 * (q2 * q * repulsion * splat(1.000000001) - attraction)",
                    "the repulsion is off by 1e-9",
                ),
            ),
        ),
    ),
    legacy_check(
        name="stepping/lennard-jones-trajectory",
        title="The first 20 steps at constant energy, engine against engine",
        equation="m a = F, velocity Verlet, rho = 0.8442, dt = 0.005",
        criterion="rms separation <= four roundings of a coordinate a step",
        citation="Swope, Andersen, Berens & Wilson, J. Chem. Phys. 76, 637 (1982)",
        judge=_judge_early,
        variants=fixed("against-lammps", "against-ase"),
        faults=(
            (
                "against-lammps",
                _kernel_fault(
                    "attraction-1e-9",
                    _FORCE_TERM,
                    "f = q2 * q2 * (q2 * q * repulsion - attraction * splat(1.000000001))",
                    "the attraction is off by 1e-9",
                ),
            ),
        ),
    ),
    legacy_check(
        name="stepping/lennard-jones-chaos",
        title="Growth of the separation between two engines, against that of one engine disturbed by 1e-13",
        equation="|delta r(t)| ~ |delta r(0)| exp(lambda t)",
        criterion="lambda within the standard errors of 12 starts; separation of 1e-6 reached no sooner",
        citation="Allen & Tildesley (1987), section 3.2; Benettin et al., Meccanica 15, 9 (1980)",
        judge=_judge_growth,
        variants=fixed("against-lammps"),
        faults=(
            (
                "against-lammps",
                _kernel_fault(
                    "cutoff-edge",
                    "f = where(r2 < splat(cutoff * cutoff), f, zeros())",
                    "f = where(r2 < splat(0.99999 * cutoff * cutoff), f, zeros())",
                    "pairs at the very edge of the cutoff are missed now and then",
                ),
            ),
        ),
    ),
    legacy_check(
        name="stepping/lennard-jones-energy",
        title="Error of the energy of a hot drop against the time step, every scheme",
        equation="sqrt(mean (E(t) - E(0))^2) ~ dt^p, all pairs, open space",
        criterion=f"fitted order = claimed, at most 2, +- {ORDER_TOLERANCE} or twice the departure of local slopes",
        citation="Allen & Tildesley, Computer Simulation of Liquids (1987), section 3.2",
        judge=_judge_energy_error,
        variants=legacy_schemes_with(lambda name, claims: claims.order is not None),
        faults=(
            (
                "velocity_verlet",
                Fault(
                    "velocity-verlet-lagged-force",
                    "stepping/schemes.py",
                    "return r, v_half + 0.5 * dt * a, (a,)",
                    "return r, v_half + 0.5 * dt * memory[0], (a,)",
                    "the second half kick takes the old acceleration",
                ),
            ),
        ),
        engines=("refimpl", "lammps"),
    ),
    legacy_check(
        name="stepping/lennard-jones-equation-of-state",
        title="Energy and pressure of the fluid at constant energy, against two equations of state",
        equation="u = <U>/N + u_tail, p = (2 <K> + <W>)/3V + p_tail, at T = 2 <K>/(3 (N - 1))",
        criterion="within the standard errors of correlated data, the gap between the equations, and 1/N",
        citation="Kolafa & Nezbeda, Fluid Phase Equilib. 100, 1 (1994); Thol et al., JPCRD 45, 023101 (2016)",
        judge=_judge_equation_of_state,
        variants=fixed(*STATE_POINTS),
        faults=(
            (
                "rho0.8-T1.0",
                _kernel_fault(
                    "virial-factor",
                    "return 0.5 * all_energy, 0.5 * all_work",
                    "return 0.5 * all_energy, 0.6 * all_work",
                    "the virial is 20 % too large",
                ),
            ),
        ),
        engines=("refimpl", "lammps"),
    ),
    legacy_check(
        name="stepping/lennard-jones-averages",
        title="Temperature, energy and pressure from one start, engine against engine",
        equation="T = 2 <K>/(3 (N - 1)), u = <U>/N, p = (2 <K> + <W>)/3V",
        criterion="within the standard errors of two correlated series",
        citation="Flyvbjerg & Petersen, J. Chem. Phys. 91, 461 (1989); Wolff, Comput. Phys. Commun. 156, 143 (2004)",
        judge=_judge_averages,
        variants=fixed(*(f"{point}-against-lammps" for point in STATE_POINTS)),
        faults=(
            (
                "rho0.8-T1.0-against-lammps",
                Fault(
                    "kinetic-energy-1-percent",
                    "stepping/forces/lennard_jones.py",
                    "    return 0.5 * np.sum(v * v)",
                    "    return 0.505 * np.sum(v * v)",
                    "the kinetic energy is 1 % too large",
                ),
            ),
        ),
    ),
)
