"""The mapping that a preset finds: its rows are looked up among the topics of a log or a bus."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from service.inputs import columns
from service.inputs.ardusub import thrusters_by_outputs
from service.inputs.owners import autopilot_message, instance_place, ros_name
from service.inputs.presets import COMMAND, PRESETS, Preset, Row
from service.inputs.proposal import NOTHING_FOUND, Observation, Proposal, others_note
from service.inputs.settings import Armed, Inputs, Source, inside
from service.inputs.table import Topic
from service.inputs.units import FRACTION

_NOT_THE_VEHICLES = re.compile(
    r"(?:^|[/_])(?:camera|cam|zed|realsense|oak|depthai|stereo|kinect|d4\d\d|t265|lidar|ouster|livox|gimbal)"
    r"[a-z0-9]*(?:[/_]|$)"
)
"""Names of sensors that bring an Imu of their own, in axes of their own: a camera's z is where it looks."""
Candidate = tuple[Row, Topic]


def propose(observed: Observation, name: str | None = None) -> Proposal:
    """The mapping of a preset; without one, that of the first which finds a yaw rate, or else of the columns' names."""
    found = columns.own(observed) if name in (None, "incsvr") else None
    for preset in PRESETS:
        found = _Lookup.of(preset, observed).proposal() if found is None and name in (None, preset.name) else found
    found = columns.by_names(observed) if found is None else found
    if found is not None:
        return found
    return Proposal(Inputs(preset=name), missing=NOTHING_FOUND, unseen=frozenset(NOTHING_FOUND))


