"""A vehicle's description of itself in a log: heartbeat, firmware, batteries, and the parameters of its thrusters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, isfinite

import numpy as np

from service.inputs.ardusub_frames import change_words, concerns_thrusters
from service.inputs.owners import autopilot_message, base
from service.inputs.table import Table, Topic
from service.inputs.thrust import is_battery_voltage
from service.inputs.vehicle_kind import BUILD_NAMES, SelfDescription

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
        if value == before or not concerns_thrusters(name):
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


_TEXTS = {"MSG": ("Message",), "STATUSTEXT": ("text", "message.text")}
_BATTERIES = {
    "BATTERY_STATUS": (("voltages[0]", "message.voltages[0]"), 1e-3),
    "BAT": (("Volt",), 1.0),
    "battery_status": (("voltage_v",), 1.0),
}
"""The field of a battery's voltage, and volts over its unit, by the message."""
_HEARTBEAT, _BUILD = "HEARTBEAT", "VER"
_FIRMWARES = ("Ardu", "APM", "AntennaTracker", "Blimp")
"""The beginnings of texts that name a firmware."""


def names(topics: Sequence[Topic]) -> list[str]:
    """The topics in which a vehicle speaks of itself, its parameters among them."""
    speaking = {_HEARTBEAT, _BUILD, *_TEXTS, *_BATTERIES, *PARAMETER_FIELDS}
    return [topic.name for topic in topics if base(_message(topic)) in speaking]


def of_vehicle(topics: Sequence[Topic], tables: Mapping[str, Table]) -> SelfDescription:
    """The description by the last message of each topic that contains one."""
    heartbeat: dict[str, float | str] = {}
    firmware = ""
    for message, table in _tables(topics, tables):
        if message == _HEARTBEAT:
            heartbeat = {name: float(values[-1]) for name, values in table.columns.items() if values.size}
            heartbeat |= {name: texts[-1] for name, texts in table.texts.items() if texts}
        for name in _TEXTS.get(message, ()):
            firmware = next((text for text in table.texts.get(name, ()) if text.startswith(_FIRMWARES)), firmware)
        if message == _BUILD and "BU" in table.columns and not firmware:
            firmware = BUILD_NAMES.get(int(table.columns["BU"][-1]), "")
    return SelfDescription(heartbeat, firmware)


def absent_batteries(topics: Sequence[Topic], tables: Mapping[str, Table]) -> frozenset[str]:
    """The topics of batteries that never show a voltage which a battery can have."""
    found = []
    for topic in topics:
        fields, volts = _BATTERIES.get(base(_message(topic)), ((), 0.0))
        columns = tables[topic.name].columns if topic.name in tables else {}
        if fields and not any(name in columns and is_battery_voltage(volts * columns[name]).any() for name in fields):
            found.append(topic.name)
    return frozenset(found)


def _tables(topics: Sequence[Topic], tables: Mapping[str, Table]) -> Iterator[tuple[str, Table]]:
    for topic in topics:
        if topic.name in tables:
            yield base(_message(topic)), tables[topic.name]


def _message(topic: Topic) -> str:
    return autopilot_message(topic) or topic.name
