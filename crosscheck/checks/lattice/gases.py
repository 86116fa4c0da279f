"""Scenes of lattice gases, and what the checks of this folder share.

Units: links and steps; d is the mean occupation of a channel.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from crosscheck.checks.base import Laboratory, Tier, Variant
from crosscheck.engines.capabilities import refusal
from crosscheck.engines.protocol import Kind, Run
from crosscheck.engines.registry import engine_class
from crosscheck.errors import Unsupported
from crosscheck.faults import Fault
from crosscheck.references.lattice_models import MODELS, VELOCITIES
from crosscheck.scene import Floats, LatticeGas, Method, Occupations, Output, Scene
from crosscheck.verdict import Findings, controls, statistical, worst

#: A method by its kind: the engine's own first scheme that moves a lattice gas.
LATTICE: Kind = "lattice"
ISOTROPIC = tuple(name for name in MODELS if name != "hpp")
FHP = "Frisch et al., Complex Systems 1, 649 (1987)"

#: Faults of the tables, which several checks must see.
NO_COLLISIONS = Fault(
    "no-collisions",
    "lattice/models.py",
    "            outcomes[state] = cycle if identity",
    "            outcomes[state] = (state,) if velocities.channels < 7 else cycle if identity",
    "six-bit and HPP particles never collide",
)
ONE_OUTCOME = Fault(
    "one-outcome",
    "lattice/models.py",
    "            outcomes[state] = cycle if identity",
    "            outcomes[state] = (members[0],) if len(members) > 1 else cycle if identity",
    "all states of a class turn into its first one: no semi-detailed balance",
)


class State(NamedTuple):
    """A gas at rest; model: its name; density: d, the mean occupation of a channel."""

    model: str
    density: float


def at_densities(names: Iterable[str], densities: Iterable[float], tier: Tier = "full") -> tuple[Variant, ...]:
    """Variants such as fhp1-d0.3, whose values are `State`.

    names: of the models. densities: d of each. tier: of all of them.
    """
    return tuple(Variant(f"{name}-d{density:g}", State(name, density), tier) for name in names for density in densities)


def gas_scene(
    name: str, model: str, rows: int, columns: int, steps: int, initial: Occupations, output: Output, **gas: Any
) -> Scene:
    """A lattice gas of rows x columns sites for so many steps.

    name: of the scene. model: name of the gas. initial: occupations at the start. output: what is measured. gas:
    further entries of `LatticeGas`.
    """
    return Scene(
        name=name,
        dimension=2,
        duration=steps,
        lattice_gas=LatticeGas(model=model, rows=rows, columns=columns, **gas),
        initial=initial,
        output=output,
    )


def filled(density: float | tuple[float, ...], seed: int, **more: Any) -> Occupations:
    """Channels filled at random in local equilibrium.

    density: d, one or per row. seed: of the random numbers. more: further entries of `Occupations`.
    """
    return Occupations(kind="occupations", density=density, seed=seed, **more)


def filled_channels(occupations: Floats, seed: int) -> Occupations:
    """Channels filled at random with the mean `occupations`, (b,), at every site; seed: of the random numbers."""
    return Occupations(kind="occupations", channels=tuple(occupations.tolist()), seed=seed)


def populations(run: Run) -> Floats:
    """Numbers of particles in `run`, (samples, blocks along x, along y, b)."""
    return run["populations"]


def methods_for(engine: str, scene: Scene) -> list[Method]:
    """The engine's lattice schemes that can be given this scene, in its own order."""
    declared = engine_class(engine)
    methods = [Method(scheme=name) for name, claims in declared.schemes.items() if claims.kind == LATTICE]
    return [method for method in methods if refusal(declared, scene, method) is None]


def boltzmann_method(laboratory: Laboratory) -> Method:
    """The first scheme of the laboratory's engine that iterates mean occupations, that is, measures H.

    Unsupported if there is none.
    """
    probe = gas_scene("probe", "hpp", 2, 2, 0, filled(0.5, 0), Output(interval=1, observables=("h_function",)))
    found = methods_for(laboratory.engine, probe)
    if not found:
        raise Unsupported(f"{laboratory.engine}: no lattice scheme with h_function")
    return found[0]


# -- starting states -------------------------------------------------------------------------------------


def started(found: ArrayLike, asked: ArrayLike, model: str, sites: int) -> Findings:
    """Controls: mass and momentum a site at the start, which later numbers are divided by, are those asked for.

    found: populations a site, (b,). asked: mean occupations, (b,), of channels that are filled independently. model:
    name of the gas. sites: their number.
    """
    c = VELOCITIES[model].cartesian
    counts, f = np.asarray(found, dtype=np.float64), np.asarray(asked, dtype=np.float64)
    weights = {"particles": np.ones(len(c)), "momentum along x": c[:, 0], "momentum along y": c[:, 1]}
    return controls(
        worst(
            [
                statistical(
                    f"{label} a site at the start",
                    float(counts @ w),
                    float((w**2 @ (f * (1 - f)) / sites) ** 0.5),
                    float(np.round(f @ w, 12)),  # a sum that cancels is 0
                    0.0,
                    "standard error of independent channels",
                    samples=sites,
                )
                for label, w in weights.items()
            ]
        )
    )


def away(model: str, f: Floats) -> Floats:
    """Occupations (b,) with the mass and the momentum of f (b,), half as far from it as occupations of 0 to 1 allow.

    model: name of the gas.
    """
    velocities = VELOCITIES[model]
    charges = np.vstack([np.ones(velocities.channels), velocities.cartesian.T])
    # a direction that changes neither mass nor momentum
    direction = np.linalg.svd(charges)[2][-1]
    room = np.where(direction > 0, (1 - f) / np.maximum(direction, 1e-30), f / np.maximum(-direction, 1e-30)).min()
    return np.asarray(f + 0.5 * room * direction)
