"""The integrators' recurrences, from the literature, for any force and number type: what a run's steps must obey.

m r'' = f(r, v) from (r, v) at time 0. Each function gives positions and velocities after 0, 1, ... steps. They share
nothing with the implementation: Verlet is his two-step relation of the positions, Gear's predictor-corrector acts on
the derivatives themselves, not on Nordsieck's scaled ones.

Literature: L. Verlet, Phys. Rev. 159, 98 (1967); W. C. Swope, H. C. Andersen, P. H. Berens and K. R. Wilson, J. Chem.
Phys. 76, 637 (1982); D. Beeman, J. Comput. Phys. 20, 130 (1976); C. W. Gear, Numerical Initial Value Problems in
Ordinary Differential Equations, Prentice-Hall (1971); R. W. Hockney and J. W. Eastwood, Computer Simulation Using
Particles (1988), for leap-frog.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from math import factorial
from typing import Any, NamedTuple

import numpy as np

from crosscheck.references.oscillator import gear_corrector
from crosscheck.scene import Floats


class Problem(NamedTuple):
    """A problem m r'' = f(r, v).

    acceleration: f/m as a function of r and v, of any one shape. higher: the third and further time derivatives of r,
    as a function of r, v and their number; None: Gear's schemes take them as zero.
    """

    acceleration: Callable[[Floats, Floats], Floats]
    higher: Callable[[Floats, Floats, int], list[Floats]] | None = None


#: Positions and velocities, each (steps + 1, ...).
Path = tuple[Floats, Floats]


def _single(step: Callable[[Any, Any, Any, Any], tuple[Any, Any]]) -> Callable[[Problem, Any, Any, Any, int], Path]:
    """A scheme without memory. step: of (acceleration, r, v, dt)."""

    def path(problem: Problem, r: Any, v: Any, dt: Any, steps: int) -> Path:
        states = [(r, v)]
        for _ in range(steps):
            states.append(step(problem.acceleration, *states[-1], dt))
        return _stacked(states)

    return path


def _stacked(states: list[tuple[Any, Any]]) -> Path:
    positions, velocities = zip(*states, strict=True)
    return np.array(positions), np.array(velocities)


def _euler(a: Any, r: Any, v: Any, dt: Any) -> tuple[Any, Any]:
    kick = dt * a(r, v)
    return r + dt * (v + kick / 2), v + kick


def _modified_euler(a: Any, r: Any, v: Any, dt: Any) -> tuple[Any, Any]:
    kick = dt * a(r, v)
    return r + dt * (v + 3 * kick / 2), v + kick


def _symplectic_euler(a: Any, r: Any, v: Any, dt: Any) -> tuple[Any, Any]:
    kick = dt * a(r, v)
    return r + dt * (v + kick), v + kick


def _euler_pc(a: Any, r: Any, v: Any, dt: Any) -> tuple[Any, Any]:
    kick = dt * a(r + dt * v, v + dt * a(r, v))
    return r + dt * (v + kick), v + kick


def _verlet(problem: Problem, r: Any, v: Any, dt: Any, steps: int) -> Path:
    """r_{n+1} - 2 r_n + r_{n-1} = dt^2 a(r_n, (r_n - r_{n-1})/dt); at the start with the velocity given there."""
    kick = dt**2 * problem.acceleration(r, v)
    places = [r - dt * v + kick / 2, r, r + dt * v + kick / 2]
    for _ in range(steps):
        last, now = places[-2], places[-1]
        places.append(2 * now - last + dt**2 * problem.acceleration(now, (now - last) / dt))
    # places[n + 1] is r_n
    middle = [(places[n + 1], (places[n + 2] - places[n]) / (2 * dt)) for n in range(1, steps + 1)]
    return _stacked([(r, v), *middle])


def _leapfrog(problem: Problem, r: Any, v: Any, dt: Any, steps: int) -> Path:
    """v_{n+1/2} - v_{n-1/2} = dt a(r_n, v_{n-1/2}); r_{n+1} - r_n = dt v_{n+1/2}; v_n the mean of its neighbours."""
    half = v + dt * problem.acceleration(r, v) / 2
    states = [(r, v)]
    for _ in range(steps):
        r = r + dt * half
        kick = dt * problem.acceleration(r, half)
        states.append((r, half + kick / 2))
        half = half + kick
    return _stacked(states)


def _velocity_verlet(problem: Problem, r: Any, v: Any, dt: Any, steps: int) -> Path:
    """r_{n+1} = r_n + dt v_n + dt^2 a_n/2, v_{n+1} = v_n + dt (a_n + a_{n+1})/2, a_{n+1} at the half-step velocity."""
    a, states = problem.acceleration(r, v), [(r, v)]
    for _ in range(steps):
        r = r + dt * v + dt**2 * a / 2
        ahead = problem.acceleration(r, v + dt * a / 2)
        v, a = v + dt * (a + ahead) / 2, ahead
        states.append((r, v))
    return _stacked(states)


def _drift_kick_drift(problem: Problem, r: Any, v: Any, dt: Any, steps: int) -> Path:
    """r_{n+1/2} = r_n + dt v_n/2; v_{n+1} = v_n + dt a(r_{n+1/2}); r_{n+1} = r_{n+1/2} + dt v_{n+1}/2."""
    states = [(r, v)]
    for _ in range(steps):
        middle = r + dt * v / 2
        v = v + dt * problem.acceleration(middle, v)
        r = middle + dt * v / 2
        states.append((r, v))
    return _stacked(states)


def _beeman(predicted: bool) -> Callable[[Problem, Any, Any, Any, int], Path]:
    """r_{n+1} = r_n + dt v_n + dt^2 (4 a_n - a_{n-1})/6; v_{n+1} = v_n + dt (2 a_{n+1} + 5 a_n - a_{n-1})/6.

    The force at the new place gets v_n, or the predicted v_n + dt (3 a_n - a_{n-1})/2; a_{-1} is that of an Euler step
    backwards.
    """

    def path(problem: Problem, r: Any, v: Any, dt: Any, steps: int) -> Path:
        a = problem.acceleration(r, v)
        before = problem.acceleration(r - dt * (v - dt * a / 2), v - dt * a)
        states = [(r, v)]
        for _ in range(steps):
            r = r + dt * v + dt**2 * (2 * a / 3 - before / 6)
            seen = v + dt * (3 * a - before) / 2 if predicted else v
            ahead = problem.acceleration(r, seen)
            v = v + dt * (ahead / 3 + 5 * a / 6 - before / 6)
            before, a = a, ahead
            states.append((r, v))
        return _stacked(states)

    return path


def _gear(scheme: str) -> Callable[[Problem, Any, Any, Any, int], Path]:
    """Derivatives y_q predicted by Taylor's series, corrected by alpha_q (q!/dt^q) (dt^2/2) (a - y_2) (Gear 1971)."""

    def path(problem: Problem, r: Any, v: Any, dt: Any, steps: int) -> Path:
        corrector, analytic = gear_corrector(scheme)
        size = len(corrector)
        y = [r, v, problem.acceleration(r, v)]
        more = problem.higher(r, v, size - 3) if analytic and problem.higher is not None else []
        y += more if more else [np.zeros_like(r)] * (size - 3)
        states = [(r, v)]
        for _ in range(steps):
            y = [sum(y[k] * dt ** (k - q) / factorial(k - q) for k in range(q, size)) for q in range(size)]
            miss = problem.acceleration(y[0], y[1]) - y[2]
            for q, alpha in enumerate(corrector):
                weight: Fraction = alpha * factorial(q) / 2
                y[q] = y[q] + miss * dt ** (2 - q) * weight.numerator / weight.denominator
            states.append((y[0], y[1]))
        return _stacked(states)

    return path


