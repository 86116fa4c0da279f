"""`refimpl.stepping.forces.grains`: rough soft grains beside LAMMPS's `gran/hooke/history`."""

from crosscheck.checks.performance.races import Race
from crosscheck.checks.performance.stepping_races import grains_race

RACES = (grains_race(10_000),)
SHORT = (grains_race(108, steps=10, settling=0.05),)


def bench_grains(race: Race, side: str, read_out) -> None:
    read_out(race, side)
