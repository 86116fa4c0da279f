"""Engine files: what stands beside them, and files of one name in two directories."""

import subprocess
import sys

import pytest

from crosscheck.engines.registry import engine_class

ENGINE = """
import helper

class Engine:
    name = helper.NAME
    schemes = {}
    capabilities = ()

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
    classes = [engine_class(name) for name in engines]
    assert [one.name for one in classes] == ["one", "two"]
    assert len({one.__module__ for one in classes}) == 2
    assert sys.path == path
    assert "helper" not in sys.modules


def test_methods_of_an_engine_import_its_neighbours(engines):
    """In a process of its own, as the worker is."""
    program = (
        "import sys; from crosscheck.engines.registry import load_class; print(load_class(sys.argv[1])().version())"
    )
    found = [
        subprocess.run([sys.executable, "-P", "-c", program, name], capture_output=True, text=True, check=True).stdout
        for name in engines
    ]
    assert found == ["one 0\n", "two 1\n"]
