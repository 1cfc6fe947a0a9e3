"""A start for the fit: least squares of the equation's integrals over spans, ∫τ = M Δν + Σ θ ∫φ."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.model.factors import one_by_one
from incsvr.model.rows import Row
from incsvr.model.series import effort_of, period, values
from incsvr.model.structure import Structure
from incsvr.model.windows import ANGLES
from incsvr.numerics import Array, Streams


def start(structure: Structure, runs: Sequence[Streams]) -> dict[str, float]:
    """θ of a structure from integrals, each axis by itself, over the span that explains the integrals best."""
    theta = dict.fromkeys(structure.names, 0.0)
    before = 0.0
    for axis in structure.axes:
        rows = [row for row in structure.rows if row.axis == axis and not row.follows]
        tried = []
        shortest = min(run[axis][0].size for run in runs)
        for span in 2 ** np.arange(1, max(2, int(np.log2(max(shortest, 40) / 10)) + 1)):
            found = _least_squares(structure, runs, axis, rows, int(span), before)
            if found is not None:
                tried.append(found)
        solution = min(tried, key=lambda pair: pair[0])[1] if tried else np.r_[np.exp(before), np.zeros(len(rows))]
        before = float(np.log(max(solution[0], 1e-9)))
        if axis not in structure.given:
            theta[f"mass:{axis}"] = before
        for row, value in zip(rows, solution[1:], strict=True):
            theta[row.key] = float(np.clip(value, row.low, row.high))
        _brake(theta, structure, runs, axis)
    return theta


def _brake(theta: dict[str, float], structure: Structure, runs: Sequence[Streams], axis: str) -> None:
    """Where the least squares find no damping, the fit begins with one that settles in some twenty samples."""
    fast = float(np.quantile(np.abs(values(runs, axis)), 0.9))
    slope = theta.get(f"linear@{axis}", 0.0) + 2.0 * theta.get(f"quadratic@{axis}", 0.0) * fast
    if slope <= 0.0 and f"linear@{axis}" in theta:
        theta[f"linear@{axis}"] = structure.inertia(theta, axis) / (20.0 * period(runs, axis))
        if f"quadratic@{axis}" in theta:
            theta[f"quadratic@{axis}"] = 0.0


def _least_squares(
    structure: Structure, runs: Sequence[Streams], axis: str, rows: Sequence[Row], span: int, before: float
) -> tuple[float, Array] | None:
    """(residual share, solution): inertia, then coefficients; None where the recordings are too short for the span, or
    the inertia is not positive."""
    lefts, rights = [], []
    for run in runs:
        t, v = run[axis]
        if t.size <= 3 * span:
            continue
        signals = {
            name: np.interp(t, stamps, np.unwrap(value) if name in ANGLES else value)
            for name, (stamps, value) in run.items()
        }
        columns = [
            part.sign * one_by_one(part.one, signals) * one_by_one(part.other, signals)
            for part in (next(part for part in row.parts if part.axis == axis) for row in rows)
        ]
        effort = signals[effort_of(axis)] if axis in structure.driven else np.zeros_like(t)
        whole = np.array([*columns, effort])
        sums = np.concatenate(
            [np.zeros((len(whole), 1)), np.cumsum(0.5 * (whole[:, 1:] + whole[:, :-1]) * np.diff(t), axis=1)], axis=1
        )
        k = np.arange(0, t.size - span, max(1, span // 4))
        change = sums[:, k + span] - sums[:, k]
        lefts.append(np.column_stack([v[k + span] - v[k], change[:-1].T]))
        rights.append(change[-1])
    if not lefts:
        return None
    left, right = np.concatenate(lefts), np.concatenate(rights)
    if axis in structure.given or not np.any(right):  # where nothing drives, coefficients are in units of the inertia
        inertia = float(np.exp(structure.given.get(axis, before)))
        right = right - inertia * left[:, 0]
        size = left[:, 1:].std(axis=0) + 1e-12
        solution = np.r_[inertia, np.linalg.lstsq(left[:, 1:] / size, right, rcond=1e-8)[0] / size]
        rest = left[:, 1:] @ solution[1:] - right
    else:
        size = left.std(axis=0) + 1e-12
        solution = np.linalg.lstsq(left / size, right, rcond=1e-8)[0] / size
        rest = left @ solution - right
    if solution[0] <= 0.0:
        return None
    return float(np.mean(rest**2) / max(np.mean(right**2), 1e-300)), solution
