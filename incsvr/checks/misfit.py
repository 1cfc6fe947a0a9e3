"""The decision by the curve's residual: a changed vehicle is reported and learned, a sensor's fault is not."""

from __future__ import annotations

from dataclasses import dataclass

from incsvr.checks.response import SENSOR_CAUSES, VEHICLE_CAUSES, Causes, Estimate, Residual, onset_time
from incsvr.checks.verdict import CHANGE, Decision, Finding

CAUSE_SIGMAS = 6.0
"""Standard deviations from which on a cause is believed: with five causes and two windows each batch, once in years."""
LAG_SIGMAS = 5.0
"""Standard deviations from which on a lag alone is believed: in 48 hours without a fault the largest was 4.3."""
CURVE_ERROR_FACTOR = 2.0
"""Factor by which a cause is larger than what an error of the learned curve may feign."""
LASTING_SIGMAS = 2.0
"""Standard deviations from which on a cause is believed to last."""
FAULT_LEAD = 15.0
"""Variances by which a sensor's fault must explain more than any change of the vehicle; twice the ln of the odds."""
TIE = 2.0
"""Variances within which a vehicle's change explains as much: at one rate, all causes look the same."""
CALM_FIRST_HALF_SHARE = 0.5
"""The part of what is left over in the second half of a batch that the first may have where something began between:
half of its own samples may be at fault already. A curve that errs, or an inertia declared wrong, errs in both."""
MIN_GYRO_SHIFT_SHARE = 0.08
"""Least shift of the curve along the yaw rate, as a part of the largest: the learned curve itself errs by some."""
MIN_DAMPING_CHANGE = 0.25
"""Change of the damping, as a part of it, from which on it is told as one: a hull adds some tenths."""
DRIVELESS_CHANGE = -0.75
"""Change of the damping below which what is recorded is not what turns the vehicle: it would have lost nearly all its
drag."""
BOUNDLESS_CHANGE = 3.0
"""Change of the damping above which the same is true of the yaw rate, or the thrust is all but gone."""
FOREIGN_NOISES = 4.0
"""Noise levels that the best cause leaves over where torque and yaw rate do not belong together."""
MAX_CHANGE_NOISES = 2.0
"""Noise levels that a change of the vehicle leaves over at most, where it is told as one."""
MIN_LEFT_DAMPING_SHARE = 0.15
"""Part of the largest damping that a fault leaves over at least: a rough sea stays below."""

MAX_ROTOR_LAG_S = 1.5
"""Longest lag [s] that a rotor may have: a yaw rate that is later may be the thrust's doing."""

UNCLEAR, RESPONSE, UNDRIVEN = "unclear", "response", "driveless"
"""Kinds of findings: the vehicle changed or a sensor failed; torque and yaw rate do not belong together; what turns the
vehicle is not the torque."""
MODEL_KINDS = frozenset({CHANGE, UNCLEAR, RESPONSE, UNDRIVEN})
"""Kinds of what the learned curve does not explain, and no single sensor either."""
FEIGNED_CHANGES = ("moment", "one side")
"""Changes of a vehicle that a lag or a gyro's zero looks like for half a turn to and fro: no single batch tells
them."""


@dataclass(frozen=True, slots=True)
class Scales:
    """Sizes that residuals are compared with.

    Attributes:
        largest_rate, largest_damping: that were learned or configured [rad/s], [N m].
        sigma: noise level of a sample [N m].
        least_lag: how much later or earlier than usual one stream may come than the other [s].
    """

    largest_rate: float
    largest_damping: float
    sigma: float
    least_lag: float


def misfit(
    seen: Residual, found: Causes, scales: Scales, suspected: frozenset[str], joint: bool = False
) -> list[Finding]:
    """Findings on what is left over.

    Args:
        suspected: the kinds that learning is paused for.
        joint: these are the samples of two batches that both seem to be at fault.
    """
    best = found.best
    estimate = found.each[best]
    span = f"from {seen.time[0]:.10g} to {seen.time[-1]:.10g} s"
    sensors = [cause for cause in SENSOR_CAUSES if _large(cause, found.each[cause], scales, cause in suspected)]
    if best in sensors and (best in suspected or found.lead(best) > TIE or not _unremarkable(found)):
        failed = _SENTENCES[best](estimate.size, onset_time(seen, best, estimate.size))
        if best in suspected or found.lead(best) > FAULT_LEAD:
            return [Finding(best, Decision.PAUSE, failed)]
        return [_unclear(f"{failed}, or the vehicle changed")]
    if estimate.unexplained > max(FOREIGN_NOISES * scales.sigma, MIN_LEFT_DAMPING_SHARE * scales.largest_damping):
        return [_foreign(found, span)]
    if estimate.certainty < CAUSE_SIGMAS:
        large = found.left > max(FOREIGN_NOISES * scales.sigma, MIN_LEFT_DAMPING_SHARE * scales.largest_damping)
        left = (
            f"the residual of the learned curve is {found.left:.3g} {{effort_unit}} {span}: the vehicle changed or a "
            "sensor failed"
        )
        return [_unclear(left)] if large else []
    since = onset_time(seen, best, estimate.size)
    sentence = _change(best, estimate.size, since, scales)
    if sentence is None:
        return []
    gain = _apparent(best, estimate.size)
    if gain is not None and not DRIVELESS_CHANGE < gain < BOUNDLESS_CHANGE:
        return [
            Finding(
                RESPONSE if gain > 0.0 else UNDRIVEN,
                Decision.PAUSE,
                f"since {since:.10g} s the damping would have changed by {100.0 * gain:+.0f} %, far more than a "
                "vehicle's can: check the {effort}'s sensor, its sign and its unit",
            )
        ]
    if any(found.lead(cause) > -FAULT_LEAD for cause in sensors):
        return [_unclear(f"{sentence}, or {' or '.join(_DOUBTS[cause] for cause in sensors)}")]
    if estimate.unexplained > MAX_CHANGE_NOISES * scales.sigma:
        return [_foreign(found, span)]
    if best in FEIGNED_CHANGES and not joint:
        return [_unclear(f"{sentence}, or a sensor failed")]
    return [Finding(CHANGE, Decision.WARN, sentence)]


