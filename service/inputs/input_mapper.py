"""The mapper on a bus: what comes is decoded, and the mapping is resolved by all that has come until then.

Nothing here knows the bus: keys and payloads come in, in the order in which they arrived, and all that goes out follows
from them and, where messages bear no stamps, from when they arrived. A preset looks at what has been heard so far. What
a configuration names goes before what a preset finds, and what the vehicle says before what is assumed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import replace
from math import nan
from typing import Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from service.inputs import ardusub, bus_keys, owners, vehicles
from service.inputs.arming import MAX_WHOLE_NUMBER, Arming, armed_by
from service.inputs.clocks import MAX_DELAY_S
from service.inputs.forms import Undecodable, decoder, number
from service.inputs.forms.own import InvalidMeasurement, parse
from service.inputs.key_resolution import SETTLED_MESSAGES, named_topics, resolve, with_settled_sources
from service.inputs.live_clock import RATE, LiveClock
from service.inputs.mapper import (
    TORQUE,
    FieldPlace,
    State,
    has_unknown_voltage,
    read_with,
    real_values,
    silent_outputs,
    take,
)
from service.inputs.outputs import without_pulse
from service.inputs.presets import RATE_PATHS
from service.inputs.self_description import VehicleParameters, parameters_in
from service.inputs.senders import SenderWatch, sentence
from service.inputs.settings import ARRIVAL, Armed, Axis, Inputs, Source
from service.inputs.source_binding import SourceBinding, numbers
from service.inputs.table import MESSAGE, Table, Topic, leaves, table_of
from service.inputs.thrust import T200_NOMINAL_V
from service.inputs.units import FRACTION
from service.inputs.values import Values

MAX_KEYS = 1000
"""Keys that are looked at; what comes after so many is no vehicle's."""
GRACE_MESSAGES = 50
"""Messages until which the battery's voltage and the first pulse may come: a voltage is told every few seconds."""
Message = tuple[str, bytes, float]
"""Key, payload, and when it arrived [s]."""


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
        numbers: name and number of the messages of streams in our own form, until they are taken.

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
        self.numbers: list[tuple[str, int]] = []
        self._count, self._came = 0, dict[str, list[Values]]()
        self._wanted_vehicle = vehicles.named_vehicle(inputs)
        self._vehicles = vehicles.Vehicles(self._wanted_vehicle)
        self._begin()
        self._resolved = resolve(inputs, self.bindings, self.parameters)

    def _begin(self) -> None:
        """Nothing has been heard of the vehicle that is taken from now on."""
        self._arming, self._senders, self._state = Arming(), SenderWatch(), State()
        self._open: list[tuple[SourceBinding, dict[str, list[float]], float, int]] = []
        self._open_at = self._armed_at = nan
        self.placed: dict[str, bool] = {}

    @property
    def inputs(self) -> Inputs:
        """The mapping in force; topics that were heard are named by their keys where a preset found them."""
        return self._resolved.inputs

    @property
    def missing(self) -> Mapping[str, str]:
        """Sentences on what was not found, by name."""
        thrusters = self._resolved.by_key.thrusters
        silent = [] if thrusters is None or self._early() else silent_outputs(thrusters, self._state)
        if thrusters is None or not silent:
            return self._resolved.missing
        return {**self._resolved.missing, TORQUE: without_pulse(thrusters, silent)}

    def _early(self) -> bool:
        """Whether so few commands have come that pulses and voltages may still come."""
        return sum(self.bindings[key].count for key in self.keys_of(TORQUE)) <= GRACE_MESSAGES

    @property
    def _clock(self) -> LiveClock:
        assert isinstance(self._state.clock, LiveClock)
        return self._state.clock

    @property
    def system(self) -> str:
        """The vehicle that is taken; empty where nothing says whose messages come."""
        return self._vehicles.chosen

    @property
    def parameters_by_system(self) -> dict[str, dict[str, float]]:
        """The parameters that each vehicle sent, as the next process takes them."""
        return {system: dict(told) for system, told in self._parameters.by_system.items()}

    @property
    def parameters(self) -> dict[str, float]:
        """The vehicle's parameters: a received value overrides the configuration's."""
        return {**self._configured.parameters, **self._parameters.of(self.system)}

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
    def why_not(self) -> str | None:
        """The reason why measurements are not learned from; None if they are."""
        return None if self._resolved.armed is None else self._arming.why_not(self._resolved.armed)

    def take(self, messages: Iterable[Message]) -> dict[str, Values]:
        """The values of messages in the order in which they arrived, by stream."""
        for key, payload, arrival in messages:
            self._decode(key, payload, arrival)
        self._map()
        came, self._came = self._came, {}
        return {name: Values.joined(parts) for name, parts in came.items()}

    def _decode(self, key: str, payload: bytes, arrival: float) -> None:
        """Reads a message, and lets its numbers wait; those that wait are mapped before anything that changes how."""
        binding = self.bindings.get(key)
        if binding is None:
            if len(self.bindings) >= MAX_KEYS:
                return
            binding = self.bindings[key] = self._new_binding(key)
            binding.first = arrival
        if binding.decode is None:
            return
        sequence = None
        try:
            if binding.form == "incsvr":
                t, values, sequence = parse(payload)
                message: Any = {"t": t, "value": values}
            else:
                message = binding.decode(payload)
        except (Undecodable, InvalidMeasurement) as error:
            self.refused[str(error) if isinstance(error, InvalidMeasurement) else "undecodable"] += 1
            return
        name = owners.mavlink_topic(key, message)
        if name != key:
            if name not in self.bindings and len(self.bindings) >= MAX_KEYS:
                return
            binding = self.bindings.setdefault(name, SourceBinding(binding.form, binding.decode, first=arrival))
        binding.message, binding.count, binding.last = message, binding.count + 1, arrival
        if binding.type in RATE_PATHS:
            binding.look_at_rate(RATE_PATHS[binding.type])
        if not binding.fields:
            self._map()
            binding.fields = tuple(path for path, _ in leaves(message)) or ("",)
            binding.evidence = vehicles.evidence_of(Topic(name, binding.type, binding.fields, 0))
            self._vehicles.meet(vehicles.vehicles_with_yaw_rate(named_topics(self.bindings)))
            self._resolve()
        self._look_at_vehicle(name, binding)
        armed = self._resolved.by_key.armed
        if armed is not None and armed.topic == name:
            self._arm(armed, message)
        self._wait(name, binding, arrival, sequence)

    def _wait(self, name: str, binding: SourceBinding, arrival: float, sequence: int | None) -> None:
        """Lets the numbers of a message wait that the mapping reads.

        Where commands come on several keys, what bears one stamp belongs to one moment, which is complete when a
        command of another stamp comes.
        """
        if not binding.numbers:
            return
        rows, reasons = binding.rows()
        self.refused.update(reasons)
        self._count += 1
        thrusters, came = self._resolved.by_key.thrusters, [(binding, rows, arrival, self._count)]
        if thrusters is not None and name in thrusters.topics and len(set(thrusters.topics)) > 1:
            stamp = rows.get(thrusters.stamp, [0.0])[-1] or arrival
            ended = self._open if stamp != self._open_at else []
            came, self._open, self._open_at = ended, [*self._open[len(ended) :], *came], stamp
        for each, numbers_of_it, at, count in came:
            if not each.fits(numbers_of_it):
                self._map()
            each.wait(numbers_of_it, at, count)
        if sequence is not None:
            sources = self._resolved.by_key.sources.items()
            self.numbers += [(stream, sequence) for stream, source in sources if source.topic == name]

    def _map(self) -> None:
        """Maps the messages that wait, of which all came while the vehicle was armed, or none."""
        tables = {key: table for key, binding in self.bindings.items() if (table := binding.table()) is not None}
        if not tables:
            return
        inputs, moved = self._resolved.by_key, self._state.moved
        learnable_from = -np.inf if self.why_not is None else np.inf
        self._state, streams, own = take(inputs, self._state, tables, further=self._further)
        if moved is None and self._state.moved is not None:
            self._arming.moved(self._resolved.armed)
            learnable_from = min(learnable_from, self._state.moved[1] if self.why_not is None else np.inf)
        for name, each in streams.items():
            if name in (RATE, TORQUE) and getattr(inputs, name) is not None:
                self._senders.add(name, each.t, each.value)
            # What was measured before the vehicle was armed, and comes late over a second link, is not learned from.
            late = (each.t < self._armed_at) & (each.t > self._armed_at - MAX_DELAY_S)
            if each.t.size:
                self._came.setdefault(name, []).append(replace(each, learnable=(each.order >= learnable_from) & ~late))
        self.placed |= {name: is_own for (name, _), is_own in own.items()}

    def _arm(self, settings: Armed, message: Any) -> None:
        """Takes what a message says of the armed state; those that wait are mapped before it changes."""
        value = number(message, settings.field)
        if value is None or not abs(value) < MAX_WHOLE_NUMBER:
            self.refused["no_field"] += 1
        elif (armed := armed_by(settings, value)) is not None:
            if armed is not self._arming.armed:
                self._map()
                self._armed_at = self._clock.newest if armed else nan
            self._arming.take(armed)

    def _look_at_vehicle(self, name: str, binding: SourceBinding) -> None:
        """Reads a message's parameters of its vehicle, and decides whether this vehicle is the one that is used."""
        if name.endswith("/PARAM_VALUE") and (sender := owners.mavlink(name)) is not None:
            self._map()
            ours = self.system in ("", sender.system)
            at = self._clock.newest if ours else nan
            told = parameters_in(Topic(name, "", (), 0), table_of(binding.message))
            changed = [self._parameters.take(sender.system, each, value, at) for _, each, value in told]
            if any(changed) and ours:
                self._resolve()
        if binding.evidence is None or self._vehicles.is_settled:
            return
        if self._vehicles.take(binding.evidence, lambda path: number(binding.message, path)):
            self._map()
            self._begin()
            self._resolve()

    def keys_of(self, name: str) -> list[str]:
        """The keys that a stream, or `armed`, comes from."""
        by_key = self._resolved.by_key
        source = by_key.armed if name == "armed" else by_key.sources.get(name)
        topics = [] if source is None else [source.topic]
        if name == TORQUE and by_key.thrusters is not None:
            topics += by_key.thrusters.topics
        return [key for key in self.bindings if key in topics]

    def notices(self) -> list[str]:
        """Notes for people on how the measurements are made."""
        inputs, thrusters = self.inputs, self.inputs.thrusters
        found = list[str]()
        if thrusters is not None and self._configured.thrusters is None and inputs.preset == "blueos":
            doubt = ardusub.assumption(self.parameters)
            found += [doubt] if doubt else []
        if not self._early() and has_unknown_voltage(self._resolved.by_key, self._state):
            found.append(
                f"the battery's voltage is unknown: the thrust is computed for {T200_NOMINAL_V:g} V; let the vehicle "
                "send it, or name it in inputs.channels.voltage"
            )
        if inputs.torque is not None and inputs.torque.unit == FRACTION and inputs.torque.scale == 1.0:
            found.append("the torque is a fraction of full thrust, not N m, until inputs.torque.scale is set")
        for name, own in self.placed.items():
            found += self._clock.doubts(name, own, self._stamped(name))
        found += self._turning_instead()
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

    def _turning_instead(self) -> list[str]:
        """A sentence on the keys whose yaw rate changes, where the one that is taken never did."""
        source = self._resolved.by_key.yaw_rate
        taken = None if source is None else self.bindings.get(source.topic)
        if source is None or taken is None or taken.type not in RATE_PATHS or taken.moved:
            return []
        moving = [key for key, each in self.bindings.items() if each.moved]
        if taken.count < SETTLED_MESSAGES or not moving:
            return []
        return [f"{RATE} from {source.topic} never changes, but {', '.join(moving[:4])} does: name it in inputs.{RATE}"]

    def _others(self) -> frozenset[str]:
        """The vehicles that are heard and left alone."""
        return self._vehicles.others(vehicles.present_vehicles(named_topics(self.bindings), self._wanted_vehicle))

    def _stamped(self, name: str) -> bool:
        """Whether the messages that a stream comes of bear stamps."""
        by_key = self._resolved.by_key
        source = by_key.sources.get(name, by_key.thrusters)
        return source is not None and source.stamp not in ("", ARRIVAL)

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
        by_key, latest = self._resolved.by_key, dict[FieldPlace, Values]()
        for source in read_with(by_key):
            values = self._newest(source)
            table = Table(None, {source.field: values, MESSAGE: np.full(values.size, -np.inf)}, {})
            rows = real_values(source, by_key, {source.topic: table})
            latest |= {(source.topic, source.field): rows} if rows.order.size else {}
        self._state = replace(self._state, latest={**latest, **self._state.latest})
        if by_key.armed is not None and self._arming.armed is None and by_key.armed.topic in self.bindings:
            self._arm(by_key.armed, self.bindings[by_key.armed.topic].message)

    def _newest(self, source: Source) -> Array:
        """The numbers of a source in the newest message of its key."""
        binding = self.bindings.get(source.topic)
        found = None if binding is None else numbers(binding.message, source.field)
        return np.array([] if found is None else found)
