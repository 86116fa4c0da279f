"""What is measured at events, against balances of what is conserved, and against other ways to the same number."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from event_scenes import full, scatter, thermal
from numpy.testing import assert_array_equal

from refimpl.events.model import Face, Floats, Friction
from refimpl.events.simulation import Simulation

EPS = float(np.finfo(float).eps)
GRAVITY = (0.1, -1.0)


def heap(fields: tuple[int, int] | None = (3, 4), number: int = 50, *, measured: bool = True) -> Simulation:
    """Rough disks of two sizes and masses fall on a floor that gives them energy; periodic sideways."""
    rng = np.random.default_rng(11)
    small = np.arange(number) < number // 2
    rough = Friction(-0.3, 0.5, 0.4)
    model = full(
        number, lengths=(9.0, 12.0), periodic=(True, False), acceleration=GRAVITY, restitution=0.9, friction=rough,
        diameters=np.where(small, 0.6, 1.0), masses=np.where(small, 0.5, 2.0),
        faces=[None, None, Face(0.9, velocity=0.8, friction=rough), Face(0.8, friction=rough)],
    )  # fmt: skip
    x = scatter(rng, model.lengths, model.periodic, np.where(small, 0.6, 1.0), number)
    v, spins = thermal(rng, number, 2), rng.normal(size=(number, 1))
    return Simulation(model, x, v, spins, tallies=measured, fields=fields, trace=measured)


def momentum(simulation: Simulation) -> Floats:
    return simulation.masses() @ simulation.state().velocities


def rounding(simulation: Simulation) -> float:
    """Of a sum over all events, each rounded by EPS, up or down, of all energy and momentum there was or came in."""
    walls = simulation.tallies()["wall_impulse"]
    scale = simulation.kinetic_energy() + abs(simulation.potential_energy()) + np.abs(walls).sum()
    return 4 * float(np.sqrt(simulation.events) * EPS * scale)


@pytest.fixture(scope="module")
def ran() -> tuple[Simulation, float, Floats]:
    """After some 5000 events, with the energy and the momentum of the start."""
    simulation = heap()
    energy, start = simulation.kinetic_energy() + simulation.potential_energy(), momentum(simulation)
    simulation.run(until=25.0)
    assert simulation.interactions > 2_000
    assert not simulation.stopped
    return simulation, energy, start


def test_energy_balance(ran: Any) -> None:
    simulation, energy, _ = ran
    found = simulation.tallies()
    gained = simulation.kinetic_energy() + simulation.potential_energy() - energy
    assert found["dissipated_energy"] > 10
    assert found["wall_energy"][2] > 10
    assert abs(found["wall_energy"].sum() - found["dissipated_energy"] - gained) < rounding(simulation)


def test_momentum_balance(ran: Any) -> None:
    simulation, _, start = ran
    weight = simulation.masses().sum() * np.array(GRAVITY)
    given = -(momentum(simulation) - start - weight * simulation.time)
    found = simulation.tallies()["wall_impulse"]
    assert np.abs(found.sum(axis=0) - given).max() < rounding(simulation)
    assert (found[:2] == 0).all()
    assert found[2, 1] < 0 < found[3, 1]


def test_counts(ran: Any) -> None:
    simulation, *_ = ran
    found, who = simulation.tallies(), [other for *_, other in simulation.trace()]
    assert found["collisions"] == simulation.collisions == sum(other >= 0 for other in who)
    assert found["wall_collisions"].tolist() == [who.count(-1 - face) for face in range(4)]


def test_who_is_not_seen_in_time_is_struck_too_deep(ran: Any) -> None:
    simulation, *_ = ran
    quantum = 32 * EPS * max(simulation.model.lengths) / 0.6  # of the smallest grains
    assert 0 < simulation.tallies()["deepest_overlap"] < quantum
    # a pair that has got into each other by 1e-10, which passes as the input's rounding, collides there
    model = full(2, lengths=(9.0, 12.0), periodic=(True, False), restitution=0.9)
    x, v = [[1.0, 6.0], [2.0 - 1e-10, 6.0]], [[1.0, 0.0], [-1.0, 0.0]]
    late = Simulation(model, x, v, tallies=True, fields=(3, 4), trace=True)
    late.run(collisions=1)
    assert late.tallies()["deepest_overlap"] == pytest.approx(1e-10, rel=1e-4)


def test_integrals_of_the_energies() -> None:
    """Between two events they are parabolas: Gauss's rule of two points is exact."""
    scout = heap()
    scout.run(until=8.0)
    times = [0.0, *(time for time, *_ in scout.trace()), 8.0]
    simulation, kinetic, potential = heap(), 0.0, 0.0
    for start, end in itertools.pairwise(times):
        for point in (0.5 - 0.75**0.5 / 3, 0.5 + 0.75**0.5 / 3):
            simulation.run(until=max(start + point * (end - start), simulation.time))
            kinetic += 0.5 * (end - start) * simulation.kinetic_energy()
            potential += 0.5 * (end - start) * simulation.potential_energy()
    simulation.run(until=8.0)
    for found in (simulation.tallies(), scout.tallies()):
        assert abs(found["kinetic_energy_integral"] - kinetic) < 8 * rounding(simulation)
        assert abs(found["potential_energy_integral"] - potential) < 8 * rounding(simulation)


