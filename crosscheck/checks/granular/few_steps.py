"""How long the shortest contact of soft grains is: steps chosen by it, and remarks where it has too few of them.

And the remark on a restitution that a contact with coefficients of its own does not use.
"""

from __future__ import annotations

import math
import re
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.granular.soft_grains import soft_needs
from crosscheck.checks.operations import exactly
from crosscheck.engines.capabilities import Needs, words
from crosscheck.faults import Fault
from crosscheck.references.soft_impact import HertzImpact, HookeImpact, stiffness
from crosscheck.scene import Contact, GrainFriction, HardSpheres, Method, Output, Scene, explicit
from crosscheck.verdict import Judged, Judgement, round_off, worst

#: Masses and diameters of three grains, none of them 1, the velocity of the fastest, and the restitution.
_MASSES, _DIAMETERS = (0.6, 2.3, 1.7), (0.7, 1.3)
_VELOCITY, _ALPHA = (1.2, -0.5), 0.6
#: Of two of the lightest; and the speed at which two of the fastest would meet.
_REDUCED, _SPEED = min(_MASSES) / 2, 2 * math.hypot(*_VELOCITY)
#: Duration of the linear contacts, k of "hertz", and q of a disk.
_DURATION, _HERTZ_K, _DISK = 0.037, 4.1e4, 0.5
#: Steps in a contact that an engine need not remark upon, and that it must, of the ten that a contact needs.
_ENOUGH, _FEW = 10.1, 9.9
#: Share of the contact that a step may take, and the time between samples and their number.
_RESOLUTION, _INTERVAL, _SAMPLES = 1 / 17.3, 0.11, 3
_REMARK = re.compile(r"method\.dt = (\S+) is (\S+) of the shortest contact, (\S+):")
_UNUSED = "tangential restitution is not used"
_WHY = "a number is printed with so many digits"


class _Contact(NamedTuple):
    """A contact, and the shortest time for which it lasts, or half a period of its tangential spring.

    alpha, alpha_t: restitutions of the grains; alpha_t = 1: they are smooth. unused: alpha_t is given, and says nothing
    of the contact. resolved: steps are chosen by the contact.
    """

    contact: Contact
    shortest: float
    alpha: float = 1.0
    alpha_t: float = 1.0
    unused: bool = False
    resolved: bool = False


def _half_period(k_t: float) -> float:
    """Of the tangential spring of two of the lightest grains, whose tangential mass is m q/(1 + q)."""
    return math.pi * math.sqrt(_REDUCED * _DISK / (1 + _DISK) / k_t)


def _contacts() -> dict[str, _Contact]:
    """By the names of variants."""
    k = stiffness(_ALPHA, _REDUCED, _DURATION)
    undamped = HookeImpact(_REDUCED, k, 1.0, 1.0).contact_time
    # R_eff of two of the largest
    hertz = HertzImpact(_REDUCED, _HERTZ_K, max(_DIAMETERS) / 4, _SPEED, 1.0)
    # damped by gamma m_eff: omega^2 = k/m - gamma^2/4
    gamma = 1.3 * math.sqrt(k / _REDUCED)
    damped = math.pi / math.sqrt(k / _REDUCED - gamma**2 / 4)
    return {
        "duration": _Contact(Contact(duration=_DURATION), _DURATION, _ALPHA),
        "stiffness": _Contact(Contact(stiffness=k), _DURATION, _ALPHA),
        "own": _Contact(Contact(k_n=k), undamped),
        "own-rates": _Contact(Contact(k_n=k, gamma_n=gamma), damped),
        "own-spring": _Contact(Contact(k_n=k, k_t=3.1 * k), _half_period(3.1 * k), alpha_t=-0.5, unused=True),
        "own-soft-spring": _Contact(Contact(k_n=k, k_t=0.2 * k), undamped, alpha_t=-1.0),
        "hertz": _Contact(Contact(law="hertz", k_n=_HERTZ_K), hertz.contact_time),
        "resolved-duration": _Contact(Contact(duration=_DURATION), _DURATION, _ALPHA, resolved=True),
        "resolved-stiffness": _Contact(Contact(stiffness=k), _DURATION, _ALPHA, resolved=True),
    }


_CONTACTS = _contacts()


