"""What happens at a contact: momentum is exchanged at once. The naive algorithm and the fast one share these rules.

Arguments that are the same throughout: model: `HardSpheres`. rows: (N, 7 or 8), a particle's position 0-2, velocity 3-5
and the time of that state 6; in two dimensions the third components are zero. spins: (N, 3) angular velocities, or None
of smooth particles; in two dimensions only the third is not zero. i, j: numbers of particles. n: the unit vector from i
to j, or from the particle to the wall. gn: relative normal velocity (v_j - v_i).n. rough, walls, cylinder, well: the
records of `refimpl.events.model`, or None. mass: of every particle. inverse_masses: (N,), or None where all are alike;
0 for a fixed particle. bonds: see `refimpl.events.prediction`. recent: whether the TC model makes this collision
elastic. alpha: coefficient of normal restitution. face: 2 axis + (0 for the lower, 1 for the upper wall). now: the
time, on the clock of the walls' phases. seed, count: of random walls, and hits on walls of the particle so far.
Units: any consistent set. `spins`, `bonds` and `seed` are typed Any: numba prunes by `rough`, `well` and the kind of
wall.

Literature: J. T. Jenkins and M. W. Richman, Phys. Fluids 28, 3485 (1985); O. R. Walton, in Particulate Two-Phase Flow
(ed. M. C. Roco), 884 (1993); S. F. Foerster et al., Phys. Fluids 6, 1108 (1994) (friction); S. Luding and S. McNamara,
Granul. Matter 1, 113 (1998) (time in contact); B. J. Alder and T. E. Wainwright, J. Chem. Phys. 31, 459 (1959) (wells).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from refimpl.events.kernels.compiled import inline, kernel
from refimpl.events.model import (
    AMPLITUDE,
    FLUX_PHASE,
    FREQUENCY,
    OSCILLATING,
    PHASE,
    RESTITUTION,
    SLIDING,
    STATIC,
    TANGENTIAL,
    TEMPERATURE,
    THERMAL,
    UNIFORM_PHASE,
    VELOCITY,
    CylinderWall,
    Floats,
    HardSpheres,
    PlaneWalls,
    Rough,
    Vector,
    Well,
)
from refimpl.events.prediction import bonded, contact_distance, radius_of
from refimpl.random_bits import GAMMA, mix64

_S11 = np.uint64(11)


@kernel
def random_uniform(seed: Any, particle: int, count: int, draw: int) -> float:
    """Uniform in (0, 1), a function of its arguments alone: no order of events, no scheduler enters.

    The hash of `refimpl.random_bits` of the seed (uint64), the particle, its hits on walls so far and the draw.
    """
    z = mix64(np.uint64(seed) + np.uint64(particle + 1) * GAMMA)
    z = mix64(z + np.uint64(count + 1) * GAMMA)
    z = mix64(z + np.uint64(draw + 1) * GAMMA)
    return (float(np.int64(z >> _S11)) + 0.5) * 2.0**-53


@inline
def inverse_mass(mass: float, inverse_masses: Floats | None, i: int) -> float:
    """1/m_i; 0 for a fixed particle."""
    if inverse_masses is None:
        return 1.0 / mass
    return inverse_masses[i]


@inline
def reduced_mass(mass: float, inverse_masses: Floats | None, i: int, j: int) -> float:
    """m_i m_j/(m_i + m_j)."""
    if inverse_masses is None:
        return 0.5 * mass
    return 1.0 / (inverse_masses[i] + inverse_masses[j])


@inline
def is_fixed(inverse_masses: Floats | None, i: int) -> bool:
    """Whether the particle is a fixed scatterer, of infinite mass."""
    if inverse_masses is None:
        return False
    return inverse_masses[i] == 0.0


@inline
def apply_impulse(model: HardSpheres, rows: Floats, i: int, j: int, impulse: Vector) -> None:
    """Particle j gets the momentum `impulse`, i loses it."""
    px, py, pz = impulse
    one = inverse_mass(model.mass, model.inverse_masses, i)
    other = inverse_mass(model.mass, model.inverse_masses, j)
    rows[i, 3] -= one * px
    rows[i, 4] -= one * py
    rows[i, 5] -= one * pz
    rows[j, 3] += other * px
    rows[j, 4] += other * py
    rows[j, 5] += other * pz


@inline
def normal_restitution(restitution: float | None, recent: bool) -> float:
    """alpha; 1 for elastic grains, and in the TC model for grains that have collided just before.

    restitution: of the model, None for elastic grains.
    """
    if restitution is None:
        return 1.0
    return 1.0 if recent else restitution


@inline
def still_in_contact(contact_duration: float | None, age: float) -> bool:
    """TC model (Luding and McNamara 1998): the last collision is less than t_c ago.

    contact_duration: t_c, or None. age: time since the last collision.
    """
    if contact_duration is None:
        return False
    return age < contact_duration


@inline
def tangential_impulse(
    normal: float, mass: float, slip: float, alpha_t: float, static: float, sliding: float, inertia: float
) -> float:
    """Factor of the contact's slip velocity v_ct in the tangential impulse on j.

    Sticking: v'_ct = alpha_t v_ct, |J_t| = (1 - alpha_t) q/(1 + q) mu |v_ct|; if that exceeds mu_s J_n, sliding:
    |J_t| = mu_k J_n. Walton (1993); Foerster et al., Phys. Fluids 6, 1108 (1994).

    normal: normal impulse J_n > 0. mass: reduced mass mu. slip: |v_ct| > 0. alpha_t: tangential restitution. static,
    sliding: mu_s and mu_k. inertia: q in I = q m R^2.
    """
    stick = (1.0 - alpha_t) * inertia / (1.0 + inertia) * mass
    if stick * slip > static * normal:
        return -sliding * normal / slip
    return -stick


@inline
def pair_impulse(
    rough: Rough | None,
    spins: Any,
    model: HardSpheres,
    rows: Floats,
    i: int,
    j: int,
    n: Vector,
    gn: float,
    alpha: float,
    recent: bool,
) -> Vector:
    """Momentum that j gets and i loses, for gn < 0; the spins are changed.

    Normal part -(1 + alpha) gn mu along n, mu the reduced mass; tangential part as `tangential_impulse`.
    """
    nx, ny, nz = n
    mass = reduced_mass(model.mass, model.inverse_masses, i, j)
    normal = -(1.0 + alpha) * gn * mass
    px, py, pz = normal * nx, normal * ny, normal * nz
    if rough is not None:
        ri, rj = radius_of(model.diameter, model.radii, i), radius_of(model.diameter, model.radii, j)
        wx = ri * spins[i, 0] + rj * spins[j, 0]
        wy = ri * spins[i, 1] + rj * spins[j, 1]
        wz = ri * spins[i, 2] + rj * spins[j, 2]
        tx = rows[j, 3] - rows[i, 3] - gn * nx - (wy * nz - wz * ny)
        ty = rows[j, 4] - rows[i, 4] - gn * ny - (wz * nx - wx * nz)
        tz = rows[j, 5] - rows[i, 5] - gn * nz - (wx * ny - wy * nx)
        slip = math.sqrt(tx * tx + ty * ty + tz * tz)
        if slip > 0.0 and not recent:
            factor = tangential_impulse(
                normal, mass, slip, rough.tangential_restitution, rough.static, rough.sliding, rough.inertia
            )
            tx, ty, tz = factor * tx, factor * ty, factor * tz
            px, py, pz = px + tx, py + ty, pz + tz
            along = (tx, ty, tz)
            _turn_spin(spins, i, rough.inertia, inverse_mass(model.mass, model.inverse_masses, i), ri, n, along)
            _turn_spin(spins, j, rough.inertia, inverse_mass(model.mass, model.inverse_masses, j), rj, n, along)
    return px, py, pz


@inline
def _turn_spin(spins: Any, i: int, inertia: float, inverse: float, radius: float, n: Vector, impulse: Vector) -> None:
    """I dw = -R n x J for either partner: arm and impulse both change sign between them."""
    nx, ny, nz = n
    px, py, pz = impulse
    factor = -inverse / (inertia * radius)
    spins[i, 0] += factor * (ny * pz - nz * py)
    spins[i, 1] += factor * (nz * px - nx * pz)
    spins[i, 2] += factor * (nx * py - ny * px)


@kernel
def well_velocity(gn: float, inside: bool, twice_depth: float) -> tuple[float, bool]:
    """Normal velocity after a pair meets the edge of its well, and whether it is inside then.

    inside: whether it was. twice_depth: 2 eps/mu, eps the depth and mu the reduced mass. Inwards: g'^2 = g^2 + 2 eps/mu
    (a shoulder, eps < 0, may reflect); outwards: g'^2 = g^2 - 2 eps/mu, or reflection where that is negative.
    """
    square = gn * gn + (-twice_depth if inside else twice_depth)
    if square < 0.0:
        return -gn, inside
    return math.copysign(math.sqrt(square), gn), not inside


@kernel
def wall_velocity(numbers: Floats, motion: int, now: float, v: float, seed: int, i: int, count: int) -> float:
    """The wall's own normal velocity V, into the box, that a particle with normal velocity v (< 0) meets.

    numbers, motion: of the wall, see `PlaneWalls`.
    Steady: its constant. Oscillating: -A omega sin(omega t + phase). Uniform random phase: V = V0 cos(phi), of those
    walls that the particle does approach. Flux: phi with weight V - v, as arrivals at a small fast oscillation have.
    """
    if motion == OSCILLATING:
        frequency = numbers[FREQUENCY]
        return -numbers[AMPLITUDE] * frequency * math.sin(numbers[PHASE] + frequency * now)
    top = numbers[VELOCITY]
    if motion == UNIFORM_PHASE or motion == FLUX_PHASE:
        draw = 0
        while draw < 10000:
            own = top * math.cos(2.0 * math.pi * random_uniform(seed, i, count, draw))
            chance = random_uniform(seed, i, count, draw + 1)
            draw += 2
            if own > v and (motion == UNIFORM_PHASE or chance * (abs(top) - v) < own - v):
                return own
    return top


@kernel
def thermal_velocity(temperature: float, inverse: float, seed: int, i: int, count: int) -> Vector:
    """Velocity from the flux of a gas: normal sqrt(-2 T/m ln u), two tangential components Gaussian of variance T/m.

    temperature: T, energy. inverse: 1/m.
    """
    width = math.sqrt(temperature * inverse)
    normal = width * math.sqrt(-2.0 * math.log(random_uniform(seed, i, count, 0)))
    size = width * math.sqrt(-2.0 * math.log(random_uniform(seed, i, count, 1)))
    angle = 2.0 * math.pi * random_uniform(seed, i, count, 2)
    return normal, size * math.cos(angle), size * math.sin(angle)


@kernel
def hit_plane(
    model: HardSpheres,
    walls: PlaneWalls,
    rough: Rough | None,
    seed: Any,
    rows: Floats,
    spins: Any,
    i: int,
    count: int,
    face: int,
    now: float,
    recent: bool,
) -> None:
    """The rule of a plane wall: v'_n = (1 + alpha) V - alpha v_n and a tangential law; or a thermal wall."""
    numbers, motion, axis = walls.numbers[face], walls.motion[face], face >> 1
    inwards = 1.0 if face & 1 == 0 else -1.0
    inverse = inverse_mass(model.mass, model.inverse_masses, i)
    v = inwards * rows[i, 3 + axis]
    if motion == THERMAL:
        normal, one, two = _thermal(seed, numbers[TEMPERATURE], inverse, i, count)
        rows[i, 3 + axis] = inwards * normal
        rows[i, 3 + (axis + 1) % 3] = one
        rows[i, 3 + (axis + 2) % 3] = two
        if len(model.lengths) == 2:  # the one tangential axis of two dimensions
            rows[i, 3 + 1 - axis] = one
            rows[i, 5] = 0.0
        return
    own = _own_velocity(seed, numbers, motion, now, v, i, count)
    if v - own >= 0.0:
        return
    alpha = 1.0 if recent else numbers[RESTITUTION]
    law = (numbers[TANGENTIAL], numbers[STATIC], numbers[SLIDING])
    push = (1.0 + alpha) * (own - v) / inverse
    _wall_friction(model, rough, rows, spins, i, _minus_unit(axis, inwards), (0.0, 0.0, 0.0), push, law, recent)
    rows[i, 3 + axis] = inwards * ((1.0 + alpha) * own - alpha * v)


