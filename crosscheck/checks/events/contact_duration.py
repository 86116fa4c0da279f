"""With the TC model a run continues after an inelastic collapse: a contact that lasts is elastic."""

from __future__ import annotations

import numpy as np

from crosscheck.checks.base import EVENT_DRIVEN, Check, Laboratory, variants_of
from crosscheck.checks.events.rows import ROWS, Row, row_scene
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.references import EPSILON
from crosscheck.verdict import Judged, bounded, within, worst

#: t_c of the TC model, far below the time between collisions before the collapse.
_CONTACT_DURATION = 1e-6


def _judge_contact_duration(laboratory: Laboratory, row: Row) -> Judged:
    """The same rows with the TC model go on to their end."""
    alpha, duration = 0.9 * row.limit, 20.0
    run = laboratory.run(row_scene(row, alpha, duration, _CONTACT_DURATION), EVENT_DRIVEN, may_end_early=True)
    energy = run["kinetic_energy"]
    last = float(run["time"][np.isfinite(energy)][-1])
    carries_on = within(
        "round_off", "time reached", last, duration, EPSILON * duration, "the run must end at its duration",
        note=run.stopped,
    )  # fmt: skip
    falls = bounded(
        "kinetic energy at the end over that at the start", float(energy[-1] / energy[0]), 1.0, "it falls", control=True
    )
    return worst([carries_on, falls], f"alpha = {alpha:.4g}, t_c = {_CONTACT_DURATION:g}")


CHECKS = (
    Check(
        name="events/contact-duration",
        title="With the TC model a run continues after an inelastic collapse",
        equation="alpha = 1 in a collision of a particle whose last one was less than t_c ago",
        criterion="the run reaches its end with a finite number of collisions and less energy",
        citation="Luding & McNamara, Granul. Matter 1, 113 (1998)",
        judge=_judge_contact_duration,
        variants=variants_of({name: ROWS[name] for name in ("three", "wall-5")}, "full"),
        needs=Needs(
            "hard_spheres",
            (EVENT_DRIVEN,),
            words=frozenset(
                {
                    "box.boundaries=hard",
                    "box.faces",
                    "box.faces.open",
                    "dimension=2",
                    "hard_spheres.contact_duration",
                    "hard_spheres.restitution",
                }
            ),
            observables=frozenset({"collisions", "wall_collisions", "kinetic_energy"}),
        ),
        faults=(
            (
                "wall-5",
                Fault(
                    "no-contact-duration",
                    "events/rules.py",
                    "return age < contact_duration",
                    "return age < 0.0 * contact_duration",
                    "the TC model is never elastic",
                ),
            ),
        ),
    ),
)
