"""The command `prove --mutate`: the mutation score."""

from __future__ import annotations

import hashlib
import json
import shlex
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

from crosscheck import runner
from crosscheck.commands.console import that_pay
from crosscheck.directory import locked
from crosscheck.engines.registry import engine_names
from crosscheck.engines.workers.ending import Interrupted
from crosscheck.errors import UsageError
from crosscheck.files import naming, refuse_no_directory
from crosscheck.mutation import score, trial
from crosscheck.mutation.coverage import Executed, executed_lines
from crosscheck.mutation.draw import Mutant, Population, draw, population
from crosscheck.mutation.equivalents import Equivalent, equivalents
from crosscheck.mutation.trial import Outcome, try_mutant

#: The files of the mutants judged so far, and of the score.
MUTANTS, SCORE = "mutants.jsonl", "score.json"
#: Of the suite, by which its cases derive theirs: that of `crosscheck run`.
_SUITE_SEED = 0


class Sample(NamedTuple):
    """Which mutants are drawn, and what they are judged by.

    number: of mutants. seed: of the draw. tier: of the cases, "quick" or "full". checks: shell patterns of their names;
    none: all. modules: shell patterns of files; none: all. population: "refimpl", "adapters" or "performance".
    """

    number: int
    seed: int
    tier: str
    checks: tuple[str, ...]
    modules: tuple[str, ...]
    population: str


def mutate(sample: Sample, jobs: int | None, out: Path, resume: Path | None) -> int:
    """Draws mutants, judges each by the cases that execute it, and prints and writes the score; returns exit status 0.

    sample: which mutants. jobs: mutants at a time; None: one per core. out: directory of the files. resume: directory
    of a sample to be completed, in place of out; None: a new one. A sample of the quick tier may be completed by the
    full one: its survivors, but for those that are listed as equivalent, are judged again. After Ctrl-C the score of
    the mutants judged so far is printed, and they are kept. UsageError for an unknown population, tier or file, or if
    the sample to be completed is another one.
    """
    if sample.tier not in ("quick", "full"):
        raise UsageError(f"--tier {sample.tier}: unknown; take quick or full")
    among = population(sample.population, sample.modules)
    directory = resume or out
    refuse_no_directory(directory, "the mutants")
    trial.remove_leftovers()
    entries, cases = equivalents(), _cases(sample)
    mutants = draw(among, sample.number, sample.seed)
    header = sample._asdict() | {
        "checks": list(sample.checks),
        "modules": list(sample.modules),
        "sources": _sources(among),
    }
    with locked(directory):
        outcomes = _known(directory / MUTANTS, header, mutants, entries) if resume else {}
        _begin(directory / MUTANTS, header, mutants, outcomes)
        interruption: Interrupted | None = None
        try:
            jobs = that_pay(jobs, len(mutants))
            executed = _green(executed_lines(cases, _SUITE_SEED, jobs, _say))
            most = trial.MOST_COMPILED[sample.tier]
            for number, outcome in _tried(mutants, executed, outcomes, jobs, most):
                outcomes[number] = outcome
                _append(directory / MUTANTS, number, mutants[number], outcome)
                _say(_line(len(outcomes), len(mutants), mutants[number], outcome))
        except Interrupted as caught:
            interruption = caught
        found = [score.judged(mutants[number], outcome, entries) for number, outcome in sorted(outcomes.items())]
        about = {"date": datetime.now(UTC).date().isoformat(), "command": _command(sample)}
        record = score.as_record(found, about | header | {"judged": len(found)})
        score.write(directory / SCORE, record)
        _print(found, directory)
    if interruption is not None:
        print(f"complete it: add --resume {shlex.quote(str(directory))} to the command")
        raise interruption
    return 0


def _command(sample: Sample) -> str:
    """The command that draws a sample, without what its result does not depend on: directories and jobs."""
    entries = ["crosscheck", "prove", *sample.checks, "--mutate", str(sample.number), "--seed", str(sample.seed)]
    entries += ["--tier", sample.tier, "--population", sample.population]
    return shlex.join([*entries, *(part for module in sample.modules for part in ("--module", module))])


def _say(text: str) -> None:
    print(text, flush=True)


def _cases(sample: Sample) -> list[runner.Case]:
    """All cases but those that measure computing times, which say nothing while others run beside them."""
    return [case for case in runner.select(list(sample.checks), sample.tier, engine_names()) if not case.timing]


def _green(executed: Sequence[Executed]) -> list[Executed]:
    """Those whose case is green for the unchanged sources: no other could show anything."""
    for one in executed:
        if one.outcome in ("fail", "error"):
            _say(f"{one.outcome} without any mutation, and not asked: {one.case.name} [{one.case.engine}]")
    return [one for one in executed if one.outcome == "pass"]


