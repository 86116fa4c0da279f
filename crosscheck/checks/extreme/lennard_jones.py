"""Lennard-Jones particles in extreme places: at half a sigma, in one place, in boxes of two cutoffs and less; few."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Literal

import numpy as np

from crosscheck.checks.extreme.matrix import (
    RAN,
    SENTENCE,
    Answer,
    Bound,
    Case,
    Measured,
    Trial,
    Value,
    extreme_check,
    for_each,
)
from crosscheck.checks.stepping.fluids import LISTS, POTENTIAL
from crosscheck.checks.stepping.statics import Static
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.references.lennard_jones import pair_sum
from crosscheck.scene import Box, Explicit, LennardJones, Output, Scene

_METHOD = ("velocity_verlet",)
_CUTOFF = 2.5
_RECORD = ("kinetic_energy", "potential_energy", "virial")
_OPEN = frozenset({"dimension=3", "box.boundaries=open"})
_PERIODIC = frozenset({"dimension=3", "box.boundaries=periodic"})

# -- at half a sigma ---------------------------------------------------------------------------------------------------


def _potential(r: float) -> float:
    return 4 * (r**-12 - r**-6)


def _pull(r: float) -> float:
    """-d phi/dr."""
    return 24 * (2 * r**-12 - r**-6) / r


#: Distance at the start, a coarse step, a fine one, and the time in which the two are further apart than the cutoff.
_NEAR, _COARSE, _FINE, _TIME = 0.5, 2.0**-8, 2.0**-14, 2.0**-7
#: Cutoff of these two.
_REACH = 1.5
#: Stiffness at the start, phi'' = 4 (156 r^-14 - 42 r^-8), over the reduced mass 1/2: omega^2.
_OMEGA = (2 * 4 * (156 * _NEAR**-14 - 42 * _NEAR**-8)) ** 0.5
_ENERGY = _potential(_NEAR) - _potential(_REACH)
_KINETIC = "kinetic energy at the end, extrapolated to dt = 0"
_SHARE = "kinetic energy at the end, over the potential energy at the start"


def _pair(dt: float) -> Scene:
    """Two at rest, half a sigma apart, in open space."""
    return Scene(
        name="half-a-sigma",
        dimension=3,
        duration=_TIME,
        lennard_jones=LennardJones(cutoff=_REACH),
        initial=Explicit(positions=((0.0, 0.0, 0.0), (_NEAR, 0.0, 0.0))),
        output=Output(interval=_TIME, observables=_RECORD, trajectory=True),
    )


def _resolved(trial: Trial) -> Mapping[str, float]:
    """K(0) from the steps h and h/2: (4 K(h/2) - K(h))/3."""
    coarse, fine = (float(trial.run(_pair(dt), dt)["kinetic_energy"][-1]) for dt in (_FINE, _FINE / 2))
    return {_KINETIC: (4 * fine - coarse) / 3}


def _unresolved(trial: Trial) -> Measured:
    """One step flings them apart, by v = f dt/2 in units of m = 1: no force acts at its end."""
    answer, run = trial.answer(lambda: _pair(_COARSE), _COARSE)
    kinetic = np.nan if run is None else float(run["kinetic_energy"][-1])
    return Measured({_SHARE: kinetic / _potential(_NEAR)}, answer)


# -- boxes of two cutoffs and less, and few particles ------------------------------------------------------------------

_PLACES = ((0.3, 0.4, 0.2), (1.45, 0.6, 0.9), (0.7, 1.7, 1.3))


def _few(number: int, side: float | None, truncation: Literal["truncated", "force_shifted"] = "truncated") -> Scene:
    """So many particles at rest in a cube, or in open space."""
    return Scene(
        name="few",
        dimension=3,
        duration=0.0,
        lennard_jones=LennardJones(cutoff=_CUTOFF, truncation=truncation),
        box=None if side is None else Box(lengths=(side,) * 3),
        initial=Explicit(positions=_PLACES[:number]),
        output=Output(interval=1.0, observables=_RECORD, forces=True),
    )


_STATICS = ("force", "energy", "virial")


def _against_sums(trial: Trial, scene: Scene) -> Mapping[str, float]:
    """Largest differences from a direct sum over all images, over what rounding may do to them."""
    sums, found = pair_sum(scene), Static.of(trial.run(scene, 0.001))
    unit = 2 * sums.sensitivity * EPSILON
    # a particle alone has no terms: what is expected then is 0 itself
    scales = np.maximum(sums.force_scale, sums.force_scale.mean())[:, None], sums.energy_scale, sums.virial_scale
    errors = abs(found.forces - sums.forces), abs(found.energy - sums.energy), abs(found.virial - sums.virial)
    return {
        f"error of the {name}, over its rounding": float(np.max(error / (unit * scale + (np.asarray(scale) == 0))))
        for name, error, scale in zip(_STATICS, errors, scales, strict=True)
    }


_SUMMED = tuple(
    Bound(f"error of the {name}, over its rounding", 1.0, "rounding of the coordinates, through f ~ r^-13, of each sum")
    for name in _STATICS
)
#: Sides of boxes, by the names of cases, in cutoffs.
_BOXES = {"two-cutoffs": 2.0, "just-below-two-cutoffs": 2.0 * (1 - 2.0**-40), "two-fifths": 0.4}


def _alone(trial: Trial) -> Mapping[str, float]:
    """One particle flies on: places short in base two have no rounding."""
    scene = _few(1, None).changed(
        duration=8.0,
        initial=Explicit(positions=((0.5, 0.25, 1.0),), velocities=((1.0, -0.5, 0.25),)),
        output=Output(interval=1.0, trajectory=True),
    )
    run = trial.run(scene, 0.125)
    path = np.array([0.5, 0.25, 1.0]) + run["time"][:, None] * np.array([1.0, -0.5, 0.25])
    return {_PATH: float(abs(run["positions"][:, 0] - path).max())}


_PATH = "largest distance from the straight path"


def _answered(trial: Trial, positions: tuple[tuple[float, float, float], ...]) -> Measured:
    """What is said of a start."""
    answer, _ = trial.answer(
        lambda: Scene(
            name="start",
            dimension=3,
            duration=1.0,
            lennard_jones=LennardJones(cutoff=_CUTOFF),
            initial=Explicit(positions=positions),
        ),
        0.125,
    )
    return Measured({}, answer)


CHECKS = (
    extreme_check(
        "lennard-jones",
        "Lennard-Jones particles at half a sigma, in one place, in boxes of two cutoffs and less, and few",
        POTENTIAL,
        f"{LISTS}; sections 1.5.2-1.5.3",
        (
            Case(
                "half-a-sigma",
                "two at rest at r = sigma/2, energy 16128 epsilon, omega dt = 0.28 and 0.14",
                _resolved,
                for_each(
                    _METHOD,
                    Value(
                        _KINETIC,
                        _ENERGY,
                        _ENERGY * (_OMEGA * _FINE) ** 4 + 2 * _FINE * _ENERGY**0.5 * abs(_pull(_REACH)),
                        "what is left is of fourth order in omega dt, and a step's work of the force cut off",
                        "order",
                    ),
                ),
                needs=Needs("lennard_jones", words=_OPEN),
            ),
            Case(
                "half-a-sigma-one-step",
                "two at rest at r = sigma/2, omega dt = 18: one step to beyond the cutoff",
                _unresolved,
                for_each(
                    _METHOD,
                    Value(
                        _SHARE,
                        (_pull(_NEAR) * _COARSE / 2) ** 2 / _potential(_NEAR),
                        32 * EPSILON * (_pull(_NEAR) * _COARSE / 2) ** 2 / _potential(_NEAR),
                        "the scheme's own step, v = f dt/2, to 16 roundings of v",
                    ),
                    Answer(RAN, "the step is the scheme's own: that it is too large shows in the energy alone"),
                ),
                needs=Needs("lennard_jones", words=_OPEN),
            ),
            Case(
                "one-place",
                "two particles in one place",
                lambda trial: _answered(trial, ((1.0, 1.0, 1.0),) * 2),
                for_each(
                    _METHOD,
                    Answer("refused: particles 0 and 1 are at the same place: move one of them", SENTENCE),
                ),
            ),
            *(
                Case(
                    f"box-{name}",
                    f"three particles in a periodic cube of {share:.12g} cutoffs",
                    partial(_against_sums, scene=_few(3, share * _CUTOFF)),
                    for_each(_METHOD, *_SUMMED),
                    needs=Needs("lennard_jones", words=_PERIODIC),
                )
                for name, share in _BOXES.items()
            ),
            Case(
                "box-one-cutoff",
                "three particles in a periodic cube of one cutoff: own images are at the cutoff itself; force shifted",
                lambda trial: _against_sums(trial, _few(3, _CUTOFF, "force_shifted")),
                for_each(_METHOD, *_SUMMED),
                needs=Needs("lennard_jones", words=_PERIODIC | {"lennard_jones.truncation=force_shifted"}),
            ),
            Case(
                "no-particle",
                "N = 0",
                lambda trial: _answered(trial, ()),
                for_each(
                    _METHOD,
                    Answer("refused: scene: initial.positions is empty: give at least one particle", SENTENCE),
                ),
            ),
            Case(
                "alone",
                "N = 1 in open space",
                _alone,
                for_each(_METHOD, Value(_PATH, 0.0, EPSILON, "no rounding, of numbers short in base two")),
                needs=Needs("lennard_jones", words=_OPEN),
            ),
            *(
                Case(
                    f"particles-{number}",
                    f"N = {number} in a periodic cube of 1.2 cutoffs, and their images",
                    partial(_against_sums, scene=_few(number, 1.2 * _CUTOFF)),
                    for_each(_METHOD, *_SUMMED),
                    needs=Needs("lennard_jones", words=_PERIODIC),
                )
                for number in (1, 2, 3)
            ),
        ),
        Needs("lennard_jones", observables=frozenset({*_RECORD, "forces", "positions"}), schemes=_METHOD),
        (
            (
                "box-two-fifths/velocity_verlet",
                Fault(
                    "one-shell-of-images",
                    "stepping/kernels/neighbours.py",
                    "around = np.ceil((reach + 2 * rounding) * inverse) if side > 0 else 0.0",
                    "around = min(cells, np.ceil((reach + 2 * rounding) * inverse)) if side > 0 else 0.0",
                    "no images beyond the boxes next to that of the particles",
                ),
            ),
        ),
    ),
)
