"""Largest stable time step of a soft contact, by bisection; and what a run says that is far beyond it.

Literature: J. Schaefer, S. Dippel and D. E. Wolf, J. Phys. I France 6, 5 (1996).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant, variants_of
from crosscheck.checks.granular.impacts import STEP_LABEL, Law
from crosscheck.checks.granular.soft_grains import CONTACTS, soft_needs
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.references.soft_impact import damping, stability_limit, stable_resolution
from crosscheck.references.stepped_contact import growth_delay
from crosscheck.scene import Box, Face, HardSpheres, Output, Scene, explicit
from crosscheck.verdict import Judged, bounded, round_off, within, worst

#: Steps of a grain between two walls, and its speed, in diameters and units of omega_0.
STABLE_STEPS, STABLE_SPEED = 4000, 1e-9
#: Growth that counts as unstable: just below the limit it may grow with the steps, 2 a step (a Jordan block).
EXPLODED = 10.0 * STABLE_STEPS
#: Restitutions.
_ALPHAS = {"elastic": 1.0, "damped": 0.7, "strongly-damped": 0.05}
#: A step, in units of 1/omega_0, beyond the limit of 2; the number of steps after which no double holds the motion; a
#: speed at the start that is short in base two; and how fast the motion grows, (dt^2/2 - 1) + dt sqrt(dt^2/4 - 1).
_BEYOND, _BEYOND_STEPS, _BEYOND_SPEED = 3.0, 400, 2.0**-20
_BEYOND_GROWTH = _BEYOND**2 / 2 - 1 + _BEYOND * math.sqrt(_BEYOND**2 / 4 - 1)
#: Relative width at which bisection ends.
_BISECTED = 2e-5


def bisect(explodes: Callable[[float], bool], low: float, high: float, width: float) -> float:
    """The smallest argument at which `explodes` holds, to within `width`.

    ValueError unless it lies between `low`, where it must not hold, and `high`, where it must.
    """
    if explodes(low) or not explodes(high):
        raise ValueError(f"the limit does not lie between {low} and {high}")
    while high - low > width:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if explodes(middle) else (middle, high)
    return 0.5 * (low + high)


def _between_walls(alpha: float, duration: float, speed: float) -> Scene:
    """A grain that fits between two walls, so that one always touches: a damped oscillator about y = 1/2."""
    return Scene(
        name="between-walls",
        dimension=2,
        duration=duration,
        hard_spheres=HardSpheres(restitution=alpha),
        box=Box(
            lengths=(4.0, 1.0),
            boundaries=("open", "hard"),
            faces={"y-": Face(restitution=alpha), "y+": Face(restitution=alpha)},
        ),
        initial=explicit(np.array([[2.0, 0.5]]), np.array([[0.0, speed]])),
    )


def _growth(laboratory: Laboratory, alpha: float, step: float, steps: int) -> float:
    """sqrt(v^2 + (omega_0 x)^2) over the speed at the start, m = k = 1, of a grain that fits between two walls."""
    scene = _between_walls(alpha, step * steps, STABLE_SPEED)
    run = laboratory.run(scene, Law(alpha).method(1.0, step), may_end_early=True)
    size = math.hypot(run["final_velocities"][0, 1], run["final_positions"][0, 1] - 0.5) / STABLE_SPEED
    return math.inf if run.diverged or not math.isfinite(size) else size


def _judge_step_limit(laboratory: Laboratory, alpha: float) -> Judged:
    c = damping(alpha)
    limit = stability_limit(c)
    per_contact = math.sqrt(1 - c * c / 4) / math.pi

    def explodes(share: float) -> bool:
        return _growth(laboratory, alpha, share * limit, STABLE_STEPS) > EXPLODED

    try:
        found = limit * bisect(explodes, 0.9, 1.1, _BISECTED)
    except ValueError:
        found = math.nan
    delay = growth_delay(c, EXPLODED, STABLE_STEPS)
    steps, shares = 100, np.concatenate([np.linspace(0.5, 0.98, 13), np.linspace(0.99, 1.05, 13)])
    sizes = [_growth(laboratory, alpha, float(share) * limit, steps) for share in shares]
    x = [float(share) * limit * per_contact for share in shares]
    grown = Series(f"alpha = {alpha:g}", x, [max(size, EPSILON) ** 2 for size in sizes])
    threshold = Series(
        f"alpha = {alpha:g}, limit", [limit * per_contact] * 2, [min(grown.y), max(max(grown.y), 1.0)], theory=True
    )
    figure = Figure(
        "energy after 100 steps", STEP_LABEL, "energy over that at the start", "linear", "log", (grown, threshold)
    )
    return within(
        "round_off",
        "largest stable omega_0 dt",
        found,
        limit,
        limit * (delay + _BISECTED),
        f"bisected to {_BISECTED:g}, and a step must exceed the limit by {delay:.1e} to grow by {EXPLODED:g} in "
        f"{STABLE_STEPS} steps",
        note=f"c = {c:.4g}; the limit is dt/t_c = {stable_resolution(c):.4f}",
        figures=(figure,),
    )


def _judge_beyond(laboratory: Laboratory, value: None) -> Judged:
    """Before the end each step is that of the oscillator, whose map the steps are; from there on there is no number."""
    scene = _between_walls(1.0, _BEYOND * _BEYOND_STEPS, _BEYOND_SPEED)
    names = ("positions", "velocities", "wall_impulse")
    scene = scene.changed(output=Output(interval=_BEYOND, trajectory=True, observables=names[2:]))
    run = laboratory.run(scene, Law(1.0).method(1.0, _BEYOND), may_end_early=True)
    finite = np.hstack([np.isfinite(run[name]).reshape(len(run["time"]), -1) for name in names])
    first = int(np.argmin(finite.all(axis=1)))  # where one number overflows, another one may be finite yet
    afterwards = float(finite[first + 1 :].any(axis=1).sum())
    x, v, share = 0.0, _BEYOND_SPEED, 0.0
    place = 0.5
    for sample in range(first):
        # the error of a coordinate near 1/2 grows as the motion itself does
        rounding = 16 * EPSILON * (sample + 1) * place
        off = max(abs(run["positions"][sample, 0, 1] - 0.5 - x), abs(run["velocities"][sample, 0, 1] - v))
        share = max(share, float(off) / rounding)
        after = x + _BEYOND * v - _BEYOND**2 / 2 * x
        x, v = after, v - _BEYOND / 2 * (x + after)
        place *= _BEYOND_GROWTH
    return worst(
        [
            bounded("runs that do not say that they diverged", float(not run.diverged), 0.0, "no double is so large"),
            bounded("samples with numbers after the first without", afterwards, 0.0, "nothing is known from there on"),
            round_off(
                "largest error over its rounding before", share, 1.0, "rounding near y = 1/2, grown as the motion"
            ),
            bounded(
                "samples before", float(first), 4.0, "what is not reached is not judged", at_least=True, control=True
            ),
        ],
        f"{first} samples before the end",
    )


CHECKS = (
    Check(
        name="granular/beyond-the-limit",
        title="Steps far beyond the stable ones: the oscillator's map, until the run says that it diverged",
        equation="y' = y + dt v - dt^2 y/2, v' = v - dt (y + y')/2, k = m = 1, dt = 3; it grows by 6.85 a step",
        criterion="each step to rounding, the flag, and no numbers from one sample on, in all that is recorded",
        citation="Hairer, Lubich & Wanner, Acta Numerica 12, 399 (2003), on the stability of Verlet's method",
        judge=_judge_beyond,
        variants=(Variant("elastic", None),),
        needs=soft_needs(
            "dimension=2 method.contact.stiffness box.boundaries=hard",
            "positions velocities wall_impulse",
        ),
        interpreted=True,
        faults=(
            (
                "elastic",
                Fault(
                    "no-overlap-above-the-radius",
                    CONTACTS,
                    "            delta = radii[i] - sign * (r[d * i + axis] - place)\n            if delta <= 0.0:",
                    "            delta = min(radii[i] - sign * (r[d * i + axis] - place), radii[i])\n"
                    "            if delta <= 0.0:",
                    "walls push no more than at an overlap of a radius: the motion stays finite",
                ),
            ),
        ),
    ),
    Check(
        name="granular/step-limit",
        title="Largest stable time step of a soft contact",
        equation="omega_0 dt < sqrt(c^2 + 4) - c",
        criterion="a grain that fits between two walls, so that one always touches: the limit by bisection",
        citation="Schaefer, Dippel & Wolf, J. Phys. I France 6, 5 (1996)",
        judge=_judge_step_limit,
        variants=variants_of(_ALPHAS, "full"),
        needs=soft_needs("dimension=2 method.contact.stiffness box.boundaries=hard"),
        faults=(
            (
                "damped",
                Fault(
                    "wall-of-the-pair-mass",
                    CONTACTS,
                    "mass, approach = 1.0 / inverse_masses[i], _product(g, n)",
                    "mass, approach = 0.5 / inverse_masses[i], _product(g, n)",
                    "the reduced mass at a wall is that of a pair",
                ),
            ),
        ),
    ),
)
