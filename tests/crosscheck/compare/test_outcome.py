"""The class of two results and its sentence, from all evidence together; and the exit status by each standard."""

from __future__ import annotations

from typing import Any

import pytest
from pairs_of_runs import gap

from crosscheck.compare import samples
from crosscheck.compare.differences import Difference, Gap
from crosscheck.compare.growth import Growth, Law, Parting
from crosscheck.compare.outcome import MODES, Evidence, classify, later, moment, statistics_sentence, status

OFF = Difference(1, "positions", 7, 0, 1.0, 2.0, 1e-9)
LAW = Law(2.5, 0.04, 3e-16, 1.5, 1e-13, (1, 9), 11.7)


def apart(time: float) -> Gap:
    return gap(
        time, same=False, beyond=OFF, differing=OFF, rms={"positions": 0.25, "velocities": 0.75},
        largest={"positions": 0.5, "velocities": 1.0}, farthest={"positions": 7, "velocities": 9},
    )  # fmt: skip


def quantity(name: str, outcome: str, sensitivity: float = 0.01, probability: float = 0.5) -> samples.Tested:
    return samples.Tested(name, 1.0, 1.5, 0.125, 20.0, probability, sensitivity, 30.0, outcome)


def evidence(**known: Any) -> Evidence:
    entries: dict[str, Any] = {
        "setup": [], "gaps": [gap(0.0), apart(0.5)], "growth": Growth("chaos", LAW), "tested": None, "start": False,
        "neighbours": [], "steps": None, "lost": None, "broken": None, "clock": "time",
    }  # fmt: skip
    return Evidence(**(entries | known))


SAME, DIFFERENT = [quantity("mean v^2", "same")], [quantity("mean v^2", "different")]
UNCLEAR = [quantity("mean v^2", "unclear")]


@pytest.mark.parametrize(
    ("found", "mode", "classed", "told"),
    [
        (evidence(setup=["a", "b", "c", "d"]), "chaos", "different_setup", "different set-up: a; b; c."),
        (evidence(gaps=[gap(0.0), gap(1.0)]), "chaos", "same_bits", "same bits: all 2 common frames."),
        (
            evidence(gaps=[gap(0.0), apart(0.5)._replace(beyond=None)]),
            "chaos",
            "same_within_rounding",
            "no particle is further from itself than 5.0e-01 (rounding of the files: 1.0e-16)",
        ),
        (
            evidence(gaps=[gap(0.0, same=False, largest={}, floor={})]),
            "chaos",
            "same_within_rounding",
            "no particle is further from itself than 0.0e+00 (rounding of the files: 0.0e+00)",
        ),
        (
            evidence(start=True, gaps=[apart(0.0)]),
            "chaos",
            "different_setup",
            "position x of particle 7 is 1.0 against 2",
        ),
        (evidence(start=True, tested=SAME), "statistics", "same_statistics", "same statistics: 1 quantities agree"),
        (evidence(), "chaos", "chaos_only", "lambda = 2.5 +- 0.04, from 3.0e-16 (within a factor of 1.5)"),
        (evidence(), "chaos", "chaos_only", "rounding explains up to 1.0e-13; beyond t = 11.7 single"),
        (evidence(gaps=[apart(0.0)]), "chaos", "chaos_only", "the starts differ by 5.0e-01 already (position x of"),
        (evidence(tested=SAME), "chaos", "chaos_only", "need not agree. Same statistics: 1 quantities"),
        (
            evidence(tested=DIFFERENT),
            "chaos",
            "different_statistics",
            "Up to the horizon of chaos their dynamics are the",
        ),
        (evidence(tested=UNCLEAR), "chaos", "chaos_only", "single particles need not agree."),
        (evidence(growth=Growth("unclear"), tested=SAME), "chaos", "same_statistics", "Of single particles: inconclu"),
        (evidence(growth=Growth("unclear"), tested=UNCLEAR), "chaos", "inconclusive", "too few independent frames"),
        (evidence(growth=Growth("unclear")), "chaos", "inconclusive", "give the scene (--scene)"),
        (evidence(growth=Growth("rounding")), "chaos", "chaos_only", "which rounding explains without chaos"),
        (evidence(broken=1), "chaos", "different_dynamics", "at t = 0.5, a number is not finite"),
        (
            evidence(gaps=[gap(0.0), gap(0.5, missing=(2, 1), same=False)], lost=1),
            "chaos",
            "different_dynamics",
            "2 particles of the first and 1 of the second are not in the other",
        ),
        (
            evidence(growth=Growth("early", LAW, Parting(1, 1e-9)), neighbours=[3, 4], steps=[0, 100]),
            "chaos",
            "different_dynamics",
            "too early: at t = 0.5 (step 100), particle 7 is 5.00e-01 away from itself (root mean square of all: "
            "2.50e-01), where rounding and chaos explain 1.0e-09; its nearest neighbours are 3, 4.",
        ),
        (
            evidence(growth=Growth("jump", None, Parting(1, 1e-9))),
            "chaos",
            "different_dynamics",
            "a jump: at t = 0.5, particle 7 is 5.00e-01 away from itself (root mean square of all: 2.50e-01), where "
            "rounding explains 1.0e-09.",
        ),
        (
            evidence(growth=Growth("velocities", LAW, Parting(1, 0.5))),
            "chaos",
            "different_dynamics",
            "velocities are 7.50e-01 apart (root mean square; particle 9 most), where positions, which are 2.50e-01 "
            "apart, explain 5.0e-01.",
        ),
        (
            evidence(growth=Growth("momentum", LAW, Parting(1, 1e-9))),
            "chaos",
            "different_dynamics",
            "they are 5.00e+00 apart, where rounding explains 1.0e-09; the velocity of particle 9 differs most.",
        ),
    ],
)
def test_the_class_and_its_reason(found: Evidence, mode: Any, classed: str, told: str) -> None:
    what, sentence = classify(found, mode)
    assert what == classed
    assert told in sentence


