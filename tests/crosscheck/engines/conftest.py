"""A worker that the tests of a file share."""

import sys
from collections.abc import Iterator

import pytest

from crosscheck.engines.workers.pool import Worker


@pytest.fixture(scope="module")
def lammps() -> Iterator[Worker]:
    """In a process of its own: LAMMPS and numba do not share one."""
    worker = Worker("lammps", time_limit=60)
    yield worker
    worker.close()
    assert "lammps" not in sys.modules
