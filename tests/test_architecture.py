"""The house: imports point one way and make no circle; a thing's address is its name."""

from __future__ import annotations

import ast
import importlib
import pkgutil
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import crosscheck
import refimpl
from crosscheck.checks import all_checks

ROOT = Path(crosscheck.__path__[0]).parent
#: Rooms from the ground up: a module may import from its own room and from lower ones.
FLOORS = (
    ("refimpl",),
    (
        "crosscheck.errors",
        "crosscheck.text",
        "crosscheck.files",
        "crosscheck.directory",
        "crosscheck.figure",
        "crosscheck.faults",
        "crosscheck.pairs",
        "crosscheck.columns",
    ),
    ("crosscheck.lammps_dump",),
    ("crosscheck.scene",),
    ("crosscheck.verdict", "crosscheck.statistics", "crosscheck.convergence", "crosscheck.pairs"),
    ("crosscheck.references",),
    ("crosscheck.engines",),
    ("crosscheck.trajectories",),
    ("crosscheck.checks",),
    (
        "crosscheck.record",
        "crosscheck.record_form",
        "crosscheck.export",
        "crosscheck.runner",
        "crosscheck.status",
        "crosscheck.calibration",
    ),
    ("crosscheck.mutation", "crosscheck.compare", "crosscheck.budget"),
    ("crosscheck.painter", "crosscheck.report"),
    ("crosscheck.simulate", "crosscheck.documents", "crosscheck.regression"),
    ("crosscheck.inspect",),
    ("crosscheck.commands",),
    ("crosscheck.cli", "crosscheck.pytest_plugin"),
)


def modules() -> dict[str, Path]:
    found = {}
    for package in (refimpl, crosscheck):
        top = Path(package.__path__[0])
        for file in top.rglob("*.py"):
            parts = file.relative_to(top.parent).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    return found


@cache
def imports() -> dict[str, frozenset[str]]:
    """Modules of ours that each one imports, at its top, inside functions, and for types alone."""
    known = modules()
    graph = {}
    for name, file in known.items():
        found: set[str] = set()
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module is not None:
                assert node.level == 0, f"{name}: relative imports hide where a thing is"
                inner = {f"{node.module}.{alias.name}" for alias in node.names}
                found |= {one if one in known else node.module for one in inner}
        graph[name] = frozenset((found & set(known)) - {name})
    return graph


def floor(module: str) -> int:
    for number, rooms in enumerate(FLOORS):
        if any(module == room or module.startswith(f"{room}.") for room in rooms):
            return number
    assert module == "crosscheck", f"{module} has no floor: give it one in FLOORS"
    return 0


def test_imports_point_down() -> None:
    upward = [f"{one} -> {other}" for one, others in imports().items() for other in others if floor(one) < floor(other)]
    assert not upward


def test_expectations_share_no_code_with_what_they_judge() -> None:
    """References and checks import nothing of refimpl."""
    judges = {
        f"{name} -> {other}"
        for name, others in imports().items()
        if name.startswith(("crosscheck.references", "crosscheck.checks"))
        for other in others
        if other.startswith("refimpl")
    }
    assert not judges


def circles() -> Iterator[list[str]]:
    """Strongly connected components of more than one module (Tarjan)."""
    graph, index, low, stack, on = imports(), {}, {}, [], set()

    def visit(node: str) -> Iterator[list[str]]:
        index[node] = low[node] = len(index)
        stack.append(node)
        on.add(node)
        for other in sorted(graph[node]):
            if other not in index:
                yield from visit(other)
                low[node] = min(low[node], low[other])
            elif other in on:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            component = []
            while not component or component[-1] != node:
                component.append(stack.pop())
                on.discard(component[-1])
            if len(component) > 1:
                yield sorted(component)

    for node in sorted(graph):
        if node not in index:
            yield from visit(node)


def test_imports_make_no_circle() -> None:
    # a package's __init__ that names what its modules offer is no circle: nobody below imports it back
    assert list(circles()) == []


def test_nothing_private_is_imported_from_another_file() -> None:
    taken = []
    for name, file in modules().items():
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] in ("crosscheck", "refimpl"):
                taken += [
                    f"{name}: {alias.name}"
                    for alias in node.names
                    if alias.name.startswith("_") and alias.name != "__version__"
                ]
    assert not taken


def test_a_check_lies_in_the_folder_of_its_group() -> None:
    package = importlib.import_module("crosscheck.checks")
    found = []
    for module in pkgutil.walk_packages(package.__path__, "crosscheck.checks."):
        for check in getattr(importlib.import_module(module.name), "CHECKS", ()):
            found.append(check.name)
            group = check.name.partition("/")[0]
            assert module.name.split(".")[2] == group, f"{check.name} belongs in crosscheck/checks/{group}/"
    assert sorted(found) == [check.name for check in all_checks()]


def test_files_and_functions_of_checks_are_short() -> None:
    for name, file in modules().items():
        if not name.startswith("crosscheck.checks"):
            continue
        text = file.read_text(encoding="utf-8")
        assert len(text.splitlines()) < 500, f"{name}: one file a phenomenon"
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.FunctionDef):
                length = (node.end_lineno or 0) - node.lineno + 1
                assert length < 80, f"{name}.{node.name} has {length} lines"


#: Tests of a folder as a whole.
OF_FOLDERS = {"docstrings", "needs", "registry", "words"}


def test_tests_lie_at_the_paths_of_what_they_test() -> None:
    """`test_<module>.py`, or `test_<module>_<aspect>.py` where one file would be too long."""
    here = Path(__file__).parent
    astray = []
    for file in here.rglob("test_*.py"):
        parts = file.relative_to(here).parts
        if parts[0] not in ("crosscheck", "refimpl"):
            continue
        name = parts[-1].removeprefix("test_").removesuffix(".py")
        names = {path.stem for path in ROOT.joinpath(*parts[:-1]).iterdir()} | OF_FOLDERS
        if not any(name == one or name.startswith(f"{one}_") for one in names):
            astray.append("/".join(parts))
    assert not astray
