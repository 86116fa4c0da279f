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

A contact may have coefficients of its own instead, the same for pairs and walls: with s = 1 or sqrt(R_eff delta),

    F_n = s k_n delta - eta_n v_n,        F_t = -s k_t xi - eta_t u, or -eta_t u ("dashpot"), up to mu |F_n|,

and eta_n = s gamma_n m_eff, eta_t = s gamma_t m_eff; without gamma_n, eta_n is the one above that gives alpha. Bodies
of one material, of Young's modulus E and Poisson's ratio nu, touch on a circle of the radius sqrt(R_eff delta), and
have 1/E_eff = 2 (1 - nu^2)/E and 1/G_eff = 4 (1 + nu) (2 - nu)/E, so that k_n = 4 E_eff/3 and k_t = 8 G_eff (Hertz;
Mindlin without slip). The stiffness of a small tangential displacement is 2 (1 - nu)/(2 - nu) of the normal one.

Literature: P. A. Cundall and O. D. L. Strack, Geotechnique 29, 47 (1979); Y. Tsuji, T. Tanaka and T. Ishida, Powder
Technol. 71, 239 (1992); J. Schaefer, S. Dippel and D. E. Wolf, J. Phys. I France 6, 5 (1996); D. Antypov and J. A.
Elliott, Europhys. Lett. 94, 50004 (2011); R. D. Mindlin, J. Appl. Mech. 16, 259 (1949); K. L. Johnson, Contact
Mechanics, sections 4.2 and 7.2 (Cambridge, 1985).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from crosscheck.errors import UsageError
from crosscheck.scene import Contact, Floats, Friction, Method, Scene
from crosscheck.scene.parts import LEAST

#: Fewer steps than this in a contact are remarked upon.
_FEW_STEPS = 10
#: Contact time of "hertz" without damping over largest overlap/speed: 4 sqrt(pi) Gamma(2/5)/(5 Gamma(9/10)).
_HERTZ_TIME = 2.943


class ContactLaw(NamedTuple):
    """Parameters of one kind of contact, in the equations of this module.

    stiffness: k or k_n, mass/time^2 ("hertz": mass/(length time^2)). damping: c, a number; or gamma_n, 1/time ("hertz":
    1/(length time)). tangential_stiffness: k_t, as `stiffness`. tangential_damping: c_t or gamma_t, as `damping`.
    friction: mu, a number; infinity: no limit.
    """

    stiffness: float
    damping: float
    tangential_stiffness: float = 0.0
    tangential_damping: float = 0.0
    friction: float = 0.0


class SoftSpheres(NamedTuple):
    """The contact laws of a scene.

    pair: of two particles. faces: of the plane walls, in the order of `Scene.faces`; None: no wall. cylinder: of the
    cylinder; None: there is none. by_mass: the laws hold gamma_n and gamma_t, times m_eff; else the numbers c and c_t.
    granular: pairs follow `pair_style granular` of LAMMPS, whose tangential springs turn with the contact before they
    are stretched, and whose torques have the arms R - delta/2; else its styles gran/..., with the arms R.
    """

    pair: ContactLaw
    faces: tuple[ContactLaw | None, ...]
    cylinder: ContactLaw | None
    by_mass: bool = False
    granular: bool = False


def soft_spheres(scene: Scene, contact: Contact) -> SoftSpheres:
    """The contact laws of a scene of hard spheres that `unsupported` accepts; all have the same stiffness.

    scene: gives restitutions, friction, masses and walls. contact: gives the law, and stiffness or duration, or
    coefficients of its own.
    """
    spheres = scene.hard_spheres
    assert spheres is not None
    stiffness, inertia = contact_stiffness(scene, contact), inertia_ratio(scene)

    def law(restitution: float, friction: Friction | None) -> ContactLaw:
        log = math.log(restitution) if contact.gamma_n is None else 0.0
        decay = math.pi**2 + log**2
        damping = (2.0 if contact.law == "hooke" else math.sqrt(5.0)) * abs(log) / math.sqrt(decay)
        if contact.gamma_n is not None:
            damping = contact.gamma_n
        if friction is None or friction.tangential_restitution == 1:
            return ContactLaw(stiffness, damping)
        limit = math.inf if friction.sliding is None else friction.sliding
        if contact.own:
            limit = limit if contact.mu is None else contact.mu
            return ContactLaw(stiffness, damping, _tangential_stiffness(contact), contact.gamma_t or 0.0, limit)
        share, alpha_t = inertia / (1 + inertia), friction.tangential_restitution
        if contact.friction == "history":
            return ContactLaw(stiffness, damping, stiffness * share * math.acos(alpha_t) ** 2 / decay, 0.0, limit)
        return ContactLaw(stiffness, damping, 0.0, -share * math.log(alpha_t) / math.sqrt(decay), limit)

    cylinder = None if scene.box is None else scene.box.cylinder
    return SoftSpheres(
        law(spheres.restitution, spheres.friction),
        tuple(None if face is None else law(face.restitution, face.friction) for face in scene.faces),
        None if cylinder is None else law(cylinder.restitution, cylinder.friction),
        contact.gamma_n is not None,
        _granular_pairs(scene, contact),
    )


