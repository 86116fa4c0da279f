"""What a time step does to a soft contact: the contact as velocity Verlet takes it, and bounds on its errors.

The contact is that of `soft_impact`, "hooke" unless said otherwise, and h = omega_0 dt. Its errors are of order 1 in
dt/t_c, in three ways. A contact begins and ends between two steps: a sum over steps misses up to half a step's share of
a force that jumps, as the dashpot's does, which is c h/2 of the velocity at either end. Without a dashpot the energy of
a contact is off by h^2/4 at most. Inside, velocity Verlet takes the dashpot at the velocity half a step before, but
solves its difference equation exactly: see `SteppedContact`. And a tangential spring is stretched from the step before
the first that finds an overlap. dt/t_c is called the resolution.

All bounds are to leading order in h, for contacts of many steps: 20 or more; tests compare them with contacts that are
stepped one by one.

Literature: J. Schaefer, S. Dippel and D. E. Wolf, J. Phys. I France 6, 5 (1996); L. E. Silbert et al., Phys. Rev. E 64,
051302 (2001).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosscheck.references.soft_impact import (
    HertzImpact,
    HookeImpact,
    SoftContact,
    damping,
    force_impulse,
    stability_limit,
    stiffness,
)

Floats = NDArray[np.float64]


# -- normal impact -----------------------------------------------------------------------------------------------------


class SteppedContact(NamedTuple):
    """The contact x'' = -omega_0^2 x - c omega_0 x' as velocity Verlet takes it, without its beginning and its end.

    damping: c, from 0 to below 2. step: h = omega_0 dt. From half step to half step (x, v) is multiplied by a matrix of
    trace 2 - h^2 - c h and determinant 1 - c h (`soft_impact.stability_limit`): each step turns by `angle` and shrinks
    by sqrt(1 - c h), so a half turn takes pi/angle steps. ValueError from the properties if it does not swing.
    """

    damping: float
    step: float

    @property
    def angle(self) -> float:
        """Turn of one step, in radians: h as h -> 0 at c = 0."""
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
    """Relative errors by the time step, or bounds on them.

    restitution: of alpha. time: of the contact time, a mean. overlap: of the largest overlap.
    """

    restitution: float
    time: float
    overlap: float


def hooke_bounds(alpha: float, resolution: float) -> Errors:
    """Bounds for a contact in steps of dt/t_c = `resolution`: stepped against the closed form, and its ends.

    The time is bounded without the counting of whole steps. The largest overlap is missed by the half step to the
    nearest sample, h^2/8 of it, and leads the amplitude of the steps by as much. alpha: restitution, above 0, else
    ValueError. resolution: without unit.
    """
    exact = HookeImpact(1.0, 1.0, 1.0, alpha)
    stepped = SteppedContact(damping(alpha), resolution * exact.contact_time)
    alike = HookeImpact(1.0, stiffness(stepped.restitution, 1.0, stepped.duration), 1.0, stepped.restitution)
    return Errors(
        abs(math.log(stepped.restitution / alpha)) + stepped.ends,
        abs(stepped.duration / exact.contact_time - 1) + stepped.ends * resolution,
        abs(math.log(alike.largest_overlap / exact.largest_overlap)) + stepped.ends,
    )


def impact_bounds(impact: HookeImpact | HertzImpact, dt: float) -> Errors:
    """`hooke_bounds` of this impact in steps of dt (a time).

    Of "hertz": those of the linear contact that it is equivalent to, as stiff as at the largest overlap. There
    omega^2 = (5/4) k sqrt(R delta)/m (`soft_impact`), and less than that elsewhere. The time goes as the amplitude to
    the power -1/5, which in the end is off as much as restitution is.

    impact: in any consistent units.
    """
    if isinstance(impact, HookeImpact):
        return hooke_bounds(impact.alpha, dt / impact.contact_time)
    depth = impact._replace(alpha=1.0).largest_overlap
    frequency = math.sqrt(1.25 * impact.stiffness * math.sqrt(impact.radius * depth) / impact.mass)
    bounds = hooke_bounds(impact.alpha, dt * frequency / HookeImpact(1.0, 1.0, 1.0, impact.alpha).contact_time)
    return bounds._replace(time=bounds.time + bounds.restitution / 5)


def elastic_energy_bound(resolution: ArrayLike) -> Floats:
    """Largest change of the energy of an elastic contact by its steps, h^2/4 of that of the relative motion.

    It is h^2 (B_2(s) - B_2(s')) with Bernoulli's polynomial B_2(s) = s^2 - s + 1/6, between -1/12 and 1/6, and s, s'
    the phases of the step at which the contact begins and ends. resolution: dt/t_c, h = pi dt/t_c; any shape.
    """
    return np.asarray((math.pi * np.asarray(resolution, dtype=np.float64)) ** 2 / 4)


def growth_delay(c: float, growth: float, steps: int) -> float:
    """How far above the stability limit, relatively, a step must be for the amplitude to grow by `growth` in `steps`.

    Above it an eigenvalue is -(1 + d), d^2 + c h d = 2 h (h + c) epsilon at h (1 + epsilon), h the limit, to leading
    order in epsilon and d. The amplitude begins with a quarter of the speed or more. An upper bound: at c = 0, a double
    eigenvalue, the amplitude grows with the number of steps by itself. c: `damping` of the contact, at least 0.

    growth: a factor above 1. steps: their number.
    """
    rate = math.log(4 * growth) / steps
    h = stability_limit(c)
    return rate * (rate + c * h) / (2 * h * (h + c))


# -- friction ----------------------------------------------------------------------------------------------------------


def friction_bounds(thetas: ArrayLike, contact: SoftContact, resolution: float) -> Floats:
    """Bounds on errors of u'/v by the time step, in the units of `soft_impact`, w' = -T, |T| <= B, phi = pi t/t_c.

    The contact acts for at most 3/2 steps more or less than t_c, besides what the stepped contact is longer: a phase
    `shift`. It costs shift times the largest B; a stretch that is off by shift times u has T off by nu^2 x shift for
    the rest of the contact, and a dashpot at a velocity half a step old by lambda^2 x times half a step. B itself is
    off by as much as restitution is, relatively. thetas: |u|/v, any shape; contact: mu finite; resolution: dt/t_c.
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


def hard_rule_bounds(thetas: ArrayLike, contact: SoftContact, resolution: float) -> Floats:
    """Bounds on errors of u'/v by the time step, 2 h^2 (Theta + mu (1 + 1/q)), where the contact is the hard rule.

    That is "history" with alpha = 1 and alpha_t = -1 (`soft_impact`): order 2, for without a dashpot no force jumps,
    and a half turn of the tangential spring ends with the contact. thetas: |u|/v, any shape; resolution: dt/t_c.

    contact: mu finite.
    """
    step = math.pi * resolution
    return np.asarray(2 * step**2 * (np.asarray(thetas, dtype=np.float64) + contact.scale))


def sticking_bound(contact: SoftContact, resolution: float) -> float:
    """Bound on the error of u'/u of a contact that sticks (mu = infinity), by the time step dt/t_c = `resolution`.

    A tangential spring is the leapfrog's oscillator: after N steps u' = u cos((N + 1/2) theta)/cos(theta/2),
    theta = arccos(alpha_t) dt/t_c to second order, and N steps last as long as the stepped contact but for one. A
    dashpot leaves u (1 + ln(alpha_t) dt/t_c)^N.

    contact: mu infinite.
    """
    exact = HookeImpact(1.0, 1.0, 1.0, contact.alpha)
    stepped = SteppedContact(damping(contact.alpha), resolution * exact.contact_time)
    off = abs(stepped.duration / exact.contact_time - 1)
    if contact.friction == "history":
        turn = math.acos(contact.alpha_t)
        return turn * (off + 1.5 * resolution) + (turn * resolution) ** 2
    decay = -math.log(contact.alpha_t)
    return contact.alpha_t * math.expm1(decay * (off + resolution) + decay**2 * resolution)
