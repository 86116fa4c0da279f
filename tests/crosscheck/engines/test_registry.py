"""Engine files: what stands beside them, and files of one name in two directories."""

import sys

import pytest

from crosscheck.engines.registry import engine_class
from crosscheck.engines.workers.pool import Worker

ENGINE = """
from crosscheck.engines.capabilities import capability
from crosscheck.engines.protocol import Claims
import helper

class Engine:
    name = helper.NAME
    schemes = {"euler": Claims((1, 1), (1, 1))}
    capabilities = (capability("spring", "stepping", words="dimension=1", observables="kinetic_energy"),)

    def version(self):
        import late
        return f"{helper.NAME} {late.NUMBER}"

    def supports(self, scene, method):
        return None

    def run(self, scene, method):
        return None
"""


@pytest.fixture
def engines(tmp_path):
    """Two engine files of one name, each with neighbours of one name."""
    found = []
    for number, name in enumerate(("one", "two")):
        directory = tmp_path / name
        directory.mkdir()
        (directory / "engine.py").write_text(ENGINE)
        (directory / "helper.py").write_text(f"NAME = {name!r}\n")
        (directory / "late.py").write_text(f"NUMBER = {number}\n")
        found.append(f"{directory}/engine.py:Engine")
    return found


def test_neighbours_of_one_name_are_not_mixed_up(engines):
    path = list(sys.path)
    assert [engine_class(name).name for name in engines] == ["one", "two"]
    assert sys.path == path
    assert "helper" not in sys.modules


def test_methods_of_an_engine_import_its_neighbours(engines):
    for name, version in zip(engines, ("one 0", "two 1"), strict=True):
        worker = Worker(name, time_limit=120)
        try:
            assert worker.version() == version
        finally:
            worker.close()
