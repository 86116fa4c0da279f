"""Sums and samples of a run, computed again from its trace.

By derivation from the definitions of the observables.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from crosscheck.references.event_audit.deviations import Audit
from crosscheck.references.event_audit.history import Event, History
from crosscheck.scene import Floats, Scene

#: Error of a sum over some hundred events, in units of the sum of the sizes of its terms: 16 roundings of each of them.
OF_SUMS = 1e-12


def energies(history: History, i: int, v: Floats, w: Floats) -> Floats:
    """m v^2/2 + I omega^2/2 of particle i, (...); 0 of a fixed one.

    history: knows masses and moments of inertia. v, w: velocities and spins, (..., 3).
    """
    matter = history.matter
    if matter.fixed[i]:
        return np.zeros(v.shape[:-1])
    turning = matter.moments[i] if matter.spheres.friction is not None else 0.0
    return np.asarray(0.5 * matter.masses[i] * (v * v).sum(axis=-1) + 0.5 * turning * (w * w).sum(axis=-1))


def gained(history: History, event: Event) -> list[float]:
    """Energy that each partner of `event` gained in it. history: knows their masses."""
    return [
        float(energies(history, i, b.velocity, b.spin) - energies(history, i, a.velocity, a.spin))
        for i, (_, a), b in zip(event.partners, event.before, event.after, strict=True)
    ]


def impulse_on(history: History, event: Event) -> Floats:
    """Momentum that the second partner of `event` gained, (3,); if it is fixed, what the first lost. history: of it."""
    place, i = (0, event.i) if history.matter.fixed[event.j] else (1, event.j)
    change = event.after[place].velocity - event.before[place][1].velocity
    return np.asarray(history.matter.masses[i] * change * (-1.0 if place == 0 else 1.0))


def audit_tallies(
    scene: Scene,
    history: History,
    run: Mapping[str, Floats],
    rounding: tuple[float, float, float],
    found: Audit,
) -> None:
    """Notes how far samples, sums and the final state are from those of the trace.

    scene, run: as in `audit`. history: of the run, after its last event. rounding: of positions, velocities and spins.
    found: where deviations are noted.
    """
    there = run["time"] <= history.end  # not NaN, and not after a collapse
    times = run["time"][there]
    for name, (values, size) in _states(scene, history, rounding, times).items():
        if name in run:
            seen = run[name] if name.startswith("final") else run[name][there]
            found.note(name, float(np.abs(seen - values).max(initial=0.0)), float(size), "")
    counts = np.array([history.number_until(time) for time in times])
    for name, (values, sizes) in _sums(scene, history, times, counts, rounding[0]).items():
        if name in run:
            error = np.abs(run[name][there] - values) / np.where(sizes > 0, sizes, 1e-300)
            found.note(name, float(error.max(initial=0.0)), 1.0, "")
    if "events" in run:
        found.note("events", float((run["events"][there] < counts).any()), 0.5, "fewer events than the trace has")


#: What is compared, and its rounding, of the same shape or a number.
Sum = tuple[Floats, Floats]


def _states(
    scene: Scene, history: History, rounding: tuple[float, float, float], times: Floats
) -> dict[str, tuple[Floats, float]]:
    d, spins = scene.dimension, slice(2, 3) if scene.dimension == 2 else slice(0, 3)
    position, velocity, spin = rounding
    x, v, w = history.sampled(times)
    end = history.at(np.array([history.end]))
    return {
        "positions": (x[..., :d], position),
        "velocities": (v[..., :d], velocity),
        "angular_velocities": (w[..., spins], spin),
        "final_positions": (end[0][0, :, :d], position),
        "final_velocities": (end[1][0, :, :d], velocity),
        "final_angular_velocities": (end[2][0][:, spins], spin),
    }


def _sums(scene: Scene, history: History, times: Floats, counts: Floats, rounding: float) -> dict[str, Sum]:
    """Every tally at the samples, and the rounding of each."""
    matter, events, d = history.matter, history.events, scene.dimension
    core = np.array([event.kind == "core" for event in events], dtype=float)
    gains = [gained(history, event) for event in events]
    virial = [0.0 if e.j < 0 else float(e.distance * (impulse_on(history, e) @ e.n)) for e in events]
    lost = [-sum(gain) if event.kind == "core" else 0.0 for event, gain in zip(events, gains, strict=True)]
    faces = 2 * d + (matter.cylinder is not None)
    given, energy, hits, torque = (np.zeros((len(events), *shape)) for shape in ((faces, d), (faces,), (faces,), ()))
    depths = np.zeros(len(events))
    for k, event in enumerate(events):
        if event.kind == "core":
            contact = matter.radii[event.i] + matter.radii[event.j]
            depths[k] = (contact - event.distance) / contact
        if event.kind != "wall":
            continue
        face, (_, before), after = -1 - event.j, event.before[0], event.after[0]
        impulse = matter.masses[event.i] * (after.velocity - before.velocity)
        given[k, face], energy[k, face], hits[k, face] = -impulse[:d], gains[k][0], 1.0
        if face == 2 * d:
            first, second = matter.across
            assert matter.cylinder is not None
            torque[k] = matter.cylinder.radius * (event.n[first] * impulse[second] - event.n[second] * impulse[first])
    at_samples = _energies_at(history, times)
    kinetic, potential, mechanical = _integrals(history, times)
    deepest = np.maximum.accumulate(np.append(0.0, depths))[counts]
    exact = np.float64(0.5)
    # an elastic wall at rest gives no energy, but for the rounding of what it meets
    energy_size = float(at_samples["kinetic_energy"][1].max() / OF_SUMS)
    momentum_size = float(np.sqrt(2 * energy_size * matter.weights.sum()))
    radius = 0.0 if matter.cylinder is None else matter.cylinder.radius
    found = {
        "collisions": (_until(core, counts)[0], exact),
        "collisional_virial": _until(np.array(virial), counts),
        "dissipated_energy": _until(np.array(lost), counts, energy_size),
        "wall_impulse": _until(given, counts, momentum_size),
        "wall_energy": _until(energy, counts, energy_size),
        "wall_collisions": (_until(hits, counts)[0], exact),
        "wall_torque": _until(torque, counts, radius * momentum_size),
        "deepest_overlap": (deepest, rounding / matter.radii.max() / 2),
        "contact_time": (np.zeros(times.size), np.float64(1e-300)),
        "kinetic_energy_integral": (kinetic, OF_SUMS * mechanical),
        "potential_energy_integral": (potential, OF_SUMS * mechanical),
        **at_samples,
    }
    return {name: (np.asarray(values), np.asarray(sizes)) for name, (values, sizes) in found.items()}


def _until(terms: Floats, counts: Floats, least: float = 0.0) -> Sum:
    """Sums of the first terms, (counts, ...), and their rounding: of the sum of their sizes, or of `least`."""

    def summed(values: Floats) -> Floats:
        return np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)])[counts]

    return summed(terms), OF_SUMS * np.maximum(summed(np.abs(terms)), least)


def _energies_at(history: History, times: Floats) -> dict[str, Sum]:
    matter, g = history.matter, history.matter.acceleration
    x, v, w = history.sampled(times)
    turning = np.where(matter.fixed, 0.0, matter.moments) if matter.spheres.friction is not None else 0.0 * matter.radii
    rotation = (0.5 * turning * (w * w).sum(axis=2)).sum(axis=1)
    kinetic = (0.5 * matter.weights * (v * v).sum(axis=2)).sum(axis=1) + rotation
    heights = matter.weights * (x @ g)
    bonds = np.array([len(pairs) for pairs in history.bonds()])
    wells = matter.depth * bonds[np.searchsorted(history.times, times, side="right")]
    size = kinetic + np.abs(heights).sum(axis=1) + np.abs(wells)
    return {
        "kinetic_energy": (kinetic, OF_SUMS * size),
        "rotational_energy": (rotation, OF_SUMS * size),
        "potential_energy": (-heights.sum(axis=1) - wells, OF_SUMS * size),
    }


def _integrals(history: History, times: Floats) -> tuple[Floats, Floats, Floats]:
    """Kinetic and potential energy, integrated over time up to each of `times`; and the sum of all sizes."""
    matter, g = history.matter, history.matter.acceleration
    kinetic, potential, sizes = (np.zeros(times.size) for _ in range(3))
    for i in np.flatnonzero(~matter.fixed).tolist():
        known = np.array(history.times_of(i), dtype=np.float64)
        x, v, w = history.states_of(i)
        mass = matter.masses[i]

        def over(span: Floats, k: Floats, i=i, x=x, v=v, w=w, mass=mass) -> tuple[Floats, Floats]:  # type: ignore[no-untyped-def]
            """Integrals over a flight: of the kinetic energy, and of -m g.x."""
            still = energies(history, i, v[k], w[k])
            one = still * span + 0.5 * mass * ((v[k] @ g) * span**2 + (g @ g) * span**3 / 3)
            other = -mass * ((x[k] @ g) * span + (v[k] @ g) * span**2 / 2 + (g @ g) * span**3 / 6)
            return one, other

        whole = over(np.diff(known), np.arange(known.size - 1))
        last = np.searchsorted(known, times, side="right") - 1
        rest = over(times - known[last], last)
        for total, flights, more in zip((kinetic, potential), whole, rest, strict=True):
            total += np.append(0.0, np.cumsum(flights))[last] + more
            sizes += np.append(0.0, np.cumsum(np.abs(flights)))[last] + np.abs(more)
    starts = np.append(0.0, history.times)
    bonds = np.array([len(pairs) for pairs in history.bonds()], dtype=float)
    passed = np.append(0.0, np.cumsum(bonds[:-1] * np.diff(starts)))
    last = np.searchsorted(starts, times, side="right") - 1
    wells = matter.depth * (passed[last] + bonds[last] * (times - starts[last]))
    return kinetic, potential - wells, sizes + np.abs(wells)
