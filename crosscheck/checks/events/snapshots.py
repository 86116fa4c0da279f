"""Snapshots of a dilute gas of disks: long density waves, and clusters of neighbours."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, full
from crosscheck.checks.events.driven import OBSERVABLES, run_whole
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references.structure import neighbour_share, structure_factor
from crosscheck.scene import Box, Floats, HardSpheres, Lattice, Output, Scene
from crosscheck.scene.overlaps import wrapped
from crosscheck.statistics import correlated_mean
from crosscheck.verdict import Judged, statistical

#: Number of disks and their number per area; distance of centres, in diameters, up to which two are neighbours.
_NUMBER, _DENSITY, _NEAR = 200, 0.1, 1.2
#: Wave vectors, in units of 2 pi over the length of the box.
_WAVES = ((1, 0), (0, 1), (1, 1), (1, -1), (2, 0), (0, 2))


def _judge_snapshots(laboratory: Laboratory, judge: Callable[[Floats, float], Judged]) -> Judged:
    """Runs the gas; judge: of the positions at the samples, (samples, N, 2), and the length of the box."""
    scene = Scene(
        name="snapshots",
        dimension=2,
        duration=50000.0,
        hard_spheres=HardSpheres(),
        box=Box(density=_DENSITY),
        initial=Lattice(kind="lattice", structure="square", number=_NUMBER, temperature=1.0, seed=laboratory.seed()),
        output=Output(interval=10.0, observables=OBSERVABLES, trajectory=True),
    )
    run = run_whole(laboratory, scene)
    lengths = scene.lengths()
    assert lengths is not None
    positions = run["positions"][10:]
    return judge(positions, lengths[0])


def _judge_modes(positions: Floats, length: float) -> Judged:
    """The mean square of the Fourier components of the density."""
    measured, expected = [], []
    for vector in _WAVES:
        wave = 2 * math.pi / length * np.array(vector)
        amplitude = np.exp(-1j * (positions @ wave)).sum(axis=1)
        measured.append(np.abs(amplitude) ** 2 / _NUMBER)
        expected.append(float(structure_factor(_DENSITY, float(np.hypot(*wave)))))
    theory = np.array(expected)
    mean = correlated_mean((np.array(measured) / theory[:, None]).mean(axis=0) * theory.mean())
    k = np.array([2 * math.pi / length * math.hypot(*vector) for vector in _WAVES])
    means = [correlated_mean(one) for one in measured]
    figure = Figure(
        "Snapshots: structure factor",
        "k",
        "<|n(k)|^2>/N",
        series=(
            Series("snapshots", k.tolist(), [m.value for m in means], [m.error for m in means]),
            Series("compressibility", sorted(k.tolist()), structure_factor(_DENSITY, np.sort(k)).tolist(), theory=True),
        ),
    )
    return statistical(
        f"<|n(k)|^2>/N, mean of {len(_WAVES)} long waves",
        mean.value,
        mean.error,
        float(theory.mean()),
        0.0,
        f"correlated series of {len(positions)} snapshots; theory off by 1/N: fixed number",
        samples=mean,
        doubt=float(theory.mean()) / _NUMBER,
        needed=0.06,
        note="1 for an ideal gas",
        figures=(figure,),
    )


def _judge_clusters(positions: Floats, length: float) -> Judged:
    """Clusters of disks that are linked by neighbours, and the share of disks that have one."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    lengths = np.full(2, length)
    crowded, sizes = np.zeros(len(positions)), np.zeros(_NUMBER + 1)
    for sample, x in enumerate(positions):
        pairs = cKDTree(wrapped(x, lengths), boxsize=lengths).query_pairs(_NEAR, output_type="ndarray")
        graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(_NUMBER, _NUMBER))
        labels = connected_components(graph, directed=False)[1]
        members = np.bincount(np.bincount(labels), minlength=_NUMBER + 1)
        sizes += members
        crowded[sample] = 1 - members[1] / _NUMBER
    mean = correlated_mean(crowded)
    expected = neighbour_share(_DENSITY * (_NUMBER - 1) / _NUMBER, _NEAR)
    largest = int(np.flatnonzero(sizes)[-1])
    count = sizes[1 : largest + 1] / len(positions)
    figure = Figure(
        "Snapshots: clusters",
        "size",
        "number of clusters",
        y_scale="log",
        series=(Series(f"linked within {_NEAR}", list(map(float, range(1, largest + 1))), count.tolist()),),
    )
    return statistical(
        f"share of disks with another within {_NEAR} diameters",
        mean.value,
        mean.error,
        expected,
        0.0,
        f"correlated series of {len(positions)} snapshots; third order in the density, about 1 %, left out",
        samples=mean,
        doubt=0.01 * expected,
        needed=0.06,
        note=f"largest cluster {largest}",
        figures=(figure,),
    )


CHECKS = (
    Check(
        name="events/snapshots",
        title="Snapshots of a dilute gas of disks: long density waves against the compressibility, and clusters",
        equation="<|n(k)|^2>/N -> 1/(d(eta Z)/deta) for k -> 0; share with a neighbour: n int g - (n^2/2) int int e",
        criterion="standard error of the correlated series of snapshots",
        citation="J.-P. Hansen and I. R. McDonald, Theory of Simple Liquids, sections 2.6, 3.5; S. Luding, Phys. Rev. "
        "E 63, 042201 (2001)",
        judge=_judge_snapshots,
        faults=(
            (
                "modes",
                Fault(
                    "small-disks",
                    "events/prediction.py",
                    "return diameter",
                    "return 0.5 * diameter",
                    "disks collide at half their diameter",
                ),
            ),
        ),
        variants=full(modes=_judge_modes, clusters=_judge_clusters),
        needs=Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=frozenset({"box.boundaries=periodic", "dimension=2"}),
            observables=frozenset({*OBSERVABLES, "positions", "velocities"}),
        ),
    ),
)
