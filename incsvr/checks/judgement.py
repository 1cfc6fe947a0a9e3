"""All checks of one batch, the surest causes first, and the decision that follows.

    state, verdict = check(state, vehicle, batch, learned, older)

A value in, a value out: no clock, no randomness, and as much memory as a batch takes. Learning pauses with the first
batch of which a finding asks for it. It resumes with the batch after the first that each check which paused it could
judge and found clean: a check that cannot tell (a sign on a straight leg) ends no pause.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from incsvr.checks.agreement import (
    MAX_ROTOR_LAG_S,
    RESPONSE,
    UNCLEAR,
    YOUNG_CURVE_BATCHES,
    CheckResult,
    CurveOfRates,
    least_lag,
    respond,
)
from incsvr.checks.causes import TRIMMED_DEVIATIONS, Causes
from incsvr.checks.clock import paces, period
from incsvr.checks.curve import Curve
from incsvr.checks.frozen_stream import STREAM_WORDS, stuck
from incsvr.checks.heading import against_heading
from incsvr.checks.outliers import outliers
from incsvr.checks.power import MIN_TURNING_RATE_SHARE, drives, turns
from incsvr.checks.state import PRIOR_LAG_PRECISION, State, Vehicle
from incsvr.checks.torque_without_turn import unmoved
from incsvr.checks.unit import unit
from incsvr.checks.verdict import CHANGE, CHANGE_MEMORY_S, Decision, Finding, Verdict
from incsvr.numerics import Array, robust_deviation
from incsvr.signals.raw import HEADING, HIGH, LOW, TORQUE, named
from incsvr.signals.samples import Samples

RETAINED_SHARE = 0.9
"""The part of what is known of usual figures that a batch leaves: they stand for about ten batches."""
MAX_BATCH_PRECISION = 1.0 / 0.1**2
"""Precision [s⁻²] that one batch may give a lag at most: a rotor that follows its command slowly is no delay that is
always the same."""
RELEARN_BATCHES = 4
"""Batches of turning, one after the other, that fit each other and not what is learned: then that is what is wrong."""
DRIFTED_LAGS = 2.0
"""Lags that count by which the streams should have drifted apart before a pace is a new one, and no clock's."""
DRIFTED_DEVIATIONS = 6.0
"""Deviations of what a batch resolves by which they should have drifted apart besides."""
MAX_SEEN_DRIFT_SHARE = 0.25
"""Share of that drift which the streams are seen apart by at most where the pace is a new one."""


AGREEING_NOISES = 1.5
"""Noise levels that samples which follow one curve are from it."""


def check(
    state: State, vehicle: Vehicle, batch: Samples, learned: CurveOfRates | None, older: CurveOfRates | None = None
) -> tuple[State, Verdict]:
    """Judges a batch before it is learned.

    Args:
        batch: n ≥ 1 samples with what their raw streams showed (`Samples.raw`).
        learned: the curve that is learned, at any rates; None before anything is.
        older: the same from before the last batch: a curve follows what is wrong, and hides it by that.
    """
    state, verdict = _judged(state, vehicle, batch, learned, older)
    return state, verdict.in_words(vehicle.words)


def _judged(
    state: State, vehicle: Vehicle, batch: Samples, learned: CurveOfRates | None, older: CurveOfRates | None
) -> tuple[State, Verdict]:
    """The state after a batch and the verdict on it, whose sentences are templates."""
    learned_until_now = learned
    learned, older = _trusted(state, vehicle, learned), _trusted(state, vehicle, older)
    known = None if learned is None else learned(batch.yaw_rate)
    saw = {
        "stuck": _stuck(state, vehicle, batch, known),
        "outliers": CheckResult(outliers(batch), True),
        "sign": _sign(vehicle, batch),
        "unmoved": CheckResult(_unmoved(vehicle, batch, learned_until_now), True),
        "unit": _unit(state, vehicle, batch, known),
        "heading": CheckResult(against_heading(batch, vehicle.largest_rate), HEADING in batch.raw),
        "response": respond(state, vehicle, batch, learned, older or learned),
    }
    saw["pace"], state = _pace(state, vehicle, batch, saw["response"])
    # One fault is seen by several checks: the first of them knows best what it is.
    pausing = next((name for name, each in saw.items() if each.pauses), None)
    warnings = [f for each in saw.values() for f in each.findings if f.decision < Decision.PAUSE]
    state = _reconsidered(state, vehicle, batch, known, pausing)
    if state.agreeing >= RELEARN_BATCHES:
        return _relearned(state, batch)
    if pausing is not None:
        also = saw["pace"].findings if pausing != "pace" else []
        return _paused(state, batch, pausing, saw[pausing].findings + also)
    findings = _once(state, batch, warnings)
    if state.paused_since is not None and state.kinds != {UNCLEAR}:
        left = frozenset(name for name in state.paused_by if not saw[name].conclusive)
        after = replace(state, paused_by=left, before=None)
        if not left:
            after = replace(after, paused_since=None, kinds=frozenset(), agreeing=0)
        return after, Verdict(tuple(findings), learn=False, suspect=False, span=_span(batch))
    turning = turns(batch, vehicle.largest_rate)
    after = replace(
        state,
        paused_since=None,
        paused_by=frozenset(),
        kinds=frozenset(),
        learned=min(state.learned + turning, YOUNG_CURVE_BATCHES),
        rates=state.counted(vehicle, batch.yaw_rate) if turning else state.rates,
    )
    verdict = Verdict(tuple(findings), learn=True, suspect=False, span=_span(batch))
    if any(f.kind == CHANGE for f in warnings):
        # the curve moves now, and how far apart the streams usually seem to be goes by it
        moved = replace(after, learned=0, rates=State().rates, lag=0.0, precision=PRIOR_LAG_PRECISION, before=None)
        return replace(moved, told=float(batch.time[-1])), verdict
    drifts = any(saw["pace"].findings)
    return _usual(after, batch, saw["response"].causes, drifts), verdict


