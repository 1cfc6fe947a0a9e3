"""What people call effects, their parameters, channels and instants, with units."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from typing import Any

from incsvr.plant.words import YAW_WORDS, AxisWords
from incsvr.tracing.sentences import LABELS
from service.inputs.units import si_unit


def words(key: str) -> str:
    """A key in words: `torque_lag` is Torque lag."""
    text = key.replace("_", " ").strip()
    return f"{text[:1].upper()}{text[1:]}"


def clock_text(seconds: float) -> str:
    """The vehicle's time in words: seconds since its start, or the date where it counts from 1970."""
    if seconds > 1e8:
        return datetime.fromtimestamp(seconds).strftime("%Y-%m-%d %H:%M:%S")
    return f"{seconds:.1f} s"


def effect(name: str) -> str:
    """An effect in words: `coupling:thruster_3_speed` is Coupling to thruster 3 speed."""
    kind, _, channel = name.partition(":")
    return words(kind) + (f" {'by' if kind == 'modulation' else 'to'} {channel.replace('_', ' ')}" if channel else "")


def channel(name: str) -> str:
    """A channel in words with the unit of its name where it is a known one: `depth` is Depth [m]."""
    unit = si_unit(name)
    return words(name) + (f" [{unit}]" if unit else "")


def parameter(name: str, value: float, interval: Any = None, axis: AxisWords = YAW_WORDS) -> str:
    """A parameter with its value, interval and unit: time constant 0.71 s (0.66 to 0.76)."""
    label, unit = LABELS.get(name, (name.replace("_", " "), ""))
    known = f"{value:.3g} {axis.fill(unit)}" if isinstance(value, float | int) else str(value)
    shown = f"{axis.fill(label)} {known}".rstrip()
    return shown + (f" ({interval[0]:.3g} to {interval[1]:.3g})" if interval and interval[0] < interval[1] else "")


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
