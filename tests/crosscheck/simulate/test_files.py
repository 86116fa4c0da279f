"""The directory of a simulation: whole results, no files of an earlier one, and nothing that is not ours is touched."""

import os

import pytest

from crosscheck.errors import UsageError
from crosscheck.simulate.files import MANIFEST, file_labels, results_in


def write(out, **files):
    with results_in(out) as results:
        paths = []
        for stem, text in files.items():
            paths.append(results.scratch / f"{stem}.csv")
            paths[-1].write_text(text)
        return results.put(paths)


def names(out):
    return {path.name for path in out.iterdir()}


def test_files_of_an_earlier_simulation_are_removed(tmp_path):
    out = tmp_path / "out"
    assert write(out, a="1", b="2") == [out / "a.csv", out / "b.csv"]
    (out / "mine.txt").write_text("of the user")
    write(out, a="3")
    assert names(out) == {"a.csv", "mine.txt", MANIFEST}
    assert (out / "a.csv").read_text() == "3"


def test_what_was_changed_since_is_not_removed(tmp_path):
    write(tmp_path, a="1", b="2", c="3")
    (tmp_path / "b.csv").write_text("edited by hand")
    (tmp_path / "kept.csv").write_text("3")
    (tmp_path / "c.csv").unlink()
    (tmp_path / "c.csv").symlink_to(tmp_path / "kept.csv")
    write(tmp_path, a="1")
    assert names(tmp_path) == {"a.csv", "b.csv", "c.csv", "kept.csv", MANIFEST}


def test_a_list_that_names_files_elsewhere_removes_none(tmp_path):
    out = tmp_path / "out"
    write(out, a="1")
    (tmp_path / "precious.csv").write_text("1")
    (out / MANIFEST).write_text((out / MANIFEST).read_text().replace("a.csv", "../precious.csv"))
    write(out, b="2")
    assert (tmp_path / "precious.csv").is_file()


@pytest.mark.parametrize("text", ["", "not JSON", "[1, 2]", '{"a.csv": 1}', '{"..": "x", "": "y"}'])
def test_a_damaged_list_removes_nothing(tmp_path, text):
    write(tmp_path, a="1")
    (tmp_path / MANIFEST).write_text(text)
    write(tmp_path, b="2")
    assert names(tmp_path) == {"a.csv", "b.csv", MANIFEST}


@pytest.mark.parametrize("name", ["a.csv", MANIFEST])
def test_links_are_replaced_and_not_followed(tmp_path, name):
    precious = tmp_path / "precious"
    precious.write_text("of the user")
    out = tmp_path / "out"
    out.mkdir()
    (out / name).symlink_to(precious)
    write(out, a="1")
    assert precious.read_text() == "of the user"
    assert not (out / name).is_symlink()
    assert (out / "a.csv").read_text() == "1"


def test_a_directory_in_place_of_a_file(tmp_path):
    (tmp_path / "a.csv").mkdir()
    with pytest.raises(UsageError, match=r"a\.csv: is a directory"):
        write(tmp_path, a="1")


def test_a_failure_leaves_the_directory_as_it_was(tmp_path):
    write(tmp_path, a="1")
    with pytest.raises(FileNotFoundError), results_in(tmp_path) as results:  # noqa: PT012 - within the block it fails
        (results.scratch / "a.csv").write_text("half")
        results.put([results.scratch / "a.csv", results.scratch / "missing.csv"])
    assert names(tmp_path) == {"a.csv", MANIFEST}
    assert (tmp_path / "a.csv").read_text() == "1"


def test_a_directory_that_cannot_be_written_to(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match=r"--out .*file: cannot be written to"), results_in(tmp_path / "file"):
        pass


@pytest.mark.parametrize(
    ("engines", "labels"),
    [
        (["refimpl", "lammps"], ["refimpl", "lammps"]),
        (["some/engine.py:Engine"], ["engine.py-Engine"]),
        (["A/x.py:Engine", "B/x.py:Engine"], ["A-x.py-Engine", "B-x.py-Engine"]),
        (["A/x.py:Engine", "a/x.py:Engine"], ["1-x.py-Engine", "2-x.py-Engine"]),
        (["a.py:" + "E" * 200, "b.py:" + "E" * 200], ["1-" + "E" * 150, "2-" + "E" * 150]),
        (["x.py:One", "x.py:Two"], ["x.py-One", "x.py-Two"]),
        (["/a b/x.py:E", "/a-b/x.py:E"], ["1-x.py-E", "2-x.py-E"]),
    ],
)
def test_labels_of_engines_differ(tmp_path, monkeypatch, engines, labels):
    monkeypatch.chdir(tmp_path)
    assert list(file_labels(engines).values()) == labels
    assert all(os.sep not in label for label in labels)
