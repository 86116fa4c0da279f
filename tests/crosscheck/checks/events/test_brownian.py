"""The scene of Brownian motion."""

from __future__ import annotations

import pytest

from crosscheck.checks.events import brownian


@pytest.mark.parametrize("name", list(brownian.BATHS))
def test_tracers_fit_into_the_lattice(name: str) -> None:
    bath = brownian.BATHS[name]
    scene = brownian.brownian(bath, 0, 1.0)
    assert sum(scene.species) == bath.tracers
    assert (bath.sites - bath.tracers) / scene.volume() == pytest.approx(bath.density)
    scene.initial_state()
