"""The yaw rate's answer to what the equations of a block do not foretell, against motions that were integrated."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from incsvr.tracing.run import Array
from incsvr.tracing.weak.disturbance_response import DisturbanceResponse, disturbance_response
from incsvr.tracing.weak.noise_autocorrelation import burg
from incsvr.tracing.weak.weak_form import Blocks, split
from incsvr.tracing.weak.whitening import whiten

INERTIA, PERIOD, SIZE, STEP = 1.0, 0.35, 35, 0.01
WHITE = np.zeros(3)


def pushed(
    seed: int, memory: float, gain: float, white: float = 0.0, count: int = 40_000
) -> tuple[Blocks, Array, Array]:
    """Blocks, disturbance and rate of I ṙ = w − gain r, in steps of 0.01 s; w fades by exp(−T_b/memory) in a block,
    beside white noise of that deviation in its mean over a block."""
    keep, random = np.exp(-STEP / memory), np.random.default_rng(seed)
    water = lfilter([np.sqrt(1.0 - keep**2)], [1.0, -keep], random.normal(size=count * SIZE))
    water = water + white * np.sqrt(SIZE) * random.normal(size=water.size)
    fades = np.exp(-gain * STEP / INERTIA)
    # the rate that a step's disturbance ends with is the next one's beginning
    rate = np.concatenate([[0.0], lfilter([(1.0 - fades) / gain], [1.0, -fades], water)[:-1]])
    return split(np.array([0, rate.size]), SIZE, STEP), water, rate


def measured(blocks: Blocks, unforeseen: Array, ar: Array, values: Array) -> float:
    """Slope of a column of block values by what was not foreseen of its block, both whitened."""
    return float(whiten(values, ar, blocks) @ unforeseen / (unforeseen @ unforeseen))


@pytest.mark.parametrize("gain", [2.0, 9.0])
def test_white_noise_is_answered_as_the_rate_runs(gain: float) -> None:
    """Against I ṙ = 1 − K r: r(T_b) and its mean."""
    answer = disturbance_response(np.zeros(2), gain, WHITE, 0.0, PERIOD, INERTIA)
    time = np.linspace(0.0, PERIOD, 20_001)
    rate = (1.0 - np.exp(-gain * time / INERTIA)) / gain
    assert answer.rise == pytest.approx(rate[-1], rel=1e-3)
    assert answer.mean == pytest.approx(rate.mean(), rel=1e-2)


def test_without_damping_and_controller_the_rate_runs_straight() -> None:
    answer = disturbance_response(np.zeros(2), 0.0, WHITE, 0.0, PERIOD, INERTIA)
    assert answer.rise == pytest.approx(PERIOD / INERTIA, rel=1e-3)
    assert answer.mean == pytest.approx(0.5 * PERIOD / INERTIA, rel=1e-3)


@pytest.mark.parametrize("memory", [0.2, 0.7, 3.0])
@pytest.mark.parametrize("gain", [3.0, 9.0])
def test_noise_that_lasts_is_answered_before_its_block(memory: float, gain: float) -> None:
    """Rise and mean are what a vehicle does; taken as white, the noise would turn it by a quarter more."""
    blocks, water, rate = pushed(1, memory, gain)
    mean = blocks.mean(water)
    ar = burg(mean, blocks)
    answer, white = (disturbance_response(np.zeros(2), gain, colour, 0.0, PERIOD, INERTIA) for colour in (ar, WHITE))
    unforeseen = whiten(mean, ar, blocks)
    rise = measured(blocks, unforeseen, ar, blocks.slope(rate) * PERIOD)
    assert answer.rise == pytest.approx(rise, rel=0.06)
    assert answer.mean == pytest.approx(measured(blocks, unforeseen, ar, blocks.mean(rate)), rel=0.06)
    if memory > 0.5 and gain > 5.0:
        assert white.rise[0] > 1.25 * rise


@pytest.mark.parametrize("of_the_water", [True, False])
def test_of_white_noise_beside_it_the_waters_turns_the_vehicle(of_the_water: bool) -> None:
    """The torque's does not: what it foretells of a block it only seems to."""
    white, gain = 0.7, 5.0
    blocks, water, rate = pushed(3, 0.7, gain, white if of_the_water else 0.0)
    seen = blocks.mean(water)
    if not of_the_water:
        seen = seen + white * np.random.default_rng(4).normal(size=seen.size)
    ar = burg(seen, blocks)
    unforeseen = whiten(seen, ar, blocks)
    noise_fraction = 0.0 if of_the_water else white**2 / float(np.var(unforeseen))
    answer = disturbance_response(np.zeros(2), gain, ar, noise_fraction, PERIOD, INERTIA)
    rise = measured(blocks, unforeseen, ar, blocks.slope(rate) * PERIOD)
    # what turns the vehicle of e is for the equations to say, not for its answer
    turning = 1.0 - noise_fraction
    assert turning * answer.rise == pytest.approx(rise, rel=0.12)


@pytest.mark.parametrize("memory", [0.02, 0.7])
def test_damping_takes_its_part(memory: float) -> None:
    """What I₀ Δr/T_b − τ shows of e is what the damping, not yet known, leaves: e = shown + d' r."""
    slope, gain = 4.0, 3.0
    blocks, water, rate = pushed(2, memory, slope + gain)
    ar = burg(blocks.mean(water), blocks)
    shown = whiten(blocks.mean(water) - slope * blocks.mean(rate), ar, blocks)
    unforeseen = whiten(blocks.mean(water), ar, blocks)
    part = float(shown @ unforeseen / (unforeseen @ unforeseen))
    answer = disturbance_response(np.full(2, slope), gain, ar, 0.0, PERIOD, INERTIA)
    assert answer.mean * part == pytest.approx(measured(blocks, unforeseen, ar, blocks.mean(rate)), rel=0.06)


def test_the_whole_path_ends_as_the_course_does() -> None:
    answer: DisturbanceResponse = disturbance_response(
        np.zeros(3), 5.0, np.array([0.6, 0.1, 0.0]), 0.0, PERIOD, INERTIA
    )
    assert answer.left(answer.path) == pytest.approx(answer.mean[0], rel=1e-9)
