"""Standard error against run time of the viscosity of a lattice gas, from lattices of growing width.

Literature: U. Frisch et al., Complex Systems 1, 649 (1987); L. P. Kadanoff, G. R. McNamara and G. Zanetti, Phys. Rev. A
40, 4527 (1989).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.lattice.gases import FHP, LATTICE, filled, gas_scene, populations
from crosscheck.checks.lattice.green_kubo import against_green_kubo, first_step, fluctuations
from crosscheck.checks.lattice.waves import MEMBERS, SHEAR, decay_rate, transverse_momentum, wavenumber
from crosscheck.checks.performance.work_precision_averaging import CRITERION, FACTOR, averaged
from crosscheck.engines.capabilities import Needs
from crosscheck.engines.protocol import Claims, Run
from crosscheck.faults import Fault
from crosscheck.references import lattice_gas as known
from crosscheck.references.lattice_models import VELOCITIES, modes
from crosscheck.scene import Method, Output, Wave
from crosscheck.verdict import Judged, worst

_MODEL, _DENSITY, _ROWS = "fhp_saturated", 0.5, 32
_NARROWEST, _RUNGS, _SAMPLES = 128, 4, 40


def _schemes(schemes: Mapping[str, Claims]) -> Iterable[Variant]:
    """One variant per scheme whose particles are counted, not averaged, and which does not take minutes."""
    return (
        Variant(name, name, "full")
        for name, claims in schemes.items()
        if claims.kind == LATTICE and not name.endswith(("_numpy", "_boltzmann"))
    )


def _judge(laboratory: Laboratory, scheme: str) -> Judged:
    """nu from the decay of a shear wave on lattices of growing width."""
    k = wavenumber(_MODEL, _ROWS)
    rate = modes(_MODEL, _DENSITY, (0.0, k)).shear_decay
    every = max(1, int(1.5 / rate) // _SAMPLES)
    steps = every * _SAMPLES
    phases = np.exp(-1j * k * np.arange(_ROWS) * VELOCITIES[_MODEL].row_height)
    wave = (Wave(of="velocity_x", amplitude=SHEAR, mode=(0.0, 1.0)),)

    def one(columns: float, member: int) -> tuple[float, Run]:
        start = filled(_DENSITY, laboratory.seed(f"{columns:g}/{member}"), waves=wave)
        output = Output(interval=every, observables=("populations",), fields=(1, _ROWS))
        scene = gas_scene("work-precision-viscosity", _MODEL, _ROWS, int(columns), steps, start, output)
        run = laboratory.run(scene, Method(scheme=scheme))
        signal = populations(run)[:, 0] @ transverse_momentum(_MODEL) @ phases
        return decay_rate(np.arange(0, steps + 1, every), signal, rate) / k**2, run

    found = averaged([_NARROWEST * FACTOR**rung for rung in range(_RUNGS)], one, MEMBERS)
    c = VELOCITIES[_MODEL].cartesian
    rest = fluctuations(laboratory, _MODEL, _DENSITY, [c[:, 0] * c[:, 1], (c[:, 0] ** 2 - c[:, 1] ** 2) / 2], _ROWS)
    theory = known.shear_viscosity(_MODEL, _DENSITY)
    mean, note = against_green_kubo(
        "nu, of the widest lattices", found.values[-1].tolist(), (rate / k**2, theory), rest, rate
    )
    figure = found.figure(
        f"the viscosity of {_MODEL}, d = {_DENSITY:g}, from a shear wave on {_ROWS} rows",
        scheme, laboratory.claims[scheme], "columns", lambda run: float(run.cost.site_updates or 0), "sites updated",
    )  # fmt: skip
    return worst([found.exponent(), first_step(_MODEL, rest, "shear"), mean], f"{found.merit()}; {note}", (figure,))


CHECKS = (
    Check(
        name="performance/work-precision-lattice-viscosity",
        title="Work and precision on the viscosity of a lattice gas",
        equation="u_x(y, t) = u_0 sin(k y) exp(-nu k^2 t)",
        criterion=f"{CRITERION}, that of fluctuations at rest, whose first step is exact; {MEMBERS} runs of a width",
        citation=f"{FHP}; Kadanoff, McNamara & Zanetti, Phys. Rev. A 40, 4527 (1989)",
        judge=_judge,
        variants=_schemes,
        faults=(
            (
                "lattice_planes",
                Fault(
                    "cold-head-on",
                    "lattice/models.py",
                    "            outcomes[state] = cycle if identity",
                    "            outcomes[state] = (state,) if state in (9, 18, 36) else cycle if identity",
                    "head-on pairs of six bits pass through each other",
                ),
            ),
        ),
        needs=Needs("lattice_gas", (LATTICE,), observables=frozenset({"populations"})),
        timing=True,
    ),
)
