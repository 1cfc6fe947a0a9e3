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
from service.inputs import bus_keys, frames
from service.inputs.arming import says_armed
from service.inputs.clock_of_rate import ClockOfRate
from service.inputs.forms import Undecodable, as_float, decoder, number
from service.inputs.forms.own import Refused, parse
from service.inputs.known import RATE, TORQUE, Known
from service.inputs.resolving import ANGLE, resolved, steady
from service.inputs.settings import Armed, Inputs
from service.inputs.thrust import T200_NOMINAL
from service.inputs.told_torque import ToldTorque
from service.inputs.units import FRACTION
from service.logs.gathering import leaves

LARGEST = 2.0**53
"""Flags and states are whole numbers below."""
MOST = 1000
"""Keys that are looked at; what comes after so many is no vehicle's."""


@dataclass(frozen=True, slots=True)
class Heard:
    """Values of a stream: stamps [s], values in SI units, and the message's number where it has one."""

    name: str
    t: list[float]
    value: list[float]
    sequence: int | None = None


class Hearing:
    """What one learner hears; one thread calls it.

    Args:
        inputs: the mapping of the configuration.
        parameters: of the vehicle, as an earlier process heard them.

    Attributes:
        keys: the key expressions to listen to.
        known: the keys that were heard.
        types: of ROS 2, by key, where something else than the key says them.
        told: parameters that the vehicle told, and that have to do with its thrusters.
        armed: whether the thrusters may turn; None before anything says so.
        refused: messages that are no measurements, by reason.
        placed: by stream, whether its own stamps count, or its times of arrival.

    Raises:
        BadInput: the configuration names a type that is not read, or a topic that is no key expression.
    """

    def __init__(self, inputs: Inputs, parameters: Mapping[str, float] | None = None) -> None:
        self._configured = inputs
        self.keys = bus_keys.listened(inputs)
        for _, form in bus_keys.forms(inputs):
            decoder(form)
        self.known: dict[str, Known] = {}
        self.types: dict[str, str] = {}
        self.told = dict(parameters or {})
        self.armed: bool | None = False if inputs.armed is not None and inputs.armed.events else None
        self.refused: Counter[str] = Counter()
        self.placed: dict[str, bool] = {}
        self._clock, self._torque = ClockOfRate(), ToldTorque()
        self._latest: dict[str, float] = {}
        self._resolved = resolved(inputs, self.known, self.parameters)

    @property
    def inputs(self) -> Inputs:
        """The mapping in force; topics that were heard are named by their keys where a preset found them."""
        return self._resolved.inputs

    @property
    def missing(self) -> Mapping[str, str]:
        """Sentences on what was not found, by name."""
        return self._resolved.missing

    @property
    def parameters(self) -> dict[str, float]:
        """Of the vehicle: what it told goes before what the configuration says."""
        return {**self._configured.parameters, **self.told}

    @property
    def notes(self) -> tuple[str, ...]:
        """What a preset concluded, one sentence each."""
        return self._resolved.notes

    @property
    def may_learn(self) -> bool:
        """Whether the thrusters may turn, as far as anything says so."""
        return self._resolved.armed is None or self.armed is True

    @property
    def why_not(self) -> str | None:
        """Why nothing that comes is learned from; None where it is."""
        source = self._resolved.armed
        if source is None or self.armed:
            return None
        if self.armed is None:
            return f"nothing has said yet whether the vehicle is armed; {source.topic} would"
        return f"the vehicle is not armed (by {source.topic}), so that there is nothing to learn from"

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
                known.message = {"t": t, "value": values}
            else:
                known.message = known.decode(payload)
        except (Undecodable, Refused) as error:
            self.refused[str(error) if isinstance(error, Refused) else "undecodable"] += 1
            return []
        if not known.fields:
            known.fields = tuple(path for path, _ in leaves(known.message)) or ("",)
            self._resolve()
        if key.endswith("/PARAM_VALUE"):
            self._parameter(known.message)
        if known.armed is not None:
            self._arm(known.armed, known.message)
        told = list(self._told(known, arrival))
        return told if sequence is None else [replace(heard, sequence=sequence) for heard in told]

    def notices(self) -> list[str]:
        """What a person should know of how the measurements come about."""
        inputs, thrusters = self.inputs, self.inputs.thrusters
        found = []
        if thrusters is not None and self._configured.thrusters is None and inputs.preset == "blueos":
            doubt = frames.assumed(self.parameters)
            found += [doubt] if doubt else []
        if thrusters is not None and self._torque.guessed_voltage(thrusters, self._latest):
            found.append(
                f"nothing says the battery's voltage: the thrust is taken for that at {T200_NOMINAL:g} V; let the "
                "vehicle send it, or name it in inputs.channels.voltage"
            )
        if inputs.torque is not None and inputs.torque.unit == FRACTION and inputs.torque.scale == 1.0:
            found.append("the torque is a fraction of full thrust, not N m, until inputs.torque.scale says how much")
        for name, own in self.placed.items():
            found += self._of_its_clock(name, own)
        if self._resolved.ignored:
            other = min(self._resolved.ignored)
            found.append(f"{other} is heard as well and left alone: name the topics in inputs to take it instead")
        return found

    def _of_its_clock(self, name: str, own: bool) -> list[str]:
        """Whether the stamps of a stream are of the yaw rate's clock."""
        thrusters = self.inputs.thrusters
        stamped = [
            known.stamp(source)[0] for known in self.known.values() for of, source in known.quantities if of == name
        ]
        if name == TORQUE and thrusters is not None:
            stamped += [known.stamp(thrusters)[0] for known in self.known.values() if known.commands]
        if not own and any(stamped):
            return [f"the stamps of {name} are of another clock than those of yaw_rate: its times of arrival count"]
        lag = self._clock.behind(name)
        if lag is None:
            return []
        return [
            f"the stamps of {name} are {abs(lag):.2g} s {'behind' if lag > 0.0 else 'ahead of'} those of yaw_rate that "
            "arrive with them; if they are of another clock, set its stamp to arrival"
        ]

    def _told(self, known: Known, arrival: float) -> Iterator[Heard]:
        for name, source in known.quantities:
            values = known.numbers(source.field)
            if values is None:
                self.refused["no_field"] += 1
                continue
            values = [value * source.factor for value in values]
            if values:
                self._latest[name] = values[-1]
            if name.startswith(ANGLE[0]):
                continue
            stamps = known.stamps(source)
            if name == RATE:
                times = self._clock.reference(stamps, arrival)
            else:
                times, self.placed[name] = self._clock.placed(name, stamps, arrival)
            if len(times) == len(values):
                yield Heard(name, times, values)
            elif times:
                self.refused["unequal_length"] += 1
        thrusters = self.inputs.thrusters
        if thrusters is None or not known.commands:
            return
        if not self._torque.take(thrusters, known):
            self.refused["no_field"] += 1
            return
        times, self.placed[TORQUE] = self._clock.placed(TORQUE, known.stamps(thrusters), arrival)
        told = self._torque.told(thrusters, known, times[0], self._latest) if len(times) == 1 else None
        if told is not None:
            yield Heard(TORQUE, [told[0]], [told[1]])

    def _arm(self, settings: Armed, message: Any) -> None:
        value = number(message, settings.field)
        if value is None or not abs(value) < LARGEST:
            self.refused["no_field"] += 1
        else:
            self.armed = bool(says_armed(settings, np.array([value]))[0])

    def _parameter(self, message: Any) -> None:
        """A parameter of the vehicle; what it says goes before what was assumed."""
        body = message.get("message") if isinstance(message, dict) else None
        if not isinstance(body, dict):
            return
        name, value = body.get("param_id"), as_float(body.get("param_value"))
        if isinstance(name, list):
            name = "".join(str(each) for each in name)
        if not isinstance(name, str) or value is None or not abs(value) < LARGEST:
            return
        name = name.partition("\0")[0]
        if frames.relevant(name) and self.told.get(name) != value:
            self.told[name] = value
            self._resolve()

    def _meet(self, key: str) -> Known:
        """A key that is heard for the first time."""
        kind = self.types.get(key)
        form = bus_keys.form(key) or (f"cdr:{kind}" if kind else None)
        if form is None:
            preset = self._configured.preset
            told = (each for topic, each in bus_keys.forms(self._configured) if bus_keys.matches(topic, key, preset))
            form = next(told, "json")
        try:
            return Known(form, decoder(form))
        except BadInput:  # a type that a bridge announces, and that nothing is read from
            return Known(form, None)

    def _resolve(self) -> None:
        """The mapping by all that was heard until now; what the newest messages say holds."""
        configured = steady(self._configured, self.inputs, self.known)
        self._resolved = resolved(configured, self.known, self.parameters)
        for known in self.known.values():
            for name, source in known.quantities:
                values = known.numbers(source.field)
                if name not in self._latest and values:
                    self._latest[name] = values[-1] * source.factor
            if known.armed is not None and self.armed is None:
                self._arm(known.armed, known.message)
