"""Results that the memory cannot hold, and steps that cannot be counted, are refused before an engine starts."""

from __future__ import annotations

from typing import Any

import pytest
from scene_files import DISKS, FLUID, SPRING, changed

from crosscheck.engines.sizes import refuse_large_run
from crosscheck.engines.soft_spheres import resolved
from crosscheck.errors import UsageError
from crosscheck.scene import Contact, Method, Scene

EVENTS = Method(scheme="event_driven")


def scene(table: dict[str, Any], output: dict[str, Any], duration: float = 1.0) -> Scene:
    return Scene.model_validate(table | {"output": output, "duration": duration}, strict=False)


@pytest.fixture(autouse=True)
def memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine of 16 GiB."""
    monkeypatch.setattr("crosscheck.scene.sizes.memory", lambda: 2**34)


@pytest.mark.parametrize(
    ("table", "output", "method", "message"),
    [
        (DISKS, {"interval": 1e-9, "observables": ("collisions",)}, EVENTS, "1000000000 samples of 2 particles need"),
        (DISKS, {"collisions": (1,), "fields": (10**6, 10**4), "trajectory": True}, EVENTS,
         "2 samples and 10000000000 cells of 2 particles need about"),
        (changed(FLUID, "initial.number", 10**5), {"interval": 1e-4, "trajectory": True}, Method(scheme="a", dt=1e-5),
         "10001 samples of 100000 particles need about 89.4 GiB of memory, this machine has 16 GiB"),
        (changed(FLUID, "initial.number", 10**9), {}, Method(scheme="a", dt=0.1), "1000000000 particles need about"),
        (SPRING, {"interval": 1e-90}, EVENTS, "samples of 2 particles need about"),
        (SPRING, {}, Method(scheme="a", dt=1e-99), "too many steps of method.dt = 1e-99 to be counted"),
    ],
)  # fmt: skip
def test_refused_with_the_numbers(table: Any, output: dict[str, Any], method: Method, message: str) -> None:
    with pytest.raises(UsageError, match=message.replace(".", r"\.")):
        refuse_large_run(scene(table, output), method)


@pytest.mark.parametrize("method", [EVENTS, Method(scheme="a", dt=1e-5)])
def test_what_fits_is_run(method: Method) -> None:
    refuse_large_run(scene(DISKS, {"interval": 1e-4, "trajectory": True}), method)
    refuse_large_run(scene(SPRING, {}, 1e9), method)


def test_the_estimate_is_what_the_arrays_take() -> None:
    """Positions and velocities of 1000 particles at 10001 times are 0.48 GB; twice that is asked for."""
    run = scene(changed(FLUID, "initial.number", 1000), {"interval": 1e-4, "trajectory": True})
    with pytest.MonkeyPatch.context() as patch:
        for size, fits in ((1.0e9, True), (0.9e9, False)):
            patch.setattr("crosscheck.scene.sizes.memory", lambda size=size: size)
            if fits:
                refuse_large_run(run, EVENTS)
            else:
                with pytest.raises(UsageError):
                    refuse_large_run(run, EVENTS)


def test_contacts_so_short_that_their_steps_cannot_be_counted() -> None:
    for duration, resolution in ((1e-90, 1e-50), (1e-18, 0.01), (1e-99, 0.5)):
        method = Method(scheme="verlet", contact=Contact(duration=duration, resolution=resolution))
        with pytest.raises(UsageError, match="too many to be counted: take softer contacts"):
            resolved(scene(DISKS, {}), method)
