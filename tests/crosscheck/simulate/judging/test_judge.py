"""All laws on small scenes: right runs break none, each planted bug breaks those that it should."""

from __future__ import annotations

import re

import pytest
from judged import outcomes, verdicts, with_fault

from crosscheck.engines.workers.pool import Pool
from crosscheck.scene import (
    Box,
    Contact,
    Explicit,
    Face,
    Gravity,
    HardSpheres,
    Kepler,
    Lattice,
    LatticeGas,
    LennardJones,
    Method,
    Occupations,
    Output,
    Scene,
    Spring,
    Well,
)
from crosscheck.simulate.judging.judge import JUDGE_NOTHING, allowance, check_of
from crosscheck.simulate.judging.laws import all_laws


@pytest.fixture(autouse=True)
def plain(monkeypatch):
    """Workers run plain Python: nothing is compiled; and audits are short."""
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    monkeypatch.setattr("crosscheck.simulate.judging.audits.events.MOST_EVENTS", 60)
    monkeypatch.setattr("crosscheck.simulate.judging.audits.events._AUDITED", 50)
    monkeypatch.setattr("crosscheck.simulate.judging.equilibrium.WANTED", 60)
    monkeypatch.setattr("crosscheck.simulate.judging.laws.thermal_walls._HITS", 100.0)
    monkeypatch.setattr("crosscheck.simulate.judging.audits.steps._PAIRS", 2000)


@pytest.fixture(scope="module")
def pool():
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("NUMBA_DISABLE_JIT", "1")
        workers = Pool()
        yield workers
        workers.close()


ENERGIES = Output(interval=0.125, observables=("kinetic_energy", "potential_energy"))


def scene(name, **entries):
    return Scene(**({"name": name, "dimension": 2, "duration": 2.0, "output": ENERGIES} | entries))


