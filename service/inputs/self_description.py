"""A vehicle's description of itself: heartbeat, firmware, batteries, and the parameters of its thrusters."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, isfinite
from typing import Any

import numpy as np

from service.inputs.arming import MAX_WHOLE_NUMBER
from service.inputs.owners import autopilot_message, base
from service.inputs.presets import holding
from service.inputs.settings import inside
from service.inputs.table import Table, Topic
from service.inputs.thrust import is_battery_voltage
from service.inputs.units import FACTORS
from service.inputs.vehicle_kind import BUILD_NAMES, SelfDescription

PARAMETER_FIELDS = {"PARM": ("Name", "Value"), "PARAM_VALUE": ("param_id", "param_value")}
"""The fields of a parameter's name and value, by the message."""


def parameters_in(topic: Topic, table: Table) -> Iterator[tuple[float, str, float]]:
    """Arrival [s], name and value of each parameter that has to do with a vehicle's thrusters."""
    name, value = PARAMETER_FIELDS.get(autopilot_message(topic) or topic.name, ("", ""))
    for path in ("", "message.") if name else ():
        if path + name in table.texts and path + value in table.columns:
            values = table.columns[path + value]
            arrival = np.zeros(values.size) if table.arrival is None else table.arrival
            for when, text, number in zip(arrival.tolist(), table.texts[path + name], values.tolist(), strict=True):
                told = text.partition("\0")[0]
                if abs(number) < MAX_WHOLE_NUMBER and _concerns_thrusters(told):
                    yield when, told, number


def _concerns_thrusters(name: str) -> bool:
    of_outputs = name.startswith(("MOT_", "SERVO")) and name.endswith(("_DIRECTION", "_FUNCTION"))
    return of_outputs or name in ("FRAME_CONFIG", "FRAME_CLASS")


def _change_words(name: str, value: float, before: float) -> str:
    """A change of a parameter, such as `MOT_1_DIRECTION -1 (1 before)`."""
    return f"{name} {value:g} ({before:g} before)"


def changes_note(said: Collection[str], mark: str = "; ") -> tuple[str, ...]:
    """The sentence on parameters that changed, each with since when; nothing without any."""
    whole = f"parameters changed during the log, and apply from then on: {mark.join(said)}"
    return (whole,) if said else ()


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
    """The parts of a log, at least one, by the parameters in the tables of its vehicle's topics.

    What was told first holds before it, too.
    """
    told = [each for topic in topics if topic.name in tables for each in parameters_in(topic, tables[topic.name])]
    told.sort(key=lambda each: each[0])
    now = {name: value for _, name, value in reversed(told)}
    found = [ParameterEpoch(parameters=dict(now))]
    for arrival, name, value in told:
        before, now[name] = now[name], value
        if value == before:
            continue
        words, last = _change_words(name, value, before), found[-1]
        earlier = found.pop().changes if last.since == arrival else ()
        found.append(ParameterEpoch(arrival, dict(now), (*earlier, words)))
    return tuple(found)


MAX_CHANGES_SHOWN = 6
"""Changes that are kept to be shown, the newest."""


class VehicleParameters:
    """The parameters that vehicles have sent on a bus.

    Args:
        kept: as `by_system` gave it in an earlier process.

    Attributes:
        by_system: values by name, by vehicle.
    """

    def __init__(self, kept: Mapping[str, Any] | None = None) -> None:
        self.by_system: dict[str, dict[str, float]] = {name: dict(told) for name, told in (kept or {}).items()}
        self._changes: dict[str, deque[str]] = {}

    def of(self, system: str) -> dict[str, float]:
        """The parameters of a vehicle; before one is taken, those of the only one that sent any."""
        if not system and len(self.by_system) == 1:
            (system,) = self.by_system
        return dict(self.by_system.get(system, {}))

    def take(self, system: str, name: str, value: float, when: float) -> bool:
        """Takes a parameter of a vehicle at a time of its clock [s]; True where it changes something.

        Where that time is not known, NaN, the change is not named.
        """
        told = self.by_system.setdefault(system, {})
        if told.get(name) == value:
            return False
        if name in told and isfinite(when):
            changes = self._changes.setdefault(system, deque(maxlen=MAX_CHANGES_SHOWN))
            changes.append(f"{_change_words(name, value, told[name])} from {when:.6g} s on")
        told[name] = value
        return True

    def note(self, system: str) -> tuple[str, ...]:
        """The sentence on a vehicle's changed parameters."""
        return changes_note(self._changes.get(system, ()), ", ")


_TEXTS = {"MSG": ("Message",), "STATUSTEXT": ("text", "message.text")}
_HEARTBEAT, _BUILD = "HEARTBEAT", "VER"
_FIRMWARES = ("Ardu", "APM", "AntennaTracker", "Blimp")
"""The beginnings of texts that name a firmware."""


def names(topics: Sequence[Topic]) -> list[str]:
    """The topics in which a vehicle speaks of itself, its parameters among them."""
    speaking = {_HEARTBEAT, _BUILD, *_TEXTS, *PARAMETER_FIELDS}
    return [topic.name for topic in topics if base(_message(topic)) in speaking or holding(topic, "voltage")]


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
    found = list[str]()
    for topic in topics:
        held = holding(topic, "voltage")
        if held is not None:
            columns, row = tables[topic.name].columns if topic.name in tables else {}, held[1]
            volts = FACTORS[row.unit] * columns.get(inside(row.field, topic.fields), np.empty(0))
            found += [] if is_battery_voltage(volts).any() else [topic.name]
    return frozenset(found)


def _tables(topics: Sequence[Topic], tables: Mapping[str, Table]) -> Iterator[tuple[str, Table]]:
    for topic in topics:
        if topic.name in tables:
            yield base(_message(topic)), tables[topic.name]


def _message(topic: Topic) -> str:
    return autopilot_message(topic) or topic.name
