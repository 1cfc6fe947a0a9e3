"""Which key is what: the configuration and a preset, held against all that was heard until now.

What was heard first stays where several would do, and of several vehicles one alone is heard.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from service.inputs import bus_keys
from service.inputs.known import RATE, TORQUE, VOLTAGE, Known
from service.inputs.presets import Observed, Proposal, proposed
from service.inputs.presets.proposal import NOTHING
from service.inputs.settings import Armed, Inputs, Source, Thrusters
from service.logs.table import Topic

ANGLE = "(angle of thruster {})"
"""What turns a thruster: it is used, and is no stream; no channel's name has a bracket."""
STAYS = 50
"""Messages after which another key that a preset would rather take comes too late: seconds of a slow stream."""
HEARTBEAT = Armed(topic="the autopilot's HEARTBEAT", field="")
"""What a vehicle of BlueOS will say, before it did."""


@dataclass(frozen=True, slots=True)
class Resolved:
    """What is known of the mapping.

    Attributes:
        inputs: the mapping in force.
        missing: sentences on what was not found, by name.
        armed: what says whether the thrusters may turn; None where nothing does.
        ignored: keys of other vehicles.
        notes: what a preset concluded, one sentence each.
    """

    inputs: Inputs
    missing: Mapping[str, str]
    armed: Armed | None
    ignored: frozenset[str]
    notes: tuple[str, ...]


def resolved(configured: Inputs, known: Mapping[str, Known], parameters: Mapping[str, float]) -> Resolved:
    """The mapping now; what is taken from each key is written into what is known of it."""
    preset = configured.preset
    topics, ignored = _topics(known)
    found = Proposal(Inputs(preset=preset))
    if preset not in ("incsvr", None):
        found = proposed(Observed(topics, parameters), preset)
    proposal = found.with_inputs(configured)
    inputs = proposal.inputs
    for each in known.values():
        each.quantities, each.commands, each.armed = [], [], None
    for name, source in _named(inputs).items():
        key = bound(source.topic, known, preset)
        if key is not None:
            completed = source.model_copy(update={"field": known[key].path(name, source.field)})
            known[key].quantities.append((name, completed))
    if inputs.armed is not None and (key := bound(inputs.armed.topic, known, preset)) is not None:
        path = known[key].path("armed", inputs.armed.field)
        known[key].armed = inputs.armed.model_copy(update={"field": path})
    if inputs.thrusters is not None:
        inputs = inputs.model_copy(update={"thrusters": _commanded(inputs.thrusters, known, inputs)})
    missing = {name: _on_a_bus(name, cure) for name, cure in proposal.missing.items()}
    armed = HEARTBEAT if preset == "blueos" and inputs.armed is None else inputs.armed
    return Resolved(inputs, missing, armed, ignored, proposal.notes)


def steady(configured: Inputs, now: Inputs, known: Mapping[str, Known]) -> Inputs:
    """The configuration with what a preset found and what has come for a while since: that stays."""
    found = {}
    for name in (RATE, TORQUE):
        source = getattr(now, name)
        if source is None or getattr(configured, name) is not None or configured.thrusters is not None:
            continue
        if source.topic in known and known[source.topic].count >= STAYS:
            found[name] = source
    return configured.model_copy(update=found)


def bound(topic: str, known: Mapping[str, Known], preset: str | None) -> str | None:
    """The key of a topic: the first that was heard of it."""
    if topic in known:
        return topic
    of_it = (key for key, each in known.items() if each.fields)
    return next((key for key in of_it if bus_keys.matches(topic, key, preset)), None)


def _named(inputs: Inputs) -> dict[str, Source]:
    """What is taken from messages, by name; what turns thrusters has a name that no channel has."""
    named = {RATE: inputs.yaw_rate, TORQUE: inputs.torque, **inputs.channels}
    if inputs.thrusters is not None:
        named = {VOLTAGE: inputs.thrusters.measured_voltage, **named}
        named |= {ANGLE.format(k): each.turned_by for k, each in enumerate(inputs.thrusters.each)}
    return {name: source for name, source in named.items() if source is not None}


def _commanded(thrusters: Thrusters, known: Mapping[str, Known], inputs: Inputs) -> Thrusters:
    """The thrusters, each with the path of its command."""
    found = []
    for k, (each, topic) in enumerate(zip(thrusters.each, thrusters.topics, strict=True)):
        key = bound(topic, known, inputs.preset)
        if key is not None:
            each = each.model_copy(update={"field": known[key].path("command", each.field)})
            known[key].commands.append(k)
        found.append(each)
    return thrusters.model_copy(update={"each": tuple(found)})


def _topics(known: Mapping[str, Known]) -> tuple[list[Topic], frozenset[str]]:
    """What was heard, for the presets: what came first counts as the busiest; and what is left alone."""
    heard = [(key, each) for key, each in known.items() if each.fields]
    attitudes = [key for key, _ in heard if bus_keys.mavlink_message(key) == "ATTITUDE"]
    vehicles = (None, *(bus_keys.system(key) for key in attitudes[:1]))
    topics = [
        Topic(key, each.type, each.fields, -order)
        for order, (key, each) in enumerate(heard)
        if bus_keys.system(key) in vehicles or not attitudes
    ]
    return topics, frozenset(key for key in attitudes if bus_keys.system(key) not in vehicles)


def _on_a_bus(name: str, cure: str) -> str:
    """What to do about something missing, where it would be on a bus."""
    if cure.startswith(NOTHING[name][:12]):
        return f"nothing that was heard is the {name}: say where it comes in inputs.{name}, with topic, form and field"
    return cure
