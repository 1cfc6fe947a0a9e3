"""The integration of one run, with the sensors and the pilot in the loop.

Heun's method in plain floats, for so few states are quicker without arrays. What drives the vehicle is constant over a
step of 10 ms, at most a fortieth of a time scale, by which the method errs by about 1e-4 of a step's change.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from simulator.second.commands import Pilot
from simulator.second.plant import STEP, Array, Plant
from simulator.second.sensors import Clocked


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
    gyro_stamps, gyro_noise = [*gyro.stamps.tolist(), math.inf], gyro.noise.tolist()
    compass_stamps = [*(compass.stamps.tolist() if compass else []), math.inf]
    compass_noise = compass.noise.tolist() if compass else []

    r, heading = start
    seen_rate, seen_heading, seen_at = 0.0, heading, 0.0
    command = carried = 0.0
    rates, headings, thrusts, commands = [], [], [], []
    gyro_log: list[float] = []
    compass_log: list[float] = []
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
        while gyro_stamps[len(gyro_log)] <= end:
            stamp = gyro_stamps[len(gyro_log)]
            part = 1.0 - (end - stamp) / STEP
            seen_rate = rate_before + part * (r - rate_before) + gyro_noise[len(gyro_log)]
            gyro_log.append(seen_rate)
            if compass is None:
                seen_heading += seen_rate * (stamp - seen_at)
                seen_at = stamp
        while compass_stamps[len(compass_log)] <= end:
            part = 1.0 - (end - compass_stamps[len(compass_log)]) / STEP
            seen_heading = heading_before + part * (heading - heading_before) + compass_noise[len(compass_log)]
            compass_log.append(seen_heading)
    return Motion(
        np.array(rates),
        np.array(headings),
        np.array(thrusts),
        np.array(commands),
        np.array(gyro_log),
        np.array(compass_log),
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
