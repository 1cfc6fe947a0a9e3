"""Whether torque and yaw rate of a batch belong together by what is learned of the damping, looked at in windows.

A fault that begins within a batch is wrong throughout in the second half of it; what is learned follows a fault and
hides it by that, so that a batch is judged by what was learned before the last one as well; and two batches, one after
the other, tell what one alone does not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from incsvr.checks.curve import Curve
from incsvr.checks.misfit import MAX_ROTOR_LAG_S, UNCLEAR, Scales, could_tell, late_since_then, misfit
from incsvr.checks.onset import onset
from incsvr.checks.power import turned_round, turns
from incsvr.checks.response import Estimate, Residual, causes
from incsvr.checks.state import State, Vehicle
from incsvr.checks.verdict import Decision, Finding
from incsvr.numerics import Array, root_mean_square
from incsvr.signals.samples import Samples

YOUNG_CURVE_BATCHES = 3
"""Batches of turning after which the curve is known well enough to judge a batch by."""
MIN_DRAG_NOISES = 2.0
"""The learned damping over a batch, in noise levels, from which on it is its own drag that moves a vehicle."""
USUAL_LAG_PRECISION = 1.0 / 0.15**2
"""Precision of the usual lag [s⁻²] from which on another lag is told from it."""
MIN_LAG_WIDTHS = 2.0
"""Least lag beside the usual one that counts, in widths of the smoothing, within which the filter forgives it; and as
much as the usual one besides."""
JOINT_WINDOW_INDEX = 3
"""Place, among the windows that a batch is looked at in, of the one with the batch before."""
MAX_JOINED_DURATIONS = 2.0
"""Longest pause, in durations of the batch, across which two batches are looked at together."""
CurveOfRates = Callable[[Array], Curve]
"""The learned curve at any yaw rates (n,) [rad/s]."""


@dataclass(frozen=True, slots=True)
class CheckResult:
    """The result of one check: its findings, whether this batch could show its faults, and the lag of the streams."""

    findings: list[Finding]
    conclusive: bool
    lag: Estimate | None = None

    @property
    def pauses(self) -> bool:
        return any(finding.decision >= Decision.PAUSE for finding in self.findings)


def respond(
    state: State, vehicle: Vehicle, batch: Samples, learned: CurveOfRates | None, older: CurveOfRates | None
) -> CheckResult:
    """The agreement of the batch and of its second half with what is learned, then of the batch with what was learned
    before the last one, then of both together: the half that is wrong throughout tells what begins within a batch."""
    if learned is None or older is None:
        return CheckResult([], state.learned < YOUNG_CURVE_BATCHES)
    half = batch.take(slice(len(batch) // 2, None))
    windows = [(batch, learned), (half, learned), (batch, older)]
    if state.before is not None and 0.0 < batch.time[0] - state.before.time[-1] < MAX_JOINED_DURATIONS * np.ptp(
        batch.time
    ):
        windows.append((Samples.concatenate((state.before, batch)), older))
    could, seen_first, lag = False, list[Finding](), None
    for place, (samples, function) in enumerate(windows):
        known = function(samples.yaw_rate)
        seen = Residual.of(samples, known, state.lag)
        if (
            not turns(samples.take(known.inside), vehicle.largest_rate)
            or root_mean_square(seen.damping) < MIN_DRAG_NOISES * known.sigma
        ):
            continue  # a controller answers the water, and what it does looks like any cause
        found = causes(seen, known.sigma)
        if found is None:
            continue
        lag = found.each["lag"] if place == 0 else lag
        scales = Scales(vehicle.largest_rate, known.largest, known.sigma, least_lag(state, vehicle))
        joint = place == JOINT_WINDOW_INDEX and state.kinds == {UNCLEAR}
        if samples is half:
            first = batch.take(slice(0, len(batch) // 2))
            until_then = Residual.of(first, function(first.yaw_rate), state.lag).deviation
            findings = late_since_then(seen, found, scales, until_then)
        else:
            findings = misfit(seen, found, scales, state.kinds, joint)
            if place == 0 and not findings and state.paused_since is None:
                findings = onset(seen, scales)
        # sway answers a step later than yaw, and is in no curve of it
        if turned_round(samples, vehicle.inertia):
            findings = [finding for finding in findings if finding.kind != UNCLEAR]
        unclear = any(finding.kind == UNCLEAR for finding in findings)
        # what is unclear by one window another may tell
        if findings and (not seen_first or (not unclear and (joint or findings[0].decision == Decision.PAUSE))):
            seen_first = findings
        if seen_first and seen_first[0].kind != UNCLEAR:
            break
        could |= samples is not half and could_tell(found, scales)
    return CheckResult(seen_first, bool(seen_first) or could, lag)


def least_lag(state: State, vehicle: Vehicle) -> float:
    """The tolerated deviation of the lag between the streams from its usual [s]; a rotor's is unknown at first."""
    usual = abs(state.lag)
    return (
        MIN_LAG_WIDTHS * vehicle.smoothing + usual
        if state.precision > USUAL_LAG_PRECISION
        else max(MAX_ROTOR_LAG_S - usual, 0.0)
    )
