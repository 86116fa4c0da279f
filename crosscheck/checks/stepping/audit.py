"""Audits of runs under smooth forces: every sample by sums over all pairs, every step by the scheme's recurrence.

What is judged is an error over a bound on rounding, by quantity: the largest of all scenes of a case, with the scene
that it was found in.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from crosscheck.checks.base import Laboratory, Tier, Variant, full, quick
from crosscheck.engines.capabilities import refusal, scheme_of
from crosscheck.engines.protocol import Engine, Run
from crosscheck.engines.registry import engine_class
from crosscheck.errors import Unsupported
from crosscheck.pairs import Pair, Row, covering
from crosscheck.references import EPSILON
from crosscheck.references.recurrences import MAPS, Problem, Solution, solutions
from crosscheck.references.smooth_forces import Smooth, accelerations, kinetic_energy, smooth
from crosscheck.scene import Floats, Method, Output, Scene
from crosscheck.verdict import Findings, round_off, worst

ENERGIES = ("kinetic_energy", "potential_energy", "virial")
#: The roundings of two codes with one recurrence differ by so much more than those of one in two precisions do.
_SCATTER = 20.0
#: Seeds of starts that each table of rows has for itself, and tables of other rows that the full tier has.
_STARTS, _OTHERS = 1000, 4
WHY = "bounds on the rounding of coordinates, terms and sums; of steps, 20 times what doubles do to the recurrence"


class Ledger:
    """The largest errors so far, in bounds of rounding, by quantity; and how many scenes the engine refused."""

    def __init__(self) -> None:
        self.shares: dict[str, tuple[float, str]] = {}
        self.scenes = 0
        self.refused: list[str] = []

    def note(self, quantity: str, error: Any, bound: Any, where: str) -> None:
        """Keeps the largest error/bound of a quantity.

        error, bound: numbers or arrays of one shape. where: the scene, in words. A NaN is an infinite error.
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            shares = np.asarray(abs(np.asarray(error, dtype=np.longdouble)) / bound, dtype=np.float64)
        shares = np.where(np.asarray(error) == 0, 0.0, np.where(np.isnan(shares), np.inf, shares))
        share = float(shares.max(initial=0.0))
        if share >= self.shares.get(quantity, (-1.0, ""))[0]:
            self.shares[quantity] = share, where

    def findings(self) -> Findings:
        """A judgement for each quantity. Unsupported, with the reasons, if the engine refused all scenes."""
        if not self.scenes:
            raise Unsupported("; ".join(dict.fromkeys(self.refused)) or "no scene")
        note = f"{self.scenes} scenes"
        if self.refused:
            note += f", {len(self.refused)} more that the engine does not know"
        return worst(
            [
                round_off(f"{quantity}: largest error, in bounds of rounding", share, 1.0, WHY, note=where)
                for quantity, (share, where) in self.shares.items()
            ],
            note,
        )


def measurable(engine: str, scene: Scene) -> frozenset[str]:
    """What an engine declares that it measures in scenes of an interaction.

    engine: its name. scene: of that interaction.
    """
    capabilities = engine_class(engine).capabilities
    of = [one.observables for one in capabilities if one.interaction == scene.interaction and one.kind == "stepping"]
    return frozenset().union(*of)


def asking(engine: str, scene: Scene, interval: float, *, trajectory: bool = True) -> Scene:
    """`scene`, asking for all that the engine measures of energies, forces and, with `trajectory`, states.

    engine: its name. interval: time between samples.
    """
    known = measurable(engine, scene)
    return scene.changed(
        output=Output(
            interval=interval,
            observables=tuple(name for name in ENERGIES if name in known),
            trajectory=trajectory and {"positions", "velocities"} <= known,
            forces="forces" in known,
        )
    )


def run_or_refuse(laboratory: Laboratory, ledger: Ledger, scene: Scene, method: Method) -> Run | None:
    """The run of a scene; None if the engine does not know it, which the ledger notes.

    laboratory: runs it. method: with which scheme and step.
    """
    reason = laboratory.refusal(scene, method)
    if reason is None:
        try:
            run = laboratory.run(scene, method)
        except Unsupported as unsupported:
            reason = str(unsupported)
        else:
            ledger.scenes += 1
            return run
    ledger.refused.append(reason)
    return None


