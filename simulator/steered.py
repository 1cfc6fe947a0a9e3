"""Leng as a torque steers it: a manoeuvre that is played, and the log that a beginner starts with.

The log's vehicle has weak thrust to one side (`REVERSE_EFFICIENCY`), which its recorded torque does not show: the
torque is what the rotors' speeds make in a vehicle that is sound. That is what `trace` is to find.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from incsvr.errors import BadInput
from incsvr.numerics import Array
from service.recordings.recording import Recording
from service.recordings.recording_csv import write
from simulator import leng
from simulator.trial_command import Command, command
from simulator.trial_effects import Physics
from simulator.trial_effects.physics import ThrustMap
from simulator.trial_vehicle import STEP, move
from simulator.underway import SCALE, inflow, recorded, water

MAX_TORQUE = SCALE.torque
"""Both thrusters' moment at full speed [N m]."""
LOG_DURATION = 300.0
"""Length of a beginner's log [s]: `fit` learns from it in a second, `trace` in some ten."""
REVERSE_EFFICIENCY = 0.7
"""The part of a moment to port (negative) that the log's vehicle makes of what its rotors' speeds show."""


def steered(name: str, time: Array, torque: Array, seed: int) -> Recording:
    """Leng, without its hull, as a torque moves it from rest.

    Args:
        name: of the recording.
        time: (n,) stamps [s], increasing.
        torque: (n,) what is asked of the thrusters [N m]; each value holds until the next one.
        seed: draws the water, the wavering of the thrust and the noise of the sensors.

    Raises:
        BadInput: the torque is more than the vehicle has.
    """
    beyond = np.flatnonzero(np.abs(torque) > MAX_TORQUE)
    if beyond.size:
        raise BadInput(
            f"{name}: the torque is {torque[beyond[0]]:g} N m at {time[beyond[0]]:g} s, and the simulated vehicle has "
            f"±{MAX_TORQUE:g} N m; scale the manoeuvre down"
        )
    ticks = _ticks(float(time[-1] - time[0]))
    held = np.searchsorted(time - time[0], ticks, side="right") - 1
    return _recording(name, torque[held], (inflow,), seed)


def write_log(path: Path, seed: int) -> float:
    """Writes a beginner's log; returns the vehicle's inertia [kg m²].

    Raises:
        OSError: the file cannot be written.
    """
    write(path, leng_log(path.stem, seed))
    return leng.INERTIA


def leng_log(name: str, seed: int) -> Recording:
    """A beginner's log: Leng steered by steps and sines at once, with weak thrust to port."""
    ticks = _ticks(LOG_DURATION)
    random = np.random.default_rng([seed, *b"log"])
    levels, sines = (np.array(command(kind, SCALE, ticks, random).table) for kind in ("telegraph", "multisine"))
    return _recording(name, 0.5 * (levels + sines), (_weak_to_port, inflow), seed)


def _ticks(duration: float) -> Array:
    """The half steps of the integrator [s]."""
    return np.arange(2 * max(1, round(duration / STEP)) + 1, dtype=np.float64) * STEP / 2.0


def _recording(name: str, torque: Array, produced: tuple[ThrustMap, ...], seed: int) -> Recording:
    """Leng as torques (2 n + 1,) at the integrator's half steps move it [N m]; `produced` is what becomes of them."""
    for_water, for_sensors = (
        np.random.default_rng(each) for each in np.random.SeedSequence([seed, *b"steered"]).spawn(2)
    )
    told = torque[:-1:2]
    physics = Physics(leng.INERTIA, leng.damping, produced=produced)
    motion = move(physics, Command(torque.tolist()), water(told, for_water, hull=False), 0.0)
    return recorded(name, told, motion, for_sensors)


def _weak_to_port(moment: float, _rate: float, _tick: int) -> float:
    return moment if moment > 0.0 else REVERSE_EFFICIENCY * moment
