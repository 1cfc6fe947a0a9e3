"""A dead band: its width, that of either side, and what the recording's own steps look like."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from incsvr.effects import catalogue
from incsvr.tracing import trace
from incsvr.tracing.run import Array, Run
from tests.incsvr.turning import instants, turning

TIME = instants(400.0)
SMALL = 1.125
"""Moment of inertia of the small vehicle [kg m²]."""
SINE = 60.0 * np.sin(2.0 * np.pi * TIME / 20.0)


@pytest.mark.parametrize("key", ["dead_zone/step", "dead_zone/shifted"])
def test_none_is_looked_for_within_the_steps_of_the_recorded_torque(key: str) -> None:
    """Of commands about zero most that are recorded as one step were less: thrust that is missing, but no dead band."""
    effect, signals = catalogue()[key], turning(0, SINE).signals
    assert min(effect.starts(signals))[0] < 3.0
    coarse = effect.starts(replace(signals, quantum=8.0))
    assert min(coarse)[0] == pytest.approx(12.0)
    assert all(low < high for low, high in (effect.bracket(replace(signals, quantum=8.0), start) for start in coarse))


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
FOUR = np.repeat(np.random.default_rng(6).choice([-1.0, -0.55, 0.55, 1.0], 260), 150)


@pytest.mark.parametrize(("course", "half"), [(STAIRS, 0.3), (FOUR, 1.0)], ids=["stairs", "four levels"])
def test_a_band_is_told_under_a_few_levels(course: Array, half: float) -> None:
    """The levels' distance is none of the torque's resolution: a narrower band is looked for, too. Where every level
    loses the same, a thrust curve and another inertia together pass for it, and each of them alone is told to."""
    found = trace([driven(6.0 * course, half)], inertia=SMALL, torque="commanded")
    assert [effect.effect for effect in found.effects] == ["dead_zone"]
    assert found.effects[0].parameters["half_width_nm"] == pytest.approx(half, abs=0.1)
