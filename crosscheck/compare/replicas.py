"""Runs that should all be the same: which one is not, and at which frame it left the others."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from crosscheck.compare.differences import VECTORS, converted
from crosscheck.compare.pairing import Pairing, pair
from crosscheck.errors import UsageError
from crosscheck.files import shown_path
from crosscheck.trajectories.frames import Frame, Source


class Replicas(NamedTuple):
    """What several runs are to each other.

    reference: number of a run that stayed with the largest group to the end. left: number of a run -> number of the
    frame, among those of the reference, at which its bits were first different from that group's. groups: sizes of the
    groups with the same bits in all frames, largest first. frames: that all have. times: of these, of the reference.
    """

    reference: int
    left: dict[int, int]
    groups: tuple[int, ...]
    frames: int
    times: tuple[float, ...]


def replicas(sources: Sequence[Source], progress: Callable[[int, int], Any] = lambda done, total: None) -> Replicas:
    """Which runs leave the others, and when; every file is read once, and of each frame a digest is kept.

    At every frame, the runs that were the same so far are grouped by their bits; those outside the largest group leave
    there (of two groups of one size, those without the first run). sources: at least two trajectories. progress: is
    told the number of files read, and of all. UsageError if a run has no frame in common with the first.
    """
    pairings: list[Pairing | None] = [None]
    for other in sources[1:]:
        pairings.append(pair(sources[0], other))
    common = set(range(len(sources[0])))
    for pairing in pairings[1:]:
        assert pairing is not None
        common &= {int(frame) for frame in pairing.first}
    if not common:
        raise UsageError(f"{shown_path(sources[0].path)}: no frame is common to all runs: compare them in pairs")
    frames = sorted(common)
    digests = []
    for number, (source, pairing) in enumerate(zip(sources, pairings, strict=True)):
        counterpart = {frame: frame for frame in frames}
        if pairing is not None:
            counterpart = {int(a): int(b) for a, b in zip(pairing.first, pairing.second, strict=True)}
        found = []
        for frame in frames:
            read = source.read(counterpart[frame])
            found.append(_digest(read if pairing is None else converted(read, pairing)))
        digests.append(found)
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
    times = tuple(float(sources[0].times[frame]) for frame in frames)
    return Replicas(staying[0], left, tuple(sorted(whole.values(), reverse=True)), len(frames), times)


def _digest(frame: Frame) -> bytes:
    """A digest of the bits of all that is compared in a frame."""
    digest = hashlib.blake2b(frame.ids.tobytes(), digest_size=16)
    for name in VECTORS:
        values = getattr(frame, name)
        if values is not None:
            digest.update((values + 0.0).tobytes())  # -0 and 0 are one number
    return digest.digest()
