"""Effects between the commanded and the produced moment: rotors, gear, flow past the thrusters."""

from __future__ import annotations

import math
from dataclasses import replace

from simulator.trial_effects.physics import Circumstances, Physics, ThrustMap, Truth


def with_dead_zone(physics: Physics, half: float) -> Physics:
    """Commands up to `half` [N m] give nothing; beyond, the moment starts at zero."""

    def offset(moment: float, _rate: float, _tick: int) -> float:
        return math.copysign(max(abs(moment) - half, 0.0), moment)

    return _commanded(physics, offset)


def with_weak_reverse(physics: Physics, efficiency: float) -> Physics:
    """A propeller gives so much astern of what it gives ahead."""

    def astern(moment: float, _rate: float, _tick: int) -> float:
        return moment * efficiency if moment < 0 else moment

    return _commanded(physics, astern)


def with_limit(physics: Physics, limit: float) -> Physics:
    """No moment is larger [N m]."""

    def cut(moment: float, _rate: float, _tick: int) -> float:
        return min(max(moment, -limit), limit)

    return _commanded(physics, cut)


def _commanded(physics: Physics, change: ThrustMap) -> Physics:
    return replace(physics, commanded=(*physics.commanded, change))


def torque_lag(physics: Physics, here: Circumstances) -> tuple[Physics, Truth]:
    """Rotors follow their set point: T ṅ = n₀ − n with the moment n|n|, quadratic in the speed, or T τ̇ = τ₀ − τ."""
    time = here.size * here.scale.time * here.random.uniform(0.6, 0.95)
    speed = bool(here.random.random() < 0.5)
    shape = "rotor speed" if speed else "moment"
    return replace(physics, rotor_time=time, rotor_speed=speed), {"time_constant_s": time, "shape": shape}


def torque_delay(physics: Physics, here: Circumstances) -> tuple[Physics, Truth]:
    """The command takes its time on the way to the thrusters."""
    delay = here.size * here.scale.time * here.random.uniform(0.4, 0.7)
    return replace(physics, delay=delay), {"delay_s": delay}


def dead_zone(physics: Physics, here: Circumstances) -> tuple[Physics, Truth]:
    """Small commands turn no rotor; beyond, the moment either starts at zero or jumps to its full value."""
    half = here.size * here.scale.torque * here.random.uniform(0.07, 0.09)
    jump = bool(here.random.random() < 0.3)

    def gate(moment: float, _rate: float, _tick: int) -> float:
        return moment if abs(moment) > half else 0.0

    truth: Truth = {"half_width_nm": half, "shape": "jump" if jump else "offset"}
    return (_commanded(physics, gate) if jump else with_dead_zone(physics, half)), truth


def torque_asymmetry(physics: Physics, here: Circumstances) -> tuple[Physics, Truth]:
    """A propeller gives less astern than ahead."""
    efficiency = 1.0 - here.size * here.random.uniform(0.13, 0.19)
    return with_weak_reverse(physics, efficiency), {"reverse_efficiency": efficiency}


def torque_saturation(physics: Physics, here: Circumstances) -> tuple[Physics, Truth]:
    """High commands fall short: a current limit that cuts, or a supply that bends the curve, u/(1 + |u/L|⁴)^¼."""
    if here.size == 0:
        return physics, {"limit_nm": math.inf, "shape": "none"}
    hard = bool(here.random.random() < 0.5)
    # Half the size: half as much of the full torque is lost.
    lost = here.random.uniform(0.28, 0.36) * here.size
    limit = here.scale.torque * (1.0 - lost)
    # The smooth curve loses its first tenth long before L, so its L lies higher for the same loss at full torque.
    corner = here.scale.torque / ((1.0 - lost) ** -4 - 1.0) ** 0.25

    def bend(moment: float, _rate: float, _tick: int) -> float:
        ratio = moment / corner
        return moment / math.sqrt(math.sqrt(1.0 + ratio * ratio * ratio * ratio))

    truth: Truth = {"limit_nm": limit if hard else corner, "shape": "cut" if hard else "bend"}
    return (with_limit(physics, limit) if hard else _commanded(physics, bend)), truth


def inflow(physics: Physics, here: Circumstances) -> tuple[Physics, Truth]:
    """Water meets the propeller at the vehicle's own speed: n|n| loses |n| u_a (Fossen: advance number), n = √|τ|."""
    scale = here.scale
    # At full torque and full rate this share of the moment is lost.
    share = here.size * here.random.uniform(0.15, 0.22)
    coefficient = share * scale.torque / (scale.rate * math.sqrt(scale.torque))

    def loss(moment: float, rate: float, _tick: int) -> float:
        return moment - coefficient * math.sqrt(abs(moment)) * rate

    return replace(physics, produced=(*physics.produced, loss)), {"coefficient": coefficient}
