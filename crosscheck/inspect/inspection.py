"""Inspects a trajectory: streams its frames past all properties, and gathers what each tells."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from crosscheck.figure import Figure
from crosscheck.inspect.properties import properties
from crosscheck.inspect.property import Collector, Property, Told
from crosscheck.inspect.setting import Options, Setting, setting_of
from crosscheck.inspect.view import View
from crosscheck.scene import Scene
from crosscheck.trajectories.frames import Frame, Source, first_line
from crosscheck.verdict import FALSE_ALARM_OF_A_RUN, Judgement

_NONE = Options()


@dataclass(frozen=True)
class Found:
    """What is told of one property. property: it. told: see `Told`. unsaid: why nothing can be said of it, or ""."""

    property: Property
    told: Told
    unsaid: str = ""


@dataclass(frozen=True)
class Inspection:
    """A trajectory, and what its properties say. setting: what is known of it. found: in the order of the table."""

    setting: Setting
    found: tuple[Found, ...]

    @property
    def judgements(self) -> list[Judgement]:
        """All of them, in their order."""
        return [judgement for one in self.found for judgement in one.told.judgements]

    @property
    def figures(self) -> list[Figure]:
        """All of them, in their order."""
        return [figure for one in self.found for figure in one.told.figures]

    @property
    def false_alarms(self) -> float:
        """Probability that a judgement is red although all is right: the sum over those that chance may turn red."""
        return sum(one.false_alarm or 0.0 for one in self.judgements)


def inspect_trajectory(
    source: Source,
    scene: Scene | None = None,
    options: Options = _NONE,
    progress: Callable[[int, int], Any] = lambda done, total: None,
) -> Inspection:
    """Inspects a trajectory; two frames are in memory at a time, and some hundred numbers of each.

    source: its frames. scene: what was run; None: not known. options: what the user says. progress: is told the number
    of frames done, and of all. All statistical judgements together are red of a right trajectory with the probability
    `FALSE_ALARM_OF_A_RUN`, since a file cannot be measured again: each has an equal share of it. UsageError if the
    scene, or what the user says, does not fit the file.
    """
    setting = setting_of(source, scene, options)
    begun = [(one, one.begin(setting)) for one in properties()]
    collectors = [collector for _, collector in begun if not isinstance(collector, str)]
    seen = _collect(setting, collectors, progress)
    once = FALSE_ALARM_OF_A_RUN
    if seen:
        chances = sum(one.false_alarm is not None for each in collectors for one in each.judge(once).judgements)
        once = FALSE_ALARM_OF_A_RUN / max(chances, 1)
    return Inspection(setting, tuple(_told(one, collector, once, seen) for one, collector in begun))


def _told(one: Property, collector: Collector | str, once: float, seen: int) -> Found:
    if isinstance(collector, str):
        return Found(one, Told(), collector)
    if seen == 0 and one.chapter != "file":
        return Found(one, Told(), "no frame can be used")
    return Found(one, collector.judge(once))


def _collect(setting: Setting, collectors: list[Collector], progress: Callable[[int, int], Any]) -> int:
    """Shows all frames to the collectors, up to the first one that cannot be used; the number of those that were."""
    before = None
    total = len(setting.source)
    for index in range(total):
        try:
            frame = setting.boxed(setting.source.read(index))
            reason = _unusable(frame, setting)
        except (ValueError, OSError, EOFError) as error:
            reason = f"cannot be read ({first_line(error)})"
        if reason:
            for collector in collectors:
                collector.stopped(f"Frame {index} (counted from 0) {reason}; it and what follows are not looked at.")
            return index
        view = View(setting, index, frame, before)
        for collector in collectors:
            collector.add(view)
        view.before = None  # two frames are in memory, not all
        before = view
        progress(index + 1, total)
    return total


def _unusable(frame: Frame, setting: Setting) -> str:
    """Why a frame cannot be used, as the end of a sentence; "" if it can."""
    first = setting.first
    if not np.array_equal(frame.ids, first.ids):
        lost = np.setdiff1d(first.ids, frame.ids)
        new = np.setdiff1d(frame.ids, first.ids)
        what = f"lacks {len(lost)} particles of the first, such as {lost[0]}" if len(lost) else ""
        return " and ".join(filter(None, (what, f"has {len(new)} others, such as {new[0]}" if len(new) else "")))
    for name in ("positions", "velocities"):
        values = getattr(frame, name)
        if (values is None) != (getattr(first, name) is None):
            return f"{'lacks' if values is None else 'has'} {name}, unlike the first"
        if values is not None and not np.isfinite(values).all():
            row = int(np.flatnonzero(~np.isfinite(values).all(axis=1))[0])
            return f"has {name} that are not finite, of particle {frame.ids[row]}"
    return ""
