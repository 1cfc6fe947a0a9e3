"""Recordings as cells of even length: the rate at their edges, the mean of the torque in them, on the data's own time.

Everything that is fitted, chosen, proved and drawn is computed on these cells.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from incsvr.effects import Signals
from incsvr.errors import BadInput
from incsvr.model_trace.run import Run, pieces, sample_period, stream
from incsvr.model_trace.thresholds import MIN_PIECE_CELLS, USUAL_QUANTILES
from incsvr.model_trace.torque_nature import TorqueNature
from incsvr.numerics import Array, cell_means, integral_at
from incsvr.signals import scales
from incsvr.tracing.interpolation import snapped_edges, without_spikes


@dataclass(frozen=True, slots=True)
class Cells:
    """The cells of all pieces of all recordings, one after the other.

    Attributes:
        signals: one value a cell: time, rate and heading at its beginning, torque its mean, channels at its middle.
        fine: the torque in equal parts of the cells, on which thrust effects act.
        parts: how many parts a cell has.
        end: (n,) rate at the end of each cell [rad/s].
        run: (pieces,) number of the recording that each piece is from.
        rate_period, torque_period: usual times between two samples [s].
    """

    signals: Signals
    fine: Signals
    parts: int
    end: Array
    run: NDArray[np.intp]
    rate_period: float
    torque_period: float

    @property
    def step(self) -> float:
        """Length of a cell [s]."""
        return self.signals.step

    @property
    def start(self) -> NDArray[np.intp]:
        """(pieces + 1,) first cell of each piece, and the end."""
        return self.signals.start

    @property
    def resolution(self) -> float:
        """The longer period of the two streams [s]: what happens within it is not seen."""
        return max(self.rate_period, self.torque_period)

    @property
    def cell_run(self) -> NDArray[np.intp]:
        """(n,) number of the recording of each cell."""
        return np.repeat(self.run, np.diff(self.start))

    def __len__(self) -> int:
        return self.end.size


@dataclass(frozen=True, slots=True)
class Cut:
    """The division of recordings into cells.

    Attributes:
        step: length of a cell [s].
        nature: how the torque runs between its samples.
        scale: T_c [s].
        clock: the stream at whose samples cells begin, so that nothing in a cell answers what happens in it; None for
            cells that begin anywhere.
        divide: equal parts into which each cell is cut once more.
        steps: cells of a window.
    """

    step: float
    nature: TorqueNature
    scale: float
    clock: str | None = None
    divide: int = 1
    steps: int = 1


def time_scale(runs: Sequence[Run]) -> float:
    """T_c [s]: the lag at which the autocorrelation of the yaw rate falls below one half, over all runs together."""
    period = sample_period(runs, "yaw_rate")
    grids = []
    for piece in (piece for run in runs for piece in pieces(run)):
        at, rate = stream(piece, piece.yaw_rate)
        grids.append(np.interp(np.arange(at[0], at[-1], period), at, rate))
    return scales.time_scale(grids, period)


def settling_time(runs: Sequence[Run], inertia: float) -> float:
    """I σ(r)/σ(τ) [s]: in about that time the vehicle follows a slow command; infinite without a torque."""
    rates = np.concatenate([stream(run, run.yaw_rate)[1] for run in runs])
    torques = np.concatenate([stream(run, run.torque)[1] for run in runs])
    rate, torque = (float(np.std(np.clip(x, *np.quantile(x, USUAL_QUANTILES)))) for x in (rates, torques))
    return inertia * rate / torque if torque > 0.0 else np.inf


def cut(runs: Sequence[Run], inertia: float, names: Sequence[str], how: Cut) -> Cells:
    """The recordings in cells.

    Args:
        runs: the recordings.
        inertia: I₀ [kg m²]; between two samples the rate bends as the torque has it.
        names: the channels to take along; `heading` among them where it is recorded.
        how: they are cut.

    Raises:
        BadInput: yaw rate and torque never overlap in time.
    """
    rate_period, torque_period = sample_period(runs, "yaw_rate"), sample_period(runs, "torque")
    step = how.step / how.divide
    parts = max(int(np.ceil(step / min(torque_period, 0.5 * step) - 1e-6)), 1)
    found: list[dict[str, Array]] = []
    number = []
    for k, run in enumerate(runs):
        for piece in pieces(run):
            cells = _piece(piece, inertia, names, how, parts)
            if cells is not None:
                found.append(cells)
                number.append(k)
    if not found:
        words = runs[0].words
        raise BadInput(
            f"{words.rate_column} and {words.effort} never overlap in time: check the stamps of the two streams"
        )
    joined = {name: np.concatenate([each[name] for each in found]) for name in found[0]}
    start = np.cumsum([0, *(each["rate"].size for each in found)]).astype(np.intp)
    heading = joined.pop("heading", None)
    if heading is None:
        heading = np.concatenate([np.cumsum(each["rate"]) - each["rate"] for each in found]) * step
    time, count = joined["time"], joined["time"].size
    channels = {name: joined[name] for name in names if name != "heading"}
    signals = Signals(
        step=step, start=start, time=time, rate=joined["rate"], torque=joined["torque"], channels=channels,
        heading=heading, inertia=inertia, scale=how.scale, block=step,
        origin=(float(time.min()), float(time.max()) + step), rate_name=runs[0].rate_name,
        torque_noise=_torque_noise(runs) if how.nature.noisy else 0.0,
    )  # fmt: skip
    within = np.tile(np.arange(parts) * (step / parts), count)
    fine = replace(
        signals, step=step / parts, start=start * parts, time=np.repeat(time, parts) + within, torque=joined["fine"],
        rate=np.repeat(signals.rate, parts), heading=np.empty(0),
        channels={name: np.repeat(values, parts) for name, values in channels.items()},
    )  # fmt: skip
    return Cells(signals, fine, parts, joined["end"], np.array(number, dtype=np.intp), rate_period, torque_period)


def _torque_noise(runs: Sequence[Run]) -> float:
    """Deviation of the white noise of the torque's samples [N m]."""
    return scales.white_noise(np.concatenate([np.diff(stream(run, run.torque)[1], 3) for run in runs]))


