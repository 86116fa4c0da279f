"""The step loop: any scheme with any force, compiled once per pair of types, nothing recorded that is not asked for.

Coordinates are not wrapped into the box, so that trajectories have no jumps. But one that is FAR_OUT box sides away or
further is brought back by whole sides, and the number of sides is kept: a particle that streams through periodic images
for 1e12 steps is moved with a rounding of FAR_OUT sides times 1e-16, not of its whole path. The shifts are powers of
two times the side, between half of the coordinate and all of it, so that subtracting them rounds nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba.extending import overload, register_jitable

from refimpl.compilation import INTERPRETED, compiled
from refimpl.stepping.forces.generic import (
    DIVERGED,
    GOOD,
    NEEDS_CAPACITY,
    Force,
    accelerate,
    bodies_in_registers,
    energy_and_virial,
    enlarge,
    in_registers,
    kinetic_energy,
    operations,
    periods,
    renew,
    status,
    team,
)
from refimpl.stepping.kernels.registers import from_array, to_array, tuple_from_arrays, tuple_to_arrays
from refimpl.stepping.schemes import COMPENSATED, SCHEMES, Memory, Scheme, StepResult

#: Coordinates further from the origin than so many periods are brought back, looked for after every STRIDE steps.
FAR_OUT = 2.0**12
STRIDE = 2**10


#: Steps between two samples from which on few coordinates are kept in registers, by a loop compiled for their number.
MANY_STEPS = 1_000_000


def step(self: Any, force: Force, r: np.ndarray, v: np.ndarray, memory: Memory, dt: float) -> StepResult:
    """`self.step(force, r, v, memory, dt)` of a scheme, callable from kernels; arguments as in `schemes`."""
    state: StepResult = self.step(force, r, v, memory, dt)
    return state


@overload(step, strict=False, inline="always")
def _step(self: Any, force: Any, r: Any, v: Any, memory: Any, dt: Any) -> Any:
    return self.instance_class.step


@register_jitable
def _copy_end(x: np.ndarray, end: np.ndarray) -> None:
    """Writes the last numbers of x to `end`: an assignment of arrays takes two seconds more to compile."""
    first = x.size - end.size
    for k in range(end.size):
        end[k] = x[first + k]


@compiled(cache=True)
def _advance(scheme, force, state, dt, first, last, every, frames, thermo):  # type: ignore[no-untyped-def]
    """Steps first + 1 ... last; a sample after every step whose number is a multiple of `every`.

    state: (r, v, memory). frames: (positions, velocities), (samples, coordinates) both, or empty. thermo: (samples, 3)
    or None. Returns the state, the number of the last good step and the force's status; a failed step changes nothing.
    """
    r, v, memory = state
    positions, velocities = frames
    for number in range(first + 1, last + 1):
        if number % every == 0 and len(positions) > 0:
            renew(force)
        r_new, v_new, memory_new = step(scheme, force, r, v, memory, dt)
        outcome = status(force)
        if outcome != GOOD:
            return (r, v, memory), number - 1, outcome
        if number % every == 0:
            sample = number // every
            # empty, not None, where they are not asked for: one compiled loop for both, and a test a sample
            if len(positions) > 0:
                _copy_end(r_new, positions[sample])
                _copy_end(v_new, velocities[sample])
            if thermo is not None:
                thermo[sample, 0] = kinetic_energy(force, v_new)
                thermo[sample, 1], thermo[sample, 2] = energy_and_virial(force, r_new)
                # not every scheme has had the force at r_new before
                if status(force) == NEEDS_CAPACITY:
                    return (r, v, memory), number - 1, NEEDS_CAPACITY
        r, v, memory = r_new, v_new, memory_new
    return (r, v, memory), last, GOOD


@compiled(cache=True)
def _advance_in_registers(scheme, force, state, axes, bodies, dt, steps):  # type: ignore[no-untyped-def]
    """As `_advance`, of `steps` steps without a sample; axes, bodies: tuples as long as there are any."""
    r, v = from_array(state[0], axes, bodies), from_array(state[1], axes, bodies)
    memory = tuple_from_arrays(state[2], axes, bodies)
    few = in_registers(force, bodies)
    done, outcome = 0, GOOD
    while done < steps:
        r_new, v_new, memory_new = step(scheme, few, r, v, memory, dt)
        outcome = status(few)
        if outcome != GOOD:
            break
        r, v, memory = r_new, v_new, memory_new
        done += 1
    to_array(r, state[0])
    to_array(v, state[1])
    tuple_to_arrays(memory, state[2])
    return done, outcome


def _few(force: Force, r: np.ndarray, memory: Memory) -> int:
    """Number of bodies, if the coordinates `r` and what a scheme remembers of them fit into registers; else 0."""
    if INTERPRETED or any(part.shape != r.shape for part in memory):
        return 0
    return bodies_in_registers(force, r.size)


def _advance_few(
    scheme: Any, force: Force, state: StepResult, dt: float, bodies: int, steps: int
) -> tuple[StepResult, int, int]:
    """`_advance_in_registers` of a copy of the state; returns it, the number of good steps and the force's status."""
    r, v, memory = state[0].copy(), state[1].copy(), tuple(part.copy() for part in state[2])
    axes = r.size // bodies
    done, outcome = _advance_in_registers(scheme, force, (r, v, memory), (0,) * axes, (0,) * bodies, dt, steps)
    return (r, v, memory), done, outcome


