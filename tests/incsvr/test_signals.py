"""The synchroniser: right on what is known, deaf to bundling and interleaving, and it never bridges a gap."""

from __future__ import annotations

import json
from math import inf, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.signals import MAX_CHANNELS, SignalSettings, Synchroniser, synchronise
from incsvr.signals.samples import Samples
from incsvr.signals.smoothing import smooth
from incsvr.signals.streams import JUMP_S, MAX_WAITING_VALUES

SETTINGS = SignalSettings(inertia=350.0, sample_period=0.6, smoothing=0.12, lateness=0.2, gap=0.2)
Message = tuple[float, float]
REGULAR: list[Message] = [(0.1 * k, 0.0) for k in range(20)]


def sine(duration: float = 20.0) -> dict[str, tuple[Array, Array]]:
    """A vehicle whose damping is exactly 400 r, its two streams on clocks of their own."""
    pace = 2.0 * np.pi / 15.0
    gyro = np.arange(0.0, duration, 0.02, dtype=np.float64)
    rotor = np.arange(0.007, duration, 0.031, dtype=np.float64)
    torque = 350.0 * 0.2 * pace * np.cos(pace * rotor) + 400.0 * 0.2 * np.sin(pace * rotor)
    return {"yaw_rate": (gyro, 0.2 * np.sin(pace * gyro)), "torque": (rotor, torque)}


def same(one: Samples, other: Samples) -> bool:
    """Equal to the last bit."""
    columns = ((part.time, part.yaw_rate, part.damping, *part.channels.values()) for part in (one, other))
    left, right = ([column.tobytes() for column in part] for part in columns)
    return left == right and list(one.channels) == list(other.channels)


def test_the_damping_of_a_known_vehicle_is_found() -> None:
    samples, rejected = synchronise(SETTINGS, sine())
    assert not rejected
    assert len(samples) == 32
    np.testing.assert_allclose(samples.damping, 400.0 * samples.yaw_rate, atol=0.05)
    np.testing.assert_allclose(np.diff(samples.time), 0.6)


def test_torque_and_acceleration_pass_the_same_filter() -> None:
    """Thrust that rises far faster than the filter must not appear in the damping of a vehicle that has none."""
    time = np.arange(0.0, 12.0, 0.01, dtype=np.float64)
    since = np.clip(time - 6.0, 0.0, 0.1)
    torque = 700.0 * since
    yaw_rate = (350.0 * since**2 + 70.0 * np.maximum(time - 6.1, 0.0)) / 350.0
    settings = SignalSettings(sample_period=0.05, smoothing=0.12, gap=0.2, rate_limit=10.0)
    samples, _ = synchronise(settings, {"yaw_rate": (time, yaw_rate), "torque": (time, torque)})
    assert np.abs(samples.damping).max() < 0.02


def test_jitter_leaves_no_bias() -> None:
    rng = np.random.default_rng(3)
    time = np.sort(rng.uniform(0.0, 60.0, 3000))
    settings = SignalSettings(sample_period=0.5, smoothing=0.3, gap=0.5)
    samples, _ = synchronise(settings, {"yaw_rate": (time, 0.01 * time), "torque": (time, 1.0 + 0.5 * time)})
    np.testing.assert_allclose(samples.yaw_rate, 0.01 * samples.time, atol=1e-12)
    np.testing.assert_allclose(samples.damping, 1.0 + 0.5 * samples.time - 3.5, atol=1e-9)


