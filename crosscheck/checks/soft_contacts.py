"""Soft grains, one contact at a time: impacts in the plane and in space, two codes step by step, and extreme cases.

Many pairs (or grains and a wall), each far from the others, make up one scene: a run is a curve, over angles of impact
or over the phase of the time step at which contacts begin. Speeds of approach and diameters are near 1 and the contacts
so short, `DURATION`, that the line of centres turns by some 1e-6 at most, far below the errors of the time step.

Those are of order 1 in dt/t_c, in three ways. A contact begins and ends between two steps: a sum over steps misses up
to half a step's share of a force that jumps, as the dashpot's does, which is c h/2 of the velocity at either end,
h = omega_0 dt. Without one the energy of a linear contact is off by h^2/4 at most at either end. Inside, velocity
Verlet takes the dashpot at the velocity half a step before, but solves its difference equation exactly: see
`SteppedContact`. And a tangential spring is stretched from the step before the first that finds an overlap.

Literature: P. A. Cundall and O. D. L. Strack, Geotechnique 29, 47 (1979); J. Schaefer, S. Dippel and D. E. Wolf, J.
Phys. I France 6, 5 (1996); S. F. Foerster et al., Phys. Fluids 6, 1108 (1994); L. E. Silbert et al., Phys. Rev. E 64,
051302 (2001); D. Antypov and J. A. Elliott, Europhys. Lett. 94, 50004 (2011).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosscheck.checks.base import Check, Laboratory, fixed
from crosscheck.convergence import ORDER_TOLERANCE, WHY_ORDER, worst
from crosscheck.engines.base import Claims, Run
from crosscheck.errors import Unsupported
from crosscheck.faults import Fault
from crosscheck.references import EPSILON, granular
from crosscheck.references.granular import Body
from crosscheck.references.soft_impact import (
    HertzImpact,
    HookeImpact,
    SoftContact,
    damping,
    force_impulse,
    hard_impact,
    residual,
    soft_impact,
    stability_limit,
    stable_resolution,
)
from crosscheck.scene import (
    Box,
    Contact,
    Face,
    Friction,
    GrainFriction,
    HardSpheres,
    Lattice,
    Method,
    Output,
    Scene,
    explicit,
)
from crosscheck.statistics import fitted_order, independent_mean, standard_error
from crosscheck.verdict import Figure, Judgement, Series, bounded, order, round_off, statistical, within

Floats = NDArray[np.float64]
FrictionLaw = Literal["history", "dashpot"]

#: t_c of grains of diameter and speed near 1, so short that a contact does not turn.
DURATION = 1e-6
#: That of head-on impacts, which turn nothing at all.
CENTRAL_DURATION = 1e-2
#: Distance of pairs, in diameters of the largest grain; what skin of a list an engine has.
APART = 3.0
_SCHEME = "velocity_verlet"
_EVENTS = Method(scheme="event_driven")
_STEP_LABEL = "dt / t_c"


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
    alike = HookeImpact(1.0, _stiffness(stepped.restitution, 1.0, stepped.duration), 1.0, stepped.restitution)
    return Errors(
        abs(math.log(stepped.restitution / alpha)) + stepped.ends,
        abs(stepped.duration / exact.contact_time - 1) + stepped.ends * resolution,
        abs(math.log(alike.largest_overlap / exact.largest_overlap)) + stepped.ends,
    )


def _stiffness(alpha: float, mass: float, duration: float) -> float:
    """k of a contact time, of the reduced mass."""
    return mass * (math.pi**2 + math.log(alpha) ** 2) / duration**2


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
        return Method(scheme=_SCHEME, dt=dt, contact=Contact(stiffness=stiffness, law=self.law, friction=history))


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
        sides = tuple(hard if axis == 1 else "open" for axis, hard in enumerate(["hard"] * d))
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


def _lasting(resolution: float) -> int:
    """Steps from the start until all have parted: a contact and a quarter of one, and the steps before it."""
    return math.ceil(1.25 / resolution) + 6


def after(impacts: Impacts, run: Run) -> tuple[Floats, Floats]:
    """Velocities and spins at the end, (P, 2, 3)."""
    return _bodies(impacts, run.final_velocities), _bodies(impacts, run.final_angular_velocities, spin=True)


def _bodies(impacts: Impacts, rows: Floats | None, spin: bool = False) -> Floats:
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
    places = _bodies(impacts, run.positions)
    if impacts.wall:
        return np.asarray(impacts.radii[:, 0] - places[:, :, 0, 1])
    distance = np.linalg.norm(places[:, :, 0] - places[:, :, 1], axis=2)
    return np.asarray(impacts.radii.sum(axis=1) - distance)


def wander(impacts: Impacts, steps: int) -> float:
    """Four standard errors of a coordinate, which every step rounds: a random walk."""
    return 4 * math.sqrt(steps) * EPSILON * impacts.size


def rounded_speed(impacts: Impacts, steps: int, alpha: float, duration: float) -> float:
    """What `wander` of an overlap makes of a velocity: times omega_0^2 t_c = (pi^2 + ln^2 alpha)/t_c."""
    return wander(impacts, steps) * (math.pi**2 + math.log(alpha) ** 2) / duration


def _ratio_judgement(
    what: str, errors: Sequence[float], bounds: Sequence[float], why: str, **more: object
) -> Judgement:
    """The largest of the errors over their bounds, 1 at most."""
    ratios = np.asarray(errors) / np.asarray(bounds)
    return bounded(f"{what}, over its bound", float(ratios.max()), 1.0, why, **more)  # type: ignore[arg-type]


# -- head-on -----------------------------------------------------------------------------------------------------------

#: dt/t_c; not of whole numbers of steps in a contact, of which one end makes up for what the other does.
RESOLUTIONS = (1 / 40.4, 1 / 160.4, 1 / 640.4)
ALPHAS = (1.0, 0.9, 0.6, 0.2, 0.05)
SPEEDS = (0.5, 1.0, 2.0)
#: Phases of the step at which contacts begin, equally spaced.
PHASES = 8


class _HeadOn(NamedTuple):
    """Relative errors and their bounds, of one restitution at one resolution: all bounds and errors are positive."""

    errors: Errors
    bounds: Errors


def _head_on(laboratory: Laboratory, law: Law, resolution: float, wall: bool) -> _HeadOn:
    speeds = np.repeat(SPEEDS, PHASES)
    phases = np.tile((np.arange(PHASES) + 0.5) / PHASES, len(SPEEDS))
    impacts = make_impacts(
        2, np.zeros(speeds.size), laboratory.seed(), phases=phases, speeds=speeds, wall=wall, central=True
    )
    mass, radius = float(impacts.reduced[0]), 0.5 if wall else 0.25
    exact: list[HookeImpact | HertzImpact]
    if law.law == "hooke":
        stiffness = _stiffness(law.alpha, mass, CENTRAL_DURATION)
        exact = [HookeImpact(mass, stiffness, float(v), law.alpha) for v in speeds]
    else:
        # the contact time, proportional to k^(-2/5), is CENTRAL_DURATION at speed 1
        stiffness = (HertzImpact(mass, 1.0, radius, 1.0, law.alpha).contact_time / CENTRAL_DURATION) ** 2.5
        exact = [HertzImpact(mass, stiffness, radius, float(v), law.alpha) for v in speeds]
    dt = resolution * CENTRAL_DURATION
    # of "hertz", slow contacts last longer
    steps = math.ceil(max(one.contact_time for one in exact) / CENTRAL_DURATION * _lasting(resolution))
    run = laboratory.run(impact_scene(impacts, law, dt, steps, sampled=True), law.method(stiffness, dt))
    velocity, _ = rebound(impacts, *after(impacts, run))
    depth = overlaps(impacts, run)
    times = dt * (depth > 0).sum(axis=0).reshape(len(SPEEDS), PHASES).mean(axis=1)
    wanted = np.array([one.contact_time for one in exact])
    deepest = np.array([one.largest_overlap for one in exact])
    bounds = [_impact_bounds(law, one, dt) for one in exact[::PHASES]]
    largest = Errors(*(max(column) for column in zip(*bounds, strict=True)))
    # a mean over equally spaced phases counts whole steps to one of the phases
    counting = dt / PHASES / float(wanted.min())
    rounding = rounded_speed(impacts, steps, law.alpha, CENTRAL_DURATION) / (law.alpha * min(SPEEDS))
    shallow = wander(impacts, steps) / float(deepest.min())
    return _HeadOn(
        Errors(
            float(abs(np.log(velocity / law.alpha)).max()),
            float(abs(times / wanted[::PHASES] - 1).max()),
            float(abs(np.log(depth.max(axis=0) / deepest)).max()),
        ),
        Errors(largest.restitution + rounding, largest.time + counting, largest.overlap + shallow),
    )


def _impact_bounds(law: Law, impact: HookeImpact | HertzImpact, dt: float) -> Errors:
    """`hooke_bounds`; of "hertz", of the linear contact that it is equivalent to, as stiff as at the largest overlap.

    There omega^2 = (5/4) k sqrt(R delta)/m (`soft_impact`), and less than that elsewhere. The time goes as the
    amplitude to the power -1/5, which in the end is off as much as restitution is.
    """
    if isinstance(impact, HookeImpact):
        return hooke_bounds(law.alpha, dt / impact.contact_time)
    depth = impact._replace(alpha=1.0).largest_overlap
    frequency = math.sqrt(1.25 * impact.stiffness * math.sqrt(impact.radius * depth) / impact.mass)
    bounds = hooke_bounds(law.alpha, dt * frequency / HookeImpact(1.0, 1.0, 1.0, law.alpha).contact_time)
    return bounds._replace(time=bounds.time + bounds.restitution / 5)


def _judge_head_on(laboratory: Laboratory, variant: str) -> Judgement:
    wall, rule = variant == "wall", "hertz" if variant == "hertz" else "hooke"
    found = {
        (alpha, resolution): _head_on(laboratory, Law(alpha, law=rule), resolution, wall)  # type: ignore[arg-type]
        for alpha in ALPHAS
        for resolution in RESOLUTIONS
    }
    series: list[Series] = []
    for alpha in ALPHAS:
        curve = [found[alpha, resolution] for resolution in RESOLUTIONS]
        x = list(RESOLUTIONS)
        series.append(Series(f"alpha = {alpha:g}", x, [one.errors.restitution for one in curve]))
        series.append(Series(f"alpha = {alpha:g}, bound", x, [one.bounds.restitution for one in curve], theory=True))
    figure = Figure(
        f"restitution of head-on impacts, {variant}",
        _STEP_LABEL,
        "largest relative error of v'/v",
        "log",
        "log",
        tuple(series),
    )
    why = "stepped contact against the closed form, and -ln(1 - c h) + h^2/4 for its ends between steps, h = omega_0 dt"
    judgements = [
        _ratio_judgement(
            f"largest relative error of the {name}",
            [getattr(one.errors, key) for one in found.values()],
            [getattr(one.bounds, key) for one in found.values()],
            why,
        )
        for name, key in (("restitution", "restitution"), ("contact time", "time"), ("largest overlap", "overlap"))
    ]
    errors = [
        math.hypot(*(found[alpha, resolution].errors.restitution for alpha in ALPHAS if alpha < 1))
        for resolution in RESOLUTIONS
    ]
    judgements.append(
        order(
            "order of v'/v in dt, with dashpot", fitted_order(RESOLUTIONS, errors, EPSILON).value, 1.0,
            ORDER_TOLERANCE, WHY_ORDER,
        )
    )  # fmt: skip
    finest = found[ALPHAS[-1], RESOLUTIONS[-1]].errors
    note = (
        f"speeds {SPEEDS}, {PHASES} phases of the step; at alpha = {ALPHAS[-1]:g} and dt = t_c/640 relative errors of "
        f"{finest.restitution:.2g}, {finest.time:.2g} (time) and {finest.overlap:.2g} (overlap)"
    )
    return worst(judgements, note, (figure,))


# -- oblique impacts ---------------------------------------------------------------------------------------------------

#: Angles of impact, up to ANGLE_RANGE times the hard rule's limit of sticking.
ANGLES, ANGLE_RANGE = 60, 2.5
#: dt/t_c, down to errors far below what Coulomb's law does while the grains attract, which is
#: mu (1 + 1/q) (alpha^(2 chi/pi) - alpha) of u'/v, 0.007 in the first variant.
OBLIQUE_RESOLUTIONS = (1 / 160.4, 1 / 640.4, 1 / 2560.4)
#: Variants: dimension, contact, wall.
OBLIQUE: dict[str, tuple[int, SoftContact, bool]] = {
    "2d-history": (2, SoftContact(0.8, -0.5, 0.3, 0.5, "history"), False),
    "2d-dashpot": (2, SoftContact(0.8, 0.3, 0.3, 0.5, "dashpot"), False),
    "2d-wall-history": (2, SoftContact(0.6, -0.3, 0.4, 0.5, "history"), True),
    "2d-wall-dashpot": (2, SoftContact(0.6, 0.2, 0.4, 0.4, "dashpot"), True),
    "2d-hard-rule": (2, SoftContact(1.0, -1.0, 0.3, 0.5, "history"), False),
    "3d-history": (3, SoftContact(0.9, -0.7, 0.5, 0.4, "history"), False),
    "3d-dashpot": (3, SoftContact(0.5, 0.5, 0.2, 0.4, "dashpot"), False),
    "3d-wall-history": (3, SoftContact(0.7, 0.0, 0.3, 0.4, "history"), True),
}


#: Of the case that is the hard rule at every angle: there the error is of order 2 in dt, and soon that of the turn.
HARD_RULE_RESOLUTIONS = (1 / 10.4, 1 / 40.4, 1 / 160.4)


def turns(impacts: Impacts) -> Floats:
    """Errors on what the turn of the line of centres changes of g' over v, v = 1, (P,).

    In t_c it is |v_1 - v_2| t_c over the distance of the centres, and turns the impulse, 2 v normal to it at most, and
    the velocity that approaches.
    """
    speed = np.linalg.norm(impacts.velocities[:, 0] - impacts.velocities[:, 1], axis=1)
    return np.asarray(2 * DURATION * speed / impacts.radii.sum(axis=1) * (1 + speed))


def friction_bounds(thetas: ArrayLike, contact: SoftContact, resolution: float) -> Floats:
    """Errors on errors of u'/v by the time step, in the units of `soft_impact`, w' = -T, |T| <= B, phi = pi t/t_c.

    The contact acts for at most 3/2 steps more or less than t_c, besides what the stepped contact is longer: a phase
    `shift`. It costs shift times the largest B; a stretch that is off by shift times u has T off by nu^2 x shift for
    the rest of the contact, and a dashpot at a velocity half a step old by lambda^2 x times half a step. B itself is
    off by as much as restitution is, relatively.
    """
    theta = np.asarray(thetas, dtype=np.float64)
    exact = HookeImpact(1.0, 1.0, 1.0, contact.alpha)
    c = damping(contact.alpha)
    stepped = SteppedContact(c, resolution * exact.contact_time)
    normal = hooke_bounds(contact.alpha, resolution)
    shift = math.pi * (1.5 * resolution + abs(stepped.duration / exact.contact_time - 1))
    largest = max(1.0, c / math.sqrt(1 - c**2 / 4))
    x = theta / contact.scale
    if contact.friction == "history":
        late = math.acos(contact.alpha_t) ** 2 / math.pi * x * shift
    else:
        late = math.log(contact.alpha_t) ** 2 / 2 * x * resolution
    return np.asarray(contact.scale * (largest * shift + late + normal.restitution * force_impulse(contact.alpha)))


def _judge_oblique(laboratory: Laboratory, variant: str) -> Judgement:
    dimension, contact, wall = OBLIQUE[variant]
    limit = granular.sliding_limit(contact.alpha, contact.alpha_t, contact.mu, contact.q)
    thetas = limit * ANGLE_RANGE * (np.arange(ANGLES) + 0.5) / ANGLES
    impacts = make_impacts(dimension, thetas, laboratory.seed(), q=contact.q, wall=wall)
    law = Law(contact.alpha, contact)
    stiffness = _stiffness(contact.alpha, float(impacts.reduced[0]), DURATION)
    exact = soft_impact(thetas, contact)
    turning, hard_rule = turns(impacts), variant == "2d-hard-rule"
    ladder = HARD_RULE_RESOLUTIONS if hard_rule else OBLIQUE_RESOLUTIONS
    slips, normals, ratios, errors = [], [], [], []
    for resolution in ladder:
        dt = resolution * DURATION
        scene = impact_scene(impacts, law, dt, _lasting(resolution))
        run = laboratory.run(scene, law.method(stiffness, dt))
        normal, slip = rebound(impacts, *after(impacts, run))
        step = math.pi * resolution
        bound = 2 * step**2 * (thetas + contact.scale) if hard_rule else friction_bounds(thetas, contact, resolution)
        off = turning + rounded_speed(impacts, _lasting(resolution), contact.alpha, DURATION)
        bound = bound + off
        ratios.append(float((abs(slip - exact.slip) / bound).max()))
        errors.append(float(np.sqrt(np.mean((slip - exact.slip) ** 2))))
        slips.append(slip)
        allowed = hooke_bounds(contact.alpha, resolution).restitution + off / contact.alpha
        normals.append(float((abs(np.log(normal / contact.alpha)) / allowed).max()))
    scene = impact_scene(impacts, law, ladder[0] * DURATION, _lasting(ladder[0]))
    rigid = laboratory.run(scene, _EVENTS, engine="refimpl")
    _, rigid_slip = rebound(impacts, *after(impacts, rigid))
    by_rule = _hard_errors(impacts, contact, *after(impacts, rigid))
    step_errors = "2 h^2 (Theta + mu (1 + 1/q))" if hard_rule else "1.5 steps of contact, the lag of the dashpot"
    why = f"{step_errors}, the turn of the normal by v t_c over the diameter, rounding"
    fastest = float(np.linalg.norm(impacts.velocities, axis=2).max())
    apart = residual(contact)
    judgements = [
        _ratio_judgement("largest error of u'/v at three steps", ratios, [1.0] * 3, why),
        _ratio_judgement("largest error of v'_n/v_n at three steps", normals, [1.0] * 3, why),
        order(
            "order of u'/v in dt", fitted_order(ladder, errors, EPSILON).value, 2.0 if hard_rule else 1.0,
            ORDER_TOLERANCE, WHY_ORDER,
        ),
        round_off(
            "largest error of velocities and of R w of event-driven grains against the hard rule", by_rule,
            16 * EPSILON * impacts.size / float(impacts.radii.max()) * fastest,
            "rounding of the places at contact: it turns the normal, by which every component changes",
        ),
    ]  # fmt: skip
    note = (
        f"soft contacts are off the hard rule by {apart.size:.4f} at most, at Theta = {apart.theta:.3g}, in the limit; "
        f"rms error {errors[-1]:.2g} at dt = t_c/{1 / ladder[-1]:.0f}"
    )
    curves = _Curves(variant, contact, thetas, slips[-1], rigid_slip, ladder, errors)
    return worst(judgements, note, _oblique_figures(curves))


def _hard_errors(impacts: Impacts, contact: SoftContact, velocities: Floats, spins: Floats) -> float:
    """Largest error of the velocities and of R w after impacts by the hard rule."""
    errors = [0.0]
    for k in range(len(impacts.masses)):
        one, two = (
            Body(
                float(impacts.masses[k, i]), float(impacts.radii[k, i]), impacts.velocities[k, i], impacts.spins[k, i],
                impacts.q,
            )
            for i in (0, 1)
        )  # fmt: skip
        expected = granular.impact(one, two, impacts.normals[k], contact.alpha, contact.alpha_t, contact.mu, contact.mu)
        errors.append(float(abs(velocities[k] - expected.velocities).max()))
        errors.append(float(abs(impacts.radii[k][:, None] * (spins[k] - expected.spins)).max()))
    return max(errors)


class _Curves(NamedTuple):
    """Slips after against those before, of soft grains at the smallest step and of event-driven ones; the ladder."""

    variant: str
    contact: SoftContact
    thetas: Floats
    soft: Floats
    rigid: Floats
    ladder: tuple[float, ...]
    errors: list[float]


def _oblique_figures(curves: _Curves) -> tuple[Figure, ...]:
    """Foerster's plot of the soft and the event-driven engine with both theories, and the error against the step."""
    x, fine = curves.thetas.tolist(), np.linspace(0, float(curves.thetas[-1]), 200)
    label = f"soft, dt = t_c/{1 / curves.ladder[-1]:.0f}"
    soft, hard = soft_impact(fine, curves.contact).slip, hard_impact(fine, curves.contact).slip
    apart = curves.soft - hard_impact(curves.thetas, curves.contact).slip
    return (
        Figure(
            f"oblique impacts, {curves.variant}", "Theta = |u|/v_n before", "u'/v_n after",
            series=(
                Series(label, x, curves.soft.tolist()),
                Series("event-driven", x, curves.rigid.tolist()),
                Series("soft contact, closed form", fine.tolist(), soft.tolist(), theory=True),
                Series("hard rule", fine.tolist(), hard.tolist(), theory=True),
            ),
        ),
        Figure(
            f"soft less hard, {curves.variant}", "Theta = |u|/v_n before", "difference of u'/v_n",
            series=(
                Series(label, x, apart.tolist()),
                Series("closed form", fine.tolist(), (soft - hard).tolist(), theory=True),
            ),
        ),
        Figure(
            "oblique impacts against the step", _STEP_LABEL, "rms error of u'/v_n", "log", "log",
            (Series(curves.variant, list(curves.ladder), curves.errors),),
        ),
    )  # fmt: skip


