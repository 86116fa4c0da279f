"""One impact of two soft grains, or of a grain and a wall: closed forms, and the outcome of friction.

Limit t_c -> 0 at a given restitution: the line of centres does not turn during the contact, and nothing but the contact
acts. m: the reduced mass; v > 0: the speed of approach along the normal; u: the velocity of the surfaces along each
other, Theta = |u|/v; q = I/(m_grain R^2), the same for both grains; alpha, alpha_t: normal and tangential restitution,
alpha_t = +1 smooth, -1 perfectly rough. `crosscheck.engines.soft_spheres` states the laws. In SI or any other units.

Normal, "hooke": with chi = arccos(c/2), cot chi = |ln alpha|/pi, and the phase phi = pi t/t_c in (0, pi),

    delta   = (v/omega_0) e^(-phi cot chi) sin(phi)/sin(chi),         omega_0^2 = k/m,
    delta'  = v e^(-phi cot chi) sin(chi - phi)/sin(chi),
    F_n     = m omega_0 v e^(-phi cot chi) sin(2 chi - phi)/sin(chi):

the overlap is largest at phi = chi, where it is (v/omega_0) alpha^(chi/pi), and the force attracts from phi = 2 chi
on, for alpha < 1. By then the velocity is -v alpha^(2 chi/pi), so that

    integral F_n dt = (1 + alpha) m v,      integral |F_n| dt = (1 + 2 alpha^(2 chi/pi) - alpha) m v.

"hertz": y = (4/5) delta^(5/4) and ds = delta^(1/4) dt make of it the linear oscillator y_ss + a y_s + (5/4) b y = 0
with b = k sqrt(R)/m, a = c sqrt(b), y_s = delta': "hooke" with c/sqrt 5 for c/2 (Antypov and Elliott 2011). As F_n dt
has no other factor than ds, both integrals above hold for it too.

Tangential, on "hooke", Coulomb's limit mu |F_n|: the tangential mass is m q/(1 + q). With w the tangential momentum and
T the force against it over mu m v, and ' = d/d phi, all that is left is alpha, alpha_t and x = Theta q/((1 + q) mu):

    w' = -T,    w(0) = x,    |T| <= B = |F_n| dt/(m v d phi),
    "history"   T' = nu^2 w, nu = arccos(alpha_t)/pi, or T stays on the limit if that would take it beyond,
    "dashpot"   T = lambda w, lambda = -ln(alpha_t)/pi, cut off at B.

So u'/v = mu (1 + 1/q) f(x; alpha, alpha_t), and mu and q only scale what a soft contact is off the hard rule.

* mu = infinity: u' = alpha_t u. "history" does not come to this as mu -> infinity at alpha < 1: where F_n turns
  round the limit is 0 and the stretch is lost, whatever mu. The limit is in `weak_slip_restitution`.
* Contacts slide at some time at every Theta > 0, as the limit is 0 within the contact, or, at alpha = 1, at its end;
  there is one exception, the last below.
* Sliding throughout, it is the integral of |F_n| that counts: J_t = mu integral |F_n| dt, more than mu J_n. Since the
  force against the slip keeps its sign where the grains attract, the hard rule is missed by
  2 mu (1 + 1/q) (alpha^(2 chi/pi) - alpha) at large Theta: from `gross_sliding` on, as a limit where that is infinite.
* alpha = 1 and alpha_t = -1, "history": nu = 1 and B = sin phi. If it sticks, T = x sin phi, within B throughout if
  x <= 1: u' = -u. For x > 1 it slides from the start, w = x - 1 + cos phi, and as w > B' = cos phi never sticks:
  J_t = 2 mu m v. The hard rule's limit is x = (1 + alpha)/(1 - alpha_t) = 1 too: both agree at every angle.

Literature: P. A. Cundall and O. D. L. Strack, Geotechnique 29, 47 (1979); J. Schaefer, S. Dippel and D. E. Wolf, J.
Phys. I France 6, 5 (1996); D. Antypov and J. A. Elliott, Europhys. Lett. 94, 50004 (2011); L. D. Landau and E. M.
Lifshitz, Theory of Elasticity, section 9; O. R. Walton, in Particulate Two-Phase Flow, ed. M. C. Roco (1993).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosscheck.references import EPSILON

Floats = NDArray[np.float64]

#: c = LARGEST_DAMPING[law] zeta, zeta = 1 where the contact does not end.
LARGEST_DAMPING = {"hooke": 2.0, "hertz": math.sqrt(5)}

#: Contact time of "hertz" without damping over largest overlap/v: 4 sqrt(pi) Gamma(2/5)/(5 Gamma(9/10)) = 2.943.
HERTZ_TIME = 0.8 * math.sqrt(math.pi) * math.gamma(0.4) / math.gamma(0.9)

#: Changes between sticking and sliding in a stretch of the contact in which F_n keeps its sign; five at most are seen.
MOST_CHANGES = 20


# -- normal impact -----------------------------------------------------------------------------------------------------


def damping(alpha: float, law: Literal["hooke", "hertz"] = "hooke") -> float:
    """c of a restitution: 2 |ln alpha|/sqrt(pi^2 + ln^2 alpha) of "hooke", sqrt(5) for 2 of "hertz"; 0 <= alpha <= 1.

    ValueError for other alpha.

    alpha: restitution. law: of the normal force.
    """
    if alpha == 0:
        return LARGEST_DAMPING[law]
    if not 0 < alpha <= 1:
        raise ValueError("the restitution of a soft contact is above 0, and at most 1")
    return LARGEST_DAMPING[law] * abs(math.log(alpha)) / math.hypot(math.pi, math.log(alpha))


def stiffness(alpha: float, mass: float, contact_time: float) -> float:
    """k of a contact time, (pi^2 + ln^2 alpha) m/t_c^2 with the reduced mass m, of "hooke".

    alpha: restitution, above 0. mass: m, reduced. contact_time: t_c, time. Any consistent units; gives mass/time^2.
    """
    return mass * (math.pi**2 + math.log(alpha) ** 2) / contact_time**2


def restitution(c: float, law: Literal["hooke", "hertz"] = "hooke") -> float:
    """alpha of a damping, exp(-pi zeta/sqrt(1 - zeta^2)), zeta = c/2 of "hooke", c/sqrt(5) of "hertz".

    ValueError unless 0 <= zeta <= 1: above, the contact does not end.

    c: damping, without unit. law: of the normal force.
    """
    zeta = c / LARGEST_DAMPING[law]
    if not 0 <= zeta <= 1:
        raise ValueError(f"the damping of {law} lies between 0 and {LARGEST_DAMPING[law]:.4g}")
    return 0.0 if zeta == 1 else math.exp(-math.pi * zeta / math.sqrt((1 - zeta) * (1 + zeta)))


def _chi(alpha: float) -> float:
    """arccos zeta = arccot(|ln alpha|/pi), in (0, pi/2]."""
    if not 0 < alpha <= 1:
        raise ValueError("the restitution of a soft contact is above 0, and at most 1")
    return math.atan2(math.pi, -math.log(alpha))


def force_impulse(alpha: float) -> float:
    """Integral of |F_n| dt over m v, 1 + 2 alpha^(2 chi/pi) - alpha, of "hooke" and "hertz"; 1 + alpha or more.

    ValueError unless 0 < alpha <= 1.

    alpha: restitution. Derived at the top.
    """
    return 1 + 2 * alpha ** (2 * _chi(alpha) / math.pi) - alpha


class HookeImpact(NamedTuple):
    """A contact F_n = k delta + c sqrt(m k) delta' from delta = 0 at t = 0, where delta' = v, to delta = 0.

    mass m (reduced), stiffness k (force/length), speed v, restitution alpha; times are from the first touch. ValueError
    from the properties unless 0 < alpha <= 1.
    """

    mass: float
    stiffness: float
    speed: float
    alpha: float = 1.0

    @property
    def frequency(self) -> float:
        """omega_0 = sqrt(k/m)."""
        return math.sqrt(self.stiffness / self.mass)

    @property
    def contact_time(self) -> float:
        """t_c = pi/(omega_0 sin chi) = sqrt(pi^2 + ln^2 alpha)/omega_0; grows without limit as alpha -> 0."""
        return math.pi / (self.frequency * math.sin(_chi(self.alpha)))

    @property
    def largest_overlap(self) -> float:
        """(v/omega_0) alpha^(chi/pi) = (v/omega_0) exp(-chi cot chi): v/omega_0 at alpha = 1, v/(e omega_0) at 0."""
        return self.speed / self.frequency * self.alpha ** (_chi(self.alpha) / math.pi)

    @property
    def time_of_largest_overlap(self) -> float:
        """t_c chi/pi = chi/(omega_0 sin chi): t_c/2 at alpha = 1, 1/omega_0 as alpha -> 0."""
        return self.contact_time * _chi(self.alpha) / math.pi

    @property
    def time_of_attraction(self) -> float:
        """F_n = 0 at twice the time of the largest overlap, and attracts from there to t_c."""
        return 2 * self.time_of_largest_overlap

    @property
    def first_force(self) -> float:
        """F_n at t = 0: c sqrt(m k) v."""
        return damping(self.alpha) * self.mass * self.frequency * self.speed

    @property
    def last_force(self) -> float:
        """F_n at t = t_c: -alpha c sqrt(m k) v, attractive."""
        return -self.alpha * self.first_force

    def overlap(self, time: ArrayLike) -> Floats:
        """delta(t), 0 outside the contact.

        time: t, any shape. A length.
        """
        return -self.speed / self.frequency * self._wave(time, 0)

    def velocity(self, time: ArrayLike) -> Floats:
        """delta'(t), 0 outside the contact.

        time: t, any shape. Length/time.
        """
        return self.speed * self._wave(time, 1)

    def force(self, time: ArrayLike) -> Floats:
        """F_n(t), positive where it repels, 0 outside the contact.

        time: t, any shape. Mass length/time^2.
        """
        return self.mass * self.frequency * self.speed * self._wave(time, 2)

    def _wave(self, time: ArrayLike, lead: int) -> Floats:
        """e^(-phi cot chi) sin(lead chi - phi)/sin chi, 0 outside the contact."""
        chi, times = _chi(self.alpha), np.asarray(time, dtype=np.float64)
        inside = (times >= 0) & (times <= self.contact_time)
        phase = np.where(inside, times, 0.0) * (math.pi / self.contact_time)
        return np.where(inside, np.exp(-phase / math.tan(chi)) * np.sin(lead * chi - phase) / math.sin(chi), 0.0)


class HertzImpact(NamedTuple):
    """A contact F_n = k sqrt(R delta) delta + c sqrt(m k) (R delta)^(1/4) delta', which begins with delta' = v.

    mass m (reduced), stiffness k (force/area), radius R (reduced), speed v, restitution alpha. ValueError from the
    properties unless 0 < alpha <= 1.
    """

    mass: float
    stiffness: float
    radius: float
    speed: float
    alpha: float = 1.0

    @property
    def largest_overlap(self) -> float:
        """(5 m v^2/(4 k sqrt R))^(2/5) alpha^(4 chi/(5 pi)), chi = arccos(c/sqrt 5)."""
        elastic = (1.25 * self.mass * self.speed**2 / (self.stiffness * math.sqrt(self.radius))) ** 0.4
        return elastic * self.alpha ** (0.8 * _chi(self.alpha) / math.pi)

    @property
    def contact_time(self) -> float:
        """At alpha = 1 HERTZ_TIME delta_max/v, proportional to v^(-1/5).

        t_c = integral ds/delta^(1/4) = (4/5) (delta_0/v) sin(chi)^(-4/5) integral_0^pi e^(a phi) sin^(-1/5)(phi) d phi,
        delta_0 the overlap at alpha = 1, a = |ln alpha|/(5 pi). The last integral is
        pi 2^(1/5) Gamma(4/5) e^(pi a/2)/|Gamma((9/5 + i a)/2)|^2 (Gradshteyn and Ryzhik 3.892.1).
        """
        from scipy.special import loggamma

        a = -math.log(self.alpha) / (5 * math.pi)
        size = math.exp(-2 * float(loggamma(complex(0.9, a / 2)).real))
        integral = math.pi * 2**0.2 * math.gamma(0.8) * math.exp(math.pi * a / 2) * size
        elastic = self._replace(alpha=1.0).largest_overlap
        return 0.8 * elastic / self.speed * math.sin(_chi(self.alpha)) ** -0.8 * integral


# -- the time step -----------------------------------------------------------------------------------------------------


def stability_limit(c: float) -> float:
    """Largest omega_0 dt at which velocity Verlet is stable on x'' = -omega_0^2 x - c omega_0 x'.

    The force at the new x takes the velocity of the half step: v += dt a/2; x += dt v; a(x, v); v += dt a/2. From half
    step to half step, h = omega_0 dt, (x, v/omega_0) is multiplied by ((1 - h^2, h (1 - c h)), (-h, 1 - c h)): trace
    2 - h^2 - c h, determinant 1 - c h. Both eigenvalues lie within the unit circle if h^2 + 2 c h < 4, that is
    h < sqrt(c^2 + 4) - c. ValueError if c < 0.

    c: damping, without unit. By derivation.
    """
    if c < 0:
        raise ValueError("a damping is at least 0")
    # sqrt(c^2 + 4) - c, without the difference
    return 4 / (math.hypot(c, 2) + c)


def stable_resolution(c: float) -> float:
    """The same limit as dt/t_c, omega_0 t_c = pi/sqrt(1 - c^2/4): 2/pi at c = 0.

    Of the tangential laws, "history" asks for arccos(alpha_t) dt/t_c < 2 and so for no less, "dashpot" for
    -ln(alpha_t) dt/t_c < 2. ValueError unless 0 <= c < 2.

    c: damping, without unit.
    """
    if not 0 <= c < 2:
        raise ValueError("a contact ends only with a damping of at least 0, and below 2")
    return stability_limit(c) / math.pi * math.sqrt((1 - c / 2) * (1 + c / 2))


# -- friction ----------------------------------------------------------------------------------------------------------


class SoftContact(NamedTuple):
    """Two like grains, or a grain and a wall, with friction; all without unit.

    alpha, alpha_t: normal and tangential restitution. mu: coefficient of friction (infinity: no limit). q: I/(m_grain
    R^2). friction: the law along the surfaces. Functions of it raise ValueError unless 0 < alpha <= 1, -1 <= alpha_t <=
    1 ("dashpot": above 0), mu >= 0 and q > 0.
    """

    alpha: float
    alpha_t: float
    mu: float
    q: float = 0.4
    friction: Literal["history", "dashpot"] = "history"

    @property
    def scale(self) -> float:
        """mu (1 + 1/q): Theta over x."""
        return self.mu * (1 + 1 / self.q)


class Outcome(NamedTuple):
    """slip: u'/v after the impact, in the direction of u; impulse: J_t/(m v), against u."""

    slip: Floats
    impulse: Floats


