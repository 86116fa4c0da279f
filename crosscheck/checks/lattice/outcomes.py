"""Random outcomes of lattice gases: how often each, and whether a random number is used twice.

Sites whose state has several outcomes, particles that the force can turn, and those that diffusive walls can send along
either of two channels, by some ten thousand each.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Literal, NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.lattice.gases import FHP, LATTICE, filled, gas_scene
from crosscheck.checks.lattice.recording import Recorded, lattice_methods, recorded
from crosscheck.engines.capabilities import Needs
from crosscheck.errors import Unsupported
from crosscheck.faults import Fault
from crosscheck.references.lattice_audit import Motion, coins, draws_of, outcomes, pushes
from crosscheck.references.lattice_draws import frequencies, serial
from crosscheck.references.lattice_models import MODELS
from crosscheck.scene import Floats, Obstacle, Output, Scene
from crosscheck.verdict import Judged, Judgement, by_chance, round_off, worst

#: Of each model: the place of the scheme that is judged in the quick tier, among those of the engine.
_SCHEMES = {"fhp1": 2, "fhp2": 2, "fhp3": 1, "fhp_saturated": 2, "fhp_saturated_identity": 2}
#: The density of most head-on pairs, and some of all other states.
DENSITY = 0.35
FORCE = -0.37


_Kind = Literal["free", "driven", "wide"]


class _Case(NamedTuple):
    """A model; what moves beside collisions; the place of the scheme among those of the engine.

    driven: with diffusive walls and a force; wide: with a force alone, on two rows that are longer than 64 words.
    """

    model: str
    kind: _Kind
    scheme: int


def _judge(laboratory: Laboratory, case: _Case) -> Judged:
    scene = _SCENES[case.kind](case.model, laboratory.seed())
    found = _recorded(laboratory, scene.changed(seed=laboratory.seed("one")), case.scheme)
    again = recorded(laboratory, scene.changed(seed=laboratory.seed("other")), found.method)
    first = found.forbidden
    judgements: list[Judgement] = [
        round_off(
            "sites that leave a step in a state that the arrived one cannot become",
            first.number,
            0.5,
            "coordinates say where each particle arrives, the definition of the model what it may become",
            note=first.first,
        )
    ]
    if first.number:  # outcomes that no rule has: of others nothing can be said
        return worst(judgements, found.method.scheme)
    if case.kind != "free":
        judgements += _of_collisions_with_force(found)
        judgements += _of("particles that the force can turn", *_pushed(found, again), draws_of(abs(FORCE)))
        if case.kind == "driven" and case.model != "hpp":  # there a flat wall sends what arrives straight back
            judgements += _of("particles that diffusive walls send either way", *_tossed(found, again), draws_of(0.5))
    else:
        judgements += _of("outcomes of collisions", found.motion, again.motion, outcomes(case.model, "", None))
    rows, columns = found.walls.shape
    return worst(judgements, f"{found.method.scheme}: {len(found.trajectory) - 1} steps of {rows} x {columns} sites")


def _recorded(laboratory: Laboratory, scene: Scene, number: int) -> Recorded:
    """With the lattice scheme of this number, counted round, or the next one that counts particles and can run it."""
    methods = lattice_methods(laboratory.engine)
    for turn in range(len(methods)):
        try:
            found = recorded(laboratory, scene, methods[(number + turn) % len(methods)])
        except Unsupported:
            continue
        if found.whole:
            return found
    raise Unsupported(f"{laboratory.engine}: no lattice scheme that counts particles can run this scene")


def _free_scene(model: str, seed: int) -> Scene:
    # in FHP-I and II only head-on pairs have two outcomes
    rows, steps = (64, 6) if model in ("fhp1", "fhp2") else (48, 5)
    return gas_scene("free", model, rows, 128, steps, filled(DENSITY, seed), Output())


def _driven_scene(model: str, seed: int) -> Scene:
    """Thin walls, so that many particles meet them."""
    walls = tuple(Obstacle(rows=(row, row), rule="diffusive_y") for row in range(2, 64, 5))
    posts = tuple(Obstacle(columns=(column, column), rule="diffusive_x") for column in range(3, 64, 9))
    return gas_scene(
        "driven", model, 64, 64, 8, filled(DENSITY, seed), Output(), obstacles=(*walls, *posts), force=FORCE
    )


def _wide_scene(model: str, seed: int) -> Scene:
    """A flow along the particles that the force turns: many of them."""
    return gas_scene("wide", model, 2, 6200, 6, filled(DENSITY, seed, velocity_x=0.3), Output(), force=FORCE)


_SCENES: dict[str, Callable[[str, int], Scene]] = {"free": _free_scene, "driven": _driven_scene, "wide": _wide_scene}


def _pushed(found: Recorded, again: Recorded) -> tuple[Motion, Motion]:
    one, other = (pushes(gas.lattice, gas.walls, FORCE, gas.motion) for gas in (found, again))
    return one, other


def _tossed(found: Recorded, again: Recorded) -> tuple[Motion, Motion]:
    one, other = (coins(gas.lattice, gas.walls, gas.motion) for gas in (found, again))
    return one, other


def _counts(motion: Motion, number: int) -> Floats:
    """How often each state became each other one, (number, number)."""
    flat = motion.arrived.ravel() * number + motion.after.ravel()
    return np.bincount(flat, minlength=number**2).reshape(number, number).astype(np.float64)


def _of_collisions_with_force(found: Recorded) -> Iterable[Judgement]:
    """The force and the collision of a site together: they draw independent numbers."""
    fluid = found.walls == ""
    there = Motion(found.motion.arrived[:, fluid], found.motion.after[:, fluid])
    yield from _frequencies("outcomes of force and collision", there, outcomes(found.lattice.model, "", FORCE))


def _frequencies(label: str, motion: Motion, probabilities: Floats) -> Iterable[Judgement]:
    from scipy.stats import halfnorm

    found = frequencies(_counts(motion, len(probabilities)), probabilities)
    why = f"chi^2 of {found.draws} outcomes, as the normal variable of the same probability"
    yield by_chance(f"{label}, all states", found.total, halfnorm, why)
    yield by_chance(f"{label}, the worst state", found.worst, halfnorm, why, note=f"state {found.state:b}")


def _of(label: str, one: Motion, other: Motion, probabilities: Floats) -> Iterable[Judgement]:
    from scipy.stats import halfnorm

    yield from _frequencies(label, one, probabilities)
    for name, compared in (("of one run", None), ("of two seeds", other)):
        found = serial(one, probabilities, compared)
        step, row, column = found.distance
        yield by_chance(
            f"{label}, {name}: largest serial correlation",
            found.largest,
            halfnorm,
            f"the largest of {found.distances} distances, as one normal variable of the same probability",
            note=f"{step} steps, {row} rows, {column} columns apart",
        )


def _variants() -> Iterable[Variant]:
    for number in range(3):
        for model, scheme in _SCHEMES.items():
            yield Variant(
                f"{model}-{number + 1}", _Case(model, "free", number), "quick" if number == scheme else "full"
            )
        kinds: tuple[_Kind, ...] = ("driven", "wide")
        for kind in kinds:
            yield Variant(f"fhp1-{kind}-{number + 1}", _Case("fhp1", kind, number), "quick" if number == 2 else "full")
    for model in MODELS:
        if model != "fhp1":
            yield Variant(f"{model}-driven-1", _Case(model, "driven", 0), "full")


CHECKS = (
    Check(
        name="lattice/outcomes",
        title="Random outcomes of collisions, of the force and of diffusive walls: frequencies and serial correlation",
        equation="P(s -> t) = A(s -> t), and draws that do not know of each other",
        criterion="chi^2 of each state and of all; the largest correlation at any distance in time and space",
        citation=FHP,
        judge=_judge,
        variants=tuple(_variants()),
        faults=(
            (
                "fhp1-3",
                Fault(
                    "same-number-in-two-rows",
                    "lattice/randomness.py",
                    "return mix64(key + (row + _ONE) * GAMMA)",
                    "return mix64(key + (row // np.uint64(2) + _ONE) * GAMMA)",
                    "two rows draw the same random bits",
                ),
            ),
            (
                "fhp2-3",
                Fault(
                    "always-one-way",
                    "lattice/plain.py",
                    "            fresh = sum(self._bits(COLLISION, draw + j).astype(np.int64)",
                    "            fresh = sum(0 * self._bits(COLLISION, draw + j).astype(np.int64)",
                    "all head-on pairs turn the same way",
                ),
            ),
            (
                "fhp1-wide-3",
                Fault(
                    "words-of-two-draws",
                    "lattice/randomness.py",
                    "ROW = 1 << 32",
                    "ROW = 1 << 5",
                    "the second draw of a row takes the words of the first one from column 2048 on",
                ),
            ),
            (
                "fhp1-driven-3",
                Fault(
                    "no-tossing",
                    "lattice/plain.py",
                    "        coin = self._bits(WALLS, 0)",
                    "        coin = self._bits(WALLS, 0) | self._bits(WALLS, 1)",
                    "diffusive walls send three of four particles straight back",
                ),
            ),
        ),
        needs=Needs("lattice_gas", (LATTICE,), observables=frozenset({"populations"})),
        interpreted=True,
    ),
)
