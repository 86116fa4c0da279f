"""A million steps of bodies on circles, where Verlet's difference equation has an exact solution."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, variants_of
from crosscheck.checks.stepping.orbits import SIGMAS, WHY_ROUNDING
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references.circles import Circles, satellites, triangle
from crosscheck.scene import Gravity, Method, Scene, explicit
from crosscheck.verdict import Judged, round_off, worst

_G, _SOFTENING, _STEPS = 1.7, 0.3, 1_000_000


class _Case(NamedTuple):
    """Bodies that circle, and the scheme that moves them."""

    bodies: Callable[[], Circles]
    scheme: str


#: Routh: stable if the sum of the products of two masses is less than 1/27 of the square of all.
_CASES = {
    "triangle/velocity_verlet": _Case(lambda: triangle((0.01, 2.0, 0.005), 1.3, _G, _SOFTENING), "velocity_verlet"),
    "satellites/leapfrog": _Case(lambda: satellites(16, 9, 0.8, _G, _SOFTENING), "leapfrog"),
}


def _judge(laboratory: Laboratory, case: _Case) -> Judged:
    """Positions and velocities after a million steps, a thousand to the shortest period."""
    bodies = case.bodies()
    dt = 2 * np.pi / 1000 / bodies.rates.max()
    scene = Scene(
        name="circles",
        dimension=3,
        duration=_STEPS * dt,
        masses=tuple(bodies.masses.tolist()),
        gravity=Gravity(G=_G, softening=_SOFTENING),
        initial=explicit(bodies.positions(dt, 0), bodies.velocities(dt, 0)),
    )
    run = laboratory.run(scene, Method(scheme=case.scheme, dt=dt))
    rounding = SIGMAS * bodies.rounding_error(dt, _STEPS)
    radius = bodies.radii.max()
    return worst(
        [
            round_off(
                f"{quantity}, largest difference from the exact solution of the scheme",
                float(np.linalg.norm(run[f"final_{quantity}"] - exact, axis=1).max() / unit),
                rounding,
                WHY_ROUNDING,
                note=f"in units of {name}; {run.cost.steps} steps",
            )
            for quantity, exact, unit, name in (
                ("positions", bodies.positions(dt, _STEPS), radius, "the largest radius"),
                ("velocities", bodies.velocities(dt, _STEPS), radius * bodies.rates.max(), "radius times rate"),
            )
        ]
    )


CHECKS = (
    Check(
        name="stepping/circles",
        title="Bodies on circles, a million steps of Verlet: the exact solution of the difference equation",
        equation="r_n = R(n theta) r_0, 2 sin(theta/2) = omega dt",
        criterion=WHY_ROUNDING,
        citation="Lagrange (1772); Routh, Proc. London Math. Soc. 6, 86 (1875); Verlet, Phys. Rev. 159, 98 (1967)",
        judge=_judge,
        variants=variants_of(_CASES),
        faults=tuple(
            (variant, Fault(name, f"stepping/kernels/{file}.py", old, new, breaks))
            for variant, name, file, old, new, breaks in (
                (
                    "triangle/velocity_verlet",
                    "registers-unlike-masses",
                    "few_bodies",
                    "lane_everywhere(builder, masses, j)",
                    "lane_everywhere(builder, masses, (j + 1) % r.bodies)",
                    "a body attracts with the mass of the next one",
                ),
                (
                    "satellites/leapfrog",
                    "registers-core",
                    "few_bodies",
                    "builder.fmul(arguments[4], arguments[4])",
                    "arguments[4]",
                    "the softening is not squared",
                ),
                (
                    "satellites/leapfrog",
                    "registers-last-body",
                    "registers",
                    "for body in range(kind.bodies):",
                    "for body in range(kind.bodies - 1):",
                    "the last body's coordinates are not written back",
                ),
            )
        ),
        needs=Needs(
            "gravity",
            words=frozenset({"dimension=3", "gravity.G", "gravity.softening", "masses[]", "masses=0"}),
            schemes=tuple({case.scheme for case in _CASES.values()}),
            promises=("long_runs",),
        ),
    ),
)
