"""`refimpl.stepping.forces.lennard_jones` beside LAMMPS's pair styles, each with the best of several skins."""

from pathlib import Path

from peers.lammps_melt import SKINS, STYLES, engine_name

from crosscheck.checks.performance.races import Race, best_of, engine_side
from crosscheck.checks.performance.stepping_races import lennard_jones_race
from crosscheck.checks.stepping.fluids import STEP

_FILE = Path(__file__).parents[1] / "peers" / "lammps_melt.py"
_TUNED = tuple(
    best_of(
        f"LAMMPS {style}",
        tuple(engine_side(f"skin {skin}", f"{_FILE}:{engine_name(name, skin)}", STEP) for skin in SKINS),
    )
    for name, style in STYLES.items()
)
RACES = tuple(lennard_jones_race(number, _TUNED) for number in (4000, 32000))
SHORT = (lennard_jones_race(500, (engine_side("LAMMPS", "lammps", STEP),), steps=10),)


def bench_lennard_jones(race: Race, side: str, read_out) -> None:
    read_out(race, side)
