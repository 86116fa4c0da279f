"""Files by LAMMPS itself, once for all tests of readers."""

import os
import subprocess
import sys
from pathlib import Path

import lammps_files
import pytest
from filelock import FileLock
from truth import Truth


@pytest.fixture(scope="session")
def lammps(tmp_path_factory: pytest.TempPathFactory) -> Truth:
    """Files of LAMMPS, and what it held in memory: see `lammps_files`."""
    base = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        base = base.parent  # of all workers
    directory: Path = base / "lammps-files"
    with FileLock(base / "lammps-files.lock"):
        if not (directory / "truth.npz").exists():
            directory.mkdir(exist_ok=True)
            subprocess.run([sys.executable, "-P", lammps_files.__file__, str(directory)], check=True, timeout=300)
    return Truth(directory)
