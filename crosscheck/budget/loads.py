"""How much there is to do in a case: the runs of the engine under judgement, by particles and steps or events.

The numbers were counted with the engines that come with the suite, and are kept in `loads.jsonl`, a line a case:
`python -m crosscheck.budget [PATTERN ...]` counts again. They do not depend on the machine, but for what is called
`elsewhere`. A case that is not in the file, such as that of a scheme of another engine, is taken to be as large as the
largest one of its check.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import files
from typing import NamedTuple

from crosscheck.engines.capabilities import schemes_for
from crosscheck.engines.protocol import Engine

#: Beside this module, and part of the package.
FILE = "loads.jsonl"


class Load(NamedTuple):
    """Runs of scenes of one interaction and size, moved by schemes of one kind.

    interaction: name of the table. kind: of the schemes. size: number of particles, or of sites of a lattice, as one of
    `SIZES`. schemes: how many schemes of the counted engine took part. runs: their number. units: in all runs, time
    steps, and one more for the forces at the start; of event-driven hard spheres collisions, of pairs and with walls;
    of a lattice gas steps times sites.
    """

    interaction: str
    kind: str
    size: int
    schemes: int
    runs: int
    units: int


class CaseLoad(NamedTuple):
    """What a case consists of.

    engine: that it was counted with. loads: its runs. elsewhere: seconds of reference engines and of the analysis, on
    the machine that counted: rough.
    """

    engine: str
    loads: tuple[Load, ...]
    elsewhere: float


#: Sizes are told apart by a quarter of an octave: what an engine takes for a step is known no better.
SIZES = tuple(sorted({round(2 ** (quarter / 4)) for quarter in range(100)}))


def rounded_size(size: int) -> int:
    """The one of `SIZES` that is nearest to a number of particles or sites, `size`, by their ratio."""
    return min(SIZES, key=lambda one: max(one, size, 1) / min(one, max(size, 1)))


@cache
def table() -> Mapping[str, CaseLoad]:
    """What was counted, by the name of the case, `group/phenomenon/variant`."""
    text = files("crosscheck.budget").joinpath(FILE).read_text(encoding="utf-8")
    return dict(as_case(line) for line in text.splitlines())


def as_line(case: str, load: CaseLoad) -> str:
    """The line of the file for a case. case: its name. load: what it consists of."""
    entries = {"case": case, "engine": load.engine, "elsewhere": load.elsewhere, "loads": load.loads}
    return json.dumps(entries)


def as_case(line: str) -> tuple[str, CaseLoad]:
    """The name of the case in a line of the file, and what it consists of."""
    entries = json.loads(line)
    loads = tuple(Load(*one) for one in entries["loads"])
    return entries["case"], CaseLoad(entries["engine"], loads, entries["elsewhere"])


def load_of(check: str, variant: str) -> CaseLoad | None:
    """What a case consists of; None if neither it nor another case of its check was counted.

    check, variant: their names.
    """
    known = table().get(f"{check}/{variant}")
    if known is not None:
        return known
    others = [load for name, load in table().items() if name.startswith(f"{check}/")]
    return max(others, key=lambda load: sum(one.units * one.size for one in load.loads), default=None)


def share(load: Load, engine: type[Engine]) -> float:
    """Which share of the counted runs an engine has that may have fewer schemes of the kind; 1 at most.

    load: of a check that runs all schemes that there are. engine: its class.
    """
    own = len(schemes_for(engine, load.interaction, load.kind))
    return min(1.0, own / load.schemes) if load.schemes else 1.0


def classes(loads: Sequence[Load]) -> set[tuple[str, str]]:
    """The interactions, with the kind of scheme, of these `loads`."""
    return {(one.interaction, one.kind) for one in loads}
