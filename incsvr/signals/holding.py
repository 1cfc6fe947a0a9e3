"""A torque that is a command: it holds until the next one, and no line leads from one to the other (Section IV-A).

A command that is logged while it holds, as telemetry does it, repeats itself: between two messages that say the same
it was that all the time, however far apart they are; between two that differ nobody knows when it changed. So a sample
stands only where the command held throughout the filter's window, and for SETTLING_S before it, in which the rotors
follow. There the torque is known exactly, without any filter of its own, and the filter of the yaw rate is as narrow as
the gyro allows: what a slow stream cannot tell is left out, instead of smoothed over.

A command that does not repeat itself is one that was logged when it was given: it holds up to the stamp of the next.

Every result depends on the stamps and values around its own instant alone.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array, Streams
from incsvr.signals.filter_width import latest_steps, periods, widenings
from incsvr.signals.settings import (
    COMMANDED,
    MAX_PAUSE_S,
    MEASURED,
    MIN_WIDTH_PERIODS,
    SETTLING_S,
    TORQUE,
    WIDENING_FACTOR,
    YAW_RATE,
    SignalSettings,
)
from incsvr.signals.smoothing import HALF_WINDOW_WIDTHS, Smoothed, mean_period, nowhere, smooth

REPEATED_SHARE = 0.3
"""Share of a torque's messages that repeat the one before beyond which it is a command that was logged while it
held."""
MIN_HOLDING_SHARE = 0.1
"""Share of the instants of a slow torque at which it holds for a whole window, by how many of its messages repeat: with
fewer a line between them is better than next to no samples."""
MAX_HOLDING_PERIODS = 2.5
"""Periods of the torque after which it is no longer known to hold: one message may be lost."""
STEPS_PER_WIDTH = 6
"""Steps in a width of the filter as which a command that is not repeated is drawn."""


def filters(
    settings: SignalSettings, streams: Streams, at: Array, settled: float, on_a_line: bool
) -> tuple[NDArray[np.bool_], NDArray[np.int64], int]:
    """The filters of the samples at (m,) times [s].

    Args:
        streams: name → (stamps [s], values); the last PERIOD_STEPS before each instant must be there.
        settled: up to where all streams are known [s].
        on_a_line: whether samples are freed of what knows no torque but one on a line.

    Returns:
        (m,) whether the torque is a command that was logged while it held; (m,) by how many steps of WIDENING_FACTOR
        the filter is widened; how many of the instants, from the first on, have a filter that does not reach beyond
        what is known.
    """
    time, value = streams[TORQUE]
    period = periods(time, at)
    holding = np.zeros(at.size, dtype=bool) if on_a_line else _holds(settings, (time, value), at, period)
    commands = holding if on_a_line or settings.torque != COMMANDED else np.ones(at.size, dtype=bool)
    widening = widenings(settings, np.maximum(periods(streams[YAW_RATE][0], at), np.where(commands, 0.0, period)))
    until = np.where(commands, _known_until(time, settled), settled) if commands.any() else settled
    waits = np.flatnonzero((at + settings.reach * WIDENING_FACTOR**widening > until) & (commands | (widening > 0)))
    return holding, widening, int(waits[0]) if waits.size else at.size


def _holds(settings: SignalSettings, torque: tuple[Array, Array], at: Array, period: Array) -> NDArray[np.bool_]:
    """(m,) whether the torque of (stamps [s], values) is taken for a command logged while it holds, at (m,) times [s].

    Where nothing is configured this is asked of a torque that is too slow for the filter alone. It follows from the
    messages up to each instant.
    """
    if settings.torque == MEASURED:
        return np.zeros(at.size, dtype=bool)
    if settings.torque == COMMANDED:
        return np.asarray(_repeated(torque[1], torque[0], at) > REPEATED_SHARE)
    slow = MIN_WIDTH_PERIODS * period > settings.smoothing * (1.0 + 1e-9)
    if not slow.any():
        return slow
    spanned = 1.0 + (2.0 * settings.reach + SETTLING_S) / np.maximum(period, 1e-9)
    return np.asarray(slow & (_repeated(torque[1], torque[0], at) ** spanned >= MIN_HOLDING_SHARE))


def _repeated(value: Array, time: Array, at: Array) -> Array:
    """(m,) how many of a stream's latest messages repeat the one before, as a share."""
    if value.size < 2:
        return np.zeros(at.size)
    same, counted = latest_steps(np.diff(value) == 0.0, time, at)
    return np.asarray(same.sum(axis=1) / np.maximum(counted, 1))


