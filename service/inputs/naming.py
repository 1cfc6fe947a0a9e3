"""The mapping with topics and paths as they are in the messages of a log or of a bus."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Any

from service.inputs.settings import Inputs, Thruster

Places = Callable[[str, Any, str], dict[str, Any]]
"""What changes of a source (its `topic`, `field`, `stamp` or `stamp_unit`), by the name of its quantity, the source and
the topic that it names."""


def inside(path: str, fields: Collection[str]) -> str:
    """A path where it stands in a message with these fields: in JSON those of MAVLink are within `message`."""
    return f"message.{path}" if path and path not in fields and f"message.{path}" in fields else path


def renamed(inputs: Inputs, places: Places) -> Inputs:
    """The mapping with the places of all sources."""

    def at(name: str, source: Any) -> Any:
        return None if source is None else source.model_copy(update=places(name, source, source.topic))

    def thruster(one: Thruster, common: str) -> Thruster:
        changed = {
            name: each
            for name, each in places("command", one, one.topic or common).items()
            if name in ("topic", "field")
        }
        return one.model_copy(update={**changed, "turned_by": at("turned_by", one.turned_by)})

    thrusters = inputs.thrusters
    if thrusters is not None:
        each = tuple(thruster(one, thrusters.topic) for one in thrusters.each)
        stamped = places("commands", thrusters, thrusters.topics[0])
        changed: dict[str, Any] = {name: stamped[name] for name in ("stamp", "stamp_unit") if name in stamped}
        voltage = at("voltage", thrusters.measured_voltage)
        thrusters = thrusters.model_copy(update={**changed, "each": each, "measured_voltage": voltage})
    return inputs.model_copy(
        update={
            **{name: at(name, getattr(inputs, name)) for name in ("yaw_rate", "torque", "armed")},
            "channels": {name: at(name, source) for name, source in inputs.channels.items()},
            "thrusters": thrusters,
        }
    )
