"""Time-integration schemes for m r'' = f(r, v): pure step functions on arrays, and the table of what each claims.

A scheme is a record (a `NamedTuple`, usually without fields) with two pure functions, or three:

`start(force, r, v, dt) -> memory`
    what the scheme carries from step to step besides `r` and `v`, a tuple of arrays;
`step(force, r, v, memory, dt) -> (r, v, memory)`
    the state one step later, positions and velocities at the same time;
`moved(memory, by) -> memory`, of schemes whose memory holds positions
    the memory after all positions have changed by `by`, (N*d,), whole periods of the box. Called from Python only.

`force`: a record with the functions of `forces.generic`; `accelerate(force, r, v)` is f/m. `r`, `v`: flat coordinates
and velocities, shape (N*d,). `dt`: the time step, in the unit of time of the force. The functions run as plain numpy,
and compiled inside the step loop of `integrate`.

To add a scheme: one class here and one line in `SCHEMES`. Its claims are checked by `crosscheck run 'stepping/*'`.

Literature: M. P. Allen and D. J. Tildesley, Computer Simulation of Liquids, 2nd ed., Oxford University Press (2017),
chapter 3 and appendix E of the 1st ed. (1987); L. Verlet, Phys. Rev. 159, 98 (1967); D. Beeman, J. Comput. Phys. 20,
130 (1976); C. W. Gear, Numerical Initial Value Problems in Ordinary Differential Equations, Prentice-Hall (1971);
W. C. Swope, H. C. Andersen, P. H. Berens and K. R. Wilson, J. Chem. Phys. 76, 637 (1982).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numba.extending import register_jitable

from refimpl.stepping.forces.generic import Force, accelerate, derivatives
from refimpl.stepping.kernels.sums import add_to, kick_drift

Array = np.ndarray
Memory = tuple[Array, ...]
StepResult = tuple[Array, Array, Memory]


class Euler(NamedTuple):
    """r + dt v + dt^2 a/2; v + dt a, with a = f(r, v)/m at the old time."""

    def start(self, force: Force, r: Array, v: Array, dt: float) -> Memory:
        return ()

    def step(self, force: Force, r: Array, v: Array, memory: Memory, dt: float) -> StepResult:
        a = accelerate(force, r, v)
        return r + dt * v + 0.5 * dt**2 * a, v + dt * a, memory


class ModifiedEuler(NamedTuple):
    """v' = v + dt a; r + dt v' + dt^2 a/2: counts the acceleration in r three times over, hence artificial damping."""

    def start(self, force: Force, r: Array, v: Array, dt: float) -> Memory:
        return ()

    def step(self, force: Force, r: Array, v: Array, memory: Memory, dt: float) -> StepResult:
        a = accelerate(force, r, v)
        v = v + dt * a
        return r + dt * v + 0.5 * dt**2 * a, v, memory


class SymplecticEuler(NamedTuple):
    """v' = v + dt a; r + dt v': the usual semi-implicit Euler."""

    def start(self, force: Force, r: Array, v: Array, dt: float) -> Memory:
        return ()

    def step(self, force: Force, r: Array, v: Array, memory: Memory, dt: float) -> StepResult:
        v = v + dt * accelerate(force, r, v)
        return r + dt * v, v, memory


class Verlet(NamedTuple):
    """r(t+dt) = 2 r(t) - r(t-dt) + dt^2 a(t); v(t) = (r(t+dt) - r(t-dt))/2dt.

    The velocity needs the positions one step ahead: they are the memory. A velocity-dependent force gets the backward
    difference (r(t) - r(t-dt))/dt, the only velocity known when it is evaluated.
    """

    def start(self, force: Force, r: Array, v: Array, dt: float) -> Memory:
        a = accelerate(force, r, v)
        r_before = r - dt * v + 0.5 * dt**2 * a
        return (2.0 * r - r_before + dt**2 * a,)

    def step(self, force: Force, r: Array, v: Array, memory: Memory, dt: float) -> StepResult:
        r_now = memory[0]
        a = accelerate(force, r_now, (r_now - r) / dt)
        r_ahead = 2.0 * r_now - r + dt**2 * a
        return r_now, (r_ahead - r) / (2.0 * dt), (r_ahead,)

    def moved(self, memory: Memory, by: Array) -> Memory:
        return (memory[0] + by,)


class LeapFrog(NamedTuple):
    """v(t+dt/2) = v(t-dt/2) + dt a(t); r(t+dt) = r(t) + dt v(t+dt/2); v(t) is the mean of the two half-step values.

    The memory is the half-step velocity ahead; a velocity-dependent force gets the one behind.
    """

    def start(self, force: Force, r: Array, v: Array, dt: float) -> Memory:
        return (v + 0.5 * dt * accelerate(force, r, v),)

    def step(self, force: Force, r: Array, v: Array, memory: Memory, dt: float) -> StepResult:
        v_behind = memory[0]
        r = r + dt * v_behind
        v_ahead = v_behind + dt * accelerate(force, r, v_behind)
        return r, 0.5 * (v_behind + v_ahead), (v_ahead,)


class VelocityVerlet(NamedTuple):
    """v(t+dt/2) = v + dt a/2; r + dt v(t+dt/2); v(t+dt) = v(t+dt/2) + dt a(t+dt)/2.

    The memory is the acceleration. A velocity-dependent force gets the half-step velocity, as in LAMMPS.
    """

    def start(self, force: Force, r: Array, v: Array, dt: float) -> Memory:
        return (accelerate(force, r, v),)

    def step(self, force: Force, r: Array, v: Array, memory: Memory, dt: float) -> StepResult:
        v_half, r = kick_drift(r, v, memory[0], dt)
        a = accelerate(force, r, v_half)
        return r, add_to(v_half, 0.5 * dt, a), (a,)


@register_jitable
def _accelerations_now_and_before(force: Force, r: Array, v: Array, dt: float) -> Memory:
    """a(0) and a(-dt), the latter from an Euler step backwards: the start of the Beeman schemes."""
    a = accelerate(force, r, v)
    return a, accelerate(force, r - dt * v + 0.5 * dt**2 * a, v - dt * a)


class Beeman(NamedTuple):
    """r + dt v + dt^2 (4 a(t) - a(t-dt))/6; v + dt (2 a(t+dt) + 5 a(t) - a(t-dt))/6.

    A velocity-dependent force gets the velocity of the step before.
    """

    def start(self, force: Force, r: Array, v: Array, dt: float) -> Memory:
        return _accelerations_now_and_before(force, r, v, dt)

    def step(self, force: Force, r: Array, v: Array, memory: Memory, dt: float) -> StepResult:
        a, a_before = memory
        r = r + dt * v + dt**2 / 6.0 * (4.0 * a - a_before)
        a_new = accelerate(force, r, v)
        return r, v + dt / 6.0 * (2.0 * a_new + 5.0 * a - a_before), (a_new, a)


class BeemanPredictorCorrector(NamedTuple):
    """Beeman, with the velocity-dependent force at the predicted velocity v + dt (3 a(t) - a(t-dt))/2."""

    def start(self, force: Force, r: Array, v: Array, dt: float) -> Memory:
        return _accelerations_now_and_before(force, r, v, dt)

    def step(self, force: Force, r: Array, v: Array, memory: Memory, dt: float) -> StepResult:
        a, a_before = memory
        r = r + dt * v + dt**2 / 6.0 * (4.0 * a - a_before)
        v_predicted = v + 0.5 * dt * (3.0 * a - a_before)
        a_new = accelerate(force, r, v_predicted)
        return r, v + dt / 6.0 * (2.0 * a_new + 5.0 * a - a_before), (a_new, a)


class EulerPredictorCorrector(NamedTuple):
    """Predicts r + dt v and v + dt a, evaluates a' there, corrects: v' = v + dt a'; r + dt v'. Not Heun's method."""

    def start(self, force: Force, r: Array, v: Array, dt: float) -> Memory:
        return ()

    def step(self, force: Force, r: Array, v: Array, memory: Memory, dt: float) -> StepResult:
        a = accelerate(force, r, v)
        v_new = v + dt * accelerate(force, r + dt * v, v + dt * a)
        return r + dt * v_new, v_new, memory


