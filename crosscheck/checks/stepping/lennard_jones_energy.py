"""Error of the energy of a hot drop against the time step."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import Check, Laboratory, schemes_with
from crosscheck.checks.stepping.audit import tier_beside_audits
from crosscheck.checks.stepping.faults import scheme_fault
from crosscheck.checks.stepping.fluids import OPEN, STEP, fluid
from crosscheck.convergence import ORDER_TOLERANCE, WHY_ORDER, fitted_order
from crosscheck.engines.capabilities import Needs
from crosscheck.figure import Figure, Series
from crosscheck.references import EPSILON
from crosscheck.scene import Box, LennardJones, Method, Output, Scene, explicit
from crosscheck.verdict import Judged, order


def _drop(number: int, density: float, temperature: float, seed: int) -> Scene:
    """A cube cut out of a lattice, in open space; all pairs interact."""
    state = fluid(number, density, temperature, seed, cutoff=0.5).initial_state()
    assert state.lengths is not None
    return Scene(
        name=f"drop-{number}",
        dimension=3,
        duration=0.5,
        lennard_jones=LennardJones(cutoff=30.0),
        box=Box(lengths=(60.0, 60.0, 60.0), boundaries=("open", "open", "open")),
        initial=explicit(state.positions + 30.0 - state.lengths / 2, state.velocities),
    )


#: Time steps by nominal order: first-order schemes are asymptotic only at much smaller ones.
DRIFT_STEPS = {1: (0.001, 0.0005, 0.00025, 0.000125), 2: (0.004, 0.002, 0.001, 0.0005)}


def _judge(laboratory: Laboratory, scheme: str) -> Judged:
    """Rms of E(t) - E(0) a particle over a time unit of a hot drop, the cutoff beyond it, so that E is smooth."""
    claims = laboratory.claims[scheme]
    assert claims.order is not None
    # melted first: on a lattice the forces nearly cancel, which hides the error
    melt = _drop(108, 0.8, 2.0, laboratory.seed())
    output = Output(interval=0.02, observables=("kinetic_energy", "potential_energy"))
    laboratory.demand(melt.changed(output=output), Method(scheme=scheme, dt=DRIFT_STEPS[2][0]))
    start = laboratory.run(melt, STEP, engine="refimpl")
    # the higher derivatives that Gear's schemes start from are zero here, which leaves order 2
    nominal = min(*claims.order, 2)
    scene = melt.changed(
        initial=explicit(start["final_positions"], start["final_velocities"]),
        duration=1.0,
        output=output,
    )
    errors = []
    for dt in DRIFT_STEPS[nominal]:
        run = laboratory.run(scene, Method(scheme=scheme, dt=dt))
        energy = (run["kinetic_energy"] + run["potential_energy"]) / scene.number
        errors.append(float(np.sqrt(((energy - energy[0]) ** 2).mean())))
    slope = fitted_order(DRIFT_STEPS[nominal], errors, 1e3 * EPSILON)
    curve = Series(scheme, list(DRIFT_STEPS[nominal]), errors)
    return order(
        "order of the energy error",
        slope.value,
        nominal,
        max(ORDER_TOLERANCE, 2 * slope.error),
        f"{WHY_ORDER}; or twice the departure of the local slopes",
        uncertainty=slope.error,
        figures=(Figure("energy error of the drop", "dt", "rms of E - E0 a particle", "log", "log", (curve,)),),
    )


CHECKS = (
    Check(
        name="stepping/lennard-jones-energy",
        title="Error of the energy of a hot drop against the time step, every scheme",
        equation="sqrt(mean (E(t) - E(0))^2) ~ dt^p, all pairs, open space",
        criterion=f"fitted order = claimed, at most 2, +- {ORDER_TOLERANCE} or twice the departure of local slopes",
        citation="Allen & Tildesley, Computer Simulation of Liquids (1987), section 3.2",
        judge=_judge,
        variants=schemes_with(lambda name, claims: claims.order is not None, tier_beside_audits("velocity_verlet")),
        faults=(
            (
                "velocity_verlet",
                scheme_fault(
                    "velocity-verlet-lagged-force",
                    "return r, add_to(v_half, 0.5 * dt, a), (a,)",
                    "return r, add_to(v_half, 0.5 * dt, memory[0]), (a,)",
                    "the second half kick takes the old acceleration",
                ),
            ),
        ),
        needs=Needs(
            "lennard_jones",
            words=OPEN,
            observables=frozenset({"kinetic_energy", "potential_energy"}),
            # all pairs, over thousands of steps
            promises=("long_runs",),
        ),
    ),
)