# -- two codes ---------------------------------------------------------------------------------------------------------

#: Contact time of the pairs that are followed step by step, and dt/t_c: long enough that the line of centres turns,
#: and that delta/R, by which the arms of `pair_style granular` are shorter, is seen.
FOLLOWED, FOLLOWED_RESOLUTION = 1e-2, 1 / 50
_FOLLOWED_PAIRS = 100
#: Who is asked for the other trajectory.
_OTHER = {"refimpl": "lammps"}
#: Variants: dimension, contact, whether grains are of unlike masses and sizes, whether they hit a wall.
TWO_CODES: dict[str, tuple[int, SoftContact | None, bool, bool]] = {
    "2d-history": (2, SoftContact(0.8, -0.5, 0.3, 0.5, "history"), False, False),
    "2d-dashpot": (2, SoftContact(0.8, 0.3, 0.3, 0.5, "dashpot"), False, False),
    "2d-wall-history": (2, SoftContact(0.8, -0.5, 0.3, 0.5, "history"), False, True),
    "2d-unlike-smooth": (2, None, True, False),
    "2d-unlike-history": (2, SoftContact(0.8, -0.5, 0.3, 0.5, "history"), True, False),
    "3d-history": (3, SoftContact(0.7, -0.6, 0.5, 0.4, "history"), False, False),
    "3d-unlike-dashpot": (3, SoftContact(0.7, 0.2, 0.5, 0.4, "dashpot"), True, False),
    "3d-unlike-history": (3, SoftContact(0.7, -0.6, 0.5, 0.4, "history"), True, False),
}


