"""What a scene does not have costs nothing: the loop that runs it, beside one that was written for it alone.

The general entry point compiles its loop for the features of a scene. Two copies of the sources tell what it should
have become: one without a trace of the absent features (`bare_sources`), compiled anew; and, for schemes that take time
steps, one whose step loop is velocity Verlet in place and nothing else, neither samples nor a failed step undone. Of
the first, the instructions of the compiled loop are compared; of both, the bits of the end, the operations, and time.
"""

from __future__ import annotations

import ast
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.events.gases import event_driven, spheres
from crosscheck.checks.lattice.gases import LATTICE, filled, gas_scene
from crosscheck.checks.operations import exactly
from crosscheck.checks.performance.bare_sources import copy_without
from crosscheck.checks.performance.compiled_code import compiled_code
from crosscheck.checks.performance.speeds import TURNS, Turn, alternated
from crosscheck.checks.performance.stepping_races import cloud
from crosscheck.checks.stepping.fluids import PERIODIC, STEP, fluid
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.workers.pool import Worker
from crosscheck.faults import Fault, sources
from crosscheck.scene import Contact, Gravity, Method, Output, Scene, Spring, explicit
from crosscheck.verdict import Judged, bounded, worst

#: Share by which the general entry point may be dearer than a kernel for one scene.
_MOST = 0.03
_WHY = "the goal: what is not used costs nothing, up to 3 %"
_STEP_LOOP, _EVENT_LOOP, _PLANES = (
    "stepping.integrate._advance",
    "events.kernels.loop.advance",
    "lattice.kernels.planes.advance",
)
#: The step loop of velocity Verlet alone, with the arguments of the general one.
_VERLET_ALONE = """
def _advance(scheme, force, state, dt, first, last, every, frames, thermo):
    r, v, memory = state
    r, v, a = r.copy(), v.copy(), memory[0]
    for number in range(first + 1, last + 1):
        for q in range(r.size):
            v[q] += 0.5 * dt * a[q]
            r[q] += dt * v[q]
        a = accelerate(force, r, v)
        outcome = status(force)
        if outcome != GOOD:
            return (r, v, (a,)), number, outcome
        for q in range(r.size):
            v[q] += 0.5 * dt * a[q]
    return (r, v, (a,)), last, GOOD
"""


class _Bare(NamedTuple):
    """A scene without a feature.

    size: of the scene for `scene`: of a run whose time counts. loop: that runs it, "module.function" below `refimpl`.
    absent: names of fields and arguments that are None where the scene has nothing that is not needed.
    """

    kind: str
    size: int
    loop: str
    method: Method
    absent: tuple[str, ...]


_VERLET = Method(scheme="velocity_verlet", dt=1e-5)
_SOFT = Method(scheme="velocity_verlet", dt=2e-4, contact=Contact(duration=0.01))
_BARE = {
    "spring": _Bare("spring", 1000, _STEP_LOOP, _VERLET, ("gamma", "thermo")),
    "gravity": _Bare("gravity", 1024, _STEP_LOOP, _VERLET, ("softening", "thermo")),
    "lennard-jones": _Bare(
        "lennard_jones",
        4000,
        _STEP_LOOP,
        STEP,
        (
            *("species", "species_epsilon", "species_sigma", "slot_size", "slot_strength", "mass", "masses", "walls"),
            *("shift_energy", "shift_force", "thermo"),
        ),
    ),
    "grains": _Bare("grains", 4000, _STEP_LOOP, _SOFT, ("inverse_inertias", "thermo")),
    "spheres": _Bare(
        "spheres",
        4000,
        _EVENT_LOOP,
        Method(scheme="event_driven"),
        (
            *("radii", "inverse_masses", "restitution", "rough", "acceleration", "well", "walls", "cylinder"),
            *("contact_duration", "seed", "spins", "bonds", "hits", "last", "tallies", "fields", "counts", "trace"),
        ),
    ),
    "fhp": _Bare("fhp", 512, _PLANES, Method(scheme="lattice_planes"), ("walls", "wall_draws", "push")),
}


