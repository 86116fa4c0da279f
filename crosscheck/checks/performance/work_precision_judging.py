"""What the checks of error against run time share: ladders that are run and timed, and how they are judged.

A ladder is one method with smaller and smaller time steps, or tolerances, on one scene. Times are of the integration
alone, without compilation; they are shown, and judge nothing.

Literature: E. Hairer, S. P. Norsett and G. Wanner, Solving Ordinary Differential Equations I, sections II.4 and II.10
(1993), on work-precision diagrams and on errors that follow a tolerance.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Tier, Variant
from crosscheck.checks.operations import evaluations_of
from crosscheck.checks.stepping.orbits import WHY_BIASED
from crosscheck.convergence import LEVEL, ORDER_TOLERANCE, WHY_ORDER, WIDEST, WINDOW, Observed, observed_order
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Claims, Run
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Ladder
from crosscheck.scene import Floats, Method, Scene
from crosscheck.verdict import Judged, Judgement, bounded, order, round_off, worst

#: Times that every run of a ladder is made, alternated with the others; runs of more CPU seconds less often.
REPEATS, FEWER, LONG, VERY_LONG = 5, 3, 0.02, 1.0
#: The error, in its unit, from which a run says nothing any more: the size of what is computed.
LOST = 1.0
#: Runs of another engine that take the same steps, and the scheme of `refimpl` that these are.
SAME_STEPS = {("lammps", "velocity_verlet"): "velocity_verlet", ("ase", "velocity_verlet"): "velocity_verlet"}
#: Exponent of the error in the tolerance, at least.
LEAST_EXPONENT = 0.75
_WHY_EXPONENT = (
    "steps whose estimated error of order q + 1 is kept to the tolerance give a global error that falls as its power "
    "q/(q + 1) at least; q >= 3 of all four solvers"
)
_WHY_SAME = "the same steps of the same scheme: rounding of both runs"
_WHY_ORDER = f"{WHY_ORDER}; {WINDOW}"


@dataclass(frozen=True)
class Problem:
    """A case with a known solution.

    name: of the problem; its check is called work-precision-`name`. title: what the scene is, in words. equation,
    citation, needs, faults: as of a `Check`. unit: of the error. scene: without its time step. error: of a run, in
    `unit`. order: that a scheme shows here, from its name and claims. numbers: of steps of a run, from the claims,
    coarsest first. floor: what rounding makes of the error, from the scheme and the number of steps. tolerances: of
    schemes that choose their steps. accept: whether a scheme, by its name and claims, can run the problem. quick: the
    schemes of the quick tier. same_steps: whether `SAME_STEPS` holds: not with friction. at_least: why orders may be
    higher than claimed, or "".
    """

    name: str
    title: str
    equation: str
    citation: str
    unit: str
    scene: Scene
    error: Callable[[Run], float]
    order: Callable[[str, Claims], int]
    numbers: Callable[[Claims], Floats]
    floor: Callable[[str, float], float]
    needs: Needs
    faults: tuple[tuple[str, Fault], ...]
    tolerances: tuple[float, ...] = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)
    accept: Callable[[str, Claims], bool] = field(default=lambda scheme, claims: True)
    quick: Collection[str] = ()
    same_steps: bool = True
    at_least: str = ""


def check(problem: Problem) -> Check:
    """The check of a problem: a variant for each scheme that takes time steps, of its own choice or not."""
    return Check(
        name=f"performance/work-precision-{problem.name}",
        title=f"Work and precision on {problem.title}",
        equation=problem.equation,
        criterion=f"error = C evaluations^-order, order as claimed +- {ORDER_TOLERANCE}: {WHY_ORDER}"
        + (f" (or higher: {problem.at_least})" if problem.at_least else "")
        + f"; {WINDOW}; with a "
        f"tolerance, error ~ tolerance^p, p >= {LEAST_EXPONENT:g}; the same scheme in another engine has the same "
        "error at equal steps; evaluations counted exactly; CPU time is shown, not judged",
        citation=problem.citation,
        judge=partial(judge, problem=problem),
        variants=partial(_variants, problem=problem),
        faults=problem.faults,
        needs=replace(problem.needs, kinds=("stepping", "adaptive")),
        timing=True,
    )


def _variants(schemes: Mapping[str, Claims], problem: Problem) -> Iterable[Variant]:
    for name, claims in schemes.items():
        if claims.kind in ("stepping", "adaptive") and problem.accept(name, claims):
            tier: Tier = "quick" if name in problem.quick else "full"
            yield Variant(name, name, tier)


def family(claims: Claims) -> str:
    """The family of a scheme, from what it claims."""
    if claims.kind == "adaptive" or (claims.kind == "stepping" and claims.order is None):
        return "chooses its steps"
    if claims.kind != "stepping":
        return {"event_driven": "event-driven", "lattice": "lattice", "collision_search": "collision search"}[
            claims.kind
        ]
    if claims.symplectic:
        return "symplectic"
    assert claims.order is not None
    return "first order" if claims.order[0] == 1 else "not symplectic, order 2 or more"


# -- runs --------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Rung:
    """One step of a ladder. control: time step, tolerance or the like. runs: the same run, repeated."""

    control: float
    runs: tuple[Run, ...]

    @property
    def first(self) -> Run:
        """The first of the runs, which all give the same numbers."""
        return self.runs[0]

    @property
    def seconds(self) -> tuple[float, float, float]:
        """CPU time, s: median, least and largest."""
        cpu = [run.cost.cpu for run in self.runs]
        return float(np.median(cpu)), min(cpu), max(cpu)


def climbed(laboratory: Laboratory, scene: Scene, methods: Mapping[float, Method]) -> list[Rung]:
    """Runs a scene by several methods, in turns, so that a change of the machine's speed meets all.

    laboratory: runs them. methods: by what is varied.
    """
    runs: dict[float, list[Run]] = {control: [] for control in methods}
    for turn in range(REPEATS):
        for control, method in methods.items():
            made = runs[control]
            cpu = made[0].cost.cpu if made else 0.0
            if turn < (1 if cpu > VERY_LONG else FEWER if cpu > LONG else REPEATS):
                made.append(laboratory.run(scene, method, may_end_early=True))
    return [Rung(control, tuple(made)) for control, made in runs.items()]


def as_figure(
    title: str,
    unit: str,
    label: str,
    claims: Claims,
    control: str,
    rungs: list[Rung],
    errors: list[float],
    uncertainties: list[float],
    *,
    count: Callable[[Run], float] = lambda run: run.cost.evaluations,
    count_label: str = "evaluations of the force",
    lost: float = LOST,
) -> Figure:
    """The figure of a ladder. title: of the case. unit: what the error is, with its unit. label: of the method.

    claims: of its scheme. control: what is varied. rungs: the runs. errors, uncertainties: of each rung. count: of a
    run, 0 where it was not counted; count_label: what it is. lost: the error from which a run says nothing.
    """
    seconds = [rung.seconds for rung in rungs]
    counts = [float(count(rung.first)) for rung in rungs]
    failures = [_failure(rung.first, error, lost) for rung, error in zip(rungs, errors, strict=True)]
    ladder = Ladder(
        label=label,
        family=family(claims),
        control=control,
        controls=[rung.control for rung in rungs],
        error=errors,
        uncertainty=uncertainties,
        cpu=[one[0] for one in seconds],
        cpu_low=[one[1] for one in seconds],
        cpu_high=[one[2] for one in seconds],
        count=counts if all(counts) else [],
        count_label=count_label,
        failures=failures,
    )
    return Figure(title, "CPU time of a run/s", unit, "log", "log", ladder=ladder)


def _failure(run: Run, error: float, lost: float) -> str:
    if run.diverged:
        return "diverged"
    if run.stopped:
        return run.stopped
    return "error as large as what is computed" if not error < lost else ""


# -- the judge ---------------------------------------------------------------------------------------------------------


def expected_evaluations(engine: str, scheme: str, steps: int) -> int | None:
    """Evaluations of the force by this scheme of this engine, in `steps` steps and at the start; None if not known.

    engine, scheme: names.
    """
    if engine != "refimpl" and (engine, scheme) != ("lammps", "velocity_verlet"):
        return None
    start, each = evaluations_of(scheme)
    return start + steps * each


def methods_of(problem: Problem, scheme: str, claims: Claims) -> dict[float, Method]:
    """The methods of the ladder of a scheme, by time step or tolerance; one, if the step is only the first of many.

    problem: gives the ladder. scheme, claims: name and claims.
    """
    if claims.takes_tolerance:
        return {tolerance: Method(scheme=scheme, tolerance=tolerance) for tolerance in problem.tolerances}
    numbers = problem.numbers(claims).astype(int).tolist()
    steps = [problem.scene.duration / n for n in (numbers[:1] if claims.order is None else numbers)]
    return {dt: Method(scheme=scheme, dt=dt) for dt in steps}


def judge(laboratory: Laboratory, scheme: str, problem: Problem) -> Judged:
    """Runs the ladder of a scheme, and judges its order, its counts, and its error beside that of the same scheme.

    laboratory: runs it. scheme: its name. problem: the case.
    """
    claims = laboratory.claims[scheme]
    rungs = climbed(laboratory, problem.scene, methods_of(problem, scheme, claims))
    errors = [problem.error(rung.first) for rung in rungs]
    floors = [problem.floor(scheme, rung.first.cost.steps) for rung in rungs]
    control = "tolerance" if claims.takes_tolerance else "dt"
    figure = as_figure(problem.title, f"largest error/{problem.unit}", scheme, claims, control, rungs, errors, floors)
    judgements = _of_errors(problem, scheme, claims, rungs, errors, floors)
    judgements += _of_counts(laboratory, problem, scheme, rungs)
    judgements += _beside_others(laboratory, problem, scheme, rungs, errors)
    cost = rungs[-1].first.cost
    each = rungs[-1].seconds[0] / cost.evaluations * 1e9 if cost.evaluations else np.nan
    return worst(judgements, f"{each:.0f} ns an evaluation" if cost.evaluations else "", (figure,))


def _of_errors(
    problem: Problem, scheme: str, claims: Claims, rungs: list[Rung], errors: list[float], floors: list[float]
) -> list[Judgement]:
    """Exact to rounding; or the order in the asymptotic window; or how the error follows the tolerance."""
    biased = [floor * max(rung.first.cost.steps, 1) ** 0.5 for floor, rung in zip(floors, rungs, strict=True)]
    shares = [error / allowed for error, allowed in zip(errors, biased, strict=True)]
    if len(rungs) == 1 or max(shares) <= 1:
        k = int(np.argmax(shares))
        return [round_off(f"largest error/{problem.unit}", errors[k], biased[k], WHY_BIASED)]
    if not errors[-1] < LOST:
        quantity = f"error/{problem.unit} at the smallest step"
        return [bounded(quantity, errors[-1], LOST, "the finest run follows the motion: no other is asked for more")]
    counts = [rung.first.cost.evaluations for rung in rungs]
    controls = np.array([rung.control for rung in rungs])
    if claims.takes_tolerance:
        seen = observed_order(controls, errors, floors, ceiling=LOST)
        return [_at_least("exponent of the error in the tolerance", seen, LEAST_EXPONENT, _WHY_EXPONENT)]
    sizes = 1 / np.array(counts, dtype=np.float64) if all(counts) else controls
    seen, expected = observed_order(sizes, errors, floors, ceiling=LOST), problem.order(scheme, claims)
    if not seen.used and errors[-1] <= biased[-1]:  # once it is stable it is exact: no window of four runs in between
        note = f"{len(errors)} runs, of which {sum(not error < LOST for error in errors)} failed; {seen.reason}"
        quantity = f"error/{problem.unit} at the smallest step"
        return [round_off(quantity, errors[-1], biased[-1], WHY_BIASED, note=note)]
    if problem.at_least:
        least = expected - ORDER_TOLERANCE
        return [_at_least("order of the error, at least as claimed", seen, least, f"{WHY_ORDER}; {problem.at_least}")]
    return [judged_order("order of the error", seen, expected)]


def judged_order(quantity: str, seen: Observed, expected: float) -> Judgement:
    """The judgement that an observed order is the expected one; inconclusive where its interval is too wide to tell.

    quantity: what it is the order of. seen: the order. expected: what is claimed.
    """
    found = order(quantity, seen.value, expected, ORDER_TOLERANCE, _WHY_ORDER, uncertainty=seen.half, note=_note(seen))
    holds = seen.interval[0] - ORDER_TOLERANCE <= expected <= seen.interval[1] + ORDER_TOLERANCE
    if not seen.used or (seen.half > WIDEST and holds and not seen.leaves(expected)):
        return replace(found, outcome="inconclusive")
    if seen.leaves(expected):
        note = f"{found.note}; it goes away from the claimed order towards small steps, to {seen.finer:.3f}"
        return replace(
            found,
            outcome="fail",
            deviation=max(found.deviation or 0.0, abs(seen.finer - expected) / ORDER_TOLERANCE),
            note=note,
        )
    return found


def _at_least(quantity: str, seen: Observed, least: float, why: str) -> Judgement:
    """The judgement that an observed order is `least` or more: red if its whole interval is below."""
    found = bounded(quantity, seen.value, least, why, at_least=True, note=_note(seen))
    unknown = not seen.used or (found.outcome == "fail" and seen.interval[1] >= least)
    return replace(found, outcome="inconclusive") if unknown else found


def _note(seen: Observed) -> str:
    if not seen.used:
        return f"no asymptotic window: {seen.reason}"
    return f"{LEVEL:.0%} interval {seen.interval[0]:.3f} to {seen.interval[1]:.3f}, from {len(seen.used)} runs"


def _of_counts(laboratory: Laboratory, problem: Problem, scheme: str, rungs: list[Rung]) -> list[Judgement]:
    off = []
    for rung in rungs:
        steps = round(problem.scene.duration / rung.control)
        expected = expected_evaluations(laboratory.engine, scheme, steps)
        if expected is None:
            return []
        # a run that diverged has taken fewer steps
        off += [abs(run.cost.evaluations - expected) for run in rung.runs if not run.diverged]
    return [
        round_off(
            "evaluations miscounted", max(off, default=0), 0.5, "a count: steps times those of a step, and the start's"
        )
    ]


def _beside_others(
    laboratory: Laboratory, problem: Problem, scheme: str, rungs: list[Rung], errors: list[float]
) -> list[Judgement]:
    """The error at equal steps of an engine that runs a scheme of the reference engine."""
    same = SAME_STEPS.get((laboratory.engine, scheme))
    if same is None or not problem.same_steps:
        return []
    rung, error = rungs[1], errors[1]
    run = laboratory.run(problem.scene, Method(scheme=same, dt=rung.control), engine="refimpl")
    allowed = 2 * problem.floor(scheme, rung.first.cost.steps)
    return [
        round_off(
            f"difference of the error from that of refimpl at equal dt/{problem.unit}",
            error - problem.error(run),
            allowed,
            _WHY_SAME,
        )
    ]
