"""The oscillator r'' = -omega0^2 r - 2 beta r': closed form, and the exact numerical solution of each scheme.

Every scheme of `refimpl.stepping.schemes` is linear on this problem, so n steps are a power of a small matrix. The
matrices below are derived from the recurrences by hand, in the dimensionless velocity u = v dt with

    a dt^2 = -kappa r - c u,    kappa = (omega0 dt)^2,    c = gamma dt/m = 2 beta dt,

and share nothing with the implementation: they are the second derivation that it is judged by.

Literature: L. D. Landau and E. M. Lifshitz, Mechanics, sections 21 and 25; C. W. Gear, Numerical Initial Value Problems
in Ordinary Differential Equations, Prentice-Hall (1971); A. Nordsieck, Math. Comp. 16, 22 (1962).
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import cache
from math import comb
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosscheck.references import EPSILON

Matrix = NDArray[Any]


def solution(
    time: ArrayLike, r0: float, v0: float, omega0: float, beta: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """r(t), v(t) of r'' = -omega0^2 r - 2 beta r' from r0, v0: under-damped, critical and over-damped.

    time in the units of 1/omega0. The three cases share C(t) = cos, 1, cosh and S(t) = sin(w t)/w, t, sinh(w t)/w:
    r = e^{-beta t} (r0 C + (v0 + beta r0) S), v = e^{-beta t} (v0 C - (omega0^2 r0 + beta v0) S).

    time: t, any shape. r0: length. v0: length/time. omega0, beta: 1/time, not negative. Any consistent units.
    """
    t = np.asarray(time, dtype=np.float64)
    square = (omega0 - beta) * (omega0 + beta)
    if square > 0:
        w = np.sqrt(square)
        c, s = np.cos(w * t), np.sin(w * t) / w
        decay = np.exp(-beta * t)
    elif square == 0:
        c, s = np.ones_like(t), t
        decay = np.exp(-beta * t)
    else:
        # two decaying exponentials, e^{-(beta - w) t} and e^{-2 w t} times that: no overflow at long times, and no
        # difference of nearly equal numbers (beta - w = omega0^2/(beta + w))
        w = np.sqrt(-square)
        slow, fallen = np.exp(-(omega0**2) / (beta + w) * t), -np.expm1(-2 * w * t)
        c, s = slow * (1 - 0.5 * fallen), 0.5 * slow * fallen / w
        decay = np.ones_like(t)
    return decay * (r0 * c + (v0 + beta * r0) * s), decay * (v0 * c - (omega0**2 * r0 + beta * v0) * s)


def fastest_rate(omega0: float, beta: float) -> float:
    """Largest modulus of the roots of s^2 + 2 beta s + omega0^2 = 0, in units of 1/time.

    omega0 up to critical damping, beta + sqrt(beta^2 - omega0^2) beyond it: the rate that a time step must resolve.

    omega0, beta: 1/time, not negative. By derivation: the roots of the quadratic equation.
    """
    return omega0 if beta <= omega0 else beta + (beta**2 - omega0**2) ** 0.5


# Each entry gives, for (kappa, c), three matrices: start (state from (r, u)), advance (state to state), read ((r, u)
# from state). Entries are exact in any number type, so that a test can run them with rationals.
Linear = tuple[Matrix, Matrix, Matrix]
_IDENTITY = np.array([[1, 0], [0, 1]], dtype=object)


def _one_step(*rows: list[Any]) -> Linear:
    return _IDENTITY, np.array(rows, dtype=object), _IDENTITY


def _euler(kappa: Any, c: Any) -> Linear:
    return _one_step([1 - kappa / 2, 1 - c / 2], [-kappa, 1 - c])


def _modified_euler(kappa: Any, c: Any) -> Linear:
    return _one_step([1 - 3 * kappa / 2, 1 - 3 * c / 2], [-kappa, 1 - c])


def _symplectic_euler(kappa: Any, c: Any) -> Linear:
    return _one_step([1 - kappa, 1 - c], [-kappa, 1 - c])


def _euler_pc(kappa: Any, c: Any) -> Linear:
    # a' dt^2 = -kappa (r + u) - c (u + a dt^2), with a dt^2 = -kappa r - c u
    on_r, on_u = -kappa + c * kappa, -kappa - c + c * c
    return _one_step([1 + on_r, 1 + on_u], [on_r, 1 + on_u])


def _verlet(kappa: Any, c: Any) -> Linear:
    # state (r_{n-1}, r_n, r_{n+1}); r_{n+1} = (2 - kappa - c) r_n - (1 - c) r_{n-1}
    start = [[1 - kappa / 2, -1 - c / 2], [1, 0], [1 - kappa / 2, 1 - c / 2]]
    advance = [[0, 1, 0], [0, 0, 1], [0, -(1 - c), 2 - kappa - c]]
    half = type(kappa)(1) / 2
    return _objects(start), _objects(advance), _objects([[0, 1, 0], [-half, 0, half]])


def _leapfrog(kappa: Any, c: Any) -> Linear:
    # state (r_n, u_{n-1/2}, u_{n+1/2})
    half = type(kappa)(1) / 2
    start = [[1, 0], [kappa / 2, 1 + c / 2], [-kappa / 2, 1 - c / 2]]
    advance = [[1, 0, 1], [0, 0, 1], [-kappa, 0, 1 - kappa - c]]
    return _objects(start), _objects(advance), _objects([[1, 0, 0], [0, half, half]])


def _velocity_verlet(kappa: Any, c: Any) -> Linear:
    # state (r, u, q) with q = a dt^2: u_half = u + q/2, r' = r + u_half, q' = -kappa r' - c u_half, u' = u_half + q'/2
    half = type(kappa)(1) / 2
    u_half = np.array([0, 1, half], dtype=object)
    r_new = u_half + np.array([1, 0, 0], dtype=object)
    q_new = -kappa * r_new - c * u_half
    start = [[1, 0], [0, 1], [-kappa, -c]]
    return _objects(start), np.array([r_new, u_half + q_new / 2, q_new]), _objects([[1, 0, 0], [0, 1, 0]])


def _beeman(kappa: Any, c: Any, predicted: bool) -> Linear:
    # state (r, u, q_n, q_{n-1})
    one = type(kappa)(1)
    now = np.array([[-kappa, -c]], dtype=object)
    before = -kappa * np.array([[1 - kappa / 2, -1 - c / 2]], dtype=object) - c * np.array(
        [[kappa, 1 + c]], dtype=object
    )
    start = np.vstack([_IDENTITY, now, before])
    r_new = np.array([1, 1, 4 * one / 6, -one / 6], dtype=object)
    u_seen = np.array([0, 1, 3 * one / 2, -one / 2] if predicted else [0, 1, 0, 0], dtype=object)
    q_new = -kappa * r_new - c * u_seen
    u_new = np.array([0, 1, 5 * one / 6, -one / 6], dtype=object) + q_new / 3
    advance = np.array([r_new, u_new, q_new, [0, 0, 1, 0]], dtype=object)
    return start, advance, _objects([[1, 0, 0, 0], [0, 1, 0, 0]])


def _gear(kappa: Any, c: Any, corrector: list[Any], analytic_start: bool) -> Linear:
    # Nordsieck: R' = P R + alpha (g - e_2) P R, with g R = -(kappa R_0 + c R_1)/2 the equation of motion
    size = len(corrector)
    one = type(kappa)(1)
    pascal = np.array([[comb(q, p) for q in range(size)] for p in range(size)], dtype=object)
    defect = np.array([-kappa / 2, -c / 2, -one, *[0] * (size - 3)], dtype=object)
    advance = pascal + np.outer(np.array(corrector, dtype=object), defect @ pascal)
    rows = [[one, 0], [0, one]]
    for q in range(size - 2):
        known = q == 0 or analytic_start
        # (q+2)(q+1) R_{q+2} = -kappa R_q - c (q+1) R_{q+1}
        rows.append(
            [
                (-kappa * low - c * (q + 1) * high) / ((q + 2) * (q + 1)) if known else 0 * one
                for low, high in zip(rows[q], rows[q + 1], strict=True)
            ]
        )
    return _objects(rows), advance, np.eye(2, size, dtype=int).astype(object)


def _objects(rows: list[list[Any]]) -> Matrix:
    return np.array(rows, dtype=object)


#: Corrector coefficients as (numerator, denominator): Gear (1971); Allen and Tildesley (1987), appendix E.
_CORRECTORS = {
    "gear2": [(0, 1), (1, 1), (1, 1)],
    "gear3": [(1, 6), (5, 6), (1, 1), (1, 3)],
    "gear4": [(19, 120), (3, 4), (1, 1), (1, 2), (1, 12)],
    "gear4_velocity": [(19, 90), (3, 4), (1, 1), (1, 2), (1, 12)],
    "gear5": [(3, 20), (251, 360), (1, 1), (11, 18), (1, 6), (1, 60)],
    "gear5_velocity": [(3, 16), (251, 360), (1, 1), (11, 18), (1, 6), (1, 60)],
}
_ZERO_START = {"gear4_zero_start": "gear4_velocity", "gear5_zero_start": "gear5_velocity"}
_PLAIN: dict[str, Callable[[Any, Any], Linear]] = {
    "euler": _euler,
    "modified_euler": _modified_euler,
    "symplectic_euler": _symplectic_euler,
    "verlet": _verlet,
    "leapfrog": _leapfrog,
    "velocity_verlet": _velocity_verlet,
    "beeman": lambda kappa, c: _beeman(kappa, c, predicted=False),
    "beeman_pc": lambda kappa, c: _beeman(kappa, c, predicted=True),
    "euler_pc": _euler_pc,
}


def matrices(scheme: str, kappa: Any, c: Any) -> Linear:
    """(start, advance, read) of `scheme`: after n steps (r, v dt) = read advance^n start (r0, v0 dt).

    kappa = (omega0 dt)^2 and c = gamma dt/m may be floats, rationals or mpmath numbers; the matrices have their type.
    KeyError for a scheme without a matrix.

    scheme: its name. By derivation from the recurrences.
    """
    if scheme in _PLAIN:
        return _PLAIN[scheme](kappa, c)
    name = _ZERO_START.get(scheme, scheme)
    one = type(kappa)(1)
    corrector = [one * numerator / denominator for numerator, denominator in _CORRECTORS[name]]
    return _gear(kappa, c, corrector, analytic_start=name == scheme)


def gear_corrector(scheme: str) -> tuple[list[Fraction], bool]:
    """Gear's coefficients alpha_0, alpha_1, ..., and whether the start knows the higher derivatives.

    scheme: its name, else KeyError. Gear (1971); Allen and Tildesley (1987), appendix E.
    """
    name = _ZERO_START.get(scheme, scheme)
    return [Fraction(*pair) for pair in _CORRECTORS[name]], name == scheme


def has_matrix(scheme: str) -> bool:
    """Whether the exact numerical solution of this scheme is known here.

    scheme: its name.
    """
    return scheme in _PLAIN or scheme in _CORRECTORS or scheme in _ZERO_START


def numerical_solution(
    scheme: str, steps: int, dt: float, r0: float, v0: float, omega0: float, beta: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """r and v after 0, 1, ... `steps` steps, from the matrices in long double, rounded to float64.

    scheme: a name known to `has_matrix`, else KeyError. dt: time step. r0: length. v0: length/time. omega0, beta:
    1/time. Any consistent units. Two arrays (steps + 1,), exact to the rounding of long double.
    """
    kappa, c = np.longdouble(omega0 * dt) ** 2, 2 * np.longdouble(beta) * np.longdouble(dt)
    start, advance, read = (m.astype(np.longdouble) for m in matrices(scheme, kappa, c))
    given = np.array([r0, np.longdouble(v0) * np.longdouble(dt)], dtype=np.longdouble)
    states = (advance @ start @ given)[:, np.newaxis]
    while states.shape[1] < steps:  # `advance` is the power that leads from these states to the ones after them
        states = np.hstack([states, advance @ states])
        advance = advance @ advance
    out = np.vstack([given, (read @ states[:, :steps]).T])
    return out[:, 0].astype(np.float64), (out[:, 1] / np.longdouble(dt)).astype(np.float64)


def growth_per_step(scheme: str, h: float) -> float:
    """Largest modulus of the eigenvalues of the undamped step matrix at h = omega0 dt.

    scheme: a name known to `has_matrix`, else KeyError. h: radians per step.
    """
    advance = matrices(scheme, float(h) ** 2, 0.0)[1].astype(np.float64)
    return float(np.abs(np.linalg.eigvals(advance)).max())


#: Largest omega0 dt that leaves the amplitude bounded for ever: roots of the characteristic polynomials.
_STRICT_LIMITS = {
    "modified_euler": 2**0.5,
    "symplectic_euler": 2.0,
    "verlet": 2.0,
    "leapfrog": 2.0,
    "velocity_verlet": 2.0,
    "beeman": 2.0,
    "beeman_pc": 2.0,
    "euler_pc": 2 / 3**0.5,
    "gear2": 2.0,
    "gear3": 2**0.5,
}


def strict_limit(scheme: str) -> float | None:
    """The stability limit in closed form; None where no step is stable for ever, or the growth too slow to see.

    scheme: its name; None too if it is not known. In radians, omega0 dt.
    """
    return _STRICT_LIMITS.get(scheme)


@cache
def practical_limit(scheme: str, growth: float) -> float:
    """The smallest h = omega0 dt at which the amplitude grows by the factor `growth` > 1 a step, from eigenvalues.

    scheme: a name known to `has_matrix`, else KeyError. In radians, to 1e-14.
    """
    from scipy.optimize import brentq

    grid = np.linspace(0.01, 2.5, 80)
    above = np.flatnonzero([growth_per_step(scheme, h) > growth for h in grid])[0]
    return float(brentq(lambda h: growth_per_step(scheme, h) - growth, grid[above - 1], grid[above], xtol=1e-14))


def growth_rate(scheme: str, h: float) -> float:
    """ln(largest |eigenvalue|) of the undamped step matrix, to 1e-16: for rates far below the error of `eigvals`.

    The characteristic polynomial is exact (Faddeev and LeVerrier, in rationals); its root is polished by Newton's
    method in long double.

    scheme: a name known to `has_matrix`, else KeyError. h: radians per step.
    """
    advance = matrices(scheme, Fraction(h) ** 2, Fraction(0))[1]
    size = len(advance)
    coefficients, power = [Fraction(1)], np.zeros((size, size), dtype=object)
    for k in range(1, size + 1):
        power = advance @ (power + coefficients[-1] * np.eye(size, dtype=int).astype(object))
        coefficients.append(-Fraction(np.trace(power)) / k)
    polynomial = np.array([np.longdouble(c.numerator) / np.longdouble(c.denominator) for c in coefficients])
    eigenvalues = np.linalg.eigvals(advance.astype(np.float64))
    root: Any = np.clongdouble(eigenvalues[np.abs(eigenvalues).argmax()])
    for _ in range(20):
        root -= np.polyval(polynomial, root) / np.polyval(np.polyder(polynomial), root)
    return float(np.log(np.abs(root)))


def energy_growth(scheme: str, h: float) -> float:
    """d ln E/d(omega0 t) of the undamped oscillator at h = omega0 dt: twice the growth rate of the amplitude.

    0 where the growth a step is of the size of rounding. E = (v^2 + omega0^2 r^2)/2, averaged over a period.

    scheme: a name known to `has_matrix`, else KeyError. h: radians per step.
    """
    rate = 2 * growth_rate(scheme, h) / h
    return float(rate) if abs(rate) > 4 * EPSILON / h else 0.0


# -- what rounding does ------------------------------------------------------------------------------------------------


def rounding_error(steps: float) -> float:
    """Standard deviation of r and of v/omega0, in units of the amplitude, after `steps` independent roundings of both.

    Each is rounded by eps/sqrt(12) of itself in every step, and turns with the phase from then on: a random walk
    (D. Brouwer, Astron. J. 46, 149 (1937)).

    steps: how many.
    """
    return float(EPSILON * (2 / 12 * steps) ** 0.5)


def rounding_lever(scheme: str, rate: float) -> float:
    """How much a rounding of the position counts in the velocity: 1; of Verlet 1/(omega dt).

    Verlet's positions carry the velocity as a difference, so that a rounding of r is one of r/dt in v. scheme: its
    name. rate: steps per radian of the motion, 1/(omega dt).
    """
    return rate if scheme == "verlet" else 1.0
