"""LAMMPS for Lennard-Jones particles with other pair styles and skins: engines of the benchmarks.

Each class runs in a worker process of its own, so it may set what `crosscheck.engines.lammps` has as constants.
"""

from __future__ import annotations

from crosscheck.engines.lammps import LammpsEngine, particles
from crosscheck.engines.protocol import Run
from crosscheck.scene import Method, Scene

#: Skins among which the best one is, in sigma.
SKINS = (0.2, 0.25, 0.3, 0.35, 0.4)
#: Pair styles, by their names in class names.
STYLES = {"Opt": "lj/cut/opt", "Omp": "lj/cut/omp"}


def engine_name(style: str, skin: float) -> str:
    """The name of the class with this style, a key of `STYLES`, and this skin, one of `SKINS`."""
    return f"{style}{round(100 * skin)}"


def _engine(style: str, skin: float) -> type[LammpsEngine]:
    class Tuned(LammpsEngine):
        """LAMMPS with this pair style and skin."""

        name = f"lammps-{engine_name(style, skin)}"
        arguments = ("-package", "omp", "1")

        def run(self, scene: Scene, method: Method) -> Run:
            particles._SKIN = skin
            particles._LJ_STYLES["truncated"] = STYLES[style]
            return super().run(scene, method)

    return Tuned


globals().update({engine_name(style, skin): _engine(style, skin) for style in STYLES for skin in SKINS})
