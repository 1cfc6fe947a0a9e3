"""A recorded heading beside the integral of the yaw rate, over a whole recording: does it follow, does it drift.

The checks of a batch (heading.py) see a wrong direction, a wrong unit and a large drift; what is small adds up.
"""

from __future__ import annotations

import numpy as np

from incsvr.numerics import Array, robust_deviation, root_mean_square, running_integral

WINDOW_S = 60.0
"""Window over which both are compared [s]."""
MIN_TURNED_RAD = 0.3
"""Turn to and fro of the vehicle in one window (RMS) from which on anything is told [rad]."""
MAX_DIFFERENCE_SHARE = 0.7
"""Part of that turn which a heading differs by, counted either way, from which on it does not follow: a compass that
errs by 10° differs by half as much."""
MAX_DRIFT_RAD = 0.35
"""Drift over a whole recording that is borne [rad]: 20°, to both sides of which the deviation of a compass does not
reach."""
DRIFT_SIGMAS = 5.0
"""Standard deviations beyond which a drift is believed."""
MIN_WINDOWS = 3
"""Windows from which anything is told."""


def beside_yaw_rate(rate: tuple[Array, Array], heading: tuple[Array, Array]) -> str | None:
    """A sentence where the heading does not follow the yaw rate, or drifts away from it; None where neither is seen.

    Args:
        rate: stamps (n,) [s] and yaw rates [rad/s].
        heading: stamps (m,) [s] and headings [rad].
    """
    (time, values), (stamps, angle) = rate, heading
    if time.size < 2 or stamps.size < 2:
        return None
    turned = running_integral(time, values)
    inside = (stamps >= time[0]) & (stamps <= time[-1])
    stamps, angle = stamps[inside], np.unwrap(angle[inside])
    gyro = np.interp(stamps, time, turned)
    slopes, follows = [], []
    for begin in np.arange(stamps[0], stamps[-1] - WINDOW_S, WINDOW_S) if stamps.size else ():
        here = (stamps >= begin) & (stamps < begin + WINDOW_S)
        if here.sum() < 10:
            continue
        at = stamps[here] - begin
        moved, slope = _detrended(at, angle[here] - gyro[here])
        away, _ = _detrended(at, gyro[here])
        opposite, _ = _detrended(at, angle[here] + gyro[here])
        slopes.append(slope)
        if away > MIN_TURNED_RAD:
            follows.append(min(moved, opposite) / away)
    if len(follows) >= MIN_WINDOWS and float(np.median(follows)) > MAX_DIFFERENCE_SHARE:
        return (
            "the heading does not follow the yaw rate: it belongs to another clock, another sensor or another unit; "
            "leave its column out, or mend it"
        )
    if len(slopes) < MIN_WINDOWS:
        return None
    drift, span = float(np.median(slopes)), float(stamps[-1] - stamps[0])
    whole = float(angle[-1] - angle[0] - gyro[-1] + gyro[0])
    doubt = robust_deviation(np.array(slopes) - drift) * 1.2533 / np.sqrt(len(slopes))
    if min(abs(drift) * span, np.sign(drift) * whole) < MAX_DRIFT_RAD or abs(drift) < DRIFT_SIGMAS * doubt:
        return None
    return (
        f"the heading drifts by {drift:+.2g} rad/s against the yaw rate, {np.degrees(drift * span):+.3g}° in all: the "
        "zero of the gyro, or the compass; what depends on the heading is not to be trusted until one is calibrated"
    )


def _detrended(at: Array, values: Array) -> tuple[float, float]:
    """RMS of values beside their line, and its slope."""
    slope, level = np.polyfit(at, values, 1).tolist()
    return root_mean_square(values - level - slope * at), float(slope)