def _scene(bare: _Bare, seed: int) -> Scene:
    """The scene, which takes some tenths of a second."""
    number, step = bare.size, bare.method.dt or 0.0
    if bare.kind == "lennard_jones":
        return fluid(number, 0.8442, 1.44, seed, duration=600 * step)
    if bare.kind == "grains":
        # as dense as grains that flow: packing 0.63
        return spheres(number, 1.2, seed % 2**31, duration=3000 * step)
    if bare.kind == "spheres":
        output = Output(collisions=(50 * number,), observables=("collisions",))
        return spheres(number, 0.5, seed % 2**31, duration=1e6, output=output)
    if bare.kind == "fhp":
        return gas_scene("fhp", "fhp1", number, number, 8000, filled(0.3, seed), Output(observables=("sites",)))
    if bare.kind == "gravity":
        return cloud(number, seed).changed(gravity=Gravity(), duration=400 * step)
    rng = np.random.default_rng(seed)
    return Scene(
        name=f"springs-{number}",
        dimension=3,
        duration=20_000 * step,
        spring=Spring(k=1.0),
        initial=explicit(rng.normal(size=(number, 3)), rng.normal(size=(number, 3))),
    )


@contextmanager
def _copies(laboratory: Laboratory, bare: _Bare, *names: str) -> Iterator[dict[str, Path]]:
    """Directories, by name, with copies of the sources that the engine under judgement runs.

    names: "general", as they are; "cut", without a trace of the features; "by hand", with a step loop of its own too.
    """
    original = sources(laboratory.pool.overlay)
    with ExitStack() as stack:
        found = {name: Path(stack.enter_context(tempfile.TemporaryDirectory())) for name in names}
        for name, directory in found.items():
            copy_without(original, directory, () if name == "general" else bare.absent)
        if "by hand" in found:
            _write_by_hand(found["by hand"] / "refimpl" / "stepping" / "integrate.py")
        yield found


def _write_by_hand(file: Path) -> None:
    """Puts the loop of velocity Verlet alone in the place of the step loop, with the decorators of that."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    loop = next(node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == "_advance")
    alone = ast.parse(_VERLET_ALONE).body[0]
    assert isinstance(alone, ast.FunctionDef)
    if ast.unparse(alone.args) != ast.unparse(loop.args):
        raise AssertionError(f"the step loop now takes ({ast.unparse(loop.args)}): write the one by hand anew")
    loop.body = alone.body
    file.write_text(ast.unparse(tree) + "\n", encoding="utf-8")


def _judge_code(laboratory: Laboratory, bare: _Bare) -> Judged:
    """Types of the loop's arguments; its instructions beside those without a trace of the features; bits, counts."""
    scene = _scene(bare, laboratory.seed())
    laboratory.demand(scene, bare.method)
    with _copies(laboratory, bare, "general", "cut") as copies:
        general, cut = (compiled_code(scene, bare.method, bare.loop, directory) for directory in copies.values())
    there = sorted(
        path for path, kind in general.fields.items() if kind != "none" and path.split(".")[-1] in bare.absent
    )
    known = {path.split(".")[-1] for path in general.fields}
    unknown = sorted(set(bare.absent) - known)
    judged = [
        exactly(f"features that the code has and the scene has not ({', '.join(there) or 'none'})", len(there), 0),
        exactly(
            f"features that no argument of the loop is named after ({', '.join(unknown) or 'none'})", len(unknown), 0
        ),
        bounded(
            "instructions of the loop beyond those of one without a trace of the features, relative",
            general.instructions / cut.instructions - 1,
            _MOST,
            _WHY,
            note=f"{general.instructions} instructions of LLVM, optimised; {cut.instructions}",
        ),
        exactly("states at the end that differ in a bit", general.digest != cut.digest, 0),
        exactly("counts of operations that differ", len(general.counts.items() ^ cut.counts.items()), 0),
    ]
    return worst(judged, f"{len(bare.absent)} absent features")


def _judge_time(laboratory: Laboratory, bare: _Bare) -> Judged:
    """CPU time of the loop over that of the copies: the least of each, which no other process has disturbed."""
    scene = _scene(bare, laboratory.seed())
    laboratory.demand(scene, bare.method)
    names = ("general", "cut", *(["by hand"] if bare.loop == _STEP_LOOP else ()))
    with _copies(laboratory, bare, *names) as copies, ExitStack() as stack:
        workers = {name: Worker(laboratory.engine, directory) for name, directory in copies.items()}
        for worker in workers.values():
            stack.callback(worker.close)
        ends = [worker.run(scene, bare.method) for worker in workers.values()]  # and all is compiled
        taken = alternated({name: partial(_run, worker, scene, bare.method) for name, worker in workers.items()})
    least = {name: min(turn.seconds for turn in turns) for name, turns in taken.items()}
    for turns in taken.values():
        laboratory.cost.add(turns[-1].cost)
    bits = [name for name in ("final_positions", "final_velocities", "sites") if name in ends[0]]
    other = sum(not np.array_equal(end[name], ends[0][name]) for end in ends[1:] for name in bits)
    judged = [exactly("states at the end that differ in a bit", other, 0)] + [
        bounded(
            f"CPU time beyond that of the loop {words}, relative",
            least["general"] / least[name] - 1,
            _MOST,
            f"{_WHY}; the least of {TURNS} alternated turns of each",
            note=", ".join(f"{one} {seconds:.4g} s" for one, seconds in least.items()),
        )
        for name, words in (("cut", "without a trace of the features"), ("by hand", "written by hand"))
        if name in least
    ]
    return worst(judged, f"{scene.name}: {least['general']:.3g} CPU s")


