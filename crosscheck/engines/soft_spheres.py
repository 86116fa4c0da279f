"""Hard spheres as spheres that overlap: the contact laws that give a scene's restitution and friction.

Two grains of reduced mass m_eff that overlap by delta, with the relative velocity v_n along the normal and u along the
surfaces, push each other apart with

    F_n = k delta - eta_n v_n,        eta_n = c sqrt(m_eff k),       c = 2 |ln alpha|/sqrt(pi^2 + ln^2 alpha),

and touch for t_c = sqrt((pi^2 + ln^2 alpha) m_eff/k), whatever their speed; alpha is the same for all masses. Along the
surfaces there is a force up to mu |F_n|, and below it

    "history"   F_t = -k_t xi, xi the tangential stretch,   k_t/k = q/(1 + q) arccos^2(alpha_t)/(pi^2 + ln^2 alpha),
    "dashpot"   F_t = -c_t sqrt(m_eff k) u,                 c_t = -q/(1 + q) ln(alpha_t)/sqrt(pi^2 + ln^2 alpha).

A contact that sticks throughout (mu = infinity) then ends with u' = alpha_t u: the tangential mass is m_eff q/(1 + q),
I = q m R^2; within t_c the stretch goes through the phase arccos(alpha_t) of its oscillation, or the dashpot reduces u
by the factor alpha_t. With a finite limit mu the law does not tend to a collision rule of hard spheres, not even for
t_c -> 0: F_n passes zero before the end and attracts afterwards, so that every contact slides for a while; and the
limit is mu |F_n|, so that a contact that slides throughout has J_t = mu int |F_n| dt, a little more than mu J_n.
`crosscheck.references.soft_impact` has the outcome in closed form or to rounding, and its distance from Walton's rule:
0 for alpha = 1 and alpha_t = -1 ("history"), else largest where sticking ends.

"hertz": F_n = k sqrt(R_eff delta) delta - eta_n v_n with eta_n = c sqrt(m_eff k) (R_eff delta)^(1/4) and
c = sqrt(5) |ln alpha|/sqrt(pi^2 + ln^2 alpha), with which alpha does not depend on the speed either.

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
from crosscheck.scene.parts import LEAST


class ContactLaw(NamedTuple):
    """Parameters of one kind of contact, in the equations of this module.

    stiffness: k, mass/time^2 ("hertz": mass/(length time^2)). damping: c, a number. tangential_stiffness: k_t,
    mass/time^2. tangential_damping: c_t, a number. friction: mu, a number; infinity: no limit.
    """

    stiffness: float
    damping: float
    tangential_stiffness: float = 0.0
    tangential_damping: float = 0.0
    friction: float = 0.0


class SoftSpheres(NamedTuple):
    """The contact laws of a scene.

    pair: of two particles. faces: of the plane walls, in the order of `Scene.faces`; None: no wall. cylinder: of the
    cylinder; None: there is none.
    """

    pair: ContactLaw
    faces: tuple[ContactLaw | None, ...]
    cylinder: ContactLaw | None


def soft_spheres(scene: Scene, contact: Contact) -> SoftSpheres:
    """The contact laws of a scene of hard spheres that `unsupported` accepts; all have the same stiffness.

    scene: gives restitutions, friction, masses and walls. contact: gives the law, and stiffness or duration.
    """
    spheres = scene.hard_spheres
    assert spheres is not None
    stiffness, inertia = contact_stiffness(scene, contact), inertia_ratio(scene)

    def law(restitution: float, friction: Friction | None) -> ContactLaw:
        log = math.log(restitution)
        decay = math.pi**2 + log**2
        damping = (2.0 if contact.law == "hooke" else math.sqrt(5.0)) * abs(log) / math.sqrt(decay)
        if friction is None or friction.tangential_restitution == 1:
            return ContactLaw(stiffness, damping)
        limit = math.inf if friction.sliding is None else friction.sliding
        share, alpha_t = inertia / (1 + inertia), friction.tangential_restitution
        if contact.friction == "history":
            return ContactLaw(stiffness, damping, stiffness * share * math.acos(alpha_t) ** 2 / decay, 0.0, limit)
        return ContactLaw(stiffness, damping, 0.0, -share * math.log(alpha_t) / math.sqrt(decay), limit)

    cylinder = None if scene.box is None else scene.box.cylinder
    return SoftSpheres(
        law(spheres.restitution, spheres.friction),
        tuple(None if face is None else law(face.restitution, face.friction) for face in scene.faces),
        None if cylinder is None else law(cylinder.restitution, cylinder.friction),
    )


def contact_stiffness(scene: Scene, contact: Contact) -> float:
    """Stiffness k of all contacts, mass/time^2 ("hertz": mass/(length time^2)).

    contact: gives it, or the duration from which it follows. scene: gives smallest mass and restitution for that.
    """
    if contact.stiffness is not None:
        return contact.stiffness
    assert contact.duration is not None
    return _duration_times_root_stiffness(scene) ** 2 / contact.duration**2


def contact_duration(scene: Scene, contact: Contact) -> float:
    """Duration t_c of a contact of two particles of the smallest mass, in units of time; for the law "hooke".

    contact: gives it, or the stiffness from which it follows. scene: gives smallest mass and restitution for that.
    """
    if contact.duration is not None:
        return contact.duration
    assert contact.stiffness is not None
    return _duration_times_root_stiffness(scene) / math.sqrt(contact.stiffness)


def _duration_times_root_stiffness(scene: Scene) -> float:
    """t_c sqrt(k) of two particles of the smallest mass: sqrt((pi^2 + ln^2 alpha) m/2)."""
    assert scene.hard_spheres is not None
    decay = math.pi**2 + math.log(scene.hard_spheres.restitution) ** 2
    return math.sqrt(decay * float(np.min(scene.masses)) / 2)


def inertia_ratio(scene: Scene) -> float:
    """q in the moment of inertia I = q m R^2: that of `scene`, or by default that of a solid sphere or disk."""
    friction = None if scene.hard_spheres is None else scene.hard_spheres.friction
    if friction is not None and friction.inertia is not None:
        return friction.inertia
    return 0.5 if scene.dimension == 2 else 0.4


def resolved(scene: Scene, method: Method) -> Method:
    """The method with `dt` in place of `contact.resolution`; other methods are returned as they are.

    dt is the largest step up to resolution * t_c that divides the time between samples (or the duration, if there are
    none). scene: gives t_c and that time. method: as the user wrote it. UsageError if there is a contact but the scene
    has no hard spheres, if their restitution is 0, for which t_c is infinite, or if the steps cannot be counted.
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
    longest = contact.resolution * contact_duration(scene, contact)
    if longest < LEAST or span / longest > 2**53:
        raise UsageError(f"method.contact: steps of {longest:.3g} are too many to be counted: take softer contacts")
    steps = max(1, math.ceil(span / longest * (1 - 1e-12)))
    # a new method, not a copy with both entries changed: copies are not validated
    return Method(
        scheme=method.scheme,
        dt=span / steps if span > 0 else contact_duration(scene, contact),
        contact=contact.model_copy(update={"resolution": None}),
    )


