"""Parameters of vehicles, message by message: each counts from when it was received, for the vehicle that sent it."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import Any

from service.inputs import ardusub_frames
from service.inputs.arming import MAX_WHOLE_NUMBER
from service.inputs.forms import as_float

MAX_CHANGES_SHOWN = 6
"""Changes that are kept to be shown, the newest."""


class VehicleParameters:
    """The parameters that vehicles have sent.

    Args:
        kept: as `by_system` gave it in an earlier process, or names and values of no vehicle that is known.

    Attributes:
        by_system: values by name, by vehicle; under an empty name those of which nobody knows the vehicle.
    """

    def __init__(self, kept: Mapping[str, Any] | None = None) -> None:
        self.by_system: dict[str, dict[str, float]] = {}
        for name, value in (kept or {}).items():
            if isinstance(value, Mapping):
                self.by_system[name] = dict(value)
            else:
                self.by_system.setdefault("", {})[name] = float(value)
        self._changes: dict[str, deque[str]] = {}

    def of(self, system: str) -> dict[str, float]:
        """The parameters of a vehicle; before one is taken, those of the only one that sent any."""
        known = [name for name in self.by_system if name]
        system = known[0] if not system and len(known) == 1 else system
        return {**self.by_system.get("", {}), **(self.by_system.get(system, {}) if system else {})}

    def take(self, system: str, message: Any, when: float | None) -> bool:
        """Takes a PARAM_VALUE of a vehicle, as JSON, at a time of its clock [s]; True where it changes something."""
        body = message.get("message") if isinstance(message, dict) else None
        if not isinstance(body, dict):
            return False
        name, value = body.get("param_id"), as_float(body.get("param_value"))
        if isinstance(name, list):
            name = "".join(str(each) for each in name)
        if not isinstance(name, str) or value is None or not abs(value) < MAX_WHOLE_NUMBER:
            return False
        name = name.partition("\0")[0]
        told = self.by_system.setdefault(system, {})
        if not ardusub_frames.concerns_thrusters(name) or told.get(name) == value:
            return False
        if name in told and when is not None:
            changes = self._changes.setdefault(system, deque(maxlen=MAX_CHANGES_SHOWN))
            changes.append(f"{change_words(name, value, told[name])} from {when:.6g} s on")
        told[name] = value
        return True

    def note(self, system: str) -> tuple[str, ...]:
        """The sentence on a vehicle's changed parameters."""
        changes = self._changes.get(system, ())
        return (f"parameters changed during the log, and apply from then on: {', '.join(changes)}",) if changes else ()


def change_words(name: str, value: float, before: float) -> str:
    """A change of a parameter, such as `MOT_1_DIRECTION -1 (1 before)`."""
    return f"{name} {value:g} ({before:g} before)"
