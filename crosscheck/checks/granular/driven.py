"""Driven scenes of hard spheres: event-driven against soft grains, whose contacts last t_c, in the limit t_c -> 0.

What a soft run has in the mean is off by a term of the first order in t_c: of a grain's time the share nu t_c is spent
in contact (nu the collision rate), and of its contacts the same share are with two grains at once. So runs at two or
more t_c give the value at t_c = 0 by a straight line, with its standard error, and that is compared with the
event-driven run, which has no t_c. The second order is left to the error bar: it is (nu t_c)^2.

The step's own error does not vanish with t_c at a given dt/t_c. At the dt/t_c of these checks an impact has alpha to
1e-3 (of 0.9), alpha_t of a dashpot to 3e-3 and of a tangential spring to 0.6 dt/t_c at worst, in the mean over impacts.

Literature: S. Luding et al., Phys. Rev. E 49, 1634 (1994) and 50, 4113 (1994); S. Luding and S. McNamara, Granular
Matter 1, 113 (1998).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from crosscheck.checks.base import EVENT_DRIVEN, Laboratory, fixed, legacy_check, soft
from crosscheck.checks.events.driven import run_whole, snapshot_figure
from crosscheck.checks.events.drum import DRUM_RADIUS, DRUM_SAMPLE, drum_scene, surface_angle
from crosscheck.convergence import ORDER_TOLERANCE, WHY_ORDER
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Frame, RoundFrame, Series
from crosscheck.references import EPSILON
from crosscheck.references.soft_impact import damping, stiffness
from crosscheck.scene import (
    Box,
    Explicit,
    Face,
    Floats,
    Friction,
    GrainFriction,
    HardSpheres,
    Lattice,
    Oscillation,
    Output,
    Scene,
)
from crosscheck.statistics import Mean, correlated_mean, fitted_order, standard_error
from crosscheck.verdict import Judged, Judgement, bounded, order, statistical, within, worst

#: Stretches of a run, whose means give a profile its standard errors.
BLOCKS = 20


def _trajectory(run: Run, skip: int) -> tuple[Floats, Floats]:
    """Positions and velocities of the samples from number `skip` on."""
    return run["positions"][skip:], run["velocities"][skip:]


# -- means in the limit --------------------------------------------------------------------------------


def hard_limit(durations: Sequence[float], means: Sequence[Mean]) -> Mean:
    """Value at t_c = 0 of the straight line through means at several t_c, by least squares with weights 1/error^2.

    The error is that of the means, carried on; independent: the smallest number of them. ValueError for fewer than two
    durations, or an error that is not positive.
    """
    errors = np.array([mean.error for mean in means])
    if len(set(durations)) < 2 or not (errors > 0).all():
        raise ValueError(f"a limit needs two durations and positive errors, got {durations} and {errors}")
    values = [mean.value for mean in means]
    line, covariance = np.polyfit(durations, values, 1, w=1 / errors, cov="unscaled")
    return Mean(float(line[1]), float(covariance[1, 1] ** 0.5), min(mean.independent for mean in means))


class Profile(NamedTuple):
    """share: of the grains in each bin; mean: of the quantity over them; both (blocks, bins)."""

    share: Floats
    mean: Floats

    def means(self, values: Floats) -> list[Mean]:
        """Mean over the blocks of each bin of `values`, one of the two."""
        errors = standard_error(values)
        return [Mean(float(v), float(e), len(values)) for v, e in zip(values.mean(axis=0), errors, strict=True)]


def profile(places: ArrayLike, quantity: ArrayLike, edges: ArrayLike, blocks: int = BLOCKS) -> Profile:
    """Share and mean of a quantity over bins of the place, in each of `blocks` stretches of the samples.

    places, quantity: (samples, N). A bin that is empty in a stretch has the mean NaN there. Samples beyond a whole
    number of stretches are left out.
    """
    x, q, ends = np.asarray(places), np.asarray(quantity), np.asarray(edges)
    length = len(x) // blocks
    shares, means = np.empty((blocks, len(ends) - 1)), np.empty((blocks, len(ends) - 1))
    for block in range(blocks):
        part = slice(block * length, (block + 1) * length)
        count = np.histogram(x[part], ends)[0]
        shares[block] = count / x[part].size
        with np.errstate(invalid="ignore"):
            means[block] = np.histogram(x[part], ends, weights=q[part])[0] / count
    return Profile(shares, means)


_WHY = "standard errors of correlated series; soft ones taken to t_c = 0 along a straight line"


def _against(quantity: str, limit: Mean, hard: Mean, needed: float, why: str = _WHY) -> Judgement:
    """The soft limit against the event-driven mean."""
    samples = min(limit.independent, hard.independent)
    return statistical(quantity, limit.value, limit.error, hard.value, hard.error, why, samples=samples, needed=needed)


def _against_duration(
    title: str, label: str, engine: str, durations: Sequence[float], means: Sequence[Mean], hard: Mean
) -> Figure:
    """A mean against t_c, with the event-driven one at 0 and the line's value there."""
    limit = hard_limit(durations, means)
    x, y = [0.0, *durations], [limit, *means]
    return Figure(
        title,
        "t_c",
        label,
        series=(
            Series(f"soft, {engine}", x, [m.value for m in y], [m.error for m in y]),
            Series("event-driven", [0.0], [hard.value], [hard.error]),
        ),
    )


