"""A command holds until the next one: samples of it are right however slowly it comes, and deaf to bundling."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from incsvr.checks.resolution import resolution_fault
from incsvr.model.inertia import estimate_inertia
from incsvr.numerics import Array
from incsvr.signals import SignalSettings, Synchroniser, synchronise
from incsvr.signals.message_rates import slow_torque
from incsvr.signals.samples import Samples
from tests.worlds import ROV, slow

SETTINGS = SignalSettings(inertia=ROV.inertia, sample_period=0.1, smoothing=0.15, lateness=0.0, rate_limit=6.0)
STEP = 0.005
Streams = dict[str, tuple[Array, Array]]


def error(samples: Samples) -> float:
    """The median error of the samples between 0.4 and 0.6 rad/s, as a part of the damping there."""
    near = np.abs(np.abs(samples.yaw_rate) - 0.5) < 0.1
    true = ROV.damping(samples.yaw_rate[near])
    return float(np.median(samples.damping[near] / true)) - 1.0


@pytest.mark.parametrize("every", [0.5, 0.2])
@pytest.mark.parametrize("torque", [None, "commanded"])
def test_a_slow_command_that_holds_gives_samples_that_are_right(every: float, torque: str | None) -> None:
    streams = slow(4, every, duration=160.0).streams()
    samples, _ = synchronise(replace(SETTINGS, torque=torque), streams)  # type: ignore[arg-type]
    assert len(samples) > 200
    assert abs(error(samples)) < 0.03
    assert np.max(np.abs(samples.damping - ROV.damping(samples.yaw_rate))) < 0.5
    assert resolution_fault(samples, SETTINGS.smoothing) is None


def test_on_a_line_between_its_messages_it_is_wrong_and_that_is_said() -> None:
    streams = slow(4, 0.5, duration=300.0).streams()
    settings = replace(SETTINGS, torque="measured", smoothing=0.45)
    samples, _ = synchronise(settings, streams)
    assert error(samples) > 0.2
    told = resolution_fault(samples, settings.smoothing)
    assert told is not None
    assert told.share > 0.15
    assert "the damping curve may be" in told.sentence
    assert "set signals.torque to commanded" in told.cure(settings)


def test_a_command_that_is_logged_when_it_is_given_holds_to_the_stamp_of_the_next() -> None:
    """A controller's at 4 Hz: none repeats itself."""
    random = np.random.default_rng(5)
    given = 0.25 * np.arange(1600, dtype=np.float64)
    command = 3.0 * np.sin(0.7 * given) + random.normal(0.0, 1.0, given.size)
    time: Array = STEP * np.arange(given.size * 50, dtype=np.float64)
    rate, rates = 0.0, np.empty(time.size)
    for k, torque in enumerate(np.repeat(command, 50).tolist()):
        rates[k] = rate
        rate += STEP / ROV.inertia * (torque - 0.6 * rate - 1.6 * rate * abs(rate))
    streams: Streams = {"yaw_rate": (time[::10], rates[::10]), "torque": (given, command)}
    off = {}
    for kind in ("commanded", "measured"):
        samples, _ = synchronise(replace(SETTINGS, torque=kind), streams)
        off[kind] = float(np.std(samples.damping - ROV.damping(samples.yaw_rate)))
    assert off["commanded"] < 0.15
    assert off["measured"] > 3.0 * off["commanded"]


@pytest.mark.parametrize("torque", [None, "commanded"])
@pytest.mark.parametrize(("lateness", "every"), [(0.0, 0.5), (0.7, 0.5), (0.2, 2.5)])
def test_bundling_makes_no_difference(torque: str | None, lateness: float, every: float) -> None:
    streams = slow(6, every, changes=(1.6 * every, 4.8 * every), duration=60.0).streams()
    settings = replace(SETTINGS, torque=torque, lateness=lateness)  # type: ignore[arg-type]
    whole, _ = synchronise(settings, streams)
    random, one = np.random.default_rng(7), Synchroniser(settings)
    waiting = {name: list(zip(t.tolist(), v.tolist(), strict=True)) for name, (t, v) in streams.items()}
    parts = []
    while any(waiting.values()):
        name = str(random.choice([each for each, queue in waiting.items() if queue]))
        for stamp, value in waiting[name][: (size := int(random.choice([1, 3, 40])))]:
            one.push_one(name, stamp, value)
        del waiting[name][:size]
        parts.append(one.ready())
        if random.random() < 0.1:
            one = Synchroniser.from_dict(json.loads(json.dumps(one.to_dict())))
    played = Samples.concatenate([*parts, one.ready()])
    assert len(whole) > 20
    for column in ("time", "yaw_rate", "damping"):
        assert getattr(whole, column).tobytes() == getattr(played, column).tobytes()


def test_a_torque_that_never_repeats_is_no_command_that_was_seen_to_hold() -> None:
    streams = slow(8, 0.2, duration=60.0).streams()
    stamps, values = streams["torque"]
    noisy = {**streams, "torque": (stamps, values + np.random.default_rng(9).normal(0.0, 1e-6, values.size))}
    followed, _ = synchronise(SETTINGS, noisy)
    measured, _ = synchronise(replace(SETTINGS, torque="measured"), noisy)
    assert followed.damping.tobytes() == measured.damping.tobytes()


def test_where_the_command_held_the_inertia_is_told_however_slowly_it_comes() -> None:
    estimate = estimate_inertia([slow(10, 0.5, duration=200.0).streams()])
    assert abs(estimate.inertia - ROV.inertia) < 0.02


TIME = np.arange(0.0, 200.0, 0.05, dtype=np.float64)


def commanded(seed: int, longest: float = 2.0) -> tuple[Array, Array]:
    """Instants and levels of a command."""
    random = np.random.default_rng(seed)
    at = np.cumsum(random.uniform(0.3, longest, 400))
    return at[at < TIME[-1]], random.uniform(-1.0, 1.0, 400)[: np.count_nonzero(at < TIME[-1])]


def turning(at: Array, levels: Array) -> Array:
    """A yaw rate that follows the levels within a quarter of a second."""
    command = levels[np.clip(np.searchsorted(at, TIME, side="right") - 1, 0, None)]
    rate = np.zeros(TIME.size)
    for k in range(1, TIME.size):
        rate[k] = rate[k - 1] + 0.2 * (command[k - 1] - rate[k - 1])
    return rate


def test_what_is_sent_on_change_is_known_between() -> None:
    at, levels = commanded(780101)
    assert slow_torque((TIME, turning(at, levels)), (at, levels)) is None


def test_noise_of_a_gyro_says_nothing_of_how_fast_a_vehicle_is() -> None:
    """It changes from sample to sample: that asked for a torque at 501 Hz."""
    noise = np.random.default_rng(780102).normal(0.0, 0.005, TIME.size)
    told = np.random.default_rng(780103).uniform(-1.0, 1.0, TIME.size)
    assert slow_torque((TIME, noise), (TIME, told)) is None
