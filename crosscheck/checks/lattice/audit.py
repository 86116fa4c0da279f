"""Every site of small lattice gases at every step: all pairs of models, walls, forces, sizes, starts and schemes.

The auditor of `crosscheck.references` follows the particles by coordinates and knows what a site may become. A row of
the table of features is a scene of a few hundred sites and four steps; each is judged.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from crosscheck.checks.base import Check, FeatureRows, Laboratory, full, quick
from crosscheck.checks.lattice.gases import FHP, LATTICE, gas_scene
from crosscheck.checks.lattice.recording import Recorded, lattice_methods, recorded
from crosscheck.engines.capabilities import Needs, refusal
from crosscheck.engines.registry import engine_class
from crosscheck.errors import Unsupported
from crosscheck.faults import Fault
from crosscheck.pairs import Pair, Row, covering, pairs_of
from crosscheck.references import EPSILON
from crosscheck.references.lattice_audit import coins, mean_step, numbers, pushes
from crosscheck.references.lattice_models import MODELS, VELOCITIES, entropy_density, fermi_dirac
from crosscheck.references.lattice_starts import deviation_from_equilibrium, fields
from crosscheck.scene import LatticeGas, Method, Obstacle, Occupations, Output, Scene, Wave
from crosscheck.verdict import LEAST_SAMPLES, Judged, Judgement, by_chance, round_off, worst

#: Each feature and its levels; the first one is its absence, or the plainest.
FACTORS = {
    "walls": ("none", "bounce_back disk", "bounce_back plate", "bounce_back corners", "specular_x first column",
              "specular_x last column", "specular_y first row", "specular_y last row", "specular_y overlapping",
              "diffusive_x first column", "diffusive_x last column", "diffusive_y first row", "diffusive_y last row",
              "diffusive_x overlapping"),
    "force": ("none", "0.3", "-0.3", "0", "1", "-1"),
    "model": MODELS,
    "columns": ("5", "1", "64", "65", "512", "513"),
    "rows": ("few", "least", "more"),
    "blocks": ("whole", "columns", "rows", "both"),
    "start": ("density", "channels", "values of rows", "oblique waves", "cells"),
    "scheme": ("first", "second", "third", "fourth", "first by threads"),
    "reversals": ("no", "yes"),
}  # fmt: skip
STEPS, CHUNKS, THREADS = 3, 4, (2, 3, 7)
#: Tables of other rows, whole, of the full tier.
TABLES = range(1, 5)
#: Rows of the square lattice, and of the triangular one.
_ROWS = {"few": (3, 4), "least": (1, 2), "more": (4, 6)}
#: Walls that draw no random numbers.
_PLAIN = tuple(walls for walls in FACTORS["walls"] if not walls.startswith("diffusive"))


@cache
def rows(table: int = 0) -> tuple[list[Row], set[Pair]]:
    """The rows that are judged, and the pairs of levels that go together in no scene.

    table: another one has other rows.
    Only a gas without random numbers can be reversed, so few rows have reversals: in them each level of the other
    features occurs. Mean occupations do not start from numbers of particles.
    """
    found, _ = covering({**FACTORS, "reversals": ("no",)}, (_valid,), table)
    reversible = {**FACTORS, "walls": _PLAIN, "force": ("none",), "model": ("hpp",), "reversals": ("yes",)}
    reversible["scheme"] = FACTORS["scheme"][:3]
    for k in range(max(map(len, reversible.values()))):
        found.append({name: levels[k % len(levels)] for name, levels in reversible.items()})
    every = {
        ((one, a), (other, b)) for one, other in combinations(FACTORS, 2) for a in FACTORS[one] for b in FACTORS[other]
    }
    return found, every.difference(*map(pairs_of, found))


def _valid(row: Row) -> bool:
    return row["scheme"] != "fourth" or row["start"] != "cells"


# -- scenes ----------------------------------------------------------------------------------------------


def _shape(row: Row) -> tuple[int, int]:
    """Numbers of rows and columns."""
    columns = int(row["columns"])
    return _ROWS["few" if row["rows"] == "more" and columns > 500 else row["rows"]][row["model"] != "hpp"], columns


def _obstacles(row: Row) -> tuple[Obstacle, ...]:
    if row["walls"] == "none":
        return ()
    name, _, place = row["walls"].partition(" ")
    rule: Any = name
    (down, across), first = _shape(row), (0, 0)
    return {
        "first row": (Obstacle(rows=first, rule=rule),),
        "last row": (Obstacle(rows=(down - 1, down - 1), rule=rule),),
        "first column": (Obstacle(columns=first, rule=rule),),
        "last column": (Obstacle(columns=(across - 1, across - 1), rule=rule),),
        "plate": (Obstacle(columns=(across // 3, across // 2), rows=(down // 3, down // 2), rule=rule),),
        "disk": (Obstacle(centre=(across / 2 + 0.25, 0.5), radius=1.2, rule=rule),),
        "corners": (Obstacle(sites=((0, 0), (across - 1, down - 1), (0, down - 1)), rule=rule),),
        "overlapping": (
            Obstacle(rows=first, rule=rule),
            Obstacle(columns=(across // 2, across // 2)),
            Obstacle(sites=((0, down - 1), (across // 2, 0)), rule=rule),
        ),
    }[place]


def _start(row: Row, down: int, seed: int) -> Occupations:
    """Unlike occupations of all channels wherever the start allows it."""
    given: dict[str, dict[str, Any]] = {
        "density": {"density": 0.4, "velocity_x": 0.1, "velocity_y": 0.05},
        "channels": {"channels": tuple(np.linspace(0.25, 0.75, VELOCITIES[row["model"]].channels).tolist())},
        "values of rows": {
            "density": tuple(0.3 + 0.1 * k / down for k in range(down)),
            "velocity_x": tuple(0.1 - 0.05 * k for k in range(down)),
            "velocity_y": tuple(0.02 * k for k in range(down)),
        },
        "oblique waves": {
            "density": 0.4,
            "velocity_x": 0.05,
            "waves": (
                Wave(of="density", amplitude=0.1, mode=(1.0, 2.0), phase=0.3),
                Wave(of="velocity_x", amplitude=0.1, mode=(2.0, 1.0)),
                Wave(of="velocity_y", amplitude=0.05, mode=(1.0, -1.0), phase=1.0),
            ),
        },
        "cells": {"density": 0.4, "cells": 1, "waves": (Wave(of="density", amplitude=0.2, mode=(0.5, 1.0)),)},
    }
    return Occupations(kind="occupations", seed=seed, **given[row["start"]])


def _scene(row: Row, seed: int) -> Scene:
    down, across = _shape(row)
    gas: dict[str, Any] = {"obstacles": _obstacles(row)}
    if row["force"] != "none":
        gas["force"] = float(row["force"])
    if row["reversals"] == "yes":
        gas["reversals"] = (1, 3)
    name = ", ".join(f"{feature} {level}" for feature, level in row.items() if level not in ("none", "no"))
    return gas_scene(name, row["model"], down, across, STEPS, _start(row, down, seed), Output(), **gas)


def _blocks(row: Row) -> tuple[int, int]:
    """Numbers of blocks along x and y."""
    down, across = _shape(row)
    some = next((k for k in (2, 3, 5) if across % k == 0), 1)
    both = (some, next((k for k in (2, 3) if down % k == 0), 1))
    return {"whole": (1, 1), "columns": (across, 1), "rows": (1, down), "both": both}[row["blocks"]]


# -- what is found in them -------------------------------------------------------------------------------


class _Found(NamedTuple):
    """Of one row: errors by quantity, in units in which more than 1 is wrong; (sum, variance) of random numbers.

    where: what is wrong, in words, by quantity.
    """

    errors: dict[str, float]
    chances: dict[str, tuple[float, float]]
    where: dict[str, str]


FORBIDDEN = "sites that leave a step in a state that the arrived one cannot become"
SITES = "sites that differ from the last populations"
IMPULSE = "momentum given by the force to a row, less that of the sites' change, in particles"
BLOCKS = "populations of blocks, less those counted by site, in roundings"
MEANS = "mean occupations after a step, less the auditor's, in roundings"
H = "H, less that of the occupations, in roundings"
START = "mean occupations of the start, from the equilibrium asked for, in roundings"
PUSHES = "particles turned by the force"
COINS = "particles sent straight back by diffusive walls"
FILLED = "particles of the start"
#: Whole numbers of particles are wrong by 1 or not at all; the tolerance of the others is counted in roundings.
_TOLERANCES = {FORBIDDEN: 0.5, SITES: 0.5, IMPULSE: 0.5, BLOCKS: 1.0, MEANS: 1.0, H: 1.0, START: 1.0}
_WHY = {
    FORBIDDEN: "coordinates say where each particle arrives, the definition of the model what it may become",
    SITES: "both are the state at the end",
    IMPULSE: "collisions keep the momentum of a site: only a turned particle changes it, by 2",
    BLOCKS: "sums over the same sites, a rounding for each",
    MEANS: "a rounding for each of the 2^b states that are summed over, and each of the b factors",
    H: "two roundings for each channel of the sum",
    START: "sums of a solution by Newton's method, met to some roundings for each channel, and its logarithms",
}


def _of_particles(found: Recorded, row: Row) -> _Found:
    run, walls = found.run, found.walls
    first = found.forbidden
    errors, where = {FORBIDDEN: float(first.number)}, {FORBIDDEN: first.first}
    chances = {}
    motion = found.motion
    if "sites" in run:
        errors[SITES] = float((run["sites"] != numbers(found.trajectory[-1])).sum())
    if found.force is not None:
        done = pushes(found.lattice, walls, found.force, motion)
        p = abs(found.force)
        if 0 < p < 1:
            chances[PUSHES] = (float((done.after - p * done.arrived).sum()), float(p * (1 - p) * done.arrived.sum()))
        if "force_impulse" in run:
            counted = np.diff(run["force_impulse"], axis=0) * np.sign(found.force or 1.0)
            errors[IMPULSE] = float(np.abs(counted - 2 * done.after.sum(axis=2)).max())
            errors[IMPULSE] += float(np.abs(run["force_impulse"][0]).max())
    tossed = coins(found.lattice, walls, motion)
    chances[COINS] = (float((tossed.after - 0.5 * tossed.arrived).sum()), 0.25 * float(tossed.arrived.sum()))
    if row["start"] != "cells":
        f = _asked(found)[walls == ""]
        filled = found.trajectory[0][walls == ""]
        chances[FILLED] = (float((filled - f).sum()), float((f * (1 - f)).sum()))
    return _Found(errors, chances, where)


def _asked(found: Recorded) -> np.ndarray:
    """Mean occupations that the scene asks for, as if there were no walls."""
    initial = found.scene.initial
    assert isinstance(initial, Occupations)
    if initial.channels is not None:
        return np.broadcast_to(np.array(initial.channels), found.trajectory[0].shape)
    asked = fields(found.lattice, initial)
    return fermi_dirac(found.lattice.model, asked.density, asked.velocity)


def _of_means(found: Recorded) -> _Found:
    run, f = found.run, found.trajectory
    channels = f.shape[-1]
    errors, where = {}, {}
    expected = np.array([mean_step(found.lattice, found.walls, found.force, one) for one in f[:-1]])
    away = np.abs(expected - f[1:])
    errors[MEANS] = float(away.max()) / (channels * 2**channels * EPSILON)
    step, line, column, channel = (int(k) for k in np.unravel_index(away.argmax(), away.shape))
    where[MEANS] = f"step {step + 1}, column {column}, row {line}, channel {channel}"
    if "h_function" in run:
        h = entropy_density(f).sum(axis=(1, 2))
        errors[H] = float(np.abs(run["h_function"] - h).max()) / (2 * f[0].size * EPSILON)
    initial, fluid = found.scene.initial, found.walls == ""
    assert isinstance(initial, Occupations)
    errors[START] = float(np.abs(f[0][~fluid]).sum()) / EPSILON
    if initial.channels is not None:
        errors[START] += float(np.abs(f[0][fluid] - np.array(initial.channels)).max(initial=0)) / EPSILON
    elif fluid.any():
        asked = fields(found.lattice, initial)
        here = type(asked)(asked.density[fluid], asked.velocity[fluid])
        errors[START] += max(deviation_from_equilibrium(found.lattice.model, f[0][fluid], here)) / (
            32 * channels * EPSILON
        )
    return _Found(errors, {}, where)


def _before(gas: LatticeGas | None, steps: int) -> LatticeGas | None:
    """The same gas with the reversals that come within so many steps."""
    if gas is None or gas.reversals is None:
        return gas
    return gas.model_copy(update={"reversals": tuple(step for step in gas.reversals if step <= steps)})


def _blocks_error(laboratory: Laboratory, found: Recorded, row: Row) -> float:
    """Two steps of the same run with larger blocks, seen at the start and at the end."""
    across, down = _blocks(row)
    output = Output(interval=2, fields=None if (across, down) == (1, 1) else (across, down),
                    observables=("populations",))  # fmt: skip
    scene = found.scene.changed(output=output, duration=2, lattice_gas=_before(found.scene.lattice_gas, 2))
    counted = laboratory.run(scene, found.method)["populations"]
    f = found.trajectory[:3:2]
    samples, rows_, columns, channels = f.shape
    expected = f.reshape(samples, down, rows_ // down, across, columns // across, channels).sum(axis=(2, 4))
    share = max(rows_ * columns / (down * across), 1) * EPSILON
    return float((np.abs(counted - expected.transpose(0, 2, 1, 3)) / (share * np.maximum(expected, 1).max())).max())


def _methods(engine: str, scene: Scene, row: Row, number: int) -> Iterable[Method]:
    """The scheme that the row names, by 2, 3 or 7 threads in turn if the engine takes them; and then the others."""
    methods = lattice_methods(engine)
    wanted = FACTORS["scheme"].index(row["scheme"]) % (len(FACTORS["scheme"]) - 1)
    if row["scheme"] == "first by threads":
        several = Method(scheme=methods[0].scheme, threads=THREADS[number % len(THREADS)])
        if refusal(engine_class(engine), scene, several) is None:
            yield several
    for turn in range(len(methods)):
        yield methods[(wanted + turn) % len(methods)]


def _audited(laboratory: Laboratory, row: Row, number: int) -> _Found | None:
    """What is found with the scheme that the row names, or else with the next one that can run it; None: with none."""
    scene = _scene(row, laboratory.seed(str(number)))
    for method in _methods(laboratory.engine, scene, row, number):
        try:
            found = recorded(laboratory, scene, method)
            blocks = _blocks_error(laboratory, found, row)
        except Unsupported:
            continue
        judged = _of_means(found) if "h_function" in found.run or not found.whole else _of_particles(found, row)
        return judged._replace(errors={**judged.errors, BLOCKS: blocks})
    return None


class _Chunk(NamedTuple):
    """Every so many rows of a table (`step`), from `first` on."""

    first: int
    step: int = CHUNKS
    table: int = 0


def _judge(laboratory: Laboratory, chunk: _Chunk) -> Judged:
    found, skipped = [], 0
    for number, row in enumerate(rows(chunk.table)[0]):
        if number % chunk.step == chunk.first:
            one = _audited(laboratory, row, number)
            skipped += one is None
            if one is not None:
                found.append((row, one))
    if not found:
        raise Unsupported(f"{laboratory.engine}: none of its lattice schemes can run a row")
    judgements = [*_errors(found), *_chances(found)]
    left = f"; {skipped} need more than the engine has" if skipped else ""
    return worst(judgements, f"{len(found)} scenes of all pairs of features{left}")


def _errors(found: list[tuple[Row, _Found]]) -> Iterable[Judgement]:
    for quantity, tolerance in _TOLERANCES.items():
        there = [(one.errors[quantity], number) for number, (_, one) in enumerate(found) if quantity in one.errors]
        if not there:
            continue
        error, number = max(there)
        row, one = found[number]
        note = ""
        if error > tolerance:
            features = ", ".join(f"{name} {level}" for name, level in row.items() if level not in ("none", "no"))
            note = f"{one.where.get(quantity, '')} of the scene with {features}".removeprefix(" of ")
        yield round_off(f"{quantity}, the most of a scene", error, tolerance, _WHY[quantity], note=note)


def _chances(found: list[tuple[Row, _Found]]) -> Iterable[Judgement]:
    from scipy.stats import halfnorm

    for quantity in (PUSHES, COINS, FILLED):
        there = [one.chances[quantity] for _, one in found if quantity in one.chances]
        total, variance = (sum(values) for values in zip(*there, strict=True)) if there else (0.0, 0.0)
        if variance > LEAST_SAMPLES:
            yield by_chance(
                f"{quantity}, less those expected, over the standard deviation: its size",
                abs(total) / variance**0.5,
                halfnorm,
                "binomial numbers with the probability that the scene asks for, summed over scenes",
            )


CHECKS = (
    Check(
        name="lattice/audit",
        title="Every site of small lattice gases at every step, for all pairs of features",
        equation="s(r + c_i, t + 1) = M s(r, t)",
        criterion="each particle arrives by coordinates, no outcome that the model does not have, force and "
        "populations counted by hand; mean occupations to rounding; random numbers within their binomial error",
        citation=FHP,
        judge=_judge,
        variants=(
            *quick(**{f"rows-{chunk}": _Chunk(chunk) for chunk in range(CHUNKS)}),
            *full(**{f"other-rows-{table}": _Chunk(0, 1, table) for table in TABLES}),
        ),
        faults=(
            (
                "rows-0",
                Fault(
                    "head-on-pairs-pass",
                    "lattice/models.py",
                    "    if velocities.momentum(state) == (0, 0) and velocities.mass(state) <= 3:\n        return None",
                    "    if velocities.momentum(state) == (0, 0) and velocities.mass(state) == 3:\n        return None",
                    "head-on pairs of FHP-I pass through each other",
                ),
            ),
            (
                "rows-1",
                Fault(
                    "odd-rows-as-even",
                    "lattice/velocities.py",
                    "return (a + (row - b) % 2 - row % 2) // 2",
                    "return (a + b % 2) // 2",
                    "particles that change the row arrive in odd rows as in even ones",
                ),
            ),
            (
                "rows-2",
                Fault(
                    "force-at-half-the-rate",
                    "lattice/gas.py",
                    "return round(self.probability * (1 << DIGITS))",
                    "return round(self.probability * (1 << (DIGITS - 1)))",
                    "the force turns half as many particles as it should",
                ),
            ),
        ),
        needs=Needs("lattice_gas", (LATTICE,), observables=frozenset({"populations"})),
        interpreted=True,
        features=FeatureRows(FACTORS, rows),
    ),
)