def _granular_pairs(scene: Scene, contact: Contact) -> bool:
    """Whether pairs follow `pair_style granular`: it has the laws that LAMMPS's faster styles gran/... have not."""
    if contact.gamma_n is not None:
        return contact.E is not None or (contact.law, contact.friction) == ("hertz", "dashpot")
    # eta_n = c sqrt(m_eff k) is a rate gamma times m_eff for grains of one mass only
    return contact.law == "hertz" or np.unique(scene.masses).size > 1


def _tangential_stiffness(contact: Contact) -> float:
    """k_t of a contact with coefficients of its own."""
    if contact.E is not None and contact.nu is not None:
        return 2 * contact.E / ((1 + contact.nu) * (2 - contact.nu))
    return contact.k_t or 0.0


def contact_stiffness(scene: Scene, contact: Contact) -> float:
    """Stiffness k of all contacts, mass/time^2 ("hertz": mass/(length time^2)).

    contact: gives it, or the duration or the moduli from which it follows. scene: gives smallest mass and restitution
    for a duration.
    """
    if contact.E is not None and contact.nu is not None:
        return 2 * contact.E / (3 * (1 - contact.nu**2))
    if contact.duration is None:
        given = contact.k_n or contact.stiffness
        assert given is not None
        return given
    return _duration_times_root_stiffness(scene) ** 2 / contact.duration**2


def contact_duration(scene: Scene, contact: Contact) -> float:
    """Duration t_c of a contact of two particles of the smallest mass, in units of time; for the law "hooke".

    contact: gives it, or the stiffness (and gamma_n) from which it follows. scene: gives smallest mass and restitution
    for that. Infinite if gamma_n is so large that the contact does not end.
    """
    if contact.duration is not None:
        return contact.duration
    stiffness = contact_stiffness(scene, contact)
    if contact.gamma_n is None:
        return _duration_times_root_stiffness(scene) / math.sqrt(stiffness)
    square = 2 * stiffness / float(np.min(scene.masses)) - contact.gamma_n**2 / 4
    return math.pi / math.sqrt(square) if square > 0 else math.inf


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
    has no hard spheres, if both say what a contact dissipates or how rough it is, if a coefficient of the contact is
    missing, if t_c is infinite, as with a restitution of 0, or if the steps cannot be counted.
    """
    contact = method.contact
    if contact is None:
        return method
    if scene.hard_spheres is None:
        raise UsageError("method.contact says how [hard_spheres] touch, and the scene has none: remove it")
    if contact.own:
        _check_coefficients(scene, contact)
    if contact.resolution is None:
        return method
    if scene.hard_spheres.restitution == 0:
        raise UsageError("method.contact.resolution needs a restitution above 0: give method.dt")
    if math.isinf(contact_duration(scene, contact)):
        raise UsageError(
            f"method.contact.gamma_n = {contact.gamma_n:g} is so large that contacts do not end, and have no duration: "
            "give method.dt in place of method.contact.resolution"
        )
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


def _surfaces(scene: Scene) -> Iterator[tuple[str, float, Friction | None]]:
    """Of pairs, of each face and of the cylinder: name of the table, restitution, and friction."""
    assert scene.hard_spheres is not None
    yield "hard_spheres", scene.hard_spheres.restitution, scene.hard_spheres.friction
    for name, face in zip((f"{axis}{side}" for axis in "xyz" for side in "-+"), scene.faces, strict=False):
        if face is not None:
            yield f'box.faces."{name}"', face.restitution, face.friction
    if scene.box is not None and scene.box.cylinder is not None:
        yield "box.cylinder", scene.box.cylinder.restitution, scene.box.cylinder.friction


def _check_coefficients(scene: Scene, contact: Contact) -> None:
    """UsageError if coefficients of the contact's own contradict the scene, or one of them is missing."""
    tangential = [name for name in ("k_t", "gamma_t", "mu") if getattr(contact, name) is not None]
    if tangential and scene.spin_dimension == 0:
        raise UsageError(f"method.contact.{tangential[0]}: smooth grains: add [hard_spheres.friction], or remove it")
    for name, restitution, friction in _surfaces(scene):
        if contact.gamma_n is not None and restitution != 1:
            raise UsageError(
                f"method.contact.gamma_n and {name}.restitution = {restitution:g} both say what a contact dissipates: "
                "remove one of them"
            )
        if contact.mu is not None and friction is not None and friction.sliding is not None:
            raise UsageError(
                f"method.contact.mu and {name}.friction.sliding = {friction.sliding:g} both limit the friction: "
                "remove mu, or static and sliding"
            )
    if scene.spin_dimension and contact.friction == "history" and not _tangential_stiffness(contact):
        raise UsageError(
            'method.contact.k_t is missing: with k_n, friction = "history" is a spring of this stiffness: add it, as '
            f"k_t = {2 * contact_stiffness(scene, contact) / 7:.6g} (2/7 of k_n)"
        )
    if scene.spin_dimension and contact.friction == "dashpot" and contact.gamma_t is None:
        raise UsageError('method.contact.gamma_t is missing: with k_n, friction = "dashpot" is this damping: add it')