def _judge_two_codes(laboratory: Laboratory, variant: str) -> Judgement:
    dimension, contact, unlike, wall = TWO_CODES[variant]
    rng = np.random.default_rng(laboratory.seed("grains"))
    shape = (_FOLLOWED_PAIRS, 2)
    masses, diameters = (rng.uniform(0.5, 2.0, shape), rng.choice([0.6, 1.0], shape)) if unlike else (1.0, 1.0)
    impacts = make_impacts(
        dimension,
        np.zeros(_FOLLOWED_PAIRS) if contact is None else rng.uniform(0.0, 4.0, _FOLLOWED_PAIRS),
        laboratory.seed(),
        masses=masses,
        diameters=diameters,
        q=None if contact is None else contact.q,
        wall=wall,
    )
    law = Law(0.7) if contact is None else Law(contact.alpha, contact)
    dt, steps = FOLLOWED_RESOLUTION * FOLLOWED, _lasting(FOLLOWED_RESOLUTION)
    # of the longest contact
    steps = math.ceil(steps * math.sqrt(float(impacts.reduced.max() / impacts.reduced.min())))
    scene = impact_scene(impacts, law, dt, steps, sampled=True)
    method = law.method(_stiffness(law.alpha, float(impacts.reduced.min()), FOLLOWED), dt)
    runs = [laboratory.run(scene, method, engine) for engine in (None, _OTHER.get(laboratory.engine, "refimpl"))]

    def differences(name: str, spin: bool = False) -> Floats:
        """The largest of each sample."""
        one, two = (_bodies(impacts, getattr(run, name), spin) for run in runs)
        return np.asarray(abs(one - two).reshape(len(one), -1).max(axis=1))

    places, velocities = differences("positions"), differences("velocities")
    wandered, tolerance = wander(impacts, steps), rounded_speed(impacts, steps, law.alpha, FOLLOWED)
    why = "a coordinate is rounded at every step, a random walk, and overlaps times omega_0^2 t_c are velocities"
    judgements = [
        round_off("largest difference of velocities", float(velocities.max()), tolerance, why),
        round_off(
            "largest difference of positions", float(places.max()), wandered + tolerance * FOLLOWED,
            "rounding of the coordinates, and the velocities' difference for a contact",
        ),
    ]  # fmt: skip
    times = (FOLLOWED_RESOLUTION * np.arange(places.size)).tolist()
    curves = [Series(f"{variant}, velocities", times, velocities.tolist())]
    if contact is not None:
        spins = differences("angular_velocities", spin=True)
        curves.append(Series(f"{variant}, spins", times, spins.tolist()))
        radius = float(impacts.radii[impacts.radii > 0].min())
        judgements.append(
            round_off(
                "largest difference of spins", float(spins.max()), tolerance / (contact.q * radius),
                f"{why}, and R w changes by 1/q as much",
            )
        )  # fmt: skip
    figure = Figure("two codes, step by step", "time / t_c", "largest difference", "linear", "log", tuple(curves))
    kinds = "unlike masses and sizes" if unlike else "like grains"
    note = f"{_FOLLOWED_PAIRS} impacts at once, {kinds}, {steps} steps, coordinates up to {impacts.size:.0f}"
    return worst(judgements, note, (figure,))


