"""Three ways to move the same gas: bit planes, table look-up and NumPy."""

from __future__ import annotations

from typing import Any

from crosscheck.checks.base import Check, Laboratory, Variant
from crosscheck.checks.lattice.gases import LATTICE, filled, gas_scene
from crosscheck.checks.lattice.recording import recorded
from crosscheck.engines.capabilities import Needs, refusal
from crosscheck.engines.registry import engine_class
from crosscheck.faults import Fault
from crosscheck.references.lattice_models import MODELS
from crosscheck.scene import Floats, Method, Obstacle, Output, Scene
from crosscheck.verdict import Judged, Judgement, round_off, worst

STEPS = 4
_ROWS, _COLUMNS = 8, 133
EVOLVERS = ("lattice_lookup", "lattice_planes", "lattice_numpy")
#: Models of the quick tier: whose states choose among at most two outcomes, and among more, by one random bit and two.
_QUICK = ("fhp3", "fhp_saturated_identity")


def _judge(laboratory: Laboratory, model: str) -> Judged:
    """The same sites from all evolvers, and what one of them does by the auditor: agreement alone proves nothing."""
    seed = laboratory.seed()
    walls = (
        Obstacle(rows=(0, 0), rule="diffusive_y"),
        Obstacle(columns=(0, 0), rule="diffusive_x"),
        Obstacle(rows=(5, 5), rule="specular_y"),
        Obstacle(columns=(70, 70), rule="specular_x"),
        Obstacle(centre=(35.0, 2.5), radius=1.5),
    )
    start = filled(0.35, seed)
    judgements = []
    both: dict[str, dict[str, Any]] = {"walls": {"obstacles": walls, "force": -0.05}, "free": {}}
    for name, gas in both.items():
        scene = gas_scene(name, model, _ROWS, _COLUMNS, STEPS, start, Output(), **gas)
        first, *others = (recorded(laboratory, scene, Method(scheme=scheme)) for scheme in EVOLVERS)
        judgements.append(
            round_off(
                f"{name}: sites that {EVOLVERS[0]} moves otherwise than the rules say",
                first.forbidden.number,
                0.5,
                "coordinates say where each particle arrives, the definition of the model what it may become",
                note=first.forbidden.first,
            )
        )
        judgements += [
            round_off(
                f"{name}: sites in which {scheme} differs from {EVOLVERS[0]}",
                float((other.trajectory != first.trajectory).any(axis=-1).sum()),
                0.5,
                "the random bits of a site are numbered, so all evolvers draw the same: not one bit may differ",
            )
            for scheme, other in zip(EVOLVERS[1:], others, strict=True)
        ]
        judgements += _in_one_go(laboratory, scene, first.trajectory[-1], name)
    return worst(judgements, f"{STEPS} steps of {_ROWS} x {_COLUMNS} sites")


def _in_one_go(laboratory: Laboratory, scene: Scene, expected: Floats, name: str) -> list[Judgement]:
    """All steps without a look in between, in which an evolver may take several together, or share them out.

    expected: the sites after the last step, (rows, columns, b).
    """
    whole = scene.changed(output=Output(interval=STEPS, fields=(_COLUMNS, _ROWS), observables=("populations",)))
    judgements = []
    for method in (*(Method(scheme=scheme) for scheme in EVOLVERS), Method(scheme="lattice_planes", threads=2)):
        if refusal(engine_class(laboratory.engine), whole, method) is None:
            last = laboratory.run(whole, method)["populations"][-1].transpose(1, 0, 2)
            threads = f" by {method.threads} threads" if method.threads else ""
            judgements.append(
                round_off(
                    f"{name}: sites that {method.scheme}{threads} moves otherwise in {STEPS} steps at once",
                    float((last != expected).any(axis=-1).sum()),
                    0.5,
                    "steps taken together are the same steps: not one bit may differ",
                )
            )
    return judgements


CHECKS = (
    Check(
        name="lattice/evolvers",
        title="Bit planes, table look-up and NumPy move the same gas, by the rules",
        equation="s(t + 1) = C S s(t)",
        criterion="not one bit differs",
        citation="Frisch, Hasslacher & Pomeau, Phys. Rev. Lett. 56, 1505 (1986)",
        judge=_judge,
        variants=tuple(Variant(name, name, "quick" if name in _QUICK else "full") for name in MODELS),
        faults=(
            (
                "fhp3",
                Fault(
                    "neighbour-word",
                    "lattice/kernels/words.py",
                    "(read(place + -1) >> 63)",
                    "(read(place + -2) >> 63)",
                    "bit planes take the bit at the edge of a word from the next but one",
                ),
            ),
            (
                "fhp3",
                Fault(
                    "early-triangle",
                    "lattice/kernels/planes.py",
                    "inset = slope * (level + 1)",
                    "inset = slope * level",
                    "where several steps are taken in one pass, rows move before their neighbours have",
                ),
            ),
        ),
        needs=Needs("lattice_gas", (LATTICE,), observables=frozenset({"populations"}), schemes=EVOLVERS),
        interpreted=True,
    ),
)
