"""Processes of their own, in which a copy of the sources of `refimpl` runs scenes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from crosscheck.errors import EngineError


def answer_of(module: str, request: Any, directory: Path, limit: float, what: str, **variables: str) -> Any:
    """What `python -m module REQUEST` prints on its last line, as JSON, with one thread; EngineError if that fails.

    module: its name. request: what the file REQUEST holds, as JSON. directory: with the copy of `refimpl` that is first
    on the path; numba's cache is in its folder `kernels`. limit: seconds that it may take. what: is missing if it takes
    longer, and of which scene, in words. variables: of the environment, beside those.
    """
    file = directory / "request.json"
    file.write_text(json.dumps(request), encoding="utf-8")
    path = os.pathsep.join(filter(None, [str(directory), os.environ.get("PYTHONPATH", "")]))
    environment = os.environ | {"PYTHONPATH": path, "NUMBA_CACHE_DIR": str(directory / "kernels")}
    environment |= dict.fromkeys(("OMP_NUM_THREADS", "NUMBA_NUM_THREADS"), "1") | variables
    command = [sys.executable, "-P", "-m", module, str(file)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        raise EngineError(f"refimpl: no {what} within {limit:g} s") from None
    if done.returncode:
        raise EngineError(f"refimpl: no {what}: {done.stderr.strip()[-2000:]}")
    return json.loads(done.stdout.splitlines()[-1])
