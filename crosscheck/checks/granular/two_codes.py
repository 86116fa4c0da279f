"""A hundred impacts of soft grains at once, step by step in two codes.

Literature: L. E. Silbert et al., Phys. Rev. E 64, 051302 (2001).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant, variants_of
from crosscheck.checks.granular.impacts import (
    Floats,
    Impacts,
    Law,
    after,
    bodies,
    impact_scene,
    lasting,
    make_impacts,
    rebound,
    wander,
)
from crosscheck.checks.granular.soft_grains import CONTACTS, REFERENCE, contact_needs, soft_needs
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references.soft_impact import SoftContact, stiffness
from crosscheck.scene import Contact
from crosscheck.verdict import Judged, bounded, round_off, worst

#: Contact time of the pairs that are followed step by step, and dt/t_c: long enough that the line of centres turns,
#: and that delta/R, by which the arms of `pair_style granular` are shorter, is seen.
FOLLOWED, FOLLOWED_RESOLUTION = 1e-2, 1 / 50
_PAIRS = 100
#: The other code: every engine is compared with the reference, and that one with LAMMPS.
_PEER = "lammps"


class _Pairs(NamedTuple):
    """What meets, in `dimension` dimensions; name: of the variant, in figures.

    contact: None of smooth grains. unlike: masses and sizes are. wall: grains hit a wall, not each other. own: entries
    of a `scene.Contact` with coefficients of its own, in place of those that give the contact's restitutions; None: it
    has none. begun: steps of the contact that lie before the start, in which grains then overlap.
    """

    name: str
    dimension: int
    contact: SoftContact | None
    unlike: bool = False
    wall: bool = False
    own: dict[str, Any] | None = None
    begun: int = 0


TWO_CODES = (
    _Pairs("2d-history", 2, SoftContact(0.8, -0.5, 0.3, 0.5, "history")),
    _Pairs("2d-dashpot", 2, SoftContact(0.8, 0.3, 0.3, 0.5, "dashpot")),
    _Pairs("2d-wall-history", 2, SoftContact(0.8, -0.5, 0.3, 0.5, "history"), wall=True),
    _Pairs("2d-unlike-smooth", 2, None, unlike=True),
    _Pairs("2d-unlike-history", 2, SoftContact(0.8, -0.5, 0.3, 0.5, "history"), unlike=True),
    _Pairs("3d-history", 3, SoftContact(0.7, -0.6, 0.5, 0.4, "history")),
    _Pairs("3d-unlike-dashpot", 3, SoftContact(0.7, 0.2, 0.5, 0.4, "dashpot"), unlike=True),
    _Pairs("3d-unlike-history", 3, SoftContact(0.7, -0.6, 0.5, 0.4, "history"), unlike=True),
)

#: Coefficients with which grains of mass 1 touch for about `FOLLOWED`, and are damped to a restitution of about 0.7.
_K, _HERTZ_K, _RATE, _HERTZ_RATE = 5e4, 2e6, 70.0, 3e3
_HOOKE = {"k_n": _K, "k_t": 2 / 7 * _K, "gamma_n": _RATE, "gamma_t": 0.5 * _RATE, "mu": 0.4}
_HERTZ = {
    "law": "hertz", "k_n": _HERTZ_K, "k_t": 0.8 * _HERTZ_K, "gamma_n": _HERTZ_RATE, "gamma_t": 0.5 * _HERTZ_RATE,
    "mu": 0.4,
}  # fmt: skip
_MODULI = {"law": "hertz", "E": 1.5 * _HERTZ_K, "nu": 0.3, "mu": 0.4}
_DAMPED = _MODULI | {"gamma_n": _HERTZ_RATE, "gamma_t": 0.5 * _HERTZ_RATE}
_ROUGH = SoftContact(1.0, -1.0, math.inf, 0.4, "history")


def _without(entries: dict[str, Any], **others: Any) -> dict[str, Any]:
    """Entries of a contact with a tangential dashpot in place of the spring."""
    return {name: value for name, value in entries.items() if name != "k_t"} | {"friction": "dashpot", **others}


#: Every style of LAMMPS that has the coefficients of `method.contact`: unlike grains with each other, and on a wall.
OWN_COEFFICIENTS = tuple(
    _Pairs(f"3d-{kind}{'-wall' if wall else ''}", 3, contact, unlike=True, wall=wall, own=own)
    for wall in (False, True)
    for kind, contact, own in (
        ("gran-hooke", _ROUGH, _without(_HOOKE)),
        ("gran-hooke-history", _ROUGH, _HOOKE),
        ("gran-hertz-history", _ROUGH, _HERTZ),
        ("hertz-dashpot", _ROUGH, _without(_HERTZ)),
        ("hertz-mindlin", _ROUGH, _MODULI | {"gamma_n": 0.0, "gamma_t": _HERTZ_RATE}),
        ("hertz-mindlin-damped", _ROUGH, _DAMPED),
        ("hertz-mindlin-restitution", _ROUGH._replace(alpha=0.7), _MODULI),
        (
            "hertz-springs-restitution",
            _ROUGH._replace(alpha=0.7),
            {"law": "hertz", "k_n": _HERTZ_K, "k_t": _HERTZ_K, "mu": 0.4},
        ),
        ("hooke-springs-restitution", _ROUGH._replace(alpha=0.7), {"k_n": _K, "k_t": 0.5 * _K, "mu": 0.4}),
    )
)
#: In the plane, one of each law of the overlap.
PLANE_COEFFICIENTS = (
    _Pairs("2d-gran-hooke-history", 2, _ROUGH._replace(q=0.5), unlike=True, own=_HOOKE),
    _Pairs("2d-hertz-mindlin-damped", 2, _ROUGH._replace(q=0.5), unlike=True, own=_DAMPED),
    _Pairs("2d-hertz-mindlin-damped-wall", 2, _ROUGH._replace(q=0.5), unlike=True, wall=True, own=_DAMPED),
)
#: Runs that start in the contact, with stretches of 0.
BEGUN = (
    _Pairs("3d-begun-gran-hooke-history", 3, _ROUGH, unlike=True, own=_HOOKE, begun=10),
    _Pairs("3d-begun-hertz-mindlin", 3, _ROUGH, unlike=True, own=_DAMPED, begun=10),
    _Pairs("3d-begun-hertz-mindlin-wall", 3, _ROUGH, unlike=True, wall=True, own=_DAMPED, begun=10),
)


def _sensitivity(law: Law, impacts: Impacts) -> float:
    """Change of a velocity by a change of the overlap during a whole contact, over that change, 1/time.

    The steepest force over the displacement, for a contact, over the smallest mass: of "hertz", 3/2 sqrt(R delta) k.
    """
    if law.own is None:
        return (math.pi**2 + math.log(law.alpha) ** 2) / FOLLOWED
    k = law.own.k_n or law.own.E or 0.0
    if law.own.law == "hertz":
        radius = float(impacts.radii.max())
        deepest = (1.25 * float(impacts.reduced.max()) / (k * math.sqrt(radius))) ** 0.4
        k *= 1.5 * math.sqrt(radius * deepest)
    return k * FOLLOWED / float(impacts.reduced.min())


def _judge_two_codes(laboratory: Laboratory, pairs: _Pairs) -> Judged:
    contact, unlike = pairs.contact, pairs.unlike
    rng = np.random.default_rng(laboratory.seed("grains"))
    shape = (_PAIRS, 2)
    masses, diameters = (rng.uniform(0.5, 2.0, shape), rng.choice([0.6, 1.0], shape)) if unlike else (1.0, 1.0)
    impacts = make_impacts(
        pairs.dimension,
        np.zeros(_PAIRS) if contact is None else rng.uniform(0.0, 4.0, _PAIRS),
        laboratory.seed(),
        phases=rng.random(_PAIRS) - 1 - pairs.begun if pairs.begun else None,
        masses=masses,
        diameters=diameters,
        q=None if contact is None else contact.q,
        wall=pairs.wall,
    )
    law = Law(0.7) if contact is None else Law(contact.alpha, contact)
    if pairs.own is not None:
        law = law._replace(own=Contact(**pairs.own))
    dt, steps = FOLLOWED_RESOLUTION * FOLLOWED, lasting(FOLLOWED_RESOLUTION)
    # of the longest contact
    steps = math.ceil(steps * math.sqrt(float(impacts.reduced.max() / impacts.reduced.min())))
    scene = impact_scene(impacts, law, dt, steps, sampled=True)
    method = law.method(stiffness(law.alpha, float(impacts.reduced.min()), FOLLOWED), dt)
    other = _PEER if laboratory.engine == REFERENCE else REFERENCE
    runs = [laboratory.run(scene, method, engine) for engine in (None, other)]

    def differences(name: str, spin: bool = False) -> Floats:
        """The largest of each sample."""
        one, two = (bodies(impacts, run[name], spin) for run in runs)
        return np.asarray(abs(one - two).reshape(len(one), -1).max(axis=1))

    places, velocities = differences("positions"), differences("velocities")
    normal, _ = rebound(impacts, *after(impacts, runs[0]))
    wandered = wander(impacts, steps)
    tolerance = wandered * _sensitivity(law, impacts)
    why = "a coordinate is rounded at every step, a random walk, and overlaps times omega_0^2 t_c are velocities"
    judgements = [
        round_off("largest difference of velocities", float(velocities.max()), tolerance, why),
        round_off(
            "largest difference of positions", float(places.max()), wandered + tolerance * FOLLOWED,
            "rounding of the coordinates, and the velocities' difference for a contact",
        ),
    ]  # fmt: skip
    judgements.append(
        bounded(
            "pairs that have not met and parted", float((normal <= 0).sum()), 0.0,
            "two codes agree on what never touches",
            control=True,
        )
    )  # fmt: skip
    times = (FOLLOWED_RESOLUTION * np.arange(places.size)).tolist()
    curves = [Series(f"{pairs.name}, velocities", times, velocities.tolist())]
    if contact is not None:
        spins = differences("angular_velocities", spin=True)
        curves.append(Series(f"{pairs.name}, spins", times, spins.tolist()))
        radius = float(impacts.radii[impacts.radii > 0].min())
        judgements.append(
            round_off(
                "largest difference of spins", float(spins.max()), tolerance / (contact.q * radius),
                f"{why}, and R w changes by 1/q as much",
            )
        )  # fmt: skip
    figure = Figure("two codes, step by step", "time / t_c", "largest difference", "linear", "log", tuple(curves))
    kinds = "unlike masses and sizes" if unlike else "like grains"
    note = f"{_PAIRS} impacts at once, {kinds}, {steps} steps, coordinates up to {impacts.size:.0f}"
    return worst(judgements, note, (figure,))


CHECKS = (
    Check(
        name="granular/two-codes",
        title="A hundred impacts at once, step by step in two codes",
        equation="gran/hooke, gran/hooke/history and pair_style granular of LAMMPS",
        criterion="positions, velocities and spins at every step, to rounding",
        citation="Silbert et al., Phys. Rev. E 64, 051302 (2001)",
        judge=_judge_two_codes,
        variants=(
            *variants_of({pairs.name: pairs for pairs in TWO_CODES}, "full"),
            *(
                Variant(
                    pairs.name,
                    pairs,
                    "full" if pairs in PLANE_COEFFICIENTS else "quick",
                    contact_needs(Contact(**pairs.own)),
                )
                for pairs in (*OWN_COEFFICIENTS, *PLANE_COEFFICIENTS, *BEGUN)
                if pairs.own is not None
            ),
        ),
        needs=soft_needs("method.contact.stiffness hard_spheres.restitution", "positions velocities"),
        faults=(
            (
                "2d-unlike-history",
                Fault(
                    "torque-on-the-other-arm",
                    CONTACTS,
                    "_add_torque(d, spins, a, j, inverse_inertias[j] * (radii[j] - shorter), twist)",
                    "_add_torque(d, spins, a, j, inverse_inertias[j] * (radii[i] - shorter), twist)",
                    "the torque on the second grain has the arm of the first",
                ),
            ),
            (
                "3d-gran-hertz-history",
                Fault(
                    "rate-without-the-circle",
                    CONTACTS,
                    "return coefficient * mass * scale",
                    "return coefficient * mass",
                    "the damping gamma m_eff of Hertz's contact does not grow with the circle of contact",
                ),
            ),
            (
                "3d-hertz-mindlin-damped-wall",
                Fault(
                    "wall-as-curved-as-a-grain",
                    CONTACTS,
                    "scale = _scale(model, delta, radii[i])",
                    "scale = _scale(model, delta, 0.5 * radii[i])",
                    "R_eff of a grain on a plane wall is that of two grains",
                ),
            ),
        ),
    ),
)
