"""Scenes survive the way to TOML and JSON and back; every mistake in one is a single message with the key's path."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from hypothesis import given
from hypothesis import strategies as st
from scene_files import assert_survives_files
from scipy.spatial import cKDTree

from crosscheck.errors import UsageError
from crosscheck.scene import (
    TALLIES,
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
    explicit,
    whole_steps,
)

positive = st.floats(1e-300, 1e300)
finite = st.floats(allow_nan=False, allow_infinity=False)


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
    observables = [name for name in ("kinetic_energy", "potential_energy", *TALLIES) if name != "wall_torque" or drum]
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
        name=draw(st.text()),
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
        several = st.lists(positive, min_size=1, max_size=3).map(tuple)
        more["lennard_jones"] = LennardJones(
            cutoff=draw(positive),
            epsilon=draw(positive | several),
            length=draw(positive | several),
            length_form=draw(st.sampled_from(["sigma", "r_m"])),
            truncation=draw(st.sampled_from(["truncated", "shifted", "force_shifted"])),
            tail_corrections=draw(st.booleans()),
        )
        more["species"] = draw(st.none() | st.lists(st.integers(0, 3), min_size=number, max_size=number).map(tuple))
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
        name=draw(st.text()),
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


def test_a_scene_is_frozen() -> None:
    scene = Scene(name="a", dimension=1, duration=0.0, spring=Spring(k=1.0), initial=Explicit(positions=((1.0,),)))
    with pytest.raises(ValueError, match="frozen"):
        scene.duration = 2.0
    assert scene.changed(duration=2.0).duration == 2
    with pytest.raises(UsageError, match="duration: Input should be greater than or equal to 0"):
        scene.changed(duration=-2.0)


# -- mistakes -------------------------------------------------------------------------------------------

SPRING: dict[str, Any] = {
    "name": "a",
    "dimension": 1,
    "duration": 1.0,
    "spring": {"k": 1.0},
    "initial": {"kind": "explicit", "positions": [[1.0], [2.0]]},
}
FLUID: dict[str, Any] = {
    "name": "a",
    "dimension": 3,
    "duration": 1.0,
    "lennard_jones": {"cutoff": 2.5},
    "box": {"lengths": [5.0, 5.0, 5.0]},
    "initial": {"kind": "lattice", "structure": "fcc", "number": 4, "temperature": 1.0, "seed": 0},
}


def changed(table: dict[str, Any], path: str, value: Any) -> dict[str, Any]:
    """A copy with another value at `path`, or without the key, if the value is ..."""
    key, _, rest = path.partition(".")
    copy = dict(table)
    if rest:
        copy[key] = changed(copy.get(key, {}), rest, value)
    elif value is ...:
        del copy[key]
    else:
        copy[key] = value
    return copy


def load(tmp_path: Path, table: dict[str, Any]) -> Scene:
    path = tmp_path / "scene.toml"
    path.write_text(tomli_w.dumps(table))
    return Scene.load(path)


@pytest.mark.parametrize(
    ("table", "path", "value", "message"),
    [
        (SPRING, "durations", 1.0, "unknown key 'durations'; did you mean 'duration'?"),
        (SPRING, "spring.gama", 1.0, "unknown key 'spring.gama'; did you mean 'gamma'?"),
        (SPRING, "initial.velocity", [[1.0]], "unknown key 'initial.velocity'; did you mean 'velocities'?"),
        (SPRING, "cutoff", 1.0, "unknown key 'cutoff'; it belongs in [lennard_jones] or [box.wall]"),
        (SPRING, "output.acceleration", 1.0, "it belongs in the scene itself, above the first table"),
        (SPRING, "zzz", 1.0, "unknown key 'zzz'; remove it"),
        (SPRING, "duration", "long", "duration: Input should be a valid number (found 'long')"),
        (SPRING, "duration", True, "duration: Input should be a valid number (found True)"),
        (SPRING, "dimension", 4, "dimension: Input should be 1, 2 or 3 (found 4)"),
        (SPRING, "duration", math.nan, "duration: Input should be a finite number (found nan)"),
        (SPRING, "spring.k", math.inf, "spring.k: Input should be a finite number (found inf)"),
        (SPRING, "initial.positions", [[1.0], [math.nan]], "initial.positions.1.0: Input should be a finite number"),
        (SPRING, "masses", -1.0, "masses: Input should be greater than 0 (found -1.0)"),
        (SPRING, "masses", [1.0, -1.0], "masses.1: Input should be greater than or equal to 0 (found -1.0)"),
        (SPRING, "masses", "heavy", "masses: Input should be a valid number (found 'heavy')"),
        (SPRING, "masses", [1.0, 0.0], "masses: a particle without mass moves with [gravity] only"),
        (SPRING, "duration", ..., "'duration' is missing: add it"),
        (SPRING, "spring.k", ..., "'spring.k' is missing: add it"),
        (SPRING, "spring", ..., "[gravity], [hard_spheres], [lattice_gas]; found none"),
        (SPRING, "gravity", {}, "[hard_spheres], [lattice_gas]; found spring and gravity"),
        (SPRING, "initial.kind", ..., "'initial.kind' is missing: add it, one of explicit, lattice, kepler, file"),
        (SPRING, "initial.kind", "random", "initial.kind: Input should be one of explicit, lattice, kepler, file"),
        (SPRING, "initial.positions", [[1.0], [2.0, 3.0]], "initial.positions[1] has 2 components in dimension 1"),
        (SPRING, "initial.velocities", [[1.0]], "initial.velocities has 1 rows for 2 particles"),
        (SPRING, "initial.positions", [], "initial.positions is empty: give at least one particle"),
        (SPRING, "box", {"density": 1.0}, "[box] goes with [lennard_jones] or [hard_spheres]"),
        (SPRING, "output.trajectory", True, "output.interval is missing: say how often to record"),
        (SPRING, "output", {"interval": 1.0, "observables": ["heat"]}, "output.observables.0: Input should be"),
        (SPRING, "method", {"scheme": "verlet", "dt": 0.0}, "method.dt: Input should be greater than 0 (found 0.0)"),
        (FLUID, "dimension", 1, "[lennard_jones] needs dimension 2 or 3"),
        (FLUID, "box.lengths", [5.0, 5.0], "box.lengths needs 3 entries, found 2"),
        (FLUID, "box.density", 1.0, "box: give exactly one of lengths, density and packing_fraction"),
        (FLUID, "box.boundaries", ["wall"] * 3, 'box: a boundary "wall" and the table [box.wall] go together'),
        (FLUID, "box", ..., "initial.kind = 'lattice' fills a box: add [box]"),
        (FLUID, "lennard_jones.epsilon", [1.0, -1.0], "lennard_jones.epsilon.1: Input should be greater than 0"),
        (FLUID, "initial.structure", "hcp", "initial.structure: Input should be 'fcc', 'sc', 'square' or 'triangular'"),
        (FLUID, "initial.structre", "fcc", "unknown key 'initial.structre'; did you mean 'structure'?"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_message_with_its_path(
    tmp_path: Path, table: dict[str, Any], path: str, value: Any, message: str
) -> None:
    with pytest.raises(UsageError) as error:
        load(tmp_path, changed(table, path, value))
    (line,) = str(error.value).splitlines()
    assert line.startswith(f"{tmp_path / 'scene.toml'}: ")
    assert message in line


def test_a_misspelt_key_is_not_missing_as_well(tmp_path: Path) -> None:
    with pytest.raises(UsageError) as error:
        load(tmp_path, changed(changed(SPRING, "duration", ...), "durration", 1.0))
    assert str(error.value).endswith("unknown key 'durration'; did you mean 'duration'?")
    assert len(str(error.value).splitlines()) == 1


def test_two_mistakes_are_two_lines(tmp_path: Path) -> None:
    with pytest.raises(UsageError) as error:
        load(tmp_path, changed(changed(SPRING, "duration", -1.0), "masses", "x"))
    assert len(str(error.value).splitlines()) == 2


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


@pytest.mark.parametrize("text", ["", "{", "[1]", "null"])
def test_json_that_is_no_scene(text: str) -> None:
    with pytest.raises(UsageError, match=r"^scene: "):
        Scene.from_json(text)


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


# -- initial states --------------------------------------------------------------------------------------


def fluid(structure: str, number: int, **more: Any) -> Scene:
    dimension = 2 if structure in ("square", "triangular") else 3
    options = {"temperature": 1.5, "seed": 1, "density": 0.8} | more
    return Scene(
        name="fluid",
        dimension=dimension,
        duration=1.0,
        lennard_jones=LennardJones(cutoff=2.5),
        box=Box(density=options.pop("density")),
        initial=Lattice(kind="lattice", structure=structure, number=number, **options),
    )


def nearest(scene: Scene) -> float:
    state = scene.initial_state()
    distances, _ = cKDTree(state.positions, boxsize=state.lengths).query(state.positions, k=2)
    return float(distances[:, 1].min())


@pytest.mark.parametrize(
    ("structure", "number", "distance"),
    [
        ("fcc", 256, 2**0.5 / 2 * (4 / 0.8) ** (1 / 3)),
        ("sc", 216, 0.8 ** (-1 / 3)),
        ("square", 144, 0.8**-0.5),
        ("triangular", 360, None),
    ],
)
def test_lattices_are_the_ones_named(structure: str, number: int, distance: float | None) -> None:
    scene = fluid(structure, number)
    state = scene.initial_state()
    assert state.positions.shape == (number, scene.dimension)
    assert (state.positions >= 0).all()
    assert (state.positions < state.lengths).all()
    assert scene.volume() == pytest.approx(number / 0.8)
    if distance is not None:
        assert nearest(scene) == pytest.approx(distance)
    else:
        # nearly triangular in a square: within some per cent of the ideal distance
        assert nearest(scene) == pytest.approx((2 / 3**0.5 / 0.8) ** 0.5, rel=0.06)


@given(structure=st.sampled_from(["fcc", "sc", "square", "triangular"]), number=st.integers(1, 300))
def test_any_number_of_sites_keeps_apart(structure: str, number: int) -> None:
    scene = fluid(structure, number)
    state = scene.initial_state()
    assert state.positions.shape == (number, scene.dimension)
    if number > 1:
        assert nearest(scene) > 0.4 * (number / 0.8 / number) ** (1 / scene.dimension)


@given(number=st.integers(2, 200), seed=st.integers(0, 2**32), temperature=st.floats(1e-3, 10))
def test_velocities_are_maxwell_s_without_total_momentum(number: int, seed: int, temperature: float) -> None:
    masses = tuple(1.0 + i % 3 for i in range(number))
    scene = fluid("fcc", number, seed=seed, temperature=temperature).changed(masses=masses)
    state = scene.initial_state()
    m, v = state.masses[:, None], state.velocities
    np.testing.assert_allclose((m * v).sum(axis=0), 0, atol=1e-12 * abs(m * v).sum())
    assert 0.5 * (m * v**2).sum() == pytest.approx(1.5 * (number - 1) * temperature, rel=1e-12)
    again = scene.initial_state()
    np.testing.assert_array_equal(again.velocities, v)
    np.testing.assert_array_equal(again.positions, state.positions)


def test_velocities_follow_maxwell_s_distribution() -> None:
    from scipy.stats import kstest

    scene = fluid("fcc", 4000, temperature=2.0).changed(masses=4.0)
    assert kstest(scene.initial_state().velocities.ravel() / 0.5**0.5, "norm").pvalue > 1e-3


def test_seeds_differ_and_no_temperature_is_rest() -> None:
    one, two = (fluid("fcc", 32, seed=seed).initial_state().velocities for seed in (1, 2))
    assert not (one == two).any()
    assert not fluid("fcc", 32, temperature=0.0).initial_state().velocities.any()
    assert not fluid("fcc", 1).initial_state().velocities.any()


def test_a_lattice_of_another_dimension() -> None:
    scene = fluid("fcc", 32)
    wrong = scene.changed(initial=scene.initial.model_copy(update={"structure": "square"}))
    with pytest.raises(UsageError, match="'square' fills 2 dimensions, the scene has 3: take another structure"):
        wrong.initial_state()


@given(
    e=st.floats(0, 0.99),
    a=st.floats(0.1, 10),
    G=st.floats(0.1, 10),
    masses=st.tuples(st.floats(0, 5), st.floats(0.1, 5)),
    dimension=st.sampled_from([2, 3]),
)
def test_kepler_start_has_the_energy_and_angular_momentum_of_its_orbit(
    e: float, a: float, G: float, masses: tuple[float, float], dimension: int
) -> None:
    scene = Scene(
        name="orbit",
        dimension=dimension,
        duration=1.0,
        masses=masses,
        gravity=Gravity(G=G),
        initial=Kepler(kind="kepler", semi_major_axis=a, eccentricity=e),
    )
    state = scene.initial_state()
    r, v = state.positions[1] - state.positions[0], state.velocities[1] - state.velocities[0]
    total = G * sum(masses)
    assert 0.5 * v @ v - total / np.linalg.norm(r) == pytest.approx(-total / (2 * a), rel=1e-11)
    assert r[0] * v[1] - r[1] * v[0] == pytest.approx((total * a * (1 - e**2)) ** 0.5, rel=1e-12)
    assert np.linalg.norm(r) == pytest.approx(a * (1 + e))
    for vectors in (state.positions, state.velocities):
        np.testing.assert_allclose(state.masses @ vectors, 0, atol=1e-13 * abs(vectors).max() * sum(masses))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"gravity": None, "spring": Spring(k=1.0)}, r"'kepler' needs \[gravity\] and dimension 2 or 3"),
        ({"dimension": 1}, r"'kepler' needs \[gravity\] and dimension 2 or 3"),
        ({"masses": (0.0, 0.0)}, "one of the two bodies of initial.kind = 'kepler' needs a mass"),
        ({"masses": (1.0, 1.0, 1.0)}, "masses: 3 values for 2 particles; give one, or one per particle"),
        ({"species": (0,)}, "species: 1 values for 2 particles; give one per particle"),
    ],
)
def test_states_that_cannot_be(change: dict[str, Any], message: str) -> None:
    scene = Scene(
        name="orbit", dimension=2, duration=1.0, gravity=Gravity(), initial=Kepler(kind="kepler", eccentricity=0.1)
    )
    with pytest.raises(UsageError, match=message):
        scene.changed(**change).initial_state()


@pytest.mark.parametrize(
    ("positions", "lengths", "pair"),
    [
        ([[1.0, 1.0], [2.0, 2.0], [1.0, 1.0]], [5.0, 5.0], "0 and 2"),
        ([[1.0, 1.0], [2.0, 2.0], [2.0, 7.0]], [5.0, 5.0], "1 and 2"),
        ([[1.0, 0.0], [2.0, 2.0], [1.0, 5.0]], [5.0, 5.0], "0 and 2"),
        ([[-0.0, 1.0], [0.0, 1.0]], None, "0 and 1"),
    ],
)
def test_coincident_particles_are_named(positions: list[list[float]], lengths: list[float] | None, pair: str) -> None:
    scene = Scene(
        name="pair",
        dimension=2,
        duration=0.0,
        lennard_jones=LennardJones(cutoff=2.5),
        box=None if lengths is None else Box(lengths=tuple(lengths)),
        initial=explicit(np.array(positions), np.zeros((len(positions), 2))),
    )
    with pytest.raises(UsageError, match=f"particles {pair} are at the same place: move one of them"):
        scene.initial_state()


def test_springs_may_coincide_and_rest_by_default(tmp_path: Path) -> None:
    state = load(tmp_path, changed(SPRING, "initial.positions", [[1.0], [1.0]])).initial_state()
    np.testing.assert_array_equal(state.velocities, [[0.0], [0.0]])
    np.testing.assert_array_equal(state.masses, [1.0, 1.0])
    assert state.species is state.lengths is None


# -- configuration files ---------------------------------------------------------------------------------

POSITIONS = np.array([[0.1, 0.2, 0.3], [1.5, 1.6, 1.7]])
VELOCITIES = np.array([[1.0, 0.0, -0.25], [0.0, 2.0, 0.5]])


def from_file(tmp_path: Path, name: str, dimension: int = 3) -> Scene:
    table = changed(FLUID, "initial", {"kind": "file", "path": name})
    if dimension == 2:
        table = changed(changed(table, "dimension", 2), "box.lengths", [5.0, 5.0])
    return load(tmp_path, table)


@pytest.mark.parametrize("dimension", [2, 3])
def test_npz_configurations(tmp_path: Path, dimension: int) -> None:
    np.savez(tmp_path / "start.npz", positions=POSITIONS, velocities=VELOCITIES)
    state = from_file(tmp_path, "start.npz", dimension).initial_state()
    np.testing.assert_array_equal(state.positions, POSITIONS[:, :dimension])
    np.testing.assert_array_equal(state.velocities, VELOCITIES[:, :dimension])
    np.savez(tmp_path / "rest.npz", positions=POSITIONS)
    assert not from_file(tmp_path, "rest.npz").initial_state().velocities.any()


def test_xyz_configurations(tmp_path: Path) -> None:
    rows = "".join(f"X {x!r} {y!r} {z!r}\n" for x, y, z in POSITIONS.tolist())
    (tmp_path / "start.xyz").write_text(f"2\nProperties=species:S:1:pos:R:3\n{rows}")
    state = from_file(tmp_path, "start.xyz").initial_state()
    np.testing.assert_array_equal(state.positions, POSITIONS)
    assert not state.velocities.any()


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        (None, r"initial.path = .*start.npz: cannot be read as a configuration"),
        ({"velocities": POSITIONS}, r"cannot be read as a configuration .*positions"),
        ({"positions": np.full((2, 3), np.nan)}, "holds values that are not finite"),
        ({"positions": POSITIONS[:, :2]}, r"initial.positions\[0\] has 2 components in dimension 3"),
        ({"positions": POSITIONS[0]}, r"cannot be read as a configuration"),
        ({"positions": POSITIONS, "velocities": VELOCITIES[:1]}, "initial.velocities has 1 rows for 2 particles"),
    ],
)
def test_configurations_that_cannot_be_used(tmp_path: Path, arrays: dict[str, Any] | None, message: str) -> None:
    if arrays is not None:
        np.savez(tmp_path / "start.npz", **arrays)
    with pytest.raises(UsageError, match=message):
        from_file(tmp_path, "start.npz")


# -- hard spheres ------------------------------------------------------------------------------------------

DISKS: dict[str, Any] = {
    "name": "a",
    "dimension": 2,
    "duration": 1.0,
    "hard_spheres": {"diameter": 1.0},
    "box": {"lengths": [5.0, 5.0], "boundaries": ["periodic", "hard"]},
    "initial": {"kind": "explicit", "positions": [[1.0, 1.0], [3.0, 3.0]], "velocities": [[1.0, 0.0], [0.0, 0.0]]},
}
ROUGH = {"tangential_restitution": 0.5}
MIXTURE = changed(changed(DISKS, "hard_spheres.diameter", [1.0, 2.0]), "species", [0, 1])
TURNING = changed(DISKS, "hard_spheres.friction", ROUGH)
DRUM = changed(changed(DISKS, "box.boundaries", ["open", "open"]), "box.cylinder", {"radius": 2.5})


@pytest.mark.parametrize(
    ("table", "path", "value", "message"),
    [
        (DISKS, "hard_spheres.diameter", -1.0,
         "hard_spheres.diameter: Input should be greater than or equal to 0 (found -1.0)"),
        (DISKS, "hard_spheres.diameter", [1.0, -1.0],
         "hard_spheres.diameter.1: Input should be greater than or equal to 0"),
        (DISKS, "hard_spheres.diameter", [1.0, 2.0],
         "hard_spheres.diameter has 2 values, one per species: add species"),
        (MIXTURE, "species", [0, 2], "species 2 has no hard_spheres.diameter: there are 2 values"),
        (DISKS, "hard_spheres.restitution", 1.2,
         "hard_spheres.restitution: Input should be less than or equal to 1 (found 1.2)"),
        (DISKS, "hard_spheres.contact_duration", 0.0, "hard_spheres.contact_duration: Input should be greater than 0"),
        (DISKS, "hard_spheres.fixed", [1], "hard_spheres.fixed: there is no particle of species 1"),
        (MIXTURE, "hard_spheres.fixed", [0, 1], "hard_spheres.fixed: all particles are fixed, nothing moves"),
        (MIXTURE, "hard_spheres.fixd", [0], "unknown key 'hard_spheres.fixd'; did you mean 'fixed'?"),
        (TURNING, "hard_spheres.friction.tangential_restitution", -1.5,
         "tangential_restitution: Input should be greater than or equal to -1 (found -1.5)"),
        (TURNING, "hard_spheres.friction", ROUGH | {"static": 0.3, "sliding": 0.4},
         "hard_spheres.friction: sliding = 0.4 exceeds static = 0.3: make it smaller"),
        (TURNING, "hard_spheres.friction", ROUGH | {"static": 0.3}, "friction: static and sliding go together"),
        (TURNING, "hard_spheres.friction", ROUGH | {"inertia": 1.5},
         "inertia = 1.5 is more than that of a hollow grain, 1:"),
        (TURNING, "hard_spheres.friction", {}, "'hard_spheres.friction.tangential_restitution' is missing: add it"),
        (TURNING, "hard_spheres.diameter", 0.0, "hard_spheres: diameter = 0 with [hard_spheres.friction]"),
        (DISKS, "hard_spheres.well", {"depth": 1.0, "range": 1.0},
         "hard_spheres.well.range: Input should be greater than 1"),
        (DISKS, "acceleration", [1.0], "acceleration needs 2 components, found 1"),
        (changed(MIXTURE, "hard_spheres.fixed", [0]), "acceleration", [0.0, -1.0], "fixed particles do not fall"),
        (DISKS, "dimension", 1, "[hard_spheres] needs dimension 2 or 3"),
        (DISKS, "initial", {"kind": "kepler", "eccentricity": 0.0}, "initial.kind = 'kepler' needs [gravity]"),
        (DISKS, "initial.angular_velocities", [[1.0], [1.0]],
         "smooth grains do not rotate: add [hard_spheres.friction]"),
        (TURNING, "initial.angular_velocities", [[1.0, 0.0], [1.0, 0.0]],
         "initial.angular_velocities[0] has 2 components in dimension 2"),
        (DISKS, "box.boundaries", ["wall", "hard"], 'a boundary "wall" and the table [box.wall] go together'),
        (DISKS, "box", {"lengths": [5.0, 5.0], "boundaries": ["wall", "wall"], "wall": {"cutoff": 1.0}},
         'box.boundaries: a "wall" is for [lennard_jones]; that of hard spheres is called "hard"'),
        (DISKS, "box.faces", {"w-": {}}, 'box.faces."w-": there is no such face; the faces are x-, x+, y-, y+'),
        (DISKS, "box.faces", {"z-": {}}, 'box.faces."z-": there is no such face'),
        (DISKS, "box.faces", {"x-": {}}, 'box.faces."x-": box.boundaries says "periodic" along x: make it "hard"'),
        (DISKS, "box.faces", {"y-": {"velocity": 1.0, "temperature": 1.0}},
         "box.faces.y-: give at most one of velocity, random_phase, oscillation, temperature; found velocity and temp"),
        (DISKS, "box.faces", {"y-": {"open": True, "velocity": 1.0}},
         "box.faces.y-: open = true means that there is no wall"),
        (DISKS, "box.faces", {"y-": {"temperature": 1.0, "restitution": 0.5}}, "remove restitution and friction"),
        (DISKS, "box.faces", {"y-": {"restitution": 1.5}},
         "box.faces.y-.restitution: Input should be less than or equal to 1"),
        (DISKS, "box.faces", {"y-": {"velocity": -1.0}},
         "box.faces.y-.velocity: Input should be greater than or equal to 0"),
        (DISKS, "box.faces", {"y-": {"friction": ROUGH}}, 'box.faces."y-".friction: smooth grains do not rub on walls'),
        (TURNING, "box.faces", {"y-": {"friction": ROUGH | {"inertia": 1.0}}},
         "unknown key 'box.faces.y-.friction.inertia'; it belongs in [hard_spheres.friction]"),
        (DISKS, "box.faces", {"y-": {"restitutoin": 1.0}}, "'box.faces.y-.restitutoin'; did you mean 'restitution'?"),
        (DISKS, "box.faces", {"y-": {"temperature": 1.0}},
         "seed is missing: walls with temperature or random_phase draw"),
        (DISKS, "box.faces", {"y-": {"random_phase": {"speed": 1.0, "law": "normal"}}},
         "law: Input should be 'uniform' or 'flux'"),
        (DRUM, "box.cylinder.radius", -1.0, "box.cylinder.radius: Input should be greater than 0 (found -1.0)"),
        (DRUM, "box.cylinder.axis", "x", "box.cylinder.axis = 'x': in the plane it is a circle: remove axis"),
        (DRUM, "box.cylinder.angular_velocity", 1.0, "angular_velocity = 1: a smooth wall drags nothing: add friction"),
        (DRUM, "box.cylinder.friction", ROUGH, "box.cylinder.friction: smooth grains do not rub on walls"),
        (DRUM, "box.boundaries", ["open", "hard"],
         'box.boundaries: along y, across the cylinder, it must be "open", found "hard"'),
        (DISKS, "output.observables", ["virial"], "output.interval is missing"),
        (DISKS, "output", {"interval": 1.0, "observables": ["virial"]}, "hard spheres have no 'virial'"),
        (DISKS, "output", {"forces": True}, "output.forces: hard spheres exert impulses, not forces"),
        (DISKS, "output", {"interval": 1.0, "observables": ["rotational_energy"]},
         "'rotational_energy' needs [hard_spheres.friction]"),
        (DISKS, "output", {"interval": 1.0, "observables": ["wall_torque"]}, "'wall_torque' needs [box.cylinder]"),
        (DISKS, "output", {"interval": 1.0, "observables": ["heat"]}, "output.observables.0: Input should be"),
        (DISKS, "output", {"interval": 1.0, "collisions": [1]},
         "interval and collisions both say when to record: remove one"),
        (DISKS, "output", {"collisions": [2, 2]}, "output: collisions must increase: found 2 after 2"),
        (DISKS, "output", {"collisions": []}, "output: collisions is empty"),
        (DISKS, "output", {"collisions": [0]}, "output.collisions.0: Input should be greater than 0 (found 0)"),
        (DISKS, "output", {"fields": [4]}, "output.fields needs 2 entries, found 1"),
        (changed(DISKS, "box", ...), "output", {"fields": [4, 4]}, "output.fields divides a box into cells: add [box]"),
        (SPRING, "acceleration", [1.0], "acceleration goes with [hard_spheres] only"),
        (SPRING, "output", {"interval": 1.0, "observables": ["collisions"]},
         "'collisions' goes with [hard_spheres] only"),
        (FLUID, "box", {"packing_fraction": 0.4}, "box.packing_fraction goes with [hard_spheres] only"),
        (FLUID, "box.boundaries", ["hard"] * 3, 'a boundary "hard" goes with [hard_spheres] only'),
        (FLUID, "initial.speed", 1.0, "initial: give exactly one of temperature and speed"),
    ],
)  # fmt: skip
def test_a_mistake_about_hard_spheres(
    tmp_path: Path, table: dict[str, Any], path: str, value: Any, message: str
) -> None:
    test_a_mistake_is_one_message_with_its_path(tmp_path, table, path, value, message)


@pytest.mark.parametrize(
    ("table", "path", "value", "message"),
    [
        (DISKS, "box.lengths", [2.0, 5.0],
         "its length 2 along x, which is periodic, must exceed two contact ranges, 2:"),
        (changed(DISKS, "hard_spheres.well", {"depth": 1.0, "range": 2.5}), "box.lengths", [5.0, 9.0],
         "must exceed two contact ranges, 5"),
        (DISKS, "initial.positions", [[1.0, 1.0], [1.5, 1.0]],
         r"particles 0 and 1 overlap: their centres are 0.5 apart, and their contact distance is 1 \(gap -0.5\): move"),
        (DISKS, "initial.positions", [[0.2, 2.0], [4.8, 2.0]],
         "particles 0 and 1 overlap: their centres are 0.4 apart"),
        (DISKS, "initial.positions", [[1.0, 0.4], [3.0, 3.0]],
         "particle 0 is beyond the wall y- by 0.1: its centre must be at least 0.5 from y = 0; it is at 0.4"),
        (DISKS, "initial.positions", [[1.0, 1.0], [3.0, 7.0]], r"particle 1 is beyond the wall y\+ by 2.5"),
        (changed(DISKS, "box.faces", {"y-": {"oscillation": {"amplitude": 0.7, "frequency": 1.0}}}), "duration", 1.0,
         "particle 0 is beyond the wall y- by 0.2"),
        (DISKS, "box.faces", {"y-": {"oscillation": {"amplitude": 4.1, "frequency": 1.0}}},
         "box.faces: the walls that oscillate along y leave no room for the largest particle"),
        (DRUM, "initial.positions", [[2.5, 2.5], [2.5, 4.6]],
         "particle 1 is beyond the cylinder by 0.1: its centre must be within 2 of the axis; it is 2.1 away"),
        (DRUM, "box.cylinder.radius", 3.0, "box.cylinder.radius = 3 does not fit into the box: make box.lengths"),
        (changed(MIXTURE, "initial.positions", [[1.0, 1.0], [4.0, 3.0]]), "hard_spheres.fixed", [0],
         r"initial.velocities\[0\] is not zero: the particle is of a fixed species"),
        (MIXTURE, "species", [0], "species: 1 values for 2 particles"),
        (DISKS, "initial", {"kind": "lattice", "structure": "square", "number": 36, "speed": 1.0, "seed": 0},
         "overlap.*take fewer particles, smaller ones or a larger box"),
        (changed(DISKS, "box.lengths", [5.0, 0.9]), "initial",
         {"kind": "lattice", "structure": "square", "number": 4, "speed": 1.0, "seed": 0},
         "box: 0.9 along y is too narrow for a particle of diameter 1 between its walls"),
        (changed(DRUM, "box.cylinder.radius", 0.4), "initial",
         {"kind": "lattice", "structure": "square", "number": 1, "speed": 1.0, "seed": 0},
         "box.cylinder.radius = 0.4 must exceed that of the particles, 0.5"),
    ],
)  # fmt: skip
def test_hard_states_that_cannot_be(tmp_path: Path, table: dict[str, Any], path: str, value: Any, message: str) -> None:
    if path == "box.lengths" and "well" in table["hard_spheres"]:
        table = changed(table, "initial.positions", [[1.0, 1.0], [3.0, 5.0]])
    with pytest.raises(UsageError, match=message) as error:
        load(tmp_path, changed(table, path, value)).initial_state()
    assert len(str(error.value).splitlines()) == 1


def test_touching_is_no_overlap(tmp_path: Path) -> None:
    load(tmp_path, changed(DISKS, "initial.positions", [[1.0, 0.5], [2.0 - 1e-12, 0.5]])).initial_state()


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


def test_fixed_particles(tmp_path: Path) -> None:
    still = changed(changed(MIXTURE, "hard_spheres.fixed", [1]), "initial.positions", [[1.0, 1.0], [2.0, 2.8]])
    scene = load(tmp_path, still)
    np.testing.assert_array_equal(scene.fixed(), [False, True])
    scene.initial_state()
    assert not load(tmp_path, MIXTURE).fixed().any()
    # fixed ones may overlap each other
    still = changed(still, "initial.velocities", [[1.0, 0.0], [0.0, 0.0], [0.0, 0.0]])
    three = changed(changed(still, "species", [0, 1, 1]), "initial.positions", [[1.0, 0.6], [1.0, 3.0], [1.5, 3.5]])
    load(tmp_path, three).initial_state()


def test_faces_of_a_scene(tmp_path: Path) -> None:
    scene = load(tmp_path, changed(DISKS, "box.faces", {"y-": {"velocity": 1.0}}))
    assert scene.faces == (None, None, Face(velocity=1.0), Face())
    assert load(tmp_path, changed(DISKS, "box.faces", {"y+": {"open": True}})).faces == (None, None, Face(), None)
    assert load(tmp_path, changed(DISKS, "box", ...)).faces == (None,) * 4


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


def test_when_an_event_driven_run_is_recorded(tmp_path: Path) -> None:
    def times(**output: Any) -> list[float]:
        return load(tmp_path, changed(DISKS, "output", output)).samples().tolist()

    assert times() == [0, 1]
    assert times(interval=0.25) == [0, 0.25, 0.5, 0.75, 1]
    assert times(interval=0.4) == [0, 0.4, 0.8]
    assert times(interval=0.1)[-1] == 1
    np.testing.assert_array_equal(times(collisions=[3, 9]), [0, math.nan, math.nan])


@given(number=st.integers(1, 60), stroke=st.floats(0.01, 0.5), edge=st.floats(10, 20))
def test_a_lattice_between_hard_walls_keeps_surfaces_inside(number: int, stroke: float, edge: float) -> None:
    floor = Face(oscillation=Oscillation(amplitude=stroke, frequency=1.0))
    scene = Scene(
        name="box",
        dimension=2,
        duration=1.0,
        hard_spheres=HardSpheres(),
        box=Box(lengths=(edge, edge), boundaries=("hard", "hard"), faces={"y-": floor}),
        initial=Lattice(kind="lattice", structure="square", number=number, speed=2.0, seed=1),
    )
    state = scene.initial_state()
    assert (state.positions >= 0.5 - 1e-12).all()
    assert (state.positions <= edge - 0.5 + 1e-12).all()
    assert (state.positions[:, 1] >= 0.5 + stroke - 1e-12).all()
    np.testing.assert_allclose(np.linalg.norm(state.velocities, axis=1), 2.0, rtol=1e-14)


def test_the_densest_square_lattice_fits_between_walls() -> None:
    scene = Scene(
        name="box",
        dimension=2,
        duration=1.0,
        hard_spheres=HardSpheres(),
        box=Box(lengths=(10.0, 10.0), boundaries=("hard", "hard")),
        initial=Lattice(kind="lattice", structure="square", number=100, speed=1.0, seed=1),
    )
    x = np.unique(scene.initial_state().positions.round(12))
    np.testing.assert_allclose(x, np.arange(10) + 0.5, rtol=1e-12)


@pytest.mark.parametrize(("dimension", "structure"), [(2, "triangular"), (3, "fcc")])
def test_a_lattice_in_a_cylinder(dimension: int, structure: str) -> None:
    scene = Scene(
        name="drum",
        dimension=dimension,
        duration=1.0,
        hard_spheres=HardSpheres(),
        box=Box(
            lengths=(12.0,) * dimension,
            boundaries=("open", "open", "hard")[:dimension],
            cylinder=Cylinder(radius=5.5, axis="z" if dimension == 3 else None),
        ),
        initial=Lattice(kind="lattice", structure=structure, number=50, temperature=1.0, seed=1),
    )
    state = scene.initial_state()
    assert len(state.positions) == 50
    assert np.linalg.norm(state.positions[:, :2] - 6.0, axis=1).max() <= 5.0


def test_lattice_velocities_beside_fixed_particles() -> None:
    scene = Scene(
        name="mixture",
        dimension=2,
        duration=1.0,
        masses=2.0,
        species=(0, 1) * 50,
        hard_spheres=HardSpheres(diameter=0.5, fixed=(1,)),
        box=Box(lengths=(20.0, 20.0)),
        initial=Lattice(kind="lattice", structure="square", number=100, temperature=1.5, seed=1),
    )
    v = scene.initial_state().velocities
    assert not v[1::2].any()
    assert (v[::2] ** 2).sum() == pytest.approx(2 * 50 * 1.5 / 2.0)


def test_many_disks_are_checked_at_once() -> None:
    scene = Scene(
        name="many",
        dimension=2,
        duration=1.0,
        hard_spheres=HardSpheres(),
        box=Box(packing_fraction=0.5),
        initial=Lattice(kind="lattice", structure="square", number=200_000, temperature=1.0, seed=1),
    )
    assert len(scene.initial_state().positions) == 200_000  # all pairs would take hours


def test_files_may_hold_angular_velocities(tmp_path: Path) -> None:
    table = changed(TURNING, "initial", {"kind": "file", "path": "start.npz"})
    places = np.array([[1.0, 1.0], [3.0, 3.0]])
    np.savez(tmp_path / "start.npz", positions=places, angular_velocities=[[1.0], [2.0]])
    np.testing.assert_array_equal(load(tmp_path, table).initial_state().angular_velocities, [[1.0], [2.0]])
    for spins, message in (
        ([[math.nan], [2.0]], "angular_velocities holds values that are not finite"),
        ([1.0, 2.0], "angular_velocities needs two dimensions, found 1"),
        ([[1.0]], "initial.angular_velocities has 1 rows for 2 particles"),
    ):
        np.savez(tmp_path / "start.npz", positions=places, angular_velocities=spins)
        with pytest.raises(UsageError, match=message):
            load(tmp_path, table)


def test_a_time_step_is_asked_for() -> None:
    assert Method(scheme="verlet", dt=0.5).step == 0.5
    with pytest.raises(UsageError, match=r"method.dt is missing: scheme 'verlet' takes time steps: add dt"):
        _ = Method(scheme="verlet").step
