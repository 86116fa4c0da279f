"""Stiff springs: damping far beyond critical, and two time scales in one scene; and scenes of 0 to 3 particles."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

from crosscheck.checks.base import Tier
from crosscheck.checks.extreme.matrix import (
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
from crosscheck.checks.stepping.faults import scheme_fault
from crosscheck.checks.stepping.springs import LITERATURE
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.references.oscillator import numerical_solution
from crosscheck.references.stability import ROUNDINGS, steps_of
from crosscheck.scene import Explicit, Output, Scene, Spring, explicit

#: All schemes whose steps are known in closed form.
_SCHEMES = (
    "euler", "modified_euler", "symplectic_euler", "verlet", "leapfrog", "velocity_verlet", "beeman", "beeman_pc",
    "euler_pc", "gear2", "gear3", "gear4", "gear4_velocity", "gear5", "gear5_velocity", "gear4_zero_start",
    "gear5_zero_start",
)  # fmt: skip

# -- damping far beyond critical ---------------------------------------------------------------------------------------

#: gamma dt/m of a step that is far beyond any limit, and steps of it: no double overflows yet. (omega0 dt)^2 = 1/16.
_DAMPED, _STEP, _STEPS = 1e4, 0.25, 12
#: So many steps that no double holds the motion.
_BEYOND = 200
_SILENT = "runs that do not say that they diverged"
_AFTER = "samples with numbers after the first without"
_ERROR = "largest error of a state over its rounding"


def _damped(steps: int) -> Scene:
    """k = m = 1."""
    return Scene(
        name="over-damped",
        dimension=1,
        duration=steps * _STEP,
        spring=Spring(k=1.0, gamma=_DAMPED / _STEP),
        initial=Explicit(positions=((1.0,),), velocities=((0.7,),)),
        output=Output(interval=_STEP, trajectory=True),
    )


def _over_damped(trial: Trial) -> Mapping[str, float]:
    """The scheme's own steps, far from the motion, must be exactly its own; then so many that no double holds them."""
    run = trial.run(_damped(_STEPS), _STEP)
    h = np.array([_STEP])
    exact = steps_of(trial.method, h, _DAMPED / (2 * h), np.ones(1), 0.7 * h, _STEPS)
    r, u = run["positions"][:, 0], run["velocities"][:, 0] * _STEP
    shares = abs(r - exact.r)[1:] / exact.r_error[1:], abs(u - exact.u)[1:] / exact.u_error[1:]
    beyond = trial.run(_damped(_BEYOND), _STEP, may_end_early=True)
    finite = np.isfinite(beyond["positions"][:, 0, 0]) & np.isfinite(beyond["velocities"][:, 0, 0])
    first = int(np.argmin(finite))
    return {
        _ERROR: float(np.maximum(*shares).max()),
        _SILENT: float(not beyond.diverged),
        _AFTER: float(np.count_nonzero(finite[first:])),
    }


_EXPECTED_DAMPED = (
    Bound(_ERROR, 1.0, "roundings of the terms of each step, carried on by powers of the step matrix"),
    Bound(_SILENT, 0.0, f"it grows by gamma dt/m or more a step, and no double holds {_BEYOND} of them"),
    Bound(_AFTER, 0.0, "nothing is known from there on"),
)

#: gamma of a spring of k = m = 1, whose rates are as 1 to 1e4; time step and time.
_GAMMA, _DT, _TIME = 100.0, 1e-3, 300.0
_RATE = "slow rate, from the second half of the run"


def _slow_rate() -> float:
    """The smaller root of s^2 - gamma s + 1 = 0."""
    return 2.0 / (_GAMMA + (_GAMMA**2 - 4.0) ** 0.5)


def _creeping(trial: Trial) -> Mapping[str, float]:
    """ln of the ratio of places at the middle and at the end, over the time between."""
    scene = Scene(
        name="creeping",
        dimension=1,
        duration=_TIME,
        spring=Spring(k=1.0, gamma=_GAMMA),
        initial=Explicit(positions=((1.0,),), velocities=((0.0,),)),
        output=Output(interval=_TIME / 2, trajectory=True),
    )
    run = trial.laboratory.run(scene, trial.how(_DT), interpreted=False)
    return {_RATE: float(np.log(run["positions"][1, 0, 0] / run["positions"][2, 0, 0]) / (_TIME / 2))}


# -- two time scales in one scene --------------------------------------------------------------------------------------

#: Masses of two springs of k = 1, whose frequencies are as 1 to 1e4; omega0 dt of the fast one; steps.
_MASSES, _FAST, _MANY, _MORE = (1.0, 1e-8), 0.1, 3000, 300_000


