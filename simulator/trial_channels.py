"""Further channels of a trial vehicle: some act on it, most do not."""

from __future__ import annotations

import numpy as np

from simulator.trial_effects.physics import Array

# centre, deviation, correlation time in the vehicle's I r/τ, recorder's frequency [Hz], sensor noise in deviations
_WANDERING = {
    "sway": (0.0, 0.15, 5.0, 10.0, 0.05),
    "surge": (0.6, 0.2, 15.0, 10.0, 0.05),
    "heave": (0.0, 0.08, 6.0, 10.0, 0.05),
    "roll_rate": (0.0, 0.05, 1.5, 20.0, 0.05),
    "pitch_rate": (0.0, 0.04, 1.5, 20.0, 0.05),
    "depth": (6.0, 1.5, 60.0, 5.0, 0.01),
    "winch_load": (40.0, 12.0, 25.0, 5.0, 0.05),
    "ballast_flow": (0.0, 0.3, 12.0, 4.0, 0.1),
    "arm_angle": (0.4, 0.35, 30.0, 10.0, 0.02),
}
_DECLINING = {
    # start, change over the run, wandering deviation, correlation time, frequency, sensor noise in deviations
    "voltage": (16.4, -1.2, 0.3, 25.0, 2.0, 0.1),
    "temperature": (12.0, -1.5, 0.3, 120.0, 1.0, 0.05),
}
CHANNELS = (*_WANDERING, *_DECLINING)


def frequency(name: str) -> float:
    """How often the recorder samples this channel [Hz]."""
    return _WANDERING[name][3] if name in _WANDERING else _DECLINING[name][4]


def sensor_noise(name: str) -> float:
    """Deviation of the sensor, in deviations of the channel."""
    return _WANDERING[name][4] if name in _WANDERING else _DECLINING[name][5]


def channel(name: str, time: Array, unit: float, random: np.random.Generator) -> Array:
    """A channel's true course.

    Args:
        name: one of CHANNELS.
        time: (n,) evenly spaced [s].
        unit: the vehicle's I r/τ [s].
        random: draws the course.

    Raises:
        KeyError: no such channel.
    """
    if name in _WANDERING:
        centre, deviation, memory, _, _ = _WANDERING[name]
        return centre + deviation * _wander(time, memory * unit, random)
    start, change, deviation, memory, _, _ = _DECLINING[name]
    return np.asarray(start + change * time / time[-1] + deviation * _wander(time, memory * unit, random))


def _wander(time: Array, memory: float, random: np.random.Generator) -> Array:
    """A smooth random course with deviation one: noise through a filter that falls off as a Gaussian."""
    step = float(time[1] - time[0])
    # The transform's course is periodic; of a longer one no end meets its beginning.
    count = time.size + round(8 * memory / step)
    frequencies = np.fft.rfftfreq(count, step)
    shape = np.exp(-0.5 * (2 * np.pi * frequencies * memory / 2) ** 2)
    spectrum = shape * (random.standard_normal(frequencies.size) + 1j * random.standard_normal(frequencies.size))
    spectrum[0] = 0.0
    course = np.fft.irfft(spectrum, count)
    return np.asarray(course[: time.size] / np.std(course))
