"""The form of a line of the record: what `record.read` accepts, so that nobody who reads its lines meets another one.

Declared a second time, beside the dataclasses that lines are written from: a record comes from a file, which may be
damaged, edited, or of another version. Fields that are not known are left alone. See docs/record.md.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Annotated, Any, Literal, NoReturn, NotRequired, get_args, get_origin, get_type_hints

from pydantic import AfterValidator, Discriminator, Field, Tag, TypeAdapter, ValidationError
from typing_extensions import TypedDict, is_typeddict

from crosscheck.text import shortened
from crosscheck.verdict import Kind, Outcome, Sense

_Finite = Annotated[float, Field(allow_inf_nan=False)]
#: A number, or null where it was not finite.
Number = _Finite | None
#: Whole numbers of more digits are read as floating-point numbers, which may be too large.
_DIGITS = 18
#: Sizes of a container that can be drawn: squares and ratios are finite.
_SMALLEST, _LARGEST = 1e-150, 1e150


class _Series(TypedDict):
    label: str
    x: list[Number]
    y: list[Number]
    theory: bool
    error: NotRequired[list[Number] | None]
    bins: NotRequired[bool]


class _Frame(TypedDict):
    shape: Literal["box"]
    left: _Finite
    right: _Finite
    bottom: _Finite
    top: _Finite
    walls: list[Literal["left", "right", "bottom", "top"]]


class _RoundFrame(TypedDict):
    shape: Literal["drum"]
    x: _Finite
    y: _Finite
    radius: _Finite


def _drawable(container: dict[str, Any]) -> dict[str, Any]:
    if container["shape"] == "drum":
        sizes, places = [container["radius"]], [container["x"], container["y"]]
    else:
        places = [container[side] for side in ("left", "right", "bottom", "top")]
        sizes = [places[1] - places[0], places[3] - places[2]]
    if not all(_SMALLEST < size < _LARGEST for size in sizes) or any(abs(place) > _LARGEST for place in places):
        raise ValueError("a container needs an inside that can be drawn")
    return container


def _shape(container: Any) -> str | None:
    shape = container.get("shape") if isinstance(container, dict) else None
    return shape if shape in ("box", "drum") else None


_Container = Annotated[
    Annotated[_Frame, Tag("box")] | Annotated[_RoundFrame, Tag("drum")],
    Discriminator(_shape),
    AfterValidator(_drawable),
]


def _rising(limits: list[float]) -> list[float]:
    if not limits[0] < limits[1]:
        raise ValueError("limits must rise")
    return limits


_Limits = Annotated[list[_Finite], Field(min_length=2, max_length=2), AfterValidator(_rising)] | None


class _Snapshot(TypedDict):
    x: list[Number]
    y: list[Number]
    radius: list[Number] | Number
    container: _Container
    value: list[Number] | None
    value_label: str
    limits: _Limits


def _same_numbers(snapshot: dict[str, Any]) -> dict[str, Any]:
    lists = [snapshot[name] for name in ("x", "y", "radius", "value") if isinstance(snapshot[name], list)]
    if len({len(one) for one in lists}) > 1:
        raise ValueError("x, y, radius and value differ in length")
    return snapshot


def _rectangle(rows: list[list[Number]]) -> list[list[Number]]:
    if len({len(row) for row in rows}) > 1:
        raise ValueError("the rows of a grid differ in length")
    return rows


_Grid = Annotated[list[list[Number]], AfterValidator(_rectangle)]


def _same_lengths(series: dict[str, Any]) -> dict[str, Any]:
    places, values, error = len(series["x"]), len(series["y"]), series.get("error")
    if values != places - bool(series.get("bins")) or (error is not None and len(error) != values):
        raise ValueError("x, y and error differ in length")
    return series


class _Map(TypedDict):
    values: _Grid
    container: _Container
    value_label: str
    limits: _Limits
    arrows: Annotated[list[_Grid], Field(min_length=2, max_length=2)] | None
    arrow_label: str
    lines: NotRequired[list[Annotated[_Series, AfterValidator(_same_lengths)]]]


def _same_grids(field: dict[str, Any]) -> dict[str, Any]:
    u, v = field["arrows"] or ([], [])
    if [len(row) for row in u] != [len(row) for row in v]:
        raise ValueError("the components of the arrows differ in shape")
    return field


class _Ladder(TypedDict):
    label: str
    family: str
    control: str
    controls: list[Number]
    error: list[Number]
    uncertainty: list[Number]
    cpu: list[Number]
    cpu_low: list[Number]
    cpu_high: list[Number]
    count: list[Number]
    count_label: str
    failures: list[str]


def _same_rungs(ladder: dict[str, Any]) -> dict[str, Any]:
    lists = [one for name, one in ladder.items() if isinstance(one, list) and not (name == "count" and not one)]
    if len({len(one) for one in lists}) > 1:
        raise ValueError("the lists of a ladder differ in length")
    return ladder


class _Figure(TypedDict):
    title: str
    x_label: str
    y_label: str
    x_scale: Literal["linear", "log"]
    y_scale: Literal["linear", "log"]
    series: list[Annotated[_Series, AfterValidator(_same_lengths)]]
    snapshot: NotRequired[Annotated[_Snapshot, AfterValidator(_same_numbers)] | None]
    map: NotRequired[Annotated[_Map, AfterValidator(_same_grids)] | None]
    ladder: NotRequired[Annotated[_Ladder, AfterValidator(_same_rungs)] | None]


class _Criterion(TypedDict):
    kind: Kind
    sense: Sense
    tolerance: Number
    why: str


class _Judgement(TypedDict):
    outcome: Literal["pass", "fail", "inconclusive"]
    quantity: str
    measured: Number
    uncertainty: Number
    expected: Number
    expected_uncertainty: Number
    deviation: Number
    sensitivity: Number
    criterion: _Criterion
    sigmas: Number
    freedom: NotRequired[Number]
    doubt: NotRequired[Number]
    p_value: NotRequired[Number]
    false_alarm: NotRequired[Number]
    control: bool
    note: str


class _Provenance(TypedDict):
    seed: int
    versions: NotRequired[dict[str, str]]
    cpu: NotRequired[str]
    cores: NotRequired[int]
    system: NotRequired[str]
    command: NotRequired[str]


class _Common(TypedDict):
    """What lines of both schemas hold."""

    schema: int
    check: str
    engine: str
    outcome: Outcome
    note: str
    figures: list[_Figure]
    message: str
    cost: dict[str, Number]
    time: str
    provenance: _Provenance


class _Line(_Common):
    variant: str
    tier: Literal["small", "quick", "full"]
    judgements: list[_Judgement]
    worst: int | None
    refused: NotRequired[int | None]


class _OldCriterion(TypedDict):
    kind: Kind
    tolerance: Number
    why: str


class _OldLine(_Common):
    quantity: str | None
    measured: Number
    uncertainty: Number
    expected: Number
    expected_uncertainty: Number
    deviation: Number
    deviation_unit: str | None
    sensitivity: Number
    criterion: _OldCriterion | None


_FORMS: dict[int, TypeAdapter[Any]] = {1: TypeAdapter(_OldLine), 2: TypeAdapter(_Line)}


def leaves() -> dict[str, type]:
    """The fields of a line and of its judgements that hold one value, by their paths, with their types.

    A path has the names joined by dots, as "judgements.criterion.kind"; "cost.*" stands for every name in `cost`. The
    types are str, bool, int, and float for a number; any may be null. What figures hold is left out.
    """
    return dict(_leaves(_Line, ""))


def _leaves(form: Any, path: str) -> Iterator[tuple[str, type]]:
    kinds = [kind for kind in get_args(form) if kind is not type(None)]
    if is_typeddict(form):
        for name, kind in get_type_hints(form).items():
            yield from _leaves(kind, f"{path}.{name}".removeprefix("."))
    elif get_origin(form) is list:
        if kinds[0] is not _Figure:
            yield from _leaves(kinds[0], path)
    elif get_origin(form) is dict:
        yield from _leaves(kinds[1], f"{path}.*")
    elif get_origin(form) is Literal:
        yield path, str
    elif kinds:  # with null
        yield from _leaves(kinds[0], path)
    else:
        yield path, form


def parse(text: str) -> dict[str, Any]:
    """The object in a line of JSON; ValueError, with a reason in words, if it is not one.

    text: the line. Refused are also numbers that JSON does not have (NaN), and an object with two entries of one name.
    """
    try:
        line = json.loads(text, parse_constant=_no_number, parse_int=_whole, object_pairs_hook=_entries)
    except json.JSONDecodeError as error:
        raise ValueError(f"not JSON ({error.msg}, column {error.colno})") from None
    except RecursionError:
        raise ValueError("nested too deeply") from None
    if not isinstance(line, dict):
        raise ValueError("not an object")
    return line


def check_form(line: dict[str, Any], schema: int) -> None:
    """ValueError, which names the first field that is missing or wrong, unless a line has the form of its schema.

    line: as JSON holds it. schema: 1 or 2.
    """
    try:
        _FORMS[schema].validate_python(line, strict=True)
    except ValidationError as error:
        raise ValueError(_in_words(error)) from None
    except RecursionError:
        raise ValueError("nested too deeply") from None
    if schema == 1:
        return
    judgements, worst, outcome = line["judgements"], line["worst"], line["outcome"]
    if outcome in ("skip", "error"):
        if judgements or worst is not None:
            raise ValueError(f"a verdict '{outcome}' has no judgements, and 'worst' is null")
    elif worst is None or not 0 <= worst < len(judgements):
        raise ValueError("'worst' is not the index of a judgement")
    elif judgements[worst]["outcome"] != outcome:
        raise ValueError("'outcome' is not that of the judgement 'worst'")


def _in_words(error: ValidationError) -> str:
    """The first of the errors: the path of the field, and what is wrong with it."""
    first = error.errors(include_url=False, include_context=False, include_input=False)[0]
    # an entry that may be of several types has the type at the end of its path
    path = ".".join(str(key) for key in first["loc"] if str(key).isidentifier() or isinstance(key, int))
    if first["type"] == "missing":
        return f"'{path}' is missing"
    return f"'{shortened(path)}': {shortened(first['msg'].removeprefix('Value error, '), 200)}"


def _no_number(token: str) -> NoReturn:
    raise ValueError(f"{token} is no number in JSON: what is not finite is null")


def _whole(digits: str) -> float:
    return int(digits) if len(digits) <= _DIGITS else float(digits)


def _entries(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    entries = dict(pairs)
    if len(entries) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"'{shortened(twice)}' is there twice")
    return entries
