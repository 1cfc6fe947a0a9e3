"""A stream in another unit: beyond what is plausible, or the vehicle would take up more energy than it was given."""

from __future__ import annotations

import numpy as np

from incsvr.checks.frozen_stream import STREAM_UNITS, STREAM_WORDS
from incsvr.checks.power import MIN_TURNING_RATE_SHARE, answer
from incsvr.checks.verdict import Decision, Finding
from incsvr.plant.words import YAW_WORDS, AxisWords
from incsvr.signals.raw import TORQUE
from incsvr.signals.samples import Samples

ENERGY_OVER_WORK = 5.0
"""Growth of the kinetic energy over the work of the largest torque from which on a unit is wrong: a declared inertia
may be wrong by some tenths, a yaw rate in degrees per second makes 57 of it."""
MIN_ANSWER_T = 6.0
"""Student's t from which on it is the torque that turns the vehicle: water turns one that rests, too."""

REACH_QUANTILE = 0.75
"""Quantile of what the inertia takes that is held against the torque's reach: a quarter of the samples of a batch."""
MAX_TORQUE_REACHES = 1.5
"""Whole reaches of the torque which the inertia alone must not take in these samples."""
MIN_INERTIA_NOISES = 10.0
"""Noise levels that the inertia takes at least: a gyro's noise, differentiated, asks for much where the filter is
short."""
IMPLAUSIBLE_SHARE = 0.2
"""Part of a stream's values beyond its limit from which on they are no single outliers."""
MIN_VALUES = 50
"""Values of which that part is taken."""


def implausible(name: str, refused: int, received: int, limit: float, words: AxisWords = YAW_WORDS) -> Finding | None:
    """Whether a stream is in another unit, by how many of the values received were refused as beyond its `limit`."""
    if received < MIN_VALUES or refused < IMPLAUSIBLE_SHARE * received:
        return None
    cure = "are they in {other_unit}?" if name == "yaw_rate" else "are they in another unit?"
    found = Finding(
        "unit",
        Decision.PAUSE,
        f"{100.0 * refused / received:.0f} % of the {STREAM_WORDS[name]}'s values are beyond the plausible ±{limit:g} "
        f"{STREAM_UNITS[name]}: {cure}",
    )
    return found.in_words(words)


def unit(batch: Samples, inertia: float, largest_rate: float, reach: float, sigma: float) -> list[Finding]:
    """Whether the yaw rate of a batch can be in rad/s.

    Args:
        inertia: as declared [kg m²].
        largest_rate: that the vehicle reaches [rad/s].
        reach: how far the torque usually goes from end to end [N m].
        sigma: noise level of a sample [N m]; infinite before it is known.
    """
    rate, torque = batch.yaw_rate, batch.raw[TORQUE]
    if len(batch) < 2 or float(np.max(np.abs(rate))) < 2.0 * MIN_TURNING_RATE_SHARE * largest_rate:
        return []
    # a torque that kept its side reaches from none
    energy, given = 0.5 * inertia * rate**2, max(float(np.ptp(np.append(torque, 0.0))), reach)
    gained = float(np.max(energy - np.minimum.accumulate(energy)))
    work = 0.5 * given * float(np.median(np.diff(batch.time))) * float(np.sum(np.abs(rate)))
    # what the declared inertia alone takes, of samples that stand apart as well
    asked = float(np.quantile(np.abs(torque - batch.damping), REACH_QUANTILE))
    if gained <= ENERGY_OVER_WORK * work and asked <= max(MAX_TORQUE_REACHES * given, MIN_INERTIA_NOISES * sigma):
        return []
    if answer(batch) < MIN_ANSWER_T:
        return []
    return [
        Finding(
            "unit",
            Decision.PAUSE,
            f"the {{rate}} reaches {float(np.max(np.abs(rate))):.3g} {{rate_unit}} from {batch.time[0]:.10g} to "
            f"{batch.time[-1]:.10g} s, faster than the {{effort}} can turn {inertia:g} {{inertia_unit}}: check the "
            "units of both, and the {inertia}",
        )
    ]
