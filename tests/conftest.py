"""Kernels compiled by tests are kept apart for each state of the sources; hypothesis repeats its examples."""

import os
from collections.abc import Callable, Iterator
from types import ModuleType

# as in `crosscheck.cli.main`; it is read when numpy is imported
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import pytest
from hypothesis import settings
from plain_python import plain_python

from crosscheck.engines.workers.cache import kernel_cache, take_care_of_damage
from crosscheck.engines.workers.pool import Worker

# numba's own cache can be stale
os.environ["NUMBA_CACHE_DIR"] = str(kernel_cache())
# as in the workers, which share the cache
take_care_of_damage()

# no limit on the time of one example: the machine may be shared, and the first may compile
settings.register_profile("repeatable", derandomize=True, deadline=None, max_examples=50)
settings.load_profile("repeatable")


@pytest.fixture(scope="session")
def interpreted() -> Iterator[Worker]:
    """`refimpl` as plain Python, for scenes so small that compiling would take longer than running."""
    worker = Worker("refimpl", time_limit=300, interpreted=True)
    yield worker
    worker.close()


@pytest.fixture
def plain_module() -> Iterator[Callable[[str], ModuleType]]:
    """Modules of `refimpl` and of tests/support whose kernels run as plain Python, in this process, by their names."""
    with np.errstate(all="ignore"):  # as in a process that interprets all kernels
        yield plain_python
