"""Each engine with its own method: what may be written, which runs follow, an event-driven beside a stepping one."""

import json

import numpy as np
import pytest
from hard_disks import EVENTS, disks

from crosscheck.errors import UsageError
from crosscheck.scene import Box, Contact, Explicit, HardSpheres, Method, Output, Scene, Spring
from crosscheck.simulate.methods import Planned, planned
from crosscheck.simulate.run import simulate


@pytest.fixture
def plain(monkeypatch):
    """Workers run plain Python: that is enough for short runs, and nothing is compiled."""
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")


SPRING = Scene(
    name="two springs",
    dimension=2,
    duration=1.0,
    spring=Spring(k=1.0),
    initial=Explicit(positions=((1.0, 0.0), (0.0, 1.0))),
    output=Output(interval=0.25, observables=("kinetic_energy", "potential_energy"), trajectory=True),
    method=Method(scheme="velocity_verlet", dt=0.125),
)
BARE = SPRING.changed(method=None)


def runs(scene: Scene, engines: list[str], *texts: str) -> list[tuple[str, str, Method]]:
    return [(one.engine, one.label, one.method) for one in planned(scene, engines, texts)]


def test_an_engine_without_a_method_of_its_own_takes_the_scenes():
    found = runs(SPRING, ["refimpl", "rebound"], "rebound:scheme=whfast,dt=0.25")
    assert found == [
        ("refimpl", "refimpl", SPRING.method),
        ("rebound", "rebound", Method(scheme="whfast", dt=0.25)),
    ]


def test_a_run_knows_its_method_by_its_scene():
    (one,) = planned(BARE, ["refimpl"], ["scheme=verlet,dt=0.5"])
    assert one == Planned("refimpl", "refimpl", BARE.changed(method=one.method), Method(scheme="verlet", dt=0.5))


def test_a_method_of_all_and_one_of_one_engine():
    methods = [method for *_, method in runs(BARE, ["a.py:A", "refimpl"], "scheme=x,dt=1", "refimpl:scheme=y,dt=2e-3")]
    assert methods == [Method(scheme="x", dt=1.0), Method(scheme="y", dt=2e-3)]


def test_two_methods_of_one_engine_are_two_runs_named_by_what_tells_them_apart():
    texts = ("refimpl:scheme=event_driven", "refimpl:scheme=verlet,dt=1e-4", "refimpl:scheme=verlet,dt=0.002")
    assert [label for _, label, _ in runs(BARE, ["refimpl"], *texts)] == [
        "refimpl-event_driven", "refimpl-verlet-dt0.0001", "refimpl-verlet-dt0.002",
    ]  # fmt: skip
    long = [f"refimpl:scheme={'x' * 200},dt={dt}" for dt in (1, 2)]
    assert len({label for _, label, _ in runs(BARE, ["refimpl"], *long)}) == 2


def test_without_a_scheme_the_entries_change_the_scenes_method():
    soft = disks(method=Method(scheme="velocity_verlet", dt=1e-3, contact=Contact(stiffness=10.0)))
    assert runs(SPRING, ["refimpl"], "dt=0.0625")[0][2] == Method(scheme="velocity_verlet", dt=0.0625)
    assert runs(soft, ["refimpl"], "contact.stiffness=20")[0][2] == soft.method.model_copy(
        update={"contact": Contact(stiffness=20.0)}
    )
    new = runs(soft, ["refimpl"], 'scheme = event_driven , contact.law = "hertz", contact.stiffness=1e3, dt=1')[0][2]
    assert new == Method(scheme="event_driven", dt=1.0, contact=Contact(law="hertz", stiffness=1e3))


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        (["sheme=verlet,dt=1"], "--method sheme=verlet,dt=1: unknown key 'sheme'; did you mean 'scheme'?"),
        (["scheme=verlet,dt=-1"], "dt: Input should be greater than 0 (found -1)"),
        (["scheme=verlet,dt=soon"], "dt: Input should be a valid number (found 'soon')"),
        (["scheme=verlet,dt=nan"], "dt: Input should be a finite number"),
        (["scheme=verlet,contact.law=soft,contact.k_n=1"], "contact.law: Input should be 'hooke' or 'hertz'"),
        (["scheme=verlet,dt=1,dt=2"], "'dt' is there twice"),
        (["scheme=verlet,dt.x=1,dt=2"], "'dt' is there twice"),
        (["scheme=verlet,dt=1,dt.x=2"], "'dt' is a value and a table"),
        (["verlet"], "'verlet' is not key=value"),
        (["refimpl:"], "'' is not key=value"),
        (["scheme=verlet,"], "'' is not key=value"),
        (["lammps:scheme=verlet"], "engine lammps takes no part, only refimpl: add --engine lammps, or mend the name"),
        (["refimpl:scheme=a", "refimpl:scheme=a"], "refimpl has this method twice"),
        (["refimpl:scheme=a", "scheme=b"], "every engine has a method of its own"),
    ],
)
def test_what_is_not_understood_is_refused_in_one_line(texts, message):
    with pytest.raises(UsageError) as error:
        planned(BARE, ["refimpl"], texts)
    assert message in str(error.value)
    assert str(error.value).startswith("--method ")
    assert "\n" not in str(error.value)


