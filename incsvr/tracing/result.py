"""The result of a trace on the engine: findings in the contract's words, and their proof on unseen data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from incsvr.errors import BadInput
from incsvr.model.factors import Indices
from incsvr.model.fitting import Fit
from incsvr.model.identification import EFFECTS, PLAIN, identify, leaving, remaining
from incsvr.model.rivals import agreeing
from incsvr.model.scales import motion_scale
from incsvr.model.series import effort_of, values
from incsvr.numerics import Array
from incsvr.plant.axes import of_rate
from incsvr.plant.words import AxisWords
from incsvr.signals.settings import TorqueKind
from incsvr.tracing import spells
from incsvr.tracing.answering import Loop
from incsvr.tracing.channels import usable_channels
from incsvr.tracing.effects_found import FREE, Traced, findings_of
from incsvr.tracing.findings import Finding, Pictures, RejectedEffect, Trace, UnexplainedChannel
from incsvr.tracing.ledger import ledger_of
from incsvr.tracing.loop import answer_left, loop_of
from incsvr.tracing.model import TracedModel
from incsvr.tracing.parameters import has_size
from incsvr.tracing.proof import Proof, prove
from incsvr.tracing.recordings import Recordings, recordings_of
from incsvr.tracing.refusals import refuse_too_little_motion
from incsvr.tracing.rest import smooth_rest
from incsvr.tracing.run import Run, check
from incsvr.tracing.sentences import of_loop, of_share
from incsvr.tracing.statistics import p_value
from incsvr.tracing.stretches import bounded
from incsvr.tracing.thresholds import MAX_REJECTED, MIN_HEADING_SAMPLES, OTHER_GYRO_CORRELATION
from incsvr.tracing.traced_model import traced_model
from incsvr.tracing.unseen import Judge, ends, judge, times
from incsvr.tracing.vocabulary import contract_name

TOO_LITTLE = "it improves too little beside the effects found"
NOT_UNSEEN = "it does not improve predictions of excluded parts of the recordings clearly"
NO_GAIN = "free runs of excluded data are hardly better with it"
NO_SIZE = "it improves the predictions, but these recordings do not tell its size"
OVERLAP = (
    "the stamps of the recordings overlap, so each has its own time: effects that begin or drift were not sought; "
    "recordings of one dive need stamps that continue from one to the next"
)


def trace(
    runs: Sequence[Run], *, inertia: float, validate: Sequence[Run] | None = None, torque: TorqueKind | None = None
) -> Trace:
    """Find what the declared model lacks.

    Args:
        runs: the recordings to fit.
        inertia: I₀, declared [kg m²].
        validate: recordings for the proof alone; without them folds of `runs` are excluded.
        torque: whether the torque was commanded, or measured with noise of its own; None where nobody says.

    Raises:
        BadInput: where the recordings cannot answer.
    """
    found = _traced(runs, inertia, validate, torque, must_find=False)
    assert found is not None
    return found


def trace_if_found(runs: Sequence[Run], *, inertia: float, torque: TorqueKind | None = None) -> Trace | None:
    """As `trace`; None where it finds no effect, without the work of proving that there is none."""
    return _traced(runs, inertia, None, torque, must_find=True)


def _traced(
    runs: Sequence[Run], inertia: float, validate: Sequence[Run] | None, torque: TorqueKind | None, must_find: bool
) -> Trace | None:
    check(runs)
    if validate:
        check(validate)
    names, ignored = usable_channels([*runs, *(validate or [])])
    headings = [run.channels.get("heading", np.empty(0)) for run in (*runs, *(validate or ()))]
    heading = ["heading"] * all(np.isfinite(each).sum() > MIN_HEADING_SAMPLES for each in headings)
    recordings, share = bounded(recordings_of(runs, [*names, *heading]))
    refuse_too_little_motion(recordings, motion_scale(recordings.streams, recordings.axis))
    try:
        found = identify(recordings.streams, [recordings.axis], {recordings.axis: inertia}, recordings.channels)
    except np.linalg.LinAlgError as error:
        raise BadInput(
            f"the equations of these recordings have no solution ({error}): the vehicle hardly moves, or a channel "
            "repeats another; drive turns both ways with several torques, and leave out what is recorded twice"
        ) from error
    fitted = judge(recordings, found.models[PLAIN], recordings, excluded=False)
    refuse_too_little_motion(recordings, fitted.scale, found)
    if must_find and not found.found.added:
        return None
    unseen = judge(recordings, found.models[PLAIN], recordings, excluded=True)
    if validate:
        other = recordings_of(validate, [*names, *heading], recordings.begin)
        unseen = judge(bounded(other)[0], found.models[PLAIN], recordings, excluded=False)
    loop = loop_of(runs, fitted, found.models[PLAIN], torque)
    if loop is Loop.OTHER_GYRO and answer_left(fitted, found.model) < OTHER_GYRO_CORRELATION:
        loop = Loop.OPEN  # what was missing had looked like an answer
    result = _result(Traced(found, recordings, fitted, unseen, inertia, loop), ignored, of_share(share))
    return None if must_find and not result.effects else result


def _result(traced: Traced, ignored: Mapping[str, str], of_thinning: tuple[str, ...]) -> Trace:
    sought = traced.loop is not Loop.OTHER_GYRO
    traced, hidden = _with_sizes(traced) if sought else (traced, [])
    found, recordings, fitted, inertia = traced.found, traced.recordings, traced.fitted, traced.inertia
    best, effects, unsure = _settled(traced, free_inertia=True) if sought else (PLAIN, [], [])
    proof = prove(found, best, traced.unseen, fitted, traced.closed)
    if best.endswith(FREE) and not proof.proven:  # the search did not want that inertia: unseen data have to
        best, effects, unsure = _settled(traced, free_inertia=False)
        proof = prove(found, best, traced.unseen, fitted, traced.closed)
    rejected = _rejected(traced, hidden) if sought else []
    complete, unexplained = found.found.fit, tuple[UnexplainedChannel, ...]()
    if sought:
        complete, unexplained = smooth_rest(complete, recordings.channels)
    loud = _spells(complete, recordings, fitted.scale)
    plain, model = found.models[PLAIN], found.models[best]
    floor = float(proof.error["floor"]["torque_rmse"])
    named = {each.name: tuple(each.candidate.start) for each in found.found.added} if best.startswith(EFFECTS) else {}
    size = (recordings.begin, floor, fitted.block, fitted.scale)
    as_value = traced_model(model, named, inertia, *size)
    unnamed = unexplained or loud or not sought
    return Trace(
        inertia=inertia,
        verdict="effects" if effects else "unexplained" if unnamed else "none",
        effects=tuple(effects),
        rejected=tuple(sorted([*hidden, *unsure, *rejected], key=lambda one: one.p_value)),
        unexplained=unexplained,
        error=proof.error,
        ignored_channels=dict(ignored),
        notes=(
            *(() if recordings.one_clock else (OVERLAP,)),
            *of_loop(traced.loop, traced.words),
            *of_thinning,
            *_of_best(proof, bool(effects) and best == PLAIN, traced.words),
            *((spells.sentence(loud),) if loud else ()),
        ),
        loop="closed" if traced.closed else "open",
        proven=bool(effects) and proof.proven,
        spans=loud,
        one_clock=recordings.one_clock,
        sought=sought,
        axis=of_rate(recordings.axis),
        declared_model=traced_model(plain, {}, inertia, *size),
        model=as_value,
        pictures=_pictures(proof, fitted, plain, model, as_value),
    )


def _with_sizes(traced: Traced) -> tuple[Traced, list[RejectedEffect]]:
    """What remains without the effects whose size the recordings hide, and those; the last of them leaves first.

    In open loop the last one leaves, too, while all together hardly better free runs of excluded data.
    """
    hidden = list[RejectedEffect]()
    while traced.found.found.added:
        _, findings = findings_of(traced, free_inertia=True)
        pairs = list(zip(traced.found.found.added, findings, strict=False))  # a free inertia is one more finding
        lost = [
            (one, each)
            for one, each in pairs
            if not has_size(each.interval, traced.inertia, traced.sample, traced.least_band())
        ]
        late = [(one, each) for one, each in pairs if each.effect in ("torque_lag", "torque_delay")]
        if len(late) == 2 and any(pair in lost for pair in late):  # beside each other either may lose its size
            lost = [min(late, key=lambda pair: remaining(traced.found, [pair[0].name]).value)]
        lost = lost[-1:]  # the last one may have hidden the size of those before
        why = NO_SIZE
        if not lost and not traced.closed and not any(_better(traced, name) for name in (EFFECTS, f"{EFFECTS}{FREE}")):
            lost, why = [pairs[-1]], NO_GAIN
        if not lost:
            break
        hidden += [RejectedEffect(each.effect, each.p_value, why, refused=True) for _, each in lost]
        traced = replace(traced, found=leaving(traced.found, {one.name: why for one, _ in lost}, not traced.closed))
    return traced, hidden


def _settled(traced: Traced, free_inertia: bool) -> tuple[str, list[Finding], list[RejectedEffect]]:
    """The name of the best of our own simulators on excluded recordings, the effects that have a size, and the rest."""
    name, added = findings_of(traced, free_inertia)
    effects = [each for each in added if has_size(each.interval, traced.inertia, traced.sample, traced.least_band())]
    unsure = [RejectedEffect(each.effect, each.p_value, NO_SIZE, refused=True) for each in added if each not in effects]
    better = _better(traced, name)
    if effects and not traced.closed and not better:
        unsure += [RejectedEffect(each.effect, each.p_value, NO_GAIN, refused=True) for each in effects]
        effects = []
    return name if effects and better else PLAIN, effects, unsure


def _better(
    traced: Traced,
    name: str,
    least: float = 0.05,  # of their error: effects gain a tenth and more, smoother noise a hundredth
    sure: float = 0.01,  # of their error, where nearly each free run gains: water that pushes hides the rest
    agree: float = 0.85,  # seven of eight
) -> bool:
    """Whether free runs of excluded data are better with a simulator than with the plain one."""
    found = traced.found
    if name not in found.excluded:
        return False
    left = float(found.excluded[name][0] / found.excluded[PLAIN][0])
    if left >= 1.0 - least and left < 1.0 - sure:
        return agreeing(found.models[name], found.models[PLAIN], traced.recordings.streams) >= agree
    return left < 1.0 - least


def _rejected(traced: Traced, hidden: Sequence[RejectedEffect]) -> list[RejectedEffect]:
    """Effects that were refused, and those that promise most of what the predictor still lacks; without `hidden`."""
    found, result = traced.found, dict[str, RejectedEffect]()
    named = {contract_name(each.name) for each in found.found.added} | {each.effect for each in hidden}
    for each, evidence in found.found.weighed:
        name, count = contract_name(each.name), max(len(each.start), 1)
        sure = 0.5 * (evidence.sure**2 + count - 1)  # by the scatter of blocks, where errors depend on each other
        p = p_value(2.0 * min(evidence.gain, sure), count, len(found.effects))
        if name not in named and (name not in result or p < result[name].p_value):
            result[name] = RejectedEffect(name, p, NOT_UNSEEN if p < 0.01 else TOO_LITTLE)
    for key, why in found.found.refused.items():
        name = contract_name(key)
        if name not in named:
            result[name] = RejectedEffect(name, 1.0, why, refused=True)
    return sorted(result.values(), key=lambda each: (not each.refused, each.p_value))[:MAX_REJECTED]


def _of_best(proof: Proof, without: bool, words: AxisWords) -> tuple[str, ...]:
    """Notes on what is better than the model, and on effects that the best simulator does without."""
    best, notes = proof.error["best"], list[str]()
    called = {
        "zero": "a rate of zero", "hold": "the first rate kept", "output_error": "the plain model with a free inertia",
        "before": "the declared model",
    }  # fmt: skip
    if best["name"] in called:
        notes.append(
            f"{called[best['name']]} predicts unseen data best: {best['free_run_rmse']:.3g} {words.rate_unit}, the "
            f"model {proof.error['after']['free_run_rmse']:.3g}"
        )
    if without:
        notes.append(
            "free runs of excluded data are hardly better with the effects, so the model does not contain them"
        )
    return tuple(notes)


def _spells(predictor: Fit, recordings: Recordings, scale: float) -> tuple[tuple[float, float], ...]:
    """Spans in which the predictor's errors are larger than elsewhere [s]."""
    stamps = times(predictor.problem.windows)
    rate = np.concatenate([np.gradient(run[recordings.axis][1]) for run in recordings.streams])
    seen = values(recordings.streams, recordings.axis)
    own = np.concatenate([run[recordings.axis][0] for run in recordings.streams])
    effort = np.concatenate([
        np.gradient(np.interp(run[recordings.axis][0], *run[effort_of(recordings.axis)])) for run in recordings.streams
    ])  # fmt: skip
    at = np.clip(np.searchsorted(own, stamps), 0, seen.size - 1)
    step = float(np.median(np.diff(own)))
    loud = spells.spells(predictor.error, np.column_stack([effort[at], rate[at]]), scale / step)
    return spells.spans(stamps, loud, step)


