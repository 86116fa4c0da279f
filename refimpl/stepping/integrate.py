"""The step loop: any scheme with any force, compiled once per pair of types, nothing recorded that is not asked for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numba.extending import overload

from refimpl.stepping.forces.generic import (
    DIVERGED,
    GOOD,
    NEEDS_CAPACITY,
    accelerate,
    enlarge,
    kinetic_energy,
    potential_energy,
    status,
    virial,
)
from refimpl.stepping.schemes import SCHEMES, Memory, State


def step(self: Any, force: Any, r: np.ndarray, v: np.ndarray, memory: Memory, dt: float) -> State:
    """`scheme.step(...)`, for kernels."""
    state: State = self.step(force, r, v, memory, dt)
    return state


@overload(step, inline="never", strict=False)
def _step(self: Any, force: Any, r: Any, v: Any, memory: Any, dt: Any) -> Any:
    return self.instance_class.step


@njit(cache=True, error_model="numpy")
def _advance(scheme, force, r, v, memory, dt, first, last, every, positions, velocities, thermo):  # type: ignore[no-untyped-def]
    """Steps first + 1 ... last; a sample after every step whose number is a multiple of `every`.

    Returns the state, the number of the last good step and the force's status; a failed step changes nothing.
    """
    for number in range(first + 1, last + 1):
        r_new, v_new, memory_new = step(scheme, force, r, v, memory, dt)
        outcome = status(force)
        if outcome != GOOD:
            return r, v, memory, number - 1, outcome
        r, v, memory = r_new, v_new, memory_new
        if number % every == 0:
            sample = number // every
            if positions is not None:
                positions[sample] = r
            if velocities is not None:
                velocities[sample] = v
            if thermo is not None:
                thermo[sample, 0] = kinetic_energy(force, v)
                thermo[sample, 1] = potential_energy(force, r)
                thermo[sample, 2] = virial(force, r)
    return r, v, memory, last, GOOD


@njit(cache=True, error_model="numpy")
def _thermo(force, r, v):  # type: ignore[no-untyped-def]
    return kinetic_energy(force, v), potential_energy(force, r), virial(force, r)


@njit(cache=True, error_model="numpy")
def _accelerate(force, r, v):  # type: ignore[no-untyped-def]
    return accelerate(force, r, v), status(force)


def acceleration(force: Any, r: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, Any]:
    """One compiled evaluation of f(r, v)/m, and the force, enlarged if it had to be."""
    while True:
        a, outcome = _accelerate(force, r, v)
        if outcome != NEEDS_CAPACITY:
            return a, force
        force = enlarge(force)


@dataclass
class Integration:
    """What `integrate` returns. Sample s is at time s * every * dt; sample 0 is the initial state.

    r, v: final state, flat. steps: taken before the end or the divergence. diverged: stopped by a non-finite state.
    positions, velocities: (samples, N*d) or None. thermo: (samples, 3), columns K, U, W, or None.
    evaluations: of the force, exactly. force: with its work arrays as they ended.
    """

    r: np.ndarray
    v: np.ndarray
    steps: int
    diverged: bool
    positions: np.ndarray | None
    velocities: np.ndarray | None
    thermo: np.ndarray | None
    evaluations: int
    force: Any


def integrate(
    scheme: str,
    force: Any,
    r: np.ndarray,
    v: np.ndarray,
    dt: float,
    steps: int,
    *,
    every: int | None = None,
    trajectory: bool = False,
    thermo: bool = False,
) -> Integration:
    """Takes `steps` steps of length `dt` with a scheme of `SCHEMES`.

    r, v: flat initial state, shape (N*d,), left untouched. every: steps between samples (default: one, at the end).
    trajectory: record r and v at the samples. thermo: record kinetic energy, potential energy and virial there.
    Raises KeyError for an unknown scheme, ValueError for bad sizes.
    """
    if steps < 0 or (every is not None and every < 1):
        raise ValueError(f"steps must be >= 0 and every >= 1, got steps = {steps}, every = {every}")
    if r.shape != v.shape or r.ndim != 1:
        raise ValueError(f"r and v must be flat and of one shape, got {r.shape} and {v.shape}")
    table = SCHEMES[scheme]
    record = table.record
    r = np.ascontiguousarray(r, dtype=np.float64).copy()
    v = np.ascontiguousarray(v, dtype=np.float64).copy()
    every = every or max(steps, 1)
    samples = steps // every + 1
    positions = np.full((samples, r.size), np.nan) if trajectory else None
    velocities = np.full((samples, r.size), np.nan) if trajectory else None
    energies = np.full((samples, 3), np.nan) if thermo else None

    while True:
        # taken once: plain Python, which calls the same compiled forces and costs no compilation of its own
        memory = record.start(force, r, v, dt)
        outcome = status(force)
        if outcome != NEEDS_CAPACITY:
            break
        force = enlarge(force)
    if positions is not None and velocities is not None:
        positions[0], velocities[0] = r, v
    if energies is not None:
        energies[0] = _thermo(force, r, v)

    done = 0
    while outcome != DIVERGED:
        r, v, memory, done, outcome = _advance(
            record, force, r, v, memory, dt, done, steps, every, positions, velocities, energies
        )
        if outcome == GOOD:
            break
        if outcome == NEEDS_CAPACITY:
            force = enlarge(force)
    diverged = outcome == DIVERGED or not bool(np.isfinite(r).all() and np.isfinite(v).all())
    evaluations = table.start_evaluations + done * table.evaluations
    return Integration(r, v, done, diverged, positions, velocities, energies, evaluations, force)
