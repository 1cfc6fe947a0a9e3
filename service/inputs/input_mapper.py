"""The mapping at work on a bus: one message after the other becomes measurements in SI units on one clock.

Nothing here knows the bus: keys and payloads come in, in the order in which they arrived, and all that goes out follows
from them and, where messages bear no stamps, from when they arrived. A preset looks at what has been heard so far. What
a configuration names goes before what a preset finds, and what the vehicle says before what is assumed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.plant.axes import AXES
from service.inputs import ardusub_frames, bus_keys, owners, vehicles
from service.inputs.ardusub_frames import VehicleParameters
from service.inputs.arming import Arming
from service.inputs.clocks import ClockOfRate
from service.inputs.forms import Undecodable, decoder, number
from service.inputs.forms.own import InvalidMeasurement, parse
from service.inputs.key_resolution import ANGLE_NAME, BATTERY_NAME, named_topics, resolve, with_settled_sources
from service.inputs.senders import SenderWatch, sentence
from service.inputs.settings import Armed, Axis, Inputs
from service.inputs.source_binding import RATE, TORQUE, VOLTAGE, SourceBinding
from service.inputs.table import Topic, leaves
from service.inputs.thrust import T200_NOMINAL_V, is_battery_voltage
from service.inputs.torque_of_commands import TorqueOfCommands
from service.inputs.units import FRACTION

MAX_KEYS = 1000
"""Keys that are looked at; what comes after so many is no vehicle's."""


@dataclass(frozen=True, slots=True)
class MappedValues:
    """Values of a stream: stamps [s], values in SI units, and the message's number where it has one."""

    name: str
    t: list[float]
    value: list[float]
    sequence: int | None = None


