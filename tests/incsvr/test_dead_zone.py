"""A dead band: its width, and what the noise of a measured torque looks like beside it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from incsvr.numerics import Array
from incsvr.tracing import trace
from incsvr.tracing.run import Run

SMALL = 1.125
"""Moment of inertia of the small vehicle [kg m²]."""


def driven(asked: Array, half: float) -> Run:
    """A small vehicle in moving water whose thrusters lose `half` of every command [N m], told every 0.05 s."""
    random, step = np.random.default_rng(5), 0.01
    water = 0.15 * np.repeat(random.normal(size=asked.size // 5), 5)
    thrust = (np.sign(asked) * np.maximum(np.abs(asked) - half, 0.0) + water).tolist()
    rate = [0.0]
    for push in thrust[:-1]:
        rate.append(rate[-1] + step / SMALL * (push - 0.8 * rate[-1] - 1.6 * rate[-1] * abs(rate[-1])))
    time = step * np.arange(asked.size, dtype=np.float64)[::5]
    seen = np.array(rate)[::5] + 2e-3 * random.normal(size=time.size)
    return Run("levels", time, seen, asked[::5], {})


STAIRS = np.tile(np.repeat([0.25, 0.0, -0.25, 0.5, 0.0, -0.5, 1.0, 0.0, -1.0, 0.75, 0.1, -0.75, -0.1], 300), 10)


@pytest.mark.slow
def test_a_band_is_told_under_a_few_levels() -> None:
    found = trace([driven(6.0 * STAIRS, 0.3)], inertia=SMALL, torque="commanded")
    assert [effect.effect for effect in found.effects] == ["dead_zone"]
    assert found.effects[0].parameters["half_width_nm"] == pytest.approx(0.3, abs=0.1)


@pytest.mark.slow
def test_what_silences_the_noise_of_a_measured_torque_is_no_dead_band() -> None:
    run = driven(6.0 * STAIRS, 0.0)
    noisy = replace(run, torque=run.torque + np.random.default_rng(7).normal(0.0, 0.2, run.time.size))
    found = trace([noisy], inertia=SMALL)
    assert "dead_zone" not in [effect.effect for effect in found.effects]
