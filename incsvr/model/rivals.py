"""Free runs of data that a fit excluded: of models, of a velocity of zero, and of the first value kept."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from incsvr.model.fitting import Fit
from incsvr.model.left_out import FEW_FOLDS, fold_parameters
from incsvr.model.series import duration
from incsvr.model.simulation import predict
from incsvr.model.structure import Structure
from incsvr.model.windows import Windows, cut
from incsvr.numerics import Array, Streams, root_mean_square


def free_windows(
    structure: Structure, step: float, runs: Sequence[Streams], horizon: float = np.inf, excluded: bool = True
) -> Windows:
    """Recordings as windows of a simulator, of a horizon [s]; with an infinite one, as its free runs.

    Args:
        step: of the simulation [s].
        excluded: whether these are the recordings of the fits: of fewer than three the free runs are long blocks then.
    """
    if horizon == np.inf and excluded and len(runs) < 3:
        horizon = duration(runs, structure.axes[0]) / FEW_FOLDS
    return cut(runs, replace(structure, predictor=False), step, horizon)


def free_runs(model: Fit, windows: Windows, excluded: bool, runaway: float) -> Array:
    """(samples,) the velocities of a model from those measured at each window's first edge.

    Args:
        excluded: whether by the fit without the fold in which the window lies, else by the whole one.
        runaway: beyond so many of the fastest measured velocities of an axis it has run away, and stays there.
    """
    structure = replace(model.structure, predictor=False)
    columns = fold_parameters(model) if excluded else np.array([[model.theta[name]] for name in model.names])
    columns = columns[[model.names.index(name) for name in structure.names]]
    starts = np.repeat(windows.starts[:, None], columns.shape[1], axis=1)
    count = windows.first.size
    fold = windows.run if len(windows.runs) >= 3 else np.arange(count) * FEW_FOLDS // count
    own = np.minimum(fold, columns.shape[1] - 1)[windows.window]
    predicted = predict(structure, columns, windows, starts)[np.arange(own.size), own]
    top = [np.abs(windows.measured[windows.axis == i]).max() for i in range(len(windows.axes))]
    most = runaway * np.array(top)[windows.axis]
    return np.asarray(np.clip(predicted, -most, most))


def agreeing(model: Fit, other: Fit, runs: Sequence[Streams]) -> float:
    """The share of the excluded free runs in which a model of one axis errs less than another."""
    sums = list[Array]()
    for each in (model, other):
        windows = free_windows(each.structure, each.problem.windows.step, runs)
        errors = windows.measured - free_runs(each, windows, True, 2.0)
        sums.append(np.asarray(np.bincount(windows.window, errors**2), dtype=np.float64))
    return float(np.mean(sums[0] < sums[1]))


def excluded_free_runs(models: Mapping[str, Fit], runs: Sequence[Streams]) -> dict[str, Array]:
    """(axes,) by name, the RMS error of free runs of each fold by the fit without it [m/s], [rad/s].

    A fold is a whole recording where there are three or more, else a long block. `zero` and `hold` are added.
    """
    found = dict[str, Array]()
    for name, model in models.items():
        windows = free_windows(model.structure, model.problem.windows.step, runs)
        # What runs away counts as twice the fastest, that others remain comparable.
        errors = {name: windows.measured - free_runs(model, windows, True, 2.0)}
        if not found:
            kept = windows.starts[windows.axis, windows.window]
            errors |= {"zero": windows.measured, "hold": windows.measured - kept}
        for label, error in errors.items():
            found[label] = np.array([root_mean_square(error[windows.axis == i]) for i in range(len(windows.axes))])
    return found
