"""A vehicle and its controller in motion, integrated."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from simulator.effects import Physics
from simulator.effects.physics import Array
from simulator.missions.autopilot import Autopilot
from simulator.missions.plans import Plan
from simulator.missions.vehicles import Vehicle
from simulator.trial_vehicle import STEP, Onset, response


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
    h, half = STEP, STEP / 2.0
    r, psi, rotor, w = 0.0, 0.0, 0.0, 0.0
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
            tick, noisy = 2 * step, moments[step]
            u = arrived(step) if late else commands[-1]
            a1, d1, e1 = respond(u, tick, noisy, r, psi, rotor, w)
            b1 = r
            b2 = r + half * a1
            a2, d2, e2 = respond(u, tick + 1, noisy, b2, psi + half * b1, rotor + half * d1, w + half * e1)
            b3 = r + half * a2
            a3, d3, e3 = respond(u, tick + 1, noisy, b3, psi + half * b2, rotor + half * d2, w + half * e2)
            b4 = r + h * a3
            a4, d4, e4 = respond(u, tick + 2, noisy, b4, psi + h * b3, rotor + h * d3, w + h * e3)
            r += h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)
            psi += h / 6.0 * (b1 + 2.0 * (b2 + b3) + b4)
            rotor += h / 6.0 * (d1 + 2.0 * (d2 + d3) + d4)
            w += h / 6.0 * (e1 + 2.0 * (e2 + e3) + e4)
    time = STEP * np.arange(len(rates), dtype=np.float64)
    return Motion(time, np.array(rates), np.array(headings), np.array(gyro), np.array(compass), np.array(commands))
