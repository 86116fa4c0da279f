"""The JSON Schema of compare.json."""

from __future__ import annotations

import json

from crosscheck.compare.written import schema
from crosscheck.documents.markdown import NOTICE


def compare_schema() -> str:
    """The JSON Schema (draft 2020-12) of what `crosscheck compare` writes of two trajectories."""
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "$comment": NOTICE}
    return json.dumps(head | schema(), indent=1, ensure_ascii=False) + "\n"
