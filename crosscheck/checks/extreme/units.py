"""The same scene in other units: lengths, times and masses by powers of two change no bit, however large they are.

A double's relative rounding does not depend on its exponent. So a scene whose numbers are multiplied by powers of two,
each as its unit says, must give the same numbers times the same powers, unless a code compares a quantity that has a
unit with a constant, or leaves the range of the doubles.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import NamedTuple, TypeAlias

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check
from crosscheck.checks.extreme.matrix import (
    RAN,
    Answer,
    Bound,
    Case,
    Expected,
    Measured,
    Trial,
    extreme_check,
    for_each,
)
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Run
from crosscheck.faults import Fault
from crosscheck.scene import (
    Box,
    Contact,
    Explicit,
    Floats,
    Gravity,
    HardSpheres,
    LennardJones,
    Output,
    Scene,
    Spring,
)


class Units(NamedTuple):
    """Powers of two by which all numbers are multiplied; length, time, mass: factors of their units."""

    length: float = 1.0
    time: float = 1.0
    mass: float = 1.0


#: What makes a scene in some units.
Maker: TypeAlias = Callable[[Units], Scene]

_X = np.array([[0.31, 0.42], [1.73, 0.67], [0.93, 1.91], [2.61, 2.12]])
_V = np.array([[0.21, -0.35], [-0.14, 0.27], [0.33, 0.12], [-0.42, -0.06]])
_M = (1.0, 0.7, 1.9, 0.4)
_STEPS, _DT = 48, 0.0371


def _explicit(units: Units) -> Explicit:
    speed = units.length / units.time
    return Explicit(
        positions=tuple(map(tuple, (_X * units.length).tolist())), velocities=tuple(map(tuple, (_V * speed).tolist()))
    )


def _masses(units: Units) -> tuple[float, ...]:
    return tuple(m * units.mass for m in _M)


def _output(units: Units) -> Output:
    return Output(interval=8 * _DT * units.time, trajectory=True)


def _gravity(units: Units) -> Scene:
    length, time, mass = units
    return Scene(
        name="units",
        dimension=2,
        duration=_STEPS * _DT * time,
        masses=_masses(units),
        gravity=Gravity(G=0.6 * length**3 / (mass * time**2)),
        initial=_explicit(units),
        output=_output(units),
    )


def _springs(units: Units) -> Scene:
    return Scene(
        name="units",
        dimension=2,
        duration=_STEPS * _DT * units.time,
        masses=_masses(units),
        spring=Spring(k=1.3 * units.mass / units.time**2, gamma=0.17 * units.mass / units.time),
        initial=_explicit(units),
        output=_output(units),
    )


def _fluid(units: Units) -> Scene:
    length, time, mass = units
    return Scene(
        name="units",
        dimension=2,
        duration=_STEPS * _DT * time,
        masses=_masses(units),
        lennard_jones=LennardJones(epsilon=0.8 * mass * length**2 / time**2, length=1.1 * length, cutoff=2.3 * length),
        box=Box(lengths=(5.3 * length, 4.9 * length)),
        initial=_explicit(units),
        output=_output(units),
    )


def _spheres(units: Units) -> Scene:
    """Disks of unlike masses in a periodic box, restitution 0.9."""
    length, time, _ = units
    return Scene(
        name="units",
        dimension=2,
        duration=_LATE * time,
        masses=_masses(units),
        hard_spheres=HardSpheres(diameter=1.1 * length, restitution=0.9),
        box=Box(lengths=(4.3 * length, 4.1 * length)),
        initial=_explicit(units),
        output=Output(interval=_LATE * time / 8, trajectory=True),
    )


#: Time of the runs of spheres: some tens of collisions. And the stiffness of soft ones.
_LATE, _STIFF = 64 * _DT, 8.0


def _contact(units: Units) -> Contact:
    return Contact(stiffness=_STIFF * units.mass / units.time**2)


#: By the names of cases: very long, short, slow, fast, heavy and light, and G m from 1e-20 to 1e20.
_UNITS = {
    "small-1e-20": Units(length=2.0**-66),
    "large-1e20": Units(length=2.0**66),
    "fast-1e-20": Units(time=2.0**-66),
    "slow-1e20": Units(time=2.0**66),
    "light-1e-20": Units(mass=2.0**-66),
    "heavy-1e20": Units(mass=2.0**66),
}
_COUPLINGS = {
    "Gm-1e-20": Units(time=2.0**33),
    "Gm-1e20": Units(time=2.0**-33),
}
_BITS = "numbers of the paths that differ from those in units near 1"
_SAME = Bound(_BITS, 0.0, "multiplying by powers of two rounds nothing: the same bits")
_RAN = Answer(RAN, "units are no reason to refuse a scene, or to end a run")


def _differences(trial: Trial, make: Maker, units: Units, soft: bool) -> Measured:
    """Numbers of positions and velocities that differ, once they are brought back to units near 1."""

    def run(of: Units) -> tuple[str, Run | None]:
        dt = None if trial.takes_no_step else _DT * of.time
        return trial.answer(lambda: make(of), dt, _contact(of) if soft else None)

    def paths(found: Run | None, of: Units) -> Floats:
        if found is None:
            return np.full(1, np.nan)
        return np.concatenate([found["positions"] / of.length, found["velocities"] * (of.time / of.length)], axis=2)

    (_, near), (answer, far) = run(Units()), run(units)
    return Measured({_BITS: float(np.count_nonzero(paths(near, Units()) != paths(far, units)))}, answer)


def _check(
    name: str,
    make: Maker,
    needs: Needs,
    methods: tuple[str, ...],
    fault: tuple[str, Fault],
    units: Mapping[str, Units],
    *,
    soft: bool = False,
    failing: tuple[str, ...] = (),
) -> Check:
    """The check of one kind of scene.

    methods: of the quick tier; all others of the engine are not judged. failing: names of units in which LAMMPS cannot
    sort particles into its cells.
    """

    def expected(of: str) -> dict[str, tuple[Expected, ...]]:
        rows = for_each(methods, _SAME, _RAN)
        if of in failing:
            rows["velocity_verlet@lammps"] = (Answer("failed", "LAMMPS's cells for neighbours have no such sizes"),)
        return rows

    cases = tuple(
        Case(
            case,
            f"lengths times {of.length:.3g}, times {of.time:.3g}, masses {of.mass:.3g}",
            partial(_differences, make=make, units=of, soft=soft),
            expected(case),
        )
        for case, of in units.items()
    )
    return extreme_check(
        f"units-{name}",
        f"{name.replace('-', ' ').capitalize()} in units from 1e-20 to 1e20: the same bits",
        "x(t; L, T, M) = L x(t/T; 1, 1, 1) for factors that are powers of two",
        "IEEE Standard for Floating-Point Arithmetic 754 (2019); Goldberg, ACM Comput. Surv. 23, 5 (1991)",
        cases,
        needs,
        (fault,),
    )


#: A length that has no unit, added at each step.
_STRAY = Fault(
    "length-without-unit",
    "stepping/schemes.py",
    "        v_half, r = kick_drift(r, v, memory[0], dt)\n",
    "        v_half, r = kick_drift(r + 1e-30, v, memory[0], dt)\n",
    "velocity Verlet adds a length of 1e-30, whatever the unit, at each step",
)
_PATHS = frozenset({"positions", "velocities"})
_PLANE = {"dimension=2", "masses[]"}

CHECKS = (
    _check(
        "gravity",
        _gravity,
        Needs("gravity", words=frozenset({*_PLANE, "gravity.G"}), observables=_PATHS),
        ("velocity_verlet", "leapfrog", "gear5", "ias15", "whfast"),
        ("small-1e-20/velocity_verlet", _STRAY),
        _UNITS | _COUPLINGS,
    ),
    _check(
        "springs",
        _springs,
        Needs("spring", words=frozenset({*_PLANE, "spring.gamma"}), observables=_PATHS),
        ("velocity_verlet", "verlet", "beeman_pc", "euler_pc", "gear4_velocity"),
        ("small-1e-20/velocity_verlet", _STRAY),
        _UNITS,
    ),
    _check(
        "lennard-jones",
        _fluid,
        Needs("lennard_jones", words=frozenset({*_PLANE, "box.boundaries=periodic"}), observables=_PATHS),
        ("velocity_verlet",),
        ("small-1e-20/velocity_verlet", _STRAY),
        _UNITS,
        failing=("small-1e-20", "large-1e20"),
    ),
    _check(
        "soft-grains",
        _spheres,
        Needs(
            "hard_spheres",
            words=frozenset({*_PLANE, "box.boundaries=periodic", "hard_spheres.restitution", "method.contact"}),
            observables=_PATHS,
        ),
        ("velocity_verlet",),
        ("small-1e-20/velocity_verlet", _STRAY),
        _UNITS,
        soft=True,
        failing=("small-1e-20", "large-1e20"),
    ),
    _check(
        "hard-spheres",
        _spheres,
        Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=frozenset({*_PLANE, "box.boundaries=periodic", "hard_spheres.restitution"}),
            observables=_PATHS,
        ),
        ("event_driven", "event_driven_lists", "event_driven_calendar", "event_driven_naive"),
        (
            "small-1e-20/event_driven",
            Fault(
                "impulse-without-unit",
                "events/rules.py",
                "    normal = -(1.0 + alpha) * gn * mass\n",
                "    normal = -(1.0 + alpha) * gn * mass - 1e-30\n",
                "a collision has an impulse of 1e-30 more, whatever the unit",
            ),
        ),
        _UNITS,
    ),
)
