"""Potential energy and virial of a force of `refimpl`, each by itself; callable from compiled code too."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba.extending import register_jitable

from refimpl.stepping.forces.generic import energy_and_virial


@register_jitable
def potential_energy(force: Any, r: np.ndarray) -> float:
    """U at the coordinates r, (N*d,)."""
    return energy_and_virial(force, r)[0]  # type: ignore[no-any-return]


@register_jitable
def virial(force: Any, r: np.ndarray) -> float:
    """W at the coordinates r, (N*d,)."""
    return energy_and_virial(force, r)[1]  # type: ignore[no-any-return]
