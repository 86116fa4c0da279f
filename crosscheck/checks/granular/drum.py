"""Rough disks in a turning drum: angle of the heap, event-driven with the TC model and soft.

Literature: S. Luding and S. McNamara, Granular Matter 1, 113 (1998); J. Schaefer, S. Dippel and D. E. Wolf, J. Phys. I
France 6, 5 (1996).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full, soft
from crosscheck.checks.events.driven import run_whole, snapshot_figure
from crosscheck.checks.events.drum import DRUM_RADIUS, DRUM_SAMPLE, drum_scene, fall_angles, surface_angle
from crosscheck.checks.granular.driven import against, hard_limit, trajectory
from crosscheck.checks.granular.soft_grains import CONTACTS, REFERENCE, soft_needs
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, RoundFrame, Series
from crosscheck.scene import Friction, Output, Scene
from crosscheck.statistics import Mean, correlated_mean
from crosscheck.verdict import Judged, worst

#: Laws along the surfaces.
_Law = Literal["history", "dashpot"]
#: Contact times of soft grains, and the tangential laws that they are run with.
_DURATIONS = (0.04, 0.02)
#: Duration of these runs: their limit at t_c = 0 has an error several times that of a run.
_SOFT_DURATION = 600.0
_LAWS: tuple[_Law, ...] = ("history", "dashpot")
#: Contact times of the TC model, in the event-driven runs.
_TC_DURATIONS = (4e-4, 2e-4, 1e-4)
#: Samples of the start, which are left out.
_SKIP = round(15.0 / DRUM_SAMPLE)


def _drum(seed: int, contact: float | None, duration: float) -> Scene:
    """The drum of `events/drum`; contact: t_c of the TC model. The wall's alpha_t is one that a dashpot can have."""
    scene = drum_scene(seed, 1.0)
    assert scene.hard_spheres is not None
    assert scene.box is not None
    assert scene.box.cylinder is not None
    friction = Friction(tangential_restitution=0.01, static=0.8, sliding=0.8)
    cylinder = scene.box.cylinder.model_copy(update={"friction": friction})
    return scene.changed(
        duration=duration,
        hard_spheres=scene.hard_spheres.model_copy(update={"contact_duration": contact}),
        box=scene.box.model_copy(update={"cylinder": cylinder}),
        output=Output(interval=DRUM_SAMPLE, trajectory=True),
    )


class _Heap(NamedTuple):
    """Angles in degrees, of the centre of mass and of the surface; distance of the centre of mass from the axis."""

    angle: Mean
    lever: Mean
    surface: Mean


def _measured_drum(run: Run) -> _Heap:
    positions, _ = trajectory(run, _SKIP)
    middle = np.full(2, DRUM_RADIUS)
    return _Heap(
        correlated_mean(fall_angles(positions, middle)),
        correlated_mean(np.linalg.norm(positions.mean(axis=1) - middle, axis=1)),
        correlated_mean([surface_angle(x, middle, DRUM_RADIUS) for x in positions]),
    )


def between(one: Mean, other: Mean) -> tuple[Mean, float]:
    """The middle of two means, with the error of the one that is less certain, and half of their difference.

    one, other: the means, in one unit.
    """
    worse = max(one, other, key=lambda mean: mean.error)
    return worse._replace(value=0.5 * (one.value + other.value)), 0.5 * abs(one.value - other.value)


class _Runs(NamedTuple):
    """Soft runs by tangential law, at each t_c, and event-driven runs, at each t_c of the TC model."""

    soft: dict[_Law, list[Run]]
    event_driven: list[Run]


def _runs(laboratory: Laboratory) -> _Runs:
    runs = {
        law: [
            run_whole(
                laboratory,
                _drum(laboratory.seed(f"{law}-{part}"), None, _SOFT_DURATION),
                soft(duration=t_c, resolution=1 / 25, friction=law),
            )
            for part, t_c in enumerate(_DURATIONS)
        ]
        for law in _LAWS
    }
    event_runs = [
        run_whole(laboratory, _drum(laboratory.seed(f"tc-{part}"), t_c, 150.0), EVENT_DRIVEN, REFERENCE)
        for part, t_c in enumerate(_TC_DURATIONS)
    ]
    return _Runs(runs, event_runs)


