"""Speed of the lattice-gas evolvers beside each other, and beside the memory that they run through."""

from __future__ import annotations

import time
from typing import Literal, NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, full
from crosscheck.checks.lattice.gases import LATTICE, filled, gas_scene
from crosscheck.checks.performance.speeds import by_two_threads
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references.lattice_models import VELOCITIES
from crosscheck.scene import Method, Output
from crosscheck.verdict import Judged, Judgement, bounded

PLANES, LOOKUP, NUMPY = (Method(scheme=f"lattice_{name}") for name in ("planes", "lookup", "numpy"))
TURNS, SIZE, STEPS = 7, 4096, 256
#: Rows that a core's second cache holds.
_IN_CACHE = 64
#: What bit planes reached of a copy's bandwidth while each step was a pass over memory, every channel read and written
#: (AMD EPYC, Zen 5): what several steps a pass must exceed.
_BY_STEPS = {"hpp": 1.53, "fhp1": 1.06, "fhp_saturated": 1.06, "fhp3": 0.94}
_FASTER, _SPEED_UP = 1.5, 1.9
#: Of a goal, what is asked for.
_ASKED = 0.9


def _copy_bandwidth() -> float:
    """Bytes read and written per second by a copy of 400 MB."""
    source = np.ones(50_000_000)
    target = np.empty_like(source)
    np.copyto(target, source)
    started = time.perf_counter()
    np.copyto(target, source)
    return 2 * source.nbytes / (time.perf_counter() - started)


class _Race(NamedTuple):
    """Bit planes of a model beside the memory's bandwidth, evolvers that move bytes, or themselves by two threads."""

    model: str
    beside: Literal["memory", "lookup", "threads"]


def _judge(laboratory: Laboratory, race: _Race) -> Judged:
    """Site updates per second of bit planes, as bytes moved, over those of a copy; the others, on a smaller lattice."""
    judges = {"memory": _beside_memory, "lookup": _beside_lookup, "threads": _by_threads}
    return judges[race.beside](laboratory, race.model)


def _beside_memory(laboratory: Laboratory, name: str) -> Judgement:
    start = filled(0.3, laboratory.seed())
    scene = gas_scene("large", name, SIZE, SIZE, STEPS, start, Output())
    narrow = gas_scene("in-cache", name, _IN_CACHE, SIZE, STEPS * SIZE // _IN_CACHE, start, Output())
    bits = 2 * VELOCITIES[name].channels
    ratios, rates, shares = [], [], []
    for turn in range(TURNS + 1):
        rate, in_cache = (SIZE * SIZE * STEPS / laboratory.run(one, PLANES).cost.wall for one in (scene, narrow))
        bandwidth = _copy_bandwidth()
        if turn:  # the first turn warms
            rates.append(rate)
            shares.append(rate / in_cache)
            ratios.append(rate * bits / 8 / bandwidth)
    return bounded(
        f"bytes of all sites and steps, {bits} bits each, over a copy's in the same time",
        float(np.median(ratios)),
        _ASKED * _FASTER * _BY_STEPS[name],
        f"{_ASKED} of the goal, {_FASTER} times the {_BY_STEPS[name]} of one step a pass; median of {TURNS} alternated "
        f"turns, of {min(ratios):.2f} ... {max(ratios):.2f}",
        at_least=True,
        note=f"{np.median(rates) / 1e9:.3g} Gsites/s, {SIZE} x {SIZE} sites, one thread; {np.median(shares):.2f} of "
        f"the rate of {_IN_CACHE} x {SIZE} sites, in cache",
    )


def _by_threads(laboratory: Laboratory, name: str) -> Judgement:
    scene = gas_scene("large", name, SIZE, SIZE, STEPS, filled(0.3, laboratory.seed()), Output())
    return by_two_threads(laboratory, scene, PLANES, _ASKED * _SPEED_UP, f"{SIZE} x {SIZE} sites, {STEPS} steps")


def _beside_lookup(laboratory: Laboratory, name: str) -> Judgement:
    rates: dict[str, list[float]] = {method.scheme: [] for method in (PLANES, LOOKUP, NUMPY)}
    for turn in range(TURNS + 1):
        for method, size, steps in ((PLANES, 2048, 100), (LOOKUP, 512, 20), (NUMPY, 512, 5)):
            scene = gas_scene("gas", name, size, size, steps, filled(0.3, laboratory.seed()), Output())
            cost = laboratory.run(scene, method).cost
            if turn:
                rates[method.scheme].append(size * size * steps / cost.cpu)
    ratios = np.array(rates[PLANES.scheme]) / np.array(rates[LOOKUP.scheme])
    return bounded(
        "site updates per CPU second, bit planes over table look-up",
        float(np.median(ratios)),
        20.0,
        f"the goal; median of {TURNS} alternated turns, of {ratios.min():.3g} ... {ratios.max():.3g}",
        at_least=True,
        note="Gsites per CPU second: "
        + ", ".join(f"{scheme} {np.median(found) / 1e9:.3g}" for scheme, found in rates.items()),
    )


CHECKS = (
    Check(
        name="performance/lattice-gas",
        title="Lattice gases: bit planes beside the memory's bandwidth, beside bytes, and by threads",
        equation="site updates/seconds",
        criterion=f"out of the caches, {_ASKED} of {_FASTER} times what one step a pass reaches of a copy's bandwidth, "
        f"median of {TURNS} turns, one thread; two threads {_ASKED} of {_SPEED_UP} times one (two free cores, "
        "else inconclusive); 20 times the table look-up",
        citation="Kohring, J. Stat. Phys. 63, 411 (1991); Wonnacott, Int. J. Parallel Program. 30, 181 (2002)",
        judge=_judge,
        variants=full(
            **{
                f"{race.model}-{race.beside}": race
                for race in (
                    *(_Race(name, "memory") for name in _BY_STEPS),
                    *(_Race(name, "threads") for name in ("hpp", "fhp1")),
                    _Race("fhp_saturated", "lookup"),
                    _Race("hpp", "lookup"),
                )
            }
        ),
        faults=(
            (
                "fhp_saturated-lookup",
                Fault(
                    "a-step-a-call",
                    "lattice/kernels/planes.py",
                    "    _seal(planes, copy // size, there, size, columns)\n",
                    "    for _ in range(500):\n        _seal(planes, copy // size, there, size, columns)\n",
                    "the ends of each row are sealed five hundred times",
                ),
            ),
            (
                "fhp1-memory",
                Fault(
                    "a-step-a-pass",
                    "lattice/bitplanes.py",
                    "    if block < 2:\n        return",
                    "    if block > 0:\n        return",
                    "bit planes pass through memory once in each step",
                ),
            ),
        ),
        needs=Needs(
            "lattice_gas",
            (LATTICE,),
            schemes=tuple(method.scheme for method in (PLANES, LOOKUP, NUMPY)),
            promises=("speed",),
        ),
        timing=True,
    ),
)
