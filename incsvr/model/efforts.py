"""What an actuator applies in each step of a simulation: exact means of the effort's own samples.

Between its samples an effort is constant as a command is, runs on lines, or is a smooth curve; its integral is exact.
Static stages act on the samples, a shift in time on the curve, a lag on the steps' means.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from incsvr.numerics import Array, Stream, integral_at
from incsvr.numerics.linear_filter import lfilter

WAYS = ("linear", "hold", "smooth")
"""How an effort gets from one of its samples to the next."""


@dataclass(frozen=True, slots=True)
class Stage:
    """What the actuators make of a demanded effort, before it acts; a number that is None changes nothing.

    Attributes:
        exponent: τ → τ₀ (τ/τ₀)ᵖ, τ₀ being `top`, the effort at which the curve gives what is demanded.
        dead: half width of the dead band [effort].
        limit: saturation: the largest effort that acts [effort].
        reverse: thrust astern as a share of the thrust ahead at the same demand.
        shift: dead time [s]; negative where the effort's stamps are late.
        lag: time constant of the actuators [s].
        blur: width over which the samples are averaged [s], because a measured effort has noise that never acts.
    """

    exponent: float | None = None
    dead: float | None = None
    limit: float | None = None
    reverse: float | None = None
    shift: float = 0.0
    lag: float | None = None
    blur: float | None = None

    def static(self, effort: Array, top: float) -> Array:
        """(n,) the samples after the static stages."""
        u = effort
        if self.exponent is not None:
            u = top * np.sign(u) * np.abs(u / top) ** self.exponent
        if self.dead is not None:
            u = u - np.clip(u, -abs(self.dead), abs(self.dead))
        if self.limit is not None:
            u = np.clip(u, -self.limit, self.limit)
        if self.reverse is not None:
            u = np.where(u < 0.0, self.reverse * u, u)
        return u


def means(stream: Stream, edges: Array, way: str, stage: Stage, top: float) -> Array:
    """(steps,) the mean effort between the edges [s], which are evenly spaced, after its stages."""
    t, u = stream
    step = float(edges[1] - edges[0])
    if stage.blur is not None:  # before all other stages: the noise of a sensor passes no actuator
        raw, half = _integral(t, u, "linear"), 0.5 * stage.blur
        u = (raw(t + half) - raw(t - half)) / stage.blur
    mean = np.asarray(np.diff(_integral(t, stage.static(u, top), way)(edges - stage.shift)) / step)
    if stage.lag is None or stage.lag <= 0.0:
        return mean
    share = step / stage.lag
    before = lagged(mean, share)
    return np.asarray(mean + (before - mean) * (-np.expm1(-share) / share))


def lagged(value: Array, share: float) -> Array:
    """(n,) the state of a first-order lag before each step, at rest on the first value; `share` is step / constant."""
    kept = float(np.exp(-share))
    return np.asarray(lfilter([0.0, 1.0 - kept], [1.0, -kept], value - value[0]) + value[0])


def _integral(t: Array, u: Array, way: str) -> Callable[[Array], Array]:
    """The integral of the effort from its first stamp on; before its first and after its last sample it is constant."""
    curve = PchipInterpolator(t, u).antiderivative() if way == "smooth" and t.size > 3 else None

    def whole(at: Array) -> Array:
        inside = np.clip(at, t[0], t[-1])
        beyond = at - inside
        sums = integral_at(t, u, inside, way == "hold") if curve is None else curve(inside)
        return np.asarray(sums + beyond * np.where(at < t[0], u[0], u[-1]))

    return whole
