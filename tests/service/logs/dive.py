"""A small ROV that turns to and fro, and what its instruments say of it: the truth behind the logs of every format."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from incsvr.numerics import Array
from service.cli.command_line import main
from service.inputs.settings import Inputs
from service.inputs.thrust import t200
from service.logs.reading import LogDescription
from service.recordings.reading import Reading
from service.recordings.recording import Recording

BOOT = 215.0
"""The vehicle's clock where the log begins [s]."""
EPOCH = 1_700_000_000.0
"""The world's clock then [s]."""
DIRECTIONS = (-1, -1, 1, 1)
YAW = (1, -1, -1, 1)
ARM = 0.171
VOLTS = 15.0


@dataclass(frozen=True)
class Dive:
    """Times since the log began [s], the clockwise yaw rate [rad/s] and the command of a turn, −1 … 1."""

    time: Array
    rate: Array
    command: Array

    @property
    def pulses(self) -> Array:
        """(n, 4) what motors 1 … 4 are told [µs], whole as servos have it."""
        told = 1500.0 + np.outer(self.command, 400.0 * np.array(YAW) * np.array(DIRECTIONS))
        return np.round(told)

    @property
    def torque(self) -> Array:
        """The moment of the four thrusters [N m]."""
        volts = np.full(self.time.size, VOLTS)
        turns = [
            YAW[k] * ARM * t200(DIRECTIONS[k] * (self.pulses[:, k] - 1500.0), volts) for k in range(len(DIRECTIONS))
        ]
        return np.asarray(np.sum(turns, axis=0))


def dive(seconds: float = 30.0, hz: float = 20.0) -> Dive:
    """Steps of the command; the rate follows them against drag, I = 0.6 kg m²."""
    time = np.round(np.arange(0.0, seconds, 1.0 / hz), 6)
    levels = np.random.default_rng(780000).uniform(-0.6, 0.6, int(seconds) + 1)
    command = levels[time.astype(int)]
    still = Dive(time, np.zeros(time.size), command)
    rate, drive = np.zeros(time.size), still.torque
    for k in range(1, time.size):
        r = rate[k - 1]
        rate[k] = r + (drive[k - 1] - 0.6 * r - 1.6 * r * abs(r)) / 0.6 / hz
    rate += np.random.default_rng(780001).normal(0.0, 0.002, time.size)
    return Dive(time, rate, command)


PARAMETERS = {
    "FRAME_CONFIG": 2.0,
    **{f"MOT_{k}_DIRECTION": float(direction) for k, direction in enumerate(DIRECTIONS, start=1)},
    **{f"SERVO{k}_FUNCTION": 32.0 + k for k in range(1, 9)},
}


def read(path: Path, *columns: str, learns: bool = True, **inputs: Any) -> Recording:
    """The recording that a log of any format is, with these columns and inputs."""
    return Reading(LogDescription(columns, Inputs.model_validate(inputs)), learns=learns).of_one(path)


def refused(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """The sentence with which a command refuses these words."""
    assert main(list(words)) == 2
    return capsys.readouterr().err
