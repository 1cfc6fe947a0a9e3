"""All streams of the recordings on one uniform grid, whatever their clocks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import median_filter

from incsvr.effects.signals import Signals
from incsvr.errors import BadInput
from incsvr.signals import scales
from incsvr.tracing.run import Array, Run, sample_period, stream

BETWEEN = 4
"""Parts of a sample period in which the yaw rate is followed."""

FEW_VALUES = 0.25
"""Of the samples: a torque of fewer values was recorded in steps."""

FEWEST_LEVELS = 8
"""Of a torque that stands most of the time: with fewer, going from one level to the next is no course in steps."""


def despiked(values: Array, threshold: float = 6.0) -> Array:
    """`values` with isolated spikes replaced by the median of their neighbourhood of five.

    Only samples whose neighbours agree are touched: a step of the command stays where it is.
    """
    if values.size < 7:
        return values
    calm = median_filter(values, 5, mode="nearest")
    away = np.abs(values - calm)
    # where the values run faster than they scatter most are their own median: the third differences know the scatter
    scale = max(1.4826 * float(np.median(away)), scales.white_noise(np.diff(values, 3)))
    if scale <= 0.0:  # a held command deviates by nothing but its resolution
        steps = np.abs(np.diff(values))
        scale = float(np.min(steps[steps > 0.0], initial=np.inf))
    spike = away > max(threshold * scale, 0.02 * float(np.std(values)))  # the top of a smooth sine is no spike
    spike[1:] &= ~(spike[:-1] & (away[:-1] > 0.5 * away[1:]))  # two in a row are no spike
    return np.where(spike, calm, values)


def time_scale(runs: Sequence[Run]) -> float:
    """T_c [s]: the lag at which the autocorrelation of the yaw rate falls below one half, over all runs together."""
    period = sample_period(runs, "yaw_rate")
    grids = []
    for piece in (piece for run in runs for piece in pieces(run)):
        at, rate = stream(piece, piece.yaw_rate)
        grids.append(np.interp(np.arange(at[0], at[-1], period), at, rate))
    return scales.time_scale(grids, period)


def settling_time(runs: Sequence[Run], inertia: float) -> float:
    """I σ(r)/σ(τ) [s]: in about that time the vehicle follows a slow command; infinite without one, 2 % of outliers
    at either end left out. `inertia` is the declared one [kg m²]."""
    rates = np.concatenate([stream(run, run.yaw_rate)[1] for run in runs])
    torques = np.concatenate([stream(run, run.torque)[1] for run in runs])
    rate_spread, torque_spread = (float(np.std(np.clip(x, *np.quantile(x, [0.02, 0.98])))) for x in (rates, torques))
    return inertia * rate_spread / torque_spread if torque_spread > 0.0 else np.inf


def _cells(at: Array, values: Array, centres: Array, width: float, zero_order_hold: bool) -> Array:
    """Mean of a stream over cells of `width` around `centres`: exact for its linear (or held) interpolation."""
    ends = _integral(at, values, np.stack([centres - 0.5 * width, centres + 0.5 * width]), zero_order_hold)
    mean: Array = (ends[1] - ends[0]) / width
    return mean


def _integral(at: Array, values: Array, when: Array, zero_order_hold: bool) -> Array:
    """Integral of a stream from its first stamp to `when`: exact for its linear (or held) interpolation."""
    steps = (values[:-1] if zero_order_hold else 0.5 * (values[1:] + values[:-1])) * np.diff(at)
    total = np.concatenate([[0.0], np.cumsum(steps)])
    where = np.clip(when, at[0], at[-1])
    index = np.clip(np.searchsorted(at, where, side="right") - 1, 0, at.size - 2)
    past = where - at[index]
    slope = 0.0 if zero_order_hold else (values[index + 1] - values[index]) / (at[index + 1] - at[index])
    inside = total[index] + past * (values[index] + 0.5 * slope * past)
    outside: Array = inside + np.minimum(when - at[0], 0) * values[0] + np.maximum(when - at[-1], 0) * values[-1]
    return outside


def _between(
    at: Array, rate: Array, when: Array, torque: Array, inertia: float, zero_order_hold: bool
) -> tuple[Array, Array]:
    """The yaw rate with stamps between its own: where a command jumps it has a corner, which a line cuts off.

    What the torque leaves of it, r − ∫τ/I₀ dt, has none, and is linear there: a higher order would carry more of the
    gyro's noise.
    """
    part = np.arange(BETWEEN) / BETWEEN
    dense = np.append((at[:-1, None] + np.diff(at)[:, None] * part).ravel(), at[-1])
    torque_rate = _integral(when, torque, dense, zero_order_hold) / inertia
    return dense, torque_rate + np.interp(dense, at, rate - torque_rate[::BETWEEN])


def _ends(at: Array, values: Array, centres: Array, step: float) -> Array:
    """Mean of a stream at both edges of each cell.

    The trapezoid rule over cell means is the mean over windows of two cells. Between the edges of those windows lies
    the acceleration that belongs to such a mean of the torque: not between cell means, where a block has few samples.
    """
    edges = [_cells(at, values, centres + side * step, 0.5 * step, False) for side in (-0.5, 0.5)]
    ends: Array = 0.5 * (edges[0] + edges[1])
    return ends


def on_fine_grid(
    runs: Sequence[Run], step: float, names: Sequence[str], zero_order_hold: bool, inertia: float
) -> Signals:
    """All runs on one uniform grid of `step` seconds: each stream averaged over cells of one step.

    Averaging every stream with the same kernel commutes with the (linear) equation of motion; streams of other rates,
    uneven stamps and missing cells need no case of their own.
    """
    parts: list[dict[str, Array]] = []
    channels: dict[str, list[Array]] = {name: [] for name in names}
    starts = [0]
    for run in runs:
        for piece in pieces(run):
            at, rate = stream(piece, piece.yaw_rate)
            when, torque = stream(piece, piece.torque)
            rate, torque = despiked(rate, 12.0), despiked(torque)
            begin, end = max(at[0], when[0]), min(at[-1], when[-1])
            centres = np.arange(begin, end + 0.25 * step, step)
            if centres.size < 5:
                continue
            at, rate = _between(at, rate, when, torque, inertia, zero_order_hold)
            part = {
                "time": centres,
                "rate": _cells(at, rate, centres, step, False),
                "ends": _ends(at, rate, centres, step),
                "torque": _cells(when, torque, centres, step, zero_order_hold),
            }
            for name in names:
                channels[name].append(_channel(piece, name, centres, step))
            parts.append(part)
            starts.append(starts[-1] + centres.size)
    if not parts:
        raise BadInput("yaw_rate and torque never overlap in time: check the stamps of the two streams")
    joined = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    start = np.array(starts, dtype=np.intp)
    others = {name: np.concatenate(values) for name, values in channels.items()}
    heading = others.pop("heading", None)
    signals = Signals(
        step=step,
        start=start,
        time=joined.pop("time"),
        rate=joined.pop("rate"),
        ends=joined.pop("ends"),
        torque=joined.pop("torque"),
        quantum=_quantum(runs),
        channels=others,
        rate_name=runs[0].rate_name,
    )
    return replace(signals, heading=signals.integral(signals.rate) if heading is None else heading)


def _quantum(runs: Sequence[Run]) -> float:
    """Step in which the torque was recorded [N m]; 0 where nearly every sample has a value of its own.

    Levels of a command that stands for some time tell nothing of it, unless the torque goes from one to the next: then
    it is a smooth course that was recorded in steps.
    """
    torque = [np.round(stream(run, run.torque)[1], 9) for run in runs]
    values = np.unique(np.concatenate(torque))
    size = sum(each.size for each in torque)
    if not 1 < values.size < FEW_VALUES * size:
        return 0.0
    rises = np.concatenate([np.diff(np.searchsorted(values, each)) for each in torque])
    rises = np.abs(rises[rises != 0])
    if 2 * rises.size < size and (values.size <= FEWEST_LEVELS or np.median(rises) > 1):
        return 0.0
    return float(np.median(np.diff(values)))


def _channel(run: Run, name: str, centres: Array, step: float) -> Array:
    at, values = stream(run, run.channels.get(name, np.full(run.time.size, np.nan)))
    if at.size < 2:
        return np.full(centres.size, np.nan)
    return _cells(
        at, np.asarray(np.unwrap(values) if name == "heading" else values, dtype=np.float64), centres, step, False
    )


def pieces(run: Run) -> list[Run]:
    """The run cut where one of the two streams pauses for more than a second and ten of its periods."""
    cuts = []
    for values in (run.yaw_rate, run.torque):
        at, _ = stream(run, values)
        gaps = np.diff(at)
        cuts += [(at[k], at[k + 1]) for k in np.flatnonzero(gaps > max(1.0, 10.0 * float(np.median(gaps))))]
    if not cuts:
        return [run]
    pieces = []
    begin = run.time[0]
    for gap_begin, gap_end in sorted(cuts):
        if gap_begin > begin:
            pieces.append(_part(run, begin, gap_begin))
        begin = max(begin, gap_end)
    pieces.append(_part(run, begin, run.time[-1]))
    return [piece for piece in pieces if all(np.isfinite(v).sum() > 5 for v in (piece.yaw_rate, piece.torque))]


def _part(run: Run, begin: float, end: float) -> Run:
    here = (run.time >= begin) & (run.time <= end)
    channels = {name: values[here] for name, values in run.channels.items()}
    return Run(run.name, run.time[here], run.yaw_rate[here], run.torque[here], channels, run.rate_name)
