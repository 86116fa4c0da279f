"""Lattice gases at their extremes: empty, full, one particle, one site, odd widths, and lattices that are all wall."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np

from crosscheck.checks.base import Tier
from crosscheck.checks.extreme.matrix import (
    SENTENCE,
    Answer,
    Bound,
    Case,
    Expected,
    Measured,
    Trial,
    Value,
    extreme_check,
    for_each,
)
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references.lattice_audit import velocities
from crosscheck.references.lattice_models import MODELS
from crosscheck.scene import LatticeGas, Obstacle, Occupations, Output, Scene

#: Evolvers of the bits of the sites, and the equation of their means.
_BITS, _MEANS = ("lattice_planes", "lattice_lookup", "lattice_numpy"), "lattice_boltzmann"
_STEPS = 16


def _gas(model: str, rows: int, columns: int, steps: int, *, interval: int | None = 1, **more: Any) -> Scene:
    """A gas whose populations are recorded, summed over the lattice; with sites at the end without an interval.

    more: `density`, `channels`, `cells` of the start; other entries are those of the gas, or of the output ("fields").
    """
    start = {name: more.pop(name) for name in ("density", "channels", "cells") if name in more}
    fields = more.pop("fields", None)
    return Scene(
        name="lattice",
        dimension=2,
        duration=steps,
        lattice_gas=LatticeGas(model=model, rows=rows, columns=columns, **more),
        initial=Occupations(kind="occupations", seed=3, **start),
        output=Output(interval=interval, observables=("populations",), fields=fields),
    )


_CHANGED = "populations that change"


def _filled(trial: Trial, model: str, occupation: float) -> Mapping[str, float]:
    """All channels empty, or all full: nothing can change."""
    scene = _gas(model, 6, 10, _STEPS, density=occupation, fields=(10, 6))
    populations = trial.run(scene)["populations"]
    return {_CHANGED: float(np.count_nonzero(populations != occupation))}


#: A square lattice of this side, which a particle leaves on one side and enters on the other one.
_AROUND = 8
_NUMBER, _RETURN, _STILL = "particles, too many or few", "channels that differ after the way round", "steps at rest"


def _one(trial: Trial, model: str) -> Mapping[str, float]:
    """One particle on the whole lattice flies round it: each component of its way is a whole number of boxes."""
    steps = 2 * _AROUND
    channels = len(velocities(model))
    scene = _gas(
        model, _AROUND, _AROUND, steps, density=1 / (channels * _AROUND**2), cells=_AROUND, fields=(_AROUND, _AROUND)
    )
    populations = trial.run(scene)["populations"]
    flat = populations.reshape(len(populations), -1)
    moving = np.flatnonzero(velocities(model).any(axis=1))
    at_rest = not populations[0][..., moving].any()
    return {
        _NUMBER: float(abs(flat.sum(axis=1) - 1).max()),
        _RETURN: float(np.count_nonzero(flat[-1] != flat[0])),
        _STILL: float(0 if at_rest else np.count_nonzero((flat[1:] == flat[:-1]).all(axis=1))),
    }


_WRONG = "states that are not (1, 0, 1, 0) and (0, 1, 0, 1) in turns"


def _single_site(trial: Trial) -> Mapping[str, float]:
    """HPP on one site: two that meet head-on leave at right angles, and meet again."""
    populations = trial.run(_gas("hpp", 1, 1, _STEPS, channels=(1.0, 0.0, 1.0, 0.0)))["populations"]
    expected = np.array([[1.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, 1.0]])[np.arange(_STEPS + 1) % 2]
    return {_WRONG: float((populations.reshape(-1, 4) != expected).any(axis=1).sum())}


#: Widths around those of words of 64 and of vectors of 512 bits.
_WIDTHS = (1, 3, 63, 65, 513)
_LOST, _BACK = "change of mass and momentum", "channels that differ after the way back"


def _odd(trial: Trial, model: str, rows: int) -> Mapping[str, float]:
    """Mass and momentum of lattices of many widths; and of HPP the way back, half a step after the last one."""
    lost, differ = 0.0, 0.0
    moving = velocities(model)
    for width in _WIDTHS:
        populations = trial.run(_gas(model, rows, width, 12, density=0.3))["populations"].reshape(13, -1)
        lost = max(lost, abs(populations.sum(axis=1) - populations[0].sum()).max())
        lost = max(lost, abs((populations - populations[0]) @ moving).max())
        if model != "hpp":
            continue
        there = _gas(model, rows, width, 24, density=0.3, interval=24, fields=(width, rows), reversals=(12, 24))
        start, end = trial.run(there)["populations"]
        differ += np.count_nonzero(start != end)
    return {_LOST: float(lost), _BACK: float(differ)}


def _walled(trial: Trial, open_sites: int) -> Mapping[str, float]:
    """A lattice of walls that send particles back, but for one site or none, which starts full."""
    wall = [(column, row) for row in range(4) for column in range(6) if not (open_sites and (column, row) == (3, 1))]
    scene = _gas("hpp", 4, 6, _STEPS, density=1.0, fields=(6, 4), obstacles=(Obstacle(sites=tuple(wall)),))
    populations = trial.run(scene)["populations"].reshape(_STEPS + 1, -1)
    full = 4.0 * open_sites
    return {
        _NUMBER: float(abs(populations.sum(axis=1) - full).max()),
        _CHANGED: float(np.count_nonzero(populations[::2] != populations[0])),
    }


def _answered(trial: Trial, model: str, rows: int, columns: int) -> Measured:
    answer, _ = trial.answer(lambda: _gas(model, rows, columns, 4, density=0.3))
    return Measured({}, answer)


_COUNT = "a count: exact"
_QUANTUM = "one particle more or less, or turned, changes mass or momentum by half a unit or more"
#: Models of the quick tier: one of each lattice, with and without a particle at rest.
_QUICK = ("hpp", "fhp3")
_EVEN = "refused: scene: lattice_gas.rows = 1: a periodic triangular lattice needs an even number"
_REVERSED = Needs("lattice_gas", ("lattice",), words=frozenset({"lattice_gas.reversals"}))


def _of_models() -> Iterator[Case]:
    """Cases of every model."""
    for model in MODELS:
        tier: Tier = "quick" if model in _QUICK else "full"
        for name, occupation in (("empty", 0.0), ("full", 1.0)):
            yield Case(
                f"{name}-{model}",
                f"{model}, all channels {name}",
                partial(_filled, model=model, occupation=occupation),
                for_each((*_BITS, _MEANS), Bound(_CHANGED, 0.0, "nothing can move into a full channel: exact")),
                tier,
            )
        yield Case(
            f"one-{model}",
            f"{model}, one particle on {_AROUND} x {_AROUND} sites",
            partial(_one, model=model),
            for_each(
                _BITS,
                Value(_NUMBER, 0.0, 0.5, _COUNT),
                Bound(_RETURN, 0.0, "a way of whole boxes along both axes, and nobody to meet: exact"),
                Bound(_STILL, 0.0, "a moving particle is at another site after each step"),
            ),
            tier,
        )
        expected: list[Expected] = [Value(_LOST, 0.0, 0.25, _QUANTUM)]
        if model == "hpp":
            expected.append(Bound(_BACK, 0.0, "without random numbers the way back is the same: bit for bit"))
        for rows in (1, 2, 5) if model == "hpp" else (2, 6):
            yield Case(
                f"odd-widths-{model}-{rows}",
                f"{model}, {rows} rows of {', '.join(map(str, _WIDTHS))} sites",
                partial(_odd, model=model, rows=rows),
                for_each(_BITS, *expected),
                "quick" if model in _QUICK and rows <= 2 else "full",
                _REVERSED if model == "hpp" else None,
            )


CHECKS = (
    extreme_check(
        "lattices",
        "Lattice gases: empty, full, one particle, one site, odd widths, all wall",
        "n_i(x + c_i, t + 1) = n_i(x, t) + Omega_i(n)",
        "Frisch et al., Complex Systems 1, 649 (1987); Hardy, de Pazzis & Pomeau, Phys. Rev. A 13, 1949 (1976)",
        (
            *_of_models(),
            Case(
                "one-site-hpp",
                "HPP on 1 x 1 sites: two particles head-on",
                _single_site,
                for_each((*_BITS, _MEANS), Bound(_WRONG, 0.0, "the collision rule, and each channel leads to itself")),
            ),
            Case(
                "one-row-fhp1",
                "FHP on one row",
                lambda trial: _answered(trial, "fhp1", 1, 4),
                for_each((*_BITS, _MEANS), Answer(_EVEN, SENTENCE)),
            ),
            *(
                Case(
                    f"walls-but-{open_sites}",
                    f"HPP, 4 x 6 sites, walls on all but {open_sites}",
                    partial(_walled, open_sites=open_sites),
                    for_each(
                        _BITS,
                        Value(_NUMBER, 0.0, 0.5, _COUNT),
                        Bound(_CHANGED, 0.0, "what goes out of the open site is back after two steps: exact"),
                    ),
                    needs=Needs(
                        "lattice_gas",
                        ("lattice",),
                        words=frozenset({"lattice_gas.obstacles", "lattice_gas.obstacles.rule=bounce_back"}),
                    ),
                )
                for open_sites in (0, 1)
            ),
        ),
        Needs("lattice_gas", ("lattice",), observables=frozenset({"populations"})),
        (
            (
                "odd-widths-hpp-2/lattice_lookup",
                Fault(
                    "first-image-on-both-sides",
                    "lattice/lookup.py",
                    "ring[0], ring[columns + 1] = source[columns - 1], source[0]",
                    "ring[0], ring[columns + 1] = source[columns - 1], source[columns - 1]",
                    "what leaves a row at its end comes from the end of the row again",
                ),
            ),
        ),
    ),
)
