"""Hard spheres as spheres that overlap: the contact laws that give a scene's restitution and friction.

Two grains of reduced mass m_eff that overlap by delta, with the relative velocity v_n along the normal and u along the
surfaces, push each other apart with

    F_n = k delta - eta_n v_n,        eta_n = c sqrt(m_eff k),       c = 2 |ln alpha|/sqrt(pi^2 + ln^2 alpha),

and touch for t_c = sqrt((pi^2 + ln^2 alpha) m_eff/k), whatever their speed; alpha is the same for all masses. Along the
surfaces there is a force up to mu |F_n|, and below it

    "history"   F_t = -k_t xi, xi the tangential stretch,   k_t/k = q/(1 + q) arccos^2(alpha_t)/(pi^2 + ln^2 alpha),
    "dashpot"   F_t = -c_t sqrt(m_eff k) u,                 c_t = -q/(1 + q) ln(alpha_t)/sqrt(pi^2 + ln^2 alpha).

A contact that sticks throughout (mu = infinity) then ends with u' = alpha_t u: the tangential mass is m_eff q/(1 + q),
I = q m R^2, the stretch turns through arccos(alpha_t) and the dashpot slows by alpha_t in t_c. With a limit mu the law
is nobody's hard rule, not even for t_c -> 0: F_n passes zero before the end and attracts afterwards, so that every
contact slides for a while, and the limit takes |F_n|, so that a contact that slides throughout has J_t = mu int |F_n|,
a little more than mu J_n. `crosscheck.references.soft_impact` has the outcome in closed form or to rounding, and its
distance from Walton's rule: 0 for alpha = 1 and alpha_t = -1 ("history"), else largest where sticking ends.

"hertz": F_n = k sqrt(R_eff delta) delta - eta_n v_n with eta_n = c sqrt(m_eff k) (R_eff delta)^(1/4) and
c = sqrt(5) |ln alpha|/sqrt(pi^2 + ln^2 alpha), which too gives an alpha that does not depend on the speed.

Literature: P. A. Cundall and O. D. L. Strack, Geotechnique 29, 47 (1979); Y. Tsuji, T. Tanaka and T. Ishida, Powder
Technol. 71, 239 (1992); J. Schaefer, S. Dippel and D. E. Wolf, J. Phys. I France 6, 5 (1996); D. Antypov and J. A.
Elliott, Europhys. Lett. 94, 50004 (2011).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from crosscheck.errors import UsageError
from crosscheck.scene import Contact, Friction, Method, Scene


class Law(NamedTuple):
    """Numbers of one kind of contact, as in the module's equations: k, c, k_t, c_t, mu (infinity: no limit)."""

    stiffness: float
    damping: float
    tangential_stiffness: float = 0.0
    tangential_damping: float = 0.0
    friction: float = 0.0


class SoftSpheres(NamedTuple):
    """Laws of pairs, of the plane walls (None: no wall) in the order of `Scene.faces`, and of the cylinder."""

    pair: Law
    faces: tuple[Law | None, ...]
    cylinder: Law | None


def soft_spheres(scene: Scene, contact: Contact) -> SoftSpheres:
    """The contact laws of a scene of hard spheres that `unsupported` accepts. The stiffness is the same everywhere."""
    spheres = scene.hard_spheres
    assert spheres is not None
    stiffness, inertia = contact_stiffness(scene, contact), inertia_ratio(scene)

    def law(restitution: float, friction: Friction | None) -> Law:
        log = math.log(restitution)
        decay = math.pi**2 + log**2
        damping = (2.0 if contact.law == "hooke" else math.sqrt(5.0)) * abs(log) / math.sqrt(decay)
        if friction is None or friction.tangential_restitution == 1:
            return Law(stiffness, damping)
        limit = math.inf if friction.sliding is None else friction.sliding
        share, alpha_t = inertia / (1 + inertia), friction.tangential_restitution
        if contact.friction == "history":
            return Law(stiffness, damping, stiffness * share * math.acos(alpha_t) ** 2 / decay, 0.0, limit)
        return Law(stiffness, damping, 0.0, -share * math.log(alpha_t) / math.sqrt(decay), limit)

    cylinder = None if scene.box is None else scene.box.cylinder
    return SoftSpheres(
        law(spheres.restitution, spheres.friction),
        tuple(None if face is None else law(face.restitution, face.friction) for face in scene.faces),
        None if cylinder is None else law(cylinder.restitution, cylinder.friction),
    )


