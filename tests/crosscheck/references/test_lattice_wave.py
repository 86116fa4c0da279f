"""Sound of the whole Boltzmann equation: a faint wave is that of the linear modes, and a loud one steepens."""

from __future__ import annotations

import math

import numpy as np
import pytest

from crosscheck.references.lattice_models import VELOCITIES, modes
from crosscheck.references.lattice_wave import sound_wave

ROWS, STEPS = 32, 160


@pytest.mark.parametrize(("model", "density"), [("fhp1", 0.3), ("fhp3", 0.5), ("hpp", 0.4)])
def test_a_faint_wave_decays_as_the_linear_modes_do(model: str, density: float) -> None:
    times = np.arange(STEPS + 1)
    signal = sound_wave(model, density, 1e-6, ROWS, times) / (1e-6 * density * VELOCITIES[model].channels)
    assert signal[0] == pytest.approx(1.0, rel=1e-9)
    k = 2 * math.pi / (ROWS * VELOCITIES[model].row_height)
    known = modes(model, density, (0.0, k))
    # over whole periods, after the other modes of the lattice have gone: s(t + T) = exp(-alpha T) s(t)
    period = 2 * math.pi / known.sound_frequency
    start = 40
    later = np.interp(start + period * np.array([0.0, 1.0]), times, signal)
    assert later[1] / later[0] == pytest.approx(math.exp(-known.sound_damping * period), rel=0.02)


def test_a_loud_wave_is_damped_more_where_it_steepens() -> None:
    times = np.arange(0, 400, 2)

    def loss(density: float) -> float:
        loud, faint = (sound_wave("fhp3", density, size, ROWS, times) / size for size in (0.2, 1e-5))
        return float(np.abs(loud[-40:]).max() / np.abs(faint[-40:]).max())

    # g(1/2) = 0
    assert loss(0.3) < 0.98 < loss(0.5) < 1.01
