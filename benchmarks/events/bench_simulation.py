"""`refimpl.events.simulation`: gases of hard particles, the schedulers beside each other.

Programs that no registry offers join where environment variables name them: `PROGRAMS` of `event_races`.
"""

from crosscheck.checks.performance.event_races import GASES, gas_race
from crosscheck.checks.performance.races import Race

RACES = (
    *(gas_race(gas, number, 200_000) for gas in GASES[:2] for number in (1372, 10_976, 97_556)),
    gas_race(GASES[0], 1_000_188, 500_000, settling=4.0, most=2, turns=3),
    *(gas_race(gas, 10_976, 200_000) for gas in GASES[2:]),
)
SHORT = tuple(gas_race(gas, 108, 100, settling=1.0) for gas in GASES)


def bench_events(race: Race, side: str, read_out) -> None:
    read_out(race, side)
