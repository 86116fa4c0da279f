"""Many impacts of soft grains in one scene, and what a time step does to a contact: what checks of contacts share.

Many pairs (or grains and a wall), each far from the others, make up one scene: a run is a curve, over angles of impact
or over the phase of the time step at which contacts begin. Speeds of approach and diameters are near 1 and the contacts
so short, `DURATION`, that the line of centres turns by some 1e-6 at most, far below the errors of the time step.

Those are of order 1 in dt/t_c, in three ways. A contact begins and ends between two steps: a sum over steps misses up
to half a step's share of a force that jumps, as the dashpot's does, which is c h/2 of the velocity at either end,
h = omega_0 dt. Without one the energy of a linear contact is off by h^2/4 at most at either end. Inside, velocity
Verlet takes the dashpot at the velocity half a step before, but solves its difference equation exactly: see
`SteppedContact`. And a tangential spring is stretched from the step before the first that finds an overlap.

Literature: J. Schaefer, S. Dippel and D. E. Wolf, J. Phys. I France 6, 5 (1996); L. E. Silbert et al., Phys. Rev. E 64,
051302 (2001).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosscheck.engines.protocol import Run
from crosscheck.references import EPSILON
from crosscheck.references.soft_impact import (
    HookeImpact,
    SoftContact,
    damping,
)
from crosscheck.references.soft_impact import stiffness as contact_stiffness
from crosscheck.scene import (
    Box,
    Contact,
    Face,
    Friction,
    GrainFriction,
    HardSpheres,
    Method,
    Output,
    Scene,
    explicit,
)
from crosscheck.verdict import Judged, bounded

Floats = NDArray[np.float64]

#: t_c of grains of diameter and speed near 1, so short that a contact does not turn.
DURATION = 1e-6
#: That of head-on impacts, which turn nothing at all.
CENTRAL_DURATION = 1e-2
#: dt/t_c; not of whole numbers of steps in a contact, of which one end makes up for what the other does.
RESOLUTIONS = (1 / 40.4, 1 / 160.4, 1 / 640.4)
#: Angles of impact in a run.
ANGLES = 60
#: Phases of the step at which contacts begin, equally spaced.
PHASES = 8
#: Distance of pairs, in diameters of the largest grain; what skin of a list an engine has.
APART = 3.0
STEP_LABEL = "dt / t_c"


# -- what a time step does to a contact --------------------------------------------------------------------------------


class SteppedContact(NamedTuple):
    """The contact x'' = -omega_0^2 x - c omega_0 x' as velocity Verlet takes it, without its beginning and its end.

    step: h = omega_0 dt. From half step to half step (x, v) is multiplied by a matrix of trace 2 - h^2 - c h and
    determinant 1 - c h (`soft_impact.stability_limit`): each step turns by `angle` and shrinks by sqrt(1 - c h), so a
    half turn takes pi/angle steps. ValueError from the properties if it does not swing.
    """

    damping: float
    step: float

    @property
    def angle(self) -> float:
        remains = 1 - self.damping * self.step
        half_trace = 1 - (self.step**2 + self.damping * self.step) / 2
        if remains <= half_trace**2:
            raise ValueError("the grains creep to rest, or explode, in steps so long")
        return math.acos(half_trace / math.sqrt(remains))

    @property
    def restitution(self) -> float:
        """(1 - c h)^(pi/(2 angle)), alpha as h -> 0."""
        return math.exp(0.5 * math.pi / self.angle * math.log1p(-self.damping * self.step))

    @property
    def duration(self) -> float:
        """pi h/angle, omega_0 t_c as h -> 0."""
        return math.pi * self.step / self.angle

    @property
    def ends(self) -> float:
        """Largest |ln| of what the ends of the contact make of the velocity: half a step of 1 - c h and h^2/8 each."""
        return -math.log1p(-self.damping * self.step) + self.step**2 / 4


class Errors(NamedTuple):
    """Relative errors by the time step, or bounds on them: restitution, contact time (a mean), largest overlap."""

    restitution: float
    time: float
    overlap: float


def hooke_bounds(alpha: float, resolution: float) -> Errors:
    """Of a contact in steps of dt/t_c = `resolution`: the stepped contact against the closed form, and its ends.

    The time is bounded without the counting of whole steps. The largest overlap is missed by the half step to the
    nearest sample, h^2/8 of it, and leads the amplitude of the steps by as much.
    """
    exact = HookeImpact(1.0, 1.0, 1.0, alpha)
    stepped = SteppedContact(damping(alpha), resolution * exact.contact_time)
    alike = HookeImpact(1.0, contact_stiffness(stepped.restitution, 1.0, stepped.duration), 1.0, stepped.restitution)
    return Errors(
        abs(math.log(stepped.restitution / alpha)) + stepped.ends,
        abs(stepped.duration / exact.contact_time - 1) + stepped.ends * resolution,
        abs(math.log(alike.largest_overlap / exact.largest_overlap)) + stepped.ends,
    )


# -- many impacts in one scene -----------------------------------------------------------------------------------------


class Impacts(NamedTuple):
    """P pairs (of grains, or of a grain and the wall y = 0), each with two bodies.

    masses, radii (P, 2), infinite and 0 of the wall; velocities, spins (P, 2, 3) before; normals (P, 3) from the second
    to the first, and places (P, 3) of the contact at the first touch; q of all. phases (P,): steps to the first touch.
    """

    dimension: int
    masses: Floats
    radii: Floats
    velocities: Floats
    spins: Floats
    normals: Floats
    places: Floats
    phases: Floats
    q: float
    wall: bool

    @property
    def reduced(self) -> Floats:
        """Reduced masses, (P,)."""
        return np.asarray(1 / (1 / self.masses).sum(axis=1))

    @property
    def size(self) -> float:
        """Largest coordinate."""
        return float(abs(self.places).max() + 2 * self.radii.max())

    @property
    def slips(self) -> Floats:
        """Slip of the surfaces before the impact, (P, 3)."""
        g = self.contact_velocity(self.velocities, self.spins)
        return np.asarray(g - (g * self.normals).sum(axis=1)[:, None] * self.normals)

    @property
    def approach(self) -> Floats:
        """Speeds of approach before the impact, (P,)."""
        return -(self.contact_velocity(self.velocities, self.spins) * self.normals).sum(axis=1)

    def contact_velocity(self, velocities: Floats, spins: Floats) -> Floats:
        """Velocities of the surfaces along each other and along the normal, (P, 3), as `granular.contact_velocity`."""
        rolling = np.cross((self.radii[:, :, None] * spins).sum(axis=1), self.normals)
        return np.asarray(velocities[:, 0] - velocities[:, 1] - rolling)

    def touching(self) -> Floats:
        """Centres at the first touch, (P, 2, 3)."""
        arms = self.radii[:, :, None] * self.normals[:, None, :] * np.array([1.0, -1.0])[:, None]
        return np.asarray(self.places[:, None, :] + arms)


def make_impacts(
    dimension: int,
    thetas: ArrayLike,
    seed: int,
    *,
    phases: ArrayLike | None = None,
    speeds: ArrayLike = 1.0,
    masses: ArrayLike = 1.0,
    diameters: ArrayLike = 1.0,
    q: float | None = None,
    wall: bool = False,
    central: bool = False,
) -> Impacts:
    """Impacts with the slips `thetas` times the speeds of approach, in random directions.

    Velocities and spins that make up the slip are random. central: the first grain's spin alone, so that the line of
    centres turns by nothing but the impact. phases: at random by default; masses, diameters: (P, 2) or less.
    """
    theta = np.atleast_1d(np.asarray(thetas, dtype=np.float64))
    number, rng = theta.size, np.random.default_rng(seed)
    space = np.array([1.0, 1.0, float(dimension == 3)])
    normals = np.tile([0.0, 1.0, 0.0], (number, 1)) if wall else _unit(rng.normal(size=(number, 3)) * space)
    tangents = rng.normal(size=(number, 3)) * space
    tangents = _unit(tangents - (tangents * normals).sum(axis=1)[:, None] * normals)
    speed = np.broadcast_to(np.asarray(speeds, dtype=np.float64), (number,))
    mass = np.broadcast_to(np.asarray(masses, dtype=np.float64), (number, 2)).copy()
    radii = np.broadcast_to(np.asarray(diameters, dtype=np.float64) / 2, (number, 2)).copy()
    if wall:
        mass[:, 1], radii[:, 1] = np.inf, 0.0
    slip = (theta * speed)[:, None] * tangents
    spins, velocities = np.zeros((number, 2, 3)), np.zeros((number, 2, 3))
    if central:
        spins[:, 0] = np.cross(slip, normals) / radii[:, :1]
        velocities[:, 0] = -speed[:, None] * normals
    else:
        spins[:] = rng.normal(size=(number, 2, 3)) * (np.ones(3) if dimension == 3 else 1 - space)
        velocities[:, 1] = 0.1 * rng.normal(size=(number, 3)) * space
        if wall:
            spins[:, 1] = velocities[:, 1] = 0.0
        rolling = np.cross((radii[:, :, None] * spins).sum(axis=1), normals)
        velocities[:, 0] = velocities[:, 1] - speed[:, None] * normals + slip + rolling
    axes = [axis for axis in range(dimension) if not (wall and axis == 1)]
    side = math.ceil(number ** (1 / len(axes)) - 1e-9)
    apart = APART * 2 * float(radii.max())
    places = np.zeros((number, 3))
    for power, axis in enumerate(axes):
        places[:, axis] = apart * (np.arange(number) // side**power % side + 1)
    return Impacts(
        dimension,
        mass,
        radii,
        velocities,
        spins,
        normals,
        places,
        1 + (rng.random(number) if phases is None else np.asarray(phases, dtype=np.float64)),
        (0.4 if dimension == 3 else 0.5) if q is None else q,
        wall,
    )


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1)[:, None])


class Law(NamedTuple):
    """Of all contacts of a scene: restitution; friction, or smooth; the law of the overlap, and of friction."""

    alpha: float
    friction: SoftContact | None = None
    law: Literal["hooke", "hertz"] = "hooke"

    def method(self, stiffness: float, dt: float) -> Method:
        history = "history" if self.friction is None else self.friction.friction
        return Method(
            scheme="velocity_verlet", dt=dt, contact=Contact(stiffness=stiffness, law=self.law, friction=history)
        )


def impact_scene(impacts: Impacts, law: Law, dt: float, steps: int, sampled: bool = False) -> Scene:
    """The scene of the impacts, `steps` long; grains touch after their phases times dt. sampled: at every step."""
    d, bodies = impacts.dimension, 1 if impacts.wall else 2
    started = impacts.touching() - (dt * impacts.phases)[:, None, None] * impacts.velocities
    sizes, species = np.unique(impacts.radii[:, :bodies].ravel(), return_inverse=True)
    grains = friction = None
    if law.friction is not None:
        limit = None if math.isinf(law.friction.mu) else law.friction.mu
        alpha_t = law.friction.alpha_t
        grains = GrainFriction(tangential_restitution=alpha_t, static=limit, sliding=limit, inertia=impacts.q)
        friction = Friction(tangential_restitution=alpha_t, static=limit, sliding=limit)
    box = None
    if impacts.wall:
        faces = {"y-": Face(restitution=law.alpha, friction=friction), "y+": Face(open=True)}
        sides = tuple("hard" if axis == 1 else "open" for axis in range(d))
        box = Box(lengths=(2 * impacts.size,) * d, boundaries=sides, faces=faces)  # type: ignore[arg-type]
    spins = impacts.spins[:, :bodies].reshape(-1, 3)[:, 2 if d == 2 else 0 :]
    return Scene(
        name="soft-impacts",
        dimension=d,  # type: ignore[arg-type]
        duration=dt * steps,
        masses=tuple(impacts.masses[:, :bodies].ravel().tolist()),
        species=tuple(species.tolist()) if sizes.size > 1 else None,
        hard_spheres=HardSpheres(diameter=tuple((2 * sizes).tolist()), restitution=law.alpha, friction=grains),
        box=box,
        initial=explicit(
            started[:, :bodies].reshape(-1, 3)[:, :d],
            impacts.velocities[:, :bodies].reshape(-1, 3)[:, :d],
            None if grains is None else spins,
        ),
        output=Output(interval=dt, trajectory=True) if sampled else Output(),
    )


def lasting(resolution: float) -> int:
    """Steps from the start until all have parted: a contact and a quarter of one, and the steps before it."""
    return math.ceil(1.25 / resolution) + 6


def after(impacts: Impacts, run: Run) -> tuple[Floats, Floats]:
    """Velocities and spins at the end, (P, 2, 3)."""
    return bodies(impacts, run["final_velocities"]), bodies(impacts, run.get("final_angular_velocities"), spin=True)


def bodies(impacts: Impacts, rows: Floats | None, spin: bool = False) -> Floats:
    """(..., N, components) as (..., P, 2, 3); walls and what is absent are 0, the one component of a spin the third."""
    number = len(impacts.masses)
    if rows is None:
        return np.zeros((number, 2, 3))
    grains = 1 if impacts.wall else 2
    lead = rows.shape[:-2]
    found = np.zeros((*lead, number, 2, 3))
    first = 3 - rows.shape[-1] if spin else 0
    found[..., :grains, first : first + rows.shape[-1]] = rows.reshape(*lead, number, grains, rows.shape[-1])
    return found


def rebound(impacts: Impacts, velocities: Floats, spins: Floats) -> tuple[Floats, Floats]:
    """Of the contacts after the impact: v'_n/v_n, and the slip along the slip before over v_n, each (P,)."""
    g, slips = impacts.contact_velocity(velocities, spins), impacts.slips
    sizes = np.linalg.norm(slips, axis=1)
    along = (g * slips).sum(axis=1) / np.where(sizes > 0, sizes, 1.0)
    return (g * impacts.normals).sum(axis=1) / impacts.approach, along / impacts.approach


