"""What a check declares that it needs of an engine is what all its scenes use, and nothing else."""

from __future__ import annotations

import pytest

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.events import (
    brownian,
    collision_rate,
    cost,
    equation_of_state,
    ideal_gas,
    lorentz,
    maxwell,
    mixture,
    robustness,
    schedulers,
    self_diffusion,
    specification,
    square_well_energy,
    square_well_liquid,
    square_well_pairs,
    square_well_virial_coefficient,
)
from crosscheck.engines.capabilities import Needs, measured, words
from crosscheck.engines.protocol import Run
from crosscheck.engines.registry import engine_class
from crosscheck.engines.workers.pool import Pool
from crosscheck.scene import Scene

MODULES = (
    brownian, collision_rate, cost, equation_of_state, ideal_gas, lorentz, maxwell, mixture, robustness, schedulers,
    self_diffusion, specification, square_well_energy, square_well_liquid, square_well_pairs,
    square_well_virial_coefficient,
)  # fmt: skip
CHECKS = [check for module in MODULES for check in module.CHECKS]


class _Seen(Exception):
    """The first scene that a check runs."""


def first_scene(check: Check, variant: Variant) -> Scene:
    class Recording(Laboratory):
        def run(self, scene: Scene, *args: object, **more: object) -> Run:
            raise _Seen(scene)

    schemes = engine_class("refimpl").schemes
    laboratory = Recording("refimpl", schemes, Pool(None, 1.0), f"{check.name}/{variant.name}")
    with pytest.raises(_Seen) as seen:
        check.judge(laboratory, variant.value)
    scene: Scene = seen.value.args[0]
    return scene


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.name)
def test_needs_are_what_all_variants_use(check: Check) -> None:
    needs = check.needs
    assert isinstance(needs, Needs)
    scenes = [first_scene(check, variant) for variant in check.offered(engine_class("refimpl").schemes)]
    assert {scene.interaction for scene in scenes} == {needs.interaction}
    common = frozenset.intersection(*(words(scene) for scene in scenes))
    asked = frozenset.intersection(*(measured(scene) for scene in scenes))
    assert needs.words == common, "the words that all variants use"
    assert needs.observables == asked, "the observables that all variants ask for"