class Residual(NamedTuple):
    """size: largest |soft - hard| of u'/v, over all impact angles; theta: where, infinity if it is the limit there."""

    size: float
    theta: float


def soft_impact(theta: ArrayLike, contact: SoftContact) -> Outcome:
    """u'/v and J_t/(m v) of a soft contact, u'/v = Theta - (1 + 1/q) J_t/(m v); any shape, odd in theta.

    Sticking and sliding are solved in closed form one after the other, the times of change by root finding: exact to
    rounding. ValueError for values that `SoftContact` excludes, or a theta that is not finite.

    theta: Theta, any shape, without unit. contact: its laws. Derivation at the top.
    """
    _validate(contact)
    slips = np.asarray(theta, dtype=np.float64)
    if not np.all(np.isfinite(slips)):
        raise ValueError("theta must be finite")
    if _frictionless(contact):
        impulse = np.zeros_like(slips)
    elif math.isinf(contact.mu):
        impulse = (1 - contact.alpha_t) * slips * (contact.q / (1 + contact.q))
    else:
        scaled = (_impulse(abs(float(x)) / contact.scale, contact) for x in slips.flat)
        impulse = contact.mu * np.copysign(np.fromiter(scaled, np.float64, slips.size).reshape(slips.shape), slips)
    return Outcome(np.asarray(slips - (1 + 1 / contact.q) * impulse), np.asarray(impulse))


