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
from viewer.report.drawing import AFTER, BEFORE, MEASURED, STYLE, binned, edges

RUNS = {"without the hull": "T1", "with the hull": "T2"}
COLOURS = {"without the hull": BEFORE, "with the hull": AFTER}
INERTIA = 350.0
"""Leng's, as the demo declares it [kg m²]."""


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
        _difference(right, rate, *learned.values())
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


def _difference(axes: Axes, rate: Array, without: FitPictures, hull: FitPictures) -> None:
    """By how much samples and curve with the hull lie above the curve without it."""
    turns, damping = _one_way(hull)
    near = turns <= rate[-1]
    middle, low, median, high = binned(turns[near], (damping - _both_ways(without, turns))[near], edges(turns[near]))
    halves = np.stack((median - low, high - median))
    axes.errorbar(
        middle, median, halves, fmt="o", color=MEASURED, markersize=5.0, label="median of samples, middle half"
    )
    axes.plot(
        rate, _both_ways(hull, rate) - _both_ways(without, rate), color=AFTER, linewidth=2.4, label="learned curves"
    )
    axes.axhline(0.0, color=BEFORE, linewidth=1.2)
    axes.set(xlabel="Yaw rate r [rad/s]", ylabel="Damping that the hull adds [N m]", xlim=(0.0, rate[-1]))
    axes.set_title("What the hull adds")
    axes.legend(loc="upper left")


def _one_way(learned: FitPictures) -> tuple[Array, Array]:
    """(n,) rates and damping of all samples, turned one way: damping opposes both turns alike."""
    rate, damping = learned.samples.yaw_rate, learned.samples.damping
    return np.abs(rate), damping * np.sign(rate)


def _both_ways(learned: FitPictures, rate: Array) -> Array:
    """(n,) the learned damping at rates ≥ 0, the mean of both turns [N m]."""
    left, right = (learned.model.predict(side * rate).damping for side in (1.0, -1.0))
    return np.asarray((left - right) / 2.0)
