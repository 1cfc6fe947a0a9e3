"""Streams that were filtered or resampled before they were exported: no smoothing here undoes that.

Three traces are looked for. A command of straight pieces was joined by lines. Where a held command steps, a vehicle
cannot answer before: a rate that does was filtered both ways, or the command's stamps are late. And samples (or means)
that come more slowly than the vehicle settles show where it settles, and not how.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from incsvr.checks.own_motion import least_squares
from incsvr.numerics import Array

Stream = tuple[Array, Array]
STRAIGHT_SHARE, MAX_BEND_SHARE = 0.7, 0.02
"""Share of a moving command without a bend, and how large a bend is none, in parts of its steps."""
SIX_DIGITS = 2e-5
"""Bend of a motion that is none, in parts of its size, where its values have six digits."""
MIN_REPEATS = 3
"""Times that each value of a motion comes from which on a slower stream was filled up: some send each value twice."""
MAX_PIECE = 50
"""Samples of a straight piece of a motion at most: from step to step of a command, a motion without noise has more."""
MIN_JOINT_SHARE, MIN_JOINTS = 0.3, 12
"""The bend at a joint in parts of the steps, and joints at least: a slow sine is straight, too, and has none."""
MIN_SLOPE_SPREAD = 0.1
"""Spread of the slopes below which a command's slope is limited: then its ramps are its own."""
MIN_STEPS = 15
"""Steps of a held command by which an early answer is seen."""
LEAD_PERIODS = 3
"""Periods of the rate before a step within which an early answer is looked for."""
MAX_EFFORT_PERIODS = 1.5
"""Periods of the rate that one of the effort is at most: a slower one is stamped when it is known."""
EARLY_DEVIATIONS = 3.5
"""Standard errors of an answer before its cause."""
MIN_EARLY_SHARE = 0.08
"""Answer before a step in parts of that in as long a time after it: a jitter of stamps makes less."""
MAX_PERIODS = 0.7
"""Periods within which a vehicle settles that is sampled too slowly: by then its motion shows no acceleration."""
RAW = "export the raw samples: the curve may be wrong by its own size, whatever error is given beside"


def filtered_export(rate: Stream, effort: Stream) -> str | None:
    """A sentence, a template of `AxisWords`, on streams that look filtered or resampled; None where they do not."""
    for name, values in (("effort", effort[1]), ("rate", rate[1])):
        if joined_by_lines(values, is_exact=name == "rate"):
            return f"the {{{name}}} has only straight pieces between joints, as where it was resampled by lines: {RAW}"
    count = repeats(rate[1])
    if count >= MIN_REPEATS:
        return f"the {{rate}} repeats each of its values {count} times, as where a slower stream was filled up: {RAW}"
    if answers_early(rate, effort):
        return (
            "the {rate} changes before the {effort} does, as where it was filtered both ways, or the {effort}'s stamps "
            f"are late: {RAW}"
        )
    settles = settling_periods(rate, effort)
    if settles is not None and settles < MAX_PERIODS:
        period = float(np.median(np.diff(rate[0])))
        return (
            f"the {{rate}} comes every {period:.2g} s, within which the vehicle settles: means or thinned samples, "
            f"which do not show its acceleration; {RAW}"
        )
    return None


def repeats(values: Array) -> int:
    """How many times each value of a motion (n,) comes, where nearly all come equally often; else 1."""
    lengths = np.diff(np.flatnonzero(np.concatenate(([True], np.diff(values) != 0.0, [True]))))
    if lengths.size < 3 * MIN_JOINTS:
        return 1
    usual = int(np.median(lengths))
    return usual if float(np.mean(lengths == usual)) > 0.9 else 1


