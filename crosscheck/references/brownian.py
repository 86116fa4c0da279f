"""Brownian motion: the velocity autocorrelation of heavy particles in a bath of light ones.

k_B = 1; temperature, T, an energy; M the tracer's mass, m that of a particle of the bath; gamma a rate.

Literature: G. E. Uhlenbeck and L. S. Ornstein, Phys. Rev. 36, 823 (1930); J.-P. Hansen and I. R. McDonald, Theory of
Simple Liquids; S. Chapman and T. G. Cowling, The Mathematical Theory of Non-uniform Gases, 3rd ed. (1970).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crosscheck.references.hard_mixtures import mixture, mixture_contact_values
from crosscheck.references.transport import friction

Floats = NDArray[np.float64]


def brownian_autocorrelation(time: ArrayLike, gamma: float, temperature: float, tracer_mass: float) -> Floats:
    """<v_x(0) v_x(t)> = (T/M) exp(-gamma t), Ornstein and Uhlenbeck; M >> m. D = T/(M gamma).

    time: t, any shape. gamma: decay rate, 1/time. temperature: T, energy. tracer_mass: M. Any consistent units; gives a
    velocity squared, of the shape of time.
    """
    return np.asarray(temperature / tracer_mass * np.exp(-gamma * np.asarray(time, dtype=np.float64)))


class Tracers(NamedTuple):
    """Enskog's theory of several tracers in a finite bath, total momentum zero; T = 1.

    gamma: decay rate with the bath, and between: with the other tracers, 1/time. share: of the tracers in the total
    mass. number: of tracers. mass: of one of them, M, in masses of a particle of the bath. doubt: relative uncertainty
    of the initial decay, from g at contact.
    """

    gamma: float
    between: float
    share: float
    number: int
    mass: float
    doubt: float

    @property
    def variance(self) -> float:
        """C(0) = <v_x^2> = (T/M)(1 - M/M_total): the total momentum is zero."""
        return (1 - self.share / self.number) / self.mass

    def autocorrelation(self, time: Floats) -> Floats:
        """C(t) = <v_x(0) v_x(t)> by modes, a velocity squared of the shape of time.

        The tracers' common velocity drags the bath along, its differences do not. Momentum spreads over the box at
        once; the common mode decays with gamma M_total/(bath's mass). time: t, any shape, in the units of 1/gamma.
        """
        bath = 1 - self.share
        apart = (self.number - 1) / self.number * np.exp(-(self.gamma + self.between) * time)
        return np.asarray((apart + bath / self.number * np.exp(-self.gamma * time / bath)) / self.mass)


def tracers_in_bath(density: float, particles: int, tracers: int, size: float, mass: float, dimension: int) -> Tracers:
    """Tracers of diameter `size` and mass `mass` among `particles` of diameter and mass 1, of number density `density`.

    gamma is `transport.friction` with g of the mixture at contact; `between` the same among tracers. The doubt is 1 %
    of g - 1 with the bath, and 5 % of g among tracers.

    density: of the particles of the bath, per length^d in their diameters. particles, tracers: numbers. size: in
    diameters, mass: in masses of a particle of the bath. dimension: 2 or 3, else ValueError. From Chapman and Cowling's
    theory.
    """
    tracer_density = density * tracers / particles
    species = mixture([density, tracer_density], [1.0, size], [1.0, mass])
    g = mixture_contact_values(species, dimension)
    gamma = friction(density, (1 + size) / 2, 1.0, mass, dimension, contact=float(g[0, 1]))
    # every tracer relaxes to the mean velocity of all of them, itself included: the density is that of all
    between = friction(tracer_density, size, mass, mass, dimension, contact=float(g[1, 1]))
    share = tracers * mass / (tracers * mass + particles)
    return Tracers(gamma, between, share, tracers, mass, 0.01 * (float(g[0, 1]) - 1) + 0.05 * between / gamma)


def returned_share(rate: float, time: float) -> float:
    """Share of the initial decay that particles of the bath give back within a short time; an estimate.

    rate: collisions of one particle of the bath with others of it, per time. Of those that have met the tracer, rate
    time/2 have met another since, on average; about a third of those come back to it, with half the momentum.

    time: in the units of 1/rate; short, rate time well below 1.
    """
    return rate * time / 12
