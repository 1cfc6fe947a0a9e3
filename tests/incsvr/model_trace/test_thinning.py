"""Long recordings are thinned to bounded samples, and keep what a trace needs."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.model.series import duration, values
from incsvr.model_trace.recordings import Recordings
from incsvr.model_trace.thinning import thinned
from incsvr.numerics import Array


def recordings(seconds: float, rate: float) -> Recordings:
    """A yaw rate that wanders within seconds, under a torque of 10 Hz."""
    time: Array = np.asarray(np.arange(0.0, seconds, 1.0 / rate))
    knots = np.random.default_rng(1).normal(size=int(seconds / 4) + 1)
    yaw: Array = np.asarray(np.interp(time, np.arange(0.0, seconds + 4.0, 4.0), knots))
    torque: Array = np.asarray(np.arange(0.0, seconds, 0.1))
    run = {"yaw_rate": (time, yaw), "torque": (torque, np.sin(torque)), "time": (time, time)}
    return Recordings("yaw_rate", (run,), 0.0, True, ("time",))


def test_a_short_recording_stays_as_it_is() -> None:
    given = recordings(600.0, 10.0)
    assert thinned(given, standing=5.0) == (given, 1.0)


def test_samples_between_commands_that_stay_are_merged() -> None:
    given = recordings(600.0, 50.0)
    found, share = thinned(given, standing=5.0)
    (run,), (whole,) = found.streams, given.streams
    assert share == 1.0
    assert run["torque"] is whole["torque"]
    assert values(found.streams, "yaw_rate").size == 7_500
    assert np.allclose(run["yaw_rate"][1][:2], whole["yaw_rate"][1][:8].reshape(2, 4).mean(axis=1))
    assert run["yaw_rate"][0][0] == pytest.approx(0.03)


def test_of_an_hour_under_a_controller_stretches_remain() -> None:
    """Nothing is merged that a command between two samples answers."""
    given = recordings(3600.0, 50.0)
    found, share = thinned(given, standing=0.02)
    assert values(found.streams, "yaw_rate").size == pytest.approx(8_000, rel=0.02)
    assert share == pytest.approx(8.0 / 180.0, rel=0.02)
    assert duration(found.streams, "yaw_rate") == pytest.approx(160.0, rel=0.02)
    begins = [run["yaw_rate"][0][0] for run in found.streams]
    assert len(begins) > 2
    assert np.allclose(np.diff(begins), np.diff(begins)[0], atol=0.1)
    for run in found.streams:
        assert run["torque"][0][0] <= run["yaw_rate"][0][0] + 0.02
