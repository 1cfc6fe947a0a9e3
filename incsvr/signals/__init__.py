"""Streams with their own clocks, rates and faults become damping samples on one grid (Section IV-A)."""

from __future__ import annotations

from incsvr.signals.playing import play, synchronise
from incsvr.signals.settings import MAX_CHANNELS, REQUIRED, RUN_PAUSE_S, TORQUE, YAW_RATE, SignalSettings
from incsvr.signals.synchroniser import Synchroniser

__all__ = [
    "MAX_CHANNELS",
    "REQUIRED",
    "RUN_PAUSE_S",
    "TORQUE",
    "YAW_RATE",
    "SignalSettings",
    "Synchroniser",
    "play",
    "synchronise",
]
