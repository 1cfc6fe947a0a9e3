"""Errors of a model on recordings: free runs, and the rivals that need no model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from incsvr.model.series import Series
from incsvr.model.simulation import predict
from incsvr.model.structure import Structure
from incsvr.model.windows import cut
from incsvr.numerics import Array


def residuals(
    structure: Structure, theta: Mapping[str, float], runs: Sequence[Series], step: float, horizon: float
) -> tuple[Array, Array, Array, Array]:
    """Measured values, and the errors of the model, of holding the first value, by sample; and each sample's axis.

    Every window of the horizon [s] begins with its first measured velocity; an infinite one is a free run of the whole.
    """
    plain = replace(structure, predictor=False)
    windows = cut(runs, plain, step, horizon)
    columns = np.array([theta[name] for name in plain.names])[:, None]
    told = predict(plain, columns, windows, windows.starts[:, None])[:, 0]
    held = windows.starts[windows.axis, windows.window]
    return windows.measured, windows.measured - told, windows.measured - held, windows.axis


def rms(
    structure: Structure, theta: Mapping[str, float], runs: Sequence[Series], step: float, horizon: float = np.inf
) -> dict[str, dict[str, float]]:
    """RMS by axis of the `model`, of a velocity of `zero` and of `hold`, the first value kept."""
    measured, error, held, axis = residuals(structure, theta, runs, step, horizon)
    found = {}
    for i, name in enumerate(structure.axes):
        own = axis == i
        found[name] = {
            "model": _rms(np.clip(error[own], -1e3, 1e3)), "zero": _rms(measured[own]), "hold": _rms(held[own]),
        }  # fmt: skip
    return found


def _rms(value: Array) -> float:
    return float(np.sqrt(np.mean(value * value))) if value.size else float("nan")
