"""What the checks of averages against run time share: the standard error of one run, from independent ones.

The error of an average falls as the square root of what is averaged over, and so of the run time. Its constant, the
standard error times the square root of the CPU time, is what methods are compared by.

Literature: M. P. Allen and D. J. Tildesley, Computer Simulation of Liquids (1987), section 6.4; U. Wolff, Comput. Phys.
Commun. 156, 143 (2004).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from crosscheck.checks.performance.work_precision_judging import Rung, as_figure
from crosscheck.engines.protocol import Claims, Run
from crosscheck.figure import Figure
from crosscheck.scene import Floats
from crosscheck.verdict import Judgement, statistical

#: Independent runs of each rung: the relative error of a standard error is 1/sqrt(2 (members - 1)), 15 %.
MEMBERS = 24
#: How much more each rung averages over than the one before.
FACTOR = 4
CRITERION = (
    f"standard error ~ work^(-1/2), from {MEMBERS} independent runs of each length, within the error of standard "
    "errors; the mean of the longest as expected; CPU time is shown, not judged"
)
_WHY = (
    f"averages over independent parts: the central limit theorem; a standard error from {MEMBERS} runs is known to "
    "1/sqrt(2 (n - 1))"
)


@dataclass(frozen=True)
class Averages:
    """Averages of runs of growing length.

    amounts: (rungs,), of what is averaged over. values: (rungs, members). rungs: the runs of each. expected: what the
    values are to be, of a method that errs beside its scatter; None: it does not.
    """

    amounts: Floats
    values: Floats
    rungs: list[Rung]
    expected: float | None = None

    @property
    def errors(self) -> Floats:
        """Relative error of one run, (rungs,): its standard error, or the root mean square of all of its error."""
        if self.expected is None:
            return np.asarray(self.values.std(axis=1, ddof=1) / abs(self.values[-1].mean()))
        return np.asarray(np.sqrt(((self.values / self.expected - 1) ** 2).mean(axis=1)))

    @property
    def _name(self) -> str:
        return "standard error" if self.expected is None else "error"

    def exponent(self) -> Judgement:
        """The judgement that the standard error falls with the square root of the amount."""
        x, y = np.log(self.amounts), np.log(self.errors)
        weights = (x - x.mean()) / ((x - x.mean()) ** 2).sum()
        each = 1 / (2 * (self.values.shape[1] - 1)) ** 0.5
        return statistical(
            "power of the amount in the standard error"
            if self.expected is None
            else "power of the amount in the error",
            float(weights @ y),
            float(each * (weights**2).sum() ** 0.5),
            -0.5,
            0.0,
            _WHY,
            samples=self.values.shape[1],
        )

    def merit(self) -> str:
        """Relative error times the square root of the CPU seconds, of the longest runs, in words."""
        return f"relative {self._name} {self.errors[-1] * self.rungs[-1].seconds[0] ** 0.5:.2g}/sqrt(CPU s)"

    def figure(
        self, title: str, label: str, claims: Claims, control: str, count: Callable[[Run], float], count_label: str
    ) -> Figure:
        """The figure of the ladder.

        title: of the case. label: of the method. claims: of its scheme. control: what is varied. count: of a run.
        count_label: what that is.
        """
        errors = self.errors.tolist()
        unknown = (self.errors / (2 * (self.values.shape[1] - 1)) ** 0.5).tolist()
        return as_figure(
            title, "relative error of a run", label, claims, control, self.rungs, errors, unknown,
            count=count, count_label=count_label,
        )  # fmt: skip


def averaged(
    amounts: Sequence[float],
    run: Callable[[float, int], tuple[float, Run]],
    members: int = MEMBERS,
    expected: float | None = None,
) -> Averages:
    """Runs of all amounts, in turns. amounts: rising. run: value and run of an amount and a member, from 0.

    members: independent runs of each amount. expected: see `Averages`.
    """
    made = [[run(amount, member) for amount in amounts] for member in range(members)]
    values = np.array([[value for value, _ in turn] for turn in made]).T
    rungs = [Rung(float(amount), tuple(turn[k][1] for turn in made)) for k, amount in enumerate(amounts)]
    return Averages(np.array(amounts, dtype=np.float64), values, rungs, expected)
