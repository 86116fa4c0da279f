"""`simulate --format`: every engine writes every format, with the numbers of its run, to the last bit."""

from importlib.util import find_spec

import ase.io
import gsd.hoomd
import numpy as np
import pytest
from hard_disks import disks
from trajectory_files import bits, dump_frames, side_by_side

from crosscheck.errors import UsageError
from crosscheck.scene import (
    Box,
    Contact,
    Explicit,
    GrainFriction,
    Gravity,
    HardSpheres,
    LennardJones,
    Method,
    Output,
    Scene,
    explicit,
)
from crosscheck.simulate.run import simulate
from crosscheck.trajectories.formats import formats


@pytest.fixture(autouse=True)
def plain(monkeypatch):
    """Workers run plain Python: that is enough for short runs, and nothing is compiled."""
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")


RECORD = Output(interval=0.25, trajectory=True)
VERLET = Method(scheme="velocity_verlet", dt=0.0625)
FLUID = Scene(
    name="two argon atoms",
    dimension=3,
    duration=0.5,
    masses=(1.0, 2.0),
    lennard_jones=LennardJones(cutoff=2.5, truncation="shifted"),
    box=Box(lengths=(6.0, 6.0, 6.0)),
    initial=explicit(np.array([[0.1, 0.2, 0.3], [1.3, 0.2, 5.9]]), np.array([[-1.0, 0.1, 0.0], [0.3, 0.0, 0.7]])),
    output=RECORD,
    method=VERLET,
)
PLANETS = Scene(
    name="two planets",
    dimension=2,
    duration=0.5,
    masses=(1.0, 3.0),
    gravity=Gravity(),
    initial=explicit(np.array([[1.0, 0.0], [-0.3, 0.1]]), np.array([[0.0, 1.0], [0.1, 0.1]])),
    output=RECORD,
    method=Method(scheme="ias15", dt=0.0625),
)
#: Two disks that roll over each other, in a box with a floor.
GRAINS = disks(
    duration=0.5,
    hard_spheres=HardSpheres(restitution=0.9, friction=GrainFriction(tangential_restitution=0.0)),
    box=Box(lengths=(6.0, 6.0), boundaries=("periodic", "hard")),
    initial=Explicit(
        positions=((1.0, 1.0), (2.1, 1.3)), velocities=((1.0, 0.0), (0.0, 0.2)), angular_velocities=((3.0,), (-1.0,))
    ),
    output=RECORD,
)
SOFT = Method(scheme="velocity_verlet", dt=1 / 1024, contact=Contact(stiffness=1e3))


@pytest.mark.parametrize(
    ("engine", "scene"),
    [
        ("refimpl", FLUID),
        ("refimpl", GRAINS.model_copy(update={"method": Method(scheme="event_driven")})),
        ("lammps", FLUID),
        ("lammps", GRAINS.model_copy(update={"method": SOFT})),
        ("ase", FLUID),
        ("rebound", PLANETS),
    ],
)
def test_every_engine_writes_every_format(tmp_path, engine, scene):
    if engine != "refimpl" and find_spec(engine) is None:
        pytest.skip(f"needs the package {engine}")
    (tmp_path / "scene.toml").write_text(scene.to_toml())
    done = simulate(tmp_path / "scene.toml", [engine], tmp_path / "out", formats=tuple(formats()))
    names = {path.name for path in done.paths if path.name.startswith(("trajectory", "arrays"))}
    suffixes = ("lammpsdump", "extxyz", "gsd")
    assert names == {f"arrays-{engine}.npz", *(f"trajectory-{engine}.{suffix}" for suffix in suffixes)}
    with np.load(tmp_path / "out" / f"arrays-{engine}.npz") as arrays:
        run = {name: arrays[name] for name in ("time", "positions", "velocities")}
        spins = arrays.get("angular_velocities")
    assert run["time"].tolist() == [0, 0.25, 0.5]
    assert np.ptp(run["positions"], axis=0).all()
    dump, extxyz, log = (tmp_path / "out" / f"trajectory-{engine}.{suffix}" for suffix in suffixes)
    frames, atoms = dump_frames(dump), ase.io.read(extxyz, ":")
    with gsd.hoomd.open(str(log)) as opened:
        logs = [frame.log for frame in opened]
    assert len(frames) == len(atoms) == len(logs) == 3
    for k, (frame, atom, logged) in enumerate(zip(frames, atoms, logs, strict=True)):
        step = 1 if scene.method.dt is None else round(0.25 / scene.method.dt)
        assert frame["step"] == k * step
        assert frame["v_time"][0] == atom.info["time"] == logged["time"][0] == run["time"][k]
        for name, columns in (("positions", ("xu", "yu", "zu")), ("velocities", ("vx", "vy", "vz"))):
            expected = bits(np.pad(run[name][k], ((0, 0), (0, 3 - scene.dimension))))
            assert bits(side_by_side(frame, *columns)) == expected
            assert bits(atom.arrays[name]) == expected
            assert bits(logged[f"particles/{name}"]) == expected
        masses = bits(np.broadcast_to(scene.masses, scene.number))
        assert bits(frame["mass"]) == bits(atom.arrays["masses"]) == bits(logged["particles/masses"]) == masses
        if spins is not None:
            assert spins.any()
            assert bits(frame["omegaz"]) == bits(spins[k, :, 0])
            assert bits(atom.arrays["angular_velocities"][:, 2]) == bits(spins[k, :, 0])
            assert bits(logged["particles/angular_velocities"][:, 2]) == bits(spins[k, :, 0])
            assert frame["radius"].tolist() == atom.arrays["radius"].tolist() == [0.5, 0.5]


def test_npz_is_the_file_of_all_arrays(tmp_path):
    """It is not written twice, and the default is not written beside it."""
    (tmp_path / "scene.toml").write_text(FLUID.to_toml())
    done = simulate(tmp_path / "scene.toml", ["refimpl"], tmp_path / "out", formats=("npz",))
    assert [path.name for path in done.paths if path.suffix in (".npz", ".extxyz")] == [
        "arrays-refimpl.npz",
        "restart-refimpl.npz",
    ]


def test_a_format_that_nobody_knows_is_refused_before_the_run(tmp_path):
    with pytest.raises(UsageError, match="--format pdb: unknown; take dump, extxyz, gsd, npz"):
        simulate("kepler", ["refimpl"], tmp_path / "out", formats=("pdb",))
    assert not (tmp_path / "out").exists()
