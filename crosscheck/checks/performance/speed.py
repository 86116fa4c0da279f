"""Speed of an engine beside its peer: the same scene, alternated, CPU seconds of the integration alone."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from crosscheck.checks.base import Check, Laboratory, fixed, legacy_check
from crosscheck.checks.stepping.lennard_jones import fluid
from crosscheck.faults import Fault
from crosscheck.scene import Gravity, Method, Scene, explicit
from crosscheck.verdict import Judged, bounded

#: Turns of each engine; the median ratio counts, so that a disturbed turn does not.
TURNS = 7


def _judge(laboratory: Laboratory, scene: Scene, method: Method, peer: str, goal: float) -> Judged:
    rates: dict[str, list[float]] = {laboratory.engine: [], peer: []}
    for turn in range(TURNS + 1):
        for engine, found in rates.items():
            cost = laboratory.run(scene, method, engine=engine).cost
            if turn:  # the first turn warms caches
                found.append(scene.number * cost.steps / cost.cpu)
    ratios = np.array(rates[laboratory.engine]) / np.array(rates[peer])
    ours, theirs = (float(np.median(found)) for found in rates.values())
    return bounded(
        f"particle steps per CPU second, ratio to {peer}",
        float(np.median(ratios)),
        goal,
        f"the goal; median of {TURNS} alternated turns, of {ratios.min():.2f} ... {ratios.max():.2f}",
        at_least=True,
        note=f"{laboratory.engine} {ours:.3g}, {peer} {theirs:.3g} particle steps per CPU second",
    )


def _judge_lennard_jones(laboratory: Laboratory, variant: str) -> Judged:
    """The melt of LAMMPS' own benchmark, lists rebuilt by displacement on both sides."""
    number = int(variant.removeprefix("N"))
    method = Method(scheme="velocity_verlet", dt=0.005)
    melt = fluid(number, 0.8442, 1.44, laboratory.seed(), duration=1.0)
    start = laboratory.run(melt, method, engine="refimpl")
    steps = 800_000 // number
    scene = melt.changed(
        initial=explicit(start["final_positions"], start["final_velocities"]), duration=steps * method.step
    )
    return _judge(laboratory, scene, method, "lammps", 1.5)


def _judge_gravity(laboratory: Laboratory, variant: str) -> Judged:
    """A softened cloud at rest, leap-frog on both sides: one evaluation of all pairs a step."""
    number = int(variant.removeprefix("N"))
    positions = np.random.default_rng(laboratory.seed()).normal(size=(number, 3))
    method = Method(scheme="leapfrog", dt=1e-4)
    scene = Scene(
        name=f"cloud-{number}",
        dimension=3,
        duration=max(4, 40_000_000 // number**2) * method.step,
        masses=1.0 / number,
        gravity=Gravity(softening=0.01),
        initial=explicit(positions, np.zeros_like(positions)),
    )
    return _judge(laboratory, scene, method, "rebound", 4.0)


def _check(
    name: str,
    title: str,
    judge: Callable[[Laboratory, str], Judged],
    variants: tuple[str, ...],
    goal: str,
    fault: Fault,
) -> Check:
    return legacy_check(
        name=f"performance/{name}",
        title=title,
        equation="particles x steps / CPU seconds",
        criterion=f"{goal}, median of {TURNS} alternated turns, one thread, compilation apart",
        citation="Thompson et al., Comput. Phys. Commun. 271, 108171 (2022); Rein & Liu, A&A 537, A128 (2012)",
        judge=judge,
        variants=fixed(*variants),
        faults=((variants[0], fault),),
        tier="full",
        timing=True,
    )


CHECKS = (
    _check(
        "lennard-jones-speed",
        "Lennard-Jones at rho = 0.8442, cutoff 2.5: speed beside LAMMPS lj/cut/opt",
        _judge_lennard_jones,
        ("N4000", "N32000"),
        "at least 1.5 times LAMMPS",
        Fault(
            "no-skin",
            "stepping/forces/lennard_jones.py",
            "SKIN = 0.8",
            "SKIN = 0.0001",
            "the lists have no skin to speak of: they are built at every step",
        ),
    ),
    _check(
        "gravity-speed",
        "Gravity between all pairs: speed beside REBOUND's basic gravity",
        _judge_gravity,
        ("N1024", "N4096"),
        "at least 4 times REBOUND",
        Fault(
            "plain-gravity",
            "stepping/forces/gravity.py",
            "if mass.size <= FEW_BODIES:",
            "if mass.size <= 1_000_000:",
            "the plain loop is taken for any number of bodies",
        ),
    ),
)
