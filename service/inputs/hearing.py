"""The mapping at work on a bus: one message after the other becomes measurements in SI units on one clock.

Nothing here knows the bus: keys and payloads come in, in the order in which they arrived, and all that goes out follows
from them and, where messages bear no stamps, from when they arrived. A preset looks at what has been heard so far; what
was heard first stays where several would do. What a configuration names goes before what a preset finds.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from math import nan
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from service.inputs import bus_keys, frames
from service.inputs.arming import says_armed
from service.inputs.clock_of_rate import ClockOfRate
from service.inputs.forms import Undecodable, as_float, decoder, number
from service.inputs.forms.cdr import has_header
from service.inputs.forms.own import Refused, parse
from service.inputs.presets import Observed, Proposal, proposed
from service.inputs.presets.proposal import NOTHING
from service.inputs.presets.ros import RATES, TORQUES
from service.inputs.settings import ARRIVAL, Armed, Inputs, Source, Thrusters
from service.inputs.thrust import T200_NOMINAL, moment, sensible
from service.inputs.units import FRACTION, STAMPS
from service.logs.gathering import leaves
from service.logs.table import Topic

LARGEST = 2.0**53
"""Flags and states are whole numbers below."""
SOON = 50
"""Commands until which the battery's voltage may come: it is told every few seconds."""
MOST = 1000
"""Keys that are looked at; what comes after so many is no vehicle's."""
RATE, TORQUE, VOLTAGE, SURGE = "yaw_rate", "torque", "voltage", "surge"


@dataclass(frozen=True, slots=True)
class Heard:
    """Values of a stream: stamps [s], values in SI units, and the message's number where it has one."""

    name: str
    t: list[float]
    value: list[float]
    sequence: int | None = None


@dataclass(slots=True)
class Known:
    """A key that was heard: how its messages are read, the newest, how many came, and what is taken from them."""

    form: str
    decode: Callable[[bytes], Any] | None
    fields: tuple[str, ...] = ()
    message: Any = None
    count: int = 0
    first: float = 0.0
    last: float = 0.0
    quantities: list[tuple[str, Source]] = field(default_factory=list)
    commands: list[int] = field(default_factory=list)
    armed: Armed | None = None


