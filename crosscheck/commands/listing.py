"""Commands that print what there is: checks, engines, and the report of a run."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

from rich.table import Table

from crosscheck import runner
from crosscheck.checks import all_checks
from crosscheck.checks.base import TIERS, Check, Variant
from crosscheck.commands.console import plain, say_if_torn, wide_console
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.registry import engine_class, engine_names
from crosscheck.engines.workers.pool import Worker
from crosscheck.errors import EngineError, EngineMissing


def _variants_by_engine(check: Check) -> dict[str, tuple[Variant, ...]]:
    """The variants of a check, by name of those installed engines that it judges."""
    offers = {name: runner.judging(check, name, engine_class(name)) for name in engine_names()}
    return {name: variants for name, variants in offers.items() if variants}


def list_checks(as_json: bool) -> None:
    """Prints every check with its engines, the number of its variants in each tier, and its title.

    as_json: print all variants and faults, as JSON, instead of a table.
    """
    rows = []
    for check in all_checks():
        offers = _variants_by_engine(check)
        rows.append(
            {
                "check": check.name,
                "title": check.title,
                "engines": list(offers),
                "variants": {
                    engine: [{"name": one.name, "tier": one.tier} for one in variants]
                    for engine, variants in offers.items()
                },
                "faults": [fault.name for _, fault in check.faults],
            }
        )
    if as_json:
        print(json.dumps(rows, indent=2))
        return
    table = Table("check", "engines", *TIERS, "measures", box=None, pad_edge=False)
    for check in all_checks():
        offers = _variants_by_engine(check)
        tiers = Counter({one.name: one.tier for variants in offers.values() for one in variants}.values())
        counts = [str(tiers[tier]) if tiers[tier] else "" for tier in TIERS]
        table.add_row(check.name, " ".join(offers), *counts, check.title)
    wide_console().print(table)


def show(name: str) -> None:
    """Prints equation, criterion, needs, variants and planted faults of a check.

    name: of a check, or of a case. UsageError if there is no such check.
    """
    check = runner.find(name)
    console = wide_console()
    console.print(f"[bold]{check.name}[/bold]", highlight=False)
    for label, text in (
        ("measures", check.title),
        ("equation", check.equation),
        ("criterion", check.criterion),
        ("citation", check.citation),
        ("needs", "; ".join(_needs_as_text(one) for one in check.all_needs)),
    ):
        console.print(f"  {label:<10} {text}", highlight=False, markup=False)
    for engine, variants in _variants_by_engine(check).items():
        for tier in TIERS:
            names = [one.name for one in variants if one.tier == tier]
            if names:
                console.print(f"  {tier:<10} {engine}: {', '.join(names)}", highlight=False, markup=False)
    for variant, fault in check.faults:
        text = f"  {'fault':<10} {fault.name} (seen by {variant}): {fault.breaks}"
        console.print(text, highlight=False, markup=False)


def _needs_as_text(needs: Needs) -> str:
    """What a check asks of an engine, as "[gravity] by stepping schemes, masses[], virial"."""
    kinds = f"[{needs.interaction}] by {' or '.join(needs.kinds)} schemes"
    return ", ".join([kinds, *needs.schemes, *sorted(needs.words), *sorted(needs.observables), *needs.promises])


def engines() -> None:
    """Prints each installed engine with its version, or the reason why it cannot run on this machine."""
    table = Table("engine", "state", "version or reason", "schemes", box=None, pad_edge=False)
    for name in engine_names():
        worker = Worker(name, time_limit=120)
        try:
            state, text = "found", worker.version()
        except (EngineMissing, EngineError) as error:
            state, text = "missing", str(error).splitlines()[0]
        finally:
            worker.close()
        table.add_row(name, state, plain(text), " ".join(engine_class(name).schemes))
    wide_console().print(table)


def report(directory: Path) -> None:
    """Writes the report of a finished or interrupted run. directory: of the run. UsageError if it has no record."""
    from crosscheck.report.html import write_report

    say_if_torn(directory)
    print(write_report(directory))
