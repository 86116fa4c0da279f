"""Pressure and energy of fluids in equilibrium against published equations of state, in the range that these have."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from crosscheck.references import hard_spheres as hard
from crosscheck.references import lennard_jones as soft
from crosscheck.references.hard_mixtures import mixture, mixture_compressibility
from crosscheck.references.hard_spheres import Estimate
from crosscheck.scene import Floats, Scene
from crosscheck.simulate.judging.equilibrium import (
    OBSERVABLES,
    Equilibrium,
    equilibrium,
    extras,
    mean_of,
    settled,
    wall_temperature,
    why_none,
)
from crosscheck.simulate.judging.law import Law
from crosscheck.simulate.judging.trial import Trial
from crosscheck.statistics import combined
from crosscheck.verdict import Judged, Judgement, statistical, worst

#: Largest ratio of diameters for which the equation of mixtures is known.
_UNLIKE = 3.0
#: Least cutoff, in sigma, beyond which g = 1 for the corrections; and by how much g may be off there.
_CUTOFF, _STRUCTURE = 2.5, 0.1
#: States of the Lennard-Jones fluid that are known: temperatures, and densities up to the freezing line.
_COLDEST, _HOTTEST, _DENSEST = 0.68, 6.0, 0.86
#: Vapour and liquid in equilibrium: T, densities of both. NIST Standard Reference Simulation Website.
_COEXISTENCE = (
    (0.70, 0.0019956, 0.84341),
    (0.80, 0.0061007, 0.79981),
    (0.85, 0.0096404, 0.77681),
    (0.90, 0.01451, 0.75284),
    (1.00, 0.029556, 0.70094),
    (1.10, 0.055061, 0.64075),
    (1.20, 0.1003, 0.56329),
    (1.32, 0.31, 0.31),
)


def _excuse(trial: Trial) -> str | None:
    scene = trial.scene
    if scene.lennard_jones is None and scene.hard_spheres is None:
        return f"none is known for [{scene.interaction}]"
    if set(scene.boundaries) != {"periodic"}:
        return "it is known of periodic boxes alone"
    reason = why_none(trial) or ("the particles fall" if scene.acceleration is not None else None)
    if reason or wall_temperature(scene) is not None:
        return reason or "walls"
    return _hard_excuse(trial) if scene.hard_spheres is not None else _soft_excuse(trial)


def _judge(trial: Trial) -> Judged:
    return _judge_hard(trial) if trial.scene.hard_spheres is not None else _judge_soft(trial)


# -- hard spheres ------------------------------------------------------------------------------------------------------


def _hard_excuse(trial: Trial) -> str | None:
    spheres = trial.scene.hard_spheres
    assert spheres is not None
    if not trial.event_driven:
        return "it is of hard spheres; these are soft" if trial.kind == "stepping" else "impulses are not summed"
    if spheres.well is not None:
        return "none is known of square wells at this density"
    if not trial.measures("collisional_virial"):
        return "the engine does not measure the collisional virial"
    try:
        _known(trial.scene)
    except ValueError as error:
        return str(error)
    return None


def _known(scene: Scene) -> Estimate:
    """Z of N spheres. ValueError, with the reason, outside the range of the equation."""
    diameters, d, number = scene.diameters(), scene.dimension, scene.number
    assert diameters is not None
    volume = scene.volume()
    kinds, counts = np.unique(diameters, return_counts=True)
    if kinds.size == 1:
        return hard.finite_compressibility(hard.packing_fraction(number / volume, d, float(kinds[0])), number, d)
    if kinds.max() > _UNLIKE * kinds.min():
        raise ValueError(f"diameters that differ by more than a factor of {_UNLIKE:g}")
    species = mixture(counts / volume, kinds)
    known = mixture_compressibility(species, d)
    shift = hard.number_correction(species.packing_fraction[d - 2], number, d)
    # of mixtures the correction for finite N is known to its size alone
    return Estimate(known.value - shift, doubt=known.doubt + 0.5 * shift)


def _judge_hard(trial: Trial) -> Judged:
    """Z from the collisional virial; of one species from the number of collisions too."""
    found, known = equilibrium(trial), _known(trial.scene)
    number, d = trial.scene.number, trial.scene.dimension
    temperature = float(found.temperature.mean())
    virial = _rates(found, found.run["collisional_virial"]) / (d * number * temperature)
    mean = mean_of(virial)
    why = "published equations of state, for this N; standard error of correlated stretches"
    judged = [
        settled(
            found,
            statistical(
                "Z = p/(n T) from the collisional virial", 1 + mean.value, mean.error, known.value, 0.0, why,
                samples=mean, doubt=known.doubt,
            ),
        )
    ]  # fmt: skip
    diameters, masses = trial.start.diameters, trial.start.masses
    assert diameters is not None
    alike = np.unique(diameters).size == 1 and np.unique(masses).size == 1
    if alike and "collisions" in found.run:
        unit = float(diameters[0]) * (float(masses[0]) / temperature) ** 0.5
        counted = hard.excess_from_rate(2 * unit * _rates(found, found.run["collisions"]) / number, number, d)
        if counted.mean() > 0:
            apart = mean_of((virial - counted) / counted.mean())
            judged.append(
                settled(
                    found,
                    statistical(
                        "Z - 1 from impulses over that from the number of collisions, less 1", apart.value, apart.error,
                        0.0, 0.0, "exact in equilibrium at constant energy; standard error of correlated stretches",
                        samples=apart,
                    ),
                )
            )  # fmt: skip
    return worst(judged, _note(found))


def _rates(found: Equilibrium, tally: Floats) -> Floats:
    """Growth per time of a sum between samples after the relaxation."""
    return np.asarray((np.diff(tally) / np.diff(found.run["time"]))[found.first :])


def _note(found: Equilibrium) -> str:
    return f"{found.samples} samples until t = {found.scene.duration:g}, T = {found.temperature.mean():.4g}"


# -- Lennard-Jones -----------------------------------------------------------------------------------------------------


def _soft_excuse(trial: Trial) -> str | None:
    scene = trial.scene
    lj = scene.lennard_jones
    assert lj is not None
    if scene.dimension != 3:
        return "it is known in three dimensions"
    if np.size(lj.epsilon) > 1 or np.size(lj.length) > 1 or np.unique(trial.start.masses).size > 1:
        return "it is known of one species"
    if lj.truncation != "truncated":
        return f"it is of the whole potential, and lennard_jones.truncation={lj.truncation} is another one"
    epsilon, sigma = _units(scene)
    if lj.cutoff < _CUTOFF * sigma:
        return f"corrections for a cutoff below {_CUTOFF:g} sigma are not known well enough"
    try:
        import teqp  # noqa: F401
    except ImportError:
        return "the package teqp, which has it, is not installed"
    kinetic = trial.run.get("kinetic_energy")
    if kinetic is None or not trial.measures("virial") or not trial.measures("potential_energy"):
        return "the engine does not measure energies and virial"
    half = len(kinetic) // 2
    t = 2 * float(kinetic[half:].mean()) / (3 * (scene.number - 1)) / epsilon
    return _outside(t, scene.number / scene.volume() * sigma**3)


def _units(scene: Scene) -> tuple[float, float]:
    """epsilon and sigma."""
    lj = scene.lennard_jones
    assert lj is not None
    length = float(np.max(lj.length)) / (2 ** (1 / 6) if lj.length_form == "r_m" else 1.0)
    return float(np.max(lj.epsilon)), length


def _outside(temperature: float, density: float) -> str | None:
    """None, or why a state, in reduced units, is not one of the fluid that is known."""
    state = f"T = {temperature:.3g}, density {density:.3g}"
    if not _COLDEST <= temperature <= _HOTTEST:
        return f"{state}: it is known for temperatures from {_COLDEST:g} to {_HOTTEST:g}"
    if density > _DENSEST:
        return f"{state}: it is of fluids, known here up to a density of {_DENSEST:g}"
    t, vapour, liquid = np.array(_COEXISTENCE).T
    if temperature < t[-1] and np.interp(temperature, t, vapour) < density < np.interp(temperature, t, liquid):
        return f"{state}: vapour and liquid part"
    return None


def _judge_soft(trial: Trial) -> Judged:
    """u and p at the temperature that the run has, with the corrections for the cutoff."""
    found, scene = equilibrium(trial), trial.scene
    epsilon, sigma = _units(scene)
    number, lj = scene.number, scene.lennard_jones
    assert lj is not None
    density = number / scene.volume() * sigma**3
    run, first = found.run, found.first
    t_series = found.temperature / epsilon
    t = mean_of(t_series)
    outside = _outside(t.value, density)
    tail = soft.tail(density, lj.cutoff / sigma)
    known = soft.equation_of_state(t.value, density)
    warmer = soft.equation_of_state(1.01 * t.value, density)
    volume = scene.volume() / sigma**3
    moving = found.kinetic
    series = {
        "energy": run["potential_energy"][first:] / (number * epsilon),
        "pressure": (2 * moving + run["virial"][first:]) / (3 * volume * epsilon),
    }
    judged: list[Judgement] = []
    for name, correction, size in (
        ("energy", tail.energy, abs(known.energy)),
        ("pressure", tail.pressure, density * t.value),
    ):
        expected, gap = getattr(known, name), getattr(known, f"{name}_uncertainty")
        # u, p and T fluctuate together: the error is that of the series with the temperature's share taken out
        slope = (getattr(warmer, name) - expected) / (0.01 * t.value)
        mean = mean_of(series[name] - slope * (t_series - t.value))
        doubt = 2 * gap + (size + abs(slope) * t.value) / number + _STRUCTURE * abs(correction)
        one = statistical(
            f"{name} {'a particle' if name == 'energy' else ''}".strip() + ", in epsilon and sigma",
            mean.value + correction,
            mean.error,
            expected,
            0.0,
            "two equations of state and the gap between them; 1/N of it; a tenth of the correction for the cutoff",
            samples=combined(mean.value, mean.error, (mean, t)),
            doubt=doubt,
            note=outside or "",
        )
        if outside and one.outcome == "fail":
            one = replace(one, outcome="inconclusive")
        judged.append(settled(found, one))
    return worst(judged, _note(found))


LAWS = (
    Law(
        "equation-of-state",
        "Z(eta) of hard disks, spheres and their mixtures; u(T, n), p(T, n) of the Lennard-Jones fluid",
        _excuse,
        _judge,
        records=OBSERVABLES,
        extra=extras,
    ),
)
