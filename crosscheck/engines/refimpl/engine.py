"""The reference implementations of `refimpl` as an engine."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from numpy.typing import NDArray

from crosscheck.engines import soft_spheres
from crosscheck.engines.capabilities import capability
from crosscheck.engines.protocol import Claims, Run
from crosscheck.engines.refimpl.continuation import Continuation
from crosscheck.scene import Method, Scene
from crosscheck.scene.observables import named
from refimpl.stepping.schemes import COMPENSATED, SCHEMES

NAIVE = "event_driven_naive"
BOLTZMANN = "lattice_boltzmann"
#: Event-driven schemes, and the queue of events that `refimpl.events` calls by that name.
SCHEDULERS = {
    "event_driven": "tree",
    "event_driven_lists": "lists",
    "event_driven_calendar": "calendar",
    "event_driven_neighbours": "neighbours",
    NAIVE: "naive",
}
#: Schemes of lattice gases, and the class of `refimpl.lattice` that moves them.
EVOLVERS = {
    "lattice_planes": "bitplanes.PlaneGas",
    "lattice_lookup": "lookup.LookupGas",
    "lattice_numpy": "plain.PlainGas",
    BOLTZMANN: "boltzmann.BoltzmannLattice",
}
#: Schemes that move soft grains: in them, the tangential stretch of a contact grows once a step, at the new time.
GRAINS = ("velocity_verlet", "leapfrog", "verlet", "symplectic_euler")


_STATES = "positions velocities"
_SMOOTH = f"{_STATES} forces kinetic_energy potential_energy virial"
_HARD = f"{_STATES} angular_velocities kinetic_energy potential_energy rotational_energy"
_TRACE = "event_times event_partners event_positions event_velocities event_angular_velocities"
_SPRINGS = "dimension=1 dimension=2 dimension=3 masses[] spring.gamma"
_GRAVITY = "dimension=2 dimension=3 masses[] masses=0 gravity.G gravity.softening method.threads"
_FLUIDS = """
    dimension=2 dimension=3 masses[] box.boundaries=periodic box.boundaries=open box.boundaries=wall
    box.wall box.wall.epsilon box.wall.sigma lennard_jones.epsilon lennard_jones.epsilon[]
    lennard_jones.length lennard_jones.length[] lennard_jones.length_form=sigma
    lennard_jones.length_form=r_m lennard_jones.truncation=truncated lennard_jones.truncation=shifted
    lennard_jones.truncation=force_shifted method.threads
"""
#: Words of hard spheres that event-driven schemes and schemes with soft contacts understand.
_SPHERES = """
    dimension=2 dimension=3 masses[] acceleration hard_spheres.diameter hard_spheres.diameter[] hard_spheres.restitution
    hard_spheres.friction hard_spheres.friction.static hard_spheres.friction.sliding hard_spheres.friction.inertia
    box.boundaries=periodic box.boundaries=open box.boundaries=hard
    box.faces box.faces.open box.faces.restitution box.faces.oscillation box.faces.oscillation.phase
    box.faces.friction box.faces.friction.static box.faces.friction.sliding
    box.cylinder box.cylinder.axis=x box.cylinder.axis=y box.cylinder.axis=z box.cylinder.angular_velocity
    box.cylinder.restitution box.cylinder.friction box.cylinder.friction.static box.cylinder.friction.sliding
"""
#: With those that need events: collision rules without a soft counterpart, and samples at numbers of collisions.
_EVENTS = f"""{_SPHERES}
    hard_spheres.fixed hard_spheres.contact_duration hard_spheres.well box.faces.velocity box.faces.temperature
    box.faces.random_phase box.faces.random_phase.law=uniform box.faces.random_phase.law=flux output.collisions
"""
_CONTACTS = """
    method.contact method.contact.law=hooke method.contact.law=hertz method.contact.stiffness method.contact.duration
    method.contact.friction=history method.contact.friction=dashpot
    method.contact.k_n method.contact.k_t method.contact.E method.contact.nu
    method.contact.gamma_n method.contact.gamma_t method.contact.mu
"""
_GASES = """
    dimension=2 lattice_gas.obstacles lattice_gas.obstacles.columns lattice_gas.obstacles.rows
    lattice_gas.obstacles.centre lattice_gas.obstacles.radius lattice_gas.obstacles.sites
    lattice_gas.obstacles.rule=bounce_back lattice_gas.obstacles.rule=specular_x lattice_gas.obstacles.rule=specular_y
    lattice_gas.obstacles.rule=diffusive_x lattice_gas.obstacles.rule=diffusive_y lattice_gas.force
