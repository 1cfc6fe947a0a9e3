"""The integration of one run, with the sensors and the pilot in the loop.

Heun's method in plain floats, for so few states are quicker without arrays. What drives the vehicle is constant over a
step of 10 ms, at most a fortieth of a time scale, by which the method errs by about 1e-4 of a step's change.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from simulator.second.commands import Pilot
from simulator.second.plant import STEP, Array, Plant
from simulator.second.sensors import Clocked


class _SensorLog:
    """The samples of one sensor as they are taken; none without a sensor."""

    def __init__(self, sensor: Clocked | None) -> None:
        self._stamps = [*(sensor.stamps.tolist() if sensor else []), math.inf]
        self._noise = sensor.noise.tolist() if sensor else []
        self.values: list[float] = []

    def take(self, end: float, before: float, now: float) -> Iterator[tuple[float, float]]:
        """Stamp and value of each sample in the step that ends at `end` [s], between the true values at its ends."""
        while self._stamps[len(self.values)] <= end:
            stamp = self._stamps[len(self.values)]
            part = 1.0 - (end - stamp) / STEP
            self.values.append(before + part * (now - before) + self._noise[len(self.values)])
            yield stamp, self.values[-1]


@dataclass(frozen=True, slots=True)
class Motion:
    """What truly happened, and what gyro and compass logged of it.

    Attributes:
        yaw_rate: (n,) at the end of each step [rad/s].
        heading: (n,) likewise, counted on [rad].
        thrust: (n,) what the thrusters gave in each step [N m].
        command: (ticks,) what was asked of them and held [N m].
        gyro: samples at the gyro's stamps [rad/s].
        compass: samples at the compass's stamps [rad]; empty without one.
    """

    yaw_rate: Array
    heading: Array
    thrust: Array
    command: Array
    gyro: Array
    compass: Array


def motion_of(
    plant: Plant, pilot: Pilot, hold: int, gyro: Clocked, compass: Clocked | None, start: tuple[float, float]
) -> Motion:
    """Moves the plant through all its steps.

    Args:
        plant: what moves, with the water in its `outside`.
        pilot: asked every `hold` steps.
        hold: steps of integration for which a command is held.
        gyro: the gyro's clock and noise.
        compass: the compass's; without one the pilot counts the heading on from the gyro.
        start: yaw rate [rad/s] and heading [rad].
    """
    respond = acceleration_of(plant)
    stages = [make() for make in plant.stages]
    factors, outside, scales = plant.drag_factor.tolist(), plant.outside.tolist(), plant.thrust_factor.tolist()
    wakes = [[share, -math.expm1(-STEP / constant), 0.0] for share, constant in plant.wakes]
    r, heading = start
    seen_rate, seen_heading, seen_at = 0.0, heading, 0.0
    command = carried = 0.0
    rates, headings, thrusts, commands = [], [], [], []
    gyro_log, compass_log = _SensorLog(gyro), _SensorLog(compass)
    for k in range(plant.outside.size):
        if k % hold == 0:
            command = pilot(k // hold, seen_rate, seen_heading)
            commands.append(command)
        thrust = command
        for stage in stages:
            thrust = stage(thrust)
        thrust *= scales[k]
        push, factor = thrust + outside[k], factors[k]
        first = respond(push, thrust, factor, carried, r, heading)
        second = respond(push, thrust, factor, carried, r + STEP * first, heading + STEP * r)
        rate_before, heading_before = r, heading
        r += 0.5 * STEP * (first + second)
        heading += 0.5 * STEP * (rate_before + r)
        if wakes:
            carried = 0.0
            for wake in wakes:
                wake[2] += wake[1] * (0.5 * (rate_before + r) - wake[2])
                carried += wake[0] * wake[2]
        rates.append(r)
        headings.append(heading)
        thrusts.append(thrust)
        end = (k + 1) * STEP
        for stamp, seen_rate in gyro_log.take(end, rate_before, r):
            if compass is None:
                seen_heading += seen_rate * (stamp - seen_at)
                seen_at = stamp
        for _, logged in compass_log.take(end, heading_before, heading):
            seen_heading = logged
    return Motion(
        np.array(rates),
        np.array(headings),
        np.array(thrusts),
        np.array(commands),
        np.array(gyro_log.values),
        np.array(compass_log.values),
    )


def acceleration_of(plant: Plant) -> Callable[[float, float, float, float, float, float], float]:
    """(push without losses [N m], thrust [N m], drag's factor, water's rate [rad/s], r, ψ) -> ṙ [rad/s²]."""
    drag, moments, losses = plant.drag, plant.moments, plant.losses
    inertia = plant.inertia

    def respond(push: float, thrust: float, factor: float, carried: float, r: float, heading: float) -> float:
        net = push - factor * drag(r - carried)
        for moment in moments:
            net += moment(r, heading)
        for loss in losses:
            net -= loss(thrust, r)
        return net / inertia

    return respond
