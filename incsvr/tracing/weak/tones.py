"""A command that is a sum of a few tones, told from the whole run: no block's own noise is in it to speak of.

Tones are taken one at a time, the loudest first, and all fitted again by Gauss-Newton: the RELAX algorithm of J. Li and
P. Stoica, "Efficient mixed-spectrum estimation with applications to target feature extraction", IEEE Trans. Signal
Processing 44(2), 1996.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from incsvr.effects import Signals
from incsvr.tracing.run import Array
from incsvr.tracing.weak.weak_form import Blocks

MOST = 12
"""Tones: a command that has more of them moves as it likes."""

FEWEST_MEANS = 4 * MOST
"""Of a run: fewer would be explained by any tones."""

PADDED = 4
"""Length of the spectrum in which the loudest is looked for, in that of the run."""

STEPS = 3
"""Of Gauss-Newton after each tone."""

RIDGE = 1e-10
"""Of each column's square."""


def as_tones(signals: Signals, blocks: Blocks) -> Array:
    """(n,) the torque as a constant and a few tones, run by run; of a run too short for that its mean [N m]."""
    torque, found = blocks.mean(signals.torque), np.empty(len(signals))
    for run, (begin, end) in zip(signals.runs(), pairwise(blocks.start), strict=True):
        means = torque[begin:end]
        if not means.size:  # shorter than a block
            found[run] = signals.torque[run]
            continue
        frequency = _frequencies(means) if means.size >= FEWEST_MEANS else np.zeros(0)
        at = np.arange(len(signals))[run] - blocks.first[begin]
        tones = _tones(at / (blocks.size * means.size), frequency)
        inside = np.zeros((len(signals), tones.shape[1]))
        inside[run] = tones
        seen = blocks.mean(inside)[begin:end]
        found[run] = tones @ np.linalg.lstsq(seen, means, rcond=1e-10)[0]
    return found


def _frequencies(values: Array) -> Array:
    """Cycles over the run of as many tones as BIC asks for."""
    n = values.size
    time = np.arange(n) / n
    frequency, left = np.zeros(0), values - float(np.mean(values))
    while frequency.size < MOST:
        more, better = _moved(values, time, np.append(frequency, _loudest(left)))
        before, after = float(left @ left), float(better @ better)
        if after <= 0.0 or n * np.log(before / after) < 5.0 * np.log(n):
            break
        frequency, left = more, better
    return frequency


def _loudest(left: Array) -> float:
    """Cycles over the run of the loudest tone."""
    power = np.abs(np.fft.rfft(left * np.hanning(left.size), PADDED * left.size))
    return max(float(np.argmax(power)), 1.0) / PADDED


def _moved(values: Array, time: Array, frequency: Array) -> tuple[Array, Array]:
    """The frequencies, moved to where they explain most, and what they leave of `values` there."""
    for _ in range(STEPS):
        tones = _tones(time, frequency)
        amplitude = _fitted(tones, values)
        cos, sin = tones[:, 1 : frequency.size + 1], tones[:, frequency.size + 1 :]
        a, b = amplitude[1 : frequency.size + 1], amplitude[frequency.size + 1 :]
        derivative = 2.0 * np.pi * time[:, None] * (b * cos - a * sin)
        moved = _fitted(np.column_stack([tones, derivative]), values - tones @ amplitude)
        frequency = frequency + np.clip(moved[-frequency.size :], -1.0 / PADDED, 1.0 / PADDED)
    tones = _tones(time, frequency)
    return frequency, values - tones @ _fitted(tones, values)


def _fitted(columns: Array, values: Array) -> Array:
    """Least squares by the normal equations, in a sixth of the time that singular values take.

    The ridge holds two tones that came to lie on each other.
    """
    normal = columns.T @ columns
    return np.asarray(np.linalg.solve(normal + np.diag(RIDGE * np.diag(normal) + 1e-300), columns.T @ values))


def _tones(time: Array, frequency: Array) -> Array:
    """(n, 2 k + 1) one, cosines and sines at times (n,) in parts of the run."""
    phase = 2.0 * np.pi * np.outer(time, frequency)
    return np.column_stack([np.ones(time.size), np.cos(phase), np.sin(phase)])