@kernel
def _minus_unit(axis: int, inwards: float) -> Vector:
    """The unit vector towards the wall across `axis`; inwards: +1 for the lower face, -1 for the upper one."""
    return (-inwards if axis == 0 else 0.0, -inwards if axis == 1 else 0.0, -inwards if axis == 2 else 0.0)


@inline
def _thermal(seed: Any, temperature: float, inverse: float, i: int, count: int) -> Vector:
    if seed is None:
        return 0.0, 0.0, 0.0
    return thermal_velocity(temperature, inverse, seed, i, count)


@inline
def _own_velocity(seed: Any, numbers: Floats, motion: int, now: float, v: float, i: int, count: int) -> float:
    if seed is None:
        return wall_velocity(numbers, motion, now, v, 0, i, count)
    return wall_velocity(numbers, motion, now, v, seed, i, count)


@inline
def _wall_friction(
    model: HardSpheres,
    rough: Rough | None,
    rows: Floats,
    spins: Any,
    i: int,
    n: Vector,
    u: Vector,
    normal: float,
    law: Vector,
    recent: bool,
) -> None:
    """Tangential impulse of a wall whose surface moves with velocity u, on a grain that can turn; n is towards it.

    normal: the normal impulse. law: tangential restitution, static and sliding coefficient of friction.
    """
    if rough is not None:
        (nx, ny, nz), (ux, uy, uz), (alpha_t, static, sliding) = n, u, law
        if recent or alpha_t == 1.0:
            return
        inverse = inverse_mass(model.mass, model.inverse_masses, i)
        radius = radius_of(model.diameter, model.radii, i)
        wx, wy, wz = radius * spins[i, 0], radius * spins[i, 1], radius * spins[i, 2]
        tx = ux - rows[i, 3] - (wy * nz - wz * ny)
        ty = uy - rows[i, 4] - (wz * nx - wx * nz)
        tz = uz - rows[i, 5] - (wx * ny - wy * nx)
        along = tx * nx + ty * ny + tz * nz
        tx, ty, tz = tx - along * nx, ty - along * ny, tz - along * nz
        slip = math.sqrt(tx * tx + ty * ty + tz * tz)
        if slip > 0.0:
            factor = tangential_impulse(normal, 1.0 / inverse, slip, alpha_t, static, sliding, rough.inertia)
            tx, ty, tz = factor * tx, factor * ty, factor * tz
            rows[i, 3] -= tx * inverse
            rows[i, 4] -= ty * inverse
            rows[i, 5] -= tz * inverse
            _turn_spin(spins, i, rough.inertia, inverse, radius, n, (tx, ty, tz))


