"""Scenes of springs in which every pair of features occurs: each judged by its closed sums, step by step.

`FACTORS` are the features with their levels, the first one of each its absence; `rows` combines them.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from crosscheck.checks.base import Check, FeatureRows
from crosscheck.checks.stepping.audit import Features, audit_rows, parts_of
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.pairs import Pair, Row
from crosscheck.scene import Scene, Spring, explicit

#: Features of scenes of springs and their levels.
FACTORS: dict[str, tuple[str, ...]] = {
    "dimension": ("1", "2", "3"),
    "masses": ("1", "equal", "unlike"),
    "friction": ("none", "0.3"),
    "particles": ("1", "4"),
}


def scene_of(row: Row, seed: int) -> Scene:
    """The scene of a row, without what it records. row: of `rows`. seed: of the places, velocities and masses."""
    rng = np.random.default_rng(seed)
    shape = int(row["particles"]), int(row["dimension"])
    masses: Any = {"1": 1.0, "equal": 2.3}.get(row["masses"], tuple(rng.uniform(0.2, 3.0, shape[0]).tolist()))
    return Scene(
        name="pairs-of-features",
        dimension=shape[1],  # type: ignore[arg-type]
        duration=0.0,
        masses=masses,
        spring=Spring(k=1.7, gamma=None if row["friction"] == "none" else float(row["friction"])),
        initial=explicit(rng.normal(size=shape), rng.normal(size=shape)),
    )


def _valid(row: Row) -> bool:
    return not (row["particles"] == "1" and row["masses"] == "unlike")


FEATURES = Features(FACTORS, _valid, scene_of, dt=0.15, steps=4, seed=3)


def rows() -> tuple[list[Row], set[Pair]]:
    """Rows in which every pair of levels occurs, and the pairs that no scene has: unlike masses of one particle."""
    return FEATURES.rows


CHECKS = (
    Check(
        name="stepping/spring-features",
        title="Springs with every pair of features: energies, virial, forces and steps",
        equation="U = k sum r^2/2, W = -k sum r^2, K = sum m v^2/2, F = -k r - gamma v; m_i a_i = F_i",
        criterion="each within bounds of rounding: of terms and sums, and of velocity Verlet in doubles",
        citation="Landau & Lifshitz, Mechanics, sections 10 and 25; Higham, Accuracy and Stability (2002), chapter 4",
        judge=audit_rows,
        variants=parts_of(FEATURES, 1),
        faults=(
            (
                "rows-0",
                Fault(
                    "spring-virial-sign",
                    "stepping/forces/spring.py",
                    "return 0.5 * squares, -squares",
                    "return 0.5 * squares, squares",
                    "the virial has the wrong sign",
                ),
            ),
        ),
        needs=Needs("spring"),
        interpreted=True,
        features=FeatureRows(FACTORS, rows),
    ),
)
