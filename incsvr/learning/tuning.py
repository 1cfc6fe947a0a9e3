"""Choosing C, ε and γ: the grid search of Section IV-B that leaves one batch out.

For each point of the grid the learner runs over all batches but one, in their order, and is judged by its mean absolute
error on that one; each batch is left out once, and the errors are averaged. Nothing is random.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.iteration import Settings
from incsvr.learning.learner import start, step
from incsvr.samples import Samples


@dataclass(frozen=True, slots=True)
class Grid:
    """The values to try; the defaults are the paper's, for ±0.25 rad/s and ±100 N m."""

    C: Sequence[float] = (10.0, 100.0, 1000.0, 10000.0)
    epsilon: Sequence[float] = (0.1, 1.0, 2.0, 5.0)
    gamma: Sequence[float] = (5.0, 10.0, 20.0, 30.0)

    def __len__(self) -> int:
        return len(self.C) * len(self.epsilon) * len(self.gamma)


@dataclass(frozen=True, slots=True)
class Trial:
    """One point of the grid.

    Attributes:
        settings: with its C [N m], epsilon [N m] and gamma [(rad/s)⁻²].
        mae: mean over the batches left out of the mean absolute error on each [N m].
        spread: standard deviation over the batches left out [N m].
    """

    settings: Settings
    mae: float
    spread: float


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
        errors = np.array([_error(trial, batches, left_out) for left_out in range(count)])
        yield Trial(trial, float(errors.mean()), float(errors.std(ddof=1)))


def best(trials: Sequence[Trial]) -> Trial:
    """The trial with the smallest error; of equals the first."""
    return min(trials, key=lambda trial: trial.mae)


def _error(settings: Settings, batches: Sequence[Samples], left_out: int) -> float:
    """MAE [N m] on one batch after learning from the others; the curve itself, not its continuation."""
    state = start(settings)
    for k, batch in enumerate(batches):
        if k != left_out:
            state, _ = step(settings, state, batch)
    unseen = batches[left_out]
    return float(np.abs(state.model.evaluate(unseen.yaw_rate) - unseen.damping).mean())
