"""What numba made of the loop that runs a scene: its instructions, and the types of all that it was given.

    python -P -m crosscheck.checks.performance.compiled_code REQUEST

runs a scene of `refimpl` in a process of its own, since it looks at all that was compiled there. REQUEST: a file with
the "scene" and the "method" as JSON texts, and the "loop", "module.function" below `refimpl`. It prints an object:
instructions: of the optimised code of the loop, with all that is linked to it. fields: the types of the loop's
arguments, by their paths. digest: of the bits of the state at the end. counts: operations counted.
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from crosscheck.checks.performance.own_process import answer_of
from crosscheck.scene import Method, Scene

#: Seconds that a scene may take, compilation included.
_LIMIT = 300.0


class Code(NamedTuple):
    """What is printed; instructions, fields, digest, counts: see the module."""

    instructions: int
    fields: dict[str, str]
    digest: str
    counts: dict[str, float]


def compiled_code(scene: Scene, method: Method, loop: str, overlay: Path) -> Code:
    """The code of the loop that runs a scene, from a process of its own; EngineError if that fails.

    scene, method: what runs, and how. loop: "module.function" below `refimpl`. overlay: directory with a `refimpl`, in
    whose folder `kernels` numba's cache is.
    """
    request = {"scene": scene.to_json(), "method": method.model_dump_json(), "loop": loop}
    return Code(**answer_of(__name__, request, overlay, _LIMIT, f"code of the scene {scene.name}"))


def _main(request: dict[str, str]) -> Code:
    from crosscheck.engines.refimpl import RefimplEngine

    scene, method = Scene.from_json(request["scene"]), Method.model_validate_json(request["method"])
    run = RefimplEngine().run(scene, method)
    digest = hashlib.sha256()
    for name in sorted({"final_positions", "final_velocities", "sites"} & run.keys()):
        digest.update(run[name].tobytes())
    module, _, name = request["loop"].rpartition(".")
    loop = getattr(import_module(f"refimpl.{module}"), name)
    (signature,) = loop.signatures
    apart = {"wall", "cpu", "compile", "peak_bytes"}
    return Code(
        _instructions(loop.overloads[signature].library.get_llvm_str()),
        dict(_fields(dict(zip(loop.py_func.__code__.co_varnames, signature, strict=False)))),
        digest.hexdigest(),
        {name: value for name, value in run.cost.known().items() if name not in apart},
    )


def _instructions(text: str) -> int:
    """Number of instructions in the functions of a module of LLVM."""
    from llvmlite import binding

    functions = binding.parse_assembly(text).functions
    return sum(1 for function in functions for block in function.blocks for _ in block.instructions)


def _fields(types: dict[str, Any], before: str = "") -> Iterator[tuple[str, str]]:
    """(path, type) of arguments and the fields of records among them."""
    from numba.core import types as kinds

    tuples: Any = kinds.BaseTuple
    for name, kind in types.items():
        if isinstance(kind, tuples):
            inner = tuple(kind)
            names = getattr(kind, "fields", None) or map(str, range(len(inner)))
            yield from _fields(dict(zip(names, inner, strict=True)), f"{before}{name}.")
        else:
            yield f"{before}{name}", str(kind)


if __name__ == "__main__":
    found = _main(json.loads(Path(sys.argv[1]).read_text(encoding="utf-8")))
    sys.stdout.write(json.dumps(found._asdict()) + "\n")
