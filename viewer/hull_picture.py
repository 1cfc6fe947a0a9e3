"""The README's first picture: the damping that the demo's vehicle has without its hull and with it, and the difference.

The two runs are those that the demo leaves beside its recording; each is learned by itself, as `incsvr fit` does it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import incsvr
from incsvr.errors import BadInput
from incsvr.free_run.fit_pictures import FitPictures
from incsvr.numerics import Array
from viewer.report.drawing import AFTER, BEFORE, MEASURED, STYLE

RUNS = {"without the hull": "T1", "with the hull": "T2"}
COLOURS = {"without the hull": BEFORE, "with the hull": AFTER}
INERTIA = 350.0
"""Leng's, as the demo declares it [kg m²]."""
RATE_BINS = 14
"""Bins of the yaw rate for the means of the samples."""


def draw(folder: Path, picture: Path) -> None:
    """Draws the runs `T1.csv` and `T2.csv` of a folder.

    Raises:
        BadInput: one of them is not there.
    """
    learned = {name: _learned(folder / f"{run}.csv") for name, run in RUNS.items()}
    fastest = min(max(abs(end) for end in each.model.trained_range or (0.0, 0.0)) for each in learned.values())
    rate: Array = np.linspace(0.0, fastest, 201, dtype=np.float64)
    with rc_context(STYLE | {"savefig.dpi": 150, "font.size": 11}):
        figure = Figure(figsize=(11.0, 4.4), layout="constrained")
        left, right = figure.subplots(1, 2)
        _curves(left, rate, learned)
        _difference(right, rate, learned)
        figure.savefig(picture)


def _learned(run: Path) -> FitPictures:
    if not run.is_file():
        raise BadInput(f"{run}: there is no such run; `make demo` makes it")
    fit: Any = incsvr.fit(run, inertia=INERTIA, config="config.yaml")
    learned: FitPictures = fit.pictures
    return learned


def _curves(axes: Axes, rate: Array, learned: dict[str, FitPictures]) -> None:
    for name, each in learned.items():
        turns, damping = _one_way(each)
        axes.plot(turns, damping, ".", color=COLOURS[name], markersize=2.5, alpha=0.3)
        axes.plot(rate, _both_ways(each, rate), color=COLOURS[name], linewidth=2.4, label=name)
    axes.set(xlabel="Yaw rate r [rad/s]", ylabel="Damping d(r) [N m]", title="What was learned")
    axes.set(xlim=(0.0, rate[-1]), ylim=(0.0, None))
    axes.legend(loc="upper left")


def _difference(axes: Axes, rate: Array, learned: dict[str, FitPictures]) -> None:
    """By how much samples and curve with the hull lie above those without it."""
    edges: Array = np.linspace(0.0, rate[-1], RATE_BINS + 1, dtype=np.float64)
    means, errors = zip(*(_means(each, edges) for each in learned.values()), strict=True)
    middle, doubt = (edges[1:] + edges[:-1]) / 2.0, 1.96 * np.hypot(*errors)
    axes.errorbar(
        middle, means[1] - means[0], doubt, fmt="o", color=MEASURED, markersize=5.0, label="means of samples, 95 %"
    )
    curves = [_both_ways(each, rate) for each in learned.values()]
    axes.plot(rate, curves[1] - curves[0], color=AFTER, linewidth=2.4, label="learned curves")
    axes.axhline(0.0, color=BEFORE, linewidth=1.2)
    axes.set(xlabel="Yaw rate r [rad/s]", ylabel="Damping that the hull adds [N m]", xlim=(0.0, rate[-1]))
    axes.set_title("What the hull adds")
    axes.legend(loc="upper left")


def _means(learned: FitPictures, edges: Array) -> tuple[Array, Array]:
    """(RATE_BINS,) the samples' damping between two edges, less what the curve bends there, and standard errors."""
    turns, damping = _one_way(learned)
    place = np.digitize(turns, edges) - 1
    middle = (edges[1:] + edges[:-1]) / 2.0
    level = damping - _both_ways(learned, turns) + _both_ways(learned, middle)[np.clip(place, 0, RATE_BINS - 1)]
    parts = [level[place == k] for k in range(RATE_BINS)]
    means = np.array([part.mean() if part.size else np.nan for part in parts])
    errors = np.array([part.std() / np.sqrt(part.size) if part.size else np.nan for part in parts])
    return means, errors


def _one_way(learned: FitPictures) -> tuple[Array, Array]:
    """(n,) rates and damping of all samples, turned one way: damping opposes both turns alike."""
    rate, damping = learned.samples.yaw_rate, learned.samples.damping
    return np.abs(rate), damping * np.sign(rate)


def _both_ways(learned: FitPictures, rate: Array) -> Array:
    """(n,) the learned damping at rates ≥ 0, the mean of both turns [N m]."""
    left, right = (learned.model.predict(side * rate).damping for side in (1.0, -1.0))
    return np.asarray((left - right) / 2.0)
