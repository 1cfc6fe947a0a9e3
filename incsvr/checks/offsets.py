"""Whether the torque keeps its place beside the yaw rate throughout a recording, or one of two clocks steps or drifts.

In each stretch of a recording τ(t + δ) is regressed on ṙ, r, r|r| and a constant; the δ that leaves least is how late
the torque's stamps are there. Inertia and damping are free in each stretch, so that neither a wrong inertia nor a new
hull looks like a clock. A delay that stays the same is none either: rotors have one.

In 48 simulated missions, most in closed loop (seeds from 910200 to 910400, 2026-11-26), and on the measured vehicles
nothing was told.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from incsvr.numerics import Array, independent_share
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
    gap = 2.0 * smoothing
    moved = smooth(*rate, at, smoothing=smoothing, gap=gap)
    grid = np.arange(begin, begin + STRETCH_S, DELAY_STEP_S, dtype=np.float64)
    pushed = smooth(*torque, grid, smoothing=smoothing, gap=gap)
    if not pushed.complete.any():
        return None
    place = np.rint((at[:, None] + delays - begin) / DELAY_STEP_S).astype(np.intp).clip(0, grid.size - 1)
    shifted = pushed.value[place]
    known = moved.complete & np.isfinite(shifted).all(axis=1)
    if known.sum() < STRETCH_S / (4.0 * max(smoothing, DELAY_STEP_S)) or np.ptp(shifted[known]) <= 0.0:
        return None
    r, rise, y = moved.value[known], moved.slope[known], shifted[known]
    design = np.column_stack([rise, r, r * np.abs(r), np.ones(r.size)])
    left = y - design @ np.linalg.lstsq(design, y, rcond=None)[0]
    share = np.maximum(np.mean(left**2, axis=0) / np.maximum(np.var(y, axis=0), ROUNDING_SHARE), ROUNDING_SHARE)
    best = int(np.argmin(share))
    if share[best] > 1.0 - MIN_EXPLAINED_SHARE or not 0 < best < delays.size - 1:
        return None
    worth = r.size * independent_share(left[:, best])
    inside = np.flatnonzero(worth * np.log(share / share[best]) < SURE_LOG_LIKELIHOOD)
    least, most = float(delays[inside[0]]), float(delays[inside[-1]])
    if most - least > 2.0 * MAX_DOUBT_S:
        return None
    return Offset(begin, begin + STRETCH_S, float(delays[best]), least, most)
