"""Restitution of soft grains towards 1 and towards 0, and the energy of an elastic gas.

Literature: J. Schaefer, S. Dippel and D. E. Wolf, J. Phys. I France 6, 5 (1996).
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.granular.impacts import (
    CENTRAL_DURATION,
    PHASES,
    RESOLUTIONS,
    STEP_LABEL,
    Floats,
    Law,
    after,
    impact_scene,
    lasting,
    make_impacts,
    ratio_judgement,
    rebound,
    rounded_speed,
)
from crosscheck.checks.granular.soft_grains import CONTACTS, soft_needs
from crosscheck.convergence import ORDER_TOLERANCE, WHY_ORDER, fitted_order
from crosscheck.errors import Unsupported
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.references.soft_impact import stiffness
from crosscheck.references.stepped_contact import elastic_energy_bound, hooke_bounds
from crosscheck.scene import Box, HardSpheres, Lattice, Output, Scene
from crosscheck.statistics import independent_mean, standard_error
from crosscheck.verdict import Judged, order, statistical, within, worst

# -- towards 1, and towards 0 ------------------------------------------------------------------------------------------


class _Towards(NamedTuple):
    """Restitutions towards `limit`, the nearest last, at these dt/t_c, and the order of the error at the last one."""

    limit: int
    alphas: tuple[float, ...]
    resolutions: tuple[float, ...]
    order: float


TOWARDS_1 = _Towards(1, (0.99, 0.9999, 1 - 1e-6, 1.0), RESOLUTIONS, 2.0)
#: As alpha -> 0, t_c is long, and d ln alpha = -pi d zeta/(1 - zeta^2)^(3/2) asks for small steps.
TOWARDS_0 = _Towards(0, (1e-2, 1e-3, 1e-6), (1e-3, 2.5e-4, 6.25e-5), 1.0)


def _rebounds(laboratory: Laboratory, alpha: float, resolution: float) -> tuple[Floats, float]:
    """v'/v of head-on impacts at equally spaced phases of the step, and a bound on its relative error."""
    phases = (np.arange(PHASES) + 0.5) / PHASES
    impacts = make_impacts(2, np.zeros(PHASES), laboratory.seed(), phases=phases, central=True)
    dt, steps = resolution * CENTRAL_DURATION, lasting(resolution)
    k = stiffness(alpha, float(impacts.reduced[0]), CENTRAL_DURATION)
    run = laboratory.run(impact_scene(impacts, Law(alpha), dt, steps), Law(alpha).method(k, dt))
    rounding = rounded_speed(impacts, steps, alpha, CENTRAL_DURATION) / alpha
    return rebound(impacts, *after(impacts, run))[0], hooke_bounds(alpha, resolution).restitution + rounding


def _judge_towards(laboratory: Laboratory, case: _Towards) -> Judged:
    alphas, resolutions = case.alphas, case.resolutions
    found = {(a, r): _rebounds(laboratory, a, r) for a in alphas for r in resolutions}
    # a grain that does not come back is further off than any bound
    errors = {key: float(abs(np.log(np.maximum(v, 1e-300) / key[0])).max()) for key, (v, _) in found.items()}
    bounds = {key: bound for key, (_, bound) in found.items()}
    series: list[Series] = []
    for alpha in alphas:
        x = list(resolutions)
        label = f"alpha = {alpha:.7g}"
        series.append(Series(label, x, [errors[alpha, r] for r in resolutions]))
        series.append(Series(f"{label}, bound", x, [bounds[alpha, r] for r in resolutions], theory=True))
    figure = Figure(
        f"restitution towards {case.limit}", STEP_LABEL, "largest relative error of v'/v", "log", "log",
        tuple(series),
    )  # fmt: skip
    why = "stepped contact against the closed form, and -ln(1 - c h) + h^2/4 for its ends; rounding of the coordinates"
    judgements = [ratio_judgement("largest relative error of v'/v", list(errors.values()), list(bounds.values()), why)]
    alpha = alphas[-1]
    slope = fitted_order(resolutions, [errors[alpha, r] for r in resolutions], EPSILON).value
    judgements.append(order(f"order of v'/v in dt at alpha = {alpha:g}", slope, case.order, ORDER_TOLERANCE, WHY_ORDER))
    last = ", ".join(f"{a:.7g}: {found[a, resolutions[-1]][0].mean():.8g}" for a in alphas)
    return worst(judgements, f"mean v'/v at the smallest step, {last}", (figure,))


def _judge_zero(laboratory: Laboratory) -> Judged:
    """Restitution 0 has no soft contact: it must be refused."""
    reason = ""
    impacts = make_impacts(2, np.zeros(2), laboratory.seed(), central=True)
    try:
        laboratory.run(impact_scene(impacts, Law(0.0), 0.01, 10), Law(0.0).method(1.0, 0.01))
    except Unsupported as refusal:
        reason = str(refusal)
    return within("round_off", "refusals", float(bool(reason)), 1.0, 0.5, "a count: exact", note=reason or "it was run")


# -- an elastic gas ----------------------------------------------------------------------------------------------------

