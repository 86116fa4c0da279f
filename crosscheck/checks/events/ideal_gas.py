"""Pressure of dilute disks on hard walls, and its growth with the square of the speed; sigma = m = 1."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full, quick, small
from crosscheck.checks.events.gases import SETTLING, TALLIES, duration_of, event_driven, gas, in_blocks, rates
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.references.hard_spheres import disk_compressibility, packing_fraction
from crosscheck.references.hard_walls import disk_box_pressure, impulse_of_a_hit
from crosscheck.references.speeds import mono_speed_temperature
from crosscheck.scene import Floats, Output, Scene, explicit
from crosscheck.statistics import Mean, correlated_mean
from crosscheck.verdict import Judged, Judgement, bounded, round_off, statistical, worst

#: Number of disks between hard walls, and of so few that slow codes move them. The reference holds to n = 0.127 (eta =
#: 0.1); at n = 0.2 its uncertainty, which grows as eta^2, is meant to cover its error.
WALLED, FEW = 400, 64
#: Disturbance of a second run's positions, relative to the box: some 450 roundings of a coordinate.
DISTURBANCE = 1e-13


class _Walled(NamedTuple):
    """Disks of speed 1.

    density: number per area; collisions: of pairs in the run. number: of disks. needed: relative deviations of the
    pressure and of the impulse of a hit that must be seen.
    """

    density: float
    collisions: float
    number: int = WALLED
    needed: tuple[float, float] = (0.02, 0.03)


class _Scaling(NamedTuple):
    """The same disks with several speeds V0.

    density: number per area; speeds: the first is 1. number: of disks. collisions: of pairs in each run.
    """

    density: float
    speeds: tuple[float, ...]
    number: int = WALLED
    collisions: float = 2e5


class _Pressure(NamedTuple):
    """Pressure on the walls.

    mean: over the blocks. residual: of the virial theorem. bound: of that residual. impulse: mean of a hit.
    """

    mean: Mean
    residual: float
    bound: float
    impulse: Mean


def _wall_pressure(scene: Scene, run: Run) -> _Pressure:
    """Mean force per length on the four walls of a square box.

    With positions from the box's middle and centres that stop at (L - sigma)/2, the virial theorem is exact for any
    span of time: (L - sigma)/2 sum I = 2 K t + W - [sum m r.v], with the impulses I that the walls got, the collisional
    virial W and the change of the last term. That change is bounded, and most of the noise in the impulses: it is added
    to them here. Without collisions nothing but 2 K t is left.
    """
    lengths = scene.lengths()
    assert lengths is not None
    length = float(lengths[0])
    outwards = np.array([-1.0, 1.0, -1.0, 1.0])
    pushed = run["wall_impulse"][:, [0, 1, 2, 3], [0, 0, 1, 1]] @ outwards
    hits, virial = run["wall_collisions"].sum(axis=1), run["collisional_virial"]
    moment = ((run["positions"] - length / 2) * run["velocities"]).sum(axis=(1, 2))
    kinetic = 0.5 * float((run["velocities"][0] ** 2).sum())
    right = 2 * kinetic * run["time"] + virial - (moment - moment[0])
    residual = np.abs(0.5 * (length - 1) * pushed - right).max() / right[-1]
    complete = pushed + 2 * moment / (length - 1)
    per_hit = (np.diff(pushed) / np.diff(hits))[SETTLING:]
    return _Pressure(
        correlated_mean(rates(run, complete) / (4 * length)),
        float(residual),
        EPSILON * float(run["collisions"][-1] + hits[-1]),
        correlated_mean(per_hit),
    )


def _walled(walled: _Walled | _Scaling, speed: float, seed: int) -> Scene:
    """Disks of one speed in a square box with hard walls, T = V0^2/2."""
    density, number = walled.density, walled.number
    temperature = mono_speed_temperature(speed, 2)
    duration = duration_of(walled.collisions, number, packing_fraction(density, 2), 2, temperature)
    return gas(2, number, density, seed, in_blocks(duration, True), duration, hard=True, speed=speed)


def _judge(laboratory: Laboratory, value: _Walled | _Scaling) -> Judged:
    return _judge_scaling(laboratory, value) if isinstance(value, _Scaling) else _judge_pressure(laboratory, value)


def _judge_pressure(laboratory: Laboratory, walled: _Walled) -> Judged:
    """Pressure on the walls, the virial theorem, and the impulse of a hit."""
    density, number = walled.density, walled.number
    scene = _walled(walled, 1.0, laboratory.seed())
    found = _wall_pressure(scene, laboratory.run(scene, EVENT_DRIVEN))
    temperature = mono_speed_temperature(1.0, 2)
    ideal = density * temperature
    known = disk_box_pressure(number, (number / density) ** 0.5, temperature)
    theorem = round_off(
        "residual of the virial theorem, relative",
        found.residual,
        found.bound,
        "one rounding of a running sum for every collision and every hit",
    )
    pressure = statistical(
        "p/(n T)",
        found.mean.value / ideal,
        found.mean.error / ideal,
        known.value / ideal,
        0.0,
        "standard error of correlated blocks; the reference's error, which grows as eta^2",
        samples=found.mean,
        doubt=known.doubt / ideal,
        needed=walled.needed[0],
        figures=(_pressure_figure(walled, found.mean.value / ideal, found.mean.error / ideal),),
    )
    impulse = statistical(
        "impulse of a hit",
        found.impulse.value,
        found.impulse.error,
        impulse_of_a_hit(temperature, 2 * number),
        0.0,
        "standard error of correlated blocks; exact at constant energy",
        samples=found.impulse,
        needed=walled.needed[1],
    )
    return worst([theorem, pressure, impulse], f"N = {number}; the ideal gas of points has p/(n T) = 1")


def _pressure_figure(walled: _Walled, value: float, error: float) -> Figure:
    x = np.geomspace(0.004, 0.2, 40)
    number = walled.number
    law = [disk_box_pressure(number, (number / n) ** 0.5).value / n for n in x]
    bulk = [disk_compressibility(packing_fraction(n, 2)).value for n in x]
    return Figure(
        "wall pressure", "n sigma^2", "p/(n T)", "log", "linear",
        (
            Series("measured", [walled.density], [value], [error]),
            Series(f"box with {number} disks", x.tolist(), law, theory=True),
            Series("Z of the bulk", x.tolist(), bulk, theory=True),
            Series("ideal gas", x.tolist(), [1.0] * x.size, theory=True),
        ),
    )  # fmt: skip


def _judge_scaling(laboratory: Laboratory, scaling: _Scaling) -> Judged:
    """V0 sets the unit of time alone: the same trajectory until chaos, p ~ V0^2 afterwards."""
    seed = laboratory.seed()
    pressures = []
    for speed in scaling.speeds:
        scene = _walled(scaling, speed, seed)
        pressures.append(_wall_pressure(scene, laboratory.run(scene, EVENT_DRIVEN)).mean)
    p, u = np.array([m.value for m in pressures]), np.array([m.error / m.value for m in pressures])
    weights = np.log(scaling.speeds) - np.mean(np.log(scaling.speeds))
    weights /= (weights**2).sum()
    exponent = statistical(
        "exponent of V0 in the pressure",
        float(weights @ np.log(p)),
        float(np.sqrt(weights**2 @ u**2)),
        2.0,
        0.0,
        "standard errors of correlated blocks",
        samples=pressures,
        needed=0.01,
        figures=(_scaling_figure(scaling, p, u),),
    )
    same = _same_events(laboratory, scaling, seed)
    return worst([*same, exponent], f"V0 = {scaling.speeds}, N = {scaling.number}, n = {scaling.density}")


def _same_events(laboratory: Laboratory, scaling: _Scaling, seed: int) -> list[Judgement]:
    """Positions after the same number of collisions, N/4: no further apart than if slightly disturbed."""
    number = scaling.number
    output = Output(collisions=(number // 16, number // 8, number // 4), observables=TALLIES, trajectory=True)
    scenes = [gas(2, number, scaling.density, seed, output, 1e9, hard=True, speed=speed) for speed in scaling.speeds]
    state, lengths = scenes[0].initial_state(), scenes[0].lengths()
    assert lengths is not None
    shake = np.random.default_rng(laboratory.seed("disturbance")).normal(size=state.positions.shape)
    disturbed = state.positions + DISTURBANCE * lengths * shake
    twin = scenes[0].changed(initial=explicit(disturbed, state.velocities))
    runs = [laboratory.run(scene, EVENT_DRIVEN) for scene in (*scenes, twin)]
    apart = [_separation(runs[0], run) for run in runs[1:]]
    return [
        bounded(
            f"largest separation of V0 = {speed:g} from V0 = 1 in N/4 collisions",
            separation,
            apart[-1],
            f"V0 scales velocities and times alone; that of a twin disturbed by {DISTURBANCE:g} L, some 450 roundings "
            "of a coordinate",
        )
        for speed, separation in zip(scaling.speeds[1:], apart[:-1], strict=True)
    ]


def _separation(one: Run, two: Run) -> float:
    """Largest rms distance of the same particle in two runs."""
    return float(np.sqrt(((one["positions"] - two["positions"]) ** 2).mean(axis=(1, 2))).max())


def _scaling_figure(scaling: _Scaling, p: Floats, u: Floats) -> Figure:
    speeds = list(scaling.speeds)
    known = disk_box_pressure(scaling.number, (scaling.number / scaling.density) ** 0.5).value
    law = [known * mono_speed_temperature(speed, 2) for speed in speeds]
    return Figure(
        f"wall pressure against V0, n = {scaling.density}", "V0", "p", "log", "log",
        (Series("measured", speeds, p.tolist(), (p * u).tolist()), Series("V0^2", speeds, law, theory=True)),
    )  # fmt: skip


def _impulse_fault(axis: int) -> Fault:
    name = "xyz"[axis]
    old = f"_add_to_wall(tallies, face, {axis}, -p{name})"
    return Fault(
        f"impulse-{name}-0.1-percent",
        "events/kernels/measure.py",
        old,
        old.replace("-p", "-1.001 * p"),
        f"impulses on walls along {name} are 0.1 % too large",
    )


_COARSE_CLOCK = Fault(
    "coarse-clock",
    "events/kernels/loop.py",
    "now = max(now, due)",
    "now = max(now, np.ceil(due * 1e9) * 1e-9)",
    "events fall on a clock that ticks every 1e-9, whatever the speed",
)

CHECKS = (
    Check(
        name="events/ideal-gas",
        title="Pressure of disks on hard walls against density, and its growth with the square of the speed",
        equation="p = sum I/(4 L t); (L - sigma)/2 sum I = 2 K t + W - [sum m r.v]; p -> n T as n -> 0; p ~ V0^2",
        criterion="virial theorem to one rounding an event; pressure within the errors of correlated blocks and of the "
        "theory of the box; impulse of a hit sqrt(2 pi m T)",
        citation="Lebowitz & Percus, Phys. Rev. 122, 1675 (1961); Clisby & McCoy, J. Stat. Phys. 122, 15 (2006); "
        "Hansen & McDonald, Theory of Simple Liquids, section 2.2",
        judge=_judge,
        variants=(
            *quick(**{"n0.05": _Walled(0.05, 4e5), "speeds": _Scaling(0.05, (1.0, 3.0, 10.0))}),
            *full(**{f"n{n:g}": _Walled(n, 1.5e6) for n in (0.005, 0.01, 0.02, 0.1, 0.2)}),
            small(f"n0.05-N{FEW}", _Walled(0.05, 1e4, FEW, (0.02, 0.1)), "n0.05"),
            small(f"speeds-N{FEW}", _Scaling(0.05, (1.0, 3.0, 10.0), FEW, 5e3), "speeds"),
        ),
        needs=event_driven("dimension=2 box.boundaries=hard", f"positions velocities {' '.join(TALLIES)}"),
        faults=(
            ("n0.05", _impulse_fault(0)),
            ("n0.02", _impulse_fault(1)),
            ("speeds", _COARSE_CLOCK),
            (f"n0.05-N{FEW}", _impulse_fault(0)),
            (f"speeds-N{FEW}", _COARSE_CLOCK),
        ),
    ),
)
