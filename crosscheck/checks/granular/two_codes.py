"""A hundred impacts of soft grains at once, step by step in two codes.

Literature: L. E. Silbert et al., Phys. Rev. E 64, 051302 (2001).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, variants_of
from crosscheck.checks.granular.impacts import (
    Floats,
    Law,
    bodies,
    impact_scene,
    lasting,
    make_impacts,
    rounded_speed,
    wander,
)
from crosscheck.checks.granular.soft_grains import CONTACTS, REFERENCE, soft_needs
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references.soft_impact import SoftContact, stiffness
from crosscheck.verdict import Judged, round_off, worst

#: Contact time of the pairs that are followed step by step, and dt/t_c: long enough that the line of centres turns,
#: and that delta/R, by which the arms of `pair_style granular` are shorter, is seen.
FOLLOWED, FOLLOWED_RESOLUTION = 1e-2, 1 / 50
_PAIRS = 100
#: The other code: every engine is compared with the reference, and that one with LAMMPS.
_PEER = "lammps"


class _Pairs(NamedTuple):
    """What meets, in `dimension` dimensions; name: of the variant, in figures.

    contact: None of smooth grains. unlike: masses and sizes are. wall: grains hit a wall, not each other.
    """

    name: str
    dimension: int
    contact: SoftContact | None
    unlike: bool = False
    wall: bool = False


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


def _judge_two_codes(laboratory: Laboratory, pairs: _Pairs) -> Judged:
    contact, unlike = pairs.contact, pairs.unlike
    rng = np.random.default_rng(laboratory.seed("grains"))
    shape = (_PAIRS, 2)
    masses, diameters = (rng.uniform(0.5, 2.0, shape), rng.choice([0.6, 1.0], shape)) if unlike else (1.0, 1.0)
    impacts = make_impacts(
        pairs.dimension,
        np.zeros(_PAIRS) if contact is None else rng.uniform(0.0, 4.0, _PAIRS),
        laboratory.seed(),
        masses=masses,
        diameters=diameters,
        q=None if contact is None else contact.q,
        wall=pairs.wall,
    )
    law = Law(0.7) if contact is None else Law(contact.alpha, contact)
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
    wandered, tolerance = wander(impacts, steps), rounded_speed(impacts, steps, law.alpha, FOLLOWED)
    why = "a coordinate is rounded at every step, a random walk, and overlaps times omega_0^2 t_c are velocities"
    judgements = [
        round_off("largest difference of velocities", float(velocities.max()), tolerance, why),
        round_off(
            "largest difference of positions", float(places.max()), wandered + tolerance * FOLLOWED,
            "rounding of the coordinates, and the velocities' difference for a contact",
        ),
    ]  # fmt: skip
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
        variants=variants_of({pairs.name: pairs for pairs in TWO_CODES}, "full"),
        needs=soft_needs("method.contact.stiffness hard_spheres.restitution", "positions velocities"),
        faults=(
            (
                "2d-unlike-history",
                Fault(
                    "torque-on-the-other-arm",
                    CONTACTS,
                    "_add_torque(d, d * number, a, j, inverse_inertias[j] * (radii[j] - shorter), n, f)",
                    "_add_torque(d, d * number, a, j, inverse_inertias[j] * (radii[i] - shorter), n, f)",
                    "the torque on the second grain has the arm of the first",
                ),
            ),
        ),
    ),
)
