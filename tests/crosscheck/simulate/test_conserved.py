"""What the parts of a scene imply: a word that nobody has looked at is a reason why a quantity may change."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.scene import (
    Box,
    Contact,
    Cylinder,
    Explicit,
    Face,
    Friction,
    GrainFriction,
    Gravity,
    HardSpheres,
    LennardJones,
    Method,
    Oscillation,
    Scene,
    Spring,
    Wall,
    Well,
)
from crosscheck.simulate import conserved
from crosscheck.simulate.conserved import changes_momentum, energy, has_potential, turns

EVENTS, STEPS = Method(scheme="event_driven"), Method(scheme="velocity_verlet", dt=0.1)


def soft(**entries):
    return STEPS.model_copy(update={"contact": Contact(**entries)})


ROUGH = Friction(tangential_restitution=0.5)


def scene(**entries):
    return Scene(
        **({"name": "s", "dimension": 2, "duration": 1.0, "initial": Explicit(positions=((3.0, 3.0),))} | entries)
    )


def hard(boundaries=("periodic", "periodic"), faces=None, cylinder=None, spheres=None, **entries):
    box = Box(lengths=(6.0, 6.0), boundaries=boundaries, faces=faces, cylinder=cylinder)
    return scene(hard_spheres=spheres or HardSpheres(), box=box, **entries)


GRAINS = HardSpheres(friction=GrainFriction(tangential_restitution=0.5))
HALF = ("hard", "periodic")
FIXED = hard(spheres=HardSpheres(fixed=(0,)), species=(0, 1), initial=Explicit(positions=((1.0, 1.0), (3.0, 3.0))))


@pytest.mark.parametrize(
    ("one", "method", "expected"),
    [
        (scene(spring=Spring(k=1.0)), STEPS, "kept"),
        (scene(spring=Spring(k=1.0, gamma=0.1)), STEPS, "lost"),
        (scene(gravity=Gravity(softening=0.1)), STEPS, "kept"),
        (scene(lennard_jones=LennardJones(cutoff=2.0)), STEPS, "kept"),
        (hard(acceleration=(0.0, -1.0)), EVENTS, "kept"),
        (hard(spheres=HardSpheres(well=Well(depth=1.0, range=1.5))), EVENTS, "kept"),
        (hard(spheres=HardSpheres(restitution=0.9, contact_duration=0.1)), EVENTS, "lost"),
        (hard(spheres=GRAINS), EVENTS, "lost"),
        (hard(HALF, {"x-": Face(restitution=0.5)}), EVENTS, "lost"),
        (hard(HALF, {"x-": Face(velocity=0.5)}), EVENTS, "changed"),
        (hard(HALF, {"x-": Face(temperature=0.5)}, seed=1), EVENTS, "changed"),
        (hard(HALF, {"x-": Face(oscillation=Oscillation(amplitude=0.1, frequency=1.0))}), EVENTS, "changed"),
        (hard(), soft(stiffness=10.0), "kept"),
        (hard(), soft(k_n=10.0), "kept"),
        (hard(), soft(k_n=10.0, gamma_n=0.0), "kept"),
        (hard(), soft(k_n=10.0, gamma_n=1.0), "lost"),
        (hard(), soft(law="hertz", E=10.0, nu=0.3, gamma_n=1.0), "lost"),
        (hard(HALF, {"x-": Face(velocity=0.5)}), soft(k_n=10.0, gamma_n=1.0), "changed"),
        (hard(spheres=GRAINS), soft(k_n=10.0, gamma_n=0.0, gamma_t=1.0, mu=0.5, friction="dashpot"), "lost"),
        # a spring along the contact gives back what it has taken up
        (hard(spheres=GRAINS), soft(k_n=10.0, gamma_n=1.0, k_t=3.0), "changed"),
        (hard(spheres=GRAINS), soft(stiffness=10.0), "changed"),
        (hard(spheres=GRAINS), soft(stiffness=10.0, friction="dashpot"), "lost"),
        (hard(spheres=GRAINS), soft(k_n=10.0, gamma_n=0.0, k_t=3.0, gamma_t=1.0, mu=0.0), "kept"),
        (hard(spheres=GRAINS), soft(k_n=10.0, gamma_n=2.0, k_t=3.0, mu=0.0), "lost"),
    ],
)
def test_energy(one, method, expected):
    assert energy(one, method) == expected


def test_a_new_word_is_a_reason_for_everything(monkeypatch):
    monkeypatch.setattr(conserved, "words", lambda *_: frozenset({"dimension=2", "new.word"}))
    one = scene(gravity=Gravity())
    assert energy(one, STEPS) == "changed"
    assert changes_momentum(one, STEPS, 0) == "new.word"
    assert turns(one, STEPS) == "new.word"


@pytest.mark.parametrize(
    ("one", "expected"),
    [
        (scene(spring=Spring(k=1.0)), ("spring", "spring")),
        (scene(gravity=Gravity()), (None, None)),
        (hard(acceleration=(0.0, -1.0)), (None, None)),
        (hard(HALF), ("box.boundaries=hard", None)),
        (hard(HALF, {"x-": Face(friction=ROUGH)}, spheres=GRAINS), ("box.boundaries=hard", "box.faces.friction")),
        (hard(HALF, {"x-": Face(temperature=1.0)}, seed=1), ("box.boundaries=hard", "box.faces.temperature")),
        (FIXED, ("hard_spheres.fixed",) * 2),
        (hard(("open", "open"), cylinder=Cylinder(radius=3.0)), ("box.cylinder",) * 2),
    ],
)
def test_momentum_along_each_axis(one, expected):
    assert tuple(changes_momentum(one, EVENTS, axis) for axis in range(2)) == expected


def test_momentum_given_to_walls_may_be_known():
    one = hard(HALF, {"x-": Face(friction=ROUGH)}, spheres=GRAINS)
    assert all(changes_momentum(one, EVENTS, axis, walls_known=True) is None for axis in range(2))
    walled = scene(
        lennard_jones=LennardJones(cutoff=2.0),
        box=Box(lengths=(6.0, 6.0), boundaries=("wall", "periodic"), wall=Wall(cutoff=2.0)),
    )
    assert changes_momentum(walled, STEPS, 0, walls_known=True) == "box.boundaries=wall"
    assert changes_momentum(walled, STEPS, 1) is None


def test_what_turns():
    origin, kept = turns(scene(spring=Spring(k=1.0)), STEPS)
    assert (origin.tolist(), kept.tolist()) == ([0, 0, 0], [0, 0, 1])
    middle, kept = turns(hard(("open", "open"), cylinder=Cylinder(radius=3.0)), EVENTS)
    assert (middle.tolist(), kept.tolist()) == ([3, 3, 0], [0, 0, 1])
    assert turns(hard(), EVENTS) == "box.boundaries=periodic"
    assert turns(scene(spring=Spring(k=1.0, gamma=1.0)), STEPS) == "spring.gamma"
    assert turns(hard(("open", "open"), spheres=GRAINS, cylinder=Cylinder(radius=3.0, friction=ROUGH)), EVENTS) == (
        "box.cylinder.friction"
    )
    line = Scene(name="s", dimension=1, duration=1.0, spring=Spring(k=1.0), initial=Explicit(positions=((1.0,),)))
    assert turns(line, STEPS) == "dimension=1"
    space = Scene(
        name="s",
        dimension=3,
        duration=1.0,
        hard_spheres=HardSpheres(),
        box=Box(
            lengths=(6.0, 6.0, 9.0), boundaries=("open", "open", "periodic"), cylinder=Cylinder(radius=3.0, axis="z")
        ),
        initial=Explicit(positions=((3.0, 3.0, 1.0),)),
    )
    middle, kept = turns(space, EVENTS)
    assert np.array_equal(middle, [3, 3, 4.5])
    assert kept.tolist() == [0, 0, 1]
    for side in ("z-", "z+"):
        floor = space.changed(
            hard_spheres=GRAINS,
            box=Box(
                lengths=(6.0, 6.0, 9.0),
                boundaries=("open", "open", "hard"),
                cylinder=Cylinder(radius=3.0, axis="z"),
                faces={side: Face(friction=ROUGH)},
            ),
        )
        assert turns(floor, EVENTS) == "box.faces"


def test_what_has_a_potential():
    assert has_potential(scene(gravity=Gravity()), STEPS)
    assert not has_potential(hard(), EVENTS)
    assert has_potential(hard(acceleration=(0.0, 1.0)), EVENTS)
    assert has_potential(hard(), STEPS.model_copy(update={"contact": Contact(stiffness=1.0)}))


def test_what_takes_energy_up():
    rough = hard(("hard", "periodic"), {"x-": Face(restitution=0.9)})
    warm = hard(("hard", "periodic"), {"x-": Face(temperature=1.0)}, seed=0)
    assert [conserved.dissipates(one, EVENTS) for one in (rough, warm)] == [True, False]
    assert conserved.dissipates(hard(spheres=HardSpheres(restitution=0.9)), EVENTS)
    assert not conserved.dissipates(hard(), EVENTS)
    assert [conserved.dissipates(hard(), soft(k_n=10.0, gamma_n=rate)) for rate in (1.0, 0.0)] == [True, False]