ORBIT = scene(
    "orbit",
    duration=4.0,
    gravity=Gravity(),
    masses=(1.0, 0.5),
    initial=Kepler(kind="kepler", eccentricity=0.3),
    method=Method(scheme="leapfrog", dt=1 / 64),
)
SPRINGS = scene(
    "springs",
    spring=Spring(k=4.0),
    initial=Explicit(positions=((1.0, 0.0), (0.2, 0.7)), velocities=((0.0, 0.5), (0.3, 0.0))),
    method=Method(scheme="velocity_verlet", dt=1 / 64),
)
SPECIES = tuple(k % 2 for k in range(25))
MIXTURE = scene(
    "mixture",
    duration=6.0,
    hard_spheres=HardSpheres(diameter=(1.0, 0.6)),
    species=SPECIES,
    masses=tuple(1.0 + kind for kind in SPECIES),
    box=Box(lengths=(7.0, 7.0)),
    initial=Lattice(kind="lattice", structure="square", number=25, temperature=1.0, seed=2),
    output=Output(interval=0.5, observables=("collisions",)),
    method=Method(scheme="event_driven"),
)
WALLED = MIXTURE.changed(
    name="walled",
    hard_spheres=HardSpheres(),
    species=None,
    masses=1.0,
    box=Box(lengths=(8.0, 8.0), boundaries=("hard",) * 2),
)
THERMAL = WALLED.changed(
    name="thermal", box=Box(lengths=(8.0, 8.0), boundaries=("hard", "periodic"), faces={"x-": Face(temperature=1.0)})
)
CLUSTER = scene(
    "cluster",
    duration=1.0,
    lennard_jones=LennardJones(cutoff=2.0),
    initial=Explicit(positions=((0.0, 0.0), (1.1, 0.1), (0.5, 1.0)), velocities=((0.1, 0.2), (-0.2, 0.0), (0.1, -0.2))),
    method=Method(scheme="velocity_verlet", dt=1 / 128),
)
SOFT = scene(
    "soft",
    duration=1.0,
    hard_spheres=HardSpheres(restitution=0.8),
    initial=Explicit(positions=((0.0, 0.0), (1.2, 0.2)), velocities=((1.0, 0.0), (0.0, 0.0))),
    output=Output(interval=0.125, observables=("kinetic_energy",)),
    method=Method(scheme="velocity_verlet", dt=1 / 512, contact=Contact(stiffness=500.0)),
)
#: Coefficients of the contact's own, which dissipate, or not.
OWN = SOFT.changed(
    name="own",
    hard_spheres=HardSpheres(),
    method=Method(scheme="velocity_verlet", dt=1 / 512, contact=Contact(k_n=500.0, gamma_n=2.0)),
)
#: Collisions that follow each other within the contact duration are rare: no stretch that is audited has one by chance.
RARE = MIXTURE.changed(
    name="rare",
    duration=16.0,
    hard_spheres=HardSpheres(restitution=0.98, contact_duration=3e-3),
    species=None,
    masses=1.0,
)
GAS = scene(
    "gas",
    duration=8.0,
    lattice_gas=LatticeGas(model="fhp3", columns=20, rows=8, force=0.1),
    initial=Occupations(kind="occupations", density=0.3, seed=3),
    output=Output(interval=2.0, observables=("populations",)),
    method=Method(scheme="lattice_numpy"),
)
#: Each scene, and the laws that judge it.
RIGHT = {
    "orbit": (ORBIT, "angular-momentum audit energy momentum time-step"),
    "springs": (SPRINGS, "angular-momentum audit energy time-step"),
    "damped": (SPRINGS.changed(spring=Spring(k=4.0, gamma=0.5)), "audit energy time-step"),
    "mixture": (MIXTURE, "audit energy equation-of-state equipartition momentum overlap speeds"),
    "wells": (
        MIXTURE.changed(
            hard_spheres=HardSpheres(well=Well(depth=1.0, range=1.3)), species=None, masses=1.0, duration=1.5
        ),
        "audit energy equipartition momentum overlap speeds",
    ),
    "walled": (WALLED, "audit energy equipartition momentum overlap speeds virial-theorem"),
    "thermal": (THERMAL, "audit energy equipartition momentum overlap speeds thermal-walls"),
    "cluster": (CLUSTER, "angular-momentum audit energy momentum time-step"),
    "soft": (SOFT, "angular-momentum audit energy momentum time-step"),
    "own": (OWN, "angular-momentum audit energy momentum time-step"),
    "own, elastic": (
        OWN.changed(method=Method(scheme="velocity_verlet", dt=1 / 512, contact=Contact(k_n=500.0, gamma_n=0.0))),
        "angular-momentum audit energy momentum time-step",
    ),
    "rare": (RARE, "audit energy momentum overlap"),
    "gas": (GAS, "audit particles"),
    # rounding errors of mean occupations are no random walk
    "means": (
        GAS.changed(
            duration=40.0,
            lattice_gas=LatticeGas(model="fhp2", columns=64, rows=32, force=0.05),
            method=Method(scheme="lattice_boltzmann"),
        ),
        "audit particles",
    ),
}


@pytest.mark.parametrize("name", RIGHT)
def test_a_right_run_breaks_no_law(name, pool):
    one, laws = RIGHT[name]
    found = verdicts(pool, one)
    assert not outcomes(found, "fail", "error")
    judged = {law for law, verdict in found.items() if verdict.findings is not None}
    assert judged == {*laws.split(), *JUDGE_NOTHING}
    # few samples of few particles: what is statistical may be undecided, and nothing else
    assert set(outcomes(found, "inconclusive")) <= {"speeds", "equipartition", "equation-of-state", "thermal-walls"}
    for law, verdict in found.items():
        assert verdict.check == f"simulate/{one.name}"
        assert verdict.message.startswith(f"{law}: ") or not verdict.message


