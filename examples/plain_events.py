"""A slow engine, to be judged within a budget: event-driven hard spheres in plain numpy, O(N) work an event.

    crosscheck run --engine examples/plain_events.py:PlainEvents --budget 60

The algorithm of Alder and Wainwright without cells and without a queue: the earliest collision of each particle is
kept, and after an event it is predicted again for those whom it concerns. See `docs/slow-codes.md`.
"""

from __future__ import annotations

import numpy as np

from crosscheck.engines.capabilities import capability
from crosscheck.engines.protocol import Claims, Cost, Run, timed
from crosscheck.scene import Floats, Method, Scene

NOTHING = -1


class PlainEvents:
    name = "plain events"
    schemes = {"event_driven": Claims(kind="event_driven", reversible=None)}
    capabilities = (
        capability(
            "hard_spheres",
            "event_driven",
            words="dimension=2 dimension=3 box.boundaries=periodic box.boundaries=hard masses[] "
            "hard_spheres.restitution output.collisions",
            observables="positions velocities kinetic_energy dissipated_energy collisions collisional_virial "
            "wall_impulse wall_collisions event_times event_partners event_positions event_velocities",
        ),
    )

    def version(self) -> str:
        return f"1.0 (numpy {np.__version__})"

    def supports(self, scene: Scene, method: Method) -> str | None:
        return None if scene.number <= 5000 else "every event looks at all particles: at most 5000"

    def run(self, scene: Scene, method: Method) -> Run:
        cost = Cost()
        gas = Gas(scene)
        record = Record(scene, gas)
        counts = scene.output.collisions
        with timed(cost):
            if counts is None:
                for time in scene.samples()[1:]:
                    gas.advance(float(time))
                    record.sample()
                gas.advance(scene.duration)
            else:
                for count in counts:
                    gas.advance(scene.duration, count)
                    record.sample()
        cost.events = len(gas.event_times)
        stopped = counts is not None and gas.collisions < counts[-1]
        return record.run(cost, "the duration is over before the last collision" if stopped else "")


