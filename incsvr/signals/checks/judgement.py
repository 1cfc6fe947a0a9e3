"""All checks of one batch, in the order of how sure their causes are, and the decision that follows.

    state, verdict = check(state, vehicle, batch, learned, older)

A value in, a value out: no clock, no randomness, and as much memory as a batch takes. Learning pauses with the first
batch of which a finding asks for it. It resumes with the batch after the first that each check which paused it could
judge and found clean: a check that cannot tell (a sign on a straight leg) ends no pause.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from incsvr.samples import Array, Samples
from incsvr.signals.checks.clock import paces, period
from incsvr.signals.checks.curve import Curve
from incsvr.signals.checks.heading import against_heading
from incsvr.signals.checks.misfit import RESPONSE, STILL, UNCLEAR, Scales, could_tell, late_since_then, misfit
from incsvr.signals.checks.outliers import outliers
from incsvr.signals.checks.power import MOVING, drives, turns
from incsvr.signals.checks.response import Left, agrees, causes
from incsvr.signals.checks.state import UNKNOWN, State, Vehicle
from incsvr.signals.checks.stuck import CALLED, stuck
from incsvr.signals.checks.unit import unit
from incsvr.signals.checks.verdict import CHANGE, REMEMBERED, Decision, Finding, Verdict
from incsvr.signals.raw import HEADING, HIGH, LOW, TORQUE, named

YOUNG = 3
"""Batches of turning after which the curve is known well enough to judge a batch by."""
KEPT = 0.9
"""The part of what is known of usual figures that a batch leaves: they stand for about ten batches."""
OUT_OF_NOISE = 2.0
"""The learned damping over a batch, in noise levels, from which on it is its own drag that moves a vehicle."""
KNOWN = 1.0 / 0.15**2
"""How sure the usual lag must be to tell another from it [s⁻²]."""
SURE = 1.0 / 0.1**2
"""How sure one batch may make it [s⁻²]: a rotor that follows its command slowly is no delay that is always the same."""
LAG = 2.0
"""Least lag beside the usual one that counts, in widths of the smoothing, within which the filter forgives it; and as
much as the usual one besides."""
LONGEST = 1.5
"""Before it is known, a lag longer than this [s] is no rotor's."""
ANEW = 4
"""Batches of turning, one after the other, that fit each other and not what is learned: then that is what is wrong."""
JOINED = 2.0
"""Batches' durations within which two batches are looked at together."""
Learned = Callable[[Array], Curve]
"""What is learned, at any yaw rates (n,) [rad/s]."""


@dataclass(frozen=True, slots=True)
class _Saw:
    """What one check saw, and whether it could have seen its faults in this batch."""

    findings: list[Finding]
    could: bool

    @property
    def pauses(self) -> bool:
        return any(finding.decision >= Decision.PAUSE for finding in self.findings)


def check(
    state: State, vehicle: Vehicle, batch: Samples, learned: Learned | None, older: Learned | None = None
) -> tuple[State, Verdict]:
    """Judges a batch before it is learned.

    Args:
        batch: n ≥ 1 samples with what their raw streams showed (`Samples.raw`).
        learned: the curve that is learned, at any rates; None before anything is.
        older: the same from before the last batch: a curve follows what is wrong, and hides it by that.
    """
    learned, older = _trusted(state, vehicle, learned), _trusted(state, vehicle, older)
    known = None if learned is None else learned(batch.yaw_rate)
    saw = {
        "stuck": _stuck(state, vehicle, batch, known),
        "outliers": _Saw(outliers(batch), True),
        "sign": _sign(vehicle, batch),
        "unit": _unit(state, vehicle, batch, known),
        "heading": _Saw(against_heading(batch, vehicle.largest_rate), HEADING in batch.raw),
        "response": _response(state, vehicle, batch, learned, older or learned),
        "pace": _Saw(paces(batch, state.periods), True),
    }
    # One fault is seen by several checks: the first of them knows best what it is.
    pausing = next((name for name, each in saw.items() if each.pauses), None)
    warnings = [f for each in saw.values() for f in each.findings if f.decision < Decision.PAUSE]
    state = _reconsidered(state, vehicle, batch, known, pausing)
    if state.agreeing >= ANEW:
        sentence = f"the last {ANEW} batches fit each other and not what is learned: the damping is learned anew"
        verdict = Verdict((Finding(CHANGE, Decision.WARN, sentence),), learn=True, suspect=False, span=_span(batch))
        return State(usual=state.usual, reach=state.reach, periods=state.periods, told=float(batch.time[-1])), verdict
    if pausing is not None:
        return _paused(state, batch, pausing, saw[pausing].findings + saw["pace"].findings)
    findings = _once(state, batch, warnings)
    if state.paused_since is not None and state.kinds != {UNCLEAR}:
        left = frozenset(name for name in state.paused_by if not saw[name].could)
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
        learned=min(state.learned + turning, YOUNG),
        rates=state.counted(vehicle, batch.yaw_rate) if turning else state.rates,
    )
    verdict = Verdict(tuple(findings), learn=True, suspect=False, span=_span(batch))
    if any(f.kind == CHANGE for f in warnings):
        # the curve moves now, and how far apart the streams usually seem to be goes by it
        moved = replace(after, learned=0, rates=State().rates, lag=0.0, precision=UNKNOWN, before=None)
        return replace(moved, told=float(batch.time[-1])), verdict
    drifts = any(saw["pace"].findings)
    return _usual(after, vehicle, batch, known, drifts), verdict


