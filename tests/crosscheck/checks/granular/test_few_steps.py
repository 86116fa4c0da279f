"""Remarks with wrong numbers, and those that are missing or not wanted, are red."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from crosscheck.checks.granular.few_steps import CHECKS
from crosscheck.engines.protocol import Run
from crosscheck.engines.soft_spheres import remarks
from crosscheck.scene import Method, Scene
from crosscheck.verdict import findings

VARIANTS = {one.name: one.value for one in CHECKS[0].variants if not one.value.resolved}


def _outcome(name: str, change: Any) -> str:
    def run(scene: Scene, method: Method) -> Run:
        found = remarks(scene, method, scene.initial_state(method.contact).velocities)
        return Run({}, remarks=[change(text) for text in found if change(text)])

    laboratory: Any = SimpleNamespace(run=run)
    return findings(CHECKS[0].judge(laboratory, VARIANTS[name])).outcome


@pytest.mark.parametrize("name", sorted(VARIANTS))
def test_remarks(name: str) -> None:
    assert _outcome(name, lambda text: text) == "pass"
    assert _outcome(name, lambda text: "") == "fail"
    assert _outcome(name, lambda text: text.replace("shortest contact, 0", "shortest contact, 1")) == "fail"
