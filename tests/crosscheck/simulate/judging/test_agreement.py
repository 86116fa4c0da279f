"""Two runs of one scene: right ones agree within what dt and rounding explain, and others do not."""

from __future__ import annotations

import pytest
from judged import verdicts

from crosscheck.engines.workers.pool import Pool
from crosscheck.scene import (
    Box,
    Explicit,
    Face,
    Gravity,
    HardSpheres,
    Kepler,
    Lattice,
    LatticeGas,
    Obstacle,
    Occupations,
    Output,
    Scene,
)


@pytest.fixture(scope="module")
def pool():
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("NUMBA_DISABLE_JIT", "1")
        for law in ("audit", "equation_of_state", "speeds", "equipartition", "energy", "thermal_walls", "time_step"):
            patch.setattr(f"crosscheck.simulate.judging.laws.{law}.LAWS", ())
        patch.setattr("crosscheck.simulate.judging.equilibrium.WANTED", 60)
        workers = Pool()
        yield workers
        workers.close()


ORBIT = Scene(
    name="orbit",
    dimension=2,
    duration=4.0,
    gravity=Gravity(),
    masses=(1.0, 0.5),
    initial=Kepler(kind="kepler", eccentricity=0.3),
    output=Output(interval=0.5, observables=("kinetic_energy",)),
)
DISKS = Scene(
    name="disks",
    dimension=2,
    duration=20.0,
    hard_spheres=HardSpheres(),
    box=Box(lengths=(8.0, 8.0), boundaries=("hard", "periodic")),
    initial=Lattice(kind="lattice", structure="square", number=25, temperature=1.0, seed=3),
    output=Output(interval=0.25, observables=("kinetic_energy",)),
)
GAS = Scene(
    name="gas",
    dimension=2,
    duration=6.0,
    lattice_gas=LatticeGas(model="hpp", columns=12, rows=8),
    initial=Occupations(kind="occupations", density=0.3, seed=3),
    output=Output(interval=2.0, observables=("populations",), fields=(2, 2)),
)
#: An engine that runs another scene than it was asked to, by the scene's name: one worker runs them all.
OTHER = """
from crosscheck.engines.refimpl import RefimplEngine

CHANGES = {
    "G off by 1e-9": lambda scene: {"gravity": {"G": 1.0 + 1e-9}},
    "G off by 1e-3": lambda scene: {"gravity": {"G": 1.001}},
    "moved by 1e-11": lambda scene: {"initial": scene.initial.model_copy(update={"semi_major_axis": 1.0 + 1e-11})},
    "smaller disks": lambda scene: {"hard_spheres": {"diameter": 1.0 - 1e-9}},
    "hot walls": lambda scene: {
        "initial": scene.initial.model_copy(update={"temperature": 9.0}),
        "box": scene.box.model_copy(update={"faces": {"x-": {"temperature": 9.0}, "x+": {"temperature": 9.0}}}),
    },
    "another seed": lambda scene: {"initial": scene.initial.model_copy(update={"seed": 4})},
}

class Other(RefimplEngine):
    name = "other"
    run_from = None

    def run(self, scene, method):
        change = CHANGES.get(scene.name)
        return super().run(scene if change is None else scene.changed(**change(scene)), method)
"""


@pytest.fixture(scope="module")
def other(tmp_path_factory):
    file = tmp_path_factory.mktemp("engine") / "other.py"
    file.write_text(OTHER)
    return f"{file}:Other"


def agreement(pool, scene, engines, methods):
    (found,) = [one for one in verdicts(pool, scene, engines, methods).values() if one.variant == "agreement"]
    return found


LEAPFROG, VERLET = "refimpl:scheme=leapfrog,dt=0.015625", "refimpl:scheme=velocity_verlet,dt=0.03125"


def test_two_schemes_and_two_engines_agree_within_their_steps(pool):
    for engines, methods in (
        (["refimpl"], [LEAPFROG, VERLET]),
        (["refimpl", "rebound"], ["scheme=leapfrog,dt=0.03125"]),
    ):
        found = agreement(pool, ORBIT, engines, methods)
        assert found.outcome == "pass"
        assert 0 < found.findings.judgements[0].measured < 1
    assert found.engine == "refimpl - rebound"


def test_the_same_steps_agree_to_rounding_and_others_do_not(pool, other):
    methods = ["scheme=velocity_verlet,dt=0.03125"]
    (same,) = agreement(pool, ORBIT, ["refimpl", other], methods).findings.judgements
    assert same.outcome == "pass"
    assert "same bits: all " in same.note
    # a constant of gravity that is off by less than the time step's error
    (off,) = agreement(pool, ORBIT.changed(name="G off by 1e-9"), ["refimpl", other], methods).findings.judgements
    assert off.outcome == "fail"
    assert off.measured > 50
    assert "different dynamics, too early" in off.note
    # by so little a start may be disturbed, but not changed
    (moved,) = agreement(pool, ORBIT.changed(name="moved by 1e-11"), ["refimpl", other], methods).findings.judgements
    assert (moved.outcome, moved.quantity) == ("fail", "distance of the starts")


