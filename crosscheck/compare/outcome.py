"""What a comparison of two results says: its class, in one sentence, and the exit status by the asked standard."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple, get_args

from crosscheck.compare.differences import VECTORS, Difference, Gap
from crosscheck.compare.growth import Growth, Law, Parting
from crosscheck.compare.pairing import Clock
from crosscheck.compare.samples import Tested, different
from crosscheck.status import Status

#: What two results are to each other.
Class = Literal[
    "same_bits",
    "same_within_rounding",
    "chaos_only",
    "different_dynamics",
    "different_setup",
    "same_statistics",
    "different_statistics",
    "inconclusive",
]
#: By which standard two results are to be the same.
Mode = Literal["exact", "tolerance", "chaos", "statistics"]
MODES: tuple[Mode, ...] = get_args(Mode)

#: Classes that are the same by each standard; others are different, but "inconclusive".
_SAME: dict[Mode, tuple[Class, ...]] = {
    "exact": ("same_bits",),
    "tolerance": ("same_bits", "same_within_rounding"),
    "chaos": ("same_bits", "same_within_rounding", "chaos_only"),
    "statistics": ("same_bits", "same_within_rounding", "same_statistics"),
}
#: Classes that a standard cannot judge.
_OPEN: dict[Mode, tuple[Class, ...]] = {
    "exact": (),
    "tolerance": (),
    "chaos": ("inconclusive", "same_statistics"),
    "statistics": ("inconclusive", "chaos_only"),
}
#: What stands before the number of a frame.
_CLOCKS: dict[Clock, str] = {"time": "t =", "step": "step", "order": "frame"}
#: Most particles, quantities or sentences that a sentence names.
_FEW = 3


def status(classed: Class, mode: Mode) -> Status:
    """Exit status: 0 the same by the standard, 1 different, 3 inconclusive.

    classed: what two results are to each other. mode: the standard.
    """
    if classed in _SAME[mode]:
        return Status.PASSED
    return Status.INCONCLUSIVE if classed in _OPEN[mode] else Status.FAILED


class Evidence(NamedTuple):
    """What was found out about two trajectories.

    setup: see `different_setup`. gaps: of all pairs of frames. growth: None if nothing is beyond the rounding of the
    files. tested: statistics; None: not looked at. start: whether the first frame
    is further apart than a disturbance may be. neighbours: ids of the nearest neighbours of the particle that is
    farthest apart where the dynamics part. steps: of the frames, or None. lost: number of the first frame with
    particles that the other has not. broken: number of the first frame with a number that is not finite. clock:
    by what frames are matched.
    """

    setup: list[str]
    gaps: list[Gap]
    growth: Growth | None
    tested: list[Tested] | None
    start: bool
    neighbours: list[int]
    steps: list[int] | None
    lost: int | None
    broken: int | None
    clock: Clock


def classify(found: Evidence, mode: Mode) -> tuple[Class, str]:
    """The class of two trajectories, and one plain sentence that says why.

    found: the evidence. mode: with "statistics", the statistics decide where they were looked at.
    """
    gaps = found.gaps
    if found.setup:
        return "different_setup", f"different set-up: {'; '.join(found.setup[:_FEW])}."
    if all(gap.same for gap in gaps):
        return "same_bits", f"same bits: all {len(gaps)} common frames."
    if all(gap.beyond is None for gap in gaps) and found.lost is None:
        return "same_within_rounding", f"same within the files' rounding: {_largest(gaps)}."
    statistics = None if found.tested is None else statistics_sentence(found.tested)
    if mode == "statistics" and statistics is not None:
        return statistics
    if found.start:
        return (
            "different_setup",
            f"different set-up: in the first frame, {_component(gaps[0].beyond)}. Runs of other starts are compared by "
            "--mode statistics.",
        )
    classed, sentence = _dynamics(found)
    if statistics is None:
        return classed, sentence
    if classed == "inconclusive":
        return statistics[0], f"{statistics[1]} Of single particles: {sentence}"
    if classed == "chaos_only" and statistics[0] == "different_statistics":
        return "different_statistics", f"{statistics[1]} Up to the horizon of chaos their dynamics are the same."
    return classed, sentence if statistics[0] == "inconclusive" else f"{sentence} {_capital(statistics[1])}"


def _dynamics(found: Evidence) -> tuple[Class, str]:
    """The class by how the two runs part."""
    growth, gaps = found.growth, found.gaps
    if found.broken is not None:
        return "different_dynamics", f"different dynamics: at {_when(found, found.broken)}, a number is not finite."
    if found.lost is not None:
        gap = gaps[found.lost]
        return (
            "different_dynamics",
            f"different dynamics: at {_when(found, found.lost)}, {gap.missing[0]} particles of the first and"
            f" {gap.missing[1]} of the second are not in the other.",
        )
    assert growth is not None
    if growth.kind == "rounding":
        return "chaos_only", f"rounding alone: {_largest(gaps)}, which rounding explains without chaos."
    law, parting = growth.law, growth.parting
    if growth.kind == "chaos" and law is not None:
        return (
            "chaos_only",
            f"chaos only: the separation grows as exp(lambda t), lambda = {_rate(law)}, from {law.start:.1e} (within a "
            f"factor of {law.factor:.2g}), and rounding explains up to {law.limit:.1e};{_disturbed(gaps[0])} beyond "
            f"{later(found.clock, law.horizon)} single particles need not agree.",
        )
    if parting is not None:
        return "different_dynamics", f"different dynamics{_parting(found, growth, parting)}"
    return (
        "inconclusive",
        "inconclusive: too few frames show how the separation grows, between the rounding of the files and the distance"
        " of neighbours; write more frames at the start, with more digits, or give the scene (--scene), whose rate is"
        " then measured.",
    )


def _parting(found: Evidence, growth: Growth, parting: Parting) -> str:
    """The rest of the sentence on runs that part: when, which particle, by how much, and what would be explained."""
    gap, when, explained = found.gaps[parting.frame], _when(found, parting.frame), f"{parting.expected:.1e}"
    if growth.kind == "momentum":
        assert gap.momentum is not None
        return (
            f": at {when}, one run has not kept its total momentum, the other has: they are "
            f"{math.dist(*gap.momentum):.2e} apart, where rounding explains {explained}; the velocity of particle "
            f"{gap.farthest['velocities']} differs most."
        )
    if growth.kind == "velocities":
        return (
            f": at {when}, velocities are {gap.rms['velocities']:.2e} apart (root mean square; particle "
            f"{gap.farthest['velocities']} most), where positions, which are {gap.rms['positions']:.2e} apart, explain "
            f"{explained}."
        )
    how = "too early" if growth.kind == "early" else "a jump"
    by = "and chaos explain" if growth.law else "explains"
    near = f"; its nearest neighbours are {', '.join(map(str, found.neighbours))}" if found.neighbours else ""
    return (
        f", {how}: at {when}, particle {gap.farthest['positions']} is {gap.largest['positions']:.2e} away from itself "
        f"(root mean square of all: {gap.rms['positions']:.2e}), where rounding {by} {explained}{near}."
    )


def statistics_sentence(tested: list[Tested]) -> tuple[Class, str]:
    """The class of two samples, and a sentence that says why. tested: of `compare_samples` or `compare_series`."""
    off = different(tested)
    if off:
        told = [
            f"{one.name} {one.first:.5g} against {one.second:.5g} ({abs(one.first - one.second) / one.error:.1f} "
            "standard errors)"
            for one in off[:_FEW]
        ]
        more = f", and {len(off) - _FEW} more" if len(off) > _FEW else ""
        return "different_statistics", f"different statistics: {'; '.join(told)}{more}."
    judged = [one for one in tested if one.outcome == "same"]
    if not judged:
        return "inconclusive", "inconclusive: too few independent frames for statistics."
    best = min(judged, key=lambda one: one.sensitivity)
    return (
        "same_statistics",
        f"same statistics: {len(judged)} quantities agree; a difference of {best.sensitivity:.1%} would be seen in "
        f"{best.name}.",
    )


def _rate(law: Law) -> str:
    return f"{law.rate:.3g} +- {law.error:.1g}" if law.error else f"{law.rate:.3g}"


def _disturbed(gap: Gap) -> str:
    """What the first frame says of a start that was disturbed or rounded, within the sentence."""
    if gap.beyond is None:
        return ""
    return f" the starts differ by {gap.largest[gap.beyond.quantity]:.1e} already ({_component(gap.beyond)});"


def _component(one: Difference | None) -> str:
    """Particle, quantity and numbers of a component that differs."""
    assert one is not None
    return (
        f"{VECTORS[one.quantity]} {'xyz'[one.axis]} of particle {one.particle} is {one.first!r} against {one.second!r}"
    )


def _largest(gaps: list[Gap]) -> str:
    """The largest distance of a particle from itself, and where."""
    at = max(range(len(gaps)), key=lambda k: gaps[k].largest.get("positions", 0.0))
    gap = gaps[at]
    far, floor = gap.largest.get("positions", 0.0), gap.floor.get("positions", 0.0)
    return f"no particle is further from itself than {far:.1e} (rounding of the files: {floor:.1e})"


def _when(found: Evidence, at: int) -> str:
    return moment(found.clock, found.gaps[at].time, None if found.steps is None else found.steps[at])


def moment(clock: Clock, time: float, step: int | None) -> str:
    """The moment of a frame in words: "t = 1.6 (step 320)", "step 320", or "frame 3 (step 320)".

    clock: by what frames are matched. time: of the frame on this clock. step: of the frame; None: it is not known.
    """
    if clock == "step":
        return f"step {time:.0f}"
    found = f"t = {time:g}" if clock == "time" else f"frame {time:.0f}"
    return found if step is None else f"{found} (step {step})"


def later(clock: Clock, time: float) -> str:
    """A moment between frames in words, such as the horizon of chaos. clock, time: as in `moment`."""
    return f"{_CLOCKS[clock]} {time:.4g}"


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
