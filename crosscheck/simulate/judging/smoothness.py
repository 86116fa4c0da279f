"""How smooth the forces of a scene are: the order that a scheme can have, and what late kicks do to the energy."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.stepping.orbits import nominal_order
from crosscheck.references.lennard_jones import at_cutoff, cut_diffusion
from crosscheck.scene import Scene
from crosscheck.simulate.judging.trial import Trial

#: More pairs than those at random are at no more than this at a cutoff: g(r) there.
_CROWDED = 1.5


def jump(scene: Scene) -> str | None:
    """None, or the word of the part whose force jumps, or whose contacts begin with a kink. scene: what is run.

    A force that jumps acts up to a step too early or too late: an error of first order, of either sign, each time.
    """
    if scene.hard_spheres is not None:
        return "hard_spheres"
    if scene.lennard_jones is not None and scene.lennard_jones.truncation != "force_shifted":
        return f"lennard_jones.truncation={scene.lennard_jones.truncation}"
    if scene.box is not None and scene.box.wall is not None:
        return "box.wall"
    return None


def claimed_order(trial: Trial) -> int | None:
    """The order that the scheme of a trial claims for its forces, were they smooth; None: it claims none."""
    claims = trial.claims
    depends = (trial.scene.spring is not None and trial.scene.spring.gamma is not None) or (
        trial.scene.hard_spheres is not None
    )
    if depends:
        return None if claims.order_damped is None else min(claims.order_damped)
    if claims.order is None:
        return None
    of_start = claims.order[0] if trial.scene.spring is not None else nominal_order(trial.method.scheme, claims)
    return min(*claims.order, of_start)


def late_kicks(trial: Trial, dt: float, duration: float, kinetic: float) -> float:
    """Standard deviation of the energy after so much time, by forces that jump at a cutoff and act at whole steps.

    A pair that crosses the cutoff gets its force up to a step too early or too late, as in
    `crosscheck.references.lennard_jones.cut_diffusion`, whose pairs are at random: there are g(r_c) <= 1.5 times as
    many. Particles cross the reach of walls likewise, at four times the mean density at most.

    trial: of [lennard_jones]. dt: the step. duration: time. kinetic: the largest kinetic energy.
    """
    scene, d = trial.scene, trial.scene.dimension
    lj = scene.lennard_jones
    assert lj is not None
    number, lightest = scene.number, float(trial.start.masses.min())
    temperature = 2 * kinetic / (d * number)
    # up to a step late, of either sign: twice as far as a kick of half a step, and so four times the variance
    variance = 4 * _CROWDED * cut_diffusion(scene, temperature, dt, trial.room)
    wall = None if scene.box is None else scene.box.wall
    lengths = scene.lengths()
    if wall is not None and lengths is not None:
        like = lj.model_copy(
            update={"epsilon": wall.epsilon, "length": wall.sigma, "length_form": "sigma", "cutoff": wall.cutoff}
        )
        speed = (2 * temperature / (np.pi * lightest)) ** 0.5
        faces = sum(2 * number / float(lengths[axis]) for axis in range(d) if scene.boundaries[axis] == "wall")
        variance += 4 * faces * speed * at_cutoff(like)[1] ** 2 * 2 * temperature / lightest * dt**2 / 3
    return float((variance * duration) ** 0.5)