class Gear(NamedTuple):
    """Gear's predictor-corrector for second-order equations, on the scaled derivatives R_q = r_q dt^q/q!.

    Predict R by Taylor's series (Pascal's triangle), evaluate a at the prediction, correct
    R_q += alpha_q (a dt^2/2 - R_2). The memory is R_0, R_1, ... as one array, shape (order + 1, N*d).

    corrector: alpha_0 ... alpha_order. analytic_start: higher derivatives from the force, which may be zero.
    """

    corrector: Array
    analytic_start: bool

    def start(self, force: Force, r: Array, v: Array, dt: float) -> Memory:
        size = self.corrector.size
        scaled = np.zeros((size, r.size))
        scaled[0] = r
        scaled[1] = dt * v
        scaled[2] = accelerate(force, r, v) * (dt**2 / 2.0)
        if self.analytic_start:
            higher = derivatives(force, r, v, size - 3)
            factor = dt**2 / 2.0
            for q in range(3, size):
                factor *= dt / q
                scaled[q] = factor * higher[q - 3]
        return (scaled,)

    def step(self, force: Force, r: Array, v: Array, memory: Memory, dt: float) -> StepResult:
        size = self.corrector.size
        scaled = memory[0].copy()
        for lowest in range(size - 1):
            for q in range(size - 2, lowest - 1, -1):
                scaled[q] += scaled[q + 1]
        change = accelerate(force, scaled[0], scaled[1] / dt) * (dt**2 / 2.0) - scaled[2]
        for q in range(size):
            scaled[q] += self.corrector[q] * change
        return scaled[0].copy(), scaled[1] / dt, (scaled,)

    def moved(self, memory: Memory, by: Array) -> Memory:
        scaled = memory[0].copy()
        scaled[0] += by
        return (scaled,)


