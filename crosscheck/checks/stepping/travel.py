"""Particles that stream through a periodic box, further and further from where they started."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant, schemes_with
from crosscheck.checks.stepping.audit import (
    Expected,
    Ledger,
    asking,
    audit_samples,
    audit_steps,
    has_recurrence,
    run_or_refuse,
)
from crosscheck.checks.stepping.faults import LOSS
from crosscheck.engines.capabilities import Needs, words
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.scene import Box, LennardJones, Method, Output, Scene, explicit
from crosscheck.verdict import Judged, round_off, worst

#: Steps of a run, from one sample to the next, and time step: long enough for an engine to bring coordinates back into
#: the box now and then.
STEPS, EVERY, DT = 1040, 208, 0.004
#: Length and speed of all numbers: sides of the box are shorter than 1.
_UNIT = 0.15
_SIDES = (4.3 * _UNIT, 5.1 * _UNIT)
#: Box sides that the particles are away at the start.
_AWAY = 4095
#: Schemes of the quick tier: their memory holds positions.
_QUICK = ("verlet", "gear5")


def _stream() -> Scene:
    """Two particles that circle about each other, and stream through the box in a run."""
    middle = _UNIT * np.array([4.2, 0.3]) + np.array([_AWAY, -_AWAY]) * _SIDES
    x = middle + _UNIT * np.array([[-0.55, 0.1], [0.6, -0.12]])
    v = _UNIT * np.array([[0.9, -0.3], [0.85, -0.55]])
    return Scene(
        name="stream",
        dimension=2,
        duration=STEPS * DT,
        lennard_jones=LennardJones(epsilon=_UNIT**2, length=_UNIT, cutoff=1.9 * _UNIT, truncation="force_shifted"),
        box=Box(lengths=_SIDES),
        initial=explicit(x, v),
    )


def _judge(laboratory: Laboratory, scheme: str) -> Judged:
    ledger = Ledger()
    scene = asking(laboratory.engine, _stream(), EVERY * DT)
    run = run_or_refuse(laboratory, ledger, scene, Method(scheme=scheme, dt=DT))
    if run is not None:
        audit_samples(ledger, scene, run, scene.name)
        audit_steps(ledger, Expected(scene, scheme, DT, STEPS), run, STEPS, EVERY, scene.name)
    return ledger.findings()


#: Free particles: time step, steps of a run and from one sample to the next, and the fastest one's path in a step. All
#: numbers are short in base two, so that paths have no rounding; 700 sides of the box are more than LAMMPS counts.
_FREE_DT, _FREE_STEPS, _FREE_EVERY, _PATH = 2.0**-8, 2800, 700, 2.0
_SIDE, _CUTOFF = 8.0, 3.0


def _free() -> Scene:
    """Particles on lines along each axis, half a side from each other: no force reaches so far; the last one rests."""
    x = np.array([[1.0, 1.0, 1.0], [3.0, 2.0, 5.0], [7.0, 5.0, 6.0], [3.0, 5.0, 1.0]])
    v = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]) * _PATH / _FREE_DT
    return Scene(
        name="free",
        dimension=3,
        duration=_FREE_STEPS * _FREE_DT,
        lennard_jones=LennardJones(cutoff=_CUTOFF),
        box=Box(lengths=(_SIDE,) * 3),
        initial=explicit(x, v),
        output=Output(interval=_FREE_EVERY * _FREE_DT, trajectory=True),
    )


def _judge_free(laboratory: Laboratory, value: None) -> Judged:
    scene = _free()
    run = laboratory.run(scene, Method(scheme="velocity_verlet", dt=_FREE_DT))
    state = scene.initial_state()
    expected = state.positions + run["time"][:, None, None] * state.velocities
    size = float(np.abs(expected).max())
    why = "no rounding, of numbers short in base two; one of the largest coordinate, where it is put together of parts"
    return worst(
        [
            round_off("places, off by", float(np.abs(run["positions"] - expected).max()), EPSILON * size, why),
            round_off(
                "velocities, off by",
                float(np.abs(run["velocities"] - state.velocities).max()),
                EPSILON * float(np.abs(state.velocities).max()),
                "no force acts: none but a rounding of other units",
            ),
        ],
        f"{size / _SIDE:.0f} sides of the box in {_FREE_STEPS} steps",
    )


CHECKS = (
    Check(
        name="stepping/many-boxes",
        title="Free particles that cross a periodic box hundreds of times in a run",
        equation="r(t) = r_0 + v t, unwrapped",
        criterion="to rounding, at the end and between",
        citation="Allen & Tildesley, Computer Simulation of Liquids (1987), section 1.5.3",
        judge=_judge_free,
        variants=(Variant("free", None),),
        faults=(("free", LOSS),),
        needs=Needs("lennard_jones", words=words(_free()), schemes=("velocity_verlet",), promises=("long_runs",)),
    ),
    Check(
        name="stepping/far-from-the-origin",
        title="Particles that stream through thousands of images of the box, against the recurrence of the scheme",
        equation="r_n, v_n by the recurrence of each scheme; U, W by sums over all pairs and images",
        criterion="each within bounds of rounding: of coordinates as large as the path, and of the recurrence",
        citation="Allen & Tildesley, Computer Simulation of Liquids (1987), section 1.5.3",
        judge=_judge,
        variants=schemes_with(
            lambda name, claims: has_recurrence(name), lambda name: "quick" if name in _QUICK else "full"
        ),
        faults=(
            (
                "verlet",
                Fault(
                    "verlet-left-behind",
                    "stepping/schemes.py",
                    "return (memory[0] + by,)",
                    "return memory",
                    "where positions are brought back into the box, those of the next step are not",
                ),
            ),
            (
                "gear5",
                Fault(
                    "turns-forgotten",
                    "stepping/integrate.py",
                    "        self.turns += turns\n",
                    "        self.turns = turns\n",
                    "how often a particle was brought back counts from the last time only",
                ),
            ),
        ),
        needs=Needs("lennard_jones", words=words(_stream())),
        interpreted=True,
    ),
)