def overlaps(impacts: Impacts, run: Run) -> Floats:
    """delta of every pair at every sample, negative while apart, (samples, P)."""
    places = bodies(impacts, run["positions"])
    if impacts.wall:
        return np.asarray(impacts.radii[:, 0] - places[:, :, 0, 1])
    distance = np.linalg.norm(places[:, :, 0] - places[:, :, 1], axis=2)
    return np.asarray(impacts.radii.sum(axis=1) - distance)


def turns(impacts: Impacts) -> Floats:
    """Errors on what the turn of the line of centres changes of g' over v, v = 1, (P,).

    In t_c it is |v_1 - v_2| t_c over the distance of the centres, and turns the impulse, 2 v normal to it at most, and
    the velocity that approaches.
    """
    speed = np.linalg.norm(impacts.velocities[:, 0] - impacts.velocities[:, 1], axis=1)
    return np.asarray(2 * DURATION * speed / impacts.radii.sum(axis=1) * (1 + speed))


def wander(impacts: Impacts, steps: int) -> float:
    """Four standard errors of a coordinate, which every step rounds: a random walk."""
    return 4 * math.sqrt(steps) * EPSILON * impacts.size


def rounded_speed(impacts: Impacts, steps: int, alpha: float, duration: float) -> float:
    """What `wander` of an overlap makes of a velocity: times omega_0^2 t_c = (pi^2 + ln^2 alpha)/t_c."""
    return wander(impacts, steps) * (math.pi**2 + math.log(alpha) ** 2) / duration


def ratio_judgement(what: str, errors: Sequence[float], bounds: Sequence[float], why: str, **more: object) -> Judged:
    """The largest of the errors over their bounds, 1 at most."""
    ratios = np.asarray(errors) / np.asarray(bounds)
    return bounded(f"{what}, over its bound", float(ratios.max()), 1.0, why, **more)  # type: ignore[arg-type]
