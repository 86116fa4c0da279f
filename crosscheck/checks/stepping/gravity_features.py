"""Scenes of gravity in which every pair of features occurs: each judged by sums over all pairs, step by step.

`FACTORS` are the features with their levels, the first one of each its absence; `rows` combines them.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from crosscheck.checks.base import Check, FeatureRows
from crosscheck.checks.stepping.audit import Features, audit_rows, parts_of
from crosscheck.checks.stepping.faults import gravity_fault
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.pairs import Pair, Row
from crosscheck.scene import Gravity, Scene, explicit

#: Features of scenes of gravity and their levels.
FACTORS: dict[str, tuple[str, ...]] = {
    "dimension": ("3", "2"),
    "masses": ("1", "equal", "unlike", "unlike, two of them 0"),
    "G": ("1", "0.37"),
    "softening": ("none", "0.8"),
    # as many as codes of few bodies have, and more than a few cache lines hold
    "bodies": ("5", "2", "80"),
    "place": ("about the origin", "elsewhere"),
}
#: Number of variants.
CHUNKS = 2


def scene_of(row: Row, seed: int) -> Scene:
    """The scene of a row, without what it records. row: of `rows`. seed: of the places, velocities and masses."""
    rng = np.random.default_rng(seed)
    number, d = int(row["bodies"]), int(row["dimension"])
    unlike = rng.uniform(0.2, 3.0, number)
    if row["masses"].endswith("0"):
        unlike[[0, number - 2]] = 0.0
    masses: Any = {"1": 1.0, "equal": 2.3}.get(row["masses"], tuple(unlike.tolist()))
    x = 2.5 * rng.normal(size=(number, d)) + (0.0 if row["place"] == "about the origin" else 17.3)
    return Scene(
        name="pairs-of-features",
        dimension=d,  # type: ignore[arg-type]
        duration=0.0,
        masses=masses,
        gravity=Gravity(G=float(row["G"]), softening=None if row["softening"] == "none" else float(row["softening"])),
        initial=explicit(x, rng.normal(size=x.shape)),
    )


def _valid(row: Row) -> bool:
    return not (row["bodies"] == "2" and row["masses"].endswith("0"))


FEATURES = Features(FACTORS, _valid, scene_of, dt=0.02, steps=3, seed=2)


def rows() -> tuple[list[Row], set[Pair]]:
    """Rows in which every pair of levels occurs, and the pairs that no scene has: two bodies, both without mass."""
    return FEATURES.rows


CHECKS = (
    Check(
        name="stepping/gravity-features",
        title="Gravity with every pair of features: energies, virial, forces and steps",
        equation="phi = -G m_i m_j/sqrt(r^2 + s^2), W = sum r_ij . F_ij, by sums over all pairs; m_i a_i = F_i",
        criterion="each within bounds of rounding: of terms and sums, and of velocity Verlet in doubles",
        citation="Aarseth, MNRAS 126, 223 (1963); Higham, Accuracy and Stability of Numerical Algorithms (2002), ch. 4",
        judge=audit_rows,
        variants=parts_of(FEATURES, CHUNKS),
        faults=(
            (
                "rows-1",
                Fault(
                    "softened-virial",
                    "stepping/kernels/gravity.py",
                    "virial_i += per_mass * (square / softened)",
                    "virial_i += per_mass",
                    "the virial of softened bodies is their energy",
                ),
            ),
            (
                "rows-1",
                gravity_fault(
                    "softening-length-for-square",
                    "square += softening * softening",
                    "square += softening",
                    "the softening is added where its square should be",
                ),
            ),
        ),
        needs=Needs("gravity"),
        interpreted=True,
        features=FeatureRows(FACTORS, rows),
    ),
)
