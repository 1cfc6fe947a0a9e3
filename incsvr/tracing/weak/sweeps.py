"""A command that is one sweeping tone, told from the whole run: no block's own noise is in it to speak of.

The analytic signal of D. Gabor, "Theory of communication", J. IEE 93 (1946), says where its phase is to begin from.
Between the instants at which a sweep begins anew the phase is a polynomial, fitted to the torque by Gauss-Newton: the
maximum likelihood of P. M. Djurić and S. M. Kay, "Parameter estimation of chirp signals", IEEE Trans. ASSP 38 (1990).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d
from scipy.signal import hilbert

from incsvr.effects import Signals
from incsvr.tracing.run import Array

UNEVEN = 0.25
"""Most by which the analytic signal's size may usually leave its median: more is no single tone."""

ANEW = 2.0
"""Factor by which the frequency changes at once where a sweep begins anew."""

DEGREES = (3, 5, 7, 9, 11, 13)
"""Of the phase between two such instants, as BIC asks: an exponential sweep over a decade needs nine."""

STEPS = 4
"""Of Gauss-Newton at each degree."""

FEWEST = 200
"""Samples of a piece: fewer would be explained by any phase."""


def as_sweeps(signals: Signals) -> Array:
    """(n,) the torque as a constant and one sweeping tone, run by run; its mean in a run that is none [N m]."""
    found = np.empty(len(signals))
    for run in signals.runs():
        torque = signals.torque[run]
        window = max(round(signals.scale / signals.step), 3)
        found[run] = _sweep(torque, window) if torque.size > FEWEST else np.mean(torque)
    return found


def _sweep(torque: Array, window: int) -> Array:
    none = np.full(torque.size, float(np.mean(torque)))
    smooth = uniform_filter1d(torque, max(window // 4, 1))
    analytic = hilbert(smooth - np.mean(smooth))
    size = np.abs(analytic)
    usual = float(np.median(size))
    if not usual > 0.0 or 1.4826 * float(np.median(np.abs(size - usual))) > UNEVEN * usual:
        return none
    phase = np.asarray(np.unwrap(np.angle(analytic)), dtype=np.float64)
    sweeps = list(pairwise(_anew(phase)))
    # at the ends of a run, where the analytic signal ends as well, a part that is too short stays as it was recorded
    for end in (0, -1):
        while sweeps and sweeps[end][1] - sweeps[end][0] < FEWEST:
            sweeps.pop(end)
    if not sweeps or min(b - a for a, b in sweeps) < FEWEST:
        return none
    found = torque.copy()
    found[sweeps[0][0] : sweeps[-1][1]] = _fitted(torque, phase, sweeps, window)
    return found


def _fitted(torque: Array, phase: Array, sweeps: list[tuple[int, int]], window: int) -> Array:
    """The torque from the first sweep to the last as one tone whose phase is a polynomial in each of them."""
    pieces = []
    for a, b in sweeps:
        near = min(window, (b - a) // 8)  # at its ends the analytic signal is no guide
        time = np.arange(a + near, b - near)
        pieces.append(_Piece(a, b, a, b, chebyshev.chebfit(_within(time, a, b), phase[time], DEGREES[0])))
    torque = torque[: sweeps[-1][1]]
    best, least = torque[sweeps[0][0] :], np.inf
    for degree in DEGREES:
        pieces = [replace(p, curve=np.append(p.curve, np.zeros(degree + 1 - p.curve.size))) for p in pieces]
        for _ in range(STEPS):
            level, amplitude = _levelled(torque, pieces)
            pieces = _met(torque, pieces, window, level, amplitude)
            pieces = [_improved(torque, piece, level, amplitude) for piece in pieces]
        level, amplitude = _levelled(torque, pieces)
        found = level + amplitude * np.cos(_phase(pieces))
        left = float(np.sum((torque[pieces[0].begin :] - found) ** 2))
        criterion = torque.size * np.log(max(left, 1e-300)) + (degree + 1) * len(pieces) * np.log(torque.size)
        if criterion >= least:
            break
        best, least = found, criterion
    return best


@dataclass(frozen=True, slots=True)
class _Piece:
    """One sweep: its samples, those over which its curve runs from −1 to 1, and the phase as a Chebyshev series."""

    begin: int
    end: int
    first: int
    last: int
    curve: Array

    def phase(self, time: NDArray[np.intp]) -> Array:
        return np.asarray(chebyshev.chebval(_within(time, self.first, self.last), self.curve), dtype=np.float64)


def _within(time: NDArray[np.intp], first: int, last: int) -> Array:
    return np.asarray(2.0 * (time - first) / (last - first) - 1.0, dtype=np.float64)


def _anew(phase: Array) -> list[int]:
    """First samples of the sweeps, and the end: where half a cycle takes another time at once."""
    time = np.arange(phase.size, dtype=np.float64)
    increasing = np.maximum.accumulate(phase) + 1e-9 * time
    before = time - np.interp(increasing - np.pi, increasing, time)
    after = np.interp(increasing + np.pi, increasing, time) - time
    known = (increasing - np.pi >= increasing[0]) & (increasing + np.pi <= increasing[-1])
    change = np.where(known, np.abs(np.log(np.maximum(after, 1.0) / np.maximum(before, 1.0))), 0.0)
    edges = [0, phase.size]
    while change[k := int(np.argmax(change))] > np.log(ANEW):
        edges.append(k)
        near = round(max(before[k], after[k]))
        change[max(k - near, 0) : k + near + 1] = 0.0
    return sorted(edges)


def _phase(pieces: list[_Piece]) -> Array:
    return np.concatenate([piece.phase(np.arange(piece.begin, piece.end)) for piece in pieces])


def _levelled(torque: Array, pieces: list[_Piece]) -> tuple[float, float]:
    """The constant and the amplitude that explain most at this phase."""
    tone = np.cos(_phase(pieces))
    columns = np.column_stack([np.ones(tone.size), tone])
    level, amplitude = np.linalg.lstsq(columns, torque[pieces[0].begin :], rcond=1e-10)[0]
    return float(level), float(amplitude)


def _improved(torque: Array, piece: _Piece, level: float, amplitude: float) -> _Piece:
    """The phase one step of Gauss-Newton nearer, and no farther than a radian."""
    time = np.arange(piece.begin, piece.end)
    basis = chebyshev.chebvander(_within(time, piece.first, piece.last), piece.curve.size - 1)
    phase = basis @ piece.curve
    left = torque[piece.begin : piece.end] - level - amplitude * np.cos(phase)
    step = np.linalg.lstsq(-amplitude * np.sin(phase)[:, None] * basis, left, rcond=1e-10)[0]
    return replace(piece, curve=piece.curve + step / max(1.0, float(np.max(np.abs(basis @ step)))))


def _met(torque: Array, pieces: list[_Piece], window: int, level: float, amplitude: float) -> list[_Piece]:
    """The instants at which a sweep begins anew, moved to where its two sides leave least."""
    met = list(pieces)
    for k in range(len(met) - 1):
        one, two = met[k], met[k + 1]
        near = np.arange(max(one.end - 2 * window, one.begin + 1), min(one.end + 2 * window, two.end))
        before, after = (np.square(torque[near] - level - amplitude * np.cos(p.phase(near))) for p in (one, two))
        lost = np.cumsum(before) - before + np.sum(after) - np.cumsum(after) + after
        meets = int(near[int(np.argmin(lost))])
        met[k], met[k + 1] = replace(one, end=meets), replace(two, begin=meets)
    return met
