"""Sound of any amplitude by the whole lattice Boltzmann equation, whose damping grows with the amplitude.

The occupations f_i(y), uniform along x, move by f_i(y + c_iy) <- f_i(y) + Delta_i(f(y)) in a step, with the mean
collision Delta of `lattice_models`. Sound of a finite amplitude steepens where sound is faster in denser gas, that is
where the factor g(d) of the advection is not 0, and loses energy to waves of half its length.

Literature: U. Frisch et al., Complex Systems 1, 649 (1987) (Boltzmann equation); L. D. Landau and E. M. Lifshitz, Fluid
Mechanics, section 101 (simple waves).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from crosscheck.references.lattice_models import VELOCITIES, fermi_dirac, mean_collision


def sound_wave(
    model: str, density: float, amplitude: float, rows: int, times: NDArray[np.int64]
) -> NDArray[np.float64]:
    """2/rows sum_y rho(y) cos(k y) at the steps `times`, of a wave d (1 + amplitude cos(k y)) at rest at first.

    k = 2 pi over the height of the rows. model: a name of `MODELS`, else KeyError. density: d, mean occupation.
    amplitude: relative to d, so that occupations stay below 1. rows: of one wavelength, periodic. times: ascending from
    0, steps; (samples,). Returns particles per site, (samples,).
    """
    velocities = VELOCITIES[model]
    phase = 2 * math.pi * np.arange(rows) / rows
    f = fermi_dirac(model, density * (1 + amplitude * np.cos(phase)), np.zeros((rows, 2)))
    found, step = [], 0
    for time in times.tolist():
        while step < time:
            f = f + mean_collision(model, f)
            f = np.stack([np.roll(f[:, i], up) for i, (_, up) in enumerate(velocities.integers)], axis=1)
            step += 1
        found.append(2 / rows * float(f.sum(axis=1) @ np.cos(phase)))
    return np.array(found)
