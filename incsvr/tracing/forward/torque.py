"""What of a command does not follow from what the log holds before it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from incsvr.effects import Signals

Array = NDArray[np.float64]

LAGS = 3
"""Cells of the past from which the next command is predicted: a controller's and its filter's."""

RUNNING = (4.0, 20.0)
"""Cells of the running means of a command's surprise: a Kalman filter with that gyro would forget as slowly."""


def surprise(s: Signals) -> Array:
    """(3, n) the torque less its linear prediction from the torques before it, and from rate and heading up to now, and
    two running means of that; what is larger than usual is a turn that was asked for, and is cut.
    """
    history = [np.roll(s.torque, k) for k in range(1, LAGS + 1)]
    history += [np.roll(values, k) for values in (s.rate, s.heading) for k in range(LAGS)]
    design = np.stack([*history, np.ones(len(s))], axis=1)
    usable = np.ones(len(s), dtype=bool)
    for k in range(LAGS):
        usable[np.minimum(s.start[:-1] + k, len(s) - 1)] = False
    left = np.zeros(len(s))
    weight = usable.astype(np.float64)
    for _ in range(3):
        root = np.sqrt(weight)[:, None]
        left = s.torque - design @ np.linalg.lstsq(design * root, s.torque * root[:, 0])[0]
        usual = 1.4826 * float(np.median(np.abs(left[usable])))
        weight = usable / (1.0 + (left / max(3.0 * usual, 1e-12)) ** 2)
    new = np.where(usable, np.clip(left, -4.0 * usual, 4.0 * usual), 0.0)
    return np.stack([new, *(lfilter([1.0 / length], [1.0, 1.0 / length - 1.0], new) for length in RUNNING)])
