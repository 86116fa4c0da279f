"""Speed of the lattice-gas evolvers beside each other, and beside the memory that they run through."""

from __future__ import annotations

import time
from typing import Literal, NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, full
from crosscheck.checks.lattice.gases import LATTICE, filled, gas_scene
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references.lattice_models import VELOCITIES
from crosscheck.scene import Method, Output
from crosscheck.verdict import Judged, Judgement, bounded

PLANES, LOOKUP, NUMPY = (Method(scheme=f"lattice_{name}") for name in ("planes", "lookup", "numpy"))
TURNS, SIZE, STEPS = 7, 4096, 20
#: Bits that a site's step moves through memory: every channel is read and written. Goal, as a part of the bandwidth.
GOALS = {"hpp": 0.8, "fhp1": 0.6, "fhp_saturated": 0.6}


def _copy_bandwidth() -> float:
    """Bytes read and written per second by a copy of 400 MB."""
    source = np.ones(50_000_000)
    target = np.empty_like(source)
    np.copyto(target, source)
    started = time.perf_counter()
    np.copyto(target, source)
    return 2 * source.nbytes / (time.perf_counter() - started)


class _Race(NamedTuple):
    """Bit planes of a model beside the memory's bandwidth, or beside the evolvers that move bytes."""

    model: str
    beside: Literal["memory", "lookup"]


def _judge(laboratory: Laboratory, race: _Race) -> Judged:
    """Site updates per second of bit planes, as bytes moved, over those of a copy; the others, on a smaller lattice."""
    return (_beside_memory if race.beside == "memory" else _beside_lookup)(laboratory, race.model)


def _beside_memory(laboratory: Laboratory, name: str) -> Judgement:
    scene = gas_scene("large", name, SIZE, SIZE, STEPS, filled(0.3, laboratory.seed()), Output())
    bits = 2 * VELOCITIES[name].channels
    ratios, rates = [], []
    for turn in range(TURNS + 1):
        wall = laboratory.run(scene, PLANES).cost.wall
        bandwidth = _copy_bandwidth()
        if turn:  # the first turn warms
            rates.append(SIZE * SIZE * STEPS / wall)
            ratios.append(rates[-1] * bits / 8 / bandwidth)
    return bounded(
        f"bytes moved, {bits} bits a site, over a copy's",
        float(np.median(ratios)),
        GOALS[name],
        f"the goal; median of {TURNS} alternated turns, of {min(ratios):.2f} ... {max(ratios):.2f}",
        at_least=True,
        note=f"{np.median(rates) / 1e9:.3g} Gsites/s, {SIZE} x {SIZE} sites, one thread",
    )


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
        title="Lattice gases: bit planes beside the memory's bandwidth, and beside bytes",
        equation="site updates/seconds",
        criterion=f"0.6 of a copy's bandwidth (FHP, 12 bits a site), 0.8 (HPP, 8 bits), median of {TURNS} turns, one "
        "thread; 20 times the table look-up",
        citation="Kohring, J. Stat. Phys. 63, 411 (1991)",
        judge=_judge,
        variants=full(
            **{
                f"{race.model}-{race.beside}": race
                for race in (
                    *(_Race(name, "memory") for name in GOALS),
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
                    "            key = row_key(seed, COLLISION, np.uint64(now), np.uint64(row))\n",
                    "            key = row_key(seed, COLLISION, np.uint64(now), np.uint64(row))\n"
                    "            for _ in range(50):\n                _seal(target, channels, here, size, columns)\n",
                    "the ends of each row are sealed fifty times",
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
