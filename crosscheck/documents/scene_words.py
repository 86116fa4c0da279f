"""The page of the words of a scene, and their JSON Schema."""

from __future__ import annotations

import inspect
import json
from typing import Any

from crosscheck.documents.markdown import NOTICE, page, table_of
from crosscheck.scene import Scene
from crosscheck.scene.parts import INTERACTIONS, Interaction, LatticeGas, Part, SceneEntries
from crosscheck.scene.tables import ANY_INDEX, ANY_KEY, Table, tables
from refimpl.lattice.models import MODELS

#: A minimal scene for each interaction.
EXAMPLES = {
    "spring": """\
name = "oscillator"
dimension = 1
duration = 10.0

[spring]
k = 1.0

[initial]
kind = "explicit"
positions = [[1.0]]

[method]
scheme = "velocity_verlet"
dt = 0.01
""",
    "lennard_jones": """\
name = "liquid"
dimension = 3
duration = 10.0

[lennard_jones]
cutoff = 2.5

[box]
density = 0.8

[initial]
kind = "lattice"
structure = "fcc"
number = 256
temperature = 1.0
seed = 1

[method]
scheme = "velocity_verlet"
dt = 0.005
""",
    "gravity": """\
name = "two-bodies"
dimension = 2
duration = 10.0
masses = [0.5, 0.5]

[gravity]

[initial]
kind = "kepler"
eccentricity = 0.5

[method]
scheme = "leapfrog"
dt = 0.01
""",
    "hard_spheres": """\
name = "granular-gas"
dimension = 2
duration = 10.0

[hard_spheres]
restitution = 0.9

[box]
packing_fraction = 0.3

[initial]
kind = "lattice"
structure = "square"
number = 400
temperature = 1.0
seed = 1

[method]
scheme = "event_driven"
""",
    "lattice_gas": """\
name = "fhp-gas"
dimension = 2
duration = 100

[lattice_gas]
model = "fhp1"
columns = 64
rows = 64

[initial]
kind = "occupations"
density = 0.3
seed = 1

[method]
scheme = "lattice_planes"
""",
}


def scene_words() -> str:
    """The page of all words of the scene language: a section per TOML table, and an example per interaction."""
    lines = [
        *_INTRODUCTION.format(interactions=", ".join(f"`[{name}]`" for name in INTERACTIONS)).splitlines(),
    ]
    documented: dict[type[Part], str] = {}
    for table in tables(Scene):
        title = f"`{table.title}`" if table.title else "The scene itself"
        lines += ["", f"## {title}", ""]
        if table.part in documented:
            lines.append(f"The words are those of {documented[table.part]}.")
            continue
        documented[table.part] = title
        lines += [_text(table.part), "", *_words(table)]
    lines += ["", "## Examples", "", "A minimal scene of each interaction, which records only the state at the end."]
    for name in INTERACTIONS:
        lines += ["", f"### `[{name}]`", "", "```toml", *EXAMPLES[name].splitlines(), "```"]
    return page("Words of a scene", lines)


_INTRODUCTION = """\
A scene is a [TOML](https://toml.io) file that says what is simulated. Words above the first table belong to the scene
itself; all others are in tables, which this page lists in reading order. A scene has exactly one interaction:
{interactions}.

* **Units.** A scene is in one consistent system of units, which it chooses: reduced units, or SI, where length is in m,
  mass in kg and energy in J. A temperature is an energy (k_B = 1). The unit 1 is that of a number without a unit; link
  and step are the units of length and time of a lattice gas.
* **Defaults.** A word without a default is required. "-" means that the word may be left out, and the column "meaning"
  says what holds then.
* **Numbers** are at most 1e100 in size, and where 0 is not allowed at least 1e-100, so that squares and cubes of them
  are numbers too.
* **Vectors** are lists of d numbers, with the dimension d of space.
* **Tables.** `[box.faces."x-"]` stands for any face; a table in `[[double brackets]]` may be repeated.
* **Mistakes.** Unknown words are refused; the message names the word that was probably meant. Words that contradict
  each other are refused when the scene is read; the message says which to remove.

The same as a JSON Schema, for editors: [scene.schema.json](scene.schema.json)."""


