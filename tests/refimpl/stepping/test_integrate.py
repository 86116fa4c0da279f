"""The step loop: what is recorded and when, what is counted, and what happens when a force fails."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import njit
from numba.extending import register_jitable

from refimpl.compilation import implements
from refimpl.stepping import integrate as module
from refimpl.stepping.forces.generic import (
    DIVERGED,
    GOOD,
    NEEDS_CAPACITY,
    accelerate,
    energy_and_virial,
    enlarge,
    kinetic_energy,
    periods,
    renew,
    status,
)
from refimpl.stepping.forces.gravity import gravity
from refimpl.stepping.forces.spring import spring
from refimpl.stepping.integrate import acceleration, integrate
from refimpl.stepping.schemes import SCHEMES

FORCE = spring(2.0, 0.5, 0.3)
R, V = np.array([1.0, -0.4, 0.2]), np.array([0.1, 0.5, -2.0])
STATUS, SEEN, ENLARGED = 0, 1, 2


class Fussy(NamedTuple):
    """a = -r up to |r| = `room`, for which its work arrays are too small, and `end`, where it has diverged.

    state: the status, evaluations, and how often it was enlarged.
    """

    room: float
    end: float
    state: np.ndarray


def fussy(room: float, end: float = np.inf) -> Fussy:
    return Fussy(room, end, np.zeros(3, dtype=np.int64))


@register_jitable
def _answer(force: Fussy, r: np.ndarray) -> Any:
    """Whether the force can be evaluated at r."""
    force.state[STATUS] = GOOD
    for x in r:
        if not abs(x) <= force.end:
            force.state[STATUS] = DIVERGED
        elif abs(x) > force.room and force.state[STATUS] == GOOD:
            force.state[STATUS] = NEEDS_CAPACITY
    return force.state[STATUS] == GOOD


@implements(accelerate, Fussy)
def _accelerate(force: Fussy, r: np.ndarray, v: np.ndarray) -> np.ndarray:
    force.state[SEEN] += 1
    return -r if _answer(force, r) else np.full(r.size, np.nan)


@implements(energy_and_virial, Fussy)
def _energy_and_virial(force: Fussy, r: np.ndarray) -> tuple[float, float]:
    square = np.sum(r * r) if _answer(force, r) else np.nan
    return 0.5 * square, -square


@implements(kinetic_energy, Fussy)
def _kinetic_energy(force: Fussy, v: np.ndarray) -> float:
    return 0.5 * np.sum(v * v)


@implements(status, Fussy)
def _status(force: Fussy) -> int:
    return force.state[STATUS]


@implements(enlarge, Fussy)
def _enlarge(force: Fussy) -> Fussy:
    force.state[ENLARGED] += 1
    return force._replace(room=1.5 * force.room)


@pytest.fixture
def as_plain_python(monkeypatch: pytest.MonkeyPatch) -> None:
    """The loop as plain Python: every scheme, nothing to compile, and no cache that could be stale."""
    monkeypatch.setattr(module, "_advance", module._advance.py_func)


@pytest.fixture(scope="module")
def compiled_apart() -> Callable[..., Any]:
    return njit(error_model="numpy")(module._advance.py_func)


# -- samples ----------------------------------------------------------------------------------------


@given(steps=st.integers(0, 40), every=st.integers(1, 50), dt=st.floats(1e-3, 0.3))
def test_samples_are_those_of_a_run_sampled_at_every_step(steps: int, every: int, dt: float) -> None:
    all_of_them = integrate("velocity_verlet", FORCE, R, V, dt, steps, every=1, trajectory=True, thermo=True)
    some = integrate("velocity_verlet", FORCE, R, V, dt, steps, every=every, trajectory=True, thermo=True)
    for name in ("positions", "velocities", "thermo"):
        found, expected = getattr(some, name), getattr(all_of_them, name)
        assert len(expected) == steps + 1
        np.testing.assert_array_equal(found, expected[::every])
    np.testing.assert_array_equal(some.r, all_of_them.positions[-1])
    np.testing.assert_array_equal(some.v, all_of_them.velocities[-1])
    np.testing.assert_array_equal(all_of_them.positions[0], R)
    np.testing.assert_array_equal(all_of_them.velocities[0], V)
    assert some.steps == steps


def test_the_default_is_one_sample_at_the_end() -> None:
    run = integrate("velocity_verlet", FORCE, R, V, 0.1, 7, trajectory=True, thermo=True)
    np.testing.assert_array_equal(run.positions, [R, run.r])
    assert run.thermo.shape == (2, 3)


def test_thermo_is_what_the_force_answers() -> None:
    run = integrate("velocity_verlet", FORCE, R, V, 0.1, 9, every=3, trajectory=True, thermo=True)
    expected = [
        (kinetic_energy(FORCE, v), *energy_and_virial(FORCE, r))
        for r, v in zip(run.positions, run.velocities, strict=True)
    ]
    np.testing.assert_allclose(run.thermo, expected, rtol=1e-15)


@pytest.mark.parametrize(("trajectory", "thermo"), [(False, False), (True, False), (False, True)])
@pytest.mark.usefixtures("as_plain_python")
def test_nothing_is_recorded_that_is_not_asked_for(trajectory: bool, thermo: bool) -> None:
    run = integrate("velocity_verlet", FORCE, R, V, 0.1, 4, every=2, trajectory=trajectory, thermo=thermo)
    assert (run.positions is not None) == (run.velocities is not None) == trajectory
    assert (run.thermo is not None) == thermo


def test_no_steps_leave_the_state() -> None:
    run = integrate("velocity_verlet", FORCE, R, V, 0.1, 0, trajectory=True, thermo=True)
    np.testing.assert_array_equal([run.r, run.v], [R, V])
    assert (run.steps, run.diverged, len(run.positions)) == (0, False, 1)


def test_initial_state_is_left_untouched() -> None:
    r, v = R.copy(), V.copy()
    run = integrate("velocity_verlet", FORCE, r, v, 0.1, 3, every=1, trajectory=True, thermo=True)
    run.r[:], run.v[:], run.positions[:] = 0, 0, 0
    np.testing.assert_array_equal([r, v], [R, V])


def test_any_number_type_and_stride_will_do() -> None:
    both = np.array([[1, 2, 3], [4, 5, 6]])
    one = integrate("velocity_verlet", FORCE, both[0, ::-1], both[1], 0.1, 3, every=1, trajectory=True, thermo=True)
    two = integrate(
        "velocity_verlet", FORCE, np.array([3.0, 2, 1]), np.array([4.0, 5, 6]), 0.1, 3, every=1, trajectory=True,
        thermo=True,
    )  # fmt: skip
    np.testing.assert_array_equal(one.positions, two.positions)


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"steps": -1}, ValueError, "got steps = -1"),
        ({"every": 0}, ValueError, "every = 0"),
        ({"v": V[:2]}, ValueError, r"flat and of one shape, got \(3,\) and \(2,\)"),
        ({"r": R[:, None], "v": V[:, None]}, ValueError, "flat and of one shape"),
        ({"scheme": "magic"}, KeyError, "magic"),
    ],
)
def test_bad_arguments_are_named(change: dict[str, Any], error: type[Exception], message: str) -> None:
    arguments = {"scheme": "verlet", "force": FORCE, "r": R, "v": V, "dt": 0.1, "steps": 1} | change
    with pytest.raises(error, match=message):
        integrate(**arguments)


def test_acceleration_is_the_force_s() -> None:
    a, force = acceleration(FORCE, R, V)
    np.testing.assert_array_equal(a, accelerate(FORCE, R, V))
    assert force is FORCE


# -- divergence -------------------------------------------------------------------------------------


def test_a_state_that_is_not_finite_is_divergence() -> None:
    run = integrate("velocity_verlet", spring(1e6, 1.0, 1.0), R, V, 10.0, 60, trajectory=True, thermo=True)
    assert run.diverged
    assert not np.isfinite(run.r).all()


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.usefixtures("as_plain_python")
def test_a_failed_step_changes_nothing(scheme: str) -> None:
    r, v = np.array([1.0, 0.2]), np.array([4.0, 0.0])
    free = integrate(scheme, fussy(np.inf), r, v, 0.1, 20, every=1, trajectory=True, thermo=True)
    run = integrate(scheme, fussy(np.inf, end=2.5), r, v, 0.1, 20, every=1, trajectory=True, thermo=True)
    assert run.diverged
    assert 0 < run.steps < 20
    np.testing.assert_array_equal(run.r, free.positions[run.steps])
    np.testing.assert_array_equal(run.v, free.velocities[run.steps])
    np.testing.assert_array_equal(run.positions[: run.steps + 1], free.positions[: run.steps + 1])
    assert np.isnan(run.positions[run.steps + 1 :]).all()
    assert np.isnan(run.thermo[run.steps + 1 :]).all()
    assert run.evaluations == SCHEMES[scheme].start_evaluations + run.steps * SCHEMES[scheme].evaluations


@pytest.mark.usefixtures("as_plain_python")
def test_a_start_that_diverges_takes_no_step() -> None:
    run = integrate("velocity_verlet", fussy(np.inf, end=0.5), R, V, 0.1, 20, trajectory=True)
    assert (run.diverged, run.steps) == (True, 0)
    np.testing.assert_array_equal(run.r, R)


# -- far from the origin -----------------------------------------------------------------------------


class Stream(NamedTuple):
    """No force, in boxes of side 4 along the first coordinate of two. state: how often it was told to renew."""

    state: np.ndarray


@implements(accelerate, Stream)
def _no_acceleration(force: Stream, r: np.ndarray, v: np.ndarray) -> np.ndarray:
    assert (abs(r[::2]) < 2.0**17 * 4).all(), "brought back in time"
    return np.zeros_like(r)


@implements(periods, Stream)
def _periods(force: Stream) -> np.ndarray:
    return np.array([4.0, 0.0] * 2)


@implements(renew, Stream)
def _renew(force: Stream) -> None:
    force.state[0] += 1


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.usefixtures("as_plain_python")
def test_after_1e9_boxes_a_particle_streams_as_at_the_start(scheme: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """2^10 + 2^-25 boxes a step, from 2^30 boxes away: added there, 2^-25 would be rounded off at each step."""
    monkeypatch.setattr(module, "STRIDE", 64)
    dt, steps, side = 2.0**-6, 1024, 4.0
    a_step = side * (2.0**10 + 2.0**-25)
    r, v = np.array([side * 2.0**30, 0.25, -side * 2.0**30, 0.5]), np.array([a_step, 0.5, -a_step, 0.0]) / dt
    force = Stream(np.zeros(1, dtype=np.int64))
    run = integrate(scheme, force, r, v, dt, steps, every=256, trajectory=True)
    expected = r + np.arange(0, steps + 1, 256)[:, None] * dt * v
    np.testing.assert_array_equal(run.positions, expected)
    np.testing.assert_array_equal(run.r, expected[-1])
    np.testing.assert_array_equal(run.v, v)
    assert not run.diverged
    assert force.state[0] >= steps // 64
    still = integrate(scheme, force, r, v, dt, 0, trajectory=True)
    np.testing.assert_array_equal([still.r, still.positions[0]], [r, r])


# -- work arrays that are too small ------------------------------------------------------------------


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("room", [0.5, 1.01, 2.1, 3.0])
@pytest.mark.usefixtures("as_plain_python")
def test_enlarging_in_between_changes_nothing(scheme: str, room: float) -> None:
    """From too small at the start to too small only once, in the middle: every number is that of a roomy force."""
    r, v = np.array([1.0, 0.2]), np.array([4.0, 0.0])
    options: dict[str, Any] = {"every": 2, "trajectory": True, "thermo": True}
    roomy = integrate(scheme, fussy(np.inf), r, v, 0.1, 20, **options)
    force = fussy(room)
    run = integrate(scheme, force, r, v, 0.1, 20, **options)
    assert force.state[ENLARGED] > 0
    assert run.force.room > room
    assert (run.diverged, run.steps, run.evaluations) == (False, 20, roomy.evaluations)
    for name in ("r", "v", "positions", "velocities", "thermo"):
        np.testing.assert_array_equal(getattr(run, name), getattr(roomy, name))


def test_enlarging_in_the_compiled_loop(compiled_apart: Callable[..., Any], monkeypatch: pytest.MonkeyPatch) -> None:
    # compiled anew, not from the cache: the cache would not see a change of the force in this file
    monkeypatch.setattr(module, "_advance", compiled_apart)
    r, v = np.array([1.0, 0.2]), np.array([4.0, 0.0])
    options: dict[str, Any] = {"every": 2, "trajectory": True}  # thermo compiles for twice as long
    roomy = integrate("velocity_verlet", fussy(np.inf), r, v, 0.1, 20, **options)
    force = fussy(1.01)
    run = integrate("velocity_verlet", force, r, v, 0.1, 20, **options)
    assert force.state[ENLARGED] == 4
    assert run.force.room == pytest.approx(1.01 * 1.5**4)
    assert (run.diverged, run.steps, run.evaluations) == (False, 20, 21)
    for name in ("r", "v", "positions", "velocities"):
        np.testing.assert_array_equal(getattr(run, name), getattr(roomy, name))
    # the failed evaluations are extra; those of a roomy force are counted exactly
    assert roomy.force.state[SEEN] == 21

    lost = integrate("velocity_verlet", fussy(np.inf, end=2.5), r, v, 0.1, 20, **options)
    assert lost.diverged
    np.testing.assert_array_equal(lost.positions[lost.steps // 2], roomy.positions[lost.steps // 2])


def test_acceleration_enlarges_the_force() -> None:
    force = fussy(0.5)
    a, larger = acceleration(force, R, V)
    np.testing.assert_array_equal(a, -R)
    assert larger.room >= 1


@pytest.mark.parametrize(("scheme", "evaluations"), [("euler", 0), ("velocity_verlet", 1)])
def test_what_a_force_could_not_do_before_is_no_reason_to_enlarge_it(scheme: str, evaluations: int) -> None:
    """A start that does not evaluate the force was repeated, and the force enlarged, without end."""
    force = fussy(5.0)
    force.state[STATUS] = NEEDS_CAPACITY
    run = integrate(scheme, force, R, V, 0.1, 0)
    assert run.force.state[SEEN] == evaluations
    assert run.force.state[ENLARGED] == 0


def _cloud(bodies: int, dimension: int, softening: float | None) -> tuple[Any, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(bodies)
    masses = rng.uniform(0.0, 1.0, bodies)
    masses[1:2] = 0.0
    size = bodies * dimension
    return gravity(masses, dimension, 1.7, softening), rng.normal(size=size), 0.1 * rng.normal(size=size)


@pytest.mark.parametrize(
    ("scheme", "system"),
    [
        ("euler", _cloud(3, 2, None)),
        ("velocity_verlet", _cloud(16, 3, 0.3)),
        ("leapfrog", _cloud(1, 3, None)),
        ("beeman_pc", _cloud(2, 3, None)),
        ("verlet", (spring(2.0, 0.5), R, V)),
        ("euler_pc", (FORCE, np.arange(40.0), np.ones(40))),
    ],
)
def test_many_steps_of_few_bodies_have_the_bits_of_those_with_arrays(
    scheme: str, system: tuple[Any, np.ndarray, np.ndarray], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Samples on the way, a run that goes on, and one in pieces."""
    force, r, v = system
    begun = (r.copy(), v.copy())
    runs = {}
    for many in (1000, 10**9):
        monkeypatch.setattr(module, "MANY_STEPS", many)
        first = integrate(scheme, force, r, v, 1e-3, 1403, every=700, trajectory=True, pace=lambda done: 500)
        runs[many] = (first, integrate(scheme, force, r, v, 1e-3, 1200, state=first.state))
    assert np.array_equal(r, begun[0])
    assert np.array_equal(v, begun[1])
    for few, arrays in zip(*runs.values(), strict=True):
        assert few.steps == arrays.steps
        assert few.evaluations == arrays.evaluations
        assert np.array_equal(few.r, arrays.r)
        assert np.array_equal(few.v, arrays.v)
    assert np.array_equal(runs[1000][0].positions, runs[10**9][0].positions)


def test_bodies_that_meet_stop_a_long_run_at_the_step_at_which_arrays_stop(monkeypatch: pytest.MonkeyPatch) -> None:
    r, v = np.array([-0.5, 0.0, 0.5, 0.0]), np.array([1.0, 0.0, -1.0, 0.0])
    force = gravity(np.zeros(2), 2)
    runs = []
    for many in (1000, 10**9):
        monkeypatch.setattr(module, "MANY_STEPS", many)
        runs.append(integrate("leapfrog", force, r, v, 2.0**-10, 2000))
    assert [run.diverged for run in runs] == [True, True]
    assert [run.steps for run in runs] == [511, 511]
    assert np.array_equal(runs[0].r, runs[1].r)


def test_gear_and_unlike_masses_stay_with_arrays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MANY_STEPS", 1000)
    monkeypatch.setattr(module, "_advance_in_registers", None)
    assert integrate("gear3", FORCE, R, V, 1e-3, 1001).steps == 1001
    assert integrate("leapfrog", spring(2.0, np.array([1.0, 2.0, 3.0])), R, V, 1e-3, 1001).steps == 1001