def _curves(
    engine: str, x: Floats, durations: Sequence[float], soft_means: list[list[Mean]], hard: list[Mean]
) -> tuple[Series, ...]:
    """Profiles of the soft runs and of the event-driven one."""
    labels = [f"{engine}, t_c = {duration:g}" for duration in durations] + ["event-driven"]
    return tuple(
        Series(label, x.tolist(), [m.value for m in means], [m.error for m in means])
        for label, means in zip(labels, [*soft_means, hard], strict=True)
    )


def _table(durations: Sequence[float], means: Sequence[Mean], hard: Mean) -> str:
    soft_ones = ", ".join(
        f"{m.value:.5g} +- {m.error:.2g} at t_c = {t:g}" for t, m in zip(durations, means, strict=True)
    )
    limit = hard_limit(durations, means)
    return (
        f"{soft_ones}, limit {limit.value:.5g} +- {limit.error:.2g}, event-driven {hard.value:.5g} +- {hard.error:.2g}"
    )


# -- a bed on a floor that oscillates --------------------------------------------------------------------

_BED_DURATIONS, _BED_SAMPLES = (0.01, 0.005), (10800, 8100)
#: Not commensurate with the floor's period 2 pi/8: samples at all phases alike.
_BED_SAMPLE = 0.37
_BED_WARM_UP = 100.0


def _bed(seed: int, samples: int) -> Scene:
    """Six layers of disks, restitution 0.9, on a floor that oscillates with a = 0.3, a omega^2 = 19 g."""
    floor = Face(oscillation=Oscillation(amplitude=0.3, frequency=8.0))
    return Scene(
        name="vibrated-bed",
        dimension=2,
        duration=samples * _BED_SAMPLE,
        acceleration=(0.0, -1.0),
        hard_spheres=HardSpheres(restitution=0.9),
        box=Box(lengths=(10.0, 100.0), boundaries=("periodic", "hard"), faces={"y-": floor, "y+": Face(open=True)}),
        initial=Lattice(kind="lattice", structure="square", number=60, temperature=1.0, seed=seed),
        output=Output(interval=_BED_SAMPLE, trajectory=True),
    )


class _Bed(NamedTuple):
    height: Mean
    energy: Mean
    temperature: Profile


def _measured_bed(run: Run, edges: Floats) -> _Bed:
    positions, velocities = _trajectory(run, round(_BED_WARM_UP / _BED_SAMPLE))
    z, energy = positions[:, :, 1], 0.5 * (velocities**2).sum(axis=2)
    # the mean velocity is zero at every height: all of the kinetic energy is temperature
    return _Bed(correlated_mean(z.mean(axis=1)), correlated_mean(energy.mean(axis=1)), profile(z, energy, edges))