@st.composite
def streams(draw: st.DrawFn) -> dict[str, list[Message]]:
    """Streams with faults: out of order, twice, late, not numbers, implausible, with gaps and with jumping clocks."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    result: dict[str, list[Message]] = {}
    for name in ("yaw_rate", "torque", "depth"):
        size = draw(st.integers(0, 400))
        time = np.cumsum(rng.exponential(draw(st.sampled_from([0.03, 0.1])), size)) + rng.choice([0.0, 5.0])
        time += np.cumsum(np.where(rng.random(size) < 0.01, rng.choice([0.5, 30.0, 4000.0], size), 0.0))
        time += np.where(rng.random(size) < 0.2, rng.normal(0.0, 0.1, size), 0.0)
        time = np.where(rng.random(size) < 0.03, np.roll(time, 1), time)
        time = np.where(rng.random(size) < 0.01, rng.choice([nan, inf, -1.0, 1e12, 500.0], size), time)
        value = rng.normal(0.0, 0.2, size)
        value = np.where(rng.random(size) < 0.01, rng.choice([nan, -inf, 1e6], size), value)
        result[name] = list(zip(time.tolist(), value.tolist(), strict=True))
    return result


def play(messages: dict[str, list[Message]], rng: np.random.Generator, settings: SignalSettings) -> Samples:
    """Pushes the streams in random bundles and a random order, asks now and then, and is put to disk and back."""
    synchroniser = Synchroniser(settings)
    waiting = {name: list(queue) for name, queue in messages.items()}
    parts = []
    while any(waiting.values()):
        name = str(rng.choice([name for name, queue in waiting.items() if queue]))
        size = int(rng.choice([1, 2, 7, 60, 1000]))
        bundle, waiting[name] = waiting[name][:size], waiting[name][size:]
        if size == 1 and rng.random() < 0.5:
            synchroniser.push_one(name, *bundle[0])
        else:
            synchroniser.push(name, [time for time, _ in bundle], [value for _, value in bundle])
        if rng.random() < 0.5:
            parts.append(synchroniser.ready())
        if rng.random() < 0.1:
            synchroniser = Synchroniser.from_dict(json.loads(json.dumps(synchroniser.to_dict())))
    parts.append(synchroniser.ready())
    return Samples.concatenate(parts)


@given(
    messages=streams(),
    one=st.integers(0, 2**32),
    other=st.integers(0, 2**32),
    period=st.sampled_from([0.05, 0.6, 3.0]),
    gap=st.sampled_from([0.2, None]),
)
def test_bundling_and_interleaving_make_no_difference(
    messages: dict[str, list[Message]], one: int, other: int, period: float, gap: float | None
) -> None:
    settings = SignalSettings(sample_period=period, smoothing=0.12, gap=gap)
    both = {name: messages[name] for name in ("yaw_rate", "torque")}
    assert same(play(both, np.random.default_rng(one), settings), play(both, np.random.default_rng(other), settings))


@pytest.mark.slow
@given(st.lists(st.tuples(st.floats(0.0, 60.0), st.booleans()), max_size=20))
def test_where_both_clocks_begin_anew_what_is_lost_is_the_last_bundle(cuts: list[tuple[float, bool]]) -> None:
    """As long as the streams come together, as they do from a vehicle: within ten seconds."""
    synchroniser, parts, last = Synchroniser(SETTINGS), [], 0.0
    run = sine(30.0)
    for cut, torque_first in sorted([*cuts, *((5.0 * k, False) for k in range(1, 13))]):
        for name in sorted(run, reverse=torque_first):
            time, value = run[name]
            true = np.concatenate((time, time + 30.0))
            part = (true >= last) & (true < cut)
            synchroniser.push(name, np.tile(time, 2)[part], np.tile(value, 2)[part])
            parts.append(synchroniser.ready())
        last = cut
    once, _ = synchronise(SETTINGS, run)
    samples = Samples.concatenate(parts)
    anew = int(np.flatnonzero(np.diff(samples.time) < 0.0)[0]) + 1
    assert anew >= len(once) - 6.0 / SETTINGS.sample_period  # the longest bundle is 5 s
    assert same(samples.take(slice(0, anew)), once.take(slice(0, anew)))
    assert same(samples.take(slice(anew, None)), once)


@given(messages=streams(), one=st.integers(0, 2**32))
def test_channels_never_change_yaw_rate_and_damping(messages: dict[str, list[Message]], one: int) -> None:
    without = play({name: messages[name] for name in ("yaw_rate", "torque")}, np.random.default_rng(one), SETTINGS)
    with_depth = play(messages, np.random.default_rng(one), SETTINGS)
    shared = min(len(without), len(with_depth))  # the last may still wait for the channel
    for part in ("time", "yaw_rate", "damping"):
        assert getattr(without, part)[:shared].tobytes() == getattr(with_depth, part)[:shared].tobytes()


@given(messages=streams())
def test_every_message_is_taken_or_counted(messages: dict[str, list[Message]]) -> None:
    synchroniser = Synchroniser(SETTINGS)
    for name, queue in messages.items():
        synchroniser.push(name, [time for time, _ in queue], [value for _, value in queue])
    taken = sum(reading.held for reading in synchroniser.readings.values())
    assert taken + sum(synchroniser.rejected.values()) == sum(len(queue) for queue in messages.values())


@given(messages=streams())
def test_no_sample_stands_near_a_gap(messages: dict[str, list[Message]]) -> None:
    samples = play({name: messages[name] for name in ("yaw_rate", "torque")}, np.random.default_rng(0), SETTINGS)
    for name in ("yaw_rate", "torque"):
        stamps = np.array([time for time, _ in messages[name]])
        for at in samples.time:
            near = np.sort(stamps[np.abs(stamps - at) <= SETTINGS.reach])
            edges = np.concatenate(([at - SETTINGS.reach], near, [at + SETTINGS.reach]))
            assert np.diff(edges).max() <= SETTINGS.longest_pause + 1e-9


def push_all(messages: list[Message]) -> Synchroniser:
    synchroniser = Synchroniser(SETTINGS)
    for time, value in messages:
        synchroniser.push_one("yaw_rate", time, value)
    return synchroniser


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        ((nan, 0.0), "not_finite"),
        ((2.0, nan), "not_finite"),
        ((2.0, -inf), "not_finite"),
        ((-0.1, 0.0), "negative_time"),
        ((1e12, 0.0), "implausible_time"),
        ((2.0, 14.3), "implausible"),  # 0.25 rad/s in degrees
        (REGULAR[19], "duplicate"),
        ((REGULAR[19][0] + 4e-16, 0.0), "duplicate"),
        ((REGULAR[18][0] - 4e-16, 0.0), "duplicate"),
        (REGULAR[17], "duplicate"),  # of one that still may be corrected
        (REGULAR[16], "late"),
    ],
)
def test_a_refusal_is_counted_by_its_reason(message: Message, reason: str) -> None:
    assert push_all([*REGULAR, message]).rejected == {reason: 1}


@pytest.mark.parametrize("lost", [0.0, 0.05, 0.1])
def test_lost_messages_do_not_lengthen_the_period(lost: float) -> None:
    kept = np.flatnonzero(np.random.default_rng(650_004).random(2000) >= lost)
    time, at = 0.02 * kept.astype(np.float64), np.arange(2.0, 38.0, 0.5, dtype=np.float64)
    found = smooth(time, np.sin(time), at, smoothing=0.2, gap=1.0)
    np.testing.assert_allclose(found.period, 0.02)


def test_a_wrong_second_stamp_is_not_the_first_clock() -> None:
    synchroniser = push_all([(5.0, 0.0), (500.0, 0.0), *((5.1 + 0.1 * k, 0.0) for k in range(20))])
    assert synchroniser.newest("yaw_rate") == pytest.approx(7.0)
    assert synchroniser.rejected == {"clock_jump": 2}
    assert not synchroniser.readings["yaw_rate"].began_anew


def test_a_pause_of_years_costs_nothing() -> None:
    streams = sine()
    joined = {name: (np.concatenate((time, time + 1e9)), np.tile(value, 2)) for name, (time, value) in streams.items()}
    samples, _ = synchronise(SETTINGS, joined)
    assert len(samples) == 66
    assert np.diff(samples.time).max() > 9e8


def test_memory_is_bounded_where_one_stream_is_dead() -> None:
    synchroniser = Synchroniser(SETTINGS)
    time = 0.02 * np.arange(3 * MAX_WAITING_VALUES)
    for start in range(0, time.size, 10_000):
        synchroniser.push("yaw_rate", time[start : start + 10_000], np.zeros(10_000))
        assert len(synchroniser.ready()) == 0
    held = len(synchroniser.to_dict()["streams"]["yaw_rate"]["time"])
    assert held <= MAX_WAITING_VALUES
    assert synchroniser.rejected["overflow"] == time.size - held


def test_channels_stand_with_the_samples() -> None:
    streams = sine(40.0)
    fast = np.arange(0.0, 40.0, 0.05, dtype=np.float64)
    slow = np.arange(0.0, 40.0, 4.0, dtype=np.float64)
    channels = {"depth": (fast, 2.0 + 0.1 * fast), "temperature": (slow, 10.0 + slow)}
    samples, _ = synchronise(SignalSettings(channels=("depth", "temperature")), {**streams, **channels})
    np.testing.assert_allclose(samples.channels["depth"], 2.0 + 0.1 * samples.time, atol=1e-9)
    np.testing.assert_array_equal(samples.channels["temperature"], 10.0 + samples.time // 4.0 * 4.0)


def test_a_dead_channel_delays_but_does_not_stop() -> None:
    streams = sine(40.0)
    samples, _ = synchronise(SignalSettings(channels=("depth",)), streams)
    assert np.isnan(samples.channels["depth"]).all()
    assert 40.0 - JUMP_S - 2.0 < samples.time[-1] < 40.0 - JUMP_S


def test_there_is_an_end_to_channels() -> None:
    synchroniser = Synchroniser(SETTINGS)
    for k in range(MAX_CHANNELS + 3):
        synchroniser.push_one(f"channel_{k}", 0.0, 1.0)
    assert synchroniser.rejected == {"too_many_channels": 3}


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"inertia": 0.0}, "inertia is 0.0"),
        ({"sample_period": nan}, "sample_period is nan"),
        ({"lateness": -1.0}, "lateness is -1.0"),
        ({"smoothing": 0.05, "gap": 0.2}, "raise the smoothing or lower the gap"),
        ({"smoothing": 3.0, "gap": 5.0}, "recordings that are apart"),
    ],
)
def test_impossible_settings_are_refused(wrong: dict[str, float], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        SignalSettings(**wrong)  # type: ignore[arg-type]