class Gas:
    """The spheres, their next collisions, and what they have given to the walls."""

    def __init__(self, scene: Scene) -> None:
        assert scene.hard_spheres is not None
        state = scene.initial_state()
        assert state.lengths is not None
        self.r, self.v, self.m = state.positions.copy(), state.velocities.copy(), state.masses
        self.diameter = float(np.atleast_1d(scene.hard_spheres.diameter)[0])
        self.restitution = scene.hard_spheres.restitution
        self.lengths = state.lengths
        self.periods = scene.periods()
        self.walls = self.periods == 0
        n, d = self.r.shape
        self.time = 0.0
        self.collisions, self.virial, self.dissipated = 0, 0.0, 0.0
        self.wall_impulse, self.wall_collisions = np.zeros((2 * d, d)), np.zeros(2 * d)
        self.event_times: list[float] = []
        self.events: list[tuple[int, int, Floats, Floats, Floats, Floats]] = []
        self.traced = scene.output.trace
        #: Time and partner of the earliest collision of each particle; time and axis of its earliest hit of a wall.
        self.pair_time, self.partner = np.full(n, np.inf), np.full(n, NOTHING)
        self.wall_time, self.wall_axis = np.full(n, np.inf), np.zeros(n, dtype=int)
        self.horizon = 0.0
        self.predict_all()

    # -- prediction ---------------------------------------------------------------------------------

    def predict_all(self) -> None:
        """Predicts everything again, for as long as the nearest image of a partner stays the nearest one."""
        fastest = 2 * float(np.sqrt((self.v**2).sum(axis=1).max()))
        room = np.min(self.periods[~self.walls] / 2, initial=np.inf) - self.diameter
        self.horizon = self.time + room / fastest if fastest > 0 else np.inf
        for i in range(len(self.r)):
            self.predict(i)

    def predict(self, i: int) -> None:
        """The earliest collision of particle i with any other one, and with a wall."""
        times = self.collision_times(i)
        j = int(times.argmin())
        self.pair_time[i], self.partner[i] = times[j], j if times[j] < np.inf else NOTHING
        sooner = times < self.pair_time
        self.pair_time[sooner], self.partner[sooner] = times[sooner], i
        self.predict_wall(i)

    def collision_times(self, i: int) -> Floats:
        """Times (N,) of the collisions of particle i: |d + u t| = sigma, the earlier root, if they approach."""
        d = self.r - self.r[i]
        d -= self.periods * np.rint(d / np.where(self.walls, 1.0, self.periods))
        u = self.v - self.v[i]
        b, uu = (d * u).sum(axis=1), (u * u).sum(axis=1)
        approach = b < 0
        approach[i] = False
        d, u, b, uu = d[approach], u[approach], b[approach], uu[approach]
        # at the closest approach: b^2 - u^2 (d^2 - sigma^2) would lose the digits of a pair that is far apart
        nearest = d - (b / uu)[:, None] * u
        root = uu * (self.diameter**2 - (nearest * nearest).sum(axis=1))
        meets = root >= 0
        c = (d * d).sum(axis=1) - self.diameter**2
        times = np.full(len(self.r), np.inf)
        after = np.maximum(c[meets] / (np.sqrt(root[meets]) - b[meets]), 0.0)
        times[np.flatnonzero(approach)[meets]] = self.time + after
        return times

    def predict_wall(self, i: int) -> None:
        v, radius = self.v[i], self.diameter / 2
        faces = np.where(v > 0, self.lengths - radius, radius)
        moving = self.walls & (v != 0)
        times = np.full(len(v), np.inf)
        times[moving] = self.time + np.maximum((faces - self.r[i])[moving] / v[moving], 0.0)
        axis = int(times.argmin())
        self.wall_time[i], self.wall_axis[i] = times[axis], axis

    # -- motion -------------------------------------------------------------------------------------

    def advance(self, until: float, collisions: int | None = None) -> None:
        """Goes from event to event up to the time `until`, or to so many collisions of pairs."""
        while collisions is None or self.collisions < collisions:
            i, k = int(self.pair_time.argmin()), int(self.wall_time.argmin())
            pair, wall = self.pair_time[i], self.wall_time[k]
            due = min(pair, wall, self.horizon)
            if due > until:
                self.move(until)
                return
            self.move(float(due))
            if due == self.horizon and due < min(pair, wall):
                self.predict_all()
            elif pair <= wall:
                self.collide(i, int(self.partner[i]))
            else:
                self.hit_wall(k, int(self.wall_axis[k]))

    def move(self, time: float) -> None:
        self.r += self.v * (time - self.time)
        self.time = time

    def collide(self, i: int, j: int) -> None:
        d = self.r[j] - self.r[i]
        d -= self.periods * np.rint(d / np.where(self.walls, 1.0, self.periods))
        normal = d / np.sqrt(d @ d)
        reduced = self.m[i] * self.m[j] / (self.m[i] + self.m[j])
        approach = float((self.v[i] - self.v[j]) @ normal)
        impulse = (1 + self.restitution) * reduced * approach
        self.v[i] -= impulse / self.m[i] * normal
        self.v[j] += impulse / self.m[j] * normal
        self.collisions += 1
        self.virial += self.diameter * impulse
        self.dissipated += 0.5 * (1 - self.restitution**2) * reduced * approach**2
        self.note(i, j)
        self.predict_after(i, j)

    def hit_wall(self, i: int, axis: int) -> None:
        face = 2 * axis + int(self.v[i, axis] > 0)
        self.wall_impulse[face, axis] += 2 * self.m[i] * self.v[i, axis]
        self.wall_collisions[face] += 1
        self.v[i, axis] *= -1
        self.note(i, -1 - face)
        self.predict_after(i)

    def predict_after(self, *changed: int) -> None:
        """Predicts for those whose velocity has changed, and for those who were to meet them."""
        waiting = np.flatnonzero(np.isin(self.partner, changed))
        self.pair_time[waiting], self.partner[waiting] = np.inf, NOTHING
        for i in {*changed, *waiting.tolist()}:
            self.predict(i)

    def note(self, i: int, j: int) -> None:
        self.event_times.append(self.time)
        if self.traced:
            nothing = np.zeros(self.r.shape[1])
            position, velocity = (self.r[j].copy(), self.v[j].copy()) if j >= 0 else (nothing, nothing)
            self.events.append((i, j, self.r[i].copy(), position, self.v[i].copy(), velocity))


class Record:
    """What is sampled of a gas; sample 0 is the start."""

    def __init__(self, scene: Scene, gas: Gas) -> None:
        self.scene, self.gas = scene, gas
        self.samples: list[dict[str, object]] = []
        self.sample()

    def sample(self) -> None:
        gas = self.gas
        self.samples.append(
            {
                "time": gas.time,
                "positions": gas.r.copy(),
                "velocities": gas.v.copy(),
                "kinetic_energy": 0.5 * float(gas.m @ (gas.v**2).sum(axis=1)),
                "dissipated_energy": gas.dissipated,
                "collisions": float(gas.collisions),
                "collisional_virial": gas.virial,
                "wall_impulse": gas.wall_impulse.copy(),
                "wall_collisions": gas.wall_collisions.copy(),
            }
        )

    def run(self, cost: Cost, stopped: str) -> Run:
        gas = self.gas
        run = Run(final_positions=gas.r, final_velocities=gas.v, cost=cost, stopped=stopped)
        for name in self.scene.asked():
            if name in self.samples[0]:
                run[name] = np.array([sample[name] for sample in self.samples])
        if self.scene.output.trace:
            run["event_times"] = np.array(gas.event_times)
            i, j, r_i, r_j, v_i, v_j = zip(*gas.events, strict=True) if gas.events else ((),) * 6
            d = gas.r.shape[1]
            run["event_partners"] = np.array([i, j], dtype=float).T.reshape(-1, 2)
            run["event_positions"] = np.stack([np.reshape(r_i, (-1, d)), np.reshape(r_j, (-1, d))], axis=1)
            run["event_velocities"] = np.stack([np.reshape(v_i, (-1, d)), np.reshape(v_j, (-1, d))], axis=1)
        return run
