"""What is judged of grains that slide and roll: starts on every face, and errors of a run by the closed form."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.checks.granular.slide_to_roll import FLOORS, _errors, _Floor, _Grains, _on_face
from crosscheck.engines.protocol import Run
from crosscheck.scene import Contact


def exact(grains: _Grains, dimension: int) -> Run:
    """The run by the closed form: spins by u = v - R omega x n = 0 at the end, component by component."""
    times = np.linspace(0.0, 1.2, 7)
    v, w = np.zeros((2, 7, len(grains.expected), 3))
    for n, one in enumerate(grains.expected):
        velocity, rolling = one.motion(times)
        v[:, n] = velocity[:, None] * grains.directions[n]
        # on the floor z = 0, rolling along x turns about +y
        w[:, n] = rolling[:, None] / 0.5 * np.cross(grains.normal, grains.directions[n])
    inertia = grains.expected[0].inertia * 0.25
    return Run(
        time=times,
        positions=np.tile(np.array(grains.scene.initial_state(CONTACT).positions), (7, 1, 1)),
        velocities=v[:, :, :dimension],
        angular_velocities=w[:, :, 2:] if dimension == 2 else w,
        rotational_energy=0.5 * inertia * (w**2).sum(axis=(1, 2)),
    )


#: That spheres may overlap is all that is asked of it.
CONTACT = Contact(stiffness=1.0)


@pytest.mark.parametrize("floor", FLOORS, ids=lambda floor: floor.name)
def test_errors_of_the_closed_form_and_of_a_spin_turned_round(floor: _Floor) -> None:
    for axis in range(floor.dimension):
        for upper in (0, 1):
            grains = _on_face(floor, axis, upper)
            run = exact(grains, floor.dimension)
            errors = _errors(grains, floor, run)
            assert max(errors) < 1e-14
            run["angular_velocities"] = -run["angular_velocities"]
            assert _errors(grains, floor, run).motion > 1


def test_a_ball_on_the_floor_turns_about_y_where_it_rolls_along_x() -> None:
    grains = _on_face(FLOORS[1], 2, 0)
    np.testing.assert_array_equal(np.cross(grains.normal, grains.directions[0]), [0.0, 1.0, 0.0])
    np.testing.assert_array_equal(grains.directions[0], [1.0, 0.0, 0.0])
