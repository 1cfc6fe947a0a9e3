"""The torque as the tracer uses it: what of a measured one acted, and what of a command was not known before."""

from __future__ import annotations

from itertools import pairwise
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from incsvr.effects import Signals
from incsvr.tracing.forward.thresholds import DEGREES

Array = NDArray[np.float64]
Scalar = TypeVar("Scalar", bound=np.generic)

BESIDE = 2
"""Blocks to either side from which a block's torque is told."""

JUMP = 6.0
"""Usual differences of neighbouring blocks beyond which the command has jumped between them."""

LAGS = 3
"""Cells of the past from which the next command is predicted: a controller's and its filter's."""

RUNNING = (4.0, 20.0)
"""Cells of the running means of a command's surprise: a Kalman filter with that gyro would forget as slowly."""


def acting_torque(s: Signals) -> Array:
    """(n,) the torque of each block as its neighbours tell it, so that its own noise is in no regressor [N m].

    A shape such as a limit, built on a measured torque, shares the noise of the torque on the other side of the
    equation and is rewarded for what it takes of that. In its place stands the torque's prediction from instruments
    that do not hold this noise, the blocks beside it: two-stage least squares (J. Wooldridge, Econometric Analysis of
    Cross Section and Panel Data, 2010, ch. 5; T. Söderström, Errors-in-Variables Methods in System Identification,
    2018, ch. 6). Neighbours beyond a jump of the command are replaced by those on this side of it; a block with jumps
    at both ends has no such neighbour and keeps its own.
    """
    torque = s.torque
    change = np.abs(_moved(torque, s.start, 1) - torque)
    jumped = change > JUMP * 1.4826 * max(float(np.median(change)), 1e-300)  # between a block and the next
    closed = [_moved(jumped, s.start, -1), jumped]
    sides = [[torque], [torque]]
    for k in range(1, BESIDE + 1):
        left, right = _moved(torque, s.start, -k), _moved(torque, s.start, k)
        to_left, to_right = ~closed[0], ~closed[1]
        sides[0].append(np.where(to_left, left, np.where(to_right, right, sides[0][-1])))
        sides[1].append(np.where(to_right, right, np.where(to_left, left, sides[1][-1])))
        closed = [closed[0] | _moved(jumped, s.start, -k - 1), closed[1] | _moved(jumped, s.start, k)]
    alone = jumped & _moved(jumped, s.start, -1)
    design = np.stack([np.ones(torque.size), *sides[0][1:], *sides[1][1:]], axis=1)
    weight = (~alone).astype(np.float64)
    for _ in range(4):
        root = np.sqrt(weight)
        told = design @ np.linalg.lstsq(design * root[:, None], torque * root)[0]
        usual = 1.4826 * float(np.median(np.abs(torque - told)))
        weight = ~alone * (DEGREES + 1.0) / (DEGREES + ((torque - told) / max(usual, 1e-300)) ** 2)
    return np.where(alone, torque, told)


def _moved(values: NDArray[Scalar], starts: NDArray[np.intp], by: int) -> NDArray[Scalar]:
    """(n,) the values so many blocks later; at the end of a piece its last."""
    out = np.empty_like(values)
    for begin, end in pairwise(starts):
        out[begin:end] = values[np.clip(np.arange(begin, end) + by, begin, end - 1)]
    return out


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
