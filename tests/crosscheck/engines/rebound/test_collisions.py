"""Hard spheres in REBOUND: single impacts in closed form, what a gas conserves, and what the searches find."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosscheck.checks.base import schemes_with
from crosscheck.engines.capabilities import refusal
from crosscheck.engines.rebound.collisions import MOST_ROOT_BOXES, root_boxes
from crosscheck.engines.rebound.engine import SEARCHES, ReboundEngine
from crosscheck.engines.workers.pool import Worker
from crosscheck.errors import UsageError
from crosscheck.scene import (
    Box,
    Contact,
    Cylinder,
    Explicit,
    Floats,
    GrainFriction,
    Gravity,
    HardSpheres,
    Lattice,
    Method,
    Output,
    Scene,
    Well,
    explicit,
)

ROUNDING = float(np.finfo(float).eps)
each_search = pytest.mark.parametrize("scheme", SEARCHES)


@pytest.fixture(scope="module")
def rebound() -> Iterator[Worker]:
    worker = Worker("rebound", time_limit=60)
    yield worker
    worker.close()


def pair(**changes: Any) -> Scene:
    """Two disks, their surfaces 2 apart, that meet head-on after t = 1."""
    entries: dict[str, Any] = {
        "name": "pair",
        "dimension": 2,
        "duration": 2.0,
        "masses": (1.0, 3.0),
        "species": (0, 1),
        "hard_spheres": HardSpheres(diameter=(1.0, 2.0)),
        "initial": Explicit(positions=((0.0, 0.0), (3.5, 0.0)), velocities=((1.5, 0.0), (-0.5, 0.0))),
        "output": Output(interval=1 / 16, observables=("collisions",), trajectory=True),
    }
    return Scene(**(entries | changes))


def gas(number: int, fraction: float, duration: float, dimension: int = 2, **changes: Any) -> Scene:
    entries: dict[str, Any] = {
        "name": "gas",
        "dimension": dimension,
        "duration": duration,
        "hard_spheres": HardSpheres(),
        "box": Box(packing_fraction=fraction),
        "initial": Lattice(
            kind="lattice", structure="square" if dimension == 2 else "sc", number=number, temperature=1.0, seed=11
        ),
        "output": Output(interval=duration / 20, observables=("kinetic_energy", "collisions"), trajectory=True),
    }
    return Scene(**(entries | changes))


# -- one impact --------------------------------------------------------------------------------------------------------


@each_search
@pytest.mark.parametrize("restitution", [1.0, 0.8, 0.25])
def test_head_on(rebound: Worker, scheme: str, restitution: float) -> None:
    spheres = HardSpheres(diameter=(1.0, 2.0), restitution=restitution)
    run = rebound.run(pair(hard_spheres=spheres), Method(scheme=scheme, dt=1 / 32))
    # the centre of mass rests; touching is overlapping, and t = 1 is the end of a step
    after = np.array([[-1.5, 0.0], [0.5, 0.0]]) * restitution
    np.testing.assert_allclose(run["final_velocities"], after, atol=4 * ROUNDING)
    np.testing.assert_allclose(run["final_positions"], np.array([[1.5, 0.0], [3.0, 0.0]]) + after, atol=100 * ROUNDING)
    np.testing.assert_array_equal(run["collisions"], np.arange(33) >= 16)
    assert (run.cost.steps, run.cost.events, run.cost.evaluations) == (64, 1, 0)


@settings(max_examples=40, deadline=None)
@given(
    offset=st.floats(-1.2, 1.2),
    speed=st.floats(0.5, 2.0),
    mass=st.floats(0.01, 100.0),
    restitution=st.floats(0.05, 1.0),
    scheme=st.sampled_from(list(SEARCHES)),
)
def test_any_impact(rebound: Worker, offset: float, speed: float, mass: float, restitution: float, scheme: str) -> None:
    """Momentum and restitution; no friction. The normal is that at the end of the step."""
    scene = pair(
        masses=(1.0, mass),
        hard_spheres=HardSpheres(diameter=(1.0, 2.0), restitution=restitution),
        initial=Explicit(positions=((0.0, 0.0), (2.0, offset)), velocities=((speed, 0.1), (-0.2, 0.0))),
        output=Output(interval=1 / 64, trajectory=True),
    )
    run = rebound.run(scene, Method(scheme=scheme, dt=1 / 64))
    momentum = np.einsum("n,snd->sd", [1.0, mass], run["velocities"])
    np.testing.assert_allclose(momentum, momentum[[0]] * np.ones((129, 1)), atol=8 * ROUNDING * (1 + mass) * speed)
    hit = int(np.flatnonzero(np.diff(run["velocities"][:, 0, 0]))[0]) + 1
    apart = run["positions"][hit, 0] - run["positions"][hit, 1]
    normal = apart / np.linalg.norm(apart)
    before, after = (run["velocities"][k, 0] - run["velocities"][k, 1] for k in (hit - 1, hit))
    assert 1.5 - (speed + 0.3) / 64 <= np.linalg.norm(apart) <= 1.5
    expected = before - (1 + restitution) * (before @ normal) * normal
    np.testing.assert_allclose(after, expected, atol=16 * ROUNDING * speed)


class Pairs:
    """Pairs far apart: a disk with velocity 1 along x, and one at rest at impact parameter b, both of diameter 1."""

    def __init__(self, number: int, widest: float) -> None:
        rng = np.random.default_rng(5)
        self.number, self.b = number, rng.uniform(-widest, widest, number)
        #: Until they touch, and from then on until they would be closest.
        self.before, self.inside = rng.uniform(0.5, 1.5, number), np.sqrt(1 - self.b**2)
        self.places = 6.0 * np.stack(np.divmod(np.arange(number), 10), axis=1)
        others = self.places + np.stack([self.inside + self.before, self.b], axis=1)
        self.scene = gas(
            2 * number,
            0.1,
            3.0,
            box=None,
            initial=explicit(
                np.concatenate([self.places, others]), np.repeat([[1.0, 0.0], [0.0, 0.0]], number, axis=0)
            ),
            output=Output(),
        )


@each_search
def test_late_impacts_are_of_first_order(rebound: Worker, scheme: str) -> None:
    pairs = Pairs(100, widest=0.7)
    touching = np.stack([pairs.inside, pairs.b], axis=1)
    exchanged = touching[:, [0]] * touching
    exact = pairs.places + np.array([3.0, 0.0]) - (3.0 - pairs.before)[:, None] * exchanged
    errors = []
    for dt in (1 / 16, 1 / 64):
        run = rebound.run(pairs.scene, Method(scheme=scheme, dt=dt))
        assert run.cost.events == pairs.number
        errors.append(np.linalg.norm(run["final_positions"][: pairs.number] - exact, axis=1).mean())
    # late by a share of dt that is uniform: the mean has a relative standard error of 1/sqrt(3 number), twice
    assert errors[0] / errors[1] == pytest.approx(4, rel=4 * np.sqrt(2 / (3 * pairs.number)))


@each_search
def test_grazing_pairs_pass_unseen(rebound: Worker, scheme: str) -> None:
    """A pair is seen if a step ends between first contact and closest approach."""
    pairs, dt = Pairs(300, widest=1.0), 3 / 8
    seen = np.ceil(pairs.before / dt) * dt < pairs.before + pairs.inside
    run = rebound.run(pairs.scene, Method(scheme=scheme, dt=dt))
    np.testing.assert_array_equal(run["final_velocities"][: pairs.number, 0] != 1, seen)
    assert run.cost.events == seen.sum() < pairs.number


@each_search
def test_no_search_sees_a_pair_that_has_passed(rebound: Worker, scheme: str) -> None:
    # at the end of the step their centres have passed each other, by less than their contact distance
    run = rebound.run(pair(output=Output()), Method(scheme=scheme, dt=2.0))
    assert run.cost.events == 0
    np.testing.assert_array_equal(run["final_velocities"], [[1.5, 0.0], [-0.5, 0.0]])


# -- space -------------------------------------------------------------------------------------------------------------


@each_search
@pytest.mark.parametrize("dt", [1.0, 1 / 64])
def test_unwrapped_and_in_order(rebound: Worker, scheme: str, dt: float) -> None:
    """Small spheres cross a flat box, by less and by more than half a box a step, and never touch."""
    scene = Scene(
        name="flight",
        dimension=3,
        duration=8.0,
        masses=(1.0, 2.0, 3.0, 1e-3),
        hard_spheres=HardSpheres(diameter=0.001),
        box=Box(lengths=(3.0, 1.5, 4.5)),
        initial=Explicit(
            positions=((0.1, 0.2, 0.3), (2.9, 1.4, 4.0), (-1.0, 0.7, 9.5), (1.3, 0.4, 2.2)),
            velocities=((3.3, -1.7, 0.2), (-0.9, 0.31, 2.3), (0.01, -0.02, 0.03), (-6.1, 11.3, 7.7)),
        ),
        output=Output(interval=2.0, trajectory=True),
    )
    run = rebound.run(scene, Method(scheme=scheme, dt=dt))
    state = scene.initial_state()
    exact = state.positions + run["time"][:, None, None] * state.velocities
    assert run.cost.events == 0
    np.testing.assert_array_equal(run["final_velocities"], state.velocities)
    # every step adds two roundings of a coordinate of at most a box
    np.testing.assert_allclose(run["positions"], exact, rtol=0, atol=2 * 8 / dt * 4.5 * ROUNDING)


@each_search
def test_impact_across_a_corner_of_the_box(rebound: Worker, scheme: str) -> None:
    scene = pair(
        masses=1.0,
        species=None,
        hard_spheres=HardSpheres(),
        box=Box(lengths=(6.0, 3.0)),
        duration=1.0,
        initial=Explicit(positions=((1.25, 1.25), (5.75, 2.75)), velocities=((-1.0, -1.0), (0.0, 0.0))),
    )
    run = rebound.run(scene, Method(scheme=scheme, dt=1 / 256))
    np.testing.assert_allclose(run["final_velocities"], [[0.0, 0.0], [-1.0, -1.0]], atol=4 * ROUNDING)
    np.testing.assert_allclose(run["final_positions"].sum(axis=0), [6.0, 3.0], atol=1000 * ROUNDING)


@each_search
def test_open_space_has_no_edge(rebound: Worker, scheme: str) -> None:
    """Far away a disk catches up with another."""
    flight = Explicit(positions=((0.0, 0.0), (26.0, 0.0)), velocities=((2.0, 0.0), (1.5, 0.0)))
    scene = pair(masses=1.0, species=None, hard_spheres=HardSpheres(), initial=flight, duration=64.0, output=Output())
    run = rebound.run(scene, Method(scheme=scheme, dt=1 / 4))
    np.testing.assert_allclose(run["final_positions"], [[121.0, 0.0], [129.0, 0.0]], atol=256 * 128 * ROUNDING)
    np.testing.assert_allclose(run["final_velocities"], [[1.5, 0.0], [2.0, 0.0]], atol=4 * ROUNDING)


# -- gases -------------------------------------------------------------------------------------------------------------


@each_search
@pytest.mark.parametrize("dimension", [2, 3])
def test_elastic_gas(rebound: Worker, scheme: str, dimension: int) -> None:
    """It is dense enough, for long enough, that disks left to leave their plane by a rounding error would do so."""
    scene = gas(36 if dimension == 2 else 27, 0.4 if dimension == 2 else 0.2, 20.0, dimension)
    run = rebound.run(scene, Method(scheme=scheme, dt=1 / 40))
    assert run.cost.events > 500
    # each impact rounds a few times, at random
    rounding = 16 * ROUNDING * np.sqrt(run.cost.events)
    np.testing.assert_allclose(run["kinetic_energy"], run["kinetic_energy"][0], rtol=rounding)
    np.testing.assert_allclose(run["velocities"].sum(axis=1), 0.0, atol=rounding * scene.number)
    again = rebound.run(scene, Method(scheme=scheme, dt=1 / 40))
    np.testing.assert_array_equal(again["positions"], run["positions"])


@each_search
def test_impacts_are_counted_once(rebound: Worker, scheme: str) -> None:
    """Sampled at every step, the velocities tell how many pairs have collided."""
    dt = 1 / 512
    scene = gas(36, 0.1, 2.0, hard_spheres=HardSpheres(restitution=0.9))
    run = rebound.run(
        scene.changed(output=Output(interval=dt, observables=("collisions",), trajectory=True)),
        Method(scheme=scheme, dt=dt),
    )
    changed = (np.diff(run["velocities"], axis=0) != 0).any(axis=2).sum(axis=1)
    assert set(changed) == {0, 2}
    np.testing.assert_array_equal(np.diff(run["collisions"]), changed / 2)
    assert run.cost.events == run["collisions"][-1] > 15


@each_search
def test_rest_in_contact_is_no_collision(rebound: Worker, scheme: str) -> None:
    """A row of disks that touch hands the first one's velocity on to the last one, which has nobody to hit."""
    row = tuple((float(x), 0.0) for x in (-2, 0, 1, 2))
    scene = gas(4, 0.1, 3.0, box=None, initial=Explicit(positions=row, velocities=((1.0, 0.0), *((0.0, 0.0),) * 3)))
    run = rebound.run(scene, Method(scheme=scheme, dt=3 / 40))
    assert run.cost.events == 3
    # three impulses turned by the sine of pi, or not
    np.testing.assert_allclose(run["final_velocities"], [[0.0, 0.0]] * 3 + [[1.0, 0.0]], atol=4 * ROUNDING)


