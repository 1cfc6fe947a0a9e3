"""What the tracer knows of the noise: where it sits."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.tracing.run import Array
from incsvr.tracing.weak.noise import noise_fraction
from incsvr.tracing.weak.weak_form import Blocks, split


def lively(draw: np.random.Generator, n: int) -> tuple[Blocks, Array]:
    """n blocks of 0.1 s in each of which the torque is another, and that torque."""
    fine = np.repeat(draw.normal(size=n), 4)
    return split(np.array([0, 4 * n + 1]), 4, 0.1), np.concatenate([fine, fine[-1:]])


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_the_share_of_the_torque_is_read_beside_the_gyros_noise(share: float) -> None:
    """The gyro's noise is in neither the torque nor the water; unknown, it would pass for water."""
    draw = np.random.default_rng(4)
    blocks, fine = lively(draw, n := 20_000)
    torque = blocks.mean(fine)
    fastest = float(np.std(np.diff(torque, 3)) / np.sqrt(20.0))
    water = fastest * np.sqrt((1.0 - share) / share) * draw.normal(size=n)
    gyro, again = (0.3 * fastest * np.diff(draw.normal(size=n + 1)) for _ in range(2))
    residual = torque - water + gyro
    found, blind = noise_fraction(blocks, fine, residual, again), noise_fraction(blocks, fine, residual)
    assert found is not None
    assert blind is not None
    assert found == pytest.approx(share, abs=0.05)
    assert blind < found - 0.2 * share**2


@pytest.mark.parametrize(("answered", "told"), [(1.0, True), (0.3, False)])
def test_a_share_is_told_where_what_moves_in_the_torque_is_noise_alone(answered: float, told: bool) -> None:
    """Of a command that an effect takes a part of, that part is in the residual, too, and would pass for noise."""
    draw = np.random.default_rng(5)
    blocks, fine = lively(draw, n := 20_000)
    torque = blocks.mean(fine)
    residual = answered * torque + 0.2 * draw.normal(size=n) * float(np.std(torque))
    assert noise_fraction(blocks, fine, residual, orders=(3,)) is not None
    assert (noise_fraction(blocks, fine, residual, orders=(3,), least_part=0.7) is not None) is told