class Hearing:
    """What one learner hears; one thread calls it.

    Args:
        inputs: the mapping of the configuration.
        parameters: of the vehicle, as an earlier process heard them.

    Attributes:
        keys: the key expressions to listen to.
        inputs: the mapping in force; topics that were heard are named by their keys.
        missing: sentences on what was not found, by name.
        parameters: of the vehicle that have to do with its thrusters.
        armed: whether the thrusters may turn; None before anything says so.
        refused: messages that are no measurements, by reason.
        placed: by stream, whether its own stamps count, or its times of arrival.

    Raises:
        BadInput: the configuration names a type that is not read, or a topic that is no key expression.
    """

    def __init__(self, inputs: Inputs, parameters: Mapping[str, float] | None = None) -> None:
        self._configured = inputs
        self.parameters = {**inputs.parameters, **(parameters or {})}
        self.inputs, self.missing = inputs, dict[str, str]()
        self.armed: bool | None = False if inputs.armed is not None and inputs.armed.events else None
        self.refused: Counter[str] = Counter()
        self.placed: dict[str, bool] = {}
        self.known: dict[str, Known] = {}
        self.types: dict[str, str] = {}
        self.keys = bus_keys.listened(inputs)
        for _, form in self._forms():
            decoder(form)
        self._clock = ClockOfRate()
        self._latest: dict[str, float] = {}
        self._commands: list[float] = []
        self._moment: Heard | None = None
        self._ignored: set[str] = set()
        self._resolve()

    @property
    def may_learn(self) -> bool:
        """Whether the thrusters may turn, as far as anything says so."""
        return self._armed_source is None or self.armed is True

    @property
    def why_not(self) -> str | None:
        """Why nothing that comes is learned from; None where it is."""
        if self.may_learn:
            return None
        source = self._armed_source
        topic = "the autopilot's HEARTBEAT" if source is None else source.topic
        if self.armed is None:
            return f"nothing has said yet whether the vehicle is armed; {topic} would"
        return f"the vehicle is not armed (by {topic}), so that there is nothing to learn from"

    def notices(self) -> list[str]:
        """What a person should know of how the measurements come about."""
        found = []
        inputs = self.inputs
        if inputs.thrusters is not None and self._configured.thrusters is None and self._configured.preset == "blueos":
            doubt = frames.assumed(self.parameters)
            found += [doubt] if doubt else []
        if inputs.thrusters is not None and self._nominal(inputs.thrusters):
            found.append(
                f"nothing says the battery's voltage: the thrust is taken for that at {T200_NOMINAL:g} V; let the "
                "vehicle send it, or name it in inputs.channels.voltage"
            )
        if inputs.torque is not None and inputs.torque.unit == FRACTION and inputs.torque.scale == 1.0:
            found.append("the torque is a fraction of full thrust, not N m, until inputs.torque.scale says how much")
        for name, own in self.placed.items():
            source = self._source(name)
            if not own and isinstance(source, Source) and _stamp(source, self._known(source.topic))[0]:
                found.append(
                    f"the stamps of {name} are of another clock than those of yaw_rate: its times of arrival count"
                )
        if self._ignored:
            found.append(
                f"{min(self._ignored)} is heard as well and left alone: name the topics in inputs to take it instead"
            )
        return found

    def announce(self, key: str, kind: str) -> None:
        """A bridge says that messages of this type come on a key."""
        self.types[key] = kind

    def hear(self, key: str, payload: bytes, arrival: float) -> list[Heard]:
        """What a message tells, arrived at `arrival` [s] of a clock that goes on."""
        known = self.known.get(key)
        if known is None:
            if len(self.known) >= MOST:
                return []
            known = self.known[key] = self._meet(key)
            known.first = arrival
        if known.decode is None:
            return []
        known.count, known.last = known.count + 1, arrival
        sequence = None
        try:
            if known.form == "incsvr":
                t, values, sequence = parse(payload)
                message: Any = {"t": t, "value": values}
            else:
                message = known.decode(payload)
        except (Undecodable, Refused) as error:
            self.refused[str(error) if isinstance(error, Refused) else "undecodable"] += 1
            return []
        known.message = message
        if not known.fields:
            known.fields = tuple(path for path, _ in leaves(message)) or ("",)
            self._resolve()
        if bus_keys.mavlink_message(key) == "PARAM_VALUE":
            self._parameter(message)
        if known.armed is not None:
            self._arm(known.armed, message)
        return [
            Heard(heard.name, heard.t, heard.value, sequence) if sequence is not None else heard
            for heard in self._told(known, message, arrival)
        ]

    def _told(self, known: Known, message: Any, arrival: float) -> Iterator[Heard]:
        for name, source in known.quantities:
            values = _numbers(message, source.field)
            if values is None:
                self.refused["no_field"] += 1
                continue
            values = [value * source.factor for value in values]
            if values:
                self._latest[name] = values[-1]
            stamps = _stamps(message, *_stamp(source, known))
            if name == RATE:
                times = self._clock.reference(stamps, arrival)
            else:
                times, self.placed[name] = self._clock.placed(stamps, arrival)
            if len(times) != len(values):
                if times:
                    self.refused["unequal_length"] += 1
                continue
            yield Heard(name, times, values)
        if known.commands and self.inputs.thrusters is not None:
            yield from self._torque(self.inputs.thrusters, known, message, arrival)

    def _torque(self, settings: Thrusters, known: Known, message: Any, arrival: float) -> Iterator[Heard]:
        """The moment, once every thruster has told its command.

        Where each has a key of its own, it waits for a later stamp: what bears the same belongs to the same moment.
        """
        for each in known.commands:
            command = number(message, settings.each[each].field)
            if command is None:
                self.refused["no_field"] += 1
                return
            self._commands[each] = command
        times, self.placed[TORQUE] = self._clock.placed(_stamps(message, *_stamp(settings, known)), arrival)
        if len(times) != 1 or np.isnan(self._commands).any():
            return
        commands = [np.array([command]) for command in self._commands]
        volts, speed = np.array([self._volts(settings)]), np.array([self._latest.get(SURGE, 0.0)])
        with np.errstate(all="ignore"):  # what is no command makes no moment, and is refused as beyond the plausible
            told = Heard(TORQUE, times, [float(moment(settings, commands, volts, speed)[0])])
        if len(known.commands) == len(settings.each):
            yield told
            return
        if self._moment is not None and self._moment.t < told.t:
            yield self._moment
        self._moment = told

    def _volts(self, settings: Thrusters) -> float:
        measured = self._measured_volts()
        if measured is not None:
            return measured
        return T200_NOMINAL if settings.voltage is None else settings.voltage

    def _measured_volts(self) -> float | None:
        measured = self._latest.get(VOLTAGE)
        return measured if measured is not None and sensible(np.array([measured]))[0] else None

    def _nominal(self, settings: Thrusters) -> bool:
        """Whether the thrust is that of a voltage that nobody told, though it had time to come."""
        told = any(known.commands and known.count > SOON for known in self.known.values())
        guessed = settings.curve == "t200" and settings.voltage is None and settings.command in ("pwm", "fraction")
        return guessed and told and self._measured_volts() is None

    def _arm(self, settings: Armed, message: Any) -> None:
        value = number(message, settings.field)
        if value is None or not abs(value) < LARGEST:
            self.refused["no_field"] += 1
        else:
            self.armed = bool(says_armed(settings, np.array([value]))[0])

    def _parameter(self, message: Any) -> None:
        """A parameter of the vehicle; what it says goes before what was assumed."""
        body = message.get("message", {}) if isinstance(message, dict) else {}
        name, value = body.get("param_id"), body.get("param_value")
        if isinstance(name, list):
            name = "".join(str(each) for each in name)
        told = as_float(value)
        if not isinstance(name, str) or told is None:
            return
        name = name.partition("\0")[0]
        if frames.relevant(name) and self.parameters.get(name) != told:
            self.parameters[name] = told
            self._resolve()

    def _meet(self, key: str) -> Known:
        """A key that is heard for the first time."""
        kind = self.types.get(key)
        form = bus_keys.form(key) or (f"cdr:{kind}" if kind else None)
        if form is None:
            form = next(
                (each for name, each in self._forms() if bus_keys.matches(name, key, self.inputs.preset)), "json"
            )
        try:
            return Known(form, decoder(form))
        except BadInput:  # a type that a bridge announces, and that nothing is read from
            return Known(form, None)

    def _forms(self) -> Iterator[tuple[str, str]]:
        """The forms that the configuration names, by topic."""
        inputs = self._configured
        for source in (inputs.yaw_rate, inputs.torque, inputs.armed, *inputs.channels.values()):
            if source is not None:
                yield source.topic, source.form
        if inputs.thrusters is not None:
            for topic in inputs.thrusters.topics:
                yield topic, inputs.thrusters.form
            if inputs.thrusters.measured_voltage is not None:
                yield inputs.thrusters.measured_voltage.topic, inputs.thrusters.measured_voltage.form

    def _resolve(self) -> None:
        """The mapping by all that was heard until now, and what is taken from each key."""
        preset = self._configured.preset
        found = Proposal(Inputs(preset=preset))
        if preset not in ("incsvr", None):
            found = proposed(Observed(self._topics(), self.parameters), preset)
        proposal = found.with_inputs(self._configured)
        before = len(self._commands)
        self.inputs = proposal.inputs
        self.missing = {name: _on_a_bus(name, cure) for name, cure in proposal.missing.items()}
        thrusters, armed = self.inputs.thrusters, self.inputs.armed
        if preset == "blueos" and armed is None:
            self._armed_source: Armed | None = Armed(topic="the autopilot's HEARTBEAT", field="")
        else:
            self._armed_source = armed
        for known in self.known.values():
            known.quantities, known.commands, known.armed = [], [], None
        named = {RATE: self.inputs.yaw_rate, TORQUE: self.inputs.torque, **self.inputs.channels}
        if thrusters is not None and thrusters.measured_voltage is not None and VOLTAGE not in self.inputs.channels:
            named[VOLTAGE] = thrusters.measured_voltage
        for name, source in named.items():
            key = None if source is None else self._bound(source.topic)
            if key is not None and source is not None:
                self._take(name, source, self.known[key])
        if armed is not None and (key := self._bound(armed.topic)) is not None:
            known = self.known[key]
            known.armed = armed.model_copy(update={"field": _field("armed", armed.field, known)})
            if self.armed is None:  # what was said before anything showed what it is
                self._arm(known.armed, known.message)
        if thrusters is not None:
            each = list(thrusters.each)
            for number_, topic in enumerate(thrusters.topics):
                key = self._bound(topic)
                if key is not None:
                    path = _field("command", each[number_].field, self.known[key])
                    each[number_] = each[number_].model_copy(update={"field": path})
                    self.known[key].commands.append(number_)
            self.inputs = self.inputs.model_copy(
                update={"thrusters": thrusters.model_copy(update={"each": tuple(each)})}
            )
            if before != len(each):
                self._commands = [nan] * len(each)

    def _take(self, name: str, source: Source, known: Known) -> None:
        """From now on this quantity is taken from messages of a key; what the newest says holds."""
        completed = source.model_copy(update={"field": _field(name, source.field, known)})
        known.quantities.append((name, completed))
        values = _numbers(known.message, completed.field)
        if name not in self._latest and values:
            self._latest[name] = values[-1] * source.factor

    def _topics(self) -> list[Topic]:
        """What was heard, for the presets: what came first counts as the busiest. Of vehicles, one alone."""
        heard = [(key, known) for key, known in self.known.items() if known.fields]
        vehicle = next((bus_keys.system(key) for key, _ in heard if key.endswith("/ATTITUDE")), None)
        self._ignored = {
            key for key, _ in heard if key.endswith("/ATTITUDE") and bus_keys.system(key) not in (None, vehicle)
        }
        return [
            Topic(key, known.form.removeprefix("cdr:") if known.form.startswith("cdr:") else "", known.fields, -order)
            for order, (key, known) in enumerate(heard)
            if bus_keys.system(key) in (None, vehicle)
        ]

    def _bound(self, topic: str) -> str | None:
        """The key of a topic: the first that was heard of it."""
        if topic in self.known:
            return topic
        of_it = (key for key, known in self.known.items() if known.fields)
        return next((key for key in of_it if bus_keys.matches(topic, key, self.inputs.preset)), None)

    def _known(self, topic: str) -> Known | None:
        key = self._bound(topic)
        return None if key is None else self.known[key]

    def _source(self, name: str) -> Source | Thrusters | None:
        if name == TORQUE:
            return self.inputs.torque or self.inputs.thrusters
        return self.inputs.channels.get(name)


