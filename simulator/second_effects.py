"""A second list of effects, to test the tracer on what it was not fitted to.

Whoever improves a method on one list fits it to that list, too. This one was written apart: most effects have another
shape than in the main list and in the catalogue that looks for them.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from simulator.physics import STEP, Array, MakeStage, Physics, Setting, Stage, Truth, static

MODULATES = {"voltage": "thrust", "temperature": "drag", "depth": "drag"}
"""What a channel scales; every other one the drag."""


def inertia(here: Setting) -> tuple[Physics, Truth]:
    """Payload, flooded tanks, the added mass near a wall: one number in nature, too."""
    factor = 1.0 + here.size * here.sign() * here.between(0.14, 0.25)
    return Physics(inertia=(factor,)), {"inertia_kg_m2": factor * here.inertia}


def drag_drift(here: Setting) -> tuple[Physics, Truth]:
    """Weed catches in clumps: the drag grows by many small steps, of sizes and at times of their own."""
    fraction, clumps = here.size * here.between(0.3, 0.5), int(here.random.integers(8, 15))
    times = here.duration * (np.arange(clumps) + here.random.uniform(0.0, 1.0, clumps)) / clumps
    grown = np.cumsum(here.random.uniform(0.5, 1.5, clumps))
    levels = np.concatenate([[1.0], 1.0 + fraction * grown / grown[-1]])
    return Physics(drag=(lambda t: levels[np.searchsorted(times, t, side="right")],)), {"fraction": fraction}


def drag_step(here: Setting) -> tuple[Physics, Truth]:
    """A fairing comes loose, a load is fastened: it takes some time scales until the drag is another one."""
    fraction = here.size * (here.between(0.28, 0.45) if here.heads() else -here.between(0.22, 0.32))
    at, rise = here.duration * here.between(0.3, 0.7), 0.5 * here.time
    factor = (lambda t: 1.0 + fraction * (0.5 + 0.5 * np.tanh((t - at) / rise)),)
    return Physics(drag=factor), {"fraction": fraction, "at_s": at}


def memory(here: Setting) -> tuple[Physics, Truth]:
    """The boundary layer and, far slower, the water in an open frame turn along, and the hull drags in both."""
    share = here.size * here.between(0.28, 0.42)
    near, far = here.time * here.between(2.0, 3.5), here.time * here.between(7.0, 10.0)
    truth: Truth = {"gain_nm_s": share * here.torque / here.rate, "time_constant_s": 0.7 * near + 0.3 * far}
    return Physics(wakes=((0.7 * share, near), (0.3 * share, far))), truth


def coulomb(here: Setting) -> tuple[Physics, Truth]:
    """A slip ring rubs, and rubs harder while it creeps (Stribeck)."""
    friction = here.size * here.torque * here.between(0.05, 0.085)
    creep, breakaway = 0.015 * here.rate, 0.06 * here.rate

    def rub(r: float, _heading: float) -> float:
        return -friction * math.tanh(r / creep) * (1.0 + 0.25 * math.exp(-((r / breakaway) ** 2)))

    return Physics(moments=(rub,)), {"moment_nm": friction}


def bias_torque(here: Setting) -> tuple[Physics, Truth]:
    """A bent skeg, thrusters out of line: a constant."""
    moment = here.size * here.sign() * here.torque * here.between(0.045, 0.08)
    return Physics(outside=(lambda t: np.full(t.size, moment),)), {"moment_nm": moment}


def bias_drift(here: Setting) -> tuple[Physics, Truth]:
    """Ballast leaks to one side, fast at first: a moment that nears its end like one minus an exponential."""
    end = here.size * here.sign() * here.torque * here.between(0.1, 0.15)
    constant = here.duration * here.between(0.5, 0.9)
    course = (lambda t: end * np.expm1(-t / constant) / math.expm1(-here.duration / constant),)
    return Physics(outside=course), {"nm_per_s": end / here.duration}


def wave(here: Setting) -> tuple[Physics, Truth]:
    """Swell with crests sharper than its troughs, that comes in groups."""
    amplitude, period = here.size * here.torque * here.between(0.055, 0.09), here.time * here.between(4.0, 9.0)
    phase, other = here.between(-math.pi, math.pi), here.between(-math.pi, math.pi)

    def swell(t: Array) -> Array:
        groups = 1.0 + 0.2 * np.sin(2.0 * math.pi * t / (11.0 * period) + other)
        crest = np.exp(0.5 * np.sin(2.0 * math.pi * t / period + phase))
        # Mean of exp(sin/2), and the amplitude of its first harmonic.
        return np.asarray(amplitude * groups * (crest - 1.0635) / 0.5158)

    return Physics(outside=(swell,)), {"amplitude_nm": amplitude, "period_s": period, "phase_rad": phase}


def heading_current(here: Setting) -> tuple[Physics, Truth]:
    """A current turns the hull by its drag (once a turn) and its Munk moment (twice); either may be the stronger."""
    amplitude = here.size * here.torque * here.between(0.065, 0.1)
    phase, other = here.between(-math.pi, math.pi), here.between(-math.pi, math.pi)
    harmonic, weaker = (1 if here.heads() else 2), amplitude * here.between(0.15, 0.3)
    drag = (lambda _r, psi: amplitude * math.sin(harmonic * psi + phase),)
    munk = (lambda _r, psi: weaker * math.sin((3 - harmonic) * psi + other),)
    return Physics(moments=drag + munk), {"amplitude_nm": amplitude, "phase_rad": phase, "harmonic": harmonic}


def tether(here: Setting) -> tuple[Physics, Truth]:
    """A cable, untwisted at the start: with some slack, whose knee is soft, or one that stiffens as it winds up."""
    stiffness = here.size * here.torque * here.between(0.05, 0.085) / here.swing
    slack, loose = here.swing * here.between(0.15, 0.35), here.heads()

    def pull(_r: float, heading: float) -> float:
        twist = heading - here.start
        if loose:
            return -stiffness * math.copysign(math.hypot(twist, slack) - slack, twist)
        return -stiffness * twist * (1.0 + 0.2 * math.tanh((twist / here.swing) ** 2))

    truth: Truth = {"stiffness_nm_per_rad": stiffness, "shape": "slack" if loose else "stiffening"}
    return Physics(moments=(pull,)), truth


def torque_lag(here: Setting) -> tuple[Physics, Truth]:
    """The motor's lag before the propeller's, or a rotor that a given shaft torque drives against its quadratic load.

    The second is slow where it turns slowly: J ṅ = Q − k n|n| has the time constant J/(2 k n). The parameter is the
    mean delay of the first, and the time constant of the second at a quarter of the full thrust, half of its speed.
    """
    constant, loaded = here.size * here.time * here.between(0.15, 0.28), here.heads()
    make = _loaded_rotor(constant, here.torque) if loaded else _two_in_series(constant)
    truth: Truth = {"time_constant_s": constant, "shape": "loaded rotor" if loaded else "two in series"}
    return Physics(stages=(make,)), truth


def _two_in_series(constant: float) -> MakeStage:
    motor_part, propeller_part = -math.expm1(-STEP / (0.4 * constant)), -math.expm1(-STEP / (0.6 * constant))

    def make(moment: float) -> Stage:
        motor = propeller = moment

        def stage(command: float) -> float:
            nonlocal motor, propeller
            motor += motor_part * (command - motor)
            propeller += propeller_part * (motor - propeller)
            return propeller

        return stage

    return make


def _loaded_rotor(constant: float, full: float) -> MakeStage:
    def make(moment: float) -> Stage:
        speed = math.copysign(math.sqrt(abs(moment) / full), moment)

        def stage(command: float) -> float:
            nonlocal speed
            # Implicit in the load, since a fast small rotor at full load would overshoot in an explicit step.
            speed = (speed + STEP / constant * command / full) / (1.0 + STEP / constant * abs(speed))
            return full * speed * abs(speed)

        return stage

    return make


def torque_delay(here: Setting) -> tuple[Physics, Truth]:
    """A shared bus: each command waits for its turn, now shorter, now longer, but none overtakes another."""
    mean = here.size * here.time * here.between(0.12, 0.25)
    seed = int(here.random.integers(2**31))

    def make(moment: float) -> Stage:
        random, waiting = np.random.default_rng(seed), deque[tuple[int, float]]()
        step, last, in_force = 0, moment, moment

        def stage(command: float) -> float:
            nonlocal step, last, in_force
            if command != last:
                due = step + round(mean * random.uniform(0.8, 1.2) / STEP)
                waiting.append((max(due, waiting[-1][0]) if waiting else due, command))
                last = command
            while waiting and waiting[0][0] <= step:
                in_force = waiting.popleft()[1]
            step += 1
            return in_force

        return stage

    return Physics(stages=(make,)), {"delay_s": mean}


def dead_zone(here: Setting) -> tuple[Physics, Truth]:
    """A dead band with soft edges and not quite the same to either side.

    Beyond it what exceeds the band comes out (gear with play), or nearly all of the command (a controller's stiction).
    """
    width, skew = here.size * here.torque * here.between(0.08, 0.13), here.between(-0.12, 0.12)
    play_in_gear = here.heads()

    def band(command: float) -> float:
        edge = width * (1.0 + math.copysign(skew, command))
        if not play_in_gear:
            ratio = (abs(command) / edge) ** 12
            return command * ratio / (1.0 + ratio)
        soft = 0.12 * edge
        if abs(command) > 5.0 * edge:
            return command - math.copysign(edge, command)
        beyond = math.log1p(math.exp((abs(command) - edge) / soft)) - math.log1p(math.exp(-edge / soft))
        return math.copysign(soft * beyond, command)

    truth: Truth = {"half_width_nm": width, "shape": "gear" if play_in_gear else "stiction"}
    return Physics(stages=(static(band),)), truth


def torque_asymmetry(here: Setting) -> tuple[Physics, Truth]:
    """Astern the blades meet the flow with their thin edge and lose more the harder they work; or they were built in
    the other way round, and gain."""
    gained = here.size * here.sign() * here.between(0.2, 0.36)

    def astern(command: float) -> float:
        load = abs(command) / here.torque
        return command if command >= 0.0 else command * (1.0 + gained * 1.3 * load / (load + 0.15))

    return Physics(stages=(static(astern),)), {"reverse_efficiency": 1.0 + gained}


def torque_saturation(here: Setting) -> tuple[Physics, Truth]:
    """Thrust that bends to a limit, a / (1 + (|a|/L)^p)^(1/p): from cavitation (p = 2.5) to a current limit (p = 8)."""
    # The square root, for about half of the thrust is lost to a limit that is that much higher.
    limit, sharpness = here.torque * here.between(0.5, 0.65) / math.sqrt(here.size), here.between(2.5, 8.0)
    bend = static(lambda command: command / math.pow(1.0 + math.pow(abs(command) / limit, sharpness), 1.0 / sharpness))
    return Physics(stages=(bend,)), {"limit_nm": limit, "shape": f"sharpness {sharpness:.1f}"}


def inflow(here: Setting) -> tuple[Physics, Truth]:
    """The propeller runs into water that the turn brings: K_T falls with the advance ratio J ~ r/n, and a little faster
    than in proportion where the turn goes the way of the thrust."""
    share = here.size * here.between(0.2, 0.32)

    def loss(thrust: float, r: float) -> float:
        advance = r / here.rate
        return share * math.sqrt(abs(thrust) * here.torque) * advance * (1.0 + math.copysign(0.25, thrust) * advance)

    return Physics(losses=(loss,)), {"coefficient": share * math.sqrt(here.torque) / here.rate}


def coupling(here: Setting) -> tuple[Physics, Truth]:
    """A moment that follows a channel, and a little more than in proportion where the channel is large.

    What passes through zero acts from there; what never does, from its usual value.
    """
    time, values = here.course
    spread = float(np.std(values))
    origin = float(np.median(values)) if abs(np.mean(values)) > 2.0 * spread else 0.0
    coefficient = here.size * here.sign() * here.torque * here.between(0.06, 0.09) / spread

    def moment(t: Array) -> Array:
        away = np.interp(t, time, values) - origin
        return np.asarray(coefficient * away * (0.85 + 0.15 * np.abs(away) / spread))

    return Physics(outside=(moment,)), {"coefficient": coefficient, "origin": origin}


def modulation(here: Setting) -> tuple[Physics, Truth]:
    """A power of the channel scales thrust or drag: the one by which a deviation of the channel makes 12 to 20 %.

    At the channel's mean nothing is scaled.
    """
    time, values = here.course
    mean, spread = float(np.mean(values)), float(np.std(values))
    what = MODULATES.get(here.channel, "drag")
    share = here.size * here.between(0.12, 0.2) * (here.sign() if what == "drag" else 1.0)

    def factor(t: Array) -> Array:
        return np.asarray(np.clip(np.interp(t, time, values) / mean, 0.05, None) ** (share * mean / spread))

    truth: Truth = {"coefficient": share / spread, "reference": mean, "shape": what}
    return Physics(thrust=(factor,)) if what == "thrust" else Physics(drag=(factor,)), truth
