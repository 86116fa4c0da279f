"""What a trajectory says of a run, and the box that is made for formats in which every trajectory has one."""

from dataclasses import replace

import numpy as np
import pytest
from hard_disks import EVENTS, disks, fall
from hypothesis import given
from trajectory_files import trajectories

from crosscheck.scene import (
    Box,
    Explicit,
    Face,
    GrainFriction,
    HardSpheres,
    LennardJones,
    Method,
    Output,
    Scene,
    Spring,
    Wall,
)
from crosscheck.trajectories.trajectory import box_around, trajectory_of

GRAINS = HardSpheres(diameter=0.5, friction=GrainFriction(tangential_restitution=0.0))


def test_vectors_of_a_plane_are_completed_and_spins_are_about_z():
    scene = disks(hard_spheres=GRAINS, masses=(1.0, 2.0, 3.0))
    run = fall(scene, angular_velocities=np.arange(9.0).reshape(3, 3, 1))
    found = trajectory_of(scene, run)
    assert found.positions.tolist() == np.pad(run["positions"], ((0, 0), (0, 0), (0, 1))).tolist()
    assert found.more["velocities"].shape == (3, 3, 3)
    assert found.more["angular_velocities"][..., 2].tolist() == [[0, 1, 2], [3, 4, 5], [6, 7, 8]]
    assert not found.more["angular_velocities"][..., :2].any()
    assert found.more["radius"].tolist() == [0.25] * 3
    # disks, I = m R^2/2
    assert found.more["moment_of_inertia"].tolist() == [0.5 * m * 0.0625 for m in (1.0, 2.0, 3.0)]
    assert (found.dimension, found.cell.tolist(), found.periodic.tolist()) == (2, [6, 5, 0], [True, True, False])


@pytest.mark.parametrize("name", ["positions", "velocities", "angular_velocities"])
def test_it_ends_before_the_first_sample_that_is_not_finite(name):
    scene = disks(hard_spheres=GRAINS)
    run = fall(scene, angular_velocities=np.ones((3, 3, 1)))
    run[name] = run[name].copy()
    run[name][1, 2] = np.nan
    found = trajectory_of(scene, run)
    assert found.time.tolist() == [0.0]
    assert len(found.steps) == len(found.positions) == len(found.more["velocities"]) == 1


def test_a_run_without_a_trajectory_has_none():
    scene = disks(output=Output(interval=1.0))
    run = fall(scene)
    del run["positions"]
    assert trajectory_of(scene, run) is None


def test_steps_are_those_of_the_method_or_numbers_of_samples():
    scene = Scene(
        name="spring",
        dimension=1,
        duration=1.0,
        spring=Spring(k=1.0),
        initial=Explicit(positions=((1.0,),)),
        output=Output(interval=0.5, trajectory=True),
        method=Method(scheme="verlet", dt=0.125),
    )
    assert trajectory_of(scene, fall(scene)).steps.tolist() == [0, 4, 8]
    other = Method(scheme="velocity_verlet", dt=0.25)
    assert trajectory_of(scene, fall(scene), other).steps.tolist() == [0, 2, 4]
    assert trajectory_of(disks(), fall(disks()), EVENTS).steps.tolist() == [0, 1, 2]


def with_walls(x, **box):
    scene = disks(box=Box(lengths=(x, 5.0), **box))
    return trajectory_of(scene, fall(scene))


def test_the_box_is_that_of_the_scene_between_walls_and_along_periodic_axes():
    found = with_walls(6.5, boundaries=("hard", "periodic"))
    assert found.walled.tolist() == [[True, True], [False, False], [False, False]]
    # a path leaves it along y; along z it is a hundredth of the longest side
    assert box_around(found).tolist() == [[0, 6.5], [0, 5], [-0.0325, 0.0325]]


def test_the_box_goes_around_particles_where_there_is_no_wall():
    found = with_walls(6.0, boundaries=("hard", "open"), faces={"x+": Face(open=True)})
    assert found.walled.tolist() == [[True, False], [False, False], [False, False]]
    # y from 1 to 5.3 with radii 0.5; x up to 5.9
    assert box_around(found)[:2].tolist() == [[0, 6.4], [0, 1.5 + 2 * 1.9 + 0.5]]


def test_walls_of_a_fluid_are_walls():
    scene = Scene(
        name="film",
        dimension=3,
        duration=1.0,
        lennard_jones=LennardJones(cutoff=2.0),
        box=Box(lengths=(5.0,) * 3, boundaries=("periodic", "periodic", "wall"), wall=Wall(cutoff=1.0)),
        initial=Explicit(positions=((1.0, 1.0, 1.0),)),
        output=Output(interval=1.0, trajectory=True),
    )
    assert trajectory_of(scene, fall(scene)).walled.tolist() == [[False, False], [False, False], [True, True]]


def test_one_particle_in_open_space_is_in_a_box():
    scene = disks(box=None, hard_spheres=None, spring=Spring(k=1.0), initial=Explicit(positions=((0.0, 0.0),)))
    assert box_around(trajectory_of(scene, fall(scene))).tolist() == [[-0.5, 0.5], [-0.5, 0.5], [-0.005, 0.005]]


@given(trajectories())
def test_a_box_around_any_trajectory_is_finite_and_holds_what_walls_and_periods_do_not(trajectory):
    box = box_around(trajectory)
    assert np.isfinite(box).all()
    assert (box[:, 0] < box[:, 1]).all()
    for axis in range(3):
        x = trajectory.positions[..., axis]
        if axis >= trajectory.dimension:
            assert box[axis, 0] == -box[axis, 1]
        elif trajectory.periodic[axis] or trajectory.walled[axis].all():
            assert box[axis].tolist() == [0, trajectory.cell[axis]]
        elif not trajectory.walled[axis].any():
            assert box[axis, 0] < x.min()
            assert x.max() < box[axis, 1]
            assert box[axis, 0] <= 0 or trajectory.cell[axis] == 0


def test_points_far_from_the_origin_are_inside_a_box_that_single_precision_tells():
    scene = disks(box=None, hard_spheres=None, spring=Spring(k=1.0), initial=Explicit(positions=((1e9, -2e9),)))
    found = replace(trajectory_of(scene, fall(scene)), positions=np.array([[[1e9, -2e9, 0.0]]]))
    assert box_around(found)[:2] == pytest.approx(
        np.array([[1e9 - 1e3, 1e9 + 1e3], [-2e9 - 2e3, -2e9 + 2e3]]), rel=1e-12
    )


def test_the_margin_around_a_small_system_is_small():
    scene = disks(box=None, hard_spheres=None, spring=Spring(k=1.0), initial=Explicit(positions=((0.0, 0.0),)))
    found = replace(trajectory_of(scene, fall(scene)), positions=np.array([[[0.0, 0, 0]], [[1e-10, 2e-10, 0]]]))
    expected = [[-2e-13, 1e-10 + 2e-13], [-2e-13, 2e-10 + 2e-13]]
    assert box_around(found)[:2] == pytest.approx(np.array(expected), rel=1e-9, abs=1e-24)