_SINGLE = {
    "euler": _euler,
    "modified_euler": _modified_euler,
    "symplectic_euler": _symplectic_euler,
    "euler_pc": _euler_pc,
}
_GEARS = (
    *("gear2", "gear3", "gear4", "gear4_velocity", "gear5", "gear5_velocity"),
    *("gear4_zero_start", "gear5_zero_start"),
)
#: The maps that go by the name of a scheme, of which one must be the engine's.
MAPS: dict[str, tuple[Callable[[Problem, Any, Any, Any, int], Path], ...]] = {
    **{name: (_single(step),) for name, step in _SINGLE.items()},
    **{name: (_gear(name),) for name in _GEARS},
    "verlet": (_verlet,),
    "leapfrog": (_leapfrog, _drift_kick_drift),
    "velocity_verlet": (_velocity_verlet,),
    "beeman": (_beeman(predicted=False),),
    "beeman_pc": (_beeman(predicted=True),),
}


class Solution(NamedTuple):
    """Where a map leads. positions, velocities: (steps + 1, ...) each. evaluations: of the acceleration."""

    positions: Floats
    velocities: Floats
    evaluations: int


def solutions(scheme: str, problem: Problem, r: Floats, v: Floats, dt: float, steps: int) -> list[Solution]:
    """Positions and velocities by every map that goes by the name of the scheme.

    scheme: one of `MAPS`, else KeyError. problem: what is solved. r, v: the start; the arithmetic is that of their
    type. dt: the time step. steps: how many. Units: any consistent ones. See the module for derivations and literature.
    """
    step = np.asarray(r).dtype.type(dt)
    found = []
    for path in MAPS[scheme]:
        calls: list[int] = []

        def counted(r: Floats, v: Floats, calls: list[int] = calls) -> Floats:
            calls.append(1)
            return problem.acceleration(r, v)

        found.append(Solution(*path(problem._replace(acceleration=counted), r, v, step, steps), len(calls)))
    return found
