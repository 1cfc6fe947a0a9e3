"""What people call effects, their parameters, streams and channels, with units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from incsvr.plant.words import YAW_WORDS, AxisWords
from incsvr.tracing.sentences import LABELS
from service.inputs.units import si_unit
from viewer.frame import clock_text


def words(key: str) -> str:
    """A key in words: `torque_lag` is Torque lag."""
    text = key.replace("_", " ").strip()
    return f"{text[:1].upper()}{text[1:]}"


def effect(name: str) -> str:
    """An effect in words: `coupling:thruster_3_speed` is Coupling to thruster 3 speed."""
    kind, _, channel = name.partition(":")
    return words(kind) + (f" {'by' if kind == 'modulation' else 'to'} {channel.replace('_', ' ')}" if channel else "")


def channel(name: str, unit: str = "") -> str:
    """A channel in words with its unit, or that of its name where it is a known one: `depth` is Depth [m]."""
    unit = unit or si_unit(name)
    return words(name) + (f" [{unit}]" if unit else "")


def parameter(name: str, value: float, interval: Any = None, axis: AxisWords = YAW_WORDS) -> str:
    """A parameter with its value, interval and unit: time constant 0.71 s (0.66 to 0.76)."""
    label, unit = _label(name, axis)
    shown = f"{label} {value:.3g} {unit}".rstrip() if isinstance(value, float | int) else f"{label} {value}"
    return shown + (f" ({interval[0]:.3g} to {interval[1]:.3g})" if interval and interval[0] < interval[1] else "")


def found_title(name: str, state: str, parameter: str, axis: AxisWords) -> str:
    """The title of a found effect's parameter: Torque lag, proven: time constant [s]."""
    label, unit = _label(parameter, axis)
    return f"{effect(name)}, {state}: {label}" + (f" [{unit}]" if unit else "")


def _label(parameter: str, axis: AxisWords) -> tuple[str, str]:
    """What a parameter is called, and its unit."""
    if parameter not in LABELS:
        return parameter.replace("_", " "), ""
    label, unit = LABELS[parameter]
    return axis.fill(label), axis.fill(unit)


def finding(found: Mapping[str, Any]) -> str:
    """An effect that was found: its name in words, and the sentence about it."""
    name = str(found.get("effect"))
    about = str(found.get("sentence") or "").removeprefix(f"{name}: ")
    return f"{effect(name)}: {about}" if about else effect(name)


def step(entry: Mapping[str, Any]) -> str:
    """One step of the ledger as a sentence; its evidence stands with the effect."""
    t, revision = entry.get("t", entry.get("at")), entry.get("revision")
    when = f"**{clock_text(t)}** " if isinstance(t, float | int) else ""
    served = "" if revision is None else f" (revision {revision})"
    about = str(entry.get("effect", "?"))
    # What is suspected says its effect's name again, which stands before it.
    why = str(entry.get("why", "")).removeprefix(f"{about}: ").replace("\n", " ")
    return f"{when}{effect(about)}: {entry.get('step', '?')}{f': {why}' if why else ''}{served}"
