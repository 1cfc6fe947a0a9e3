"""Moments that act besides thrusters and drag."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from simulator.trial_effects.physics import Circumstances, Moment, Physics, Truth


def with_moment(physics: Physics, moment: Moment) -> Physics:
    """A moment more acts besides."""
    return replace(physics, moments=(*physics.moments, moment))


def bias_torque(physics: Physics, here: Circumstances) -> tuple[Physics, Truth]:
    """A bent fin or a badly trimmed thruster: a constant moment."""
    constant = here.sign() * here.size * here.scale.torque * here.random.uniform(0.04, 0.07)
    return with_moment(physics, lambda _rate, _heading, _tick: constant), {"moment_nm": constant}


def bias_drift(physics: Physics, here: Circumstances) -> tuple[Physics, Truth]:
    """A constant moment grows slowly from nothing, evenly in time."""
    end = here.sign() * here.size * here.scale.torque * here.random.uniform(0.09, 0.13)
    slope = end / float(here.time[-1])
    table = (slope * here.time).tolist()
    return with_moment(physics, lambda _rate, _heading, tick: table[tick]), {"nm_per_s": slope}


def heading_current(physics: Physics, here: Circumstances) -> tuple[Physics, Truth]:
    """A steady current turns the hull: once a turn (weathercock) or twice (the Munk moment)."""
    amplitude = here.size * here.scale.torque * here.random.uniform(0.06, 0.08)
    phase = here.random.uniform(-math.pi, math.pi)
    harmonic = 1 if here.random.random() < 0.5 else 2

    def current(_rate: float, heading: float, _tick: int) -> float:
        return amplitude * math.sin(harmonic * heading + phase)

    return with_moment(physics, current), {"amplitude_nm": amplitude, "phase_rad": phase, "harmonic": harmonic}


def tether(physics: Physics, here: Circumstances) -> tuple[Physics, Truth]:
    """A cable winds up with the turned angle."""
    scale = here.scale
    stiffness = here.size * here.random.uniform(0.007, 0.010) * scale.torque / (scale.rate * scale.time)

    def twist(_rate: float, heading: float, _tick: int) -> float:
        return -stiffness * heading

    return with_moment(physics, twist), {"stiffness_nm_per_rad": stiffness}


def wave(physics: Physics, here: Circumstances) -> tuple[Physics, Truth]:
    """Swell rocks the hull: a periodic moment, with a little of the second harmonic as Stokes waves have it."""
    scale = here.scale
    amplitude = here.size * scale.torque * here.random.uniform(0.055, 0.075)
    period = scale.time * here.random.uniform(5.0, 11.0)
    phase = here.random.uniform(-math.pi, math.pi)
    steepness = here.random.uniform(0.0, 0.15)
    angle = 2 * math.pi * here.time / period + phase
    table = (amplitude * (np.sin(angle) + steepness * np.sin(2 * angle))).tolist()
    truth: Truth = {"amplitude_nm": amplitude, "period_s": period, "phase_rad": phase}
    return with_moment(physics, lambda _rate, _heading, tick: table[tick]), truth


def coulomb(physics: Physics, here: Circumstances) -> tuple[Physics, Truth]:
    """A slip ring or a seal rubs: a moment against the sense of turning, however slow (regularised by tanh)."""
    friction = here.size * here.scale.torque * here.random.uniform(0.05, 0.07)
    creep = 0.02 * here.scale.rate

    def rub(rate: float, _heading: float, _tick: int) -> float:
        return -friction * math.tanh(rate / creep)

    return with_moment(physics, rub), {"moment_nm": friction}
