"""States as arrays by name, and back."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from refimpl.snapshot import restore, snapshot


class Record(NamedTuple):
    rows: Any
    shared: Any
    absent: Any = None


def state(fill: float = 0.0) -> dict[str, Any]:
    rows = np.full((3, 2), fill)
    return {"record": Record(rows, rows), "time": fill, "count": int(fill), "ended": bool(fill), "why": "x" * int(fill),
            "pair": (np.full(2, fill, np.int32), np.float64(fill))}  # fmt: skip


def test_a_snapshot_is_restored_in_place_with_what_is_shared() -> None:
    arrays, like = snapshot(state(2.0)), state()
    assert set(arrays) == {"record.rows", "time", "count", "ended", "why", "pair.0", "pair.1"}
    mine = like["record"].rows
    found = restore(like, arrays)
    assert found["record"].rows is mine
    assert found["record"].shared is mine
    assert (mine == 2.0).all()
    assert (found["time"], found["count"], found["ended"], found["why"]) == (2.0, 2, True, "xx")
    assert (found["pair"][0] == 2).all()
    assert found["pair"][1] == 2.0
    mine[:] = 7.0
    assert (arrays["record.rows"] == 2.0).all()  # a copy


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"time": None}, "array time is missing"),
        ({"more": np.zeros(1)}, "array more has no place"),
        ({"record.rows": np.zeros((3, 2), np.float32)}, "array record.rows has the type float32, not float64"),
        ({"record.rows": np.zeros((4, 2))}, r"array record.rows has the shape \(4, 2\), not \(3, 2\)"),
        ({"pair.0": np.zeros((1, 2), np.int32)}, r"array pair.0 has the shape \(1, 2\), not \(2,\)"),
        ({"pair.0": np.zeros(1, np.int32)}, "pair.0"),
    ],
)
def test_what_does_not_fit_is_named(change: dict[str, Any], message: str) -> None:
    arrays = {name: value for name, value in (snapshot(state()) | change).items() if value is not None}
    with pytest.raises(ValueError, match=message):
        restore(state(), arrays, growing=("pair",))


def test_what_grows_is_made_anew() -> None:
    arrays = snapshot(state()) | {"pair.0": np.arange(5, dtype=np.int32)}
    found = restore(state(), arrays, growing=("pair",))
    assert found["pair"][0].tolist() == [0, 1, 2, 3, 4]
    assert found["pair"][0].ctypes.data % 64 == 0


def test_a_snapshot_holds_numbers_and_texts_only() -> None:
    with pytest.raises(TypeError, match=r"sim\.function is a builtin_function_or_method"):
        snapshot({"sim": {"function": len}})


@given(arrays(np.float64, array_shapes(max_dims=3, max_side=4)))
def test_any_bits_come_back(values: np.ndarray) -> None:
    found = restore({"x": np.zeros_like(values)}, snapshot({"x": values}))
    assert found["x"].tobytes() == values.tobytes()


@given(st.floats(), st.integers(-(2**62), 2**62), st.text(alphabet="abc "))
def test_numbers_and_texts_come_back(number: float, whole: int, text: str) -> None:
    found = restore({"a": 0.0, "b": 0, "c": ""}, snapshot({"a": number, "b": whole, "c": text}))
    assert np.float64(found["a"]).tobytes() == np.float64(number).tobytes()
    assert (found["b"], found["c"]) == (whole, text)