def test_a_run_without_a_method_says_both_ways_to_give_it_one():
    with pytest.raises(UsageError, match=r"add \[method\] with .*, or give --method refimpl:scheme=euler,dt=0.0025"):
        planned(BARE, ["refimpl"])
    with pytest.raises(UsageError, match="once; for several methods of one engine, give --method refimpl:scheme="):
        planned(SPRING, ["refimpl", "refimpl"])


def test_an_engine_that_lacks_the_scenes_kind_of_scheme_is_told_which_it_has(tmp_path, plain):
    path = tmp_path / "scene.toml"
    path.write_text(disks(method=EVENTS).to_toml())
    with pytest.raises(UsageError) as error:
        simulate(path, ["refimpl", "rebound"], tmp_path / "out")
    (line,) = str(error.value).splitlines()
    assert line.startswith("rebound cannot run scene disks: no scheme 'event_driven'; it has ")
    assert line.endswith(": give it a method of its own, as --method rebound:scheme=collisions_direct,dt=0.01")
    assert not any((tmp_path / "out").iterdir())


BEADS = Scene(
    name="string-of-beads",
    dimension=3,
    duration=4.0,
    hard_spheres=HardSpheres(diameter=2.0),
    box=Box(lengths=(24.0, 24.0, 24.0)),
    initial=Explicit(
        positions=tuple((x, 12.0, 12.0) for x in (2.0, 5.5, 8.5, 12.5, 15.5, 19.0)),
        velocities=tuple((u, 0.0, 0.0) for u in (1.0, -0.4, 0.7, 0.0, -1.1, 0.3)),
    ),
    output=Output(interval=0.5, observables=("kinetic_energy", "collisions"), trajectory=True),
)


def test_an_event_driven_and_a_stepping_engine_in_one_simulation(tmp_path, plain):
    """A search for collisions after each step finds each of them late by at most a step."""
    path, dt = tmp_path / "scene.toml", 0.001
    path.write_text(BEADS.to_toml())
    texts = ["refimpl:scheme=event_driven", f"rebound:scheme=collisions_direct,dt={dt}"]
    done = simulate(path, ["refimpl", "rebound"], tmp_path / "out", methods=texts)
    assert done.whole
    assert [(one.engine, one.method) for one in done.rows] == [
        ("refimpl", "event_driven"), ("rebound", "collisions_direct, dt = 0.001"),
    ]  # fmt: skip
    (position,) = [one for one in done.differences if one.what == "position"]
    with (
        np.load(tmp_path / "out" / "arrays-refimpl.npz") as ours,
        np.load(tmp_path / "out" / "arrays-rebound.npz") as theirs,
    ):
        assert ours["time"].tolist() == theirs["time"].tolist()
        assert ours["collisions"][-1] == theirs["collisions"][-1] > 3
        late = ours["collisions"][-1] * dt * 2.1  # relative speeds are up to 2.1
        assert 0 < position.largest * 2.0 < late
        for run, method in ((ours, "event_driven"), (theirs, "collisions_direct")):
            about = json.loads(str(run["about"]))
            assert about["method"].startswith(method)
            assert about["scene"]["method"]["scheme"] == method
    picture = (tmp_path / "out" / "picture.svg").read_text()
    assert "refimpl: event_driven" in picture
    assert "rebound: collisions_direct, dt = 0.001" in picture


def test_two_methods_of_one_engine_and_a_restart_file_of_each(tmp_path, plain):
    path, out = tmp_path / "scene.toml", tmp_path / "out"
    path.write_text(SPRING.to_toml())
    done = simulate(path, ["refimpl"], out, methods=["refimpl:dt=0.125", "refimpl:dt=0.0625"])
    names = [f"refimpl-velocity_verlet-dt{dt}" for dt in ("0.125", "0.0625")]
    assert [one.engine for one in done.rows] == names
    assert all((out / f"{kind}-{name}.npz").is_file() for kind in ("arrays", "restart") for name in names)
    # the positions of velocity Verlet are off by t (dt^2/24) sin t of an amplitude of 1: three quarters of that
    (position,) = [one for one in done.differences if one.what == "position"]
    assert position.largest * 2**0.5 == pytest.approx(0.75 * 0.125**2 / 24 * np.sin(1.0), rel=0.02)
    second = simulate(
        path, ["refimpl"], tmp_path / "on", restart=out / f"restart-{names[1]}.npz", methods=["dt=0.0625"]
    )
    assert second.whole
    with pytest.raises(UsageError, match="alone"):
        simulate(
            path, ["refimpl"], tmp_path / "no", restart=out / f"restart-{names[1]}.npz",
            methods=["refimpl:dt=0.125", "refimpl:dt=0.0625"],
        )  # fmt: skip


def test_runs_that_record_nothing_are_compared_at_their_ends(tmp_path, plain):
    scene = BEADS.changed(output=Output(interval=0.5), duration=1.0)
    path = tmp_path / "scene.toml"
    path.write_text(scene.to_toml())
    texts = ["refimpl:scheme=event_driven", "rebound:scheme=collisions_direct,dt=0.01"]
    done = simulate(path, ["refimpl", "rebound"], tmp_path / "out", methods=texts)
    assert [one.what for one in done.differences] == ["position at the end"]
