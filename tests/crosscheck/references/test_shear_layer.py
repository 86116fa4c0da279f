"""The viscous shear layer where its answer is known: without shear, and without viscosity."""

from __future__ import annotations

import math

import numpy as np
import pytest

from crosscheck.references.shear_layer import disturbance, double_layer, largest_growth

DELTA = 1.0
#: Michalke's fastest wave: k delta = 0.4446.
K = 0.4446


def test_two_layers_in_a_period() -> None:
    y = np.linspace(0, 40, 401)[:-1]
    flow = double_layer(y, 40, 2.0, 1.0)
    np.testing.assert_allclose(flow[::200], [-2, 2], atol=1e-7)
    np.testing.assert_allclose(flow[[100, 300]], 0, atol=1e-7)  # the middles of the layers
    np.testing.assert_allclose(flow, np.roll(-flow, 200), atol=1e-7)
    assert np.gradient(flow, y)[100] == pytest.approx(2.0, rel=1e-2)  # U/delta


def test_fastest_wave_on_a_tanh_layer() -> None:
    """Rayleigh's equation by differences on (-10, 10): largest growth rate of all waves on one layer."""
    y = np.linspace(-10, 10, 801)
    h, u = y[1] - y[0], np.tanh(y)
    curvature = -2 * u / np.cosh(y) ** 2

    def growth(k: float) -> float:
        second = (np.eye(y.size, k=1) + np.eye(y.size, k=-1) - 2 * np.eye(y.size)) / h**2
        inverse = np.linalg.inv(second - k**2 * np.eye(y.size))
        operator = -1j * k * np.diag(u) + 1j * k * curvature[:, None] * inverse
        return float(np.linalg.eigvals(operator).real.max())

    rate = growth(K)
    assert largest_growth(1.0, 1.0) == pytest.approx(rate, rel=2e-3)
    assert largest_growth(3.0, 2.0) == pytest.approx(1.5 * rate, rel=2e-3)


def test_growth_without_viscosity() -> None:
    period, points = 40.0, 256
    spacing = period / points
    flow = double_layer(np.arange(points) * spacing, period, 1.0, DELTA)
    for g in (1.0, 0.5):
        times = np.array([0.0, 60.0, 66.0]) / g
        v = disturbance(flow, spacing, K, 1e-6, g, 1e-3, times)
        size = np.sqrt((np.abs(v) ** 2).mean(axis=1))
        rate = math.log(size[2] / size[1]) / (times[2] - times[1])
        assert rate == pytest.approx(largest_growth(g, DELTA), rel=0.01)


def test_without_shear_a_wave_drifts_and_decays() -> None:
    """v = v_0 exp(-i k g U t - nu k^2 t), U the same everywhere."""
    times = np.array([0.0, 1.0, 7.0])
    found = disturbance(np.full(16, 0.3), 0.5, 0.4, 0.2, 0.7, 0.1, times)
    expected = 0.1 * np.exp(-1j * 0.4 * 0.7 * 0.3 * times - 0.2 * 0.4**2 * times)
    np.testing.assert_allclose(found, np.repeat(expected[:, None], 16, axis=1), rtol=1e-8)