def test_the_searches_find_the_same_pairs(rebound: Worker) -> None:
    scene = gas(36, 0.1, 4.0, box=Box(lengths=(24.0, 12.0)), species=(0, 1) * 18)
    scene = scene.changed(hard_spheres=HardSpheres(diameter=(0.5, 1.5), restitution=0.9))
    runs = [rebound.run(scene, Method(scheme=scheme, dt=0.005)) for scheme in SEARCHES]
    assert runs[0].cost.events > 20
    for run in runs[1:]:
        # no two collisions in one step depend on each other: the order in which they are resolved does not matter
        np.testing.assert_array_equal(run["positions"], runs[0]["positions"])


# -- what is asked and refused -----------------------------------------------------------------------------------------


def test_claims() -> None:
    claims = ReboundEngine.schemes
    assert {name for name, claim in claims.items() if claim.kind == "collision_search"} == set(SEARCHES)
    assert {variant.name for variant in schemes_with()(claims)} == set(claims) - set(SEARCHES)


def test_a_time_step_is_needed(rebound: Worker) -> None:
    with pytest.raises(UsageError, match="dt is missing"):
        rebound.run(pair(), Method(scheme="collisions_tree"))


def _species(**entries: Any) -> dict[str, Any]:
    return {"hard_spheres": HardSpheres(diameter=(1.0, 2.0), **entries)}


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({}, None),
        (_species(restitution=0.0), "counts a pair again"),
        (_species(restitution=0.0) | {"output": Output()}, None),
        ({"hard_spheres": HardSpheres(diameter=(0.0, 1.0))}, None),
        ({"hard_spheres": HardSpheres(diameter=0.0)}, "at most one diameter may be 0"),
        (_species(friction=GrainFriction(tangential_restitution=0.5)), "no hard_spheres.friction"),
        (_species(well=Well(depth=1.0, range=1.2)), "no hard_spheres.well"),
        (_species(contact_duration=0.1), "no hard_spheres.contact_duration"),
        (_species(fixed=(0,)) | {"initial": Explicit(positions=((0.0, 0.0), (3.5, 0.0)))}, "no hard_spheres.fixed"),
        ({"acceleration": (0.0, -1.0)}, "no acceleration"),
        ({"output": Output(collisions=(1,))}, "no output.collisions"),
        ({"box": Box(lengths=(8.0, 8.0)), "output": Output(fields=(2, 2))}, "no output.fields"),
        (
            {"output": Output(interval=1.0, observables=("potential_energy", "events"))},
            "no events, no potential_energy",
        ),
        ({"box": Box(lengths=(8.0, 8.0), boundaries=("open", "open"))}, None),
        ({"box": Box(lengths=(8.0, 8.0), boundaries=("periodic", "open"))}, "open along all"),
        ({"box": Box(lengths=(8.0, 8.0), boundaries=("periodic", "hard"))}, "no box.boundaries=hard"),
        (
            {"box": Box(lengths=(8.0, 8.0), boundaries=("open", "open"), cylinder=Cylinder(radius=4.0))},
            "no box.cylinder",
        ),
        ({"box": Box(lengths=(8.0, 12.0))}, None),
        ({"box": Box(lengths=(8.0, 8.0 * np.sqrt(2)))}, "equal cubes"),
    ],
)
def test_reasons(changes: dict[str, Any], reason: str | None) -> None:
    scene, method = pair(**changes), Method(scheme="collisions_direct", dt=0.1)
    found = refusal(ReboundEngine, scene, method) or ReboundEngine().supports(scene, method)
    assert (found is None) == (reason is None)
    assert (reason or "") in (found or "")


def test_no_softness_and_no_gravity() -> None:
    soft = Method(scheme="collisions_tree", dt=0.1, contact=Contact(stiffness=1.0))
    assert "declares no method.contact" in str(refusal(ReboundEngine, pair(), soft))
    stars = pair(hard_spheres=None, gravity=Gravity(), output=Output())
    assert "is for [hard_spheres], not for [gravity]" in str(
        refusal(ReboundEngine, stars, Method(scheme="collisions_line", dt=0.1))
    )


@given(
    numbers=st.lists(st.integers(1, MOST_ROOT_BOXES), min_size=2, max_size=3),
    edge=st.floats(1e-3, 1e3),
)
def test_root_boxes(numbers: list[int], edge: float) -> None:
    lengths: Floats = np.multiply(numbers, edge)
    found = root_boxes(lengths)
    assert found is not None
    assert found[1] == tuple(np.array(numbers) // np.gcd.reduce(numbers))
    np.testing.assert_allclose(np.multiply(found[1], found[0]), lengths, rtol=4 * ROUNDING)
