"""The channels of the recordings that may be candidates, and the reasons against the others."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.numerics import Array
from incsvr.plant.axes import EFFORTS
from incsvr.tracing.run import Run, stream


def usable_channels(
    runs: Sequence[Run],
    copy: float = 0.995,  # correlation beyond which two channels are copies
    function: float = 0.95,  # R² beyond which one is a function of torque or rate: one side of the equation on both
) -> tuple[list[str], dict[str, str]]:
    """Names of the channels that may be candidates, and the reason for each that may not (heading is never one)."""
    names = sorted({name for run in runs for name in run.channels} - {"heading"})
    words = runs[0].words
    kept: dict[str, Array] = {}
    refused: dict[str, str] = {}
    grids = [stream(run, run.yaw_rate) for run in runs]
    at = [np.linspace(g[0][0], g[0][-1], min(4000, max(g[0].size, 2))) for g in grids]
    rate = np.concatenate([np.interp(a, *g) for a, g in zip(at, grids, strict=True)])
    torque = np.concatenate([np.interp(a, *stream(run, run.torque)) for a, run in zip(at, runs, strict=True)])
    for name in names:
        if name in EFFORTS:
            refused[name] = "it is what the actuators apply along another axis"
            continue
        streams = [stream(run, run.channels.get(name, np.full(run.time.size, np.nan))) for run in runs]
        if any(when.size < 10 for when, _ in streams):
            nothing = all(when.size == 0 for when, _ in streams)
            refused[name] = "it is empty" if nothing else _rarely(len(runs))
            continue
        values = np.concatenate([np.interp(a, *s) for a, s in zip(at, streams, strict=True)])
        if np.ptp(values) <= 1e-9 * max(1.0, float(np.max(np.abs(values)))):
            refused[name] = "it is constant"
        elif _explained(values, torque) > function:
            refused[name] = f"it is a function of the {words.effort}"
        elif _explained(values, rate) > function:
            refused[name] = f"it is a function of the {words.rate}"
        else:
            twin = next((other for other, x in kept.items() if abs(np.corrcoef(x, values)[0, 1]) > copy), None)
            if twin is None:
                kept[name] = values
            else:
                refused[name] = f"it is a copy of {twin}; the two cannot be distinguished"
    return list(kept), refused


def _rarely(runs: int) -> str:
    return "it was hardly ever sampled" if runs == 1 else "it was not sampled in every recording"


def _explained(values: Array, by: Array) -> float:
    """R² of a polynomial of fifth degree."""
    if np.ptp(by) <= 0.0:
        return 0.0
    x = (by - np.mean(by)) / np.std(by)
    x = np.clip(x, -4.0, 4.0) / 2.0
    design = np.vander(x, 6)
    residual = values - design @ np.linalg.lstsq(design, values, rcond=None)[0]
    return 1.0 - float(np.var(residual) / np.var(values))
