"""Three bodies: the figure-eight orbit and the Pythagorean problem, with their states at later times; G = 1.

The later states were computed with Taylor series of order 40 in 40 decimal digits, from the doubles that the codes are
given (truncation 1e-34 a step; the energy is kept to 1e-28): all digits given are good.

Literature: A. Chenciner and R. Montgomery, Ann. Math. 152, 881 (2000), with C. Simo's digits; C. Burrau, Astron. Nachr.
195, 113 (1913); V. Szebehely and C. F. Peters, Astron. J. 72, 876 (1967).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crosscheck.references import EPSILON

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class ThreeBodies:
    """The states of three bodies in a plane at time 0 and at a later time; G = 1.

    masses: (3,). positions, velocities: (3, 2), at time 0. time: the later one. final_positions, final_velocities: (3,
    2), then. energy: total, conserved; so is the angular momentum, which is zero. sensitivity, greatest: of the final
    state to relative errors in the components x_k of the state at time t, (sum_jk (d x_j(T)/d x_k(t) x_k(t))^2)^(1/2):
    its root mean square over the time, and its maximum.
    """

    masses: tuple[float, float, float]
    positions: Floats
    velocities: Floats
    time: float
    final_positions: Floats
    final_velocities: Floats
    energy: float
    sensitivity: float
    greatest: float

    def rounding_error(self, steps: float, even: bool = True) -> float:
        """Standard deviation of the final state if every step rounds every component independently.

        steps: their number. even: steps of one length; else they may all be where the motion is most sensitive.
        """
        return (self.sensitivity if even else self.greatest) * EPSILON / 12**0.5 * steps**0.5


_X, _V = np.array([0.97000436, -0.24308753]), np.array([-0.93240737, -0.86473146])

#: One period. From eight digits the bodies return to within 4.1e-8 of where they were.
FIGURE_EIGHT = ThreeBodies(
    masses=(1.0, 1.0, 1.0),
    positions=np.array([_X, -_X, 0 * _X]),
    velocities=np.array([-_V / 2, -_V / 2, _V]),
    time=6.32591398,
    final_positions=np.array(
        [
            [0.97000434443112543662, -0.24308754345679362758],
            [-0.97000437448629543880, 0.24308751553722470892],
            [3.0055170002182263859e-8, 2.7919568918658849636e-8],
        ]
    ),
    final_velocities=np.array(
        [
            [0.46620372396391878726, 0.43236572051200787736],
            [0.46620364679536276809, 0.43236573991692567132],
            [-0.93240737075928155536, -0.86473146042893352869],
        ]
    ),
    energy=-1.2871419917663255582,
    sensitivity=30.3,
    greatest=46.1,
)
#: The largest distance of a body from its start after one period of exact motion.
RETURN_ERROR = 4.102213515e-8

#: Bound on |dE| and |dL| by the length of a change of the figure-eight's initial state (r, v): 2.35 and 2.11 there.
GREATEST_GRADIENT = 2.4

#: Bodies of mass 3, 4 and 5 opposite the sides of that length, from rest.
PYTHAGOREAN = ThreeBodies(
    masses=(3.0, 4.0, 5.0),
    positions=np.array([[1.0, 3.0], [-2.0, -1.0], [1.0, -1.0]]),
    velocities=np.zeros((3, 2)),
    time=10.0,
    final_positions=np.array(
        [
            [0.77848041013808549311, 0.14139230029008616862],
            [-2.0250924779781985862, 0.097219384146058396502],
            [1.1529857362997075731, -0.16261088749089841837],
        ]
    ),
    final_velocities=np.array(
        [
            [1.7339443623805864286, 3.2247383696182900261],
            [-0.28255545657033173998, -0.38629894784371772808],
            [-0.81432225217208646520, -1.6258038634959998332],
        ]
    ),
    energy=-769 / 60,
    sensitivity=1.33e4,
    greatest=1.45e6,
)


def energy(masses: Floats, r: Floats, v: Floats) -> Floats:
    """Kinetic energy minus the sum over pairs of m_i m_j/r_ij, by its definition.

    masses: (N,). r, v: positions and velocities, (..., N, d). Gives (...,); G = 1.
    """
    kinetic = 0.5 * (masses[:, None] * v * v).sum((-1, -2))
    i, j = np.triu_indices(masses.size, 1)
    return np.asarray(kinetic - (masses[i] * masses[j] / np.linalg.norm(r[..., i, :] - r[..., j, :], axis=-1)).sum(-1))


def angular_momentum(masses: Floats, r: Floats, v: Floats) -> Floats:
    """Sum of m r x v, by its definition.

    masses: (N,). r, v: positions and velocities, (..., N, 2). Gives (...,); G = 1.
    """
    return np.asarray((masses * (r[..., 0] * v[..., 1] - r[..., 1] * v[..., 0])).sum(-1))
