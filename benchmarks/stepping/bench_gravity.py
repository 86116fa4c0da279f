"""`refimpl.stepping.forces.gravity` beside REBOUND: few bodies on circles, and clouds."""

from crosscheck.checks.performance.races import Race
from crosscheck.checks.performance.stepping_races import gravity_race

#: A turn of few bodies is a million steps or more, from which on they are kept in registers.
RACES = (
    *(gravity_race(number, pairs=2e8) for number in (2, 3, 8, 16)),
    *(gravity_race(number, pairs=2e8) for number in (64, 256, 1024, 4096)),
)
SHORT = (gravity_race(3, pairs=1e3), gravity_race(64, pairs=1e4))


def bench_gravity(race: Race, side: str, read_out) -> None:
    read_out(race, side)