def _tried(
    mutants: Sequence[Mutant], executed: Sequence[Executed], known: dict[int, Outcome], jobs: int, most_compiled: int
) -> Iterator[tuple[int, Outcome]]:
    """The number and the outcome of each mutant that has none yet, as they are finished."""
    with ThreadPoolExecutor(jobs) as pool:
        left: dict[Future[Outcome | None], int] = {
            pool.submit(try_mutant, mutant, executed, _SUITE_SEED, most_compiled): number
            for number, mutant in enumerate(mutants)
            if number not in known
        }
        try:
            while left:
                for future in wait(left, return_when=FIRST_COMPLETED).done:
                    number, outcome = left.pop(future), future.result()
                    if outcome is not None:
                        yield number, outcome
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


def _line(done: int, number: int, mutant: Mutant, outcome: Outcome) -> str:
    head = f"[{done}/{number}] {'caught' if outcome.caught else 'SURVIVED':<8} {mutant.name}  {outcome.seconds:.1f} s"
    if outcome.caught:
        return f"{head}  by {outcome.by}: {outcome.why[:120]}"
    left = f", not shown to {outcome.left} compiled ones" if outcome.left else ""
    return f"{head}  {outcome.judged} cases{left}"


def _sources(among: Population) -> str:
    """A hash of the files of a population."""
    digest = hashlib.sha256()
    for path in among.files:
        digest.update(path.encode() + (among.root / path).read_bytes())
    return digest.hexdigest()[:16]


def _known(
    path: Path, header: dict[str, Any], mutants: Sequence[Mutant], entries: Sequence[Equivalent]
) -> dict[int, Outcome]:
    """The outcomes in the file, by number. Of the quick tier, where the full one judges, the survivors are left out."""
    outcomes, tier = _read(path, header)
    if tier == header["tier"]:
        return outcomes
    states = {number: score.judged(mutants[number], outcome, entries).state for number, outcome in outcomes.items()}
    return {number: outcome for number, outcome in outcomes.items() if states[number] != "survived"}


def _begin(path: Path, header: dict[str, Any], mutants: Sequence[Mutant], known: dict[int, Outcome]) -> None:
    """Starts the file of mutants, with those whose outcome is known."""
    lines = [json.dumps(header) + "\n", *(_written(number, mutants[number], known[number]) for number in known)]
    new = path.with_suffix(".new")
    with naming(path):
        new.write_text("".join(lines), encoding="utf-8")
        new.replace(path)


def _append(path: Path, number: int, mutant: Mutant, outcome: Outcome) -> None:
    with naming(path), path.open("a", encoding="utf-8") as file:
        file.write(_written(number, mutant, outcome))


def _written(number: int, mutant: Mutant, outcome: Outcome) -> str:
    return json.dumps({"number": number, "name": mutant.name, **asdict(outcome)}) + "\n"


def _read(path: Path, header: dict[str, Any]) -> tuple[dict[int, Outcome], str]:
    """The outcomes in the file, by number, and the tier that judged; a torn last line does not count.

    UsageError if it is of another sample, or of the full tier where the quick one is asked for.
    """
    if not path.is_file():
        raise UsageError(f"{path}: there is no sample to be completed")
    lines = path.read_text(encoding="utf-8").split("\n")[:-1]
    try:
        first, *rest = [json.loads(line) for line in lines]
    except ValueError as error:
        raise UsageError(f"{path}: not a file of mutants: {error}") from None
    for name, value in header.items():
        more = name == "tier" and (first.get(name), value) == ("quick", "full")
        if first.get(name) != value and not more:
            raise UsageError(
                f"{path}: it has {name} {first.get(name)}, not {value}: draw a new sample, or give the same"
            )
    outcomes = {line.pop("number"): Outcome(**{k: v for k, v in line.items() if k != "name"}) for line in rest}
    return outcomes, first["tier"]


def _print(found: Sequence[score.Judged], directory: Path) -> None:
    """Prints the survivors, the tables and the score."""
    for one in found:
        if one.state == "survived":
            place = one.mutant.mutation.function or "the module"
            print(f"\nsurvived {one.outcome.judged} cases: {one.mutant.name}, in {place}")
            print(one.mutant.diff())
    keys: dict[str, Callable[[Mutant], str]] = {"file": score.by_file, "operator": score.by_operator}
    for title, key in keys.items():
        print(f"\n{title:<48} caught survived equivalent")
        for name, count in score.counted_by(found, key).items():
            print(f"{name:<48} {count.caught:>6} {count.survived:>8} {count.equivalent:>10}")
    total = score.counted(found)
    low, high = total.interval
    print(
        f"\n{total.caught} of {total.caught + total.survived} caught: {total.share:.1%}, at {score.CONFIDENCE:.0%}"
        f" between {low:.1%} and {high:.1%}; {total.equivalent} equivalent ones; {directory / SCORE}"
    )
