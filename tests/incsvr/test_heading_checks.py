"""A measured heading beside the gyro: the check names a gyro's zero, not a compass of another sign or unit."""

from __future__ import annotations

import numpy as np

from incsvr.checks import Decision
from incsvr.numerics import Array
from simulator import leng
from tests.incsvr.test_checks import guided


def heading(sign: float, bias: float, unit: float = 1.0) -> dict[str, tuple[Array, Array]]:
    """Leng's streams with a heading at 2 Hz that is wrapped, and a gyro whose zero is off from the beginning."""
    found = leng.recording("T1", 5).streams()
    t, rate = found["yaw_rate"]
    turned = np.concatenate(([0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(t))))
    at = np.arange(0.1, t[-1], 0.5)
    angle = sign * np.interp(at, t, turned) + np.random.default_rng(5).normal(0.0, 0.01, at.size)
    wrapped = ((angle + np.pi) % (2.0 * np.pi) - np.pi) * unit
    return found | {"yaw_rate": (t, rate + bias), "heading": (at, wrapped)}


def test_a_measured_heading_tells_a_gyros_zero_from_the_first_batch_on() -> None:
    _, verdicts = guided(heading(1.0, 0.02))
    assert verdicts[0].decision is Decision.PAUSE
    assert "heading turns" in verdicts[0].findings[0].sentence
    assert not any(verdict.learn for verdict in verdicts)
    _, sound = guided(heading(1.0, 0.0))
    assert all(verdict.learn and not verdict.findings for verdict in sound)


def test_a_compass_that_counts_clockwise_is_said_and_learning_goes_on() -> None:
    _, verdicts = guided(heading(-1.0, 0.0))
    assert "opposite directions" in verdicts[0].findings[0].sentence
    assert all(verdict.learn for verdict in verdicts)


def test_a_vehicle_that_rolls_turns_its_heading_otherwise_than_the_gyro_says() -> None:
    """ψ̇ = q sin φ + r cos φ: a pitch rate at an angle of roll is no gyro's zero."""
    found = heading(1.0, 0.02)
    t, _ = found["yaw_rate"]
    level = {name: (t, 0.01 * np.sin(t)) for name in ("roll_rate", "pitch_rate")}
    rolling = {**level, "roll_rate": (t, 0.3 * np.sin(t))}
    assert guided(found | level)[1][0].findings[0].sentence == guided(found)[1][0].findings[0].sentence
    assert not [each for each in guided(found | rolling)[1][0].findings if "heading" in each.sentence]


def test_a_heading_in_degrees_is_said() -> None:
    _, verdicts = guided(heading(1.0, 0.0, unit=180.0 / np.pi))
    assert any("give it in rad" in finding.sentence for verdict in verdicts for finding in verdict.findings)