@dataclass(frozen=True, slots=True)
class _Lookup:
    """One preset among the topics.

    Attributes:
        topics: by the kind of their messages; where several hold one message of an autopilot, the busiest of them.
    """

    preset: Preset
    observed: Observation
    topics: dict[str, list[Topic]]

    @staticmethod
    def of(preset: Preset, observed: Observation) -> _Lookup:
        busiest: dict[str, Topic] = {}
        for topic in sorted(observed.topics, key=lambda each: each.count):
            busiest[_shown(topic)] = topic
        topics: dict[str, list[Topic]] = {}
        for topic in busiest.values():
            topics.setdefault(preset.kind(topic), []).append(topic)
        return _Lookup(preset, observed, topics)

    def proposal(self) -> Proposal | None:
        """The mapping by the preset's rows; None where there is no yaw rate."""
        preset, torques = self.preset, self._candidates("torque")
        pushed = torques[0][1] if torques else None
        rates = self._candidates("yaw_rate", pushed)
        if not rates:
            return None
        found = {"yaw_rate": rates, "torque": torques}
        for name in dict.fromkeys(row.quantity for row in preset.rows):
            if name not in (*found, COMMAND):
                found[name] = self._candidates(name, pushed, rates[0][1])
        reasons = {name: self._others(name, each) for name, each in found.items()}
        sources = {name: source_of(preset, *each[0]) for name, each in found.items() if each and name != "armed"}
        rate, torque, voltage = sources.pop("yaw_rate"), sources.pop("torque", None), sources.get("voltage")
        thrusters, missing = None, dict[str, str]()
        if preset.outputs:
            thrusters, said, missing = thrusters_by_outputs(self.observed, voltage, preset.outputs)
            reasons = {"torque": said} | {name: each for name, each in reasons.items() if name != "torque"}
        elif torque is None:
            told = [topic for kind in preset.commands for topic in self.topics.get(kind, ())]
            hint = f" (their commands may be {min(told, key=lambda topic: topic.name).name})" if told else ""
            missing["torque"] = preset.torque or f"{NOTHING_FOUND['torque']}{hint}"
        elif torque.unit == FRACTION:
            doubt = f"{torque.topic} is a fraction of the full torque, without a unit until a scale is given"
            reasons["torque"] = (*reasons["torque"], doubt)
        inputs = Inputs(
            preset=preset.name,
            yaw_rate=rate,
            torque=torque,
            thrusters=thrusters,
            channels=sources,
            armed=self._armed(found.get("armed", [])),
        )
        unseen = frozenset[str]() if preset.outputs or preset.torque else frozenset(missing)
        return Proposal(inputs, missing=missing, reasons=reasons, unseen=unseen)

    def _candidates(self, name: str, pushed: Topic | None = None, turning: Topic | None = None) -> list[Candidate]:
        """The topics that hold a quantity, the likeliest first; how busy they are says nothing.

        Those come first that are no camera's, then those whose values move, then those of the earlier rows, then those
        that share the first part of their name with the topic of the torque, then those with the shortest and the first
        names; a battery that shows none comes last.
        """
        share = None if pushed is None else ros_name(pushed.name).partition("/")[0]

        def place(candidate: Candidate) -> tuple[Any, ...]:
            row, topic = candidate
            absent = name == "voltage" and topic.name in self.observed.absent_batteries
            likely = absent, row.otherwise, _foreign(topic), self._rank(candidate), self.preset.rows.index(row)
            if not _is_of_ros(topic):
                return *likely, *instance_place(topic.name), topic.name
            plain = ros_name(topic.name)
            return *likely, share is not None and plain.partition("/")[0] != share, plain.count("/"), plain

        rows = [row for row in self.preset.rows if row.quantity == name]
        found = [(row, topic) for row in rows for topic in self.topics.get(row.kind, ()) if _has(row, topic)]
        found = [each for each in found if not each[0].moving or self._rank(each, unseen=3) < 3]
        return sorted((each for each in found if not each[0].beside or each[1] == turning), key=place)

    def _others(self, name: str, found: Sequence[Candidate]) -> tuple[str, ...]:
        """The sentence on the topic of a quantity that is used of several."""
        if not found:
            return ()
        taken, rest = found[0], [each for each in found[1:] if not each[0].otherwise]
        why = self.preset.why
        if any(self._rank(each) > self._rank(taken) for each in rest):
            why += " whose values move"
        elif any(_foreign(topic) for _, topic in rest) and not _foreign(taken[1]):
            why += " that is no camera's"
        return others_note(name, _shown(taken[1]), [_shown(topic) for _, topic in rest], why)

    def _rank(self, candidate: Candidate, unseen: int = 0) -> int:
        row, topic = candidate
        return self.observed.ranks.get((topic.name, row.field), unseen)

    def _armed(self, found: Sequence[Candidate]) -> Armed | None:
        """What says whether the vehicle is armed; where that is told by events, they are expected though none came."""
        if found:
            return armed_of(self.preset, *found[0])
        row = next((row for row in self.preset.rows if row.quantity == "armed"), None)
        if row is None or not row.armed.get("events"):
            return None
        return armed_of(self.preset, row, Topic(row.kind, "", (row.field, row.stamp), 0))


def source_of(preset: Preset, row: Row, topic: Topic) -> Source:
    """The source of a row in a topic."""
    return Source(unit=row.unit, sign=row.sign, **_placed(preset, row, topic))


def armed_of(preset: Preset, row: Row, topic: Topic) -> Armed:
    """How a topic says whether the vehicle is armed."""
    return Armed(**row.armed, **_placed(preset, row, topic))


def _placed(preset: Preset, row: Row, topic: Topic) -> dict[str, Any]:
    """Where a row stands in a topic, and by which stamp, if messages bear it."""
    path = inside(row.stamp, topic.fields)
    stamp = {"stamp": path, "stamp_unit": row.stamp_unit} if path in topic.fields else {}
    form = f"cdr:{topic.type}" if preset.form == "cdr" else preset.form
    return {"topic": topic.name, "field": inside(row.field, topic.fields), "form": form, **stamp}


def _shown(topic: Topic) -> str:
    """The name of a topic in a sentence: of an autopilot's, that of its message."""
    return autopilot_message(topic) or topic.name


def _has(row: Row, topic: Topic) -> bool:
    return inside(row.field, topic.fields) in topic.fields


def _is_of_ros(topic: Topic) -> bool:
    return "/msg/" in topic.type


def _foreign(topic: Topic) -> bool:
    return _is_of_ros(topic) and _NOT_THE_VEHICLES.search(ros_name(topic.name).lower()) is not None
