"""Sources without a feature: which tests are decided, and that what is left does the same."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import refimpl
from crosscheck.checks.performance.bare_sources import copy_without
from crosscheck.checks.performance.pay_for_use import _BARE, _write_by_hand

SOURCE = """
def acceleration(r, gamma, mass, force):
    found = -r
    if gamma is not None and mass > 0:
        found = found - gamma * r
    if gamma is None or mass == 1:
        found = 2 * found
    else:
        found = 3 * found
    if not gamma is None:
        found = 5 * found
    if mass is None:
        found = 7 * found
    if force.gamma is None:
        return found
    return found * (11 if gamma is None else 13)
"""


def cut(tmp_path: Path, *absent: str) -> tuple[int, str, Any]:
    """Number of tests decided, the text that is left, and the function."""
    package = tmp_path / "before" / "physics"
    package.mkdir(parents=True)
    (package / "forces.py").write_text(SOURCE, encoding="utf-8")
    number = copy_without(package, tmp_path, absent)
    text = (tmp_path / "physics" / "forces.py").read_text(encoding="utf-8")
    names: dict[str, Any] = {}
    exec(compile(text, "forces.py", "exec"), names)
    return number, text, names["acceleration"]


def test_a_feature_leaves_no_trace(tmp_path: Path) -> None:
    number, text, _ = cut(tmp_path, "gamma")
    assert number == 5
    assert "gamma is" not in text
    assert "3 * found" not in text
    assert "5 * found" not in text
    assert "mass is None" in text


def test_what_is_left_does_the_same(tmp_path: Path) -> None:
    _, _, left = cut(tmp_path, "gamma")
    names: dict[str, Any] = {}
    exec(compile(SOURCE, "forces.py", "exec"), names)
    for mass in (None, 1, 2):
        if mass is not None:  # None is compared with a number only where gamma is there
            arguments = (3.0, None, mass, SimpleNamespace(gamma=None))
            assert left(*arguments) == names["acceleration"](*arguments)


def test_nothing_is_touched_without_absent_features(tmp_path: Path) -> None:
    number, text, _ = cut(tmp_path)
    assert (number, text) == (0, SOURCE)


@pytest.mark.parametrize("name", _BARE)
def test_features_are_asked_for_somewhere(tmp_path: Path, name: str) -> None:
    """A name that no test in the sources asks for would be cut out of nothing."""
    sources = Path(refimpl.__path__[0])
    text = "\n".join(file.read_text(encoding="utf-8") for file in sources.rglob("*.py"))
    fields = {one for one in _BARE[name].absent if f"{one} is None" not in text and f"{one} is not None" not in text}
    # of a record with several fields for one feature, one is asked for
    assert fields <= {
        "species_epsilon",
        "species_sigma",
        "slot_size",
        "slot_strength",
        "rough",
        "hits",
        "last",
        "counts",
    }
    assert copy_without(sources, tmp_path, _BARE[name].absent) > 0


def test_the_loop_by_hand_takes_what_the_general_one_takes(tmp_path: Path) -> None:
    copy_without(Path(refimpl.__path__[0]), tmp_path, ())
    file = tmp_path / "refimpl" / "stepping" / "integrate.py"
    _write_by_hand(file)
    text = file.read_text(encoding="utf-8")
    assert "a = accelerate(force, r, v)" in text
    assert "kinetic_energy(force, v_new)" not in text
    compile(text, "integrate.py", "exec")
