"""Grains on floors: at rest, vibrating, and the limits of high frequency.

Literature: S. McNamara and W. R. Young, Phys. Fluids A 4, 496 (1992); S. McNamara and J.-L. Barrat, Phys. Rev. E 55,
7767 (1997); R. Soto, Phys. Rev. E 69, 061305 (2004); S. Luding and S. McNamara, Granul. Matter 1, 113 (1998).
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosscheck.checks.base import EVENT_DRIVEN, Laboratory, reference_check
from crosscheck.checks.events.cooling import reported_time
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Frame, Histogram, Series, Snapshot
from crosscheck.references import EPSILON
from crosscheck.references import granular as reference
from crosscheck.scene import (
    Box,
    Face,
    HardSpheres,
    Lattice,
    Oscillation,
    Output,
    RandomPhase,
    Scene,
    explicit,
)
from crosscheck.statistics import standard_error
from crosscheck.verdict import Judged, bounded, round_off, statistical, within, worst

Floats = NDArray[np.float64]
Law = Literal["uniform", "flux"]

#: The face y-, the floor, among the faces.
_FLOOR = 2
#: All scenes but one have g = 1, and floors with A omega = V0 = 1 where the floor vibrates fast.
_GRAVITY = 1.0


def _over_floor(
    floor: Face, heights: Floats, velocities: Floats, duration: float, interval: float, *, gravity: bool = True,
    seed: int | None = None, width: float = 1.0,
) -> Scene:  # fmt: skip
    """Point grains, which do not hit each other, above the floor y = 0; nothing above, periodic to the sides.

    width: of the box; a narrow one keeps the rounding of places small, in a wide one many grains are apart.
    """
    number = heights.size
    places = np.stack([width * (np.arange(number) + 0.5) / number, heights], axis=1)
    return Scene(
        name="grains-on-a-floor",
        dimension=2,
        duration=duration,
        seed=seed,
        acceleration=(0.0, -_GRAVITY) if gravity else None,
        hard_spheres=HardSpheres(diameter=0.0),
        box=Box(
            lengths=(width, max(2.0, float(heights.max()))),
            boundaries=("periodic", "hard"),
            faces={"y-": floor, "y+": Face(open=True)},
        ),
        initial=explicit(places, np.stack([np.zeros(number), velocities], axis=1)),
        output=Output(interval=interval, observables=("wall_collisions", "wall_energy"), trajectory=True),
    )


def _vertical(run: Run) -> tuple[Floats, Floats]:
    """Heights and velocities, (samples, N)."""
    return run["positions"][:, :, 1], run["velocities"][:, :, 1]


# -- Zeno --------------------------------------------------------------------------------------------------------------


def _judge_zeno(laboratory: Laboratory, variant: str) -> Judged:
    alpha = float(variant.removeprefix("e"))
    ball = reference.BouncingBall(1.0, alpha, _GRAVITY)
    scene = _over_floor(
        Face(restitution=alpha), np.array([ball.height]), np.zeros(1), 1.5 * ball.rest, ball.rest / 4000
    )
    run = laboratory.run(scene, EVENT_DRIVEN)
    tick = float(np.spacing(ball.rest))
    ended = within(
        "round_off", "time of the collapse", reported_time(run), ball.rest,
        run.cost.events * 2 * tick / (1 - alpha),
        "the clock's rounding d keeps a velocity of g d/(1 - e), and each impact may wait for twice that",
    )  # fmt: skip
    z, v = (values[:, 0] for values in _vertical(run))
    bounce = run["wall_collisions"][:, _FLOOR]
    # flights that are longer than the interval are all seen
    seen = range(1 + int(np.log(ball.fall * 4000 / ball.rest) / -np.log(alpha)))
    first = [int(np.flatnonzero(bounce == k)[0]) for k in seen if (bounce == k).any()]
    z, v, k = z[first], v[first], bounce[first]
    ends = run["time"][first] + (v + np.sqrt(v * v + 2 * _GRAVITY * z)) / _GRAVITY
    apexes = z + v * v / (2 * _GRAVITY)
    times = np.array([ball.impact_time(int(one) + 1) for one in k])
    late = round_off(
        "largest error of an impact's time",
        float(abs(ends - times).max()),
        4 * tick * len(seen) * (1 + 1 / (1 - alpha)),
        "two roundings of the clock an impact, which also change the velocity of all later flights",
    )
    path = float(ball.height + 2 * apexes[1:].sum() + 2 * apexes[-1] * alpha**2 / (1 - alpha**2))
    whole = within(
        "round_off", "total path", path, ball.path, 8 * tick * len(seen) / (1 - alpha),
        "the same roundings; flights too short for a sample as a geometric series",
    )  # fmt: skip
    return worst([ended, late, whole], f"{len(first)} of {len(seen)} flights seen; '{run.stopped}'")


# -- the vibrating floor -----------------------------------------------------------------------------------------------

#: Heights of the drops, in amplitudes: from chatter to flights of many periods.
_DROPS = np.geomspace(1e-3, 30.0, 16)
_INTERVAL, _SAMPLES = 1.5, 40


class _Flight(NamedTuple):
    """State after an interval, and the impacts in it."""

    height: float
    velocity: float
    impacts: int


def flight(height: float, velocity: float, time: float, span: float, amplitude: float, omega: float) -> _Flight:
    """An elastic ball above the floor A cos(omega t), g = 1: from `time` on for `span`, by `plate_impact_time`."""
    end, impacts = time + span, 0
    while True:
        hit = reference.plate_impact_time(height, velocity, time, amplitude, omega, _GRAVITY, horizon=end - time)
        s = min(hit, end) - time
        height, velocity = height + velocity * s - _GRAVITY * s * s / 2, velocity - _GRAVITY * s
        if hit >= end:
            return _Flight(height, velocity, impacts)
        plate = -amplitude * omega * float(np.sin(omega * hit))
        height, velocity, time = amplitude * float(np.cos(omega * hit)), 2 * plate - velocity, hit
        impacts += 1


def _compare(state: tuple[float, float, float], found: tuple[float, float], omega: float) -> tuple[float, int]:
    """Error of a state one interval later in units of what rounding may do, and the impacts between."""
    z, v, t = state
    exact = flight(z, v, t, _INTERVAL, 1.0, omega)
    rounding = EPSILON * np.array([abs(z) + _DROPS[-1], abs(v) + omega, t + 1.0])
    # its effect through the derivatives, by differences ten thousand times larger
    scale, size = 1e4, np.zeros(2)
    for k in range(3):
        moved = np.array(state)
        moved[k] += scale * rounding[k]
        height, velocity, time = moved.tolist()
        other = flight(height, velocity, time, _INTERVAL - (time - t), 1.0, omega)
        size += abs(np.array(other[:2]) - exact[:2]) / scale
    size += EPSILON * np.array([abs(exact.height) + _DROPS[-1], abs(exact.velocity) + omega])
    error = abs(np.array(found) - exact[:2])
    return float((error / (8 * (1 + exact.impacts) * size)).max()), exact.impacts


def _judge_vibrating(laboratory: Laboratory, variant: str) -> Judged:
    if variant.startswith("column"):
        return _judge_column(laboratory, float(variant.removeprefix("column-")))
    omega = float(variant) ** 0.5
    floor = Face(oscillation=Oscillation(amplitude=1.0, frequency=omega))
    scene = _over_floor(floor, 1 + _DROPS, np.zeros(_DROPS.size), _INTERVAL * _SAMPLES, _INTERVAL)
    run = laboratory.run(scene, EVENT_DRIVEN)
    z, v = _vertical(run)
    gap = float((z - np.cos(omega * run["time"])[:, None]).min())
    touch = 4 * EPSILON * float(_DROPS[-1] + 1 + omega * run["time"][-1])
    above = bounded("deepest place below the floor", -gap, touch, "rounding of the coordinates and of the phase")
    if -gap > touch:
        return above
    worst_error, impacts = 0.0, 0
    for k in range(_SAMPLES):
        for ball in range(_DROPS.size):
            start = (float(z[k, ball]), float(v[k, ball]), float(run["time"][k]))
            error, number = _compare(start, (float(z[k + 1, ball]), float(v[k + 1, ball])), omega)
            worst_error, impacts = max(worst_error, error), impacts + number
    like = round_off(
        "largest error of a state after an interval",
        worst_error,
        1.0,
        "in units of eight roundings an impact of height, velocity and time, through the derivatives of the flight",
    )
    counted = float(run["wall_collisions"][-1, _FLOOR])
    all_hits = within("round_off", "impacts", counted, float(impacts), 0.5, "a count: none missed or doubled")
    return worst([above, like, all_hits], f"{_DROPS.size} balls, {_SAMPLES} intervals of {_INTERVAL:g}")


#: t_c of the shaken column: a bed at rest collides about once a grain and t_c.
_CONTACT_DURATION = 1e-2


def _judge_column(laboratory: Laboratory, shaking: float) -> Judged:
    """Inelastic disks between side walls on a floor with A = 0.5: nobody falls through it."""
    amplitude, omega, number = 0.5, (shaking / 0.5) ** 0.5, 60
    scene = Scene(
        name="vibrated-column",
        dimension=2,
        duration=10.0,
        acceleration=(0.0, -_GRAVITY),
        hard_spheres=HardSpheres(restitution=0.9, contact_duration=_CONTACT_DURATION),
        box=Box(
            lengths=(6.0, 20.0),
            boundaries=("hard", "hard"),
            faces={
                "y-": Face(restitution=0.9, oscillation=Oscillation(amplitude=amplitude, frequency=omega)),
                "y+": Face(open=True),
            },
        ),
        initial=Lattice(kind="lattice", structure="square", number=number, temperature=0.1, seed=laboratory.seed()),
        output=Output(interval=0.05, observables=("wall_collisions", "collisions"), trajectory=True),
    )
    run = laboratory.run(scene, EVENT_DRIVEN)
    x, y = run["positions"][:, :, 0], run["positions"][:, :, 1]
    gaps = np.stack([y - 0.5 - amplitude * np.cos(omega * run["time"])[:, None], x - 0.5, 5.5 - x])
    deepest = float(0.0 - gaps.min()) if np.isfinite(gaps).all() else np.inf
    figure = Figure(
        f"shaken column, A omega^2/g = {shaking:g}", "x", "y",
        snapshot=Snapshot(
            x[-1].tolist(), y[-1].tolist(), 0.5,
            Frame(0.0, 6.0, amplitude * float(np.cos(omega * run["time"][-1])), 20.0, ("left", "right", "bottom")),
        ),
    )  # fmt: skip
    return bounded(
        "deepest penetration of floor and side walls",
        deepest,
        # the phase omega t, and places of up to the height of the box
        4 * EPSILON * (20.0 + amplitude * omega * 10.0),
        "rounding of the coordinates and of the clock",
        note=f"{run['wall_collisions'][-1, _FLOOR]:.0f} impacts on the floor, {run.cost.events} events; "
        f"{run.stopped or 'ran to its end'}",
        figures=(figure,),
    )


# -- random phases -----------------------------------------------------------------------------------------------------

#: Grains of each run, velocities before the impact in units of V0.
GRAINS = 40000
SPEEDS = (1.0, 2.0, 3.0)


def random_visit_gain(speed: float, law: Law) -> float:
    """Mean energy gained in a visit to a wall that draws V = cos(phase) at each impact, V > -u; V0 = 1, elastic.

    G(u) = <((2 V + u)^2 - u^2)/2 + G(-2 V - u) [2 V + u < 0]>: who does not leave hits again at once. Iterated on a
    grid of u in [0, 2], where alone it happens; for u >= 2 the mean of one impact. Error below 1e-3.
    """
    plates = np.cos(np.pi * (np.arange(500) + 0.5) / 500)
    grid = np.append(np.linspace(0.0, 2.0, 101)[1:], speed)[:, None]
    weights = np.where(plates > -grid, 1.0 if law == "uniform" else grid + plates, 0.0)
    weights /= weights.sum(axis=1, keepdims=True)
    out = 2 * plates + grid
    once = (weights * 0.5 * (out**2 - grid**2)).sum(axis=1)
    gains = once
    # at most 0.6 hit again: 40 impacts are more than enough
    for _ in range(40):
        again = np.where(out < 0, np.interp(-out, grid[:-1, 0], gains[:-1]), 0.0)
        gains = once + (weights * again).sum(axis=1)
    return float(gains[-1])


def _judge_random(laboratory: Laboratory, variant: str) -> Judged:
    law, speed = variant.split("-u")
    u = float(speed)
    assert law in ("uniform", "flux")
    floor = Face(random_phase=RandomPhase(speed=1.0, law=law))  # type: ignore[arg-type]
    scene = _over_floor(
        floor, np.full(GRAINS, 0.5 * u), np.full(GRAINS, -u), 1.0, 1.0, gravity=False, seed=laboratory.seed(),
        width=4.0 * GRAINS,
    )  # fmt: skip
    run = laboratory.run(scene, EVENT_DRIVEN)
    gains = 0.5 * (run["final_velocities"][:, 1] ** 2 - u * u)
    single = {"uniform": reference.uniform_phase_gain, "flux": reference.flux_phase_gain}[law](u, 1.0)
    visit = random_visit_gain(u, law)  # type: ignore[arg-type]
    hits = float(run["wall_collisions"][-1, _FLOOR]) / GRAINS
    expected, error = (single, 0.0) if u >= 2 else (visit, 1e-3)
    plates = (run["final_velocities"][:, 1] - u) / 2
    figures = _plate_figures(plates, u, f"{law} phases, u = {u:g}") if u >= 2 else ()
    return statistical(
        "mean energy gained in a visit to the wall",
        float(gains.mean()),
        float(standard_error(gains)),
        expected,
        error,
        f"standard error over {GRAINS} independent grains",
        samples=GRAINS,
        needed=0.1,
        note=f"{hits:.4f} impacts a visit; closed form of one impact {single:.4f}, of a visit {visit:.4f}",
        figures=figures,
    )


def _plate_figures(plates: Floats, u: float, label: str) -> tuple[Figure, ...]:
    """Density of the wall's velocity at the impact, with the two laws."""
    edges = np.linspace(-1.0, 1.0, 41)
    heights = np.histogram(plates, edges, density=True)[0]
    fine = np.cos(np.linspace(0.02, 0.98, 100) * np.pi)[::-1]
    return (
        Figure(
            f"velocity of the wall that grains of u = {u:g} meet", "V/V0", "probability density", "linear", "linear",
            (
                Histogram(label, edges.tolist(), heights.tolist()),
                Series("uniform", fine.tolist(), reference.uniform_phase_density(fine, 1.0).tolist(), theory=True),
                Series("flux", fine.tolist(), reference.flux_phase_density(fine, u, 1.0).tolist(), theory=True),
            ),
        ),
    )  # fmt: skip


