"""Free runs of recordings that a fit excluded: of models, of a velocity of zero, and of the first value kept."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from incsvr.model.fitting import Fit
from incsvr.model.left_out import fold_parameters
from incsvr.model.series import duration
from incsvr.model.simulation import predict
from incsvr.model.windows import cut
from incsvr.numerics import Array, Streams, root_mean_square


def excluded_free_runs(
    models: Mapping[str, Fit],
    runs: Sequence[Streams],
    few: int = 8,  # blocks of one or two recordings: long, yet several
) -> dict[str, Array]:
    """(axes,) by name, the RMS error of free runs of each fold by the fit without it [m/s], [rad/s].

    A fold is a whole recording where there are three or more, else a long block. `zero` and `hold` are added.
    """
    first = next(iter(models.values()))
    step, axes = first.problem.windows.step, first.structure.axes
    whole = len(runs) >= 3
    horizon = np.inf if whole else duration(runs, axes[0]) / few
    found = dict[str, Array]()
    for name, model in models.items():
        structure = replace(model.structure, predictor=False)
        windows = cut(runs, structure, step, horizon)
        fold = windows.run if whole else np.arange(windows.first.size) * few // windows.first.size
        columns = fold_parameters(model)[[model.names.index(each) for each in structure.names]]
        columns = columns[:, np.minimum(fold, columns.shape[1] - 1)]
        top = [np.abs(windows.measured[windows.axis == i]).max() for i in range(len(axes))]
        most = 2.0 * np.array(top)[windows.axis]  # what runs away counts so, that others remain comparable
        starts = np.repeat(windows.starts[:, None], columns.shape[1], axis=1)
        predicted = predict(structure, columns, windows, starts)[np.arange(windows.window.size), windows.window]
        errors = {name: windows.measured - np.clip(predicted, -most, most)}
        if not found:
            errors |= {
                "zero": windows.measured,
                "hold": windows.measured - windows.starts[windows.axis, windows.window],
            }
        for label, error in errors.items():
            found[label] = np.array([root_mean_square(error[windows.axis == i]) for i in range(len(axes))])
    return found
