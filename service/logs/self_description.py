"""A vehicle's description of itself in a log: heartbeat, firmware, batteries."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from service.inputs.instances import base
from service.inputs.owners import autopilot_message
from service.inputs.table import Table, Topic
from service.inputs.thrust import is_battery_voltage
from service.inputs.vehicle_kind import BUILD_NAMES, SelfDescription
from service.logs.parameters import PARAMETER_FIELDS

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
        for field in _TEXTS.get(message, ()):
            firmware = next((text for text in table.texts.get(field, ()) if text.startswith(_FIRMWARES)), firmware)
        if message == _BUILD and "BU" in table.columns and not firmware:
            firmware = BUILD_NAMES.get(int(table.columns["BU"][-1]), "")
    return SelfDescription(heartbeat, firmware)


def absent_batteries(topics: Sequence[Topic], tables: Mapping[str, Table]) -> frozenset[str]:
    """The topics of batteries that never show a voltage which a battery can have."""
    found = []
    for topic in topics:
        fields, volts = _BATTERIES.get(base(_message(topic)), ((), 0.0))
        columns = tables[topic.name].columns if topic.name in tables else {}
        if fields and not any(
            field in columns and is_battery_voltage(volts * columns[field]).any() for field in fields
        ):
            found.append(topic.name)
    return frozenset(found)


def _tables(topics: Sequence[Topic], tables: Mapping[str, Table]) -> Iterator[tuple[str, Table]]:
    for topic in topics:
        if topic.name in tables:
            yield base(_message(topic)), tables[topic.name]


def _message(topic: Topic) -> str:
    return autopilot_message(topic) or topic.name
