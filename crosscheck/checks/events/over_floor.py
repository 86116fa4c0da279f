"""Scenes of grains over a floor, one or many that do not hit each other, and figures of their impacts."""

from __future__ import annotations

import numpy as np

from crosscheck.engines.protocol import Run
from crosscheck.figure import Figure, Histogram, Series
from crosscheck.references import floors
from crosscheck.scene import Box, Face, Floats, HardSpheres, Output, Scene, explicit

#: The face y-, the floor, among the faces.
FLOOR = 2
#: Words and observables that all scenes over a floor need of an engine.
FLOOR_WORDS = frozenset(
    {
        "dimension=2",
        "box.boundaries=hard",
        "box.boundaries=periodic",
        "box.faces",
        "box.faces.open",
        "hard_spheres.diameter",
    }
)
FLOOR_OBSERVABLES = frozenset({"wall_collisions", "wall_energy", "positions", "velocities"})
#: All scenes but one have g = 1, and floors with A omega = V0 = 1 where the floor vibrates fast.
GRAVITY = 1.0


def over_floor(
    floor: Face, heights: Floats, velocities: Floats, duration: float, interval: float, *, gravity: bool = True,
    seed: int | None = None, width: float = 1.0, diameter: float = 0.0,
) -> Scene:  # fmt: skip
    """Point grains, which do not hit each other, above the floor y = 0; nothing above, periodic to the sides.

    floor: its motion and impact rule. heights, velocities: at the start, (N,). diameter: of grains that are no points,
    whose heights are those of their lowest points. duration: of the run. interval: between
    samples. gravity: g = 1, or none. seed: of random phases. width: of the box; a narrow one keeps the rounding of
    places small, in a wide one many grains are apart.
    """
    number = heights.size
    places = np.stack([width * (np.arange(number) + 0.5) / number, heights + diameter / 2], axis=1)
    return Scene(
        name="grains-on-a-floor",
        dimension=2,
        duration=duration,
        seed=seed,
        acceleration=(0.0, -GRAVITY) if gravity else None,
        hard_spheres=HardSpheres(diameter=diameter),
        box=Box(
            lengths=(width, max(2.0, float(heights.max()) + diameter)),
            boundaries=("periodic", "hard"),
            faces={"y-": floor, "y+": Face(open=True)},
        ),
        initial=explicit(places, np.stack([np.zeros(number), velocities], axis=1)),
        output=Output(interval=interval, observables=("wall_collisions", "wall_energy"), trajectory=True),
    )


def vertical(run: Run) -> tuple[Floats, Floats]:
    """Heights and vertical velocities of `run` at its samples, both (samples, N)."""
    return run["positions"][:, :, 1], run["velocities"][:, :, 1]


def plate_figures(plates: Floats, u: float, label: str) -> tuple[Figure, ...]:
    """Density of the wall's velocity at the impact, with the two laws.

    plates: velocities of the wall, V0 = 1, (impacts,). u: of the grains. label: of the measured curve.
    """
    edges = np.linspace(-1.0, 1.0, 41)
    heights = np.histogram(plates, edges, density=True)[0]
    fine = np.cos(np.linspace(0.02, 0.98, 100) * np.pi)[::-1]
    return (
        Figure(
            f"velocity of the wall that grains of u = {u:g} meet", "V/V0", "probability density", "linear", "linear",
            (
                Histogram(label, edges.tolist(), heights.tolist()),
                Series("uniform", fine.tolist(), floors.uniform_phase_density(fine, 1.0).tolist(), theory=True),
                Series("flux", fine.tolist(), floors.flux_phase_density(fine, u, 1.0).tolist(), theory=True),
            ),
        ),
    )  # fmt: skip
