"""What rounding does to the energy over very many steps: a random walk, not a drift.

Velocity Verlet keeps the energy of an oscillator, read out at the same phase, but for rounding. If the roundings of the
steps are independent, their sum grows as the root of the steps (D. Brouwer, Astron. J. 46, 149 (1937)); a bias of them
would grow as the steps themselves. The exponent is fitted to the root mean square over many springs in one scene.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from crosscheck.checks.extreme.matrix import Bound, Case, Mean, Measured, Trial, extreme_check, for_each
from crosscheck.checks.stepping.faults import scheme_fault
from crosscheck.engines.capabilities import Needs
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.scene import Floats, Method, Output, Scene, Spring, explicit

#: Blocks of the record of a spring, and how many of them the longer lag has.
_BLOCKS, _LAG = 256, 32
#: A step whose binary digits have no short period, golden ratio/16; and one whose digits have, a tenth.
_GOLDEN, _TENTH = (1 + 5**0.5) / 32, 0.1
_EXPONENT = "exponent of the growth of |dE| with the steps"
_WALK = "root mean square of dE/E over that of independent roundings, at the end"


def _energies(trial: Trial, dt: float, steps: int, springs: int, compensated: bool = False) -> Floats:
    """Energy of each spring at the ends of the blocks, over that at the start, less 1: (blocks + 1, springs).

    Velocity Verlet keeps v^2 + omega^2 r^2 (1 - (omega dt)^2/4) exactly, at all phases; omega = 1.
    """
    rng = np.random.default_rng(trial.laboratory.seed())
    phase, size = rng.uniform(0, 2 * np.pi, (springs, 1)), rng.uniform(1, 2, (springs, 1))
    inside = 1 - dt**2 / 4
    scene = Scene(
        name="walk",
        dimension=1,
        duration=steps * dt,
        spring=Spring(k=1.0),
        initial=explicit(size * np.cos(phase), size * inside**0.5 * np.sin(phase)),
        output=Output(interval=steps // _BLOCKS * dt, trajectory=True),
    )
    method = Method(scheme=trial.method, dt=dt, compensated=compensated)
    run = trial.laboratory.run(scene, method, interpreted=False)
    r, v = run["positions"][:, :, 0], run["velocities"][:, :, 0]
    energy = v**2 + r**2 * inside
    return np.asarray(energy / energy[0] - 1)


def _mean_log(number: int) -> float:
    """Mean of the logarithm of the mean of so many squares of normal numbers of variance 1."""
    from scipy.special import digamma

    return float(digamma(number / 2) - np.log(number / 2))


def _exponents(change: Floats) -> Floats:
    """Of each spring, from the mean squares of the changes over one block and over `_LAG` blocks."""
    short, long = np.diff(change, axis=0), np.diff(change[::_LAG], axis=0)
    logs = [np.log((one**2).mean(axis=0)) - _mean_log(len(one)) for one in (short, long)]
    return np.asarray(0.5 * (logs[1] - logs[0]) / np.log(_LAG))


def _walking(trial: Trial, dt: float, steps: int, springs: int) -> Measured:
    change = _energies(trial, dt, steps, springs)
    exponents = _exponents(change)
    lags = 2 ** np.arange(int(np.log2(_BLOCKS)))
    rms = [float(np.sqrt((np.diff(change[::lag], axis=0) ** 2).mean())) for lag in lags]
    x = [float(lag * (steps // _BLOCKS)) for lag in lags]
    walk = (EPSILON * np.sqrt(2 / 12 * np.array(x))).tolist()
    figure = Figure(
        "Velocity Verlet: energy of springs", "steps", "root mean square of dE/E", "log", "log",
        (Series(f"omega dt = {dt:.4g}", x, rms), Series("independent roundings of r and v", x, walk, theory=True)),
    )  # fmt: skip
    error = float(exponents.std(ddof=1) / len(exponents) ** 0.5)
    last = float(np.sqrt((change[-1] ** 2).mean()) / (EPSILON * (2 / 12 * steps) ** 0.5))
    numbers = {_EXPONENT: float(exponents.mean()), _WALK: last}
    return Measured(numbers, figures=(figure,), errors={_EXPONENT: (error, float(len(exponents)))})


_HALF = Mean(_EXPONENT, 0.5, "a sum of independent roundings is a random walk (Brouwer 1937)")
#: Of the prefactor: the energy takes the roundings of v twice, in either half of the kick, and those of the products.
_FEW = Bound(_WALK, 3.0, "three roundings of each of r and v in a step, and a root mean square of few springs")
_ALIKE = Bound(_EXPONENT, 1.0, "products with 0.1 are rounded in a short period: at worst all alike, which is linear")


def _compensated(trial: Trial, dt: float, steps: int, springs: int) -> Mapping[str, float]:
    """The root mean square at the end alone: at the start of the record the rounding of what is recorded shows."""
    change = _energies(trial, dt, steps, springs, compensated=True)
    return {_WALK: float(np.sqrt((change[-1] ** 2).mean()) / (EPSILON * (2 / 12 * steps) ** 0.5))}


def _less(dt: float) -> Bound:
    return Bound(
        _WALK, 3.0 * dt, "what is rounded are the increments, omega dt times as large, and the place of a force"
    )


_KEPT = Needs("spring", words=frozenset({"method.compensated"}))

CHECKS = (
    extreme_check(
        "drift",
        "The energy of velocity Verlet over 1e8 steps: a random walk of roundings",
        "<(dE/E)^2>^(1/2) ~ n^(1/2), with E = v^2 + omega^2 r^2 (1 - (omega dt)^2/4)",
        "Brouwer, Astron. J. 46, 149 (1937); Hairer, McLachlan & Razakarivony, BIT 48, 231 (2008)",
        (
            Case(
                "walk",
                "springs, omega dt = golden ratio/16, 2^18 steps, 32 starts",
                lambda trial: _walking(trial, _GOLDEN, 2**18, 32),
                for_each(("velocity_verlet", "leapfrog"), _HALF, _FEW),
            ),
            Case(
                "walk-1e8",
                "springs, omega dt = golden ratio/16, 1e8 steps, 16 starts",
                lambda trial: _walking(trial, _GOLDEN, 100_000_000, 16),
                for_each(("velocity_verlet",), _HALF, _FEW),
                "full",
                Needs("spring", promises=("speed",)),
            ),
            Case(
                "tenth",
                "springs, omega dt = 0.1, whose binary digits have a period of four: 2^24 steps, 16 starts",
                lambda trial: _walking(trial, _TENTH, 2**24, 16),
                for_each(("velocity_verlet",), _ALIKE),
                "full",
            ),
            Case(
                "compensated",
                "springs, omega dt = golden ratio/16, compensated summation, 2^18 steps, 32 starts",
                lambda trial: _compensated(trial, _GOLDEN, 2**18, 32),
                for_each(("velocity_verlet",), _less(_GOLDEN)),
                needs=_KEPT,
            ),
            Case(
                "compensated-tenth",
                "springs, omega dt = 0.1, compensated summation, 2^24 steps, 16 starts",
                lambda trial: _compensated(trial, _TENTH, 2**24, 16),
                for_each(("velocity_verlet",), _less(_TENTH)),
                "full",
                _KEPT,
            ),
        ),
        Needs(
            "spring",
            words=frozenset({"dimension=1"}),
            observables=frozenset({"positions", "velocities"}),
            promises=("long_runs",),
        ),
        (
            (
                "walk/velocity_verlet",
                scheme_fault(
                    "rounding-with-a-bias",
                    "        return r, add_to(v_half, 0.5 * dt, a), (a,)",
                    "        return r, (1.0 - 2.3e-16) * add_to(v_half, 0.5 * dt, a), (a,)",
                    "velocity Verlet loses a unit of the last digit of the velocity in each step",
                ),
            ),
            (
                "compensated/velocity_verlet",
                scheme_fault(
                    "velocities-without-their-rest",
                    "        v_half, v_rest = _add(v, v_rest, 0.5 * dt * a)\n",
                    "        v_half, v_rest = _add(v, 0.0 * v_rest, 0.5 * dt * a)\n",
                    "what velocities lack by rounding is not kept",
                ),
            ),
        ),
        interpreted=False,
    ),
)
