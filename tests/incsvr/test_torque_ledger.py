"""The torque ledger: samples free of the traced effects, parts that add up, the same bits however messages come."""

from __future__ import annotations

import json
from collections.abc import Mapping

import numpy as np
import pytest

from incsvr.compensation.effects_in_force import Compensation
from incsvr.compensation.freeing import takes_torque as ledger
from incsvr.model.rows import Factor
from incsvr.numerics import Array
from incsvr.plant.body import DECLARED_INERTIA
from incsvr.signals import SignalSettings, Synchroniser, synchronise
from incsvr.signals.samples import Samples
from incsvr.tracing.model import Effect, TracedModel
from simulator import leng
from tests.hidden import BIAS, LAG, TRUTH, acting, lag, memory, recording, stage, trim, with_channels

CHANNELS = ("sway", "voltage", "depth", "heading")

BENT, LAGGING = trim(BIAS), lag(LAG)
VOLTAGE = Factor("about", "voltage", 15.0)
EVERYTHING = (
    LAGGING,
    BENT,
    stage("torque_delay", "shift", 0.13),
    stage("dead_zone", "dead", 4.0),
    stage("torque_asymmetry", "reverse", 0.8),
    memory(60.0, 4.0),
    acting("inflow", Factor("value", "yaw_rate"), Factor("root", "torque"), value=3.0),
    acting("coulomb", Factor("sign", "yaw_rate", 0.003), value=2.0),
    acting("heading_current", Factor("sine2", "heading"), value=3.0),
    acting("tether", Factor("value", "heading"), value=0.2),
    stage("inertia", "mass", 370.0),
    acting("coupling:sway", Factor("value", "sway"), value=-8.0),
    acting("modulation:voltage", VOLTAGE, Factor("value", "torque"), value=-0.03),
    acting("modulation:depth", Factor("about", "depth", 2.0), Factor("drag", "yaw_rate"), value=5.0),
)


def compensation(*effects: Effect) -> Compensation:
    rate = np.linspace(-0.3, 0.3, 61)
    return Compensation.of(TracedModel(350.0, rate, TRUTH(rate), effects, 1.0, 0.5, 3.0, (0.0, 400.0)))


def channels(time: Array, heading: Array) -> dict[str, Array]:
    return {
        "heading": np.mod(heading + np.pi, 2.0 * np.pi) - np.pi,
        "sway": 0.1 * np.sin(0.3 * time),
        "voltage": 15.0 + np.cos(0.05 * time),
        "depth": 2.0 + np.sin(0.02 * time),
    }


def test_the_samples_are_free_of_lag_and_bias() -> None:
    streams = recording(3, noise=0.0).streams()
    plain, _ = synchronise(leng.SIGNALS, streams)
    freed, _ = synchronise(leng.SIGNALS, streams, ledger(leng.SIGNALS, compensation(LAGGING, BENT)))
    off_plain, off_freed = (samples.damping - TRUTH(samples.yaw_rate) for samples in (plain, freed))
    assert np.array_equal(plain.time, freed.time)
    assert abs(off_plain.mean()) > 0.9 * BIAS
    assert abs(off_freed.mean()) < 0.05
    # What is left comes where the command jumps between two stamps of the torque.
    assert np.sqrt(np.mean(off_freed**2)) < 0.05 * np.sqrt(np.mean(off_plain**2))


def whole_run(seed: int) -> Mapping[str, tuple[Array, Array]]:
    run = recording(seed, 120.0)
    rate = np.nan_to_num(run.columns["yaw_rate"])
    return with_channels(run, channels(run.time, np.cumsum(rate) * 0.5)).streams()


def test_the_parts_add_up_to_the_torque() -> None:
    settings = SignalSettings(channels=CHANNELS)
    streams = whole_run(5)
    plain, _ = synchronise(settings, streams)
    split, _ = synchronise(settings, streams, ledger(settings, compensation(*EVERYTHING)))
    assert {DECLARED_INERTIA, *(each.name for each in EVERYTHING)} == set(split.parts)
    plain = plain.take(np.isin(plain.time, split.time))
    assert len(split) > 150
    torque = plain.damping + split.parts[DECLARED_INERTIA]
    np.testing.assert_allclose(split.damping + sum(split.parts.values()), torque, atol=1e-9)


@pytest.mark.parametrize(("seed", "delay"), [(1, -0.4), pytest.param(1, 0.13, marks=pytest.mark.slow)])
def test_it_makes_no_difference_how_messages_come_and_where_it_is_stopped(seed: int, delay: float) -> None:
    random = np.random.default_rng(seed)
    settings = SignalSettings(channels=CHANNELS)
    late = stage("torque_delay", "shift", delay)
    effects = compensation(*(late if each.name == "torque_delay" else each for each in EVERYTHING))
    streams = {}
    for name, (t, value) in whole_run(seed).items():
        # Two drop-outs: one that is bridged, one that begins a new run.
        there = (t < 30.0) | ((t > 31.0) & (t < 60.0)) | (t > 66.0)
        streams[name] = (t[there], value[there])
    whole, _ = synchronise(settings, streams, ledger(settings, effects))
    synchroniser = Synchroniser(settings, ledger(settings, effects))
    parts, sent = [], dict.fromkeys(streams, 0)
    for now in np.arange(0.0, 125.0, 0.7).tolist():
        for name, (t, value) in streams.items():
            upto = int(np.searchsorted(t, now + random.uniform(0.0, 1.5)))
            synchroniser.push(name, t[sent[name] : upto], value[sent[name] : upto])
            sent[name] = max(upto, sent[name])
        parts.append(synchroniser.ready())
        if random.random() < 0.2:
            synchroniser = Synchroniser.from_dict(
                json.loads(json.dumps(synchroniser.to_dict())), ledger(settings, effects)
            )
    played = Samples.concatenate(parts)
    assert len(played) == len(whole) > 150
    assert np.array_equal(played.damping, whole.damping)
    for name in whole.parts:
        assert np.array_equal(played.parts[name], whole.parts[name]), name


@pytest.mark.slow
def test_its_memory_is_bounded() -> None:
    synchroniser = Synchroniser(leng.SIGNALS, ledger(leng.SIGNALS, compensation(LAGGING, BENT)))
    sizes = []
    for begin in np.arange(0.0, 400.0, 10.0).tolist():
        for name, (t, value) in recording(3).streams().items():
            part = (t >= begin) & (t < begin + 10.0)
            synchroniser.push(name, t[part], value[part])
        synchroniser.ready()
        sizes.append(len(json.dumps(synchroniser.to_dict())))
    assert max(sizes) < 2 * min(sizes)


def test_no_sample_is_made_where_a_channel_of_an_effect_is_missing() -> None:
    settings = SignalSettings(channels=("sway",))
    run = recording(3, 100.0)
    sway = np.where(run.time < 40.0, 0.0, np.nan)
    effects = compensation(acting("coupling:sway", Factor("value", "sway"), value=-8.0))
    samples, _ = synchronise(settings, with_channels(run, {"sway": sway}).streams(), ledger(settings, effects))
    assert len(samples) > 0
    assert samples.time.max() < 40.0


def test_what_refers_to_the_clock_of_its_recording_is_left_out() -> None:
    wave = acting("wave", Factor("wave", "time", 0.9), value=2.0)
    drift = acting("bias_drift", Factor("value", "time"), value=0.01)
    kept = compensation(LAGGING, wave, drift)
    assert kept.names == ("torque_lag",)
    assert kept.left_out == ("wave", "bias_drift")
