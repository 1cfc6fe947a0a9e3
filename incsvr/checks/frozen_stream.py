"""A stream that stands still within a few steps of its own resolution while the other says that it cannot.

A vehicle at rest may show one value for long, and so may a command. A yaw rate is stuck only where the torque meanwhile
would have turned the vehicle; a torque, where the learned drag leaves of it what should have turned it, and did not.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from incsvr.checks.curve import Curve
from incsvr.checks.verdict import Decision, Finding
from incsvr.numerics import Array, root_mean_square
from incsvr.signals.raw import HIGH, LOW, STEP, TORQUE, named
from incsvr.signals.samples import Samples

STILL_STEPS = 3.0
"""Steps of its resolution within which a stream stands still: the last bit, and the one beside it, may toggle."""
MAX_STILL_REACH_SHARE = 0.005
"""Part of how far a stream usually reaches that those steps are at most: a command of few levels has large ones."""
QUIET_SCATTER_SHARE = 0.05
"""Part of the scatter that a stream usually shows within a window below which it stands still, too: noise does not
cease by itself."""
MIN_STILL_SAMPLES = 6
"""Samples in a row of which a stream is stuck: with fewer a slow turn may well agree."""
UNDAMPED_TURN_FACTOR = 10.0
"""Factor by which the torque, undamped, would have turned the yaw rate further: damping takes most of it away."""
MIN_SWEPT_RANGE_SHARE = 0.05
"""Part of the yaw rate's range that is swept meanwhile: noise sweeps less."""
UNEXPLAINED_NOISES = 3.0
"""Noise levels of what drag leaves of a torque that should have turned the vehicle."""
UNEXPLAINED_DAMPING_SHARE = 0.15
"""Part of the largest damping that it is at least: swell moves a vehicle whose torque rests at zero."""
MIN_ANSWERED_SHARE = 0.2
"""Part of it by which it turns the vehicle at least: a ship whose sway takes most of her rudder's moment by 0.27."""
MAX_ANSWERED_VARIATION = 0.5
"""Part of the variation of what drag leaves of a torque by which that turns the vehicle at least; a wrong curve hardly
changes it."""
CERTAIN_DEVIATIONS = 2.0
"""Standard deviations by which that is less."""
STREAM_WORDS = {"yaw_rate": "{rate}", "torque": "{effort}"}
"""Words of messages for the streams: templates of `AxisWords`, as sentences of findings are."""
STREAM_UNITS = {"yaw_rate": "{rate_unit}", "torque": "{effort_unit}"}
"""Units of the streams."""


@dataclass(frozen=True, slots=True)
class Stretch:
    """Samples `first` to `last`, both included, during which a stream stood still."""

    first: int
    last: int

    @property
    def slice(self) -> slice:
        return slice(self.first, self.last + 1)


def stuck(
    batch: Samples,
    inertia: float,
    range_width: float,
    usual: Mapping[str, float],
    reach: Mapping[str, float],
    curve: Curve | None,
) -> tuple[list[Finding], bool]:
    """The streams that were constant in a batch, and whether both moved at all.

    Args:
        batch: with what its raw streams showed.
        inertia: as declared [kg m²].
        range_width: of the vehicle's yaw rates [rad/s].
        usual: how much each stream scatters within a window when it is sound, in its unit.
        reach: how far it usually reaches, in its unit; nothing before a batch was learned.
        curve: what is learned, where anything is.
    """
    found, moved = [], True
    first = {"yaw_rate": range_width, "torque": 0.0}
    for name, proves in (("yaw_rate", _turned), ("torque", _moved)):
        low, high = batch.raw[named(name, LOW)], batch.raw[named(name, HIGH)]
        steps = min(STILL_STEPS * _resolution(batch, name), MAX_STILL_REACH_SHARE * reach.get(name, first[name]))
        limit = max(steps, QUIET_SCATTER_SHARE * usual.get(name, 0.0))
        moved &= float(high.max() - low.min()) > limit
        for stretch in _stretches(low, high, limit):
            if proves(batch, stretch, limit, inertia, range_width, curve):
                found.append(_finding(batch, name, stretch))
                break
    return found, moved


