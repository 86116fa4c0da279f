"""Runs that should all be the same: which one is not, and at which frame it left the others."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

from crosscheck.compare.differences import VECTORS, converted
from crosscheck.compare.outcome import moment
from crosscheck.compare.pairing import Clock, Pairing, pair
from crosscheck.errors import UsageError
from crosscheck.files import shown_path
from crosscheck.trajectories.frames import Frame, Source


class Replicas(NamedTuple):
    """What several runs are to each other.

    reference: number of a run that stayed with the largest group to the end. left: number of a run -> number of the
    frame, among those of the reference, at which its bits were first different from that group's. groups: sizes of the
    groups with the same bits in all frames, largest first. frames: that all have. clock: by what they are matched.
    times: of these on this clock, of the first run. steps: of these, or None. remarks: whole sentences.
    """

    reference: int
    left: dict[int, int]
    groups: tuple[int, ...]
    frames: int
    clock: Clock
    times: tuple[float, ...]
    steps: tuple[int, ...] | None
    remarks: tuple[str, ...]

    def when(self, frame: int) -> str:
        """The moment of a frame, in words. frame: its number among those that all have."""
        return moment(self.clock, self.times[frame], None if self.steps is None else self.steps[frame])


def replicas(sources: Sequence[Source], progress: Callable[[int, int], Any] = lambda done, total: None) -> Replicas:
    """Which runs leave the others, and when; every file is read once, and of each frame a digest is kept.

    At every frame, the runs that were the same so far are grouped by their bits; those outside the largest group leave
    there (of two groups of one size, those without the first run). What not all files hold, as velocities, does not
    count. sources: at least two trajectories. progress: is told the number of files read, and of all. UsageError if a
    run has no frame in common with the first.
    """
    pairings = [pair(sources[0], other) for other in sources[1:]]
    common = set(range(len(sources[0])))
    for pairing in pairings:
        common &= {int(frame) for frame in pairing.first}
    if not common:
        raise UsageError(f"{shown_path(sources[0].path)}: no frame is common to all runs: compare them in pairs")
    frames = sorted(common)
    counterparts = [{frame: frame for frame in frames}]
    for pairing in pairings:
        counterparts.append({int(a): int(b) for a, b in zip(pairing.first, pairing.second, strict=True)})
    starts = [source.read(places[frames[0]]) for source, places in zip(sources, counterparts, strict=True)]
    held = [name for name in VECTORS if all(getattr(start, name) is not None for start in starts)]
    digests = []
    for number, (source, places) in enumerate(zip(sources, counterparts, strict=True)):
        read = (source.read(places[frame]) for frame in frames)
        digests.append([_digest(one if not number else converted(one, pairings[number - 1]), held) for one in read])
        progress(number + 1, len(sources))
    left: dict[int, int] = {}
    staying = list(range(len(sources)))
    for place in range(len(frames)):
        groups = Counter(digests[member][place] for member in staying)
        if len(groups) == 1:
            continue
        first = digests[staying[0]][place]
        largest = max(groups, key=lambda digest: (groups[digest], digest == first))
        left |= {member: place for member in staying if digests[member][place] != largest}
        staying = [member for member in staying if digests[member][place] == largest]
    whole = Counter(tuple(one) for one in digests)
    clock = pairings[0].clock if len({pairing.clock for pairing in pairings}) == 1 else "order"
    on_clock = dict(zip(pairings[0].first.tolist(), pairings[0].times.tolist(), strict=True))
    steps = sources[0].steps
    return Replicas(
        staying[0],
        left,
        tuple(sorted(whole.values(), reverse=True)),
        len(frames),
        clock,
        tuple(float(frame if clock == "order" else on_clock[frame]) for frame in frames),
        None if steps is None else tuple(int(steps[frame]) for frame in frames),
        tuple(_left_open(sources, pairings, starts, held)),
    )


def _left_open(
    sources: Sequence[Source], pairings: Sequence[Pairing], starts: Sequence[Frame], held: list[str]
) -> Iterator[str]:
    """Sentences on what is not compared, and on files whose bits differ for the way they are written alone."""
    first = sources[0]
    for name in VECTORS:
        if name not in held and any(getattr(start, name) is not None for start in starts):
            yield f"{VECTORS[name]} is not in all files, and is not compared."
    for source, pairing in zip(sources[1:], pairings, strict=True):
        why = [
            f"{name} of {source.rounding[name].name} against {first.rounding[name].name}"
            for name in held
            if source.rounding[name] != first.rounding[name]
        ]
        if source.wrapping != first.wrapping:
            why.append(f"{source.wrapping} against {first.wrapping} positions")
        if not pairing.length == pairing.velocity == pairing.spin == 1:
            why.append("converted units")
        if why:
            yield (
                f"{source.path.name} is written in another way than {first.path.name} ({'; '.join(why)}): its bits may"
                " differ for that alone, so files of one format tell more."
            )


def _digest(frame: Frame, held: list[str]) -> bytes:
    """A digest of the bits of a frame. held: the quantities that count."""
    digest = hashlib.blake2b(frame.ids.tobytes(), digest_size=16)
    for name in held:
        values = getattr(frame, name)
        if values is not None:
            digest.update((values + 0.0).tobytes())  # -0 and 0 are one number
    return digest.digest()
