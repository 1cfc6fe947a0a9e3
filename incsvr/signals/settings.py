"""The settings by which streams become samples, and the filter that follows where they are left open."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Literal

from incsvr.errors import BadInput
from incsvr.signals.smoothing import HALF_WINDOW_WIDTHS

YAW_RATE = "yaw_rate"
"""Name of the stream of the velocity."""
TORQUE = "torque"
"""Name of the stream of the torque."""
REQUIRED = (YAW_RATE, TORQUE)
"""Streams without which there is no sample."""
MAX_CHANNELS = 64
"""Further streams that are kept, at most."""
RUN_PAUSE_S = 5.0
"""Time between two recordings that are joined to one [s]: longer than any gap that a window may hold."""
MAX_PAUSE_WIDTHS = 5.0 / 3.0
"""Longest pause that is bridged, in widths of the filter, where none is set: a window is six widths long."""
MAX_PAUSE_S = 4.0
"""Longest pause that is bridged where none is set [s]: joined recordings are further apart."""
MIN_WIDTH_PERIODS = 0.9
"""Width of the filter in periods of the slower stream, at least: pauses of 1.5 periods are bridged then."""
WIDENING_FACTOR = 1.25
"""Factor by which the filter is widened in each step, so that jitter of the stamps does not change it."""
MAX_WIDENING_STEPS = 4
"""Steps in which it is widened at most."""
ROTOR_LAG_S = 0.2
"""Lag by which rotors commonly trail their command [s]; a filter this wide forgives it where the torque is a
command."""
SETTLING_S = ROTOR_LAG_S
"""Time after a change for which a command that holds is not yet what acts [s]."""
TorqueKind = Literal["measured", "commanded"]
COMMANDED: TorqueKind = "commanded"
MEASURED: TorqueKind = "measured"
MAX_WIDENING = WIDENING_FACTOR**MAX_WIDENING_STEPS
"""Width of the filter in configured ones, at most: one that is wider would show another vehicle than the one that was
asked for."""


@dataclass(frozen=True, slots=True)
class SignalSettings:
    """The settings by which streams become samples.

    Attributes:
        inertia: moment of inertia with added mass about yaw, I [kg m²].
        sample_period: time between two samples [s]; from 5 · smoothing on their noise is nearly white.
        smoothing: standard deviation of the Gaussian low-pass filter [s].
        lateness: how far behind the newest of its stream a message may come and still count [s].
        gap: longest pause between two messages of a stream across which it still counts as continuous [s]; None
            follows the streams, and then the filter is widened for slow ones.
        rate_limit: largest plausible magnitude of the yaw rate [rad/s].
        torque_limit: largest plausible magnitude of the torque [N m].
        torque: "measured", so that it runs on a line from one message to the next, or "commanded", so that it holds
            until the next one; None takes a torque that is too slow for the filter and repeats itself for commanded.
        channels: further channels that every sample needs from the beginning; others join with their first message.
    """

    inertia: float = 350.0
    sample_period: float = 0.6
    smoothing: float = 0.12
    lateness: float = 0.2
    gap: float | None = None
    rate_limit: float = 1.0
    torque_limit: float = 500.0
    channels: tuple[str, ...] = ()
    torque: TorqueKind | None = None

    def __post_init__(self) -> None:
        for name in ("inertia", "sample_period", "smoothing", "gap", "rate_limit", "torque_limit"):
            value = getattr(self, name)
            if value is None and name == "gap":
                continue
            if not (isfinite(value) and value > 0.0):
                raise BadInput(f"{name} is {value}: give a positive, finite number")
        if self.torque not in (MEASURED, COMMANDED, None):
            raise BadInput(f"torque is {self.torque}: give measured, commanded, or None to infer it from the stream")
        if not (isfinite(self.lateness) and self.lateness >= 0.0):
            raise BadInput(f"lateness is {self.lateness}: give zero or a positive, finite number of seconds")
        if self.gap is not None and self.gap > 2.0 * self.smoothing:
            raise BadInput(
                f"a gap of {self.gap} s is longer than twice the smoothing of {self.smoothing} s, and the filter would "
                "bridge unmeasured time: raise the smoothing or lower the gap"
            )
        if self.gap is not None and self.gap >= RUN_PAUSE_S:
            raise BadInput(f"a gap of {self.gap} s would join recordings that are apart: keep it below {RUN_PAUSE_S} s")
        if len(self.channels) > MAX_CHANNELS:
            raise BadInput(f"{len(self.channels)} channels are declared: at most {MAX_CHANNELS} are kept")

    @property
    def reach(self) -> float:
        """Half the smoothing window [s]."""
        return HALF_WINDOW_WIDTHS * self.smoothing

    @property
    def widest_reach(self) -> float:
        """Half the window of a filter that was widened as far as it may be [s]."""
        return self.reach if self.gap is not None else self.reach * MAX_WIDENING

    @property
    def looks_back(self) -> float:
        """The time before a sample over which a stream is read, without the stream's period [s]."""
        return self.widest_reach + SETTLING_S

    @property
    def longest_pause(self) -> float:
        """The longest pause that is bridged, however wide the filter is [s]."""
        return self.bridged(self.smoothing * MAX_WIDENING)

    def bridged(self, smoothing: float) -> float:
        """The longest pause that a filter of this width bridges [s]."""
        return min(MAX_PAUSE_WIDTHS * smoothing, MAX_PAUSE_S) if self.gap is None else self.gap
