"""The collisions of a table as boolean logic on whole words: 64 sites an operation.

For every channel i, t_i(n, r) says whether a collision toggles it, n the b occupations of a site and r its random bits.
The functions share one reduced ordered decision diagram (Bryant, IEEE Trans. Comput. C-35, 677 (1986)), each node an
operation or two on words. The order of the variables is improved by sifting, and pairs of them are replaced by their
exclusive or where that helps (linear sifting: Meinel, Somenzi & Theobald, IEEE Trans. CAD 19, 521 (2000)). Everything
is derived from the table.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple


class Program(NamedTuple):
    """Operations on words. Values 0 ... inputs - 1 are the inputs: b occupations, then `draws` random words.

    operations: (name, value, value), "and", "or", "xor", "andnot" (a and not b), "ornot" or "not"; each result is
    the next value. toggles: of each channel, the value to be xor-ed onto it, or None where nothing ever changes.
    rejected: the value that marks sites whose random bits must be drawn again, or None where every draw is good.
    """

    inputs: int
    draws: int
    operations: tuple[tuple[str, int, int], ...]
    toggles: tuple[int | None, ...]
    rejected: int | None


def draws(outcomes: tuple[tuple[int, ...], ...]) -> int:
    """Random bits of a site: those that number the outcomes of the state that has most."""
    return max((len(found) - 1).bit_length() for found in outcomes)


def outcome(found: tuple[int, ...], bits: int) -> int | None:
    """The state that the random bits choose among `found`, or None: draw again.

    Of the bits, only as many count as number the outcomes.
    """
    code = bits & ((1 << (len(found) - 1).bit_length()) - 1)
    return found[code] if code < len(found) else None


@cache
def program(outcomes: tuple[tuple[int, ...], ...]) -> Program:
    """The logic of a collision table, outcomes[state] -> states."""
    channels, random = (len(outcomes) - 1).bit_length(), draws(outcomes)
    inputs = channels + random
    functions = [0] * (channels + 1)
    for row in range(1 << inputs):
        state, bits = row & (len(outcomes) - 1), row >> channels
        chosen = outcome(outcomes[state], bits)
        changed = 1 << channels if chosen is None else chosen ^ state
        for k in range(channels + 1):
            functions[k] |= (changed >> k & 1) << row
    diagram = _fewest_operations(functions, inputs)
    return Program(
        inputs, random, tuple(diagram.operations), tuple(diagram.values[:channels]), diagram.values[channels]
    )


#: Exclusive ors that are tried without gain before the search ends.
_PATIENCE = 3


def _fewest_operations(functions: list[int], inputs: int) -> _Diagram:
    """A diagram with few operations, found by linear sifting."""
    best = _sifted(functions, inputs, [])
    pairs: list[tuple[int, int]] = []
    order, patience = best.order, _PATIENCE
    while patience:
        trials = []
        for i in range(inputs):
            for j in range(inputs):
                if i != j:
                    mixed = [_mixed(f, i, j, inputs) for f in functions]
                    trials.append((len(_Diagram(mixed, inputs, [*pairs, (i, j)], order).operations), i, j, mixed))
        _, i, j, functions = min(trials)
        pairs.append((i, j))
        found = _sifted(functions, inputs, pairs, order)
        order, patience = found.order, patience - 1
        if len(found.operations) < len(best.operations):
            best, patience = found, _PATIENCE
    return best


def _mixed(f: int, i: int, j: int, inputs: int) -> int:
    """The same function of the variables with x_i replaced by x_i ^ x_j."""
    ones, width = ~_zeros(j, inputs), 1 << i
    low = _zeros(i, inputs)
    swapped = (f & low) << width | (f >> width) & low
    return (f & ~ones) | (swapped & ones)


@cache
def _zeros(variable: int, inputs: int) -> int:
    """Rows of a truth table in which the variable is 0: blocks of 2^variable, every second one."""
    block = (1 << (1 << variable)) - 1
    return sum(block << start for start in range(0, 1 << inputs, 2 << variable))


def _sifted(functions: list[int], inputs: int, pairs: list[tuple[int, int]], order: Sequence[int] = ()) -> _Diagram:
    """Each variable is moved to its best place in the order, until none moves."""
    best = _Diagram(functions, inputs, pairs, order or range(inputs))
    improved = True
    while improved:
        improved = False
        for variable in range(inputs):
            rest = [v for v in best.order if v != variable]
            for place in range(inputs):
                trial = _Diagram(functions, inputs, pairs, [*rest[:place], variable, *rest[place:]])
                if len(trial.operations) < len(best.operations):
                    best, improved = trial, True
    return best


class _Diagram:
    """Operations that compute some functions, each node once.

    A function is its truth table: bit `row` of an integer, the bits of the row being the variables. pairs: (i, j), in
    the order in which variable i was replaced by its exclusive or with variable j. values: of each function, the value
    that holds it, or None for the constant 0.
    """

    def __init__(
        self, functions: list[int], inputs: int, pairs: Sequence[tuple[int, int]], order: Sequence[int]
    ) -> None:
        self.operations: list[tuple[str, int, int]] = []
        self.order = list(order)
        self._full = (1 << (1 << inputs)) - 1
        self._low = [_zeros(variable, inputs) for variable in range(inputs)]
        self._next = inputs
        self._variables = list(range(inputs))
        for i, j in pairs:
            self._variables[i] = self._emit("xor", self._variables[i], self._variables[j])
        self._known = {low ^ self._full: v for low, v in zip(self._low, self._variables, strict=True)}
        if self._full in functions:
            raise ValueError("a collision that toggles a channel of every state conserves nothing")
        self.values = [None if f == 0 else self._node(f, 0) for f in functions]

    def _halves(self, f: int, variable: int) -> tuple[int, int]:
        """f with the variable 0, and 1: each as a function of all variables."""
        low, width = self._low[variable], 1 << variable
        zero, one = f & low, (f >> width) & low
        return zero | zero << width, one | one << width

    def _node(self, f: int, level: int) -> int:
        full = self._full
        if f in self._known:
            return self._known[f]
        if f ^ full in self._known:
            complement = self._known[f ^ full]
            self._known[f] = self._emit("not", complement, complement)
            return self._known[f]
        while True:
            zero, one = self._halves(f, self.order[level])
            variable = self._variables[self.order[level]]
            level += 1
            if zero != one:
                break
        if zero == 0:
            result = self._emit("and", variable, self._node(one, level))
        elif one == 0:
            result = self._emit("andnot", self._node(zero, level), variable)
        elif zero == full:
            result = self._emit("ornot", self._node(one, level), variable)
        elif one == full:
            result = self._emit("or", self._node(zero, level), variable)
        elif zero ^ one == full:
            result = self._emit("xor", self._node(zero, level), variable)
        else:
            # the exclusive or of both halves is often known already, or simpler than either
            low = self._node(zero, level)
            difference = self._emit("and", variable, self._node(zero ^ one, level))
            result = self._emit("xor", low, difference)
        self._known[f] = result
        return result

    def _emit(self, name: str, a: int, b: int) -> int:
        self.operations.append((name, a, b))
        self._next += 1
        return self._next - 1