def test_dynamics_that_differ_do_so_whatever_the_statistics_say() -> None:
    early = evidence(growth=Growth("early", LAW, Parting(1, 1e-9)), tested=SAME)
    what, sentence = classify(early, "chaos")
    assert what == "different_dynamics"
    assert sentence.endswith("would be seen in mean v^2.")


def test_statistics_name_what_is_off_or_what_would_be_seen() -> None:
    many = [quantity(str(k), "different", probability=k * 1e-9) for k in (4, 2, 3, 1)]
    what, sentence = statistics_sentence([*many, *SAME])
    assert what == "different_statistics"
    numbers = "1 against 1.5 (4.0 standard errors)"
    assert sentence == f"different statistics: 1 {numbers}; 2 {numbers}; 3 {numbers}, and 1 more."
    assert statistics_sentence(many[:3])[1].endswith("standard errors).")
    best = [quantity("a", "same", 0.03), quantity("b", "same", 0.02), quantity("c", "unclear", 0.01)]
    assert statistics_sentence(best)[1] == (
        "same statistics: 2 quantities agree; a difference of 2.0% would be seen in b."
    )


@pytest.mark.parametrize(
    ("classed", "statuses"),
    [
        ("same_bits", (0, 0, 0, 0)),
        ("same_within_rounding", (1, 0, 0, 0)),
        ("chaos_only", (1, 1, 0, 3)),
        ("different_dynamics", (1, 1, 1, 1)),
        ("different_setup", (1, 1, 1, 1)),
        ("same_statistics", (1, 1, 3, 0)),
        ("different_statistics", (1, 1, 1, 1)),
        ("inconclusive", (1, 1, 3, 3)),
    ],
)
def test_the_exit_status_by_each_standard(classed: Any, statuses: tuple[int, ...]) -> None:
    assert MODES == ("exact", "tolerance", "chaos", "statistics")
    assert tuple(int(status(classed, mode)) for mode in MODES) == statuses


def test_moments_in_words() -> None:
    assert moment("time", 1.6, 320) == "t = 1.6 (step 320)"
    assert moment("time", 1.6, None) == "t = 1.6"
    assert moment("step", 12345678.0, 12345678) == "step 12345678"
    assert moment("order", 3.0, 320) == "frame 3 (step 320)"
    assert moment("order", 1234567.0, None) == "frame 1234567"
    assert (later("time", 11.71234), later("step", 2.0), later("order", 4.5)) == ("t = 11.71", "step 2", "frame 4.5")
