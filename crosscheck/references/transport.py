"""Transport in gases of hard disks and spheres: Enskog's theory, self-diffusion of few spheres, friction of a tracer.

k_B = 1; the diameter sigma, the mass m and the temperature T (an energy) are 1 where no argument says otherwise;
dimension, d, is 2 or 3; density, n, particles per length^d; eta the packing fraction; number, N, of particles; g the
pair distribution function at contact.

Literature: S. Chapman and T. G. Cowling, The Mathematical Theory of Non-uniform Gases, 3rd ed. (1970); I.-C. Yeh and G.
Hummer, J. Phys. Chem. B 108, 15873 (2004); NIST Standard Reference Simulation Website, hard-sphere page.
"""

from __future__ import annotations

from math import inf

import numpy as np

from crosscheck.references.hard_spheres import (
    NIST_PARTICLES,
    Estimate,
    contact_value,
    demand_dimension,
    number_density,
    packing_fraction,
)


def friction(
    density: float,
    distance: float,
    mass: float,
    tracer_mass: float,
    dimension: int,
    temperature: float = 1.0,
    contact: float = 1.0,
) -> float:
    """Rate gamma of the initial decay of a tracer's velocity autocorrelation in a bath of density n and mass m.

    gamma M = 4 (S_d/d) n s^(d-1) g mu <u_+>, with S_d = 2 pi, 4 pi, <u_+> = sqrt(T/2 pi mu), mu the reduced mass, s the
    distance of the centres at contact, g the bath's density there over n: 2 n s g sqrt(2 pi mu T) for disks, (8/3) n
    s^2 g sqrt(2 pi mu T) for spheres. For M >> m the whole decay is exp(-gamma t) in Enskog's theory; in a dense bath
    recollisions and the backflow (Stokes) lower gamma.

    density: n, 1/length^d. distance: s, length. mass: m, tracer_mass: M. dimension: d, 2 or 3, else ValueError.
    temperature: T, energy. contact: g. Any consistent units; gives 1/time.
    """
    demand_dimension(dimension)
    mu = mass * tracer_mass / (mass + tracer_mass)
    factor = 2.0 if dimension == 2 else 8 / 3
    force = factor * density * distance ** (dimension - 1) * contact * (2 * np.pi * mu * temperature) ** 0.5
    return float(force / tracer_mass)


#: D of the Boltzmann equation over its first Sonine approximation: exact to the digits given. Spheres: 1.01896 in the
#: literature; both from the twelfth approximation with exact integrals, which the tests repeat.
SONINE_DIFFUSION = {2: 1.027094, 3: 1.018954}


def enskog_diffusion(
    eta: float, dimension: int, temperature: float = 1.0, mass: float = 1.0, diameter: float = 1.0, sonine: bool = True
) -> Estimate:
    """Self-diffusion in Enskog's theory, T/(m zeta) with zeta of `friction` for equal masses, times the Sonine factor.

    First approximation: sqrt(T/pi m)/(2 n sigma g) of disks, 3 sqrt(T/pi m)/(8 n sigma^2 g) of spheres. The doubt
    is that of g, not of the theory: an infinite system of spheres diffuses 37 % faster than D_E at n = 0.5 and 17 %
    slower at n = 0.9; in two dimensions D grows without bound with the box (long-time tails) and the dilute limit only
    is sharp.

    eta: packing fraction. dimension: 2 or 3. temperature: T, energy. mass: m. diameter: sigma, length. sonine: whether
    to multiply by the Sonine factor. Any consistent units; gives length^2/time. ValueError as `compressibility`.
    """
    n, g = number_density(eta, dimension, diameter), contact_value(eta, dimension)
    heavy = friction(n, diameter, mass, mass, dimension, temperature, g.value)
    value = temperature / (mass * heavy) * (SONINE_DIFFUSION[dimension] if sonine else 1.0)
    return Estimate(value, doubt=value * g.doubt / g.value)


def enskog_viscosity(eta: float, temperature: float = 1.0, mass: float = 1.0, diameter: float = 1.0) -> float:
    """Shear viscosity of spheres in Enskog's theory, first approximation times 1.016 (Chapman and Cowling).

    (5/16 sigma^2) sqrt(m T/pi) b (1/(b g) + 4/5 + 0.7614 b g), b = 4 eta; within some 5 % for n <= 0.7.

    eta: packing fraction, above 0. temperature: T, energy. mass: m. diameter: sigma, length. Any consistent units;
    gives mass/(length time). ValueError as `sphere_compressibility`.
    """
    b = 4 * eta
    bg = b * contact_value(eta, 3).value
    dilute = 1.016 * 5 / 16 / diameter**2 * (mass * temperature / np.pi) ** 0.5
    return float(dilute * b * (1 / bg + 0.8 + 0.7614 * bg))


