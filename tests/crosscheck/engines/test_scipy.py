"""SciPy's solvers: forces beside an independent sum, tolerances, samples, counts, and what they refuse."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.engines.capabilities import refusal
from crosscheck.engines.protocol import shapes
from crosscheck.engines.scipy import ScipyEngine
from crosscheck.engines.workers.worker import _check_step
from crosscheck.errors import UsageError
from crosscheck.references import kepler, oscillator
from crosscheck.references.smooth_forces import accelerations, smooth
from crosscheck.scene import Gravity, Kepler, Method, Output, Scene, Spring, explicit

ENGINE = ScipyEngine()
SCHEMES = list(ENGINE.schemes)
by_scheme = pytest.mark.parametrize("scheme", SCHEMES)
ALL = ("kinetic_energy", "potential_energy", "virial")


def oscillators(**changes: object) -> Scene:
    entries: dict[str, object] = {
        "name": "oscillators",
        "dimension": 2,
        "duration": 3.0,
        "masses": (1.5, 0.5),
        "spring": Spring(k=2.0, gamma=0.3),
        "initial": explicit(np.array([[1.0, 0.2], [0.0, -2.0]]), np.array([[0.3, 0.0], [1.0, 0.4]])),
        "output": Output(interval=0.5, trajectory=True, observables=ALL, forces=True),
    }
    return Scene.model_validate(entries | changes)


def bodies(softening: float | None = None, **changes: object) -> Scene:
    rng = np.random.default_rng(3)
    entries: dict[str, object] = {
        "name": "bodies",
        "dimension": 3,
        "duration": 1.0,
        "masses": (2.0, 0.7, 0.0, 1.1),
        "gravity": Gravity(G=1.3, softening=softening),
        "initial": explicit(rng.normal(size=(4, 3)), rng.normal(size=(4, 3))),
        "output": Output(interval=0.25, trajectory=True, observables=ALL, forces=True),
    }
    return Scene.model_validate(entries | changes)


@pytest.mark.parametrize("scene", [oscillators(), bodies(), bodies(0.4)], ids=["springs", "bodies", "softened"])
def test_forces_energies_and_virial_are_those_of_an_independent_sum(scene: Scene) -> None:
    run = ENGINE.run(scene, Method(scheme="DOP853", tolerance=1e-8))
    for sample, r in enumerate(run["positions"]):
        exact = smooth(scene, r)
        assert run["potential_energy"][sample] == pytest.approx(float(exact.energy), rel=1e-13)
        assert run["virial"][sample] == pytest.approx(float(exact.virial), rel=1e-13)
    masses = scene.initial_state().masses
    expected = masses[:, None] * accelerations(scene, run["final_positions"], run["final_velocities"])
    np.testing.assert_allclose(run["forces"], expected.astype(float), rtol=1e-12, atol=1e-13)
    kinetic = 0.5 * (masses[:, None] * run["velocities"] ** 2).sum((1, 2))
    np.testing.assert_allclose(run["kinetic_energy"], kinetic, rtol=1e-14)
    for name, shape in shapes(scene, len(run["time"])).items():
        assert run[name].shape == shape


@by_scheme
def test_errors_follow_the_tolerance(scheme: str) -> None:
    scene, errors = oscillators(masses=1.0), []
    for tolerance in (1e-4, 1e-7, 1e-10):
        run = ENGINE.run(scene, Method(scheme=scheme, tolerance=tolerance))
        start = scene.initial_state()
        exact = [
            oscillator.solution(run["time"], start.positions[i, k], start.velocities[i, k], 2**0.5, 0.15)[0]
            for i in range(2)
            for k in range(2)
        ]
        errors.append(abs(run["positions"].reshape(-1, 4) - np.array(exact).T).max())
        assert errors[-1] < 100 * tolerance
        assert (run["time"] == scene.samples()).all()
    assert errors[0] > 20 * errors[1] > 400 * errors[2]


@by_scheme
def test_units_do_not_matter_but_for_rounding(scheme: str) -> None:
    """Lengths times 2^40, times times 2^-20: the same steps, the same numbers, scaled."""
    scene, length, time = oscillators(), 2.0**40, 2.0**-20
    start = scene.initial_state()
    other = oscillators(
        duration=scene.duration * time,
        spring=Spring(k=2.0 / time**2, gamma=0.3 / time),
        initial=explicit(start.positions * length, start.velocities * length / time),
        output=scene.output.model_copy(update={"interval": 0.5 * time}),
    )
    method = Method(scheme=scheme, tolerance=1e-6)
    one, two = ENGINE.run(scene, method), ENGINE.run(other, method)
    assert one.cost.steps == two.cost.steps
    np.testing.assert_allclose(two["positions"] / length, one["positions"], rtol=1e-12, atol=1e-12)


@by_scheme
def test_the_end_is_the_end_of_a_step_and_the_last_sample(scheme: str) -> None:
    scene = Scene(
        name="kepler",
        dimension=2,
        duration=2 * np.pi,
        masses=(3.0, 1.0),
        gravity=Gravity(G=2.0),
        initial=Kepler(kind="kepler", semi_major_axis=2.0, eccentricity=0.5),
        output=Output(interval=2 * np.pi / 8, trajectory=True),
    )
    run = ENGINE.run(scene, Method(scheme=scheme, tolerance=1e-9))
    assert (run["positions"][-1] == run["final_positions"]).all()
    exact, _ = kepler.two_bodies(run["time"], (3.0, 1.0), 0.5, 2.0, 2.0)
    # the samples in between are of the dense output, whose error is of the tolerance too
    assert abs(run["positions"] - exact).max() < 1e-5
    assert run.cost.evaluations > run.cost.steps > 10


def test_starts_at_the_origin_and_runs_of_no_duration() -> None:
    at_rest = oscillators(initial=explicit(np.zeros((2, 2)), np.zeros((2, 2))))
    assert not ENGINE.run(at_rest, Method(scheme="RK45", tolerance=1e-6))["positions"].any()
    still = ENGINE.run(oscillators(duration=0.0), Method(scheme="Radau", tolerance=1e-6))
    assert still["positions"].shape[0] == 1
    assert still.cost.steps == 0


def test_a_run_into_a_collision_says_why_it_ended() -> None:
    scene = bodies(
        dimension=2,
        masses=(1.0, 1.0),
        initial=explicit(np.array([[-1.0, 0.0], [1.0, 0.0]]), np.zeros((2, 2))),
        duration=10.0,
        output=Output(),
        gravity=Gravity(),
    )
    run = ENGINE.run(scene, Method(scheme="DOP853", tolerance=1e-10))
    assert run.stopped or run.diverged or run.cost.steps > 100


def test_tolerances_below_rounding_are_refused() -> None:
    assert "below what doubles allow" in str(ENGINE.supports(bodies(), Method(scheme="RK45", tolerance=1e-15)))
    assert ENGINE.supports(bodies(), Method(scheme="RK45", tolerance=1e-12)) is None
    assert refusal(ENGINE, bodies(), Method(scheme="RK45", tolerance=1e-9)) is None


@pytest.mark.parametrize(
    ("scheme", "entries", "words"),
    [
        ("RK45", {}, "method.tolerance is missing: scheme 'RK45' chooses its own time steps: add tolerance"),
        ("RK45", {"dt": 0.1}, "method.dt = 0.1: scheme 'RK45' chooses its own time steps: remove dt"),
    ],
)
def test_a_tolerance_is_asked_for(scheme: str, entries: dict[str, float], words: str) -> None:
    with pytest.raises(UsageError, match=words):
        _check_step(ENGINE.schemes[scheme], Method.model_validate({"scheme": scheme, **entries}))


def test_a_solver_that_gets_nowhere_is_stopped() -> None:
    """LSODA at a loose tolerance comes so near to a collision that its steps never grow again."""
    scene = Scene(
        name="kepler",
        dimension=2,
        duration=20 * np.pi,
        masses=(3.0, 1.0),
        gravity=Gravity(G=2.0),
        initial=Kepler(kind="kepler", semi_major_axis=2.0, eccentricity=0.5),
        output=Output(interval=2 * np.pi / 5, trajectory=True),
    )
    run = ENGINE.run(scene, Method(scheme="LSODA", tolerance=1e-2))
    assert "10000 steps took it" in run.stopped
    assert np.isfinite(run["final_positions"]).all()
    assert np.isnan(run["positions"][-1]).all()
