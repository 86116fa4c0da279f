"""`refimpl.lattice`: bit planes beside the evolver that moves bytes and a copy of memory; two threads beside one."""

from crosscheck.checks.performance.lattice_races import lattice_race, threads_race
from crosscheck.checks.performance.races import Race

RACES = (
    *(lattice_race(model, 4096, steps=64) for model in ("hpp", "fhp1", "fhp_saturated")),
    lattice_race("fhp1", 512, steps=4096),
    threads_race("fhp1", 4096, steps=64),
)
SHORT = (lattice_race("hpp", 64, steps=4), threads_race("fhp1", 64, steps=4))


def bench_lattice(race: Race, side: str, read_out) -> None:
    read_out(race, side)
