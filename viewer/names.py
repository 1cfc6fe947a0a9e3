"""What people call effects, channels and instants, with units."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from typing import Any

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


def about(found: Mapping[str, Any]) -> str:
    """The sentence about an effect that was found, which has its values and intervals, without its name."""
    return str(found.get("sentence") or "").removeprefix(f"{found.get('effect')}: ")


def finding(found: Mapping[str, Any]) -> str:
    """An effect that was found: its name in words, and the sentence about it."""
    return ": ".join(filter(None, (effect(str(found.get("effect"))), about(found))))


def step(entry: Mapping[str, Any]) -> str:
    """One step of the ledger as a sentence; its evidence stands with the effect."""
    t, revision = entry.get("t", entry.get("at")), entry.get("revision")
    when = f"**{clock_text(t)}** " if isinstance(t, float | int) else ""
    served = "" if revision is None else f" (revision {revision})"
    about = str(entry.get("effect", "?"))
    # What is suspected says its effect's name again, which stands before it.
    why = str(entry.get("why", "")).removeprefix(f"{about}: ").replace("\n", " ")
    return f"{when}{effect(about)}: {entry.get('step', '?')}{f': {why}' if why else ''}{served}"
