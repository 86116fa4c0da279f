"""What an audit finds: the largest deviation of each kind.

A share of a tolerance: the tolerance has its derivation where it is noted.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field


@dataclass
class Audit:
    """The largest deviation of each kind, as a share of its tolerance, and where it was found.

    shares: by kind, in the order in which they were first noted. where: in words, by kind. events: number of those
    audited.
    """

    shares: dict[str, float] = field(default_factory=dict)
    where: dict[str, str] = field(default_factory=dict)
    events: int = 0

    def note(self, kind: str, error: float, tolerance: float, where: str) -> None:
        """Takes up a deviation.

        kind: of it. error, tolerance: in one unit; an error that is NaN is beyond every tolerance, and without a
        tolerance there must be none. where: in words.
        """
        share = 0.0 if error == 0 else math.inf
        if tolerance > 0 and not math.isnan(error):
            share = float(error / tolerance)
        if share > self.shares.setdefault(kind, 0.0):
            self.shares[kind], self.where[kind] = share, where

    @property
    def good(self) -> bool:
        """Whether all deviations are within their tolerances."""
        return all(share <= 1 for share in self.shares.values())