# -- the limit of a small, fast floor ----------------------------------------------------------------------------------

AMPLITUDES = (0.1, 0.03, 0.01, 0.003)
#: Grains, one per phase; samples a period, and periods after the last grain has come.
PHASES, PER_PERIOD, PERIODS = 2000, 6, 12


class Visits(NamedTuple):
    """Of every grain: energy gained in its visit to the floor, velocity on leaving; and the share still there."""

    gains: Floats
    velocities: Floats
    unfinished: float


def _visit_floor(laboratory: Laboratory, u: float, amplitude: float) -> Visits:
    """One grain per phase comes down onto the floor A cos(t/A), V0 = 1: at z = 0 it would have velocity -u.

    A visit is over when the grain rises above the floor's highest place.
    """
    period = 2 * np.pi * amplitude
    # times at which the grains would pass z = 0: equally spaced over one period, from above the floor
    passing = 1.5 * amplitude / u + period * (np.arange(PHASES) + 0.5) / PHASES
    heights = u * passing - _GRAVITY * passing**2 / 2
    interval = period / PER_PERIOD
    floor = Face(oscillation=Oscillation(amplitude=amplitude, frequency=1 / amplitude))
    duration = interval * int(PER_PERIOD * PERIODS)
    run = laboratory.run(_over_floor(floor, heights, -u + _GRAVITY * passing, duration, interval), EVENT_DRIVEN)
    z, v = _vertical(run)
    gone = (z > amplitude) & (v > 0)
    finished = gone.any(axis=0)
    sample = np.where(finished, gone.argmax(axis=0), z.shape[0] - 1)
    who = np.arange(PHASES)
    energies = 0.5 * v[sample, who] ** 2 + _GRAVITY * z[sample, who]
    return Visits(energies - 0.5 * u * u, np.sqrt(2 * np.maximum(energies, 0.0)), 1 - float(finished.mean()))


