"""Energy of fluids of square wells over many events, and the pairs inside; diameter, mass and depth are 1."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full
from crosscheck.checks.events.square_wells import NEEDS_STATES, OBSERVABLES, fluid
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.references.square_well import WIDTH
from crosscheck.scene import Floats, Output
from crosscheck.scene.overlaps import wrapped
from crosscheck.verdict import Judged, round_off, worst

SAMPLES, INTERVAL = 40, 2.5


class _Fluid(NamedTuple):
    """number: of particles; density per sigma^d; temperature at the start; depth, negative: a shoulder."""

    dimension: int
    number: int
    density: float
    temperature: float
    depth: float


def _pairs_inside(positions: Floats, length: float) -> int:
    """Pairs closer than the range of the well, nearest images; positions (N, d)."""
    from scipy.spatial import cKDTree

    lengths = np.full(positions.shape[1], length)
    tree = cKDTree(wrapped(positions, lengths), boxsize=lengths)
    return len(tree.query_pairs(WIDTH, output_type="ndarray"))


def _judge(laboratory: Laboratory, state: _Fluid) -> Judged:
    """Total energy at every sample, and the wells' against the pairs counted in the recorded positions."""
    dimension, number, density, temperature, depth = state
    scene = fluid(dimension, number, density, temperature, laboratory.seed(), depth)
    scene = scene.changed(
        duration=SAMPLES * INTERVAL,
        output=Output(interval=INTERVAL, observables=OBSERVABLES, trajectory=True),
    )
    run = laboratory.run(scene, EVENT_DRIVEN)
    kinetic, potential = run["kinetic_energy"], run["potential_energy"]
    lengths = scene.lengths()
    assert lengths is not None
    counted = np.array([_pairs_inside(frame, float(lengths[0])) for frame in run["positions"]])
    total = kinetic + potential
    name = f"{dimension}D, depth {depth:g}"
    events = float(run["events"][-1])
    change = abs(total - total[0]).max()
    # a pair that meets has a few times the mean kinetic energy, hence 4 of its roundings per event and partner
    unit = EPSILON * (kinetic.max() / number + abs(depth))
    energy = round_off(
        "largest change of the energy",
        float(change),
        8 * events * unit,
        "four roundings of the mean energy per event and partner",
        figures=(
            Figure(
                "energy a particle", "t", "energy", series=(
                    Series(f"{name}: kinetic", run["time"].tolist(), (kinetic / number).tolist()),
                    Series(f"{name}: wells", run["time"].tolist(), (potential / number).tolist()),
                    Series(f"{name}: sum", run["time"].tolist(), (total / number).tolist(), theory=True),
                ),
            ),
        ),
    )  # fmt: skip
    wells = round_off(
        "largest difference between the wells' energy and -depth x pairs inside",
        float(abs(potential + depth * counted).max()),
        0.5 * abs(depth),
        "a whole number of pairs: none may be missing",
    )
    return worst([energy, wells], f"{events:.3g} events, {counted.min()} to {counted.max()} pairs inside")


CHECKS = (
    Check(
        name="events/square-well-energy",
        title="Square wells: the energy over many events, and the pairs inside",
        equation="K + U = const, U = -depth x number of pairs closer than 1.5",
        criterion="change <= 8 events x rounding of the mean energy; U exact, pairs counted in the positions",
        citation="Alder & Wainwright, J. Chem. Phys. 31, 459 (1959)",
        judge=_judge,
        variants=full(
            **{
                "2d": _Fluid(2, 196, 0.4, 1.0, 1.0),
                "3d": _Fluid(3, 256, 0.5, 1.0, 1.0),
                "3d-shoulder": _Fluid(3, 256, 0.3, 1.0, -1.0),
            }
        ),
        needs=NEEDS_STATES,
        faults=(
            (
                "3d",
                Fault(
                    "bond-kept",
                    "events/rules.py",
                    "            bonds[i, 0] -= 1\n            return",
                    "            bonds[i, 0] -= i % 50 != 7\n            return",
                    "some particles keep the bond with a partner that has left the well",
                ),
            ),
            (
                "3d-shoulder",
                Fault(
                    "edge-gains-energy",
                    "events/rules.py",
                    "return math.copysign(math.sqrt(square), gn), not inside",
                    "return math.copysign(math.sqrt(square), gn) * 1.0000001, not inside",
                    "a pair that passes the edge of its well gains 1e-7 of its speed",
                ),
            ),
        ),
    ),
)
