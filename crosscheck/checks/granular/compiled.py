"""Soft grains compiled and as plain Python: the same bits.

The quick variants ask for what other quick checks ask for, so that no kernel is compiled for them alone.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, full, quick
from crosscheck.checks.both_modes import EQUATION, interpretable, same_bits
from crosscheck.checks.granular.soft_grains import soft_needs
from crosscheck.faults import Fault
from crosscheck.scene import (
    Box,
    Contact,
    Face,
    Friction,
    GrainFriction,
    HardSpheres,
    Method,
    Observable,
    Oscillation,
    Output,
    Scene,
    explicit,
)
from crosscheck.verdict import Judged, worst

_TALLIES: tuple[Observable, ...] = ("contact_time", "collisional_virial", "wall_impulse")
_BOUNDARIES: tuple[Literal["periodic", "hard"], ...] = ("periodic", "hard", "periodic")
_DT = 2e-3


class _Grains(NamedTuple):
    """Grains in two or three dimensions, smooth or rough; energies: whether they are measured at the samples."""

    dimension: int
    rough: bool
    energies: bool = False


def _scene(grains: _Grains, seed: int) -> Scene:
    """Eight grains of two kinds that fall onto a shaken floor."""
    d, rng = grains.dimension, np.random.default_rng(seed)
    places = np.array(list(np.ndindex(*(3,) * d))[:8]) * 1.05 + 0.6
    friction = GrainFriction(tangential_restitution=1.0, static=0.5, sliding=0.5) if grains.rough else None
    law = Friction(tangential_restitution=1.0, static=0.3, sliding=0.3) if grains.rough else None
    floor = Face(restitution=0.9, oscillation=Oscillation(amplitude=0.05, frequency=9.0, phase=0.3), friction=law)
    energies: tuple[Observable, ...] = ("kinetic_energy", "potential_energy") if grains.energies else ()
    return Scene(
        name="grains",
        dimension=d,  # type: ignore[arg-type]
        duration=40 * _DT,
        masses=(1.0, 2.0) * 4,
        species=(0, 1) * 4,
        acceleration=(0.0, -1.0, 0.0)[:d],
        hard_spheres=HardSpheres(diameter=(1.0, 0.9), restitution=0.8, friction=friction),
        box=Box(lengths=(4.0,) * d, boundaries=_BOUNDARIES[:d], faces={"y-": floor}),
        initial=explicit(places, 3 * rng.normal(size=places.shape)),
        output=Output(interval=10 * _DT, trajectory=True, observables=(*_TALLIES, *energies)),
    )


def _judge(laboratory: Laboratory, grains: _Grains) -> Judged:
    scene = _scene(grains, laboratory.seed())
    hooke = Contact(stiffness=2e3)
    hertz = Contact(law="hertz", stiffness=2e3)
    return worst(
        [
            same_bits(laboratory, scene, Method(scheme="velocity_verlet", dt=_DT, contact=contact), contact.law)
            for contact in (hooke, hertz)
        ],
        "40 steps of 8 grains",
    )


CHECKS = (
    Check(
        name="granular/compiled",
        title="Contacts of soft grains, compiled and as plain Python",
        equation=EQUATION,
        criterion="not one bit differs",
        citation="Cundall & Strack, Geotechnique 29, 47 (1979)",
        judge=_judge,
        variants=(
            *quick(
                **{
                    "smooth-disks": _Grains(2, False),
                    "rough-spheres": _Grains(3, True),
                }
            ),
            *full(
                **{
                    "rough-disks": _Grains(2, True),
                    "smooth-spheres": _Grains(3, False, True),
                    "energies": _Grains(2, True, True),
                }
            ),
        ),
        needs=interpretable(soft_needs("method.contact.law=hertz", " ".join(_TALLIES))),
        faults=(
            (
                "smooth-disks",
                Fault(
                    "fused-contacts",
                    "stepping/kernels/compiled.py",
                    'INTERNAL: dict[str, Any] = {"error_model": "numpy", ',
                    'INTERNAL: dict[str, Any] = {"error_model": "numpy", "fastmath": True, ',
                    "compiled code may reorder and fuse sums",
                ),
            ),
        ),
    ),
)
