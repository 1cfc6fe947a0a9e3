"""Whether torque and yaw rate of a batch belong together by what is learned: a changed vehicle is told and learned, a
sensor's fault is not, and what may be either waits for the next batch.

The batch is judged with the one before it, by what was learned before that: what is learned follows a fault, and hides
it by that.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from incsvr.checks.causes import DELAY_STEP_S, SENSOR_CAUSES, VEHICLE_CAUSES, Cause, Causes, Window, causes
from incsvr.checks.curve import Curve
from incsvr.checks.power import turned_round, turns
from incsvr.checks.state import State, Vehicle
from incsvr.checks.verdict import CHANGE, Decision, Finding
from incsvr.numerics import Array, root_mean_square
from incsvr.signals.samples import Samples

YOUNG_CURVE_BATCHES = 3
"""Batches of turning after which the curve is known well enough to judge a batch by."""
SURE_ODDS, SUSPECT_ODDS = 12.0, 4.0
"""ln of odds over nothing from which on a cause is believed, and from which on a sensor's fault is suspected, or
believed to last. In 397 of 398 batches without a fault it was at most 0.1."""
LEAD = 8.0
"""ln of odds by which a sensor's fault must lead any change of the vehicle."""
MIN_GYRO_SHIFT_SHARE = 0.08
"""Least shift of the curve along the yaw rate, as a part of the largest: the learned curve itself errs by some."""
MIN_CHANGE = 0.25
"""Change of damping or thrust, as a part, from which on it is told: a hull adds some tenths."""
MAX_LOSS, MAX_GAIN = -0.75, 3.0
"""Changes of the damping, as a part, beyond which it is none: no vehicle loses nearly all of it."""
FOREIGN_NOISES, MIN_LEFT_DAMPING_SHARE = 4.0, 0.15
"""Noise levels, and part of the largest damping, that every cause leaves over where torque and yaw rate do not belong
together."""
MIN_DRAG_NOISES = 3.0
"""The learned damping over a batch, in noise levels, from which on it is its own drag that moves a vehicle."""
MAX_ROTOR_LAG_S = 1.5
"""Longest lag [s] that a rotor may have: a yaw rate that is later may be the thrust's doing."""
USUAL_LAG_PRECISION = 1.0 / 0.15**2
"""Precision of the usual lag [s⁻²] from which on another lag is told from it."""
MIN_LAG_WIDTHS = 2.0
"""Least lag beside the usual one that counts, in widths of the smoothing, within which the filter forgives it; and as
much as the usual one besides. A step between two delays is none either."""
MAX_JOINED_DURATIONS = 2.0
"""Longest pause, in durations of the batch, across which two batches are looked at together."""
UNCLEAR, RESPONSE, UNDRIVEN = "unclear", "response", "driveless"
"""Kinds of findings: the vehicle changed or a sensor failed; torque and yaw rate do not belong together; what turns the
vehicle is not the torque."""
MODEL_KINDS = frozenset({CHANGE, UNCLEAR, RESPONSE, UNDRIVEN})
"""Kinds of what the learned curve does not explain, and no single sensor either."""
CurveOfRates = Callable[[Array], Curve]
"""The learned curve at any yaw rates (n,) [rad/s]."""


@dataclass(frozen=True, slots=True)
class CheckResult:
    """The result of one check: its findings, whether this batch could show its faults, and the causes it weighed."""

    findings: list[Finding]
    conclusive: bool
    causes: Causes | None = None

    @property
    def pauses(self) -> bool:
        return any(finding.decision >= Decision.PAUSE for finding in self.findings)


def respond(
    state: State, vehicle: Vehicle, batch: Samples, learned: CurveOfRates | None, older: CurveOfRates | None
) -> CheckResult:
    """The findings on a batch and the one before it, by what was learned before that."""
    if learned is None or older is None:
        return CheckResult([], state.learned < YOUNG_CURVE_BATCHES)
    joined = batch
    if state.before is not None and 0.0 < batch.time[0] - state.before.time[-1] < MAX_JOINED_DURATIONS * np.ptp(
        batch.time
    ):
        joined = Samples.concatenate((state.before, batch))
    known = older(joined.yaw_rate)
    inside = known.inside & (joined.time >= batch.time[0])
    if (
        not turns(joined.take(inside), vehicle.largest_rate)
        or root_mean_square(known.damping[inside]) < MIN_DRAG_NOISES * known.sigma
    ):
        return CheckResult([], False)  # a controller answers the water, and what it does looks like any cause
    window = Window.of(joined, known, state.lag, state.precision**-0.5, vehicle.largest_rate)
    found = causes(window, known.sigma, known.largest, vehicle.largest_rate)
    if found is None:
        return CheckResult([], False)
    findings = _findings(found, state, vehicle, known, f"from {batch.time[0]:.10g} to {batch.time[-1]:.10g} s")
    # sway answers a step later than yaw, and is in no curve of it
    if turned_round(batch, vehicle.inertia):
        findings = [finding for finding in findings if finding.kind != UNCLEAR]
    could = found.zero < 0.5 * MIN_GYRO_SHIFT_SHARE * vehicle.largest_rate and found.lag[1] < 0.5 * least_lag(
        state, vehicle
    )
    return CheckResult(findings, bool(findings) or could, found)


def least_lag(state: State, vehicle: Vehicle) -> float:
    """The tolerated deviation of the lag between the streams from its usual [s]; a rotor's is unknown at first."""
    usual = abs(state.lag)
    return (
        max(MIN_LAG_WIDTHS * vehicle.smoothing, 1.5 * DELAY_STEP_S) + usual
        if state.precision > USUAL_LAG_PRECISION
        else max(MAX_ROTOR_LAG_S - usual, 0.0)
    )