def _relearned(state: State, batch: Samples) -> tuple[State, Verdict]:
    """The state in which nothing is trusted that was learned, and the verdict that says so."""
    sentence = (
        f"the last {RELEARN_BATCHES} batches agree with each other and not with the learned curve: the damping is "
        "learned anew"
    )
    verdict = Verdict((Finding(CHANGE, Decision.WARN, sentence),), learn=True, suspect=False, span=_span(batch))
    return State(usual=state.usual, reach=state.reach, periods=state.periods, told=float(batch.time[-1])), verdict


def _trusted(state: State, vehicle: Vehicle, learned: CurveOfRates | None) -> CurveOfRates | None:
    """The curve where it was learned well enough to judge a batch by."""
    if learned is None or state.learned < YOUNG_CURVE_BATCHES:
        return None

    def curve(rate: Array) -> Curve:
        known = learned(rate)
        return replace(known, inside=known.inside & state.near(vehicle, rate))

    return curve


def _reconsidered(state: State, vehicle: Vehicle, batch: Samples, known: Curve | None, pausing: str | None) -> State:
    """The number of consecutive batches that contradict the learned curve and agree with each other."""
    if known is None or state.paused_since is None or not turns(batch, vehicle.largest_rate):
        return state
    foreign = pausing in (None, RESPONSE) and state.kinds <= {RESPONSE, UNCLEAR}
    return replace(state, agreeing=state.agreeing + 1 if foreign and _agrees(batch, known.sigma) else 0)


def _paused(state: State, batch: Samples, by: str, findings: list[Finding]) -> tuple[State, Verdict]:
    was = state.paused_since is not None
    kinds = frozenset(f.kind for f in findings if f.decision >= Decision.PAUSE)
    reasons = frozenset() if state.kinds == {UNCLEAR} else state.paused_by  # what is unclear is none beside another
    after = replace(
        state,
        paused_since=state.paused_since if was else float(batch.time[0]),
        paused_by=reasons if reasons and kinds == {UNCLEAR} else reasons | {by},
        kinds=kinds | (state.kinds - {UNCLEAR}),
        before=_kept(batch) if kinds == {UNCLEAR} else None,
    )
    # what was unclear until now may have begun in the batch before that as well
    suspect = kinds != {UNCLEAR} and (not was or state.kinds == {UNCLEAR})
    return after, Verdict(tuple(findings), learn=False, suspect=suspect, span=_span(batch))


def _stuck(state: State, vehicle: Vehicle, batch: Samples, known: Curve | None) -> CheckResult:
    low, high = vehicle.rate_range
    found, moved = stuck(batch, vehicle.inertia, high - low, state.usual, state.reach, known)
    return CheckResult(found, moved)


def _sign(vehicle: Vehicle, batch: Samples) -> CheckResult:
    if vehicle.sign_known:
        return CheckResult([], False)
    return CheckResult(drives(batch, vehicle.inertia, vehicle.largest_rate), turns(batch, vehicle.largest_rate))


def _unmoved(vehicle: Vehicle, batch: Samples, learned: CurveOfRates | None) -> list[Finding]:
    """The findings on a torque that turns nothing; of the learned curve only the size is used."""
    if learned is None:
        return []
    return unmoved(batch, vehicle.largest_rate, learned(batch.yaw_rate).largest, vehicle.inertia)