# -- stability ---------------------------------------------------------------------------------------------------------

#: Steps of a grain between two walls, and its speed, in diameters and units of omega_0.
STABLE_STEPS, STABLE_SPEED = 4000, 1e-9
#: Growth beyond which it explodes: just below the limit it may grow with the steps, 2 a step (a Jordan block).
EXPLODED = 10.0 * STABLE_STEPS
_STABLE_ALPHAS = {"elastic": 1.0, "damped": 0.7, "strongly-damped": 0.05}
#: Relative width at which bisection ends.
_BISECTED = 2e-5


def bisect(explodes: Callable[[float], bool], low: float, high: float, width: float) -> float:
    """The place from where on it explodes, to `width`. ValueError unless it is between low and high."""
    if explodes(low) or not explodes(high):
        raise ValueError(f"the limit does not lie between {low} and {high}")
    while high - low > width:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if explodes(middle) else (middle, high)
    return 0.5 * (low + high)


def _growth(laboratory: Laboratory, alpha: float, step: float, steps: int) -> float:
    """sqrt(v^2 + (omega_0 x)^2) over the speed at the start, m = k = 1, of a grain that fits between two walls."""
    scene = Scene(
        name="between-walls",
        dimension=2,
        duration=step * steps,
        hard_spheres=HardSpheres(restitution=alpha),
        box=Box(
            lengths=(4.0, 1.0),
            boundaries=("open", "hard"),
            faces={"y-": Face(restitution=alpha), "y+": Face(restitution=alpha)},
        ),
        initial=explicit(np.array([[2.0, 0.5]]), np.array([[0.0, STABLE_SPEED]])),
    )
    run = laboratory.run(scene, Law(alpha).method(1.0, step))
    size = math.hypot(run.final_velocities[0, 1], run.final_positions[0, 1] - 0.5) / STABLE_SPEED
    return math.inf if run.diverged or not math.isfinite(size) else size


