"""The steady flow between walls is what steps of the Boltzmann equation end in, and has its viscosity."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.references.lattice_channel import Rule, forced_channel, slip_length, steady_channel
from crosscheck.references.lattice_gas import shear_viscosity
from crosscheck.references.lattice_models import VELOCITIES, mean_collision


def stepped(model: str, density: float, rows: int, rule: Rule, steps: int, force: float) -> np.ndarray:
    """Momentum a site of each row over the force, after steps of the nonlinear equation, channel by channel."""
    velocities = VELOCITIES[model]
    integers, c = velocities.integers, velocities.cartesian
    f = np.full((rows, velocities.channels), density)
    for _ in range(steps):
        after = np.empty_like(f)
        for i, (x, y) in enumerate(integers):
            back, mirrored = f[0, integers.index((-x, -y))], f[0, integers.index((x, -y))]
            after[0, i] = back if rule == "bounce_back" else 0.5 * (back + mirrored)
        for row in range(1, rows):
            pushed = f[row].copy()
            pushed[integers.index((2, 0))] += 0.5 * force
            pushed[integers.index((-2, 0))] -= 0.5 * force
            after[row] = pushed + mean_collision(model, pushed)
        for i, (_, up) in enumerate(integers):
            f[:, i] = np.roll(after[:, i], up)
    return f @ c[:, 0] / force


@pytest.mark.parametrize("rule", ["bounce_back", "diffusive_y"])
@pytest.mark.parametrize(("model", "density"), [("fhp3", 0.5), ("fhp_saturated", 0.3)])
def test_the_steady_flow_is_the_end_of_many_steps(model: str, density: float, rule: Rule) -> None:
    rows = 6
    expected = forced_channel(model, density, rows, rule)
    found = stepped(model, density, rows, rule, 700, 1e-7)
    # what moves along the wall row itself stays there, and is not driven
    np.testing.assert_allclose(found[1:], expected[1:], rtol=1e-6)


@pytest.mark.parametrize("model", ["fhp1", "fhp2", "fhp3", "fhp_saturated"])
def test_the_middle_of_the_channel_bends_as_the_viscosity_says(model: str) -> None:
    flow = forced_channel(model, 0.3, 40, "bounce_back")
    bend = np.diff(flow[15:26], 2) / VELOCITIES[model].row_height ** 2
    np.testing.assert_allclose(bend, -1 / shear_viscosity(model, 0.3), rtol=1e-6)


def test_slip_grows_with_the_free_path_and_walls_that_return_less_slip_more() -> None:
    dense, dilute = (slip_length("fhp_saturated", d, "bounce_back") for d in (0.5, 0.1))
    assert -0.5 < dense < 0 < dilute
    assert slip_length("fhp_saturated", 0.5, "diffusive_y") > dense
    # it is a property of the wall, to the second order of the free path over the height
    assert slip_length("fhp_saturated", 0.5, "bounce_back", 32) == pytest.approx(dense, abs=0.02)


@pytest.mark.parametrize("rule", ["bounce_back", "diffusive_y"])
@pytest.mark.parametrize("model", ["fhp3", "fhp_saturated"])
def test_a_faster_flow_is_what_many_steps_of_the_whole_equation_end_in(model: str, rule: Rule) -> None:
    rows, density, force = 6, 0.4, 0.03
    velocities = VELOCITIES[model]
    integers, c = velocities.integers, velocities.cartesian
    forwards, backwards = integers.index((2, 0)), integers.index((-2, 0))
    f = np.full((rows, velocities.channels), density)
    for _ in range(2000):
        after = f + mean_collision(model, f)
        turned = force * after[:, backwards] * (1 - after[:, forwards])
        for row in range(1, rows):
            after[row, forwards] += turned[row]
            after[row, backwards] -= turned[row]
        for i, (x, y) in enumerate(integers):
            back, mirrored = f[0, integers.index((-x, -y))], f[0, integers.index((x, -y))]
            after[0, i] = back if rule == "bounce_back" else 0.5 * (back + mirrored)
        for i, (_, up) in enumerate(integers):
            f[:, i] = np.roll(after[:, i], up)
    steady = steady_channel(model, density, rows, rule, force)
    np.testing.assert_allclose(steady.flow[1:], (f @ c[:, 0])[1:], rtol=1e-9)
    np.testing.assert_allclose(steady.given[1:], 2 * turned[1:], rtol=1e-9)
    # a slow one is what the linearised equation gives, where the force acts after the momentum is looked at, not before
    slow = steady_channel(model, density, rows, rule, 1e-7)
    linear = forced_channel(model, density, rows, rule)
    np.testing.assert_allclose(slow.flow[1:] / slow.given[1], linear[1:] + 1, rtol=1e-5)


def test_a_flow_that_is_too_fast_is_refused() -> None:
    with pytest.raises(ValueError, match="no steady flow is found"):
        steady_channel("fhp3", 0.5, 64, "bounce_back", 0.9)
