"""Soft grains at their extremes: deep overlaps, restitutions of 0 and nearly 1, steps beyond the contact."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import Literal

import numpy as np

from crosscheck.checks.extreme.matrix import (
    SENTENCE,
    Answer,
    Case,
    Expected,
    Measured,
    Trial,
    Value,
    extreme_check,
    for_each,
)
from crosscheck.checks.granular.soft_grains import CONTACTS, soft_needs
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.references.soft_impact import stiffness
from crosscheck.scene import Contact, HardSpheres, Output, Scene, explicit

_METHOD = ("velocity_verlet",)
_SPEED = "speed of parting"
Law = Literal["hooke", "hertz"]


def _pair(apart: float, approach: float, duration: float, alpha: float = 1.0) -> Scene:
    """Two disks of mass and diameter 1, their centres so far apart, that approach each other."""
    return Scene(
        name="pair",
        dimension=2,
        duration=duration,
        hard_spheres=HardSpheres(restitution=alpha),
        initial=explicit(
            np.array([[0.0, 0.0], [apart, 0.0]]), np.array([[0.5 * approach, 0.0], [-0.5 * approach, 0.0]])
        ),
        output=Output(interval=duration, trajectory=True),
    )


def _parting(velocities: np.ndarray) -> float:
    return float(velocities[1, 0] - velocities[0, 0])


# -- deep overlaps -----------------------------------------------------------------------------------------------------

_STIFFNESS, _STEP = 100.0, 2.0**-10


def _released(trial: Trial, overlap: float, law: Law) -> Mapping[str, float]:
    """From rest at an overlap until they are apart."""
    run = trial.run(_pair(1.0 - overlap, 0.0, 1.0), _STEP, Contact(law=law, stiffness=_STIFFNESS))
    return {_SPEED: _parting(run["final_velocities"])}


def _released_case(name: str, what: str, overlap: float, law: Law) -> Case:
    """The energy of the overlap: k d^2/2, "hertz" 2/5 k sqrt(R_eff) d^(5/2), in the relative motion of mass 1/2."""
    energy = 0.5 * _STIFFNESS * overlap**2 if law == "hooke" else 0.4 * _STIFFNESS * 0.25**0.5 * overlap**2.5
    # omega dt at the start: the tangent stiffness over the reduced mass
    tangent = _STIFFNESS if law == "hooke" else 1.5 * _STIFFNESS * (0.25 * overlap) ** 0.5
    step = _STEP * (2 * tangent) ** 0.5
    speed = (4 * energy) ** 0.5
    return Case(
        name,
        f"two disks at rest with an overlap of {what}, {law}",
        lambda trial: _released(trial, overlap, law),
        for_each(
            _METHOD,
            Value(_SPEED, speed, speed * step**2 / 4, "energy off by (omega dt)^2/4 at most, and half of it", "order"),
        ),
        needs=Needs("hard_spheres", words=frozenset({f"method.contact.law={law}"})),
    )


_TOO_DEEP = (
    "refused: particles 0 and 1 overlap by more than the smaller of their radii, 0.5: their centres are 0.25 apart, "
    "and their contact distance is 1 (gap -0.75): move one of them"
)

# -- restitutions ------------------------------------------------------------------------------------------------------

_DURATION, _APART, _APPROACH = 0.125, 1.25, 2.0
_LOST = "speed lost, beside an elastic pair, over the speed"
_FINE = 2.0**-10


def _nearly_elastic(trial: Trial) -> Mapping[str, float]:
    """Restitution 1 - 1e-12 beside 1, of contacts of one duration."""
    speeds = [
        _parting(
            trial.run(_pair(_APART, _APPROACH, 1.0, alpha), _FINE, Contact(duration=_DURATION))["final_velocities"]
        )
        for alpha in (1.0, 1 - 1e-12)
    ]
    return {_LOST: (speeds[0] - speeds[1]) / _APPROACH}


def _without_restitution(trial: Trial, resolution: bool) -> Measured:
    contact = Contact(stiffness=_STIFFNESS, resolution=0.05 if resolution else None)
    answer, _ = trial.answer(lambda: _pair(_APART, _APPROACH, 1.0, 0.0), None if resolution else _STEP, contact)
    return Measured({}, answer)


def _no_restitution(engine: str) -> Answer:
    words = "no spring with a dashpot gives a restitution of 0: restitution 0 needs an event-driven scheme"
    return Answer(f"refused: {engine}: {words}", SENTENCE)


_NO_RESOLUTION = "refused: method.contact.resolution needs a restitution above 0: give method.dt"

# -- steps as long as a contact ----------------------------------------------------------------------------------------


def _long_step(trial: Trial, steps: float) -> Measured:
    """One step from the first touch into the contact, one out of it; steps: dt/t_c."""
    dt = _DT
    answer, run = trial.answer(lambda: _pair(1.0 + _APPROACH * dt, _APPROACH, 8 * dt), dt, Contact(duration=dt / steps))
    return Measured({_SPEED: math.nan if run is None else _parting(run["final_velocities"])}, answer)


#: A step short in base two: the pair touches after one, and overlaps by _APPROACH dt after two.
_DT = 0.125


def _expected_long(steps: float, share: str, duration: str) -> tuple[Expected, ...]:
    """k = pi^2 m/(2 t_c^2): the velocity gains 2 k delta dt/m = pi^2 delta dt/t_c^2 in the one step."""
    gained = 2 * stiffness(1.0, 0.5, _DT / steps) * _APPROACH * _DT * _DT
    speed = gained - _APPROACH
    words = (
        f"remarked: method.dt = 0.125 is {share} of the shortest contact, {duration}: what a contact does needs more "
        "than 10 steps."
    )
    return (
        Value(_SPEED, speed, 32 * EPSILON * gained, "the scheme's own step, to 32 roundings of the velocity gained"),
        Answer(words, SENTENCE),
    )


_LONG = {"1": (1.0, "1", "0.125"), "2": (2.0, "2", "0.0625"), "100": (100.0, "1e+02", "0.00125")}

CHECKS = (
    extreme_check(
        "soft-grains",
        "Soft grains: overlaps of half a radius and more, restitutions of 0 and 1 - 1e-12, steps beyond the contact",
        "F = k delta - eta v_n;  m_eff v^2/2 = k delta^2/2;  v' = pi^2 delta dt/t_c^2 - v for one step in a contact",
        "Schaefer, Dippel & Wolf, J. Phys. I France 6, 5 (1996)",
        (
            _released_case("overlap-half-a-radius", "half a radius", 0.25, "hooke"),
            _released_case("overlap-a-radius", "a radius", 0.5, "hooke"),
            _released_case("overlap-half-a-radius-hertz", "half a radius", 0.25, "hertz"),
            Case(
                "overlap-more",
                "an overlap of 1.5 radii",
                lambda trial: Measured(
                    {}, trial.answer(lambda: _pair(0.25, 0.0, 1.0), _STEP, Contact(stiffness=_STIFFNESS))[0]
                ),
                for_each(_METHOD, Answer(_TOO_DEEP, SENTENCE)),
            ),
            Case(
                "restitution-nearly-1",
                f"restitution 1 - 1e-12, {_DURATION / _FINE:g} steps in a contact",
                _nearly_elastic,
                for_each(
                    _METHOD,
                    Value(
                        _LOST,
                        1e-12,
                        1e-12 * 2 * _FINE / _DURATION + 4 * EPSILON * _DURATION / _FINE,
                        "a step's share of the damping at either end, and four roundings of the velocity at each step",
                    ),
                ),
            ),
            Case(
                "restitution-0",
                "restitution 0",
                lambda trial: _without_restitution(trial, resolution=False),
                {
                    **for_each(_METHOD, _no_restitution("refimpl")),
                    "velocity_verlet@lammps": (_no_restitution("lammps"),),
                },
            ),
            Case(
                "restitution-0-resolution",
                "restitution 0, with a step that is to follow from the contact",
                lambda trial: _without_restitution(trial, resolution=True),
                for_each(_METHOD, Answer(_NO_RESOLUTION, SENTENCE)),
            ),
            *(
                Case(
                    f"step-of-{name}-contacts",
                    f"dt = {name} t_c: one step in the contact",
                    partial(_long_step, steps=steps),
                    for_each(_METHOD, *_expected_long(steps, share, duration)),
                )
                for name, (steps, share, duration) in _LONG.items()
            ),
        ),
        soft_needs("dimension=2 method.contact.stiffness method.contact.duration", "positions velocities"),
        (
            (
                "overlap-half-a-radius/velocity_verlet",
                Fault(
                    "no-overlap-above-a-fifth",
                    CONTACTS,
                    "        delta = radii[i] + radii[j] - distance\n",
                    "        delta = min(radii[i] + radii[j] - distance, 0.2)\n",
                    "two grains push no more than at an overlap of a fifth of a diameter",
                ),
            ),
        ),
    ),
)
