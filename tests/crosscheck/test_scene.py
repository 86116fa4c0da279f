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
from scipy.spatial import cKDTree

from crosscheck.errors import UsageError
from crosscheck.scene import (
    Box,
    Explicit,
    Gravity,
    Kepler,
    Lattice,
    LennardJones,
    Method,
    Output,
    Scene,
    Spring,
    Wall,
    explicit,
    whole_steps,
)

positive = st.floats(1e-300, 1e300)
finite = st.floats(allow_nan=False, allow_infinity=False)


# -- there and back -------------------------------------------------------------------------------------


@st.composite
def scenes(draw: st.DrawFn) -> Scene:
    """Any valid scene."""
    dimension = draw(st.sampled_from([1, 2, 3]))
    kind = draw(st.sampled_from(["spring", "gravity"] + ["lennard_jones"] * (dimension > 1)))
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
    assert Scene.from_json(scene.to_json()) == scene
    path = tmp_path_factory.getbasetemp() / "scene.toml"
    path.write_text(scene.to_toml(), encoding="utf-8", newline="")
    again = Scene.load(path)
    assert again == scene
    assert again.to_toml() == scene.to_toml()
    assert scene.changed() == scene


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
        (SPRING, "cutoff", 1.0, "unknown key 'cutoff'; it belongs in [wall] or [lennard_jones]"),
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
        (SPRING, "spring", ..., "give exactly one of [spring], [lennard_jones], [gravity]; found none"),
        (SPRING, "gravity", {}, "[spring], [lennard_jones], [gravity]; found spring and gravity"),
        (SPRING, "initial.kind", ..., "'initial.kind' is missing: add it, one of explicit, lattice, kepler, file"),
        (SPRING, "initial.kind", "random", "initial.kind: Input should be one of explicit, lattice, kepler, file"),
        (SPRING, "initial.positions", [[1.0], [2.0, 3.0]], "initial.positions[1] has 2 components in dimension 1"),
        (SPRING, "initial.velocities", [[1.0]], "initial.velocities has 1 rows for 2 particles"),
        (SPRING, "initial.positions", [], "initial.positions is empty: give at least one particle"),
        (SPRING, "box", {"density": 1.0}, "[box] goes with [lennard_jones]"),
        (SPRING, "output.trajectory", True, "output.interval is missing: say how often to record"),
        (SPRING, "output", {"interval": 1.0, "observables": ["heat"]}, "output.observables.0: Input should be"),
        (SPRING, "method", {"scheme": "verlet", "dt": 0.0}, "method.dt: Input should be greater than 0 (found 0.0)"),
        (FLUID, "dimension", 1, "[lennard_jones] needs dimension 2 or 3"),
        (FLUID, "box.lengths", [5.0, 5.0], "box.lengths needs 3 entries, found 2"),
        (FLUID, "box.density", 1.0, "box: give exactly one of lengths and density"),
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