def plain(signals: Signals) -> Cells:
    """A grid whose torque holds from each point to the next as cells, of which only simulations are asked."""
    runs = np.arange(signals.start.size - 1, dtype=np.intp)
    return Cells(signals, signals, 1, signals.rate, runs, signals.step, signals.step)


def _piece(run: Run, inertia: float, names: Sequence[str], how: Cut, parts: int) -> dict[str, Array] | None:
    """A stretch without a pause as cells; None where it is too short."""
    held, divide = how.nature.held, how.divide
    at, rate = stream(run, run.yaw_rate)
    when, torque = stream(run, run.torque)
    begin, end = max(at[0], when[0]), min(at[-1], when[-1])
    clock = {"yaw_rate": at, "torque": when}.get(how.clock or "")
    if clock is not None:
        begin = clock[min(int(np.searchsorted(clock, begin)), clock.size - 1)]
    count = int((end - begin) / how.step + 1e-9)
    if count < MIN_PIECE_CELLS:
        return None
    edges = begin + how.step * np.arange(count + 1)
    if clock is not None:
        edges = snapped_edges(edges, clock, how.step)
    edges = np.interp(np.arange(count * divide + 1) / divide, np.arange(count + 1), edges)
    count *= divide
    torque = without_spikes(torque) if how.nature.noisy else torque
    free = without_spikes(rate - integral_at(when, torque, at, held) / inertia)
    rates = np.interp(edges, at, free) + integral_at(when, torque, edges, held) / inertia
    fine_edges = np.interp(np.arange(count * parts + 1) / parts, np.arange(count + 1), edges)
    fine = cell_means(when, torque, fine_edges, held)
    cells = {
        "time": edges[:-1],
        "rate": rates[:-1],
        # as if every cell had the same length: stamps of a clock are even but for a quarter of a period
        "end": rates[:-1] + np.diff(rates) * (how.step / divide / np.diff(edges)),
        "torque": fine.reshape(count, parts).mean(axis=1),
        "fine": fine,
    }
    for name in names:
        stamps, values = stream(run, run.channels[name])
        of_heading = name == "heading"
        middle = edges[:-1] if of_heading else 0.5 * (edges[:-1] + edges[1:])
        course = np.asarray(np.unwrap(values) if of_heading else values, dtype=np.float64)
        cells[name] = np.interp(middle, stamps, course) if stamps.size else np.zeros(count)
    return cells
