"""Executed lines of Python, and compiled lines of kernels, also of those that come from numba's cache."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

MODULE = """
from numba import njit

@njit
def inner(x):
    return x + 1.0

@njit(cache=True)
def kernel(x):
    y = inner(x)
    return y * 2.0

def at_import():
    return 7.0

NUMBER = at_import()

def plain(x):
    if x > 0:
        return kernel(x)
    return -1.0
"""

SCRIPT = """
import json, sys
from crosscheck.engines.workers import recording
recorder = recording.recorder()
import module
found = []
for x in (-1.0, 1.0, 1.0):
    module.plain(x)
    taken = recorder.take()
    found.append(taken["run"].get(module.__file__, []))
    imported = taken["import"][module.__file__]
sys.settrace(None)
print(json.dumps([*found, imported]))
"""


def recorded(directory: Path, **environment: str) -> list[list[str]]:
    """The texts of the lines that three calls execute, in a process of their own."""
    variables = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(directory), os.environ.get("PYTHONPATH", "")]),
        "CROSSCHECK_RECORD_LINES": str(directory),
        "NUMBA_CACHE_DIR": str(directory / "cache"),
        **environment,
    }
    done = subprocess.run([sys.executable, "-c", SCRIPT], env=variables, check=True, capture_output=True, text=True)
    lines = MODULE.splitlines()
    return [[lines[number - 1].strip() for number in numbers] for numbers in json.loads(done.stdout)]


def test_lines_of_python_and_of_kernels(tmp_path: Path) -> None:
    (tmp_path / "module.py").write_text(MODULE)
    of_kernels = {"return x + 1.0", "y = inner(x)", "return y * 2.0"}
    for _ in range(2):  # compiled, then loaded from the cache
        first, second, third, imported = recorded(tmp_path)
        assert {"def plain(x):", "return 7.0"} <= set(imported)
        assert "return 7.0" not in first
        assert "return -1.0" in first
        assert not of_kernels & set(first)
        assert of_kernels <= set(second)
        assert of_kernels <= set(third)
        assert "return -1.0" not in second


def test_interpreted_kernels_are_lines_of_python(tmp_path: Path) -> None:
    (tmp_path / "module.py").write_text(MODULE)
    _, second, third, _ = recorded(tmp_path, NUMBA_DISABLE_JIT="1")
    assert {"return x + 1.0", "y = inner(x)", "return kernel(x)"} <= set(second)
    assert second == third
