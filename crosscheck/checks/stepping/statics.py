"""Forces, energy and virial of one configuration, and how two of them compare."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.engines.protocol import Run
from crosscheck.references import EPSILON
from crosscheck.references.lennard_jones import PairSum
from crosscheck.scene import Floats
from crosscheck.verdict import Findings, round_off, worst


class Static(NamedTuple):
    """Forces (N, d), energy and virial."""

    forces: Floats
    energy: float
    virial: float

    @classmethod
    def of(cls, run: Run) -> Static:
        """Of a run that asked for its forces, at its start."""
        return cls(run["forces"], run["potential_energy"][0], run["virial"][0])

    @classmethod
    def summed(cls, sums: PairSum) -> Static:
        """Of a direct pair sum."""
        return cls(sums.forces, sums.energy, sums.virial)


def compare(measured: Static, other: Static, sums: PairSum, against: str) -> Findings:
    """Largest relative differences of forces, energy and virial, each relative to the sum of its terms' sizes."""
    scale = np.maximum(sums.force_scale, sums.force_scale.mean())[:, None]
    errors = {
        "force": float((abs(measured.forces - other.forces) / scale).max()),
        "energy": abs(measured.energy - other.energy) / sums.energy_scale,
        "virial": abs(measured.virial - other.virial) / sums.virial_scale,
    }
    return worst(
        [
            round_off(
                f"largest relative difference from {against}: {name}",
                error,
                2 * sums.sensitivity * EPSILON,
                "rounding of the coordinates, through f ~ r^-13, in each of the two",
            )
            for name, error in errors.items()
        ]
    )
