"""One recording as the tracer takes it, and whether it can be used at all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array, Streams, running_integral
from incsvr.plant.axes import YAW, of_rate
from incsvr.plant.words import AxisWords, words_of
from incsvr.tracing.gyro import check_gyro


@dataclass(frozen=True, slots=True)
class Run:
    """One contiguous recording; a cell that was not sampled is NaN.

    Attributes:
        name: what messages call it.
        time: (n,) strictly increasing [s].
        yaw_rate: (n,) r [rad/s].
        torque: (n,) τ, the yaw moment that the actuators are told to apply, positive the way yaw_rate is [N m].
        channels: further streams by name, (n,) each; `heading` in rad.
        rate_name: what the recording calls the velocity that stands in `yaw_rate`, of another axis than yaw.
        rate_limit: the velocity beyond which it is in another unit; None is what no vehicle of this axis reaches.
    """

    name: str
    time: Array
    yaw_rate: Array
    torque: Array
    channels: Mapping[str, Array] = field(default_factory=dict)
    rate_name: str = YAW.rate
    rate_limit: float | None = None

    @property
    def words(self) -> AxisWords:
        """The words for the quantities of the axis."""
        return words_of(of_rate(self.rate_name))


def stream(run: Run, values: Array) -> tuple[Array, Array]:
    """The instants at which a stream was sampled, and its values there."""
    here = np.isfinite(values)
    return run.time[here], values[here]


def as_run(streams: Streams, axis: str = YAW.rate) -> Run:
    """Streams as the tracer takes them: one column each on the instants of all, NaN where a stream has no value."""
    time = np.unique(np.concatenate([t for t, _ in streams.values()]))
    columns = {}
    for name, (t, values) in streams.items():
        columns[name] = np.full(time.size, np.nan)
        columns[name][np.searchsorted(time, t)] = values
    return Run("the recent data", time, columns.pop("yaw_rate"), columns.pop("torque"), columns, axis)


def check(runs: Sequence[Run]) -> None:
    """Refuse what no method can answer.

    Raises:
        BadInput: no runs, unequal lengths, time that does not increase, too few samples, time stamps in milliseconds,
            a constant yaw rate, a yaw rate or heading in degrees, a gyro that was stuck or clipped.
    """
    if not runs:
        raise BadInput("no recording was given: name at least one CSV file")
    for run in runs:
        lengths = {run.time.size, run.yaw_rate.size, run.torque.size, *(c.size for c in run.channels.values())}
        if len(lengths) != 1:
            raise BadInput(f"{run.name}: the columns have different lengths; give every column one cell per row")
        if not np.all(np.isfinite(run.time)) or np.any(np.diff(run.time) <= 0):
            raise BadInput(f"{run.name}: t must increase from row to row; sort the rows and drop repeated stamps")
        _check_streams(run)
    _check_together(runs)


def sample_period(runs: Sequence[Run], of: Literal["yaw_rate", "torque"]) -> float:
    """Median time between two samples of a stream, over all runs together [s]."""
    steps = [np.diff(stream(run, run.yaw_rate if of == "yaw_rate" else run.torque)[0]) for run in runs]
    return float(np.median(np.concatenate(steps)))


def _check_streams(run: Run) -> None:
    words = run.words
    for label, values in (("yaw_rate", run.yaw_rate), ("torque", run.torque)):
        if np.isfinite(values).sum() < 2:
            raise BadInput(f"{run.name}: {label} holds no numbers; record it or leave this run out")
    period = sample_period([run], "yaw_rate")
    if period >= 1.0 and period == round(period) and run.time[-1] - run.time[0] > 2000.0:
        raise BadInput(
            f"{run.name}: the {words.rate} is sampled every {period:g} s, which looks like time stamps in ms; "
            "divide t by 1000"
        )
    fastest = float(np.nanpercentile(np.abs(run.yaw_rate), 99))
    if fastest > (of_rate(run.rate_name).fastest if run.rate_limit is None else run.rate_limit):
        raise BadInput(
            f"{run.name}: |{words.rate_column}| reaches {fastest:.3g}, no vehicle {words.turns} at that many "
            f"{words.rate_unit}; convert degrees, or raise vehicle.rate_limit if it does"
        )
    heading = run.channels.get("heading")
    if heading is not None and np.isfinite(heading).sum() > 2:
        at, angle = stream(run, heading)
        angle_steps = np.abs(np.diff(np.unwrap(angle)))
        expected = np.abs(np.diff(np.interp(at, *_integral(run))))
        if np.nanmax(np.abs(angle)) > 30.0 and np.median(angle_steps) > 10.0 * max(float(np.median(expected)), 1e-9):
            raise BadInput(
                f"{run.name}: heading turns far faster than the {words.rate} says; convert it from degrees to rad"
            )
    when, rate = stream(run, run.yaw_rate)
    check_gyro(run.name, when, rate, np.interp(when, *stream(run, run.torque)), words)


def _integral(run: Run) -> tuple[Array, Array]:
    at, rate = stream(run, run.yaw_rate)
    return at, running_integral(at, rate)


def _check_together(
    runs: Sequence[Run],
    fewest: int = 200,  # samples of each stream, over all runs, from which on anything is concluded
) -> None:
    samples = min(
        sum(int(np.isfinite(values).sum()) for values in streams)
        for streams in (
            [run.yaw_rate for run in runs],
            [run.torque for run in runs],
        )
    )
    if samples < fewest:
        raise BadInput(f"{samples} samples are too few to trace anything; record at least {fewest}, better ten minutes")
    rate = np.concatenate([stream(run, run.yaw_rate)[1] for run in runs])
    if np.ptp(rate) <= 1e-9:
        raise BadInput(
            f"the {runs[0].words.rate} never changes: nothing can be learned from it; check the gyro's stream"
        )
