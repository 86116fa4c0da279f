"""Head-on impacts of grains of very unlike masses and sizes.

Literature: J. Schaefer, S. Dippel and D. E. Wolf, J. Phys. I France 6, 5 (1996).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, variants_of
from crosscheck.checks.granular.impacts import (
    CENTRAL_DURATION,
    PHASES,
    Floats,
    Impacts,
    Law,
    after,
    impact_scene,
    lasting,
    make_impacts,
    overlaps,
    ratio_judgement,
    rebound,
    rounded_speed,
)
from crosscheck.checks.granular.soft_grains import CONTACTS, soft_needs
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.references.soft_impact import stiffness
from crosscheck.references.stepped_contact import hooke_bounds
from crosscheck.verdict import Judged, round_off, worst

MASS_RATIOS = tuple(10.0**power for power in range(7))
SIZE_RATIOS = (1.0, 2.0, 5.0, 10.0, 30.0)
_ALPHA, _RESOLUTION = 0.5, 1 / 160


class _Unlike(NamedTuple):
    """What of the grains is unlike: both, by the same ratio, sizes up to the largest of `SIZE_RATIOS` only."""

    name: str
    masses: bool = False
    sizes: bool = False


UNLIKE = (_Unlike("masses", masses=True), _Unlike("sizes", sizes=True), _Unlike("both", masses=True, sizes=True))


def _momentum_lost(impacts: Impacts, velocities: Floats) -> Floats:
    """Change of each pair's momentum, of velocities (P, 2, 3) after the impact, over what its grains carry; (P,)."""
    masses = impacts.masses[:, :, None]
    momenta = [(masses * v).sum(axis=1) for v in (velocities, impacts.velocities)]
    carried = (masses * abs(velocities)).sum(axis=(1, 2)) + (masses * abs(impacts.velocities)).sum(axis=(1, 2))
    return np.asarray(abs(momenta[0] - momenta[1]).max(axis=1) / carried)


def _impacts(unlike: _Unlike, seed: int) -> tuple[Floats, Impacts]:
    """Ratios (P,), and impacts of heavy or large grains at rest, hit by those of mass and diameter 1."""
    ratios = np.repeat(MASS_RATIOS if unlike.masses else SIZE_RATIOS, PHASES)
    pairs = np.stack([np.ones(ratios.size), ratios], axis=1)
    phases = np.tile((np.arange(PHASES) + 0.5) / PHASES, ratios.size // PHASES)
    sizes = np.minimum(pairs, SIZE_RATIOS[-1]) if unlike.sizes else 1.0
    masses = pairs if unlike.masses else 1.0
    return ratios, make_impacts(
        2, np.zeros(ratios.size), seed, phases=phases, masses=masses, diameters=sizes, central=True
    )


def _judge_ratios(laboratory: Laboratory, unlike: _Unlike) -> Judged:
    ratios, impacts = _impacts(unlike, laboratory.seed())
    reduced, law = impacts.reduced, Law(_ALPHA)
    k = stiffness(_ALPHA, float(reduced.min()), CENTRAL_DURATION)
    dt = _RESOLUTION * CENTRAL_DURATION
    expected = CENTRAL_DURATION * np.sqrt(reduced / reduced.min())
    steps = math.ceil(float(expected.max()) / CENTRAL_DURATION * lasting(_RESOLUTION))
    run = laboratory.run(impact_scene(impacts, law, dt, steps, sampled=True), law.method(k, dt))
    velocities, spins = after(impacts, run)
    normal, _ = rebound(impacts, velocities, spins)
    grouped = (-1, PHASES)
    lasted = dt * (overlaps(impacts, run) > 0).sum(axis=0).reshape(grouped).mean(axis=1)
    wanted = expected.reshape(grouped)[:, 0]
    bounds = [hooke_bounds(_ALPHA, dt / float(duration)) for duration in wanted]
    rounding = rounded_speed(impacts, steps, _ALPHA, CENTRAL_DURATION) / _ALPHA
    restitution = abs(np.log(normal / _ALPHA)).reshape(grouped).max(axis=1)
    ratio = ratios.reshape(grouped)[:, 0].tolist()
    figure = Figure(
        "contact time of unlike grains", "ratio of masses or sizes", "t_c over the shortest", "log", "linear",
        (
            Series(unlike.name, ratio, (lasted / wanted.min()).tolist()),
            Series(f"{unlike.name}, sqrt(m_eff)", ratio, (wanted / wanted.min()).tolist(), theory=True),
        ),
    )  # fmt: skip
    why = "stepped contact against the closed form, -ln(1 - c h) + h^2/4 for its ends, rounding of the coordinates"
    return worst(
        [
            ratio_judgement(
                "largest relative error of the restitution", restitution.tolist(),
                [one.restitution + rounding for one in bounds], why,
            ),
            ratio_judgement(
                "largest relative error of the contact time", abs(lasted / wanted - 1).tolist(),
                [one.time + dt / PHASES / float(d) for one, d in zip(bounds, wanted, strict=True)],
                "stepped contact against the closed form, and whole steps, averaged over equally spaced phases",
            ),
            round_off(
                "largest change of a pair's momentum, relative to what its grains carry",
                float(_momentum_lost(impacts, velocities).max()),
                4 * EPSILON * math.sqrt(steps), "rounding of the velocities at every step, a random walk",
            ),
        ],
        f"{'mass' if unlike.masses else 'size'} ratios 1 to {ratio[-1]:g}, alpha = {_ALPHA:g}, "
        f"dt = t_c/{1 / _RESOLUTION:.0f}",
        (figure,),
    )  # fmt: skip


CHECKS = (
    Check(
        name="granular/ratios",
        title="Head-on impacts of grains of very unlike masses and sizes",
        equation="t_c = sqrt((pi^2 + ln^2 alpha) m_eff/k); v' = alpha v; m_1 v_1 + m_2 v_2 = const",
        criterion="bounds of first order in c omega_0 dt and second in omega_0 dt; momentum to rounding",
        citation="Schaefer, Dippel & Wolf, J. Phys. I France 6, 5 (1996)",
        judge=_judge_ratios,
        variants=variants_of({unlike.name: unlike for unlike in UNLIKE}, "full"),
        needs=soft_needs("dimension=2 method.contact.stiffness hard_spheres.restitution", "positions velocities"),
        faults=(
            (
                "masses",
                Fault(
                    "reduced-mass-of-like-grains",
                    CONTACTS,
                    "mass = 1.0 / (inverse_masses[i] + inverse_masses[j])",
                    "mass = 0.5 / inverse_masses[i]",
                    "the reduced mass is half that of the first grain",
                ),
            ),
        ),
    ),
)
