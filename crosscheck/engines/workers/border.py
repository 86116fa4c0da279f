"""The border between an engine and the suite: everything that an engine has or returns is checked here.

The worker checks, and converts to plain Python and to arrays of float64; the suite checks again what arrives, since an
engine can change any code in its own process. A misfit blames the engine and says what it gave, in few words.
"""

from __future__ import annotations

import math
import reprlib
from collections.abc import Mapping
from dataclasses import fields
from numbers import Real
from typing import Any, get_args

import numpy as np

from crosscheck.engines.capabilities import Capability
from crosscheck.engines.protocol import Claims, Cost, Engine, Kind, Run, sample_times, shapes
from crosscheck.scene import Floats, Method, Scene
from crosscheck.scene.observables import TABLE
from crosscheck.scene.parts import INTERACTIONS

#: Longest text of an engine that is kept: a version, and a reason, a remark or a message, characters.
LONGEST_VERSION = 200
LONGEST_TEXT = 2000
#: Largest number of remarks of a run.
MOST_REMARKS = 100
#: What an engine may promise, see `docs/engines.md`.
PROMISES = (
    "speed", "long_runs", "interpretable", "operations", "documented_draws", "restarts", "remarks_on_order",
    "remarks_on_contacts", "impulses_after_steps", "springs_turned_at_walls", "cut_to_the_scene",
)  # fmt: skip
#: Largest cost that is believed: 30 years in seconds, and what a signed 64-bit integer holds.
_LONGEST_TIME = 1e9
_LARGEST_COUNT = 2**63 - 1
#: Relative error of the times of samples: as close as a dt must divide the duration (`Scene.steps`); more only where
#: steps are added up one by one, each of which may add one unit of round-off.
_SAME_TIME = 1e-9

_REPR = reprlib.Repr()
_REPR.maxother = _REPR.maxstring = 80


class Misfit(Exception):
    """What an engine has or returns is not what the protocol asks for; the message says what it is and should be."""


# -- texts -------------------------------------------------------------------------------------------------------


def shown(value: object) -> str:
    """A value in at most 100 characters for a message, whatever its own `repr` does."""
    try:
        return capped(_REPR.repr(value), 100)
    except BaseException:
        return f"<{type(value).__name__}>"


def capped(text: str, longest: int = LONGEST_TEXT) -> str:
    """The text with at most `longest` characters; what no file can hold (lone surrogates) becomes a question mark."""
    whole = text if len(text) <= longest else f"{text[:longest]} ... ({len(text)} characters)"
    return whole.encode(errors="replace").decode()


def described(error: BaseException) -> str:
    """Type and message of the exception `error`, capped, whatever its own `str` does."""
    try:
        return f"{type(error).__name__}: {capped(str(error))}"
    except BaseException:
        return f"{type(error).__name__} (whose text cannot be had)"


def _text(value: object, what: str, mend: str, longest: int = LONGEST_TEXT) -> str:
    """The value, if it is a text that is not blank; Misfit otherwise. what: what has it. mend: what it should be."""
    if not isinstance(value, str) or not value.strip():
        raise Misfit(f"{what} {shown(value)}: {mend}")
    return capped(str(value), longest)


def version(value: object) -> str:
    """What `Engine.version` returned, as a text. value: as it came; Misfit if it is no text or blank."""
    return _text(value, "version() returned", "return a text that is not empty", LONGEST_VERSION)


def reason(value: object) -> str | None:
    """What `Engine.supports` returned. value: as it came; Misfit if it is neither None nor a text that is not blank."""
    mend = "return None if it can run the scene, or why not, as a text"
    return None if value is None else _text(value, "supports() returned", mend)


# -- declarations ------------------------------------------------------------------------------------------------


