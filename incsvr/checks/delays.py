"""How late the torque comes beside the yaw rate: in each minute of a recording, and before its sign is blamed.

τ(t + δ) is regressed on ṙ, r, r|r| and a constant; the δ that leaves least is how late the torque's stamps are.
Inertia and damping are free, so that neither a wrong inertia nor a new hull looks like a clock. Where clocks step or
drift, the delay of a recording's stretches differs; a delay that stays the same is a rotor's. And a torque that acts
late seems to count against the yaw rate: where a vehicle turns against it at its own stamps, and follows it at some
delay far better than it ever turns against it, the sign is right.

In 48 simulated missions, most in closed loop (seeds from 910200 to 910400, 2026-11-26), and on the measured vehicles
nothing was told.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from incsvr.numerics import Array, independent_share
from incsvr.signals.raw import TORQUE
from incsvr.signals.samples import Samples
from incsvr.signals.smoothing import smooth

STRETCH_S = 60.0
"""Length of a stretch of a recording [s]: a dozen commands, which tell a delay to some hundredths of a second."""
MAX_DELAY_S = 4.0
"""Longest delay that is tried, to both sides [s]; beyond, the streams do not belong together."""
DELAY_STEP_S = 0.05
"""Step between two delays that are tried [s]."""
MIN_CLOCK_STEP_S = 0.25
"""Difference of two delays from which on it is a clock's [s]: rotors follow a small command later than a large one by
up to a fifth of a second, and two quartz clocks part by a tenth in a quarter of an hour."""
SURE_LOG_LIKELIHOOD = 9.0
"""Twice the log-likelihood by which a delay must be worse to be out of the question: three standard deviations."""
MAX_DOUBT_S = 0.5
"""Delays to both sides that are in question in a stretch which tells anything, at most [s]."""
MIN_STRETCHES = 2
"""Stretches that must tell the same on either side of a step."""
ROUNDING_SHARE = 1e-12
"""Share of the torque that rounding leaves of noise-free data."""
MIN_EXPLAINED_SHARE = 0.5
"""Share of the torque that the motion must explain in a stretch for its delay to be believed."""


MIN_SAMPLES = 10
"""Samples from which a regression says anything."""
SIGN_DELAYS_S: Array = DELAY_STEP_S * np.arange(21.0, dtype=np.float64)
"""Delays by which a torque that acts late is told from one of the wrong sign [s]: rotors, links and clocks make some
tenths; a longer one is half a turn of many vehicles, whose sign no delay tells."""
MIN_WRONG_SHARE = 0.3
"""Part of the torque that the wrong sign must explain against the yaw rate before the sign is looked at."""
MIN_BETTER_SHARE = 0.05
"""Part of the torque by which the right sign must explain more than the wrong one at any shorter delay: of one sine
both explain nearly the same."""


@dataclass(frozen=True, slots=True)
class Offset:
    """The delay of the torque in a stretch, with the possible range from `least` to `most`, all in [s]."""

    begin: float
    end: float
    late: float
    least: float
    most: float


def offsets(rate: tuple[Array, Array], torque: tuple[Array, Array], smoothing: float) -> list[Offset]:
    """The delay of the torque in each stretch that shows it.

    Args:
        rate: stamps (n,) [s] and yaw rates [rad/s].
        torque: stamps (m,) [s] and torques [N m].
        smoothing: standard deviation of the filter of both [s].
    """
    if not rate[0].size or not torque[0].size:
        return []
    begin, end = max(rate[0][0], torque[0][0]), min(rate[0][-1], torque[0][-1])
    count = int((end - begin) // STRETCH_S)
    found = (_of_stretch(rate, torque, begin + k * STRETCH_S, smoothing) for k in range(count))
    return [each for each in found if each is not None]


def unsteady(found: list[Offset]) -> str | None:
    """A sentence where one clock steps, or runs at another speed, beside the other; None where neither explains all.

    A step needs MIN_STRETCHES stretches on both sides, another speed twice as many: where a controller closes the
    loop, a stretch may show the controller's delay instead of the vehicle's. A clock that walks is told by its pace
    (checks).
    """
    if len(found) < 2 * MIN_STRETCHES:
        return None
    late, early = max(found, key=lambda each: each.late), min(found, key=lambda each: each.late)
    if late.late - early.late < MIN_CLOCK_STEP_S or late.least <= early.most:
        return None
    middle = np.array([0.5 * (each.begin + each.end) for each in found])
    offset = np.array([each.late for each in found])
    line = np.polyval(np.polyfit(middle, offset, 1), middle)
    steps = [
        np.where(np.arange(offset.size) < k, offset[:k].mean(), offset[k:].mean())
        for k in range(MIN_STRETCHES, offset.size - MIN_STRETCHES + 1)
    ]
    step = min(steps, key=lambda levels: float(np.sum((offset - levels) ** 2)))
    nearer = min((line, step), key=lambda levels: float(np.sum((offset - levels) ** 2)))
    if any(
        not each.least - DELAY_STEP_S <= at <= each.most + DELAY_STEP_S
        for each, at in zip(found, nearer.tolist(), strict=True)
    ):
        return None
    if nearer is line:
        slope = 1e3 * float(line[-1] - line[0]) / float(middle[-1] - middle[0])
        how = f"the clock of one stream runs at another speed, {abs(slope):.2g} ms a second"
    else:
        k = int(np.flatnonzero(np.diff(step))[0])
        how = f"the clock of one stream steps between {found[k].begin:.4g} and {found[k + 1].end:.4g} s"
    return (
        f"{how}: the torque is {late.late - early.late:.2g} s later relative to the yaw rate from {late.begin:.4g} to "
        f"{late.end:.4g} s than from {early.begin:.4g} to {early.end:.4g} s; stamp both with one clock"
    )


def _of_stretch(
    rate: tuple[Array, Array], torque: tuple[Array, Array], begin: float, smoothing: float
) -> Offset | None:
    delays = np.arange(-MAX_DELAY_S, MAX_DELAY_S + 0.5 * DELAY_STEP_S, DELAY_STEP_S, dtype=np.float64)
    at = np.arange(begin + MAX_DELAY_S, begin + STRETCH_S - MAX_DELAY_S, max(smoothing, DELAY_STEP_S), dtype=np.float64)
    moved = smooth(*rate, at, smoothing=smoothing, gap=2.0 * smoothing)
    found = delay(moved.slope, moved.value, _shifted(torque, at, delays, smoothing))
    if found is None or found.left.shape[0] < STRETCH_S / (4.0 * max(smoothing, DELAY_STEP_S)):
        return None
    share = np.maximum(found.share, ROUNDING_SHARE)
    best = int(np.argmin(share))
    if share[best] > 1.0 - MIN_EXPLAINED_SHARE or not 0 < best < delays.size - 1:
        return None
    worth = found.left.shape[0] * independent_share(found.left[:, best])
    inside = np.flatnonzero(worth * np.log(share / share[best]) < SURE_LOG_LIKELIHOOD)
    least, most = float(delays[inside[0]]), float(delays[inside[-1]])
    if most - least > 2.0 * MAX_DOUBT_S:
        return None
    return Offset(begin, begin + STRETCH_S, float(delays[best]), least, most)


@dataclass(frozen=True, slots=True)
class Delays:
    """What the motion explains of a torque at k delays.

    Attributes:
        left: (n, k) what is left of the torque [N m].
        share: (k,) of the torque's variance.
        side: (k,) 1 where inertia and drag both count along the torque, −1 where against, 0 where they are at odds.
    """

    left: Array
    share: Array
    side: Array


def delay(slope: Array, rate: Array, efforts: Array) -> Delays | None:
    """The regression of a torque, at each of k delays, on the motion; None where they say nothing.

    Args:
        slope, rate: (n,) ṙ [rad/s²] and r [rad/s], NaN where they are not known.
        efforts: (n, k) the torque at each delay [N m], likewise.
    """
    known = np.isfinite(slope) & np.isfinite(rate) & np.isfinite(efforts).all(axis=1)
    slope, rate, efforts = slope[known], rate[known], efforts[known]
    if rate.size < MIN_SAMPLES or np.ptp(efforts) <= 0.0:
        return None
    design = np.column_stack([slope, rate, rate * np.abs(rate), np.ones(rate.size)])
    theta = np.linalg.lstsq(design, efforts, rcond=None)[0]
    left = efforts - design @ theta
    about = np.maximum(np.var(efforts, axis=0), 1e-300)
    drag = np.sign((rate @ rate) * theta[1] + float(np.sum(rate**2 * np.abs(rate))) * theta[2])
    side = np.where(drag == np.sign(theta[0]), drag, 0.0)
    return Delays(left, np.mean(left**2, axis=0) / about, side)


def _shifted(torque: tuple[Array, Array], at: Array, delays: Array, smoothing: float) -> Array:
    """(n, k) the filtered torque [N m] at (n,) instants, each of (k,) delays later [s]; NaN where it is not known."""
    step = DELAY_STEP_S
    grid = np.arange(at[0] + delays[0], at[-1] + delays[-1] + step, step)
    pushed: Array = smooth(*torque, grid, smoothing=smoothing, gap=2.0 * smoothing).value
    return np.asarray(pushed[np.rint((at[:, None] + delays - grid[0]) / step).astype(np.intp).clip(0, grid.size - 1)])


@dataclass(frozen=True, slots=True)
class TorqueSign:
    """The sign of a torque relative to a yaw rate, over delays.

    Attributes:
        opposes: part of the torque that acceleration and rate explain with both against it, at no or a shorter delay.
        follows: part that they explain with both along it, at the best delay.
        delay: that one [s].
    """

    opposes: float
    follows: float
    delay: float

    @property
    def late(self) -> bool:
        """Whether the torque is late and its sign right."""
        return self.follows >= self.opposes + MIN_BETTER_SHARE

    @property
    def may_be_late(self) -> bool:
        """Whether it is late where its sign is right."""
        return self.follows >= MIN_WRONG_SHARE


def torque_sign(samples: Samples, inertia: float, torque: tuple[Array, Array], smoothing: float) -> TorqueSign | None:
    """The sign of the torque, if the vehicle seems to turn against it; else None.

    Args:
        samples: n of them, made with this inertia [kg m²].
        torque: stamps (m,) [s] and values [N m].
        smoothing: standard deviation of its filter [s].
    """
    slope = (samples.raw[TORQUE] - samples.damping) / inertia
    found = delay(slope, samples.yaw_rate, _shifted(torque, samples.time, -SIGN_DELAYS_S[::-1], smoothing)[:, ::-1])
    if found is None:
        return None
    along = found.side * (1.0 - found.share)
    with_it, against = np.maximum(along, 0.0), np.maximum(-along, 0.0)
    best = int(np.argmax(with_it))
    until = best + 1 if with_it[best] > 0.0 else along.size
    opposes = float(np.max(against[:until]))
    if opposes < MIN_WRONG_SHARE or with_it[0] > 0.0:
        return None
    return TorqueSign(opposes, float(with_it[best]), float(SIGN_DELAYS_S[best]))
