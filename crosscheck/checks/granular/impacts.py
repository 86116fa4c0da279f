"""Many impacts of soft grains in one scene: what the checks of single contacts share.

Many pairs (or grains and a wall), each far from the others, make up one scene: a run is a curve, over angles of impact
or over the phase of the time step at which contacts begin. Speeds of approach and diameters are near 1 and the contacts
so short, `DURATION`, that the line of centres turns by some 1e-6 at most, far below the errors of the time step. What
those are: `crosscheck.references.stepped_contact`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosscheck.engines.protocol import Run
from crosscheck.references import EPSILON
from crosscheck.references.soft_impact import SoftContact
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


class Impacts(NamedTuple):
    """P pairs (of grains, or of a grain and the wall y = 0) in `dimension` dimensions, each with two bodies.

    masses, radii: (P, 2), infinite and 0 of the wall. velocities, spins: before the impact, (P, 2, 3). normals: unit
    vectors from the second body to the first, (P, 3). places: of the contact at the first touch, (P, 3). phases: time
    steps to the first touch, (P,). q: I/(m R^2) of all grains. wall: the second body of each pair is the wall.
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
        """Reduced mass of each pair, (P,)."""
        return np.asarray(1 / (1 / self.masses).sum(axis=1))

    @property
    def size(self) -> float:
        """Largest coordinate of the scene (length)."""
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
        """Velocity of the first surface relative to the second at the contact, (P, 3).

        velocities, spins: of the bodies, (P, 2, 3). As `crosscheck.references.granular.contact_velocity` of one pair.
        """
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
    """Impacts with the slips `thetas` (P,) times the speeds of approach, in random directions.

    Velocities and spins that make up the slip are random. dimension: 2 or 3. seed: of all that is random. phases (P,):
    steps to the first touch, less 1; at random by default. speeds: of approach, (P,) or one. masses, diameters: (P, 2)
    or what can be broadcast to it. q: I/(m R^2), by default of solid spheres or disks. wall: the second body of each
    pair is the wall y = 0. central: the first grain's spin alone makes up the slip, so that the line of centres turns
    by nothing but the impact.
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
    """Of all contacts of a scene: coefficient of restitution `alpha`, friction, and law of the overlap.

    friction: the soft contact with friction; None of smooth grains. law: "hooke", a linear spring, or "hertz". own:
    coefficients of the contact's own, in place of those that follow from `alpha` and `friction`.
    """

    alpha: float
    friction: SoftContact | None = None
    law: Literal["hooke", "hertz"] = "hooke"
    own: Contact | None = None

    def method(self, stiffness: float, dt: float) -> Method:
        """Velocity Verlet in steps dt (time), with contacts of this law; stiffness: force/length, "hertz": /area.

        The stiffness is not used where the contact has coefficients of its own.
        """
        if self.own is not None:
            return Method(scheme="velocity_verlet", dt=dt, contact=self.own)
        history = "history" if self.friction is None else self.friction.friction
        return Method(
            scheme="velocity_verlet", dt=dt, contact=Contact(stiffness=stiffness, law=self.law, friction=history)
        )


def impact_scene(impacts: Impacts, law: Law, dt: float, steps: int, sampled: bool = False) -> Scene:
    """The scene of the impacts, `steps` times dt long; grains touch after their phases times dt.

    law: of all contacts. dt: time step (time). sampled: positions and velocities at every step are asked for, else
    those at the end.
    """
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
    """Steps from the start until all pairs have parted: a contact and a quarter of one, and the steps before it.

    resolution: dt/t_c.
    """
    return math.ceil(1.25 / resolution) + 6


def after(impacts: Impacts, run: Run) -> tuple[Floats, Floats]:
    """Velocities and spins of the bodies of `impacts` at the end of their `run`, both (P, 2, 3)."""
    return bodies(impacts, run["final_velocities"]), bodies(impacts, run.get("final_angular_velocities"), spin=True)


def bodies(impacts: Impacts, rows: Floats | None, spin: bool = False) -> Floats:
    """Vectors of N grains, in the order of `impact_scene`, as those of the P pairs of `impacts`, (..., P, 2, 3).

    rows: (..., N, components), or None: all zero. spin: a single component is the third. Components that are absent and
    the vectors of walls are 0.
    """
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
    """Of each contact after the impact: v'_n/v_n, and u'/v_n, both (P,).

    v_n: speed of approach before, u': slip after, along the slip before. impacts: as before. velocities, spins: after,
    (P, 2, 3).
    """
    g, slips = impacts.contact_velocity(velocities, spins), impacts.slips
    sizes = np.linalg.norm(slips, axis=1)
    along = (g * slips).sum(axis=1) / np.where(sizes > 0, sizes, 1.0)
    return (g * impacts.normals).sum(axis=1) / impacts.approach, along / impacts.approach


def overlaps(impacts: Impacts, run: Run) -> Floats:
    """Overlap delta of every pair of `impacts` at every sample of their `run`, negative while apart, (samples, P)."""
    places = bodies(impacts, run["positions"])
    if impacts.wall:
        return np.asarray(impacts.radii[:, 0] - places[:, :, 0, 1])
    distance = np.linalg.norm(places[:, :, 0] - places[:, :, 1], axis=2)
    return np.asarray(impacts.radii.sum(axis=1) - distance)


def turns(impacts: Impacts) -> Floats:
    """Of each pair of `impacts`, a bound on the change of g'/v by the turn of the line of centres, v = 1; (P,).

    The line turns by |v_1 - v_2| t_c over the distance of the centres. With it turn the impulse, 2 v at most, and the
    direction along which the grains approach.
    """
    speed = np.linalg.norm(impacts.velocities[:, 0] - impacts.velocities[:, 1], axis=1)
    return np.asarray(2 * DURATION * speed / impacts.radii.sum(axis=1) * (1 + speed))


def wander(impacts: Impacts, steps: int) -> float:
    """Four standard errors of a coordinate (length) that each of `steps` steps rounds: a random walk.

    impacts: their largest coordinate sets the size of a rounding.
    """
    return 4 * math.sqrt(steps) * EPSILON * impacts.size


def rounded_speed(impacts: Impacts, steps: int, alpha: float, duration: float) -> float:
    """Change of a velocity by an overlap that is off by `wander`: times omega_0^2 t_c = (pi^2 + ln^2 alpha)/t_c.

    impacts, steps: as for `wander`. alpha: coefficient of restitution. duration: t_c (time).
    """
    return wander(impacts, steps) * (math.pi**2 + math.log(alpha) ** 2) / duration


def ratio_judgement(what: str, errors: Sequence[float], bounds: Sequence[float], why: str, **more: object) -> Judged:
    """The largest of `errors` over their `bounds`, which may be 1 at most; both in the same order.

    what: the error, in words. why: the reason of the bounds, in words. more: further arguments of `bounded`.
    """
    ratios = np.asarray(errors) / np.asarray(bounds)
    return bounded(f"{what}, over its bound", float(ratios.max()), 1.0, why, **more)  # type: ignore[arg-type]
