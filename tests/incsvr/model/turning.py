"""A vehicle that turns: I ṙ + (d + k |r| + c |u|) r = τ + w, in steps of 2 ms, and its log."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from incsvr.numerics import Array, Stream, Streams

STEP = 0.002
"""Step of the integration by the midpoint rule [s]."""


@dataclass(frozen=True)
class Turning:
    """A vehicle.

    Attributes:
        inertia: I [kg m²].
        linear, quadratic: d [N m s], k [N m s²].
        cross_flow: c [N s²].
        thrust: makes the torque that acts of the one that is asked for [N m].
    """

    inertia: float = 24.0
    linear: float = 9.0
    quadratic: float = 26.0
    cross_flow: float = 0.0
    thrust: Callable[[float], float] = float

    def course(self, torque: Callable[[int, float], float], surge: Array) -> tuple[Array, Array]:
        """(n,) r [rad/s] and τ [N m] at each step; `torque` is asked for τ of a step, at the present r."""
        rate, rates, torques = 0.0, np.zeros(surge.size), np.zeros(surge.size)
        for k, flow in enumerate((self.linear + self.cross_flow * np.abs(surge)).tolist()):
            tau = torque(k, rate)
            rates[k], torques[k] = rate, tau
            tau = self.thrust(tau)
            middle = rate + 0.5 * STEP * (tau - (flow + self.quadratic * abs(rate)) * rate) / self.inertia
            rate += STEP * (tau - (flow + self.quadratic * abs(middle)) * middle) / self.inertia
        return rates, torques


def times(seconds: float) -> Array:
    """(n,) instants of the integration [s]."""
    return np.asarray(np.arange(round(seconds / STEP)) * STEP)


def commands(random: np.random.Generator, seconds: float, largest: float, lasting: float = 2.0) -> Array:
    """(n,) torques that hold for `lasting` seconds each [N m]."""
    count = round(lasting / STEP)
    levels = random.uniform(-largest, largest, times(seconds).size // count + 1)
    return np.asarray(np.repeat(levels, count)[: times(seconds).size])


def wandering(random: np.random.Generator, seconds: float, size: float, constant: float) -> Array:
    """(n,) a value that wanders with a time constant [s] and this deviation."""
    value = np.zeros(times(seconds).size)
    kept, level = float(np.exp(-STEP / constant)), 0.0
    for k, push in enumerate((size * np.sqrt(1.0 - kept**2) * random.normal(size=value.size)).tolist()):
        level = kept * level + push
        value[k] = level
    return value


def logged(random: np.random.Generator, value: Array, rate: float, noise: float = 0.0, late: float = 0.0) -> Stream:
    """A stream of samples at a rate [Hz] with white noise; its stamps are `late` by so much [s]."""
    every = round(1.0 / rate / STEP)
    sampled = value[::every]
    return np.asarray(np.arange(sampled.size) * every * STEP + late), sampled + noise * random.normal(size=sampled.size)


def dive(
    vehicle: Turning,
    seed: int,
    seconds: float = 120.0,
    rate: float = 10.0,  # of the log [Hz]
    noise: float = 0.003,  # of the gyro [rad/s]
    early: float = 0.0,  # by which the torque's clock is behind the gyro's [s]
    way: str = "hold",  # of the torque: it holds for 2 s, or runs on lines between changes every 0.1 s
) -> Streams:
    """A log of the yaw rate, the torque and the surge, which wanders, in open loop."""
    random = np.random.default_rng(seed)
    t = times(seconds)
    if way == "hold":
        torque = commands(random, seconds, 12.0)
    else:
        coarse = np.arange(0.0, seconds + 1.0, 0.1)
        smooth = np.convolve(random.normal(size=coarse.size), np.ones(12) / 2.0, mode="same")
        torque = np.interp(t, coarse, 6.0 * smooth)
    surge = 0.8 + wandering(random, seconds, 0.5, 5.0)
    rates, torques = vehicle.course(lambda k, _: float(torque[k]), surge)
    return {
        "yaw_rate": logged(random, rates, rate, noise),
        "torque": logged(random, torques, rate, late=-early),
        "surge": logged(random, surge, rate, 0.01),
    }


def steered(
    vehicle: Turning,
    seed: int,
    seconds: float = 120.0,
    rate: float = 10.0,
    gain: float = 40.0,
    water: float = 0.5,
    constant: float = 1.5,
) -> Streams:
    """A log in closed loop: a controller asks at each sample for `gain` [N m s] times the error of the measured rate.

    The water turns the vehicle, too, by a torque that wanders: `water` is its deviation [N m], `constant` its time
    constant [s]. The controller answers it.
    """
    random = np.random.default_rng(seed)
    t, every = times(seconds), round(1.0 / rate / STEP)
    pushes = wandering(random, seconds, water, constant)
    surge = 0.8 + wandering(random, seconds, 0.5, 5.0)
    wanted = commands(random, seconds, 0.5, lasting=4.0)
    gyro = 0.003 * random.normal(size=t.size)
    demand = np.zeros(t.size)

    def torque(k: int, rate_now: float) -> float:
        demand[k] = gain * (wanted[k] - rate_now - gyro[k]) if k % every == 0 else demand[k - 1]
        return float(demand[k] + pushes[k])

    rates, _ = vehicle.course(torque, surge)
    return {
        "yaw_rate": logged(random, rates + gyro, rate),
        "torque": logged(random, demand, rate),
        "surge": logged(random, surge, rate, 0.01),
    }
