"""Missed events among many particles: the pairs that can meet give what all pairs give."""

from __future__ import annotations

import numpy as np
import pytest

from crosscheck.engines.protocol import Run
from crosscheck.references.event_audit import audit, missed
from crosscheck.scene import Box, HardSpheres, Lattice, Method, Output, Scene, Well


def scene(dimension, **changes):
    entries = {
        "name": "many",
        "dimension": dimension,
        "duration": 0.6,
        "hard_spheres": HardSpheres(restitution=0.8),
        "box": Box(lengths=(9.0, 8.0) if dimension == 2 else (4.6, 5.0, 4.8)),
        "initial": Lattice(
            kind="lattice", structure="square" if dimension == 2 else "sc", number=36, temperature=1.0, seed=3
        ),
        "output": Output(interval=0.3, trajectory=True, trace=True),
    }
    return Scene(**(entries | changes))


SCENES = {
    "disks": scene(2),
    "spheres": scene(3),
    "walls": scene(2, box=Box(lengths=(9.0, 8.0), boundaries=("hard", "periodic"))),
    "wells": scene(3, duration=0.2, hard_spheres=HardSpheres(well=Well(depth=1.0, range=1.3))),
    "little room": scene(2, box=Box(lengths=(16.0, 2.5)), initial=Lattice(
        kind="lattice", structure="square", number=16, temperature=1.0, seed=3)),
}  # fmt: skip


@pytest.mark.parametrize("name", SCENES)
def test_near_pairs_find_what_all_pairs_find(name, interpreted, monkeypatch):
    case = SCENES[name]
    run = interpreted.run(case, Method(scheme="event_driven"))
    events = len(run["event_times"])
    assert events > 8
    # pairs that hit each other late, and a run in which one event was not seen
    cut = {key: value[:-3] if key.startswith("event_") else value for key, value in run.items()}
    for arrays in (run, Run(cut)):
        found = []
        for most in (missed.ALL_PAIRS, 0):
            monkeypatch.setattr(missed, "ALL_PAIRS", most)
            monkeypatch.setattr(missed, "_AT_A_TIME", 200)
            found.append(audit(case, arrays))
        all_pairs, near = (one.shares["missed events"] for one in found)
        assert near == pytest.approx(all_pairs, rel=1e-6, abs=1e-6)
        assert found[0].where.get("missed events") == found[1].where.get("missed events")
    assert np.isfinite(near)
    assert near > 1e3
