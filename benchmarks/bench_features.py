"""What each feature costs, in time and bytes, beside the bare scene."""

from crosscheck.checks.performance.feature_races import (
    event_features,
    grains_features,
    gravity_features,
    lattice_features,
    lennard_jones_features,
)
from crosscheck.checks.performance.races import Race

RACES = (gravity_features(), lennard_jones_features(), grains_features(), event_features(), lattice_features())
SHORT = (gravity_features(16, 20), lattice_features(64, 64))


def bench_features(race: Race, side: str, read_out) -> None:
    read_out(race, side)