def acceleration(force: Force, r: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, Force]:
    """f(r, v)/m at the coordinates r and velocities v, (N*d,) each, and the force, enlarged if it had to be."""
    while True:
        a = accelerate(force, r, v)
        if status(force) != NEEDS_CAPACITY:
            return a, force
        force = enlarge(force)


def thermo_now(force: Force, r: np.ndarray, v: np.ndarray) -> tuple[float, float, float]:
    """Kinetic energy, potential energy and virial of a force at the coordinates r and velocities v, (N*d,) each."""
    return kinetic_energy(force, v), *energy_and_virial(force, r)


def _enlarged(force: Force, r: np.ndarray, v: np.ndarray, outcome: int) -> Force | None:
    """The force with room for what it failed at from (r, v); None if it diverged.

    Of two evaluations in one start or step only the status of the last is known, and DIVERGED may come from the NaN of
    the first. The first one is always at (r, v): it is repeated.
    """
    if outcome == DIVERGED:
        accelerate(force, r, v)
        outcome = status(force)
    return enlarge(force) if outcome == NEEDS_CAPACITY else None


class _Turns:
    """By how many periods the coordinates of the step loop differ from those of the particles.

    possible: whether any coordinate has a period. turns: (N*d,), whole numbers, exact up to 2^53.
    """

    def __init__(self, box: np.ndarray | None) -> None:
        self.possible = box is not None
        self._box = np.zeros(0) if box is None else box
        self.turns = np.zeros(self._box.size)

    def excess(self, r: np.ndarray) -> np.ndarray | None:
        """What to subtract from coordinates FAR_OUT periods away or further, (N*d,); None if there are none.

        It is noted as subtracted. Of a coordinate, the largest power of two times the period that goes into it.
        """
        if not self.possible:
            return None
        ratio = np.divide(r, self._box, out=np.zeros_like(r), where=self._box > 0)
        far = (abs(ratio) >= FAR_OUT) & np.isfinite(ratio)
        if not far.any():
            return None
        turns = np.where(far, np.copysign(np.ldexp(0.5, np.frexp(abs(ratio))[1]), ratio), 0.0)
        self.turns += turns
        return turns * self._box

    def true(self, r: np.ndarray) -> np.ndarray:
        """The coordinates of the particles, where those of the step loop, or the last ones of them, are r, (..., n)."""
        if not self.turns.any():
            return r
        size = r.shape[-1]
        return r + (self.turns * self._box)[self._box.size - size :]


@dataclass
class Integration:
    """The result of `integrate`. Sample s is at time s * every * dt; sample 0 is the initial state.

    r, v: final state, flat. steps: taken before the end or the divergence. diverged: stopped by a state that is not
    finite, or in which the force found a particle lost.
    positions, velocities: (samples, N*d), or fewer coordinates if asked so, or None. thermo: (samples, 3), columns K,
    U, W, or None. evaluations: of the force, as it counts them, or the scheme's number where it does not. operations:
    of this integration, see `forces.generic.operations`. force: with its work arrays as they ended. state: all that
    decides how it would go on, with the memory of the scheme.
    """

    r: np.ndarray
    v: np.ndarray
    steps: int
    diverged: bool
    positions: np.ndarray | None
    velocities: np.ndarray | None
    thermo: np.ndarray | None
    evaluations: int
    operations: dict[str, int]
    force: Force
    state: dict[str, Any]


def scheme_of(name: str, compensated: bool = False) -> Scheme:
    """The scheme of this name. compensated: with compensated summation. KeyError if there is none."""
    return (COMPENSATED if compensated else SCHEMES)[name]


def compile_steps(
    scheme: str,
    force: Force,
    r: np.ndarray,
    v: np.ndarray,
    dt: float,
    *,
    thermo: bool = False,
    compensated: bool = False,
) -> None:
    """Compiles, or loads from the cache, the loop that `integrate` runs with these arguments; takes no step.

    scheme, force, r, v, dt, thermo, compensated: as of `integrate`. Raises KeyError for an unknown scheme.
    """
    record = scheme_of(scheme, compensated).record
    memory = record.start(force, r, v, dt)
    frames = np.empty((0, r.size))
    with team(force):  # which compiles what helpers do
        _advance(record, force, (r, v, memory), dt, 0, 0, 1, (frames, frames), np.empty((1, 3)) if thermo else None)