@register_jitable
def _add(total: Array, rest: Array, more: Array) -> tuple[Array, Array]:
    """total + rest + more as a rounded sum and what it lacks, exactly: D. E. Knuth, vol. 2 (1997), 4.2.2."""
    more = more + rest
    new = total + more
    part = new - total
    return new, (total - (new - part)) + (more - part)


class CompensatedVelocityVerlet(NamedTuple):
    """Velocity Verlet whose r and v keep what their sums lose by rounding: what is rounded are dt v and dt a alone.

    The memory is the acceleration, and what r and v lack. Compensated summation: W. Kahan, Commun. ACM 8, 40 (1965); E.
    Hairer, R. I. McLachlan and A. Razakarivony, BIT Numer. Math. 48, 231 (2008).
    """

    def start(self, force: Force, r: Array, v: Array, dt: float) -> Memory:
        return accelerate(force, r, v), np.zeros_like(r), np.zeros_like(v)

    def step(self, force: Force, r: Array, v: Array, memory: Memory, dt: float) -> StepResult:
        a, r_rest, v_rest = memory
        v_half, v_rest = _add(v, v_rest, 0.5 * dt * a)
        r, r_rest = _add(r, r_rest + dt * v_rest, dt * v_half)
        a = accelerate(force, r, v_half)
        v, v_rest = _add(v_half, v_rest, 0.5 * dt * a)
        return r, v, (a, r_rest, v_rest)


@dataclass(frozen=True)
class Scheme:
    """A scheme and what it claims; the checks of its runs hold it to that.

    record: the scheme.
    order, order_damped: global orders (position, velocity) of the error for f(r) and for f(r, v).
    evaluations, start_evaluations: of the force, per step and at the start.
    symplectic, reversible: of the map from the initial to the final (r, v), start procedure included.
    """

    record: Any
    order: tuple[int, int]
    order_damped: tuple[int, int]
    evaluations: int
    start_evaluations: int
    symplectic: bool
    reversible: bool


