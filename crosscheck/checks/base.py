"""What a check is, and the laboratory that it works in.

To add one: a file in the folder of its group, `crosscheck/checks/<group>/`, whose `CHECKS` is a tuple of `Check`, each
with a planted fault. It is found by being there.
"""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, get_args

from crosscheck.engines.capabilities import Needs, refusal, scheme_of
from crosscheck.engines.protocol import Claims, Cost, Kind, Run
from crosscheck.engines.registry import engine_class
from crosscheck.engines.workers.pool import Pool, Worker
from crosscheck.errors import EndedEarly, EngineError, Unsupported
from crosscheck.faults import Fault
from crosscheck.pairs import Pair, Row
from crosscheck.scene import Contact, Method, Scene
from crosscheck.verdict import Judged

#: "small": a variant in the place of a larger one, for codes that are too slow for that; the full tier contains the
#: quick one.
Tier = Literal["small", "quick", "full"]
TIERS: tuple[Tier, ...] = get_args(Tier)
#: A method by its kind: the engine's own first scheme that goes from event to event.
EVENT_DRIVEN: Kind = "event_driven"


@dataclass(frozen=True)
class Variant:
    """One of the cases of a check on every engine: its name, its parameters, and the tier that it belongs to.

    name: seeds the case: not to be changed without reason. value: what `Check.judge` gets. needs: what this variant
    asks of an engine beside what its check asks. instead: of the small tier, the name of the larger variant that it
    stands for.
    """

    name: str
    value: Any
    tier: Tier = "quick"
    needs: Needs | None = None
    instead: str = ""


#: The variants of a check; or, where they are schemes, a function of those that the engine has.
Variants = tuple[Variant, ...] | Callable[[Mapping[str, Claims]], Iterable[Variant]]


@dataclass(frozen=True)
class FeatureRows:
    """Features that a check combines, and in which rows: for the table of what is judged together.

    factors: the levels of each feature, the first one its absence. rows: returns the rows that the check judges, all
    factors in each, and the pairs of levels that no scene has.
    """

    factors: Mapping[str, Sequence[str]]
    rows: Callable[[], tuple[list[Row], set[Pair]]]


@dataclass
class Laboratory:
    """What a check's `judge` works with, for one case: it runs scenes, adds up their cost, and derives random seeds.

    engine: name of the engine under judgement. claims: what that engine declares of its schemes, by scheme. pool: the
    worker processes that engines run in. case: `check/variant`, from which all seeds of the case are derived.
    suite_seed: seed of the whole run of the suite, from which they are derived too. cost: of all runs so far, summed;
    of the peak memory, the largest. interpreted: see `Check`. refused: scenes that the engine under judgement cannot
    run, by their names: a check may go on without them, and judge less than it would.
    """

    engine: str
    claims: dict[str, Claims]
    pool: Pool
    case: str
    suite_seed: int = 0
    cost: Cost = field(default_factory=Cost)
    interpreted: bool = False
    refused: list[str] = field(default_factory=list)

    def run(
        self,
        scene: Scene,
        method: Method | Kind,
        engine: str | None = None,
        *,
        may_end_early: bool = False,
        interpreted: bool | None = None,
    ) -> Run:
        """Runs `scene`, and adds the cost of the run to `cost`.

        method: or a kind of scheme, of which the engine's first one for this interaction is taken. engine: name of
        another engine, as a reference; by default that under judgement. may_end_early: the check judges a run that
        diverged, or stopped (inelastic collapse), itself. Otherwise such a run ends the case: EndedEarly if it is of
        the engine under judgement, EngineError if it is of a reference. Unsupported if the engine has no scheme of that
        kind for this interaction; the errors of the engine (see `crosscheck.errors`) pass through. interpreted: whether
        an engine that promises `interpretable` runs as plain Python; None: as the check says.
        """
        name = engine or self.engine
        worker = self._worker(name, self.interpreted if interpreted is None else interpreted)
        with self._noting_refusals(name, scene):
            run = worker.run(scene, method if isinstance(method, Method) else _of_kind(name, scene, method))
        return self._taken(name, scene, run, may_end_early)

    def run_in_two(self, scene: Scene, method: Method | Kind) -> tuple[Run, Run]:
        """Runs `scene` in two halves, the second one from the state that the first one leaves; both runs.

        method: as in `run`; so are the errors. EngineError if the engine leaves no state.
        """
        worker = self._worker(self.engine, self.interpreted)
        half = scene.changed(duration=scene.duration / 2)
        with (
            self._noting_refusals(self.engine, scene),
            tempfile.TemporaryDirectory(prefix="crosscheck-halves-") as directory,
        ):
            how = method if isinstance(method, Method) else _of_kind(self.engine, scene, method)
            middle, end = (Path(directory) / f"{name}.npz" for name in ("middle", "end"))
            first = self._taken(self.engine, scene, worker.run(half, how, keep=middle))
            if not middle.exists():
                raise EngineError(f"{self.engine}: it leaves no state at the end of scene {scene.name} to go on from")
            second = self._taken(self.engine, scene, worker.run(half, how, restart=middle, keep=end))
        return first, second

    def refusal(self, scene: Scene, method: Method) -> str | None:
        """None, or why the engine under judgement does not declare what a scene and a method need, see `capabilities`.

        scene, method: what would be run.
        """
        reason = refusal(engine_class(self.engine), scene, method)
        self.refused.extend([] if reason is None else [scene.name])
        return reason

    @contextmanager
    def _noting_refusals(self, engine: str, scene: Scene) -> Iterator[None]:
        """Notes that the engine under judgement refuses the scene, where it does so within the block."""
        try:
            yield
        except Unsupported:
            self.refused.extend([scene.name] if engine == self.engine else [])
            raise

    def demand(self, scene: Scene, method: Method | Kind) -> None:
        """Unsupported, EngineMissing, as from `run`, if the engine under judgement would not run `scene`.

        For checks that run another engine first: what is not judged shall cost nothing. scene, method: as in `run`; of
        the scene, all but the initial state and the duration should be what will be run.
        """
        how = method if isinstance(method, Method) else _of_kind(self.engine, scene, method)
        reason = self._worker(self.engine, self.interpreted).supports(scene, how)
        if reason is not None:
            raise Unsupported(f"{self.engine}: {reason}")

    def _worker(self, name: str, interpreted: bool) -> Worker:
        return self.pool.worker(name, interpreted and "interpretable" in getattr(engine_class(name), "promises", ()))

    def _taken(self, name: str, scene: Scene, run: Run, may_end_early: bool = False) -> Run:
        """The run, whose cost is added; EndedEarly or EngineError if it ended early."""
        self.cost.add(run.cost)
        if (run.diverged or run.stopped) and not may_end_early:
            reason = f"{name}, scene {scene.name}: the run {'diverged' if run.diverged else f'stopped: {run.stopped}'}"
            raise (EndedEarly if name == self.engine else EngineError)(reason)
        return run

    def seed(self, purpose: str = "") -> int:
        """A seed of 32 bits, derived from `suite_seed`, `case` and `purpose`: for the same three always the same.

        purpose: tells several seeds of one case apart, such as those of independent runs.
        """
        text = f"{self.suite_seed}/{self.case}/{purpose}"
        return int.from_bytes(hashlib.sha256(text.encode()).digest()[:4])


