"""Choice by the class of a record, compiled and plain; instructions and their plain twins; kernels as plain Python."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np
import pytest
from numba import njit
from numba.core.dispatcher import Dispatcher

from refimpl.compilation import dispatched, implements
from refimpl.events import prediction


class Circle(NamedTuple):
    radius: float


class Square(NamedTuple):
    side: float


class Line(NamedTuple):
    length: float


@dispatched()
def area(shape: Any, factor: float) -> float:
    """Area times `factor`."""
    return 0.0


@implements(area, Circle)
def _circle(shape: Circle, factor: float) -> float:
    return factor * np.pi * shape.radius**2


@implements(area, Square)
def _square(shape: Square, factor: float) -> float:
    return factor * shape.side**2


@njit
def area_in_kernel(shape: Any, factor: float) -> float:
    """`area`, chosen while this is compiled."""
    return area(shape, factor)


@pytest.mark.parametrize(
    ("shape", "expected"), [(Circle(2.0), 12 * np.pi), (Square(2.0), 12.0), (Line(2.0), 0.0)], ids=str
)
def test_class_of_the_record_decides(shape: Any, expected: float) -> None:
    assert area(shape, 3.0) == pytest.approx(expected)
    assert area_in_kernel(shape, 3.0) == pytest.approx(expected)


INTERPRETED = """
import warnings
warnings.simplefilter("error")
import numpy as np
from refimpl.compilation import INTERPRETED
from refimpl.events.kernels.memory import prefetch
from refimpl.events.rules import random_uniform
from refimpl.lattice.kernels import words
from refimpl.stepping.kernels import simd

assert INTERPRETED
assert prefetch(np.zeros(3), 0) is None
assert 0 < random_uniform(np.uint64(2**64 - 1), 5, 6, 7) < 1  # silent, although it overflows
x = np.arange(20.0)
assert simd.total(simd.load(x, 3) * simd.load_splat(x, 2)) == 2 * sum(range(3, 11))
simd.store(x, 1, simd.where(simd.lanes() < simd.splat(4.0), simd.zeros(), simd.square_root(simd.splat(9.0))))
assert x[:10].tolist() == [0.0] * 5 + [3.0] * 4 + [9.0]
assert not simd.any_lane(simd.lanes() < simd.zeros())
plane = np.arange(24, dtype=np.uint64)
word = words.load(plane, 2)
plane[:] = 0
assert word.tolist() == list(range(2, 10))  # a value, not a view
assert words.population(words.splat(np.uint64(3))) == 16
assert words.any_bit(words.lanes())
print("interpreted")
"""


def test_kernels_run_as_plain_python_where_numba_compiles_nothing() -> None:
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run([sys.executable, "-c", INTERPRETED], env=environment, capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("interpreted\n", "")


def test_eight_doubles_at_once_are_the_same_in_plain_python() -> None:
    path = Path(__file__).parent / "events" / "kernels" / "test_lanes.py"
    code = f"import runpy; runpy.run_path({str(path)!r})['test_operations']()"
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_modules_as_plain_python_are_beside_the_compiled_ones(plain_module: Any) -> None:
    """Of one simulation, the same bits; each has classes of its own, and imports find the compiled ones as before."""
    plain = plain_module("refimpl.events.prediction")
    assert plain is plain_module("refimpl.events.prediction") is not prediction
    assert sys.modules["refimpl.events.prediction"] is prediction
    assert isinstance(plain.falling_time, FunctionType)
    assert isinstance(prediction.falling_time, Dispatcher)
    assert plain_module("refimpl.compilation").INTERPRETED
    for height, speed in ((1.0, -0.3), (0.2, 1.7)):
        assert plain.falling_time(height, speed, -1.0) == prediction.falling_time(height, speed, -1.0)
