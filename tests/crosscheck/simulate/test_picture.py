"""The picture of a run: particles in their size, among their walls."""

import numpy as np
import pytest
from hard_disks import EVENTS, disks, fall

from crosscheck.scene import Box, Cylinder, Explicit, HardSpheres
from crosscheck.simulate.observables import Result, observables
from crosscheck.simulate.picture import draw_configuration, draw_picture


def circles(scene, run):
    """Diameters (in the units of the axes) and centres of what is drawn as disks, and the axes."""
    from matplotlib.figure import Figure

    axes = Figure().add_subplot()
    draw_configuration(axes, scene, run)
    found = [(c.get_widths(), c.get_offsets()) for c in axes.collections]
    return np.concatenate([w for w, _ in found]), np.concatenate([o for _, o in found]), axes


def test_disks_are_drawn_in_their_size():
    scene = disks(hard_spheres=HardSpheres(diameter=(1.0, 0.5)), species=(0, 1, 0))
    widths, centres, axes = circles(scene, fall(scene))
    # the third one has gone up to y = 5.3, that is 0.3, and reaches over both periodic edges: it is seen four times
    assert sorted(widths) == [0.5] + [1.0] * 5
    for x in (5.9, -0.1):
        for y in (0.3, 5.3):
            assert np.isclose(centres, [x, y]).all(axis=1).sum() == 1
    assert axes.get_xlim() == (0, 6)
    assert axes.get_ylim() == (0, 5)


@pytest.mark.parametrize("boundaries", [("hard", "hard"), ("open", "open"), ("periodic", "hard"), None])
def test_walls_are_drawn(tmp_path, boundaries):
    drum = Cylinder(radius=2.5) if boundaries == ("open", "open") else None
    box = None if boundaries is None else Box(lengths=(6.0, 5.0), boundaries=boundaries, cylinder=drum)
    scene = disks(
        box=box,
        hard_spheres=HardSpheres(diameter=(1.0, 0.0), fixed=(0,)),
        species=(0, 1, 1),
        initial=Explicit(
            positions=((3.0, 2.5), (2.0, 2.0), (4.0, 3.0)), velocities=((0.0, 0.0), (0.5, 0.0), (0.0, 0.1))
        ),
    )
    run = fall(scene)
    widths, _, axes = circles(scene, run)
    assert len(widths) == 3
    walls = [line for line in axes.lines if line.get_linewidth() == 2]
    assert len(walls) == (0 if boundaries is None else 2 * boundaries.count("hard"))
    assert [patch.radius for patch in axes.patches] == [2.5] * (drum is not None)
    assert len(axes.lines) - len(walls) == 2  # the paths of those that move
    result = Result("refimpl", "1", run, observables(scene, run))
    assert [path.suffix for path in draw_picture(tmp_path, scene, EVENTS, [result], {})] == [".png", ".svg"]