def _of_kind(engine: str, scene: Scene, kind: Kind) -> Method:
    scheme = scheme_of(engine_class(engine), scene.interaction, kind)
    if scheme is None:
        raise Unsupported(f"{engine}: no {kind} scheme for [{scene.interaction}]")
    return Method(scheme=scheme)


@dataclass(frozen=True)
class Check:
    """One phenomenon: scene, observable, reference and criterion.

    features: those of which it judges all pairs; None: none.

    name: `group/phenomenon`; a variant (a scheme, an eccentricity ...) is appended to it. title: the phenomenon in one
    line. equation: what is compared, as a formula in plain text. criterion: what passes, in words. citation: the
    literature. judge: measures one variant, given a laboratory and the variant's value. variants: see `Variants`.
    needs: what an engine must declare to be judged, own or foreign; several: all of them. faults: (variant, planted bug
    of `refimpl` that must turn it red). reference: engines, one or several, that this check compares with, and
    therefore does not judge. timing: run alone, nothing else beside it. interpreted: its scenes are so small that
    compiling would take longer than running: an engine that promises `interpretable` runs as plain Python.
    """

    name: str
    title: str
    equation: str
    criterion: str
    citation: str
    judge: Callable[[Laboratory, Any], Judged]
    variants: Variants
    faults: tuple[tuple[str, Fault], ...]
    needs: Needs | tuple[Needs, ...]
    reference: str | tuple[str, ...] | None = None
    timing: bool = False
    interpreted: bool = False
    features: FeatureRows | None = None

    @property
    def all_needs(self) -> tuple[Needs, ...]:
        """The needs as a tuple, of one too."""
        return self.needs if isinstance(self.needs, tuple) else (self.needs,)

    def offered(self, schemes: Mapping[str, Claims]) -> tuple[Variant, ...]:
        """The variants for an engine with these schemes; schemes: its claims, by scheme."""
        return self.variants if isinstance(self.variants, tuple) else tuple(self.variants(schemes))


def quick(*names: str, **values: Any) -> tuple[Variant, ...]:
    """Variants of the quick tier: `names`, whose value is the name itself, then `values`, each with the value given."""
    return variants_of({**dict(zip(names, names, strict=True)), **values}, "quick")


def full(*names: str, **values: Any) -> tuple[Variant, ...]:
    """Variants of the full tier: `names`, whose value is the name itself, then `values`, each with the value given."""
    return variants_of({**dict(zip(names, names, strict=True)), **values}, "full")


def small(name: str, value: Any, instead: str) -> Variant:
    """A variant of the small tier; name, value, instead: as in `Variant`."""
    return Variant(name, value, "small", instead=instead)


def variants_of(values: Mapping[str, Any], tier: Tier = "quick") -> tuple[Variant, ...]:
    """Variants of one `tier`; values: the value of each, by the variant's name."""
    return tuple(Variant(name, value, tier) for name, value in values.items())


def schemes_with(
    accept: Callable[[str, Claims], bool] = lambda name, claims: True,
    tier: Callable[[str], Tier] = lambda name: "quick",
) -> Callable[[Mapping[str, Claims]], Iterable[Variant]]:
    """One variant per scheme of the engine that takes time steps under forces and that `accept` accepts.

    accept: of a scheme's name and claims. tier: that of the variant, by the scheme's name.
    """
    return lambda schemes: (
        Variant(name, name, tier(name))
        for name, claims in schemes.items()
        if claims.kind == "stepping" and accept(name, claims)
    )


def soft(**contact: Any) -> Method:
    """The method that runs hard spheres as soft ones by velocity Verlet; contact: entries of a `scene.Contact`."""
    return Method(scheme="velocity_verlet", contact=Contact(**contact))
