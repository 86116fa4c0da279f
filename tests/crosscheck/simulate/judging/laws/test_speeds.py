"""Maxwell's law on velocities that are drawn: right ones are green, deviations of the stated sensitivity are red."""

from __future__ import annotations

import numpy as np
import pytest
from gases import drawn, gas, trial

from crosscheck.scene import explicit
from crosscheck.simulate.judging.laws import all_laws
from crosscheck.verdict import findings

LAWS = {law.name: law for law in all_laws()}


def judged(name, scene, velocities):
    one = trial(scene, velocities)
    found = findings(LAWS[name].judge(one))
    return found.outcome, found


MIXED = gas(masses=tuple(1.0 + 3.0 * (k % 2) for k in range(64)), species=tuple(k % 2 for k in range(64)))


@pytest.mark.parametrize("scene", [gas(), gas(number=27, dimension=3), MIXED], ids=["disks", "spheres", "mixture"])
def test_right_velocities_are_green_and_known_well(scene):
    for name in ("speeds", "equipartition"):
        outcomes = [judged(name, scene, lambda attempt, k=k: drawn(scene, k + attempt)) for k in range(5)]
        assert [outcome for outcome, _ in outcomes] == ["pass"] * 5
        means = [one for one in outcomes[0][1].judgements if one.uncertainty is not None]
        assert max(one.sensitivity for one in means) < 0.12


def test_a_hot_axis_is_red():
    def hot(attempt):
        v = drawn(gas(), attempt)
        v[:, :, 0] *= 1.03
        return v

    outcome, found = judged("equipartition", gas(), hot)
    assert outcome == "fail"
    assert [one.outcome for one in found.judgements] == ["fail", "fail"]


def test_a_hot_species_is_red():
    def hot(attempt):
        v = drawn(MIXED, attempt)
        v[:, np.array(MIXED.species) == 1] *= 1.03
        return v

    _, found = judged("equipartition", MIXED, hot)
    assert [one.quantity for one in found.judgements if one.outcome == "fail"] == [
        f"kinetic energy of a velocity component of mass {mass}, over T/2" for mass in (1, 4)
    ]


def test_too_few_fast_particles_are_red():
    def cut(attempt):
        v = drawn(gas(), attempt)
        speed = np.linalg.norm(v, axis=2, keepdims=True)
        return v / np.where(speed > 2.5, speed / 2.5, 1.0)

    outcome, found = judged("speeds", gas(), cut)
    assert outcome == "fail"
    assert found.judgements[0].outcome == "fail"


def test_one_speed_is_red_in_both():
    def one(attempt):
        v = drawn(gas(), attempt)
        return v / np.linalg.norm(v, axis=2, keepdims=True)

    _, found = judged("speeds", gas(), one)
    assert [judgement.outcome for judgement in found.judgements] == ["fail", "fail"]


def test_a_start_with_a_flow_may_not_be_over():
    """Particles that begin in two streams: what is not Maxwell's may not be there yet."""
    scene = gas()
    state = scene.initial_state()
    streams = np.zeros_like(state.velocities)
    streams[:, 0] = np.where(state.positions[:, 1] > 6.0, 1.0, -1.0)
    flowing = scene.changed(initial=explicit(state.positions, streams))

    def slow(attempt):
        return drawn(scene, attempt) * 0.3 + streams

    outcome, found = judged("equipartition", flowing, slow)
    assert outcome == "inconclusive"
    assert "the velocities of the start are not those of equilibrium" in found.judgements[0].note
