"""What is known of a trajectory before its frames are looked at: from the file, the scene, and what the user says."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hard_disks import disks
from inspected import flying

from crosscheck.errors import UsageError
from crosscheck.inspect.setting import Options, box_of, setting_of
from crosscheck.scene import (
    Box,
    Cylinder,
    Explicit,
    Face,
    GrainFriction,
    HardSpheres,
    Lattice,
    LennardJones,
    Method,
    Scene,
    Spring,
)
from crosscheck.scene.parts import Contact
from crosscheck.trajectories.frames import Box as FileBox
from crosscheck.trajectories.frames import Units

LATTICE = Lattice(kind="lattice", structure="fcc", number=32, temperature=1.0, seed=1)
FLUID = Scene(
    name="fluid",
    dimension=3,
    duration=1.0,
    lennard_jones=LennardJones(cutoff=1.5),
    box=Box(density=0.5),
    initial=LATTICE,
)


def of_scene(scene: Scene, **options: Any) -> Any:
    return setting_of(flying(number=scene.number, frames=4), scene, Options(**options))


def hard(**changes: Any) -> Scene:
    return disks(**({"box": Box(lengths=(6.0, 5.0))} | changes))


OSCILLATOR = Scene(name="s", dimension=1, duration=1.0, spring=Spring(k=1.0), initial=Explicit(positions=((1.0,),)))
THERMAL = Box(lengths=(6.0, 5.0), boundaries=("hard", "periodic"), faces={"x-": Face(temperature=1.5)})


@pytest.mark.parametrize(
    ("scene", "ensemble"),
    [
        (FLUID, "nve"),
        (FLUID.changed(box=None, initial=Explicit(positions=((0.0, 0.0, 0.0), (1.2, 0.0, 0.0)))), "none"),
        (hard(), "nve"),
        (hard(hard_spheres=HardSpheres(restitution=0.9)), "none"),
        (hard(hard_spheres=HardSpheres(diameter=0.0)), "none"),
        (hard(acceleration=(0.0, -1.0), box=Box(lengths=(6.0, 5.0), boundaries=("periodic", "hard"))), "none"),
        (hard(box=THERMAL, seed=1), "nvt"),
        (hard(box=THERMAL.model_copy(update={"faces": {"x-": Face(velocity=1.0)}})), "none"),
        (hard(box=Box(lengths=(6.0, 5.0), boundaries=("open", "periodic"))), "none"),
        (hard(box=Box(lengths=(9.0, 9.0), boundaries=("open", "open"), cylinder=Cylinder(radius=4.4)),
              initial=Explicit(positions=((4.0, 4.0), (6.0, 6.0)))), "nve"),
        (OSCILLATOR, "none"),
    ],
)  # fmt: skip
def test_the_ensemble_that_the_words_of_a_scene_make(scene: Scene, ensemble: str) -> None:
    assert of_scene(scene).ensemble == ensemble
    assert of_scene(scene, ensemble="equilibrium").ensemble == "equilibrium"


def test_the_temperature_is_that_of_thermal_walls_or_of_the_user() -> None:
    walls = hard(box=THERMAL, seed=1)
    assert of_scene(walls).temperature == 1.5
    assert of_scene(walls, temperature="2.5").temperature == 2.5
    assert of_scene(walls, ensemble="nve").temperature is None
    assert of_scene(hard()).temperature is None
    metal = replace(flying(), units=Units("Angstrom", "ps", "Angstrom/ps"))
    assert setting_of(metal, None, Options(temperature="300 K")).temperature == pytest.approx(249.43, rel=1e-4)


def test_the_scene_says_along_which_axes_a_box_is_periodic_where_the_file_does_not() -> None:
    scene = hard(box=Box(lengths=(6.0, 5.0), boundaries=("hard", "periodic")))
    unstated = FileBox(np.diag([6.0, 5.0, 0.0]), np.zeros(3), np.array([True, True, False]), stated=False)
    source = flying(number=scene.number, box=unstated, velocities=None)
    setting = setting_of(source, scene, Options())
    for frame in (setting.first, setting.boxed(source.read(1))):
        assert frame.box is not None
        assert frame.box.periodic.tolist() == [False, True, False]
    alone = setting_of(source, None, Options()).boxed(source.read(1)).box
    assert alone is not None
    assert alone.periodic.tolist() == [True, True, False]


def test_steps_from_the_first_frame() -> None:
    counted = setting_of(flying(steps=50 + 10 * np.arange(60)), None, Options())
    assert [counted.steps_to(index) for index in (0, 1, 7)] == [1, 10, 70]
    for source in (flying(), flying(steps=np.zeros(60, dtype=np.int64))):
        assert setting_of(source, None, Options()).steps_to(7) == 7000


def test_a_scene_without_a_box_has_none() -> None:
    assert box_of(OSCILLATOR) is None
    assert setting_of(flying(number=1, box=None), OSCILLATOR, Options()).box is None


def test_kelvin_needs_masses() -> None:
    source = replace(flying(masses=None), units=Units("nm", "ps", "nm/ps"))
    with pytest.raises(UsageError, match="states no masses: give --mass TYPE=MASS"):
        setting_of(source, None, Options(temperature="300K"))
    given = setting_of(source, None, Options(temperature="300K", masses={"all": 18.0}))
    assert given.temperature == pytest.approx(2.4943, rel=1e-4)


@pytest.mark.parametrize("text", ["0", "-1", "1.2.3", "hot", "300 C", "nan", "inf", "K", ""])
def test_temperatures_that_are_none(text: str) -> None:
    with pytest.raises(UsageError, match="give a number above 0"):
        setting_of(flying(), None, Options(temperature=text))


def test_what_is_conserved_follows_from_the_scene() -> None:
    found = of_scene(hard(box=Box(lengths=(6.0, 5.0), boundaries=("hard", "periodic")))).conserved
    assert [bool(reason) for reason in found.momentum] == [True, False, False]
    assert (found.kinetic_energy, found.energy) == ("", "")
    assert "[box.boundaries=hard]" in found.angular_momentum
    soft = hard(method=Method(scheme="velocity_verlet", dt=0.01, contact=Contact(stiffness=1e4)))
    assert "potential" in of_scene(soft).conserved.kinetic_energy
    assert "soft contacts" in of_scene(soft).conserved.energy
    rough = hard(box=None, hard_spheres=HardSpheres(friction=GrainFriction(tangential_restitution=0.5)))
    assert "spins" in of_scene(rough).conserved.angular_momentum
    falling = hard(acceleration=(0.0, -1.0))
    assert [bool(reason) for reason in of_scene(falling).conserved.momentum] == [False, True, False]
    assert "potential" in of_scene(FLUID).conserved.kinetic_energy
    assert of_scene(FLUID).conserved.energy == ""
    damped = Scene(
        name="s", dimension=1, duration=1.0, spring=Spring(k=1.0, gamma=0.1), initial=Explicit(positions=((1.0,),))
    )
    assert "spring.gamma" in of_scene(damped).conserved.energy


def test_without_a_scene_the_user_says_that_it_is_closed() -> None:
    assert all(setting_of(flying(), None, Options()).conserved.momentum)
    assert not any(setting_of(flying(), None, Options(ensemble="nve")).conserved.momentum)
    walled = FileBox(np.diag([5.0] * 3), np.zeros(3), np.array([True, False, True]))
    found = setting_of(flying(box=walled), None, Options(ensemble="nve")).conserved
    assert [bool(reason) for reason in found.momentum] == [False, True, False]
    assert setting_of(flying(box=None), None, Options(ensemble="nve")).conserved.angular_momentum == ""


def test_masses_of_the_file_of_the_scene_and_of_the_user() -> None:
    types = np.array([1, 2] * 10)
    assert setting_of(flying(masses=None), None, Options()).masses.tolist() == [1.0] * 20
    assert setting_of(flying(masses=None, types=types), None, Options()).masses is None
    given = setting_of(flying(masses=None, types=types), None, Options(masses={"1": 2.0, "2": 3.0}))
    assert given.masses.tolist() == [2.0, 3.0] * 10
    heavy = hard(masses=(1.0, 2.0, 4.0))
    assert of_scene(heavy).masses.tolist() == [1.0, 2.0, 4.0]
    for masses in ({"1": 2.0}, {"1": 2.0, "2": 1.0, "3": 1.0}):
        with pytest.raises(UsageError, match="has the types 1, 2: give one for each"):
            setting_of(flying(types=types), None, Options(masses=masses))
    assert setting_of(flying(masses=None), None, Options(masses={"all": 3.0})).masses.tolist() == [3.0] * 20


def test_particles_at_rest_are_left_out() -> None:
    source = flying()
    v = np.array(source.velocities)
    v[:, 3:5] = 0.0
    x = np.array(source.positions)
    x[:, 3:5] = x[0, 3:5]
    setting = setting_of(flying(positions=x, velocities=v), None, Options())
    assert setting.number == 18
    assert "2 particles are at rest" in setting.remarks[0]
    scene = hard(species=(0, 1, 1), hard_spheres=HardSpheres(fixed=(0,)),
                 initial=Explicit(positions=((1.0, 1.0), (3.0, 3.0), (5.0, 1.5))))  # fmt: skip
    assert of_scene(scene).moving.tolist() == [False, True, True]


def test_axes_and_degrees_of_freedom() -> None:
    source = flying()
    x, v = np.array(source.positions), np.array(source.velocities)
    x[..., 2], v[..., 2] = 0.3, 0.0
    plane = setting_of(flying(positions=x, velocities=v), None, Options(constraints=3))
    assert plane.axes == (0, 1)
    assert plane.freedoms == 2 * 19 - 3
    assert setting_of(flying(), None, Options()).freedoms == 3 * 19


def test_clocks() -> None:
    assert setting_of(flying(), None, Options()).clock.same_unit
    steps = np.arange(60) * 10
    unknown = flying(times=np.full(60, np.nan), steps=steps)
    assert setting_of(unknown, None, Options()).clock[1:] == ("step", False)
    scene = FLUID.changed(method=Method(scheme="velocity_verlet", dt=0.005))
    of_steps = setting_of(flying(number=32, times=np.full(60, np.nan), steps=steps), scene, Options())
    assert of_steps.clock[1:] == ("time", True)
    np.testing.assert_allclose(of_steps.clock.values, 0.05 * np.arange(60))
    nothing = setting_of(flying(times=np.full(60, np.nan)), None, Options())
    assert nothing.clock[1:] == ("frame", False)
    for units, same in (
        (Units("nm", "ps", "nm/ps"), True),
        (Units("nm", "fs", "nm/ps"), False),
        (Units("nm", "step", "nm/ps"), False),
        (Units(), True),
    ):
        assert setting_of(replace(flying(), units=units), None, Options()).clock.same_unit == same


def test_hard_particles_need_diameters() -> None:
    with pytest.raises(UsageError, match="states no diameters"):
        setting_of(flying(), None, Options(hard=True))
    assert of_scene(hard()).hard
    soft = hard(method=Method(scheme="velocity_verlet", dt=0.01, contact=Contact(stiffness=1e4)))
    assert not of_scene(soft).hard


def test_a_scene_of_other_particles_is_refused() -> None:
    with pytest.raises(UsageError, match="it has 20 particles, and scene fluid has 32"):
        setting_of(flying(), FLUID, Options())


def test_the_box_of_the_scene_stands_in_for_one_that_the_file_does_not_state() -> None:
    found = setting_of(flying(number=32, box=None), FLUID, Options()).first.box
    np.testing.assert_allclose(np.diag(found.vectors), FLUID.lengths())
    assert found.periodic.all()