"""


class RefimplEngine:
    """The algorithms of `refimpl`: all interactions and all their schemes."""

    name = "refimpl"
    schemes = {name: Claims(s.order, s.order_damped, s.symplectic, s.reversible) for name, s in SCHEMES.items()}
    schemes |= {name: Claims(kind="event_driven") for name in SCHEDULERS}
    schemes |= {name: Claims(kind="lattice") for name in EVOLVERS}
    capabilities = (
        capability("spring", "stepping", words=_SPRINGS, observables=_SMOOTH),
        capability(
            "spring",
            "stepping",
            words=f"{_SPRINGS} method.compensated",
            observables=_SMOOTH,
            schemes=tuple(COMPENSATED),
        ),
        capability("gravity", "stepping", words=_GRAVITY, observables=_SMOOTH),
        capability(
            "gravity",
            "stepping",
            words=f"{_GRAVITY} method.compensated",
            observables=_SMOOTH,
            schemes=tuple(COMPENSATED),
        ),
        capability("lennard_jones", "stepping", words=_FLUIDS, observables=_SMOOTH),
        capability(
            "lennard_jones",
            "stepping",
            words=f"{_FLUIDS} method.compensated",
            observables=_SMOOTH,
            schemes=tuple(COMPENSATED),
        ),
        capability(
            "hard_spheres",
            "stepping",
            words=f"{_SPHERES} {_CONTACTS}",
            observables=f"{_HARD} collisional_virial contact_time wall_impulse wall_torque",
            schemes=GRAINS,
        ),
        capability(
            "hard_spheres",
            "event_driven",
            words=f"{_EVENTS} output.fields",
            observables=f"{_HARD} {_TRACE} {' '.join(named('hard_spheres'))}",
            schemes=tuple(name for name in SCHEDULERS if name != NAIVE),
        ),
        capability(
            "hard_spheres",
            "event_driven",
            words=_EVENTS,
            observables=f"{_HARD} {_TRACE} collisions events",
            schemes=(NAIVE,),
        ),
        capability(
            "lattice_gas",
            "lattice",
            words=f"{_GASES} lattice_gas.reversals method.threads",
            observables="populations force_impulse sites",
            schemes=("lattice_planes",),
        ),
        capability(
            "lattice_gas",
            "lattice",
            words=f"{_GASES} lattice_gas.reversals",
            observables="populations force_impulse sites",
            schemes=("lattice_lookup", "lattice_numpy"),
        ),
        capability("lattice_gas", "lattice", words=_GASES, observables="populations h_function", schemes=(BOLTZMANN,)),
    )
    #: Speeds that it is held to, against the peers that the checks name; that thousands of steps of some hundred
    #: particles take seconds; that its kernels run as plain Python too; that it counts its operations; and that what a
    #: scene does not have is not in the code that runs it.
    promises = (
        "speed", "long_runs", "interpretable", "operations", "documented_draws", "restarts", "remarks_on_order",
        "remarks_on_contacts", "cut_to_the_scene",
    )  # fmt: skip

    def version(self) -> str:
        import numba

        from crosscheck import __version__

        return f"{__version__} (numba {numba.__version__})"

    def supports(self, scene: Scene, method: Method) -> str | None:
        if scene.lattice_gas is not None:
            from crosscheck.engines.refimpl.lattice import unsupported

            return unsupported(scene, method.scheme)
        if scene.hard_spheres is not None and self.schemes[method.scheme].kind == "stepping":
            return soft_spheres.unsupported(scene, method)
        if scene.lennard_jones is not None:
            from crosscheck.engines.refimpl.stepping import unsupported_fluid

            return unsupported_fluid(scene)
        return None

    def run(self, scene: Scene, method: Method) -> Run:
        return self._run(scene, method, None)

    def run_from(
        self, scene: Scene, method: Method, start: Mapping[str, NDArray[Any]] | None
    ) -> tuple[Run, dict[str, NDArray[Any]] | None]:
        ends = Continuation(start)
        return self._run(scene, method, ends), ends.end

    def _run(self, scene: Scene, method: Method, ends: Continuation | None) -> Run:
        if scene.lattice_gas is not None:
            from crosscheck.engines.refimpl.lattice import run_lattice

            return run_lattice(scene, method, EVOLVERS[method.scheme], ends)
        if scene.hard_spheres is not None and method.contact is not None:
            from crosscheck.engines.refimpl.grains import run_grains

            return run_grains(scene, method, ends)
        if scene.hard_spheres is not None:
            from crosscheck.engines.refimpl.events import run_events

            return run_events(scene, SCHEDULERS[method.scheme], ends)
        from crosscheck.engines.refimpl.stepping import run_steps

        return run_steps(scene, method, ends)
