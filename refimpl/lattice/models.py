"""Collision tables of lattice gases, built from what a collision conserves.

A model is a velocity set and a label: states of equal mass, momentum and label turn into each other. Momenta are
compared in integers; summed from cosines, they would find no collision at all in double precision. The outcome is drawn
uniformly among the class, with the state that enters or without it: A(s -> s') is symmetric, and semi-detailed balance,
sum_s A(s -> s') = 1, holds.

Literature: Hardy, Pomeau & de Pazzis, J. Math. Phys. 14, 1746 (1973) (HPP); Frisch, Hasslacher & Pomeau, Phys. Rev.
Lett. 56, 1505 (1986) (FHP-I); Frisch et al., Complex Systems 1, 649 (1987) (FHP-II); d'Humieres & Lallemand, Complex
Systems 1, 599 (1987) (FHP-III).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Hashable
from functools import cached_property

import numpy as np

from refimpl.lattice.velocities import SQUARE, TRIANGULAR, TRIANGULAR_REST, VelocitySet

#: A rule turns a state into states with the same label.
Label = Callable[[VelocitySet, int], Hashable]


class Model:
    """A lattice gas: a velocity set and a collision table.

    name: of the model. velocities: the set. outcomes: 2^b tuples; outcomes[s] are the states that s turns into, each
    with probability 1/len(outcomes[s]).
    """

    def __init__(self, name: str, velocities: VelocitySet, outcomes: tuple[tuple[int, ...], ...]) -> None:
        self.name = name
        self.velocities = velocities
        self.outcomes = outcomes

    @property
    def channels(self) -> int:
        """b."""
        return self.velocities.channels

    @property
    def deterministic(self) -> bool:
        """No state has more than one outcome."""
        return all(len(found) == 1 for found in self.outcomes)

    @cached_property
    def table(self) -> tuple[np.ndarray, np.ndarray]:
        """Outcomes as an array (2^b, most) of uint8, padded with zeros, and how many each state has, (2^b,)."""
        numbers = np.array([len(found) for found in self.outcomes])
        outcomes = np.zeros((numbers.size, numbers.max()), dtype=np.uint8)
        for state, found in enumerate(self.outcomes):
            outcomes[state, : len(found)] = found
        return outcomes, numbers

    @cached_property
    def active(self) -> tuple[int, ...]:
        """States that a collision can change."""
        return tuple(s for s, found in enumerate(self.outcomes) if found != (s,))


def build(name: str, velocities: VelocitySet, label: Label, *, identity: bool = False) -> Model:
    """The model whose collisions conserve mass, momentum and `label`.

    name: of the model. velocities: its set. label: what else of a state is conserved, any hashable value. identity: the
    state that enters is among the outcomes; otherwise it is one only where there is no other.
    """
    classes: defaultdict[Hashable, list[int]] = defaultdict(list)
    for state in range(velocities.states):
        key = (velocities.mass(state), velocities.momentum(state), label(velocities, state))
        classes[key].append(state)
    outcomes: list[tuple[int, ...]] = [(state,) for state in range(velocities.states)]
    for members in classes.values():
        for place, state in enumerate(members):
            # in a cycle from the state on: any one choice for all is then a permutation, and its logic short
            cycle = (*members[place:], *members[:place])
            outcomes[state] = cycle if identity or len(cycle) == 1 else cycle[1:]
    return Model(name, velocities, tuple(outcomes))


def _all(velocities: VelocitySet, state: int) -> Hashable:
    """Every collision that keeps mass and momentum."""
    return None


def _resting(velocities: VelocitySet, state: int) -> int:
    return sum(state >> i & 1 for i in velocities.rest)


def _fhp1(velocities: VelocitySet, state: int) -> Hashable:
    """Two head-on, and three symmetric particles; nothing else collides."""
    if velocities.momentum(state) == (0, 0) and velocities.mass(state) <= 3:
        return None
    return state


def _fhp2(velocities: VelocitySet, state: int) -> Hashable:
    """Those of FHP-I, with a resting spectator or without; and rest + mover <-> two movers at +-60 degrees."""
    resting = _resting(velocities, state)
    if velocities.momentum(state) == (0, 0) and velocities.mass(state) - resting <= 3:
        return ("spectator", resting)
    return None if velocities.mass(state) == 2 else state


def _fhp3(velocities: VelocitySet, state: int) -> Hashable:
    """All, but with zero momentum the resting particle is a spectator: head-on pairs turn, triples turn."""
    return _resting(velocities, state) if velocities.momentum(state) == (0, 0) else None


#: By name. fhp_saturated: all collisions of 2, 3 and 4 particles on six bits; with "_identity", the state that enters
#: is one of its own outcomes.
MODELS = {
    model.name: model
    for model in (
        build("hpp", SQUARE, _all),
        build("fhp1", TRIANGULAR, _fhp1),
        build("fhp2", TRIANGULAR_REST, _fhp2),
        build("fhp3", TRIANGULAR_REST, _fhp3),
        build("fhp_saturated", TRIANGULAR, _all),
        build("fhp_saturated_identity", TRIANGULAR, _all, identity=True),
    )
}
