"""A trajectory as a whole: right ones are green, each planted fault turns its property red, frames that are lost."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from inspected import PLANTED, flying, red, told

from crosscheck.inspect.inspection import inspect_trajectory
from crosscheck.inspect.properties import properties
from crosscheck.inspect.property import CHAPTERS
from crosscheck.inspect.setting import Options
from crosscheck.trajectories.frames import Cut
from crosscheck.verdict import FALSE_ALARM_OF_A_RUN


def canonical(seed: int, **more: Any) -> Any:
    return PLANTED.ornstein_uhlenbeck(seed, **more)


@pytest.mark.parametrize("seed", range(4))
def test_a_right_trajectory_is_green(seed: int) -> None:
    """The levels add up to 1e-3 for a file, so that none of a few is red."""
    for inspection in PLANTED.inspections(canonical(seed, frames=120, number=40)):
        assert red(inspection) == set()
        assert inspection.false_alarms == pytest.approx(FALSE_ALARM_OF_A_RUN)


#: Faults of the table that show in particles of Ornstein and Uhlenbeck.
HERE = [fault for fault in PLANTED.FAULTS if "Ornstein-Uhlenbeck" in fault.kinds]


@pytest.mark.parametrize("fault", HERE, ids=lambda fault: fault.name)
def test_a_planted_fault_turns_its_property_red(fault: Any) -> None:
    run = fault.plant(canonical(3), np.random.default_rng(3))
    assert fault.property in red(PLANTED.inspected(run, "ensemble"))


#: Faults of positions and frames, which any trajectory shows.
EXACT = ("repeated frames", "time axis", "images of the box", "frames")


@pytest.mark.parametrize(
    "fault", [fault for fault in PLANTED.FAULTS if fault.property in EXACT], ids=lambda fault: fault.name
)
def test_a_fault_of_frames_turns_its_property_red_alone_of_the_exact_ones(fault: Any) -> None:
    run = canonical(1, frames=120, dt=0.05, number=20)
    run = PLANTED.wrapped(run) if "wrapped" in fault.name else run
    assert not red(PLANTED.inspected(run, "nothing")) & set(EXACT)
    wrong = fault.plant(run, np.random.default_rng(1))
    assert red(PLANTED.inspected(wrong, "nothing")) & set(EXACT) == {fault.property}


def test_exchanged_frames_with_their_times_written_anew() -> None:
    run = PLANTED._exchange_quietly(canonical(2, frames=150, dt=0.3, number=20), np.random.default_rng(1))
    assert "order of frames" in red(PLANTED.inspected(run, "nothing"))


def test_a_file_that_ends_within_a_frame_is_red() -> None:
    source = replace(flying(), remarks=(Cut("what follows step 7 is not read: it is cut."),))
    (judgement,) = told(inspect_trajectory(source), "frames")
    assert (judgement.outcome, judgement.measured) == ("fail", 1.0)
    assert "step 7" in judgement.note
    assert red(inspect_trajectory(replace(flying(), remarks=("it states no times.",)))) == set()


@pytest.mark.parametrize("field", ["positions", "velocities"])
def test_what_follows_a_number_that_is_none_is_not_looked_at(field: str) -> None:
    values = np.array(getattr(flying(), field))
    values[30, 4, 1] = np.inf
    seen = []
    inspection = inspect_trajectory(flying(**{field: values}), progress=lambda done, total: seen.append((done, total)))
    (judgement,) = told(inspection, "frames")
    assert judgement.outcome == "fail"
    assert f"Frame 30 (counted from 0) has {field} that are not finite, of particle 5" in judgement.note
    assert seen[-1] == (30, 60)


def test_nothing_is_said_of_a_file_whose_first_frame_cannot_be_used() -> None:
    positions = np.array(flying().positions)
    positions[0] = np.nan
    inspection = inspect_trajectory(flying(positions=positions))
    assert {found.unsaid for found in inspection.found if found.property.chapter != "file"} >= {"no frame can be used"}
    assert red(inspection) == {"frames"}


class Losing(type(flying())):  # type: ignore[misc]
    """A source that loses a particle, and whose frame 50 cannot be read."""

    def read(self, index: int) -> Any:
        if index == 50:
            raise ValueError("the disk is full")
        frame = super().read(index)
        if index < 40 or self.format == "whole":
            return frame
        keep = frame.ids != 7
        return frame._replace(ids=frame.ids[keep], positions=frame.positions[keep], velocities=frame.velocities[keep])


def test_lost_particles_and_frames_that_cannot_be_read() -> None:
    fields = vars(flying())
    (judgement,) = told(inspect_trajectory(Losing(**fields)), "frames")
    assert "Frame 40 (counted from 0) lacks 1 particles of the first, such as 7" in judgement.note
    (judgement,) = told(inspect_trajectory(Losing(**fields | {"format": "whole"})), "frames")
    assert "Frame 50 (counted from 0) cannot be read (the disk is full)" in judgement.note


def test_a_trajectory_of_one_frame_and_of_one_particle() -> None:
    for source in (flying(frames=1), flying(number=1, velocities=None), flying(frames=2, number=2), flying(frames=5)):
        for ensemble in ("equilibrium", "nve", "none"):
            inspection = inspect_trajectory(source, None, Options(ensemble=ensemble))
            assert red(inspection) == set()


def test_properties_are_found_by_being_there_in_the_order_of_chapters() -> None:
    found = properties()
    assert len({one.name for one in found}) == len(found)
    assert [CHAPTERS.index(one.chapter) for one in found] == sorted(CHAPTERS.index(one.chapter) for one in found)
    assert {one.chapter for one in found} == set(CHAPTERS)


def test_the_same_file_gives_the_same_numbers() -> None:
    one, other = (inspect_trajectory(PLANTED.source_of(canonical(1, frames=60))) for _ in range(2))
    assert [judgement.as_record() for judgement in one.judgements] == [
        judgement.as_record() for judgement in other.judgements
    ]


def test_how_many_frames_were_looked_at_is_told() -> None:
    positions = np.array(flying().positions)
    positions[7, 3] = np.inf
    for source, told_of in ((flying(), "60 of 60 frames"), (flying(positions=positions), "7 of 60 frames")):
        (one,) = (one for one in inspect_trajectory(source).found if one.property.name == "frames")
        assert told_of in " ".join(one.told.said)


@pytest.mark.parametrize("seed", [12, 26])
def test_a_crystal_whose_waves_keep_their_energies_is_not_red(seed: int) -> None:
    """By the scatter from frame to frame, the fourth moments of these are nine standard errors off."""
    inspection = inspect_trajectory(PLANTED.source_of(PLANTED.harmonic_crystal(seed)))
    assert red(inspection) == set()
    assert max(one.sigmas for one in told(inspection, "Maxwell's distribution") if one.uncertainty) > 6


@pytest.mark.parametrize("made", [PLANTED.ornstein_uhlenbeck, PLANTED.normals, PLANTED.harmonic_crystal])
def test_units_do_not_matter(made: Any) -> None:
    """Atoms in metres, seconds and kilograms, by powers of two: the same judgements, to the last digits."""
    length, time, mass = 2.0**-33, 2.0**-40, 2.0**-86
    run = made(2, 60)
    small = run._replace(
        times=run.times * time,
        positions=run.positions * length,
        velocities=run.velocities * length / time,
        masses=run.masses * mass,
        sides=run.sides * length,
        temperature=None if run.temperature is None else run.temperature * mass * (length / time) ** 2,
    )
    for how in ("nothing", "ensemble"):
        here, there = (PLANTED.inspected(one, how).judgements for one in (run, small))
        assert [(one.quantity, one.outcome) for one in here] == [(one.quantity, one.outcome) for one in there]
        for one, other in zip(here, there, strict=True):
            assert one.deviation == pytest.approx(other.deviation, rel=1e-6, abs=1e-9), one.quantity