@kernel
def hit_cylinder(
    model: HardSpheres, cylinder: CylinderWall, rough: Rough | None, rows: Floats, spins: Any, i: int, recent: bool
) -> None:
    """The rule of the cylinder, which turns about the middle of the box: u = Omega x r at its surface."""
    first, second = cylinder.first, cylinder.second
    rx = rows[i, first] - 0.5 * model.lengths[first]
    ry = rows[i, second] - 0.5 * model.lengths[second]
    r = math.sqrt(rx * rx + ry * ry)
    rx, ry = rx / r, ry / r
    gn = rx * rows[i, 3 + first] + ry * rows[i, 3 + second]
    if gn <= 0.0:
        return
    inverse = inverse_mass(model.mass, model.inverse_masses, i)
    alpha = 1.0 if recent else cylinder.restitution
    turning = cylinder.angular_velocity * cylinder.radius
    n = (
        _component(rx, ry, first, second, 0),
        _component(rx, ry, first, second, 1),
        _component(rx, ry, first, second, 2),
    )
    u = (
        turning * _component(-ry, rx, first, second, 0),
        turning * _component(-ry, rx, first, second, 1),
        turning * _component(-ry, rx, first, second, 2),
    )
    law = (cylinder.tangential_restitution, cylinder.static, cylinder.sliding)
    _wall_friction(model, rough, rows, spins, i, n, u, (1.0 + alpha) * gn / inverse, law, recent)
    rows[i, 3 + first] -= (1.0 + alpha) * gn * rx
    rows[i, 3 + second] -= (1.0 + alpha) * gn * ry


