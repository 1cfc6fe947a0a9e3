"""The colour of the noise, beside jumps of the command."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from incsvr.tracing.run import Array
from incsvr.tracing.weak.noise_autocorrelation import autoregression, burg, fades
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


def jumping(seed: int, size: float) -> tuple[Array, Blocks, float]:
    """Noise beside a command that jumps in every sixth block, a third of a sample early or late; by that a sample is
    `size` [N m]. Residual, blocks, and the variance of the instants."""
    noise, blocks = noisy(seed)
    random = np.random.default_rng(100 + seed)
    mistimed = np.where(random.random(len(blocks)) < 1.0 / 6.0, size, 0.0)
    return noise + mistimed * random.normal(0.0, 0.3, len(blocks)), replace(blocks, mistimed=mistimed), 0.3**2


@pytest.mark.parametrize("seed", range(4))
def test_what_the_instants_of_jumps_leave_is_not_taken_for_the_colour(seed: int) -> None:
    residual, blocks, jump_noise = jumping(seed, 60.0)
    assert abs(burg(residual, blocks, jump_noise)[0] - MEMORY) > 0.2
    np.testing.assert_allclose(autoregression(residual, blocks, jump_noise), [MEMORY, 0.0, 0.0], atol=0.03)


def test_some_blocks_are_read_as_if_they_were_all() -> None:
    residual, blocks, jump_noise = jumping(2, 60.0)
    first = np.arange(len(blocks)) < 2000  # the first run
    alone = replace(split(np.array([0, 2001]), 1, 1.0), mistimed=blocks.mistimed[first])
    np.testing.assert_allclose(
        autoregression(residual, blocks.only(first), jump_noise),
        autoregression(residual[first], alone, jump_noise),
        atol=0.02,
    )


def test_a_command_that_hardly_jumps_leaves_the_colour_to_burg() -> None:
    residual, blocks, jump_noise = jumping(3, 1.0)
    np.testing.assert_array_equal(autoregression(residual, blocks, jump_noise), burg(residual, blocks, jump_noise))


def test_a_colour_fades_where_all_roots_lie_within_the_unit_circle() -> None:
    random = np.random.default_rng(0)
    kept = 0
    for ar in random.normal(0.0, 0.8, (500, 3)):
        inside = bool(np.max(np.abs(np.roots([1.0, *-ar]))) < 1.0)
        assert fades(ar) == inside
        kept += inside
    assert 50 < kept < 450


def test_a_ramp_has_no_colour_that_grows() -> None:
    """Least squares would let it grow without end; Burg's stays."""
    ramp = np.power(1.02, np.arange(400.0))
    blocks = replace(split(np.array([0, 401]), 1, 1.0), mistimed=np.where(np.arange(400) % 9 == 0, 10.0, 0.0))
    assert fades(autoregression(ramp, blocks, 1.0))
