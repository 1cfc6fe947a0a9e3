"""What the tracer knows of the noise: where it sits, and a command foretold without it."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.tracer.noise import foretell, noise_share
from incsvr.tracer.run import Array
from incsvr.tracer.weak_form import split


def correlation(a: Array, b: Array) -> float:
    return float(np.corrcoef(a, b)[0, 1])


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_the_share_of_the_torque_is_read_beside_the_gyros_noise(share: float) -> None:
    """The gyro's noise is in neither the torque nor the water; unknown, it would pass for water."""
    draw = np.random.default_rng(4)
    n = 20_000
    blocks = split(np.array([0, 4 * n + 1]), 4, 0.1)
    fine = np.repeat(draw.normal(size=n), 4)
    fine = np.concatenate([fine, fine[-1:]])
    torque = blocks.mean(fine)
    fastest = float(np.std(np.diff(torque, 3)) / np.sqrt(20.0))
    water = fastest * np.sqrt((1.0 - share) / share) * draw.normal(size=n)
    gyro, again = (0.3 * fastest * np.diff(draw.normal(size=n + 1)) for _ in range(2))
    residual = torque - water + gyro
    found, blind = noise_share(blocks, fine, residual, again), noise_share(blocks, fine, residual)
    assert found is not None
    assert blind is not None
    assert found == pytest.approx(share, abs=0.05)
    assert blind < found - 0.2 * share**2


class TestForetelling:
    """A command is told from earlier blocks alone, so that no noise of its own is in it."""

    blocks = split(np.array([0, 6001, 12002]), 4, 0.1)
    noise = np.random.default_rng(5).normal(size=len(blocks))

    def test_a_command_that_stays_is_its_mean_since_the_last_jump(self) -> None:
        command = np.repeat(np.random.default_rng(6).choice([-40.0, -20.0, 20.0, 40.0], 100), 30)
        torque = command + self.noise
        foretold, _ = foretell(torque, self.blocks)
        told = foretold != torque
        assert 0.95 < told.mean() < 0.98  # all but the jumps themselves, three in four of every thirtieth block
        error = (foretold - command)[told]
        assert abs(error.mean()) < 0.05  # with jumps in a fit, a part of one would always be expected
        assert error.std() < 0.5
        assert abs(correlation(error, self.noise[told])) < 0.05

    def test_a_command_that_moves_is_foretold_by_least_squares(self) -> None:
        command = 40.0 * np.sin(0.2 * np.arange(len(self.blocks)))
        torque = command + self.noise
        foretold, _ = foretell(torque, self.blocks)
        told = np.flatnonzero(foretold != torque)
        assert told.size > 0.9 * torque.size
        error = (foretold - command)[told]
        assert error.std() < 1.2
        # neither its own noise nor that of the block before, whose edge it shares
        assert abs(correlation(error, self.noise[told])) < 0.05
        assert abs(correlation(error, self.noise[told - 1])) < 0.05

    def test_runs_too_short_to_tell_from_hold_their_own(self) -> None:
        short = split(np.arange(0, 200, 13), 4, 0.1)
        torque = np.random.default_rng(7).normal(size=len(short))
        np.testing.assert_array_equal(foretell(torque, short)[0], torque)
