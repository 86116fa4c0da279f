"""The picture of a run: particles in their size, among their walls."""

import numpy as np
import pytest
from hard_disks import EVENTS, disks, fall

from crosscheck.engines.protocol import Run
from crosscheck.scene import Box, Cylinder, Explicit, HardSpheres, Lattice, LennardJones, Scene
from crosscheck.simulate.observables import Result, observables
from crosscheck.simulate.picture import draw_configuration, draw_picture, snapshot_of


def circles(scene, run):
    """Diameters (in the units of the axes) and centres of what is drawn as disks, and the axes."""
    from matplotlib.collections import EllipseCollection
    from matplotlib.figure import Figure

    axes = Figure().add_subplot()
    draw_configuration(axes, scene, run)
    found = [(c.get_widths(), c.get_offsets()) for c in axes.collections if isinstance(c, EllipseCollection)]
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
    assert [path.suffix for path in draw_picture(tmp_path, scene, [EVENTS], [result], {})] == [".png", ".svg"]


def fluid(dimension, **lennard_jones):
    """A Lennard-Jones scene of 16 particles, and a run of it that went nowhere."""
    scene = Scene(
        name="fluid",
        dimension=dimension,
        duration=1.0,
        box=Box(lengths=(6.0, 5.0, 4.0)[:dimension]),
        species=(0, 1) * 8,
        lennard_jones=LennardJones(cutoff=1.9, **({"length": (1.0, 0.5)} | lennard_jones)),
        initial=Lattice(
            kind="lattice", structure="square" if dimension == 2 else "sc", number=16, temperature=1.0, seed=1
        ),
    )
    state = scene.initial_state()
    return scene, Run(time=np.zeros(1), final_positions=state.positions, final_velocities=state.velocities)


def test_particles_in_the_plane_have_their_size():
    snapshot = snapshot_of(*fluid(2))
    assert snapshot.radius == [0.5, 0.25] * 8
    assert snapshot_of(*fluid(2, length_form="r_m")).radius == pytest.approx(
        np.array([0.5, 0.25] * 8) / 2 ** (1 / 6), rel=1e-3
    )


def test_far_particles_are_smaller_and_behind():
    scene, run = fluid(3)
    radius = snapshot_of(scene, run).radius
    assert radius == sorted(radius)
    assert radius[0] < radius[-1]


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_run_that_lost_its_particles_has_a_picture(tmp_path, dimension):
    scene, run = fluid(dimension)
    run["final_positions"] = np.full_like(run["final_positions"], np.nan)
    run["final_positions"][0] = np.inf
    result = Result("refimpl", "1", run, observables(scene, run))
    paths = draw_picture(tmp_path, scene, [EVENTS], [result], {})
    assert "16 particles outside the picture or not finite" in paths[-1].read_text()


def test_open_sides_are_dashed_and_periodic_ones_are_not():
    from matplotlib.collections import LineCollection

    for boundary, number in (("open", 2), ("periodic", 0)):
        scene = disks(box=Box(lengths=(6.0, 5.0), boundaries=("periodic", boundary)))
        _, _, axes = circles(scene, fall(scene))
        assert sum(len(c.get_segments()) for c in axes.collections if isinstance(c, LineCollection)) == number


@pytest.mark.filterwarnings("error")
def test_names_are_drawn_as_they_are_written(tmp_path):
    """Between two "$" matplotlib would read mathematics, and stop at a command that it does not know."""
    scene = disks(name="\u6f22 $\\foo$ <b> _^{")
    run = fall(scene)
    results = [Result(f"$\\bar$ {which}\x1b.py:Class", "1", run, observables(scene, run)) for which in "ab"]
    draw_picture(tmp_path, scene, [EVENTS] * len(results), results, {"energy": np.ones(run["time"].size)})
    texts = (tmp_path / "picture.svg").read_text(encoding="utf-8")
    assert "\u6f22 $\\foo$ &lt;b&gt; _^{: event_driven" in texts
    assert "|$\\bar$ a\\x1b.py:Class - $\\bar$ b\\x1b.py:Class|" in texts
