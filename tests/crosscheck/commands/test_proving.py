"""The command that plants faults: what runs beside what. What it prints is tested with the command line."""

from __future__ import annotations

import threading
from dataclasses import replace

import pytest

from crosscheck.checks import all_checks
from crosscheck.checks.base import Check
from crosscheck.commands import proving
from crosscheck.faults import Fault
from crosscheck.verdict import Verdict


def test_faults_of_checks_that_measure_times_come_last_and_alone(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    planted = [check for check in all_checks() if check.faults][:5]
    checks = tuple(replace(check, timing=number % 2 == 0) for number, check in enumerate(planted))
    of_times = [check.name for check in checks if check.timing]
    lock, running, order = threading.Lock(), set[str](), list[tuple[str, int]]()

    def proved(check: Check, variant: str, fault: Fault, *, seed: int, time_limit: float) -> tuple[Verdict, str]:
        name = f"{check.name} {fault.name}"
        with lock:
            running.add(name)
            order.append((check.name, len(running)))
        with lock:
            running.remove(name)
        return Verdict(check.name, variant, "refimpl", "fail", None, ""), "pass"

    monkeypatch.setattr(proving, "all_checks", lambda: checks)
    monkeypatch.setattr(proving, "_prove_one", proved)
    assert proving.prove([], 3, 1) == 0
    number = sum(len(check.faults) for check in checks)
    assert f"{number} of {number} planted faults turned their check red" in capsys.readouterr().out
    last = sum(len(check.faults) for check in checks if check.timing)
    assert {name for name, _ in order[-last:]} == set(of_times)
    assert all(beside == 1 for _, beside in order[-last:])