class InputMapper:
    """The inputs of one learner; one thread calls it.

    Args:
        inputs: the mapping of the configuration.
        parameters: of vehicles, as an earlier process heard them.

    Attributes:
        keys: the key expressions to listen to.
        bindings: the keys that were heard, each instance by itself.
        types: of ROS 2, by key, where something else than the key says them.
        refused: messages that are no measurements, by reason.
        placed: by stream, whether its own stamps count, or its times of arrival.

    Raises:
        BadInput: the configuration names a type that is not read, or a topic that is no key expression.
    """

    def __init__(
        self, inputs: Inputs, parameters: Mapping[str, Any] | None = None, further: tuple[Axis, ...] = ()
    ) -> None:
        self._configured, self._further = inputs, further
        if inputs.velocity_frame != "body" or any(inputs.velocity_place):
            raise BadInput("inputs.velocity_frame and inputs.velocity_place are applied to logs alone; leave them out")
        self.keys = bus_keys.key_expressions(inputs)
        for place in inputs.places():
            decoder(place.form)
        self.bindings: dict[str, SourceBinding] = {}
        self.types: dict[str, str] = {}
        self._parameters = VehicleParameters(parameters)
        self.refused: Counter[str] = Counter()
        self._wanted_vehicle = vehicles.named_vehicle(inputs)
        self._vehicles = vehicles.Vehicles(self._wanted_vehicle)
        self._begin()
        self._resolved = resolve(inputs, self.bindings, self.parameters)

    def _begin(self) -> None:
        """Nothing has been heard of the vehicle that is taken from now on."""
        self._arming = Arming()
        self.placed: dict[str, bool] = {}
        self._clock, self._torque, self._senders = ClockOfRate(), TorqueOfCommands(), SenderWatch()
        self._latest: dict[str, float] = {}

    @property
    def inputs(self) -> Inputs:
        """The mapping in force; topics that were heard are named by their keys where a preset found them."""
        return self._resolved.inputs

    @property
    def missing(self) -> Mapping[str, str]:
        """Sentences on what was not found, by name."""
        thrusters = self.inputs.thrusters
        silent = None if thrusters is None else self._torque.silent(thrusters)
        return self._resolved.missing if silent is None else {**self._resolved.missing, TORQUE: silent}

    @property
    def system(self) -> str:
        """The vehicle that is taken; empty where nothing says whose messages come."""
        return self._vehicles.chosen

    @property
    def told_parameters(self) -> dict[str, float]:
        """Parameters that the vehicle told, and that have to do with its thrusters."""
        return self._parameters.of(self.system)

    @property
    def parameters_by_system(self) -> dict[str, dict[str, float]]:
        """The parameters that each vehicle sent, as the next process takes them."""
        return {system: dict(told) for system, told in self._parameters.by_system.items()}

    @property
    def parameters(self) -> dict[str, float]:
        """The vehicle's parameters: a received value overrides the configuration's."""
        return {**self._configured.parameters, **self.told_parameters}

    @property
    def notes(self) -> tuple[str, ...]:
        """The conclusions of a preset and later changes, one sentence each."""
        others = self._others()
        of_vehicles = (self._vehicles.note(others),) if others else ()
        return (*of_vehicles, *self._resolved.notes, *self._parameters.note(self.system))

    @property
    def armed(self) -> bool | None:
        """Whether the thrusters may turn; None before anything says so."""
        events = self._resolved.armed is not None and self._resolved.armed.events
        return False if events and self._arming.armed is None else self._arming.armed

    @property
    def may_learn(self) -> bool:
        """Whether the thrusters may turn, as far as anything says so."""
        return self._resolved.armed is None or self.armed is True

    @property
    def why_not(self) -> str | None:
        """The reason why measurements are not learned from; None if they are."""
        return None if self._resolved.armed is None else self._arming.why_not(self._resolved.armed)

    def announce(self, key: str, kind: str) -> None:
        """A bridge says that messages of this type come on a key."""
        self.types[key] = kind

    def hear(self, key: str, payload: bytes, arrival: float) -> list[MappedValues]:
        """The measurements of a message that arrived at `arrival` [s] of a clock that never goes back."""
        binding = self.bindings.get(key)
        if binding is None:
            if len(self.bindings) >= MAX_KEYS:
                return []
            binding = self.bindings[key] = self._new_binding(key)
            binding.first = arrival
        if binding.decode is None:
            return []
        sequence = None
        try:
            if binding.form == "incsvr":
                t, values, sequence = parse(payload)
                message: Any = {"t": t, "value": values}
            else:
                message = binding.decode(payload)
        except (Undecodable, InvalidMeasurement) as error:
            self.refused[str(error) if isinstance(error, InvalidMeasurement) else "undecodable"] += 1
            return []
        name = owners.mavlink_topic(key, message)
        if name != key:
            if name not in self.bindings and len(self.bindings) >= MAX_KEYS:
                return []
            binding = self.bindings.setdefault(name, SourceBinding(binding.form, binding.decode, first=arrival))
        binding.message, binding.count, binding.last = message, binding.count + 1, arrival
        if not binding.fields:
            binding.fields = tuple(path for path, _ in leaves(message)) or ("",)
            binding.evidence = vehicles.evidence_of(Topic(name, binding.type, binding.fields, 0))
            self._vehicles.meet(vehicles.vehicles_with_yaw_rate(named_topics(self.bindings)))
            self._resolve()
        self._look_at_vehicle(name, binding)
        if binding.armed is not None:
            self._arm(binding.armed, binding.message)
        told = list(self._values_of(binding, arrival))
        return told if sequence is None else [replace(heard, sequence=sequence) for heard in told]

    def _look_at_vehicle(self, name: str, binding: SourceBinding) -> None:
        """Reads a message's parameters of its vehicle, and decides whether this vehicle is the one that is used."""
        if name.endswith("/PARAM_VALUE") and (sender := owners.mavlink(name)) is not None:
            ours = self.system in ("", sender.system)
            when = self._clock.newest if ours else None
            if self._parameters.take(sender.system, binding.message, when) and ours:
                self._resolve()
        if binding.evidence is None or self._vehicles.is_settled:
            return
        if self._vehicles.take(binding.evidence, lambda path: number(binding.message, path)):
            self._begin()
            self._resolve()

    def notices(self) -> list[str]:
        """Notes for people on how the measurements are made."""
        inputs, thrusters = self.inputs, self.inputs.thrusters
        found = list[str]()
        if thrusters is not None and self._configured.thrusters is None and inputs.preset == "blueos":
            doubt = ardusub_frames.assumption(self.parameters)
            found += [doubt] if doubt else []
        if thrusters is not None and self._torque.guessed_voltage(thrusters, self._latest):
            found.append(
                f"the battery's voltage is unknown: the thrust is computed for {T200_NOMINAL_V:g} V; let the vehicle "
                "send it, or name it in inputs.channels.voltage"
            )
        if inputs.torque is not None and inputs.torque.unit == FRACTION and inputs.torque.scale == 1.0:
            found.append("the torque is a fraction of full thrust, not N m, until inputs.torque.scale is set")
        for name, own in self.placed.items():
            found += self._clock.doubts(name, own, self._stamped(name))
        for name, source in ((RATE, inputs.yaw_rate), (TORQUE, inputs.torque)):
            share = self._senders.share(name)
            if source is not None and share is not None:
                found.append(sentence(name, source.topic, share))
        able = vehicles.vehicles_with_yaw_rate(named_topics(self.bindings))
        if not self._wanted_vehicle and self._others() & set(able):
            found.append(self._vehicles.note(self._others()))
        elif self._wanted_vehicle and able and self._wanted_vehicle not in able:
            found.append(f"vehicle {self._wanted_vehicle} (inputs.system) sends nothing, only {', '.join(able)}")
        if self._arming.by_movement and self._resolved.armed is not None:
            found.append(
                f"{self._resolved.armed.topic} has not reported the vehicle as armed, but its outputs move: it is "
                "assumed armed"
            )
        return found

    def _others(self) -> frozenset[str]:
        """The vehicles that are heard and left alone."""
        return self._vehicles.others(vehicles.present_vehicles(named_topics(self.bindings), self._wanted_vehicle))

    def _stamped(self, name: str) -> bool:
        """Whether the messages that a stream comes of bear stamps."""
        heard, thrusters = self.bindings.values(), self.inputs.thrusters
        stamps = [binding.stamp(source)[0] for binding in heard for of, source in binding.quantities if of == name]
        if name == TORQUE and thrusters is not None:
            stamps += [binding.stamp(thrusters)[0] for binding in heard if binding.commands]
        return any(stamps)

    def _values_of(self, binding: SourceBinding, arrival: float) -> Iterator[MappedValues]:
        for name, source in binding.quantities:
            values = binding.numbers(source.field)
            if values is None:
                self.refused["no_field"] += 1
                continue
            values = [value * source.factor for value in values]
            if values:
                self._remember(name, values[-1])
            if name.startswith(ANGLE_NAME[0]):
                continue
            stamps = binding.stamps(source)
            if name == RATE:
                times = self._clock.reference(stamps, arrival)
            else:
                times, self.placed[name] = self._clock.times_of(name, stamps, arrival)
            self._senders.add(name, times, values)
            if len(times) == len(values):
                yield MappedValues(name, times, values)
            elif times:
                self.refused["unequal_length"] += 1
        thrusters = self.inputs.thrusters
        if thrusters is None or not binding.commands:
            return
        if not self._torque.take(thrusters, binding):
            self.refused["no_field"] += 1
            return
        if self._torque.movement.has_moved:
            self._arming.moved(self._resolved.armed)
        times, self.placed[TORQUE] = self._clock.times_of(TORQUE, binding.stamps(thrusters), arrival)
        told = (
            self._torque.newest_efforts(thrusters, binding, times[0], self._latest, self._further)
            if len(times) == 1
            else None
        )
        if told is not None:
            names = (TORQUE, *(AXES[axis].effort for axis in self._further))
            for name, effort in zip(names, told[1], strict=True):
                yield MappedValues(name, [told[0]], [effort])

    def _remember(self, name: str, value: float) -> None:
        """The newest value of what commands are read with; that of a battery which is none is no voltage."""
        if name not in (VOLTAGE, BATTERY_NAME) or is_battery_voltage(np.array([value]))[0]:
            self._latest[name] = value

    def _arm(self, settings: Armed, message: Any) -> None:
        if not self._arming.take(settings, number(message, settings.field)):
            self.refused["no_field"] += 1

    def _new_binding(self, key: str) -> SourceBinding:
        """A key that is heard for the first time."""
        form = bus_keys.form_of(key, self.types.get(key), self._configured)
        try:
            return SourceBinding(form, decoder(form))
        except BadInput:  # a type that a bridge announces, and that nothing is read from
            return SourceBinding(form, None)

    def _resolve(self) -> None:
        """The mapping by all that was heard until now; what the newest messages say holds."""
        others = self._others()
        ours = {topic.name for topic in named_topics(self.bindings) if owners.system_of(topic) not in others}
        configured = with_settled_sources(self._configured, self.inputs, {key: self.bindings[key] for key in ours})
        self._resolved = resolve(configured, self.bindings, self.parameters, others)
        for binding in self.bindings.values():
            for name, source in binding.quantities:
                values = binding.numbers(source.field)
                if name not in self._latest and values:
                    self._remember(name, values[-1] * source.factor)
            if binding.armed is not None and self._arming.armed is None:
                self._arm(binding.armed, binding.message)
