"""What a scene asks of the machine's memory, estimated before anything of that size is made."""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path

from crosscheck.errors import UsageError
from crosscheck.scene.parts import Occupations, SceneEntries

#: Bytes that the start of a run takes at its peak, measured with 1e6 of them: for each component of a particle's
#: position (92 to 97 on a lattice, of hard spheres with the search for overlaps), and for each site of a lattice gas.
PER_COMPONENT, PER_SITE = 96, 32
#: Arrays as large as the mean occupations of a lattice gas that exist at once where these differ along x.
_OCCUPATIONS = 3
_GIB = 2**30


@cache
def memory() -> int:
    """Bytes of memory that this process can have: of the machine, or of its control group where that has less."""
    installed = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    try:
        limit = Path("/sys/fs/cgroup/memory.max").read_text().strip()
    except OSError:
        return installed
    return min(installed, int(limit)) if limit.isdecimal() else installed


def refuse_large(needed: float, what: str, mend: str) -> None:
    """UsageError if so much memory is needed that this machine does not have it.

    needed: bytes. what: needs it, with its numbers. mend: what the user may do.
    """
    if needed > memory():
        raise UsageError(
            f"{what} need about {needed / _GIB:.3g} GiB of memory, this machine has {memory() / _GIB:.3g} GiB: {mend}"
        )


def refuse_large_start(scene: SceneEntries) -> None:
    """UsageError if the initial state alone needs more memory than the machine has. scene: all entries."""
    gas, initial = scene.lattice_gas, scene.initial
    if gas is None:
        needed = float(PER_COMPONENT * scene.number * scene.dimension)
        refuse_large(needed, f"initial: {scene.number} particles", "take fewer particles")
        return
    from crosscheck.scene.lattice_gas import gas_model

    sites, per_site = gas.rows * gas.columns, float(PER_SITE)
    if isinstance(initial, Occupations) and any(wave.mode[0] for wave in initial.waves):
        per_site += 8 * _OCCUPATIONS * gas_model(scene).channels
    refuse_large(per_site * sites, f"lattice_gas: {gas.columns} x {gas.rows} sites", "take fewer rows or columns")
