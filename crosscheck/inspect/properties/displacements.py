"""Velocities against displacements: velocities are the derivative of the positions with respect to the file's time."""

from __future__ import annotations

import numpy as np

from crosscheck.inspect.property import Collector, Property, Told
from crosscheck.inspect.setting import FEWEST, NOT_IN_EQUILIBRIUM, Setting
from crosscheck.inspect.view import View
from crosscheck.statistics import correlated_mean
from crosscheck.verdict import statistical

#: Loss of the velocity's autocorrelation in an interval beyond which the trapezoid says too little.
_LOST = 0.3


class _Displacements(Collector):
    def __init__(self, setting: Setting) -> None:
        self._setting = setting
        self._slopes: list[float] = []
        self._lost: list[tuple[float, float]] = []

    def add(self, view: View) -> None:
        before, travelled = view.before, view.travelled
        if before is None or travelled is None:
            return
        moving = self._setting.moving
        here, there = view.frame.velocities, before.frame.velocities
        assert here is not None
        assert there is not None
        square = float(np.sum(travelled**2))
        if square > 0:
            self._slopes.append(float(np.sum(view.nearest * travelled)) / square)
            self._lost.append((float(np.sum(here[moving] * there[moving])), float(np.sum(here[moving] ** 2))))

    def judge(self, once: float) -> Told:
        if len(self._slopes) < 4:
            return Told((), ("too few intervals with motion.",))
        products, squares = np.sum(self._lost, axis=0)
        lost = float(1 - products / squares)
        if lost > _LOST:
            return Told((), (f"velocities lose {lost:.0%} of themselves from frame to frame: too much to integrate.",))
        mean = correlated_mean(self._slopes)
        why = (
            "the trapezoidal rule; its error is no more than the share of itself that the velocity loses in an "
            f"interval, {lost:.2g}"
        )
        quantity = "displacement over velocity times time"
        doubt = max(lost, self._rounding())
        return Told(
            (statistical(quantity, mean.value, mean.error, 1.0, 0.0, why, samples=mean, doubt=doubt, once=once),)
        )

    def _rounding(self) -> float:
        """What rounding of the file does to the slope, relative."""
        setting = self._setting
        first = setting.first
        assert first.velocities is not None
        speeds = np.abs(first.velocities).mean() or 1.0
        interval = float(np.median(np.abs(np.diff(setting.clock.values)))) or 1.0
        rounding = setting.source.rounding
        positions = 2 * float(rounding["positions"].of(first.positions).max()) / (speeds * interval)
        return positions + float(rounding["velocities"].of(first.velocities).max()) / speeds


def _begin(setting: Setting) -> Collector | str:
    if setting.first.velocities is None:
        return "the file holds no velocities"
    if not setting.clock.same_unit:
        return f"the file states {setting.clock.name}s, and no time in the unit of its velocities"
    if setting.ensemble == "none" or setting.number < FEWEST:
        return f"motion that is regular may repeat itself within an interval: {NOT_IN_EQUILIBRIUM}, or of few particles"
    return _Displacements(setting)


PROPERTY = Property("velocities against displacements", "motion", _begin)
