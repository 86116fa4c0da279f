"""Pages of what is registered: observables, engines with what they declare, schemes with their claims, and checks."""

from __future__ import annotations

from crosscheck.checks import all_checks
from crosscheck.checks.base import TIERS, Check
from crosscheck.documents.markdown import page, table_of
from crosscheck.engines.capabilities import Capability
from crosscheck.engines.protocol import Engine
from crosscheck.engines.registry import engine_class, shipped_engines
from crosscheck.runner import unmatched
from crosscheck.scene.observables import TABLE
from crosscheck.scene.parts import INTERACTIONS


def _shipped() -> dict[str, type[Engine]]:
    """The engines that come with the suite, so that a page does not depend on what else is installed."""
    return {name: engine_class(name) for name in shipped_engines()}


_OBSERVABLES = """\
What a run can be asked for: `output.observables` takes the names of those that are asked for by name. Shapes: d is
the dimension of space, N the number of particles, b the number of channels of a lattice gas; samples contain the
start. Units are those of the scene. Cumulative ones are summed or integrated from the start of the run to the sample.
Derived ones are computed by the suite, for every engine that measures what they need."""
_ENGINES = """\
What the engines that come with the suite declare; whatever an engine does not declare is refused for it, with the
reason. A column is a capability: an engine with its schemes. Words are entries of a scene
([scene-words.md](scene-words.md)); `entry=choice` is one of its values, `entry[]` one value per species, `masses[]`
unlike masses. What is not listed here, every engine takes from the scene (box sides, initial state, seeds)."""
_SCHEMES = """\
`method.scheme` takes these names. An engine claims orders of the global error of position and velocity, for forces
f(r) and f(r, v), and whether the map from start to end is symplectic and reversible: the checks hold it to that. A
dash: nothing is claimed, and nothing is checked."""
_CHECKS = """\
Every check, with the shipped engines that it judges and the number of its variants in each tier (the full tier
contains the quick one; the small one is for [slow codes](../slow-codes.md)). `crosscheck show NAME` prints equation,
needs, variants and planted faults."""


# -- observables -------------------------------------------------------------------------------------------------------

_MATTER = {
    "any": "any scene",
    "particles": "particles",
    "smooth_particles": "particles with smooth forces",
    "hard_spheres": "hard spheres",
    "lattice_gas": "lattice gas",
}
_ASKED = {
    "always": "always there",
    "trajectory": "`output.trajectory`",
    "forces": "`output.forces`",
    "trace": "`output.trace`",
    "fields": "`output.fields`",
    "observables": "its name",
}


def observables() -> str:
    """The page of the table of observables."""
    rows = []
    for row in TABLE.values():
        how = (
            "derived from " + ", ".join(row.needs) if row.needs else "cumulative" if row.cumulative else "of the moment"
        )
        meaning = row.meaning if row.requires is None else f"{row.meaning}; needs `[{row.requires[0]}]`"
        rows.append((f"`{row.name}`", _MATTER[row.matter], _ASKED[row.asked], row.shape, row.unit, how, meaning))
    head = ("name", "of", "asked for by", "shape", "unit", "kind", "meaning")
    return page("Observables", [*_OBSERVABLES.splitlines(), "", *table_of(head, rows)])


# -- engines -----------------------------------------------------------------------------------------------------------


def engines() -> str:
    """The page of what the shipped engines declare, one table per interaction."""
    lines = _ENGINES.splitlines()
    for interaction in INTERACTIONS:
        columns = [
            (name, engine, one)
            for name, engine in _shipped().items()
            for one in engine.capabilities
            if one.interaction == interaction
        ]
        head = [f"{name}: {_served(engine, one)}" for name, engine, one in columns]
        words = sorted({word for *_, one in columns for word in one.words})
        measured = [name for name in TABLE if any(name in one.observables for *_, one in columns)]
        rows = [(f"`{word}`", *("yes" if word in one.words else "" for *_, one in columns)) for word in words]
        rows += [
            (f"observable `{name}`", *("yes" if name in one.observables else "" for *_, one in columns))
            for name in measured
        ]
        lines += ["", f"## `[{interaction}]`", "", *table_of(("word or observable", *head), rows)]
    return page("What the engines declare", lines)


def _served(engine: type[Engine], one: Capability) -> str:
    """The schemes of a capability: all of its kind, or their names."""
    if not one.schemes:
        return f"{_KINDS[one.kind]} schemes"
    return ", ".join(one.schemes)


# -- schemes -----------------------------------------------------------------------------------------------------------

_KINDS = {
    "stepping": "time-step",
    "adaptive": "adaptive",
    "event_driven": "event-driven",
    "collision_search": "collision-search",
    "lattice": "lattice",
}


def schemes() -> str:
    """The page of all schemes of the shipped engines, with their claims."""
    rows = [
        (
            f"`{scheme}`",
            name,
            _KINDS[claims.kind],
            _order(claims.order),
            _order(claims.order_damped),
            _claim(claims.symplectic),
            _claim(claims.reversible),
        )
        for name, engine in _shipped().items()
        for scheme, claims in engine.schemes.items()
    ]
    head = ("scheme", "engine", "kind", "order, f(r)", "order, f(r, v)", "symplectic", "reversible")
    return page("Schemes", [*_SCHEMES.splitlines(), "", *table_of(head, rows)])


def _order(order: tuple[int, int] | None) -> str:
    return "-" if order is None else f"{order[0]}, {order[1]}"


def _claim(value: bool | None) -> str:
    return "-" if value is None else "yes" if value else "no"


# -- checks ------------------------------------------------------------------------------------------------------------


def checks() -> str:
    """The page of all checks, one section per group."""
    groups: dict[str, list[Check]] = {}
    for check in all_checks():
        groups.setdefault(check.name.partition("/")[0], []).append(check)
    lines = _CHECKS.splitlines()
    for group, members in groups.items():
        rows = []
        for check in members:
            judged = [name for name, engine in _shipped().items() if unmatched(check, name, engine) is None]
            variants = {one.name: one.tier for name in judged for one in check.offered(_shipped()[name].schemes)}
            tiers = list(variants.values())
            counts = [str(tiers.count(tier) or "") for tier in TIERS]
            rows.append((f"`{check.name}`", ", ".join(judged), *counts, check.title, check.criterion, check.citation))
        head = ("check", "engines", *TIERS, "measures", "criterion", "citation")
        lines += ["", f"## {group}", "", *table_of(head, rows)]
    return page("Checks", lines)
