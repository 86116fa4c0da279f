"""What an engine has not declared never reaches it, whoever wrote the engine and whatever the scene language learns."""

from __future__ import annotations

import re
from typing import Any

import pytest
from pydantic import create_model

from crosscheck.engines.capabilities import Capability, capability, measured, refusal, scheme_of, words
from crosscheck.engines.protocol import Claims
from crosscheck.engines.registry import engine_class, engine_names
from crosscheck.scene import (
    Box,
    Contact,
    Explicit,
    Face,
    GrainFriction,
    Gravity,
    HardSpheres,
    LatticeGas,
    LennardJones,
    Method,
    Obstacle,
    Occupations,
    Output,
    Scene,
    Spring,
    Wall,
)
from crosscheck.scene.observables import NAMED, TABLE

ONE = Explicit(positions=((1.0, 1.0),))
SCENES = {
    "spring": Scene(name="a", dimension=2, duration=1.0, spring=Spring(k=1.0), initial=ONE),
    "gravity": Scene(name="a", dimension=2, duration=1.0, gravity=Gravity(), initial=ONE),
    "lennard_jones": Scene(name="a", dimension=2, duration=1.0, lennard_jones=LennardJones(cutoff=2.5), initial=ONE),
    "hard_spheres": Scene(name="a", dimension=2, duration=1.0, hard_spheres=HardSpheres(), initial=ONE),
    "lattice_gas": Scene(
        name="a",
        dimension=2,
        duration=1.0,
        lattice_gas=LatticeGas(model="hpp", columns=4, rows=4),
        initial=Occupations(kind="occupations", density=0.2, seed=0),
    ),
}


@pytest.mark.parametrize(
    ("interaction", "changes", "found"),
    [
        ("spring", {}, "dimension=2"),
        ("spring", {"spring": Spring(k=2.0, gamma=0.1)}, "dimension=2 spring.gamma"),
        ("gravity", {"gravity": Gravity(G=2.0)}, "dimension=2 gravity.G"),
        (
            "lennard_jones",
            {},
            "dimension=2 lennard_jones.length_form=sigma lennard_jones.truncation=truncated",
        ),
        (
            "lennard_jones",
            {
                "lennard_jones": LennardJones(cutoff=2.5, epsilon=(1.0, 2.0), length=(1.0,), tail_corrections=True),
                "species": (0, 1),
            },
            "dimension=2 lennard_jones.epsilon[] lennard_jones.length_form=sigma lennard_jones.truncation=truncated",
        ),
        (
            "lennard_jones",
            {"box": Box(lengths=(9.0, 9.0), boundaries=("wall", "periodic"), wall=Wall(cutoff=1.0, sigma=0.5))},
            "dimension=2 lennard_jones.length_form=sigma lennard_jones.truncation=truncated box.boundaries=wall "
            "box.boundaries=periodic box.wall box.wall.sigma",
        ),
        ("hard_spheres", {"hard_spheres": HardSpheres(diameter=2.0)}, "dimension=2 hard_spheres.diameter"),
        (
            "hard_spheres",
            {
                "hard_spheres": HardSpheres(friction=GrainFriction(tangential_restitution=0.0)),
                "box": Box(lengths=(9.0, 9.0), boundaries=("hard", "open"), faces={"x-": Face(temperature=1.0)}),
                "seed": 1,
                "output": Output(collisions=(1,), fields=(2, 2)),
            },
            "dimension=2 hard_spheres.friction box.boundaries=hard box.boundaries=open box.faces "
            "box.faces.temperature output.collisions output.fields",
        ),
        (
            "lattice_gas",
            {
                "lattice_gas": LatticeGas(model="hpp", columns=4, rows=4, obstacles=(Obstacle(rows=(0, 0)),)),
                "output": Output(interval=1.0, observables=("populations",), fields=(2, 2)),
            },
            "dimension=2 lattice_gas.obstacles lattice_gas.obstacles.rows lattice_gas.obstacles.rule=bounce_back",
        ),
    ],
)
def test_words(interaction: str, changes: dict[str, Any], found: str) -> None:
    scene = SCENES[interaction].changed(**changes)
    assert words(scene) == set(found.split())


def test_masses_are_words_where_they_differ_or_vanish() -> None:
    two = Explicit(positions=((1.0, 1.0), (2.0, 2.0)))
    for masses, found in (
        (2.0, set()),
        ((2.0, 2.0), set()),
        ((1.0, 2.0), {"masses[]"}),
        ((1.0, 0.0), {"masses[]", "masses=0"}),
    ):
        scene = SCENES["gravity"].changed(masses=masses, initial=two)
        assert words(scene) == {"dimension=2"} | found


def test_the_contact_of_a_method_is_made_of_words() -> None:
    method = Method(scheme="velocity_verlet", dt=0.1, contact=Contact(stiffness=1.0, law="hertz"))
    contact = {"", ".stiffness", ".law=hertz", ".friction=history"}
    assert words(SCENES["hard_spheres"], method) == {"dimension=2"} | {f"method.contact{word}" for word in contact}