def growth_delay(c: float) -> float:
    """How far, relatively, above the limit a step must be to grow by `EXPLODED` in `STABLE_STEPS`.

    Above it an eigenvalue is -(1 + d), d^2 + c h d = 2 h (h + c) epsilon at h (1 + epsilon), h the limit, to leading
    order in epsilon and d. The amplitude begins with a quarter of the speed or more.
    """
    rate = math.log(4 * EXPLODED) / STABLE_STEPS
    h = stability_limit(c)
    return rate * (rate + c * h) / (2 * h * (h + c))


def _judge_step_limit(laboratory: Laboratory, variant: str) -> Judgement:
    alpha = _STABLE_ALPHAS[variant]
    c = damping(alpha)
    limit = stability_limit(c)
    per_contact = math.sqrt(1 - c * c / 4) / math.pi

    def explodes(share: float) -> bool:
        return _growth(laboratory, alpha, share * limit, STABLE_STEPS) > EXPLODED

    try:
        found = limit * bisect(explodes, 0.9, 1.1, _BISECTED)
    except ValueError:
        found = math.nan
    delay = growth_delay(c)
    steps, shares = 100, np.concatenate([np.linspace(0.5, 0.98, 13), np.linspace(0.99, 1.05, 13)])
    sizes = [_growth(laboratory, alpha, float(share) * limit, steps) for share in shares]
    x = [float(share) * limit * per_contact for share in shares]
    grown = Series(f"{variant}, alpha = {alpha:g}", x, [max(size, EPSILON) ** 2 for size in sizes])
    threshold = Series(
        f"{variant}, limit", [limit * per_contact] * 2, [min(grown.y), max(max(grown.y), 1.0)], theory=True
    )
    figure = Figure(
        "energy after 100 steps", _STEP_LABEL, "energy over that at the start", "linear", "log", (grown, threshold)
    )
    return within(
        "round_off",
        "largest stable omega_0 dt",
        found,
        limit,
        limit * (delay + _BISECTED),
        f"bisected to {_BISECTED:g}, and a step must exceed the limit by {delay:.1e} to grow by {EXPLODED:g} in "
        f"{STABLE_STEPS} steps",
        note=f"c = {c:.4g}; the limit is dt/t_c = {stable_resolution(c):.4f}",
        figures=(figure,),
    )


# -- restitution towards 1 and 0 ---------------------------------------------------------------------------------------

NEARLY_ELASTIC = (0.99, 0.9999, 1 - 1e-6, 1.0)
NEARLY_PLASTIC = (1e-2, 1e-3, 1e-6)
#: dt/t_c; as alpha -> 0, t_c is long, and d ln alpha = -pi d zeta/(1 - zeta^2)^(3/2) asks for small steps.
_PLASTIC_RESOLUTIONS = (1e-3, 2.5e-4, 6.25e-5)


def _rebounds(laboratory: Laboratory, alpha: float, resolution: float) -> tuple[Floats, float]:
    """v'/v of head-on impacts at equally spaced phases of the step, and a bound on its relative error."""
    phases = (np.arange(PHASES) + 0.5) / PHASES
    impacts = make_impacts(2, np.zeros(PHASES), laboratory.seed(), phases=phases, central=True)
    dt, steps = resolution * CENTRAL_DURATION, _lasting(resolution)
    stiffness = _stiffness(alpha, float(impacts.reduced[0]), CENTRAL_DURATION)
    run = laboratory.run(impact_scene(impacts, Law(alpha), dt, steps), Law(alpha).method(stiffness, dt))
    rounding = rounded_speed(impacts, steps, alpha, CENTRAL_DURATION) / alpha
    return rebound(impacts, *after(impacts, run))[0], hooke_bounds(alpha, resolution).restitution + rounding


def _judge_towards(laboratory: Laboratory, variant: str) -> Judgement:
    plastic = variant == "towards-0"
    alphas, resolutions = (NEARLY_PLASTIC, _PLASTIC_RESOLUTIONS) if plastic else (NEARLY_ELASTIC, RESOLUTIONS)
    found = {(a, r): _rebounds(laboratory, a, r) for a in alphas for r in resolutions}
    # a grain that does not come back is further off than any bound
    errors = {key: float(abs(np.log(np.maximum(v, 1e-300) / key[0])).max()) for key, (v, _) in found.items()}
    bounds = {key: bound for key, (_, bound) in found.items()}
    series: list[Series] = []
    for alpha in alphas:
        x = list(resolutions)
        label = f"alpha = {alpha:.7g}"
        series.append(Series(label, x, [errors[alpha, r] for r in resolutions]))
        series.append(Series(f"{label}, bound", x, [bounds[alpha, r] for r in resolutions], theory=True))
    figure = Figure(
        f"restitution {variant.replace('-', ' ')}", _STEP_LABEL, "largest relative error of v'/v", "log", "log",
        tuple(series),
    )  # fmt: skip
    why = "stepped contact against the closed form, and -ln(1 - c h) + h^2/4 for its ends; rounding of the coordinates"
    judgements = [_ratio_judgement("largest relative error of v'/v", list(errors.values()), list(bounds.values()), why)]
    expected = 1.0 if plastic else 2.0
    alpha = alphas[-1]
    slope = fitted_order(resolutions, [errors[alpha, r] for r in resolutions], EPSILON).value
    judgements.append(order(f"order of v'/v in dt at alpha = {alpha:g}", slope, expected, ORDER_TOLERANCE, WHY_ORDER))
    last = ", ".join(f"{a:.7g}: {found[a, resolutions[-1]][0].mean():.8g}" for a in alphas)
    return worst(judgements, f"mean v'/v at the smallest step, {last}", (figure,))


