"""Hard spheres in LAMMPS: soft grains of its GRANULAR package, with the contact laws of `soft_spheres`.

Pairs of grains of one mass go by the classic styles, which are the fastest: `gran/hooke`, and with tangential springs
`gran/hooke/history`. Their dashpots are m_eff gamma, so gamma = c sqrt(k/m_eff). Unlike masses and "hertz" go by
`pair_style granular` with `damping coeff_restitution`, which is eta_n = c sqrt(m_eff k) of every pair.

With coefficients of the contact's own, gamma_n and gamma_t are those of the classic styles, `gran/hertz/history` too,
for any masses. E and nu are `hertz/material` with `tangential mindlin NULL`, and so LAMMPS's own formulas; dampings
beside them, and of "hertz" with a tangential dashpot, are `viscoelastic`.

Walls are granular ones throughout: the classic `hooke/history` wall of LAMMPS 22Jul2025 multiplies k_t by the radius of
the contact, and yields NaN without normal damping. At a plane, the tangential springs of both kinds are the same. For
E and nu, walls have the stiffnesses that follow: `hertz/material` of a wall has another mean of the moduli than of a
pair (https://github.com/lammps/lammps/issues/4141).

A region that moves (the turning cylinder, an oscillating face) has no velocity before the first step: grains that start
in contact with it feel a wall at rest in the first half-step.

The forces are evaluated with the velocities at the half-step: with dashpots or friction the scheme is of order 1.

Literature: L. E. Silbert et al., Phys. Rev. E 64, 051302 (2001), and the manual's pages of these styles.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from crosscheck.engines import soft_spheres
from crosscheck.engines.lammps.instance import FEW, Atoms, advance, box, pair_virial
from crosscheck.engines.protocol import Run, shapes, strides
from crosscheck.engines.soft_spheres import ContactLaw, SoftSpheres
from crosscheck.scene import AXES, Contact, Cylinder, Face, Method, Oscillation, Scene, State
from crosscheck.scene.observables import TABLE

#: Stands for no limit of friction: LAMMPS's largest coefficient of friction.
_MOST_FRICTION = 1e4
#: Restitution in place of 1 beside a tangential dashpot, which LAMMPS defines as a multiple of the normal one: with 1,
#: both would be 0.
_NEARLY_ELASTIC = math.nextafter(1.0, 0.0)
#: Share of the normal damping in the tangential one where the former is 0, since LAMMPS has a multiple of it: a power
#: of two, so that the product is exact.
_NEARLY_UNDAMPED = 2.0**-60
#: Skin of the neighbour list in largest diameters: among the fastest of 0.03 to 0.5, for steps of t_c/50 and t_c/5.
_SKIN = 0.1
#: I/(m R^2) in LAMMPS's rotational energy, whatever `fix nve/sphere` integrates.
_INERTIA = 0.4
#: A phase counts as 0 or pi up to this sine: the floating-point number nearest to pi has a sine of 1e-16.
_ROUNDING = 1e-15


def unsupported(scene: Scene, method: Method) -> str | None:
    """None, or the reason why LAMMPS cannot run this scene of hard spheres as soft ones.

    scene: of words that the engine declares. method: gives the contact.
    """
    reason = soft_spheres.unsupported(scene, method)
    if reason is not None:
        return reason
    assert method.contact is not None
    inertia = soft_spheres.inertia_ratio(scene)
    if scene.spin_dimension and inertia != _INERTIA and (scene.dimension, inertia) != (2, 0.5):
        return f"fix nve/sphere turns spheres (q = 2/5) and, in the plane, disks (q = 1/2), not q = {inertia:g}"
    if method.contact.law == "hertz" and scene.across:
        return 'contact.law = "hertz": at a cylinder, R_eff of LAMMPS contains the curvature of the wall'
    return None


def integrate(lammps: Any, lmp: Any, scene: Scene, method: Method) -> Run:
    """Runs a scene of hard spheres as soft ones.

    lammps: the module. lmp: a new LAMMPS instance. scene, method: accepted by `unsupported`. UsageError if dt does not
    divide duration and interval.
    """
    contact = method.contact
    assert contact is not None
    laws = soft_spheres.soft_spheres(scene, contact)
    grains = _Grains(lmp, scene, scene.initial_state(contact))
    _, every = strides(scene, method)
    lmp.commands_list(
        [
            *_pairs(scene, laws, contact, grains.state),
            *_motion(scene),
            *_walls(scene, laws, method),
            *(["fix plane all enforce2d"] if scene.dimension == 2 else []),
            *_records(scene, every),
        ]
    )
    run, good = advance(lmp, grains, scene, method)
    _read(lammps, lmp, scene, run, good, method.step, every)
    run.remarks = tuple(soft_spheres.remarks(scene, method, grains.state.velocities))
    return run


class _Grains(Atoms):
    """The particles of a scene, in a box that extends a diameter beyond its walls."""

    def __init__(self, lmp: Any, scene: Scene, state: State) -> None:
        assert state.diameters is not None
        super().__init__(lmp, scene, state)
        styles, edges = ["p"] * 3, [(-0.5, 0.5)] * 3
        margin = float(state.diameters.max())
        for axis, boundary in enumerate(scene.boundaries):
            length = 0.0 if state.lengths is None else float(state.lengths[axis])
            if boundary == "periodic":
                edges[axis] = (0.0, length)
                continue
            x = state.positions[:, axis]
            faces = scene.faces[2 * axis : 2 * axis + 2]
            beyond = [margin + (0.0 if face is None else _amplitude(face)) for face in faces]
            walled = [face is not None or axis in scene.across for face in faces]
            lower = 0.0 if walled[0] else float(x.min())
            upper = length if walled[1] else float(x.max())
            edges[axis] = (lower - beyond[0], upper + beyond[1])
            styles[axis] = "".join("f" if wall else "s" for wall in walled)
        few_unbounded = any("s" in style for style in styles) and scene.number <= FEW
        lmp.commands_list(
            [
                "units lj",
                "newton off",  # some percent faster: no forces are sent back from ghost atoms
                "atom_style sphere",
                *box(scene.dimension, styles, edges, 1, sort=not few_unbounded),
                "comm_modify vel yes",
                f"neighbor {_SKIN * margin!r} {'nsq' if few_unbounded else 'bin'}",
                "neigh_modify delay 0 every 1 check yes",
            ]
        )
        self.create([1] * scene.number, self.wrapped)
        self.assign("radius", state.diameters / 2)
        self.assign("rmass", state.masses)
        if state.angular_velocities is not None:
            spins = np.zeros((scene.number, 3))
            spins[:, 3 - scene.spin_dimension :] = state.angular_velocities
            self.assign("omega", spins)


def _amplitude(face: Face) -> float:
    return 0.0 if face.oscillation is None else face.oscillation.amplitude


def _pairs(scene: Scene, laws: SoftSpheres, contact: Contact, state: State) -> Iterator[str]:
    """Commands for the contacts of pairs."""
    assert scene.hard_spheres is not None
    law = laws.pair
    springs = bool(law.tangential_stiffness and law.friction)
    if laws.granular or (contact.law == "hertz" and not springs):
        yield "pair_style granular"
        yield f"pair_coeff * * {_granular(law, contact, scene.hard_spheres.restitution, pairs=True)}"
        return
    rate = 1.0 if laws.by_mass else math.sqrt(law.stiffness / (float(state.masses[0]) / 2))
    numbers = (
        law.stiffness,
        law.tangential_stiffness,
        law.damping * rate,
        law.tangential_damping * rate,
        min(law.friction, _MOST_FRICTION),
    )
    style = f"gran/{contact.law}/history" if springs else "gran/hooke"
    yield f"pair_style {style} {' '.join(repr(float(number)) for number in numbers)} 1"
    yield "pair_coeff * *"


def _granular(law: ContactLaw, contact: Contact, restitution: float, pairs: bool = False) -> str:
    """Arguments of `pair_style granular` (pairs) and `fix wall/gran granular` for the law."""
    limit, damping = min(law.friction, _MOST_FRICTION), law.damping
    if contact.gamma_n is not None:
        kind = "mass_velocity" if contact.law == "hooke" else "viscoelastic"
        damping = damping or law.tangential_damping * _NEARLY_UNDAMPED
        coefficient = damping
    else:
        kind = "coeff_restitution"
        if law.tangential_damping and not damping:
            restitution, damping = _NEARLY_ELASTIC, -2 * math.log(_NEARLY_ELASTIC) / math.pi
        coefficient = restitution
    share = law.tangential_damping / damping if law.tangential_damping else 0.0
    material = pairs and contact.E is not None
    if law.tangential_stiffness and law.friction:
        spring = "linear_history" if contact.law == "hooke" else "mindlin"
        tangential = f"{spring} {'NULL' if material else repr(law.tangential_stiffness)} {share!r} {limit!r}"
    else:
        tangential = f"linear_nohistory {share!r} {limit!r}"
    normal = f"{contact.law} {law.stiffness!r} {coefficient!r}"
    if material:
        normal = f"hertz/material {contact.E!r} {coefficient!r} {contact.nu!r}"
    return f"{normal} damping {kind} tangential {tangential}"


def _motion(scene: Scene) -> Iterator[str]:
    """Commands for the integrator and the uniform field."""
    disks = scene.dimension == 2 and soft_spheres.inertia_ratio(scene) == 0.5
    yield f"fix integrate all {'nve/sphere' + ' disc' * disks if scene.spin_dimension else 'nve'}"
    if scene.acceleration is not None and any(scene.acceleration):
        field = [*scene.acceleration, 0.0][:3]
        yield f"fix field all gravity {math.hypot(*field)!r} vector {' '.join(map(repr, field))}"


def _walls(scene: Scene, laws: SoftSpheres, method: Method) -> Iterator[str]:
    """Commands for the plane walls and the cylinder."""
    contact, lengths = method.contact, scene.lengths()
    assert contact is not None
    # "contacts": the fix keeps the force on every particle
    keep = " contacts" if {"wall_impulse", "wall_torque"} & set(scene.output.observables) else ""
    for index, (face, law) in enumerate(zip(scene.faces, laws.faces, strict=True)):
        if face is None or law is None:
            continue
        assert lengths is not None
        axis, upper = divmod(index, 2)
        place, style = float(lengths[axis]) if upper else 0.0, "wall/gran"
        if face.oscillation is None:
            wall = _plane(axis, upper, place)
        elif abs(math.sin(face.oscillation.phase)) <= _ROUNDING:
            wall = _wiggling_plane(axis, upper, place, face.oscillation)
        else:
            yield from _oscillating_region(index, place, face.oscillation, method.step)
            style, wall = "wall/gran/region", f"region plane{index}"
        granular = _granular(law, contact, face.restitution)
        yield f"fix face{index} all {style} granular {granular} {wall}{keep}"
    if laws.cylinder is not None:
        assert scene.box is not None
        assert scene.box.cylinder is not None
        yield from _cylinder(scene, scene.box.cylinder, method.step)
        granular = _granular(laws.cylinder, contact, scene.box.cylinder.restitution)
        yield f"fix face{len(scene.faces)} all wall/gran/region granular {granular} region drum{keep}"


def _plane(axis: int, upper: int, place: float) -> str:
    return f"{AXES[axis]}plane {f'NULL {place!r}' if upper else f'{place!r} NULL'}"


def _wiggling_plane(axis: int, upper: int, place: float, oscillation: Oscillation) -> str:
    """A plane at place + a cos(omega t), a > 0 into the box for phase 0: LAMMPS has lo + A - A cos(omega t)."""
    a = (-1) ** upper * oscillation.amplitude * math.copysign(1.0, math.cos(oscillation.phase))
    period = 2 * math.pi / oscillation.frequency
    return f"{_plane(axis, upper, place + a)} wiggle {AXES[axis]} {-a!r} {period!r}"


def _oscillating_region(index: int, place: float, oscillation: Oscillation, dt: float) -> Iterator[str]:
    """Commands for the same plane at any phase: a moving region; its velocity is the mean over the step, first 0."""
    axis, upper = divmod(index, 2)
    point, normal, motion = ["0.0"] * 3, ["0.0"] * 3, ["NULL"] * 3
    point[axis], normal[axis], motion[axis] = repr(place), repr((-1.0) ** upper), f"v_shift{index}"
    a = (-1) ** upper * oscillation.amplitude
    yield f"variable shift{index} equal {a!r}*cos({oscillation.frequency * dt!r}*step+{oscillation.phase % math.tau!r})"
    yield f"region plane{index} plane {' '.join(point)} {' '.join(normal)} side in move {' '.join(motion)} units box"


def _cylinder(scene: Scene, cylinder: Cylinder, dt: float) -> Iterator[str]:
    """The region inside of the cylinder, which turns from the first axis across it to the second."""
    middle, axis = _centre(scene), AXES.index(cylinder.axis or "z")
    across = " ".join(repr(middle[i]) for i in scene.across)
    turn = ""
    if cylinder.angular_velocity != 0:
        # for the axis y, from x to z is the negative sense of rotation
        yield f"variable turn equal {(-1 if axis == 1 else 1) * cylinder.angular_velocity * dt!r}*step"
        turn = f" rotate v_turn {' '.join(map(repr, middle))} {' '.join('1' if i == axis else '0' for i in range(3))}"
    yield f"region drum cylinder {AXES[axis]} {across} {cylinder.radius!r} INF INF side in{turn} units box"


def _centre(scene: Scene) -> list[float]:
    """Centre of the box, three coordinates."""
    lengths = scene.lengths()
    assert lengths is not None
    return [*(0.5 * lengths).tolist(), 0.0][:3]


class _Rate(NamedTuple):
    """A variable of LAMMPS whose integral over time, times `sign`, is a flat element of an observable."""

    observable: str
    element: int
    sign: float
    variable: str


def _energies(scene: Scene) -> list[str]:
    return [name for name in ("kinetic_energy", "rotational_energy") if name in scene.output.observables]


def _rates(scene: Scene) -> list[_Rate]:
    asked, d = scene.output.observables, scene.dimension
    rates = [
        _Rate("collisional_virial", 0, 1.0, "virial"),
        _Rate("contact_time", 0, 1.0, "touching"),
        # of the force on the grains: the faces get the opposite
        *(_Rate("wall_impulse", d * w + i, -1.0, f"push{w}{AXES[i]}") for w in _wall_indices(scene) for i in range(d)),
        _Rate("wall_torque", 0, 1.0, "torque"),
    ]
    return [rate for rate in rates if rate.observable in asked]


def _wall_indices(scene: Scene) -> list[int]:
    """Indices, in `face_names`, of the walls that exist."""
    there = [face is not None for face in scene.faces] + [True] * (len(scene.across) > 0)
    return [index for index, wall in enumerate(there) if wall]


def _records(scene: Scene, every: int) -> Iterator[str]:
    """Commands that record the observables inside LAMMPS, without a call to Python per sample.

    Integrals over time follow the trapezoidal rule over all steps: with it, velocity Verlet changes momentum and
    angular momentum by exactly these integrals. Recorded are means over the steps from one sample to the next, and the
    rates at the samples; `_read` combines them.
    """
    energies, rates = _energies(scene), _rates(scene)
    asked = scene.output.observables
    if energies:
        rotation = ""
        if scene.spin_dimension:
            yield "compute rotation all erotate/sphere"
            rotation = f"{soft_spheres.inertia_ratio(scene) / _INERTIA!r}*c_rotation"
            yield f"variable rotational_energy equal {rotation}"
        yield "compute translation all ke"
        yield f"variable kinetic_energy equal c_translation{rotation and '+' + rotation}"
    if "collisional_virial" in asked:
        yield from pair_virial(scene.dimension)
    if "contact_time" in asked:
        yield "compute contacts all contact/atom"
        yield "compute touched all reduce sum c_contacts"
        yield "variable touching equal 0.5*c_touched"  # both grains of a pair count it
    if "wall_impulse" in asked:
        for wall in _wall_indices(scene):
            yield f"compute push{wall} all reduce sum f_face{wall}[2] f_face{wall}[3] f_face{wall}[4]"
            for i, axis in enumerate(AXES[: scene.dimension], 1):
                yield f"variable push{wall}{axis} equal c_push{wall}[{i}]"
    if "wall_torque" in asked:
        yield from _torque(scene)
    # all are variables: `fix vector` refuses a mixture of variables and computes, being neither intensive nor extensive
    changing = [f"v_{rate.variable}" for rate in rates]
    columns = [f"v_{name}" for name in energies] + changing
    if rates:
        yield f"fix sums all ave/time 1 {every} {every} {' '.join(changing)}"
        columns += ["f_sums"] if len(rates) == 1 else [f"f_sums[{i + 1}]" for i in range(len(rates))]
    if columns:
        yield f"fix samples all vector {every} {' '.join(columns)}"


def _torque(scene: Scene) -> Iterator[str]:
    """Commands for the torque of the cylinder about its axis; it acts on a particle at the point of contact."""
    drum, middle = len(scene.faces), _centre(scene)
    first, second = scene.across
    x, y = (f"({AXES[axis]}-{middle[axis]!r})" for axis in (first, second))
    yield f"variable off atom sqrt({x}^2+{y}^2)"
    yield "variable arm atom 1+radius/(v_off+(v_off==0))"
    yield f"variable twist atom v_arm*({x}*f_face{drum}[{second + 2}]-{y}*f_face{drum}[{first + 2}])"
    yield "compute torque all reduce sum v_twist"
    yield "variable torque equal c_torque"


def _read(lammps: Any, lmp: Any, scene: Scene, run: Run, good: int, dt: float, every: int) -> None:
    """Writes the observables into the run; good: number of samples before it diverged."""
    energies, rates = _energies(scene), _rates(scene)
    table = np.full((run["time"].size, len(energies) + 2 * len(rates)), np.nan)
    width = table.shape[1]
    style = lammps.LMP_TYPE_VECTOR if width == 1 else lammps.LMP_TYPE_ARRAY
    for i, j in np.ndindex(good, width):
        table[i, j] = lmp.extract_fix("samples", lammps.LMP_STYLE_GLOBAL, style, i, j)
    wanted = shapes(scene, run["time"].size)
    # of walls that are not there too: zeros
    tallies = {name: np.zeros(wanted[name]) for name in scene.output.observables if TABLE[name].cumulative}
    run.update({name: table[:, column] for column, name in enumerate(energies)})
    now, mean = np.split(table[:, len(energies) :], 2, axis=1)
    parts = dt * (every * mean[1:] + (now[:-1] - now[1:]) / 2)
    for column, rate in enumerate(rates):
        values = tallies[rate.observable].reshape(run["time"].size, -1)
        values[1:, rate.element] = rate.sign * np.cumsum(parts[:, column])
    for tally in tallies.values():
        tally[good:] = np.nan
    run.update(tallies)
