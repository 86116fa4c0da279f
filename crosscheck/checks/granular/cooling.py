"""An inelastic gas that cools: soft spheres of growing stiffness beside event-driven ones.

Literature: N. Mitarai and H. Nakanishi, Phys. Rev. E 67, 021301 (2003); S. Luding, Nonlinearity 22, R101 (2009).
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, soft, variants_of
from crosscheck.checks.granular.gases import RESOLUTION, convergence, energies, relaxed
from crosscheck.checks.granular.soft_grains import CONTACTS, REFERENCE, soft_needs
from crosscheck.convergence import WHY_ORDER
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.scene import Box, Floats, HardSpheres, Lattice, Output, Scene
from crosscheck.verdict import Judged

ALPHA = 0.8
#: Stiffnesses, in units of m T/sigma^2 at the start, and the number of initial states that each is run from.
STIFFNESSES = {1e3: 48, 1e4: 48, 1e5: 48, 1e6: 32, 1e7: 12}


class Gas(NamedTuple):
    """A gas of hard spheres, by the `name` of its variant, in `dimension` dimensions.

    structure: of the lattice it starts on. packing_fraction: the share of the box that the particles fill. time:
    duration, in which a particle collides about 3 times.
    """

    name: str
    dimension: Literal[2, 3]
    structure: Literal["square", "sc"]
    packing_fraction: float
    time: float


DISKS = Gas("disks", 2, "square", 0.5, 0.4)
SPHERES = Gas("spheres", 3, "sc", 0.3, 0.5)


def cooling_gas(gas: Gas) -> Scene:
    """1000 smooth inelastic disks or spheres in a periodic box, T = 1 at the start; gas: which ones."""
    return Scene(
        name="cooling",
        dimension=gas.dimension,
        duration=gas.time,
        hard_spheres=HardSpheres(restitution=ALPHA),
        box=Box(packing_fraction=gas.packing_fraction),
        initial=Lattice(kind="lattice", structure=gas.structure, number=1000, temperature=1.0, seed=0),
        output=Output(interval=gas.time / 8, observables=("kinetic_energy",)),
    )


def _judge_cooling(laboratory: Laboratory, gas: Gas) -> Judged:
    """T of soft over T of hard spheres, from the same states: power of the stiffness with which they converge."""
    scene = cooling_gas(gas)
    laboratory.demand(scene, soft(stiffness=min(STIFFNESSES), resolution=RESOLUTION))
    starts = [relaxed(laboratory, scene, f"state {i}", 2.0) for i in range(max(STIFFNESSES.values()))]
    hard = [energies(laboratory.run(start, EVENT_DRIVEN, engine=REFERENCE)) for start in starts]
    times = np.linspace(0.0, scene.duration, len(hard[0]))
    curves = [_temperature_curve("event-driven", times, np.mean(hard, axis=0), scene)]
    soft_ends = []
    for stiffness, number in STIFFNESSES.items():
        method = soft(stiffness=stiffness, resolution=RESOLUTION)
        runs = [energies(laboratory.run(start, method)) for start in starts[:number]]
        curves.append(
            _temperature_curve(f"k = {stiffness:.0e}, {laboratory.engine}", times, np.mean(runs, axis=0), scene)
        )
        soft_ends.append(np.array(runs)[:, -1])
    temperatures = Figure(f"Cooling {gas.name}: T(t)", "t", "T", series=tuple(curves))
    return convergence(
        f"T(k)/T of {gas.name}",
        laboratory.engine,
        "stiffness k sigma^2/(m T)",
        np.array(list(STIFFNESSES)),
        soft_ends,
        np.array(hard)[:, -1],
        0.5,
        f"t_c goes with k^(-1/2), and the first power of t_c leads: {WHY_ORDER}, of t_c",
        (temperatures,),
    )


def _temperature_curve(label: str, times: Floats, energy: Floats, scene: Scene) -> Series:
    temperature = 2 * energy / (scene.dimension * scene.number)
    return Series(label, times.tolist(), temperature.tolist(), theory=label == "event-driven")


CHECKS = (
    Check(
        name="granular/cooling",
        title="Inelastic gas: temperature of soft spheres of growing stiffness, beside the event-driven one",
        equation="T(k)/T - 1 = a k^(-1/2), k in m T/sigma^2",
        criterion="the fitted power of 1/k is 1/2 (of t_c: 1) within half a quarter; the stiffest agrees within errors",
        citation="Mitarai & Nakanishi, Phys. Rev. E 67, 021301 (2003); Luding, Nonlinearity 22, R101 (2009)",
        judge=_judge_cooling,
        variants=variants_of({gas.name: gas for gas in (DISKS, SPHERES)}, "full"),
        needs=soft_needs("method.contact.stiffness hard_spheres.restitution box.boundaries=periodic", "kinetic_energy"),
        faults=(
            (
                "disks",
                Fault(
                    "damping-of-the-mass",
                    CONTACTS,
                    "return coefficient * np.sqrt(mass * law[STIFFNESS] * scale)",
                    "return 0.98 * coefficient * np.sqrt(mass * law[STIFFNESS] * scale)",
                    "the dashpot is 2 % too weak: the restitution is 0.8036 instead of 0.8",
                ),
            ),
        ),
    ),
)
