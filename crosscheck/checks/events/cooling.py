"""Gases of inelastic grains that cool for a given number of collisions: what checks of homogeneous cooling share."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Laboratory
from crosscheck.faults import Fault
from crosscheck.references.granular import clustering_length, rotational_freedoms, vortex_excess
from crosscheck.references.hard_spheres import number_density
from crosscheck.scene import Box, Floats, GrainFriction, HardSpheres, Lattice, Observable, Output, Scene

#: Longer than any run that ends at a count of collisions.
_FOR_EVER = 1e9
_LATTICES = {2: "square", 3: "sc"}

#: Independent starts of one gas.
STARTS = 16
#: Length of the box in units of that at which vortices grow; most grains.
SHORT, MOST = 0.5, 2500
#: Intervals, equally many collisions long, that the measurement consists of.
INTERVALS = 12

RESTITUTION_SQUARED = Fault(
    "restitution-squared",
    "events/rules.py",
    "normal = -(1.0 + alpha) * gn * mass",
    "normal = -(1.0 + alpha * alpha) * gn * mass",
    "pairs rebound with the square of the restitution",
)


def _number(loss: float, packing: float, dimension: int) -> int:
    density = number_density(packing, dimension)
    return int(density * (SHORT * clustering_length(loss, density, dimension)) ** dimension)


def finite_size(number: int, loss: float, packing: float, dimension: int) -> tuple[float, float]:
    """Length of the box in units of the clustering length, and the relative terms of order 1/N, vortices included.

    number: of grains. loss: of ln T per collision of a particle. packing: fraction. dimension: 2 or 3.
    """
    density = number_density(packing, dimension)
    length = (number / density) ** (1 / dimension) / clustering_length(loss, density, dimension)
    return length, 1 / number + vortex_excess(number, length, dimension)


class Cooling(NamedTuple):
    """What `STARTS` gases measured from the end of their warm-up on.

    number: of grains. times, temperatures, rotational: (starts, samples), T of translation and of rotation. collisions:
    of a particle, (samples,), the same of all starts.
    """

    number: int
    times: Floats
    temperatures: Floats
    rotational: Floats
    collisions: Floats

    def rates(self) -> Floats:
        """-dT/dt/T^(3/2) of each start, (starts,), mean over the intervals: 2 d(T^(-1/2))/dt."""
        return np.asarray((2 * np.diff(self.temperatures**-0.5) / np.diff(self.times)).mean(axis=1))

    def losses(self) -> Floats:
        """-dln T/ds of each start, (starts,), s the number of collisions of a particle."""
        t = self.temperatures
        return np.asarray(np.log(t[:, 0] / t[:, -1]) / (self.collisions[-1] - self.collisions[0]))


def cool(
    laboratory: Laboratory, dimension: int, alpha: float, friction: GrainFriction | None, packing: float, loss: float,
    span: float, warm: float, most: int = MOST,
) -> Cooling:  # fmt: skip
    """Lets `STARTS` gases cool for `warm` collisions a particle, and then for `span` more, which are measured.

    laboratory: runs them on the engine under judgement. dimension: 2 or 3. alpha: coefficient of restitution. friction:
    of rough grains, or None. packing: fraction. loss: of ln T per collision of a particle, expected: it sets the number
    of grains, so that the box is shorter than vortices need. most: of the grains.
    """
    number = min(_number(loss, packing, dimension), most)
    wanted = number / 2 * (warm + span * np.arange(INTERVALS + 1) / INTERVALS)
    counts = wanted.round().astype(int)
    observables: list[Observable] = ["kinetic_energy", "dissipated_energy", "collisions"]
    if friction:
        observables.append("rotational_energy")
    times, kinetic, rotational = [], [], []
    for start in range(STARTS):
        seed = laboratory.seed(str(start))
        scene = Scene(
            name="cooling",
            dimension=dimension,  # type: ignore[arg-type]
            duration=_FOR_EVER,
            hard_spheres=HardSpheres(restitution=alpha, friction=friction),
            box=Box(packing_fraction=packing),
            initial=Lattice(
                kind="lattice",
                structure=_LATTICES[dimension],  # type: ignore[arg-type]
                number=number,
                temperature=1.0,
                seed=seed,
            ),
            output=Output(collisions=tuple(counts.tolist()), observables=tuple(observables)),
        )
        run = laboratory.run(scene, EVENT_DRIVEN)
        spin = run["rotational_energy"] if friction else np.zeros_like(run["kinetic_energy"])
        times.append(run["time"][1:])
        kinetic.append((run["kinetic_energy"] - spin)[1:])
        rotational.append(spin[1:])
    freedoms = dimension * (number - 1)
    turning = rotational_freedoms(dimension) * number
    return Cooling(
        number,
        np.array(times),
        2 * np.array(kinetic) / freedoms,
        2 * np.array(rotational) / turning,
        2 * counts / number,
    )