#: Of each bug: file, text, text in its place, scene, and a law that it breaks at least.
BUGS = {
    "a mass factor off by 1e-6": (
        "events/rules.py",
        "return 1.0 / (inverse_masses[i] + inverse_masses[j])",
        "return 1.000001 / (inverse_masses[i] + inverse_masses[j])",
        MIXTURE,
        {"audit", "energy"},
    ),
    "a wall that takes 1e-3 of the momentum": (
        "events/rules.py",
        "rows[i, 3 + axis] = inwards * ((1.0 + alpha) * own - alpha * v)",
        "rows[i, 3 + axis] = inwards * ((1.0 + alpha) * own - 0.999 * alpha * v)",
        WALLED,
        {"audit", "energy"},
    ),
    "pairs that collide too deep": (
        "events/kernels/loop.py",
        "        return splat(diameter)\n",
        "        return splat(0.99 * diameter)\n",
        WALLED,
        {"audit", "overlap"},
    ),
    "collisions that follow each other within the contact duration": (
        "events/rules.py",
        "return age < contact_duration",
        "return age < 0.0 * contact_duration",
        RARE,
        {"audit"},
    ),
    "a dashpot that drives": (
        "stepping/kernels/contacts.py",
        "delta - _damping(law[DAMPING], law, model, mass, scale) * approach",
        "delta + _damping(law[DAMPING], law, model, mass, scale) * approach",
        OWN,
        {"audit", "energy"},
    ),
    "a force with the wrong sign along y": (
        "stepping/forces/spring.py",
        "        return -(k / mass) * r\n",
        "        return -(k / mass) * r * np.array([1.0, -1.0] * (r.size // 2))\n",
        SPRINGS,
        {"audit", "energy"},
    ),
    "velocities that are lost": (
        "stepping/schemes.py",
        "        return r, add_to(v_half, 0.5 * dt, a), (a,)\n",
        "        return r, (1.0 - 1e-2 * dt) * add_to(v_half, 0.5 * dt, a), (a,)\n",
        CLUSTER,
        {"audit", "energy"},
    ),
    "a scheme of a lower order": (
        "stepping/schemes.py",
        "        v_half, r = kick_drift(r, v, memory[0], dt)\n",
        "        v_half, r = kick_drift(r, v, memory[0], dt)\n        r = r + 0.1 * dt * dt * memory[0]\n",
        SPRINGS,
        {"audit", "time-step"},
    ),
    "a particle that is lost": (
        "lattice/plain.py",
        "            self._sites = after\n",
        "            after[0, 0] = 0\n            self._sites = after\n",
        GAS,
        {"audit", "particles"},
    ),
}


@pytest.mark.parametrize("bug", BUGS)
def test_a_bug_breaks_the_laws_that_it_should(bug, tmp_path, monkeypatch):
    file, old, new, one, broken = BUGS[bug]
    asked = tuple(law for law in all_laws() if law.name in broken)
    monkeypatch.setattr("crosscheck.simulate.judging.judge.all_laws", lambda: asked)
    workers = with_fault(tmp_path, file, old, new)
    try:
        found = verdicts(workers, one)
    finally:
        workers.close()
    assert set(outcomes(found, "fail")) >= broken, outcomes(found, "fail", "inconclusive", "error")
    assert not outcomes(found, "error")


KICKED = """
from crosscheck.engines.refimpl import RefimplEngine

class Kicked(RefimplEngine):
    name = "kicked"
    run_from = None

    def run(self, scene, method):
        run = super().run(scene, method)
        for name in ("velocities", "final_velocities"):
            if name in run and scene.duration > 3:
                run[name] = run[name].copy()
                run[name][(slice(8, None), 0) if name == "velocities" else 0] += 1e-7
        return run
"""


def test_a_kick_in_mid_run_is_seen_by_what_is_conserved(tmp_path, pool):
    (tmp_path / "kicked.py").write_text(KICKED)
    found = verdicts(pool, ORBIT, [f"{tmp_path}/kicked.py:Kicked"])
    assert set(outcomes(found, "fail")) >= {"momentum", "angular-momentum"}