def _judge_zero(laboratory: Laboratory) -> Judgement:
    """Restitution 0 has no soft contact: it must be refused."""
    reason = ""
    impacts = make_impacts(2, np.zeros(2), laboratory.seed(), central=True)
    try:
        laboratory.run(impact_scene(impacts, Law(0.0), 0.01, 10), Law(0.0).method(1.0, 0.01))
    except Unsupported as refusal:
        reason = str(refusal)
    return within("round_off", "refusals", float(bool(reason)), 1.0, 0.5, "a count: exact", note=reason or "it was run")


#: Disks of the elastic gas, packing fraction, contact time and duration in units of diameter and thermal speed.
_GAS, _GAS_PACKING, _GAS_CONTACT, _GAS_TIME = 100, 0.3, 0.02, 4.0
#: Steps in a contact: the relative motion's energy changes by h^2 (B_2(s) - B_2(s')), s and s' the phases of the step
#: at its ends: as if independent where B_4 = 0, at a fraction of 0.24; elsewhere in many steps only.
_GAS_STARTS, _GAS_STEPS = 24, (20.24, 60.24, 180.24)


def _judge_gas(laboratory: Laboratory) -> Judgement:
    """Energy of elastic grains, with that of their springs."""
    # whole numbers of steps
    interval = 25 * _GAS_CONTACT
    stiffness = _stiffness(1.0, 0.5, _GAS_CONTACT)
    rms, largest = np.zeros((2, _GAS_STARTS, len(_GAS_STEPS)))
    contacts = np.zeros(_GAS_STARTS)
    for start in range(_GAS_STARTS):
        scene = Scene(
            name="elastic-gas",
            dimension=2,
            duration=_GAS_TIME,
            hard_spheres=HardSpheres(),
            box=Box(packing_fraction=_GAS_PACKING),
            initial=Lattice(
                kind="lattice", structure="square", number=_GAS, temperature=1.0, seed=laboratory.seed(str(start))
            ),
            output=Output(interval=interval, observables=("kinetic_energy", "potential_energy", "contact_time")),
        )
        for rung, steps in enumerate(_GAS_STEPS):
            run = laboratory.run(scene, Law(1.0).method(stiffness, _GAS_CONTACT / steps))
            assert run.kinetic_energy is not None
            assert run.potential_energy is not None
            energy = run.kinetic_energy + run.potential_energy
            error = abs(energy / energy[0] - 1)
            rms[start, rung], largest[start, rung] = np.sqrt(np.mean(error**2)), error.max()
        contacts[start] = run.tallies["contact_time"][-1] / _GAS_CONTACT
    resolutions = 1 / np.array(_GAS_STEPS)
    bounds = contacts[:, None] * (math.pi * resolutions) ** 2 / 4 / _GAS
    orders = np.polyfit(np.log(resolutions), np.log(rms.T), 1)[0]
    mean, spread = np.exp(np.log(rms).mean(axis=0)), standard_error(np.log(rms))
    figure = Figure(
        "energy of an elastic gas", _STEP_LABEL, "rms relative error of the energy", "log", "log",
        (Series("soft disks", resolutions.tolist(), mean.tolist(), (mean * spread).tolist()),),
    )  # fmt: skip
    return worst(
        [
            _ratio_judgement(
                "largest error of the energy", largest.ravel().tolist(), bounds.ravel().tolist(),
                "a contact changes the energy by h^2/4 of the relative motion's at most, k_B T on average",
            ),
            statistical(
                "order of the energy in dt", *independent_mean(orders), 2.0, 0.0,
                f"standard error over {_GAS_STARTS} gases, whose energies walk at random from contact to contact",
                samples=_GAS_STARTS, needed=0.25,
            ),
        ],
        f"{_GAS_STARTS} gases of {_GAS} disks, {contacts.min():.0f} contacts or more each",
        (figure,),
    )  # fmt: skip


def _judge_limits(laboratory: Laboratory, variant: str) -> Judgement:
    if variant == "elastic-gas":
        return _judge_gas(laboratory)
    return _judge_zero(laboratory) if variant == "zero" else _judge_towards(laboratory, variant)


# -- no friction, and friction without limit ---------------------------------------------------------------------------

#: Slip over speed of approach: friction without limit is linear in the slip, but at a large one a code whose mu is
#: large and finite slides in the step that finds F_n nearest to 0.
_WEAK_SLIPS = (1e-3, 1e-2)
_LIMITS: dict[str, tuple[int, SoftContact]] = {
    "frictionless-history": (2, SoftContact(0.8, -0.5, 0.0, 0.5, "history")),
    "frictionless-dashpot": (2, SoftContact(0.8, 0.3, 0.0, 0.5, "dashpot")),
    "no-limit-history": (2, SoftContact(0.8, -0.5, math.inf, 0.5, "history")),
    "no-limit-dashpot": (2, SoftContact(0.8, 0.3, math.inf, 0.5, "dashpot")),
    "3d-no-limit-history": (3, SoftContact(0.6, -0.9, math.inf, 0.4, "history")),
}


def sticking_bound(contact: SoftContact, resolution: float) -> float:
    """Bound on the error of u'/u of a contact that sticks, by the time step.

    A tangential spring is the leapfrog's oscillator: after N steps u' = u cos((N + 1/2) theta)/cos(theta/2),
    theta = arccos(alpha_t) dt/t_c to second order, and N steps last as long as the stepped contact but for one. A
    dashpot leaves u (1 + ln(alpha_t) dt/t_c)^N.
    """
    exact = HookeImpact(1.0, 1.0, 1.0, contact.alpha)
    stepped = SteppedContact(damping(contact.alpha), resolution * exact.contact_time)
    off = abs(stepped.duration / exact.contact_time - 1)
    if contact.friction == "history":
        turn = math.acos(contact.alpha_t)
        return turn * (off + 1.5 * resolution) + (turn * resolution) ** 2
    decay = -math.log(contact.alpha_t)
    return contact.alpha_t * math.expm1(decay * (off + resolution) + decay**2 * resolution)