def _run(worker: Worker, scene: Scene, method: Method) -> Turn:
    cost = worker.run(scene, method).cost
    return Turn(cost.cpu, 1.0, cost)


_PROMISE = ("cut_to_the_scene",)
_NEEDS = {
    "spring": Needs("spring", words=frozenset({"dimension=3"}), schemes=(_VERLET.scheme,)),
    "gravity": Needs("gravity", words=frozenset({"dimension=3"}), schemes=(_VERLET.scheme,)),
    "lennard-jones": Needs("lennard_jones", words=PERIODIC, schemes=(STEP.scheme,)),
    "grains": Needs(
        "hard_spheres", words=frozenset({"dimension=3", "method.contact.duration"}), schemes=(_SOFT.scheme,)
    ),
    "spheres": event_driven("dimension=3 box.boundaries=periodic output.collisions", "collisions"),
    "fhp": Needs("lattice_gas", (LATTICE,), schemes=("lattice_planes",)),
}
_VARIANTS = tuple(
    Variant(name, bare, "full", needs=replace(_NEEDS[name], promises=_PROMISE)) for name, bare in _BARE.items()
)
_ALL_NEEDS = tuple(replace(needs, promises=_PROMISE) for needs in _NEEDS.values())
_CITATION = "Lam, Pitrou & Seibert, Proc. 2nd Workshop on the LLVM Compiler Infrastructure in HPC, 7 (2015)"

CHECKS = (
    Check(
        name="performance/pay-for-use",
        title="The compiled loop of a bare scene has no trace of the features that the scene has not",
        equation="instructions(general)/instructions(for the scene alone) - 1",
        criterion=f"no absent feature among the arguments; at most {_MOST:.0%} more instructions; same bits and counts",
        citation=_CITATION,
        judge=_judge_code,
        variants=_VARIANTS,
        faults=(
            (
                "gravity",
                Fault(
                    "always-softened",
                    "stepping/forces/gravity.py",
                    "        float(softening) if softening else None,\n",
                    "        float(softening or 0.0),\n",
                    "bodies without softening get one of 0, which is added to every distance",
                ),
            ),
            (
                "spheres",
                Fault(
                    "always-tallied",
                    "events/simulation.py",
                    "        if tallies or fields is not None:\n            faces",
                    "        if tallies or True:\n            faces",
                    "averages are taken that nobody asked for",
                ),
            ),
            (
                "fhp",
                Fault(
                    "always-pushed",
                    "lattice/bitplanes.py",
                    "        push = None\n",
                    "        push = Push(np.uint64(0), 1, self._packed(inside)[0], self.impulses)\n",
                    "a force of probability 0 is drawn for each site",
                ),
            ),
        ),
        needs=_ALL_NEEDS,
    ),
    Check(
        name="performance/pay-for-use-time",
        title="A bare scene through the general entry point, beside loops that are written for it alone",
        equation="CPU seconds(general)/CPU seconds(for the scene alone) - 1",
        criterion=f"at most {_MOST:.0%}, the least of {TURNS} alternated turns of each, compilation apart",
        citation=_CITATION,
        judge=_judge_time,
        variants=tuple(one for one in _VARIANTS if one.name != "spring"),  # a step is all that springs cost
        faults=(
            (
                "grains",
                Fault(
                    "energies-unasked",
                    "stepping/integrate.py",
                    "        if outcome != GOOD:\n            return (r, v, memory), number - 1, outcome\n",
                    "        if outcome != GOOD or kinetic_energy(force, v_new) < 0.0:\n"
                    "            return (r, v, memory), number - 1, outcome\n",
                    "the kinetic energy is computed after every step",
                ),
            ),
        ),
        needs=_ALL_NEEDS,
        timing=True,
    ),
)
