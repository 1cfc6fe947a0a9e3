"""Fig. 4 of the paper: yaw rate and torque of each experiment's runs, first to validate with and then to train on.

A dashed line stands where the validation run ends and the training run begins. Drawn from the runs that the demo
leaves beside its recording.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from incsvr.errors import BadInput
from service.recordings.recording_csv import read
from viewer.frame import Floats
from viewer.palette import LIGHT, Colour

EXPERIMENTS: Mapping[str, tuple[str, str]] = {"without the hull": ("V1", "T1"), "with the hull": ("V2", "T2")}
"""Each experiment's runs, in the order in which they were collected."""
STREAMS: Mapping[str, tuple[str, Colour]] = {
    "yaw_rate": ("Yaw rate [rad/s]", LIGHT.old),
    "torque": ("Torque [N m]", LIGHT.before),
}
STYLE: dict[Any, Any] = {"font.size": 9.0, "axes.spines.top": False, "axes.spines.right": False, "savefig.dpi": 150}


def draw(folder: Path, picture: Path) -> None:
    """Draws the runs `V1.csv`, `T1.csv`, `V2.csv` and `T2.csv` of a folder.

    Raises:
        BadInput: one of them is not there.
    """
    with rc_context(STYLE):
        figure = Figure(figsize=(10.0, 5.2), layout="constrained")
        axes = figure.subplots(len(STREAMS), len(EXPERIMENTS), sharex="col", sharey="row", squeeze=False)
        for column, (title, runs) in enumerate(EXPERIMENTS.items()):
            _experiment(axes[:, column].tolist(), {run: _streams(folder / f"{run}.csv") for run in runs})
            axes[0, column].set_title(f"The experiment {title}", pad=16.0)
            axes[-1, column].set_xlabel("Time of the experiment [s]")
        for row, (label, _) in enumerate(STREAMS.values()):
            axes[row, 0].set_ylabel(label)
        figure.savefig(picture)


def _experiment(axes: list[Axes], runs: Mapping[str, Mapping[str, Floats]]) -> None:
    """The runs one after the other, with the dashed line between them."""
    begins = 0.0
    for number, (name, streams) in enumerate(runs.items()):
        ends = begins + max(float(stream[-1, 0]) for stream in streams.values())
        for ax, (stream, (_, colour)) in zip(axes, STREAMS.items(), strict=True):
            time, value = streams[stream].T
            ax.plot(begins + time, value, color=_hex(colour), linewidth=0.8)
            if number:
                ax.axvline(begins, color=_hex(LIGHT.text), linestyle="--", linewidth=1.2)
            ax.grid(color=_hex(LIGHT.grid))
            ax.margins(x=0.0)
        words = f"{name}, validation" if name.startswith("V") else f"{name}, training"
        axes[0].annotate(words, ((begins + ends) / 2.0, 1.02), xycoords=("data", "axes fraction"), ha="center")
        begins = ends


def _streams(path: Path) -> dict[str, Floats]:
    """Each stream's (n, 2) stamps [s] and values."""
    if not path.is_file():
        raise BadInput(f"{path}: there is no such run; `make demo` makes it")
    streams = read(path).streams()
    return {name: np.column_stack(streams[name]) for name in STREAMS}


def _hex(colour: Colour) -> str:
    return "#{:02x}{:02x}{:02x}".format(*colour)