def _known_until(time: Array, settled: float) -> float:
    """The newest stamp [s] up to which it is known whether the torque held."""
    last = int(np.searchsorted(time, settled, side="right")) - 1
    return -np.inf if last < 0 else float(time[last])


def held_command(time: Array, value: Array, at: Array, reach: float, gap: float) -> Smoothed:
    """The command around the instants at which it held throughout; NaN at the others.

    Args:
        time: (n,) stamps [s], strictly increasing.
        value: (n,) commands [N m].
        at: (m,) instants [s].
        reach: half the window of the yaw rate's filter [s].
        gap: longest pause between two messages of a stream that is not slow [s].
    """
    if time.size < 2:
        return nowhere(at.size)
    period = periods(time, at)
    first = np.searchsorted(time, at - reach - SETTLING_S, side="right") - 1
    last = np.searchsorted(time, at + reach, side="left")
    inside = (first >= 0) & (last < time.size)
    head, tail = np.maximum(first, 0), np.minimum(last, time.size - 1)
    changes = np.concatenate(([0], np.cumsum(np.diff(value) != 0.0)))
    steps = np.diff(time)
    longest = np.maximum(gap, np.minimum(MAX_HOLDING_PERIODS * period, MAX_PAUSE_S))
    without_gap = np.array([steps[a:b].max(initial=0.0) for a, b in zip(head, tail, strict=True)]) <= longest
    held_there = inside & (changes[head] == changes[tail]) & without_gap
    known = np.where(held_there, value[head], np.nan)
    return Smoothed(
        value=known,
        slope=np.where(held_there, 0.0, np.nan),
        spread=np.where(held_there, 0.0, np.nan),
        low=known,
        high=known,
        step=np.full(at.size, np.inf),
        count=(tail - head + 1).astype(np.float64),
        spikes=np.zeros(at.size),
        period=mean_period(time, head, tail),
    )


def stepped_command(time: Array, value: Array, at: Array, smoothing: float, gap: float) -> Smoothed:
    """A command that holds until the stamp of the next one, through the filter of the yaw rate.

    Args:
        time: (n,) stamps [s], strictly increasing.
        value: (n,) commands [N m].
        at: (m,) instants [s].
        smoothing: the filter's width [s].
        gap: longest pause of a stream that is not slow [s].
    """
    if time.size < 2:
        return smooth(time, value, at, smoothing=smoothing, gap=gap)
    step, reach = smoothing / STEPS_PER_WIDTH, HALF_WINDOW_WIDTHS * smoothing
    begin, end = np.ceil(time[:-1] / step), np.ceil(np.minimum(time[1:], time[:-1] + MAX_PAUSE_S) / step)
    counts = np.maximum(end - begin, 0.0).astype(np.intp)
    starts = np.cumsum(counts) - counts
    index = np.repeat(begin - starts, counts) + np.arange(counts.sum())
    drawn = smooth(np.asarray(index * step), np.repeat(value[:-1], counts), at, smoothing=smoothing, gap=gap)
    # When it changed is known: nothing of its slope is in doubt.
    first = np.minimum(np.searchsorted(time, at - reach, side="left"), time.size - 1)
    last = np.maximum(np.searchsorted(time, at + reach, side="right") - 1, 0)
    period = mean_period(time, first, np.maximum(last, first))
    return replace(drawn, period=period, slope=np.where(drawn.complete, 0.0, np.nan))
