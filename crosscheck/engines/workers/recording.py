"""Which lines of the sources a run executes: those of Python as they run, those of kernels as they are compiled.

numba lowers every line of a function that it does not prune, so a compiled line counts as executed though the run may
not have come to it. What a kernel consists of is kept beside it in numba's cache, for the runs that load it from there.
"""

from __future__ import annotations

import gc
import hashlib
import json
import os
import sys
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

#: Set to the directories of the packages whose lines are recorded, by a process whose workers are to record.
VARIABLE = "CROSSCHECK_RECORD_LINES"

#: Line numbers by file.
Lines = dict[str, set[int]]
#: What a recorder returns: sorted line numbers by file, of "run", since the last call, and of "import", of all imports.
Executed = dict[str, dict[str, list[int]]]


def recorder() -> Recorder | None:
    """A recorder that records, if the environment asks for one; None otherwise."""
    roots = os.environ.get(VARIABLE)
    return Recorder(roots.split(os.pathsep)) if roots else None


class Recorder:
    """Records the lines executed in this thread from now on. roots: directories; other files are not recorded."""

    def __init__(self, roots: Iterable[str]) -> None:
        self._roots = tuple(f"{root.rstrip('/')}/" for root in roots)
        self._executed: dict[CodeType, set[int]] = {}
        self._imported: dict[CodeType, set[int]] = {}
        self._importing = 0
        self._to_come: dict[CodeType, int] = {}
        self._compiled: Lines = {}
        self._of_library: dict[int, Lines] = {}
        self._kept: list[Any] = []
        self._pending: list[dict[CodeType, set[int]]] = []
        if os.environ.get("NUMBA_DISABLE_JIT") != "1":
            self._listen_to_compiler()
        sys.settrace(self._called)

    def take(self) -> Executed:
        """The lines since the last call, and those of imports; kernels in use are loaded again at their next call."""
        found = _union([self._compiled, *(_by_file(one) for one in (self._executed, *self._pending))])
        self._executed.clear()
        self._pending.clear()
        self._compiled.clear()
        _forget_kernels()
        return {"run": _sorted(found), "import": _sorted(_by_file(self._imported))}

    # -- Python ------------------------------------------------------------------------------------

    def _called(self, frame: FrameType, event: str, argument: Any) -> Callable[..., Any] | None:
        code = frame.f_code
        left = self._to_come.get(code)
        if left is None:
            ours = code.co_filename.startswith(self._roots)
            left = self._to_come[code] = len({line for _, _, line in code.co_lines() if line}) if ours else 0
        if not left:
            return None
        module = code.co_name == "<module>"
        self._importing += module
        record = self._imported if self._importing else self._executed
        lines = record.get(code)
        if lines is None:
            lines = record[code] = {code.co_firstlineno}
        elif len(lines) >= left:
            return None
        return self._module_tracer(lines) if module else _line_tracer(lines)

    def _module_tracer(self, lines: set[int]) -> Callable[..., Any]:
        """As `_line_tracer`; what is called until the module returns is called by an import."""

        def line(frame: FrameType, event: str, argument: Any) -> Callable[..., Any]:
            if event == "line":
                lines.add(frame.f_lineno)
            elif event == "return":
                self._importing -= 1
            return line

        return line

    # -- numba -------------------------------------------------------------------------------------

    def _listen_to_compiler(self) -> None:
        try:
            from numba.core import lowering
            from numba.core.caching import FunctionCache
        except ImportError:
            return
        start, load, save = lowering.BaseLower.__init__, FunctionCache.load_overload, FunctionCache.save_overload
        recorder = self

        def start_lowering(self: Any, *arguments: Any, **named: Any) -> None:
            start(self, *arguments, **named)
            self._loc_notify_registry.append(
                _Lowered(recorder._lines_of(self.library), recorder._compiled, recorder._roots)
            )

        def load_overload(self: Any, sig: Any, target_context: Any) -> Any:
            file = _beside(self, sig, target_context.codegen())
            found = load(self, sig, target_context) if file is not None and file.exists() else None
            if found is None or file is None:
                recorder._pending.append(recorder._executed)
                recorder._executed = {}
                return None
            lines = {name: set(numbers) for name, numbers in json.loads(file.read_text()).items()}
            recorder._lines_of(found.library).update(lines)
            _add(recorder._compiled, lines)
            return found

        def save_overload(self: Any, sig: Any, data: Any) -> None:
            compiling = _by_file(recorder._executed)
            before = recorder._pending.pop() if recorder._pending else {}
            for code, numbers in before.items():
                recorder._executed.setdefault(code, set()).update(numbers)
            lines = _union([compiling, *recorder._linked(data.library)])
            _add(recorder._compiled, lines)
            save(self, sig, data)
            file = _beside(self, sig, data.codegen)
            if file is not None:
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(json.dumps({name: sorted(numbers) for name, numbers in lines.items()}))

        for owner, name, method in (
            (lowering.BaseLower, "__init__", start_lowering),
            (FunctionCache, "load_overload", load_overload),
            (FunctionCache, "save_overload", save_overload),
        ):
            setattr(owner, name, method)

    def _lines_of(self, library: Any) -> Lines:
        if id(library) not in self._of_library:
            self._of_library[id(library)] = {}
            self._kept.append(library)  # its id must not be given to another one
        return self._of_library[id(library)]

    def _linked(self, library: Any) -> list[Lines]:
        """The lines of a library of compiled code, and of those that are linked into it."""
        found, left, seen = [], [library], set()
        while left:
            one = left.pop()
            if id(one) not in seen:
                seen.add(id(one))
                found.append(self._lines_of(one))
                left.extend(getattr(one, "_linking_libraries", ()))
        return found