def _scales(trial: Trial, steps: int, compiled: bool) -> Mapping[str, float]:
    """Both springs beside the scheme's exact numerical solution for each, in units of their amplitudes."""
    dt = _FAST * _MASSES[1] ** 0.5
    omega = np.array(_MASSES) ** -0.5
    scene = Scene(
        name="two-scales",
        dimension=1,
        duration=steps * dt,
        masses=_MASSES,
        spring=Spring(k=1.0),
        initial=explicit(np.ones((2, 1)), 0.7 * omega[:, None]),
        output=Output(interval=steps // 100 * dt, trajectory=True),
    )
    run = trial.laboratory.run(scene, trial.how(dt), interpreted=False if compiled else None)
    numbers = {}
    for number, name in enumerate(("slow", "fast")):
        own = float(omega[number])
        r, v = numerical_solution(trial.method, steps, dt, 1.0, 0.7 * own, own, 0.0)
        error = np.hypot(run["positions"][:, number, 0] - r[:: steps // 100],
                         (run["velocities"][:, number, 0] - v[:: steps // 100]) / own)  # fmt: skip
        numbers[f"largest error of the {name} spring, in amplitudes"] = float(error.max())
    return numbers


def _expected_scales(steps: int, lever: float) -> tuple[Value, ...]:
    """lever: how much a rounding of the position counts in the slow one's velocity, see `oscillator.rounding_lever`."""
    names = ("slow", "fast")
    why = f"{ROUNDINGS:g} roundings of half a unit at each of {steps} steps, at worst all alike"
    return tuple(
        Value(f"largest error of the {name} spring, in amplitudes", 0.0, ROUNDINGS * EPSILON * steps * factor, why)
        for name, factor in zip(names, (lever, 1.0), strict=True)
    )


# -- few particles -----------------------------------------------------------------------------------------------------

_PLACES = ((1.0, 0.5), (-0.25, 2.0), (0.75, -1.5))


def _few(trial: Trial, number: int) -> Mapping[str, float]:
    """Each of so many springs beside the same one alone: bits that differ."""

    def moved(places: tuple[tuple[float, float], ...]) -> np.ndarray:
        scene = Scene(
            name="few", dimension=2, duration=2.0, spring=Spring(k=1.0), initial=Explicit(positions=places),
            output=Output(interval=0.1, trajectory=True),
        )  # fmt: skip
        run = trial.run(scene, 0.1)
        return np.concatenate([run["positions"], run["velocities"]], axis=2)

    together = moved(_PLACES[:number])
    alone = np.concatenate([moved((place,)) for place in _PLACES[:number]], axis=1)
    return {_BITS: float(np.count_nonzero(together != alone))}


def _none(trial: Trial) -> Measured:
    """A scene without a particle."""
    answer, _ = trial.answer(
        lambda: Scene(name="none", dimension=1, duration=1.0, spring=Spring(k=1.0), initial=Explicit(positions=())), 0.1
    )
    return Measured({}, answer)


_BITS = "numbers that differ from those of each particle alone"
_ALONE = Bound(_BITS, 0.0, "springs do not act on each other: the same arithmetic, bit for bit")
#: Schemes that keep the amplitude of an undamped oscillator at omega0 dt = 0.1.
_BOUNDED = ("symplectic_euler", "verlet", "leapfrog", "velocity_verlet", "beeman", "gear2", "gear3")
_LEVER = {"verlet": 1 / (_FAST * _MASSES[1] ** 0.5)}
_WHAT_SCALES = "springs of frequencies 1 : 1e4 in one scene, omega0 dt = 0.1 of the fast one"


def _scale_cases(name: str, steps: int, schemes: tuple[str, ...], tier: Tier) -> Case:
    """Two time scales over so many steps."""
    return Case(
        name,
        f"{_WHAT_SCALES}, {steps} steps",
        lambda trial: _scales(trial, steps, compiled=tier == "full"),
        {scheme: _expected_scales(steps, _LEVER.get(scheme, 1.0)) for scheme in schemes},
        tier,
        Needs("spring", words=frozenset({"masses[]"})),
    )


CHECKS = (
    extreme_check(
        "springs",
        "Stiff springs: damping far beyond critical, time scales 1 : 1e4, and scenes of no and few particles",
        "m r'' = -k r - gamma r'",
        LITERATURE,
        (
            Case(
                "over-damped-1e4",
                f"gamma dt/m = 1e4, (omega0 dt)^2 = 1/16: {_STEPS} steps, and {_BEYOND}",
                _over_damped,
                for_each(_SCHEMES, *_EXPECTED_DAMPED),
                needs=Needs("spring", words=frozenset({"spring.gamma"})),
            ),
            Case(
                "creeping",
                "gamma^2/(k m) = 1e4: rates 1 : 1e4, the fast one resolved by 10 steps, 3e5 steps",
                _creeping,
                for_each(
                    ("velocity_verlet", "leapfrog", "beeman_pc", "gear4_velocity"),
                    Value(
                        _RATE,
                        _slow_rate(),
                        _slow_rate() ** 2 * _DT,
                        "first order in the slow rate times dt: the least order of these schemes with damping",
                        "order",
                    ),
                ),
                "full",
                Needs("spring", words=frozenset({"spring.gamma"}), promises=("long_runs",)),
            ),
            _scale_cases("two-scales", _MANY, _BOUNDED, "quick"),
            _scale_cases("two-scales-long", _MORE, ("velocity_verlet", "leapfrog"), "full"),
            Case(
                "no-particle",
                "N = 0",
                _none,
                for_each(
                    ("velocity_verlet",),
                    Answer("refused: scene: initial.positions is empty: give at least one particle", SENTENCE),
                ),
            ),
            *(
                Case(
                    f"particles-{number}",
                    f"N = {number} springs beside each alone",
                    partial(_few, number=number),
                    for_each(("velocity_verlet", "gear5"), _ALONE),
                    needs=Needs("spring", words=frozenset({"dimension=2"})),
                )
                for number in (1, 2, 3)
            ),
        ),
        Needs("spring", words=frozenset({"dimension=1"}), observables=frozenset({"positions", "velocities"})),
        (
            (
                "over-damped-1e4/leapfrog",
                scheme_fault(
                    "leapfrog-damped-at-mean",
                    "v_ahead = v_behind + dt * accelerate(force, r, v_behind)",
                    "v_ahead = v_behind + dt * accelerate(force, r, 0.999 * v_behind)",
                    "leap-frog's damping is a part in a thousand too weak",
                ),
            ),
            (
                "two-scales/velocity_verlet",
                Fault(
                    "masses-of-the-first",
                    "stepping/forces/spring.py",
                    "float(masses.flat[0]) if one else masses",
                    "float(masses.flat[0])",
                    "every particle has the mass of the first",
                ),
            ),
        ),
    ),
)
