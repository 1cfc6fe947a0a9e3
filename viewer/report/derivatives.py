"""Hydrodynamic derivatives of a traced model, with intervals: of yaw N_r, N_{r|r|} and I − N_ṙ, in SNAME's letters."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from incsvr.numerics import Array
from incsvr.plant.axes import YAW, Axis
from incsvr.plant.words import words_of
from incsvr.tracing import Trace

BLOCK_TIME_SCALES = 4.0
"""Time scales of the motion in a block of the bootstrap: well above the residual's correlation time."""

BOOTSTRAP_DRAWS = 1000
"""Draws of the bootstrap."""


class Derivative(NamedTuple):
    """One of them, positive where it opposes the motion; without an interval it was declared, and not found.

    Attributes:
        interval: of 95 %.
    """

    symbol: str
    value: float
    interval: tuple[float, float] | None
    unit: str


def derivatives(trace: Trace, axis: Axis = YAW) -> tuple[list[Derivative], tuple[float, float]]:
    """The derivatives, and the rates that they hold for [rad/s].

    N_r and N_{r|r|} are those of the least squares d(r) = N_r r + N_{r|r|} r|r| on the damping that the fitted
    recordings show, d(r) and what the model leaves; their intervals are a moving-block bootstrap's (H. R. Künsch, Ann.
    Stat. 17, 1989).
    """
    pictures, model = trace.pictures, trace.model
    rate = pictures.depends["yaw_rate"]
    kept = np.isfinite(rate) & np.isfinite(pictures.residual_after)
    rate = rate[kept]
    damping = model.damping_at(rate) + pictures.residual_after[kept]
    terms = np.column_stack([rate, rate * np.abs(rate)])
    size = max(min(round(BLOCK_TIME_SCALES * model.scale / model.block), rate.size), 1)
    starts = range(0, rate.size - size + 1, max(size // 2, 1))
    normal = np.array([terms[a : a + size].T @ terms[a : a + size] for a in starts])
    score = np.array([terms[a : a + size].T @ damping[a : a + size] for a in starts])
    drawn = np.random.default_rng(0).integers(len(normal), size=(BOOTSTRAP_DRAWS, max(rate.size // size, 1)))
    spread = np.array([_solved(normal[each].sum(axis=0), score[each].sum(axis=0)) for each in drawn])
    value = _solved(terms.T @ terms, terms.T @ damping)
    low, high = np.quantile(spread, [0.025, 0.975], axis=0)
    inertia = next((each for each in trace.effects if each.effect == "inertia"), None)
    total, between = trace.inertia, None
    if inertia is not None:
        (total, *_), (between, *_) = inertia.parameters.values(), inertia.interval.values()
    words = words_of(axis)
    with_added_mass = f"{words.inertia_symbol} − {words.linear}\u0307"
    return [
        Derivative(words.linear, float(value[0]), (float(low[0]), float(high[0])), words.linear_unit),
        Derivative(words.quadratic, float(value[1]), (float(low[1]), float(high[1])), words.quadratic_unit),
        Derivative(with_added_mass, total, between, words.inertia_unit),
    ], (float(rate.min()), float(rate.max()))


def _solved(normal: Array, score: Array) -> Array:
    # at one rate alone the two cannot be told apart
    return np.asarray(np.linalg.pinv(normal, hermitian=True) @ score)
