"""The yaw rate against a measured heading: the direction in which each counts, its unit, and a gyro's zero."""

from __future__ import annotations

from math import pi

import numpy as np

from incsvr.checks.verdict import Decision, Finding
from incsvr.numerics import Array, root_mean_square, running_integral
from incsvr.signals.raw import HEADING, HEADING_TIME
from incsvr.signals.samples import Samples

ZERO_SHARES = {Decision.WARN: 0.02, Decision.PAUSE: 0.04}
"""The gyro's zero, as a part of the largest yaw rate: a compass whose deviation changes by 3° in a batch feigns 0.7 %
of 0.25 rad/s."""
ZERO_SIGMAS = 5.0
"""Standard deviations beyond which a zero is believed."""
MIN_TURNED_RAD = 0.5
"""The angle [rad] that the gyro must have turned to and fro for a direction or a unit to be told."""
MIN_AGREEMENT = 0.7
"""Agreement of gyro and heading beyond which they turn together: both are noisy."""
MISSING_SAMPLE_STEPS = 1.5
"""Pause between two samples, in least steps between them, from which on some are missing."""
TILT_RATES = ("roll_rate", "pitch_rate")
"""Channels that show whether the vehicle stays level."""
MAX_TILT_RAD = 0.2
"""Angle [rad] through which a vehicle may roll or pitch in a batch and still turn its heading by its yaw rate: beyond,
ψ̇ = (q sin φ + r cos φ)/cos θ differs from r by more than a gyro's zero does."""
MIN_HEADINGS = 5
"""Headings of a batch from which anything is told."""


def against_heading(
    batch: Samples,
    largest_rate: float,
    parts: int = 4,  # of a batch, in each of which a zero must show: of fewer a deviation says nothing
) -> list[Finding]:
    """The findings of a measured heading on a batch's yaw rate; none without a heading."""
    if HEADING not in batch.raw:
        return []
    gyro, compass, lasted = _increments(batch, 2.0 * pi)
    if gyro.size < MIN_HEADINGS:
        return []
    span = f"from {batch.time[0]:.10g} to {batch.time[-1]:.10g} s"
    if float(np.abs(gyro).sum()) > MIN_TURNED_RAD:
        agree = _agree(gyro, compass)
        if agree < -MIN_AGREEMENT:
            return [
                Finding(
                    "heading reversed",
                    Decision.WARN,
                    f"heading and yaw rate count in opposite directions {span}; count both the same way, for a compass "
                    "counts clockwise",
                )
            ]
        if abs(agree) < MIN_AGREEMENT:
            degrees = abs(_agree(gyro, _increments(batch, 360.0)[1])) > MIN_AGREEMENT
            return [_unit(span)] if degrees else []
    if not _is_level(batch):
        return []
    bias = float((gyro - compass).sum() / lasted.sum())
    each = (gyro - compass) - bias * lasted
    # increments share their ends' errors, which cancel in the sum: the two ends of the batch are what is left
    doubt = root_mean_square(each) * float(np.sqrt(2.0)) / float(lasted.sum())
    # A gyro's zero is the same throughout a batch. A vehicle that tilts, whose angles nobody recorded, turns its
    # heading now more, now less than its yaw rate says.
    count = min(parts, gyro.size // 2)
    means = [part.mean() for part in np.array_split(gyro - compass, count)]
    spread = np.std(means, ddof=1) / float(lasted.mean() * np.sqrt(count))
    decision = max((d for d, part in ZERO_SHARES.items() if abs(bias) > part * largest_rate), default=Decision.CLEAN)
    if decision and abs(bias) > ZERO_SIGMAS * max(doubt, float(spread)):
        return [
            Finding(
                "gyro bias",
                decision,
                f"the yaw rate reads {bias:+.3g} rad/s more than the heading turns {span}; calibrate the gyro's zero",
            )
        ]
    return []


def _is_level(batch: Samples) -> bool:
    """Whether the vehicle rolls and pitches little, as far as its rates were recorded; their zeros do not count."""
    for name in TILT_RATES:
        rate = batch.channels.get(name)
        if rate is not None and np.isfinite(rate).all():
            angle = running_integral(batch.time, rate - rate.mean())
            if float(np.ptp(angle)) > MAX_TILT_RAD:
                return False
    return True


def _unit(span: str) -> Finding:
    return Finding("heading unit", Decision.WARN, f"the heading is in degrees {span}; give it in rad")


def _agree(gyro: Array, compass: Array) -> float:
    """Cosine of the angle between both: 1 where they say the same, also where one of them is larger."""
    size = float(np.sqrt((gyro @ gyro) * (compass @ compass)))
    return float(gyro @ compass) / size if size > 0.0 else 0.0


def _increments(batch: Samples, turn: float) -> tuple[Array, Array, Array]:
    """Angles by which gyro [rad] and heading turned between neighbouring headings, and how long it took [s].

    Args:
        turn: a whole turn in the heading's unit.
    """
    heading, stamp = batch.raw[HEADING], batch.raw[HEADING_TIME]
    new = np.flatnonzero(np.isfinite(heading) & (np.diff(np.nan_to_num(stamp), prepend=-np.inf) > 0.0))
    if new.size < 2:
        nothing = np.empty(0)
        return nothing, nothing, nothing
    turned = running_integral(batch.time, batch.yaw_rate)
    stamp, heading = stamp[new], heading[new]
    gyro = np.diff(np.interp(stamp, batch.time, turned))
    compass = (np.diff(heading) + 0.5 * turn) % turn - 0.5 * turn
    lasted = np.diff(stamp)
    # across a pause nobody knows how the vehicle turned
    kept = lasted <= 3.0 * float(np.median(np.diff(batch.time)))
    kept |= lasted <= 1.5 * float(np.median(lasted))
    kept &= stamp[:-1] >= batch.time[0]
    # nor where samples are missing, as wherever a command changed: there it turns otherwise than before and after
    step = np.diff(batch.time)
    missing = np.flatnonzero(step > MISSING_SAMPLE_STEPS * step.min())
    begun = np.searchsorted(batch.time[missing], stamp[1:], side="left")
    kept &= begun == np.searchsorted(batch.time[missing + 1], stamp[:-1], side="right")
    return gyro[kept], compass[kept], lasted[kept]