def _judge_limit(laboratory: Laboratory, variant: str) -> Judged:
    u = float(variant.removeprefix("u"))
    visits = [_visit_floor(laboratory, u, amplitude) for amplitude in AMPLITUDES]
    means = np.array([float(visit.gains.mean()) for visit in visits])
    # the gain jumps as a function of the phase, as in `visit_gain`
    grain = 8 * (1 + u) / PHASES
    limit = reference.visit_gain(u)
    remains = float(abs(means[-1] - means[0])) * AMPLITUDES[-1] / AMPLITUDES[0] + grain
    flux, uniform = reference.flux_phase_gain(u, 1.0), reference.uniform_phase_gain(u, 1.0)
    gain_figure = Figure(
        "mean gain in a visit to a vibrating floor", "A g/V0^2", "energy/V0^2", "log", "linear",
        (
            Series(f"u = {u:g}", list(AMPLITUDES), means.tolist(), [grain] * means.size),
            Series(f"u = {u:g}, limit of a visit", [AMPLITUDES[-1], AMPLITUDES[0]], [limit.value] * 2, theory=True),
            Series("flux law", [AMPLITUDES[-1], AMPLITUDES[0]], [flux] * 2, theory=True),
            Series("uniform law", [AMPLITUDES[-1], AMPLITUDES[0]], [uniform] * 2, theory=True),
        ),
    )  # fmt: skip
    plates = (visits[-1].velocities - u) / 2
    histogram = _plate_figures(plates, u, f"floor, A = {AMPLITUDES[-1]:g}") if u >= 3 else ()
    table = ", ".join(f"A {a:g}: {mean:.4f}" for a, mean in zip(AMPLITUDES, means, strict=True))
    return within(
        "order",
        f"mean energy gained in a visit at A = {AMPLITUDES[-1]:g}",
        float(means[-1]),
        limit.value,
        remains + limit.uncertainty,
        "finite amplitude, of first order from the largest one, and the jumps between neighbouring phases",
        note=f"{table}; flux law {flux:.4f}, uniform law {uniform:g}; not gone at the end: "
        f"{max(visit.unfinished for visit in visits):.2%}",
        figures=(gain_figure, *histogram),
    )


