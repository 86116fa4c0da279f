"""The workflow files of docs/ci are valid, and their commands do what docs/regression.md says of them."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from ruamel.yaml import YAML

import crosscheck

ROOT = Path(__file__).parents[3]
FILES = {"github.yml": "vendor.github-workflows", "gitlab.yml": "vendor.gitlab-ci"}
EXAMPLE = ROOT / "examples" / "my_engine.py"
#: A check that takes a second.
CHECKS = "stepping/spring-f*"


def workflow(name: str) -> Any:
    return YAML(typ="safe").load((ROOT / "docs" / "ci" / name).read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", FILES)
def test_a_file_is_valid_by_the_schema_of_its_server(name: str) -> None:
    words = ["check_jsonschema", "--builtin-schema", FILES[name], str(ROOT / "docs" / "ci" / name)]
    done = subprocess.run([sys.executable, "-P", "-m", *words], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A repository with an engine, and a baseline that was made as the head of the files says."""
    place = tmp_path_factory.mktemp("repository")
    shutil.copy(EXAMPLE, place)
    # a pattern of checks must not become the name of this file
    (place / "stepping").mkdir()
    (place / "stepping" / "spring-figures").touch()
    script = f"set -f\ncrosscheck run {CHECKS} --engine my_engine.py:MyEngine && crosscheck baseline accept"
    done = shell(place, script, {})
    assert done.returncode == 0, done.stderr
    shutil.rmtree(place / "crosscheck-out")
    return place


@pytest.fixture
def repository(made: Path, tmp_path: Path) -> Path:
    """A copy of that repository."""
    return Path(shutil.copytree(made, tmp_path / "repository"))


def shell(place: Path, script: str, variables: dict[str, str]) -> subprocess.CompletedProcess[str]:
    """Runs a script as the servers do, which stop at the first command that fails."""
    command = f'crosscheck() {{ "{sys.executable}" -P -m crosscheck.cli "$@"; }}\n'
    environment = os.environ | {
        "PYTHONPATH": str(Path(crosscheck.__path__[0]).parent),
        "NUMBA_DISABLE_JIT": "1",  # plain Python is enough for short runs
        **variables,
    }
    environment.pop("XDG_CACHE_HOME", None)
    words = ["bash", "-e", "-c", command + script]
    return subprocess.run(words, cwd=place, capture_output=True, text=True, check=False, env=environment)


def breaks(engine: Path) -> None:
    """A mistake in the forces of the engine."""
    text = engine.read_text(encoding="utf-8")
    assert text.count("forces = -scene.spring.k * r") == 1
    engine.write_text(text.replace("forces = -scene.spring.k * r", "forces = -1.001 * scene.spring.k * r"))


# -- GitHub ---------------------------------------------------------------------------------------------------


def steps(job: str) -> list[dict[str, Any]]:
    return list(workflow("github.yml")["jobs"][job]["steps"])


def commands(job: str) -> str:
    """What a job runs, but for the installation."""
    scripts = [step["run"] for step in steps(job) if "run" in step]
    assert scripts[0] == "pip install particle-crosscheck"
    return "\n".join(scripts[1:])


def kept(job: str) -> list[str]:
    (upload,) = (step for step in steps(job) if "upload-artifact" in step.get("uses", ""))
    assert upload["if"] == "always()"
    return str(upload["with"]["path"]).split()


def variables() -> dict[str, str]:
    """Those of the workflow, as a user sets them for his repository."""
    declared = dict(workflow("github.yml")["env"])
    assert declared.keys() == {"ENGINE", "CHECKS", "XDG_CACHE_HOME"}
    assert declared["ENGINE"] == "my_engine.py:MyEngine"
    assert declared["XDG_CACHE_HOME"] == "${{ github.workspace }}/.cache"
    (cache,) = (step for step in steps("baseline") if "cache@" in step.get("uses", ""))
    assert cache["with"]["path"] == ".cache/particle-crosscheck"
    return {"ENGINE": declared["ENGINE"], "CHECKS": CHECKS, "GITHUB_STEP_SUMMARY": "summary.md"}


def test_github_compares_with_the_baseline(repository: Path) -> None:
    done = shell(repository, commands("baseline"), variables())
    assert done.returncode == 0, done.stdout + done.stderr
    assert all((repository / path).exists() for path in kept("baseline"))
    assert (repository / "crosscheck-out" / "record.jsonl").is_file()
    assert (repository / "summary.md").read_text().startswith("## particle-crosscheck\n\n**1 pass**\n")


def test_github_compares_both_sides_of_a_pull_request(repository: Path) -> None:
    checkouts = [step["with"] for step in steps("difference") if "checkout@" in step.get("uses", "")]
    assert [one["path"] for one in checkouts] == ["after", "before"]
    assert checkouts[1]["ref"] == "${{ github.base_ref }}"
    place = repository.parent
    for side in ("before", "after"):
        shutil.copytree(repository, place / side)
    breaks(place / "after" / "my_engine.py")
    judge, compare = (step["run"] for step in steps("difference")[-3:-1])
    assert commands("difference") == f"{judge}\n{compare}"
    done = shell(place, judge, variables())
    assert done.returncode == 0, done.stdout + done.stderr
    done = shell(place, compare, variables())
    assert done.returncode == 1
    assert done.stdout.startswith("after-out beside before-out: ")
    assert "new failures: " in done.stdout
    assert all((place / path).is_dir() for path in kept("difference"))
    wrong = shell(place, judge, variables() | {"CHECKS": "no/such/check"})
    assert wrong.returncode != 0, "bad usage is no result to compare"


# -- GitLab ---------------------------------------------------------------------------------------------------


def test_gitlab_is_red_for_what_is_worse_than_the_baseline(repository: Path) -> None:
    job = workflow("gitlab.yml")["physics"]
    assert job["variables"].keys() == {"ENGINE", "CHECKS", "XDG_CACHE_HOME"}
    install, *script = job["script"]
    assert install == "pip install particle-crosscheck"
    set_by_user = {"ENGINE": job["variables"]["ENGINE"], "CHECKS": CHECKS}
    artifacts = [*job["artifacts"]["paths"], job["artifacts"]["reports"]["junit"]]
    breaks(repository / "my_engine.py")
    done = shell(repository, "\n".join(script), set_by_user)
    assert done.returncode == 1, done.stdout + done.stderr
    assert all((repository / path).exists() for path in artifacts)
    assert job["allow_failure"] == {"exit_codes": [3]}
    assert job["artifacts"]["when"] == "always"
    assert "### new failures: " in (repository / "summary.md").read_text()
