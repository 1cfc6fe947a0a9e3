"""Clocks that jump, begin anew, wrap, disagree or tick slowly: what is learned after, and what never is."""

from __future__ import annotations

import json
from collections.abc import Callable

import numpy as np
import pytest

from incsvr.numerics import Array
from incsvr.signals import SignalSettings, Synchroniser
from incsvr.signals.samples import Samples
from incsvr.signals.streams import CONFIRMING_STAMPS

SETTINGS = SignalSettings()
RATE, TORQUE = "yaw_rate", "torque"
Clock = Callable[[Array], Array]


def right(t: Array) -> Array:
    return t


class Vehicle:
    """A vehicle whose damping is exactly 400 r. Its streams arrive second by second, stamped by clocks of their own."""

    def __init__(self, settings: SignalSettings = SETTINGS, gyro: float = 0.05, rotor: float = 0.05) -> None:
        self.synchroniser = Synchroniser(settings)
        self._periods = {RATE: gyro, TORQUE: rotor}
        self._time = 0.0

    def drive(self, seconds: float, rate: Clock = right, torque: Clock = right, jitter: float = 0.0) -> Samples:
        """The samples of the next seconds [s], whose stamps the clocks make of the true time."""
        parts, rng, end = [], np.random.default_rng(7), self._time + seconds
        while self._time < end:
            for name, clock in ((RATE, rate), (TORQUE, torque)):
                period = self._periods[name]
                t = np.arange(np.ceil(self._time / period - 1e-9), np.ceil((self._time + 1.0) / period - 1e-9)) * period
                t = t + rng.uniform(-jitter, jitter, t.size) * period
                self.synchroniser.push(name, clock(t), self._values(name, t))
                parts.append(self.synchroniser.ready())
            self._time += 1.0
        return Samples.concatenate(parts)

    def restart(self) -> None:
        """The learner is ended and begins again with what it saved."""
        self.synchroniser = Synchroniser.from_dict(json.loads(json.dumps(self.synchroniser.to_dict())))

    @staticmethod
    def _values(name: str, t: Array) -> Array:
        pace = 2.0 * np.pi / 60.0
        if name == RATE:
            return np.asarray(0.2 * np.sin(pace * t))
        return np.asarray(350.0 * 0.2 * pace * np.cos(pace * t) + 400.0 * 0.2 * np.sin(pace * t))


def assert_right(samples: Samples, seconds: float) -> None:
    """Nearly all samples of these seconds [s] are there, and none pairs values of different times."""
    assert len(samples) >= 0.85 * (seconds / SETTINGS.sample_period) - 3
    np.testing.assert_allclose(samples.damping, 400.0 * samples.yaw_rate, atol=0.6)


WRONG_STAMPS = {
    "one": [1e9],
    "twice the same": [1e9, 1e9],
    "two that are near": [1e9, 1e9 + 0.05],
    "the same for ever": [1e9] * 500,
    "many that follow one another": (1e9 + 0.05 * np.arange(3 * CONFIRMING_STAMPS)).tolist(),
    "many in the past": (50.0 + 0.05 * np.arange(3 * CONFIRMING_STAMPS)).tolist(),
    "here and there": [1e9, 5e8, 2e9, 7.0, 1e9, 40.0],
}


@pytest.mark.parametrize("stamps", WRONG_STAMPS.values(), ids=WRONG_STAMPS.keys())
@pytest.mark.parametrize("streams", [(RATE,), (TORQUE,), (RATE, TORQUE)], ids="+".join)
@pytest.mark.parametrize("restarts", [False, True])
def test_wrong_stamps_deafen_no_stream(stamps: list[float], streams: tuple[str, ...], restarts: bool) -> None:
    vehicle = Vehicle()
    assert_right(vehicle.drive(90.0), 90.0)
    for name in streams:
        vehicle.synchroniser.push(name, stamps, np.zeros(len(stamps)))
        vehicle.synchroniser.ready()
    if restarts:
        vehicle.restart()
    assert_right(vehicle.drive(30.0), 30.0)
    told = sum(vehicle.synchroniser.rejected.values())
    assert restarts or told > 0


def test_a_sensor_that_begins_at_zero_is_not_paired_with_the_past_of_the_other() -> None:
    vehicle = Vehicle()
    vehicle.drive(100.0)
    alone = vehicle.drive(300.0, rate=lambda t: t - 100.0)
    assert len(alone) <= 2  # of the last second before
    np.testing.assert_allclose(alone.damping, 400.0 * alone.yaw_rate, atol=0.6)
    reading = vehicle.synchroniser.readings[RATE]
    assert reading.began_anew
    assert reading.newest == pytest.approx(299.95)
    assert reading.held == pytest.approx(300 / 0.05, abs=100)


@pytest.mark.parametrize("cure", ["the other begins anew as well", "its clock is put right"])
@pytest.mark.parametrize("restarts", [False, True])
def test_once_the_clocks_agree_again_it_goes_on(cure: str, restarts: bool) -> None:
    vehicle = Vehicle()
    vehicle.drive(100.0)
    vehicle.drive(30.0, rate=lambda t: t - 100.0)
    if restarts:
        vehicle.restart()
    if cure == "its clock is put right":
        assert_right(vehicle.drive(60.0), 60.0)
    else:
        both = vehicle.drive(60.0, rate=lambda t: t - 130.0, torque=lambda t: t - 130.0)
        assert_right(both, 60.0)
        assert both.time[-1] < 60.0
        assert vehicle.synchroniser.clock_restarts == 1


@pytest.mark.parametrize("wrap", [2**32 / 1e6, 2**32 / 1e3])
def test_a_counter_that_wraps_starts_over(wrap: float) -> None:
    begin = wrap - 100.0
    vehicle = Vehicle()
    samples = vehicle.drive(200.0, rate=lambda t: (t + begin) % wrap, torque=lambda t: (t + begin) % wrap)
    assert_right(samples, 200.0)
    assert vehicle.synchroniser.clock_restarts == 1
    assert vehicle.synchroniser.rejected["clock_restarted"] == 1


@pytest.mark.parametrize(("period", "jitter"), [(0.25, 0.0), (0.25, 0.2), (0.2, 0.0), (0.2, 0.3)])
@pytest.mark.parametrize("slow", ["gyro", "rotor"])
def test_the_filter_follows_a_slow_stream(period: float, jitter: float, slow: str) -> None:
    vehicle = Vehicle(**{slow: period})  # type: ignore[arg-type]
    assert_right(vehicle.drive(120.0, jitter=jitter), 120.0)
    assert vehicle.synchroniser.smoothing > SETTINGS.smoothing


def test_a_stream_that_becomes_slow_is_followed_and_back() -> None:
    quick, slow = Vehicle(), Vehicle(rotor=0.25)
    slow._time = 60.0
    slow.synchroniser = quick.synchroniser
    assert_right(quick.drive(60.0), 60.0)
    assert_right(slow.drive(60.0), 60.0)
    quick._time = 120.0
    assert_right(quick.drive(60.0), 60.0)
    assert quick.synchroniser.smoothing == SETTINGS.smoothing


def test_a_channel_that_came_once_delays_no_sample_for_ever() -> None:
    vehicle = Vehicle()
    vehicle.drive(20.0)
    vehicle.synchroniser.push("depth", [18.0, 18.5, 19.0], [1.0, 1.0, 1.0])
    assert len(vehicle.drive(5.0)) == 0  # it may still come
    samples = vehicle.drive(20.0)
    assert samples.time[-1] > 43.0
    assert np.isnan(samples.channels["depth"][samples.time > 30.0]).all()