@inline
def _bind(bonds: Any, i: int, j: int) -> None:
    """j is inside i's well from now on."""
    bonds[i, 0] += 1
    bonds[i, bonds[i, 0]] = j


@inline
def _unbind(bonds: Any, i: int, j: int) -> None:
    """j has left i's well."""
    for slot in range(1, bonds[i, 0] + 1):
        if bonds[i, slot] == j:
            bonds[i, slot] = bonds[i, bonds[i, 0]]
            bonds[i, 0] -= 1
            return


@inline
def at_edge(well: Well, model: HardSpheres, i: int, j: int, distance2: float) -> bool:
    """Whether a pair that has an event is at the edge of its well, not at its core; distance2: squared distance."""
    middle = 0.5 * (1.0 + well.range) * contact_distance(model.diameter, model.radii, i, j)
    return distance2 >= middle * middle


@inline
def pass_edge(
    well: Well, model: HardSpheres, rows: Floats, bonds: Any, i: int, j: int, n: Vector, gn: float
) -> tuple[float, float]:
    """The rule at the edge of a well: impulse along the normal n, and energy that binds the pair more."""
    inside = bonded(bonds, i, j)
    mass = reduced_mass(model.mass, model.inverse_masses, i, j)
    new, held = well_velocity(gn, inside, 2.0 * well.depth / mass)
    impulse = mass * (new - gn)
    apply_impulse(model, rows, i, j, (impulse * n[0], impulse * n[1], impulse * n[2]))
    if held and not inside:
        _bind(bonds, i, j)
        _bind(bonds, j, i)
    elif inside and not held:
        _unbind(bonds, i, j)
        _unbind(bonds, j, i)
    return impulse, well.depth * (np.float64(held) - np.float64(inside))


@inline
def at_plane(
    model: HardSpheres,
    walls: PlaneWalls | None,
    rows: Floats,
    spins: Any,
    i: int,
    count: int,
    face: int,
    now: float,
    recent: bool,
) -> None:
    """`hit_plane`, where there are walls."""
    if walls is not None:
        hit_plane(model, walls, model.rough, model.seed, rows, spins, i, count, face, now, recent)


@inline
def at_cylinder(
    model: HardSpheres, cylinder: CylinderWall | None, rows: Floats, spins: Any, i: int, recent: bool
) -> None:
    """`hit_cylinder`, where there is one."""
    if cylinder is not None:
        hit_cylinder(model, cylinder, model.rough, rows, spins, i, recent)


@inline
def _component(a: float, b: float, first: int, second: int, axis: int) -> float:
    """Component `axis` of the vector with a along `first` and b along `second`."""
    return a if axis == first else (b if axis == second else 0.0)