def _field(name: str, path: str, known: Known) -> str:
    """The path of a number: as it was told, within MAVLink's `message`, or where the form has it."""
    if path and path not in known.fields and f"message.{path}" in known.fields:
        return f"message.{path}"
    if path:
        return path
    if known.form in ("keelson", "incsvr"):
        return "value"
    kind = known.form.removeprefix("cdr:")
    return {RATE: RATES, TORQUE: TORQUES}.get(name, {}).get(kind, "data" if kind.startswith("std_msgs/") else "")


def _stamp(source: Source | Thrusters, known: Known | None) -> tuple[str, float]:
    """Path of the stamp in a message, empty where the time of arrival counts, and seconds over its unit."""
    if source.stamp == ARRIVAL or known is None:
        return "", 1.0
    if source.stamp:
        return _field("", source.stamp, known), STAMPS[source.stamp_unit]
    if known.form == "keelson":
        return "timestamp", 1.0
    if known.form == "incsvr":
        return "t", 1.0
    if has_header(known.form.removeprefix("cdr:")):
        return "header.stamp", 1.0
    for path, factor in (("message.time_boot_ms", 1e-3), ("message.time_usec", 1e-6)):
        if path in known.fields:
            return path, factor
    return "", 1.0


def _stamps(message: Any, path: str, factor: float) -> list[float] | None:
    found = _numbers(message, path) if path else None
    return None if found is None else [stamp * factor for stamp in found]


def _numbers(message: Any, path: str) -> list[float] | None:
    """The number at a path; of our own form all of them."""
    if isinstance(message, dict) and path in message and isinstance(message[path], list):
        return [nan if (value := as_float(each)) is None else value for each in message[path]]
    found = number(message, path)
    return None if found is None else [found]


def _on_a_bus(name: str, cure: str) -> str:
    if cure.startswith(NOTHING[name][:12]):
        return f"nothing that was heard is the {name}: say where it comes in inputs.{name}, with topic, form and field"
    return cure
