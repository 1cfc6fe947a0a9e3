"""What people call effects, their parameters, streams and channels, with units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from incsvr.tracing.sentences import LABELS

_UNITS = {
    "heading": "rad",
    "surge": "m/s",
    "sway": "m/s",
    "heave": "m/s",
    "roll_rate": "rad/s",
    "pitch_rate": "rad/s",
    "depth": "m",
    "voltage": "V",
    "temperature": "°C",
}
_ENDINGS = {"_speed": "rad/s", "_pwm": "µs", "_force": "N", "_torque": "N m"}
"""Units of the channels with known names (README of the recording's form), in full or by their end."""
_EVIDENCE = ("p_value", "share", "error")
_STEPS = {"t": "Vehicle time [s]", "at": "Vehicle time [s]", "step": "Step", "effect": "Effect", "why": "Why"}


def words(key: str) -> str:
    """A key in words: `torque_lag` is Torque lag."""
    text = key.replace("_", " ").strip()
    return f"{text[:1].upper()}{text[1:]}"


def effect(name: str) -> str:
    """An effect in words: `coupling:thruster_3_speed` is Coupling to thruster 3 speed."""
    kind, _, channel = name.partition(":")
    return words(kind) + (f" {'by' if kind == 'modulation' else 'to'} {channel.replace('_', ' ')}" if channel else "")


def channel(name: str) -> str:
    """A channel in words with its unit, where its name is a known one: `depth` is Depth [m]."""
    unit = _UNITS.get(name) or next((unit for end, unit in _ENDINGS.items() if name.endswith(end)), "")
    return words(name) + (f" [{unit}]" if unit else "")


def parameter(name: str, value: float, interval: Any = None) -> str:
    """A parameter with its value, interval and unit: time constant 0.71 s (0.66 to 0.76)."""
    label, unit = LABELS.get(name, (name.replace("_", " "), ""))
    shown = f"{label} {value:.3g} {unit}".rstrip() if isinstance(value, float | int) else f"{label} {value}"
    return shown + (f" ({interval[0]:.3g} to {interval[1]:.3g})" if interval and interval[0] < interval[1] else "")


def step(entry: Mapping[str, Any]) -> dict[str, str]:
    """One step of the ledger: headings and cells in words; its evidence stands with the effect."""
    return {_STEPS.get(key, words(key)): _cell(key, value) for key, value in entry.items() if key not in _EVIDENCE}


def _cell(key: str, value: Any) -> str:
    if key == "effect":
        return effect(str(value))
    if isinstance(value, Mapping):
        return ", ".join(parameter(name, number) for name, number in value.items())
    text = f"{value:.4g}" if isinstance(value, float) else str(value)
    return text.replace("|", "/").replace("\n", " ")
