"""Errors of a model on recordings beside those of rivals that need no model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from incsvr.model.factors import Indices
from incsvr.model.simulation import predict
from incsvr.model.structure import Structure
from incsvr.model.windows import cut
from incsvr.numerics import Array, Streams, root_mean_square


def residuals(
    structure: Structure, theta: Mapping[str, float], runs: Sequence[Streams], step: float, horizon: float
) -> tuple[Array, Array, Array, Indices]:
    """(samples,) each: measured values, errors of the model, errors of the first value kept constant, and the axis.

    Every window of the horizon [s] begins with its first measured velocity; an infinite one is a free run of the whole.
    """
    plain = replace(structure, predictor=False)
    windows = cut(runs, plain, step, horizon)
    columns = np.array([theta[name] for name in plain.names])[:, None]
    predicted = predict(plain, columns, windows, windows.starts[:, None])[:, 0]
    constant = windows.starts[windows.axis, windows.window]
    return windows.measured, windows.measured - predicted, windows.measured - constant, windows.axis


def rms(
    structure: Structure, theta: Mapping[str, float], runs: Sequence[Streams], step: float, horizon: float = np.inf
) -> dict[str, dict[str, float]]:
    """RMS by axis [m/s], [rad/s] of the `model`, of a velocity of `zero`, and of `hold`, the first value for ever."""
    measured, error, of_constant, axis = residuals(structure, theta, runs, step, horizon)
    found = {}
    for i, name in enumerate(structure.axes):
        own = axis == i
        errors = {"model": np.clip(error[own], -1e3, 1e3), "zero": measured[own], "hold": of_constant[own]}
        found[name] = {label: root_mean_square(each) for label, each in errors.items()}
    return found