# -- sawtooth ----------------------------------------------------------------------------------------------------------


def _judge_sawtooth(laboratory: Laboratory, variant: str) -> Judged:
    """The floor stays at z = 0 and always has the velocity V0; one impact of each grain."""
    e = float(variant.removeprefix("e"))
    u = np.geomspace(0.2, 20.0, 40)
    fall = np.minimum(1.0, u)
    heights, velocities = u * fall - _GRAVITY * fall**2 / 2, -u + _GRAVITY * fall
    scene = _over_floor(Face(velocity=1.0, restitution=e), heights, velocities, 1.25, 1.25)
    run = laboratory.run(scene, EVENT_DRIVEN)
    after = 0.5 * run["final_velocities"][:, 1] ** 2 + _GRAVITY * run["final_positions"][:, 1]
    gains = after - (0.5 * velocities**2 + _GRAVITY * heights)
    expected = np.array([reference.sawtooth_gain(float(one), 1.0, e) for one in u])
    rounding = 16 * EPSILON * float(u.max() ** 2)
    each = round_off(
        "largest error of the gain of one impact",
        float(abs(gains - expected).max()),
        rounding,
        "of velocities and heights on the way, in units of the largest energy",
    )
    together = within(
        "round_off", "energy given by the floor", float(run["wall_energy"][-1, _FLOOR]), float(expected.sum()),
        rounding * u.size, "that of each grain",
    )  # fmt: skip
    once = within(
        "round_off", "impacts", float(run["wall_collisions"][-1, _FLOOR]), float(u.size), 0.5,
        "one of each grain",
    )  # fmt: skip
    return worst([each, together, once], f"e = {e:g}, u = 0.2 ... 20 V0")


