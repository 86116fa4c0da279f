"""The command line, in the process of the tests."""

import sys
from pathlib import Path

import pytest
from command_line import Command, Outcome

from crosscheck import cli


@pytest.fixture
def crosscheck(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Command:
    """Runs `crosscheck <words>` in this process."""

    def call(*words: str | Path) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["crosscheck", *map(str, words)])
        with pytest.raises(SystemExit) as end:
            cli.main()
        out, err = capfd.readouterr()
        return Outcome(end.value.code or 0, out, err)

    return call
