"""The main list of effects that can be hidden in a vehicle: the physics itself, for trials of the tracer.

Nothing here is shared with what finds effects (`incsvr/model/`): other formulations, other shapes, NumPy alone. An
effect on a further channel carries the channel's name behind a colon.
"""

from __future__ import annotations

import math

import numpy as np

from simulator.physics import STEP, Array, MakeStage, Physics, Setting, Stage, Truth, static


def bias_torque(here: Setting) -> tuple[Physics, Truth]:
    """A bent fin or a badly trimmed thruster: a constant moment."""
    constant = here.sign() * here.size * here.torque * here.between(0.04, 0.07)
    return Physics(moments=(lambda _rate, _heading: constant,)), {"moment_nm": constant}


def bias_drift(here: Setting) -> tuple[Physics, Truth]:
    """A constant moment grows slowly from nothing, evenly in time."""
    slope = here.sign() * here.size * here.torque * here.between(0.09, 0.13) / here.duration
    return Physics(outside=(lambda t: slope * t,)), {"nm_per_s": slope}


def heading_current(here: Setting) -> tuple[Physics, Truth]:
    """A steady current turns the hull: once a turn (weathercock) or twice (the Munk moment)."""
    amplitude, phase = here.size * here.torque * here.between(0.06, 0.08), here.between(-math.pi, math.pi)
    harmonic = 1 if here.heads() else 2
    current = (lambda _rate, heading: amplitude * math.sin(harmonic * heading + phase),)
    return Physics(moments=current), {"amplitude_nm": amplitude, "phase_rad": phase, "harmonic": harmonic}


def tether(here: Setting) -> tuple[Physics, Truth]:
    """A cable winds up with the turned angle."""
    stiffness = here.size * here.between(0.007, 0.010) * here.torque / (here.rate * here.time)
    twist = (lambda _rate, heading: -stiffness * (heading - here.start),)
    return Physics(moments=twist), {"stiffness_nm_per_rad": stiffness}


def wave(here: Setting) -> tuple[Physics, Truth]:
    """Swell rocks the hull: a periodic moment, with a little of the second harmonic as Stokes waves have it."""
    amplitude, period = here.size * here.torque * here.between(0.055, 0.075), here.time * here.between(5.0, 11.0)
    phase, steepness = here.between(-math.pi, math.pi), here.between(0.0, 0.15)

    def rocks(t: Array) -> Array:
        angle = 2.0 * math.pi * t / period + phase
        return np.asarray(amplitude * (np.sin(angle) + steepness * np.sin(2.0 * angle)))

    return Physics(outside=(rocks,)), {"amplitude_nm": amplitude, "period_s": period, "phase_rad": phase}


def coulomb(here: Setting) -> tuple[Physics, Truth]:
    """A slip ring or a seal rubs: a moment against the sense of turning, however slow (regularised by tanh)."""
    friction, creep = here.size * here.torque * here.between(0.05, 0.07), 0.02 * here.rate
    return Physics(moments=(lambda rate, _heading: -friction * math.tanh(rate / creep),)), {"moment_nm": friction}


def inertia(here: Setting) -> tuple[Physics, Truth]:
    """Payload, or added mass near a wall: the true I is not the declared one."""
    factor = 1.0 + here.sign() * here.size * here.between(0.12, 0.20)
    return Physics(inertia=(factor,)), {"inertia_kg_m2": factor * here.inertia}


def drag_drift(here: Setting) -> tuple[Physics, Truth]:
    """Weed gathers on the hull: the drag grows evenly from the first second to the last."""
    fraction = here.size * here.between(0.30, 0.45)
    return Physics(drag=(lambda t: 1.0 + fraction * t / here.duration,)), {"fraction": fraction}


def drag_step(here: Setting) -> tuple[Physics, Truth]:
    """The vehicle picks something up or loses a fairing: the drag jumps."""
    fraction = here.size * here.between(0.25, 0.38) * (-0.75 if here.heads(0.4) else 1.0)
    at = here.duration * here.between(0.3, 0.7)
    return Physics(drag=(lambda t: np.where(t >= at, 1.0 + fraction, 1.0),)), {"fraction": fraction, "at_s": at}


def memory(here: Setting) -> tuple[Physics, Truth]:
    """Water takes on the hull's rate, Tw ẇ = r − w, and the hull drags in turning water: d(r − βw), or d(r) − gw."""
    time, share = here.time * here.between(3.5, 7.0), here.size * here.between(0.22, 0.32)
    gain = share * here.torque / here.rate
    turns = here.heads()
    truth: Truth = {"gain_nm_s": gain, "time_constant_s": time, "shape": "co-rotation" if turns else "linear"}
    return Physics(wakes=((share, time),)) if turns else Physics(pulls=((gain, time),)), truth


def torque_lag(here: Setting) -> tuple[Physics, Truth]:
    """Rotors follow their set point: T ṅ = n₀ − n with the moment n|n|, quadratic in the speed, or T τ̇ = τ₀ − τ."""
    time, speed = here.size * here.time * here.between(0.6, 0.95), here.heads()
    truth: Truth = {"time_constant_s": time, "shape": "rotor speed" if speed else "moment"}
    return Physics(stages=(lagging(time, speed),)), truth