# -- samples -----------------------------------------------------------------------------------------------------------


def audit_samples(ledger: Ledger, scene: Scene, run: Run, where: str) -> None:
    """Energies, virial and forces of a run against sums over all pairs at its own positions and velocities.

    ledger: keeps the errors. scene: that `run` is of. where: the scene, in words. Without a trajectory, start and end
    alone.
    """
    state = scene.initial_state()
    positions, velocities = run.get("positions"), run.get("velocities")
    samples: dict[int, tuple[Floats, Floats]] = {0: (state.positions, state.velocities)}
    if positions is not None and velocities is not None:
        # an engine may keep momenta, or other units: a rounding or two
        start = {"positions": (state.positions, positions), "velocities": (state.velocities, velocities)}
        for name, (given, found) in start.items():
            ledger.note(f"{name} of the start", found[0] - given, 2 * EPSILON * abs(given) + 1e-300, where)
        samples.update(enumerate(zip(positions, velocities, strict=True)))
        if math.isclose(run["time"][-1], scene.duration, rel_tol=1e-9):
            ledger.note("last sample of the positions", positions[-1] - run["final_positions"], 1e-300, where)
            ledger.note("last sample of the velocities", velocities[-1] - run["final_velocities"], 1e-300, where)
    else:
        samples[len(run["time"]) - 1] = run["final_positions"], run["final_velocities"]
    for sample, (r, v) in samples.items():
        exact = smooth(scene, r)
        kinetic = kinetic_energy(state.masses, v)
        expected = {
            "kinetic_energy": kinetic,
            # an engine may know the total energy alone, and subtract the kinetic one
            "potential_energy": (exact.energy, exact.energy_error + kinetic[1]),
            "virial": (exact.virial, exact.virial_error),
        }
        for name, (value, bound) in expected.items():
            if name in run:
                ledger.note(name, run[name][sample] - value, bound, where)
    if "forces" in run:
        gamma = 0.0 if scene.spring is None or scene.spring.gamma is None else scene.spring.gamma
        friction: Floats = gamma * np.asarray(run["final_velocities"])
        exact = smooth(scene, run["final_positions"])
        bound = exact.forces_error[:, None] + 4 * EPSILON * abs(friction)
        ledger.note("forces", run["forces"] - (exact.forces - friction), bound, where)


# -- steps -------------------------------------------------------------------------------------------------------------


def problem_of(scene: Scene, *, extended: bool = True) -> Problem:
    """The equation of motion of a scene; springs know the higher derivatives.

    extended: in long double, or in double.
    """

    def acceleration(r: Floats, v: Floats) -> Floats:
        return accelerations(scene, r, v, extended=extended)

    def higher(r: Floats, v: Floats, count: int) -> list[Floats]:
        """m r''' = -k r' - gamma r'', and so on: acceleration is linear in (r, v)."""
        chain = [r, v, acceleration(r, v)]
        for _ in range(count):
            chain.append(acceleration(chain[-2], chain[-1]))
        return chain[3:]

    return Problem(acceleration, higher if scene.spring is not None else None)