def _judge_bed(laboratory: Laboratory, variant: str) -> Judged:
    # above 14 too few grains come for a temperature to a quarter
    edges = np.arange(0.0, 15.0, 2.0)
    event_run = run_whole(laboratory, _bed(laboratory.seed("event-driven"), 27000), EVENT_DRIVEN, "refimpl")
    hard = _measured_bed(event_run, edges)
    runs = [
        _measured_bed(
            run_whole(
                laboratory, _bed(laboratory.seed(f"soft-{t_c:g}"), samples), soft(duration=t_c, resolution=1 / 30)
            ),
            edges,
        )
        for t_c, samples in zip(_BED_DURATIONS, _BED_SAMPLES, strict=True)
    ]
    heights, energies = [run.height for run in runs], [run.energy for run in runs]
    judgements = [
        _against("height of the centre of mass", hard_limit(_BED_DURATIONS, heights), hard.height, 0.03),
        _against("kinetic energy of a grain", hard_limit(_BED_DURATIONS, energies), hard.energy, 0.08),
    ]
    middle = 0.5 * (edges[1:] + edges[:-1])
    hot = [run.temperature.means(run.temperature.mean) for run in runs]
    reference = hard.temperature.means(hard.temperature.mean)
    for index, z in enumerate(middle):
        limit = hard_limit(_BED_DURATIONS, [means[index] for means in hot])
        judgements.append(_against(f"temperature at z = {z:g}", limit, reference[index], 0.25))
    share = [run.temperature.means(run.temperature.share) for run in runs]
    shared = hard.temperature.means(hard.temperature.share)
    engine = laboratory.engine
    figures = (
        _against_duration(
            "Vibrated bed: kinetic energy of a grain", "K/N", engine, _BED_DURATIONS, energies, hard.energy
        ),
        _against_duration(
            "Vibrated bed: height of the centre of mass", "height", engine, _BED_DURATIONS, heights, hard.height
        ),
        Figure(
            "Vibrated bed: temperature", "height", "T", series=_curves(engine, middle, _BED_DURATIONS, hot, reference)
        ),
        Figure(
            "Vibrated bed: mass",
            "height",
            "share of the grains",
            y_scale="log",
            series=_curves(engine, middle, _BED_DURATIONS, share, shared),
        ),
        snapshot_figure(
            "Vibrated bed: grains",
            event_run,
            Frame(0.0, 10.0, 0.0, 20.0, ("bottom",)),
            10.0,
            np.linalg.norm(event_run["final_velocities"], axis=1),
            "speed",
        ),
    )
    note = (
        f"height: {_table(_BED_DURATIONS, heights, hard.height)}; K/N: {_table(_BED_DURATIONS, energies, hard.energy)}"
    )
    return worst(judgements, note, figures)


# -- a column that bounces -----------------------------------------------------------------------------

