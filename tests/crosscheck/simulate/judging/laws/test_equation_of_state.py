"""Equations of state on series that are drawn about published values: right ones are green, others are red."""

from __future__ import annotations

import math

import numpy as np
import pytest
from gases import drawn, gas, trial

from crosscheck.scene import Box, HardSpheres, Lattice, LennardJones, Scene
from crosscheck.simulate.judging.laws import all_laws
from crosscheck.simulate.judging.laws.equation_of_state import _outside
from crosscheck.verdict import findings

(LAW,) = (law for law in all_laws() if law.name == "equation-of-state")

#: NIST Standard Reference Simulation Website, Lennard-Jones isotherms: T, density, energy a particle, pressure.
NIST = [(0.85, 0.78, -5.5386, 0.047924), (0.85, 0.82, -5.7947, 0.55355)]
CUTOFF = 3.0
#: NIST, hard spheres: density, p sigma^3/kT.
SPHERES = [(0.3, 0.590354), (0.5, 1.634467)]


def fluid(temperature: float, density: float) -> Scene:
    return Scene(
        name="fluid",
        dimension=3,
        duration=100.0,
        lennard_jones=LennardJones(cutoff=CUTOFF, epsilon=2.0, length=1.5),
        box=Box(lengths=((500 / density) ** (1 / 3) * 1.5,) * 3),
        initial=Lattice(kind="lattice", structure="fcc", number=500, temperature=2 * temperature, seed=1),
    )


def judged(scene: Scene, more: dict[str, np.ndarray]):
    """The law on velocities at constant energy, with other series of the run."""
    one = trial(scene, lambda attempt: drawn(scene, attempt, 200))
    for attempt in range(2):
        one.shared[f"equilibrium {attempt}"].run.update(more)
    return findings(LAW.judge(one))


def noise(size: float) -> np.ndarray:
    return size * np.random.default_rng(3).standard_normal(200)


@pytest.mark.parametrize(("temperature", "density", "energy", "pressure"), NIST)
@pytest.mark.parametrize(
    ("deviation", "outcome"),
    [
        ((0.0, 0.0), "pass"),
        ((0.12, 0.0), "fail"),
        ((-0.12, 0.0), "fail"),
        ((0.0, 0.15), "fail"),
        ((0.0, -0.15), "fail"),
    ],
)
def test_a_lennard_jones_fluid(temperature, density, energy, pressure, deviation, outcome):
    """epsilon = 2 and sigma = 1.5: what is compared has no units. Tails by hand, of g = 1 beyond the cutoff."""
    scene = fluid(temperature, density)
    nine, three = CUTOFF**-9 / 3, CUTOFF**-3
    tails = 8 / 3 * math.pi * density * (nine - three), 16 / 3 * math.pi * density**2 * (2 * nine - three)
    u, p = energy + deviation[0] - tails[0], pressure + deviation[1] - tails[1]
    volume = 500 / density
    kinetic = 3 * 499 / 2 * temperature  # of 500 particles without a common motion
    more = {
        "potential_energy": 2.0 * 500 * (u + noise(0.01)),
        "virial": 2.0 * (3 * volume * (p + noise(0.02)) - 2 * kinetic),
    }
    # the cutoff is in the unit of the scene
    scene = scene.changed(lennard_jones=scene.lennard_jones.model_copy(update={"cutoff": 1.5 * CUTOFF}))
    found = judged(scene, more)
    assert found.outcome == outcome, [(one.quantity, one.measured, one.expected) for one in found.judgements]
    assert len(found.judgements) == 2


@pytest.mark.parametrize(("density", "pressure"), SPHERES)
@pytest.mark.parametrize(("factor", "outcome"), [(1.0, "pass"), (1.03, "fail"), (0.97, "fail")])
def test_hard_spheres(density, pressure, factor, outcome):
    """Of 512 spheres: Z differs from that of many by less than 1e-2 of Z - 1."""
    number = 512
    scene = gas(number, 3, box=Box(lengths=((number / density) ** (1 / 3),) * 3), hard_spheres=HardSpheres())
    z = 1 + factor * (pressure / density - 1)
    growth = 3 * number * (number - 1) / number * (z - 1) * (1 + noise(0.01))
    found = judged(scene, {"collisional_virial": np.cumsum(0.25 * growth)})
    assert found.outcome == outcome, [(one.quantity, one.measured, one.expected) for one in found.judgements]


@pytest.mark.parametrize(
    ("temperature", "density", "text"),
    [
        (1.0, 0.028, None),
        (1.0, 0.031, "vapour and liquid part"),
        (1.0, 0.695, "vapour and liquid part"),
        (1.0, 0.705, None),
        (0.95, 0.72, "vapour and liquid part"),
        (0.95, 0.74, None),
        (1.4, 0.31, None),
        (0.67, 0.8, "temperatures from"),
        (6.1, 0.8, "temperatures from"),
        (1.0, 0.87, "density of 0.86"),
    ],
)
def test_states_of_which_nothing_is_known(temperature, density, text):
    found = _outside(temperature, density)
    assert found is None if text is None else text in (found or "")
