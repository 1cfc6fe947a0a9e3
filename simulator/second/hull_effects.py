"""Effects of the hull and of the water around it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from simulator.second.plant import Array, Parameters, Plant, Setting


def inertia(plant: Plant, here: Setting) -> tuple[Plant, Parameters]:
    """Payload, flooded tanks, the added mass near a wall: one number in nature, too."""
    true = plant.inertia * (1.0 + here.size * here.either_sign(here.between(0.14, 0.25)))
    return replace(plant, inertia=true), {"inertia_kg_m2": true}


def drag_drift(plant: Plant, here: Setting) -> tuple[Plant, Parameters]:
    """Weed catches in clumps: the drag grows by many small steps, of sizes and at times of their own."""
    fraction = here.size * here.between(0.3, 0.5)
    clumps = int(here.random.integers(8, 15))
    times = here.time[-1] * (np.arange(clumps) + here.random.uniform(0.0, 1.0, clumps)) / clumps
    sizes = here.random.uniform(0.5, 1.5, clumps)
    sizes *= fraction / sizes.sum()
    grown = np.sum(np.where(here.time[:, None] >= times, sizes, 0.0), axis=1)
    return replace(plant, drag_factor=plant.drag_factor * (1.0 + grown)), {"fraction": fraction}


def drag_step(plant: Plant, here: Setting) -> tuple[Plant, Parameters]:
    """A fairing comes loose, a load is taken up: it takes some time scales until the drag is another one."""
    fraction = here.size * (here.between(0.28, 0.45) if here.heads() else -here.between(0.22, 0.32))
    at = float(here.time[-1]) * here.between(0.3, 0.7)
    rise = 0.5 * here.time_scale
    done = 0.5 + 0.5 * np.tanh((here.time - at) / rise)
    return replace(plant, drag_factor=plant.drag_factor * (1.0 + fraction * done)), {"fraction": fraction, "at_s": at}


def memory(plant: Plant, here: Setting) -> tuple[Plant, Parameters]:
    """The boundary layer and, far slower, the water in an open frame turn along, and the hull drags in both."""
    share = here.size * here.between(0.28, 0.42)
    near, far = here.time_scale * here.between(2.0, 3.5), here.time_scale * here.between(7.0, 10.0)
    gain = share * here.full_torque / here.full_rate
    wakes = (*plant.wakes, (0.7 * share, near), (0.3 * share, far))
    parameters: Parameters = {"gain_nm_s": gain, "time_constant_s": 0.7 * near + 0.3 * far}
    return replace(plant, wakes=wakes), parameters


def coulomb(plant: Plant, here: Setting) -> tuple[Plant, Parameters]:
    """A slip ring rubs, and rubs harder while it creeps (Stribeck)."""
    friction = here.size * here.full_torque * here.between(0.05, 0.085)
    creep, breakaway = 0.015 * here.full_rate, 0.06 * here.full_rate

    def rub(r: float, _heading: float) -> float:
        return -friction * math.tanh(r / creep) * (1.0 + 0.25 * math.exp(-((r / breakaway) ** 2)))

    return replace(plant, moments=(*plant.moments, rub)), {"moment_nm": friction}


def bias_torque(plant: Plant, here: Setting) -> tuple[Plant, Parameters]:
    """A bent skeg, thrusters out of line: a constant."""
    moment = here.size * here.either_sign(here.full_torque * here.between(0.045, 0.08))
    return _pushed(plant, np.full(here.time.size, moment)), {"moment_nm": moment}


def bias_drift(plant: Plant, here: Setting) -> tuple[Plant, Parameters]:
    """Ballast leaks to one side, fast at first: a moment that nears its end like one minus an exponential."""
    end = here.size * here.either_sign(here.full_torque * here.between(0.1, 0.15))
    duration = float(here.time[-1])
    constant = duration * here.between(0.5, 0.9)
    course = np.expm1(-here.time / constant) / math.expm1(-duration / constant)
    return _pushed(plant, end * course), {"nm_per_s": end / duration}


def wave(plant: Plant, here: Setting) -> tuple[Plant, Parameters]:
    """Swell with crests sharper than its troughs, that comes in groups."""
    amplitude = here.size * here.full_torque * here.between(0.055, 0.09)
    period = here.time_scale * here.between(4.0, 9.0)
    phase = here.between(-math.pi, math.pi)
    groups = 1.0 + 0.2 * np.sin(2.0 * math.pi * here.time / (11.0 * period) + here.between(-math.pi, math.pi))
    sine = np.sin(2.0 * math.pi * here.time / period + phase)
    crest = np.exp(0.5 * sine)
    sharp = (crest - 1.0635) / 0.5158  # mean of exp(sin/2), and its first harmonic's amplitude
    parameters: Parameters = {"amplitude_nm": amplitude, "period_s": period, "phase_rad": phase}
    return _pushed(plant, amplitude * groups * sharp), parameters


def heading_current(plant: Plant, here: Setting) -> tuple[Plant, Parameters]:
    """A current turns the hull by its drag (once a turn) and its Munk moment (twice); either may be the stronger."""
    amplitude = here.size * here.full_torque * here.between(0.065, 0.1)
    phase, other_phase = here.between(-math.pi, math.pi), here.between(-math.pi, math.pi)
    harmonic = 1 if here.heads() else 2
    weaker = amplitude * here.between(0.15, 0.3)

    def turning(_r: float, heading: float) -> float:
        return amplitude * math.sin(harmonic * heading + phase) + weaker * math.sin(
            (3 - harmonic) * heading + other_phase
        )

    parameters: Parameters = {"amplitude_nm": amplitude, "phase_rad": phase, "harmonic": float(harmonic)}
    return replace(plant, moments=(*plant.moments, turning)), parameters


def tether(plant: Plant, here: Setting) -> tuple[Plant, Parameters]:
    """A cable, untwisted at the start: with some slack, whose knee is soft, or one that stiffens as it winds up."""
    moment = here.size * here.full_torque * here.between(0.05, 0.085)
    stiffness = moment / here.swing
    slack = here.swing * here.between(0.15, 0.35)
    slack_cable = here.heads()

    def slack_then_taut(_r: float, heading: float) -> float:
        twist = heading - here.start
        return -stiffness * math.copysign(math.hypot(twist, slack) - slack, twist)

    def stiffening(_r: float, heading: float) -> float:
        twist = heading - here.start
        return -stiffness * twist * (1.0 + 0.2 * math.tanh((twist / here.swing) ** 2))

    parameters: Parameters = {"stiffness_nm_per_rad": stiffness, "shape": "slack" if slack_cable else "stiffening"}
    return replace(plant, moments=(*plant.moments, slack_then_taut if slack_cable else stiffening)), parameters


def _pushed(plant: Plant, moment: Array) -> Plant:
    return replace(plant, outside=plant.outside + moment)
