"""What an actuator applies in each step of a simulation: exact means of the effort's own samples.

Between its samples an effort is constant as a command is, runs on lines, or is a smooth curve; its integral is exact.
Static stages act on the samples, a shift in time on the curve, a lag on the steps' means.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from incsvr.numerics import Array, Stream, integral_at
from incsvr.numerics.lapack import dtbtrs

WAYS = ("linear", "hold", "smooth")
"""How an effort gets from one of its samples to the next."""
GAP_EDGE = 0.25
"""Part of a gap's half width over which its thrust sets in: commands that hold fall on few values, and within so much
there is one that tells a fit in which direction the gap is wider."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage:
    """What the actuators make of a demanded effort, before it acts; a number that is None changes nothing.

    Attributes:
        exponent: τ → τ₀ (τ/τ₀)ᵖ, τ₀ being `top`, the effort at which the curve gives what is demanded.
        dead: half width of the dead band, beyond which the thrust begins at nothing [effort].
        gap: half width of a dead band beyond which all of the demanded effort acts [effort].
        limit: saturation: the largest effort that acts [effort].
        sag: saturation that sets in by and by: the effort to which the one that acts bends [effort].
        reverse: thrust astern as a share of the thrust ahead at the same demand.
        shift: dead time [s]; negative where the effort's stamps are late.
        spin: time constant of rotors whose speed lags and whose thrust goes with its square [s].
        lag: time constant of actuators whose thrust lags [s].
    """

    exponent: float | None = None
    dead: float | None = None
    gap: float | None = None
    limit: float | None = None
    sag: float | None = None
    reverse: float | None = None
    shift: float = 0.0
    spin: float | None = None
    lag: float | None = None

    def static(self, effort: Array, top: float) -> Array:
        """(n,) the samples after the static stages."""
        u = effort
        if self.exponent is not None:
            u = top * np.sign(u) * np.abs(u / top) ** self.exponent
        if self.dead is not None:
            u = u - np.clip(u, -abs(self.dead), abs(self.dead))
        if self.gap is not None:
            u = u * np.clip((np.abs(u) / self.gap - 1.0) / GAP_EDGE + 0.5, 0.0, 1.0)
        if self.limit is not None:
            u = np.clip(u, -self.limit, self.limit)
        if self.sag is not None:
            u = u / np.cbrt(1.0 + np.abs(u / self.sag) ** 3)
        if self.reverse is not None:
            u = np.where(u < 0.0, self.reverse * u, u)
        return u

    def undone(self, effort: Array, top: float) -> Array:
        """(n,) the samples of which the static stages make these; beyond the limit, those of the limit."""
        u = effort
        if self.reverse is not None:
            u = np.where(u < 0.0, u / self.reverse, u)
        if self.sag is not None:
            u = np.clip(u, -0.99 * self.sag, 0.99 * self.sag)
            u = u / np.cbrt(1.0 - np.abs(u / self.sag) ** 3)
        if self.limit is not None:
            u = np.clip(u, -self.limit, self.limit)
        if self.gap is not None:
            u = np.where(
                np.abs(u) < 0.5 * self.gap, 0.0, np.sign(u) * np.maximum(np.abs(u), (1.0 + 0.5 * GAP_EDGE) * self.gap)
            )
        if self.dead is not None:
            u = u + np.sign(u) * abs(self.dead)
        if self.exponent is not None:
            u = top * np.sign(u) * np.abs(u / top) ** (1.0 / self.exponent)
        return u


def means(stream: Stream, edges: Array, way: str, stage: Stage, top: float) -> Array:
    """(steps,) the mean effort between the edges [s], which are evenly spaced, after its stages."""
    t, u = stream
    step = float(edges[1] - edges[0])
    mean = np.asarray(np.diff(_integral(t, stage.static(u, top), way)(edges - stage.shift)) / step)
    if stage.spin is not None and stage.spin > 0.0:
        speed = _late(root(mean), step / stage.spin)
        mean = speed * np.abs(speed)
    return mean if stage.lag is None or stage.lag <= 0.0 else _late(mean, step / stage.lag)


def _late(mean: Array, share: float) -> Array:
    """(n,) means over steps of a first-order lag's state, at rest on the first value; `share` is step / constant."""
    before = lagged(mean, share)
    return np.asarray(mean + (before - mean) * (-np.expm1(-share) / share))


def root(effort: Array) -> Array:
    """A rotor's speed, in the root of its thrust's unit."""
    return np.asarray(np.sign(effort) * np.sqrt(np.abs(effort)))


def lagged(value: Array, share: float) -> Array:
    """(n,) the state of a first-order lag before each step, at rest on the first value; `share` is step / constant."""
    kept = float(np.exp(-share))
    band = np.repeat([[1.0], [-kept]], value.size, axis=1)
    return np.asarray(dtbtrs(band, np.r_[value[0], (1.0 - kept) * value[:-1]][:, None], uplo="L")[0][:, 0])


def _integral(t: Array, u: Array, way: str) -> Callable[[Array], Array]:
    """The integral of the effort from its first stamp on; before its first and after its last sample it is constant."""
    curve = _smooth(t, u) if way == "smooth" and t.size > 3 else None

    def whole(at: Array) -> Array:
        inside = np.clip(at, t[0], t[-1])
        beyond = at - inside
        sums = integral_at(t, u, inside, way == "hold") if curve is None else curve(inside)
        return np.asarray(sums + beyond * np.where(at < t[0], u[0], u[-1]))

    return whole


def _smooth(t: Array, u: Array) -> Callable[[Array], Array]:
    """The integral of the curve of cubics that overshoots no sample (F. N. Fritsch & J. Butland, SIAM J. Sci. Stat.
    Comput. 5, 1984), from its first stamp on, at instants between its first and its last."""
    width = np.diff(t)
    rise = np.diff(u) / width
    before, after = 2.0 * width[1:] + width[:-1], width[1:] + 2.0 * width[:-1]
    turns = rise[:-1] * rise[1:] <= 0.0
    mean = before / np.where(turns, 1.0, rise[:-1]) + after / np.where(turns, 1.0, rise[1:])
    inside = np.where(turns, 0.0, (before + after) / np.where(turns, 1.0, mean))
    slope = np.r_[_at_end(width[:2], rise[:2]), inside, _at_end(width[:-3:-1], rise[:-3:-1])]
    second = (3.0 * rise - 2.0 * slope[:-1] - slope[1:]) / width
    third = (slope[:-1] + slope[1:] - 2.0 * rise) / width**2
    parts = np.stack([u[:-1], slope[:-1] / 2.0, second / 3.0, third / 4.0])
    sums = np.r_[0.0, np.cumsum(width * (parts[0] + width * (parts[1] + width * (parts[2] + width * parts[3]))))]

    def whole(at: Array) -> Array:
        k = np.clip(np.searchsorted(t, at, side="right") - 1, 0, t.size - 2)
        x, (a, b, c, d) = at - t[k], parts[:, k]
        return np.asarray(sums[k] + x * (a + x * (b + x * (c + x * d))))

    return whole


def _at_end(width: Array, rise: Array) -> float:
    """The slope at an end from the two widths and rises next to it, with three points, and within the first rise's."""
    slope = ((2.0 * width[0] + width[1]) * rise[0] - width[0] * rise[1]) / (width[0] + width[1])
    if slope * rise[0] <= 0.0:
        return 0.0
    return float(3.0 * rise[0]) if rise[0] * rise[1] < 0.0 and abs(slope) > 3.0 * abs(rise[0]) else float(slope)