def _findings(found: Causes, state: State, vehicle: Vehicle, known: Curve, span: str) -> list[Finding]:
    own = found.alike(VEHICLE_CAUSES)
    change, large = found.each[own[0]], max(FOREIGN_NOISES * known.sigma, MIN_LEFT_DAMPING_SHARE * known.largest)
    faults = [name for name in SENSOR_CAUSES if _large(name, found.each[name], state, vehicle)]
    sensor = max(faults, key=lambda name: found.each[name].odds, default=None)
    if sensor is not None and found.each[sensor].odds > (2.0 * SURE_ODDS if _may_answer(known) else SUSPECT_ODDS):
        fault, lasts = found.each[sensor], sensor in state.kinds
        if (lasts or fault.odds > max(SURE_ODDS, change.odds + LEAD)) and fault.left < large:
            return [Finding(sensor, Decision.PAUSE, _SENTENCES[sensor](fault))]
        if fault.odds > change.odds - LEAD:
            return [_unclear(f"{_SENTENCES[sensor](fault)}, or the vehicle changed")]
    if found.least > large:
        return [_foreign(found, span)]
    if change.odds < SURE_ODDS:
        return []
    sentence = _change(own, change, known)
    if sentence is None:
        return []
    gain = _apparent(own[0], change.size)
    if gain is not None and not MAX_LOSS < gain < MAX_GAIN:
        kind = RESPONSE if gain > 0.0 else UNDRIVEN
        return [
            Finding(
                kind,
                Decision.PAUSE,
                f"since {change.since:.10g} s the damping would have changed by {100.0 * gain:+.0f} %, far more than a "
                "vehicle's can: check the {effort}'s sensor, its sign and its unit",
            )
        ]
    if own[0] in ("moment", "one side") and state.kinds != {UNCLEAR}:
        return [_unclear(f"{sentence}, or a sensor failed")]
    return [Finding(CHANGE, Decision.WARN, sentence)]


def _may_answer(known: Curve) -> bool:
    """Whether the water moves a vehicle nearly as much as its torque does: a controller's answer is late, too."""
    return root_mean_square(known.damping) < 2.0 * MIN_DRAG_NOISES * known.sigma


def _large(name: str, cause: Cause, state: State, vehicle: Vehicle) -> bool:
    """Whether a sensor's fault is larger than what is forgiven."""
    if name == "zero":
        return abs(cause.size) > MIN_GYRO_SHIFT_SHARE * vehicle.largest_rate
    return name == "sign" or abs(cause.size) > least_lag(state, vehicle)


def _unclear(sentence: str) -> Finding:
    return Finding(UNCLEAR, Decision.PAUSE, f"{sentence}; the next batch decides")


def _foreign(found: Causes, span: str) -> Finding:
    return Finding(
        RESPONSE,
        Decision.PAUSE,
        f"{{effort}} and {{rate}} contradict each other {span}: the residual is {found.left:.3g} {{effort_unit}}, and "
        "no change of the vehicle explains it; check both sensors and their clocks",
    )


def _apparent(name: str, size: float) -> float | None:
    """Share by which the damping seems to have changed where it, or the thrust, did; None for other causes."""
    if name == "thrust":
        return 1.0 / (1.0 - size) - 1.0 if size < 1.0 else -1.0 - abs(size)
    return size if name == "damping" else None


def _change(names: list[str], cause: Cause, known: Curve) -> str | None:
    """The sentence on a change of the vehicle that is large enough to be reported; its causes are alike."""
    name, size, since = names[0], cause.size, f"{cause.since:.10g} s"
    gain = _apparent(name, size)
    if gain is not None and abs(gain) > MIN_CHANGE:
        lost = 1.0 / (1.0 + gain) - 1.0 if gain > -1.0 else np.inf
        if name == "thrust":
            return f"the thrust changed by {100.0 * lost:+.0f} % at {since}"
        if "thrust" not in names:
            return f"the damping changed by {100.0 * gain:+.0f} % at {since}"
        other = f" (thrust by {100.0 * lost:+.0f} % looks the same)" if gain > -1.0 else ""
        return f"damping or thrust changed by {100.0 * gain:+.0f} % at {since}{other}"
    if name == "moment" and abs(size) > MIN_LEFT_DAMPING_SHARE * known.largest:
        return f"a constant {{moment}} of {size:+.3g} {{effort_unit}} acts since {since}"
    if name == "one side" and abs(size) > MIN_CHANGE:
        return (
            f"damping or thrust changed by {100.0 * size:+.0f} % at positive and {-100.0 * size:+.0f} % at negative "
            f"rates at {since}"
        )
    return None


def _late(cause: Cause) -> str:
    which, other = ("{rate}", "{effort}") if cause.size < 0.0 else ("{effort}", "{rate}")
    late = f"the {which} is {abs(cause.size):.2g} s late against the {other} since {cause.since:.10g} s"
    if -MAX_ROTOR_LAG_S <= cause.size < 0.0:  # as a vehicle does whose thrust follows later
        return f"{late}: the thrust lags or is delayed since then, or a clock jumped; a trace of these data shows which"
    return f"{late}: the clock of one of them jumped or runs at another speed"


def _moved(cause: Cause) -> str:
    return (
        f"the {{rate}} is off by {cause.size:+.2g} {{rate_unit}} since {cause.since:.10g} s: the gyro's zero moved; "
        "calibrate it at rest"
    )


def _turned(cause: Cause) -> str:
    return (
        f"{{effort}} and {{rate}} count in opposite directions since {cause.since:.10g} s; turn the sign of one of them"
    )


_SENTENCES = {"lag": _late, "zero": _moved, "sign": _turned}