def joined_by_lines(values: Array, is_exact: bool = False) -> bool:
    """Whether a stream (n,) consists of straight pieces of several samples between joints.

    Args:
        is_exact: the pieces are straight but for rounding, and equally long: of a motion without noise, neither is.
    """
    steps = np.diff(values)
    moving = steps[1:] != 0.0
    usual = float(np.median(np.abs(steps[steps != 0.0]))) if (steps != 0.0).any() else 0.0
    straightest = _rounding(values, usual) if is_exact else MAX_BEND_SHARE * usual
    if np.count_nonzero(moving) < 3 * MIN_JOINTS:
        return False
    bends = np.abs(np.diff(steps))[moving]
    joints = bends > MIN_JOINT_SHARE * usual
    straight = bends <= straightest
    slopes = np.abs(steps[1:][moving][straight])
    limited = slopes.size > 0 and float(np.ptp(np.quantile(slopes, (0.1, 0.9)))) < MIN_SLOPE_SPREAD * usual
    return bool(
        straight.mean() > STRAIGHT_SHARE
        and not limited
        and (not is_exact or _is_regular(1 + np.flatnonzero(moving)[joints]))
        and np.count_nonzero(joints) >= MIN_JOINTS
        and np.count_nonzero(straight | joints) > 0.9 * bends.size
    )


def _rounding(values: Array, usual: float) -> float:
    """The bend [their unit] that rounding makes of straight pieces of values (n,) with such usual steps."""
    levels = np.diff(np.unique(values))
    step = float(levels.min()) if levels.size else 0.0
    return max(2.0 * step if 20.0 * step < usual else 0.0, SIX_DIGITS * float(np.max(np.abs(values))))


def _is_regular(joints: NDArray[np.intp]) -> bool:
    """Whether joints (n,), by their samples, are so many periods of one length apart: no command of a vehicle is."""
    apart = np.diff(joints)
    period = int(np.quantile(apart, 0.05)) if apart.size else 0
    return 1 < period <= MAX_PIECE and float(np.mean(apart % period == 0)) > 0.9


def answers_early(rate: Stream, effort: Stream) -> bool:
    """Whether the rate answers a step of a held command before it comes."""
    (time, values), (stamps, command) = rate, effort
    size = np.abs(np.diff(command))
    steps = 1 + np.flatnonzero(size > 0.2 * np.std(command))
    reach = LEAD_PERIODS + 3
    held = [
        k
        for k in steps
        if reach <= k < command.size - LEAD_PERIODS
        and not np.ptp(command[k - reach : k])
        and not np.ptp(command[k : k + LEAD_PERIODS])
    ]
    period = float(np.median(np.diff(time)))
    slow = float(np.median(np.diff(stamps))) > MAX_EFFORT_PERIODS * period
    if slow or len(held) < MIN_STEPS:
        return False
    at, lead = stamps[held] - period, LEAD_PERIODS  # a command on a clock of its own is late by up to a period
    before, last, now, after = (np.interp(at + k * period, time, values) for k in (-lead - 1, -lead, 0, lead))
    old, change = command[np.array(held) - 1], command[held] - command[np.array(held) - 1]
    ahead = least_squares(now - last, [last, last * np.abs(last), old, last - before, change])
    follows = least_squares(after - now, [now, now * np.abs(now), old, change])
    return bool(
        abs(ahead.theta[4]) > EARLY_DEVIATIONS * ahead.error[4]
        and abs(ahead.theta[4]) > MIN_EARLY_SHARE * abs(follows.theta[3])
        and ahead.theta[4] * follows.theta[3] > 0.0
    )


def settling_periods(rate: Stream, effort: Stream) -> float | None:
    """The periods of the rate within which a vehicle settles; None where the effort does not explain its rate."""
    time, values = rate
    if time.size < 30:
        return None
    pushed = np.interp(time, *effort)
    now, last = values[1:], values[:-1]
    fit = least_squares(now, [last, pushed[1:], pushed[:-1], last * np.abs(last)])
    keeps = float(fit.theta[0] + 2.0 * fit.theta[3] * np.median(np.abs(last)))
    if fit.left > 0.2:
        return None
    return float(-1.0 / np.log(keeps)) if 1e-9 < keeps < 1.0 else (0.0 if keeps <= 1e-9 else None)
