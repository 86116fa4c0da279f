"""Maps of stability: each scheme on damped oscillators, over omega0 dt and the damping ratio, and its boundary.

Springs of one k and gamma and of many masses lie on a ray, zeta/(omega0 dt) = gamma/(2 k dt): a run is a ray.
"""

from __future__ import annotations

import math

import numpy as np

from crosscheck.checks.extreme.matrix import Bound, Case, Expected, Measured, Trial, extreme_check, for_each
from crosscheck.checks.stepping.faults import scheme_fault
from crosscheck.checks.stepping.springs import LITERATURE
from crosscheck.engines.capabilities import Needs
from crosscheck.figure import FieldMap, Figure, Frame, Series
from crosscheck.references.stability import boundaries, log_growth, steps_of
from crosscheck.scene import Floats, Output, Scene, Spring, explicit

#: Steps of the runs of the map: so few that no growth overflows; the time step, and v/(omega0 r) at the start.
_STEPS, _DT, _PHASE = 16, 0.25, 0.7
#: Powers of ten that the map spans: of omega0 dt, and of the damping ratio.
_H, _ZETA = (-4.0, 1.0), (-2.0, 4.0)
#: Steps of the runs beside the boundary, the distances from it, of which the first one at which the eigenvalues give
#: this factor in half of the steps is taken, and powers of ten of the rays.
_LONG, _BESIDE, _FACTOR, _RAYS = 600, (0.01, 0.03, 0.1, 0.3), 1e5, (-2.0, -1.0, 0.0, 1.0, 2.0, 4.0)
#: Boundaries of the rays, of which each scheme has at least so many: Euler has none where damping is weak.
_LEAST = 5.0


def _springs(h: Floats, ratio: float, steps: int) -> Scene:
    """One spring for each h = omega0 dt, (n,), on a ray zeta/h = ratio; no damping for 0."""
    # k = 1, so that h^2 = dt^2/m, and zeta/h = gamma/(2 dt)
    start = np.ones((h.size, 1))
    return Scene(
        name="springs",
        dimension=1,
        duration=steps * _DT,
        masses=tuple((_DT**2 / h**2).tolist()),
        spring=Spring(k=1.0, gamma=2 * ratio * _DT if ratio else None),
        initial=explicit(start, _PHASE * h[:, None] / _DT),
        output=Output(interval=_DT, trajectory=True),
    )


def _powers(span: tuple[float, float], each: int) -> Floats:
    return np.arange(round(span[0] * each), round(span[1] * each) + 1) / each


def _map(trial: Trial, each: int) -> tuple[float, Floats]:
    """Largest error of a state over its rounding; log10 of the growth a step, (zeta, h), with `each` cells a decade."""
    hs, zetas = _powers(_H, each), _powers(_ZETA, each)
    growth, worst = np.full((zetas.size, hs.size), np.nan), 0.0
    for shift in range(1 - hs.size, zetas.size):
        # cells of a ray: the row of zeta is that of h, and so many more
        columns = np.arange(max(0, -shift), min(hs.size, zetas.size - shift))
        h = 10 ** hs[columns]
        ratio = 10 ** (zetas[0] - hs[0] + shift / each)
        run = trial.run(_springs(h, ratio, _STEPS), _DT, may_end_early=True)
        r, u = run["positions"][:, :, 0], run["velocities"][:, :, 0] * _DT
        exact = steps_of(trial.method, h, ratio * h, np.ones_like(h), _PHASE * h, _STEPS)
        shares = abs(r - exact.r)[1:] / exact.r_error[1:], abs(u - exact.u)[1:] / exact.u_error[1:]
        worst = float(np.maximum(worst, np.maximum(*shares).max()))
        sizes = np.hypot(r[-1], u[-1] / h) / math.hypot(1.0, _PHASE)
        growth[columns + shift, columns] = np.log10(np.maximum(sizes, 1e-300)) / _STEPS
    return worst, growth


