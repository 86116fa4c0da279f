"""The fast algorithm against the naive one: the same partners, at the same times to rounding, event by event.

Trajectories are chaotic: the naive one starts again from the fast one's state every N/2 events. A collision multiplies
rounding by two free paths in diameters: up to 100 in these scenes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from event_scenes import full, scatter, spheres, thermal
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from refimpl.events.model import (
    AMPLITUDE,
    FREQUENCY,
    PHASE,
    Cylinder,
    Face,
    Friction,
    HardSpheres,
    Oscillation,
    RandomPhase,
    Well,
    hard_spheres,
)
from refimpl.events.naive import Naive
from refimpl.events.simulation import Simulation

#: A wrong prediction is off by a share of the time between collisions, 0.1 or more; rounding, 1e-14 with times up to
#: some hundreds, by 1e-14 100^k after k collisions in one window: one for most particles, three for the unlucky.
WORST, TYPICAL = 1e-7, 1e-12
#: A window ends at this time, where everybody has left through an open side.
LONGEST = 30.0
#: A failing scene is not made smaller: another scene is another failure.
AS_DRAWN = (Phase.explicit, Phase.generate)


def naive_from(fast: Simulation) -> Naive:
    """The naive algorithm from the present of the fast one; its clock starts at 0."""
    model, state = fast.model, fast.state()
    if model.walls is not None:
        numbers = model.walls.numbers.copy()
        numbers[:, PHASE] += numbers[:, FREQUENCY] * fast._now
        model = model._replace(walls=model.walls._replace(numbers=numbers))
    lengths = np.array(model.lengths)
    x = np.where(model.periodic, state.positions % lengths, state.positions)
    naive = Naive(
        model, x, state.velocities, state.angular_velocities,
        last=-np.inf if model.contact_duration is None else fast._particles.last - fast._now,
        hits=0 if model.seed is None else fast._particles.hits.copy(),
    )  # fmt: skip
    if naive._bonds is not None:  # at the edge of a well, positions cannot tell
        held = fast._particles.bonds
        naive._bonds[:] = 0
        naive._bonds[:, : held.shape[1]] = held[:, : naive._bonds.shape[1]]
    return naive


def event(entry: tuple[float, int, int]) -> tuple[int, int]:
    """Who: a pair in any order, or a particle and a face."""
    _, one, other = entry
    return (one, other) if other < 0 else (min(one, other), max(one, other))


def compare(fast: Simulation, windows: int) -> int:
    """Asserts that both have the same events; how many there were."""
    deviations = []
    for _ in range(windows):
        if fast.stopped:
            break
        start, done, naive = fast.time, len(fast.trace()), naive_from(fast)
        naive.run(until=LONGEST, changes=fast.number // 2)
        if not naive.trace:
            break
        last = naive.trace[-1][0]
        fast.run(until=start + last + WORST)
        found = fast.trace()[done:]
        for slow, quick in zip(naive.trace, found, strict=False):
            assert event(slow) == event(quick), f"event {len(deviations)} of {len(naive.trace)}: {slow} {quick} {start}"
            deviations.append(abs(start + slow[0] - quick[0]))
        assert len(found) >= len(naive.trace) or fast.stopped
    if deviations:
        assert max(deviations) < WORST
        assert np.median(deviations) < TYPICAL
    return len(deviations)


# -- scenes ---------------------------------------------------------------------------------------

FACES = ("open", "plain", "steady", "uniform", "flux", "oscillating", "thermal")


def friction(rng: np.random.Generator) -> Friction:
    return Friction(rng.uniform(-1, 1), rng.uniform(0.3, 1), rng.uniform(0, 0.3), rng.uniform(0.1, 0.5))


def face(kind: str, rng: np.random.Generator) -> Face | None:
    alpha, rough = rng.uniform(0.7, 1), friction(rng) if rng.random() < 0.5 else None
    match kind:
        case "open":
            return None
        case "steady":
            return Face(alpha, velocity=rng.uniform(0.1, 1), friction=rough)
        case "uniform" | "flux":
            return Face(alpha, random_phase=RandomPhase(rng.uniform(0.1, 2), kind), friction=rough)
        case "oscillating":
            shaking = Oscillation(rng.uniform(0.01, 0.3), rng.uniform(1, 30), rng.uniform(0, 6))
            return Face(alpha, oscillation=shaking, friction=rough)
        case "thermal":
            return Face(temperature=rng.uniform(0.5, 3))
    return Face(alpha, friction=rough)


def sizes_and_masses(data: st.DataObject, rng: np.random.Generator, number: int) -> dict[str, Any]:
    sizes = rng.uniform(data.draw(st.sampled_from([0.3, 1.0])), 1.0, number)
    masses = np.exp(rng.uniform(0, data.draw(st.sampled_from([0.0, 3.0])), number))
    return {"diameters": sizes, "masses": masses}


def gas(data: st.DataObject, d: int) -> tuple[HardSpheres, Simulation]:
    """Everything that a model of the full type can be."""
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32)))
    number = data.draw(st.integers(30, 60))
    side = float((number / data.draw(st.sampled_from([0.05, 0.15, 0.3] if d == 3 else [0.05, 0.2, 0.4]))) ** (1 / d))
    sides = st.lists(st.sampled_from(["periodic", "walls"]), min_size=d, max_size=d)
    periodic = [kind == "periodic" for kind in data.draw(sides)]
    kinds = [("open",) * 2 if wraps else data.draw(st.tuples(*[st.sampled_from(FACES)] * 2)) for wraps in periodic]
    grains = sizes_and_masses(data, rng, number)
    down = data.draw(st.sampled_from([0.0, -1.0]))
    model = full(
        number, lengths=(side,) * d, periodic=periodic, faces=[face(kind, rng) for pair in kinds for kind in pair],
        restitution=data.draw(st.sampled_from([1.0, 0.9, 0.7])),
        friction=friction(rng) if data.draw(st.booleans()) else None,
        acceleration=(0.3 * down, *[0.0] * (d - 2), down),
        contact_duration=data.draw(st.sampled_from([None, 1e-3, 0.1])),
        seed=data.draw(st.integers(0, 2**63)), **grains,
    )  # fmt: skip
    amplitude = model.walls.numbers[:, AMPLITUDE].any()
    x = scatter(rng, model.lengths, model.periodic, grains["diameters"], number, clearance=0.3 if amplitude else 0.0)
    spins = rng.normal(size=(number, 1 if d == 2 else 3))
    return model, Simulation(model, x, thermal(rng, number, d), spins, trace=True)


#: Lifted as soon as `oscillating_time` ends for what flies away from the wall and meets nothing else.
compared: dict[str, int] = {}


def test_bare_spheres() -> None:
    assert compare(spheres(2, 0.2), windows=40) == 20 * 32


@settings(phases=AS_DRAWN, max_examples=25)
@given(st.data())
def test_disks_with_everything(data: st.DataObject) -> None:
    _, simulation = gas(data, 2)
    compared["disks"] = compared.get("disks", 0) + compare(simulation, windows=16)


@settings(phases=AS_DRAWN, max_examples=20)
@given(st.data())
def test_spheres_with_everything(data: st.DataObject) -> None:
    _, simulation = gas(data, 3)
    compared["spheres"] = compared.get("spheres", 0) + compare(simulation, windows=12)


@settings(phases=AS_DRAWN, max_examples=10)
@given(st.data())
def test_square_wells(data: st.DataObject) -> None:
    """Wells and shoulders, of unequal disks too."""
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32)))
    number = 50
    side = float((number / data.draw(st.sampled_from([0.05, 0.3]))) ** 0.5)
    well = Well(data.draw(st.floats(-1, 2)), data.draw(st.floats(1.05, 2)))
    grains = sizes_and_masses(data, rng, number)
    grains["diameters"][0] = 0.9  # by type, never alike
    grains["masses"][0] = 2.0
    model = hard_spheres(lengths=(side,) * 2, periodic=(True,) * 2, well=well, **grains)
    x = scatter(rng, model.lengths, model.periodic, grains["diameters"], number)
    simulation = Simulation(model, x, thermal(rng, number, 2), trace=True)
    compared["wells"] = compared.get("wells", 0) + compare(simulation, windows=12)


@settings(phases=AS_DRAWN, max_examples=10)
@given(st.data())
def test_cylinder(data: st.DataObject) -> None:
    """A drum about one of the axes, that turns, with rough grains, under gravity across it and along it."""
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32)))
    number, axis = 40, data.draw(st.integers(0, 2))
    side, radius = 5.0, 2.5
    rough = friction(rng)
    model = hard_spheres(
        lengths=(side,) * 3, periodic=[k == axis for k in range(3)], restitution=data.draw(st.floats(0.7, 0.99)),
        friction=rough, acceleration=data.draw(st.sampled_from([(0.0, 0.0, -1.0), (0.3, -1.0, 0.0)])),
        cylinder=Cylinder(radius, axis, data.draw(st.floats(-1, 1)), data.draw(st.floats(0.7, 1)), rough),
        contact_duration=1e-3,
    )  # fmt: skip
    circle = (radius, *(k for k in range(3) if k != axis))
    x = scatter(rng, model.lengths, model.periodic, 1.0, number, circle=circle)
    simulation = Simulation(model, x, thermal(rng, number, 3), rng.normal(size=(number, 3)), trace=True)
    compared["cylinder"] = compared.get("cylinder", 0) + compare(simulation, windows=12)


def test_compared_enough() -> None:
    """Where all of this file has run: windows end early in scenes that empty themselves, most must not."""
    if len(compared) == 4:
        assert sum(compared.values()) > 10_000, compared
