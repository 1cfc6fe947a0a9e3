"""The recent raw data: bounded, as the synchroniser takes them, and enough to make the samples again."""

from __future__ import annotations

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.signals import SignalSettings, synchronise
from incsvr.signals.streams import BELIEVED_STAMPS, MAX_WAITING_VALUES
from service.learner.batches import Batches
from service.learner.window import Window
from simulator import leng

SETTINGS = SignalSettings(channels=("depth",))


def turning(last: float, step: float = 0.02) -> tuple[Array, Array]:
    time = np.arange(0.0, last, step, dtype=np.float64)
    return time, 0.2 * np.sin(time)


def test_it_holds_its_length_and_no_more_whatever_comes() -> None:
    window = Window(SETTINGS, 60.0)
    time, value = turning(600.0)
    empty = Window(SETTINGS, 60.0)
    assert empty.is_full(empty.newest) is False
    for start in range(0, time.size, 250):
        part = slice(start, start + 250)
        for name in ("yaw_rate", "torque", "depth", "nobody configured it"):
            window.push(name, time[part], value[part])
        assert all(t.size <= 3001 for t, _ in window.streams().values())
    assert set(window.streams()) == {"yaw_rate", "torque", "depth"}
    assert window.is_full(window.newest)
    assert window.newest == time[-1]


@pytest.mark.parametrize("until", [60.0, 99.0])
def test_batches_begun_anew_are_those_of_the_whole_streams(until: float) -> None:
    streams = leng.recording("T1", seed=2).streams()
    whole, _ = synchronise(SignalSettings(), {n: (t[t < 100.0], v[t < 100.0]) for n, (t, v) in streams.items()})
    batches = Batches(SignalSettings(), 50, window=Window(SignalSettings(), 200.0))
    for name, (t, value) in streams.items():
        batches.push(name, t[t < 100.0], value[t < 100.0])
    seen = batches.samples_seen
    samples = batches.samples_under(None, until)
    known = whole.time <= until
    np.testing.assert_array_equal(samples.damping, whole.damping[known])
    batches.restart(None, until, 0)
    assert batches.samples_seen == seen == len(whole)
    np.testing.assert_array_equal(batches.to_dict()["waiting"]["damping"], whole.damping[~known])
    for name, (t, value) in streams.items():
        late = (t >= 100.0) & (t < 150.0)
        batches.push(name, t[late], value[late])
    after, _ = synchronise(SignalSettings(), {n: (t[t < 150.0], v[t < 150.0]) for n, (t, v) in streams.items()})
    np.testing.assert_array_equal(batches.to_dict()["waiting"]["damping"], after.damping[after.time > until])


def test_a_clock_that_begins_anew_empties_it() -> None:
    batches = Batches(SignalSettings(), 50, window=Window(SignalSettings(), 100.0))
    time, value = turning(120.0)
    for name in ("yaw_rate", "torque"):
        batches.push(name, time + 1000.0, value)
    assert batches.window_end() == 1000.0 + time[-1]
    for name in ("yaw_rate", "torque"):
        batches.push(name, time[: 2 * BELIEVED_STAMPS], value[: 2 * BELIEVED_STAMPS])
    assert batches.clock_restarts == 1
    assert batches.window_end() is None
    with pytest.raises(BadInput, match="clock restarted"):
        batches.restart(None, 1000.0, 0)
    assert max(t[-1] for t, _ in batches.recent().values()) < 1.0


def test_streams_that_are_too_quick_for_its_length_are_bounded_in_number() -> None:
    window = Window(SETTINGS, 900.0)
    for name in ("yaw_rate", "torque"):
        window.push(name, *turning(300.0, 0.001))
    assert window.is_full(window.newest)
    assert all(t.size <= MAX_WAITING_VALUES for t, _ in window.streams().values())
