"""Which pictures there are of what was measured on cells, and what is in them."""

from functools import partial

import numpy as np
import pytest
from hard_disks import EVENTS, disks

from crosscheck.engines.protocol import Run, shapes
from crosscheck.scene import Box, Explicit, LatticeGas, Obstacle, Occupations, Output, Scene
from crosscheck.simulate.observables import Result, observables
from crosscheck.simulate.panels import Map, Profile, draw_panel, limits_of_maps, panels
from crosscheck.simulate.picture import draw_picture


@pytest.fixture
def on(interpreted):
    """Two disks, or spheres, that fly through cells, and a run of them: by the cells and the dimension."""
    return partial(fly, interpreted)


def fly(worker, fields, dimension=2):
    box = (10.0, 5.0, 8.0)[:dimension]
    rows = ((2.0, 1.0, 1.0), (8.0, 4.0, 5.0)), ((0.5, 0.25, 1.0), (0.0, -1.0, 0.5))
    positions, velocities = (tuple(row[:dimension] for row in part) for part in rows)
    scene = disks(
        dimension=dimension,
        box=Box(lengths=box),
        initial=Explicit(positions=positions, velocities=velocities),
        output=Output(interval=1.0, fields=fields),
        duration=20.0,
    )
    return scene, worker.run(scene, EVENTS)


def gas(**output):
    """A lattice gas with a wall, and a run with random numbers."""
    scene = Scene(
        name="gas",
        dimension=2,
        duration=8,
        lattice_gas=LatticeGas(model="fhp1", columns=64, rows=8, force=0.1, obstacles=(Obstacle(columns=(3, 4)),)),
        initial=Occupations(kind="occupations", density=0.3, seed=2),
        output=Output(interval=4, **output),
    )
    generator = np.random.default_rng(1)
    run = Run({name: generator.integers(1, 9, size=shape) for name, shape in shapes(scene, 3).items()})
    run["time"] = np.array([0.0, 4.0, 8.0])
    return scene, run


def test_cells_along_one_axis_are_profiles(on):
    found = panels(*on((4, 1)))
    assert [(type(one), one.label) for one in found] == [
        (Profile, "temperature"), (Profile, "density"), (Profile, "velocity"), (Profile, "energy flux"),
    ]  # fmt: skip
    assert found[0].along == "x"
    assert found[0].x.tolist() == [1.25, 3.75, 6.25, 8.75]
    assert list(found[2].lines) == ["v_x", "v_y"]


def test_cells_along_two_axes_are_maps(on):
    found = panels(*on((4, 2)))
    assert [(type(one), one.values.shape) for one in found] == [(Map, (4, 2)), (Map, (4, 2))]
    assert found[1].arrows is not None


def test_cells_along_three_axes_are_averaged_along_one(on):
    whole = on((4, 2, 3), dimension=3)
    found = panels(*whole)
    assert [one.axes for one in found] == [("x", "z"), ("x", "z")]
    flat = panels(*on((4, 1, 3), dimension=3))
    for one, other in zip(found, flat, strict=True):
        assert one.values == pytest.approx(other.values, nan_ok=True)


def test_blocks_along_one_axis_are_space_and_time():
    found = panels(*gas(observables=("populations",), fields=(1, 4)))
    assert [(one.axes, one.values.shape, one.signed) for one in found] == [
        (("time", "y"), (3, 4), False), (("time", "y"), (3, 4), True), (("time", "y"), (3, 4), True),
    ]  # fmt: skip
    assert found[0].edges[0].tolist() == [0, 2, 6, 8]


def test_blocks_along_two_axes_are_maps_of_the_end_with_walls():
    scene, run = gas(observables=("populations", "force_impulse"), fields=(8, 4))
    found = panels(scene, run)
    assert [one.label for one in found] == [
        "speed at the end", "vorticity at the end", "particles per site", "force on a row",
    ]  # fmt: skip
    assert found[2].values.tolist() == (run["populations"][-1].sum(axis=-1) / 16).tolist()
    assert found[0].walls.shape == (2, 16)
    assert found[3].lines[""].tolist() == (run["force_impulse"][-1] / 8).tolist()


def test_sites_are_drawn_as_means():
    scene, run = gas(observables=("sites",))
    (found,) = panels(scene, run)
    counts = sum((run["sites"] >> i) & 1 for i in range(6))
    assert found.values.tolist() == counts.T.tolist()


def test_a_vortex_has_its_vorticity():
    """Solid rotation, v = omega x r: the curl is 2 omega."""
    scene, run = gas(observables=("populations",), fields=(8, 4))
    from crosscheck.scene.lattice_gas import gas_model
    from crosscheck.simulate.profiles import cell_edges

    x, y = ((e[1:] + e[:-1]) / 2 for e in cell_edges(scene))
    c = gas_model(scene).velocities.cartesian
    flow = np.stack(np.broadcast_arrays(-1e-3 * y, 1e-3 * x[:, None]), axis=-1)
    run["populations"] = np.broadcast_to(1 + 2 * flow @ c.T, (3, 8, 4, len(c)))  # u = (1/6) sum of f c
    assert panels(scene, run)[1].values == pytest.approx(2e-3)


def test_one_colour_scale_for_all_engines():
    edges = (np.arange(3.0), np.arange(2.0))
    low, high = (Map("v", ("x", "y"), edges, np.array([[a], [b]]), signed=True) for a, b in ((-1, 0), (np.nan, 3)))
    assert limits_of_maps([low, high]) == (-3, 3)
    assert limits_of_maps([Profile("T", "x", (0, 1), np.zeros(1), {})]) is None


@pytest.mark.parametrize("what", ["profile", "map", "blocks", "wave", "sites", "nothing"])
def test_every_kind_is_drawn(tmp_path, on, what):
    scene, run = {
        "profile": lambda: on((1, 3)),
        "map": lambda: on((4, 2)),
        "blocks": lambda: gas(observables=("populations", "force_impulse"), fields=(8, 4)),
        "wave": lambda: gas(observables=("populations",), fields=(4, 1)),
        "sites": lambda: gas(observables=("sites",)),
        "nothing": gas,
    }[what]()
    result = Result("refimpl", "1", run, observables(scene, run))
    png, svg = draw_picture(tmp_path, scene, [EVENTS] * 2, [result, result], {})
    assert png.read_bytes()[:4] == b"\x89PNG"
    assert svg.read_text().startswith("<?xml")


def test_a_map_without_numbers_is_drawn():
    from matplotlib.figure import Figure

    axes = Figure().add_subplot()
    empty = Map("density", ("x", "y"), (np.arange(2.0), np.arange(2.0)), np.full((1, 1), np.nan))
    draw_panel(axes, empty, limits_of_maps([empty]), "refimpl")
    assert axes.get_title() == "refimpl: density"


def test_a_name_with_dollar_signs_is_drawn(tmp_path, on):
    scene, run = on((4, 2))
    named = scene.changed(name="a $\\foo$ of " + "many words " * 14)
    result = Result("refimpl", "1", run, observables(named, run))
    assert "$\\foo$" in draw_picture(tmp_path, named, [EVENTS], [result], {})[1].read_text()