def _trusted(state: State, vehicle: Vehicle, learned: Learned | None) -> Learned | None:
    """The curve where it was learned well enough to judge a batch by."""
    if learned is None or state.learned < YOUNG:
        return None

    def curve(rate: Array) -> Curve:
        known = learned(rate)
        return replace(known, inside=known.inside & state.near(vehicle, rate))

    return curve


def _reconsidered(state: State, vehicle: Vehicle, batch: Samples, known: Curve | None, pausing: str | None) -> State:
    """How many batches in a row speak against what is learned, and for each other; a straight leg says nothing."""
    if known is None or state.paused_since is None or not turns(batch, vehicle.largest_rate):
        return state
    foreign = pausing in (None, RESPONSE) and state.kinds <= {RESPONSE, UNCLEAR}
    return replace(state, agreeing=state.agreeing + 1 if foreign and agrees(batch, known.sigma) else 0)


def _paused(state: State, batch: Samples, by: str, findings: list[Finding]) -> tuple[State, Verdict]:
    was = state.paused_since is not None
    kinds = frozenset(f.kind for f in findings if f.decision >= Decision.PAUSE)
    after = replace(
        state,
        paused_since=state.paused_since if was else float(batch.time[0]),
        paused_by=state.paused_by | {by},
        kinds=kinds | (state.kinds - {UNCLEAR}),
        before=batch if kinds == {UNCLEAR} else None,
    )
    # what was unclear until now may have begun in the batch before that as well
    suspect = kinds != {UNCLEAR} and (not was or state.kinds == {UNCLEAR})
    return after, Verdict(tuple(findings), learn=False, suspect=suspect, span=_span(batch))


def _stuck(state: State, vehicle: Vehicle, batch: Samples, known: Curve | None) -> _Saw:
    low, high = vehicle.rate_range
    found, moved = stuck(batch, vehicle.inertia, high - low, state.usual, state.reach, known)
    if known is None and not vehicle.believed:
        # nobody knows whether a torque turns this vehicle, or the water alone
        found = [finding for finding in found if finding.kind != "torque stuck"]
    return _Saw(found, moved)


def _sign(vehicle: Vehicle, batch: Samples) -> _Saw:
    return _Saw(drives(batch, vehicle.inertia, vehicle.largest_rate), turns(batch, vehicle.largest_rate))


def _unit(state: State, vehicle: Vehicle, batch: Samples, known: Curve | None) -> _Saw:
    if not vehicle.believed:
        return _Saw([], False)
    moving = float(np.max(np.abs(batch.yaw_rate))) > 2.0 * MOVING * vehicle.largest_rate
    reach, sigma = state.reach.get(TORQUE, 0.0), np.inf if known is None else known.sigma
    return _Saw(unit(batch, vehicle.inertia, vehicle.largest_rate, reach, sigma), moving)


