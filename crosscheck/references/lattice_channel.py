"""Gas in a channel between rows of wall sites, by the lattice Boltzmann equation: its slip, its sound, faster flows.

A small departure a_i(y) from equilibrium, times exp(i k x) along the channel, moves by

    a_i(y + c_iy) exp(i k c_ix) <- (a + J a)_i(y) at a row with gas, the reversed channels of a at a row of wall sites,

in a step, with the collision matrix J of `lattice_models`. That holds layers next to the walls a mean free path deep,
where the gas is no viscous fluid, and places the walls: nothing is fitted. Rows are periodic. Units: links and steps.
A flow that is not slow is steady where the whole equation, with `lattice_models.mean_collision`, gives it back.

Literature: U. Frisch et al., Complex Systems 1, 649 (1987) (Boltzmann equation); R. Cornubert, D. d'Humieres and D.
Levermore, Physica D 47, 241 (1991) (layers at walls of wall sites).
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosscheck.references.lattice_models import VELOCITIES, fermi_dirac, linearised_collision, mean_collision

#: What a wall site does: reverse the velocity; or reverse it across the wall, and along it with probability 1/2.
Rule = Literal["bounce_back", "diffusive_y"]
#: Occupations that change by less in a step of the search are steady, and the most steps that it takes.
_STEADY, _MOST_STEPS = 1e-13, 100


def _step(
    model: str, density: float, rows: int, walls: tuple[int, ...], rule: Rule, wavenumber: float
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """What happens at the rows, and the move to the next rows, each (rows b, rows b) on a (rows, b) as one vector."""
    c, integers = VELOCITIES[model].cartesian, VELOCITIES[model].integers
    b = len(c)
    gas = np.eye(b) + linearised_collision(model, fermi_dirac(model, density, (0.0, 0.0)))
    reversed_at, mirrored = np.zeros((b, b)), np.zeros((b, b))
    for i, (x, y) in enumerate(integers):
        reversed_at[integers.index((-x, -y)), i] = 1.0
        mirrored[integers.index((x, -y)), i] = 1.0
    wall = reversed_at if rule == "bounce_back" else (reversed_at + mirrored) / 2
    local, move = (np.zeros((rows, b, rows, b), dtype=np.complex128) for _ in range(2))
    for row in range(rows):
        local[row, :, row] = wall if row in walls else gas
        for i, (_, up) in enumerate(integers):
            move[(row + up) % rows, i, row, i] = np.exp(-1j * wavenumber * c[i, 0])
    return local.reshape(rows * b, rows * b), move.reshape(rows * b, rows * b)


def forced_channel(model: str, density: float, rows: int, rule: Rule) -> NDArray[np.float64]:
    """Momentum along the channel per site of each row, (rows,), where a steady force gives 1 a step to every site.

    The row 0 is a wall. model: a name of `MODELS`, else KeyError. density: d, mean occupation. rows: sites across, the
    wall included. rule: of the wall sites. By derivation: see the top; the force turns particles from -x to +x.
    """
    c = VELOCITIES[model].cartesian
    local, move = _step(model, density, rows, (0,), rule, 0.0)
    given = np.zeros((rows, len(c)))
    given[1:] = c[:, 0] * (abs(c[:, 1]) < 1e-12)
    given /= float(given[1] @ c[:, 0])
    step = (move @ local).real
    # mass is kept, so the steady state is not unique: the solution of least norm has the momentum of all of them
    steady = np.linalg.lstsq(np.eye(step.shape[0]) - step, (move @ local).real @ given.ravel())[0]
    return np.asarray(steady.reshape(rows, -1) @ c[:, 0])


class Steady(NamedTuple):
    """A steady flow. flow: momentum along the channel per site, (rows,). given: by the force in a step, (rows,)."""

    flow: NDArray[np.float64]
    given: NDArray[np.float64]


def steady_channel(model: str, density: float, rows: int, rule: Rule, force: float) -> Steady:
    """The steady flow where a force turns particles from -x to +x with the probability `force` a step.

    Of the whole Boltzmann equation, not of its linearised form: with occupations f after a collision, p f_- (1 - f_+)
    particles are turned at each site. The row 0 is a wall. model: a name of `MODELS`, else KeyError. density: d, mean
    occupation. rows: sites across, the wall included. rule: of the wall sites. By derivation; found by steps of the
    linearised equation, as (1 - L)^-1 of what is not steady yet. ValueError if these do not end.
    """
    c, integers = VELOCITIES[model].cartesian, VELOCITIES[model].integers
    local, move = (matrix.real for matrix in _step(model, density, rows, (0,), rule, 0.0))
    forwards, backwards = integers.index((2, 0)), integers.index((-2, 0))
    wall = local.reshape(rows, len(c), rows, len(c))[0, :, 0]
    back = np.linalg.pinv(np.eye(local.shape[0]) - move @ local)
    f = np.full((rows, len(c)), density)
    for _ in range(_MOST_STEPS):
        after = f + mean_collision(model, f)
        turned = force * after[:, backwards] * (1 - after[:, forwards])
        turned[0] = 0.0
        after[:, forwards] += turned
        after[:, backwards] -= turned
        after[0] = wall @ f[0]
        change = (back @ ((move @ after.ravel()) - f.ravel())).reshape(f.shape)
        f = f + change
        if not ((f > 0) & (f < 1)).all():
            break
        if abs(change).max() < _STEADY:
            return Steady(np.asarray(f @ c[:, 0]), 2 * turned)
    raise ValueError(f"force = {force:g}: no steady flow is found; take a weaker force")


def slip_length(model: str, density: float, rule: Rule, rows: int = 48) -> float:
    """b, where the gas slips at wall sites by b times its gradient there, links; negative: it rests beside them.

    From the parabola in the middle half of `forced_channel`, extended to the wall. model, density, rule, rows: as
    there.
    """
    flow = forced_channel(model, density, rows, rule)
    y = np.arange(rows) * VELOCITIES[model].row_height
    middle = slice(rows // 4, rows - rows // 4 + 1)
    _, slope, wall = np.polyfit(y[middle], flow[middle], 2)
    return float(wall / slope)