def remarks(scene: Scene, method: Method, velocities: Floats) -> list[str]:
    """What a user must know of a run with soft spheres: numbers of the scene that it does not use, and long time steps.

    scene: accepted by `unsupported`. method: gives contact and dt. velocities: at the start, (N, d), length/time; with
    "hertz", two grains that meet with twice the largest speed have the shortest contact that is looked for.
    """
    contact, friction = method.contact, None if scene.hard_spheres is None else scene.hard_spheres.friction
    assert contact is not None
    found = []
    if contact.own and friction is not None and friction.tangential_restitution not in (-1.0, 1.0):
        found.append(
            "The tangential restitution is not used but for 1 (smooth): method.contact has coefficients of its own."
        )
    shortest = _shortest_contact(scene, contact, 2 * float(np.linalg.norm(velocities, axis=1).max(initial=0.0)))
    if method.dt is not None and method.dt * _FEW_STEPS > shortest:
        found.append(
            f"method.dt = {method.dt:g} is {method.dt / shortest:.2g} of the shortest contact, {shortest:.3g}: what a "
            f"contact does needs more than {_FEW_STEPS} steps."
        )
    return found


def _shortest_contact(scene: Scene, contact: Contact, speed: float) -> float:
    """Duration of a contact of two of the lightest grains, or half a period of their tangential spring; time.

    speed: of approach, length/time. "hertz": without damping, which makes contacts longer; infinite for speed 0.
    """
    mass = float(np.min(scene.masses)) / 2
    if contact.law == "hooke":
        shortest, scale = contact_duration(scene, contact), 1.0
    else:
        diameters = np.atleast_1d(np.asarray(scene.diameters()))
        radius, k = float(diameters.max()) / 4, contact_stiffness(scene, contact)
        overlap = (1.25 * mass * speed**2 / (k * math.sqrt(radius))) ** 0.4
        shortest, scale = (_HERTZ_TIME * overlap / speed if speed > 0 else math.inf), math.sqrt(radius * overlap)
    k_t = _tangential_stiffness(contact) * scale if contact.own and scene.spin_dimension else 0.0
    if k_t > 0:
        q = inertia_ratio(scene)
        shortest = min(shortest, math.pi * math.sqrt(mass * q / (1 + q) / k_t))
    return shortest


def unsupported(scene: Scene, method: Method) -> str | None:
    """None, or the reason why the hard spheres of `scene` have no soft contact law as `method.contact` asks for it."""
    spheres, contact = scene.hard_spheres, method.contact
    assert spheres is not None
    if contact is None:
        return "hard spheres need an event-driven scheme, or method.contact, a contact law for soft spheres"
    _, restitutions, frictions = zip(*_surfaces(scene), strict=True)
    if 0.0 in restitutions:
        return "no spring with a dashpot gives a restitution of 0: restitution 0 needs an event-driven scheme"
    if 0.0 in np.atleast_1d(spheres.diameter):
        return "soft spheres have no hard_spheres.diameter = 0"
    for friction in filter(None, frictions):
        if friction.static != friction.sliding:
            return "a soft contact has one coefficient of friction: static and sliding must be equal"
        if contact.own:
            continue
        if contact.law == "hertz" and friction.tangential_restitution != 1:
            return (
                'contact.law = "hertz" has no closed form for a tangential restitution: take "hooke", or give k_n and '
                "k_t, or E and nu"
            )
        if contact.friction == "dashpot" and friction.tangential_restitution <= 0:
            return 'contact.friction = "dashpot" cannot reverse the slip: tangential_restitution must be above 0'
    return None