def late_since_then(seen: Residual, found: Causes, scales: Scales, until_then: float) -> list[Finding]:
    """Findings on the second half of a batch: whether the streams came apart within the batch.

    Args:
        until_then: robust deviation of what the curve leaves over in its first half [N m].
    """
    lag = found.each["lag"]
    if (
        not _large("lag", lag, scales, lasts=False)
        or found.lead("lag") < 0.0
        or until_then > CALM_FIRST_HALF_SHARE * found.left
    ):
        return []
    sentence = _late(lag.size, onset_time(seen, "lag", lag.size))
    if found.best == "lag" and found.lead("lag") > FAULT_LEAD:
        return [Finding("lag", Decision.PAUSE, sentence)]
    return [_unclear(f"{sentence}, or the vehicle changed")]


def _unremarkable(found: Causes) -> bool:
    """Whether a change of the damping or the thrust too small to be told explains most of a vehicle's own causes."""
    best = min(VEHICLE_CAUSES, key=lambda cause: found.each[cause].cost)
    gains = [_apparent(cause, found.each[cause].size) for cause in ("gain", "thrust")]
    even = any(found.each[cause].cost < found.each[best].cost + TIE for cause in ("gain", "thrust"))
    return even and all(gain is not None and abs(gain) < MIN_DAMPING_CHANGE for gain in gains)


def _large(cause: str, estimate: Estimate, scales: Scales, lasts: bool) -> bool:
    """Whether a sensor's fault is larger than what is forgiven, and certain."""
    least, certain = {
        "zero": (MIN_GYRO_SHIFT_SHARE * scales.largest_rate, CAUSE_SIGMAS),
        "lag": (scales.least_lag, LAG_SIGMAS),
    }[cause]
    least = max(least, CURVE_ERROR_FACTOR * estimate.bias)
    return abs(estimate.size) > least and estimate.certainty > (LASTING_SIGMAS if lasts else certain)


def _unclear(sentence: str) -> Finding:
    return Finding(UNCLEAR, Decision.PAUSE, f"{sentence}; the next batch decides")


def _foreign(found: Causes, span: str) -> Finding:
    return Finding(
        RESPONSE,
        Decision.PAUSE,
        f"{{effort}} and {{rate}} contradict each other {span}: the residual is {found.left:.3g} {{effort_unit}}, and "
        "no change of the vehicle explains it; check both sensors and their clocks",
    )


def could_tell(found: Causes, scales: Scales) -> bool:
    """Whether the samples would have shown a shift or a lag, had there been one."""
    return (
        found.each["zero"].resolved < 0.5 * MIN_GYRO_SHIFT_SHARE * scales.largest_rate
        and found.each["lag"].resolved < 0.5 * scales.least_lag
    )


def _apparent(cause: str, size: float) -> float | None:
    """Share by which the damping seems to have changed where it, or the thrust, did; None for other causes."""
    if cause == "thrust":
        return 1.0 / (1.0 - size) - 1.0 if size < 1.0 else -1.0 - abs(size)
    return size if cause == "gain" else None


def _change(cause: str, size: float, since: float, scales: Scales) -> str | None:
    """The sentence on a change of the vehicle that is large enough to be reported."""
    gain = _apparent(cause, size)
    if gain is not None and abs(gain) > MIN_DAMPING_CHANGE:
        other = f" (thrust by {100.0 * (1.0 / (1.0 + gain) - 1.0):+.0f} % looks the same)" if gain > -1.0 else ""
        return f"damping or thrust changed by {100.0 * gain:+.0f} % at {since:.10g} s{other}"
    if cause == "moment" and abs(size) > MIN_LEFT_DAMPING_SHARE * scales.largest_damping:
        return f"a constant {{moment}} of {size:+.3g} {{effort_unit}} acts since {since:.10g} s"
    if cause == "one side" and abs(size) > MIN_DAMPING_CHANGE:
        return (
            f"damping or thrust changed by {100.0 * size:+.0f} % at positive and {-100.0 * size:+.0f} % at negative "
            f"rates at {since:.10g} s"
        )
    return None


def _late(size: float, since: float) -> str:
    which, other = ("{rate}", "{effort}") if size < 0.0 else ("{effort}", "{rate}")
    late = f"the {which} is {abs(size):.2g} s late against the {other} since {since:.10g} s"
    if -MAX_ROTOR_LAG_S <= size < 0.0:  # as a vehicle does whose thrust follows later
        return f"{late}: the thrust lags or is delayed since then, or a clock jumped; a trace of these data shows which"
    return f"{late}: the clock of one of them jumped or runs at another speed"


def _moved(size: float, since: float) -> str:
    return (
        f"the {{rate}} is off by {size:+.2g} {{rate_unit}} since {since:.10g} s: the gyro's zero moved; calibrate it "
        "at rest"
    )


_DOUBTS = {"lag": "the streams' clocks are apart", "zero": "the gyro's zero moved"}
_SENTENCES = {"lag": _late, "zero": _moved}
