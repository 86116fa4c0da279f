"""`refimpl.stepping.schemes` beside each other, where the force costs next to nothing."""

from crosscheck.checks.performance.races import Race
from crosscheck.checks.performance.stepping_races import schemes_race

RACES = (schemes_race(1000, steps=5000),)
SHORT = (schemes_race(10, steps=10),)


def bench_schemes(race: Race, side: str, read_out) -> None:
    read_out(race, side)
