"""Every operation of the event kernels, counted where it is written: what is done needlessly needs no counter there.

    python -P -m crosscheck.checks.performance.counted_sources REQUEST

Kernels count what their authors thought of. Here a copy of the sources counts all: at the start of each block of
statements the number of operations that are written in it. In plain Python and in compiled code they are the same
numbers, whatever the processor and the compiler make of them, but for a loop of hints to fetch memory ahead, which
plain Python leaves out.

The module runs scenes in a process of its own, which has the copy first on its path. REQUEST: a file with a list
of pairs, the JSON texts of a scene and a method. It prints a list with an object for each scene, see `Work`.
"""

from __future__ import annotations

import ast
import hashlib
import json
import sys
import tempfile
from collections.abc import Iterator, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from crosscheck.checks.performance.own_process import answer_of
from crosscheck.engines.workers.ending import TIME_LIMIT
from crosscheck.faults import copy_sources
from crosscheck.scene import Method, Scene

#: Files of the copy, below `refimpl`, whose functions count; and those in there that write machine code themselves.
_COUNTED, _MACHINE_CODE = (
    ("events/kernels/*.py", "events/prediction.py", "events/rules.py"),
    ("compiled", "lanes", "memory"),
)
#: Functions that only fetch memory ahead, of which large systems need more: they change when, and not what is done.
_AHEAD = ("prefetch", "_prefetch", "_tree_prefetch", "_calendar_prefetch", "_look_ahead", "_tree_rival")
_OPERATIONS = (ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Compare, ast.Call, ast.Subscript, ast.IfExp)
_ALL, _FETCHING = "add_work", "add_ahead"
#: The counters: numbers at a fixed place, which kernels add to without being given it.
_COUNTER = '''
"""Operations done so far."""

import ctypes

import llvmlite.ir as ir
from numba import types

from refimpl.compilation import instruction

DONE = (ctypes.c_int64 * 2)()


def _counter(kind):
    def plain(number):
        DONE[kind] += number

    @instruction(plain)
    def add(context, number):
        def code(context, builder, signature, arguments):
            whole = ir.IntType(64)
            place = whole(ctypes.addressof(DONE) + 8 * kind).inttoptr(whole.as_pointer())
            more = context.cast(builder, arguments[0], signature.args[0], types.int64)
            builder.store(builder.add(builder.load(place), more), place)
            return context.get_dummy_value()

        return types.void(number), code

    return add


add_work, add_ahead = _counter(0), _counter(1)
'''


class Work(NamedTuple):
    """Of a run.

    work: operations since the start, at the samples. ahead: those that only fetch memory ahead, beside them. counted,
    events: observables `operation_counts` and `events`, at the same. digest: of the bits of all other results.
    """

    work: list[int]
    ahead: list[int]
    counted: list[list[int]]
    events: list[int]
    digest: str


def work_of(sources: Path, runs: Sequence[tuple[Scene, Method]], *, interpreted: bool) -> list[Work]:
    """Runs scenes with a copy of `sources` that counts all operations of the event kernels; EngineError if that fails.

    sources: directory of a `refimpl`. runs: scenes with the observables `operation_counts` and `events`, each with how
    it is run. interpreted: as plain Python; otherwise compiled, and kept nowhere.
    """
    with tempfile.TemporaryDirectory(prefix="crosscheck-work-") as name:
        directory = Path(name)
        copy_that_counts(sources, directory)
        request = [(scene.to_json(), method.model_dump_json()) for scene, method in runs]
        plain = {"NUMBA_DISABLE_JIT": "1"} if interpreted else {}
        what = f"counts of the scene {runs[0][0].name}"
        return [Work(**one) for one in answer_of(__name__, request, directory, TIME_LIMIT, what, **plain)]