def test_virial() -> None:
    """d/dt sum x.p = 2 K + sum x.F + collisions + walls; smooth disks of one size touch walls at known places."""
    rng, number, side = np.random.default_rng(2), 40, 9.0
    model = full(
        number, lengths=(side, side), periodic=(False, False), acceleration=GRAVITY, restitution=0.9,
        faces=[Face(0.9, velocity=0.5), Face(), Face(velocity=0.3), Face(0.9)],
    )  # fmt: skip
    x = scatter(rng, model.lengths, model.periodic, 1.0, number)
    simulation = Simulation(model, x, thermal(rng, number, 2), tallies=True, fields=(3, 3), trace=True)

    def moment() -> float:
        _, x, v, _ = simulation.state()
        return float(np.sum(simulation.masses() @ (x * v)))

    start = moment()
    simulation.run(until=20.0)
    found = simulation.tallies()
    touch = np.array([0.5, side - 0.5])
    given = sum(touch @ found["wall_impulse"][2 * axis : 2 * axis + 2, axis] for axis in range(2))
    expected = moment() - start - 2 * found["kinetic_energy_integral"] + found["potential_energy_integral"] + given
    assert found["collisional_virial"] > 100
    assert abs(found["collisional_virial"] - expected) < 2 * side * rounding(simulation)


# -- fields ---------------------------------------------------------------------------------------


def divergence(flux: Floats) -> Floats:
    """Out of each cell through its faces, from those through the lower ones."""
    return sum(np.roll(flux[axis], -1, axis=axis) - flux[axis] for axis in range(len(flux)))


def largest(values: Floats) -> float:
    return float(np.abs(values).max())


@pytest.mark.parametrize("shape", [(3, 4), (2, 2), (1, 5), (8, 1)])
def test_budgets_of_cells(shape: tuple[int, int]) -> None:
    """Of cells of one and of several cells of the event loop; of two along a period, which are neighbours twice."""
    simulation = heap(shape)
    simulation.run(until=15.0)
    f, g, error = simulation.fields(), np.array(GRAVITY), rounding(simulation)
    changes = {name: f[f"field_final_{name}"] - f[f"field_initial_{name}"] for name in ("mass", "momentum", "energy")}
    assert f["field_mass"].shape == shape
    assert f["field_flux_momentum"].shape == (2, *shape, 2)
    assert (f["field_flux_momentum"][1, :, 0] == 0).all()
    assert largest(f["field_flux_momentum"]) > 1
    assert largest(changes["mass"] + divergence(f["field_flux_mass"])) < error
    pulled = f["field_mass"][..., None] * g + f["field_wall_momentum"]
    assert largest(changes["momentum"] + divergence(f["field_flux_momentum"]) - pulled) < error
    work = f["field_momentum"] @ g + f["field_wall_energy"] - f["field_dissipation"]
    assert largest(changes["energy"] + divergence(f["field_flux_energy"]) - work) < error


def test_coarse_cells_are_sums_of_fine_ones() -> None:
    """So each transfer goes through the face it belongs to: of two cells along a period there are two to confuse."""
    rng, number = np.random.default_rng(6), 40
    model = full(number, lengths=(9.0, 12.0), periodic=(True, True), restitution=0.9)
    x, v = scatter(rng, model.lengths, model.periodic, 1.0, number), thermal(rng, number, 2)
    coarse, fine = (Simulation(model, x, v, fields=(cells, cells), trace=True) for cells in (2, 4))
    for simulation in (coarse, fine):
        simulation.run(until=8.0)
    assert_array_equal(coarse.state().positions, fine.state().positions)
    error, found, parts = 8 * rounding(coarse), coarse.fields(), fine.fields()
    for name, values in found.items():
        if name.startswith("field_flux"):
            pairs = [parts[name][0, ::2, ::2] + parts[name][0, ::2, 1::2],
                     parts[name][1, ::2, ::2] + parts[name][1, 1::2, ::2]]  # fmt: skip
            assert largest(values - np.stack(pairs)) < error, name
        else:
            blocks = parts[name].reshape(2, 2, 2, 2, *values.shape[2:])
            assert largest(values - blocks.sum(axis=(1, 3))) < error, name


