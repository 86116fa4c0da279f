"""Which lines of the sources each case executes. Recorded once for each state of the sources, and kept in a file.

The file lies beside the compiled kernels, in the directory that is named by a hash of `refimpl`. A case is recorded
again when a source of its check, or of an engine, has changed since: so the map is never stale.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.util
import json
import sys
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from functools import cache, partial
from pathlib import Path

import crosscheck
from crosscheck.checks import declared_in
from crosscheck.engines.workers.cache import kernel_cache
from crosscheck.engines.workers.ending import TIME_LIMIT, ending
from crosscheck.mutation.judge import Judge, recorded_roots
from crosscheck.runner import Case, find

_FILE = "executed-lines.jsonl"


@dataclass(frozen=True)
class Executed:
    """What one case executes of the unchanged sources.

    case: which. seed: of the suite. sources: a hash of the sources of its check and of the engines. outcome, seconds:
    of its verdict. interpreted: whether its kernels run as plain Python. lines: that run, by path from the directory
    that holds the packages, as "refimpl/events/rules.py". imported: lines executed by imports, by path.
    """

    case: Case
    seed: int
    sources: str
    outcome: str
    seconds: float
    interpreted: bool
    lines: dict[str, frozenset[int]]
    imported: dict[str, frozenset[int]]

    def executes(self, file: str, first: int, last: int) -> bool:
        """Whether it executes one of the lines from `first` to `last` of a file, also by an import.

        file: path as in `lines`.
        """
        both = (self.lines, self.imported)
        return any(first <= line <= last for lines in both for line in lines.get(file, ()))


def executed_lines(
    cases: Sequence[Case], seed: int, jobs: int, tell: Callable[[str], None] = lambda text: None
) -> list[Executed]:
    """What each case executes, from the file; those that are not there, or not as they are now, are recorded first.

    cases: which. seed: of the suite. jobs: how many to record at a time. tell: is told how far it is.
    """
    path = kernel_cache() / _FILE
    known = _read(path)
    missing = [case for case in cases if not _is_current(known.get((case, seed)))]
    if missing:
        tell(f"recording which lines {len(missing)} cases execute")
    groups: dict[str, list[Case]] = {}
    for case in missing:
        groups.setdefault(case.check, []).append(case)
    # here, not on the threads: Python 3.11 may fail where two of them make syntax trees at the same time
    sources = [sources_of(check) for check in groups]
    with ThreadPoolExecutor(jobs) as pool:
        for done, found in enumerate(pool.map(partial(_record, seed), groups.values(), sources), 1):
            with path.open("a", encoding="utf-8") as file:
                for one in found:
                    file.write(_written(one))
            known |= {(one.case, seed): one for one in found}
            tell(f"recorded {done} of {len(groups)} checks")
    return [known[case, seed] for case in cases if (case, seed) in known]


def _record(seed: int, cases: Iterable[Case], sources: str) -> list[Executed]:
    """What the cases of one check execute; sources: their hash.

    Interpreted ones run a second time, since recording makes them many times slower.
    """
    found = []
    with Judge(records=True) as judge, Judge() as unwatched:
        for case in cases:
            answer = judge.judge(case, seed, TIME_LIMIT)
            interpreted = find(case.check).interpreted
            seconds = unwatched.judge(case, seed, TIME_LIMIT).seconds if interpreted else answer.seconds
            if ending():
                break
            verdict = (answer.outcome, seconds, interpreted)
            lines = (_relative(answer.lines.get(kind, {})) for kind in ("run", "import"))
            found.append(Executed(case, seed, sources, *verdict, *lines))
    return found


def _relative(lines: dict[str, list[int]]) -> dict[str, frozenset[int]]:
    """The lines by path from the directory that holds the packages; lines: by absolute path."""
    of_refimpl, of_engines = recorded_roots()
    found = {}
    for name, numbers in lines.items():
        file = Path(name)
        top = of_refimpl.parent if file.is_relative_to(of_refimpl) else of_engines.parent.parent
        found[file.relative_to(top).as_posix()] = frozenset(numbers)
    return found


def _written(one: Executed) -> str:
    kinds = {"lines": one.lines, "imported": one.imported}
    sets = {name: {file: sorted(numbers) for file, numbers in lines.items()} for name, lines in kinds.items()}
    return json.dumps(asdict(one) | sets) + "\n"


def _read(path: Path) -> dict[tuple[Case, int], Executed]:
    """What the file holds, the last line of each case; a line that was not written to its end is passed over."""
    found: dict[tuple[Case, int], Executed] = {}
    for text in path.read_text(encoding="utf-8").splitlines() if path.exists() else []:
        try:
            line = json.loads(text)
        except ValueError:
            continue
        case = Case(**line.pop("case"))
        lines, imported = (_sets(line.pop(name, {})) for name in ("lines", "imported"))
        found[case, line["seed"]] = Executed(case=case, lines=lines, imported=imported, **line)
    return found


def _sets(lines: dict[str, list[int]]) -> dict[str, frozenset[int]]:
    return {file: frozenset(numbers) for file, numbers in lines.items()}


def _is_current(one: Executed | None) -> bool:
    return one is not None and one.sources == sources_of(one.case.check)


@cache
def sources_of(check: str) -> str:
    """A hash of all sources that a check's verdict may depend on, but `refimpl`; check: its name."""
    files = _imported(declared_in()[check]) | {
        module for module in _engines() if not module.startswith("crosscheck.engines.workers.recording")
    }
    digest = hashlib.sha256()
    for module in sorted(files):
        digest.update(module.encode() + _file(module).read_bytes())
    return digest.hexdigest()[:16]


@cache
def _engines() -> frozenset[str]:
    folder = Path(crosscheck.__path__[0])
    paths = [path.relative_to(folder.parent).with_suffix("").parts for path in (folder / "engines").rglob("*.py")]
    return frozenset(".".join(parts[:-1] if parts[-1] == "__init__" else parts) for parts in paths)


def _imported(module: str) -> set[str]:
    """The modules of `crosscheck` that a module imports, and those that they import; itself too."""
    found, left = set(), [module]
    while left:
        one = left.pop()
        if one not in found and one.partition(".")[0] == "crosscheck":
            found.add(one)
            left.extend(_named(one))
    return found


@cache
def _named(module: str) -> tuple[str, ...]:
    names: list[str] = []
    for node in ast.walk(ast.parse(_file(module).read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "crosscheck":
            inner = [f"{node.module}.{alias.name}" for alias in node.names]
            names += [one if _is_module(one) else str(node.module) for one in inner]
        elif isinstance(node, ast.Import):
            names += [alias.name for alias in node.names if alias.name.partition(".")[0] == "crosscheck"]
    return tuple(dict.fromkeys(names))


@cache
def _is_module(name: str) -> bool:
    try:
        return name in sys.modules or importlib.util.find_spec(name) is not None
    except ImportError:
        return False


@cache
def _file(module: str) -> Path:
    spec = importlib.util.find_spec(module)
    assert spec is not None
    assert spec.origin is not None
    return Path(spec.origin)
