"""The survey of a mapping over some seconds: each input's values, rate, range, and doubts."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from incsvr.checks import implausible
from incsvr.numerics import Array, running_integral
from incsvr.signals.message_rates import slow_torque
from service.inputs.clocks import without_leaps
from service.inputs.input_mapper import InputMapper, Message
from service.inputs.live_clock import RATE
from service.inputs.mapper import TORQUE
from service.inputs.source_binding import SourceBinding
from service.inputs.values import Values

HEADING = "heading"
MIN_TURN_RAD = 0.2
"""The angle by which the heading must turn before it is held against the yaw rate [rad]: a compass wanders by a few
degrees."""
MIN_CHANGE_PART = 1e-9
"""The part of what is plausible within which a change is rounding, as where the moments of all thrusters cancel."""
AGREEMENT_RATIOS = (0.5, 2.0)
"""The angles turned by the yaw rate over those by the heading that agree; another unit makes 57 or 1/57 of it, the
other direction −1."""
UNIT_PACES = {1e3: "milliseconds", 1e6: "microseconds", 1e9: "nanoseconds"}
QUANTITY_WORDS = {RATE: "the yaw rate", TORQUE: "the torque"}


class Survey:
    """Follows what a mapping hears.

    Args:
        limits: largest plausible magnitude of the yaw rate [rad/s] and of the torque [N m].
    """

    def __init__(self, mapper: InputMapper, limits: dict[str, float]) -> None:
        self.mapper, self._limits = mapper, limits
        self._parts: dict[str, list[Values]] = {}

    def take(self, messages: Iterable[Message]) -> None:
        """Messages came."""
        for name, values in self.mapper.take(messages).items():
            self._parts.setdefault(name, []).append(values)

    @property
    def records(self) -> dict[str, Values]:
        """The values of each input that came until now."""
        self._parts = {name: [Values.joined(parts)] for name, parts in self._parts.items()}
        return {name: joined for name, (joined,) in self._parts.items()}

    def missing(self) -> dict[str, str]:
        """The inputs that did not arrive, by name: a sentence with the cure."""
        found = dict(self.mapper.missing)
        for name in (RATE, TORQUE):
            if name not in self.records and name not in found:
                found[name] = f"{QUANTITY_WORDS[name]} has not arrived on {', '.join(self._keys_of(name)) or 'any key'}"
        if self.mapper.armed is None and self.mapper.why_not is not None:
            found["armed"] = self.mapper.why_not
        return found

    def doubts(self) -> dict[str, list[str]]:
        """The doubts about each input, by name."""
        found = {name: self._doubts(name, came) for name, came in self.records.items()}
        heading = self._against_heading()
        if heading:
            found[RATE].append(heading)
        if RATE in self.records and TORQUE in self.records:
            slow = slow_torque(_stream(self.records[RATE]), _stream(self.records[TORQUE]))
            found[TORQUE] += [] if slow is None else [slow.on_a_bus(self.mapper.inputs.preset == "blueos")]
        return {name: sentences for name, sentences in found.items() if sentences}

    def summary(self) -> dict[str, Any]:
        """The survey as plain data."""
        doubts = self.doubts()
        inputs = {name: self._input(name, came, doubts.get(name, [])) for name, came in self.records.items()}
        heard = {
            key: {
                "count": binding.count,
                "rate_hz": _hertz(binding),
                "form": binding.form,
                "fields": list(binding.fields),
            }
            for key, binding in self.mapper.bindings.items()
        }
        return {
            "inputs": inputs,
            "armed": self.mapper.armed,
            "armed_by": next(iter(self.mapper.keys_of("armed")), None),
            "parameters": dict(self.mapper.parameters),
            "missing": self.missing(),
            "notices": list(dict.fromkeys((*self.mapper.notices(), *self.mapper.notes))),
            "refused": dict(self.mapper.refused),
            "heard": heard,
        }

    def _input(self, name: str, came: Values, doubts: list[str]) -> dict[str, Any]:
        finite, span = came.value[np.isfinite(came.value)], self._span(name)
        return {
            "keys": self.mapper.keys_of(name),
            "count": came.t.size,
            "rate_hz": (came.t.size - 1) / span if span > 0.0 else 0.0,
            "low": float(finite.min()) if finite.size else None,
            "high": float(finite.max()) if finite.size else None,
            "stamps": "arrival" if self.mapper.placed.get(name) is False else "own",
            "doubts": doubts,
        }

    def _span(self, name: str) -> float:
        """The time over which the messages of an input arrived [s]."""
        heard = [self.mapper.bindings[key] for key in self.mapper.keys_of(name)]
        return max(each.last for each in heard) - min(each.first for each in heard) if heard else 0.0

    def _keys_of(self, name: str) -> list[str]:
        inputs = self.mapper.inputs
        source = inputs.yaw_rate if name == RATE else inputs.torque
        if source is not None:
            return [source.topic]
        return [] if name == RATE or inputs.thrusters is None else sorted(set(inputs.thrusters.topics))

    def _doubts(self, name: str, came: Values) -> list[str]:
        found = []
        values, span = came.value, self._span(name)
        limit = self._limits.get(name)
        if limit is not None:
            beyond = int(np.count_nonzero(~(np.abs(values) <= limit)))
            finding = implausible(name, beyond, values.size, limit)
            if finding is not None:
                found.append(finding.sentence)
            if values.size > 1 and np.ptp(values) < MIN_CHANGE_PART * limit:
                found.append(f"{QUANTITY_WORDS[name]} is constant at {round(values[0], 9):g}")
        if self.mapper.placed.get(name) is not False and span > 1.0:
            pace = float(np.ptp(came.t)) / span
            unit = next((unit for factor, unit in UNIT_PACES.items() if 0.5 < pace / factor < 2.0), None)
            if unit is not None:
                found.append(f"its stamps count {unit}: set stamp_unit")
            elif pace == 0.0:
                found.append("its stamps do not change: use the time of arrival (stamp: arrival)")
        return found

    def _against_heading(self) -> str | None:
        """Whether the yaw rate turns as the heading does, where there is one and it turned."""
        if RATE not in self.records or HEADING not in self.records:
            return None
        (time, rate), (stamps, heading) = _stream(self.records[RATE]), _stream(self.records[HEADING])
        if time.size < 3 or stamps.size < 3:
            return None
        turned = running_integral(time, rate)
        shown = np.interp(time, stamps, np.unwrap(heading))
        shown -= shown[0]
        if np.abs(shown).max() < MIN_TURN_RAD:
            return None
        ratio = float(turned @ shown / (shown @ shown))
        if AGREEMENT_RATIOS[0] < ratio < AGREEMENT_RATIOS[1]:
            return None
        why = "check its unit and that of the heading"
        if -AGREEMENT_RATIOS[1] < ratio < -AGREEMENT_RATIOS[0]:
            why = "one of the two has the opposite sign (sign: -1)"
        return f"it turns {ratio:.2g} times as far as the heading: {why}"


def _stream(came: Values) -> tuple[Array, Array]:
    """The values sorted by stamps, each once; where the clock was set by days, it goes on."""
    time, first = np.unique(came.t, return_index=True)
    return without_leaps(time)[0], came.value[first]


def _hertz(binding: SourceBinding) -> float:
    return (
        (binding.count - 1) / (binding.last - binding.first)
        if binding.count > 1 and binding.last > binding.first
        else 0.0
    )
