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
    """Forces, energy and virial of one configuration.

    forces: (N, d). energy: of all pairs. virial: sum over pairs of r . F.
    """

    forces: Floats
    energy: float
    virial: float

    @classmethod
    def of(cls, run: Run) -> Static:
        """Those of the start of `run`, whose scene asks for forces, energy and virial."""
        return cls(run["forces"], run["potential_energy"][0], run["virial"][0])

    @classmethod
    def summed(cls, sums: PairSum) -> Static:
        """Those of `sums`, a direct pair sum."""
        return cls(sums.forces, sums.energy, sums.virial)


def compare(measured: Static, other: Static, sums: PairSum, against: str) -> Findings:
    """Largest differences of forces, energy and virial, each relative to the sum of its terms' sizes.

    measured: of the engine under judgement. other: that it is compared with. sums: a direct pair sum, which gives the
    sizes. against: the name of `other`, in words.
    """
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
