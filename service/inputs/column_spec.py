"""The argument `--column NAME=[-][TOPIC.]FIELD[*FACTOR][:UNIT]`; the time of a table is `t=COLUMN:ms`."""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence
from dataclasses import dataclass

from incsvr.errors import BadInput
from incsvr.plant.axes import YAW, Axis
from service.inputs.owners import autopilot_message
from service.inputs.settings import Inputs, Source
from service.inputs.table import ROWS, Topic
from service.inputs.units import FRACTION, STAMP_UNITS, TIME_NAME, check_unit, intended_quantity

_FACTOR = re.compile(r"^(.*?)\s*\*\s*([0-9.]+(?:[eE][+-]?[0-9]+)?)$")
_NAME = re.compile(r"^[A-Za-z0-9_.-]{1,64}$")
COLUMN_EXAMPLE = "write NAME=FIELD, as in yaw_rate=r:deg/s, torque=-tau, depth=baro.depth*0.01 or t=stamp:ms"


@dataclass(frozen=True, slots=True)
class ColumnSpec:
    """One parsed `--column` argument.

    Attributes:
        inputs: the quantities that were named.
        stamp: the field that is the time, if it was named.
        stamp_unit: its unit, if it was named.
    """

    inputs: Inputs
    stamp: str | None = None
    stamp_unit: str | None = None


_OF_FILE = re.compile(r"^([^=]+):([A-Za-z0-9_.-]{1,64}=.*)$")


def split_file(text: str) -> tuple[str, str]:
    """The log that a flag is for, as in `june.csv:torque=-torque`, empty for all, and the rest."""
    found = _OF_FILE.match(text)
    return (found[1], found[2]) if found else ("", text)


def of_this_log(sentence: str, name: str) -> str:
    """A sentence whose flags are those of one log of several."""
    return re.sub(r"--column ('?)(?![^=' ]+:)(?=[A-Za-z0-9_.-]+=)", lambda found: f"{found[0]}{name}:", sentence)


def parse_columns(
    columns: Sequence[str], topics: Sequence[Topic], others: Sequence[Topic] = (), axis: Axis = YAW
) -> ColumnSpec:
    """The mapping that flags name, with topics and fields that are there.

    Args:
        topics: of the vehicle that is taken; those of its autopilot may be named by the message alone.
        others: of vehicles that are left alone; they are named in full.
        axis: whose velocity and effort are learned from.

    Raises:
        BadInput: a flag is not understood, or names what is not there.
    """
    sources: dict[str, Source] = {}
    stamp = stamp_unit = None
    names = [text.partition("=")[0].strip() for text in columns]
    for text in columns:
        name, equals, place = text.partition("=")
        name = name.strip()
        if not (equals and place.strip() and _NAME.match(name)):
            raise BadInput(f"--column {text}: {COLUMN_EXAMPLE}")
        if names.count(name) > 1:
            raise BadInput(f"--column {text}: {name} is given twice; keep one of them")
        wanted = intended_quantity(name, names)
        if wanted is not None:
            raise BadInput(f"--column {text}: there is no quantity {name}; did you mean {wanted}={place.strip()}?")
        place = _in_full(place.strip(), topics)
        scope = [topic for topic in others if place.removeprefix("-").startswith(topic.name)] or topics
        if name == TIME_NAME:
            stamp, stamp_unit = _time(text, place, scope)
        else:
            sources[name] = _source(text, place, scope)
    rate, torque = sources.pop(axis.rate, None), sources.pop(axis.effort, None)
    return ColumnSpec(Inputs(yaw_rate=rate, torque=torque, channels=sources), stamp, stamp_unit)


def typed_source(source: Source) -> str:
    """The text behind `--column NAME=` for a source, without its unit."""
    field = source.field if source.topic == ROWS else f"{source.topic}.{source.field}"
    factor = "" if source.scale == 1.0 else f"*{source.scale:g}"
    return f"{'-' if source.sign < 0 else ''}{field}{factor}"


def typed_source_with_unit(source: Source) -> str:
    """The text behind `--column NAME=` for a source, with its unit."""
    return f"{typed_source(source)}{f':{source.unit}' if source.unit not in ('', FRACTION) else ''}"


def _in_full(place: str, topics: Sequence[Topic]) -> str:
    """A place whose topic is named by its MAVLink message alone, with the topic's own name and path."""
    sign, plain = ("-", place[1:]) if place.startswith("-") else ("", place)
    for topic in topics:
        message = autopilot_message(topic)
        if message is not None and message != topic.name and plain.startswith(f"{message}."):
            path = plain.removeprefix(f"{message}.")
            inside = any(field.startswith("message.") for field in topic.fields) and not path.startswith("message.")
            return f"{sign}{topic.name}.{'message.' if inside else ''}{path}"
    return place


def _time(text: str, place: str, topics: Sequence[Topic]) -> tuple[str, str | None]:
    field, _, unit = (
        place.strip().rpartition(":") if place.rpartition(":")[2] in STAMP_UNITS else (place.strip(), "", "")
    )
    return _place(text, field, topics)[1], unit or None


def _source(text: str, place: str, topics: Sequence[Topic]) -> Source:
    sign = -1 if place.startswith("-") else 1
    field, unit, scale = place.removeprefix("-"), "", 1.0
    try:
        topic, field = _place(text, field, topics)  # as it stands: names of columns hold colons and stars, too
    except BadInput:
        field, colon, spelt = field.rpartition(":")
        if not colon:
            field = spelt
        else:
            unit = check_unit(spelt, f"--column {text}")
        factor = _FACTOR.match(field)
        if factor:
            field, scale = factor[1], float(factor[2])
        topic, field = _place(text, field, topics)
    return Source(topic=topic, field=field, unit=unit, sign=1 if sign > 0 else -1, scale=scale)


def _place(text: str, field: str, topics: Sequence[Topic]) -> tuple[str, str]:
    """Topic and field: `topic.field`, or a field that one topic alone has."""
    for topic in topics:
        for mark in (".", ":", "/"):
            inside = field.removeprefix(topic.name + mark)
            if inside != field and inside in topic.fields:
                return topic.name, inside
    having = [topic.name for topic in topics if field in topic.fields]
    if len(having) == 1:
        return having[0], field
    if having:
        raise BadInput(f"--column {text}: {field} is in {', '.join(having[:6])}; name one, as in {having[0]}.{field}")
    every = [name for topic in topics for name in (*topic.fields, *(f"{topic.name}.{each}" for each in topic.fields))]
    close = difflib.get_close_matches(field, every, n=1)
    hint = f"did you mean {close[0]}?" if close else "`incsvr inspect FILE` lists all"
    raise BadInput(f"--column {text}: there is no {field}; {hint}")
