"""The page of the matrix of stiff and extreme cases: docs/extreme.md."""

from __future__ import annotations

from collections.abc import Iterator

from crosscheck.checks import all_checks
from crosscheck.checks.base import Check, Tier
from crosscheck.checks.extreme.matrix import GROUP, Expected, Row
from crosscheck.documents.markdown import page, table_of
from crosscheck.engines.registry import engine_class, shipped_engines
from crosscheck.runner import judging

_HEAD = """\
What stiff and extreme scenes must give, case by method: a value with its tolerance, a bound, or the exact words of a
refusal. `crosscheck run 'extreme/*'` judges every row; `crosscheck show extreme/springs` says what one check asks of an
engine. Each tolerance comes from rounding, from the order of the method or from theory, and says which. A row without a
mark belongs to the quick tier; "full" marks those of `--tier full`.

A case that goes on without a word is a claim too: `ran` says that nothing is refused or remarked on, and the value
beside it says what the run is worth. In particular:

* A step that is too large for a Lennard-Jones pair at half a sigma, or for a soft contact, is taken as it is: the
  velocity after it is the scheme's own, exactly, and the energy is wrong by orders of magnitude. Contacts of less than
  ten steps are remarked on; smooth forces are not, look at the energy (`crosscheck simulate --judge` does).
* The energy of velocity Verlet walks at random with the roundings of the steps, over 1e8 steps, if the binary digits of
  omega dt have no short period. With omega dt = 0.1, 0.2, 0.3 or 0.7, whose digits repeat after four, roundings of
  products repeat too, and the walk becomes a drift after some 1e5 steps, of 2e-19 a step. Compensated summation
  (`method.compensated = true`, for velocity Verlet) makes what rounding does smaller by a factor of omega dt, and takes
  the drift away where steps are small: see [schemes.md](schemes.md) for its price.
* Events at one time that share no particle come in any order with the same result, bit for bit. Where they share one,
  the order of the particles decides, and the run says so.
* Units do not matter: lengths, times and masses may be multiplied by powers of two from 1e-20 to 1e20, and no bit
  changes. LAMMPS cannot sort particles into its cells where lengths are 1e-20 or 1e20.

The maps of stability are in the report, with the boundary from the eigenvalues of each scheme's step matrix."""

#: How the tiers are marked.
_MARKS: dict[Tier, str] = {"small": "small", "quick": "", "full": "full"}


def _rows(check: Check) -> Iterator[tuple[Row, Tier, str]]:
    """Every row of a check with the tier and an engine that it judges, by case and method."""
    found: dict[tuple[str, str], list[tuple[Row, Tier, str]]] = {}
    for engine in shipped_engines():
        for variant in judging(check, engine, engine_class(engine)):
            row = variant.value
            found.setdefault((row.case.name, row.method), []).append((row, variant.tier, engine))
    for several in found.values():
        yield from several


def _groups(check: Check) -> Iterator[tuple[str, Tier, list[str], tuple[Expected, ...]]]:
    """What a case is, its tier, the methods and engines with the same expectations, and these."""
    merged: dict[tuple[str, str, Tier, tuple[Expected, ...]], list[str]] = {}
    for row, tier, engine in _rows(check):
        expected = row.case.expectations(row.method, engine)
        methods = merged.setdefault((row.case.name, row.case.what, tier, expected), [])
        methods.append(f"`{row.method}` ({engine})")
    for (_, what, tier, expected), methods in merged.items():
        yield what, tier, methods, expected


def extreme() -> str:
    """The page of the matrix, a table a check."""
    lines = _HEAD.splitlines()
    for check in all_checks():
        if not check.name.startswith(GROUP):
            continue
        rows = []
        for what, tier, methods, expected in _groups(check):
            texts = "<br>".join(one.text for one in expected)
            reasons = "<br>".join(dict.fromkeys(one.why for one in expected))
            rows.append((what, "<br>".join(_short(methods)), texts, reasons, _MARKS[tier]))
        head = ("case", "methods", "expected", "because of", "tier")
        lines += ["", f"## {check.name}", "", f"{check.title}. {check.citation}.", "", *table_of(head, rows)]
    return page("Stiff and extreme cases", lines)


def _short(methods: list[str]) -> list[str]:
    """Methods of one engine in one line: "`a`, `b` (engine)"."""
    by_engine: dict[str, list[str]] = {}
    for one in methods:
        name, _, engine = one.partition(" ")
        by_engine.setdefault(engine, []).append(name)
    return [f"{', '.join(names)} {engine}" for engine, names in by_engine.items()]
