"""The catalogue of effects: what a yaw model may lack, one physical effect a file."""

from __future__ import annotations

from collections.abc import Iterable

from incsvr.effects.bias_drift import BiasDrift
from incsvr.effects.bias_torque import BiasTorque
from incsvr.effects.coriolis import Coriolis
from incsvr.effects.coulomb import Coulomb
from incsvr.effects.coulomb_asymmetry import CoulombAsymmetry
from incsvr.effects.coupling import Coupling
from incsvr.effects.cross_flow import CrossFlow
from incsvr.effects.dead_zone import DeadZone
from incsvr.effects.drag_drift import DragDrift
from incsvr.effects.drag_step import DragStep
from incsvr.effects.effect import Effect, Term
from incsvr.effects.gyro_bias import GyroBias
from incsvr.effects.heading_current import HeadingCurrent
from incsvr.effects.inertia import Inertia
from incsvr.effects.inflow import Inflow
from incsvr.effects.memory import Memory
from incsvr.effects.modulation import DampingModulation, ThrustModulation
from incsvr.effects.signals import Signals
from incsvr.effects.smooth_term import SmoothTerm
from incsvr.effects.tether import Tether
from incsvr.effects.thrust_change import ThrustDrift, ThrustStep
from incsvr.effects.thrust_curve import ThrustCurve
from incsvr.effects.thrust_speed import ThrustSpeed
from incsvr.effects.torque_asymmetry import TorqueAsymmetry
from incsvr.effects.torque_delay import TorqueDelay
from incsvr.effects.torque_lag import TorqueLag
from incsvr.effects.torque_saturation import Saturation, SoftSaturation
from incsvr.effects.wave import Wave
from incsvr.plant.axes import VELOCITIES, YAW, of_rate, products

__all__ = ["Effect", "Signals", "SmoothTerm", "Term", "candidates", "catalogue"]

SPEED_CHANNEL = "surge"
"""The channel in which the speed past propellers and rudders stands."""


def candidates(channels: Iterable[str] = (), rate: str = YAW.rate, one_clock: bool = True) -> tuple[Effect, ...]:
    """Every effect that may be named of the axis with this `rate`, with a coupling and the modulations of each of the
    `channels`, and the products of the velocities among them; what changes in time, only on `one_clock`.

    Example:
        >>> sorted({effect.name for effect in candidates(["winch"])} - {effect.name for effect in candidates()})
        ['coupling:winch', 'modulation:winch']
    """
    channels = tuple(channels)
    fixed: list[Effect] = [
        BiasTorque(), Inertia(), TorqueLag("moment"), TorqueLag("rotor speed"),
        TorqueDelay(), DeadZone("shifted"), DeadZone("step"), TorqueAsymmetry(),
        Saturation("limit"), Saturation("rounded corner"), Saturation("smooth limit"), SoftSaturation(), Inflow(""),
        Inflow("loaded"), HeadingCurrent(1), HeadingCurrent(2), Tether(""), Tether("slack"), Wave(), DragDrift(),
        DragStep(), Memory("linear"), Memory("co-rotating"), Coulomb(""), Coulomb("sharp"), BiasDrift(),
        ThrustStep(), ThrustDrift(), ThrustCurve(), GyroBias(), CoulombAsymmetry("sharp"),
    ]  # fmt: skip
    for channel in channels:
        fixed += [Coupling(channel), DampingModulation(channel)]
        if channel == SPEED_CHANNEL:  # of thrust and speed more is known than that one scales the other
            fixed += [ThrustSpeed(channel, "falls"), ThrustSpeed(channel, "square")]
        else:
            fixed.append(ThrustModulation(channel))
        if channel in VELOCITIES and channel != rate:
            fixed.append(CrossFlow(channel))
    if rate != YAW.rate:  # what looks at the heading does so of yaw alone
        fixed = [effect for effect in fixed if effect.name not in ("heading_current", "tether")]
    for pair in products(of_rate(rate), channels):
        fixed.append(Coriolis(*pair, own=rate if rate in pair else ""))
    return tuple(effect for effect in fixed if one_clock or not effect.needs_clock)


def catalogue(channels: Iterable[str] = ()) -> dict[str, Effect]:
    """All effects by key, with the smooth terms that are never named as effects.

    A channel may also be a product of two, a*b, on any axis.
    """
    names = list(channels)
    smooth = [SmoothTerm(name) for name in (*names, "time", "heading")]
    pairs = [pair for pair in (name.split("*") for name in names) if len(pair) == 2]
    moved = [Coriolis(first, second, own) for first, second in pairs for own in ("", first, second)]
    flows = [CrossFlow(name) for name in names]
    speeds = (ThrustSpeed(SPEED_CHANNEL, "falls"), ThrustSpeed(SPEED_CHANNEL, "square"))
    return {effect.key: effect for effect in (*candidates(names), *flows, *speeds, *smooth, *moved)}
