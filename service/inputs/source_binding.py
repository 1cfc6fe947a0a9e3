"""A key of the bus that was heard: how its messages are read, and where in one the numbers and the stamp stand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import nan
from typing import Any

from service.inputs.forms import as_float, number
from service.inputs.forms.cdr import has_header
from service.inputs.presets.ros import RATE_PATHS, TORQUE_PATHS
from service.inputs.settings import ARRIVAL, Armed, Source, Thrusters
from service.inputs.table import HEADER_STAMP, usual_stamp
from service.inputs.units import STAMP_UNITS
from service.inputs.vehicles import VehicleEvidence

RATE, TORQUE, VOLTAGE, SURGE = "yaw_rate", "torque", "voltage", "surge"


@dataclass(slots=True)
class SourceBinding:
    """A key that was heard.

    Attributes:
        form: of its messages.
        decode: what reads them; None where nothing does.
        fields: paths of what stands in them, as the first one showed.
        message: the newest.
        count: of messages; the first and the last of them came at these times [s].
        quantities: what is taken from them, by name.
        commands: the thrusters whose commands stand in them, by their numbers.
        armed: how they say whether the thrusters may turn.
        evidence: what they show of the vehicle that they are of.
    """

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
    evidence: VehicleEvidence | None = None

    @property
    def type(self) -> str:
        """The type of its messages, where they are CDR."""
        return self.form.removeprefix("cdr:") if self.form.startswith("cdr:") else ""

    def path(self, name: str, told: str) -> str:
        """The path of a number: as configured, within MAVLink's `message`, or the form's own."""
        if told and told not in self.fields and f"message.{told}" in self.fields:
            return f"message.{told}"
        if told:
            return told
        if self.form in ("keelson", "incsvr"):
            return "value"
        usual = {RATE: RATE_PATHS, TORQUE: TORQUE_PATHS}.get(name, {}).get(self.type)
        return usual or ("data" if self.type.startswith("std_msgs/") else "")

    def stamp(self, source: Source | Thrusters) -> tuple[str, float]:
        """The path of the stamp, empty for the time of arrival, and its unit in seconds."""
        if source.stamp == ARRIVAL:
            return "", 1.0
        if source.stamp:
            return self.path("", source.stamp), STAMP_UNITS[source.stamp_unit]
        if self.form in ("keelson", "incsvr"):
            return {"keelson": "timestamp", "incsvr": "t"}[self.form], 1.0
        if has_header(self.type):
            return HEADER_STAMP, 1.0
        path, unit = usual_stamp(self.fields)
        return path, STAMP_UNITS[unit]

    def stamps(self, source: Source | Thrusters) -> list[float] | None:
        """The stamps of the newest message [s]; None where the time of arrival counts."""
        path, factor = self.stamp(source)
        found = self.numbers(path) if path else None
        return None if found is None else [stamp * factor for stamp in found]

    def numbers(self, path: str) -> list[float] | None:
        """The number at a path of the newest message; of our own form all of them."""
        message = self.message
        if isinstance(message, dict) and isinstance(message.get(path), list):
            return [nan if (value := as_float(each)) is None else value for each in message[path]]
        found = number(message, path)
        return None if found is None else [found]