def hard_impact(theta: ArrayLike, contact: SoftContact) -> Outcome:
    """The rule of `granular.impact` with the same alpha, alpha_t and mu, static = kinetic.

    J_t/(m v) is that of sticking, (1 - alpha_t) Theta q/(1 + q), and mu (1 + alpha) at most. ValueError as
    `soft_impact` for the contact.

    theta: Theta, any shape, without unit. contact: its laws (Walton 1993).
    """
    _validate(contact)
    slips = np.asarray(theta, dtype=np.float64)
    sticking = (1 - contact.alpha_t) * contact.q / (1 + contact.q) * slips
    limit = contact.mu * (1 + contact.alpha)
    impulse = np.clip(sticking, -limit, limit)
    return Outcome(np.asarray(slips - (1 + 1 / contact.q) * impulse), np.asarray(impulse))


def weak_slip_restitution(contact: SoftContact) -> float:
    """u'/u of a soft contact as Theta -> 0, which is not alpha_t of "history" with alpha < 1 and any finite mu.

    The limit mu |F_n| passes 0 at phi = 2 chi and takes the stretch with it, in a time of order Theta:
    u'/u = cos(2 chi nu) cos((pi - 2 chi) nu), nu = arccos(alpha_t)/pi. "dashpot", alpha = 1 or mu = infinity: alpha_t.
    ValueError as `soft_impact`.

    contact: its laws.
    """
    _validate(contact)
    if contact.mu == 0:
        return 1.0
    if contact.friction == "dashpot" or math.isinf(contact.mu):
        return contact.alpha_t
    turn, nu = 2 * _chi(contact.alpha), math.acos(contact.alpha_t) / math.pi
    return math.cos(turn * nu) * math.cos((math.pi - turn) * nu)