def declarations(engine: type[Engine]) -> dict[str, Any]:
    """What the class of an engine declares, as plain values for `declared`; Misfit if it is not what it should be."""
    for member in ("name", "schemes", "capabilities", "version", "supports", "run"):
        if not hasattr(engine, member):
            raise Misfit(f"class {engine.__name__} lacks '{member}' (see docs/engines.md)")
    name = _text(engine.name, "name is", "give it a short text", LONGEST_VERSION)
    for member in ("version", "supports", "run"):
        if not callable(getattr(engine, member)):
            raise Misfit(f"{member} is {shown(getattr(engine, member))}: make it a method")
    schemes = engine.schemes
    if not isinstance(schemes, dict) or not schemes:
        raise Misfit(f"schemes is {shown(schemes)}: give a dict of at least one name -> Claims(...)")
    claims = {_text(key, "a name in schemes is", "give a text"): _claims(key, one) for key, one in schemes.items()}
    capabilities = engine.capabilities
    if not isinstance(capabilities, tuple) or not capabilities:
        raise Misfit(f"capabilities is {shown(capabilities)}: give a tuple of at least one capability(...)")
    promises = getattr(engine, "promises", ())
    if not isinstance(promises, tuple) or not all(isinstance(one, str) and one in PROMISES for one in promises):
        raise Misfit(f"promises is {shown(promises)}: give a tuple of names out of {', '.join(PROMISES)}")
    return {
        "name": name,
        "schemes": claims,
        "capabilities": [_capability(one, claims) for one in capabilities],
        "promises": list(promises),
    }


def _claims(name: object, claims: object) -> dict[str, Any]:
    what = f"schemes[{shown(name)}]"
    if not isinstance(claims, Claims):
        raise Misfit(f"{what} is {shown(claims)}: give Claims(...) of crosscheck.engines.protocol")
    values: dict[str, Any] = {"kind": claims.kind}
    if not isinstance(claims.kind, str) or claims.kind not in get_args(Kind):
        raise Misfit(f"{what}: kind is {shown(claims.kind)}: give one of {', '.join(get_args(Kind))}")
    for entry in ("order", "order_damped"):
        order = getattr(claims, entry)
        if order is not None and not (
            isinstance(order, tuple)
            and len(order) == 2
            and all(isinstance(one, int | np.integer) and one is not True and 0 < one < 100 for one in order)
        ):
            raise Misfit(f"{what}: {entry} is {shown(order)}: give two whole numbers (position, velocity), or None")
        values[entry] = None if order is None else [int(one) for one in order]
    for entry in ("symplectic", "reversible"):
        claim = getattr(claims, entry)
        if claim is not None and not isinstance(claim, bool | np.bool_):
            raise Misfit(f"{what}: {entry} is {shown(claim)}: give True, False or None")
        values[entry] = None if claim is None else bool(claim)
    return values


def _capability(one: object, claims: Mapping[str, dict[str, Any]]) -> dict[str, Any]:
    if not isinstance(one, Capability):
        raise Misfit(f"capabilities holds {shown(one)}: give capability(...) of crosscheck.engines.capabilities")
    what = f"capability for [{shown(one.interaction)[1:-1]}]"
    if not isinstance(one.interaction, str) or one.interaction not in INTERACTIONS:
        raise Misfit(f"{what}: there is no such interaction: give one of {', '.join(INTERACTIONS)}")
    if not isinstance(one.kind, str) or one.kind not in get_args(Kind):
        raise Misfit(f"{what}: kind is {shown(one.kind)}: give one of {', '.join(get_args(Kind))}")
    values: dict[str, Any] = {"interaction": one.interaction, "kind": one.kind}
    for entry in ("words", "observables"):
        names = getattr(one, entry)
        if not isinstance(names, frozenset) or not all(isinstance(name, str) for name in names):
            raise Misfit(f"{what}: {entry} is {shown(names)}: give a frozenset of names, as capability(...) makes it")
        values[entry] = sorted(names)
    if not isinstance(one.schemes, tuple) or not all(isinstance(name, str) for name in one.schemes):
        raise Misfit(f"{what}: schemes is {shown(one.schemes)}: give a tuple of names")
    unknown = [name for name in one.schemes if name not in claims]
    if unknown:
        raise Misfit(f"{what}: schemes names {shown(unknown[0])}, which is not in the engine's schemes")
    if not one.schemes and all(claim["kind"] != one.kind for claim in claims.values()):
        raise Misfit(f"{what}: kind is '{one.kind}', and none of the engine's schemes is of that kind")
    return values | {"schemes": list(one.schemes)}


def declared(values: Mapping[str, Any]) -> type[Engine]:
    """A class with the attributes of an engine and none of its code. values: what `declarations` gave."""
    orders = ("order", "order_damped")
    schemes = {
        name: Claims(**claims | {key: claims[key] and tuple(claims[key]) for key in orders})
        for name, claims in values["schemes"].items()
    }
    capabilities = tuple(
        Capability(
            one["interaction"],
            one["kind"],
            frozenset(one["words"]),
            frozenset(one["observables"]),
            tuple(one["schemes"]),
        )
        for one in values["capabilities"]
    )
    attributes = {"name": values["name"], "schemes": schemes, "capabilities": capabilities}
    return type("Declared", (), attributes | {"promises": tuple(values["promises"])})


