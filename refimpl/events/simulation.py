"""Event-driven dynamics of hard disks and spheres: the state, its arrays, and the calls of the compiled loop.

    model = hard_spheres(lengths=(10.0, 10.0), periodic=(True, True))
    simulation = Simulation(model, positions, velocities)
    simulation.run(until=5.0)

Time is kept as a base and a remainder, which is moved into the base when it exceeds some times to cross the box: its
rounding then is that of positions, for any time and any number of particles.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from refimpl.events.kernels import loop, measure, neighbours, schedule, shells
from refimpl.events.model import FREQUENCY, OSCILLATING, PHASE, Floats, HardSpheres, Well
from refimpl.events.prediction import NEVER
from refimpl.events.state import (
    SIMULTANEOUS,
    TOLERANCE,
    Simultaneous,
    State,
    check_state,
    collapse,
    field_energy,
    kinetic_energies,
    masses_of,
    nearness,
    radii_of,
    rms_speed,
    rotational_energies,
    shortest_time,
    spins_of,
    time_to_cross,
    two_sum,
    well_energy,
)
from refimpl.snapshot import Arrays, restore, snapshot

Scheduler = Literal["tree", "lists", "calendar", "neighbours"]

#: Times to cross the box after which the clock gets a new base; that costs about one prediction a particle.
RENEWAL = 16.0
#: 2 pi to 50 digits: phases of walls stay those of the whole time.
_FULL_TURN = Fraction("6.28318530717958647692528676655900576839433879875021")
#: Mean wait for a particle's next event that the calendar is laid out for, in times to cross a cell.
EXPECTED_WAIT = 0.25
#: Width of the shells of lists of neighbours, in mean diameters: of 0.1 to 0.4, the fastest where lists pay.
SHELL = 0.3
#: Lists of neighbours are for particles of which the largest is no larger than the mean one over this: all lists are
#: as long as the longest.
LEAST_MEAN = 0.6
#: Fewer particles than this are left to cells: their runs are short beside the compilation of another loop.
MANY = 1200
#: What a new list costs, in partners that are looked at for an event.
PRICE = 72.0
#: Slack of contact ranges, in these: rounding of distances.
SLACK = 1e-9
#: Share of the width of a cell beyond the contact range that is given to its overlap with its neighbours.
OVERLAP = 0.999
#: Attributes of a `Simulation` that are no part of its state: what it was made from, and measurements.
_APART = (
    "model", "dimension", "number", "_grid", "_counting", "_trace", "_traced", "_traced_states", "_tallies", "_fields",
    "_initial",
)  # fmt: skip
#: What of its state may be larger than at the start.
_GROWING = ("particles.cells", "particles.bonds", "particles.shells.lists", "scratch", "store")


class Simulation:
    """Hard particles of `model` from the given state, by the asynchronous event-driven algorithm with cells.

    positions, velocities: (N, d). angular_velocities: (N, 1) in two dimensions, (N, 3) in three; zero by default; only
    with friction. scheduler: "tree" (earliest event of each particle, complete binary tree), "lists" (a list of events
    per owner, complete binary tree), "calendar" (earliest events in a calendar queue), "neighbours" (as "tree", with
    lists of neighbours wherever these are possible). All give the same events, to the last bit. tallies: measure
    averages and event observables. fields: cells along each axis for the hydrodynamic fields. counting: count
    operations. trace: keep a list of all changes of state. shell: width of the shells of lists of neighbours, length,
    0 for cells alone; by default what `shell_width` finds to be faster. It changes no event, not even by a bit. Units:
    any consistent set; time is that of the velocities. Raises ValueError that names particles that overlap, lie outside
    the walls, or are not finite, and cells of the fields that are smaller than the contact range.

    Attributes: model; number N and dimension d; stopped: "", or what ended the run for good; simultaneous: see
    `state.Simultaneous`.

    Literature: M. Marin, D. Risso and P. Cordero, J. Comput. Phys. 103, 306 (1993) (lists and tree); G. Paul, J.
    Comput. Phys. 221, 615 (2007) (calendar); B. D. Lubachevsky, J. Comput. Phys. 94, 255 (1991) (one event a particle).
    """

    def __init__(
        self,
        model: HardSpheres,
        positions: ArrayLike,
        velocities: ArrayLike,
        angular_velocities: ArrayLike | None = None,
        *,
        scheduler: Scheduler = "tree",
        tallies: bool = False,
        fields: tuple[int, ...] | None = None,
        counting: bool = False,
        trace: bool = False,
        shell: float | None = None,
    ) -> None:
        x, v = np.array(positions, dtype=np.float64), np.array(velocities, dtype=np.float64)
        self.dimension = d = len(model.lengths)
        self.number = n = check_state(model, x, v)
        self._counting = np.zeros(schedule.OPERATIONS, np.int64) if counting else None
        quantum = 2.0 ** (math.ceil(math.log2(max(model.lengths))) - 51)
        lengths = tuple(round(length / quantum) * quantum for length in model.lengths)
        walls = model.walls and model.walls._replace(numbers=model.walls.numbers.copy())
        self.model = model = model._replace(lengths=lengths, walls=walls)
        width = shell_width(model, n, scheduler, fields) if shell is None else shell
        if width > 0 and not lists_possible(model, n, fields, width):
            raise ValueError(f"shell: {shell:g} is not possible in this scene, with walls, fields or few cells; give 0")
        self._grid, blocks = _grid(model, n, quantum, fields, width)
        self._rows, ints = _aligned(n, 8, np.float64), _aligned(n, 8, np.int32)
        self._rows[:, :d] = np.round(x / quantum) * quantum
        self._rows[:, schedule.SPEED : schedule.SPEED + d] = v
        spins = None if model.rough is None else spins_of(angular_velocities, n, d)
        cells = _aligned(math.prod(self._grid.counts), 8, np.int32)
        ints[:, schedule.STREAK] = -1
        hits = None if model.seed is None else np.zeros(n, np.int64)
        last = None if model.contact_duration is None else np.full(n, -np.inf)
        self._particles = loop.Particles(
            self._rows, ints, np.zeros(n), np.zeros((n, 3), np.int64), cells, spins, None, hits, last, None
        )
        self._scratch = _scratch(d, 8)
        self._store: Any = schedule.Earliest(0) if scheduler != "lists" else _lists(n, 4 * n + 256)
        self._queue = _calendar(n) if scheduler == "calendar" else _tree(n)
        self._trace = _trace() if trace else None
        self._traced: list[tuple[float, int, int]] = []
        self._traced_states = [np.zeros((0, 2, 9))]
        self._progress = np.zeros(6, np.int64)
        self._base, self._now, self._rebases = (0.0, 0.0), 0.0, 0
        self._phases = () if walls is None else tuple(map(float, walls.numbers[:, PHASE]))
        self._crossing = self._instant = 0.0
        self._ties, self.simultaneous = np.zeros(2), Simultaneous(0, math.nan)
        self.stopped = ""
        self._sort_into_cells()
        self._refuse_overlap()
        if width > 0:
            self._fill_lists(width)
        if model.well is not None:
            self._find_bonds(model.well)
        self._tallies = self._fields = None
        if tallies or fields is not None:
            faces = 2 * d + (model.cylinder is not None)
            self._tallies = measure.Tallies(
                np.zeros(measure.SUMS), np.zeros((faces, 5)), np.zeros(measure.SUMS), np.zeros((faces, 5))
            )
        if fields is not None:
            self._fields = _fields(fields, blocks, self._grid, n, ints)
        self._anchor_tallies()
        self._initial = self._cell_contents() if fields is not None else {}
        self._repredict_all()

    # -- running -----------------------------------------------------------------------------------

    def run(self, until: float = math.inf, collisions: int | None = None) -> None:
        """Runs to the time `until`, or to the number `collisions` of pair collisions since the start: what is sooner.

        An inelastic collapse ends the run earlier and for good: see `stopped`. Raises ValueError if neither is given,
        or for a time before the present one.
        """
        if until == math.inf and collisions is None:
            raise ValueError("run: give a time, or a number of collisions")
        if until < self.time:
            raise ValueError(f"run: until = {until!r} is over, it is t = {self.time!r}")
        most = np.iinfo(np.int64).max if collisions is None else collisions
        while not self.stopped:
            end = min(math.fsum((until, -self._base[0], -self._base[1])), 1e299)
            measured = loop.Measured(self._tallies, self._fields, self._counting, self._trace, self._ties)
            renewal = min(RENEWAL * self._crossing, 1e299)
            limits = loop.Limits(end, renewal, self._instant, SIMULTANEOUS * self._crossing, most)
            status, self._now = loop.advance(
                self.model, self._grid, self._particles, self._store, self._queue, self._scratch, measured,
                self._progress, self._now, limits,
            )  # fmt: skip
            self._collect_trace()
            self._collect_simultaneous()
            if status in (loop.REACHED, loop.COUNTED):
                return
            if status == loop.COLLAPSED:
                one, other = (int(self._progress[k]) for k in (loop.FIRST, loop.SECOND))
                self.stopped = collapse(one, other, self.time)
            elif status == loop.PAUSED:
                self._rebase_clock()
            elif status != loop.TRACE_FULL:
                self._enlarge(status)

    def _collect_trace(self) -> None:
        if self._trace is not None:
            length = int(self._trace.filled[0])
            for time, (one, other) in zip(self._trace.time[:length], self._trace.pairs[:length].tolist(), strict=True):
                self._traced.append((math.fsum((*self._base, time)), one, other))
            self._traced_states.append(self._trace.after[:length].copy())
            self._trace.filled[0] = 0

    def _collect_simultaneous(self) -> None:
        number, first = int(self._ties[0]), self.simultaneous.first
        if number and not self.simultaneous.number:
            first = math.fsum((*self._base, self._ties[1]))
        self.simultaneous = Simultaneous(number, first)

    def trace(self) -> list[tuple[float, int, int]]:
        """(time, i, j) of every change of state since the start, a pair in either order; j = -1 - face for a wall."""
        if self._trace is None:
            raise ValueError("events were not traced: give trace=True")
        return self._traced

    def traced_states(self) -> Floats:
        """(events, 2, 9) of every change of state: positions, not wrapped, velocities and spins of both, after it.

        In the order of `trace`; three components each, those that are absent are 0, as all of a wall are.
        """
        if self._trace is None:
            raise ValueError("events were not traced: give trace=True")
        return np.concatenate(self._traced_states)

    def _rebase_clock(self) -> None:
        """Moves the time into its base, and starts all predictions again from there."""
        self._rebases += 1
        shift, self._now = self._now, 0.0
        self._base = two_sum(*self._base, shift)
        self._rows[:, schedule.TIME] -= shift
        if self._particles.last is not None:
            self._particles.last[:] -= shift
        if self._tallies is not None:
            self._tallies.sums[measure.SINCE] -= shift
        if self._fields is not None:
            self._fields.since[:] -= shift
        self._set_phases()
        self._repredict_all()

    def _set_phases(self) -> None:
        """The phases of oscillating walls at the base of the clock, to the last bit."""
        if self.model.walls is None:
            return
        base = Fraction(self._base[0]) + Fraction(self._base[1])
        for face in np.flatnonzero(self.model.walls.motion == OSCILLATING):
            numbers = self.model.walls.numbers[face]
            turned = Fraction(self._phases[face]) + Fraction(float(numbers[FREQUENCY])) * base
            numbers[PHASE] = float(turned % _FULL_TURN)

    def _enlarge(self, status: int) -> None:
        """Doubles the array that is too small for the next event; no part of that event has been applied."""
        particles = self._particles
        if status == loop.CELL_FULL:
            self._widen_cells()
        elif status == loop.LISTS_FULL:
            self._widen_lists()
        elif status == loop.BONDS_FULL:
            bonds = np.pad(particles.bonds, ((0, 0), (0, particles.bonds.shape[1])))
            self._particles = particles._replace(bonds=bonds)
        else:
            self._store = _with_more_nodes(self._store)

    def _widen_cells(self) -> None:
        old = self._particles.cells
        cells = _aligned(len(old), 2 * old.shape[1], np.int32)
        cells[:, : old.shape[1]] = old
        self._particles = self._particles._replace(cells=cells)
        self._scratch = _scratch(self.dimension, cells.shape[1])

    def _widen_lists(self) -> None:
        lists = self._particles.shells.lists
        wider = _aligned(self.number, 2 * lists.shape[1], np.int32)
        wider[:, : lists.shape[1]] = lists
        self._particles = self._particles._replace(shells=self._particles.shells._replace(lists=wider))

    def _fill_lists(self, width: float) -> None:
        """Makes all lists of neighbours about where the particles are."""
        well, particles = self.model.well, self._particles
        centres = np.zeros((self.number, 3))
        centres[:, : self.dimension] = self._rows[:, : self.dimension]
        lists = _aligned(self.number, 32 if self.dimension == 3 else 16, np.int32)
        reach = (1.0 if well is None else well.range) * (1 + SLACK)
        self._particles = particles._replace(shells=shells.Shells(lists, centres, width, reach))
        cell_of = particles.ints[:, schedule.CELL : schedule.CELL + 3]
        radii = radii_of(self.model, self.number)
        while not shells.fill_lists(self._particles.shells, radii, cell_of, particles.cells, self._grid):
            self._widen_lists()
            self._particles.shells.lists[:, 0] = 0

    def _sort_into_cells(self) -> None:
        """Wraps all positions into the box, and puts the particles into cells."""
        d, grid, particles = self.dimension, self._grid, self._particles
        ints, rows = particles.ints, self._rows
        for k in range(d):
            side, count = grid.sides[k], grid.counts[k]
            if grid.wraps[k]:
                turns = np.floor(rows[:, k] / self.model.lengths[k])
                rows[:, k] -= turns * self.model.lengths[k]
                particles.images[:, k] += turns.astype(np.int64)
            ints[:, schedule.CELL + k] = np.clip(np.floor(rows[:, k] / side), 0, count - 1)
        x, y, z = (ints[:, schedule.CELL + k].astype(np.int64) for k in range(3))
        cell = (z * grid.counts[1] + y) * grid.counts[0] + x
        held = np.bincount(cell, minlength=len(particles.cells))
        while held.max() >= self._particles.cells.shape[1]:
            self._widen_cells()
        order = np.argsort(cell, kind="stable")
        slot = np.arange(self.number) - np.repeat(np.cumsum(held) - held, held)
        self._particles.cells[:, 0] = held
        self._particles.cells[cell[order], slot + 1] = order

    def _repredict_all(self) -> None:
        """Marks all particles for a prediction of all their events at the current time."""
        velocities = self._rows[:, schedule.SPEED : schedule.SPEED + 3]
        self._crossing = time_to_cross(self.model, velocities)
        self._instant = shortest_time(self.model, velocities, self._crossing)
        self._progress[loop.UNPREDICTED] = 0
        mobile = np.full(self.number, True) if self.model.inverse_masses is None else self.model.inverse_masses > 0
        particles = self._particles
        self._rows[:, schedule.NEXT] = NEVER
        particles.ints[:, schedule.PARTNER] = -1
        particles.ints[:, schedule.OWN] = loop.REPREDICT
        particles.own[:] = np.where(mobile, self._now, NEVER)
        if isinstance(self._store, schedule.Lists):
            self._store = _lists(self.number, self._store.time.size)
        if isinstance(self._queue, schedule.Tree):
            schedule.build_tree(self._queue, particles.own)
        else:
            wait = EXPECTED_WAIT * min(self._grid.sides[: self.dimension]) / (rms_speed(velocities) or 1.0)
            self._queue.per_time[0] = self.number / wait
            schedule.build_calendar(self._queue, particles.own, self._now)

    # -- going on later ----------------------------------------------------------------------------

    def snapshot(self) -> Arrays:
        """The complete state as arrays by name: `resume` goes on from it with the same bits. No measurements."""
        return snapshot(self._state())

    def resume(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Goes on from where another simulation of the same model, scheduler and fields was; measurements begin anew.

        arrays: of its `snapshot`. Raises ValueError that names an array which does not fit.
        """
        state = restore(self._state(), arrays, _GROWING)
        self._traced, self._traced_states = [], [np.zeros((0, 2, 9))]
        del state["walls"]  # filled in place
        for name, value in state.items():
            setattr(self, name if name in vars(self) else f"_{name}", value)
        if self._counting is not None:
            self._counting[:] = 0
        if self._tallies is not None:
            for sums in self._tallies:
                sums[:] = 0.0
            self._tallies.sums[measure.SINCE] = self._now
        if self._fields is not None:
            for sums in self._fields:
                if isinstance(sums, np.ndarray) and sums is not self._particles.ints:
                    sums[:] = 0.0
            self._fields.since[:] = self._now
            self._initial = self._cell_contents()
        self._anchor_tallies()

    def _state(self) -> dict[str, Any]:
        state = {name.removeprefix("_"): value for name, value in vars(self).items() if name not in _APART}
        # the phases of walls are those at the base of the clock
        return state | {"walls": None if self.model.walls is None else self.model.walls.numbers}

    # -- the start ---------------------------------------------------------------------------------

    def _refuse_overlap(self) -> None:
        gap, one, other = self.smallest_gap()
        if gap < -TOLERANCE * self.model.diameter - 4 * self._grid.quantum:
            raise ValueError(f"particles {one} and {other} overlap by {-gap:.6g}: move them apart")

    def _find_bonds(self, well: Well) -> None:
        slots = 32 if self.dimension == 3 else 16
        while True:
            bonds = np.zeros((self.number, slots), np.int32)
            radii = radii_of(self.model, self.number)
            if neighbours.find_bonds(radii, well.range, bonds, *self._geometry()):
                break
            slots *= 2
        self._particles = self._particles._replace(bonds=bonds)

    def _geometry(self) -> tuple[Any, ...]:
        """Arguments of `kernels.neighbours`: positions in the frame of the cells, the cells, the box."""
        d, grid = self.dimension, self._grid
        x, lengths = np.zeros((self.number, 3)), np.ones(3)
        lengths[:d] = self.model.lengths
        x[:, :d] = self.state().positions - self._particles.images[:, :d] * lengths[:d]
        cell_of = self._particles.ints[:, schedule.CELL : schedule.CELL + 3]
        return x, cell_of, self._particles.cells, np.array(grid.counts), np.array(grid.wraps), lengths

    def _anchor_tallies(self) -> None:
        """The energies, the moment of the field and its rate, from the state."""
        if self._tallies is None:
            return
        sums, field = self._tallies.sums, self.model.acceleration
        sums[measure.WELLS] = well_energy(self.model, self._particles.bonds)
        sums[measure.ENERGY] = self.kinetic_energy() + field_energy(self.model, self.state().positions)
        if field is not None:
            masses, (_, x, v, _) = self.masses(), self.state()
            sums[measure.HEIGHT] = masses @ x @ field
            sums[measure.RISE] = masses @ v @ field
            sums[measure.PULL] = masses.sum() * np.dot(field, field)

    # -- what is seen from outside -----------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """The time of the last event, or the one that the run was told to reach."""
        return math.fsum((*self._base, self._now))

    @property
    def collisions(self) -> int:
        """Pair collisions (not passages of a well's edge)."""
        return int(self._progress[loop.PAIRS])

    @property
    def events(self) -> int:
        """All events: collisions, walls, edges of wells, faces of cells, and those that had become invalid."""
        return int(self._progress[loop.EVENTS])

    @property
    def interactions(self) -> int:
        """Events that change a velocity: collisions, edges of wells, walls."""
        return int(self._progress[loop.INTERACTIONS])

    def masses(self) -> Floats:
        """(N,), 0 for fixed particles: they have no kinetic energy."""
        return masses_of(self.model, self.number)

    def state(self) -> State:
        """The state of all particles at the current time; nothing of the simulation is changed."""
        d = self.dimension
        span = (self._now - self._rows[:, schedule.TIME])[:, None]
        g = np.zeros(d) if self.model.acceleration is None else np.array(self.model.acceleration)
        v = self._rows[:, schedule.SPEED : schedule.SPEED + d]
        lengths = np.array(self.model.lengths)
        # the same sum wherever the particle's copy is that the cells have
        turns = np.floor(self._rows[:, :d] / lengths).astype(np.int64)
        wrapped, images = self._rows[:, :d] - turns * lengths, self._particles.images[:, :d] + turns
        x = wrapped + images * lengths + v * span + 0.5 * g * span**2
        spins = self._particles.spins
        return State(self.time, x, v + g * span, None if spins is None else (spins if d == 3 else spins[:, 2:]).copy())

    def rotational_energy(self) -> float:
        """sum I w^2/2."""
        return float(rotational_energies(self.model, self._particles.spins, self.number).sum())

    def kinetic_energy(self) -> float:
        """Translational and rotational."""
        return float(kinetic_energies(self.model, self.state()).sum())

    def potential_energy(self) -> float:
        """Of the field, -sum m g.x with x not wrapped, and of the wells."""
        return field_energy(self.model, self.state().positions) + well_energy(self.model, self._particles.bonds)

    def smallest_gap(self) -> tuple[float, int, int]:
        """(gap, i, j) of the closest pair of surfaces; negative: overlap. Pairs of fixed particles do not count."""
        inverse = self.model.inverse_masses
        fixed = np.zeros(self.number, bool) if inverse is None else inverse == 0
        gap, one, other = neighbours.closest(radii_of(self.model, self.number), fixed, *self._geometry())
        return float(gap), int(one), int(other)

    def memory(self) -> int:
        """Bytes of all arrays."""
        particles = self._particles
        arrays = [*particles, *(particles.shells or ()), *self._store[:], *self._queue, *self._scratch]
        return sum(array.nbytes for array in arrays if isinstance(array, np.ndarray))

    def operation_counts(self) -> NDArray[np.int64]:
        """(9,) numbers of operations. Needs `counting`.

        Comparisons, list moves, predictions, cell crossings, invalid events, wall events, states that were taken anew
        after a flight over the box, lists of neighbours made after the start, distances looked at for that.
        """
        if self._counting is None:
            raise ValueError("operations are not counted: give counting=True")
        return self._counting.copy()

    def tallies(self) -> dict[str, Any]:
        """Sums since the start, exact: see the names. Needs `tallies`.

        collisional_virial: sum of r_ij . dp_ij, positive for repulsion. dissipated_energy: lost in pair collisions.
        wall_impulse (faces, d): momentum given to each face, and to the cylinder; wall_energy: energy got from it,
        wall_collisions; wall_torque: angular momentum about the cylinder's axis that the particles got from it.
        kinetic_energy_integral, potential_energy_integral: over time. deepest_overlap: largest (s - r)/s of a pair at
        its collision, r apart where s is their contact distance: beyond rounding only after an event was missed.
        """
        if self._tallies is None:
            raise ValueError("nothing was measured: give tallies=True")
        measure.accumulate(self._tallies, self._now)
        sums, walls = self._tallies.sums + self._tallies.rests, self._tallies.walls + self._tallies.wall_rests
        return {
            "collisions": self.collisions,
            "events": self.events,
            "collisional_virial": sums[measure.VIRIAL],
            "dissipated_energy": sums[measure.DISSIPATED],
            "wall_impulse": walls[:, : self.dimension].copy(),
            "wall_energy": walls[:, measure.WALL_ENERGY].copy(),
            "wall_collisions": walls[:, measure.WALL_COUNT].copy(),
            "wall_torque": sums[measure.TORQUE],
            "deepest_overlap": sums[measure.DEEPEST],
            "kinetic_energy_integral": sums[measure.ENERGY_TIME] - sums[measure.FIELD_TIME],
            "potential_energy_integral": sums[measure.FIELD_TIME] + sums[measure.WELLS_TIME],
        }

    def fields(self) -> dict[str, Floats]:
        """Hydrodynamic fields since the start; every array has the cells' shape (nx, ny(, nz)), vectors last.

        field_mass, field_momentum, field_kinetic, field_rotational: integrals over time. field_flux_mass,
        field_flux_momentum, field_flux_energy: (d, ...) through the lower face of each cell along each axis, positive
        upwards, carried and by collisions. field_dissipation, field_collisions; field_wall_momentum and
        field_wall_energy: given by walls. field_initial_* and field_final_*: content in mass, momentum and energy.
        """
        if self._fields is None:
            raise ValueError("no fields were measured: give fields=(nx, ny)")
        measure.settle_fields(self._fields, self.model, self._rows, self._particles.spins, self._now)
        f, d = self._fields, self.dimension
        shaped = {
            "field_mass": f.mass,
            "field_momentum": f.momentum[:, :d],
            "field_kinetic": f.kinetic,
            "field_rotational": f.rotational,
            "field_dissipation": f.dissipation,
            "field_collisions": f.collisions,
            "field_wall_momentum": f.wall_momentum[:, :d],
            "field_wall_energy": f.wall_energy,
        }
        found = {name: self._shaped(values) for name, values in shaped.items()}
        fluxes = {"mass": f.flux_mass, "momentum": f.flux_momentum[..., :d], "energy": f.flux_energy}
        for name, values in fluxes.items():
            found[f"field_flux_{name}"] = np.stack([self._shaped(values[axis]) for axis in range(d)])
        found |= {f"field_initial_{name}": values for name, values in self._initial.items()}
        return found | {f"field_final_{name}": values for name, values in self._cell_contents().items()}

    def _shaped(self, values: NDArray[Any]) -> Floats:
        """(C, ...) with x fastest as (nx, ny(, nz), ...)."""
        assert self._fields is not None
        shape = self._fields.shape
        turned = values.reshape(*shape[::-1], *values.shape[1:])
        turned = np.moveaxis(turned, (0, 1, 2), (2, 1, 0))
        return np.ascontiguousarray(turned if self.dimension == 3 else turned[:, :, 0])

    def _cell_contents(self) -> dict[str, Floats]:
        """Mass, momentum and energy (kinetic, rotational, half of each well) of what is in each cell now."""
        f, d = self._fields, self.dimension
        assert f is not None
        blocks = [self._particles.ints[:, schedule.CELL + k] // f.blocks[k] for k in range(3)]
        place = (blocks[2] * f.shape[1] + blocks[1]) * f.shape[0] + blocks[0]
        state = self.state()
        masses, v, size = self.masses(), state.velocities, math.prod(f.shape)
        energy = kinetic_energies(self.model, state)
        if self.model.well is not None:
            energy -= 0.5 * self.model.well.depth * self._particles.bonds[:, 0]
        momentum = [np.bincount(place, masses * v[:, k], size) for k in range(d)]
        return {
            "mass": self._shaped(np.bincount(place, masses, size)),
            "momentum": self._shaped(np.stack(momentum, axis=1)),
            "energy": self._shaped(np.bincount(place, energy, size)),
        }


# -- building --------------------------------------------------------------------------------------


def _reach(model: HardSpheres) -> float:
    """The contact range of the largest pair, and what rounding may add."""
    return model.diameter * (1.0 if model.well is None else model.well.range) * (1 + SLACK)


def shell_width(model: HardSpheres, n: int, scheduler: Scheduler, fields: tuple[int, ...] | None) -> float:
    """Width of the shells of lists of neighbours, length; 0 where cells alone are used.

    Lists where `neighbours` is the scheduler, and where they are expected to cost less: in a gas of the mean density,
    after Enskog, a function of the model and the number n of particles alone. But cells where lists are not possible,
    see `lists_possible`, and for the documented queues. scheduler, fields: as of `Simulation`.
    """
    mean, density = _mean_size(model, n), n / math.prod(model.lengths)
    width = SHELL * mean
    if scheduler in ("lists", "calendar") or not lists_possible(model, n, fields, width):
        return 0.0
    if scheduler == "neighbours":
        return width
    fixed = model.inverse_masses is not None and bool((model.inverse_masses == 0).any())
    return width if n >= MANY and not fixed and _lists_pay(model, density, mean, width) else 0.0


def lists_possible(model: HardSpheres, n: int, fields: tuple[int, ...] | None, width: float) -> bool:
    """Whether there can be lists of neighbours, in shells of a width: without walls, fields of force, fields measured.

    Not in boxes of less than three cells, nor for very unequal particles, nor for points. model: its lengths. n: number
    of particles. fields: cells along each axis for the fields, or None. width: length.
    """
    bare = model.walls is None and model.cylinder is None and model.acceleration is None and fields is None
    alike = _mean_size(model, n) > LEAST_MEAN * model.diameter
    wide = all(length >= 3 * (_reach(model) + 2 * width) for length in model.lengths)
    return bare and alike and wide and n <= shells.MOST


def _mean_size(model: HardSpheres, n: int) -> float:
    """Diameter of n equal particles of the same total volume (in two dimensions, area)."""
    d = len(model.lengths)
    return 2 * float(np.mean(radii_of(model, n) ** d)) ** (1 / d)


def _lists_pay(model: HardSpheres, density: float, size: float, width: float) -> bool:
    """Whether lists are expected to cost less than cells, counted in partners that are looked at for an event.

    A particle of mean free path l gets a new list after x (1 + x/5) collisions, x = width/l, as measured (events/cost);
    at the edge of wells it has others. density: particles per volume. size: contact distance.
    """
    d, reach = len(model.lengths), 1.0 if model.well is None else model.well.range
    ball = math.pi if d == 2 else 4 * math.pi / 3
    packing = min(density * ball * (size / 2) ** d, 0.9)
    contact = (1 - 7 * packing / 16) / (1 - packing) ** 2 if d == 2 else (1 - packing / 2) / (1 - packing) ** 3
    section = 2 * size if d == 2 else math.pi * size**2
    x = width * math.sqrt(2) * density * section * contact
    if model.well is not None:  # those that come, and those that go
        x *= 1 + 2 * reach ** (d - 1) / contact
    in_cells = 3**d * max(1.0, density * _reach(model) ** d)
    in_list = density * ball * (reach * size + 2 * width) ** d
    # two particles are predicted for at a collision, and get so many lists
    return 2 * (in_cells - in_list) * x * (1 + x / 5) > 2 * PRICE


def _grid(
    model: HardSpheres, n: int, quantum: float, fields: tuple[int, ...] | None, width: float
) -> tuple[loop.Grid, tuple[int, ...]]:
    d = len(model.lengths)
    reach = _reach(model) + 2 * width
    natural = max(reach, (math.prod(model.lengths) / n) ** (1 / d))
    counts, blocks = [], []
    for axis, length in enumerate(model.lengths):
        if fields is None:
            counts.append(max(1, int(length / natural)))
            blocks.append(1)
            continue
        if len(fields) != d or fields[axis] < 1:
            raise ValueError(f"fields: {d} positive numbers of cells, got {fields}")
        side = length / fields[axis]
        if side < reach:
            raise ValueError(f"fields: cells of side {side:g} along axis {axis} are smaller than the contact range")
        blocks.append(max(1, int(side / natural)))
        counts.append(fields[axis] * blocks[axis])
    sides = [length / count for length, count in zip(model.lengths, counts, strict=True)]
    overlaps = [0.0 if fields is not None else 0.5 * OVERLAP * (side - reach) for side in sides]
    pad = 3 - d
    shifts = np.zeros((27, 8))
    for axis, (length, wraps) in enumerate(zip(model.lengths, model.periodic, strict=True)):
        shifts[:, axis] = wraps * length * (np.arange(27) // 3**axis % 3 - 1)
    grid = loop.Grid(
        (*counts, *[1] * pad), (*sides, *[1.0] * pad), (*overlaps, *[0.0] * pad),
        (*model.periodic, *[False] * pad), shifts, quantum, nearness(model),
    )  # fmt: skip
    return grid, (*blocks, *[1] * pad)


def _aligned(rows: int, columns: int, kind: Any) -> Any:
    """Zeros whose rows start on cache lines."""
    size = rows * columns * np.dtype(kind).itemsize
    raw = np.zeros(size + 64, np.uint8)
    start = -raw.ctypes.data % 64
    return raw[start : start + size].view(kind).reshape(rows, columns)


def _scratch(d: int, width: int) -> loop.Scratch:
    most = 3**d * width + 12  # lists of neighbours are no longer
    return loop.Scratch(np.zeros(most, np.int64), np.zeros((4, most)))


def _trace() -> loop.Trace:
    length = 1 << 6  # short: that it is full is no rare case
    return loop.Trace(
        np.zeros(length), np.zeros((length, 2), np.int64), np.zeros(1, np.int64), np.zeros((length, 2, 9))
    )


def _lists(n: int, nodes: int) -> schedule.Lists:
    """Empty, with so many unused nodes."""
    after = np.arange(1, nodes + 1, dtype=np.int32)
    after[-1] = -1
    return schedule.Lists(
        np.full(n, -1, np.int32), np.zeros(nodes), np.zeros(nodes, np.int32), np.zeros(nodes, np.int32), after,
        np.array([0, nodes], np.int32),
    )  # fmt: skip


def _with_more_nodes(store: schedule.Lists) -> schedule.Lists:
    """With twice the nodes; the new ones are chained before the unused ones."""
    size = store.time.size
    time, partner, count, after = (np.concatenate((array, np.zeros(size, array.dtype))) for array in store[1:5])
    after[size:] = np.arange(size + 1, 2 * size + 1)
    after[-1] = store.free[0]
    free = np.array([size, store.free[1] + size], np.int32)
    return schedule.Lists(store.heads, time, partner, count, after, free)


def _tree(n: int) -> schedule.Tree:
    return schedule.Tree(np.zeros(2 * n), np.zeros(2 * n, np.int32))


def _calendar(n: int) -> schedule.Calendar:
    buckets = 1 << (4 * n - 1).bit_length()
    return schedule.Calendar(
        np.zeros(n), np.zeros(n, np.int64), np.zeros(n, np.int32), np.zeros(n, np.int32),
        np.zeros(buckets, np.int32), np.zeros(1, np.int64), np.zeros(1),
    )  # fmt: skip


def _fields(shape: tuple[int, ...], blocks: tuple[int, ...], grid: loop.Grid, n: int, ints: Any) -> measure.Fields:
    cells = math.prod(shape)
    padded = (*shape, *[1] * (3 - len(shape)))
    sides = tuple(side * block for side, block in zip(grid.sides, blocks, strict=True))
    return measure.Fields(
        padded, blocks, sides, np.zeros(cells), np.zeros((cells, 3)), np.zeros(cells), np.zeros(cells),
        np.zeros((3, cells)), np.zeros((3, cells, 3)), np.zeros((3, cells)), np.zeros(cells), np.zeros(cells),
        np.zeros((cells, 3)), np.zeros(cells), np.zeros(n), ints,
    )  # fmt: skip
