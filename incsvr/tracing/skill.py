"""How well a model predicts beside the trivial ones: a rate of zero, and the last rate held."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from incsvr.effects import Signals
from incsvr.tracing.model import TracedModel, simulate
from incsvr.tracing.run import Array

HORIZONS = (0.5, 1.0, 2.0, 5.0)
"""In time scales of the motion: how far ahead the multi-step errors look."""


@dataclass(frozen=True, slots=True)
class Ahead:
    """Predictions over one horizon, each from a measured yaw rate: what came, what was predicted, what was there.

    Attributes:
        error: (m,) of the model at the end of the horizon [rad/s].
        change: (m,) by how much the yaw rate changed, the error of holding the last one [rad/s].
        rate: (m,) measured at the end, the error of zero [rad/s].
    """

    error: Array
    change: Array
    rate: Array


def ahead(
    models: Sequence[TracedModel], signals: Signals, step: float, pieces: Sequence[Sequence[slice]], scale: float
) -> tuple[Ahead, ...]:
    """Multi-step predictions of each model over its pieces of the grid, one after the other, for each of HORIZONS.

    Args:
        models: as fitted without these pieces.
        signals: what drives the free runs, and the measured motion from which each begins.
        step: of the integration [s].
        pieces: of the grid, for each model.
        scale: T_c [s].
    """

    def run(spans: Sequence[Sequence[slice]]) -> tuple[Array, Array]:
        kept = [(model, own) for model, own in zip(models, spans, strict=True) if own]
        return simulate([model for model, _ in kept], signals, step, [own for _, own in kept])

    return ahead_of(run, signals, pieces, scale)


def ahead_of(
    run: Callable[[Sequence[Sequence[slice]]], tuple[Array, Array]],
    signals: Signals,
    pieces: Sequence[Sequence[slice]],
    scale: float,
) -> tuple[Ahead, ...]:
    """`ahead` of whatever simulates the spans of each model and answers as `simulate` does; some may have no spans."""
    found = []
    for horizon in HORIZONS:
        length = max(round(horizon * scale / signals.step), 2)
        spans = [[span for piece in own for span in _tiled(piece, length)] for own in pieces]
        every = [span for own in spans for span in own]
        if not every:
            found.append(Ahead(*(np.zeros(0) for _ in range(3))))
            continue
        index, simulated = run(spans)
        cut = signals.pieces(every)
        of = np.searchsorted(cut.start, index, side="right") - 1
        last = np.flatnonzero(np.append(of[1:] != of[:-1], True))
        rate, first = cut.rate[index[last]], cut.rate[cut.start[of[last]]]
        found.append(Ahead(simulated[last] - rate, rate - first, rate))
    return tuple(found)


def joined(parts: Sequence[Sequence[Ahead]]) -> tuple[Ahead, ...]:
    """Predictions over several held-out sets as one, horizon by horizon."""
    return tuple(
        Ahead(*(np.concatenate([getattr(each, name) for each in same]) for name in ("error", "change", "rate")))
        for same in zip(*parts, strict=True)
    )


def _tiled(piece: slice, length: int) -> list[slice]:
    """Spans of `length` steps, side by side, within a piece."""
    return [slice(first, first + length + 1) for first in range(piece.start, piece.stop - length, length)]


def horizons(before: Sequence[Ahead], after: Sequence[Ahead]) -> dict[str, Any]:
    """The contract's `horizons`: root mean square multi-step errors [rad/s], keys in time scales of the motion."""
    found = {}
    for horizon, declared, traced in zip(HORIZONS, before, after, strict=True):
        if declared.error.size:
            found[f"{horizon:g}"] = {
                "before": _rms(declared.error),
                "after": _rms(traced.error),
                "hold": _rms(traced.change),
                "zero": _rms(traced.rate),
            }
    return found


def trivial(measured: Sequence[Array]) -> dict[str, Mapping[str, float]]:
    """The contract's `trivial`: free-run errors of a rate of zero, and of the first one held, over each piece."""
    rate = np.concatenate([*measured])
    hold_error = np.concatenate([piece - piece[0] for piece in measured if piece.size])
    return {"zero": {"free_run_rmse": _rms(rate)}, "hold": {"free_run_rmse": _rms(hold_error)}}


def proven(error: Mapping[str, Any], closed_loop: bool) -> bool:
    """Whether the errors on unseen data got better beyond chance, of free runs in open loop, of predictions else; and
    the model beats a rate of zero: one that does not proves nothing."""
    change = error["change"]["torque_rmse" if closed_loop else "free_run_rmse"]
    return float(change["high"]) < 0.0 and beats_zero(error)


def beats_zero(error: Mapping[str, Any]) -> bool:
    """Whether the free run with what was found errs less than saying that the vehicle does not turn."""
    return float(error["after"]["free_run_rmse"]) < float(error["trivial"]["zero"]["free_run_rmse"])


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2))) if values.size else np.nan