# -- runs --------------------------------------------------------------------------------------------------------


def outcome(run: object) -> tuple[dict[str, Any], dict[str, Any]]:
    """What `Engine.run` returned: its arrays as they are, and the rest as plain values.

    Misfit if it is not a `Run`, or if a value has the wrong type or size.
    """
    if not isinstance(run, Run):
        raise Misfit(f"run() returned {shown(run)}: return a Run of crosscheck.engines.protocol")
    values = {name: getattr(run, name, None) for name in ("diverged", "stopped", "cost", "remarks")}
    if not isinstance(values["diverged"], bool | np.bool_):
        raise Misfit(f"run.diverged is {shown(values['diverged'])}: give True or False")
    stopped = values["stopped"]
    if not isinstance(stopped, str) or (stopped and not stopped.strip()):
        raise Misfit(f"run.stopped is {shown(stopped)}: say why it ended before its time, or '' if it did not")
    remarks = values["remarks"]
    if not isinstance(remarks, tuple | list) or len(remarks) > MOST_REMARKS:
        raise Misfit(f"run.remarks is {shown(remarks)}: give a list of at most {MOST_REMARKS} sentences")
    return dict(dict.items(run)), {
        "diverged": bool(values["diverged"]),
        "stopped": capped(str(stopped)),
        "cost": cost(values["cost"]).known(),
        "remarks": [_text(one, "run.remarks holds", "give whole sentences") for one in remarks],
    }


def cost(given: object) -> Cost:
    """A cost in plain numbers. given: as it came, numpy's scalars are converted; Misfit for what is no cost."""
    if not isinstance(given, Cost):
        raise Misfit(f"run.cost is {shown(given)}: give a Cost of crosscheck.engines.protocol")
    found: dict[str, Any] = {}
    for entry in fields(Cost):
        value = getattr(given, entry.name)
        if value is None and entry.default is None:
            continue
        whole = entry.type != "float"
        number = isinstance(value, Real) and not isinstance(value, bool | np.bool_)
        if not number or not 0 <= value <= (_LARGEST_COUNT if whole else _LONGEST_TIME) or (whole and value % 1):
            what = "a whole number from 0 to 2^63 - 1" if whole else "seconds from 0 to 1e9"
            raise Misfit(f"run.cost.{entry.name} is {shown(value)}: give {what}")
        found[entry.name] = int(value) if whole else float(value)
    return Cost(**found)


def arrays(
    given: Mapping[str, Any], scene: Scene, method: Method, *, diverged: bool, stopped: str
) -> dict[str, Floats]:
    """The arrays that `scene` asks for, as float64, in the order of the table of observables.

    given: what a run holds; whatever numpy converts to float64 without loss is accepted, and observables that the scene
    did not ask for are left out. method: gives dt. diverged, stopped: of the run. Samples of a run that diverged are
    NaN from the first that holds a number that is not finite, and so is its state at the end.

    Misfit for a missing array, an unknown name, another shape or type, times that the scene does not ask for, numbers
    that are not finite though the run went well, and samples up to the end though it did not.
    """
    times = sample_times(scene, method)
    if "time" in given:
        time = _float64("time", given["time"])
        if time.ndim == 1 and time.size != times.size:
            raise Misfit(f"run['time'] has {time.size} samples, the scene asks for {times.size}")
    found = {}
    events = np.size(given["event_times"]) if "event_times" in given else 0
    for name, shape in shapes(scene, times.size, events).items():
        array = _float64(name, given[name]) if name in given else None
        if array is None or array.shape != shape:
            returned = "nothing" if array is None else f"shape {array.shape}"
            raise Misfit(f"run['{name}'] must have shape {shape}, found {returned}")
        found[name] = array
    unknown = [name for name in given if name not in TABLE]
    if unknown:
        raise Misfit(f"run holds {shown(unknown[0])}, which is no observable (docs/reference/observables.md)")
    _check_times(found["time"], times, scene, method, ended_early=diverged or bool(stopped))
    sampled = {name for name in found if "sample" in TABLE[name].axes}
    if diverged:
        return _diverged(found, sampled, at_end=_reaches_end(times, scene))
    _check_finite(found, sampled, stopped)
    whole = all(np.isfinite(found[name][-1]).all() for name in sampled)
    if stopped and whole and sampled != {"time"} and _reaches_end(times, scene):
        raise Misfit(f"run.stopped is {shown(stopped)}, yet no sample up to the end is NaN: give NaN from then on")
    return found