def _judge_friction_limits(laboratory: Laboratory, variant: str) -> Judgement:
    dimension, contact = _LIMITS[variant]
    limited = contact.mu == 0
    thetas = np.geomspace(0.1, 10.0, ANGLES) if limited else np.geomspace(*_WEAK_SLIPS, ANGLES)
    impacts = make_impacts(dimension, thetas, laboratory.seed(), q=contact.q, central=True)
    law = Law(contact.alpha, contact)
    stiffness = _stiffness(contact.alpha, float(impacts.reduced[0]), DURATION)
    if limited:
        dt, steps = RESOLUTIONS[1] * DURATION, _lasting(RESOLUTIONS[1])
        run = laboratory.run(impact_scene(impacts, law, dt, steps), law.method(stiffness, dt))
        velocities, spins = after(impacts, run)
        turned = impacts.radii[:, :, None] * abs(spins - impacts.spins)
        normal = impacts.normals[:, None, :]
        dragged = velocities - (velocities * normal).sum(axis=2)[..., None] * normal
        return worst(
            [
                round_off(
                    "largest change of R w", float(turned.max()), 4 * EPSILON * float(abs(impacts.spins).max()),
                    "without friction there is no torque: a rounding of the spins",
                ),
                round_off(
                    "largest tangential velocity", float(abs(dragged).max()),
                    wander(impacts, steps) * (1 + contact.alpha),
                    "rounding of the places at every step turns the normal; grains of diameter 1 meet at speed 1",
                ),
            ],
            f"{ANGLES} central impacts with slips up to {thetas[-1]:g}",
        )  # fmt: skip
    errors, ratios = [], []
    for resolution in RESOLUTIONS:
        dt = resolution * DURATION
        run = laboratory.run(impact_scene(impacts, law, dt, _lasting(resolution)), law.method(stiffness, dt))
        _, slip = rebound(impacts, *after(impacts, run))
        apart = abs(slip / thetas - contact.alpha_t)
        errors.append(float(np.sqrt(np.mean(apart**2))))
        # rounding of the normal over the smallest slip
        turning = (turns(impacts) + wander(impacts, _lasting(resolution))) / thetas
        ratios.append(float((apart / (sticking_bound(contact, resolution) + turning)).max()))
    figure = Figure(
        "friction without limit", _STEP_LABEL, "rms error of u'/u", "log", "log",
        (
            Series(variant, list(RESOLUTIONS), errors),
            Series(
                f"{variant}, bound", list(RESOLUTIONS), [sticking_bound(contact, one) for one in RESOLUTIONS],
                theory=True,
            ),
        ),
    )  # fmt: skip
    return worst(
        [
            _ratio_judgement(
                "largest error of u'/u at three steps", ratios, [1.0] * len(ratios),
                "1.5 steps of contact, the lag of the dashpots, rounding of the normal",
            ),
            order(
                "order of u'/u in dt", fitted_order(RESOLUTIONS, errors, EPSILON).value, 1.0, ORDER_TOLERANCE, WHY_ORDER
            ),
        ],
        f"alpha_t = {contact.alpha_t:g}; rms error {errors[-1]:.2g} at dt = t_c/640",
        (figure,),
    )  # fmt: skip


# -- unlike grains -----------------------------------------------------------------------------------------------------

MASS_RATIOS = tuple(10.0**power for power in range(7))
SIZE_RATIOS = (1.0, 2.0, 5.0, 10.0, 30.0)
_RATIO_ALPHA, _RATIO_RESOLUTION = 0.5, 1 / 160


