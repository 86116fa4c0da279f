"""Trajectories as files: what a reader of the format finds in them."""

import numpy as np
from hard_disks import disks, fall

from crosscheck.scene import GrainFriction, HardSpheres
from crosscheck.simulate.trajectory import write_trajectories


def test_a_trajectory_has_radii_and_spins(tmp_path):
    import ase.io

    scene = disks(hard_spheres=HardSpheres(friction=GrainFriction(tangential_restitution=0.0)))
    run = fall(scene, angular_velocities=np.full((3, 3, 1), 2.5))
    run["positions"][2] = np.nan  # stopped
    frames = ase.io.read(*write_trajectories(tmp_path, "refimpl", scene, run), ":")
    assert len(frames) == 2
    assert frames[1].arrays["radius"].tolist() == [0.5] * 3
    assert frames[1].arrays["angular_velocities"].tolist() == [[0, 0, 2.5]] * 3