def integrate(
    scheme: str,
    force: Force,
    r: np.ndarray,
    v: np.ndarray,
    dt: float,
    steps: int,
    *,
    every: int | None = None,
    trajectory: bool = False,
    last: int | None = None,
    thermo: bool = False,
    pace: Callable[[int], int] | None = None,
    state: Mapping[str, Any] | None = None,
    compensated: bool = False,
) -> Integration:
    """Takes `steps` steps of length `dt` with a scheme of `SCHEMES`.

    scheme: its name. force: a record with the functions of `forces.generic`. r, v: flat initial state, shape (N*d,),
    left untouched. every: steps between samples (default: one, at the end). trajectory: record r and v at the samples;
    last: only so many of their last coordinates. thermo: record kinetic energy, potential energy and virial there.
    pace: called with the number of steps done; returns after how many more it is called again; None: never called.
    state: that of an earlier integration, to go on from in place of r, v and force; None: the scheme starts.
    compensated: by the form of the scheme in `COMPENSATED`.
    Raises KeyError for an unknown scheme, ValueError for bad sizes.
    """
    if steps < 0 or (every is not None and every < 1):
        raise ValueError(f"steps must be >= 0 and every >= 1, got steps = {steps}, every = {every}")
    if r.shape != v.shape or r.ndim != 1:
        raise ValueError(f"r and v must be flat and of one shape, got {r.shape} and {v.shape}")
    table = scheme_of(scheme, compensated)
    record = table.record
    r = np.ascontiguousarray(r, dtype=np.float64).copy()
    v = np.ascontiguousarray(v, dtype=np.float64).copy()
    every = every or max(steps, 1)
    samples = steps // every + 1
    width = r.size if last is None else last
    positions = np.full((samples if trajectory else 0, width), np.nan)
    velocities = positions.copy()
    energies = np.full((samples, 3), np.nan) if thermo else None

    start, away, taken = r, _Turns(periods(force)), 0
    outcome, starts = GOOD, state is None
    if state is not None:
        r, v, memory, force, taken = (state[name] for name in ("r", "v", "memory", "force", "taken"))
        away.turns = state["turns"].copy()
        start = away.true(r)
    while (excess := away.excess(r)) is not None:
        r = r - excess
    before_all = operations(force)
    while starts:
        # called once, so it runs as plain Python, calls the same compiled forces, and is not compiled itself
        memory = record.start(force, r, v, dt)
        # of a start that does not evaluate the force, it would be that of another run
        outcome = status(force) if table.start_evaluations else GOOD
        larger = None if outcome == GOOD else _enlarged(force, r, v, outcome)
        if larger is None:
            break
        force = larger
    if trajectory:
        positions[0], velocities[0] = start[r.size - width :], v[r.size - width :]
    if energies is not None:
        energies[0] = thermo_now(force, r, v)
        while status(force) == NEEDS_CAPACITY:
            force = enlarge(force)
            energies[0] = thermo_now(force, r, v)

    few = 0 if steps < MANY_STEPS or every < MANY_STEPS // 1000 else _few(force, r, memory)
    done = 0
    while outcome != DIVERGED and done < steps:
        before = done
        # counted from the very first start: pieces of a run must be cut where the whole one is
        stop = min(steps, done + STRIDE - (taken + done) % STRIDE) if away.possible else steps
        stop = stop if pace is None else min(stop, done + pace(done))
        if few and (unsampled := min(stop, (done // every + 1) * every - 1) - done) > 0:
            (r, v, memory), taken_in, outcome = _advance_few(record, force, (r, v, memory), dt, few, unsampled)
            done += taken_in
        if outcome == GOOD:
            with team(force):
                (r, v, memory), done, outcome = _advance(
                    record, force, (r, v, memory), dt, done, stop, every, (positions, velocities), energies
                )
        recorded = slice(before // every + 1, done // every + 1) if trajectory else slice(0, 0)
        positions[recorded] = away.true(positions[recorded])
        larger = None if outcome == GOOD else _enlarged(force, r, v, outcome)
        if larger is not None:
            force, outcome = larger, GOOD
        while (taken + done) % STRIDE == 0 and (excess := away.excess(r)) is not None:
            r = r - excess
            memory = record.moved(memory, -excess) if hasattr(record, "moved") else memory
            renew(force)
    end = {"r": r, "v": v, "memory": memory, "force": force, "turns": away.turns, "taken": taken + done}
    if away.turns.any():
        force = deepcopy(force)  # the one of the state belongs to its coordinates
        renew(force)
        r = away.true(r) if done else start
    counted = {name: count - before_all[name] for name, count in operations(force).items()}
    diverged = outcome == DIVERGED or not bool(np.isfinite(r).all() and np.isfinite(v).all())
    return Integration(
        r=r,
        v=v,
        steps=done,
        diverged=diverged,
        positions=positions if trajectory else None,
        velocities=velocities if trajectory else None,
        thermo=energies,
        evaluations=counted.get("evaluations", starts * table.start_evaluations + done * table.evaluations),
        operations=counted,
        force=force,
        state=end,
    )
