"""The vehicle's parameters in a log: each counts from when it was received, the first value also before."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, isfinite

import numpy as np

from service.inputs import ardusub_frames
from service.inputs.owners import autopilot_message
from service.inputs.table import Table, Topic
from service.inputs.vehicle_parameters import change_words

PARAMETER_FIELDS = {"PARM": ("Name", "Value"), "PARAM_VALUE": ("param_id", "param_value")}
"""The fields of a parameter's name and value, by the message."""


@dataclass(frozen=True, slots=True)
class ParameterEpoch:
    """A part of a log in which the parameters of the thrusters stay as they are.

    Attributes:
        since: arrival of what began it [s], −∞ for the first.
        parameters: all that are known, by name.
        changes: what began it, in words.
    """

    since: float = -inf
    parameters: dict[str, float] = field(default_factory=dict)
    changes: tuple[str, ...] = ()


def parameter_epochs(topics: Sequence[Topic], tables: Mapping[str, Table]) -> tuple[ParameterEpoch, ...]:
    """The parts of a log, at least one, by the parameters in the tables of its vehicle's topics."""
    told = [each for topic in topics if topic.name in tables for each in _parameters_in(topic, tables[topic.name])]
    told.sort(key=lambda each: each[0])
    now: dict[str, float] = {}
    for _, name, value in told:
        now.setdefault(name, value)
    found = [ParameterEpoch(parameters=dict(now))]
    for arrival, name, value in told:
        before, now[name] = now[name], value
        if value == before or not ardusub_frames.concerns_thrusters(name):
            continue
        words, last = change_words(name, value, before), found[-1]
        if last.since == arrival:
            found[-1] = ParameterEpoch(arrival, dict(now), (*last.changes, words))
        else:
            found.append(ParameterEpoch(arrival, dict(now), (words,)))
    return tuple(found)


def _parameters_in(topic: Topic, table: Table) -> Iterator[tuple[float, str, float]]:
    """Arrival [s], name and value of each parameter."""
    name, value = PARAMETER_FIELDS.get(autopilot_message(topic) or topic.name, ("", ""))
    for path in ("", "message.") if name else ():
        if path + name in table.texts and path + value in table.columns:
            values = table.columns[path + value]
            arrival = np.zeros(values.size) if table.arrival is None else table.arrival
            for when, text, number in zip(arrival.tolist(), table.texts[path + name], values.tolist(), strict=True):
                if isfinite(number):
                    yield when, text.partition("\0")[0], number
