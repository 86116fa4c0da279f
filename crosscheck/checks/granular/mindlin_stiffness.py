"""A grain that rests on a floor of its own material, touched lightly: its stiffnesses along the floor and across it.

Literature: R. D. Mindlin, J. Appl. Mech. 16, 259 (1949); K. L. Johnson, Contact Mechanics (Cambridge, 1985).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from crosscheck.checks.base import Check, Laboratory, variants_of
from crosscheck.checks.granular.soft_grains import CONTACTS, contact_needs
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.references.hertz_mindlin import Material, Pressed, overlap_under
from crosscheck.scene import (
    Box,
    Contact,
    Face,
    Friction,
    GrainFriction,
    HardSpheres,
    Method,
    Output,
    Scene,
    explicit,
)
from crosscheck.verdict import Judged, within, worst

Floats = NDArray[np.float64]

#: Ratios of Poisson; at 0 both stiffnesses are equal.
_RATIOS = {"nu=0": 0.0, "nu=0.3": 0.3, "nu=0.5": 0.5}
#: Mass and weight are 1. The grain sinks by about 1e-3 of its diameter, and its swing is some 1e-5 of that.
_YOUNG, _RADIUS, _Q = 1e5, 0.5, 0.4
_SPEED, _DT, _STEPS = 1e-6, 1e-3, 400
_SIDE = 12.0
_CONTACT = Contact(law="hertz", E=_YOUNG, nu=0.0, gamma_n=0.0)


def _scene(pressed: Pressed) -> Scene:
    """Grains on the floor z = 0: one hops, two are pushed along the floor, and one is spun."""
    rough = {"tangential_restitution": -1.0}
    places = np.array([[x, y, _RADIUS - pressed.overlap] for x in (3.0, 9.0) for y in (3.0, 9.0)])
    velocities, spins = np.zeros((2, 4, 3))
    velocities[0, 2] = velocities[1, 0] = _SPEED
    velocities[2, 1] = -_SPEED
    spins[3, 0] = _SPEED / _RADIUS
    return Scene(
        name="touched-lightly",
        dimension=3,
        duration=_DT * _STEPS,
        acceleration=(0.0, 0.0, -1.0),
        hard_spheres=HardSpheres(friction=GrainFriction(**rough)),
        box=Box(
            lengths=(_SIDE,) * 3,
            boundaries=("open", "open", "hard"),
            faces={"z-": Face(friction=Friction(**rough)), "z+": Face(open=True)},
        ),
        initial=explicit(places, velocities, spins),
        output=Output(interval=_DT, trajectory=True),
    )


def _frequency_squared(x: Floats) -> float:
    """w^2 of a swing x(t) that velocity Verlet takes in steps dt: x(t + dt) + x(t - dt) = (2 - w^2 dt^2) x(t)."""
    around = x[2:] + x[:-2]
    return float((2 - (around * x[1:-1]).sum() / (x[1:-1] ** 2).sum()) / _DT**2)


def _judge(laboratory: Laboratory, poisson: float) -> Judged:
    material = Material(_YOUNG, poisson)
    pressed = Pressed(material, _RADIUS, overlap_under(1.0, material, _RADIUS))
    contact = _CONTACT.model_copy(update={"nu": poisson})
    run = laboratory.run(_scene(pressed), Method(scheme="velocity_verlet", dt=_DT, contact=contact))
    v, s = run["velocities"], _RADIUS * run["angular_velocities"]
    # u = v - R omega x n, n = z
    slips = [v[:, 1, 0] - s[:, 1, 1], v[:, 2, 1] + s[:, 2, 0], v[:, 3, 1] + s[:, 3, 0]]
    normal = _frequency_squared(v[:, 0, 2])
    tangential = [_frequency_squared(slip) / (1 + 1 / _Q) for slip in slips]
    swing = _SPEED / math.sqrt(pressed.normal_stiffness) / pressed.overlap
    # a coordinate near 1/2, rounded at a step, changes the velocity by w^2 dt of that, where w^2 dt^2 is looked for
    noise = EPSILON / (_SPEED * _DT * math.sqrt(_STEPS))
    tolerance = swing + noise
    why = "amplitude of the swing over the overlap, on which the stiffness depends, and rounding of the coordinates"
    ratio, across = 2 * (1 - poisson) / (2 - poisson), pressed.normal_stiffness
    judgements = [
        within("round_off", "dF_n/d delta", normal, across, tolerance * across, why),
        *(
            within(
                "round_off", f"dF_t/d xi, {how}", found, pressed.tangential_stiffness,
                noise * pressed.tangential_stiffness, "rounding of the coordinates: the overlap does not change",
            )
            for how, found in zip(("pushed along x", "pushed along -y", "spun"), tangential, strict=True)
        ),
        within(
            "round_off", "tangential over normal stiffness", tangential[0] / normal, ratio, (tolerance + noise) * ratio,
            f"of both: {why}",
        ),
    ]  # fmt: skip
    times = (_DT * np.arange(_STEPS + 1)).tolist()
    figure = Figure(
        "a resting grain, touched lightly",
        "time",
        "velocity over that at the start",
        series=(
            Series(f"nu = {poisson:g}, across the floor", times, (v[:, 0, 2] / _SPEED).tolist()),
            Series(f"nu = {poisson:g}, slip", times, (slips[0] / _SPEED).tolist()),
        ),
    )
    return worst(judgements, f"overlap {pressed.overlap:.3g}, swing {swing:.1g} of it; ratio {ratio:.4g}", (figure,))


CHECKS = (
    Check(
        name="granular/mindlin-stiffness",
        title="Hertz and Mindlin: stiffness of a resting grain across the floor and along it",
        equation="dF_n/d delta = 2 E_eff a, dF_t/d xi = 8 G_eff a, ratio 2 (1 - nu)/(2 - nu)",
        criterion="frequencies of small swings, to their amplitude over the overlap and rounding",
        citation="Mindlin, J. Appl. Mech. 16, 259 (1949); Johnson, Contact Mechanics (1985)",
        judge=_judge,
        variants=variants_of(_RATIOS),
        needs=(
            contact_needs(_CONTACT),
            Needs(
                "hard_spheres",
                words=frozenset({"dimension=3", "hard_spheres.friction", "box.faces.friction", "acceleration"}),
                observables=frozenset({"positions", "velocities", "angular_velocities"}),
            ),
        ),
        faults=(
            (
                "nu=0.3",
                Fault(
                    "spring-of-constant-stiffness",
                    CONTACTS,
                    "stiffness = law[TANGENTIAL_STIFFNESS] * scale",
                    "stiffness = law[TANGENTIAL_STIFFNESS] * (scale + 1e-5)",
                    "the tangential stiffness is not proportional to the circle of contact",
                ),
            ),
        ),
    ),
)
