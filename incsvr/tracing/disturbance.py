"""The residual of a model as one disturbance: its size, share of the torque, and correlation time."""

from __future__ import annotations

import numpy as np

from incsvr.numerics import Array, root_mean_square


def disturbance(residual: Array, period: float, torque: Array) -> dict[str, float]:
    """The residual's root mean square [N m], its part of the torque's, if there is any, and its correlation time [s].

    The correlation time is the lag at which the autocorrelation falls below 1/e, by a line between lags; below one
    period it is that of white noise.

    Args:
        residual: (n,) means over blocks of the fitted recordings [N m].
        period: of a block [s].
        torque: (m,) as recorded [N m].
    """
    size, driven = root_mean_square(residual), root_mean_square(torque)
    centred = residual - np.mean(residual)
    square = float(centred @ centred)
    lag, before = 0, 1.0
    time = 0.0
    while square > 0.0 and lag + 1 < residual.size // 4:
        lag += 1
        now = float(centred[lag:] @ centred[:-lag]) / square
        if now < np.exp(-1.0):
            time = period * (lag - 1 + (before - np.exp(-1.0)) / (before - now))
            break
        before, time = now, period * lag
    share = {"share_of_torque": size / driven} if driven > 0.0 else {}
    return {"torque_rmse": size, **share, "correlation_time_s": float(time)}
