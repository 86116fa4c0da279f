"""Few spheres, far apart: contacts are found from any distance, in every image, and at the contact distance.

A flight of 1e6 diameters ends at the other sphere's surface or misses it by less than 1e-9 of them: positions must not
be squared before they are subtracted. Energy and collision rates of a gas do not show it, its contact distances do.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TypeAlias

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, Variant, quick
from crosscheck.checks.events.gases import event_driven, spheres
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Claims, Run
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.references.first_impact import Impact, after_impact, first_impact
from crosscheck.scene import Box, Explicit, Floats, Method, Observable, Output, Scene
from crosscheck.verdict import Judged, Judgement, bounded, round_off, worst

_RECORD: tuple[Observable, ...] = ("collisions", "collisional_virial")
#: Roundings of a coordinate of the box that a contact may be off by: of positions and of a clock that runs for some
#: times to cross the box, at relative speeds of some times the mean.
_ROUNDINGS = 64
_WHY = "64 roundings of a coordinate: of positions, and of a clock that runs for some times to cross the box"

#: A sphere that passes the edge of the box twice, and meets the second image of its partner: side, places, velocities.
_SIDE = 10.0
_PLACES = ((5.0, 5.0, 5.0), (2.0, 3.0, 5.0))
_VELOCITIES = ((0.0, 0.0, 0.0), (-1.0, 0.13, 0.0))
#: Along x: of all, such that they touch across the edge of the box.
_SHIFT = 4.5
#: Two that part, and meet on the other side of the box; a third one rests aside.
_APART = ((5.0, 5.0, 8.0), (4.45, 5.0, 5.0), (5.55, 5.1, 5.0))
_PARTING = ((0.0, 0.0, 0.0), (-0.5, 0.0, 0.0), (0.5, 0.0, 0.0))
#: Time step of schemes that search for collisions after each.
_STEP = 1e-3
_SQUARES_OF_DISTANCES = Fault(
    "squares-of-distances",
    "events/prediction.py",
    "    if c > FAR * s2:\n",
    "    if c > 1e300 * s2:\n",
    "the discriminant is the difference of squares of distances, from afar too",
)
_FIRST_IMAGE_ONLY = Fault(
    "first-image-only",
    "events/kernels/loop.py",
    "    tick(counts, PREDICTIONS, p)\n",
    "    tick(counts, PREDICTIONS, p)\n    p = p if particles.images[i, 0] == 0 else 0\n",
    "no partners are looked for once a sphere has left the box: only the first image is asked",
)


def _pair(side: float, duration: float, positions: Floats, velocities: Floats, interval: float) -> Scene:
    return spheres(
        2,
        1.0,
        1,
        box=Box(lengths=(side, side, side)),
        initial=Explicit(positions=tuple(map(tuple, positions.tolist())), velocities=tuple(map(tuple, velocities))),
        duration=duration,
        output=Output(interval=interval, observables=_RECORD, trajectory=True),
    )


def _expected(scene: Scene) -> Impact | None:
    """The closed form of the first contact of the last two spheres."""
    state = scene.initial_state()
    x, v = state.positions, state.velocities
    return first_impact(
        (x[-1] - x[-2]).tolist(), (v[-1] - v[-2]).tolist(), 1.0, scene.periods().tolist(), scene.duration
    )


def _contact_error(run: Run, before: Floats) -> float:
    """Of the contact distance of the only impact: its virial over the momentum exchanged, less sigma."""
    exchanged = float(np.linalg.norm(run["final_velocities"][1] - before))
    return abs(float(run["collisional_virial"][-1]) / exchanged - 1.0) if exchanged > 0 else float("nan")


def _judge_grazing(laboratory: Laboratory) -> Judged:
    """Pairs from 1e2 ... 1e8 diameters away that miss or touch by 1e2 ... 1e6 roundings of that distance."""
    wrong, deviation, deflection, number = 0, 0.0, 0.0, 0
    for distance in (10.0**k for k in range(2, 9)):
        side = 4 * distance
        depths = [sign * scale * _ROUNDINGS * EPSILON * side for scale in (2.0, 100.0, 1e4) for sign in (-1, 1)]
        for aim in [*(1 + np.array(depths)).tolist(), 0.6]:
            positions = np.full((2, 3), 0.5 * side)
            positions[0, 0] -= distance
            positions[1, 1] += aim
            velocities = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
            scene = _pair(side, 1.5 * distance, positions, velocities, 1.5 * distance)
            impact = _expected(scene)
            run = laboratory.run(scene, EVENT_DRIVEN)
            number += 1
            hit = impact is not None
            wrong += int(run["collisions"][-1] != hit)
            if impact is not None and run["collisions"][-1] == 1:
                rounding = _ROUNDINGS * EPSILON * side
                deviation = float(np.maximum(deviation, _contact_error(run, velocities[1]) / rounding))
                if aim == 0.6:  # a grazing hit deflects by the root of its depth
                    _, expected = after_impact(impact, *velocities.tolist())
                    error = np.linalg.norm(run["final_velocities"][1] - expected)
                    deflection = float(np.maximum(deflection, error / rounding))
    return worst(
        [
            bounded(
                "grazing pairs with a wrong number of collisions", float(wrong), 0.0, "a collision only below sigma"
            ),
            round_off("error of the contact distance, in units of its rounding", deviation, 1.0, _WHY),
            round_off("error of the velocity, in units of its rounding", deflection, 2.0, "the normal, off by that"),
        ],
        f"{number} pairs",
    )


def _judge_second_image(laboratory: Laboratory) -> Judged:
    """A sphere that passes its partner twice across the edge of the box before it meets an image of it."""
    side, duration, interval = _SIDE, 60.0, 0.5
    positions, velocities = np.array(_PLACES), np.array(_VELOCITIES)
    scene = _pair(side, duration, positions, velocities, interval)
    impact = _expected(scene)
    assert impact is not None
    run = laboratory.run(scene, EVENT_DRIVEN)
    t = run["time"]
    after = np.array(after_impact(impact, *velocities.tolist()))
    late = np.maximum(t - impact.time, 0.0)[:, None, None]
    exact = positions + velocities * np.minimum(t, impact.time)[:, None, None] + after * late
    away = run["positions"] - exact
    away -= side * np.round(away / side)  # an engine may wrap
    counted = run["collisions"] - (t > impact.time)
    rounding = _ROUNDINGS * EPSILON * side
    return worst(
        [
            bounded("samples with a wrong number of collisions", float(np.count_nonzero(counted)), 0.0,
                    f"one collision, at t = {impact.time:.7g}"),
            round_off("error of a position", float(np.abs(away).max()), rounding * (1 + duration),
                      "64 roundings of a coordinate, and those of the normal over the flight after the impact"),
            round_off("error of the contact distance", _contact_error(run, velocities[1]), rounding, _WHY),
        ]
    )  # fmt: skip


def _judge_dilute(laboratory: Laboratory) -> Judged:
    """A gas at n sigma^3 = 1e-3 ... 1e-6: at each collision, the nearest two are at the contact distance.

    Free paths are up to 500 sides of the box, and places that are not wrapped are rounded as these are. The virial is
    that of the pair alone, and must be rounded as the box is.
    """
    judged: list[Judged] = []
    for density, collisions in ((1e-3, 200), (1e-5, 50), (1e-6, 20)):
        scene = spheres(
            108,
            density,
            laboratory.seed(f"{density:g}") % 2**31,
            box=Box(density=density),
            duration=1e9,
            output=Output(collisions=tuple(range(1, collisions + 1)), observables=_RECORD, trajectory=True),
        )
        lengths = scene.lengths()
        assert lengths is not None
        run = laboratory.run(scene, EVENT_DRIVEN)
        errors = np.array([abs(_nearest(x, lengths) - 1.0) for x in run["positions"][1:]])
        # unwrapped positions are rounded as the flight is
        coarse = 4 * EPSILON * np.abs(run["positions"][1:]).max(axis=(1, 2))
        rounding = _ROUNDINGS * EPSILON * float(lengths[0]) + coarse
        share = errors / rounding
        judged += [
            round_off(
                f"n = {density:g}: error of the distance at a collision, in units of its rounding",
                float(share.max()),
                1.0,
                _WHY,
                note=f"largest error {errors.max():.2g} diameters",
            ),
            round_off(
                f"n = {density:g}: error of the contact distance in the virial, in units of its rounding",
                _virial_error(run, _ROUNDINGS * EPSILON * float(lengths[0])),
                1.0,
                f"{_WHY}; and of velocities and of the sum, over the momentum exchanged",
            ),
        ]
    return worst(judged, "108 spheres")


def _virial_error(run: Run, rounding: float) -> float:
    """Largest error of the pair's virial over the momentum exchanged, less 1, over its rounding.

    run: samples each collision, of spheres of mass and diameter 1. rounding: of a contact distance.
    """
    total, velocities = run["collisional_virial"], run["velocities"]
    exchanged = np.linalg.norm(np.diff(velocities, axis=0), axis=2).max(axis=1)
    bound = rounding + EPSILON * (4 * np.abs(velocities).max() + np.abs(total).max()) / exchanged
    return float(np.max(np.abs(np.diff(total) / exchanged - 1.0) / bound))


def _nearest(positions: Floats, lengths: Floats) -> float:
    """Distance of the nearest two of all particles."""
    apart = positions[:, None, :] - positions[None, :, :]
    apart -= lengths * np.round(apart / lengths)
    distances = np.linalg.norm(apart, axis=2)
    return float(distances[np.triu_indices(len(positions), 1)].min())


def _schemes(schemes: Mapping[str, Claims]) -> tuple[Variant, ...]:
    """All of these kinds."""
    return quick(*(name for name, claims in schemes.items() if claims.kind in ("collision_search", EVENT_DRIVEN)))


def _judge_any_scheme(laboratory: Laboratory, scheme: str) -> Judged:
    """The pair of `_judge_second_image`, with the contact inside the box and across its edge; and two that part."""
    across = np.array(_PLACES) + np.array([_SHIFT, 0.0, 0.0])
    cases = {
        "inside the box": (np.array(_PLACES), _VELOCITIES, 0.5),
        "across the edge": (across, _VELOCITIES, 0.5),
        # samples may cut a flight short
        "of two that parted": (np.array(_APART), _PARTING, 20.0),
    }
    return worst(
        [judged for name, start in cases.items() for judged in _late_contact(laboratory, scheme, name, *start)]
    )


def _late_contact(
    laboratory: Laboratory,
    scheme: str,
    where: str,
    positions: Floats,
    before: tuple[tuple[float, ...], ...],
    interval: float,
) -> Iterator[Judgement]:
    """The contact of the last two spheres, by a scheme of any kind.

    where: its name. before: velocities. interval: between samples.

    A search after each step finds the pair up to dt late: |u| dt nearer, u the relative velocity, with a normal that is
    turned by less than |u| dt/(sigma - |u| dt). So the velocities are off by less than twice that, times |u|; positions
    by that times the time since, and by 2 |u| dt.
    """
    step = _STEP if laboratory.claims[scheme].takes_dt else 0.0
    velocities = np.array(before)
    scene = spheres(
        len(positions),
        1.0,
        1,
        box=Box(lengths=(_SIDE,) * 3),
        initial=Explicit(positions=tuple(map(tuple, positions.tolist())), velocities=before),
        duration=20.0,
        output=Output(interval=interval, observables=("collisions",), trajectory=True),
    )
    impact = _expected(scene)
    assert impact is not None
    run = laboratory.run(scene, Method(scheme=scheme, dt=step or None))
    t, speed = run["time"], float(np.linalg.norm(velocities[-1] - velocities[-2]))
    settled = (t <= impact.time) | (t > impact.time + step)
    counted = run["collisions"] - (t > impact.time)
    after = np.array([*velocities[:-2].tolist(), *after_impact(impact, *velocities[-2:].tolist())])
    late = np.maximum(t - impact.time, 0.0)
    exact = positions + velocities * np.minimum(t, impact.time)[:, None, None] + after * late[:, None, None]
    away = run["positions"] - exact
    away -= _SIDE * np.round(away / _SIDE)  # an engine may wrap
    turned = speed * step / (1.0 - speed * step)
    # a sum of so many steps is rounded at each
    rounding = _ROUNDINGS * EPSILON * _SIDE * (1 + scene.duration + (scene.duration / step if step else 0.0))
    bound = 2 * speed * step + 2 * turned * speed * late + rounding
    share = np.abs(away).max(axis=(1, 2)) / bound
    yield bounded(
        f"contact {where}: samples with a wrong number of collisions",
        float(np.count_nonzero(counted[settled])),
        0.0,
        f"one collision, at t = {impact.time:.7g}, or at most a step later",
    )
    yield bounded(
        f"contact {where}: error of a position over its bound",
        float(share[settled].max()),
        1.0,
        "contact found up to a step late, hence a normal turned by |u| dt/sigma; and round-off",
    )


#: What each variant judges.
Case: TypeAlias = Callable[[Laboratory], Judged]


def _judge(laboratory: Laboratory, case: Case) -> Judged:
    return case(laboratory)


CHECKS = (
    Check(
        name="events/far-impacts",
        title="Few spheres far apart: grazing from 1e8 diameters, the second image, contact distances of a dilute gas",
        equation="|r_i - r_j| = sigma at a collision; w t^2 + 2 b t + c = 0 for each image",
        criterion="collisions counted exactly; places and contact distances to roundings of the box, not of its square",
        citation="B. J. Alder and T. E. Wainwright, J. Chem. Phys. 31, 459 (1959)",
        judge=_judge,
        variants=quick(**{"grazing": _judge_grazing, "second-image": _judge_second_image, "dilute": _judge_dilute}),
        needs=event_driven("box.boundaries=periodic", "positions velocities collisions collisional_virial"),
        faults=(
            ("dilute", _SQUARES_OF_DISTANCES),
            ("grazing", _SQUARES_OF_DISTANCES),
            ("second-image", _FIRST_IMAGE_ONLY),
        ),
    ),
    Check(
        name="events/second-image",
        title="Few spheres in a periodic box: the contact with another image, by any search for collisions",
        equation="|r_i - r_j + k L| = sigma at a collision, for the image k that is met first",
        criterion="collisions counted exactly; positions as precise as a contact that is found up to a time step late",
        citation="B. J. Alder and T. E. Wainwright, J. Chem. Phys. 31, 459 (1959); Rein & Liu, A&A 537, A128 (2012)",
        judge=_judge_any_scheme,
        variants=_schemes,
        needs=Needs(
            "hard_spheres",
            ("collision_search", EVENT_DRIVEN),
            frozenset({"box.boundaries=periodic"}),
            frozenset({"positions", "collisions"}),
        ),
        faults=((EVENT_DRIVEN, _FIRST_IMAGE_ONLY),),
        interpreted=True,
    ),
)
