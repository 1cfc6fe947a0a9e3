"""A vehicle and its controller in motion, integrated."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from simulator.missions.autopilot import Autopilot
from simulator.missions.plans import Plan
from simulator.missions.vehicles import Vehicle
from simulator.trial_effects import Physics
from simulator.trial_effects.physics import Array
from simulator.trial_vehicle import STEP, Onset, response, step_on


@dataclass(frozen=True, slots=True)
class Motion:
    """What truly happened, at every integration step.

    Attributes:
        time: (n,) [s].
        yaw_rate: (n,) r [rad/s].
        heading: (n,) ψ [rad], counted on from zero.
        gyro, compass, command: (beats,) what the controller saw [rad/s], [rad], and what it said [N m].
    """

    time: Array
    yaw_rate: Array
    heading: Array
    gyro: Array
    compass: Array
    command: Array


def sail(
    physics: Physics,
    vehicle: Vehicle,
    asked: Plan,
    hold: int,
    water: Array,
    noise: tuple[Array, Array],
    onset: Onset | None = None,
) -> Motion:
    """Integrates vehicle and controller from rest by Runge and Kutta's fourth order.

    Args:
        physics: the true equations.
        vehicle: whose thrusters have a limit.
        asked: the plan, one wish a beat.
        hold: integration steps of a beat.
        water: (n,) the water's moment in each step [N m].
        noise: (beats,) each, of the gyro [rad/s] and of the compass [rad].
        onset: what comes on under way; None for nothing.
    """
    respond = response(physics)
    autopilot = Autopilot(asked, vehicle.scale.torque, hold * STEP)
    late = physics.delay / STEP
    r, psi, rotor, w, u = 0.0, 0.0, 0.0, 0.0, 0.0
    gyro_noise, compass_noise = noise[0].tolist(), noise[1].tolist()
    moments = water.tolist()
    rates, headings = list[float](), list[float]()
    gyro, compass, commands = list[float](), list[float](), list[float]()

    def arrived(step: int) -> float:
        """The command at the thrusters, mean over the step; before the first command has arrived it is zero."""
        position = step - late
        beat = math.floor(position / hold)
        before = commands[beat] if beat >= 0 else 0.0
        remaining = (beat + 1) * hold - position
        return before if remaining >= 1.0 else remaining * before + (1.0 - remaining) * commands[beat + 1]

    def slopes(tick: int, moment: float, r: float, psi: float, rotor: float, w: float) -> tuple[float, float, float]:
        return respond(u, tick, moment, r, psi, rotor, w)

    for beat in range(len(gyro_noise)):
        gyro.append(r + gyro_noise[beat])
        compass.append(psi + compass_noise[beat])
        commands.append(autopilot.command(beat, gyro[-1], compass[-1]))
        for step in range(beat * hold, (beat + 1) * hold):
            rates.append(r)
            headings.append(psi)
            if onset is not None and step == onset.step:
                respond, late = response(onset.physics), onset.physics.delay / STEP
                rotor, w = onset.rotor(commands[-1]), r
            u = arrived(step) if late else commands[-1]
            r, psi, rotor, w, _ = step_on(slopes, 2 * step, moments[step], r, psi, rotor, w)
    time = STEP * np.arange(len(rates), dtype=np.float64)
    return Motion(time, np.array(rates), np.array(headings), np.array(gyro), np.array(compass), np.array(commands))
