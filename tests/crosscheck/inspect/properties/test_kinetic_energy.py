"""The width and the distribution of the total kinetic energy, canonical and at constant energy."""

from __future__ import annotations

import numpy as np
import pytest
from inspected import flying, judged, said

NAME = "total kinetic energy"


def drawn(seed: int, frames: int = 200, width: float = 1.0, scale: float = 1.0) -> object:
    """Velocities whose kinetic energy has Gamma's law, with this width and scale."""
    rng = np.random.default_rng(seed)
    v = rng.normal(size=(frames, 20, 3)) * scale
    v -= v.mean(axis=1, keepdims=True)
    energy = (v**2).sum(axis=(1, 2))
    wanted = energy.mean() + width * (energy - energy.mean())
    return flying(frames=frames, velocities=v * np.sqrt(wanted / energy)[:, None, None])


@pytest.mark.parametrize("seed", range(6))
def test_canonical_energies_have_their_width_and_law(seed: int) -> None:
    found = judged(drawn(seed), NAME, ensemble="nvt", temperature="1.0")
    assert [one.outcome for one in found] == ["pass", "pass"]
    assert found[0].measured == pytest.approx(0, abs=4 * found[0].uncertainty)
    assert found[0].uncertainty == pytest.approx(1 / (2 * 160) ** 0.5, rel=0.5)


@pytest.mark.parametrize("width", [0.3, 1.8])
def test_another_width_is_red(width: float) -> None:
    """Thermostats that scale velocities make it too narrow."""
    width_of, law = judged(drawn(1, 500, width), NAME, ensemble="nvt", temperature="1.0")
    assert width_of.outcome == "fail"
    assert width_of.measured == pytest.approx(np.log(width), abs=0.2)
    assert law.outcome == "fail"


def test_another_temperature_is_red_in_the_law_alone() -> None:
    width, law = judged(drawn(1, scale=1.1), NAME, ensemble="nvt", temperature="1.0")
    assert (width.outcome, law.outcome) == ("pass", "fail")
    (width,) = judged(drawn(1, scale=1.1), NAME, ensemble="nvt")
    assert width.outcome == "pass"
    assert "needs a temperature" in said(drawn(1), NAME, ensemble="nvt")


@pytest.mark.parametrize(("width", "outcome"), [(0.5, "pass"), (1.0, "pass"), (2.0, "fail")])
def test_elsewhere_it_is_no_wider_than_canonical(width: float, outcome: str) -> None:
    for ensemble in ("equilibrium", "nve"):
        (one,) = judged(drawn(1, width=width), NAME, ensemble=ensemble)
        assert one.outcome == outcome
        assert one.false_alarm is not None


def test_a_constant_energy_has_no_width_and_is_not_canonical() -> None:
    (one,) = judged(flying(), NAME, ensemble="nvt")
    assert one.outcome == "fail"
    assert judged(flying(), NAME) == ()
    assert "is constant" in said(flying(), NAME)


def test_constraints_count() -> None:
    """As if 20 of 57 degrees of freedom were constrained: the width would be too large by (57/37)^(1/2)."""
    found = judged(drawn(1, 2000), NAME, ensemble="nvt", constraints=20)[0]
    assert found.measured == pytest.approx(0.5 * np.log(37 / 57), abs=0.06)
    assert found.outcome == "fail"


def test_few_frames_are_not_enough() -> None:
    assert "independent of each other" in said(drawn(1, 15), NAME, ensemble="nvt")
    assert judged(drawn(1, 12), NAME)[0].outcome in ("pass", "inconclusive")
