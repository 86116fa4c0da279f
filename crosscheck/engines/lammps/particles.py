"""Springs, gravity and Lennard-Jones particles in LAMMPS."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations_with_replacement
from typing import Any

import numpy as np

from crosscheck.engines.lammps.instance import FEW, Atoms, advance, box, pair_virial, three
from crosscheck.engines.protocol import Run, strides
from crosscheck.scene import Floats, Method, Scene, State

#: Size of the box and cutoff in open space: larger than any orbit, and its square and cube are finite numbers.
_FAR = 1e50
#: Largest number of bodies with gravity: the neighbour list holds all pairs, at most 2000 neighbours of an atom.
MOST_BODIES = 2000
_LJ_STYLES = {"truncated": "lj/cut/opt", "shifted": "lj/cut/opt", "force_shifted": "lj/smooth/linear"}
#: Skin of the lists of Lennard-Jones particles in largest sigmas, as in LAMMPS's own benchmark.
_SKIN = 0.3


def integrate(lammps: Any, lmp: Any, scene: Scene, method: Method) -> Run:
    """Runs a scene of springs, gravity or Lennard-Jones particles.

    lammps: the module. lmp: a new LAMMPS instance. scene, method: as for `Engine.run`.
    """
    system = _System(lmp, scene, scene.initial_state())
    _, every = strides(scene, method)
    output = scene.output
    lmp.commands_list(
        ["fix integrate all nve", *(["fix plane all enforce2d"] if scene.dimension < 3 else [])]
        + [line for name in output.observables for line in _record(name, scene.dimension, every)]
    )
    run, good = advance(lmp, system, scene, method)
    for name in output.observables:
        values = np.full(run["time"].size, np.nan)
        for i in range(good):
            values[i] = lmp.extract_fix(name, lammps.LMP_STYLE_GLOBAL, lammps.LMP_TYPE_VECTOR, i)
        run[name] = values
    if output.forces:
        nan_state = np.full_like(run["final_positions"], np.nan)
        run["forces"] = nan_state if run.diverged else _forces(lmp, system, output.observables)
    return run


def _record(name: str, dimension: int, every: int) -> list[str]:
    """Commands that record an observable inside LAMMPS, without a call to Python per sample."""
    if name == "kinetic_energy":
        return ["compute kinetic all ke", f"fix {name} all vector {every} c_kinetic"]
    if name == "potential_energy":
        return [f"fix {name} all vector {every} c_thermo_pe"]
    return [*pair_virial(dimension), f"fix {name} all vector {every} v_virial"]


def _forces(lmp: Any, system: _System, observables: tuple[str, ...]) -> Floats:
    """Forces at the final state, evaluated again: those of the last step have friction at the half-step velocity."""
    lmp.commands_list([f"unfix {name}" for name in observables] + ["run 0 post no"])
    return system.forces()


class _System(Atoms):
    """The particles of springs, Lennard-Jones or gravity, and their forces."""

    def __init__(self, lmp: Any, scene: Scene, state: State) -> None:
        super().__init__(lmp, scene, state)
        of_particles = kinds(scene)
        self.types = sorted(set(of_particles))
        style = "charge" if scene.gravity is not None else "atomic"
        lmp.commands_list(["units lj", f"atom_style {style}", *self._box(scene, state)])
        lmp.commands_list([f"mass {i} {mass!r}" for i, (_, mass) in enumerate(self.types, 1)])
        start = np.zeros_like(self.wrapped) if scene.spring is not None else self.wrapped
        self.create([self.types.index(kind) + 1 for kind in of_particles], start)

        if scene.gravity is not None:
            self.assign("q", state.masses)
        if scene.spring is not None:
            lmp.commands_list(list(_spring(scene)))
            # `fix spring/self` has taken the atoms' positions as anchors: the origin; now they move to their own places
            self.assign("x", np.reshape(three(self.wrapped), (-1, 3)))
        else:
            lmp.commands_list(list(_gravity(scene) if scene.gravity else _lennard_jones(scene, self.types)))

    def _box(self, scene: Scene, state: State) -> Iterator[str]:
        styles = ["p"] * 3
        edges = [(-0.5, 0.5)] * 3
        for axis, boundary in enumerate(scene.boundaries):
            x = state.positions[:, axis]
            if scene.lennard_jones is None:
                styles[axis], edges[axis] = "f", (-_FAR, _FAR)
            elif boundary == "open":
                styles[axis], edges[axis] = "s", (float(x.min()) - 1.0, float(x.max()) + 1.0)
            else:
                assert state.lengths is not None
                styles[axis], edges[axis] = "p" if boundary == "periodic" else "f", (0.0, float(state.lengths[axis]))
        yield from box(scene.dimension, styles, edges, len(self.types), sort=scene.box is not None)


def kinds(scene: Scene) -> list[tuple[int, float]]:
    """(species, mass) of every particle of `scene`: in LAMMPS, both belong to the type of an atom."""
    number = scene.number
    masses = [scene.masses] * number if isinstance(scene.masses, float) else list(scene.masses)
    return list(zip(scene.species or [0] * number, masses, strict=True))


def _spring(scene: Scene) -> Iterator[str]:
    """Commands for springs to the origin, and their damping."""
    assert scene.spring is not None
    yield "pair_style none"
    yield "neigh_modify once yes"  # no neighbour lists are needed
    yield f"fix spring all spring/self {scene.spring.k!r}"
    yield "fix_modify spring energy yes"
    if scene.spring.gamma is not None:
        yield f"fix friction all viscous {scene.spring.gamma!r}"


def _gravity(scene: Scene) -> Iterator[str]:
    """Commands for Coulomb's law with the masses as charges and the dielectric constant -1/G, which is gravity."""
    assert scene.gravity is not None
    yield f"dielectric {-1.0 / scene.gravity.G!r}"
    if scene.gravity.softening is None:
        yield f"pair_style coul/cut {_FAR!r}"
        yield "pair_coeff * *"
    else:
        # lambda^n q_i q_j/sqrt(alpha (1 - lambda)^2 + r^2), with n = lambda = 0 and 0^0 = 1
        yield f"pair_style coul/cut/soft 0.0 {scene.gravity.softening**2!r} {_FAR!r}"
        yield "pair_coeff * * 0.0"
    yield "neighbor 1.0 nsq"
    yield f"neigh_modify once yes one {MOST_BODIES} page {50 * MOST_BODIES}"  # all pairs: never rebuilt


