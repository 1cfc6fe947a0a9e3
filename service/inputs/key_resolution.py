"""The mapping of keys to inputs, by the configuration, a preset and all messages until now.

What has come for a while stays where several would do, and of several vehicles one alone is heard.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from service.inputs import bus_keys
from service.inputs.instances import base
from service.inputs.owners import autopilot_message, system_of
from service.inputs.presets import Observation, Proposal, propose
from service.inputs.presets.ros import NO_RATE_FIELD, RATE_PATHS
from service.inputs.settings import Armed, Inputs, Source, Thrusters
from service.inputs.source_binding import RATE, TORQUE, SourceBinding
from service.inputs.table import Topic, leaves
from service.inputs.thrust import is_battery_voltage
from service.inputs.vehicle_kind import SelfDescription

ANGLE_NAME, BATTERY_NAME = "(angle of thruster {})", "(battery of the thrusters)"
"""The names of what turns a thruster and of what it draws from, which are used and are no streams: no channel's name
has a bracket."""
SETTLED_MESSAGES = 50
"""Messages after which another key that a preset would rather take comes too late: seconds of a slow stream."""
EXPECTED_HEARTBEAT = Armed(topic="the autopilot's HEARTBEAT", field="")
"""The heartbeat that a vehicle of BlueOS will send, before it did."""


@dataclass(frozen=True, slots=True)
class ResolvedMapping:
    """The present state of the mapping.

    Attributes:
        inputs: the mapping in force.
        missing: sentences on what was not found, by name.
        armed: what says whether the thrusters may turn; None where nothing does.
        notes: what a preset concluded, one sentence each.
    """

    inputs: Inputs
    missing: Mapping[str, str]
    armed: Armed | None
    notes: tuple[str, ...]


def resolve(
    configured: Inputs,
    heard: Mapping[str, SourceBinding],
    parameters: Mapping[str, float],
    others: frozenset[str] = frozenset(),
) -> ResolvedMapping:
    """The mapping now; what is taken from each key is written into what is known of it.

    Args:
        others: vehicles that are left alone.
    """
    preset = configured.preset
    for each in heard.values():
        each.quantities, each.commands, each.armed = [], [], None
    topics = [topic for topic in named_topics(heard) if system_of(topic) not in others]
    known = {topic.name: heard[topic.name] for topic in topics}
    found = Proposal(Inputs(preset=preset))
    if preset not in ("incsvr", None):
        found = propose(
            Observation(
                topics, parameters, _self_description(topics, known), _absent_batteries(topics, known), _ranks(known)
            ),
            preset,
        )
    proposal = found.with_inputs(configured)
    inputs = proposal.inputs
    spelt_out = {place.topic: heard[place.topic] for place in configured.places() if place.topic in heard}
    known |= spelt_out  # also of a vehicle that is left alone, for a person asked for it
    for name, source in _named_sources(inputs).items():
        key = key_of(source.topic, known, preset)
        if key is not None:
            completed = source.model_copy(update={"field": known[key].path(name, source.field)})
            known[key].quantities.append((name, completed))
    if inputs.armed is not None and (key := key_of(inputs.armed.topic, known, preset)) is not None:
        path = known[key].path("armed", inputs.armed.field)
        known[key].armed = inputs.armed.model_copy(update={"field": path})
    if inputs.thrusters is not None:
        inputs = inputs.model_copy(update={"thrusters": _thrusters_with_paths(inputs.thrusters, known, inputs)})
    missing = {name: _cure_on_bus(name) if name in proposal.unseen else cure for name, cure in proposal.missing.items()}
    armed = EXPECTED_HEARTBEAT if preset == "blueos" and inputs.armed is None else inputs.armed
    return ResolvedMapping(inputs, missing, armed, proposal.sentences)


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


def _named_sources(inputs: Inputs) -> dict[str, Source]:
    """The sources of all inputs, by name; an angle of thrusters has a name that no channel has."""
    named = {RATE: inputs.yaw_rate, TORQUE: inputs.torque, **inputs.channels}
    if inputs.thrusters is not None:
        named[BATTERY_NAME] = inputs.thrusters.measured_voltage
        named |= {ANGLE_NAME.format(k): each.turned_by for k, each in enumerate(inputs.thrusters.each)}
    return {name: source for name, source in named.items() if source is not None}


def _thrusters_with_paths(thrusters: Thrusters, known: Mapping[str, SourceBinding], inputs: Inputs) -> Thrusters:
    """The thrusters, each with the path of its command."""
    found = []
    for k, (each, topic) in enumerate(zip(thrusters.each, thrusters.topics, strict=True)):
        key = key_of(topic, known, inputs.preset)
        if key is not None:
            each = each.model_copy(update={"field": known[key].path("command", each.field)})
            known[key].commands.append(k)
        found.append(each)
    return thrusters.model_copy(update={"each": tuple(found)})


def _self_description(topics: Sequence[Topic], known: Mapping[str, SourceBinding]) -> SelfDescription:
    """The vehicle's description of itself in its newest heartbeat."""
    beats = [topic.name for topic in topics if autopilot_message(topic) == "HEARTBEAT"]
    return SelfDescription(dict(leaves(known[beats[0]].message))) if beats else SelfDescription()


def _ranks(known: Mapping[str, SourceBinding]) -> dict[tuple[str, str], int]:
    """How poor candidates are by their newest message: without a finite number, or marked as no measurement."""
    found = {}
    for key, each in known.items():
        path = RATE_PATHS.get(each.type)
        if path is not None:
            finite = np.isfinite(each.numbers(path) or np.nan).all()
            found[key, path] = int(each.numbers(NO_RATE_FIELD) == [-1.0]) if finite else 3
    return found


def _absent_batteries(topics: Sequence[Topic], known: Mapping[str, SourceBinding]) -> frozenset[str]:
    """Batteries that show no battery in their newest message."""
    found = []
    for topic in topics:
        if base(autopilot_message(topic) or "") == "BATTERY_STATUS":
            volts = known[topic.name].numbers(known[topic.name].path("", "voltages[0]"))
            if not (volts and is_battery_voltage(1e-3 * np.array(volts))[0]):
                found.append(topic.name)
    return frozenset(found)


def _cure_on_bus(name: str) -> str:
    """The cure for a quantity that no key was recognised as."""
    return f"no key on the bus was recognised as {name}: describe it in inputs.{name}, with topic, form and field"