def _unit(state: State, vehicle: Vehicle, batch: Samples, known: Curve | None) -> CheckResult:
    moving = float(np.max(np.abs(batch.yaw_rate))) > 2.0 * MIN_TURNING_RATE_SHARE * vehicle.largest_rate
    reach, sigma = state.reach.get(TORQUE, 0.0), np.inf if known is None else known.sigma
    return CheckResult(unit(batch, vehicle.inertia, vehicle.largest_rate, reach, sigma), moving)


def _pace(state: State, vehicle: Vehicle, batch: Samples, response: CheckResult) -> tuple[CheckResult, State]:
    """Checks the stamps' pace, which is a new one where the streams should have drifted apart by it and have not."""
    findings, drift = paces(batch, state.periods)
    drift = state.drift + drift if drift else 0.0
    if state.learned < YOUNG_CURVE_BATCHES:
        findings = [replace(finding, decision=Decision.WARN) for finding in findings]
    elif response.causes is not None and _together(drift, response.causes, least_lag(state, vehicle)):
        now = {name: period(batch, name) for name in state.periods}
        return CheckResult([], True), replace(state, drift=0.0, periods=now)
    return CheckResult(findings, True), replace(state, drift=drift)


def _together(drift: float, found: Causes, least: float) -> bool:
    """Whether streams that should have drifted so far apart [s] are seen not to have."""
    return abs(drift) > max(DRIFTED_LAGS * least, DRIFTED_DEVIATIONS * found.lag[1]) and abs(
        found.lag[0]
    ) < MAX_SEEN_DRIFT_SHARE * abs(drift)


def _once(state: State, batch: Samples, findings: list[Finding]) -> list[Finding]:
    """Without the changes of the vehicle where one has been told a moment ago."""
    recently = state.told is not None and 0.0 <= batch.time[-1] - state.told < CHANGE_MEMORY_S
    return [f for f in findings if f.kind != CHANGE or not recently]


def _usual(state: State, batch: Samples, found: Causes | None, drifts: bool) -> State:
    """The usual values after a learned batch; the lag of a drifting clock is not among them."""
    usual, reach, periods = {}, {}, {}
    for name in STREAM_WORDS:
        low, high = batch.raw[named(name, LOW)], batch.raw[named(name, HIGH)]
        scatter = float(np.quantile(high - low, 0.1))  # of its noise: in most windows a quick vehicle moves
        reach[name] = max(RETAINED_SHARE * state.reach.get(name, 0.0), float(high.max() - low.min()))
        usual[name] = RETAINED_SHARE * state.usual.get(name, scatter) + (1.0 - RETAINED_SHARE) * scatter
        now = period(batch, name)
        periods[name] = RETAINED_SHARE * state.periods.get(name, now) + (1.0 - RETAINED_SHARE) * now
    state = replace(state, usual=usual, reach=reach, periods=periods, before=_kept(batch))
    if found is None or drifts:
        return state
    late, doubt = found.lag
    # it is not forgotten over straight legs, which tell nothing new
    more = min(doubt**-2.0, MAX_BATCH_PRECISION)
    kept = max(
        (RETAINED_SHARE if more > (1.0 - RETAINED_SHARE) * state.precision else 1.0) * state.precision,
        PRIOR_LAG_PRECISION,
    )
    total = min(kept + more, MAX_BATCH_PRECISION / (1.0 - RETAINED_SHARE))
    usually = float(np.clip(state.lag + late * more / total, -MAX_ROTOR_LAG_S, MAX_ROTOR_LAG_S))
    return replace(state, lag=usually, precision=total)


def _kept(batch: Samples) -> Samples:
    """What is needed of a batch beside the next one."""
    return Samples(batch.time, batch.yaw_rate, batch.damping, raw={TORQUE: batch.raw[TORQUE]})


def _span(batch: Samples) -> tuple[float, float]:
    return float(batch.time[0]), float(batch.time[-1])


def _agrees(batch: Samples, sigma: float) -> bool:
    """Whether the samples of a batch follow one curve of drag, be it another than was learned."""
    rate = batch.yaw_rate
    design = np.stack((rate, rate * np.abs(rate), np.ones(rate.size)), axis=1)
    kept = np.ones(rate.size, dtype=bool)
    size = np.zeros(3)
    for _ in range(3):
        size = np.linalg.lstsq(design[kept], batch.damping[kept], rcond=None)[0]
        left = batch.damping - design @ size
        kept = np.abs(left) <= TRIMMED_DEVIATIONS * max(robust_deviation(left), 1e-12)
    drag = design[:, :2] @ size[:2]
    return robust_deviation(batch.damping - design @ size) <= AGREEING_NOISES * sigma and float(drag @ rate) > 0.0
