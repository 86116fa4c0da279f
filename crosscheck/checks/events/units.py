"""A scene of hard spheres in other units of length and time: the same motion, by other numbers.

Where sides, diameters and times are near 1, a bound that compares a length with 1 and one that compares it with 0 are
the same.
"""

from __future__ import annotations

from typing import Any

from crosscheck.scene import Scene

#: Powers of length and time in what a scene's tables hold, by the name of the entry; what is not here has no unit of
#: either.
_POWERS = {
    "duration": (0, 1), "interval": (0, 1), "contact_duration": (0, 1),
    "positions": (1, 0), "lengths": (1, 0), "diameter": (1, 0), "radius": (1, 0), "amplitude": (1, 0),
    "velocities": (1, -1), "velocity": (1, -1), "speed": (1, -1), "acceleration": (1, -2),
    "angular_velocities": (0, -1), "angular_velocity": (0, -1), "frequency": (0, -1),
    "depth": (2, -2), "temperature": (2, -2),
}  # fmt: skip


def in_units(scene: Scene, length: float, time: float) -> Scene:
    """The scene with all lengths so many times as large, and all times; masses stay.

    scene: of hard spheres, with an explicit start. length, time: the factors, > 0.
    """

    def scaled(entry: Any, factor: float) -> Any:
        if isinstance(entry, dict):
            return {name: scaled(part, _factor(name)) for name, part in entry.items()}
        if isinstance(entry, list | tuple):
            return tuple(scaled(part, factor) for part in entry)
        return entry * factor if isinstance(entry, float) and factor != 1.0 else entry

    def _factor(name: str) -> float:
        of_length, of_time = _POWERS.get(name, (0, 0))
        return float(length**of_length * time**of_time)

    return Scene.model_validate(scaled(scene.model_dump(), 1.0))