BEADS = scene(
    "beads",
    dimension=3,
    duration=4.0,
    hard_spheres=HardSpheres(diameter=2.0),
    box=Box(lengths=(12.0,) * 3),
    initial=Explicit(
        positions=((2.0, 6.0, 6.0), (5.0, 6.3, 6.0), (8.5, 6.0, 5.8)),
        velocities=((1.0, 0.0, 0.0), (-0.4, 0.1, 0.0), (-0.7, 0.0, 0.1)),
    ),
    output=Output(interval=0.5, observables=("kinetic_energy", "collisions")),
    method=Method(scheme="collisions_direct", dt=1 / 256),
)
HARDER = """
from crosscheck.engines.rebound.engine import ReboundEngine

class Harder(ReboundEngine):
    name = "harder"

    def run(self, scene, method):
        run = super().run(scene, method)
        for name in ("velocities", "final_velocities"):
            if name in run:
                changed = run[name] != scene.own_start().velocities
                run[name] = run[name] * (1 + 1e-9 * changed)
        return run
"""


def test_a_search_for_collisions_is_audited_from_sample_to_sample(tmp_path, pool):
    right = verdicts(pool, BEADS, ["rebound"])
    assert not outcomes(right, "fail", "error", "inconclusive")
    assert right["audit"].findings is not None
    (tmp_path / "harder.py").write_text(HARDER)
    assert "audit" in outcomes(verdicts(pool, BEADS, [f"{tmp_path}/harder.py:Harder"]), "fail")


# -- the judge itself --------------------------------------------------------------------------------------------------


def test_a_run_that_ends_early_is_red_and_judged_no_further(pool):
    one = WALLED.changed(
        name="row",
        duration=400.0,
        hard_spheres=HardSpheres(restitution=0.1),
        box=None,
        initial=Explicit(
            positions=tuple((1.1 * k, 0.0) for k in range(6)), velocities=tuple((-k * 0.1, 0.0) for k in range(6))
        ),
    )
    found = verdicts(pool, one)
    assert outcomes(found, "fail") == {"end": "runs that ended before their time, or fell apart"}
    assert "inelastic collapse" in found["end"].findings.note
    assert found["momentum"].message == "momentum: the run ended before its time"
    assert found["audit"].outcome == "pass"  # of all that happened until then


def test_pieces_for_the_audit_stay_short_where_events_crowd(pool):
    """A gas that cools: at its start events are far more frequent than on average."""
    cooling = MIXTURE.changed(duration=80.0, hard_spheres=HardSpheres(restitution=0.7), species=None, masses=1.0)
    found = verdicts(pool, cooling)["audit"]
    assert found.outcome == "pass"
    numbers = [int(number) for number in re.findall(r"(\d+) events", found.findings.note)]
    assert len(numbers) == 2
    assert 20 <= min(numbers) <= max(numbers) <= 120


def test_steps_of_half_a_particle_are_no_motion(pool):
    found = verdicts(pool, CLUSTER.changed(method=Method(scheme="velocity_verlet", dt=0.125), initial=Explicit(
        positions=((0.0, 0.0), (0.6, 0.0)))))  # fmt: skip
    assert "end" in outcomes(found, "fail")
    assert "in a time step" in found["energy"].message or "ended" in found["energy"].message


def test_laws_have_names_of_their_own_and_an_equation():
    names = [law.name for law in all_laws()]
    assert len(set(names)) == len(names) >= 12
    assert all(law.equation for law in all_laws())


def test_extra_runs_take_as_long_as_is_good_for_the_run():
    assert [allowance(cpu) for cpu in (0.1, 10.0, 60.0, 1000.0)] == [5.0, 20.0, 30.0, 250.0]


@pytest.mark.parametrize(("name", "check"), [("a b/c", "simulate/a-b-c"), ("//", "simulate/scene")])
def test_names_of_scenes_become_names_of_checks(name, check):
    assert check_of(SPRINGS.changed(name=name)) == check
