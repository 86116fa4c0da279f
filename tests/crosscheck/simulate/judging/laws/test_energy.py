"""The energy of runs to a tolerance: it falls with the tolerance, or is red."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from judged import verdicts

from crosscheck.engines.workers.pool import Pool
from crosscheck.scene import Gravity, Kepler, Output, Scene, Spring, explicit

ORBIT = Scene(
    name="orbit",
    dimension=2,
    duration=8.0,
    gravity=Gravity(),
    masses=(1.0, 0.5),
    initial=Kepler(kind="kepler", eccentricity=0.5),
    output=Output(interval=0.5, observables=("kinetic_energy", "potential_energy")),
)
DAMPED = Scene(
    name="damped",
    dimension=2,
    duration=8.0,
    spring=Spring(k=2.0, gamma=0.2),
    initial=explicit(np.array([[1.0, 0.3]]), np.array([[0.0, 0.2]])),
    output=Output(interval=0.5, observables=("kinetic_energy", "potential_energy")),
)


@pytest.fixture(scope="module")
def pool() -> Iterator[Pool]:
    workers = Pool()
    yield workers
    workers.close()


@pytest.mark.parametrize("scheme", ["RK45", "DOP853", "Radau", "LSODA"])
@pytest.mark.parametrize("scene", [ORBIT, DAMPED], ids=lambda scene: scene.name)
def test_it_falls_with_the_tolerance(pool: Pool, scene: Scene, scheme: str) -> None:
    found = verdicts(pool, scene, ("scipy",), [f"scheme={scheme},tolerance=1e-7"])
    assert found["energy"].outcome == "pass"
    assert "ten times the tolerance" in found["energy"].findings.shown.quantity  # type: ignore[union-attr]
    for law in ("audit", "momentum", "time-step"):
        assert found[law].outcome == "skip"


def test_an_energy_that_does_not_follow_the_tolerance_is_red(pool: Pool, monkeypatch: pytest.MonkeyPatch) -> None:
    """The energies that the law reads drift by 1e-4 whatever the tolerance."""
    from crosscheck.simulate.judging.laws import energy

    monkeypatch.setattr(
        energy, "energy_of", lambda run: run["kinetic_energy"] + run["potential_energy"] + 1e-4 * run["time"]
    )
    found = verdicts(pool, ORBIT, ("scipy",), ["scheme=DOP853,tolerance=1e-9"])
    assert found["energy"].outcome == "fail"
