"""The colour of the noise, beside jumps of the command and outliers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from incsvr.tracer.colour import burg, fades, reweighted
from incsvr.tracer.run import Array
from incsvr.tracer.weak_form import Blocks, split

MEMORY = 0.9
"""Autocorrelation of the noise from block to block."""


def noisy(seed: int, lengths: tuple[int, ...] = (2000, 3000)) -> tuple[Array, Blocks]:
    """Runs of noise with that memory and innovations of deviation one, and their blocks."""
    random = np.random.default_rng(seed)
    noise = np.concatenate([lfilter([1.0], [1.0, -MEMORY], random.normal(size=n)) for n in lengths])
    edges = np.concatenate([[0], np.cumsum(np.array(lengths) + 1)])
    return noise, split(edges, 1, 1.0)


def test_both_find_the_autocorrelation_over_several_runs() -> None:
    noise, blocks = noisy(1)
    for ar in (burg(noise, blocks), reweighted(noise, blocks)):
        np.testing.assert_allclose(ar, [MEMORY, 0.0, 0.0], atol=0.04)


def test_all_blocks_and_a_choice_of_them_are_read_alike() -> None:
    noise, blocks = noisy(2, (3000,))
    np.testing.assert_allclose(reweighted(noise, blocks.only(np.arange(3000) < 3001)), reweighted(noise, blocks))
    half = split(np.array([0, 1501]), 1, 1.0)
    np.testing.assert_allclose(
        reweighted(noise, blocks.only(np.arange(3000) < 1500)), reweighted(noise[:1500], half), atol=0.02
    )


@pytest.mark.parametrize("seed", range(4))
def test_what_the_instants_of_jumps_leave_is_not_taken_for_the_colour(seed: int) -> None:
    """A command that jumps in every sixth block, a third of a sample early or late: Burg's method alone misreads it."""
    noise, blocks = noisy(seed)
    random = np.random.default_rng(100 + seed)
    mistimed = np.where(random.random(len(blocks)) < 1.0 / 6.0, 60.0, 0.0)
    residual = noise + mistimed * random.normal(0.0, 0.3, len(blocks))
    blocks, loud = replace(blocks, mistimed=mistimed), 0.3**2
    assert abs(burg(residual, blocks, loud)[0] - MEMORY) > 0.2
    np.testing.assert_allclose(reweighted(residual, blocks, loud), [MEMORY, 0.0, 0.0], atol=0.03)


def test_outliers_are_not_taken_for_the_colour() -> None:
    noise, blocks = noisy(7)
    random = np.random.default_rng(8)
    spoiled = noise + (random.random(noise.size) < 0.02) * random.normal(0.0, 15.0, noise.size)
    np.testing.assert_allclose(reweighted(spoiled, blocks), [MEMORY, 0.0, 0.0], atol=0.1)
    assert abs(reweighted(spoiled, blocks)[0] - MEMORY) < 0.5 * abs(burg(spoiled, blocks)[0] - MEMORY)


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
    assert fades(reweighted(ramp, split(np.array([0, 401]), 1, 1.0)))
