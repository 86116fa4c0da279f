"""What a check is, and the laboratory that it works in.

To add one: a module in `crosscheck/checks/` whose `CHECKS` is a tuple of `Check`, each with a planted fault.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

from crosscheck.engines.protocol import Claims, Cost, Run
from crosscheck.engines.workers.pool import Pool
from crosscheck.faults import Fault
from crosscheck.scene import Contact, Method, Scene
from crosscheck.verdict import Judgement

#: Hard spheres, from event to event.
EVENT_DRIVEN = Method(scheme="event_driven")
Tier = Literal["quick", "full"]
#: Variants of a check for an engine with these schemes.
Variants = Callable[[str, dict[str, Claims]], tuple[str, ...]]


@dataclass
class Laboratory:
    """Where one check judges one engine: runs scenes, adds up what they cost, hands out seeds.

    engine: the engine under judgement. claims: what it says of its schemes.
    """

    engine: str
    claims: dict[str, Claims]
    pool: Pool
    case: str
    suite_seed: int = 0
    cost: Cost = field(default_factory=Cost)

    def run(self, scene: Scene, method: Method, engine: str | None = None) -> Run:
        """Runs `scene` on the engine under judgement, or on another one as its reference."""
        run = self.pool.worker(engine or self.engine).run(scene, method)
        for name, value in asdict(run.cost).items():
            before = getattr(self.cost, name)
            setattr(self.cost, name, max(before, value) if name == "peak_bytes" else before + value)
        return run

    def seed(self, purpose: str = "") -> int:
        """A seed from the check's identity and the suite's seed: the same case always gets the same one."""
        text = f"{self.suite_seed}/{self.case}/{purpose}"
        return int.from_bytes(hashlib.sha256(text.encode()).digest()[:4])


@dataclass(frozen=True)
class Check:
    """One phenomenon: scene, engines, observable, reference and criterion.

    name: `group/phenomenon`; a variant (a scheme, an eccentricity ...) is appended to it. variants: which ones an
    engine gets; `(engine, schemes) -> names`. judge: measures one variant. engines: those of the suite's own engines
    that can do it; somebody else's engine is tried on every check. timing: run alone, nothing else beside it. faults:
    (variant, planted bug of `refimpl` that must turn it red).
    """

    name: str
    title: str
    equation: str
    criterion: str
    citation: str
    judge: Callable[[Laboratory, str], Judgement]
    variants: Variants
    faults: tuple[tuple[str, Fault], ...]
    engines: tuple[str, ...] = ("refimpl",)
    tier: Tier = "quick"
    timing: bool = False


def reference_check(
    name: str,
    title: str,
    equation: str,
    criterion: str,
    citation: str,
    judge: Callable[[Laboratory, str], Judgement],
    variants: Sequence[str],
    faults: tuple[tuple[str, Fault], ...],
    tier: Tier = "full",
) -> Check:
    """A check of the reference implementation alone, with the same variants always."""
    return Check(name, title, equation, criterion, citation, judge, fixed(*variants), faults, tier=tier)


def soft(**contact: Any) -> Method:
    """Hard spheres as soft ones, with these entries of a `Contact`."""
    return Method(scheme="velocity_verlet", contact=Contact(**contact))


def fixed(*names: str) -> Variants:
    """The same variants for every engine."""
    return lambda engine, schemes: names


def schemes_with(accept: Callable[[str, Claims], bool] = lambda name, claims: True) -> Variants:
    """One variant per scheme of the engine that takes time steps and that `accept` accepts."""
    return lambda engine, schemes: tuple(
        name for name, claims in schemes.items() if claims.stepping and accept(name, claims)
    )