def _scene(one: _Contact, duration: float, interval: float | None) -> Scene:
    """Three disks that fly apart; what is asked of them are steps and remarks."""
    friction = GrainFriction(tangential_restitution=one.alpha_t, static=0.3, sliding=0.3) if one.alpha_t < 1 else None
    x = np.array([[0.0, 0.0], [3.0, 0.2], [-3.0, 0.4]])
    v = np.array([[0.1, 0.3], _VELOCITY, [-0.2, 0.1]])
    return Scene(
        name="few-steps",
        dimension=2,
        duration=duration,
        masses=_MASSES,
        species=(0, 1, 1),
        hard_spheres=HardSpheres(diameter=_DIAMETERS, restitution=one.alpha, friction=friction),
        initial=explicit(x, v),
        output=Output(interval=interval, trajectory=interval is not None),
    )


def _units(text: str, digits: int, expected: float) -> float:
    """How far a printed number is off, in units of its last digit; digits: with how many significant ones."""
    try:
        return abs(float(text) - expected) / 10.0 ** (math.floor(math.log10(expected)) - digits + 1)
    except ValueError:
        return math.nan


def _judge_remarks(laboratory: Laboratory, one: _Contact) -> Judged:
    judgements: list[Judgement] = []
    for steps, wanted in ((_FEW, True), (_ENOUGH, False)):
        dt = one.shortest / steps
        method = Method(scheme="velocity_verlet", dt=dt, contact=one.contact)
        remarks = " ".join(laboratory.run(_scene(one, 3 * dt, None), method).remarks)
        found = _REMARK.search(remarks)
        unused = f"remarks on a restitution without use, at {steps:g} steps"
        judgements.append(exactly(unused, float(_UNUSED in remarks), float(one.unused)))
        said = f"remarks at {steps:g} steps in a contact"
        judgements.append(exactly(said, float(found is not None), float(wanted)))
        if found is None or not wanted:
            continue
        for name, text, digits, expected in (
            ("step", found[1], 6, dt),
            ("share of a contact", found[2], 2, 1 / steps),
            ("shortest contact", found[3], 3, one.shortest),
        ):
            off = _units(text, digits, expected)
            judgements.append(round_off(f"{name}, in units of its last digit", off, 0.51, _WHY))
    return worst(judgements)


def _judge_steps(laboratory: Laboratory, one: _Contact) -> Judged:
    """Steps of at most a share of the contact that divide the time between samples."""
    contact = one.contact.model_copy(update={"resolution": _RESOLUTION})
    method = Method(scheme="velocity_verlet", contact=contact)
    rest = 0.4 * _INTERVAL
    run = laboratory.run(_scene(one, _SAMPLES * _INTERVAL, _INTERVAL), method)
    each = math.ceil(_INTERVAL / (_RESOLUTION * one.shortest))
    alone = laboratory.run(_scene(one, rest, None), method)
    return worst(
        [
            exactly("steps between samples, times their number", run.cost.steps, each * _SAMPLES),
            exactly("steps of a run without samples", alone.cost.steps, math.ceil(rest / (_RESOLUTION * one.shortest))),
            exactly("samples, the start among them", run["time"].size, _SAMPLES + 1),
        ]
    )


def _judge(laboratory: Laboratory, one: _Contact) -> Judged:
    return _judge_steps(laboratory, one) if one.resolved else _judge_remarks(laboratory, one)


def _variant(name: str, one: _Contact) -> Variant:
    asked = words(_scene(one, 1.0, 1.0), Method(scheme="velocity_verlet", dt=1.0, contact=one.contact))
    promises = () if one.resolved else ("remarks_on_contacts",)
    return Variant(name, one, needs=Needs("hard_spheres", words=asked, promises=promises))


CHECKS = (
    Check(
        name="granular/few-steps",
        title="The shortest contact of soft grains: steps chosen by it, and remarks where it has less than ten",
        equation="t_c = pi/sqrt(k/m - eta^2/4), pi sqrt(m q/((1 + q) k_t)); hertz: 2.94 delta_max/v",
        criterion="a remark at 9.9 steps, with its numbers as they are printed, and none at 10.1; numbers of steps",
        citation="Schaefer, Dippel & Wolf, J. Phys. I France 6, 5 (1996); Johnson, Contact Mechanics, 11.4 (1985)",
        judge=_judge,
        variants=tuple(_variant(name, one) for name, one in _CONTACTS.items()),
        needs=soft_needs("dimension=2", "positions velocities"),
        interpreted=True,
        faults=(
            (
                "resolved-duration",
                Fault(
                    "a-step-not-taken",
                    "stepping/integrate.py",
                    "        steps=done,\n        diverged=diverged,",
                    "        steps=done + 1,\n        diverged=diverged,",
                    "a run counts a step more than it takes",
                ),
            ),
        ),
    ),
)