#: Disks of the elastic gas, packing fraction, contact time and duration in units of diameter and thermal speed.
_GAS, _GAS_PACKING, _GAS_CONTACT, _GAS_TIME = 100, 0.3, 0.02, 4.0
#: Steps in a contact. A contact changes the energy of the relative motion by h^2 (B_2(s) - B_2(s')), s and s' the
#: phases of the step at its two ends, B_n Bernoulli's polynomials. The two terms are uncorrelated where B_4 of the
#: fractional part of the steps is 0, at 0.24; elsewhere only if the steps are many.
_GAS_STARTS, _GAS_STEPS = 24, (20.24, 60.24, 180.24)


def _judge_gas(laboratory: Laboratory) -> Judged:
    """Energy of elastic grains, with that of their springs."""
    # whole numbers of steps
    interval = 25 * _GAS_CONTACT
    k = stiffness(1.0, 0.5, _GAS_CONTACT)
    rms, largest = np.zeros((2, _GAS_STARTS, len(_GAS_STEPS)))
    contacts = np.zeros(_GAS_STARTS)
    for start in range(_GAS_STARTS):
        scene = Scene(
            name="elastic-gas",
            dimension=2,
            duration=_GAS_TIME,
            hard_spheres=HardSpheres(),
            box=Box(packing_fraction=_GAS_PACKING),
            initial=Lattice(
                kind="lattice", structure="square", number=_GAS, temperature=1.0, seed=laboratory.seed(str(start))
            ),
            output=Output(interval=interval, observables=("kinetic_energy", "potential_energy", "contact_time")),
        )
        for rung, steps in enumerate(_GAS_STEPS):
            run = laboratory.run(scene, Law(1.0).method(k, _GAS_CONTACT / steps))
            energy = run["kinetic_energy"] + run["potential_energy"]
            error = abs(energy / energy[0] - 1)
            rms[start, rung], largest[start, rung] = np.sqrt(np.mean(error**2)), error.max()
        contacts[start] = run["contact_time"][-1] / _GAS_CONTACT
    resolutions = 1 / np.array(_GAS_STEPS)
    bounds = contacts[:, None] * elastic_energy_bound(resolutions) / _GAS
    orders = np.polyfit(np.log(resolutions), np.log(rms.T), 1)[0]
    mean, spread = np.exp(np.log(rms).mean(axis=0)), standard_error(np.log(rms))
    figure = Figure(
        "energy of an elastic gas", STEP_LABEL, "rms relative error of the energy", "log", "log",
        (Series("soft disks", resolutions.tolist(), mean.tolist(), (mean * spread).tolist()),),
    )  # fmt: skip
    return worst(
        [
            ratio_judgement(
                "largest error of the energy", largest.ravel().tolist(), bounds.ravel().tolist(),
                "a contact changes the energy by h^2/4 of the relative motion's at most, k_B T on average",
            ),
            statistical(
                "order of the energy in dt", *independent_mean(orders), 2.0, 0.0,
                f"standard error over {_GAS_STARTS} gases, whose energies walk at random from contact to contact",
                samples=_GAS_STARTS, needed=0.25,
            ),
        ],
        f"{_GAS_STARTS} gases of {_GAS} disks, {contacts.min():.0f} contacts or more each",
        (figure,),
    )  # fmt: skip


def _judge_limits(laboratory: Laboratory, case: _Towards | Literal["zero", "elastic-gas"]) -> Judged:
    if isinstance(case, _Towards):
        return _judge_towards(laboratory, case)
    return _judge_zero(laboratory) if case == "zero" else _judge_gas(laboratory)


#: The energy of a gas is that of its springs too.
_ENERGIES = soft_needs(observables="kinetic_energy potential_energy contact_time")
_VARIANTS = (
    Variant("towards-1", TOWARDS_1, "full"),
    Variant("towards-0", TOWARDS_0, "full"),
    Variant("zero", "zero", "full"),
    Variant("elastic-gas", "elastic-gas", "full", needs=_ENERGIES),
)
CHECKS = (
    Check(
        name="granular/restitution-limits",
        title="Restitution towards 1 and towards 0",
        equation="alpha = exp(-pi c/sqrt(4 - c^2)), c -> 0 and c -> 2; E = const at alpha = 1",
        criterion="bounds and order in dt; energy of an elastic gas to order 2, over 24 gases; 0 is refused",
        citation="Schaefer, Dippel & Wolf, J. Phys. I France 6, 5 (1996)",
        judge=_judge_limits,
        variants=_VARIANTS,
        needs=soft_needs("dimension=2 method.contact.stiffness hard_spheres.restitution"),
        faults=(
            (
                "towards-0",
                Fault(
                    "grains-never-attract",
                    CONTACTS,
                    "* scale * delta - _damping(law[DAMPING], law, model, mass, scale) * approach",
                    "* max(0.0, scale * delta - _damping(law[DAMPING], law, model, mass, scale) * approach "
                    "/ law[STIFFNESS])",
                    "the normal force is cut off where the dashpot makes it attract",
                ),
            ),
        ),
    ),
)
