"""What memory costs on this machine, by the size of what is walked through: a pointer chase.

    python -P -m crosscheck.checks.performance.memory BYTES ...

prints, as a JSON list, nanoseconds of one step of a random cycle through so many bytes, a cache line a step. Each step
needs the one before, so nothing is fetched ahead; but four walkers are on the way at once, for a code that knows the
neighbours of a particle asks for several of them at a time. It runs in a process of its own: the loop is compiled.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Sequence

import numpy as np

from crosscheck.errors import EngineError

#: Bytes of a cache line; steps that are timed, and how often: the least counts.
_LINE, _STEPS, _TURNS = 64, 2_000_000, 3
#: Seconds that all of it may take.
_LIMIT = 300.0


def chase(footprints: Sequence[float]) -> list[float]:
    """Seconds of a step of a pointer chase through so many bytes, each of `footprints`; EngineError if it fails."""
    command = [sys.executable, "-P", "-m", __name__, *(str(int(size)) for size in footprints)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=_LIMIT, check=False)
    except subprocess.TimeoutExpired:
        raise EngineError(f"pointer chase: no answer within {_LIMIT:g} s") from None
    if done.returncode:
        raise EngineError(f"pointer chase: {done.stderr.strip()[-2000:]}")
    return [1e-9 * float(nanoseconds) for nanoseconds in json.loads(done.stdout)]


def cycle(lines: int, seed: int = 1) -> np.ndarray:
    """A random cycle through all lines: (8 lines,), the entry 8 k holds 8 times the line that follows line k.

    lines: their number. seed: of the order.
    """
    order = np.random.default_rng(seed).permutation(lines)
    following = np.zeros(8 * lines, dtype=np.int64)
    following[8 * order] = 8 * np.roll(order, -1)
    return following


def _main(footprints: list[int]) -> list[float]:
    from numba import njit

    @njit
    def walk(following, places, steps):  # type: ignore[no-untyped-def]
        a, b, c, d = places
        for _ in range(steps // 4):
            a, b, c, d = following[a], following[b], following[c], following[d]
        return a, b, c, d

    found = []
    for size in footprints:
        lines = max(4, size // _LINE)
        following = cycle(lines)
        places = walk(following, tuple(8 * (lines * k // 4) for k in range(4)), min(lines, _STEPS))
        taken = []
        for _ in range(_TURNS):
            started = time.process_time()
            places = walk(following, places, _STEPS)
            taken.append(time.process_time() - started)
        found.append(1e9 * min(taken) / _STEPS)
    return found


if __name__ == "__main__":
    sys.stdout.write(json.dumps(_main([int(size) for size in sys.argv[1:]])) + "\n")