def _judge_ratios(laboratory: Laboratory, variant: str) -> Judgement:
    """Heavy or large grains at rest, hit by those of mass and diameter 1."""
    of_mass = variant != "sizes"
    ratios = np.repeat(MASS_RATIOS if of_mass else SIZE_RATIOS, PHASES)
    pairs = np.stack([np.ones(ratios.size), ratios], axis=1)
    phases = np.tile((np.arange(PHASES) + 0.5) / PHASES, ratios.size // PHASES)
    sizes = pairs if variant == "sizes" else np.minimum(pairs, SIZE_RATIOS[-1]) if variant == "both" else 1.0
    masses = pairs if of_mass else 1.0
    impacts = make_impacts(
        2, np.zeros(ratios.size), laboratory.seed(), phases=phases, masses=masses, diameters=sizes, central=True
    )
    reduced, law = impacts.reduced, Law(_RATIO_ALPHA)
    stiffness = _stiffness(_RATIO_ALPHA, float(reduced.min()), CENTRAL_DURATION)
    dt = _RATIO_RESOLUTION * CENTRAL_DURATION
    expected = CENTRAL_DURATION * np.sqrt(reduced / reduced.min())
    steps = math.ceil(float(expected.max()) / CENTRAL_DURATION * _lasting(_RATIO_RESOLUTION))
    run = laboratory.run(impact_scene(impacts, law, dt, steps, sampled=True), law.method(stiffness, dt))
    velocities, spins = after(impacts, run)
    normal, _ = rebound(impacts, velocities, spins)
    grouped = (-1, PHASES)
    lasted = dt * (overlaps(impacts, run) > 0).sum(axis=0).reshape(grouped).mean(axis=1)
    wanted = expected.reshape(grouped)[:, 0]
    bounds = [hooke_bounds(_RATIO_ALPHA, dt / float(duration)) for duration in wanted]
    rounding = rounded_speed(impacts, steps, _RATIO_ALPHA, CENTRAL_DURATION) / _RATIO_ALPHA
    restitution = abs(np.log(normal / _RATIO_ALPHA)).reshape(grouped).max(axis=1)
    masses = impacts.masses[:, :, None]
    momenta = [(masses * v).sum(axis=1) for v in (velocities, impacts.velocities)]
    carried = (masses * abs(velocities)).sum(axis=(1, 2)) + (masses * abs(impacts.velocities)).sum(axis=(1, 2))
    lost = abs(momenta[0] - momenta[1]).max(axis=1) / carried
    kind = "size" if variant == "sizes" else "mass"
    ratio = ratios.reshape(grouped)[:, 0].tolist()
    figure = Figure(
        "contact time of unlike grains", "ratio of masses or sizes", "t_c over the shortest", "log", "linear",
        (
            Series(variant, ratio, (lasted / wanted.min()).tolist()),
            Series(f"{variant}, sqrt(m_eff)", ratio, (wanted / wanted.min()).tolist(), theory=True),
        ),
    )  # fmt: skip
    why = "stepped contact against the closed form, -ln(1 - c h) + h^2/4 for its ends, rounding of the coordinates"
    return worst(
        [
            _ratio_judgement(
                "largest relative error of the restitution", restitution.tolist(),
                [one.restitution + rounding for one in bounds], why,
            ),
            _ratio_judgement(
                "largest relative error of the contact time", abs(lasted / wanted - 1).tolist(),
                [one.time + dt / PHASES / float(d) for one, d in zip(bounds, wanted, strict=True)],
                "stepped contact against the closed form, and whole steps, averaged over equally spaced phases",
            ),
            round_off(
                "largest change of a pair's momentum, relative to what its grains carry", float(lost.max()),
                4 * EPSILON * math.sqrt(steps), "rounding of the velocities at every step, a random walk",
            ),
        ],
        f"{kind} ratios 1 to {ratio[-1]:g}, alpha = {_RATIO_ALPHA:g}, dt = t_c/{1 / _RATIO_RESOLUTION:.0f}",
        (figure,),
    )  # fmt: skip


# -- the checks --------------------------------------------------------------------------------------------------------

_ENGINES = ("refimpl", "lammps")
_CONTACTS = "stepping/kernels/contacts.py"


def _limits_variants(engine: str, schemes: dict[str, Claims]) -> tuple[str, ...]:
    """LAMMPS has no energy of granular contacts."""
    return ("towards-1", "towards-0", "zero", *(() if engine == "lammps" else ("elastic-gas",)))


CHECKS = (
    Check(
        name="granular/head-on",
        title="Head-on impacts of soft grains: restitution, contact time and largest overlap",
        equation="F_n = k delta - c sqrt(m k) v_n; v' = alpha v; t_c = sqrt((pi^2 + ln^2 alpha) m/k); "
        "delta_max = (v/omega_0) alpha^(chi/pi)",
        criterion="bounds of first order in c omega_0 dt and second in omega_0 dt, and the order of v'/v in dt",
        citation="Schaefer, Dippel & Wolf, J. Phys. I France 6, 5 (1996); Antypov & Elliott, EPL 94, 50004 (2011)",
        judge=_judge_head_on,
        variants=fixed("hooke", "hertz", "wall"),
        faults=(
            (
                "hooke",
                Fault(
                    "dashpot-of-the-pair-mass",
                    _CONTACTS,
                    "return coefficient * np.sqrt(mass * law[STIFFNESS] * scale)",
                    "return coefficient * np.sqrt(2.0 * mass * law[STIFFNESS] * scale)",
                    "the dashpot has twice the reduced mass",
                ),
            ),
        ),
        engines=_ENGINES,
        tier="quick",
    ),
    Check(
        name="granular/oblique-impact",
        title="Oblique impacts of soft grains: sticking, sliding, and the hard rule beside them",
        equation="|F_t| <= mu |F_n|; u'/v_n = mu (1 + 1/q) f(Theta q/((1 + q) mu); alpha, alpha_t)",
        criterion="bounds and order 1 in dt against the closed form; event-driven grains to rounding of the hard rule",
        citation="Cundall & Strack, Geotechnique 29, 47 (1979); Foerster et al., Phys. Fluids 6, 1108 (1994)",
        judge=_judge_oblique,
        variants=fixed(*OBLIQUE),
        faults=(
            (
                "2d-history",
                Fault(
                    "no-friction-in-attraction",
                    _CONTACTS,
                    "limit = law[FRICTION] * abs(normal)",
                    "limit = law[FRICTION] * max(normal, 0.0)",
                    "Coulomb's limit is 0 where the dashpot makes the grains attract",
                ),
            ),
            (
                "2d-dashpot",
                Fault(
                    "friction-without-its-limit",
                    _CONTACTS,
                    "share = min(limit, damping * slip) / slip if slip > 0.0 else 0.0",
                    "share = damping if slip > 0.0 else 0.0",
                    "the tangential dashpot has no Coulomb limit",
                ),
            ),
        ),
        engines=_ENGINES,
        tier="full",
    ),
    Check(
        name="granular/two-codes",
        title="A hundred impacts at once, step by step in two codes",
        equation="gran/hooke, gran/hooke/history and pair_style granular of LAMMPS",
        criterion="positions, velocities and spins at every step, to rounding",
        citation="Silbert et al., Phys. Rev. E 64, 051302 (2001)",
        judge=_judge_two_codes,
        variants=fixed(*TWO_CODES),
        faults=(
            (
                "2d-unlike-history",
                Fault(
                    "torque-on-the-other-arm",
                    _CONTACTS,
                    "_add_torque(d, d * number, a, j, inverse_inertias[j] * (radii[j] - shorter), n, f)",
                    "_add_torque(d, d * number, a, j, inverse_inertias[j] * (radii[i] - shorter), n, f)",
                    "the torque on the second grain has the arm of the first",
                ),
            ),
        ),
        engines=_ENGINES,
        tier="full",
    ),
    Check(
        name="granular/step-limit",
        title="Largest stable time step of a soft contact",
        equation="omega_0 dt < sqrt(c^2 + 4) - c",
        criterion="a grain that fits between two walls, so that one always touches: the limit by bisection",
        citation="Schaefer, Dippel & Wolf, J. Phys. I France 6, 5 (1996)",
        judge=_judge_step_limit,
        variants=fixed(*_STABLE_ALPHAS),
        faults=(
            (
                "damped",
                Fault(
                    "wall-of-the-pair-mass",
                    _CONTACTS,
                    "mass, approach = 1.0 / inverse_masses[i], _product(g, n)",
                    "mass, approach = 0.5 / inverse_masses[i], _product(g, n)",
                    "the reduced mass at a wall is that of a pair",
                ),
            ),
        ),
        engines=_ENGINES,
        tier="full",
    ),
    Check(
        name="granular/restitution-limits",
        title="Restitution towards 1 and towards 0",
        equation="alpha = exp(-pi c/sqrt(4 - c^2)), c -> 0 and c -> 2; E = const at alpha = 1",
        criterion="bounds and order in dt; energy of an elastic gas to order 2, over 24 gases; 0 is refused",
        citation="Schaefer, Dippel & Wolf, J. Phys. I France 6, 5 (1996)",
        judge=_judge_limits,
        variants=_limits_variants,
        faults=(
            (
                "towards-0",
                Fault(
                    "grains-never-attract",
                    _CONTACTS,
                    "* scale * delta - _damping(law[DAMPING], law, model, mass, scale) * approach",
                    "* max(0.0, scale * delta - _damping(law[DAMPING], law, model, mass, scale) * approach "
                    "/ law[STIFFNESS])",
                    "the normal force is cut off where the dashpot makes it attract",
                ),
            ),
        ),
        engines=_ENGINES,
        tier="full",
    ),
    Check(
        name="granular/friction-limits",
        title="Soft grains without friction, and with friction without limit",
        equation="mu = 0: u' = u; mu -> infinity: u' = alpha_t u",
        criterion="spins and tangential velocities to rounding; a bound of order dt, and that order",
        citation="Cundall & Strack, Geotechnique 29, 47 (1979)",
        judge=_judge_friction_limits,
        variants=fixed(*_LIMITS),
        faults=(
            (
                "no-limit-history",
                Fault(
                    "friction-never-without-limit",
                    "stepping/forces/grains.py",
                    "min(law.friction, NO_LIMIT)",
                    "min(law.friction, 1.0)",
                    "friction without limit is that of mu = 1",
                ),
            ),
        ),
        engines=_ENGINES,
        tier="full",
    ),
    Check(
        name="granular/ratios",
        title="Head-on impacts of grains of very unlike masses and sizes",
        equation="t_c = sqrt((pi^2 + ln^2 alpha) m_eff/k); v' = alpha v; m_1 v_1 + m_2 v_2 = const",
        criterion="bounds of first order in c omega_0 dt and second in omega_0 dt; momentum to rounding",
        citation="Schaefer, Dippel & Wolf, J. Phys. I France 6, 5 (1996)",
        judge=_judge_ratios,
        variants=fixed("masses", "sizes", "both"),
        faults=(
            (
                "masses",
                Fault(
                    "reduced-mass-of-like-grains",
                    _CONTACTS,
                    "mass = 1.0 / (inverse_masses[i] + inverse_masses[j])",
                    "mass = 0.5 / inverse_masses[i]",
                    "the reduced mass is half that of the first grain",
                ),
            ),
        ),
        engines=_ENGINES,
        tier="full",
    ),
)
