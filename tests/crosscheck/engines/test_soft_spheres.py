"""Hard spheres as soft ones: the laws handed over, the time step, and what is refused."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from hypothesis import given
from hypothesis import strategies as st
from refusals import refused

from crosscheck.engines.lammps import LammpsEngine
from crosscheck.engines.refimpl import RefimplEngine
from crosscheck.engines.soft_spheres import (
    contact_duration,
    contact_stiffness,
    inertia_ratio,
    remarks,
    resolved,
    soft_spheres,
    unsupported,
)
from crosscheck.errors import UsageError
from crosscheck.references.hertz_mindlin import Material, Pressed
from crosscheck.references.soft_impact import HertzImpact
from crosscheck.scene import (
    Box,
    Contact,
    Cylinder,
    Explicit,
    Face,
    Friction,
    GrainFriction,
    HardSpheres,
    Method,
    Oscillation,
    Output,
    RandomPhase,
    Scene,
    Spring,
    Well,
)

ROUGH = GrainFriction(tangential_restitution=0.3, static=0.2, sliding=0.2)
#: Roundings of a handful of operations, relative.
ROUND_OFF = 1e-14


def disks(**changes: Any) -> Scene:
    entries: dict[str, Any] = {
        "name": "disks",
        "dimension": 2,
        "duration": 4.0,
        "hard_spheres": HardSpheres(),
        "initial": Explicit(positions=((2.0, 2.0), (5.0, 2.0)), velocities=((1.0, 0.0), (0.0, 0.0))),
    }
    return Scene(**(entries | changes))


def soft(scheme: str = "velocity_verlet", **contact: Any) -> Method:
    return Method(scheme=scheme, contact=Contact(**({"stiffness": 1e4} | contact)))


def hard(**faces: Face) -> Scene:
    """Rough disks among four walls; x_lower: the face "x-", and so on."""
    names = {name.replace("_lower", "-").replace("_upper", "+"): face for name, face in faces.items()}
    box = Box(lengths=(9.0, 9.0), boundaries=("hard", "hard"), faces=names)
    return disks(seed=0, hard_spheres=HardSpheres(friction=ROUGH), box=box)


# -- the laws ----------------------------------------------------------------------------------------------------------


@given(st.floats(0.05, 1.0), st.floats(-1.0, 1.0), st.floats(0.1, 1.0), st.floats(0.3, 5.0))
def test_a_hooke_contact_gives_the_restitutions(alpha: float, alpha_t: float, inertia: float, mass: float) -> None:
    """Both motions in closed form: in t_c, half a damped oscillation of delta, and u times cos(omega_t t_c)."""
    friction = GrainFriction(tangential_restitution=alpha_t, inertia=inertia)
    scene = disks(masses=mass, hard_spheres=HardSpheres(restitution=alpha, friction=friction))
    law = soft_spheres(scene, Contact(stiffness=200.0)).pair
    reduced = mass / 2
    rate = law.damping * math.sqrt(law.stiffness / reduced) / 2
    frequency = math.sqrt(law.stiffness / reduced - rate**2)
    assert math.exp(-rate * math.pi / frequency) == pytest.approx(alpha, rel=1e-12)
    assert contact_duration(scene, Contact(stiffness=200.0)) == pytest.approx(math.pi / frequency, rel=1e-12)
    tangential = reduced * inertia / (1 + inertia)
    turned = math.sqrt(law.tangential_stiffness / tangential) * math.pi / frequency
    assert math.cos(turned) == pytest.approx(alpha_t, abs=1e-12)
    assert law.tangential_damping == 0
    assert law.friction == (0.0 if alpha_t == 1 else math.inf)


@given(st.floats(0.05, 1.0), st.floats(0.01, 1.0), st.floats(0.1, 1.0))
def test_a_tangential_dashpot_slows_by_alpha_t_in_the_contact_time(alpha: float, alpha_t: float, q: float) -> None:
    friction = GrainFriction(tangential_restitution=alpha_t, static=0.4, sliding=0.4, inertia=q)
    scene = disks(hard_spheres=HardSpheres(restitution=alpha, friction=friction))
    contact = Contact(stiffness=200.0, friction="dashpot")
    law = soft_spheres(scene, contact).pair
    rate = law.tangential_damping * math.sqrt(0.5 * law.stiffness) / (0.5 * q / (1 + q))
    assert math.exp(-rate * contact_duration(scene, contact)) == pytest.approx(alpha_t, rel=1e-12)
    assert law.tangential_stiffness == 0
    assert law.friction == (0.0 if alpha_t == 1 else 0.4)


def test_hertz_damping_is_that_of_a_constant_restitution() -> None:
    log = math.log(0.6)
    scene = disks(hard_spheres=HardSpheres(restitution=0.6))
    law = soft_spheres(scene, Contact(law="hertz", stiffness=200.0)).pair
    assert law == pytest.approx((200.0, math.sqrt(5) * -log / math.hypot(math.pi, log), 0, 0, 0), rel=ROUND_OFF)


def test_walls_have_restitutions_of_their_own_and_one_stiffness() -> None:
    faces = {
        "x_lower": Face(restitution=0.5),
        "x_upper": Face(open=True),
        "y_upper": Face(friction=Friction(tangential_restitution=-1.0)),
    }
    laws = soft_spheres(hard(**faces), Contact(duration=0.01))
    stiffness = math.pi**2 / (2 * 0.01**2)
    assert laws.cylinder is None
    assert laws.faces[1] is None
    assert [law.stiffness for law in (laws.pair, *filter(None, laws.faces))] == pytest.approx([stiffness] * 4)
    assert laws.faces[0] is not None
    assert laws.faces[0].damping == pytest.approx(2 * math.log(2) / math.hypot(math.pi, math.log(2)), rel=ROUND_OFF)
    assert laws.faces[2] == (laws.pair.stiffness, 0.0, 0.0, 0.0, 0.0)
    assert laws.faces[3] is not None
    # arccos(-1) = pi: k_t/k = q/(1 + q) = 1/3 of disks
    assert laws.faces[3].tangential_stiffness == pytest.approx(laws.pair.stiffness / 3, rel=ROUND_OFF)
    assert laws.faces[3].friction == math.inf


def test_cylinder() -> None:
    wall = Cylinder(radius=4.0, restitution=0.5, friction=Friction(tangential_restitution=0.0))
    scene = disks(
        box=Box(lengths=(9.0, 9.0), boundaries=("open", "open"), cylinder=wall),
        hard_spheres=HardSpheres(friction=ROUGH),
    )
    law = soft_spheres(scene, Contact(stiffness=10.0)).cylinder
    decay = math.pi**2 + math.log(0.5) ** 2
    assert law is not None
    assert law.damping == pytest.approx(2 * math.log(2) / math.sqrt(decay), rel=ROUND_OFF)
    assert law.tangential_stiffness == pytest.approx(10 / 3 * (math.pi / 2) ** 2 / decay, rel=ROUND_OFF)


def test_duration_and_stiffness_are_of_the_smallest_mass() -> None:
    scene = disks(masses=(3.0, 0.5), hard_spheres=HardSpheres(restitution=0.4))
    decay = math.pi**2 + math.log(0.4) ** 2
    assert contact_stiffness(scene, Contact(stiffness=7.0)) == 7.0
    assert contact_duration(scene, Contact(duration=0.02)) == 0.02
    assert contact_stiffness(scene, Contact(duration=0.02)) == pytest.approx(decay * 0.25 / 0.02**2, rel=ROUND_OFF)
    back = Contact(stiffness=contact_stiffness(scene, Contact(duration=0.02)))
    assert contact_duration(scene, back) == pytest.approx(0.02, rel=ROUND_OFF)


@pytest.mark.parametrize(("dimension", "solid"), [(2, 0.5), (3, 0.4)])
def test_inertia_is_a_solid_bodys_unless_given(dimension: int, solid: float) -> None:
    positions = ((1.0,) * dimension, (4.0,) * dimension)
    scene = disks(dimension=dimension, initial=Explicit(positions=positions))
    assert inertia_ratio(scene) == solid
    assert inertia_ratio(scene.changed(hard_spheres=HardSpheres(friction=ROUGH))) == solid
    hollow = GrainFriction(tangential_restitution=0.0, inertia=0.6)
    assert inertia_ratio(scene.changed(hard_spheres=HardSpheres(friction=hollow))) == 0.6


# -- the time step -----------------------------------------------------------------------------------------------------


@given(st.floats(1e-4, 0.5), st.floats(1e-3, 0.3), st.floats(0.05, 3.0), st.sampled_from([None, 1, 3, 8]))
def test_the_step_is_the_largest_that_divides(ratio: float, t_c: float, duration: float, parts: int | None) -> None:
    output = Output() if parts is None else Output(interval=duration / parts, observables=("kinetic_energy",))
    scene = disks(duration=duration, output=output)
    method = resolved(scene, soft(stiffness=None, duration=t_c, resolution=ratio))
    span = duration / (parts or 1)
    steps = round(span / method.step)
    assert steps * method.step == pytest.approx(span, rel=ROUND_OFF)
    assert method.step <= ratio * t_c * (1 + 1e-11)
    # one step fewer would be too long
    assert steps == 1 or span / (steps - 1) > ratio * t_c * (1 - 1e-11)
    assert method.contact == Contact(duration=t_c)
    assert resolved(scene, method) is method
    # it divides the duration too
    assert scene.steps(method.step) == steps * (parts or 1)


def test_a_resolution_that_divides_is_taken_as_it_is() -> None:
    method = resolved(disks(duration=1.0), soft(stiffness=None, duration=0.1, resolution=0.01))
    assert method.step == pytest.approx(1e-3, rel=ROUND_OFF)


def test_an_interval_at_which_nothing_is_recorded_does_not_count() -> None:
    scene = disks(duration=1.0, output=Output(interval=0.25))
    assert resolved(scene, soft(stiffness=None, duration=1.0, resolution=1.0)).dt == 1.0


def test_a_scene_of_no_duration_has_a_step_all_the_same() -> None:
    assert resolved(disks(duration=0.0), soft(stiffness=None, duration=0.1, resolution=0.01)).dt == 0.1


def test_other_methods_stay_as_they_are() -> None:
    for method in (
        Method(scheme="event_driven"),
        soft(),
        Method(scheme="verlet", dt=0.1, contact=Contact(duration=1.0)),
    ):
        assert resolved(disks(), method) is method


def test_a_resolution_needs_spheres_that_separate() -> None:
    with pytest.raises(UsageError, match=r"resolution needs a restitution above 0"):
        resolved(disks(hard_spheres=HardSpheres(restitution=0.0)), soft(resolution=0.01))


def test_a_contact_needs_hard_spheres() -> None:
    spring = Scene(
        name="spring", dimension=2, duration=1.0, spring=Spring(k=1.0), initial=Explicit(positions=((1.0, 0.0),))
    )
    with pytest.raises(UsageError, match=r"how \[hard_spheres\] touch, and the scene has none"):
        resolved(spring, Method(scheme="verlet", dt=0.1, contact=Contact(duration=1.0)))


# -- what is refused ---------------------------------------------------------------------------------------------------

SLIPPERY = GrainFriction(tangential_restitution=0.3, static=0.4, sliding=0.2)
CYLINDER = {"lengths": (9.0, 9.0), "boundaries": ("open", "open")}


@pytest.mark.parametrize(
    ("scene", "method", "reason"),
    [
        (disks(), Method(scheme="velocity_verlet", dt=0.1), "need an event-driven scheme, or method.contact"),
        (disks(hard_spheres=HardSpheres(restitution=0.0)), soft(), "restitution 0 needs an event-driven scheme"),
        (hard(y_upper=Face(restitution=0.0)), soft(), "restitution 0 needs an event-driven scheme"),
        (disks(box=Box(**CYLINDER, cylinder=Cylinder(radius=4.0, restitution=0.0))), soft(), "restitution 0"),
        (disks(hard_spheres=HardSpheres(well=Well(depth=1.0, range=1.5))), soft(), "no hard_spheres.well"),
        (disks(species=(0, 1), hard_spheres=HardSpheres(fixed=(1,))), soft(), "no hard_spheres.fixed"),
        (disks(hard_spheres=HardSpheres(contact_duration=0.1)), soft(), "no hard_spheres.contact_duration"),
        (disks(hard_spheres=HardSpheres(diameter=0.0)), soft(), "no hard_spheres.diameter = 0"),
        (disks(species=(0, 1), hard_spheres=HardSpheres(diameter=(1.0, 0.0))), soft(), "no hard_spheres.diameter = 0"),
        (disks(output=Output(collisions=(1,), trajectory=True)), soft(), "no output.collisions"),
        (hard(x_lower=Face(velocity=1.0)), soft(), "no box.faces.velocity"),
        (hard(x_lower=Face(random_phase=RandomPhase(speed=1.0))), soft(), "no box.faces.random_phase"),
        (hard(x_lower=Face(temperature=1.0)), soft(), "no box.faces.temperature"),
        (disks(hard_spheres=HardSpheres(friction=SLIPPERY)), soft(), "static and sliding must be equal"),
        (
            hard(x_lower=Face(friction=Friction(tangential_restitution=0.3, static=0.4, sliding=0.2))),
            soft(),
            "must be equal",
        ),
        (disks(hard_spheres=HardSpheres(friction=ROUGH)), soft(law="hertz"), 'take "hooke"'),
        (
            disks(hard_spheres=HardSpheres(friction=GrainFriction(tangential_restitution=0.0))),
            soft(friction="dashpot"),
            "tangential_restitution must be above 0",
        ),
        (
            disks(output=Output(interval=1.0, observables=("collisions", "contact_time", "dissipated_energy"))),
            soft(),
            "no collisions, no dissipated_energy",
        ),
    ],
)
def test_reasons(scene: Scene, method: Method, reason: str) -> None:
    for engine in (RefimplEngine(), LammpsEngine()):
        found = refused(engine, scene, method)
        assert found is not None
        assert reason in found


@pytest.mark.parametrize(
    ("scene", "method"),
    [
        (disks(), soft()),
        (disks(), soft(law="hertz")),
        (disks(hard_spheres=HardSpheres(friction=GrainFriction(tangential_restitution=1.0))), soft(law="hertz")),
        (disks(hard_spheres=HardSpheres(friction=GrainFriction(tangential_restitution=-1.0))), soft()),
        (hard(x_lower=Face(oscillation=Oscillation(amplitude=0.1, frequency=2.0))), soft(friction="dashpot")),
        (hard(x_lower=Face(open=True)), soft()),
        (
            disks(
                hard_spheres=HardSpheres(friction=ROUGH),
                output=Output(interval=1.0, observables=("kinetic_energy", "contact_time", "rotational_energy")),
            ),
            soft(friction="dashpot"),
        ),
    ],
)
def test_what_is_taken(scene: Scene, method: Method) -> None:
    assert unsupported(scene, method) is None


# -- the words of a method ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("entries", "message"),
    [
        ({}, "exactly one of stiffness, duration, k_n and E"),
        ({"stiffness": 1.0, "duration": 1.0}, "exactly one of stiffness, duration, k_n and E"),
        ({"duration": 1.0, "law": "hertz"}, "give stiffness, k_n or E, and method.dt"),
        ({"stiffness": 1.0, "law": "hertz", "resolution": 0.1}, "give stiffness, k_n or E, and method.dt"),
        ({"k_n": 1.0, "law": "hertz", "resolution": 0.1}, "give stiffness, k_n or E, and method.dt"),
        ({"stiffness": 0.0}, "greater than 0"),
        ({"duration": -1.0}, "greater than 0"),
        ({"duration": 1.0, "resolution": 0.0}, "greater than 0"),
        ({"stiffness": 1.0, "law": "linear"}, "'hooke' or 'hertz'"),
        ({"stiffness": 1.0, "friction": "none"}, "'history' or 'dashpot'"),
        ({"stiffness": 1.0, "damping": 0.1}, "Extra inputs"),
        ({"k_n": 1.0, "stiffness": 1.0}, "k_n and E .*found stiffness and k_n"),
        ({"k_n": 1.0, "duration": 1.0}, "found duration and k_n"),
        ({"k_n": 1.0, "E": 1.0, "nu": 0.3, "law": "hertz"}, "found k_n and E"),
        ({"gamma_n": 1.0}, "found none"),
        ({"stiffness": 1.0, "gamma_n": 1.0, "mu": 0.1}, "stiffness and gamma_n: .*remove gamma_n and mu, or give k_n"),
        ({"duration": 1.0, "k_t": 1.0}, "duration and k_t: with duration all else follows"),
        ({"stiffness": 1.0, "nu": 0.3}, "stiffness and nu"),
        ({"E": 1.0, "law": "hertz"}, "E and nu go together"),
        ({"k_n": 1.0, "nu": 0.3}, "E and nu go together"),
        ({"E": 1.0, "nu": 0.3}, 'moduli of law = "hertz"'),
        ({"E": 1.0, "nu": 0.3, "k_t": 1.0, "law": "hertz"}, "the tangential stiffness follows from E and nu"),
        ({"E": 1.0, "nu": 0.6, "law": "hertz"}, "less than or equal to 0.5"),
        ({"E": 1.0, "nu": -1.0, "law": "hertz"}, "greater than -1"),
        ({"k_n": 1.0, "gamma_t": 1.0}, "gamma_t needs gamma_n"),
        ({"k_n": 1.0, "gamma_n": -1.0}, "greater than or equal to 0"),
        ({"k_n": 1.0, "mu": -1.0}, "greater than or equal to 0"),
        ({"k_n": 0.0}, "greater than 0"),
        ({"k_n": 1.0, "k_t": 1.0, "friction": "dashpot"}, '"dashpot" has no tangential spring'),
        ({"E": 1.0, "nu": 0.3, "law": "hertz", "friction": "dashpot"}, '"dashpot" has no tangential spring'),
    ],
)
def test_contacts_say_what_is_wrong_with_them(entries: dict[str, Any], message: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=message):
        Contact(**entries)
    # in the file of a scene, one line
    path, table = tmp_path / "scene.toml", tomllib.loads(disks(method=soft()).to_toml())
    table["method"]["contact"] = entries
    path.write_text(tomli_w.dumps(table), encoding="utf-8")
    with pytest.raises(UsageError, match=message if "Extra" not in message else "damping") as error:
        Scene.load(path)
    assert len(str(error.value).splitlines()) == 1


#: (scene, contact, what is wrong with the two together).
CONTRADICTIONS: list[tuple[Scene, dict[str, Any], str]] = [
    (disks(), {"k_n": 1.0, "k_t": 1.0}, r"method.contact.k_t: smooth grains: add \[hard_spheres.friction\]"),
    (disks(), {"k_n": 1.0, "mu": 0.1}, "method.contact.mu: smooth grains"),
    (disks(), {"k_n": 1.0, "gamma_n": 0.0, "gamma_t": 0.1}, "method.contact.gamma_t: smooth grains"),
    (
        disks(hard_spheres=HardSpheres(restitution=0.5)),
        {"k_n": 1.0, "gamma_n": 0.1},
        "gamma_n and hard_spheres.restitution = 0.5 both say what a contact dissipates",
    ),
    (
        hard(x_lower=Face(restitution=0.9)),
        {"k_n": 1.0, "k_t": 1.0, "gamma_n": 0.1},
        'gamma_n and box.faces."x-".restitution = 0.9 both',
    ),
    (
        disks(box=Box(lengths=(9.0, 9.0), boundaries=("open", "open"), cylinder=Cylinder(radius=4.0, restitution=0.9))),
        {"k_n": 1.0, "gamma_n": 0.1},
        "gamma_n and box.cylinder.restitution = 0.9 both",
    ),
    (
        disks(hard_spheres=HardSpheres(friction=ROUGH)),
        {"k_n": 1.0, "k_t": 1.0, "mu": 0.1},
        "mu and hard_spheres.friction.sliding = 0.2 both limit the friction",
    ),
    (
        disks(hard_spheres=HardSpheres(friction=ROUGH)),
        {"k_n": 7.0},
        r"method.contact.k_t is missing: .* as k_t = 2 \(2/7 of k_n\)",
    ),
    (
        disks(hard_spheres=HardSpheres(friction=ROUGH)),
        {"k_n": 7.0, "gamma_n": 1.0, "friction": "dashpot"},
        "method.contact.gamma_t is missing",
    ),
    (disks(), {"k_n": 1.0, "gamma_n": 10.0, "resolution": 0.1}, "so large that contacts do not end"),
]


@pytest.mark.parametrize(("scene", "contact", "message"), CONTRADICTIONS)
def test_a_contact_and_a_scene_that_contradict_each_other(scene: Scene, contact: dict[str, Any], message: str) -> None:
    with pytest.raises(UsageError, match=message) as error:
        resolved(scene, Method(scheme="velocity_verlet", contact=Contact(**contact)))
    assert len(str(error.value).splitlines()) == 1


# -- coefficients of a contact's own -----------------------------------------------------------------------------------

FREE = HardSpheres(friction=GrainFriction(tangential_restitution=-1.0))


def test_coefficients_are_handed_over_as_they_are() -> None:
    own = {"k_n": 7.0, "k_t": 2.0, "gamma_n": 0.5, "gamma_t": 0.25, "mu": 0.3}
    faces = {
        "x-": Face(friction=Friction(tangential_restitution=-1.0)),
        "x+": Face(friction=Friction(tangential_restitution=1.0)),
        "y-": Face(),
        "y+": Face(open=True),
    }
    scene = disks(hard_spheres=FREE, box=Box(lengths=(9.0, 9.0), boundaries=("hard", "hard"), faces=faces))
    laws = soft_spheres(scene, Contact(**own))
    assert laws.by_mass
    assert not laws.granular
    assert laws.pair == (7.0, 0.5, 2.0, 0.25, 0.3)
    # smooth where there is no friction
    assert laws.faces == (laws.pair, (7.0, 0.5, 0, 0, 0), (7.0, 0.5, 0, 0, 0), None)


def test_friction_without_mu_is_that_of_the_scene() -> None:
    contact = Contact(k_n=7.0, k_t=2.0, gamma_n=0.5)
    assert soft_spheres(disks(hard_spheres=FREE), contact).pair.friction == math.inf
    assert soft_spheres(disks(hard_spheres=HardSpheres(friction=ROUGH)), contact).pair.friction == 0.2


@given(st.floats(1.0, 1e9), st.floats(-0.9, 0.5))
def test_moduli_are_those_of_hertz_and_mindlin(young: float, nu: float) -> None:
    contact = Contact(law="hertz", E=young, nu=nu, gamma_n=0.0)
    law = soft_spheres(disks(hard_spheres=FREE), contact).pair
    pressed = Pressed(Material(young, nu), 1.0, 1.0)
    assert law.stiffness == pytest.approx(pressed.force, rel=1e-12)
    assert law.tangential_stiffness == pytest.approx(pressed.tangential_stiffness, rel=1e-12)


def test_without_gamma_n_the_restitution_gives_the_damping() -> None:
    scene = disks(hard_spheres=HardSpheres(restitution=0.6, friction=ROUGH))
    for own, mapped in (
        (Contact(k_n=7.0, k_t=1.0), Contact(stiffness=7.0)),
        (Contact(law="hertz", k_n=7.0, k_t=1.0), Contact(law="hertz", stiffness=7.0)),
    ):
        laws = soft_spheres(scene, own)
        assert not laws.by_mass
        smooth = disks(hard_spheres=HardSpheres(restitution=0.6))
        assert laws.pair.damping == soft_spheres(smooth, mapped).pair.damping
        assert laws.pair[2:] == (1.0, 0.0, 0.2)


@given(st.floats(0.5, 0.999), st.floats(0.1, 10.0), st.floats(1.0, 1e6))
def test_duration_by_rates_is_that_by_restitution(alpha: float, mass: float, k: float) -> None:
    by_restitution = disks(masses=mass, hard_spheres=HardSpheres(restitution=alpha))
    t_c = contact_duration(by_restitution, Contact(stiffness=k))
    rate = -2 * math.log(alpha) / t_c
    assert contact_duration(disks(masses=mass), Contact(k_n=k, gamma_n=rate)) == pytest.approx(t_c, rel=1e-12)
    resolution = resolved(disks(masses=mass), soft(stiffness=None, k_n=k, gamma_n=rate, resolution=0.1)).step
    assert resolution <= 0.1 * t_c * (1 + 1e-11)


def test_which_equations_of_lammps() -> None:
    one, several = disks(hard_spheres=FREE), disks(hard_spheres=FREE, masses=(1.0, 2.0))
    rates = {"gamma_n": 1.0, "gamma_t": 1.0}
    for contact, of_one, of_several in (
        (Contact(stiffness=1.0), False, True),
        (Contact(law="hertz", stiffness=1.0), True, True),
        (Contact(k_n=1.0, k_t=1.0, **rates), False, False),
        (Contact(k_n=1.0, friction="dashpot", **rates), False, False),
        (Contact(law="hertz", k_n=1.0, k_t=1.0, **rates), False, False),
        (Contact(law="hertz", k_n=1.0, friction="dashpot", **rates), True, True),
        (Contact(law="hertz", E=1.0, nu=0.3, **rates), True, True),
    ):
        assert soft_spheres(one, contact).granular == of_one
        assert soft_spheres(several, contact).granular == of_several


@pytest.mark.parametrize(
    ("contact", "dt", "speed", "words"),
    [
        ({"stiffness": 100.0}, 0.01, 1.0, []),
        ({"stiffness": 100.0}, 0.03, 1.0, ["dt = 0.03 is 0.14 of the shortest contact, 0.222"]),
        ({"k_n": 100.0, "k_t": 1.0, "gamma_n": 1.0}, 0.01, 1.0, []),
        ({"k_n": 100.0, "k_t": 1e4, "gamma_n": 1.0}, 0.01, 1.0, ["dt = 0.01 is 0.78 of the shortest contact, 0.0128"]),
        ({"k_n": 1.0, "k_t": 1.0, "gamma_n": 100.0}, 0.01, 1.0, []),
        # two disks of mass 1 and radius 1/2 that meet with twice the largest speed
        ({"law": "hertz", "k_n": 1e4, "k_t": 1.0}, 0.006, 1.0, []),
        (
            {"law": "hertz", "k_n": 1e4, "k_t": 1.0},
            0.01,
            1.0,
            [f"of the shortest contact, {HertzImpact(0.5, 1e4, 0.25, 2.0).contact_time:.3g}"],
        ),
        ({"law": "hertz", "k_n": 1e4, "k_t": 1.0}, 0.3, 0.0, []),
    ],
)
def test_remarks(contact: dict[str, Any], dt: float, speed: float, words: list[str]) -> None:
    method = Method(scheme="velocity_verlet", dt=dt, contact=Contact(**contact))
    found = remarks(disks(hard_spheres=FREE), method, np.array([[speed, 0.0], [0.0, 0.0]]))
    assert len(found) == len(words)
    for remark, part in zip(found, words, strict=True):
        assert part in remark
        assert remark.endswith(".")


def test_a_tangential_restitution_that_is_not_used_is_remarked_upon() -> None:
    for alpha_t, number in ((0.3, 1), (1.0, 0), (-1.0, 0)):
        scene = disks(hard_spheres=HardSpheres(friction=GrainFriction(tangential_restitution=alpha_t)))
        method = Method(scheme="velocity_verlet", dt=1e-3, contact=Contact(k_n=100.0, k_t=1.0))
        assert len(remarks(scene, method, np.zeros((2, 2)))) == number


def test_one_step_or_the_other() -> None:
    with pytest.raises(ValueError, match="both say how long a step is"):
        Method(scheme="velocity_verlet", dt=0.1, contact=Contact(duration=1.0, resolution=0.1))


@pytest.mark.parametrize(
    "contact",
    [
        Contact(stiffness=1e4),
        Contact(law="hertz", stiffness=3.0, friction="dashpot"),
        Contact(duration=0.01, resolution=1 / 50),
        Contact(k_n=7.0, k_t=2.0, gamma_n=0.5, gamma_t=0.25, mu=0.3),
        Contact(law="hertz", E=7.0, nu=0.3),
    ],
)
def test_toml_keeps_a_method_with_a_contact(contact: Contact, tmp_path: Path) -> None:
    dt = None if contact.resolution else 1e-3
    scene = disks(method=Method(scheme="velocity_verlet", dt=dt, contact=contact))
    path = tmp_path / "scene.toml"
    path.write_text(scene.to_toml(), encoding="utf-8")
    assert Scene.load(path) == scene


def test_a_scene_file_is_told_what_its_contact_lacks(tmp_path: Path) -> None:
    path = tmp_path / "scene.toml"
    text = disks(method=soft()).to_toml()
    path.write_text(text.replace("stiffness = 10000.0", "stiff = 1.0"), encoding="utf-8")
    with pytest.raises(UsageError, match=r"method\.contact"):
        Scene.load(path)
