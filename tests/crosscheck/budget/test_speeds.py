"""How fast an engine is: power laws between and beyond what was measured, and trials that every engine runs."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.budget import speeds
from crosscheck.budget.loads import Load
from crosscheck.budget.speeds import Speed
from crosscheck.engines.capabilities import refusal, schemes_for
from crosscheck.engines.registry import engine_class, shipped_engines
from crosscheck.engines.soft_spheres import resolved
from crosscheck.errors import EngineError
from crosscheck.scene import Method

METHOD = Method(scheme="x", dt=1e-4)
EXAMPLE = Path(__file__).parents[3] / "examples" / "my_engine.py"


def load(size: int, runs: int = 0, units: int = 1) -> Load:
    return Load("gravity", "stepping", size, 1, runs, units)


@given(st.floats(0, 3), st.floats(0, 3), st.integers(1, 10**6))
def test_power_laws_are_kept_between_the_sizes_and_beyond(power: float, of_calls: float, size: int) -> None:
    sizes = (2, 16, 128)
    speed = Speed(sizes, tuple(n**of_calls for n in sizes), tuple(1e-6 * n**power for n in sizes))
    n = max(size, 2)  # below the smallest, nothing is known to be quicker
    assert speed.of(load(size, 0, 10)) == pytest.approx(1e-5 * n**power)
    assert speed.of(load(size, 3, 0)) == pytest.approx(3 * n**of_calls)


@pytest.mark.parametrize(("last", "power"), [(0.5, 0.0), (8.0**5, 3.0)])
def test_noise_is_no_power_law(last: float, power: float) -> None:
    speed = Speed((2, 16), (1.0, 1.0), (1.0, last))
    assert speed.of(load(160)) == pytest.approx(last * 10**power)


def test_one_size_is_all_that_is_known() -> None:
    assert Speed((16,), (2.0,), (1.0,)).of(load(1000, 1, 5)) == 7.0


@pytest.mark.parametrize(
    ("engine", "interaction", "kind"),
    sorted(
        {(name, one.interaction, one.kind) for name in shipped_engines() for one in engine_class(name).capabilities}
    ),
)
def test_every_capability_of_the_shipped_engines_has_a_trial(engine: str, interaction: str, kind: str) -> None:
    cls = engine_class(engine)
    (scheme, *_) = schemes_for(cls, interaction, kind)
    trials = [make(speeds.SIZES[interaction][0], 3) for make in speeds._makers(interaction, kind, scheme)]
    accepted = [one for one in trials if refusal(cls, one.scene, resolved(one.scene, one.method)) is None]
    assert accepted
    assert all(one.units >= 3 for one in accepted)


class _Clock:
    """Stands for a worker, and for how long its runs take: an engine whose costs are power laws."""

    def __init__(self, call: float, unit: float, power: float, most: int = 10**9) -> None:
        self.call, self.unit, self.power, self.most = call, unit, power, most
        self.spent = 0.0
        self.sizes: list[int] = []

    def supports(self, scene: object, method: object) -> str | None:
        return None if scene.number <= self.most else "too many"  # type: ignore[attr-defined]

    def wall(self, worker: object, trial: speeds.Trial) -> tuple[float, float]:
        size = trial.scene.number
        self.sizes.append(size)
        units = trial.units if trial.scene.duration else 0
        took = self.call * size + self.unit * size**self.power * units
        self.spent += took
        return took, trial.units


@pytest.mark.parametrize("power", [0.0, 1.0, 2.0])
def test_what_a_unit_takes_is_found(monkeypatch: pytest.MonkeyPatch, power: float) -> None:
    clock = _Clock(1e-5, 3e-6, power)
    monkeypatch.setattr(speeds, "_wall", clock.wall)
    speed = speeds._timed(clock, speeds._bodies(METHOD, 3), (2, 16, 128))  # type: ignore[arg-type]
    assert speed is not None
    assert speed.sizes == (2, 16, 128)
    for size in (2, 16, 128, 1000):
        assert speed.of(load(size, 2, 50)) == pytest.approx(2e-5 * size + 50 * 3e-6 * size**power, rel=1e-6)
    assert clock.spent < 2.0


def test_what_would_take_too_long_is_not_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = _Clock(0.0, 1e-2, 2.0)
    monkeypatch.setattr(speeds, "_wall", clock.wall)
    speed = speeds._timed(clock, speeds._bodies(METHOD, 3), (2, 16, 128))  # type: ignore[arg-type]
    assert speed is not None
    assert speed.sizes == (2,)
    assert speed.units == (pytest.approx(0.04),)


def test_what_an_engine_refuses_is_not_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = _Clock(0.0, 1e-6, 1.0, most=20)
    monkeypatch.setattr(speeds, "_wall", clock.wall)
    speed = speeds._timed(clock, speeds._bodies(METHOD, 3), (2, 16, 128))  # type: ignore[arg-type]
    assert speed is not None
    assert speed.sizes == (2, 16)
    assert max(clock.sizes) == 16
    nothing = _Clock(0.0, 1e-6, 1.0, most=1)
    assert speeds._timed(nothing, speeds._bodies(METHOD, 3), (2, 16, 128)) is None  # type: ignore[arg-type]


def test_a_real_engine_is_timed() -> None:
    speed = speeds.measured(f"{EXAMPLE}:MyEngine", "gravity", "stepping", 60.0)
    assert speed is not None
    assert speed.sizes[:2] == (2, 16)
    assert all(0 < seconds < 1 for seconds in (*speed.calls, *speed.units))


def test_no_scheme_and_no_answer_give_no_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    assert speeds.measured(f"{EXAMPLE}:MyEngine", "lattice_gas", "lattice", 60.0) is None

    def fail(*arguments: object) -> None:
        raise EngineError("it fails")

    monkeypatch.setattr(speeds, "_accepted", fail)
    assert speeds.measured("refimpl", "gravity", "stepping", 60.0) is None
