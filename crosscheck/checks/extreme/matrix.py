"""The matrix of stiff and extreme cases: what each case must give with each method, declared as data and judged by it.

A row is a case with a method: its expectations are numbers with tolerances, bounds, or the exact sentence of a refusal.
The same rows judge the runs, and are the table of docs/extreme.md and of the report.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple, TypeAlias

from pydantic import ValidationError

from crosscheck.checks.base import Check, Laboratory, Tier, Variant
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Claims, Kind, Run
from crosscheck.engines.registry import engine_class
from crosscheck.errors import EngineError, Unsupported, UsageError
from crosscheck.faults import Fault
from crosscheck.figure import Figure
from crosscheck.scene import Contact, Method, Scene
from crosscheck.scene.messages import explain
from crosscheck.verdict import Findings, Judgement, bounded, statistical, within, worst

#: What all names of these checks begin with.
GROUP = "extreme/"
#: What the quantity of a judgement on words begins with; the words follow.
ANSWER = "answers that are not: "
#: The answer of a run that went to its end, with nothing to remark.
RAN = "ran"
DIVERGED = "diverged"
#: Why an answer is expected in exact words.
SENTENCE = "what the documentation promises: one line that says what, where, and the mend"


class Value(NamedTuple):
    """|measured - expected| <= tolerance.

    quantity: name and unit of the number. why: the reason for the tolerance. kind: of the criterion.
    """

    quantity: str
    expected: float
    tolerance: float
    why: str
    kind: Literal["round_off", "order"] = "round_off"

    @property
    def text(self) -> str:
        """The expectation as it stands in a table."""
        return f"{self.quantity} = {self.expected:.10g} ± {self.tolerance:.2g}"

    def judged(self, measured: Measured) -> Judgement:
        """The judgement of what was measured; measured: in the row."""
        number = float(measured.numbers[self.quantity])
        return within(self.kind, self.quantity, number, self.expected, self.tolerance, self.why)


class Bound(NamedTuple):
    """measured <= limit, or >= with `at_least`.

    quantity: name and unit of the number. why: the reason for the limit.
    """

    quantity: str
    limit: float
    why: str
    at_least: bool = False

    @property
    def text(self) -> str:
        """The expectation as it stands in a table."""
        return f"{self.quantity} {'≥' if self.at_least else '≤'} {self.limit:.4g}"

    def judged(self, measured: Measured) -> Judgement:
        """The judgement of what was measured; measured: in the row."""
        number = float(measured.numbers[self.quantity])
        return bounded(self.quantity, number, self.limit, self.why, at_least=self.at_least)


class Mean(NamedTuple):
    """|measured - expected| <= t u + doubt, of a mean whose standard error u is measured too.

    quantity: name and unit of the number. why: the reason for what is expected. doubt: what is not random.
    """

    quantity: str
    expected: float
    why: str
    doubt: float = 0.0

    @property
    def text(self) -> str:
        """The expectation as it stands in a table."""
        return f"{self.quantity} = {self.expected:.10g} within its standard error"

    def judged(self, measured: Measured) -> Judgement:
        """The judgement of what was measured; measured: in the row."""
        number, (error, samples) = float(measured.numbers[self.quantity]), measured.errors[self.quantity]
        return statistical(
            self.quantity, number, error, self.expected, 0.0, self.why, samples=samples, doubt=self.doubt
        )


class Answer(NamedTuple):
    """How the run must end: `RAN`, `DIVERGED`, or "refused: ...", "stopped: ...", "remarked: ..." with exact words.

    Without a colon the words of the engine do not count, as those of its own errors ("failed"); nor do they of an
    engine that does not come with the suite. why: who promises these words.
    """

    words: str
    why: str

    @property
    def text(self) -> str:
        """The expectation as it stands in a table."""
        return f'"{self.words}"' if ":" in self.words else self.words

    def judged(self, measured: Measured) -> Judgement:
        """The judgement of what was measured; measured: in the row."""
        found = measured.answer
        same = found == self.words
        if not measured.shipped or ":" not in self.words:
            same = found.partition(":")[0] == self.words.partition(":")[0]
        return bounded(f"{ANSWER}{self.words}", float(not same), 0.0, self.why, note=f"answer: {found}")


Expected: TypeAlias = Value | Bound | Mean | Answer


class Measured(NamedTuple):
    """What was measured in a row.

    numbers: by quantity. answer: see `Answer`. note, figures: of the verdict. shipped: by an engine of the suite.
    errors: of means, standard error and number of independent samples, by quantity.
    """

    numbers: Mapping[str, float]
    answer: str = ""
    note: str = ""
    figures: tuple[Figure, ...] = ()
    shipped: bool = True
    errors: Mapping[str, tuple[float, float]] = {}


@dataclass(frozen=True)
class Trial:
    """What a case is measured with: the laboratory, and a method by its name.

    laboratory: runs scenes. method: the name of a scheme, or of a kind of schemes, whose first one is taken.
    """

    laboratory: Laboratory
    method: str

    def how(self, dt: float | None = None, contact: Contact | None = None) -> Method | Kind:
        """The method with a time step, and a contact of soft spheres. dt: time. contact: see `Method`."""
        if self.method in self.laboratory.claims:
            return Method(scheme=self.method, dt=dt, contact=contact)
        kind: Any = self.method
        return kind

    @property
    def takes_no_step(self) -> bool:
        """Whether the method has no time step."""
        claims = self.laboratory.claims.get(self.method)
        return not claims.takes_dt if claims is not None else self.method not in ("stepping", "collision_search")

    def run(
        self, scene: Scene, dt: float | None = None, contact: Contact | None = None, *, may_end_early: bool = False
    ) -> Run:
        """Runs a scene; dt, contact: as in `how`. may_end_early, errors: as in `Laboratory.run`."""
        return self.laboratory.run(scene, self.how(dt, contact), may_end_early=may_end_early)

    def answer(
        self, scene: Callable[[], Scene], dt: float | None = None, contact: Contact | None = None
    ) -> tuple[str, Run | None]:
        """How a run of a scene ended, in the words of `Answer`, and the run; None if it was refused.

        scene: makes it, which may be what is refused. dt, contact: as in `how`.
        """
        try:
            run = self.run(scene(), dt, contact, may_end_early=True)
        except ValidationError as error:
            return f"refused: {explain(error, 'scene', Scene)}", None
        except (UsageError, Unsupported) as error:
            return f"refused: {error}", None
        except EngineError as error:
            return f"failed: {str(error).partition(chr(10))[0]}", None
        if run.stopped:
            return f"stopped: {run.stopped}", run
        if run.diverged:
            return DIVERGED, run
        return (f"remarked: {' '.join(run.remarks)}" if run.remarks else RAN), run


#: What measures a case.
Measure: TypeAlias = Callable[[Trial], Mapping[str, float] | Measured]


@dataclass(frozen=True)
class Case:
    """An extreme case.

    name: of its variants, before the method's. what: the case in words, for the table. measure: runs it. expected: what
    must come out, by method: the name of a scheme, or of a kind of schemes ("event_driven", "lattice"), with
    "@engine" after it for one engine alone. tier: of its variants. needs: beside those of its check.
    """

    name: str
    what: str
    measure: Measure
    expected: Mapping[str, tuple[Expected, ...]]
    tier: Tier = "quick"
    needs: Needs | None = None

    @property
    def methods(self) -> list[str]:
        """The names of its methods, each once."""
        return list(dict.fromkeys(name.partition("@")[0] for name in self.expected))

    def expectations(self, method: str, engine: str) -> tuple[Expected, ...]:
        """What an engine must give. method: its name. engine: that of the engine. KeyError for an unknown method."""
        return self.expected.get(f"{method}@{engine}") or self.expected[method]


class Row(NamedTuple):
    """The value of a variant: `case`, with one of its methods. method: its name."""

    case: Case
    method: str


def for_each(methods: Iterable[str], *expected: Expected) -> dict[str, tuple[Expected, ...]]:
    """The same expectations for several methods; methods: their names. expected: of each."""
    return dict.fromkeys(methods, expected)


def judge(laboratory: Laboratory, row: Row) -> Findings:
    """The findings of a row: every expectation, in the order of the table; laboratory: runs it."""
    found = row.case.measure(Trial(laboratory, row.method))
    measured = found if isinstance(found, Measured) else Measured(found)
    measured = measured._replace(shipped=engine_class(laboratory.engine).__module__.startswith("crosscheck."))
    judgements = [one.judged(measured) for one in row.case.expectations(row.method, laboratory.engine)]
    return replace(worst(judgements, figures=measured.figures), note=measured.note or judgements[0].note)


def _variants(cases: tuple[Case, ...], schemes: Mapping[str, Claims]) -> Iterable[Variant]:
    known = {*schemes, *(claims.kind for claims in schemes.values())}
    for case in cases:
        for method in case.methods:
            if method in known:
                yield Variant(f"{case.name}/{method}", Row(case, method), case.tier, case.needs)


def extreme_check(
    name: str,
    title: str,
    equation: str,
    citation: str,
    cases: tuple[Case, ...],
    needs: Needs | tuple[Needs, ...],
    faults: tuple[tuple[str, Fault], ...],
    *,
    interpreted: bool = True,
) -> Check:
    """The check of some cases of the matrix.

    name: behind the group's. title, equation, citation, needs, faults, interpreted: as in `Check`.
    """
    return Check(
        name=f"{GROUP}{name}",
        title=title,
        equation=equation,
        criterion="what the matrix of docs/extreme.md declares for each case and method",
        citation=citation,
        judge=judge,
        variants=lambda schemes: _variants(cases, schemes),
        needs=needs,
        faults=faults,
        interpreted=interpreted,
    )