_BEADS, _RESTITUTION, _FALL = 8, 0.95, 2.0
_GAP = 0.1
_APART = (0.02, 0.01, 0.005, 0.0025)
#: Gaps over v t_c.
_RATIOS = (0.003, 0.01, 0.03, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
_TOUCHING = 0.002


def _column(gap: float, duration: float) -> Scene:
    """Beads above each other that fall from rest, the lowest by `_FALL`, onto a floor; gravity 1."""
    return Scene(
        name="bouncing-column",
        dimension=2,
        duration=duration,
        acceleration=(0.0, -1.0),
        hard_spheres=HardSpheres(restitution=_RESTITUTION),
        box=Box(
            lengths=(10.0, 100.0),
            boundaries=("open", "hard"),
            faces={"y-": Face(restitution=_RESTITUTION), "y+": Face(open=True)},
        ),
        initial=Explicit(positions=tuple((0.0, 0.5 + _FALL + i * (1 + gap)) for i in range(_BEADS))),
        output=Output(interval=duration, trajectory=True),
    )


class Column(NamedTuple):
    """Of beads of mass 1 in a field 1: K + U, from U = 0 where all lie on the floor; height of the centre of mass."""

    energy: float
    height: float


def column_state(heights: ArrayLike, speeds: ArrayLike) -> Column:
    """Energy and centre of mass of beads of diameter 1 at these heights of their centres."""
    y, v = np.asarray(heights, dtype=np.float64), np.asarray(speeds, dtype=np.float64)
    number = len(y)
    return Column(float(0.5 * np.sum(v**2) + y.sum() - number**2 / 2), float(y.mean()))


def _column_after(run: Run) -> Column:
    return column_state(run["final_positions"][:, 1], run["final_velocities"][:, 1])


def soft_chain(
    number: int, restitution: float, t_c: float, gap: float, speed: float, duration: float
) -> tuple[Floats, Floats]:
    """Heights and speeds of soft beads on a line, `duration` after the lowest, at `speed`, met the floor; gravity 1.

    y_i'' = -1 + F_i - F_(i+1), F = k delta - c sqrt(m k) v_n where beads overlap, m = 1/2 between beads and 1 at the
    floor, k = (pi^2 + ln^2 alpha)/(2 t_c^2), c = 2 |ln alpha|/sqrt(pi^2 + ln^2 alpha); by an adaptive Runge-Kutta
    method, relative error 1e-8 a step, steps up to t_c/5 so that no contact is missed. Beads have diameter and mass 1.
    """
    from scipy.integrate import solve_ivp

    k = stiffness(restitution, 0.5, t_c)
    dashpots = damping(restitution) * np.sqrt(k * np.array([1.0] + [0.5] * (number - 1)))

    def rates(t: float, state: Floats) -> Floats:
        y, v = state[:number], state[number:]
        # the floor's surface is where a bead below it would have its centre
        overlap = 1 - np.diff(y, prepend=-0.5)
        force = np.where(overlap > 0, k * overlap - dashpots * np.diff(v, prepend=0.0), 0.0)
        return np.concatenate([v, force - np.append(force[1:], 0.0) - 1])

    start = np.concatenate([0.5 + np.arange(number) * (1 + gap), np.full(number, -speed)])
    done = solve_ivp(rates, (0.0, duration), start, rtol=1e-8, atol=1e-10 * speed * t_c, max_step=t_c / 5)
    return done.y[:number, -1], done.y[number:, -1]


def _judge_column(laboratory: Laboratory, variant: str) -> Judged:
    return _judge_apart(laboratory) if variant == "apart" else _judge_touching(laboratory)


def _judge_apart(laboratory: Laboratory) -> Judged:
    """Gaps of 0.1, far above v t_c: two cascades of 28 impacts each, then one common flight, near its top at t = 4."""
    scene, speed = _column(_GAP, 4.0), math.sqrt(2 * _FALL)
    hard = _column_after(run_whole(laboratory, scene, EVENT_DRIVEN, "refimpl"))
    runs = [_column_after(run_whole(laboratory, scene, soft(duration=t_c, resolution=1 / 400))) for t_c in _APART]
    judgements, curves = [], []
    for name in ("energy", "height"):
        expected = getattr(hard, name)
        errors = [abs(getattr(run, name) - expected) for run in runs]
        slope = fitted_order(_APART, errors, 1e4 * EPSILON * expected)
        judgements.append(
            order(
                f"order of the {name} after the impact in t_c",
                slope.value,
                1.0,
                ORDER_TOLERANCE,
                WHY_ORDER,
                uncertainty=slope.error,
            )
        )
        curves.append(Series(f"{name}, {laboratory.engine}", list(_APART), errors))
    figure = Figure("Bouncing column: soft less event-driven", "t_c", "difference", "log", "log", series=tuple(curves))
    note = (
        f"event-driven: energy {hard.energy:.7g}, height {hard.height:.7g}; soft at t_c = {_APART[-1]:g}: energy "
        f"{runs[-1].energy:.7g}, height {runs[-1].height:.7g}; gap/(v t_c) from "
        f"{_GAP / (speed * _APART[0]):.3g} to {_GAP / (speed * _APART[-1]):.3g}"
    )
    return worst(judgements, note, (figure,))


def _judge_touching(laboratory: Laboratory) -> Judged:
    """Gaps from far below v t_c to above: the energy kept 0.25 after the lowest bead has met the floor."""
    speed = math.sqrt(2 * _FALL)
    after = 0.25
    event_driven, chains = [], []
    found: dict[int, list[float]] = {100: [], 200: []}
    for ratio in _RATIOS:
        gap = ratio * speed * _TOUCHING
        scene = _column(gap, speed + after)
        before = _BEADS * _FALL + gap * _BEADS * (_BEADS - 1) / 2
        event_driven.append(_column_after(run_whole(laboratory, scene, EVENT_DRIVEN, "refimpl")).energy / before)
        chain = column_state(*soft_chain(_BEADS, _RESTITUTION, _TOUCHING, gap, speed, after))
        chains.append(chain.energy / before)
        for steps, kept in found.items():
            kept.append(
                _column_after(run_whole(laboratory, scene, soft(duration=_TOUCHING, resolution=1 / steps))).energy
                / before
            )
    coarse, fine = (np.array(kept) for kept in found.values())
    departures = np.abs(fine - chains)
    at = int(departures.argmax())
    judgements = [
        within(
            "order",
            f"share of the energy kept, at gap/(v t_c) = {_RATIOS[at]:g}",
            float(fine[at]),
            chains[at],
            float(np.abs(coarse - fine).max()),
            "largest change when dt is halved, which is at least what is left of an error of the first order or above",
        ),
        bounded(
            f"share lost at gap/(v t_c) = {_RATIOS[0]:g} over the event-driven",
            float((1 - fine[0]) / (1 - event_driven[0])),
            1.0,
            "beads that touch at once detach before they have lost all (Luding et al. 1994)",
        ),
    ]
    figure = Figure(
        "Bouncing column: energy kept",
        "gap/(v t_c)",
        "energy after the impact over that before",
        x_scale="log",
        series=(
            Series(f"soft, {laboratory.engine}", list(_RATIOS), fine.tolist()),
            Series("event-driven", list(_RATIOS), event_driven),
            Series("Runge-Kutta", list(_RATIOS), chains, theory=True),
        ),
    )
    pairs = ", ".join(f"{r:g}: {a:.4f} ({b:.4f})" for r, a, b in zip(_RATIOS, fine, event_driven, strict=True))
    return worst(judgements, f"kept at gap/(v t_c), soft (event-driven): {pairs}", (figure,))


# -- a channel -----------------------------------------------------------------------------------------

_PIPE_DURATIONS = (0.08, 0.04)
_PIPE_WARM_UP = 200.0
_PIPE_WIDTH = 8.0


def _pipe(seed: int, duration: float) -> Scene:
    """Rough inelastic disks that fall between two rough walls; all contacts stick, so that the laws have one limit."""
    wall = Face(restitution=0.9, friction=Friction(tangential_restitution=0.5))
    return Scene(
        name="pipe",
        dimension=2,
        duration=duration,
        acceleration=(0.1, 0.0),
        hard_spheres=HardSpheres(restitution=0.9, friction=GrainFriction(tangential_restitution=0.5)),
        box=Box(lengths=(12.0, _PIPE_WIDTH), boundaries=("periodic", "hard"), faces={"y-": wall, "y+": wall}),
        initial=Lattice(kind="lattice", structure="square", number=48, temperature=1.0, seed=seed),
        output=Output(interval=1.0, trajectory=True),
    )


class _Pipe(NamedTuple):
    flux: Mean
    temperature: Mean
    velocity: Profile


def _measured_pipe(run: Run) -> _Pipe:
    positions, velocities = _trajectory(run, round(_PIPE_WARM_UP))
    along, across = velocities[..., 0], velocities[..., 1]
    edges = np.linspace(0.5, _PIPE_WIDTH - 0.5, 8)
    density = positions.shape[1] / 12.0
    return _Pipe(
        correlated_mean(density * along.mean(axis=1)),
        correlated_mean((across**2).mean(axis=1)),
        profile(positions[..., 1], along, edges),
    )


def _judge_pipe(laboratory: Laboratory, variant: str) -> Judged:
    event_run = run_whole(laboratory, _pipe(laboratory.seed("event-driven"), 30000.0), EVENT_DRIVEN, "refimpl")
    hard = _measured_pipe(event_run)
    runs = [
        _measured_pipe(
            run_whole(
                laboratory,
                _pipe(laboratory.seed(f"soft-{part}"), 10000.0),
                soft(duration=t_c, resolution=1 / 40, friction="dashpot"),
            )
        )
        for part, t_c in enumerate(_PIPE_DURATIONS)
    ]
    fluxes, hot = [run.flux for run in runs], [run.temperature for run in runs]
    judgements = [
        _against("mass flux", hard_limit(_PIPE_DURATIONS, fluxes), hard.flux, 0.05),
        _against("<v_y^2>", hard_limit(_PIPE_DURATIONS, hot), hard.temperature, 0.08),
    ]
    y = 0.5 + (np.arange(7) + 0.5) * (_PIPE_WIDTH - 1) / 7
    engine = laboratory.engine
    profiles = [run.velocity.means(run.velocity.mean) for run in runs]
    figures = (
        _against_duration("Pipe: mass flux", "mass a unit of time", engine, _PIPE_DURATIONS, fluxes, hard.flux),
        _against_duration("Pipe: temperature across", "<v_y^2>", engine, _PIPE_DURATIONS, hot, hard.temperature),
        Figure(
            "Pipe: velocity",
            "y",
            "velocity along the fall",
            series=_curves(engine, y, _PIPE_DURATIONS, profiles, hard.velocity.means(hard.velocity.mean)),
        ),
        snapshot_figure(
            "Pipe: grains",
            event_run,
            Frame(0.0, 12.0, 0.0, _PIPE_WIDTH, ("bottom", "top")),
            12.0,
            event_run["final_velocities"][:, 0],
            "velocity along the fall",
        ),
    )
    note = (
        f"flux: {_table(_PIPE_DURATIONS, fluxes, hard.flux)}; <v_y^2>: {_table(_PIPE_DURATIONS, hot, hard.temperature)}"
    )
    return worst(judgements, note, figures)


# -- a drum --------------------------------------------------------------------------------------------

_DRUM_DURATIONS = (0.04, 0.02)
#: Of the TC model, in the event-driven runs.
_TC_DURATIONS = (4e-4, 2e-4, 1e-4)
_DRUM_SKIP = round(15.0 / DRUM_SAMPLE)


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


def fall_angles(positions: ArrayLike, middle: ArrayLike) -> Floats:
    """Degrees by which the centre of mass, seen from the middle, is turned from -y to +x.

    positions: (samples, N, 2).
    """
    x, y = (np.asarray(positions).mean(axis=1) - np.asarray(middle)).T
    return np.asarray(np.degrees(np.arctan2(x, -y)))


class _Heap(NamedTuple):
    angle: Mean
    lever: Mean
    surface: Mean


def _measured_drum(run: Run) -> _Heap:
    positions, _ = _trajectory(run, _DRUM_SKIP)
    middle = np.full(2, DRUM_RADIUS)
    return _Heap(
        correlated_mean(fall_angles(positions, middle)),
        correlated_mean(np.linalg.norm(positions.mean(axis=1) - middle, axis=1)),
        correlated_mean([surface_angle(x, middle, DRUM_RADIUS) for x in positions]),
    )


def nearest(value: float, one: Mean, other: Mean) -> Mean:
    """The point of the interval between two means that is nearest to a value, with the error of the nearer mean."""
    low, high = sorted((one, other), key=lambda mean: mean.value)
    end = low if value < 0.5 * (low.value + high.value) else high
    return end._replace(value=min(max(value, low.value), high.value))


def _judge_drum(laboratory: Laboratory, variant: str) -> Judged:
    """Both tangential laws give an impact that sticks the same outcome, but differ in contacts that endure.

    A spring bears a force at rest, a dashpot does not; a contact within t_c of the TC model bears none either, but does
    not creep. So the limit of the TC model is asked to be between theirs.
    """
    laws: tuple[Literal["history", "dashpot"], ...] = ("history", "dashpot")
    runs = {
        law: [
            run_whole(
                laboratory,
                _drum(laboratory.seed(f"{law}-{part}"), None, 450.0),
                soft(duration=t_c, resolution=1 / 25, friction=law),
            )
            for part, t_c in enumerate(_DRUM_DURATIONS)
        ]
        for law in laws
    }
    event_runs = [
        run_whole(laboratory, _drum(laboratory.seed(f"tc-{part}"), t_c, 150.0), EVENT_DRIVEN, "refimpl")
        for part, t_c in enumerate(_TC_DURATIONS)
    ]
    heaps = {law: [_measured_drum(run) for run in runs[law]] for law in laws}
    hard = [_measured_drum(run) for run in event_runs]
    angles = {law: [heap.angle for heap in heaps[law]] for law in laws}
    limits = {law: hard_limit(_DRUM_DURATIONS, angles[law]) for law in laws}
    hard_angles = [heap.angle for heap in hard]
    hard_angle = hard_limit(_TC_DURATIONS, hard_angles)
    judgement = _against(
        "angle of the centre of mass in degrees, nearest between the two tangential laws",
        nearest(hard_angle.value, limits["history"], limits["dashpot"]),
        hard_angle,
        0.12,
        "standard errors of correlated series, all taken to t_c = 0; contacts that endure rub differently in each law",
    )
    judgements = [judgement]
    engine = laboratory.engine
    if engine != "refimpl":
        # the same law in two codes has no such latitude
        again = _drum(laboratory.seed("refimpl"), None, 450.0)
        twin = _measured_drum(
            run_whole(laboratory, again, soft(duration=_DRUM_DURATIONS[0], resolution=1 / 25), "refimpl")
        ).angle
        quantity = "angle of soft grains with tangential springs, beside refimpl's"
        judgements.append(_against(quantity, angles["history"][0], twin, 0.06, "standard errors of correlated series"))
    frame = RoundFrame(DRUM_RADIUS, DRUM_RADIUS, DRUM_RADIUS)
    figures = (
        Figure(
            "Drum: angle of the centre of mass, soft",
            "t_c",
            "degrees",
            series=tuple(_ladder(f"{law}, {engine}", _DRUM_DURATIONS, angles[law]) for law in laws),
        ),
        Figure(
            "Drum: angle of the centre of mass, event-driven",
            "t_c of the TC model",
            "degrees",
            series=(_ladder("event-driven", _TC_DURATIONS, hard_angles),),
        ),
        snapshot_figure(
            f"Drum: soft grains, {engine}",
            runs["history"][-1],
            frame,
            0.0,
            np.linalg.norm(runs["history"][-1]["final_velocities"], axis=1),
            "speed",
        ),
        snapshot_figure(
            "Drum: event-driven grains",
            event_runs[-1],
            frame,
            0.0,
            np.linalg.norm(event_runs[-1]["final_velocities"], axis=1),
            "speed",
        ),
    )
    note = "; ".join(
        [f"{law}: {_listed(_DRUM_DURATIONS, heaps[law])}, limit {_pm(limits[law])}" for law in laws]
        + [f"event-driven: {_listed(_TC_DURATIONS, hard)}, limit {_pm(hard_angle)}"]
    )
    return worst(judgements, note, figures)


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


_CONTACTS = "stepping/kernels/contacts.py"
CHECKS = (
    legacy_check(
        name="granular/bouncing-column",
        title="A column of beads falls on a floor: hard and soft, with gaps above and below v t_c",
        equation="gap >> v t_c: E_soft - E_hard -> 0 as t_c; gap << v t_c: the soft column loses less",
        criterion="order 1 in t_c; energy kept as by an adaptive Runge-Kutta method, to the change when dt is halved",
        citation="S. Luding, E. Clement, A. Blumen, J. Rajchenbach and J. Duran, Phys. Rev. E 49, 1634 (1994) and 50, "
        "4113 (1994)",
        judge=_judge_column,
        variants=fixed("apart", "touching"),
        faults=(
            (
                "apart",
                Fault(
                    "weak-dashpot",
                    _CONTACTS,
                    "delta - _damping(law[DAMPING], law, model, mass, scale) * approach",
                    "delta - 0.8 * _damping(law[DAMPING], law, model, mass, scale) * approach",
                    "the normal dashpot is four fifths of what the restitution asks for",
                ),
            ),
        ),
        engines=("refimpl", "lammps"),
        tier="full",
    ),
    legacy_check(
        name="granular/drum",
        title="Rough disks in a turning drum: angle of the heap, event-driven with the TC model and soft",
        equation="tan(angle) = x_cm/(-y_cm) in the limits t_c -> 0",
        criterion="standard errors; event-driven between soft grains with tangential springs and with dashpots",
        citation="S. Luding and S. McNamara, Granular Matter 1, 113 (1998); J. Schaefer, S. Dippel and D. E. Wolf, J. "
        "Phys. I France 6, 5 (1996)",
        judge=_judge_drum,
        variants=fixed("disks"),
        faults=(
            (
                "disks",
                Fault(
                    "little-friction",
                    _CONTACTS,
                    "limit = law[FRICTION] * abs(normal)",
                    "limit = 0.4 * law[FRICTION] * abs(normal)",
                    "Coulomb's limit is two fifths of what it should be",
                ),
            ),
        ),
        engines=("refimpl", "lammps"),
        tier="full",
    ),
    legacy_check(
        name="granular/pipe",
        title="Rough disks fall down a channel with rough walls: mass flux, event-driven and soft",
        equation="flux = (1/L) sum v_x; soft: flux + O(t_c)",
        criterion="standard errors of correlated series; soft ones taken to t_c = 0 along a straight line",
        citation="J. T. Jenkins and M. W. Richman, J. Fluid Mech. 171, 53 (1986); S. Luding et al., Phys. Rev. E 50, "
        "4113 (1994)",
        judge=_judge_pipe,
        variants=fixed("channel"),
        faults=(
            (
                "channel",
                Fault(
                    "little-drag",
                    _CONTACTS,
                    "f[k] = -share * u[k]",
                    "f[k] = -0.7 * share * u[k]",
                    "the tangential dashpot is seven tenths of what it should be",
                ),
            ),
        ),
        engines=("refimpl", "lammps"),
        tier="full",
    ),
    legacy_check(
        name="granular/vibrated-bed",
        title="Inelastic disks on an oscillating floor: temperature profile and centre of mass, event-driven and soft",
        equation="z_floor = a cos(omega t); T(z) = <v^2>/2; soft: + O(t_c)",
        criterion="standard errors of correlated series and of 20 stretches; soft ones taken to t_c = 0 by a line",
        citation="S. Luding, E. Clement, A. Blumen, J. Rajchenbach and J. Duran, Phys. Rev. E 49, 1634 (1994); S. "
        "Luding, H. J. Herrmann and A. Blumen, Phys. Rev. E 50, 3100 (1994)",
        judge=_judge_bed,
        variants=fixed("disks"),
        faults=(
            (
                "disks",
                Fault(
                    "light-grains",
                    _CONTACTS,
                    "a[d * i + k] = gravity[k]",
                    "a[d * i + k] = 0.9 * gravity[k]",
                    "grains fall with nine tenths of g",
                ),
            ),
        ),
        engines=("refimpl", "lammps"),
        tier="full",
    ),
)
