"""Binary mixtures of disks and spheres: pressure, collision rate, equal temperatures; small diameter and mass are 1."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, variants_of
from crosscheck.checks.events.gases import SETTLING, TALLIES, event_driven, rates
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import hard_mixtures as reference
from crosscheck.references.hard_spheres import (
    compressibility,
    finite_compressibility,
    number_density,
    packing_fraction,
)
from crosscheck.scene import Box, HardSpheres, Output, Scene, explicit
from crosscheck.statistics import correlated_mean
from crosscheck.verdict import Judged, statistical, worst

#: Diameters and masses of the small and of the large.
SIZES, WEIGHTS = (1.0, 2.0), (1.0, 5.0)
#: Unit cells of a compound: the large one on the corner, the small ones in the middle (and on the faces).
_SMALL_SITES = {2: [[0.5, 0.5]], 3: [[0.5, 0.5, 0.5], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]]}
CELLS = {2: 24, 3: 6}
COLLISIONS, SAMPLES = 3.6e6, 288


class Blend(NamedTuple):
    """A mixture in `dimension` dimensions; eta: packing fraction of both species together."""

    dimension: int
    eta: float


MIXTURES = {
    **{f"disks-eta{eta:g}": Blend(2, eta) for eta in (0.2, 0.4, 0.5)},
    **{f"spheres-eta{eta:g}": Blend(3, eta) for eta in (0.2, 0.35, 0.45)},
}


def mixture_scene(blend: Blend, seed: int) -> tuple[Scene, reference.Mixture]:
    """Small and large particles that start on the sites of a compound; and what theory says of the mixture.

    At the start the small ones have all of the energy, T = 2K/(d (N - 1)) = 1. blend: the state. seed: of the
    velocities.
    """
    dimension, eta = blend
    basis = np.array([[0.0] * dimension, *_SMALL_SITES[dimension]])
    grid = np.stack(np.meshgrid(*[np.arange(CELLS[dimension])] * dimension, indexing="ij"), axis=-1)
    sites = (grid.reshape(-1, 1, dimension) + basis + 0.25).reshape(-1, dimension)
    species = np.tile([1] + [0] * (len(basis) - 1), len(sites) // len(basis))
    diameters, masses = np.array(SIZES)[species], np.array(WEIGHTS)[species]
    volume = float(np.pi / (2 * dimension) * (diameters**dimension).sum()) / eta
    length = volume ** (1 / dimension)
    numbers = np.bincount(species)
    velocities = np.random.default_rng(seed).normal(size=sites.shape) * (species == 0)[:, None]
    velocities[species == 0] -= velocities.sum(axis=0) / numbers[0]
    twice = float((masses[:, None] * velocities**2).sum())
    velocities *= (dimension * (len(sites) - 1) / twice) ** 0.5
    known = reference.mixture(numbers / volume, SIZES, WEIGHTS)
    rate = float(numbers @ reference.species_collision_rates(known, dimension).sum(axis=1)) / 2
    duration = COLLISIONS / rate
    scene = Scene(
        name=f"hard-mixture-{dimension}d",
        dimension=dimension,  # type: ignore[arg-type]
        duration=duration,
        masses=tuple(masses.tolist()),
        species=tuple(species.tolist()),
        hard_spheres=HardSpheres(diameter=SIZES),
        box=Box(lengths=(length,) * dimension),
        initial=explicit(sites * length / CELLS[dimension], velocities),
        output=Output(interval=duration / SAMPLES, observables=TALLIES, trajectory=True),
    )
    return scene, known


def _judge(laboratory: Laboratory, blend: Blend) -> Judged:
    """Pressure, number of collisions, and the temperatures of the small and of the large."""
    d, eta = blend
    scene, known = mixture_scene(blend, laboratory.seed())
    run = laboratory.run(scene, EVENT_DRIVEN)
    number, species, masses = scene.number, np.array(scene.species), np.array(scene.masses)
    excess = correlated_mean(rates(run, run["collisional_virial"]) / (d * number))
    rate = correlated_mean(2 * rates(run, run["collisions"]) / number)
    # no theory of finite N for mixtures: the correction for one species as dense, off by all of it
    infinite = compressibility(eta, d).value
    few = finite_compressibility(eta, number, d).value - infinite
    z = reference.mixture_compressibility(known, d)
    pressure = statistical(
        "Z from the collisional virial",
        1 + excess.value,
        excess.error,
        z.value + few,
        0.0,
        "standard error of correlated blocks; 1 % of the departure from one species; the correction for finite N",
        samples=excess,
        doubt=z.doubt + abs(few),
        needed=0.01,
        figures=(_figure(d, eta, 1 + excess.value, excess.error),),
    )
    shares = known.densities / known.densities.sum()
    expected = float(shares @ reference.species_collision_rates(known, d).sum(axis=1))
    collisions = statistical(
        "collisions of a particle per time",
        rate.value,
        rate.error,
        expected * (1 + few / (infinite - 1)),
        0.0,
        "standard error of correlated blocks; 1 % of the contact values",
        samples=rate,
        doubt=0.01 * expected,
        needed=0.02,
    )
    # at total momentum zero a particle of mass m has m<v^2> = d T (1 - m/M), M the mass of all
    kinetic = masses * (run["velocities"][SETTLING:] ** 2).sum(axis=2) / (d * (1 - masses / masses.sum()))
    small, large = (kinetic[:, species == kind].mean(axis=1) for kind in (0, 1))
    gap = correlated_mean(small - large)
    equipartition = statistical(
        "temperature of the small less that of the large, over T",
        gap.value,
        gap.error,
        0.0,
        0.0,
        f"standard error of {kinetic.shape[0]} samples",
        samples=gap,
        needed=0.05,
    )
    return worst([pressure, collisions, equipartition], f"N = {number}, diameters {SIZES}, masses {WEIGHTS}")


def _figure(dimension: int, eta: float, z: float, error: float) -> Figure:
    x = np.linspace(0.02, 0.52 if dimension == 2 else packing_fraction(0.89, 3), 40)
    large = 1 / (1 + len(_SMALL_SITES[dimension]))

    def law(e: float) -> float:
        mean = (1 - large) * SIZES[0] ** dimension + large * SIZES[1] ** dimension
        density = number_density(e, dimension) / mean
        species = reference.mixture([density * (1 - large), density * large], SIZES)
        return reference.mixture_compressibility(species, dimension).value

    name = "disks" if dimension == 2 else "spheres"
    pure = [compressibility(e, dimension).value for e in x]
    return Figure(
        f"equation of state of a mixture of {name}", "eta", "Z = p/(n T)", "linear", "linear",
        (
            Series("measured", [eta], [z], [error]),
            Series("mixture", x.tolist(), [law(e) for e in x], theory=True),
            Series("one species", x.tolist(), pure, theory=True),
        ),
    )  # fmt: skip


CHECKS = (
    Check(
        name="events/mixture",
        title="Binary mixtures of disks and spheres: pressure, collision rate, equal temperatures",
        equation="Z = 1 + sum r_ij.dp_ij/(d N T t); T_small = T_large; omega = sum x_i n_j g_ij ... sqrt(T/mu_ij)",
        criterion="within the errors of correlated blocks and of BMCSL (2D: Santos, Yuste, Lopez de Haro), 1 % of the "
        "departure from one species",
        citation="Boublik, J. Chem. Phys. 53, 471 (1970); Mansoori et al., J. Chem. Phys. 54, 1523 (1971); Santos, "
        "Yuste & Lopez de Haro, Mol. Phys. 96, 1 (1999); Jenkins & Mancini, J. Appl. Mech. 54, 27 (1987)",
        judge=_judge,
        variants=variants_of(MIXTURES, "full"),
        needs=event_driven(
            "masses[] hard_spheres.diameter[] box.boundaries=periodic", f"positions velocities {' '.join(TALLIES)}"
        ),
        faults=(
            (
                "spheres-eta0.35",
                Fault(
                    "mixture-contact-1-percent",
                    "events/prediction.py",
                    "    return radii[i] + radii[j]",
                    "    return 0.99 * (radii[i] + radii[j])",
                    "particles of several sizes collide at a distance 1 % too small",
                ),
            ),
        ),
    ),
)
