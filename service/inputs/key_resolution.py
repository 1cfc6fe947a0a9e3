"""The mapping of keys to inputs, by the configuration, a preset and all messages until now.

What has come for a while stays where several would do, and of several vehicles one alone is heard.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from service.inputs import bus_keys, self_description
from service.inputs.live_clock import RATE
from service.inputs.lookup import propose
from service.inputs.mapper import TORQUE
from service.inputs.owners import system_of
from service.inputs.presets import NO_RATE_FIELD, RATE_PATHS, TORQUE_PATHS
from service.inputs.proposal import Observation, Proposal
from service.inputs.settings import ARRIVAL, Armed, Inputs, inside, renamed
from service.inputs.source_binding import SourceBinding, numbers
from service.inputs.table import Topic, table_of, usual_stamp

SETTLED_MESSAGES = 50
"""Messages after which another key that a preset would rather take comes too late: seconds of a slow stream."""
EXPECTED_HEARTBEAT = Armed(topic="HEARTBEAT of the autopilot", field="")
"""The heartbeat that a vehicle of BlueOS will send, before it did."""


@dataclass(frozen=True, slots=True)
class ResolvedMapping:
    """The present state of the mapping.

    Attributes:
        inputs: the mapping in force.
        missing: sentences on what was not found, by name.
        armed: what says whether the thrusters may turn; None where nothing does.
        notes: what a preset concluded, one sentence each.
        by_key: the mapping in force with the keys and paths that messages have.
    """

    inputs: Inputs
    missing: Mapping[str, str]
    armed: Armed | None
    notes: tuple[str, ...]
    by_key: Inputs


def resolve(
    configured: Inputs,
    heard: Mapping[str, SourceBinding],
    parameters: Mapping[str, float],
    others: frozenset[str] = frozenset(),
) -> ResolvedMapping:
    """The mapping now; what is read of each key's messages is written into what is known of it.

    Args:
        others: vehicles that are left alone.
    """
    preset = configured.preset
    topics = [topic for topic in named_topics(heard) if system_of(topic) not in others]
    known = {topic.name: heard[topic.name] for topic in topics}
    found = Proposal(Inputs(preset=preset))
    if preset not in ("incsvr", None):
        newest = {name: table_of(known[name].message) for name in self_description.names(topics)}
        vehicle, absent = self_description.of_vehicle(topics, newest), self_description.absent_batteries(topics, newest)
        found = propose(Observation(topics, parameters, vehicle, absent, _ranks(known)), preset)
    proposal = found.with_inputs(configured)
    inputs = proposal.inputs
    spelt_out = {place.topic: heard[place.topic] for place in configured.places() if place.topic in heard}
    known |= spelt_out  # also of a vehicle that is left alone, for a person asked for it

    def places(name: str, source: Any, topic: str) -> dict[str, Any]:
        key = key_of(topic, known, preset)
        if key is None:
            return {}
        stamp, unit = _stamp(known[key], source)
        return {
            "topic": key,
            "field": _path(known[key], name, getattr(source, "field", "")),
            "stamp": stamp,
            "stamp_unit": unit,
        }

    by_key = renamed(inputs, places)
    for key, each in heard.items():
        read = [place for place in by_key.places() if place.topic == key and place.name != "armed"]
        each.numbers = tuple(dict.fromkeys(place.field for place in read))
        each.stamps = tuple(dict.fromkeys(place.stamp for place in read if place.stamp != ARRIVAL))
    missing = {name: _cure_on_bus(name) if name in proposal.unseen else cure for name, cure in proposal.missing.items()}
    armed = EXPECTED_HEARTBEAT if preset == "blueos" and inputs.armed is None else inputs.armed
    return ResolvedMapping(inputs, missing, armed, proposal.sentences, by_key)


def named_topics(known: Mapping[str, SourceBinding]) -> list[Topic]:
    """The received topics, for the presets: the first counts as the busiest."""
    heard = [(key, each) for key, each in known.items() if each.fields]
    return [Topic(key, each.type, each.fields, -order) for order, (key, each) in enumerate(heard)]


def with_settled_sources(configured: Inputs, now: Inputs, known: Mapping[str, SourceBinding]) -> Inputs:
    """The configuration with what a preset found and what has come for a while since: that stays.

    Args:
        known: the keys of the vehicle that is taken.
    """
    found = {}
    for name in (RATE, TORQUE):
        source = getattr(now, name)
        if source is None or getattr(configured, name) is not None or configured.thrusters is not None:
            continue
        if source.topic in known and known[source.topic].count >= SETTLED_MESSAGES:
            found[name] = source
    return configured.model_copy(update=found)


def key_of(topic: str, known: Mapping[str, SourceBinding], preset: str | None) -> str | None:
    """The key of a topic: the first that was heard of it."""
    if topic in known:
        return topic
    of_it = (key for key, each in known.items() if each.fields)
    return next((key for key in of_it if bus_keys.matches(topic, key, preset)), None)


def _path(binding: SourceBinding, name: str, path: str) -> str:
    """The path of a number: as configured, within MAVLink's `message`, or the form's own."""
    if path:
        return inside(path, binding.fields)
    if binding.type in ("keelson", "incsvr"):
        return "value"
    usual = {RATE: RATE_PATHS, TORQUE: TORQUE_PATHS}.get(name, {}).get(binding.type)
    return usual or ("data" if binding.type.startswith("std_msgs/") else "")


def _stamp(binding: SourceBinding, source: Any) -> tuple[str, str]:
    """The path of the stamp and its unit: as configured, or the form's own; `arrival` where there is none."""
    said = getattr(source, "stamp", "")
    if said == ARRIVAL:
        return ARRIVAL, "s"
    if said:
        return _path(binding, "", said), source.stamp_unit
    if binding.type in ("keelson", "incsvr"):
        return {"keelson": "timestamp", "incsvr": "t"}[binding.type], "s"
    path, unit = usual_stamp(binding.fields)
    return path or ARRIVAL, unit


def _ranks(known: Mapping[str, SourceBinding]) -> dict[tuple[str, str], int]:
    """How poor candidates are by their newest message: without a finite number, or marked as no measurement."""
    found = {}
    for key, each in known.items():
        path = RATE_PATHS.get(each.type)
        if path is not None:
            finite = np.isfinite(numbers(each.message, path) or np.nan).all()
            found[key, path] = int(numbers(each.message, NO_RATE_FIELD) == [-1.0]) if finite else 3
    return found


def _cure_on_bus(name: str) -> str:
    """The cure for a quantity that no key was recognised as."""
    return f"no key on the bus was recognised as {name}: describe it in inputs.{name}, with topic, form and field"