def contact_stiffness(scene: Scene, contact: Contact) -> float:
    """k of a contact."""
    if contact.stiffness is not None:
        return contact.stiffness
    assert contact.duration is not None
    return _duration_times_root(scene) ** 2 / contact.duration**2


def contact_duration(scene: Scene, contact: Contact) -> float:
    """t_c of two grains of the smallest mass, of "hooke"."""
    if contact.duration is not None:
        return contact.duration
    assert contact.stiffness is not None
    return _duration_times_root(scene) / math.sqrt(contact.stiffness)


def _duration_times_root(scene: Scene) -> float:
    """t_c sqrt(k) of two grains of the smallest mass."""
    assert scene.hard_spheres is not None
    decay = math.pi**2 + math.log(scene.hard_spheres.restitution) ** 2
    return math.sqrt(decay * float(np.min(scene.masses)) / 2)


def inertia_ratio(scene: Scene) -> float:
    """q in I = q m R^2: the scene's, or that of a solid sphere or disk."""
    friction = None if scene.hard_spheres is None else scene.hard_spheres.friction
    if friction is not None and friction.inertia is not None:
        return friction.inertia
    return 0.5 if scene.dimension == 2 else 0.4


def resolved(scene: Scene, method: Method) -> Method:
    """The method with its time step: of `contact.resolution`, the largest up to it that divides the samples' interval.

    Raises UsageError if the scene has no hard spheres, or these never separate.
    """
    contact = method.contact
    if contact is None:
        return method
    if scene.hard_spheres is None:
        raise UsageError("method.contact says how [hard_spheres] touch, and the scene has none: remove it")
    if contact.resolution is None:
        return method
    if scene.hard_spheres.restitution == 0:
        raise UsageError("method.contact.resolution needs a restitution above 0: give method.dt")
    records = scene.output.interval is not None and (scene.output.observables or scene.output.trajectory)
    span = scene.output.interval if records else scene.duration
    assert span is not None
    steps = max(1, math.ceil(span / (contact.resolution * contact_duration(scene, contact)) * (1 - 1e-12)))
    # by hand: a copy would not be validated, and both entries together are refused
    return Method(
        scheme=method.scheme,
        dt=span / steps if span > 0 else contact_duration(scene, contact),
        contact=contact.model_copy(update={"resolution": None}),
    )


def unsupported(scene: Scene, method: Method) -> str | None:
    """None, or the reason why the hard spheres of a scene cannot be softened with this contact."""
    spheres, contact = scene.hard_spheres, method.contact
    assert spheres is not None
    if contact is None:
        return "hard spheres need an event-driven scheme, or method.contact, which says how soft they may be"
    restitutions = [spheres.restitution, *(face.restitution for face in scene.faces if face is not None)]
    frictions: list[Friction | None] = [spheres.friction, *(face.friction for face in scene.faces if face is not None)]
    if scene.box is not None and scene.box.cylinder is not None:
        restitutions.append(scene.box.cylinder.restitution)
        frictions.append(scene.box.cylinder.friction)
    if 0.0 in restitutions:
        return "a spring with a dashpot never stops the grains for good: restitution 0 needs an event-driven scheme"
    if 0.0 in np.atleast_1d(spheres.diameter):
        return "soft spheres have no hard_spheres.diameter = 0"
    for friction in filter(None, frictions):
        if friction.static != friction.sliding:
            return "a soft contact has one coefficient of friction: static and sliding must be equal"
        if contact.law == "hertz" and friction.tangential_restitution != 1:
            return 'contact.law = "hertz" has no closed form for a tangential restitution: take "hooke"'
        if contact.friction == "dashpot" and friction.tangential_restitution <= 0:
            return 'contact.friction = "dashpot" never turns the slip round: tangential_restitution must be above 0'
    return None