def test_other_steps_do_not_hide_another_force(pool, other):
    methods = [LEAPFROG, f"{other}:scheme=velocity_verlet,dt=0.03125"]
    assert agreement(pool, ORBIT.changed(name="G off by 1e-3"), ["refimpl", other], methods).outcome == "fail"


def test_event_driven_schemes_agree_to_rounding_until_chaos(pool, other):
    few = DISKS.initial.model_copy(update={"number": 9})  # too few for means
    short = DISKS.changed(duration=4.0, initial=few, box=Box(lengths=(5.0, 5.0), boundaries=("hard", "periodic")))
    found = agreement(
        pool, short, ["refimpl"], ["refimpl:scheme=event_driven", "refimpl:scheme=event_driven_lists"]
    )  # fmt: skip
    assert found.outcome == "pass"
    assert "same bits" in found.findings.shown.note
    found = agreement(pool, short.changed(name="smaller disks"), ["refimpl", other], ["scheme=event_driven"])
    assert found.findings.judgements[0].outcome == "fail"
    assert "different dynamics" in found.findings.judgements[0].note


def test_walls_that_draw_leave_means_alone(pool, other):
    walls = DISKS.box.model_copy(update={"faces": {"x-": Face(temperature=1.0), "x+": Face(temperature=1.0)}})
    scene = DISKS.changed(name="hot walls", box=walls)
    found = agreement(pool, scene, ["refimpl", other], ["scheme=event_driven"])
    assert found.outcome == "fail"
    assert all(one.quantity.startswith("mean of ") for one in found.findings.judgements)
    red = {one.quantity for one in found.findings.judgements if one.outcome == "fail"}
    assert red >= {"mean of rate of collisions", "mean of rate of collisional virial"}
    names = {one.quantity for one in found.findings.judgements}
    assert names - red <= {"mean of kinetic energy"}  # of what nothing dissipates, there is no mean


def test_lattice_gases_agree_bit_for_bit(pool, other):
    found = agreement(pool, GAS, ["refimpl"], ["refimpl:scheme=lattice_numpy", "refimpl:scheme=lattice_lookup"])
    assert found.outcome == "pass"
    plain = ["scheme=lattice_numpy"]
    assert agreement(pool, GAS.changed(name="another seed"), ["refimpl", other], plain).outcome == "fail"
    drawn = GAS.lattice_gas.model_copy(update={"model": "fhp1"})
    walls = GAS.lattice_gas.model_copy(update={"obstacles": (Obstacle(rows=(0, 0), rule="diffusive_y"),)})
    for one in (drawn, walls):
        assert "draws its own" in agreement(pool, GAS.changed(lattice_gas=one), ["refimpl", other], plain).message
    means = ["refimpl:scheme=lattice_numpy", "refimpl:scheme=lattice_boltzmann"]
    assert "on average alone" in agreement(pool, GAS, ["refimpl"], means).message


def test_soft_and_hard_spheres_are_not_compared(pool):
    pair = Scene(
        name="pair",
        dimension=2,
        duration=1.0,
        hard_spheres=HardSpheres(),
        initial=Explicit(positions=((0.0, 0.0), (1.2, 0.0)), velocities=((1.0, 0.0), (0.0, 0.0))),
        output=Output(interval=0.25, observables=("kinetic_energy",)),
    )
    soft = "refimpl:scheme=velocity_verlet,dt=0.001953125,contact.stiffness=1e3"
    found = agreement(pool, pair, ["refimpl"], ["refimpl:scheme=event_driven", soft])
    assert found.outcome == "skip"
    assert found.message.startswith("agreement: hard spheres beside soft ones, or other contacts: not compared")


def test_runs_to_a_tolerance_agree_with_runs_by_steps(pool) -> None:
    """Within what ten times the tolerance changes; a tolerance that is too loose explains itself, a wrong one not."""
    methods = ["refimpl:scheme=velocity_verlet,dt=0.001", "scipy:scheme=DOP853,tolerance=1e-9"]
    found = verdicts(pool, ORBIT, ("refimpl", "scipy"), methods)
    (agreement,) = (one for name, one in found.items() if name.startswith("agreement"))
    assert agreement.outcome == "pass"
    assert all(one.outcome in ("pass", "skip") for one in found.values())
