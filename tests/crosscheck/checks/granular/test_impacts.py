"""Many impacts in one scene, by independent routes."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.checks.granular.impacts import Law, impact_scene, make_impacts, overlaps
from crosscheck.engines.protocol import Run
from crosscheck.references.soft_impact import SoftContact


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("wall", [False, True])
@pytest.mark.parametrize("central", [False, True])
def test_impacts_are_as_asked(dimension: int, wall: bool, central: bool) -> None:
    thetas, speeds = np.linspace(0, 5, 20), np.linspace(0.5, 2, 20)
    sizes = np.linspace(0.3, 1.5, 40).reshape(20, 2)
    impacts = make_impacts(
        dimension, thetas, 7, speeds=speeds, diameters=sizes, masses=3 * sizes, wall=wall, central=central
    )
    np.testing.assert_allclose(impacts.approach, speeds)
    np.testing.assert_allclose(np.linalg.norm(impacts.slips, axis=1), thetas * speeds, atol=1e-13)
    touching = impacts.touching()
    np.testing.assert_allclose(
        np.linalg.norm(touching[:, 0] - touching[:, 1], axis=1), impacts.radii.sum(axis=1), rtol=1e-12
    )
    assert np.isfinite(impacts.masses).all() != wall
    if central:
        lever = np.cross(impacts.velocities[:, 0] - impacts.velocities[:, 1], impacts.normals)
        np.testing.assert_allclose(lever, 0, atol=1e-15)
    if dimension == 2:
        assert not impacts.velocities[..., 2].any()
        assert not impacts.spins[..., :2].any()


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("wall", [False, True])
def test_scene_brings_the_grains_to_their_impacts(dimension: int, wall: bool) -> None:
    impacts = make_impacts(dimension, np.linspace(0, 2, 9), 3, wall=wall, diameters=(1.0, 0.6))
    law = Law(0.8, SoftContact(0.8, -0.5, 0.3))
    dt = 1e-3
    # it refuses overlaps
    state = impact_scene(impacts, law, dt, 10).initial_state()
    assert state.diameters is not None
    bodies = 1 if wall else 2
    expected = impacts.touching() - (dt * impacts.phases)[:, None, None] * impacts.velocities
    np.testing.assert_allclose(state.positions, expected[:, :bodies].reshape(-1, 3)[:, :dimension])
    np.testing.assert_allclose(state.diameters, 2 * impacts.radii[:, :bodies].ravel())
    np.testing.assert_array_equal(state.masses, impacts.masses[:, :bodies].ravel())
    assert state.angular_velocities is not None
    assert state.angular_velocities.shape == (9 * bodies, 1 if dimension == 2 else 3)


@pytest.mark.parametrize("wall", [False, True])
def test_overlaps(wall: bool) -> None:
    impacts = make_impacts(2, np.zeros(5), 2, wall=wall, central=True)
    rows = impacts.touching()[:, : 1 if wall else 2, :2]
    # nearer by 0.1 along the normal, then apart by 0.2
    nearer = rows.copy()
    nearer[:, 0] -= 0.1 * impacts.normals[:, :2]
    apart = rows.copy()
    apart[:, 0] += 0.2 * impacts.normals[:, :2]
    frames = np.array([frame.reshape(-1, 2) for frame in (rows, nearer, apart)])
    found = overlaps(impacts, Run(positions=frames))
    np.testing.assert_allclose(found, np.outer([0, 0.1, -0.2], np.ones(5)), atol=1e-14)
