"""A lattice-gas engine of another hand, HPP and FHP-I, and the same with mistakes that such codes have had.

The checks of lattice gases must be green for the first and red for each of the others.
"""

from __future__ import annotations

import numpy as np

from crosscheck.engines.capabilities import capability
from crosscheck.engines.protocol import Claims, Run, shapes
from crosscheck.scene import Method, Scene

#: Where a particle goes, (columns, rows), by channel: from even rows of the triangular lattice, and from odd ones.
_EVEN = ((1, 0), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1))
_ODD = ((1, 0), (1, 1), (0, 1), (-1, 0), (0, -1), (1, -1))
_SQUARE = ((1, 0), (0, 1), (-1, 0), (0, -1))


class GoodEngine:
    """Occupations as truth values, moved by index arithmetic; every random number is drawn from one generator."""

    name = "good"
    schemes = {"lattice": Claims(kind="lattice")}
    capabilities = (
        capability(
            "lattice_gas",
            "lattice",
            words="""
                dimension=2 lattice_gas.obstacles lattice_gas.obstacles.columns lattice_gas.obstacles.rows
                lattice_gas.obstacles.centre lattice_gas.obstacles.radius lattice_gas.obstacles.sites
                lattice_gas.obstacles.rule=bounce_back lattice_gas.obstacles.rule=specular_x
                lattice_gas.obstacles.rule=specular_y lattice_gas.obstacles.rule=diffusive_x
                lattice_gas.obstacles.rule=diffusive_y lattice_gas.force
            """,
            observables="populations sites force_impulse",
        ),
    )

    def version(self) -> str:
        return "1"

    def supports(self, scene: Scene, method: Method) -> str | None:
        known = scene.lattice_gas is not None and scene.lattice_gas.model in ("hpp", "fhp1")
        return None if known else "HPP and FHP-I alone"

    def run(self, scene: Scene, method: Method) -> Run:
        gas = scene.lattice_gas
        assert gas is not None
        self.hexagonal = gas.model == "fhp1"
        channels = 6 if self.hexagonal else 4
        n = (scene.initial_sites()[..., None] >> np.arange(channels) & 1).astype(bool)
        rules = scene.wall_rules()
        walls = np.zeros(n.shape[:2], dtype=int) if rules is None else rules.astype(int)
        seed = scene.seed if scene.seed is not None else getattr(scene.initial, "seed", 0)
        self.generator = np.random.default_rng([seed, 1])
        impulse = np.zeros(gas.rows)
        times = scene.samples()
        run = Run({name: np.zeros(shape) for name, shape in shapes(scene, times.size).items()})
        run["time"] = times
        across, down = scene.output.fields or (1, 1)
        for step in range(int(scene.duration) + 1):
            if step:
                n = self.step(n, walls, gas.force, impulse, step)
            for sample in np.flatnonzero(times == step):
                if "populations" in run:
                    blocks = n.reshape(down, gas.rows // down, across, gas.columns // across, channels)
                    run["populations"][sample] = blocks.sum(axis=(1, 3)).transpose(1, 0, 2)
                if "force_impulse" in run:
                    run["force_impulse"][sample] = impulse
        if "sites" in run:
            run["sites"] = n @ (1 << np.arange(channels))
        return run

    def step(self, n: np.ndarray, walls: np.ndarray, force: float | None, impulse: np.ndarray, step: int) -> np.ndarray:
        n = self.propagated(n)
        solid = walls > 0
        reflected = self.reflected(n, walls)
        if force is not None:
            plus, minus = (0, n.shape[2] // 2) if force >= 0 else (n.shape[2] // 2, 0)
            goes = ~solid & n[..., minus] & ~n[..., plus] & (self.generator.random(solid.shape) < self.rate(force))
            n[..., minus] &= ~goes
            n[..., plus] |= goes
            impulse += 2 * np.copysign(goes.sum(axis=1), force)
        return np.where(solid[..., None], reflected, self.collided(n, step))

    def rate(self, force: float) -> float:
        return abs(force)

    def propagated(self, n: np.ndarray) -> np.ndarray:
        rows, columns, channels = n.shape
        after = np.zeros_like(n)
        column = np.arange(columns)
        for row in range(rows):
            for i, (a, b) in enumerate(self.links(row)[:channels]):
                after[(row + b) % rows, (column + a) % columns, i] = n[row, :, i]
        return after

    def links(self, row: int) -> tuple[tuple[int, int], ...]:
        return (_ODD if row % 2 else _EVEN) if self.hexagonal else _SQUARE

    def reflected(self, n: np.ndarray, walls: np.ndarray) -> np.ndarray:
        coin = self.coins(walls.shape)
        for flag, drawn, image in (
            (1, 4, [3, 2, 1, 0, 5, 4] if self.hexagonal else [2, 1, 0, 3]),
            (2, 8, [0, 5, 4, 3, 2, 1] if self.hexagonal else [0, 3, 2, 1]),
        ):
            turns = (walls & flag > 0) | ((walls & drawn > 0) & coin)
            n = np.where(turns[..., None], n[..., image], n)
        return n

    def coins(self, shape: tuple[int, ...]) -> np.ndarray:
        return self.generator.random(shape) < 0.5

    def collided(self, n: np.ndarray, step: int) -> np.ndarray:
        number = n.sum(axis=-1)
        half = n.shape[2] // 2
        head_on = (number == 2) & (n & np.roll(n, half, axis=-1)).any(axis=-1)
        left = self.turns_left(n.shape[:2], step) if self.hexagonal else np.ones(n.shape[:2], dtype=bool)
        turned = np.where(left[..., None], np.roll(n, 1, axis=-1), np.roll(n, -1, axis=-1))
        n = np.where((head_on & self.collides(head_on))[..., None], turned, n)
        if self.hexagonal:
            symmetric = (number == 3) & (n[..., ::2].all(axis=-1) | n[..., 1::2].all(axis=-1))
            n = np.where(symmetric[..., None], ~n, n)
        return n

    def collides(self, head_on: np.ndarray) -> np.ndarray:
        return np.ones_like(head_on)

    def turns_left(self, shape: tuple[int, ...], step: int) -> np.ndarray:
        return self.generator.random(shape) < 0.5


class OneWay(GoodEngine):
    """Head-on pairs always turn counter-clockwise."""

    name = "one-way"

    def turns_left(self, shape: tuple[int, ...], step: int) -> np.ndarray:
        return np.ones(shape, dtype=bool)


class TakingTurns(GoodEngine):
    """Head-on pairs turn one way at even steps, the other way at odd ones: half of them each way."""

    name = "taking-turns"

    def turns_left(self, shape: tuple[int, ...], step: int) -> np.ndarray:
        return np.full(shape, step % 2 == 0)


class SameEveryStep(GoodEngine):
    """The random bits of the lattice are drawn once, and used at every step."""

    name = "same-every-step"

    def turns_left(self, shape: tuple[int, ...], step: int) -> np.ndarray:
        return np.random.default_rng(5).random(shape) < 0.5


class PassThrough(GoodEngine):
    """Head-on pairs pass through each other."""

    name = "pass-through"

    def collides(self, head_on: np.ndarray) -> np.ndarray:
        return np.zeros_like(head_on)


class EvenRows(GoodEngine):
    """Odd rows are moved as even ones are."""

    name = "even-rows"

    def links(self, row: int) -> tuple[tuple[int, int], ...]:
        return super().links(0)


class DoubleForce(GoodEngine):
    """The force turns twice as many particles as it should, and counts them rightly."""

    name = "double-force"

    def rate(self, force: float) -> float:
        return 2 * abs(force)


class Slipping(GoodEngine):
    """Walls without slip reflect as smooth ones."""

    name = "slipping"

    def reflected(self, n: np.ndarray, walls: np.ndarray) -> np.ndarray:
        return super().reflected(n, np.where(walls == 3, 2, walls))


class OneCoinARow(GoodEngine):
    """A diffusive wall draws one number for a whole row."""

    name = "one-coin-a-row"

    def coins(self, shape: tuple[int, ...]) -> np.ndarray:
        return np.broadcast_to(self.generator.random((shape[0], 1)) < 0.5, shape)


#: Those that must turn red, and in which variants of which check they do at the latest.
WRONG = {
    OneWay: ("lattice/outcomes", "fhp1-3"),
    TakingTurns: ("lattice/outcomes", "fhp1-3"),
    SameEveryStep: ("lattice/outcomes", "fhp1-3"),
    PassThrough: ("lattice/audit", "rows-1"),
    EvenRows: ("lattice/audit", "rows-0"),
    DoubleForce: ("lattice/audit", "rows-1"),
    Slipping: ("lattice/audit", "rows-1"),
    OneCoinARow: ("lattice/outcomes", "fhp1-driven-3"),
}
