"""Forces that jump at a cutoff: where, and how far the energy walks away by it."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest

from crosscheck.engines.registry import engine_class
from crosscheck.scene import Box, Gravity, HardSpheres, Lattice, LennardJones, Method, Output, Scene, Spring, Wall
from crosscheck.simulate.judging.smoothness import claimed_order, jump, late_kicks
from crosscheck.simulate.judging.trial import Trial

FLUID = {
    "name": "fluid",
    "dimension": 3,
    "duration": 1.0,
    "box": Box(lengths=(7.0, 7.0, 7.0)),
    "initial": Lattice(kind="lattice", structure="fcc", number=216, temperature=1.0, seed=3),
    "output": Output(interval=1.0, observables=("kinetic_energy", "potential_energy")),
}


def scene(**entries: Any) -> Scene:
    return Scene(**(FLUID | entries))


@pytest.mark.parametrize(
    ("entries", "word"),
    [
        ({"lennard_jones": LennardJones(cutoff=2.5)}, "lennard_jones.truncation=truncated"),
        ({"lennard_jones": LennardJones(cutoff=2.5, truncation="shifted")}, "lennard_jones.truncation=shifted"),
        ({"lennard_jones": LennardJones(cutoff=2.5, truncation="force_shifted")}, None),
        ({"hard_spheres": HardSpheres(diameter=0.9)}, "hard_spheres"),
    ],
)
def test_which_forces_jump(entries: dict[str, Any], word: str | None) -> None:
    assert jump(scene(**entries)) == word


class _Trial:
    """What the functions ask of a trial."""

    def __init__(self, one: Scene, scheme: str = "velocity_verlet") -> None:
        self.scene, self.method, self.start = one, Method(scheme=scheme, dt=0.01), one.own_start()
        self.claims = engine_class("refimpl").schemes[scheme]
        self.room = 1.0 if one.box is None else float(np.prod(one.lengths()))


def test_kicks_add_up_as_a_random_walk_and_those_of_walls_with_them() -> None:
    cut = LennardJones(cutoff=2.5, truncation="shifted")
    one = cast("Trial", _Trial(scene(lennard_jones=cut)))
    known = late_kicks(one, 0.01, 1.0, 300.0)
    assert late_kicks(one, 0.005, 4.0, 300.0) == pytest.approx(known)
    smooth = LennardJones(cutoff=2.5, truncation="force_shifted")
    assert late_kicks(cast("Trial", _Trial(scene(lennard_jones=smooth))), 0.01, 1.0, 300.0) == 0
    # the force at 2.5 sigma, as printed: 24 (2 r^-13 - r^-7) = -0.0390; pairs that cross by the gas's theory
    rate = 1.5 * 216**2 / (2 * 343) * 4 * np.pi * 2.5**2 * 2 * (2 * 600 / 648 / 2 / np.pi) ** 0.5
    variance = rate * 0.0389995**2 * 4 * (600 / 648) / 3
    assert known == pytest.approx(0.01 * variance**0.5, rel=1e-4)
    walled = scene(
        lennard_jones=cut,
        box=Box(lengths=(9.0, 7.0, 7.0), boundaries=("wall", "periodic", "periodic"), wall=Wall(cutoff=2.5)),
    )
    assert late_kicks(cast("Trial", _Trial(walled)), 0.01, 1.0, 300.0) > 0


@pytest.mark.parametrize(
    ("entries", "scheme", "order"),
    [
        ({"gravity": Gravity(), "box": None}, "velocity_verlet", 2),
        ({"spring": Spring(k=1.0), "box": None}, "leapfrog", 2),
        ({"spring": Spring(k=1.0), "box": None}, "euler", 1),
    ],
)
def test_the_order_that_a_scheme_claims(entries: dict[str, Any], scheme: str, order: int) -> None:
    lattice = FLUID | {"initial": {"kind": "explicit", "positions": ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))}}
    one = Scene(**(lattice | entries))
    assert claimed_order(cast("Trial", _Trial(one, scheme))) == order
