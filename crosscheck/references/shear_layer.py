"""Kelvin-Helmholtz instability of a viscous shear flow that spreads while the disturbance grows.

Linearised vorticity equation of an incompressible flow U(y, t) along x, periodic in y, advected with the factor g:

    d zeta/dt = -i k g U zeta + i k g U'' phi + nu (d^2/dy^2 - k^2) zeta,   (d^2/dy^2 - k^2) phi = zeta,

v = i k phi the velocity along y, and dU/dt = nu U''. Literature: P. G. Drazin and W. H. Reid, Hydrodynamic Stability,
Cambridge (1981), secs. 21 and 25; A. Michalke, J. Fluid Mech. 19, 543 (1964) (tanh profile: the inviscid rate is at
most 0.1897 U/delta, at k delta = 0.4446).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray


def largest_growth(speed: float, width: float) -> float:
    """Growth rate of the fastest wave on one tanh layer without viscosity, 0.1897 U/delta; speed: U, width: delta."""
    return 0.1897 * speed / width


def double_layer(y: ArrayLike, period: float, speed: float, width: float) -> NDArray[np.float64]:
    """speed (tanh((y - L/4)/width) - tanh((y - 3 L/4)/width) - 1): two layers in a period L, (points,).

    y: places (points,); period: L; width: delta, all in one unit of length. speed: U far from the layers.
    """
    place = np.asarray(y, dtype=np.float64)
    return speed * (np.tanh((place - period / 4) / width) - np.tanh((place - 3 * period / 4) / width) - 1)


def disturbance(
    flow: ArrayLike,
    spacing: float,
    wavenumber: float,
    viscosity: float,
    advection: float,
    start: complex,
    times: ArrayLike,
) -> NDArray[np.complex128]:
    """v(y) at the times given, (times, points), of a disturbance whose v is `start` everywhere at time 0.

    flow: U (points,) at points `spacing` apart, one period. wavenumber: k along x. viscosity: nu. advection: g. start:
    velocity; |v| well below U, or the equation is not linear. times: (times,), not decreasing, from 0 on. Spectral in
    y, fourth-order Runge-Kutta in time, with steps a quarter of the stability limit.
    """
    u = np.asarray(flow, dtype=np.float64)
    q = 2 * math.pi * np.fft.fftfreq(u.size, spacing)
    spectrum, laplacian = np.fft.fft(u), -(q**2) - wavenumber**2
    step = 0.25 * min(2.8 / (viscosity * -laplacian.min()), 2.8 / (wavenumber * abs(advection) * np.abs(u).max()))

    def rate(zeta: NDArray[np.complex128], t: float) -> NDArray[np.complex128]:
        spread = spectrum * np.exp(-viscosity * q**2 * t)
        profile, curvature = np.fft.ifft(spread).real, np.fft.ifft(-(q**2) * spread).real
        turning = 1j * wavenumber * advection
        transfer = np.fft.fft(
            -turning * profile * np.fft.ifft(zeta) + turning * curvature * np.fft.ifft(zeta / laplacian)
        )
        return np.asarray(transfer + viscosity * laplacian * zeta)

    zeta = np.fft.fft(np.full(u.size, 1j * wavenumber * start))
    now, found = 0.0, []
    for time in np.asarray(times, dtype=np.float64).tolist():
        number = max(1, math.ceil((time - now) / step))
        h = (time - now) / number
        for _ in range(number):
            a = rate(zeta, now)
            b = rate(zeta + h / 2 * a, now + h / 2)
            c = rate(zeta + h / 2 * b, now + h / 2)
            d = rate(zeta + h * c, now + h)
            zeta = zeta + h / 6 * (a + 2 * b + 2 * c + d)
            now += h
        now = time
        found.append(1j * wavenumber * np.fft.ifft(zeta / laplacian))
    return np.array(found)
