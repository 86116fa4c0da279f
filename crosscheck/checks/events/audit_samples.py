"""Few hard spheres, sampled densely: every event of engines that keep no trace, against the definitions."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, Variant
from crosscheck.checks.events.gases import event_driven
from crosscheck.engines.protocol import Run
from crosscheck.errors import UsageError
from crosscheck.faults import Fault
from crosscheck.references.event_audit import KINDS, SampledEvent, audit, reconstructed, with_trace
from crosscheck.scene import Box, Face, Floats, HardSpheres, Output, Scene, Well, explicit
from crosscheck.verdict import Judged, bounded, round_off, worst

#: Samples of a run: so many that two events of one particle between two of them are rare.
SAMPLES = 700
#: An interval in which they have is run again, so many times, each with so many samples; and so many such intervals.
FINER, SAMPLES_AGAIN, MOST_AGAIN = 3, 50, 20


class _Gas(NamedTuple):
    """Few spheres: dimension; sides of the box in contact ranges; number of them; duration; entries of the scene."""

    dimension: int
    sides: tuple[float, ...]
    number: int
    duration: float
    walls: bool = False
    spheres: HardSpheres = HardSpheres()
    unlike: bool = False
    acceleration: tuple[float, ...] | None = None


def _scene(gas: _Gas) -> Scene:
    """The gas at random places, at a temperature near 1, with one fast particle."""
    rng = np.random.default_rng(1)
    well = gas.spheres.well
    sides = np.array(gas.sides) * (1.0 if well is None else well.range)
    positions = _places(gas, sides, rng)
    velocities = rng.normal(size=positions.shape)
    velocities[0] *= 3.0  # goes round the box between two of its events
    species = tuple(range(gas.number)) if gas.unlike else None
    spheres = gas.spheres
    if gas.unlike:
        spheres = spheres.model_copy(update={"diameter": tuple(np.linspace(1.0, 0.5, gas.number).tolist())})
    walls = {"x-": Face(restitution=0.9), "x+": Face(restitution=0.8)}
    return Scene(
        name="few-spheres",
        dimension=gas.dimension,  # type: ignore[arg-type]
        duration=gas.duration,
        hard_spheres=spheres,
        box=Box(
            lengths=tuple(sides.tolist()),
            boundaries=("hard", *("periodic",) * (gas.dimension - 1)) if gas.walls else None,  # type: ignore[arg-type]
            faces=walls if gas.walls else None,
        ),
        acceleration=gas.acceleration,
        species=species,
        masses=tuple(np.linspace(1.0, 2.5, gas.number).tolist()) if gas.unlike else 1.0,
        initial=explicit(positions, velocities),
        output=Output(interval=gas.duration / SAMPLES, trajectory=True),
    )


def _places(gas: _Gas, sides: Floats, rng: np.random.Generator) -> Floats:
    """Positions without overlap of spheres of diameter 1, (N, d), inside walls."""
    while True:
        positions = rng.uniform(0.5, np.maximum(sides - 0.5, 0.51), (gas.number, gas.dimension))
        if not gas.walls:
            positions = rng.uniform(0.0, sides, positions.shape)
        gaps = positions[:, None] - positions
        gaps -= sides * np.round(gaps / sides)
        distances = np.sqrt((gaps**2).sum(axis=2)) + 9 * np.eye(gas.number)
        if distances.min() > 1.0:
            return np.asarray(positions)


def _judge(laboratory: Laboratory, gas: _Gas) -> Judged:
    """The run of a gas, whose events are where the paths from sample to sample meet."""
    scene = _scene(gas)
    run, events, unresolved = _traced(laboratory, scene, FINER)
    judgements: list[Judged] = [
        bounded(
            "intervals in which something happened that is no event",
            float(len(unresolved)),
            0.0,
            "paths are straight but for contacts: exact",
            note="; ".join(unresolved[:3]),
        )
    ]
    if not unresolved:
        found = audit(scene, with_trace(run, events))
        judgements += [
            round_off(f"{kind}: largest error, in its rounding", found.shares[kind], AMPLIFIED, f"{why}, {_MORE}",
                      note=found.where.get(kind, ""))
            for kind, why in KINDS.items()
        ]  # fmt: skip
        few = float(found.events < gas.number)
        judgements.append(bounded("runs with few events", few, 0.0, "what has no events judges nothing", control=True))
    return worst(judgements, f"{len(events)} events")


def _traced(laboratory: Laboratory, scene: Scene, finer: int) -> tuple[Run, list[SampledEvent], list[str]]:
    """A run, its events, and where there are some that no finer sampling shows as such.

    finer: how many times intervals with several events of a particle are run again, from their start, with more
    samples.
    """
    run = laboratory.run(scene, EVENT_DRIVEN)
    events, unresolved = reconstructed(scene, run)
    times = run["time"]
    if not finer:
        return run, events, [f"t = {times[k]:.6g} to {times[k + 1]:.6g}" for k in unresolved]
    left = []
    for k in unresolved[:MOST_AGAIN]:
        span = float(times[k + 1] - times[k])
        part = scene.changed(
            initial=explicit(run["positions"][k], run["velocities"][k]),
            duration=span,
            output=Output(interval=span / SAMPLES_AGAIN, trajectory=True),
        )
        wrong = _no_start(part)
        if wrong:
            left.append(f"t = {times[k]:.6g}: {wrong}")
            continue
        _, more, still = _traced(laboratory, part, finer - 1)
        events += [event._replace(time=event.time + float(times[k])) for event in more]
        left += [f"{where} after t = {times[k]:.6g}" for where in still]
    left += [f"t = {times[k]:.6g}" for k in unresolved[MOST_AGAIN:]]
    return run, events, left


def _no_start(scene: Scene) -> str:
    """Why the sample of an engine is no state that a run can begin from, as of spheres that overlap; "" if it is one.

    scene: that begins from the sample.
    """
    try:
        scene.initial_state()
    except UsageError as error:
        return str(error).rpartition(": ")[0]  # without what a user would do about it
    return ""


#: A path meets another where both are crossed: the time of the event is their distance over the change of velocity,
#: whose rounding is that of positions over that change, which may be small beside the velocities.
AMPLIFIED = 3.0
_MORE = "times 3 for the time of an event, which is read off two paths that may meet at a small angle"
_PERIODIC = "box.boundaries=periodic"


def _variant(name: str, gas: _Gas, words: str = "") -> Variant:
    needs = event_driven(f"dimension={gas.dimension} {_PERIODIC} {words}", "positions velocities")
    return Variant(name, gas, "quick", needs)


_WALLS = "box.boundaries=hard box.faces box.faces.restitution"
_VARIANTS = (
    _variant("small-2d", _Gas(2, (2.02, 2.3), 2, 20.0)),
    _variant("small-3d", _Gas(3, (2.02, 2.1, 2.2), 3, 4.0)),
    _variant("gas-2d", _Gas(2, (3.5, 4.0), 6, 6.0)),
    _variant("gas-3d", _Gas(3, (3.0, 3.5, 3.2), 8, 6.0)),
    _variant("walls", _Gas(3, (3.0, 2.5, 3.0), 6, 6.0, walls=True), _WALLS),
    _variant("inelastic", _Gas(3, (2.5, 2.6, 2.7), 6, 6.0, spheres=HardSpheres(restitution=0.8)),
             "hard_spheres.restitution"),
    _variant("unlike", _Gas(3, (2.5, 2.6, 2.7), 6, 8.0, unlike=True), "hard_spheres.diameter[] masses[]"),
    _variant("well", _Gas(3, (2.2, 2.3, 2.4), 5, 4.0, spheres=HardSpheres(well=Well(depth=0.8, range=1.4))),
             "hard_spheres.well"),
    _variant("gravity", _Gas(2, (3.5, 4.0), 6, 5.0, walls=True, acceleration=(-0.5, 0.2)), f"acceleration {_WALLS}"),
)  # fmt: skip

CHECKS = (
    Check(
        name="events/audit-samples",
        title="Every event of few spheres, from dense samples alone, against the definitions",
        equation="x0 + v0 t = x1 - v1 (dt - t) at an event; then as events/audit",
        criterion="each number to its rounding; nothing but events between samples",
        citation="Alder & Wainwright, J. Chem. Phys. 31, 459 (1959)",
        judge=_judge,
        variants=_VARIANTS,
        needs=event_driven(_PERIODIC, "positions velocities"),
        interpreted=True,
        faults=(
            (
                "unlike",
                Fault(
                    "strong-unlike-pairs",
                    "events/rules.py",
                    "return 1.0 / (inverse_masses[i] + inverse_masses[j])",
                    "return 1.000001 / (inverse_masses[i] + inverse_masses[j])",
                    "impulses of unlike particles are a millionth too large",
                ),
            ),
        ),
    ),
)
