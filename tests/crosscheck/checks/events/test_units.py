"""A scene in other units is the same motion by other numbers."""

from __future__ import annotations

import pytest

from crosscheck.checks.events.audit_rows import row_scene, rows
from crosscheck.checks.events.units import in_units


@pytest.mark.parametrize("number", [0, 8, 20, 40])
def test_units_and_back(number: int) -> None:
    scene = row_scene(rows()[0][number], number)
    there = in_units(scene, 4.0, 0.5)
    assert in_units(there, 0.25, 2.0) == scene
    one, other = scene.initial_state(), there.initial_state()
    assert (other.positions == 4.0 * one.positions).all()
    assert (other.velocities == 8.0 * one.velocities).all()
    assert (other.diameters == 4.0 * one.diameters).all()
    assert (other.masses == one.masses).all()
    assert there.duration == 0.5 * scene.duration


def test_every_unit_of_a_scene_with_all_features() -> None:
    """Speeds, accelerations and energies over those that lengths and times give; numbers without a unit stay."""
    table = rows()[0]
    for number in range(0, len(table), 2):
        one = row_scene(table[number], number)
        other = in_units(one, 4.0, 0.5)
        assert one.box is None or other.box is not None
        if one.acceleration is not None and other.acceleration is not None:
            assert other.acceleration == tuple(16.0 * g for g in one.acceleration)
        spheres, scaled = one.hard_spheres, other.hard_spheres
        assert spheres is not None
        assert scaled is not None
        assert (scaled.restitution, scaled.friction) == (spheres.restitution, spheres.friction)
        if spheres.well is not None and scaled.well is not None:
            assert scaled.well.depth == 64.0 * spheres.well.depth
            assert scaled.well.range == spheres.well.range
        for name, face in (one.box.faces or {}).items() if one.box is not None else ():
            assert other.box is not None
            assert other.box.faces is not None
            twin = other.box.faces[name]
            if face.oscillation is not None and twin.oscillation is not None:
                assert twin.oscillation.amplitude == 4.0 * face.oscillation.amplitude
                assert twin.oscillation.frequency == 2.0 * face.oscillation.frequency
                assert twin.oscillation.phase == face.oscillation.phase
            if face.temperature is not None:
                assert twin.temperature == 64.0 * face.temperature
            if face.velocity is not None:
                assert twin.velocity == 8.0 * face.velocity
