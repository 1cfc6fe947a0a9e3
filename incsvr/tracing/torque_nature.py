"""What the torque of recordings is, decided once: a command that holds or a course on a line, in open or closed loop.

In open loop nothing that the rate tells beside the torque's own past foretells the torque, however wrong the model is; a
controller follows the rate, and with it the water (P. E. Caines, C. W. Chan, IEEE Trans. Autom. Control 20, 1975).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from incsvr.signals.settings import COMMANDED, TorqueKind
from incsvr.tracing.thresholds import LOOP_CORRELATION, LOOP_DEVIATIONS, REPEATED
from incsvr.tracing.run import Array, Run, stream

PAST, RUNNING, WHITENING = 9, (20.0, 100.0), 3
"""Cells of the torque's past, and lengths of its running means, from which it is predicted; past residuals
that whiten the present one."""
CLIP = 3.0
"""Usual deviations at which a surprise is cut: a turn that was asked for is no answer."""


@dataclass(frozen=True, slots=True)
class TorqueNature:
    """What the torque is.

    Attributes:
        held: whether it keeps each value until the next sample, as a command does; else it runs on a line.
        noisy: whether it may hold noise of its own, single wrong samples among it.
        closed: whether a controller made it of the yaw rate, so that it answers the water.
    """

    held: bool
    noisy: bool
    closed: bool = False


def as_told(runs: Sequence[Run], kind: TorqueKind | None) -> TorqueNature:
    """What the torque is by what a person says, or else by its messages alone.

    Args:
        kind: "commanded", "measured", or None where nobody says.
    """
    if kind is not None:
        return TorqueNature(held=kind == COMMANDED, noisy=kind != COMMANDED)
    same = [np.diff(stream(run, run.torque)[1]) == 0.0 for run in runs]
    held = float(np.mean(np.concatenate(same))) > REPEATED
    return TorqueNature(held=held, noisy=not held)


def answers(residual: Array, torque: Array, starts: NDArray[np.intp]) -> bool:
    """Whether the torque answers what the residual tells of the water.

    Args:
        residual: (n,) what a model leaves of the torque in each cell [N m], positive where it lacks torque.
        torque: (n,) mean of each cell [N m].
        starts: (pieces + 1,) first cell of each piece, and the end.
    """
    if float(np.ptp(torque)) == 0.0:
        return False
    surprise = _whitened(residual, starts)
    past = np.stack([
        *(np.roll(torque, k) for k in range(PAST)), np.abs(torque), torque * np.abs(torque), torque**3, np.ones(torque.size),
        *(lfilter([1.0 / length], [1.0, 1.0 / length - 1.0], torque) for length in RUNNING),
    ], axis=1)  # fmt: skip
    inside = [np.arange(a + PAST, b - 1) for a, b in pairwise(starts.tolist()) if b - a > 2 * PAST]
    at = np.concatenate(inside) if inside else np.empty(0, dtype=np.intp)
    if at.size < 3 * past.shape[1]:
        return False
    own, unforeseen = surprise[at], _unforeseen(torque[at + 1] - torque[at], past[at])
    together = float(own @ unforeseen)
    deviations = together / max(float(np.sqrt(np.sum((own * unforeseen) ** 2))), 1e-300)
    correlation = together / max(float(np.sqrt((own @ own) * (unforeseen @ unforeseen))), 1e-300)
    return deviations > LOOP_DEVIATIONS and correlation > LOOP_CORRELATION


def _whitened(residual: Array, starts: NDArray[np.intp]) -> Array:
    """(n,) the residual less what its own past tells, cut where it is an outlier."""
    past = np.stack([np.roll(residual, k) for k in range(1, WHITENING + 1)], axis=1)
    usable = np.ones(residual.size, dtype=bool)
    for k in range(WHITENING):
        usable[np.minimum(starts[:-1] + k, residual.size - 1)] = False
    white = np.where(usable, residual - past @ np.linalg.lstsq(past[usable], residual[usable])[0], 0.0)
    usual = 1.4826 * float(np.median(np.abs(white)))
    return np.clip(white, -CLIP * usual, CLIP * usual) if usual > 0.0 else white


def _unforeseen(change: Array, past: Array) -> Array:
    """(n,) the change of the torque less what its past tells, fitted robustly, cut where it is an outlier."""
    left, usual = change, 0.0
    for _ in range(3):
        kept = np.abs(left) <= CLIP * usual if usual > 0.0 else np.ones(change.size, dtype=bool)
        left = change - past @ np.linalg.lstsq(past[kept], change[kept])[0]
        usual = 1.4826 * float(np.median(np.abs(left))) or float(np.std(left))
    cut = np.clip(left, -CLIP * usual, CLIP * usual)
    # a jump that was cut leads away from the level before it: that is its past, too
    return np.asarray(cut - past @ np.linalg.lstsq(past, cut)[0])
