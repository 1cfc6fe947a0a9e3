"""A configuration names topics as they are called on a bus; this is where they stand in a log."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from service.inputs.owners import autopilot_message
from service.inputs.settings import Inputs, Thruster
from service.inputs.table import Topic


def aliases(topics: Sequence[Topic]) -> dict[str, Topic]:
    """The topics by their names, and those of the vehicle's autopilot also by the message: `SERVO_OUTPUT_RAW[1]`."""
    by_message = {message: topic for topic in topics if (message := autopilot_message(topic)) is not None}
    return {**{topic.name: topic for topic in topics}, **by_message}


def with_log_names(inputs: Inputs, topics: Sequence[Topic]) -> Inputs:
    """The mapping with topics and paths as they are in a log.

    Args:
        topics: of the vehicle that is taken.
    """
    known = aliases(topics)
    update = {name: _source_in_log(getattr(inputs, name), known) for name in ("yaw_rate", "torque", "armed")}
    channels = {name: _source_in_log(source, known) for name, source in inputs.channels.items()}
    thrusters = inputs.thrusters
    if thrusters is not None:
        each = tuple(_thruster(one, thrusters.topic, known) for one in thrusters.each)
        voltage = _source_in_log(thrusters.measured_voltage, known)
        changed = {**_place_in_log(thrusters, thrusters.topic, known), "each": each, "measured_voltage": voltage}
        thrusters = thrusters.model_copy(update=changed)
    return inputs.model_copy(update={**update, "channels": channels, "thrusters": thrusters})


def _thruster(thruster: Thruster, common: str, known: Mapping[str, Topic]) -> Thruster:
    changed = _place_in_log(thruster, thruster.topic or common, known)
    if not thruster.topic:
        changed.pop("topic", None)
    return thruster.model_copy(update={**changed, "turned_by": _source_in_log(thruster.turned_by, known)})


def _source_in_log(source: Any, known: Mapping[str, Topic]) -> Any:
    """A source, or what says armed, with its topic and paths; None where there is none."""
    return None if source is None else source.model_copy(update=_place_in_log(source, source.topic, known))


def _place_in_log(named: Any, name: str, known: Mapping[str, Topic]) -> dict[str, str]:
    """The topic and those of the paths that stand elsewhere in its messages: in JSON they are within `message`."""
    if name not in known:
        return {}
    topic = known[name]
    found = {"topic": topic.name}
    for attribute in ("field", "stamp"):
        path = getattr(named, attribute, "")
        if path and path not in topic.fields and f"message.{path}" in topic.fields:
            found[attribute] = f"message.{path}"
    return found