def test_sums_of_fields(ran: Any) -> None:
    simulation, _, start = ran
    f, found, span, mass = simulation.fields(), simulation.tallies(), simulation.time, simulation.masses().sum()
    error = span * rounding(simulation)
    assert abs(f["field_mass"].sum() - mass * span) < error
    assert abs(f["field_kinetic"].sum() + f["field_rotational"].sum() - found["kinetic_energy_integral"]) < error
    assert abs(f["field_dissipation"].sum() - found["dissipated_energy"]) < error
    assert abs(f["field_wall_energy"].sum() - found["wall_energy"].sum()) < error
    assert largest(f["field_wall_momentum"].sum(axis=(0, 1)) + found["wall_impulse"].sum(axis=0)) < error
    assert f["field_collisions"].sum() == found["collisions"]
    assert f["field_rotational"].sum() > 1
    shift = simulation.masses() @ (simulation.state().positions - heap().state().positions)
    assert largest(f["field_momentum"].sum(axis=(0, 1)) - shift) < error
    for name, final in (("mass", mass), ("momentum", momentum(simulation)), ("energy", simulation.kinetic_energy())):
        assert largest(f[f"field_final_{name}"].sum(axis=(0, 1)) - final) < error
    assert largest(f["field_initial_momentum"].sum(axis=(0, 1)) - start) < error


@pytest.fixture
def sticky(plain_module: Any) -> Any:
    """Rough disks with wells, in a periodic box; as plain Python, for some thousand events."""
    events, simulation = (plain_module(f"refimpl.events.{name}") for name in ("model", "simulation"))

    def make() -> Simulation:
        rng, number = np.random.default_rng(4), 30
        rough, well = events.Friction(-0.3, 0.5, 0.4), events.Well(1.0, 1.5)
        model = events.hard_spheres(lengths=(9.0, 9.0), periodic=(True, True), friction=rough, well=well)
        x = scatter(rng, model.lengths, model.periodic, 1.0, number)
        v, spins = thermal(rng, number, 2), rng.normal(size=(number, 1))
        return simulation.Simulation(model, x, v, spins, tallies=True, fields=(3, 3))

    return make


def test_rotation_of_grains_with_wells(sticky: Any) -> None:
    """Most spells end at the edge of a well, where no spin changes: they count all the same."""
    simulation = sticky()
    simulation.run(until=10.0)
    f, found = simulation.fields(), simulation.tallies()
    assert simulation.interactions > 2 * simulation.collisions > 100
    assert f["field_rotational"].sum() > 1
    error = simulation.time * rounding(simulation)
    assert abs(f["field_kinetic"].sum() + f["field_rotational"].sum() - found["kinetic_energy_integral"]) < error


@pytest.mark.parametrize("which", ["heap", "sticky"])
def test_measurements_begin_anew_after_a_restart(sticky: Any, which: str) -> None:
    """The motion goes on to the last bit, bonds too; both parts together are what the whole measures, to rounding."""
    make = {"heap": heap, "sticky": sticky}[which]
    whole, before, after = make(), make(), make()
    before.run(until=3.0)
    after.resume(before.snapshot())
    first, again = before.fields() | before.tallies(), after.fields() | after.tallies()
    for name, values in again.items():
        if name not in ("collisions", "events") and not name.startswith(("field_initial", "field_final")):
            assert not np.any(values), name
        if name.startswith("field_initial"):
            assert_array_equal(values, first[name.replace("initial", "final")])
    for simulation in (whole, after):
        simulation.run(until=5.0)
    for mine, yours in zip(after.state(), whole.state(), strict=True):
        assert_array_equal(mine, yours)
    assert after.potential_energy() == whole.potential_energy()
    second, expected = after.fields() | after.tallies(), whole.fields() | whole.tallies()
    for name, values in expected.items():
        if name.startswith("field_final"):
            assert_array_equal(second[name], values)
        elif name not in ("collisions", "events", "deepest_overlap") and not name.startswith("field_initial"):
            error = 5 * whole.time * rounding(whole)
            assert largest(np.asarray(first[name] + second[name] - values)) < error, name


def test_to_look_changes_nothing() -> None:
    """Sums are the same to rounding, the motion to the last bit."""
    whole, watched = heap(), heap()
    whole.run(until=5.0)
    for end in np.linspace(0, 5, 50):
        watched.run(until=float(end))
        watched.fields()
        watched.tallies()
    assert watched.trace() == whole.trace()
    for name, values in whole.fields().items():
        assert largest(watched.fields()[name] - values) < 5 * rounding(whole), name


def test_nothing_was_measured() -> None:
    plain = heap(fields=None, measured=False)
    for call in (plain.tallies, plain.fields, plain.trace, plain.operation_counts):
        with pytest.raises(ValueError, match="give "):
            call()


@pytest.mark.parametrize(("shape", "message"), [((3,), "2 positive"), ((0, 2), "2 positive"), ((12, 2), "axis 0")])
def test_refused_shapes(shape: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        heap(shape)
