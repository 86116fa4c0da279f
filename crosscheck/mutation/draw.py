"""Draws mutants at random: first a line, uniformly, then an operator that applies to it, then one of its mutations."""

from __future__ import annotations

import difflib
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cached_property
from pathlib import Path
from types import CodeType

import crosscheck
import refimpl
from crosscheck.errors import UsageError
from crosscheck.mutation.operators import COST_OPERATORS, OPERATORS, Mutation, Operator, mutations
from crosscheck.mutation.syntax import Source

#: Draws without a new mutant after which there seem to be no more.
_MOST_REPEATS = 2000


@dataclass(frozen=True)
class Population:
    """The files that are mutated, and the operators.

    package: "refimpl" or "crosscheck", which is copied. root: of the package. files: path within it. operators: by
    name.
    """

    package: str
    root: Path
    files: tuple[str, ...]
    operators: dict[str, Operator]


@dataclass(frozen=True)
class Mutant:
    """A package with one mutation.

    package: its name. file: path below the package. mutation: what is changed. before, after: the text of the file.
    """

    package: str
    file: str
    mutation: Mutation
    before: str
    after: str

    @property
    def name(self) -> str:
        """File, line and operator."""
        return f"{self.package}/{self.file}:{self.mutation.line} {self.mutation.operator}"

    @cached_property
    def lines(self) -> tuple[str, str]:
        """The text of the lines that are changed, before and after, without the white space around them."""
        old, new = self.before.splitlines(), self.after.splitlines()
        matcher = difflib.SequenceMatcher(None, old, new, autojunk=False)
        changed = [one for one in matcher.get_opcodes() if one[0] != "equal"]
        a, b, c, d = changed[0][1], changed[-1][2], changed[0][3], changed[-1][4]
        return "\n".join(old[a:b]).strip(), "\n".join(new[c:d]).strip()

    def diff(self, context: int = 2) -> str:
        """The change as a unified diff; context: number of lines around it."""
        name = f"{self.package}/{self.file}"
        lines = difflib.unified_diff(
            self.before.splitlines(), self.after.splitlines(), name, name, n=context, lineterm=""
        )
        return "\n".join(lines)


def _is_kernel(path: str) -> bool:
    return "/kernels/" in path or path.startswith("stepping/forces/")


def _is_adapter(path: str) -> bool:
    here = path.removeprefix("engines/")
    folders = ("refimpl/", "lammps/", "rebound/")
    return here != path and (here.startswith(folders) or here in ("ase.py", "soft_spheres.py"))


def _all(path: str) -> bool:
    return True


#: By name: the package, which of its files, and the operators.
_POPULATIONS: dict[str, tuple[Path, Callable[[str], bool], dict[str, Operator]]] = {
    "refimpl": (Path(refimpl.__path__[0]), _all, OPERATORS),
    "adapters": (Path(crosscheck.__path__[0]), _is_adapter, OPERATORS),
    "performance": (Path(refimpl.__path__[0]), _is_kernel, COST_OPERATORS),
}
POPULATIONS = tuple(_POPULATIONS)


def population(name: str, patterns: Sequence[str] = ()) -> Population:
    """A population by its name, one of `POPULATIONS`; of its files, those that match.

    patterns: shell patterns of paths below the package, or of their folders, with or without `.py`; none: all.
    UsageError for an unknown name, or a pattern that matches no file.
    """
    if name not in _POPULATIONS:
        raise UsageError(f"--population {name}: unknown; take {', '.join(POPULATIONS)}")
    root, belongs, operators = _POPULATIONS[name]
    paths = sorted(file.relative_to(root).as_posix() for file in root.rglob("*.py"))
    files = [path for path in paths if belongs(path)]
    for pattern in patterns:
        if not any(_matches(pattern, path) for path in files):
            raise UsageError(f"--module {pattern}: no file of {root.name} matches; they are {', '.join(files)}")
    chosen = [path for path in files if not patterns or any(_matches(pattern, path) for pattern in patterns)]
    return Population(root.name, root, tuple(chosen), operators)


def _matches(pattern: str, path: str) -> bool:
    pattern = pattern.strip("/")
    forms = (pattern, f"{pattern}.py", f"{pattern}/*", f"*/{pattern}.py", f"*/{pattern}/*")
    return any(fnmatchcase(path, form) for form in forms)


def draw(among: Population, number: int, seed: int) -> list[Mutant]:
    """So many different mutants, the same ones for the same arguments; fewer if there are no more.

    Each line on which a mutation is possible is as likely as every other one; then each operator that applies to it,
    and then each of the operator's mutations of the line. Mutants whose bytecode is that of the original are not drawn.

    among: their population. number: how many. seed: of the choice.
    """
    chance = random.Random(seed)
    sources = {path: Source((among.root / path).read_text(encoding="utf-8")) for path in among.files}
    by_line: dict[tuple[str, int], dict[str, list[Mutation]]] = {}
    for path, source in sources.items():
        for one in mutations(source, among.operators):
            by_line.setdefault((path, one.line), {}).setdefault(one.operator, []).append(one)
    lines = sorted(by_line)
    code = {path: compiled(source.text) for path, source in sources.items()}
    drawn: dict[tuple[str, str], Mutant] = {}
    repeats = 0
    while lines and len(drawn) < number and repeats < _MOST_REPEATS:
        path, line = chance.choice(lines)
        operators = by_line[path, line]
        mutation = chance.choice(operators[chance.choice(sorted(operators))])
        source = sources[path]
        after = source.replaced(mutation.start, mutation.end, mutation.text)
        if (path, after) in drawn or compiled(after) == code[path]:
            repeats += 1
            continue
        repeats = 0
        drawn[path, after] = Mutant(among.package, path, mutation, source.text, after)
    return list(drawn.values())


def compiled(text: str) -> object:
    """What Python makes of a text, without its docstrings and line numbers, so that it can be compared.

    text: of a module; SyntaxError if it is not Python.
    """
    return _comparable(compile(text, "<mutant>", "exec", optimize=2, dont_inherit=True))


def _comparable(code: CodeType) -> object:
    constants = tuple(
        _comparable(one) if isinstance(one, CodeType) else (type(one), repr(one)) for one in code.co_consts
    )
    return code.co_name, code.co_code, constants, code.co_names, code.co_varnames, code.co_exceptiontable
