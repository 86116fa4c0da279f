"""The reference implementations of `refimpl` as an engine."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from crosscheck.engines import soft_spheres
from crosscheck.engines.protocol import Claims, Run
from crosscheck.scene import Method, Scene
from refimpl.stepping.schemes import SCHEMES

if TYPE_CHECKING:
    pass

NAIVE = "event_driven_naive"
#: Event-driven schemes, and the queue of events that `refimpl.events` calls by that name.
SCHEDULERS = {
    "event_driven": "tree",
    "event_driven_lists": "lists",
    "event_driven_calendar": "calendar",
    NAIVE: "naive",
}
#: Schemes of lattice gases, and the class of `refimpl.lattice` that moves them.
EVOLVERS = {
    "lattice_planes": "bitplanes.PlaneGas",
    "lattice_lookup": "lookup.LookupGas",
    "lattice_numpy": "plain.PlainGas",
    "lattice_boltzmann": "boltzmann.BoltzmannLattice",
}
#: Schemes that move soft grains: the stretch of a contact grows once a step, at the new time.
GRAINS = ("velocity_verlet", "leapfrog", "verlet", "symplectic_euler")
#: What can be told from the states of the naive algorithm.
_PLAIN = ("kinetic_energy", "potential_energy", "rotational_energy", "collisions", "events")


class RefimplEngine:
    name = "refimpl"
    schemes = {name: Claims(s.order, s.order_damped, s.symplectic, s.reversible) for name, s in SCHEMES.items()} | {
        name: Claims(None, events=True) for name in SCHEDULERS
    }
    schemes |= {name: Claims(None, lattice=True) for name in EVOLVERS}

    def version(self) -> str:
        import numba

        from crosscheck import __version__

        return f"{__version__} (numba {numba.__version__})"

    def supports(self, scene: Scene, method: Method) -> str | None:
        if method.scheme not in self.schemes:
            return f"no scheme '{method.scheme}'"
        if (scene.lattice_gas is not None) != (method.scheme in EVOLVERS):
            return f"lattice gases, and only they, are moved by {_names(EVOLVERS)}; found '{method.scheme}'"
        if scene.lattice_gas is not None:
            from crosscheck.engines.refimpl.lattice import unsupported

            return unsupported(scene, method.scheme)
        if method.contact is not None and method.scheme in SCHEDULERS:
            return f"method.contact is for schemes with time steps: {_names(GRAINS)}"
        if scene.hard_spheres is not None and method.scheme not in SCHEDULERS:
            if method.contact is not None and method.scheme not in GRAINS:
                return f"soft grains need a scheme that asks for the force once a step: {_names(GRAINS)}"
            return soft_spheres.unsupported(scene, method)
        if scene.hard_spheres is None and method.scheme in SCHEDULERS:
            return f"'{method.scheme}' is for [hard_spheres] only: take a scheme with time steps"
        if method.scheme == NAIVE and scene.hard_spheres is not None:
            unknown: list[str] = [name for name in scene.output.observables if name not in _PLAIN]
            if scene.output.fields is not None:
                unknown.append("fields")
            if unknown:
                return f"'{NAIVE}' is the plain algorithm, which does not measure {', '.join(unknown)}"
        return None

    def run(self, scene: Scene, method: Method) -> Run:
        if scene.lattice_gas is not None:
            from crosscheck.engines.refimpl.lattice import run_lattice

            return run_lattice(scene, method.scheme, EVOLVERS[method.scheme])
        if scene.hard_spheres is not None and method.contact is not None:
            from crosscheck.engines.refimpl.grains import run_grains

            return run_grains(scene, method)
        if scene.hard_spheres is not None:
            from crosscheck.engines.refimpl.events import run_events

            return run_events(scene, SCHEDULERS[method.scheme])
        from crosscheck.engines.refimpl.stepping import run_steps

        return run_steps(scene, method)


def _names(names: Iterable[str]) -> str:
    return ", ".join(f"'{name}'" for name in names)
