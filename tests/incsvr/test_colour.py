"""The colour of the noise."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from incsvr.tracing.run import Array
from incsvr.tracing.weak.noise_autocorrelation import burg
from incsvr.tracing.weak.weak_form import Blocks, split

MEMORY = 0.9
"""Autocorrelation of the noise from block to block."""


def noisy(seed: int, lengths: tuple[int, ...] = (2000, 3000)) -> tuple[Array, Blocks]:
    """Runs of noise with that memory and innovations of deviation one, and their blocks."""
    random = np.random.default_rng(seed)
    noise = np.concatenate([lfilter([1.0], [1.0, -MEMORY], random.normal(size=n)) for n in lengths])
    edges = np.concatenate([[0], np.cumsum(np.array(lengths) + 1)])
    return noise, split(edges, 1, 1.0)


def test_it_finds_the_autocorrelation_over_several_runs() -> None:
    noise, blocks = noisy(1)
    np.testing.assert_allclose(burg(noise, blocks), [MEMORY, 0.0, 0.0], atol=0.04)


def test_runs_foretell_nothing_of_each_other() -> None:
    """In another order they would foretell something else."""
    random = np.random.default_rng(5)
    runs = [level + random.normal(size=n) for level, n in ((3.0, 40), (-2.0, 70), (0.0, 55))]
    found = []
    for order in ((0, 1, 2), (2, 0, 1)):
        edges = np.concatenate([[0], np.cumsum([runs[k].size + 1 for k in order])])
        found.append(burg(np.concatenate([runs[k] for k in order]), split(edges, 1, 1.0)))
    np.testing.assert_allclose(found[0], found[1], atol=1e-12)