def sliding_onset(contact: SoftContact) -> float:
    """Smallest Theta above which the contact slides at some time: 0, for the limit is 0 at some time while T is not.

    But mu (1 + 1/q) of "history" with alpha = 1 and alpha_t = -1, where both end at once, and infinity if nothing
    limits the force (mu = infinity) or there is none (alpha_t = 1). ValueError as `soft_impact`.

    contact: its laws.
    """
    _validate(contact)
    if math.isinf(contact.mu) or contact.alpha_t == 1:
        return math.inf
    together = contact.friction == "history" and contact.alpha == 1 and contact.alpha_t == -1
    return contact.scale if together else 0.0


def gross_sliding(contact: SoftContact) -> float:
    """Theta from which the contact slides throughout, and J_t = mu `force_impulse` m v.

    "history": mu (1 + 1/q)/nu^2 at alpha = 1, from w >= B'/nu^2. Infinity at alpha < 1: F_n begins with a jump, and the
    contact sticks until the stretch has reached the limit; J_t falls short by 2 (mu cot(chi)/nu)^2 (1 + 1/q) m v/Theta
    at large Theta.
    "dashpot": mu (1 + 1/q) times the largest B/lambda + integral B d phi, which is at the beginning, at the end, or
    where B' + lambda B = 0: cot(2 chi - phi) = lambda - cot chi. At alpha = 1 it is 1 + sqrt(1 + 1/lambda^2).
    Infinity for mu = infinity and alpha_t = 1; 0 for mu = 0. ValueError as `soft_impact`.

    contact: its laws.
    """
    _validate(contact)
    if contact.mu == 0:
        return 0.0
    if math.isinf(contact.mu) or contact.alpha_t == 1:
        return math.inf
    if contact.friction == "history":
        return contact.scale * (math.pi / math.acos(contact.alpha_t)) ** 2 if contact.alpha == 1 else math.inf
    chi, rate = _chi(contact.alpha), -math.log(contact.alpha_t) / math.pi
    stationary = 2 * chi - math.atan2(1.0, rate - 1 / math.tan(chi))
    needs = []
    for load in _stages(chi):
        phases = [load.start, load.end]
        phases += [phi for phi in (stationary, stationary + math.pi) if load.start < phi < load.end]
        needs += [float(load.limit(phi) / rate + load.impulse(phi)) for phi in phases]
    return contact.scale * max(needs)