def _text(part: type[Part]) -> str:
    """The docstrings of a table's model and of the models that it extends, one line per paragraph."""
    models = [SceneEntries] if part is Scene else [model for model in part.__mro__ if issubclass(model, Part)]
    texts = [inspect.cleandoc(model.__doc__ or "") for model in models if model not in (Part, Interaction)]
    return "\n\n".join(" ".join(paragraph.split()) for text in texts for paragraph in text.split("\n\n"))


def _words(table: Table) -> list[str]:
    """The lines of a Markdown table of the words of one TOML table."""
    schema = table.part.model_json_schema()
    required = schema.get("required", ())
    rows = []
    for word, entry in schema["properties"].items():
        unit, meaning = unit_and_meaning(entry["description"])
        default = entry.get("default")
        if word in required:
            shown = "required"
        elif default is None or isinstance(default, list | dict):
            shown = "-"
        else:
            shown = f"`{json.dumps(default)}`"
        rows.append([f"`{word}`", _inner(table, word) or _type(entry), shown, unit, meaning])
    return table_of(("word", "type and allowed values", "default", "unit", "meaning"), rows)


def unit_and_meaning(description: str) -> tuple[str, str]:
    """The two parts of `description`, "[unit] meaning"; without a unit, the first one is empty."""
    text = " ".join(description.split())
    if not text.startswith("["):
        return "", text
    unit, _, meaning = text[1:].partition("] ")
    return unit, meaning


def _inner(table: Table, word: str) -> str:
    """For a word that is itself a table, or is chosen from models of refimpl: what to write for its type; else ""."""
    if table.part is LatticeGas and word == "model":
        return ", ".join(f'`"{name}"`' for name in MODELS)
    place = (*table.path, word)
    for other in tables(Scene):
        if other.path == place:
            return f"table `{other.title}`"
        if other.path in ((*place, ANY_KEY), (*place, ANY_INDEX)):
            return f"tables `{other.title}`"
        if other.path[:-1] == place and "kind" in other.part.model_fields:
            return f"table `[{'.'.join(place)}]`"
    return ""


def _type(entry: dict[str, Any], several: bool = False) -> str:
    """Type and range of an entry of a JSON Schema in words, in the plural if there are several."""
    if "anyOf" in entry:
        return " or ".join(_type(form) for form in entry["anyOf"] if form.get("type") != "null")
    if "enum" in entry or "const" in entry:
        values = ", ".join(f"`{json.dumps(value)}`" for value in entry.get("enum", [entry.get("const")]))
        return f"any of {values}" if several else values
    if entry["type"] == "boolean":
        return "`true` or `false`"
    if entry["type"] == "string":
        return "text"
    if entry["type"] == "array":
        fixed = entry.get("prefixItems")
        number, items = (f"{len(fixed)} ", fixed[0]) if fixed else ("", entry["items"])
        return f"list{'s' * several} of {number}{_type(items, several=True)}"
    bounds = [
        f"{sign} {entry[key]:g}"
        for key, sign in (("exclusiveMinimum", ">"), ("minimum", "≥"), ("exclusiveMaximum", "<"), ("maximum", "≤"))
        if key in entry
    ]
    name = "whole number" if entry["type"] == "integer" else "number"
    return f"{name}{'s' * several} {' and '.join(bounds)}".strip()


def scene_schema() -> str:
    """The JSON Schema (draft 2020-12) of scenes, by which editors check and complete their files."""
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "$comment": NOTICE}
    schema = head | Scene.model_json_schema() | {"description": _text(Scene)}
    return json.dumps(schema, indent=1, ensure_ascii=False) + "\n"