#: Number density, D/(sigma sqrt(T/m)) and its quoted error: molecular dynamics, NIST Standard Reference Simulation
#: Website, with `NIST_PARTICLES` spheres.
NIST_DIFFUSION = (
    (0.1, 1.934599, 33e-4),
    (0.3, 0.541249, 7e-4),
    (0.5, 0.253873, 3e-4),
    (0.7, 0.114739, 2e-4),
    (0.9, 0.034327, 9e-5),
)


def periodic_diffusion_shift(density: float, number: float) -> float:
    """By how much D of spheres in a periodic cube is below that without bounds: 2.837297 T/(6 pi viscosity L).

    Yeh and Hummer; the box must be long against the mean free path. T = m = sigma = 1, viscosity from Enskog's theory.

    density: n, 1/length^3. number: N; infinity gives 0.
    """
    if number == inf:
        return 0.0
    viscosity = enskog_viscosity(packing_fraction(density, 3))
    return float(2.837297 / (6 * np.pi * viscosity * (number / density) ** (1 / 3)))


def sphere_diffusion(density: float, number: float = inf) -> Estimate:
    """D/(sigma sqrt(T/m)) of N spheres in a periodic cube, 0.1 <= n <= 0.9; number may be infinite.

    NIST's D, taken to infinite N with `periodic_diffusion_shift` and back to N; between its densities D/D_E is
    interpolated (monotone cubic). Own event-driven runs gave 0.4982(15), 0.2206(5), 0.1000(5) for N = 108 at n = 0.3,
    0.5, 0.7, against 0.490, 0.222, 0.098. The uncertainty is the quoted error; the doubt 20 % of the difference of the
    shifts (Enskog's viscosity, higher orders in 1/L: 16 % found at n = 0.3) and, off the table's densities, 1 % of D.
    ValueError outside the densities.

    density: n, 1/length^3 in diameters. number: N, of spheres.
    """
    from scipy.interpolate import PchipInterpolator

    n, d, error = np.array(NIST_DIFFUSION).T
    if not n[0] <= density <= n[-1]:
        raise ValueError(f"diffusion is tabulated for number densities from {n[0]} to {n[-1]}, got {density}")

    def enskog(x: float) -> float:
        return enskog_diffusion(packing_fraction(x, 3), 3).value

    infinite = np.array([y + periodic_diffusion_shift(x, NIST_PARTICLES) for x, y in zip(n, d, strict=True)])
    ratio = PchipInterpolator(n, infinite / np.array([enskog(x) for x in n]))
    shift = periodic_diffusion_shift(density, number)
    value = float(ratio(density)) * enskog(density)
    doubt = 0.2 * abs(shift - periodic_diffusion_shift(density, NIST_PARTICLES))
    between = 0.0 if np.isclose(n, density, rtol=0, atol=1e-9).any() else 0.01 * value
    return Estimate(value - shift, float(np.interp(density, n, error)), doubt + between)


def velocity_decay_time(density: float) -> float:
    """Decay time of a sphere's velocity autocorrelation, m D/T in Enskog's theory, T = m = sigma = 1.

    density: n, 1/length^3 in diameters.
    """
    return enskog_diffusion(packing_fraction(density, 3), 3).value


def shear_decay_time(density: float, number: int) -> float:
    """Decay time L^2/(4 pi^2 nu) of the longest shear wave of N spheres in a periodic cube, T = m = sigma = 1.

    The kinematic viscosity nu is Enskog's viscosity over the mass density.

    density: n, 1/length^3 in diameters. number: N.
    """
    eta = packing_fraction(density, 3)
    return float((number / density) ** (2 / 3) / (4 * np.pi**2 * enskog_viscosity(eta) / density))


def slip_friction(viscosity: float, radius: float) -> float:
    """Force over velocity of a sphere on whose surface the fluid slips: 4 pi viscosity R (Hansen and McDonald).

    viscosity: mass/(length time). radius: R, length. Gives mass/time.
    """
    return float(4 * np.pi * viscosity * radius)


def friction_in_series(gamma: float, tracer_mass: float, slip: float) -> float:
    """Decay rate zeta/M of a tracer whose bath flows along: 1/zeta = 1/(gamma M) + 1/slip, an estimate.

    gamma: Enskog's rate, `friction`, 1/time; tracer_mass: M; slip: `slip_friction` for the distance at contact as the
    radius, mass/time.
    """
    return gamma / (1 + gamma * tracer_mass / slip)
