"""Scenes of lattice gases on `refimpl.lattice`, in the engine's worker: what comes back, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from refusals import refused

from crosscheck.engines.protocol import shapes
from crosscheck.engines.refimpl.engine import EVOLVERS, RefimplEngine
from crosscheck.engines.workers.pool import Worker
from crosscheck.errors import Unsupported, UsageError
from crosscheck.references.lattice_models import entropy_density, mean_collision
from crosscheck.scene import LatticeGas, Method, Obstacle, Occupations, Output, Scene, Spring, Wave, explicit
from refimpl.lattice.gas import Forcing
from refimpl.lattice.models import MODELS
from refimpl.lattice.plain import PlainGas

PLANES, LOOKUP, NUMPY, BOLTZMANN = (
    Method(scheme=f"lattice_{name}") for name in ("planes", "lookup", "numpy", "boltzmann")
)
GASES = (PLANES, LOOKUP, NUMPY)
FHP, HPP = MODELS["fhp1"], MODELS["hpp"]
WALLS = (
    Obstacle(rows=(0, 0), rule="diffusive_y"),
    Obstacle(columns=(0, 0), rule="specular_x"),
    Obstacle(centre=(20.0, 5.0), radius=2.0),
)


def gas(model: str = "fhp1", rows: int = 12, columns: int = 40, **changes: Any) -> Scene:
    """A gas; `lattice_gas`, `initial` and `output` add to the entries of these tables."""
    start = {"kind": "occupations", "seed": 1} | changes.pop("initial", {"density": 0.3, "velocity_x": 0.1})
    table = {"model": model, "rows": rows, "columns": columns} | changes.pop("lattice_gas", {})
    output = {"interval": 10, "observables": ("populations", "sites"), "fields": (4, 3)} | changes.pop("output", {})
    entries: dict[str, Any] = {"name": "gas", "dimension": 2, "duration": 20}
    return Scene(
        **(entries | changes),
        lattice_gas=LatticeGas(**table),
        initial=Occupations(**start),
        output=Output(**output),
    )


def full(**changes: Any) -> Scene:
    """All that particles have: walls, a force to the left, and all tallies."""
    everything = {"observables": ("populations", "force_impulse", "sites")}
    return gas(lattice_gas={"obstacles": WALLS, "force": -0.2}, output=everything, **changes)


def counted(sites: np.ndarray, channels: int, across: int, down: int) -> np.ndarray:
    """Particles of each channel, (blocks along x, along y, b), one site at a time."""
    rows, columns = sites.shape
    found = np.zeros((across, down, channels))
    for row, column in np.ndindex(rows, columns):
        bits = int(sites[row, column]) >> np.arange(channels) & 1
        found[column * across // columns, row * down // rows] += bits
    return found


# -- runs --------------------------------------------------------------------------------------------------------------


def test_tallies_of_particles(interpreted: Worker) -> None:
    scene = full()
    run = interpreted.run(scene, PLANES)
    np.testing.assert_array_equal(run["time"], [0, 10, 20])
    expected = {"time": (3,), "populations": (3, 4, 3, 6), "force_impulse": (3, 12), "sites": (12, 40)}
    assert {name: array.shape for name, array in run.items()} == expected == shapes(scene, 3)
    assert (run.stopped, run.diverged) == ("", False)
    assert (run.cost.steps, run.cost.evaluations, run.cost.events) == (20, 0, 0)
    assert run.cost.compile > 0
    assert run.cost.wall > 0


@pytest.mark.parametrize("method", GASES, ids=lambda method: method.scheme)
def test_populations_are_those_of_the_sites(interpreted: Worker, method: Method) -> None:
    run = interpreted.run(gas(), method)
    start = gas().initial_sites()
    populations, sites = run["populations"], run["sites"]
    np.testing.assert_array_equal(populations[0], counted(start, 6, 4, 3))
    np.testing.assert_array_equal(populations[-1], counted(sites, 6, 4, 3))
    assert len(set(populations.sum(axis=(1, 2, 3)))) == 1
    assert (sites != start).any()


def test_one_block_without_fields_and_nothing_unasked(interpreted: Worker) -> None:
    whole = gas(output={"fields": None, "observables": ("populations",)})
    run = interpreted.run(whole, NUMPY)
    assert run.keys() == {"time", "populations"}
    blocks = interpreted.run(gas(), NUMPY)["populations"]
    np.testing.assert_array_equal(run["populations"][:, 0, 0], blocks.sum(axis=(1, 2)))
    assert interpreted.run(gas(output={"interval": None, "observables": ()}), NUMPY).keys() == {"time"}


def test_all_gases_are_one(interpreted: Worker) -> None:
    runs = [interpreted.run(full(), method) for method in GASES]
    for run in runs[1:]:
        for name, values in runs[0].items():
            np.testing.assert_array_equal(run[name], values)


def test_the_gas_is_that_of_the_scene(interpreted: Worker) -> None:
    scene = full(duration=25)
    expected = PlainGas(FHP, scene.initial_sites(), seed=1, walls=scene.wall_rules(), forcing=Forcing(3, 0.2))
    expected.advance(20)
    run = interpreted.run(scene, PLANES)
    np.testing.assert_array_equal(run["time"], [0, 10, 20])
    np.testing.assert_array_equal(run["force_impulse"][2], -2.0 * expected.impulses)
    # the run goes on to its end after the last sample
    expected.advance(5)
    np.testing.assert_array_equal(run["sites"], expected.sites)
    assert run.cost.steps == 25


def test_the_seed_is_the_scene_s_or_that_of_the_start(interpreted: Worker) -> None:
    own, same, other = (interpreted.run(gas(seed=seed), NUMPY)["sites"] for seed in (None, 1, 2))
    np.testing.assert_array_equal(own, same)
    assert (own != other).any()


@pytest.mark.parametrize("model", ["hpp", "fhp1"])
@pytest.mark.parametrize("force", [0.3, -0.3, 0.0])
def test_the_force_gives_the_momentum_that_it_counts(interpreted: Worker, model: str, force: float) -> None:
    observables = ("populations", "force_impulse")
    scene = gas(model, lattice_gas={"force": force}, output={"observables": observables, "interval": 5})
    run = interpreted.run(scene, NUMPY)
    momentum = run["populations"].sum(axis=(1, 2)) @ MODELS[model].velocities.cartesian
    given = run["force_impulse"].sum(axis=1)
    np.testing.assert_allclose(momentum[:, 0] - momentum[0, 0], given, atol=1e-10)
    np.testing.assert_allclose(momentum[:, 1], momentum[0, 1], atol=1e-10)
    assert np.sign(given[-1]) == np.sign(force)
    assert (np.abs(np.diff(given)) > 0).all() == (force != 0)


@pytest.mark.parametrize("force", [1.0, -1.0])
def test_the_largest_force_is_one_too(interpreted: Worker, force: float) -> None:
    scene = gas(lattice_gas={"force": force, "obstacles": WALLS}, output={"observables": ("sites", "force_impulse")})
    runs = [interpreted.run(scene, method) for method in GASES]
    for run in runs:
        np.testing.assert_array_equal(run["sites"], runs[0]["sites"])
        assert np.sign(run["force_impulse"][-1].sum()) == force


@pytest.mark.parametrize("method", [PLANES, NUMPY], ids=lambda method: method.scheme)
@pytest.mark.parametrize("interval", [None, 7, 60, 100])
def test_reversals_lead_back(interpreted: Worker, method: Method, interval: int | None) -> None:
    """Two on the way, at samples and between them; a sample at a reversal is taken behind it."""
    observables = ("sites",) if interval is None else ("sites", "populations")
    scene = gas(
        "hpp",
        duration=120,
        lattice_gas={"reversals": (60, 120)},
        output={"interval": interval, "observables": observables},
    )
    run = interpreted.run(scene, method)
    there = interpreted.run(
        scene.changed(duration=60, lattice_gas=LatticeGas(model="hpp", rows=12, columns=40)), method
    )
    np.testing.assert_array_equal(run["sites"], scene.initial_sites())
    assert (there["sites"] != scene.initial_sites()).mean() > 0.3
    if interval == 60:
        populations = run["populations"].sum(axis=(1, 2))
        np.testing.assert_array_equal(populations[2], populations[0])
        momentum = populations @ np.array(HPP.velocities.integers)
        np.testing.assert_array_equal(momentum[1], -momentum[0])


# -- mean occupations --------------------------------------------------------------------------------------------------


def test_boltzmann_gives_means(interpreted: Worker) -> None:
    """The first step starts from independent channels: the mean of many sites is exactly that of the iteration."""
    f = np.array([0.5, 0.1, 0.2, 0.4, 0.1, 0.3])
    start = {"channels": tuple(f)}
    output = {"interval": 1, "observables": ("populations", "h_function"), "fields": (1, 1)}
    run = interpreted.run(gas(initial=start, duration=3, output=output), BOLTZMANN)
    means = run["populations"][:, 0, 0] / (12 * 40)
    np.testing.assert_allclose(means[:2], [f, f + mean_collision(FHP.name, f)], rtol=1e-12)
    np.testing.assert_allclose(means.sum(axis=1), f.sum(), rtol=1e-12)
    h = run["h_function"]
    np.testing.assert_allclose(h[0], 12 * 40 * entropy_density(f), rtol=1e-12)
    assert (np.diff(h) < 0).all()
    many = gas(rows=200, columns=500, initial=start, duration=1, output=output | {"observables": ("populations",)})
    found = interpreted.run(many, NUMPY)["populations"][1, 0, 0] / 1e5
    # 5.5 standard errors: one of 3e7 means is further off by chance
    assert (np.abs(found - means[1]) < 5.5 * (means[1] * (1 - means[1]) / 1e5) ** 0.5).all()


def test_boltzmann_has_the_walls_and_the_force_of_the_scene(interpreted: Worker) -> None:
    """Means of rows after one step, which starts from independent channels."""
    changes: dict[str, Any] = {
        "columns": 8000,
        "duration": 1,
        "initial": {"density": 0.4},
        "lattice_gas": {"obstacles": (Obstacle(rows=(0, 0), rule="diffusive_y"), Obstacle(rows=(6, 6))), "force": -0.5},
        "output": {"interval": 1, "observables": ("populations",), "fields": (1, 12)},
    }
    found, means = (interpreted.run(gas(**changes), method)["populations"][1, 0] for method in (NUMPY, BOLTZMANN))
    # among 72 numbers, 5.5 standard errors are passed by chance once in 4e5 seeds
    assert (np.abs(found - means) <= 5.5 * (means * (1 - means / 8000)) ** 0.5 + 1e-9).all()
    assert np.ptp(means, axis=0).min() > 100


def test_boltzmann_starts_from_the_profiles_of_the_scene(interpreted: Worker) -> None:
    wave = Wave(of="density", amplitude=0.1, mode=(1.0, 0.0))
    scene = gas(initial={"density": 0.3, "waves": (wave,)}, output={"observables": ("populations",)})
    populations = interpreted.run(scene, BOLTZMANN)["populations"]
    assert populations.shape == (3, 4, 3, 6)
    f = scene.initial_occupations().reshape(3, 4, 4, 10, 6)
    np.testing.assert_allclose(populations[0], f.sum(axis=(1, 3)).transpose(1, 0, 2), rtol=1e-12)
    assert np.abs(np.diff(populations[0].sum(axis=(1, 2)))).max() > 1


def test_boltzmann_starts_from_empty_walls_as_particles_do(interpreted: Worker) -> None:
    scene = gas(lattice_gas={"obstacles": (Obstacle(rows=(0, 3)),)}, output={"observables": ("populations",)})
    for method in (NUMPY, BOLTZMANN):
        populations = interpreted.run(scene, method)["populations"]
        assert not populations[0, :, 0].any()
        assert populations[0, :, 1:].all()


# -- refused -----------------------------------------------------------------------------------------------------------


def test_what_the_engine_runs() -> None:
    engine = RefimplEngine()
    for method in GASES:
        assert refused(engine, full(), method) is None
        reason = refused(engine, gas(output={"observables": ("h_function",)}), method)
        assert reason == "it declares no h_function for [lattice_gas]"
    means = gas(output={"observables": ("populations", "h_function")})
    assert refused(engine, means, BOLTZMANN) is None
    reason = refused(engine, full(), BOLTZMANN)
    assert reason == "it declares no force_impulse, no sites for [lattice_gas]"
    reversed_ = gas("hpp", lattice_gas={"reversals": (5,)}, output={"observables": ()})
    assert refused(engine, reversed_, NUMPY) is None
    reason = refused(engine, reversed_, BOLTZMANN)
    assert reason == "it declares no lattice_gas.reversals for [lattice_gas]"


def test_schemes_of_gases_and_of_particles_are_kept_apart(interpreted: Worker) -> None:
    spring = Scene(
        name="a",
        dimension=1,
        duration=1.0,
        spring=Spring(k=1.0),
        initial=explicit(np.ones((1, 1)), np.zeros((1, 1))),
    )
    stepping = Method(scheme="verlet", dt=1.0)
    for scene, methods in ((spring, (*GASES, BOLTZMANN)), (gas(), (stepping, Method(scheme="event_driven")))):
        for method in methods:
            reason = refused(RefimplEngine(), scene, method)
            assert reason is not None
            assert reason.startswith(f"its scheme '{method.scheme}' is for [")
            assert reason.endswith(f", not for [{scene.interaction}]")
    with pytest.raises(Unsupported, match=r"refimpl: its scheme .* not for \[lattice_gas\]"):
        interpreted.run(gas(), stepping)
    for name, claims in RefimplEngine.schemes.items():
        assert (claims.kind == "lattice") == (name in EVOLVERS)


@pytest.mark.parametrize("scheme", EVOLVERS)
def test_a_time_step_is_refused(interpreted: Worker, scheme: str) -> None:
    scene = gas(output={"observables": ("populations",)})
    with pytest.raises(UsageError, match=rf"method.dt = 1: scheme '{scheme}' takes whole steps of 1: remove dt"):
        interpreted.run(scene, Method(scheme=scheme, dt=1.0))


def test_a_state_that_cannot_be_is_about_the_scene(interpreted: Worker) -> None:
    with pytest.raises(UsageError, match=r"scene gas: initial: no occupations have mean 0.3 and velocity"):
        interpreted.run(gas(initial={"density": 0.3, "velocity_x": 0.9}), NUMPY)
