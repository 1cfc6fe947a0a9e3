"""The command behind a noisy torque: predicted from other blocks, or told from its levels."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from incsvr.effects import Signals
from incsvr.tracing.run import Array
from incsvr.tracing.weak.command import estimated_command, is_noise, predict_torque
from incsvr.tracing.weak.weak_form import split


def correlation(a: Array, b: Array) -> float:
    return float(np.corrcoef(a, b)[0, 1])


class TestForetelling:
    """A command is told from earlier blocks alone, so that no noise of its own is in it."""

    blocks = split(np.array([0, 6001, 12002]), 4, 0.1)
    noise = np.random.default_rng(5).normal(size=len(blocks))

    def test_a_command_that_stays_is_its_mean_since_the_last_jump(self) -> None:
        command = np.repeat(np.random.default_rng(6).choice([-40.0, -20.0, 20.0, 40.0], 100), 30)
        torque = command + self.noise
        predicted_torque, _ = predict_torque(torque, self.blocks)
        predicted = predicted_torque != torque
        assert 0.95 < predicted.mean() < 0.98  # all but the jumps themselves, three in four of every thirtieth block
        error = (predicted_torque - command)[predicted]
        assert abs(error.mean()) < 0.05  # with jumps in a fit, a part of one would always be expected
        assert error.std() < 0.5
        assert abs(correlation(error, self.noise[predicted])) < 0.05

    def test_jumps_are_seen_however_many_and_however_soon_the_next(self) -> None:
        """Least squares from earlier blocks miss levels by far more than the noise: that is no measure of a jump."""
        random = np.random.default_rng(9)
        holds = random.integers(5, 15, len(self.blocks))
        levels = random.permuted(np.tile([-90.0, -50.0, 50.0, 90.0], len(self.blocks) // 4 + 1))
        command = np.repeat(levels[: len(self.blocks)], holds)[: len(self.blocks)]
        torque = command + self.noise
        predicted_torque, stays = predict_torque(torque, self.blocks)
        assert stays
        assert np.max(np.abs(predicted_torque - command)) < 6.0
        assert np.mean(predicted_torque == torque) < 0.25

    def test_a_command_that_moves_is_foretold_by_least_squares(self) -> None:
        command = 40.0 * np.sin(0.2 * np.arange(len(self.blocks)))
        torque = command + self.noise
        predicted_torque, _ = predict_torque(torque, self.blocks)
        predicted = np.flatnonzero(predicted_torque != torque)
        assert predicted.size > 0.9 * torque.size
        error = (predicted_torque - command)[predicted]
        assert error.std() < 1.2
        # neither its own noise nor that of the block before, whose edge it shares
        assert abs(correlation(error, self.noise[predicted])) < 0.05
        assert abs(correlation(error, self.noise[predicted - 1])) < 0.05

    def test_runs_too_short_to_tell_from_hold_their_own(self) -> None:
        for length in (13, 9):  # three blocks in each, or two
            short = split(np.arange(0, 200, length), 4, 0.1)
            torque = np.random.default_rng(7).normal(size=len(short))
            np.testing.assert_array_equal(predict_torque(torque, short)[0], torque)


class TestLevels:
    """A command of levels is told from the whole run: little of a block's own noise is in it."""

    STEP, SIZE = 0.05, 8
    TIME = np.asarray(0.05 * np.arange(14_401), dtype=np.float64)
    START = np.array([0, 7000, 14_401])
    BLOCKS = split(START, SIZE, STEP)

    def signals(self, command: Array, noise: float) -> Signals:
        torque = command + noise * np.random.default_rng(8).normal(size=command.size)
        return Signals(self.STEP, self.START, self.TIME, np.zeros_like(torque), torque)

    def test_a_command_that_moves_as_it_likes_is_none(self) -> None:
        steps = np.random.default_rng(9).normal(size=self.TIME.size)
        walk = np.asarray(np.convolve(np.cumsum(steps), np.ones(40) / 40.0, "same"), dtype=np.float64)
        assert estimated_command(self.signals(walk, 1.0), self.BLOCKS).levels is None

    def test_a_command_that_jumps_is_told(self) -> None:
        jumps = np.repeat(np.random.default_rng(9).choice([-40.0, 40.0], 145), 100)[: self.TIME.size]
        found = estimated_command(self.signals(jumps, 1.0), self.BLOCKS)
        assert found.stays
        assert found.levels is not None
        assert np.std(found.levels - jumps) < 0.25

    @pytest.mark.parametrize("memory", [0.0, 0.9])
    def test_a_command_at_rest_asks_for_nothing(self, memory: float) -> None:
        """Told as the mean of a rest its noise would be left, for a dead band to take; a small level stays a level."""
        draw = np.random.default_rng(14)
        command = np.repeat(draw.choice([-40.0, -6.0, 0.0, 0.0, 6.0, 40.0], 145), 100)[: self.TIME.size]
        noise = lfilter([np.sqrt(1.0 - memory**2)], [1.0, -memory], draw.normal(size=self.TIME.size))
        found = estimated_command(self.signals(command + noise, 0.0), self.BLOCKS)
        assert found.stays
        assert found.levels is not None
        far = np.convolve(np.abs(np.diff(command, prepend=command[0])) > 0.0, np.ones(25), "same") == 0.0
        rests, small = far & (command == 0.0), far & (np.abs(command) == 6.0)
        # but where a jump to or from a small level is taken for noise: its two stays are one
        assert np.mean(found.levels[rests] == 0.0) > 0.9
        assert np.mean(found.smoothed_torque[rests] == 0.0) > 0.9
        assert np.mean(np.abs(found.levels[small]) > 4.0) > 0.9

    @pytest.mark.parametrize("seed", range(15, 19))
    def test_small_levels_of_a_command_that_never_rests_stay_levels(self, seed: int) -> None:
        draw = np.random.default_rng(seed)
        command = np.repeat(draw.uniform(-30.0, 30.0, 145), 100)[: self.TIME.size]
        noise = lfilter([np.sqrt(0.19)], [1.0, -0.9], draw.normal(size=self.TIME.size))
        found = estimated_command(self.signals(command + noise, 0.0), self.BLOCKS)
        assert found.stays
        assert not np.any(found.smoothed_torque == 0.0)

    def test_a_jump_that_two_samples_share_is_one(self) -> None:
        """Between two cells it is no more than what noise does; between the means of a few there is no doubt."""
        draw = np.random.default_rng(9)
        level = draw.choice([-6.0, -3.3, 3.3, 6.0], 145)
        command = np.repeat(level, 100)[: self.TIME.size]
        shared = np.asarray(np.convolve(command, np.ones(3) / 3.0, "same"), dtype=np.float64)
        found = estimated_command(self.signals(shared, 0.35), self.BLOCKS).levels
        assert found is not None
        for a, b in zip(self.START[:-1], self.START[1:], strict=True):
            jumps = np.abs(np.diff(command[a:b], prepend=command[a])) > 0.0
            far = np.convolve(jumps, np.ones(9), "same") == 0.0
            assert np.max(np.abs(found - command)[a:b][far]) < 0.5

    def test_thrust_beside_the_levels_is_no_noise(self) -> None:
        """Noise of the torque is in the equation's residual as it is; thrust turned the vehicle, and is not."""
        draw = np.random.default_rng(10)
        beside, water = draw.normal(size=len(self.BLOCKS)), draw.normal(size=len(self.BLOCKS))
        assert is_noise(self.BLOCKS, beside, beside + water)
        assert not is_noise(self.BLOCKS, beside, water)

    @pytest.mark.parametrize("late", [0, 1, 2])
    def test_thrust_that_comes_late_is_no_noise(self, late: int) -> None:
        """At first it is in the residual as noise is; only the motion some blocks later tells it."""
        draw = np.random.default_rng(11)
        beside, water = draw.normal(size=len(self.BLOCKS)), draw.normal(size=len(self.BLOCKS))
        answered = np.concatenate([np.zeros(late), beside[: beside.size - late]])
        assert not is_noise(self.BLOCKS, beside, beside - answered + 0.3 * water)

    def test_what_the_water_hides_is_taken_for_noise(self) -> None:
        """Thrust so small would matter to no effect; but its noise, were it none, feigns thrust that falls short."""
        draw = np.random.default_rng(13)
        beside, water = draw.normal(size=len(self.BLOCKS)), draw.normal(size=len(self.BLOCKS))
        assert is_noise(self.BLOCKS, beside, 30.0 * water)

    def test_what_too_few_blocks_tell_is_not_taken_for_noise(self) -> None:
        few = split(np.array([0, 80 * self.SIZE + 1]), self.SIZE, self.STEP)
        beside = np.random.default_rng(12).normal(size=len(few))
        assert not is_noise(few, beside, beside)
