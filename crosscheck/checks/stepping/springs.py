"""Oscillators that the checks of this group share."""

from __future__ import annotations

from crosscheck.engines.capabilities import Needs
from crosscheck.scene import Explicit, Output, Scene, Spring

# The documented case (SI units): m = 70 kg, k = 1e4 N/m, gamma = 100 kg/s, 5 s, r = 1 m, v = -A gamma/2m.
MASS, STIFFNESS = 70.0, 1e4
OMEGA0 = (STIFFNESS / MASS) ** 0.5
#: Undamped, on a line; damped.
SPRING = Needs("spring", words=frozenset({"dimension=1"}), observables=frozenset({"positions", "velocities"}))
DAMPED = Needs("spring", words=frozenset({"dimension=1", "spring.gamma"}), observables=SPRING.observables)

LITERATURE = (
    "Allen & Tildesley, Computer Simulation of Liquids (1987), chapter 3 and appendix E; "
    "Hairer, Lubich & Wanner, Geometric Numerical Integration (2006), chapters I, V and VI"
)


def unit_oscillator(duration: float, interval: float | None = None) -> Scene:
    """An undamped oscillator with omega0 = 1 that starts at a general phase.

    duration: of the run, in units of 1/omega0. interval: between samples, in the same; None: the end alone.
    """
    return Scene(
        name="oscillator-unit",
        dimension=1,
        duration=duration,
        spring=Spring(k=1.0),
        initial=Explicit(positions=((1.0,),), velocities=((0.7,),)),
        output=Output() if interval is None else Output(interval=interval, trajectory=True),
    )
