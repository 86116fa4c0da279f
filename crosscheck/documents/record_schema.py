"""The JSON Schema of a line of the record, from the dataclasses that a line is written from."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import Field, TypeAdapter

from crosscheck.checks.base import Tier
from crosscheck.documents.markdown import NOTICE
from crosscheck.figure import Figure
from crosscheck.record import NEWER_FIELDS, SCHEMA
from crosscheck.verdict import Judgement, Outcome


@dataclass
class _Line:
    """A verdict: what came of one variant of one check on one engine."""

    schema: Annotated[int, Field(description="number of this schema")]
    check: Annotated[str, Field(description="group/phenomenon")]
    variant: Annotated[str, Field(description="which of its variants; it may hold slashes")]
    engine: Annotated[str, Field(description="the engine under judgement: its name, or path.py:Class")]
    tier: Annotated[Tier, Field(description="the tier that the case belongs to; the full tier contains the quick one")]
    outcome: Annotated[Outcome, Field(description="of the judgement that decides; or skip, or error")]
    judgements: Annotated[list[Judgement], Field(description="all of them, in a fixed order; none after skip or error")]
    worst: Annotated[int | None, Field(description="index of the judgement that decides")]
    note: Annotated[str, Field(description="a remark on all judgements")]
    figures: list[Figure]
    message: Annotated[str, Field(description="reason of a skip, last lines of an error")]
    refused: Annotated[
        int | None, Field(description="number of scenes that the engine could not run, and are left out")
    ]
    cost: Annotated[dict[str, float], Field(description="seconds, and what the runs cost")]
    time: Annotated[str, Field(description="when the case ended: UTC, ISO 8601")]
    provenance: Annotated[dict[str, Any], Field(description="versions, machine, seed and command")]


def record_schema() -> str:
    """The JSON Schema (draft 2020-12) of a line of the record as `record.read` returns it, schema 1 brought to it."""
    schema = TypeAdapter(_Line).json_schema()
    definitions = schema["$defs"]
    del definitions["Judgement"]["properties"]["figures"]  # those of all judgements are the verdict's
    for name in ("Judgement", "Criterion"):
        definitions[name]["required"] = [one for one in definitions[name]["properties"] if one not in NEWER_FIELDS]
    schema["properties"]["schema"]["const"] = SCHEMA
    head = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$comment": NOTICE,
        "title": "A line of record.jsonl",
        "description": _Line.__doc__,
    }
    return json.dumps(head | _as_written(schema | {"title": head["title"]}), indent=1, ensure_ascii=False) + "\n"


def _as_written(part: Any) -> Any:
    """Numbers may be null, where they were not finite; titles that only repeat the name of a field are left out."""
    if isinstance(part, list):
        return [_as_written(item) for item in part]
    if not isinstance(part, dict):
        return part
    if part.get("anyOf") == [{"type": "number"}, {"type": "null"}]:
        part = {"type": "number"} | {key: value for key, value in part.items() if key != "anyOf"}
    return {
        key: ["number", "null"] if key == "type" and value == "number" else _as_written(value)
        for key, value in part.items()
        if key != "title" or not isinstance(value, str) or "properties" in part
    }