def _resolution(batch: Samples, name: str) -> float:
    """The smallest step of a stream within the batch, in its unit; 0 where it never moved."""
    steps = batch.raw[named(name, STEP)]
    steps = steps[np.isfinite(steps)]
    return float(steps.min()) if steps.size else 0.0


def _stretches(low: Array, high: Array, limit: float) -> list[Stretch]:
    """Stretches of MIN_STILL_SAMPLES samples and more within whose windows a stream keeps within `limit`, as long as
    can be."""
    found: list[Stretch] = []
    for first in range(low.size - MIN_STILL_SAMPLES + 1):
        if high[first] - low[first] > limit or (found and first <= found[-1].last):
            continue
        within = np.maximum.accumulate(high[first:]) - np.minimum.accumulate(low[first:]) <= limit
        count = int(np.argmin(within)) if not within.all() else within.size
        if count >= MIN_STILL_SAMPLES:
            found.append(Stretch(first, first + count - 1))
    return found


def _turned(
    batch: Samples, stretch: Stretch, limit: float, inertia: float, range_width: float, curve: Curve | None
) -> bool:
    """Whether the torque would have turned the vehicle while its yaw rate stood still."""
    torque, time = batch.raw[TORQUE][stretch.slice], batch.time[stretch.slice]
    pushed = np.cumsum((torque - torque.mean())[:-1] * np.diff(time)) / inertia
    # the torque's own noise turns nothing that could be seen
    floor = max(limit, 1e-3 * range_width)
    return bool(np.ptp(pushed) > UNDAMPED_TURN_FACTOR * floor)


def _moved(
    batch: Samples, stretch: Stretch, limit: float, inertia: float, range_width: float, curve: Curve | None
) -> bool:
    """Whether the vehicle moved while its torque stood still as no constant torque moves it: what the learned drag
    leaves of that torque varied, and did not turn it. A vehicle answers a step, however it turned before."""
    if curve is None or np.ptp(batch.yaw_rate[stretch.slice]) < MIN_SWEPT_RANGE_SHARE * range_width:
        return False
    torque, kept = batch.raw[TORQUE][stretch.slice], curve.inside[stretch.slice]
    left, turned = (torque - curve.damping[stretch.slice])[kept], (torque - batch.damping[stretch.slice])[kept]
    least = max(UNEXPLAINED_NOISES * curve.sigma, UNEXPLAINED_DAMPING_SHARE * curve.largest)
    if left.size < MIN_STILL_SAMPLES or root_mean_square(left) < least:
        return False
    # a curve that errs where the torque rests leaves a constant
    about = left - left.mean()
    power = float(about @ about)
    if not power > 0.0:
        return False
    answered = float(about @ turned) / power + CERTAIN_DEVIATIONS * curve.sigma / float(np.sqrt(power))
    return answered < MAX_ANSWERED_VARIATION and float(left @ turned) < MIN_ANSWERED_SHARE * float(left @ left)


def _finding(batch: Samples, name: str, stretch: Stretch) -> Finding:
    low, high = batch.raw[named(name, LOW)], batch.raw[named(name, HIGH)]
    level = 0.5 * float(low[stretch.slice].min() + high[stretch.slice].max())
    since, until = batch.time[stretch.first], batch.time[stretch.last]
    other = "the {effort} varies" if name == "yaw_rate" else "the vehicle {turns} as no constant {effort} {drives} it"
    where = f"is constant at {level:.4g} {STREAM_UNITS[name]} from {since:.10g} to {until:.10g} s while {other}"
    end = 0.01 * float(np.ptp((low.min(), high.max())))
    at_end = end > 0.0 and min(level - low.min(), high.max() - level) < end
    cure = "it is stuck, or clipped at the end of its range; check the sensor" if at_end else "check the sensor"
    return Finding(f"{name} stuck", Decision.PAUSE, f"the {STREAM_WORDS[name]} {where}; {cure}")