def copy_that_counts(sources: Path, directory: Path) -> None:
    """Writes a copy of `refimpl` whose event kernels count their operations to `directory`/refimpl.

    sources: directory of the package.
    """
    copy = copy_sources(sources, directory)
    (copy / "work.py").write_text(_COUNTER, encoding="utf-8")
    for file in (file for pattern in _COUNTED for file in copy.glob(pattern)):
        if file.stem not in _MACHINE_CODE:
            file.write_text(counting_all(file.read_text(encoding="utf-8")), encoding="utf-8")


def counting_all(text: str) -> str:
    """The text of a module whose functions count the operations that are written in them; text: of the module."""
    tree = ast.parse(text)
    functions = [node for node in tree.body if isinstance(node, ast.FunctionDef)]
    for function in functions:
        _count_in(function.body, 0, _FETCHING if function.name.startswith(_AHEAD) else _ALL)
    if functions:
        last = max(i for i, node in enumerate(tree.body) if isinstance(node, ast.Import | ast.ImportFrom))
        tree.body.insert(last, ast.ImportFrom("refimpl.work", [ast.alias(_ALL), ast.alias(_FETCHING)], 0))
    return ast.unparse(ast.fix_missing_locations(tree)) + "\n"


def _count_in(block: list[ast.stmt], more: int, counter: str) -> None:
    """Puts the count of a block at its start, and does so in the blocks within.

    more: operations of each passage beside those of the block. counter: name of what counts.
    """
    number = more
    for statement in block:
        number += sum(_operations(part) for part in _own_parts(statement))
        for inner, each in _blocks(statement):
            _count_in(inner, each, counter)
    if number:
        count = ast.Expr(ast.Call(ast.Name(counter, ast.Load()), [ast.Constant(number)], []))
        block.insert(_after_docstring(block), count)


def _after_docstring(block: list[ast.stmt]) -> int:
    match block[0]:
        case ast.Expr(value=ast.Constant(value=str())):
            return 1
    return 0


def _own_parts(statement: ast.stmt) -> Iterator[ast.AST]:
    """What of a statement is executed once with the block that it stands in."""
    match statement:
        case ast.If(test=test):
            yield test
        case ast.For(iter=iterated):
            yield iterated
        case ast.While():
            return
        case _:
            yield statement


def _blocks(statement: ast.stmt) -> Iterator[tuple[list[ast.stmt], int]]:
    """The blocks of a statement, and the operations of each passage beside those of the block itself."""
    match statement:
        case ast.If(body=body, orelse=other):
            yield body, 0
            if other:
                yield other, 0
        case ast.For(body=body):
            yield body, 1
        case ast.While(test=test, body=body):
            yield body, _operations(test)


def _operations(part: ast.AST) -> int:
    """Operations in an expression or a simple statement, an assignment being one too."""
    assigns = isinstance(part, ast.Assign | ast.AugAssign)
    return assigns + sum(isinstance(node, _OPERATIONS) for node in ast.walk(part))


def _run(scene: Scene, method: Method) -> Work:
    from crosscheck.engines.refimpl import RefimplEngine

    done = import_module("refimpl.work").DONE
    simulation = import_module("refimpl.events.simulation").Simulation
    sampled, start = simulation.operation_counts, list(done)
    work: list[int] = []
    ahead: list[int] = []

    def noting(self: Any) -> Any:
        work.append(done[0] - start[0])
        ahead.append(done[1] - start[1])
        return sampled(self)

    simulation.operation_counts = noting
    run = RefimplEngine().run(scene, method)
    simulation.operation_counts = sampled
    digest = hashlib.sha256()
    for name in sorted(run.keys() - {"operation_counts"}):
        digest.update(np.ascontiguousarray(run[name]).tobytes())
    return Work(work, ahead, run["operation_counts"].tolist(), run["events"].tolist(), digest.hexdigest())


if __name__ == "__main__":
    asked = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    found = [_run(Scene.from_json(scene), Method.model_validate_json(method))._asdict() for scene, method in asked]
    sys.stdout.write(json.dumps(found) + "\n")
