"""Keelson, the maritime conventions on Zenoh: the subject in a key says what it is and in which unit."""

from __future__ import annotations

from service.inputs.owners import keelson_subject
from service.inputs.presets.proposal import Observation, Proposal, others_note
from service.inputs.settings import Armed, Inputs, Source
from service.inputs.table import Topic

_CHANNELS = {
    "heading_true_north_deg": ("heading", "deg"),
    "yaw_deg": ("heading", "deg"),
    "roll_rate_degps": ("roll_rate", "deg/s"),
    "pitch_rate_degps": ("pitch_rate", "deg/s"),
    "surge_velocity_mps": ("surge", "m/s"),
    "sway_velocity_mps": ("sway", "m/s"),
    "battery_voltage_v": ("voltage", "V"),
    "rudder_angle_deg": ("rudder_angle", "deg"),
}
"""Name and unit of a channel by its subject."""
RATE_SUBJECT, ARMED_SUBJECT = "yaw_rate_degps", "vehicle_armed"
KEYS = tuple(f"**/@v0/**/pubsub/{subject}/**" for subject in (RATE_SUBJECT, ARMED_SUBJECT, *_CHANNELS))
"""The keys that are listened to on a bus."""
TORQUE_CURE = (
    "Keelson sends no torque: it is computed from the propellers and the rudder; describe them in inputs.thrusters of "
    "a configuration (propeller_rate_rpm, rudder_angle_deg)"
)


def proposal(observed: Observation) -> Proposal | None:
    """The mapping by subjects; None where none is a yaw rate."""
    sources: dict[str, list[Topic]] = {}
    for topic in sorted(observed.topics, key=lambda each: each.name):
        subject = keelson_subject(topic.name)
        if subject is not None:
            sources.setdefault(subject, []).append(topic)
    if RATE_SUBJECT not in sources:
        return None
    subjects = {subject: topics[0] for subject, topics in sources.items()}
    reasons = {}
    for subject, name in (
        (RATE_SUBJECT, "yaw_rate"),
        (ARMED_SUBJECT, "armed"),
        *((key, each[0]) for key, each in _CHANNELS.items()),
    ):
        first, *others = [topic.name for topic in sources.get(subject, ())] or [""]
        reasons[name] = others_note(name, first, others, "the first by its name")
    channels = {name: _source(subjects[key], unit) for key, (name, unit) in _CHANNELS.items() if key in subjects}
    armed = subjects.get(ARMED_SUBJECT)
    inputs = Inputs(
        preset="keelson",
        yaw_rate=_source(subjects[RATE_SUBJECT], "deg/s"),
        channels=channels,
        armed=None if armed is None else Armed(topic=armed.name, field="value", form="keelson"),
    )
    return Proposal(inputs, missing={"torque": TORQUE_CURE}, reasons=reasons)


def _source(topic: Topic, unit: str) -> Source:
    return Source(topic=topic.name, field="value", unit=unit, stamp="timestamp", form="keelson")
