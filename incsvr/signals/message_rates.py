"""Whether the streams come often enough for the vehicle that they show."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np

from incsvr.numerics import Array
from incsvr.plant.words import YAW_WORDS, AxisWords
from incsvr.signals.scales import time_scale

MAX_PERIOD_SCALES = 0.1
"""Period of the torque over the vehicle's time scale from which it is said. In 143 simulated recordings of 24 vehicles
(steps held for 0.8 to 2.4 s, torque at 1 to 20 Hz; seeds 780000 to 780023) a curve that was learned with the torque as
a measurement was off at its worst rate by less than a third below it, in nine of ten, and from 0.4 on by two thirds in
the median."""
JITTER_FACTOR = 1.05
"""Factor on the period that is asked for: what comes nearly as often is not too seldom."""
MAX_PAUSE_SPREAD = 0.5
"""Spread of the middle eight tenths of the pauses over their median, below which a stream is sampled; what is sent on
change alone is known between its messages, too."""


_CURES = {
    "blueos": "on ArduPilot by the message interval of SERVO_OUTPUT_RAW, or from the vehicle's own .BIN",
    "px4": "on PX4 by the high-rate bit of SDLOG_PROFILE, or by the topic's line in etc/logging/logger_topics.txt",
    "ros2": "by the rate at which the node publishes it",
    "keelson": "by the rate at which its connector publishes it",
}
"""The cures for a torque that is logged too seldom, by the kind of log."""
MIN_SCALE_SAMPLES = 2.0
"""Samples of a yaw rate within which it changes at least: of one that changes faster they show its noise, and not how
fast the vehicle is."""


@dataclass(frozen=True, slots=True)
class SlowTorque:
    """A torque that is sampled too seldom.

    Attributes:
        period: between its values [s].
        scale: within which the yaw rate changes [s].
        hertz: how often it would have to come.
    """

    period: float
    scale: float
    hertz: int

    def fault(self, words: AxisWords = YAW_WORDS) -> str:
        """The sentence for people, without the cure."""
        return (
            f"the {words.effort} is sampled every {self.period:.2g} s, too seldom for a vehicle whose {words.rate} "
            f"changes within {self.scale:.2g} s: the {words.effort} in between is unknown"
        )

    def of_a_log_by(self, preset: str | None) -> str:
        """The sentence with the cure in a preset's words; None is no preset's."""
        how = _CURES.get(preset or "", "")
        return f"{self.fault()}; record it at {self.hertz} Hz or more{f' ({how})' if how else ''}"

    def on_a_bus(self, asks: bool, words: AxisWords = YAW_WORDS) -> str:
        """The sentence with the cure, for who sends; `asks` where the vehicle can be asked from here."""
        cure = f": `incsvr inspect --bus --ask {self.hertz}` asks the vehicle for it" if asks else ""
        return f"{self.fault(words)}; send it at {self.hertz} Hz or more{cure}"


def slow_torque(rate: tuple[Array, Array], torque: tuple[Array, Array]) -> SlowTorque | None:
    """Whether the torque is sampled too seldom for how fast the vehicle turns.

    Args:
        rate: stamps (n,) [s] and yaw rates [rad/s].
        torque: stamps (m,) [s] and torques [N m].
    """
    steps = np.diff(torque[0])
    if steps.size < 8 or rate[0].size < 4 or not np.ptp(torque[1]) > 0.0:
        return None
    period = float(np.median(steps))
    low, high = np.quantile(steps, (0.1, 0.9))
    even = float(np.median(np.diff(rate[0])))
    scale = time_scale([np.interp(np.arange(rate[0][0], rate[0][-1], even), *rate)], even)
    if high - low > MAX_PAUSE_SPREAD * period or scale <= MIN_SCALE_SAMPLES * even:
        return None
    hertz = ceil(1.0 / (MAX_PERIOD_SCALES * scale))
    return None if period * hertz < JITTER_FACTOR else SlowTorque(period, scale, hertz)
