"""Transport and probation, seen from the vectors."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.learning.learner import Settings, State, step
from incsvr.learning.policies.watch import PROBATION_BATCHES, follow
from incsvr.learning.policies.weighted import Memory
from incsvr.signals.samples import Samples
from tests.incsvr.learning import drag, run, stream

SETTINGS = Settings(policy="weighted")


@pytest.fixture(scope="module")
def learned() -> State:
    return run(SETTINGS, stream(1, 700))[0]


def batch(seed: int, gain: float, fastest: float) -> Samples:
    rng = np.random.default_rng(seed)
    rate = rng.uniform(-fastest, fastest, 50)
    return Samples(500.0 + np.linspace(0.0, 29.4, 50), rate, (1.0 + gain) * drag(rate) + 4.0 * rng.normal(size=50))


def followed(state: State, samples: Samples) -> tuple[Memory, str | None]:
    memory = state.memory
    assert isinstance(memory, Memory)
    vectors, watch, sentence = follow(
        SETTINGS,
        memory.watch,
        memory.vectors,
        state.model,
        memory.noise,
        samples,
        state.model.evaluate(samples.yaw_rate),
        np.arange(len(samples)),
    )
    return Memory(vectors, memory.fastest, memory.noise, watch), sentence


def test_a_correction_is_not_trusted_beyond_the_rates_that_showed_it(learned: State) -> None:
    before = learned.memory
    assert isinstance(before, Memory)
    after, sentence = followed(learned, batch(4, 0.6, 0.12))
    assert sentence is not None
    rate = before.vectors.points.yaw_rate
    moved = after.vectors.points.damping - before.vectors.points.damping
    beyond = rate > 0.12
    assert np.ptp(moved[beyond]) < 0.3  # where a gain alone would have added 40 N m on the way
    assert 10.0 < moved[beyond].mean() < 30.0


def test_a_correction_that_the_next_batches_deny_is_taken_back(learned: State) -> None:
    state, iteration = step(SETTINGS, learned, batch(5, 0.25, 0.24))
    assert iteration.change is not None
    told = []
    for seed in range(6, 6 + PROBATION_BATCHES):
        state, iteration = step(SETTINGS, state, batch(seed, 0.0, 0.24))
        told.append(iteration.change)
    assert "as it was before" in str(told[0])
    assert told[1:] == [None] * (PROBATION_BATCHES - 1)
    rates = np.linspace(-0.24, 0.24, 49)
    assert np.abs(state.model.evaluate(rates) - drag(rates)).max() < 4.0


def test_probation_ends(learned: State) -> None:
    state, _ = step(SETTINGS, learned, batch(5, 0.25, 0.24))
    for seed in range(20, 20 + PROBATION_BATCHES):
        assert isinstance(state.memory, Memory)
        assert state.memory.watch.probation is not None
        state, iteration = step(SETTINGS, state, batch(seed, 0.25, 0.24))
        assert iteration.change is None
    assert isinstance(state.memory, Memory)
    assert state.memory.watch.probation is None