def _figures(engine: str, runs: _Runs, angles: dict[_Law, list[Mean]], hard_angles: list[Mean]) -> tuple[Figure, ...]:
    frame = RoundFrame(DRUM_RADIUS, DRUM_RADIUS, DRUM_RADIUS)
    last, event_driven = runs.soft["history"][-1], runs.event_driven[-1]
    return (
        Figure(
            "Drum: angle of the centre of mass, soft",
            "t_c",
            "degrees",
            series=tuple(_ladder(f"{law}, {engine}", _DURATIONS, angles[law]) for law in _LAWS),
        ),
        Figure(
            "Drum: angle of the centre of mass, event-driven",
            "t_c of the TC model",
            "degrees",
            series=(_ladder("event-driven", _TC_DURATIONS, hard_angles),),
        ),
        snapshot_figure(
            f"Drum: soft grains, {engine}",
            last,
            frame,
            0.0,
            np.linalg.norm(last["final_velocities"], axis=1),
            "speed",
        ),
        snapshot_figure(
            "Drum: event-driven grains",
            event_driven,
            frame,
            0.0,
            np.linalg.norm(event_driven["final_velocities"], axis=1),
            "speed",
        ),
    )


def _judge_drum(laboratory: Laboratory, _: str) -> Judged:
    """Both tangential laws give an impact that sticks the same outcome, but differ in contacts that endure.

    A spring bears a force at rest, a dashpot does not; a contact within t_c of the TC model bears none either, but does
    not creep. So the limit of the TC model is asked to be between theirs.
    """
    runs = _runs(laboratory)
    heaps = {law: [_measured_drum(run) for run in runs.soft[law]] for law in _LAWS}
    hard = [_measured_drum(run) for run in runs.event_driven]
    angles = {law: [heap.angle for heap in heaps[law]] for law in _LAWS}
    limits = {law: hard_limit(_DURATIONS, angles[law]) for law in _LAWS}
    hard_angles = [heap.angle for heap in hard]
    hard_angle = hard_limit(_TC_DURATIONS, hard_angles)
    middle, apart = between(limits["history"], limits["dashpot"])
    judgements = [
        against(
            "angle of the centre of mass in degrees, between the two tangential laws",
            middle,
            hard_angle,
            0.3,
            "standard errors of correlated series, all taken to t_c = 0; off by half the difference of the two laws, "
            "under which lasting contacts slide differently",
            doubt=apart,
        )
    ]
    if laboratory.engine != REFERENCE:
        # two codes with the same law must agree within standard errors alone
        again = _drum(laboratory.seed("refimpl"), None, _SOFT_DURATION)
        twin = _measured_drum(
            run_whole(laboratory, again, soft(duration=_DURATIONS[0], resolution=1 / 25), REFERENCE)
        ).angle
        quantity = "angle of soft grains with tangential springs, beside refimpl's"
        judgements.append(against(quantity, angles["history"][0], twin, 0.08, "standard errors of correlated series"))
    note = "; ".join(
        [f"{law}: {_listed(_DURATIONS, heaps[law])}, limit {_pm(limits[law])}" for law in _LAWS]
        + [f"event-driven: {_listed(_TC_DURATIONS, hard)}"]
    )
    return worst(judgements, note, _figures(laboratory.engine, runs, angles, hard_angles))


def _pm(mean: Mean) -> str:
    return f"{mean.value:.2f} +- {mean.error:.2f}"


def _ladder(label: str, durations: Sequence[float], means: Sequence[Mean]) -> Series:
    """Means at several t_c, and the limit at 0."""
    every = [hard_limit(durations, means), *means]
    return Series(label, [0.0, *durations], [m.value for m in every], [m.error for m in every])


def _listed(durations: Sequence[float], heaps: Sequence[_Heap]) -> str:
    return ", ".join(
        f"{_pm(h.angle)} (surface {_pm(h.surface)}, {h.lever.value:.3f} from the axis) at t_c = {t:g}"
        for t, h in zip(durations, heaps, strict=True)
    )


CHECKS = (
    Check(
        name="granular/drum",
        title="Rough disks in a turning drum: angle of the heap, event-driven with the TC model and soft",
        equation="tan(angle) = x_cm/(-y_cm) in the limits t_c -> 0",
        criterion="standard errors; event-driven between soft grains with tangential springs and with dashpots",
        citation="S. Luding and S. McNamara, Granular Matter 1, 113 (1998); J. Schaefer, S. Dippel and D. E. Wolf, J. "
        "Phys. I France 6, 5 (1996)",
        judge=_judge_drum,
        variants=full("disks"),
        needs=soft_needs(
            "dimension=2 method.contact.duration method.contact.friction=history "
            "method.contact.friction=dashpot hard_spheres.restitution hard_spheres.friction "
            "acceleration box.cylinder box.cylinder.angular_velocity box.cylinder.friction",
            "positions velocities",
        ),
        faults=(
            (
                "disks",
                Fault(
                    "little-friction",
                    CONTACTS,
                    "limit = law[FRICTION] * abs(normal)",
                    "limit = 0.2 * law[FRICTION] * abs(normal)",
                    "Coulomb's limit is a fifth of what it should be",
                ),
            ),
        ),
    ),
)
