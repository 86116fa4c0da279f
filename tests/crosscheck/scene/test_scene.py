"""Scenes survive the way to TOML and JSON and back; entries of different tables agree; durations and steps."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scene_files import DISKS, FLUID, MIXTURE, SPRING, TURNING, assert_one_message, assert_survives_files, changed, load

from crosscheck.errors import UsageError
from crosscheck.scene import (
    Box,
    Cylinder,
    Explicit,
    Face,
    Friction,
    GrainFriction,
    Gravity,
    HardSpheres,
    Kepler,
    Lattice,
    LennardJones,
    Method,
    Oscillation,
    Output,
    RandomPhase,
    Scene,
    Spring,
    Wall,
    Well,
    whole_steps,
)
from crosscheck.scene.observables import named

positive = st.floats(1e-100, 1e100)
finite = st.floats(-1e100, 1e100)
line = st.text(st.characters(exclude_categories=("Cc", "Cs", "Zl", "Zp"), exclude_characters="\ufffe\uffff"))
unit = st.floats(0, 1)


@st.composite
def frictions(draw: st.DrawFn, kind: type[Any] = Friction, **more: Any) -> Any:
    limits: dict[str, float] = {}
    if draw(st.booleans()):
        limits["static"] = draw(st.floats(0, 10))
        limits["sliding"] = draw(st.floats(0, limits["static"]))
    return kind(tangential_restitution=draw(st.floats(-1, 1)), **limits, **more)


@st.composite
def hard_scenes(draw: st.DrawFn, dimension: int) -> Scene:
    """Any valid scene of hard spheres; the initial state may be impossible."""
    number = draw(st.integers(1, 4))
    rotating = draw(st.booleans())
    size = st.floats(0.1, 10) if rotating else st.just(0.0) | st.floats(0.1, 10)
    inertia = draw(st.none() | st.floats(0.01, 0.6))
    spheres: dict[str, Any] = {
        "diameter": draw(size | st.tuples(size, size)),
        "restitution": draw(unit),
        "contact_duration": draw(st.none() | st.just(1e-6)),
        "friction": draw(frictions(GrainFriction, inertia=inertia)) if rotating else None,
        "well": draw(st.none() | st.builds(Well, depth=finite, range=st.floats(1.01, 3))),
    }
    species = draw(st.lists(st.integers(0, 1), min_size=number, max_size=number).map(tuple))
    acceleration = draw(st.none() | st.tuples(*[finite] * dimension))
    if set(species) == {0, 1} and acceleration is None and draw(st.booleans()):
        spheres["fixed"] = (0,)
    wall_friction = st.none() | frictions() if rotating else st.none()
    motions: list[dict[str, Any]] = [
        {"velocity": draw(unit)},
        {"random_phase": RandomPhase(speed=draw(positive), law=draw(st.sampled_from(["uniform", "flux"])))},
        {"oscillation": Oscillation(amplitude=draw(positive), frequency=draw(positive), phase=draw(finite))},
        {},
    ]
    rules = st.sampled_from(motions).flatmap(
        lambda motion: st.builds(
            Face, restitution=unit, friction=wall_friction, **{k: st.just(v) for k, v in motion.items()}
        )
    )
    rules = rules | st.just(Face(open=True)) | st.builds(Face, temperature=positive)
    boundaries = draw(st.tuples(*[st.sampled_from(["periodic", "hard", "open"])] * dimension))
    names = [f"{axis}{side}" for axis, kind in zip("xyz", boundaries, strict=False) if kind == "hard" for side in "-+"]
    faces = {name: draw(rules) for name in names if draw(st.booleans())}
    drum = None
    if boundaries[:2] == ("open", "open") and draw(st.booleans()):
        law = draw(wall_friction)
        turning = draw(finite) if law is not None else 0.0
        axis = "z" if dimension == 3 else None
        drum = Cylinder(
            radius=draw(positive), axis=axis, angular_velocity=turning, restitution=draw(unit), friction=law
        )
    box = Box(
        lengths=draw(st.tuples(*[positive] * dimension)), boundaries=boundaries, faces=faces or None, cylinder=drum
    )
    rows = st.lists(st.tuples(*[finite] * dimension), min_size=number, max_size=number).map(tuple)
    turns = st.lists(st.tuples(*[finite] * (1 if dimension == 2 else 3)), min_size=number, max_size=number).map(tuple)
    observables = [
        name for name in ("kinetic_energy", "potential_energy", *named("hard_spheres")) if name != "wall_torque" or drum
    ]
    if not rotating:
        observables.remove("rotational_energy")
    counts = st.sets(st.integers(1, 10**6), min_size=1).map(sorted).map(tuple)
    when = {"collisions": draw(counts)} if draw(st.booleans()) else {"interval": draw(positive)}
    output = Output(
        observables=tuple(draw(st.lists(st.sampled_from(observables), unique=True))),
        trajectory=draw(st.booleans()),
        fields=draw(st.none() | st.tuples(*[st.integers(1, 9)] * dimension)),
        **when,
    )
    return Scene(
        name=draw(line),
        dimension=dimension,
        duration=draw(st.just(0.0) | positive),
        masses=draw(positive),
        species=species,
        acceleration=acceleration,
        seed=draw(st.integers(0, 2**63 - 1)),
        hard_spheres=HardSpheres(**spheres),
        box=box,
        initial=Explicit(
            positions=draw(rows), velocities=draw(rows), angular_velocities=draw(turns) if rotating else None
        ),
        output=output,
        method=Method(scheme=draw(st.text())),
    )


# -- there and back -------------------------------------------------------------------------------------


@st.composite
def scenes(draw: st.DrawFn) -> Scene:
    """Any valid scene."""
    dimension = draw(st.sampled_from([1, 2, 3]))
    kind = draw(st.sampled_from(["spring", "gravity"] + ["lennard_jones", "hard_spheres"] * (dimension > 1)))
    if kind == "hard_spheres":
        return draw(hard_scenes(dimension))
    number = draw(st.integers(1, 4))
    vectors = st.tuples(*[finite] * dimension)
    rows = st.lists(vectors, min_size=number, max_size=number).map(tuple)
    initial: Any = Explicit(positions=draw(rows), velocities=draw(st.none() | rows))
    more: dict[str, Any] = {}
    if kind == "spring":
        more["spring"] = Spring(k=draw(positive), gamma=draw(st.none() | st.just(0.0) | positive))
    elif kind == "gravity":
        more["gravity"] = Gravity(G=draw(positive), softening=draw(st.none() | positive))
        if draw(st.booleans()):
            eccentricity = draw(st.floats(0, 1, exclude_max=True))
            initial = Kepler(kind="kepler", semi_major_axis=draw(positive), eccentricity=eccentricity)
    else:
        lengths = st.tuples(*[positive] * dimension)
        boundaries = draw(st.none() | st.tuples(*[st.sampled_from(["periodic", "wall"])] * dimension))
        wall = Wall(cutoff=draw(positive)) if boundaries and "wall" in boundaries else None
        size = {"lengths": draw(lengths)} if draw(st.booleans()) else {"density": draw(positive)}
        more["box"] = Box(boundaries=boundaries, wall=wall, **size)
        species = draw(st.none() | st.lists(st.integers(0, 2), min_size=number, max_size=number).map(tuple))
        kinds = 1 if species is None else max(species) + 1
        several = st.lists(positive, min_size=kinds, max_size=kinds).map(tuple)
        more["species"] = species
        more["lennard_jones"] = LennardJones(
            cutoff=draw(positive),
            epsilon=draw(positive | several),
            length=draw(positive | several),
            length_form=draw(st.sampled_from(["sigma", "r_m"])),
            truncation=draw(st.sampled_from(["truncated", "shifted", "force_shifted"])),
            tail_corrections=draw(st.booleans()),
        )
        if draw(st.booleans()):
            structure = draw(st.sampled_from(["fcc", "sc", "square", "triangular"]))
            temperature, seed = draw(st.just(0.0) | positive), draw(st.integers(0, 2**63 - 1))
            initial = Lattice(kind="lattice", structure=structure, number=number, temperature=temperature, seed=seed)
    observables = draw(st.lists(st.sampled_from(["kinetic_energy", "potential_energy", "virial"]), unique=True))
    output = Output(
        interval=draw(positive),
        observables=tuple(observables),
        trajectory=draw(st.booleans()),
        forces=draw(st.booleans()),
    )
    return Scene(
        name=draw(line),
        dimension=dimension,
        duration=draw(st.just(0.0) | positive),
        masses=draw(positive | st.lists(positive, min_size=number, max_size=number).map(tuple)),
        initial=initial,
        output=draw(st.just(Output()) | st.just(output)),
        method=draw(st.none() | st.just(Method(scheme=draw(st.text()), dt=draw(positive)))),
        **more,
    )


@given(scene=scenes())
def test_toml_and_json_give_back_an_equal_scene(scene: Scene, tmp_path_factory: pytest.TempPathFactory) -> None:
    assert_survives_files(scene, tmp_path_factory.getbasetemp())


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "cannot be read .No such file or directory."),
        (b"a = ", "not valid TOML"),
        (b"\xff\xfe", "not valid TOML"),
    ],
)
def test_a_file_that_cannot_be_read(tmp_path: Path, content: bytes | None, message: str) -> None:
    path = tmp_path / "scene.toml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(UsageError, match=message) as error:
        Scene.load(path)
    assert str(error.value).startswith(str(path))
    with pytest.raises(UsageError, match="cannot be read"):
        Scene.load(tmp_path)


# -- entries that do not go together --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("table", "path", "value", "message"),
    [
        (SPRING, "masses", [1.0, 0.0], "masses: a particle without mass moves with [gravity] only"),
        (SPRING, "spring", ..., "[gravity], [hard_spheres], [lattice_gas]; found none"),
        (SPRING, "gravity", {}, "[hard_spheres], [lattice_gas]; found spring and gravity"),
        (SPRING, "box", {"density": 1.0}, "[box] goes with [lennard_jones] or [hard_spheres]"),
        (SPRING, "output.trajectory", True, "output.interval is missing: say how often to record"),
        (FLUID, "dimension", 1, "[lennard_jones] needs dimension 2 or 3"),
        (FLUID, "box.lengths", [5.0, 5.0], "box.lengths needs 3 entries, found 2"),
        (FLUID, "box", ..., "initial.kind = 'lattice' fills a box: add [box]"),
        (DISKS, "dimension", 1, "[hard_spheres] needs dimension 2 or 3"),
        (DISKS, "output.observables", ["virial"], "output.interval is missing"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_message_with_its_path(
    tmp_path: Path, table: dict[str, Any], path: str, value: Any, message: str
) -> None:
    assert_one_message(tmp_path, changed(table, path, value), message)


# -- whole steps ----------------------------------------------------------------------------------------


@given(steps=st.integers(0, 10**6), dt=st.floats(1e-6, 1e3))
def test_whole_numbers_of_steps_are_seen(steps: int, dt: float) -> None:
    assert whole_steps(steps * dt, dt, "duration") == steps


@given(span=st.floats(1e-3, 1e6), dt=st.floats(1e-3, 1e6))
def test_the_step_that_is_proposed_works(span: float, dt: float) -> None:
    if abs(span / dt - round(span / dt)) <= 1e-9 * max(1, span / dt):
        assert whole_steps(span, dt, "duration") == round(span / dt)
        return
    with pytest.raises(UsageError, match="is not a whole number of steps") as error:
        whole_steps(span, dt, "duration")
    proposed = float(str(error.value).rpartition("dt = ")[2])
    assert whole_steps(span, proposed, "duration") == max(1, round(span / dt))


def test_steps_beyond_counting() -> None:
    with pytest.raises(UsageError, match="too many steps"):
        whole_steps(1.0, 5e-324, "duration")


def test_samples_of_a_scene(tmp_path: Path) -> None:
    scene = load(tmp_path, changed(SPRING, "output", {"interval": 0.25, "trajectory": True}))
    assert scene.steps(0.05) == 20
    assert scene.every(0.05) == 5
    assert scene.changed(output=Output(interval=0.25)).every(0.05) is None  # records nothing
    with pytest.raises(UsageError, match=r"output.interval = 0.25 is not a whole number of steps of method.dt = 0.1;"):
        scene.every(0.1)
    with pytest.raises(UsageError, match=r"output.interval"):
        scene.every(0.5)


def test_when_an_event_driven_run_is_recorded(tmp_path: Path) -> None:
    def times(**output: Any) -> list[float]:
        return load(tmp_path, changed(DISKS, "output", output)).samples().tolist()

    assert times() == [0, 1]
    assert times(interval=0.25) == [0, 0.25, 0.5, 0.75, 1]
    assert times(interval=0.4) == [0, 0.4, 0.8]
    assert times(interval=0.1)[-1] == 1
    np.testing.assert_array_equal(times(collisions=[3, 9]), [0, math.nan, math.nan])


# -- box and initial state ------------------------------------------------------------------------------


def test_packing_fraction(tmp_path: Path) -> None:
    box = {"packing_fraction": 0.3}
    wide = changed(changed(MIXTURE, "initial.positions", [[0.5, 0.5], [2.0, 1.2]]), "hard_spheres.diameter", [0.5, 1.0])
    assert load(tmp_path, changed(wide, "box", box)).volume() == pytest.approx(math.pi / 4 * (0.25 + 1) / 0.3)
    spheres = changed(DISKS, "dimension", 3) | {"box": box}
    spheres["initial"] = {"kind": "lattice", "structure": "sc", "number": 64, "temperature": 1.0, "seed": 0}
    assert load(tmp_path, spheres).volume() == pytest.approx(64 * math.pi / 6 / 0.3)
    points = changed(changed(DISKS, "box", box), "hard_spheres.diameter", 0.0)
    with pytest.raises(UsageError, match=r"box.packing_fraction = 0.3 needs particles with a diameter"):
        load(tmp_path, points).lengths()


def test_a_hard_state_has_diameters_and_spins(tmp_path: Path) -> None:
    state = load(tmp_path, DISKS).initial_state()
    assert state.diameters is not None
    np.testing.assert_array_equal(state.diameters, [1.0, 1.0])
    assert state.angular_velocities is None
    turning = load(tmp_path, TURNING).initial_state()
    np.testing.assert_array_equal(turning.angular_velocities, [[0.0], [0.0]])
    given = load(tmp_path, changed(TURNING, "initial.angular_velocities", [[1.0], [-2.0]])).initial_state()
    np.testing.assert_array_equal(given.angular_velocities, [[1.0], [-2.0]])
    np.testing.assert_array_equal(load(tmp_path, MIXTURE).diameters(), [1.0, 2.0])
    assert load(tmp_path, SPRING).initial_state().diameters is None


def test_springs_may_coincide_and_rest_by_default(tmp_path: Path) -> None:
    state = load(tmp_path, changed(SPRING, "initial.positions", [[1.0], [1.0]])).initial_state()
    np.testing.assert_array_equal(state.velocities, [[0.0], [0.0]])
    np.testing.assert_array_equal(state.masses, [1.0, 1.0])
    assert state.species is state.lengths is None
