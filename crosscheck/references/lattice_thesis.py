"""What a thesis of 1991 reports of sound in lattice gases, and the modes of its starting state.

M. Pliego Diaz, Simulaciones hidrodinamicas bidimensionales usando modelos discretos, thesis, UNAM (1991), sec. 4.3.
Units: links and steps; of its viscosities, see docs/lattice.md.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

#: Experiment 1 (HPP): period and sound speed. Experiment 2 (FHP with all collisions of 2, 3 and 4 particles): the same.
HPP = (412.9, 0.7387)
FHP = (787.4, 0.7493)
#: Table 4.1: nu at the crest and at the trough, by density.
VISCOSITY = {
    0.1: (140.98, 140.98),
    0.2: (87.03, 88.77),
    0.3: (62.66, 57.44),
    0.4: (48.73, 48.73),
    0.5: (38.29, 36.55),
    0.6: (45.25, 43.51),
}


def half_sine_modes(number: int) -> NDArray[np.float64]:
    """b_n, n = 1 ... number, of sin(2 pi x/L) = sum b_n cos(n pi x/L) on 0 ... L: 8/(pi (4 - n^2)), 0 for even n.

    number: how many, 1 or more. Gives (number,). By derivation: Fourier's integrals.
    """
    n = np.arange(1, number + 1, dtype=np.float64)
    odd = n % 2 == 1
    return np.where(odd, 8 / (math.pi * np.where(odd, 4 - n**2, 1.0)), 0.0)
