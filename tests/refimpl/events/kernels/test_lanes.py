"""Eight doubles at once: each operation as numpy has it, to the last bit."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_array_equal

from refimpl.events.kernels.compiled import kernel
from refimpl.events.kernels.lanes import (
    WIDTH,
    bits_of,
    columns,
    elements,
    least,
    lowest_bit,
    splat,
    square_root,
    store,
    where,
)

ROWS, SHIFT, PLACE = 11, 32, 3


@kernel
def play(rows: Any, line: Any, numbers: Any, out: Any) -> Any:
    """All operations, into the rows of `out`; and what gives a number."""
    found = columns(rows, numbers, 3, 0)
    for k in range(8):
        store(out, k, 2, found[k])
    x, y, z = found[0], found[1], columns(rows, numbers, 3, 32)[5]
    store(out, 8, 2, x * y + z)
    store(out, 9, 2, x * y - z / x)
    store(out, 10, 2, where((x < y) & (y <= z), square_root(x * x), splat(2.5)))
    store(out, 11, 2, elements(line, numbers, 3))
    below = bits_of(x < y)
    return below, bits_of(x == z), least(x), lowest_bit(below) if below != 0 else -1


numbers = st.floats(1e-3, 1e3) | st.floats(-1e3, -1e-3)


@settings(max_examples=40, deadline=None)
@given(arrays(np.float64, (ROWS, 8), elements=numbers), st.data())
def test_operations(rows: np.ndarray, data: st.DataObject) -> None:
    one = np.array(data.draw(st.lists(st.integers(0, ROWS - 1), min_size=WIDTH + PLACE, max_size=WIDTH + PLACE)))
    other = np.array(data.draw(st.lists(st.integers(0, ROWS - 1), min_size=WIDTH + PLACE, max_size=WIDTH + PLACE)))
    line, out = np.ascontiguousarray(rows[:, 7]), np.full((12, WIDTH + 4), np.nan)
    below, equal, smallest, lowest = play(rows, line, one | (other << SHIFT), out)
    which, second = one[PLACE:], other[PLACE:]
    x, y, z = rows[which, 0], rows[which, 1], rows[second, 5]
    middle = out[:, 2 : 2 + WIDTH]
    assert_array_equal(middle[:8], rows[which].T)
    assert_array_equal(middle[8], x * y + z)
    assert_array_equal(middle[9], x * y - z / x)
    assert_array_equal(middle[10], np.where((x < y) & (y <= z), np.sqrt(x * x), 2.5))
    assert_array_equal(middle[11], line[which])
    assert np.isnan(out[:, :2]).all()
    assert np.isnan(out[:, 2 + WIDTH :]).all()
    assert below == sum(1 << k for k in range(WIDTH) if x[k] < y[k])
    assert equal == sum(1 << k for k in range(WIDTH) if x[k] == z[k])
    assert smallest == x.min()
    assert lowest == (min(k for k in range(WIDTH) if x[k] < y[k]) if below else -1)