def test_what_is_measured() -> None:
    output = Output(interval=0.1, observables=("kinetic_energy", "momentum"), trajectory=False, forces=True)
    assert measured(SCENES["spring"].changed(output=output)) == {"forces", "kinetic_energy", "velocities"}
    fields = SCENES["hard_spheres"].changed(
        box=Box(lengths=(9.0, 9.0)), output=Output(fields=(2, 2), trajectory=True, interval=1.0)
    )
    assert measured(fields) == {"positions", "velocities"}


@pytest.mark.parametrize("engine", engine_names())
def test_a_new_entry_of_a_scene_is_refused_by_every_engine(engine: str) -> None:
    """A field that the language learns after an engine was written: here, one added to [hard_spheres] and [spring]."""
    declared = engine_class(engine)
    for scene_of, table in (
        ("hard_spheres", HardSpheres),
        ("spring", Spring),
        ("gravity", Gravity),
        ("lennard_jones", LennardJones),
    ):
        wider = create_model(f"Wider{table.__name__}", __base__=table, stickiness=(float | None, None))
        required = {name: 1.0 for name, field in table.model_fields.items() if field.is_required()}
        scene = SCENES[scene_of].model_copy(update={scene_of: wider(**required, stickiness=0.5)})
        assert f"{scene_of}.stickiness" in words(scene)
        for scheme, claims in declared.schemes.items():
            contact = Contact(stiffness=1.0) if (scene_of, claims.kind) == ("hard_spheres", "stepping") else None
            method = Method(scheme=scheme, dt=0.1 if claims.takes_dt else None, contact=contact)
            reason = refusal(declared, scene, method)
            assert reason is not None
            assert "stickiness" in reason or "not for" in reason


@pytest.mark.parametrize("engine", engine_names())
@pytest.mark.parametrize("interaction", SCENES)
def test_every_scheme_refuses_the_interactions_that_it_does_not_declare(engine: str, interaction: str) -> None:
    """Nothing reaches an engine by elimination, as a lattice gas with velocity Verlet."""
    declared = engine_class(engine)
    able = {(one.interaction, one.kind) for one in declared.capabilities}
    for scheme, claims in declared.schemes.items():
        reason = refusal(declared, SCENES[interaction], Method(scheme=scheme, dt=0.1 if claims.takes_dt else None))
        if (interaction, claims.kind) not in able:
            assert reason is not None
            assert f"not for [{interaction}]" in reason


@pytest.mark.parametrize("engine", engine_names())
def test_declared_words_are_words_of_the_scene_language(engine: str) -> None:
    """A misspelt declaration would refuse what the engine can do."""
    for one in engine_class(engine).capabilities:
        assert one.interaction in SCENES
        for word in one.words:
            assert re.split(r"[.=\[]", word)[0] in Scene.model_fields
        assert one.observables <= set(TABLE)
        assert not one.schemes or set(one.schemes) <= set(engine_class(engine).schemes)


def test_an_unknown_observable_is_refused_at_once() -> None:
    with pytest.raises(ValueError, match=r"capability for \[spring\]: there is no observable kinetic_energi"):
        capability("spring", "stepping", words="", observables="kinetic_energi")


class Mine:
    """An engine whose event-driven scheme has a name of its own."""

    name = "mine"
    schemes = {"edmd": Claims(kind="event_driven"), "verlet": Claims((2, 2))}
    capabilities: tuple[Capability, ...] = (
        capability("hard_spheres", "event_driven", words="dimension=2", observables="collisions"),
        capability("spring", "stepping", words="dimension=1 dimension=2", observables=""),
    )


def test_schemes_are_found_by_kind() -> None:
    assert scheme_of(Mine, "hard_spheres", "event_driven") == "edmd"
    assert scheme_of(Mine, "hard_spheres", "stepping") is None
    assert scheme_of(engine_class("refimpl"), "lattice_gas", "lattice") == "lattice_planes"


@pytest.mark.parametrize(
    ("scheme", "interaction", "changes", "reason"),
    [
        ("edmd", "hard_spheres", {}, None),
        ("edmd", "spring", {}, "its scheme 'edmd' is for [hard_spheres], not for [spring]"),
        ("verlet", "spring", {}, None),
        (
            "verlet",
            "spring",
            {"output": Output(trajectory=True, interval=1.0)},
            "it declares no positions, no velocities for [spring]",
        ),
        ("leapfrog", "spring", {}, "no scheme 'leapfrog'; it has edmd, verlet"),
    ],
)
def test_refusal(scheme: str, interaction: str, changes: dict[str, Any], reason: str | None) -> None:
    scene = SCENES[interaction].changed(**changes)
    assert refusal(Mine, scene, Method(scheme=scheme, dt=None if scheme == "edmd" else 0.1)) == reason


def test_every_named_observable_is_measured_by_some_engine_or_derived() -> None:
    able = {name for engine in engine_names() for one in engine_class(engine).capabilities for name in one.observables}
    for name in NAMED:
        row = TABLE[name]
        assert set(row.needs) <= able if row.derive is not None else name in able


def test_lattice_scene_with_a_stepping_scheme_is_refused_in_words() -> None:
    reason = refusal(engine_class("refimpl"), SCENES["lattice_gas"], Method(scheme="velocity_verlet", dt=1.0))
    assert reason is not None
    assert "not for [lattice_gas]" in reason