def _float64(name: str, value: Any) -> Floats:
    """The value as an array of float64; Misfit if that is not possible without loss."""
    what = f"run['{name}']"
    if isinstance(value, np.ndarray) and not isinstance(value, np.memmap) and type(value) is not np.ndarray:
        raise Misfit(f"{what} is a {type(value).__name__}: give a plain numpy array")
    try:
        array = np.asarray(value)
    except Exception as error:
        raise Misfit(f"{what} is {shown(value)}, no array of numbers ({described(error)})") from None
    if array.dtype.kind not in "fiu":
        raise Misfit(f"{what} holds {array.dtype} in place of float64: {shown(value)}")
    converted = array.astype(np.float64, copy=False)
    if array.dtype.itemsize >= 8 and array.dtype.kind in "iu" and (abs(converted) >= 2.0**53).any():
        raise Misfit(f"{what} holds integers of 2^53 and more, which float64 does not hold")
    if array.dtype.itemsize > 8 and not np.array_equal(converted, array, equal_nan=True):
        raise Misfit(f"{what} holds {array.dtype}, which float64 does not hold: round it to float64")
    return np.asarray(converted)


def _check_times(time: Floats, asked: Floats, scene: Scene, method: Method, *, ended_early: bool) -> None:
    """Misfit if the times are not those that the scene asks for; NaN may stand at the end of a run that ended early."""
    good = np.isfinite(time)
    until = time.size if good.all() else int(np.argmin(good))
    if until < time.size and (not ended_early or good[until:].any() or np.isinf(time).any()):
        raise Misfit(f"run['time'][{until}] is {time[until]}: give the times of all samples that there are")
    steps = 0 if method.dt is None else round(scene.duration / method.dt)
    slack = scene.duration * max(_SAME_TIME, 2 * steps * float(np.finfo(np.float64).eps))
    known = good & np.isfinite(asked)
    wrong = np.flatnonzero(known & (abs(time - asked) > slack))
    if wrong.size:
        at = wrong[0]
        raise Misfit(f"run['time'][{at}] is {time[at]:.17g}, the scene asks for {asked[at]:.17g}")
    backwards = np.flatnonzero(np.diff(time[:until]) < 0)
    if backwards.size:
        raise Misfit(f"run['time'] goes backwards after sample {backwards[0]}")
    if until and time[until - 1] > scene.duration + slack:
        raise Misfit(f"run['time'][{until - 1}] is {time[until - 1]:.17g}, after the end at {scene.duration:g}")


def _check_finite(found: Mapping[str, Floats], sampled: set[str], stopped: str) -> None:
    """Misfit for a number that is not finite, but in samples after the end of a run that stopped."""
    for name, array in found.items():
        finite = np.isfinite(array)
        if finite.all():
            continue
        at = [int(one) for one in np.argwhere(~finite)[0]]
        where = f"run['{name}']{at} is {array[tuple(at)]}"
        if not stopped:
            raise Misfit(f"{where}, although the run neither diverged nor stopped: say so, or give a number")
        if name not in sampled:
            raise Misfit(f"{where}: give the state at which the run stopped")
        if any(sample.all() for sample in finite[at[0] :]):
            raise Misfit(f"{where}, with numbers after it: a run that stopped gives NaN from then on")


def _diverged(found: Mapping[str, Floats], sampled: set[str], *, at_end: bool) -> dict[str, Floats]:
    """The arrays of a run that diverged, NaN from there on; Misfit if all samples to its end are finite.

    at_end: whether the last sample is at the end of the run.
    """
    others = sorted(sampled - {"time"})
    first = min(
        (int(np.argwhere(~np.isfinite(found[n]))[0][0]) for n in others if not np.isfinite(found[n]).all()),
        default=None,
    )
    if others and first is None and at_end:
        raise Misfit("run.diverged is True, yet all samples to the end are finite: give NaN from there on")
    after: dict[str, Floats] = {}
    for name, array in found.items():
        after[name] = array.copy()
        if name not in sampled:
            after[name].fill(math.nan)
        elif name != "time" and first is not None:
            after[name][first:] = math.nan
    return after


def _reaches_end(times: Floats, scene: Scene) -> bool:
    """Whether the last sample is at the end of the run: of a run that counts collisions, it always is."""
    return bool(np.isnan(times[-1]) or times[-1] >= scene.duration * (1 - _SAME_TIME))