def unsupported(scene: Scene, method: Method) -> str | None:
    """None, or the reason why the hard spheres of `scene` have no soft contact law as `method.contact` asks for it."""
    spheres, contact = scene.hard_spheres, method.contact
    assert spheres is not None
    if contact is None:
        return "hard spheres need an event-driven scheme, or method.contact, a contact law for soft spheres"
    restitutions = [spheres.restitution, *(face.restitution for face in scene.faces if face is not None)]
    frictions: list[Friction | None] = [spheres.friction, *(face.friction for face in scene.faces if face is not None)]
    if scene.box is not None and scene.box.cylinder is not None:
        restitutions.append(scene.box.cylinder.restitution)
        frictions.append(scene.box.cylinder.friction)
    if 0.0 in restitutions:
        return "no spring with a dashpot gives a restitution of 0: restitution 0 needs an event-driven scheme"
    if 0.0 in np.atleast_1d(spheres.diameter):
        return "soft spheres have no hard_spheres.diameter = 0"
    for friction in filter(None, frictions):
        if friction.static != friction.sliding:
            return "a soft contact has one coefficient of friction: static and sliding must be equal"
        if contact.law == "hertz" and friction.tangential_restitution != 1:
            return 'contact.law = "hertz" has no closed form for a tangential restitution: take "hooke"'
        if contact.friction == "dashpot" and friction.tangential_restitution <= 0:
            return 'contact.friction = "dashpot" cannot reverse the slip: tangential_restitution must be above 0'
    return None
