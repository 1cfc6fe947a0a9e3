"""The vehicle among several in a log or on a bus whose messages and parameters are used.

It is the first that was armed while its outputs moved. Messages are looked at in the order in which they arrived, so
that a log and a bus choose alike. A person may name another one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from math import nan

import numpy as np

from incsvr.errors import BadInput
from service.inputs.arming import says_armed
from service.inputs.lookup import armed_of
from service.inputs.outputs import MIN_PULSE_MOVEMENT_US, Ends, movement
from service.inputs.owners import autopilot_message, base, keelson_subject, system_of
from service.inputs.presets import COMMAND, OUTPUT_MESSAGE, RATE_PATHS, TORQUE_PATHS, holding
from service.inputs.settings import Armed, Inputs
from service.inputs.table import Topic

MOVES_ARMED, MOVES, IS_ARMED, IS_HEARD = 3, 2, 1, 0
"""What is known of a vehicle: its outputs move while it is armed; they move and nothing says whether it is armed; it is
armed and nothing says what its thrusters are told; else."""
_REASONS = {
    MOVES_ARMED: "the first that was armed while its outputs moved",
    MOVES: "the first whose outputs moved",
    IS_ARMED: "the first that was armed",
    IS_HEARD: "for none was armed while its outputs moved",
}


@dataclass(frozen=True, slots=True)
class VehicleEvidence:
    """The evidence of a topic's messages on their vehicle.

    Attributes:
        system: the vehicle.
        topic: whose messages they are.
        armed: how they say that it is armed; None where they say nothing of it.
        commands: paths of what its thrusters are told.
        least: a command that changes by more moves.
    """

    system: str
    topic: str
    armed: Armed | None = None
    commands: tuple[str, ...] = ()
    least: float = 0.0


def evidence_of(topic: Topic) -> VehicleEvidence | None:
    """The evidence of a topic on its vehicle; None without any."""
    system = system_of(topic)
    if not system:
        return None
    if base(autopilot_message(topic) or "") == OUTPUT_MESSAGE:
        outputs = (path for path in topic.fields if path.rpartition(".")[2].startswith("servo"))
        return VehicleEvidence(system, topic.name, commands=tuple(outputs), least=MIN_PULSE_MOVEMENT_US)
    if (armed := holding(topic, "armed")) is not None:
        return VehicleEvidence(system, topic.name, armed_of(*armed, topic))
    commands = holding(topic, COMMAND) or holding(topic, "torque")
    return None if commands is None else VehicleEvidence(system, topic.name, commands=(commands[1].field,))


def vehicles_with_yaw_rate(topics: Sequence[Topic]) -> list[str]:
    """The vehicles that could be learned from, in the order of the topics: those with a yaw rate.

    A part of a ROS name is a vehicle only where a yaw rate and a torque have it in common.
    """
    torques = {system_of(topic) for topic in topics if topic.type in TORQUE_PATHS}
    rates = [topic for topic in topics if holding(topic, "yaw_rate") is not None]
    found = [system_of(topic) for topic in rates if topic.type not in RATE_PATHS or system_of(topic) in torques]
    return [system for system in dict.fromkeys(found) if system]


def present_vehicles(topics: Sequence[Topic], wanted: str = "") -> list[str]:
    """All vehicles that send messages, also those that could not be learned from.

    Who sends a heartbeat alone is none, but where nobody sends more. A person who names a vehicle says that parts of
    ROS names are vehicles.
    """
    speaking = [topic for topic in topics if autopilot_message(topic) or keelson_subject(topic.name)]
    more = [topic for topic in speaking if autopilot_message(topic) != "HEARTBEAT"] or speaking
    named = [
        system_of(topic) for topic in topics if wanted and (topic.type in RATE_PATHS or topic.type in TORQUE_PATHS)
    ]
    return list(
        dict.fromkeys(system for system in (*vehicles_with_yaw_rate(topics), *map(system_of, more), *named) if system)
    )


@dataclass(slots=True)
class _Observation:
    armed: bool | None = None
    ends: dict[str, Ends] = field(default_factory=dict)
    has_moved: bool = False
    commanded: bool = False
    rank: int = IS_HEARD


class Vehicles:
    """The choice, message by message.

    Args:
        wanted: the vehicle that a person named; empty leaves the choice to the rule.

    Attributes:
        chosen: the vehicle that is taken; empty before one with a yaw rate was met.
        is_settled: whether nothing that comes changes the choice any more.
    """

    def __init__(self, wanted: str = "") -> None:
        self.chosen, self.is_settled = wanted, bool(wanted)
        self._wanted, self._observations = wanted, dict[str, _Observation]()
        self._with_yaw_rate: set[str] = set()

    def meet(self, systems: Iterable[str]) -> None:
        """Vehicles that have a yaw rate; where nothing else is known, the first is taken."""
        for system in systems:
            self._with_yaw_rate.add(system)
            self._consider(system)

    def take(self, sign: VehicleEvidence, number: Callable[[str], float | None]) -> bool:
        """Takes what a message shows; True where another vehicle is taken since.

        Args:
            number: the number at a path of the message.
        """
        seen = self._observations.setdefault(sign.system, _Observation())
        if sign.armed is not None:
            value = number(sign.armed.field)
            if value is not None and np.isfinite(value):
                seen.armed = bool(says_armed(sign.armed, np.array([value]))[0])
                if not seen.armed:
                    seen.ends, seen.has_moved = {}, False
        if sign.commands:
            seen.commanded = True
            if not seen.has_moved:
                told = np.array([[nan if (value := number(path)) is None else value for path in sign.commands]])
                row, seen.ends[sign.topic] = movement(told, sign.least, seen.ends.get(sign.topic))
                seen.has_moved = row is not None
        seen.rank = max(seen.rank, _rank(seen))
        return self._consider(sign.system)

    def others(self, systems: Iterable[str]) -> frozenset[str]:
        """The vehicles that are not used."""
        return frozenset(systems) - {self.chosen} if self.chosen else frozenset()

    def note(self, others: Iterable[str]) -> str:
        """The choice in one sentence."""
        named = sorted(others, key=lambda name: (len(name), name))
        why = "as it was asked"
        if not self._wanted:
            alone = not self._with_yaw_rate & set(named)
            why = "the only one that sends its yaw rate" if alone else _REASONS[self._rank(self.chosen)]
        return (
            f"vehicle {self.chosen} is used, {why}; vehicle {', '.join(named)} is ignored: --system {named[0]}, or "
            "inputs.system in a configuration, selects it"
        )

    def _consider(self, system: str) -> bool:
        if self.is_settled or system not in self._with_yaw_rate:
            return False
        before = self.chosen
        if not before or self._rank(system) > self._rank(before):
            self.chosen = system
        self.is_settled = self._rank(self.chosen) == MOVES_ARMED
        return self.chosen != before

    def _rank(self, system: str) -> int:
        return self._observations[system].rank if system in self._observations else IS_HEARD


def _rank(seen: _Observation) -> int:
    if seen.has_moved and seen.armed is not False:
        return MOVES_ARMED if seen.armed else MOVES
    return IS_ARMED if seen.armed and not seen.commanded else IS_HEARD


def named_vehicle(inputs: Inputs) -> str:
    """The vehicle that a person named, or whose topics a person spelt out; empty where the rule chooses."""
    if inputs.system:
        return inputs.system
    spelt = [source.topic for source in (inputs.yaw_rate, inputs.torque) if source is not None]
    spelt += inputs.thrusters.topics if inputs.thrusters is not None else ()
    systems = (system_of(Topic(name, "", (), 0)) for name in spelt if "*" not in name)
    return next((system for system in systems if system), "")


def refuse_unknown(wanted: str, systems: Sequence[str]) -> None:
    """Raises BadInput where a person named a vehicle that is not there."""
    if wanted and wanted not in systems:
        known = f"but {', '.join(sorted(systems))}" if systems else "where messages do not name their vehicle"
        raise BadInput(f"--system {wanted} (inputs.system): there is no such vehicle, {known}")