def lagging(time: float, speed: bool = False) -> MakeStage:
    """A first-order lag [s] of the moment, or of the rotor's speed; a step's thrust is the mean over it."""
    part = -math.expm1(-STEP / time)

    def make(moment: float) -> Stage:
        state = _root(moment) if speed else moment

        def stage(command: float) -> float:
            nonlocal state
            before = state
            state += part * ((_root(command) if speed else command) - state)
            middle = 0.5 * (before + state)
            return middle * abs(middle) if speed else middle

        return stage

    return make


def _root(moment: float) -> float:
    return math.copysign(math.sqrt(abs(moment)), moment)


def torque_delay(here: Setting) -> tuple[Physics, Truth]:
    """The command takes its time on the way to the thrusters."""
    delay = here.size * here.time * here.between(0.4, 0.7)
    return Physics(stages=(delayed(delay),)), {"delay_s": delay}


def delayed(delay: float) -> MakeStage:
    """What was commanded so long ago [s], in whole steps."""
    late = max(1, round(delay / STEP))

    def make(moment: float) -> Stage:
        ring, place = [moment] * late, 0

        def stage(command: float) -> float:
            nonlocal place
            due, ring[place] = ring[place], command
            place = (place + 1) % late
            return due

        return stage

    return make


def dead_zone(here: Setting) -> tuple[Physics, Truth]:
    """Small commands turn no rotor; beyond, the moment either starts at zero or jumps to its full value."""
    half, jump = here.size * here.torque * here.between(0.07, 0.09), here.heads(0.3)

    def gate(moment: float) -> float:
        if abs(moment) <= half:
            return 0.0
        return moment if jump else math.copysign(abs(moment) - half, moment)

    return Physics(stages=(static(gate),)), {"half_width_nm": half, "shape": "jump" if jump else "offset"}


def torque_asymmetry(here: Setting) -> tuple[Physics, Truth]:
    """A propeller gives less astern than ahead."""
    efficiency = 1.0 - here.size * here.between(0.13, 0.19)
    astern = static(lambda moment: moment * efficiency if moment < 0.0 else moment)
    return Physics(stages=(astern,)), {"reverse_efficiency": efficiency}


def torque_saturation(here: Setting) -> tuple[Physics, Truth]:
    """High commands fall short: a current limit that cuts, or a supply that bends the curve, u/(1 + |u/L|⁴)^¼."""
    hard, lost = here.heads(), here.between(0.28, 0.36) * here.size
    limit = here.torque * (1.0 - lost)
    # The smooth curve loses its first tenth long before L, so its L lies higher for the same loss at full torque.
    corner = here.torque / ((1.0 - lost) ** -4 - 1.0) ** 0.25
    cut = static(lambda moment: min(max(moment, -limit), limit))
    bend = static(lambda moment: moment / math.sqrt(math.sqrt(1.0 + (moment / corner) ** 4)))
    truth: Truth = {"limit_nm": limit if hard else corner, "shape": "cut" if hard else "bend"}
    return Physics(stages=(cut if hard else bend,)), truth


def inflow(here: Setting) -> tuple[Physics, Truth]:
    """Water meets the propeller at the vehicle's own speed: n|n| loses |n| u_a (Fossen: advance number), n = √|τ|."""
    # At full torque and full rate this share of the moment is lost.
    share = here.size * here.between(0.15, 0.22)
    coefficient = share * here.torque / (here.rate * math.sqrt(here.torque))
    loss = (lambda thrust, rate: coefficient * math.sqrt(abs(thrust)) * rate,)
    return Physics(losses=loss), {"coefficient": coefficient}


def coupling(here: Setting) -> tuple[Physics, Truth]:
    """A moment in proportion to a channel: roll through a shifted centre of mass, a winch, ballast that flows."""
    time, values = here.course
    spread = float(np.std(values))
    coefficient = here.sign() * here.size * here.torque * here.between(0.05, 0.07) / spread
    # Speeds and rates act from zero on; what lies far from zero acts by its difference from where it began.
    origin = float(values[0]) if abs(np.mean(values)) > 3.0 * spread else 0.0
    follows = (lambda t: np.asarray(coefficient * (np.interp(t, time, values) - origin)),)
    return Physics(outside=follows), {"coefficient": coefficient, "origin": origin}


def modulation(here: Setting) -> tuple[Physics, Truth]:
    """A channel scales the thrust (a battery that sags) or the drag (cold water, depth under the surface)."""
    time, values = here.course
    thrust = here.channel == "voltage" or here.heads()
    # One deviation of the channel changes the thrust, or the drag, by this much.
    strength = here.size * here.between(0.11, 0.16) * (1.0 if here.channel == "voltage" else here.sign())
    coefficient = strength / float(np.std(values))
    origin = float(np.mean(values)) if here.heads() else float(values[0])

    def factor(t: Array) -> Array:
        return np.asarray(1.0 + np.clip(coefficient * (np.interp(t, time, values) - origin), -0.7, 0.7))

    truth: Truth = {"coefficient": coefficient, "origin": origin, "shape": "thrust" if thrust else "drag"}
    return Physics(thrust=(factor,)) if thrust else Physics(drag=(factor,)), truth