class Expected:
    """Where the recurrences of a scheme lead, and what rounding may make of that.

    scene: gives the start. scheme: one of `recurrences.MAPS`. dt, steps: of the run.
    """

    def __init__(self, scene: Scene, scheme: str, dt: float, steps: int) -> None:
        state = scene.initial_state()
        start = state.positions.astype(np.longdouble), state.velocities.astype(np.longdouble)
        double = problem_of(scene, extended=False)
        self._paths = solutions(scheme, problem_of(scene), *start, dt, steps)
        rounded = solutions(scheme, double, state.positions, state.velocities, dt, steps)
        count = np.arange(steps + 1)
        first: Smooth = smooth(scene, state.positions)
        masses = np.where(state.masses > 0, state.masses, 1.0)
        kick = dt * float((first.forces_error / masses).max()) * count
        self._bounds: list[tuple[Floats, Floats]] = []
        for exact, doubled in zip(self._paths, rounded, strict=True):
            r, v = (
                _SCATTER * np.maximum.accumulate(abs(a - b).max(axis=(1, 2)))
                for a, b in ((exact.positions, doubled.positions), (exact.velocities, doubled.velocities))
            )
            far, fast = float(abs(exact.positions).max()), float(abs(exact.velocities).max())
            lever = far / dt if scheme == "verlet" else 0.0
            r = r + 8 * EPSILON * far * (1 + count) + kick * dt * count
            self._bounds.append((r, v + 8 * EPSILON * (fast * (1 + count) + lever) + kick))

    def miscounted(self, evaluations: int) -> int:
        """By how many evaluations of the force a count is off, of the map that is nearest."""
        return min((evaluations - path.evaluations for path in self._paths), key=abs)

    def compared(self, samples: Any, r: Floats, v: Floats) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
        """Errors and bounds of positions and velocities, each (samples, N, d), by the map that is nearest.

        samples: numbers of the steps after which r and v, (samples, N, d), are the state.
        """
        found = []
        for path, bounds in zip(self._paths, self._bounds, strict=True):
            errors = r - path.positions[samples], v - path.velocities[samples]
            limits = tuple(np.broadcast_to(bound[samples][:, None, None], r.shape) for bound in bounds)
            share = max(float(np.max(abs(e) / b)) for e, b in zip(errors, limits, strict=True))
            found.append((np.inf if np.isnan(share) else share, (errors, (limits[0], limits[1]))))
        return min(found, key=lambda one: one[0])[1]

    def path(self) -> tuple[Solution, tuple[Floats, Floats]]:
        """Positions and velocities by the first map, (steps + 1, N, d) each, and their bounds, (steps + 1,) each."""
        return self._paths[0], self._bounds[0]


def audit_steps(
    ledger: Ledger, expected: Expected, run: Run, steps: int, every: int, where: str, again: int = 0
) -> None:
    """The states of a run against the recurrence of its scheme.

    ledger: keeps the errors. expected: of the scheme, for the run's start and step. steps: of the run. every: steps
    between samples. where: the scene, in words. again: evaluations of the force that an engine may need to repeat.
    """
    if "positions" in run and "velocities" in run:
        numbers = [*range(0, steps + 1, every), steps]
        states = (np.concatenate([run[name], run[f"final_{name}"][None]]) for name in ("positions", "velocities"))
        errors, bounds = expected.compared(numbers, *states)
    else:
        errors, bounds = expected.compared([steps], run["final_positions"][None], run["final_velocities"][None])
    if run.cost.evaluations and run.cost.steps:  # an engine that does not count says 0
        ledger.note("steps counted", run.cost.steps - steps, 0.5, where)
        more = expected.miscounted(run.cost.evaluations)
        ledger.note("evaluations of the force counted", 0 if 0 < more <= again else more, 0.5, where)
    ledger.note("positions, step by step", errors[0], bounds[0], where)
    ledger.note("velocities, step by step", errors[1], bounds[1], where)


def audit_energies(ledger: Ledger, scene: Scene, expected: Expected, run: Run, every: int, where: str) -> None:
    """Energies and virial of a run against those of the expected states, which an engine need not have recorded.

    ledger: keeps the errors. scene: that `run` is of. expected: of its scheme. every: steps between samples. where: the
    scene, in words.
    """
    (positions, velocities, _), (apart, slower) = expected.path()
    masses = scene.initial_state().masses
    for sample in range(len(run["time"])):
        step = sample * every
        exact = smooth(scene, positions[step], uncertainty=float(apart[step]))
        kinetic, bound = kinetic_energy(masses, velocities[step])
        bound += float(slower[step] * (masses[:, None] * abs(velocities[step])).sum())
        values = {
            "kinetic_energy": (kinetic, bound),
            "potential_energy": (exact.energy, exact.energy_error + bound),
            "virial": (exact.virial, exact.virial_error),
        }
        for name, (value, tolerance) in values.items():
            if name in run:
                ledger.note(name, run[name][sample] - value, tolerance, where)


