"""Kernels compiled by tests are kept apart for each state of the sources: numba's own cache can be stale."""

import os

from crosscheck.engines.cache import kernel_cache

os.environ["NUMBA_CACHE_DIR"] = str(kernel_cache())
