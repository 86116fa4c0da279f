"""The audit's forces: derivatives of their own energy, and a plain double loop over pairs and images."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.references import EPSILON, kepler
from crosscheck.references.smooth_forces import accelerations, kinetic_energy, orbit, smooth
from crosscheck.scene import Box, Gravity, LennardJones, Scene, Spring, Wall, explicit

RNG = np.random.default_rng(5)
PLACES = np.array([[0.9, 1.1, 1.0], [2.1, 1.0, 1.2], [3.3, 1.3, 0.9], [1.4, 2.2, 1.9]]) + RNG.uniform(0, 0.1, (4, 3))
MASSES = (1.0, 0.3, 2.0, 5.0)
MIXTURE: dict[str, Any] = {"epsilon": (1.2, 0.7), "length": (1.05, 0.9)}


def scene_of(**entries: Any) -> Scene:
    given: dict[str, Any] = {
        "name": "audited",
        "dimension": 3,
        "duration": 0.0,
        "masses": MASSES,
        "initial": explicit(PLACES, np.zeros_like(PLACES)),
    }
    return Scene(**{**given, **entries})


def fluid(truncation: str, boundaries: tuple[str, ...], sides: tuple[float, ...], **entries: Any) -> Scene:
    wall = Wall(epsilon=0.6, sigma=0.8, cutoff=1.7) if "wall" in boundaries else None
    return scene_of(
        species=(0, 1, 1, 0),
        lennard_jones=LennardJones(cutoff=1.9, truncation=truncation, **MIXTURE, **entries),
        box=Box(lengths=sides, boundaries=boundaries, wall=wall),
    )


SCENES = {
    "spring": scene_of(spring=Spring(k=1.7)),
    "gravity": scene_of(gravity=Gravity(G=1.7)),
    "softened": scene_of(gravity=Gravity(G=0.6, softening=0.5)),
    "shifted": fluid("shifted", ("periodic",) * 3, (4.2, 4.0, 3.8), length_form="r_m"),
    "walls": fluid("force_shifted", ("periodic", "wall", "wall"), (4.2, 3.4, 3.1)),
    "short": fluid("truncated", ("periodic", "open", "periodic"), (4.2, 9.0, 1.3)),
}
each_scene = pytest.mark.parametrize("scene", SCENES.values(), ids=list(SCENES))


@each_scene
def test_forces_are_the_slope_of_the_energy(scene: Scene) -> None:
    """By central differences in long double, extrapolated twice: errors of 1e-12 of the largest force."""
    x, h = PLACES.astype(np.longdouble), np.longdouble(1e-4)
    forces = smooth(scene, x).forces
    for k in np.ndindex(*x.shape):

        def slope(m: int, k: tuple[int, ...] = k) -> Any:
            step = np.zeros_like(x)
            step[k] = m * h
            return (smooth(scene, x + step).energy - smooth(scene, x - step).energy) / (2 * m * h)

        one, two, four = slope(1), slope(2), slope(4)
        limit = (16 * (4 * one - two) / 3 - (4 * two - four) / 3) / 15
        assert abs(forces[k] + limit) < 1e-11 * abs(forces).max()


@pytest.mark.parametrize("name", ["spring", "gravity", "shifted", "short"])
def test_virial_is_the_slope_of_the_energy_in_the_scale(name: str) -> None:
    """W = -dU/d(ln scale) of coordinates and box: without walls, and without a softening, which is a length too."""
    scene = SCENES[name]

    def energy(scale: float) -> Any:
        box = scene.box
        if box is not None and box.lengths is not None:
            box = box.model_copy(update={"lengths": tuple(scale * side for side in box.lengths)})
        return smooth(scene.changed(box=box), scale * PLACES).energy

    h = 2.0**-13
    one, two = (energy(1 + h) - energy(1 - h)) / (2 * h), (energy(1 + 2 * h) - energy(1 - 2 * h)) / (4 * h)
    assert float(smooth(scene, PLACES).virial) == pytest.approx(-float((4 * one - two) / 3), rel=1e-8)


@each_scene
def test_doubles_stay_within_the_bounds(scene: Scene) -> None:
    exact, rounded = smooth(scene, PLACES), smooth(scene, PLACES, extended=False)
    assert (abs(exact.forces - rounded.forces) <= exact.forces_error[:, None]).all()
    assert abs(exact.energy - rounded.energy) <= exact.energy_error
    assert abs(exact.virial - rounded.virial) <= exact.virial_error
    assert exact.energy_error < 1e-10 * abs(exact.energy)


def phi(r: float, epsilon: float, sigma: float) -> float:
    return 4 * epsilon * ((sigma / r) ** 12 - (sigma / r) ** 6)


@given(cutoff=st.floats(1.0, 3.0), side=st.floats(0.9, 5.0))
def test_energy_is_that_of_a_double_loop_over_pairs_and_images(cutoff: float, side: float) -> None:
    scene = fluid("shifted", ("open", "periodic", "open"), (9.0, side, 9.0))
    scene = scene.changed(lennard_jones=LennardJones(cutoff=cutoff, truncation="shifted", **MIXTURE))
    total, size = 0.0, 0.0
    for i in range(4):
        for j in range(4):
            kinds = [scene.species[k] for k in (i, j)] if scene.species else []
            epsilon = float(np.sqrt(np.prod([MIXTURE["epsilon"][kind] for kind in kinds])))
            sigma = float(np.mean([MIXTURE["length"][kind] for kind in kinds]))
            for turn in range(-9, 10):
                r = float(np.linalg.norm(PLACES[i] - PLACES[j] - np.array([0.0, turn * side, 0.0])))
                if (i != j or turn) and r < cutoff:
                    total += 0.5 * (phi(r, epsilon, sigma) - phi(cutoff, epsilon, sigma))
                    size += epsilon * 4 * (sigma / r) ** 6 * (1 + (sigma / r) ** 6)
    assert float(smooth(scene, PLACES).energy) == pytest.approx(total, abs=1e-10 * size + 1e-300)


def test_bodies_without_mass_fall_as_others_do() -> None:
    scene = scene_of(gravity=Gravity(G=1.7, softening=0.2), masses=(1.0, 0.0, 2.0, 0.0))
    heavy = scene.changed(masses=(1.0, 1e-90, 2.0, 1e-90))
    found, expected = (accelerations(one, PLACES, np.zeros_like(PLACES)) for one in (scene, heavy))
    assert abs(found - expected).max() < 1e-15
    assert abs(smooth(scene, PLACES).forces[1]).max() == 0


def test_friction_slows_by_mass() -> None:
    scene = scene_of(spring=Spring(k=1.7, gamma=0.5))
    v = RNG.normal(size=PLACES.shape)
    found = accelerations(scene, PLACES, v)
    assert abs(found - (-1.7 * PLACES - 0.5 * v) / np.array(MASSES)[:, None]).max() < 1e-14


def test_kinetic_energy() -> None:
    value, bound = kinetic_energy(np.array([1.0, 3.0]), np.array([[1.0, 2.0], [-1.0, 0.5]]))
    assert value == 0.5 * 5 + 1.5 * 1.25
    assert 0 < bound < 20 * EPSILON * value


def test_orbit_of_two_bodies_is_keplers() -> None:
    masses, e = (3.0, 1.0), 0.3
    r, v = (part[0] for part in kepler.two_bodies(np.array([0.0]), masses, e, 2.0, 2.0))
    scene = Scene(name="two", dimension=2, duration=0.0, masses=masses, gravity=Gravity(G=2.0), initial=explicit(r, v))
    found = orbit(scene, 4.0)
    expected = kepler.two_bodies(np.array([4.0]), masses, e, 2.0, 2.0)
    for one, other in zip(found, expected, strict=True):
        assert abs(one - other[0]).max() < 1e-11
