"""Event-driven programs of others that no registry offers: the scene written for them, run, and timed from outside.

Each is used where its binary is on PATH or named by an environment variable. The suite runs without any of them.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import NamedTuple

from crosscheck.errors import EngineError, EngineMissing
from crosscheck.scene import Floats


class Spheres(NamedTuple):
    """Spheres of diameter and mass 1 in a periodic cube.

    positions: (N, 3), length. velocities: (N, 3), length/time. side: of the cube, length. elasticity: coefficient of
    normal restitution. well: depth (energy) and range (contact distances) of square wells, or None.
    """

    positions: Floats
    velocities: Floats
    side: float
    elasticity: float = 1.0
    well: tuple[float, float] | None = None


class Stretch(NamedTuple):
    """A part of a run.

    events: that change velocities. cpu: time of the processor, s. time: that was simulated.
    """

    events: int
    cpu: float
    time: float


def binary(program: str, variable: str) -> str:
    """The path of a program; EngineMissing, with the way to name it, if there is none.

    program: its name on PATH. variable: environment variable that has its path.
    """
    named = os.environ.get(variable)
    found = shutil.which(named or program)
    if found is None:
        missing = f"{variable}={named} is no program" if named else f"no program {program} on PATH"
        raise EngineMissing(f"{missing}: name the peer's binary by the environment variable {variable}")
    return found


# -- EDMD, F. Smallenburg, Eur. Phys. J. E 45, 22 (2022): the program of its folder `Single` ------------------------

#: A line of its output, one a unit of time: time and number of collisions.
_LINE = re.compile(r"Simtime: ([\d.]+), Collisions: (\d+)")


def edmd_stretch(path: str, spheres: Spheres, settling: int, least: float) -> Stretch:
    """A stretch of a run of EDMD from these positions, whose velocities it draws itself at temperature 1.

    path: of its binary. spheres: where it starts. settling: collisions before the stretch. least: CPU time of the
    stretch, s, at least, unless the run, of 100 units of time, ends before. It begins and ends with a line of the
    program's output, which a pseudo-terminal hands on at once. EngineError if there are not two such lines;
    EngineMissing where the system does not tell the CPU time of a process.
    """
    import pty

    if not Path("/proc/self/stat").exists():
        raise EngineMissing("EDMD is timed by /proc, which this system does not have")
    with tempfile.TemporaryDirectory() as folder:
        rows = "".join(f"a {x!r} {y!r} {z!r} 0.5\n" for x, y, z in spheres.positions.tolist())
        size = f"{spheres.side!r} {spheres.side!r} {spheres.side!r}"
        Path(folder, "init.sph").write_text(f"{len(spheres.positions)}\n{size}\n{rows}", encoding="utf-8")
        ours, its = pty.openpty()
        process = subprocess.Popen([path], cwd=folder, stdin=subprocess.DEVNULL, stdout=its, stderr=its)
        os.close(its)
        seen: list[Stretch] = []
        try:
            with os.fdopen(ours, "r", encoding="utf-8", errors="replace") as lines:
                for line in lines:
                    match = _LINE.match(line)
                    if match is not None and int(match[2]) >= settling:
                        seen.append(Stretch(int(match[2]), _cpu(process.pid), float(match[1])))
                        if seen[-1].cpu - seen[0].cpu >= least:
                            break
        except OSError:  # the pseudo-terminal's end, where the program has ended
            pass
        finally:
            process.kill()
            process.wait()
    if len(seen) < 2:
        raise EngineError("EDMD ended before there was anything to time")
    first, last = seen[0], seen[-1]
    return Stretch(last.events - first.events, last.cpu - first.cpu, last.time - first.time)


def _cpu(process: int) -> float:
    """CPU time of a process so far, s."""
    text = Path(f"/proc/{process}/stat").read_text(encoding="utf-8")
    user, system = text.rsplit(")", 1)[1].split()[11:13]
    return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")


# -- DynamO, M. N. Bannerman, R. Sargant and L. Lue, J. Comput. Chem. 32, 3329 (2011): the program `dynarun` ---------


def dynamo_stretch(path: str, spheres: Spheres, events: int) -> Stretch:
    """The last `events` of a run of twice so many: what it takes longer than one of half the length, the same run.

    path: of its binary. spheres: where it starts. Its CPU time is that of runs without measurements; the simulated
    time is measured apart. EngineError if it fails.
    """
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "start.xml").write_text(_configuration(spheres), encoding="utf-8")
        half, whole = (_dynamo_cpu(path, folder, count, "-E") for count in (events, 2 * events))
        before, after = (_dynamo_time(path, folder, count) for count in (events, 2 * events))
    return Stretch(events, whole - half, after - before)


def _dynamo_cpu(path: str, folder: str, events: int, *options: str) -> float:
    """CPU time of a run of so many events, s."""
    before = os.times()
    arguments = [path, "start.xml", "-c", str(events), *options, "-o", "end.xml", "--out-data-file", "data.xml"]
    done = subprocess.run(arguments, cwd=folder, capture_output=True, text=True, check=False)
    after = os.times()
    if done.returncode != 0 or not Path(folder, "end.xml").exists():
        raise EngineError(f"dynarun ended with status {done.returncode}: {(done.stderr or done.stdout)[-300:]}")
    return after.children_user + after.children_system - before.children_user - before.children_system


def _dynamo_time(path: str, folder: str, events: int) -> float:
    """The time that a run of so many events simulates."""
    _dynamo_cpu(path, folder, events)
    duration = ElementTree.parse(Path(folder, "data.xml")).getroot().find("./Misc/Duration")
    if duration is None:
        raise EngineError("dynarun wrote no duration")
    return float(duration.get("Time", "nan"))


def _configuration(spheres: Spheres) -> str:
    """The scene as DynamO's own XML; its box is about the origin."""
    law = f'Type="HardSphere" Diameter="1" Elasticity="{spheres.elasticity!r}"'
    if spheres.well is not None:
        depth, reach = spheres.well
        law = f'Type="SquareWell" Diameter="1" Elasticity="1" Lambda="{reach!r}" WellDepth="{depth!r}"'
    side = spheres.side
    centred = spheres.positions - side * (spheres.positions // side) - 0.5 * side
    particles = "".join(
        f'<Pt ID="{i}"><P x="{x!r}" y="{y!r}" z="{z!r}"/><V x="{u!r}" y="{v!r}" z="{w!r}"/></Pt>\n'
        for i, ((x, y, z), (u, v, w)) in enumerate(zip(centred.tolist(), spheres.velocities.tolist(), strict=True))
    )
    return f"""<?xml version="1.0"?>
<DynamOconfig version="1.5.0">
<Simulation>
<Scheduler Type="NeighbourList"><Sorter Type="BoundedPQMinMax3"/></Scheduler>
<SimulationSize x="{side!r}" y="{side!r}" z="{side!r}"/>
<Genus><Species Mass="1" Name="Bulk" Type="Point"><IDRange Type="All"/></Species></Genus>
<BC Type="PBC"/>
<Topology/>
<Interactions><Interaction {law} Name="Bulk"><IDPairRange Type="All"/></Interaction></Interactions>
<Locals/>
<Globals/>
<SystemEvents/>
<Dynamics Type="Newtonian"/>
</Simulation>
<Properties/>
<ParticleData>
{particles}</ParticleData>
</DynamOconfig>
"""