class _Lowered:
    """numba tells it each location that it lowers."""

    def __init__(self, lines: Lines, all_lines: Lines, roots: tuple[str, ...]) -> None:
        self._lines, self._all, self._roots = lines, all_lines, roots

    def notify(self, loc: Any) -> None:
        if loc.filename.startswith(self._roots):
            self._lines.setdefault(loc.filename, set()).add(loc.line)
            self._all.setdefault(loc.filename, set()).add(loc.line)

    def close(self) -> None:
        pass


def _line_tracer(lines: set[int]) -> Callable[..., Any]:
    add = lines.add

    def line(frame: FrameType, event: str, argument: Any) -> Callable[..., Any]:
        if event == "line":
            add(frame.f_lineno)
        return line

    return line


def _beside(cache: Any, sig: Any, codegen: Any) -> Path | None:
    """The file for the lines of a kernel, in the directory of its cache; None if it is not cached."""
    directory = os.environ.get("NUMBA_CACHE_DIR")
    if directory is None or not cache._enabled:
        return None
    name = f"{cache._cache_path}/{cache._impl.filename_base}/{cache._index_key(sig, codegen)}"
    return Path(directory) / "lines" / f"{hashlib.sha256(name.encode()).hexdigest()[:24]}.json"


def _forget_kernels() -> None:
    """Makes numba load cached kernels again, so that the next one who calls them is seen to use them."""
    dispatcher = sys.modules.get("numba.core.dispatcher")
    if dispatcher is None:
        return
    for one in gc.get_objects():
        if isinstance(one, dispatcher.Dispatcher) and one.overloads and one._cache.cache_path is not None:
            one._reset_overloads()


def _by_file(executed: Mapping[CodeType, set[int]]) -> Lines:
    found: Lines = {}
    for code, lines in executed.items():
        found.setdefault(code.co_filename, set()).update(lines)
    return found


def _sorted(lines: Lines) -> dict[str, list[int]]:
    return {file: sorted(numbers) for file, numbers in lines.items()}


def _add(to: Lines, lines: Mapping[str, set[int]]) -> None:
    for file, numbers in lines.items():
        to.setdefault(file, set()).update(numbers)


def merged(several: Iterable[Executed]) -> Executed:
    """All that several recorders have recorded; several: what each returned."""
    every = list(several)
    return {
        kind: _sorted(_union({file: set(lines) for file, lines in one.get(kind, {}).items()} for one in every))
        for kind in ("run", "import")
    }


def _union(several: Iterable[Mapping[str, set[int]]]) -> Lines:
    found: Lines = {}
    for one in several:
        _add(found, one)
    return found