def _response(state: State, vehicle: Vehicle, batch: Samples, learned: Learned | None, older: Learned | None) -> _Saw:
    """Of the batch and of its second half by what is learned, then of the batch by what was learned before the last
    one, then of both together: what begins within a batch is told by the half of it that is wrong throughout."""
    if learned is None or older is None:
        return _Saw([], state.learned < YOUNG)
    half = batch.take(slice(len(batch) // 2, None))
    windows = [(batch, learned), (half, learned), (batch, older)]
    if state.before is not None and 0.0 < batch.time[0] - state.before.time[-1] < JOINED * np.ptp(batch.time):
        windows.append((Samples.concatenate((state.before, batch)), older))
    could = False
    for samples, function in windows:
        known = function(samples.yaw_rate)
        seen = Left.of(samples, known, state.lag)
        if (
            not turns(samples.take(known.inside), vehicle.largest_rate)
            or np.sqrt(np.mean(seen.damping**2)) < OUT_OF_NOISE * known.sigma
        ):
            continue  # a controller answers the water, and what it does looks like any cause
        found = causes(seen, known.sigma)
        if found is None:
            continue
        scales = Scales(vehicle.largest_rate, known.largest, known.sigma, _least_lag(state, vehicle))
        if samples is half:
            first = batch.take(slice(0, len(batch) // 2))
            until_then = Left.of(first, function(first.yaw_rate), state.lag).deviation
            findings = late_since_then(seen, found, scales, until_then)
        else:
            findings = misfit(seen, found, scales, state.kinds)
        if not vehicle.believed:  # of a curve for unknown rates nobody says what is much
            findings = [finding for finding in findings if finding.kind != UNCLEAR]
        if findings:
            return _Saw(findings, True)
        could |= samples is not half and could_tell(found, scales)
    return _Saw([], could)


def _least_lag(state: State, vehicle: Vehicle) -> float:
    """How far from its usual the lag between the streams may be [s]; a rotor's is not known from the beginning."""
    usual = abs(state.lag)
    return LAG * vehicle.smoothing + usual if state.precision > KNOWN else max(LONGEST - usual, 0.0)


def _once(state: State, batch: Samples, findings: list[Finding]) -> list[Finding]:
    """Without the changes of the vehicle where one has been told a moment ago."""
    recently = state.told is not None and 0.0 <= batch.time[-1] - state.told < REMEMBERED
    return [f for f in findings if f.kind != CHANGE or not recently]


def _usual(state: State, vehicle: Vehicle, batch: Samples, known: Curve | None, drifts: bool) -> State:
    """What is usual, with a batch that is learned; while a clock drifts, the lag that it makes is not."""
    usual, reach, periods = {}, {}, {}
    for name in CALLED:
        low, high = batch.raw[named(name, LOW)], batch.raw[named(name, HIGH)]
        scatter = float(np.median(high - low))
        reach[name] = max(KEPT * state.reach.get(name, 0.0), float(high.max() - low.min()))
        usual[name] = KEPT * state.usual.get(name, scatter) + (1.0 - KEPT) * scatter
        now = period(batch, name)
        periods[name] = KEPT * state.periods.get(name, now) + (1.0 - KEPT) * now
    state = replace(state, usual=usual, reach=reach, periods=periods, before=batch)
    found = None if known is None or drifts else causes(Left.of(batch, known, state.lag), known.sigma)
    if found is None or not np.isfinite(found.each["lag"].resolved):
        return state
    lag = found.each["lag"]
    if lag.certainty < STILL and abs(lag.size) > LAG * vehicle.smoothing:
        return state  # of several that explain next to nothing, the best is any
    more = min(1.0 / lag.resolved**2, SURE)
    # it is not forgotten over straight legs, which tell nothing new
    kept = state.precision if more < (1.0 - KEPT) * state.precision else max(KEPT * state.precision, UNKNOWN)
    total = min(kept + more, SURE / (1.0 - KEPT))
    usually = float(np.clip(state.lag + lag.size * more / total, -LONGEST, LONGEST))
    return replace(state, lag=usually, precision=total)


def _span(batch: Samples) -> tuple[float, float]:
    return float(batch.time[0]), float(batch.time[-1])