def _lennard_jones(scene: Scene, types: list[tuple[int, float]]) -> Iterator[str]:
    """Commands for Lennard-Jones pairs and walls. types: (species, mass) of each atom type."""
    lj = scene.lennard_jones
    assert lj is not None
    to_sigma = 2 ** (-1 / 6) if lj.length_form == "r_m" else 1.0

    def of(values: float | tuple[float, ...], species: int) -> float:
        return values if isinstance(values, float) else values[species]

    sigmas = [to_sigma * of(lj.length, species) for species, _ in types]
    epsilons = [of(lj.epsilon, species) for species, _ in types]
    yield f"pair_style {_LJ_STYLES[lj.truncation]} {lj.cutoff!r}"
    yield f"pair_modify tail no shift {'yes' if lj.truncation == 'shifted' else 'no'}"
    for i, j in combinations_with_replacement(range(len(types)), 2):
        same = epsilons[i] == epsilons[j]
        epsilon = epsilons[i] if same else float(np.sqrt(epsilons[i] * epsilons[j]))  # Berthelot
        yield f"pair_coeff {i + 1} {j + 1} {epsilon!r} {0.5 * (sigmas[i] + sigmas[j])!r}"  # Lorentz
    few_unbounded = "open" in scene.boundaries and scene.number <= FEW
    yield f"neighbor {_SKIN * max(sigmas)!r} {'nsq' if few_unbounded else 'bin'}"
    yield "neigh_modify every 1 delay 0 check yes"
    wall = None if scene.box is None else scene.box.wall
    if wall is not None:
        assert scene.box is not None
        lengths = scene.lengths()
        assert lengths is not None
        shape = f"{wall.epsilon!r} {wall.sigma!r} {wall.cutoff!r}"
        faces = [
            f"{axis}lo 0.0 {shape} {axis}hi {float(length)!r} {shape}"
            for axis, length, boundary in zip("xyz", lengths, scene.boundaries, strict=False)
            if boundary == "wall"
        ]
        yield f"fix walls all wall/lj126 {' '.join(faces)}"
        yield "fix_modify walls energy yes"
