"""`import incsvr` for people who write Python: the functions that the commands call, with keywords."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any

import numpy as np

import incsvr
from incsvr.errors import BadInput
from incsvr.plant.axes import AXES
from service.cli.parser import REMOVED, meant, one_of
from service.config.sources import read as read_config
from service.config.sources import set_values
from service.fitting import compare as of_dives
from service.fitting import fit as of_axis
from service.fitting import identify as of_vehicle
from service.fitting import trace as of_effects
from service.fitting.live import Live, of_range
from service.fitting.log import Log, each_log, sources
from service.fitting.request import POLICIES, Request
from service.fitting.spoken import in_python
from service.inputs.presets import NAMES
from service.logs.cutting import instant

LOG_KEYWORDS = tuple(incsvr.Reading.__annotations__)
WHOLE_KEYWORDS = tuple(incsvr.Whole.__annotations__)
FUNCTIONS: Mapping[str, tuple[Callable[[Request], Any], Collection[str]]] = {
    "fit": (of_axis.fit, (*incsvr.Learning.__annotations__, "axis", "inertia")),
    "trace": (of_effects.trace, (*incsvr.Declared.__annotations__, "axis", "inertia")),
    "identify": (of_vehicle.identify, (*WHOLE_KEYWORDS, "vehicle", "name")),
    "compare": (of_dives.compare, WHOLE_KEYWORDS),
}
"""The functions by name, each with its keywords beside the logs."""
ELSEWHERE = {
    "json": "the result has to_dict()",
    "report": "the result has plot(); the command writes reports",
    "write": "the result has write()",
    "table": "the result has to_frame()",
}
"""What is a flag of a command and no keyword."""
CHOICES: Mapping[str, Collection[str]] = {
    "axis": tuple(AXES),
    "policy": POLICIES,
    "preset": NAMES,
}


def read(log: Any, keywords: Mapping[str, Any]) -> Log:
    """A log as a recording."""
    with in_python():
        return Log.read(_request("read", (*LOG_KEYWORDS, "axis"), log, (), keywords), {**keywords})


def call(function: str, logs: Any, validate: Any, keywords: Mapping[str, Any]) -> Any:
    """The result of one of the FUNCTIONS over logs, by keywords."""
    with in_python():
        run, takes = FUNCTIONS[function]
        return run(_request(function, takes, logs, validate, keywords))


def live(
    inertia: float | None,
    rate_range: float | tuple[float, float] | None,
    axis: str | None,
    config: Any,
    vehicle: Any,
    values: Mapping[str, Any],
) -> Live:
    """The learner of `serve` by keywords; `values` are those of the configuration."""
    with in_python():
        said: dict[str, Any] = {}
        if inertia is not None:
            said["vehicle.inertia"] = inertia
        if axis is not None:
            said["vehicle.axis"] = _converted("axis", axis)
        if rate_range is not None:
            if inertia is None:
                raise BadInput("rate_range scales the learner by the inertia; give --inertia I as well")
            span = (-rate_range, rate_range) if isinstance(rate_range, int | float) else rate_range
            said |= of_range(inertia, span)
        flags, origin = set_values(_set({**said, **values}))
        of_file = None if vehicle is None else Path(vehicle)
        if of_file is not None:
            flags.get("vehicle", {}).pop("axis", None)  # it chooses one of the file's learners
        every = read_config(None if config is None else Path(config), flags, origin, of_file)
        return Live(every.of_axis(axis))


def _request(function: str, takes: Collection[str], logs: Any, validate: Any, keywords: Mapping[str, Any]) -> Request:
    """The request that a call makes.

    Raises:
        BadInput: a keyword is none of those that the function `takes`, or has a value that it cannot have.
    """
    read_by = [each.how for each in (*each_log(logs), *each_log(validate)) if isinstance(each, Log)]
    if any(how != read_by[0] for how in read_by):
        raise BadInput("the logs were read with different keywords; read all of them alike")
    given = {**(read_by[0] if read_by else {}), **keywords}
    for each in given:
        _refuse_keyword(function, takes, each)
    recordings = sources("dives" if function == "compare" else "log", logs)
    if not recordings:
        raise BadInput(f"{function} needs a log: a file, arrays, a DataFrame, what read returned, or several")
    said = {each: _converted(each, value) for each, value in given.items() if value is not None}
    return Request(recordings, sources("validate", validate), **said)


def _refuse_keyword(function: str, takes: Collection[str], name: str) -> None:
    if name in takes:
        return
    if instead := REMOVED.get((function, f"--{name.replace('_', '-')}")):
        raise BadInput(f"{name} was removed; {instead}")
    if name in ELSEWHERE:
        raise BadInput(f"{function} takes no {name} in Python; {ELSEWHERE[name]}")
    raise BadInput(f"{function} takes no {name}{meant(name, takes)}; it takes {one_of(tuple(takes))}")


def _converted(name: str, value: Any) -> Any:
    """The value of a keyword as a request has it."""
    choices = CHOICES.get(name, (value,))
    if value not in choices:
        raise BadInput(f"{name} is {value}{meant(str(value), choices)}; it is {one_of(tuple(choices))}")
    return CONVERSIONS.get(name, str)(value)


def _texts(value: Any) -> tuple[str, ...]:
    return (value,) if isinstance(value, str) else tuple(value)


def _instant(value: Any) -> Any:
    try:
        return instant(str(value))
    except argparse.ArgumentTypeError as error:
        raise BadInput(f"a cut cannot be used: {error}") from None


def _set(value: Any) -> tuple[str, ...]:
    if isinstance(value, Mapping):
        return tuple(f"{key}={_written(key, each)}" for key, each in value.items())
    return _texts(value)


def _written(key: str, value: Any) -> str:
    """A value of the configuration as the command line takes it: a text as it is, all else as JSON."""
    if isinstance(value, str):
        return value
    try:
        return json.dumps(np.asarray(value).tolist())
    except (TypeError, ValueError):
        raise BadInput(f"{key}: give a text, a number, or a list or an array of them") from None


CONVERSIONS: Mapping[str, Callable[[Any], Any]] = {
    **dict.fromkeys(("config", "vehicle", "effects"), Path),
    **dict.fromkeys(("cut_from", "cut_to"), _instant),
    "column": _texts,
    "set": _set,
    "assume_sign": bool,
}
"""How a keyword's value becomes that of a request; others become texts, as at a command line."""
