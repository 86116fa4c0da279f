"""The memory of a start is known before it is made."""

from __future__ import annotations

import math
from typing import Any

import pytest
from scene_files import DISKS, FLUID, changed

from crosscheck.errors import UsageError
from crosscheck.scene import Scene
from crosscheck.scene.sizes import memory, refuse_large, refuse_large_start

LATTICE = {"kind": "lattice", "structure": "square", "number": 10**9, "temperature": 1.0, "seed": 0}


def scene(table: dict[str, Any]) -> Scene:
    return Scene.model_validate(table, strict=False)


def test_the_memory_is_that_of_a_machine() -> None:
    assert 2**28 < memory() < 2**50


def test_what_fits_is_not_refused_and_what_does_not_is_with_its_numbers() -> None:
    refuse_large(memory(), "these", "take less")
    with pytest.raises(UsageError, match=r"these need about .* GiB of memory, this machine has .* GiB: take less"):
        refuse_large(memory() * 1.01, "these", "take less")


def test_more_particles_than_the_memory_holds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("crosscheck.scene.sizes.memory", lambda: 2**34)
    disks = changed(changed(DISKS, "box", {"packing_fraction": 0.3}), "initial", LATTICE)
    with pytest.raises(UsageError, match="1000000000 particles need about 179 GiB of memory, this machine has 16 GiB"):
        scene(disks).initial_state()
    scene(changed(disks, "initial.number", 100)).initial_state()


def test_more_sites_than_the_memory_holds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("crosscheck.scene.sizes.memory", lambda: 2**34)
    gas = {
        "name": "a",
        "dimension": 2,
        "duration": 1.0,
        "lattice_gas": {"model": "fhp1", "columns": 10**5, "rows": 10**4},
        "initial": {"kind": "occupations", "density": 0.3, "seed": 0},
    }
    for start in ("initial_sites", "initial_occupations", "check_start"):
        with pytest.raises(UsageError, match=r"100000 x 10000 sites need about 29\.8 GiB"):
            getattr(scene(gas), start)()
    # mean occupations that differ along x are kept for all sites
    wave = {"of": "density", "amplitude": 0.1, "mode": (1.0, 0.0)}
    small = changed(gas, "lattice_gas", {"model": "fhp1", "columns": 10**4, "rows": 10**4})
    refuse_large_start(scene(small))
    with pytest.raises(UsageError, match="10000 x 10000 sites"):
        refuse_large_start(scene(changed(small, "initial.waves", (wave,))))


@pytest.mark.parametrize(
    "lengths", [(1e-90, 1e90, 1.0), (1e90, 1e90, 1e-90), (1e100, 1e-100, 1e-100), (1e-100,) * 3, (1e100,) * 3]
)
def test_a_lattice_fills_a_box_of_any_shape_with_few_sites(lengths: tuple[float, ...]) -> None:
    """In a flat box, cells of an ideal shape would be beyond all counts."""
    fluid = changed(changed(FLUID, "box.lengths", lengths), "initial.number", 1000)
    state = scene(fluid).initial_state()
    assert state.positions.shape == (1000, 3)
    assert ((state.positions >= 0) & (state.positions < lengths)).all()


def test_more_samples_than_the_memory_holds() -> None:
    disks = changed(changed(DISKS, "output", {"interval": 1e-90}), "duration", 1.0)
    with pytest.raises(UsageError, match=r"output.interval: 1e\+90 samples need about"):
        scene(disks).samples()


def test_a_volume_beyond_all_numbers() -> None:
    disks = changed(changed(DISKS, "box", {"packing_fraction": 1e-100}), "hard_spheres.diameter", 1e100)
    assert math.isfinite(scene(disks).volume())
    dense = changed(changed(DISKS, "box", {"density": 1e-100}), "dimension", 3)
    table = changed(changed(dense, "hard_spheres.diameter", 1e100), "box", {"packing_fraction": 1e-100})
    table = changed(table, "initial", {"kind": "explicit", "positions": ((0.0,) * 3,)})
    with pytest.raises(UsageError, match="box: its volume is beyond all numbers"):
        scene(table).lengths()