# -- the checks --------------------------------------------------------------------------------------------------------


CHECKS = (
    reference_check(
        "events/zeno",
        "A ball that comes to rest on a floor: infinitely many impacts in a finite time",
        "t = sqrt(2 h/g) (1 + e)/(1 - e), path h (1 + e^2)/(1 - e^2)",
        "time of the reported collapse, times of impacts and path, to the rounding of the clock",
        "McNamara & Young, Phys. Fluids A 4, 496 (1992)",
        _judge_zeno,
        variants=("e0.5", "e0.8", "e0.9", "e0.95"),
        faults=(
            (
                "e0.8",
                Fault(
                    "floor-restitution-squared",
                    "events/rules.py",
                    "rows[i, 3 + axis] = inwards * ((1.0 + alpha) * own - alpha * v)",
                    "rows[i, 3 + axis] = inwards * ((1.0 + alpha) * own - alpha * alpha * v)",
                    "walls rebound with the square of the restitution",
                ),
            ),
        ),
    ),
    reference_check(
        "events/vibrating-floor",
        "Elastic balls on a sinusoidal floor, and a shaken column: no impact missed, nobody lost",
        "z + v s - g s^2/2 = A cos(omega (t + s)), A omega^2/g from 0.1 to 100",
        "every interval of every ball against an independent root finder in long double, to rounding",
        "Soto, Phys. Rev. E 69, 061305 (2004)",
        _judge_vibrating,
        variants=("0.1", "1", "10", "100", "column-0.1", "column-1", "column-3", "column-10", "column-100"),
        faults=(
            (
                "10",
                Fault(
                    "steps-too-long",
                    "events/prediction.py",
                    "steepest = abs(a) + amplitude * frequency * frequency",
                    "steepest = abs(a) + 0.25 * amplitude * frequency * frequency",
                    "the search for the next impact passes roots",
                ),
            ),
        ),
    ),
    reference_check(
        "events/random-phase",
        "Floors that draw their phase at each impact: uniform, or weighted with the speed of approach",
        "<dE> = V0^2 (uniform), 2 V0^2 (flux) for u >= 2 V0; below, with the impacts that follow at once",
        f"mean over {GRAINS} grains",
        "McNamara & Barrat, Phys. Rev. E 55, 7767 (1997); Soto, Phys. Rev. E 69, 061305 (2004)",
        _judge_random,
        variants=[f"{law}-u{u:g}" for law in ("uniform", "flux") for u in SPEEDS],
        faults=(
            (
                "flux-u2",
                Fault(
                    "flux-as-uniform",
                    "events/rules.py",
                    "if own > v and (motion == UNIFORM_PHASE or chance * (abs(top) - v) < own - v):",
                    "if own > v and (motion == UNIFORM_PHASE or chance < 2.0):",
                    "the flux law draws uniform phases",
                ),
            ),
        ),
    ),
    reference_check(
        "events/small-amplitude",
        "A floor of small amplitude and high frequency: which law its visits tend to",
        "<dE>(A -> 0, A omega = V0) = that of a visit in the limit: 2 V0^2, the flux law's, for u >= 3 V0",
        f"mean over {PHASES} equally spaced phases at A = {', '.join(f'{a:g}' for a in AMPLITUDES)}",
        "McNamara & Barrat, Phys. Rev. E 55, 7767 (1997)",
        _judge_limit,
        variants=[f"u{u:g}" for u in SPEEDS],
        faults=(
            (
                "u2",
                Fault(
                    "floor-half-as-fast",
                    "events/rules.py",
                    "return -numbers[AMPLITUDE] * frequency * math.sin(numbers[PHASE] + frequency * now)",
                    "return -0.5 * numbers[AMPLITUDE] * frequency * math.sin(numbers[PHASE] + frequency * now)",
                    "the floor's velocity is half of what its place says",
                ),
            ),
        ),
    ),
    reference_check(
        "events/sawtooth",
        "A floor that always moves up: the limit of a sawtooth",
        "dE = 2 V0 (V0 + u) for e = 1; v' = (1 + e) V0 + e u",
        "each grain, to rounding",
        "McNamara & Barrat, Phys. Rev. E 55, 7767 (1997)",
        _judge_sawtooth,
        variants=("e1", "e0.9"),
        faults=(
            (
                "e1",
                Fault(
                    "floor-velocity-once",
                    "events/rules.py",
                    "rows[i, 3 + axis] = inwards * ((1.0 + alpha) * own - alpha * v)",
                    "rows[i, 3 + axis] = inwards * (own - alpha * v)",
                    "the floor's velocity counts once instead of 1 + alpha times",
                ),
            ),
        ),
    ),
)
