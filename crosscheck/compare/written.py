"""A comparison as JSON. Schema: docs/reference/compare.schema.json."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Annotated, Any

from pydantic import Field, TypeAdapter

from crosscheck.compare.differences import Difference
from crosscheck.compare.growth import Growth, Kind
from crosscheck.compare.outcome import Class, Mode, status
from crosscheck.compare.tables import TableComparison
from crosscheck.compare.trajectories import Comparison

#: Raised when a field changes its meaning or goes; new fields do not raise it.
SCHEMA = 1


@dataclass
class _Component:
    """One component of one particle that differs."""

    frame: Annotated[int, Field(description="number of the pair of frames, from 0")]
    time: Annotated[float, Field(description="of the frame, in the unit of the first file")]
    step: Annotated[int | None, Field(description="of the frame, if the first file states it")]
    quantity: Annotated[str, Field(description="positions, velocities or spins")]
    particle: Annotated[int, Field(description="its id")]
    axis: Annotated[int, Field(description="0, 1 or 2")]
    first: float
    second: float
    rounding: Annotated[float, Field(description="by how much rounding of the files lets them differ")]


@dataclass
class _Growing:
    """How the separation grows: s0 exp(rate t)."""

    kind: Annotated[Kind, Field(description="whether rounding and chaos explain it, or where they do not")]
    rate: Annotated[float | None, Field(description="per unit of time")]
    rate_error: Annotated[float | None, Field(description="standard error of the rate")]
    start: Annotated[float | None, Field(description="s0, a length")]
    start_factor: Annotated[float | None, Field(description="factor of the uncertainty of s0 (one standard error)")]
    limit: Annotated[float | None, Field(description="the largest s0 that rounding explains")]
    horizon: Annotated[float | None, Field(description="time beyond which single particles need not agree")]
    parting: Annotated[int | None, Field(description="number of the frame at which the dynamics part")]
    expected: Annotated[float | None, Field(description="the largest separation that rounding and chaos explain there")]


@dataclass
class _Point:
    """A pair of frames."""

    time: float
    step: int | None
    rms: Annotated[float | None, Field(description="root mean square distance of a particle from itself")]
    largest: Annotated[float | None, Field(description="the largest such distance")]
    particle: Annotated[int | None, Field(description="id of the particle with that distance")]
    floor: Annotated[float | None, Field(description="what rounding of the files makes of rms at most")]
    line: Annotated[float | None, Field(description="the largest rms that rounding and chaos explain")]
    kinetic: Annotated[
        tuple[float | None, float | None], Field(description="mean kinetic energy of a particle in both")
    ]


@dataclass
class _Quantity:
    """A mean of both samples."""

    name: str
    first: float
    second: float
    error: Annotated[float, Field(description="standard error of the difference, of correlated data")]
    freedom: Annotated[float, Field(description="degrees of freedom of that error")]
    probability: Annotated[float, Field(description="of so large a difference if there is none")]
    sensitivity: Annotated[
        float | None, Field(description="smallest difference that is seen in 90 %, as a share of the first mean")
    ]
    independent: Annotated[float, Field(description="independent samples of the shorter series")]
    outcome: Annotated[str, Field(description="same, different, or unclear")]


@dataclass
class _Document:
    """Two results and what they are to each other."""

    schema: Annotated[int, Field(description="number of this schema")]
    first: Annotated[str, Field(description="path of the first file")]
    second: Annotated[str, Field(description="path of the second file")]
    formats: tuple[str, str]
    mode: Annotated[Mode, Field(description="the standard that was asked for")]
    verdict: Annotated[Class, Field(description="what they are to each other")]
    sentence: Annotated[str, Field(description="the same as a sentence, with its reason")]
    status: Annotated[int, Field(description="exit status: 0 the same by the standard, 1 different, 3 inconclusive")]
    clock: Annotated[str, Field(description="by what frames are matched: time, step or order")]
    particles: Annotated[int, Field(description="of the first frame of the first file")]
    remarks: list[str]
    setup: Annotated[list[str], Field(description="what is different in the set-up")]
    first_bits: Annotated[_Component | None, Field(description="the first component whose bits differ")]
    first_beyond: Annotated[_Component | None, Field(description="the first one beyond the rounding of the files")]
    growth: _Growing | None
    frames: Annotated[list[_Point], Field(description="of each pair of frames")]
    statistics: Annotated[list[_Quantity] | None, Field(description="null: not looked at")]


def schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of what `document` returns."""
    return {**TypeAdapter(_Document).json_schema(), "title": "A comparison of two trajectories"}


def document(found: Comparison, mode: Mode) -> dict[str, Any]:
    """A comparison as a JSON document; numbers that are not finite become null.

    found: the comparison. mode: the standard.
    """
    points = [
        _Point(
            gap.time,
            _step(found, number),
            gap.rms.get("positions"),
            gap.largest.get("positions"),
            gap.farthest.get("positions"),
            gap.floor.get("positions"),
            None if found.line is None else float(found.line[number]),
            gap.kinetic,
        )
        for number, gap in enumerate(found.gaps)
    ]
    whole = _Document(
        SCHEMA,
        found.first,
        found.second,
        found.formats,
        mode,
        found.classed,
        found.sentence,
        int(status(found.classed, mode)),
        found.clock,
        found.particles,
        list(found.remarks),
        found.setup,
        _component(found, found.bits),
        _component(found, found.beyond),
        None if found.growth is None else _growing(found.growth),
        points,
        None if found.tested is None else [_Quantity(**one._asdict()) for one in found.tested],
    )
    return dict(_finite(asdict(whole)))


def _growing(growth: Growth) -> _Growing:
    law, parting = growth.law, growth.parting
    frame, expected = (None, None) if parting is None else parting
    if law is None:
        return _Growing(growth.kind, None, None, None, None, None, None, frame, expected)
    return _Growing(growth.kind, law.rate, law.error, law.start, law.factor, law.limit, law.horizon, frame, expected)


def table_document(found: TableComparison, mode: Mode) -> dict[str, Any]:
    """A comparison of two tables as a JSON document: the fields of `TableComparison`. found: it. mode: the standard."""
    content = asdict(found)
    content["verdict"] = content.pop("classed")
    content["tested"] = None if found.tested is None else [one._asdict() for one in found.tested]
    for name in ("bits", "beyond"):
        cell = getattr(found, name)
        content[name] = None if cell is None else cell._asdict()
    return dict(_finite({"schema": SCHEMA, "mode": mode, "status": int(status(found.classed, mode)), **content}))


def _step(found: Comparison, number: int) -> int | None:
    return None if found.steps is None else found.steps[number]


def _component(found: Comparison, one: Difference | None) -> _Component | None:
    if one is None:
        return None
    return _Component(one.pair, found.gaps[one.pair].time, _step(found, one.pair), *one[1:])


def _finite(part: Any) -> Any:
    if isinstance(part, dict):
        return {key: _finite(value) for key, value in part.items()}
    if isinstance(part, list | tuple):
        return [_finite(value) for value in part]
    return None if isinstance(part, float) and not math.isfinite(part) else part
