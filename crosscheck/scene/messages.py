"""What is wrong with a file, in words: the path of the key, what was found, and the mend."""

from __future__ import annotations

import difflib

from pydantic import ValidationError

from crosscheck.scene.parts import (
    Box,
    Contact,
    Cylinder,
    Explicit,
    Face,
    File,
    Friction,
    GrainFriction,
    Gravity,
    HardSpheres,
    Kepler,
    Lattice,
    LatticeGas,
    LennardJones,
    Method,
    Obstacle,
    Occupations,
    Oscillation,
    Output,
    Part,
    RandomPhase,
    Spring,
    Wall,
    Wave,
    Well,
)

_PARTS: dict[str, type[Part]] = {
    "box": Box,
    "wall": Wall,
    "spring": Spring,
    "gravity": Gravity,
    "lennard_jones": LennardJones,
    "hard_spheres": HardSpheres,
    "hard_spheres.friction": GrainFriction,
    "friction": Friction,
    "well": Well,
    "faces": Face,
    "random_phase": RandomPhase,
    "oscillation": Oscillation,
    "cylinder": Cylinder,
    "lattice_gas": LatticeGas,
    "obstacles": Obstacle,
    "waves": Wave,
    "output": Output,
    "method": Method,
    "contact": Contact,
}
_KINDS: dict[str, type[Part]] = {
    "explicit": Explicit,
    "lattice": Lattice,
    "kepler": Kepler,
    "file": File,
    "occupations": Occupations,
}
#: How pydantic names the forms of "one value, or one per particle" in the place of an error.
_FORMS = ("constrained-float", "tuple[constrained-float, ...]", "float", "tuple[float, ...]")


def explain(error: ValidationError, where: str, scene: type[Part]) -> str:
    """A line for every mistake: the path of the key, what is wrong with it, and the mend."""
    lines: list[str] = []
    meant: set[str] = set()
    # unknown keys first: a key that is misspelt is not missing as well
    for problem in sorted(error.errors(), key=lambda problem: problem["type"] != "extra_forbidden"):
        place, kind, found = problem["loc"], problem["type"], problem["input"]
        # of "one value, or one per particle", the form that was not given has nothing to say
        last = place[-1] if place else ""
        if last in _FORMS[1::2] or (last in _FORMS[::2] and isinstance(found, list | tuple)):
            continue
        keys = [str(part) for part in place if part not in (*_KINDS, *_FORMS)]
        path = ".".join(keys)
        if kind == "extra_forbidden":
            near, hint = _hint(str(place[-1]), [part for part in place[:-1] if isinstance(part, str)], scene)
            meant.add(".".join([*keys[:-1], near]))
            lines.append(f"unknown key '{path}'; {hint}")
        elif kind == "missing":
            if path not in meant:
                lines.append(f"'{path}' is missing: add it")
        elif kind == "union_tag_not_found":
            lines.append(f"'{path}.kind' is missing: add it, one of {', '.join(_KINDS)}")
        elif kind == "union_tag_invalid":
            lines.append(f"{path}.kind: Input should be one of {', '.join(_KINDS)} (found {problem['ctx']['tag']!r})")
        else:
            message = problem["msg"].removeprefix("Value error, ")
            value = f" (found {found!r})" if path and isinstance(found, str | int | float | bool) else ""
            lines.append(f"{path + ': ' if path else ''}{message}{value}")
    return "\n".join(f"{where}: {line}" for line in dict.fromkeys(lines))


def _hint(key: str, place: list[str], scene: type[Part]) -> tuple[str, str]:
    """The key that was meant, if there is one near in the table at this place, and what to do."""
    parts = {**_PARTS, **_KINDS}
    table = "faces" if place[-2:-1] == ["faces"] else ".".join(place[-2:])
    part = parts.get(table) or parts.get("".join(place[-1:]), scene)
    near = difflib.get_close_matches(key, part.model_fields, 1)
    if near:
        return near[0], f"did you mean '{near[0]}'?"
    owners = [f"[{name}]" for name, other in _PARTS.items() if key in other.model_fields]
    if key in scene.model_fields:
        owners.append("the scene itself, above the first table")
    return "", f"it belongs in {' or '.join(owners)}" if owners else "remove it"
