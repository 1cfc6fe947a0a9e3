"""A vehicle whose rotors lag behind their command and whose fin is bent: what no declared model knows."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from incsvr.model.rows import ONE, Factor, Part, Row
from incsvr.numerics import Array
from incsvr.tracing.model import Effect, TracedModel
from service.recordings.recording import Recording, from_table
from simulator import leng

LAG, BIAS = 0.4, 12.0
"""Time constant of the rotors [s], moment of the fin [N m]."""
TRUTH = leng.damping
STEP = 0.02


def recording(seed: int, duration: float = 400.0, *, noise: float = 1.0) -> Recording:
    """Yaw rate at 50 Hz and the commanded torque at 25 Hz, under a command that jumps every few seconds.

    Args:
        seed: draws the command and the sensors' noise.
        duration: [s].
        noise: of the sensors, 1 for 0.002 rad/s and 1 N m.
    """
    random = np.random.default_rng(seed)
    count = round(duration / STEP)
    command = np.empty(count)
    begin = 0
    while begin < count:
        end = begin + round(random.uniform(3.0, 12.0) / STEP)
        command[begin:end] = random.uniform(-90.0, 90.0)
        begin = end
    thrust, rate = float(command[0]), 0.0
    rates = np.empty(count)
    for k, asked in enumerate(command.tolist()):
        rates[k] = rate
        rate += STEP / leng.INERTIA * (thrust + BIAS - TRUTH(rate))
        thrust += STEP / LAG * (asked - thrust)
    time: Array = STEP * np.arange(count, dtype=np.float64)
    rates += noise * random.normal(0.0, 0.002, count)
    measured = command + noise * random.normal(0.0, 1.0, count)
    return Recording(f"hidden_{seed}", {"yaw_rate": (time, rates), "torque": (time[::2], measured[::2])})


def with_channels(run: Recording, channels: Mapping[str, Array]) -> Recording:
    """The run with further channels, sampled in every row."""
    return from_table(run.name, run.time, {**run.columns, **channels})


def acting(name: str, *factors: Factor, value: float, follows: str = "", constant: float | None = None) -> Effect:
    """An effect of one row, which takes so much times its factors of the torque."""
    one, other = (*factors, ONE, ONE)[:2]
    row = Row(name, (Part("yaw_rate", one, other),), follows=follows)
    times = {} if constant is None else {f"time:{row.key}": math.log(constant)}
    return Effect(name, {row.key: value} | times, (row,))


def trim(moment: float) -> Effect:
    """A constant moment that acts [N m]."""
    return acting("bias_torque", value=-moment)


def stage(name: str, kind: str, value: float) -> Effect:
    """An effect between command and thrust, or the whole inertia."""
    return Effect(name, {f"{kind}:yaw_rate": value if kind == "shift" else math.log(value)})


def lag(constant: float) -> Effect:
    """Rotors that lag [s]."""
    return stage("torque_lag", "lag", constant)


def memory(gain: float, constant: float) -> Effect:
    """Water that follows the vehicle [N m s], [s]."""
    return acting("memory", Factor("value", "~memory@yaw_rate"), value=-gain, follows="yaw_rate", constant=constant)


def write_trace(path: Path) -> None:
    """The file that a tracer would write who knew all about the vehicle."""
    rate = np.linspace(-0.3, 0.3, 61)
    model = TracedModel(leng.INERTIA, rate, TRUTH(rate), (lag(LAG), trim(BIAS)), 1.0, 0.3, 2.5, (0.0, 400.0))
    path.write_text(json.dumps({"effects": [], "model": model.to_dict()}), encoding="utf-8")