def _pictures(proof: Proof, fitted: Judge, plain: Fit, model: Fit, traced: TracedModel) -> Pictures:
    """What a report draws."""
    windows = fitted.blocks
    last, _ = ends(windows)
    stamps, ledger = ledger_of(model, traced)
    middle, run = times(windows)[last] - 0.5 * fitted.block, windows.run[windows.window[last]]
    depends = {"time": middle} | {name: _means(fitted, name, middle, run) for name in _drawn(fitted)}
    return Pictures(
        before=proof.before,
        after=proof.after,
        ledger_time=stamps,
        ledger=ledger,
        residual_before=np.concatenate(fitted.torque(plain)),
        residual_after=np.concatenate(fitted.torque(model)),
        depends=depends,
    )


def _drawn(fitted: Judge) -> dict[str, str]:
    """Streams on which a residual may depend, by the names that reports know."""
    own = fitted.recordings
    beside = {name: name for name in own.channels if name != "time"}
    return beside | {"yaw_rate": own.axis, "torque": effort_of(own.axis)}


def _means(fitted: Judge, name: str, at: Array, run: Indices) -> Array:
    """(blocks,) of a stream about the middles of the blocks."""
    found, own = np.empty(at.size), _drawn(fitted)[name]
    for k in np.unique(run):
        found[run == k] = np.interp(at[run == k], *fitted.recordings.streams[k][own])
    return found
