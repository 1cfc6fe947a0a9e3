"""A wave against the motion that the command makes: what repeats with the command is no wave."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from incsvr.effects import Signals, Term, catalogue
from incsvr.numerics import Array


@pytest.fixture(scope="module")
def signals() -> Signals:
    """Two runs on a fine grid of 0.1 s, in which nothing moves."""
    n = 3000
    time, none = np.asarray(0.1 * np.arange(n), dtype=np.float64), np.zeros(n)
    start = np.array([0, n // 2, n])
    return Signals(0.1, start, time, none, none, residual=none, scale=6.0, block=0.8, origin=(0.0, 300.0))


@pytest.mark.parametrize("harmonic", [1, 2, 3, 5, 7])
@pytest.mark.parametrize("square", [False, True])
def test_a_wave_at_a_harmonic_of_the_command_is_refused(harmonic: int, square: bool, signals: Signals) -> None:
    """What is left of the wrong shape of any effect of the motion repeats with the command; a wave does not."""
    seen = replace(signals, torque=of_one_period(signals, square))
    assert "harmonic" in wave(24.0 / harmonic, seen)


@pytest.mark.parametrize("ratio", [0.6, 1.4, 1.5, 2.5, 3.4, 6.5])
@pytest.mark.parametrize("square", [False, True])
def test_a_wave_between_the_harmonics_is_not(ratio: float, square: bool, signals: Signals) -> None:
    seen = replace(signals, torque=of_one_period(signals, square))
    assert wave(24.0 / ratio, seen) == ""


def test_a_wave_on_a_line_of_a_command_of_many_is_refused_unless_it_is_the_larger(signals: Signals) -> None:
    lines = [60.0 / k for k in (2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0)]
    torque = np.sum([20.0 * np.sin(2 * np.pi * signals.time / line + line) for line in lines], axis=0)
    seen = replace(signals, torque=torque)
    assert "line" in wave(60.0 / 13.0, seen)
    assert wave(60.0 / 15.0, seen) == ""
    assert wave(60.0 / 13.0, seen, size=15.0) == ""


def test_a_wave_on_a_line_of_a_sweep_that_is_driven_again_and_again_is_one_if_it_comes_alone() -> None:
    """What is left of the vehicle's own motion is left at the lines beside it, too."""
    time, none = np.asarray(0.1 * np.arange(12000), dtype=np.float64), np.zeros(12000)
    torque = 60.0 * np.sin(2 * np.pi * np.cumsum(0.1 * (0.25 + 0.2 * (time % 60.0) / 60.0)))
    start = np.array([0, time.size])
    seen = Signals(0.1, start, time, none, torque, residual=none, scale=6.0, block=0.8, origin=(0.0, 1200.0))
    assert wave(60.0 / 21.0, seen) == ""
    assert "line" in wave(60.0 / 21.0, replace(seen, residual=0.4 * np.gradient(torque, 0.1)))


def test_a_wave_at_a_high_harmonic_of_a_line_among_others_is_one_if_it_comes_alone(signals: Signals) -> None:
    lines = [60.0 / k for k in (2.0, 3.3, 4.7)]
    torque = np.sum([30.0 * np.sin(2 * np.pi * signals.time / line + line) for line in lines], axis=0)
    seen = replace(signals, torque=torque, residual=np.zeros(len(signals)))
    assert wave(30.0 / 5.0, seen) == ""
    assert "harmonic" in wave(30.0 / 3.0, seen)
    bent = replace(seen, residual=2.0 * np.sin(2 * np.pi * signals.time / 30.0 * 7.0))
    assert "harmonic" in wave(30.0 / 5.0, bent)


def of_one_period(signals: Signals, square: bool) -> Array:
    sine = np.sin(2 * np.pi * signals.time / 24.0)
    return 60.0 * np.sign(sine) if square else 60.0 * sine


def wave(period: float, signals: Signals, size: float = 4.0) -> str:
    return catalogue()["wave"].implausible(Term("wave", "", (size, 0.0), (period,)), signals)
