"""Choosing C, ε and γ: the grid search of Section IV-B that leaves one batch out.

For each point of the grid the learner runs over all batches but one, in their order, and is judged by its mean absolute
error on that one: after every training step, averaged over all iterations, as the paper's text says, and after the last
step alone. Each batch is left out once, and the errors are averaged. Nothing is random, and no batch is shuffled.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Literal

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.iteration import Settings
from incsvr.learning.learner import State, start, step
from incsvr.numerics import Array
from incsvr.signals.samples import Samples

Judged = Literal["every", "last"]
"""The judgement by the mean over all iterations, or by the last one alone."""

PAPER_POINT = (1000.0, 0.1, 10.0)
"""C [N m], ε [N m] and γ [(rad/s)⁻²] that the paper's search chose."""


@dataclass(frozen=True, slots=True)
class Grid:
    """The values to try; the defaults are the paper's, for ±0.25 rad/s and ±100 N m."""

    C: Sequence[float] = (10.0, 100.0, 1000.0, 10000.0)
    epsilon: Sequence[float] = (0.1, 1.0, 2.0, 5.0)
    gamma: Sequence[float] = (5.0, 10.0, 20.0, 30.0)

    def __len__(self) -> int:
        return len(self.C) * len(self.epsilon) * len(self.gamma)

    def scaled(self, rate: float, damping: float) -> Grid:
        """The grid for a vehicle that turns `rate` times as fast and is damped `damping` times as much."""
        return Grid(
            [C * damping for C in self.C], [e * damping for e in self.epsilon], [g / rate**2 for g in self.gamma]
        )


@dataclass(frozen=True, slots=True)
class Trial:
    """One point of the grid."""

    settings: Settings  # with its C [N m], epsilon [N m] and gamma [(rad/s)⁻²]
    # mean absolute error on the batch left out after each training step, mean of all steps and batches [N m]
    every: float
    last: float  # the same after the last step alone [N m]
    spread: tuple[float, float]  # standard deviation of both over the batches left out [N m]

    @property
    def point(self) -> tuple[float, float, float]:
        """C, ε and γ."""
        return self.settings.C, self.settings.epsilon, self.settings.gamma


def search(samples: Samples, settings: Settings, grid: Grid | None = None) -> Iterator[Trial]:
    """Tries the grid, one trial after the other, so that the caller can show how far it is.

    Args:
        samples: at least two full batches; what is left over after the last full one is not used.
        settings: all but C, epsilon and gamma.

    Raises:
        BadInput: fewer than two batches.
    """
    grid = grid or Grid()
    count = len(samples) // settings.batch
    if count < 2:
        raise BadInput(
            f"{len(samples)} samples are {count} full batches of {settings.batch}; leaving one out needs at least two"
        )
    batches = [samples.take(slice(k * settings.batch, (k + 1) * settings.batch)) for k in range(count)]
    for C, epsilon, gamma in product(grid.C, grid.epsilon, grid.gamma):
        trial = replace(settings, C=C, epsilon=epsilon, gamma=gamma)
        errors = _left_out(trial, batches)
        every, last = errors.mean(axis=0).tolist()
        spread = errors.std(axis=0, ddof=1).tolist()
        yield Trial(trial, every, last, (spread[0], spread[1]))


def ranked(trials: Sequence[Trial], judged: Judged) -> list[Trial]:
    """The trials from the smallest error on; of equals the first comes first."""
    return sorted(trials, key=lambda trial: getattr(trial, judged))


def _left_out(settings: Settings, batches: Sequence[Samples]) -> Array:
    """(batches, 2): the error on each batch when it is left out, mean of all iterations and at the end [N m].

    What was learned before the batch that is left out is the same for all that come after it: it is learned once.
    """
    errors, before, models = [], start(settings), list[State]()
    for left_out, unseen in enumerate(batches):
        state, rest = before, list[State]()
        for batch in batches[left_out + 1 :]:
            state, _ = step(settings, state, batch)
            rest.append(state)
        curve = [_error(each, unseen) for each in (*models, *rest)]
        errors.append((float(np.mean(curve)), curve[-1]))
        before, _ = step(settings, before, unseen)
        models.append(before)
    return np.array(errors)


def _error(state: State, unseen: Samples) -> float:
    """MAE [N m] of the curve itself, not of its continuation."""
    return float(np.abs(state.model.evaluate(unseen.yaw_rate) - unseen.damping).mean())