def _first_order(record: Any, evaluations: int = 1, *, symplectic: bool = False) -> Scheme:
    return Scheme(
        record,
        order=(1, 1),
        order_damped=(1, 1),
        evaluations=evaluations,
        start_evaluations=0,
        symplectic=symplectic,
        reversible=False,
    )


def _verlet_family(record: Any, damped: int, *, same_map: bool) -> Scheme:
    # Beeman's positions are Verlet's from a slightly different start, so its (r, v) map is neither exactly
    # symplectic nor exactly reversible, and its energy does not drift all the same.
    return Scheme(
        record,
        order=(2, 2),
        order_damped=(damped, damped),
        evaluations=1,
        start_evaluations=1 if same_map else 2,
        symplectic=same_map,
        reversible=same_map,
    )


def _gear_family(
    corrector: tuple[float, ...], order: tuple[int, int], order_damped: tuple[int, int], *, analytic_start: bool = True
) -> Scheme:
    return Scheme(
        Gear(np.array(corrector), analytic_start),
        order=order,
        order_damped=order_damped,
        evaluations=1,
        start_evaluations=1,
        symplectic=len(corrector) == 3,
        reversible=len(corrector) == 3,
    )


_GEAR4, _GEAR4_VELOCITY = (19 / 120, 3 / 4, 1.0, 1 / 2, 1 / 12), (19 / 90, 3 / 4, 1.0, 1 / 2, 1 / 12)
_GEAR5 = (3 / 20, 251 / 360, 1.0, 11 / 18, 1 / 6, 1 / 60)
_GEAR5_VELOCITY = (3 / 16, 251 / 360, 1.0, 11 / 18, 1 / 6, 1 / 60)

# gear4, f(r): order 5 in the position is that from rest, and of all that grows with time. A start with a velocity adds
# h^4/720 (v0/omega) sin(omega t), visible below h = 0.05 only.
SCHEMES: dict[str, Scheme] = {
    "euler": _first_order(Euler()),
    "modified_euler": _first_order(ModifiedEuler()),
    "symplectic_euler": _first_order(SymplecticEuler(), symplectic=True),
    "verlet": _verlet_family(Verlet(), 1, same_map=True),
    "leapfrog": _verlet_family(LeapFrog(), 1, same_map=True),
    "velocity_verlet": _verlet_family(VelocityVerlet(), 1, same_map=True),
    "beeman": _verlet_family(Beeman(), 1, same_map=False),
    "beeman_pc": _verlet_family(BeemanPredictorCorrector(), 2, same_map=False),
    "euler_pc": _first_order(EulerPredictorCorrector(), 2),
    "gear2": _gear_family((0.0, 1.0, 1.0), (2, 2), (2, 2)),
    "gear3": _gear_family((1 / 6, 5 / 6, 1.0, 1 / 3), (4, 3), (3, 3)),
    "gear4": _gear_family(_GEAR4, (5, 4), (4, 4)),
    "gear4_velocity": _gear_family(_GEAR4_VELOCITY, (4, 4), (4, 4)),
    "gear5": _gear_family(_GEAR5, (6, 5), (5, 5)),
    "gear5_velocity": _gear_family(_GEAR5_VELOCITY, (5, 5), (5, 5)),
    "gear4_zero_start": _gear_family(_GEAR4_VELOCITY, (2, 2), (2, 2), analytic_start=False),
    "gear5_zero_start": _gear_family(_GEAR5_VELOCITY, (2, 2), (2, 2), analytic_start=False),
}

#: Forms of schemes with compensated summation, by the names of these.
COMPENSATED: dict[str, Scheme] = {
    "velocity_verlet": _verlet_family(CompensatedVelocityVerlet(), 1, same_map=True),
}
