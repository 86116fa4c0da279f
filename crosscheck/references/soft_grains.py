"""An auditor of soft grains: contact forces from their definitions, and each step of a run from the one before.

Written for clarity, as a second derivation: all pairs and all walls at once, without lists or cells. In the plane,
vectors have a third component 0, and spins are along it.

The laws. Bodies i and j touch where delta = R_i + R_j - |r_ij| > 0; r_ij = r_i - r_j of nearest images, n along it.
A wall is a body j without radius of its own, of infinite mass, whose velocity is that of its surface. With the velocity
g = v_i - v_j of the centres and u = g - (g.n) n - (R_i w_i + R_j w_j) x n of the surfaces along each other, and s = 1
("hooke") or sqrt(R_eff delta) ("hertz"), R_eff = R_i R_j/(R_i + R_j), or R_i at a wall,

    F_n = s k delta - eta_n g.n,    F_t = -s k_t xi - eta_t u, not larger than mu |F_n|,

acts on i, and the opposite on j; the torques are -A_i n x F_t and -A_j n x F_t with arms A = R. The dashpots are

    eta = 2 zeta sqrt(m_eff k s) of a restitution, "hertz" sqrt(5) zeta; ln alpha = -pi zeta/sqrt(1 - zeta^2),
    eta = s gamma m_eff          of coefficients of one's own,

and k_t and eta_t of a tangential restitution alpha_t those with which, in the time t_c of a contact, the tangential
oscillator of the mass m_eff q/(1 + q) goes from u to alpha_t u, as a spring alone or a dashpot alone.

The stretch xi begins at 0 with the contact, and ends with it. At each evaluation of the forces it grows by u times the
time since the last one. Then its component along n is taken off; where xi makes F_t exceed mu |F_n|, F_t is cut, and xi
becomes the stretch that gives this F_t. A dashpot beyond the limit exerts nothing as long as xi = 0. Contacts that are
"turned first" (those of the general pair style of LAMMPS, for unlike masses or "hertz"; see `turned_first`) have xi
turned into the tangential plane, at its length, before it grows; the arms of their pairs are A = R - delta/2, and a
component along n whose spring force is below 1e-10 of the limit is left. A code may turn the stretches of its walls so
whatever its pairs do: at a plane this is the same, at a cylinder it is not.

The steps are those of velocity Verlet: v_h = v + a dt/2, r' = r + v_h dt, v' = v_h + a' dt/2, with a' of r', of v_h
and of the spins at the half-step. `audit` computes each step from the recorded state before it, so errors do not grow:
what is found is rounding or wrong; the stretches alone are its own, followed from the start.

Literature: P. A. Cundall and O. D. L. Strack, Geotechnique 29, 47 (1979); L. E. Silbert et al., Phys. Rev. E 64, 051302
(2001); Y. Tsuji, T. Tanaka and T. Ishida, Powder Technol. 71, 239 (1992); R. D. Mindlin, J. Appl. Mech. 16, 259 (1949);
W. C. Swope, H. C. Andersen, P. H. Berens and K. R. Wilson, J. Chem. Phys. 76, 637 (1982).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosscheck.references import EPSILON
from crosscheck.references.soft_impact import damping, stiffness
from crosscheck.scene import Contact, Friction, Scene

Floats = NDArray[np.float64]

#: A stretch along the normal whose spring force is below this share of Coulomb's limit is not turned.
_SLIGHT = 1e-10
#: Roundings of a sum of a few terms, in units of `EPSILON` times the largest term: of the coordinates in a distance, of
#: the sum of the forces on a grain, of a step.
_ROUNDINGS = 16.0


class Law(NamedTuple):
    """Coefficients of one kind of contact, in the equations of the module.

    k: stiffness. normal: c_n = 2 zeta (sqrt(5) zeta), or gamma_n. k_t: tangential stiffness. tangential: c_t, gamma_t.
    mu: coefficient of friction; 0: smooth; infinite: no limit.
    """

    k: float
    normal: float
    k_t: float
    tangential: float
    mu: float


def inertia_ratio(scene: Scene) -> float:
    """q of I = q m R^2: that of the scene, or of a solid ball (space) or disk (plane)."""
    assert scene.hard_spheres is not None
    friction = scene.hard_spheres.friction
    given = None if friction is None else friction.inertia
    return given if given is not None else {2: 1 / 2, 3: 2 / 5}[scene.dimension]


def turned_first(scene: Scene, contact: Contact) -> bool:
    """Whether stretches are turned before they grow, and the arms of pairs are R - delta/2.

    scene: gives the masses. contact: of the method. So it is where the dashpot follows from a restitution and masses
    are unlike, or the law is "hertz"; of coefficients of one's own, for moduli, and "hertz" with a tangential dashpot.
    """
    if contact.gamma_n is None:
        return contact.law == "hertz" or len(set(scene.initial_state(contact).masses.tolist())) > 1
    return contact.E is not None or (contact.law == "hertz" and contact.friction == "dashpot")


def law_of(scene: Scene, contact: Contact, restitution: float, friction: Friction | None) -> Law:
    """The coefficients of contacts with this restitution and friction.

    scene: gives the smallest mass, its restitution and q. contact: of the method. restitution: of these contacts.
    friction: of these contacts; None: smooth.
    """
    assert scene.hard_spheres is not None
    mass, q = float(scene.initial_state(contact).masses.min()) / 2, inertia_ratio(scene)
    moduli = contact.E is not None and contact.nu is not None
    if contact.E is not None and contact.nu is not None:
        e_star = contact.E / (2 * (1 - contact.nu**2))
        shear = contact.E / (2 * (1 + contact.nu))
        k, k_t = 4 / 3 * e_star, 8 * (shear / (2 * (2 - contact.nu)))
    elif contact.duration is not None:
        k, k_t = stiffness(scene.hard_spheres.restitution, mass, contact.duration), 0.0
    else:
        k, k_t = contact.stiffness or contact.k_n or math.nan, contact.k_t or 0.0
    normal = damping(restitution, contact.law) if contact.gamma_n is None else contact.gamma_n
    if friction is None or friction.tangential_restitution == 1.0:
        return Law(k, normal, 0.0, 0.0, 0.0)
    mu = math.inf if friction.sliding is None else friction.sliding
    if moduli or contact.k_n is not None:
        return Law(k, normal, k_t, contact.gamma_t or 0.0, mu if contact.mu is None else contact.mu)
    # of a unit reduced mass and k = 1: t_c, and the tangential mass q/(1 + q)
    t_c, tangential_mass = math.sqrt(stiffness(restitution, 1.0, 1.0)), q / (1 + q)
    if contact.friction == "history":
        frequency = math.acos(friction.tangential_restitution) / t_c
        return Law(k, normal, k * tangential_mass * frequency**2, 0.0, mu)
    return Law(k, normal, 0.0, -tangential_mass * math.log(friction.tangential_restitution) / t_c, mu)


class Evaluation(NamedTuple):
    """Accelerations and what else follows from the contacts at one moment.

    a, spins: (N, 3), accelerations and angular accelerations. touching: (pairs and walls,), whether they touch.
    pairs: number of pairs that touch. virial: sum r_ij . F_ij of pairs. walls: (faces, 3), forces on the walls. torque:
    of the cylinder on the grains, about its axis. elastic: energy of the normal springs. sharpest: the largest force.
    """

    a: Floats
    spins: Floats
    touching: NDArray[np.bool_]
    pairs: int
    virial: float
    walls: Floats
    torque: float
    elastic: float
    sharpest: float


class _Wall(NamedTuple):
    """Wall number `face` of the observables; axis, sign: of its normal; None: the cylinder."""

    face: int
    axis: int
    sign: float
    place: float
    law: Law
    motion: tuple[float, float, float]


@dataclasses.dataclass
class Contacts:
    """All contacts of a scene that may be, with the stretches of their tangential springs.

    scene: hard spheres. contact: of the method. turned_at_walls: stretches at walls are turned before they grow, also
    where those of pairs are not. stretches: (contacts, 3), 0 at first; pairs i < j in order, then all grains at each
    wall, then at the cylinder. slid: contacts at Coulomb's limit, summed over all evaluations.
    """

    scene: Scene
    contact: Contact
    turned_at_walls: bool = False
    stretches: Floats = dataclasses.field(init=False)
    slid: int = dataclasses.field(init=False)

    def __post_init__(self) -> None:
        scene, contact = self.scene, self.contact
        assert scene.hard_spheres is not None
        state = scene.initial_state(contact)
        assert state.diameters is not None
        number, q = scene.number, inertia_ratio(scene)
        self._radii, self._masses = state.diameters / 2, state.masses
        self._inertias = q * self._masses * self._radii**2
        self._periods = np.zeros(3)
        self._periods[: scene.dimension] = scene.periods()
        self._field = np.zeros(3)
        self._field[: scene.dimension] = 0.0 if scene.acceleration is None else scene.acceleration
        lengths = np.zeros(scene.dimension) if state.lengths is None else state.lengths
        self._walls: list[_Wall] = []
        self._wall_normals: list[Floats] = []
        for face, wall in enumerate(scene.faces):
            if wall is None:
                continue
            axis, sign, moves = face // 2, 1.0 if face % 2 == 0 else -1.0, wall.oscillation
            motion = (0.0, 0.0, 0.0) if moves is None else (moves.amplitude, moves.frequency, moves.phase)
            place = 0.0 if sign > 0 else float(lengths[axis])
            law = law_of(scene, contact, wall.restitution, wall.friction)
            self._walls.append(_Wall(face, axis, sign, place, law, motion))
            self._wall_normals.append(np.tile(sign * np.eye(3)[axis], (number, 1)))
        laws = [law_of(scene, contact, scene.hard_spheres.restitution, scene.hard_spheres.friction)]
        laws += [wall.law for wall in self._walls]
        cylinder = None if scene.box is None else scene.box.cylinder
        self._cylinder = cylinder
        if cylinder is not None:
            laws.append(law_of(scene, contact, cylinder.restitution, cylinder.friction))
            self._centre = lengths / 2
        self._i, self._j = np.triu_indices(number, 1)
        rounds = len(laws) - 1
        self._one = np.concatenate([self._i, np.tile(np.arange(number), rounds)])
        self._of_pairs = np.arange(self._one.size) < self._i.size
        kinds = np.concatenate([np.zeros(self._i.size, dtype=int), 1 + np.repeat(np.arange(rounds), number)])
        self._law = np.array(laws)[kinds]
        r_i, m_i = self._radii[self._one], self._masses[self._one]
        r_j, m_j = np.zeros(r_i.size), np.full(r_i.size, np.inf)
        r_j[: self._j.size], m_j[: self._j.size] = self._radii[self._j], self._masses[self._j]
        self._r_i, self._r_j = r_i, r_j
        self._mass = 1 / (1 / m_i + 1 / m_j)
        self._radius = np.where(self._of_pairs, r_i * r_j / (r_i + r_j), r_i)
        self._turned_first = np.full(r_i.size, turned_first(scene, contact))
        self._turned_first |= self.turned_at_walls & ~self._of_pairs
        self.stretches = np.zeros((r_i.size, 3))
        self.slid = 0

    @property
    def pair_count(self) -> int:
        """Number of pairs: the first of the contacts."""
        return int(self._i.size)

    def most_at_once(self, touching: NDArray[np.bool_]) -> int:
        """Most contacts of one grain. touching: (contacts,)."""
        counts = np.bincount(self._one[touching], minlength=self._radii.size)
        counts += np.bincount(self._j[touching[: self._j.size]], minlength=self._radii.size)
        return int(counts.max())

    @property
    def masses(self) -> Floats:
        """(N,)."""
        return self._masses

    @property
    def field(self) -> Floats:
        """The uniform acceleration, (3,)."""
        return self._field

    @property
    def inertias(self) -> Floats:
        """Moments of inertia, (N,)."""
        return self._inertias

    @property
    def steepest(self) -> tuple[float, float]:
        """Largest stiffness and dashpot over the mass of a grain: a bound of d a/d r, 1/time^2, and d a/d v, 1/time.

        For overlaps up to the smallest radius.
        """
        mass = float(self._masses.min())
        s = np.where(self.contact.law == "hertz", self._radius, 1.0)
        rate = np.maximum(self._law[:, 0], self._law[:, 2]) * s * 1.5
        dashpots = np.maximum(self._dashpot(self._law[:, 1], s), self._dashpot(self._law[:, 3], s))
        q = inertia_ratio(self.scene)
        return float(rate.max()) * (1 + 1 / q) / mass, float(dashpots.max()) * (1 + 1 / q) / mass

    def _dashpot(self, coefficient: Floats, s: Floats) -> Floats:
        if self.contact.gamma_n is not None:
            return np.asarray(s * coefficient * self._mass)
        return np.asarray(coefficient * np.sqrt(self._mass * self._law[:, 0] * s))

    def _geometry(self, r: Floats, v: Floats, time: float) -> tuple[Floats, Floats, Floats]:
        """Overlap (contacts,), normal towards the first body and velocity of the centres, (contacts, 3)."""
        apart = r[self._i] - r[self._j]
        sides = self._periods > 0
        if sides.any():
            lengths = self._periods[sides]
            apart[:, sides] -= lengths * np.round(apart[:, sides] / lengths)
        far = np.sqrt((apart**2).sum(axis=1))
        overlaps = [self._r_i[: far.size] + self._r_j[: far.size] - far]
        normals, speeds = [apart / far[:, None]], [v[self._i] - v[self._j]]
        for wall, wall_normals in zip(self._walls, self._wall_normals, strict=True):
            amplitude, frequency, phase = wall.motion
            angle = frequency * time + phase
            place = wall.place + wall.sign * amplitude * math.cos(angle)
            surface = np.zeros(3)
            surface[wall.axis] = -wall.sign * amplitude * frequency * math.sin(angle)
            overlaps.append(self._radii - wall.sign * (r[:, wall.axis] - place))
            normals.append(wall_normals)
            speeds.append(v - surface)
        if self._cylinder is not None:
            outwards, far, turning = self._about_axis(r)
            overlaps.append(far + self._radii - self._cylinder.radius)
            normals.append(-outwards)
            speeds.append(v - self._cylinder.angular_velocity * self._cylinder.radius * turning)
        return np.concatenate(overlaps), np.concatenate(normals), np.concatenate(speeds)

    def _about_axis(self, r: Floats) -> tuple[Floats, Floats, Floats]:
        """Unit vectors (N, 3) from the axis and in the sense of turning, and distances from the axis (N,)."""
        first, second = self.scene.across
        off = np.zeros((len(r), 3))
        off[:, [first, second]] = r[:, [first, second]] - self._centre[[first, second]]
        far = np.linalg.norm(off, axis=1)
        outwards = off / far[:, None]
        turning = np.zeros_like(outwards)
        turning[:, first], turning[:, second] = -outwards[:, second], outwards[:, first]
        return outwards, far, turning

    def evaluate(self, r: Floats, v: Floats, w: Floats, time: float, elapsed: float) -> Evaluation:
        """The contacts' forces at a moment; the stretches grow by `elapsed` times the slip, and are kept.

        r, v, w: positions, velocities and spins, (N, 3). time: of the clock of the walls. elapsed: since the last call.
        """
        overlap, n, g = self._geometry(r, v, time)
        touching = overlap > 0
        depth = np.where(touching, overlap, 0.0)
        s = np.sqrt(self._radius * depth) if self.contact.law == "hertz" else np.ones(depth.size)
        approach = (g * n).sum(axis=1)
        k, normal_damping, _, _, _ = self._law.T
        f_n = np.where(touching, s * k * depth - self._dashpot(normal_damping, s) * approach, 0.0)
        rolls = self._r_i[:, None] * w[self._one]
        rolls[: self._j.size] += self._r_j[: self._j.size, None] * w[self._j]
        u = g - approach[:, None] * n - _cross(rolls, n)
        f_t = self._friction(touching, s, f_n, n, u, elapsed)
        force = f_n[:, None] * n + f_t
        total, torque = np.zeros_like(r), np.zeros_like(w)
        np.add.at(total, self._one, force)
        np.subtract.at(total, self._j, force[: self._j.size])
        shorter = np.where(self._of_pairs & self._turned_first, depth / 2, 0.0)
        turn = -_cross(n, f_t)
        np.add.at(torque, self._one, (self._r_i - shorter)[:, None] * turn)
        np.add.at(torque, self._j, ((self._r_j - shorter)[:, None] * turn)[: self._j.size])
        pairs = self._of_pairs & touching
        far = self._r_i + self._r_j - overlap
        springs = s * k * depth**2 * (2 / 5 if self.contact.law == "hertz" else 1 / 2)
        on_walls, about = self._on_walls(r, n, force, f_t)
        return Evaluation(
            total / self._masses[:, None] + self._field,
            torque / self._inertias[:, None],
            touching,
            int(pairs.sum()),
            float((far * f_n)[pairs].sum()),
            on_walls,
            about,
            float(springs.sum()),
            float(abs(force).max(initial=0.0)),
        )

    def _friction(
        self, touching: NDArray[np.bool_], s: Floats, f_n: Floats, n: Floats, u: Floats, elapsed: float
    ) -> Floats:
        """F_t (contacts, 3); the stretches are brought up to date."""
        k_t, mu = s * self._law[:, 2], self._law[:, 4]
        dashpot = self._dashpot(self._law[:, 3], s)[:, None] * u
        with np.errstate(invalid="ignore"):
            limit = np.where(mu > 0, mu * abs(f_n), 0.0)
        limit = np.where(np.isnan(limit), np.inf, limit)  # mu = infinity at F_n = 0
        xi = self.stretches
        xi[~touching] = 0.0
        rough = touching & (mu > 0) if self.scene.spin_dimension else np.zeros_like(touching)
        if self.contact.friction == "dashpot":
            self.slid += int((rough & (np.linalg.norm(dashpot, axis=1) > limit)).sum())
            return np.where(rough[:, None], _cut(-dashpot, limit), 0.0)
        if elapsed != 0.0 and self._turned_first.any():
            along, length = (xi * n).sum(axis=1), np.linalg.norm(xi, axis=1)
            flat = xi - along[:, None] * n
            after = np.linalg.norm(flat, axis=1)
            turned = flat * np.divide(length, after, out=np.zeros_like(after), where=after > 0)[:, None]
            least = np.where(np.isfinite(mu), _SLIGHT * limit, 0.0)
            xi = np.where((self._turned_first & (abs(along) * k_t > least))[:, None], turned, xi)
        xi = np.where(rough[:, None], xi + elapsed * u, 0.0)
        begun = np.asarray(xi.any(axis=1))
        if elapsed != 0.0 and not self._turned_first.all():
            xi = np.where(self._turned_first[:, None], xi, xi - (xi * n).sum(axis=1)[:, None] * n)
        free = -k_t[:, None] * xi - dashpot
        beyond = rough & (np.linalg.norm(free, axis=1) > limit)
        f_t = np.where(beyond[:, None], _cut(free, limit) * begun[:, None], free)
        yielding = beyond & begun & (k_t > 0)
        xi[yielding] = (-(f_t + dashpot) / np.where(k_t > 0, k_t, 1.0)[:, None])[yielding]
        self.stretches = xi
        self.slid += int(beyond.sum())
        return np.where(rough[:, None], f_t, 0.0)

    def _on_walls(self, r: Floats, n: Floats, force: Floats, f_t: Floats) -> tuple[Floats, float]:
        """Forces on the walls (faces, 3), and the change of the grains' angular momentum about the cylinder's axis.

        The latter is that of the orbits, (r - c) x F, and that of the spins.
        """
        number = len(r)
        by_wall = force[self._i.size :].reshape(-1, number, 3)
        faces = np.zeros((2 * self.scene.dimension + (self._cylinder is not None), 3))
        for wall, forces in zip(self._walls, by_wall, strict=False):
            faces[wall.face] = -forces.sum(axis=0)
        if self._cylinder is None:
            return faces, 0.0
        faces[-1] = -by_wall[-1].sum(axis=0)
        first, second = self.scene.across
        axis = np.cross(np.eye(3)[first], np.eye(3)[second])
        off = np.zeros((number, 3))
        off[:, [first, second]] = (r[:, : self.scene.dimension] - self._centre)[:, [first, second]]
        spin = -self._radii[:, None] * _cross(n[-number:], f_t[-number:])
        return faces, float(((_cross(off, by_wall[-1]) + spin) @ axis).sum())

    def height_energy(self, r: Floats) -> float:
        """Energy in the uniform field, -sum m a.r; r: positions (N, 3)."""
        return -float((self._masses[:, None] * r * self._field).sum())


def _cross(a: Floats, b: Floats) -> Floats:
    """a x b of rows of three components."""
    return np.asarray(a[:, [1, 2, 0]] * b[:, [2, 0, 1]] - a[:, [2, 0, 1]] * b[:, [1, 2, 0]])


def _cut(forces: Floats, limit: Floats) -> Floats:
    """Forces (contacts, 3) of at most the size `limit` (contacts,)."""
    size = np.linalg.norm(forces, axis=1)
    factor = np.divide(limit, size, out=np.ones_like(size), where=size > limit)
    return np.asarray(forces * factor[:, None])


class Finding(NamedTuple):
    """The largest error of one quantity over the rounding that explains it; above 1 it is wrong.

    share: error/rounding. error, rounding: in the unit of the quantity. sample: number of the recorded state.
    """

    share: float
    error: float
    rounding: float
    sample: int


class Audited(NamedTuple):
    """What `audit` found, by quantity, and what happened: of use to see that a run has judged anything.

    findings: by name of the observable. contacts, walls: numbers of pairs, and of grains at walls, that began to touch.
    again: those of both that had touched before. at_once: most contacts of one grain at one time. slid: contacts times
    steps at Coulomb's limit.
    """

    findings: dict[str, Finding]
    contacts: int
    walls: int
    again: int
    at_once: int
    slid: int

    @property
    def worst(self) -> tuple[str, Finding]:
        """Name and finding of the quantity with the largest share; a NaN counts as infinite."""
        return max(self.findings.items(), key=lambda one: math.inf if math.isnan(one[1].share) else one[1].share)


class _Largest:
    """The largest error over rounding of each quantity so far."""

    def __init__(self) -> None:
        self.findings: dict[str, Finding] = {}

    def compare(self, name: str, measured: Any, expected: Any, rounding: float, sample: int) -> None:
        error = float(np.abs(np.asarray(measured) - np.asarray(expected)).max(initial=0.0))
        share = error / rounding if rounding > 0 else (0.0 if error == 0 else math.inf)
        before = self.findings.get(name)
        # not "larger": a NaN is the largest, and stays
        if before is None or not (share <= before.share or math.isnan(before.share)):
            self.findings[name] = Finding(share, error, rounding, sample)


def _padded(vectors: Floats) -> Floats:
    """(..., d) as (..., 3)."""
    wide = np.zeros((*vectors.shape[:-1], 3))
    wide[..., : vectors.shape[-1]] = vectors
    return wide


def _spins(run: Mapping[str, Floats], name: str, shape: tuple[int, ...]) -> Floats:
    """Angular velocities as vectors of three components; zero of grains that do not turn."""
    wide = np.zeros(shape)
    if name in run:
        given = run[name]
        wide[..., 3 - given.shape[-1] :] = given
    return wide


def audit(
    scene: Scene, contact: Contact, dt: float, run: Mapping[str, Floats], turned_at_walls: bool = False
) -> Audited:
    """Every step of a run, computed from the recorded state before it, and every sum over the run.

    scene: hard spheres, recorded at each step with its trajectory. contact: of the method. dt: time step, time. run:
    arrays by the names of observables; those that the scene asks for are judged. turned_at_walls: see `Contacts`.
    ValueError if the run does not hold every step.

    The rounding of a step is that of its coordinates (size of the largest one, on which overlaps depend), times the
    steepest force where they make a velocity; a stretch adds up that of all steps before.
    """
    contacts, found = Contacts(scene, contact, turned_at_walls), _Largest()
    state = scene.initial_state(contact)
    r, v = _padded(run["positions"]), _padded(run["velocities"])
    w = _spins(run, "angular_velocities", r.shape)
    steps = len(r) - 1
    if steps != scene.steps(dt) or not np.isfinite(r).all():
        raise ValueError(f"an audit needs every one of {scene.steps(dt)} steps, finite, got {steps}")
    found.compare("positions", r[0], _padded(state.positions), 0.0, 0)
    found.compare("velocities", v[0], _padded(state.velocities), 0.0, 0)
    if state.angular_velocities is not None:
        found.compare("angular_velocities", w[0], _spins({"w": state.angular_velocities}, "w", r[0].shape), 0.0, 0)
    size = float(max([abs(r).max(), *(() if state.lengths is None else state.lengths)]))
    speed = _largest_speed(scene, v, w, contacts)
    by_place, by_speed = contacts.steepest
    light, small = float(contacts.masses.min()), float(contacts.inertias.min() / contacts.masses.min()) ** 0.5
    now = contacts.evaluate(r[0], v[0], w[0], 0.0, 0.0)
    history = [now]
    began, touched, again = np.zeros(now.touching.size, dtype=int), now.touching.copy(), 0
    for step in range(steps):
        half, turning = v[step] + dt / 2 * now.a, w[step] + dt / 2 * now.spins
        after = contacts.evaluate(r[step + 1], half, turning, (step + 1) * dt, dt)
        # of the coordinates in the overlaps, of all slips in the stretches, and of the clock, which steps too
        time = (step + 1) * dt
        place = EPSILON * (_ROUNDINGS * (size + time * speed) + (step + 1) * time * speed)
        pace = _ROUNDINGS * EPSILON * (speed + dt * max(now.sharpest, after.sharpest) / light)
        change = dt * (by_place * place + by_speed * pace)
        found.compare("positions", r[step + 1], r[step] + dt * half, place + dt * (pace + change), step + 1)
        found.compare("velocities", v[step + 1], half + dt / 2 * after.a, pace + change, step + 1)
        if scene.spin_dimension:
            expected = turning + dt / 2 * after.spins
            found.compare("angular_velocities", w[step + 1], expected, (pace + change) / small, step + 1)
        begins = after.touching & ~now.touching
        again += int((begins & touched).sum())
        touched |= after.touching
        began += begins
        now = after
        history.append(now)
    _ends(run, found)
    force_rounding = light * (by_place * place + by_speed * pace) * max(1, len(contacts.masses))
    _sums(dt, run, contacts, history, found, (r, v, w), (size, force_rounding))
    return Audited(
        found.findings,
        int(began[: contacts.pair_count].sum()),
        int(began[contacts.pair_count :].sum()),
        again,
        max(contacts.most_at_once(one.touching) for one in history),
        contacts.slid,
    )


def _largest_speed(scene: Scene, v: Floats, w: Floats, contacts: Contacts) -> float:
    """Of grains, of their surfaces and of walls."""
    walls = [face.oscillation for face in scene.faces if face is not None]
    speeds = [moves.amplitude * moves.frequency for moves in walls if moves is not None]
    cylinder = None if scene.box is None else scene.box.cylinder
    if cylinder is not None:
        speeds.append(abs(cylinder.angular_velocity) * cylinder.radius)
    radius = float(np.sqrt(contacts.inertias / contacts.masses).max())
    return max(float(abs(v).max()), float(abs(w).max()) * radius, *speeds, 0.0)


def _ends(run: Mapping[str, Floats], found: _Largest) -> None:
    """The final state is the last sample."""
    for name in ("positions", "velocities", "angular_velocities"):
        if name in run:
            found.compare(f"final_{name}", run[f"final_{name}"], run[name][-1], 0.0, len(run[name]) - 1)


def _sums(
    dt: float,
    run: Mapping[str, Floats],
    contacts: Contacts,
    history: list[Evaluation],
    found: _Largest,
    states: tuple[Floats, Floats, Floats],
    sizes: tuple[float, float],
) -> None:
    """Energies at the samples; sums over the run, which velocity Verlet makes by the trapezoidal rule.

    states: r, v and w of the samples. sizes: the largest coordinate, and the rounding of the forces on a grain.
    """
    (r, v, w), (size, rounding), last = states, sizes, len(history) - 1
    turning = (contacts.inertias[:, None] * w**2 / 2).sum(axis=(1, 2))
    moving = (contacts.masses[:, None] * v**2 / 2).sum(axis=(1, 2)) + turning
    terms = r.shape[1] * 6 * EPSILON
    elastic = np.array([one.elastic for one in history])
    heights = np.array([contacts.height_energy(places) for places in r])
    lifted = float((contacts.masses[:, None] * abs(r * contacts.field)).sum(axis=(1, 2)).max())
    spread = max(one.sharpest for one in history) * len(contacts.masses) ** 2 * _ROUNDINGS * EPSILON * size
    for name, expected, tolerance in (
        ("kinetic_energy", moving, terms * float(moving.max())),
        ("rotational_energy", turning, terms * float(turning.max())),
        ("potential_energy", elastic + heights, spread + terms * (lifted + float(elastic.max()))),
    ):
        if name in run:
            found.compare(name, run[name], expected, tolerance, last)
    rates = {
        "contact_time": (np.array([one.pairs for one in history], dtype=float), EPSILON),
        "collisional_virial": (np.array([one.virial for one in history]), rounding * size),
        "wall_impulse": (np.array([one.walls for one in history])[:, :, : contacts.scene.dimension], rounding),
        "wall_torque": (np.array([one.torque for one in history]), rounding * size),
    }
    for name, (rate, error) in rates.items():
        if name in run:
            sums = np.zeros_like(rate)
            sums[1:] = dt / 2 * np.cumsum(rate[1:] + rate[:-1], axis=0)
            most = float(abs(sums).max(initial=0.0))
            found.compare(name, run[name], sums, last * (dt * error + EPSILON * most), last)
