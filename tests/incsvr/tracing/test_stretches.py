"""Long recordings are cut to stretches that are spread evenly, each with the torque that acts at its beginning."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.model.series import duration, values
from incsvr.numerics import Array
from incsvr.tracing.recordings import Recordings
from incsvr.tracing.stretches import bounded


def recordings(seconds: float) -> Recordings:
    """A yaw rate of 50 Hz that wanders within seconds, under a torque of 10 Hz."""
    time: Array = np.asarray(np.arange(0.0, seconds, 0.02))
    knots = np.random.default_rng(1).normal(size=int(seconds / 4) + 1)
    yaw: Array = np.asarray(np.interp(time, np.arange(0.0, seconds + 4.0, 4.0), knots))
    torque: Array = np.asarray(np.arange(0.0, seconds, 0.1))
    run = {"yaw_rate": (time, yaw), "torque": (torque, np.sin(torque)), "time": (time, time)}
    return Recordings("yaw_rate", (run,), 0.0, True, ("time",))


def test_a_short_recording_stays_as_it_is() -> None:
    given = recordings(400.0)
    assert bounded(given) == (given, 1.0)


def test_of_an_hour_stretches_remain() -> None:
    found, share = bounded(recordings(3600.0))
    assert values(found.streams, "yaw_rate").size == pytest.approx(24_000, rel=0.02)
    assert share == pytest.approx(24.0 / 180.0, rel=0.02)
    assert duration(found.streams, "yaw_rate") == pytest.approx(480.0, rel=0.02)
    begins = [run["yaw_rate"][0][0] for run in found.streams]
    assert len(begins) > 10
    assert np.allclose(np.diff(begins), np.diff(begins)[0], atol=0.1)
    for run in found.streams:
        assert run["torque"][0][0] <= run["yaw_rate"][0][0] + 0.02