def residual(contact: SoftContact, angles: int = 200) -> Residual:
    """Largest |u'/v of the soft contact - u'/v of the hard rule| over all impact angles, and its Theta.

    From `angles` values of arctan(Theta/Theta_0), half of them up to the hard rule's limit of sticking, Theta_0, and
    half from there to `gross_sliding`, the three highest peaks refined. At `gross_sliding` and above it is
    2 mu (1 + 1/q) (alpha^(2 chi/pi) - alpha). All is mu (1 + 1/q) times a function of alpha and alpha_t. ValueError
    as `soft_impact`.

    contact: its laws. angles: how many.
    """
    from scipy.optimize import minimize_scalar

    _validate(contact)
    if _frictionless(contact) or math.isinf(contact.mu):
        return Residual(0.0, 0.0)
    corner = (1 + contact.alpha) / (1 - contact.alpha_t)
    gross = gross_sliding(contact) / contact.scale

    def apart(angle: float) -> float:
        x = corner * math.tan(angle)
        return abs(_impulse(x, contact) - min((1 - contact.alpha_t) * x, 1 + contact.alpha))

    # a contact that slides throughout is beyond the hard rule's corner: u' >= alpha_t u, and J_t >= mu J_n
    last = math.atan(gross / corner)
    parts = [np.linspace(low, high, angles // 2 + 1) for low, high in ((0, math.pi / 4), (math.pi / 4, last))]
    grid = np.concatenate((parts[0], parts[1][1:]))
    sizes = np.array([0.0, *(apart(float(angle)) for angle in grid[1:-1]), force_impulse(contact.alpha)])
    sizes[-1] -= 1 + contact.alpha
    best = Residual(float(sizes[-1]), gross)
    peaks = [k for k in range(1, grid.size - 1) if sizes[k] >= max(sizes[k - 1], sizes[k + 1])]
    for k in sorted(peaks, key=lambda k: -sizes[k])[:3]:
        found = [Residual(float(sizes[k]), corner * math.tan(grid[k]))]
        # one side at a time: at the corner of the hard rule the peak is a cusp
        for bounds in ((grid[k - 1], grid[k]), (grid[k], grid[k + 1])):
            side = minimize_scalar(lambda a: -apart(a), bounds=bounds, method="bounded", options={"xatol": 1e-9})
            found.append(Residual(-float(side.fun), corner * math.tan(float(side.x))))
        best = max(best, *found)
    return Residual(contact.scale * best.size, contact.scale * best.theta)


def _validate(contact: SoftContact) -> None:
    _chi(contact.alpha)
    if not -1 <= contact.alpha_t <= 1:
        raise ValueError("a tangential restitution lies between -1 and 1")
    if contact.friction == "dashpot" and contact.alpha_t <= 0:
        raise ValueError("a dashpot never turns the slip round: its tangential restitution is above 0")
    if not (contact.mu >= 0 and contact.q > 0):
        raise ValueError("mu is at least 0, and q above 0")


def _frictionless(contact: SoftContact) -> bool:
    return contact.mu == 0 or contact.alpha_t == 1


# -- sticking and sliding, in the units of the module's docstring ------------------------------------------------------


class _Stage(NamedTuple):
    """A stretch of the contact in which F_n keeps its sign: the limit B and its integral from phi = 0."""

    chi: float
    sign: float
    start: float
    end: float

    def limit(self, phi: ArrayLike, order: int = 0) -> Floats:
        """B, or its derivative of order 1 or 2: each adds chi to the phase, and the factor -1/sin chi."""
        phase = np.asarray(phi, dtype=np.float64)
        wave = np.exp(-phase / math.tan(self.chi)) * np.sin((2 + order) * self.chi - phase)
        return self.sign * (-1) ** order * wave / math.sin(self.chi) ** (2 + order)

    def impulse(self, phi: ArrayLike) -> Floats:
        """Integral of B from 0 to phi."""
        phase = np.asarray(phi, dtype=np.float64)
        velocity = np.exp(-phase / math.tan(self.chi)) * np.sin(self.chi - phase) / math.sin(self.chi)
        turned = 2 * math.exp(-2 * self.chi / math.tan(self.chi))
        return 1 - velocity if self.sign > 0 else 1 + turned + velocity


def _stages(chi: float) -> tuple[_Stage, ...]:
    if 2 * chi >= math.pi:
        return (_Stage(chi, 1.0, 0.0, math.pi),)
    return _Stage(chi, 1.0, 0.0, 2 * chi), _Stage(chi, -1.0, 2 * chi, math.pi)


class _State(NamedTuple):
    """phi, tangential momentum w, force against it T."""

    phi: float
    w: float
    force: float


#: Of phi, a quantity that is 0 where the motion changes its kind, and its derivative.
Event = Callable[[ArrayLike], tuple[Floats, Floats]]


class _History(NamedTuple):
    """T' = nu^2 w on |T| <= B."""

    nu: float

    def slides(self, state: _State, load: _Stage) -> bool:
        """Whether T, on the limit, would leave it."""
        drive = self.nu**2 * state.w * _side(state)
        return bool(abs(state.force) >= load.limit(state.phi) and drive > load.limit(state.phi, 1))

    def begin(self, state: _State, load: _Stage) -> _State:
        return state if load.start == 0 else state._replace(force=0.0)

    def sticking(self, state: _State, load: _Stage) -> tuple[Callable[[float], _State], Event]:
        nu, w, force = self.nu, state.w, state.force

        def swing(phi: ArrayLike) -> tuple[Floats, Floats]:
            turn = nu * (np.asarray(phi, dtype=np.float64) - state.phi)
            return w * np.cos(turn) - force / nu * np.sin(turn), force * np.cos(turn) + nu * w * np.sin(turn)

        def at(phi: float) -> _State:
            return _State(phi, *(float(value) for value in swing(phi)))

        def slack(phi: ArrayLike) -> tuple[Floats, Floats]:
            momentum, pull = swing(phi)
            return load.limit(phi) - abs(pull), load.limit(phi, 1) - np.sign(pull) * nu**2 * momentum

        return at, slack

    def sliding(self, state: _State, load: _Stage) -> tuple[Callable[[float], _State], Event]:
        side, square = _side(state), self.nu**2

        def momentum(phi: ArrayLike) -> Floats:
            return state.w - side * (load.impulse(phi) - load.impulse(state.phi))

        def at(phi: float) -> _State:
            return _State(phi, float(momentum(phi)), side * float(load.limit(phi)))

        def excess(phi: ArrayLike) -> tuple[Floats, Floats]:
            drive = square * side * momentum(phi) - load.limit(phi, 1)
            return drive, -square * load.limit(phi) - load.limit(phi, 2)

        return at, excess


class _Dashpot(NamedTuple):
    """T = lambda w, B at most; w never changes sign."""

    rate: float

    def slides(self, state: _State, load: _Stage) -> bool:
        return bool(self.rate * state.w > load.limit(state.phi))

    def begin(self, state: _State, load: _Stage) -> _State:
        return state

    def sticking(self, state: _State, load: _Stage) -> tuple[Callable[[float], _State], Event]:
        def force(phi: ArrayLike) -> Floats:
            return self.rate * state.w * np.exp(-self.rate * (np.asarray(phi, dtype=np.float64) - state.phi))

        def at(phi: float) -> _State:
            pull = float(force(phi))
            return _State(phi, pull / self.rate, pull)

        def slack(phi: ArrayLike) -> tuple[Floats, Floats]:
            return load.limit(phi) - force(phi), load.limit(phi, 1) + self.rate * force(phi)

        return at, slack

    def sliding(self, state: _State, load: _Stage) -> tuple[Callable[[float], _State], Event]:
        def momentum(phi: ArrayLike) -> Floats:
            return state.w - (load.impulse(phi) - load.impulse(state.phi))

        def at(phi: float) -> _State:
            return _State(phi, float(momentum(phi)), float(load.limit(phi)))

        def excess(phi: ArrayLike) -> tuple[Floats, Floats]:
            slope = -self.rate * load.limit(phi) - load.limit(phi, 1)
            return self.rate * momentum(phi) - load.limit(phi), slope

        return at, excess


def _side(state: _State) -> float:
    return math.copysign(1.0, state.force if state.force != 0 else state.w)


def _impulse(x: float, contact: SoftContact) -> float:
    """J_t/(mu m v) of x >= 0. RuntimeError if the motion changes its kind without end."""
    chi = _chi(contact.alpha)
    law: _History | _Dashpot
    if contact.friction == "history":
        law = _History(math.acos(contact.alpha_t) / math.pi)
    else:
        law = _Dashpot(-math.log(contact.alpha_t) / math.pi)
    # of the terms whose difference is an event: w starts at x, and B at 2 cot chi, or reaches 1 if that is less
    rounding = 16 * EPSILON * (1 + x + 2 / math.tan(chi))
    state = _State(0.0, x, 0.0)
    for load in _stages(chi):
        state = law.begin(state, load)
        slides = law.slides(state, load)
        for _ in range(MOST_CHANGES):
            motion, event = law.sliding(state, load) if slides else law.sticking(state, load)
            state = motion(_first_negative(event, state.phi, load.end, rounding))
            if state.phi == load.end:
                break
            slides = not slides
        else:
            raise RuntimeError(f"sticking and sliding change more than {MOST_CHANGES} times")
    return x - state.w


def _first_negative(event: Event, start: float, end: float, rounding: float) -> float:
    """First phi at which the event's quantity becomes negative, `end` if none; it may be 0, to rounding, at `start`."""
    from scipy.optimize import brentq

    def value(phi: float) -> float:
        return float(event(phi)[0])

    def slope(phi: float) -> float:
        return float(event(phi)[1])

    # dense at the start, where a quantity that begins at 0 may come back soon
    grid = start + (end - start) * np.linspace(0, 1, 97) ** 3
    grid[-1] = end
    values, slopes = event(grid)
    for k in range(1, grid.size):
        low, high = float(grid[k - 1]), float(grid[k])
        if values[k] >= -rounding:
            # a dip between two points of the grid, unless twice the slope at the first does not lead below 0
            if not slopes[k - 1] < 0 < slopes[k] or values[k - 1] + 2 * slopes[k - 1] * (high - low) > 0:
                continue
            high = brentq(slope, low, high, xtol=1e-15, rtol=4 * EPSILON)
            if value(high) >= -rounding:
                continue
        if value(low) <= 0:
            return low
        return float(brentq(value, low, high, xtol=1e-15, rtol=4 * EPSILON))
    return end