def _beside(trial: Trial) -> tuple[float, float]:
    """Points beside the boundary that are on its wrong side by the run; and the number of boundaries on the rays."""
    wrong, number = 0.0, 0.0
    for power in (*_RAYS, -math.inf):
        ratio = 10.0**power
        points: list[float] = []
        for edge in boundaries(trial.method, ratio, 1e-4, 10.0):
            for side in (-1, 1):
                seen = (edge * (1 + side * by) for by in _BESIDE)
                points += [h for h in seen if _visible(trial.method, h, ratio)][:1]
        if not points:
            continue
        number += len(points)
        h = np.array(points)
        run = trial.run(_springs(h, ratio, _LONG), _DT, may_end_early=True)
        sizes = np.hypot(run["positions"][:, :, 0], run["velocities"][:, :, 0] * _DT / h)
        grown = sizes[-1] > sizes[_LONG // 2]
        expected = np.array([log_growth(trial.method, one, ratio * one) > 0 for one in points])
        wrong += float(np.count_nonzero(grown != expected))
    return wrong, number


def _visible(scheme: str, h: float, ratio: float) -> bool:
    """Whether half of the steps beside the boundary show on which side h is, and none of them overflows."""
    by_half = abs(log_growth(scheme, h, ratio * h)) * _LONG / 2
    return math.log(_FACTOR) <= by_half <= 300.0


def _boundary(scheme: str) -> Series:
    """The boundary in the coordinates of the map: the lowest one on each of many rays."""
    x, y = [], []
    for power in np.arange(-3.0, 8.01, 0.2).tolist():
        edges = boundaries(scheme, 10.0**power, 10 ** _H[0], 10 ** _H[1])
        if edges and _ZETA[0] <= power + math.log10(edges[0]) <= _ZETA[1]:
            x.append(math.log10(edges[0]))
            y.append(power + math.log10(edges[0]))
    return Series("boundary from the eigenvalues of the step matrix", x, y, theory=True)


def _figure(scheme: str, growth: Floats, each: int) -> Figure:
    half = 0.5 / each
    frame = Frame(_H[0] - half, _H[1] + half, _ZETA[0] - half, _ZETA[1] + half, ())
    field = FieldMap(growth.tolist(), frame, "log10 of the growth a step", (-1.0, 1.0), lines=(_boundary(scheme),))
    return Figure(f"Stability of {scheme}", "log10 of omega0 dt", "log10 of the damping ratio", map=field)


def _measure(trial: Trial, each: int) -> Measured:
    worst, growth = _map(trial, each)
    wrong, number = _beside(trial)
    numbers = {_STATES: worst, _SIDES: wrong, _COUNT: number}
    return Measured(numbers, figures=(_figure(trial.method, growth, each),))


_STATES = "largest error of a state over its rounding"
_SIDES = "points beside the boundary on its wrong side"
_COUNT = "points beside the boundary"
_EXPECTED: tuple[Expected, ...] = (
    Bound(_STATES, 1.0, "roundings of the terms of each step, carried on by powers of the step matrix"),
    Bound(_SIDES, 0.0, "1 % to 30 % off the boundary, where the eigenvalues give a factor of 1e5 in half of the steps"),
    Bound(_COUNT, _LEAST, "else nothing is judged there", at_least=True),
)
#: The schemes, and those whose maps are drawn in the quick tier.
_SCHEMES = (
    "euler", "modified_euler", "symplectic_euler", "verlet", "leapfrog", "velocity_verlet", "beeman", "beeman_pc",
    "euler_pc", "gear2", "gear3", "gear4", "gear4_velocity", "gear5", "gear5_velocity", "gear4_zero_start",
    "gear5_zero_start",
)  # fmt: skip
_QUICK = ("velocity_verlet", "gear5_velocity")
_WHAT = "omega0 dt from 1e-4 past the limit, damping ratio 1e-2 to 1e4, gamma dt/m to 2e5"

CHECKS = (
    extreme_check(
        "stability-map",
        "Maps of stability over step and damping, and each scheme's boundary",
        "|largest eigenvalue of M(omega0 dt, zeta)| = 1",
        LITERATURE,
        (
            Case("map", _WHAT, lambda trial: _measure(trial, 2), for_each(_QUICK, *_EXPECTED)),
            Case("fine-map", _WHAT, lambda trial: _measure(trial, 6), for_each(_SCHEMES, *_EXPECTED), "full"),
        ),
        Needs(
            "spring",
            words=frozenset({"dimension=1", "masses[]", "spring.gamma"}),
            observables=frozenset({"positions", "velocities"}),
        ),
        (
            (
                "map/velocity_verlet",
                scheme_fault(
                    "velocity-verlet-damped-late",
                    "        a = accelerate(force, r, v_half)\n        return r, add_to(v_half, 0.5 * dt, a), (a,)",
                    "        a = accelerate(force, r, v)\n        return r, add_to(v_half, 0.5 * dt, a), (a,)",
                    "a velocity-dependent force gets the velocity of half a step before",
                ),
            ),
            (
                "map/gear5_velocity",
                scheme_fault(
                    "gear5-velocity-table",
                    "_GEAR5_VELOCITY = (3 / 16, 251 / 360",
                    "_GEAR5_VELOCITY = (3 / 20, 251 / 360",
                    "the corrector for f(r, v) takes its first coefficient from the table for f(r)",
                ),
            ),
        ),
    ),
)
