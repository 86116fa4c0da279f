"""Closed forms and published values, each with its source."""

import numpy as np

#: Rounding unit of float64: the distance from 1 to the next number.
EPSILON = float(np.finfo(np.float64).eps)
