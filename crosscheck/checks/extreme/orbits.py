"""Gravity at its extremes: an eccentricity of 0.999, a fall into a collision, masses of 1 : 1e12, and few bodies."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

from crosscheck.checks.extreme.matrix import (
    SENTENCE,
    Answer,
    Bound,
    Case,
    Expected,
    Measured,
    Trial,
    Value,
    extreme_check,
    for_each,
)
from crosscheck.checks.stepping.orbits import ORBITS, PERIOD, SIGMAS, WHY_ROUNDING
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references import EPSILON, kepler
from crosscheck.references.radial_orbit import collision_time, separation
from crosscheck.scene import Explicit, Gravity, Kepler, Output, Scene, explicit

#: Schemes that keep the angular momentum exactly, but for rounding; all with the modified energy of kick-drift-kick.
_SYMPLECTIC = ("velocity_verlet", "leapfrog")
_ADAPTIVE = "ias15"
_PLANE = frozenset({"dimension=2"})
_LONG = Needs("gravity", words=frozenset({"dimension=2", "gravity.G", "masses[]"}), promises=("long_runs",))

# -- an eccentricity of 0.999 ------------------------------------------------------------------------------------------

#: Eccentricity, steps a radian at pericentre, masses and G: a = 2 and mu = a^3, so that the period is 2 pi.
_E, _PER_RADIAN, _MASSES, _G, _A = 0.999, 10.0, (3.0, 1.0), 2.0, 2.0
_MU = _G * sum(_MASSES)
#: Steps of the period.
_STEPS = int(np.ceil(PERIOD * _PER_RADIAN * kepler.fastest(_E)))
_ENERGY, _MOMENTUM = "change of the energy over a period, over |E|", "change of the angular momentum, over L"
_PLACE = "error of the place after a period, in semi-major axes"


def _eccentric(trial: Trial, steps: int) -> Mapping[str, float]:
    scene = Scene(
        name="kepler-e0.999",
        dimension=2,
        duration=PERIOD,
        masses=_MASSES,
        gravity=Gravity(G=_G),
        initial=Kepler(kind="kepler", semi_major_axis=_A, eccentricity=_E),
        output=Output(interval=PERIOD, trajectory=True),
    )
    run = trial.laboratory.run(scene, trial.how(PERIOD / steps), interpreted=False)
    r, v = kepler.relative(run["positions"]), kepler.relative(run["velocities"])
    energy, momentum = kepler.energy(r, v, _MU), kepler.angular_momentum(r, v)
    return {
        _ENERGY: float(abs(energy[-1] / energy[0] - 1)),
        _MOMENTUM: float(abs(momentum[-1] / momentum[0] - 1)),
        _PLACE: float(np.linalg.norm(r[-1] - r[0]) / _A),
    }


def _expected_eccentric() -> tuple[Expected, ...]:
    """Of leap-frog steps: what turns the apsides moves the place at apocentre by a (1 + e) times the angle.

    H_2 is the same at both apocentres, and what remains of the energy's change is rounding.
    """
    moved = (1 + _E) * abs(kepler.precession(_E, PERIOD / _STEPS)) * PERIOD
    return (
        Bound(_ENERGY, SIGMAS * kepler.energy_rounding(_E, 1.0, _STEPS), WHY_ROUNDING),
        Bound(_MOMENTUM, SIGMAS * kepler.momentum_rounding(_E, 1.0, _STEPS), WHY_ROUNDING),
        Value(
            _PLACE,
            moved,
            moved / _PER_RADIAN**2,
            "precession of the apsides under leap-frog steps; the next order of the angle of a step at pericentre",
            "order",
        ),
    )


#: Steps that the adaptive scheme takes at most, for its rounding; its step is its own.
_ADAPTIVE_STEPS = 1000
_EXPECTED_ADAPTIVE = (
    Bound(_ENERGY, SIGMAS * kepler.energy_rounding(_E, 1.0, _ADAPTIVE_STEPS), WHY_ROUNDING),
    Bound(_MOMENTUM, SIGMAS * kepler.momentum_rounding(_E, 1.0, _ADAPTIVE_STEPS), WHY_ROUNDING),
    Bound(_PLACE, SIGMAS * kepler.rounding_error(_E, 1.0, _ADAPTIVE_STEPS), WHY_ROUNDING),
)

# -- a fall ------------------------------------------------------------------------------------------------------------

#: Distance of two bodies of mass 1 at rest, G = 1: mu = 2; share of the fall that is followed; steps of it.
_HIGH, _SHARE, _FALL_STEPS = 2.0, 0.9, 2000
_FALL = _SHARE * collision_time(_HIGH, 2.0)
_DISTANCE = "distance at 0.9 of the fall"


def _falling(duration: float, softening: float | None = None) -> Scene:
    return Scene(
        name="fall",
        dimension=2,
        duration=duration,
        gravity=Gravity(G=1.0, softening=softening),
        initial=Explicit(positions=((-_HIGH / 2, 0.0), (_HIGH / 2, 0.0))),
        output=Output(interval=duration, trajectory=True),
    )


def _fall(trial: Trial) -> Mapping[str, float]:
    run = trial.run(_falling(_FALL), _FALL / _FALL_STEPS)
    return {_DISTANCE: float(np.linalg.norm(kepler.relative(run["positions"])[-1]))}


def _fallen(order: int) -> Value:
    """The distance there; the error of `order` of the step, over the shortest time scale, (r^3/mu)^(1/2)."""
    distance = separation(_FALL, _HIGH, 2.0)
    step = _FALL / _FALL_STEPS / (distance**3 / 2.0) ** 0.5
    tolerance = _HIGH * max(step**order, 64 * EPSILON * _FALL_STEPS)
    return Value(_DISTANCE, distance, tolerance, f"order {order} in dt over (r^3/mu)^(1/2) at the end", "order")


_OFF_LINE, _OFF_CENTRE = "largest distance from their line", "largest momentum of both, over that of one"


def _through(trial: Trial) -> Mapping[str, float]:
    """On beyond the collision, which no step resolves: what the two have then is no answer, but for symmetry."""
    duration = collision_time(_HIGH, 2.0) / _SHARE
    run = trial.run(_falling(duration).changed(output=Output(interval=duration / 50, trajectory=True)), duration / 2000)
    v = run["velocities"]
    return {
        _OFF_LINE: float(abs(run["positions"][:, :, 1]).max()),
        _OFF_CENTRE: float(np.linalg.norm(v.sum(axis=1), axis=1).max() / np.linalg.norm(v, axis=2).max()),
    }


_SOFT, _SOFT_STEPS = 0.25, 4000
_KEPT = "change of the energy, softened, after many passages, over |E|"


def _softened(trial: Trial) -> Mapping[str, float]:
    """Through the centre again and again."""
    duration = 20 * collision_time(_HIGH, 2.0)
    run = trial.run(_falling(duration, _SOFT), duration / _SOFT_STEPS)
    kinetic = 0.5 * (run["velocities"] ** 2).sum(axis=(1, 2))
    apart = np.linalg.norm(kepler.relative(run["positions"]), axis=1)
    energy = kinetic - 1 / np.sqrt(apart**2 + _SOFT**2)
    return {_KEPT: float(abs(energy[-1] / energy[0] - 1))}


#: omega dt of the softened passage, omega^2 = mu/softening^3, and the depth of the well over |E| at the start.
_SOFT_STEP = 20 * collision_time(_HIGH, 2.0) / _SOFT_STEPS * (2.0 / _SOFT**3) ** 0.5
_SOFT_DEPTH = (1 / _SOFT) / (1 / (_HIGH**2 + _SOFT**2) ** 0.5)

# -- masses ------------------------------------------------------------------------------------------------------------

_ROUND = 400
_LIGHT, _HEAVY = "path of the lighter body, largest error in semi-major axes", "path of the heavier one, over its own"
_CENTRE = "momentum of both, largest, over that of one"


def _unlike(trial: Trial, masses: tuple[float, float], steps: int) -> Mapping[str, float]:
    """A circular orbit with n = 1, a = 1."""
    scene = Scene(
        name="unlike",
        dimension=2,
        duration=PERIOD,
        masses=masses,
        gravity=Gravity(G=1 / sum(masses)),
        initial=Kepler(kind="kepler", eccentricity=0.0),
        output=Output(interval=PERIOD / 8, trajectory=True),
    )
    run = trial.run(scene, PERIOD / steps)
    exact, _ = kepler.two_bodies(run["time"], masses, 0.0, 1.0, 1 / sum(masses))
    light, heavy = int(np.argmin(masses)), int(np.argmax(masses))
    error = np.linalg.norm(run["positions"] - exact, axis=2).max(axis=0)
    momenta = np.array(masses)[:, None] * run["velocities"]
    return {
        _LIGHT: float(error[light]),
        _HEAVY: float(error[heavy] / np.linalg.norm(exact[0, heavy])),
        _CENTRE: float(np.linalg.norm(momenta.sum(axis=1), axis=1).max() / np.linalg.norm(momenta[0, 0])),
    }


def _expected_unlike(error: float, why: str, steps: float) -> tuple[Expected, ...]:
    return (
        Bound(_LIGHT, error, why),
        Bound(_HEAVY, error, why),
        Bound(_CENTRE, 8 * EPSILON * steps, "roundings of both velocities at each step, at worst all alike"),
    )


#: The discrete circle of radius a has the rate n (1 + (n dt)^2/24) and the speed n a (1 - (n dt)^2/8): a start with
#: n a is at the pericentre of an orbit with e = (n dt)^2/4, whose rate is less by 3/8 (n dt)^2.
_CIRCLE = (2 * np.pi / 3 + 0.5) * (PERIOD / _ROUND) ** 2
_WHY_CIRCLE = "leap-frog on a circle: late by (n dt)^2/3 a radian, on an orbit of eccentricity (n dt)^2/4"


def _answered(trial: Trial, positions: tuple[tuple[float, float], ...]) -> Measured:
    """What is said of a start."""
    answer, _ = trial.answer(
        lambda: Scene(
            name="start", dimension=2, duration=1.0, gravity=Gravity(), initial=Explicit(positions=positions)
        ),
        0.125,
    )
    return Measured({}, answer)


def _alone(trial: Trial) -> Mapping[str, float]:
    """One body flies on: places short in base two have no rounding."""
    start, speed = np.array([[0.5, 0.25]]), np.array([[1.0, -0.5]])
    scene = Scene(
        name="alone",
        dimension=2,
        duration=8.0,
        gravity=Gravity(),
        initial=explicit(start, speed),
        output=Output(interval=1.0, trajectory=True),
    )
    run = trial.run(scene, 0.125)
    return {_PATH: float(abs(run["positions"][:, 0] - start - run["time"][:, None] * speed).max())}


_PATH = "largest distance from the straight path"
_RATIOS = {"1e-12": (1.0, 1e-12), "1e12": (1.0, 1e12)}

CHECKS = (
    extreme_check(
        "orbits",
        "Gravity at its extremes: e = 0.999, a fall into a collision, masses of 1 : 1e12, few bodies",
        "r'' = -mu r/|r|^3;  radial: r = r_0 cos^2 x, t = (r_0^3/(2 mu))^(1/2) (x + sin x cos x)",
        ORBITS,
        (
            Case(
                "kepler-e0.999",
                f"e = 0.999, one period, {_PER_RADIAN:g} steps a radian at pericentre: {_STEPS} steps",
                lambda trial: _eccentric(trial, _STEPS),
                for_each(_SYMPLECTIC, *_expected_eccentric()),
                "full",
                _LONG,
            ),
            Case(
                "kepler-e0.999-adaptive",
                "e = 0.999, one period, steps of the scheme's own",
                lambda trial: _eccentric(trial, _ADAPTIVE_STEPS),
                for_each((_ADAPTIVE,), *_EXPECTED_ADAPTIVE),
                needs=_LONG,
            ),
            Case(
                "fall",
                "two bodies fall from rest towards their collision, for 0.9 of the time",
                _fall,
                {**for_each(_SYMPLECTIC, _fallen(2)), _ADAPTIVE: (_fallen(15),)},
            ),
            Case(
                "fall-through",
                "the same, without softening, on beyond their collision by a tenth of the time",
                _through,
                for_each(
                    (*_SYMPLECTIC, _ADAPTIVE),
                    Value(_OFF_LINE, 0.0, EPSILON, "nothing pulls them off it: not one rounding"),
                    Value(_OFF_CENTRE, 0.0, 2 * EPSILON, "equal and opposite velocities, each rounded alike"),
                ),
            ),
            Case(
                "fall-softened",
                f"the same, softened by {_SOFT / _HIGH:g} of the distance, through the centre again and again",
                _softened,
                for_each(
                    _SYMPLECTIC,
                    Bound(
                        _KEPT,
                        _SOFT_STEP**2 * _SOFT_DEPTH,
                        "second order in omega dt at the centre, times the depth there over |E|",
                    ),
                ),
                needs=Needs("gravity", words=frozenset({"gravity.softening"})),
            ),
            *(
                Case(
                    f"mass-ratio-{name}",
                    f"two bodies of masses {masses[0]:g} and {masses[1]:g} on a circle, {_ROUND} steps a period",
                    partial(_unlike, masses=masses, steps=_ROUND),
                    {
                        **for_each(_SYMPLECTIC, *_expected_unlike(_CIRCLE, _WHY_CIRCLE, _ROUND)),
                        _ADAPTIVE: _expected_unlike(
                            SIGMAS * kepler.rounding_error(0.0, 1.0, _ROUND), WHY_ROUNDING, _ROUND
                        ),
                    },
                    needs=Needs("gravity", words=frozenset({"masses[]", "gravity.G"})),
                )
                for name, masses in _RATIOS.items()
            ),
            Case(
                "one-place",
                "two bodies in one place",
                lambda trial: _answered(trial, ((1.0, 1.0),) * 2),
                for_each(
                    (*_SYMPLECTIC, _ADAPTIVE),
                    Answer("refused: particles 0 and 1 are at the same place: move one of them", SENTENCE),
                ),
            ),
            Case(
                "no-particle",
                "N = 0",
                lambda trial: _answered(trial, ()),
                for_each(
                    (*_SYMPLECTIC, _ADAPTIVE),
                    Answer("refused: scene: initial.positions is empty: give at least one particle", SENTENCE),
                ),
            ),
            Case(
                "alone",
                "N = 1",
                _alone,
                for_each(
                    (*_SYMPLECTIC, _ADAPTIVE),
                    Value(_PATH, 0.0, 64 * 8 * EPSILON, "a rounding of a place of 8 at each step, at worst all alike"),
                ),
            ),
        ),
        Needs("gravity", words=_PLANE, observables=frozenset({"positions", "velocities"})),
        (
            (
                "fall/leapfrog",
                Fault(
                    "half-the-kick",
                    "stepping/schemes.py",
                    "v_ahead = v_behind + dt * accelerate(force, r, v_behind)",
                    "v_ahead = v_behind + 0.9999 * dt * accelerate(force, r, v_behind)",
                    "leap-frog's kicks are a part in 1e4 too weak",
                ),
            ),
            (
                "fall-through/velocity_verlet",
                Fault(
                    "push-back-a-little-stronger",
                    "stepping/forces/gravity.py",
                    "a[q] -= from_i * dx",
                    "a[q] -= 1.000000000001 * from_i * dx",
                    "of a pair, one body is attracted a part in 1e12 more than the other",
                ),
            ),
        ),
    ),
)
