"""What sits in thrust, gyro and dry friction: found where it is plain, told from its neighbours, absent else."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from incsvr.numerics import Array
from incsvr.tracing.result import trace
from incsvr.tracing.run import Run
from tests.incsvr.test_coriolis import STEP, wandering

INERTIA, TOP = 24.0, 18.0


@dataclass(frozen=True)
class Hidden:
    """What the vehicle of these tests has beside I ṙ + 9 r + 26 r|r| = τ."""

    exponent: float = 1.0
    step: float = 0.0
    drift: float = 0.0
    square: float = 0.0
    gyro: float = 0.0
    forward: float = 0.0
    backward: float = 0.0


def vehicle(hidden: Hidden, seed: int = 1, count: int = 2400) -> Run:
    random = np.random.default_rng(seed)
    command = np.repeat(random.uniform(-TOP, TOP, count // 25), 25)
    water, surge = wandering(random, count, 0.5, 0.3), 1.0 + wandering(random, count, 4.0, 0.25)
    time: Array = STEP * np.arange(count, dtype=np.float64)
    late = time > 0.5 * time[-1]
    thrust = TOP * np.sign(command) * np.abs(command / TOP) ** hidden.exponent
    thrust *= (1.0 + hidden.step * late) * (1.0 + hidden.drift * time / time[-1])
    thrust *= 1.0 + hidden.square * (surge**2 - 1.0)
    rate = np.zeros(count)
    for k in range(count - 1):
        r = rate[k]
        for _ in range(8):
            moment = thrust[k] + water[k] - 9.0 * r - 26.0 * r * abs(r)
            friction = hidden.forward * max(np.tanh(r / 0.002), 0.0) + hidden.backward * min(np.tanh(r / 0.002), 0.0)
            r += STEP / 8.0 / INERTIA * (moment - friction)
        rate[k + 1] = r
    measured = rate + hidden.gyro + random.normal(0.0, 0.002, count)
    return Run("vehicle", time, measured, command, {"surge": surge})


PLAIN = [
    ("thrust_curve", Hidden(exponent=1.8), "exponent", 1.8),
    ("thrust_step", Hidden(step=-0.4), "fraction", -0.4),
    ("thrust_drift", Hidden(drift=-0.35), "fraction", -0.35),
    ("thrust_speed", Hidden(square=0.6), "coefficient", 1.2),
    ("gyro_bias", Hidden(gyro=0.06), "rate_rad_s", 0.06),
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "hidden", "parameter", "value"), PLAIN)
def test_it_is_named_where_it_is_plain(name: str, hidden: Hidden, parameter: str, value: float) -> None:
    found = trace([vehicle(hidden)], inertia=INERTIA, torque="commanded")
    effect = max(found.effects, key=lambda each: each.share)
    assert name in (effect.effect, *effect.cannot_tell_from)
    if effect.effect == name:
        assert effect.parameters[parameter] == pytest.approx(value, rel=0.3)


@pytest.mark.slow
def test_friction_that_differs_with_the_direction_is_friction_and_a_constant_moment() -> None:
    """While the vehicle turns both are the same: 3 N m forward and 1 backward are 2 N m of friction and 1 against."""
    found = trace([vehicle(Hidden(forward=3.0, backward=1.0))], inertia=INERTIA, torque="commanded")
    moments = {effect.effect: effect.parameters["moment_nm"] for effect in found.effects}
    assert moments == pytest.approx({"coulomb": 2.0, "bias_torque": -1.0}, rel=0.15)


def test_nothing_is_named_where_nothing_is_hidden() -> None:
    assert trace([vehicle(Hidden())], inertia=INERTIA, torque="commanded").effects == ()


@pytest.mark.slow
def test_what_changes_in_time_is_sought_on_one_clock_alone() -> None:
    """Two logs that both begin at zero: half a minute in the one is not half a minute in the other."""
    first, second = (vehicle(Hidden(step=-0.4), seed) for seed in (1, 2))
    found = trace([first, second], inertia=INERTIA)
    assert not any("time" in effect.signals for effect in found.model.effects)
    assert any("stamps of the recordings overlap" in note for note in found.notes)
