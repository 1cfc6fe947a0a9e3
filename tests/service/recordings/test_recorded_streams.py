"""What the stamps and the heading of a recording say: each fault is put into a recording that is right without it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike

from incsvr.numerics import Array, Streams
from service.cli.command_line import main
from service.recordings.recording import Recording
from service.recordings.recording_csv import write
from service.recordings.samples_from_recording import remarks_of, signals_for

STEP, COUNT, HALF = 0.05, 8000, 200.0
INERTIA = 20.0


def right(seed: int) -> Streams:
    """20 ṙ + 15 r + 40 r|r| = τ + water, τ held for 1.5 to 5 s; a heading that follows."""
    random = np.random.default_rng(seed)
    torque = np.concatenate([np.full(int(random.uniform(30, 100)), random.uniform(-9.0, 9.0)) for _ in range(270)])
    rate = np.zeros(COUNT)
    water = 0.0
    for k in range(COUNT - 1):
        water += -water * STEP / 1.5 + 0.13 * float(random.normal())
        rate[k + 1] = rate[k] + STEP / INERTIA * (torque[k] + water - 15.0 * rate[k] - 40.0 * rate[k] * abs(rate[k]))
    heading = 0.3 + np.cumsum(rate) * STEP
    time: Array = STEP * np.arange(COUNT, dtype=np.float64)
    noise = random.normal(0.0, 0.003, (2, COUNT))
    return {
        "yaw_rate": (time, rate + noise[0]),
        "torque": (time, torque[:COUNT]),
        "heading": (time, heading + noise[1]),
    }


@pytest.fixture(scope="module")
def streams() -> Streams:
    return right(910_020)


def sent_together(time: ArrayLike, period: float) -> Array:
    """The stamps of values that are written every so often, a thousandth of a second apart."""
    together = np.ceil((np.asarray(time, dtype=np.float64) + 1e-9) / period)
    first = np.searchsorted(together, together)
    return np.asarray(together * period + 0.001 * (np.arange(together.size) - first))


def said(streams: Streams) -> list[str]:
    recording = Recording("dive.csv", streams)
    return remarks_of(recording, signals_for([recording], INERTIA, 6.0).smoothing)


def test_nothing_is_said_of_a_recording_that_is_right(streams: Streams) -> None:
    assert said(streams) == []


@pytest.mark.parametrize(
    ("name", "fault", "sentence"),
    [
        ("torque", lambda t, v: (t + 0.5 * (t > HALF), v), "the clock of one stream steps between 120 and 300 s"),
        ("torque", lambda t, v: (1.0 + t - 1.0 * (t > HALF), v), "the torque is 1 s later"),
        ("yaw_rate", lambda t, v: (t + 1.0 * (t > HALF), v), "the clock of one stream steps between"),
        ("torque", lambda t, v: (1.002 * t, v), "the clock of one stream runs at another speed, 1.9 ms"),
        ("torque", lambda t, v: (sent_together(t, 0.5), v), "the torque arrives in bursts 0.49 s apart, stamped when"),
        ("heading", lambda t, v: (t, v + 0.003 * t), "the heading drifts by +0.003 rad/s against the yaw rate, +68"),
        ("heading", lambda t, v: (t, v[::-1]), "the heading does not follow the yaw rate"),
    ],
)  # fmt: skip
def test_a_fault_is_named(
    streams: Streams, name: str, fault: Callable[[Array, Array], tuple[Array, Array]], sentence: str
) -> None:
    stamps, values = fault(*streams[name])
    kept = np.concatenate(([True], np.diff(np.maximum.accumulate(stamps)) > 0.0))
    (told,) = said({**streams, name: (stamps[kept], values[kept])})
    assert sentence in told


def test_fit_and_trace_refuse_a_yaw_rate_in_bursts_and_tell_a_clock(
    streams: Streams, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    time, rate = streams["yaw_rate"]
    write(tmp_path / "bursts.csv", Recording("b", {**streams, "yaw_rate": (sent_together(time, 0.5), rate)}))
    for command in ("fit", "trace"):
        assert main([command, str(tmp_path / "bursts.csv"), "--inertia", "20"]) == 2
        assert "the yaw rate arrives in bursts 0.49 s apart" in capsys.readouterr().err
    time, torque = streams["torque"]
    write(tmp_path / "steps.csv", Recording("s", {**streams, "torque": (time + 0.5 * (time > HALF), torque)}))
    assert main(["fit", str(tmp_path / "steps.csv"), "--inertia", "20"]) == 0
    assert "the clock of one stream steps between" in capsys.readouterr().out