# -- rows --------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Features:
    """Features of scenes, combined into rows in which every pair of them occurs.

    factors: the levels of each feature, the first one its absence. valid: whether a row makes sense. scene_of: the
    scene of a row and a seed, without what it records. dt, steps: of a run. seed: of the choice among rows.
    """

    factors: Mapping[str, tuple[str, ...]]
    valid: Callable[[Row], bool]
    scene_of: Callable[[Row, int], Scene]
    dt: float
    steps: int
    seed: int
    _known: dict[type[Engine], list[Row]] = field(default_factory=dict, init=False)

    def other(self, table: int) -> Features:
        """The same features in other rows, with other starts; table: which, from 1."""
        first = _STARTS * table
        return replace(self, scene_of=lambda row, seed: self.scene_of(row, first + seed), seed=self.seed + first)

    @cached_property
    def rows(self) -> tuple[list[Row], set[Pair]]:
        """Rows with all pairs of levels, and the pairs that no scene can have."""
        return covering(self.factors, (self.valid,), self.seed)

    def method(self, engine: type[Engine], scene: Scene) -> Method:
        """Velocity Verlet if the engine has it, else its first scheme. engine: the class. scene: of a row."""
        first = scheme_of(engine, scene.interaction, "stepping")
        return Method(scheme="velocity_verlet" if "velocity_verlet" in engine.schemes else str(first), dt=self.dt)

    def known(self, name: str) -> list[Row]:
        """Rows with all pairs of the levels that an engine knows: of all levels, if it knows them all.

        name: of the engine. A level is known if a row with it is: one of all rows, or one with it alone.
        """
        engine = engine_class(name)
        if engine not in self._known:
            self._known[engine] = self._of(engine)
        return self._known[engine]

    def _of(self, engine: type[Engine]) -> list[Row]:
        rows, _ = self.rows
        if all(self._accepted(engine, row) for row in rows):
            return rows
        plain = {factor: levels[0] for factor, levels in self.factors.items()}
        alone = [{**plain, factor: level} for factor, levels in self.factors.items() for level in levels]
        accepted = [row for row in (*rows, *filter(self.valid, alone)) if self._accepted(engine, row)]
        levels = {
            factor: tuple(level for level in of if any(row[factor] == level for row in accepted))
            for factor, of in self.factors.items()
        }
        if not accepted or levels == dict(self.factors):
            return rows
        return covering(levels, (self.valid,), self.seed)[0]

    def _accepted(self, engine: type[Engine], row: Row) -> bool:
        scene = self.scene_of(row, 0)
        return refusal(engine, scene, self.method(engine, scene)) is None


class Part(NamedTuple):
    """A part of the rows of `features`: number `chunk`, from 0, of so many `chunks`."""

    features: Features
    chunk: int = 0
    chunks: int = 1


def parts_of(features: Features, chunks: int) -> tuple[Variant, ...]:
    """Variants of the quick tier, each a part of all rows, and of the full tier, each with other rows.

    features: whose rows. chunks: number of the parts.
    """
    return (
        *quick(**{f"rows-{chunk}": Part(features, chunk, chunks) for chunk in range(chunks)}),
        *full(**{f"other-rows-{table}": Part(features.other(table)) for table in range(1, _OTHERS + 1)}),
    )


def audit_rows(laboratory: Laboratory, part: Part) -> Findings:
    """Every sample and every step of a part of the rows that an engine knows.

    laboratory: runs them. part: which. A message names the features of the row that are not absent.
    """
    features, chunk, chunks = part
    ledger, engine = Ledger(), engine_class(laboratory.engine)
    dt, steps = features.dt, features.steps
    for number, row in list(enumerate(features.known(laboratory.engine)))[chunk::chunks]:
        present = [f"{name}: {level}" for name, level in row.items() if level != features.factors[name][0]]
        where = "; ".join(present) or "plain"
        scene = asking(laboratory.engine, features.scene_of(row, number).changed(duration=steps * dt), dt)
        method = features.method(engine, scene)
        run = run_or_refuse(laboratory, ledger, scene, method)
        if run is not None:
            audit_samples(ledger, scene, run, where)
            if has_recurrence(method.scheme):
                audit_steps(ledger, Expected(scene, method.scheme, dt, steps), run, steps, 1, where)
    return ledger.findings()


def has_recurrence(scheme: str) -> bool:
    """Whether the steps of a scheme of this name can be judged one by one; scheme: its name."""
    return scheme in MAPS


def tier_beside_audits(*kept: str) -> Callable[[str], Tier]:
    """The tier, by a scheme's name, of a check that shows over many steps what the audits judge in each of them.

    The full tier, but for the schemes `kept`, which show the phenomenon, and those without a recurrence.
    """
    return lambda scheme: "full" if has_recurrence(scheme) and scheme not in kept else "quick"
