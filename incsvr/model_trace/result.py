"""The result of a trace on the engine: findings in the contract's words, and their proof on unseen data."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from incsvr.errors import BadInput
from incsvr.model.efforts import Stage
from incsvr.model.fitting import Fit, fit
from incsvr.model.identification import Identification, identify
from incsvr.model.intervals import halved
from incsvr.model.rows import Row
from incsvr.model.scales import motion_scale
from incsvr.model.search import Added
from incsvr.model.series import effort_of, period, values
from incsvr.model_trace import spells
from incsvr.model_trace.answering import Loop, standing_time
from incsvr.model_trace.channels import usable_channels
from incsvr.model_trace.findings import Finding, Pictures, RejectedEffect, Trace, UnexplainedChannel
from incsvr.model_trace.ledger import ledger_of
from incsvr.model_trace.loop import answer_left, loop_of
from incsvr.model_trace.model import TracedModel
from incsvr.model_trace.parameters import has_size, parameters_of
from incsvr.model_trace.proof import EFFECTS, PLAIN, Proof, prove
from incsvr.model_trace.recordings import Recordings, recordings_of
from incsvr.model_trace.refusals import refuse_too_little_motion
from incsvr.model_trace.rest import smooth_rest
from incsvr.model_trace.run import Run, check
from incsvr.model_trace.sentences import AHEAD, LABELS, of_loop, of_share
from incsvr.model_trace.statistics import p_value
from incsvr.model_trace.thinning import thinned
from incsvr.model_trace.thresholds import MAX_REJECTED, MIN_HEADING_SAMPLES, OTHER_GYRO_CORRELATION
from incsvr.model_trace.traced_model import traced_model
from incsvr.model_trace.unseen import Judge, ends, judge, times
from incsvr.model_trace.vocabulary import contract_name, streams, word_of
from incsvr.numerics import Array
from incsvr.plant.axes import of_rate
from incsvr.plant.words import AxisWords, words_of
from incsvr.signals.settings import TorqueKind

ROUND_NUMBERS = (1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0)
"""Commands at which people read a thrust, in their decade."""
CURVES = {"dead": "dead", "limit": "limit", "reverse": "reverse", "exponent": "exponent"}
"""Stages of the effort that are a curve of the command."""
TOO_LITTLE = "it improves too little beside the effects found"
NOT_UNSEEN = "it does not improve predictions of excluded parts of the recordings clearly"
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
    recordings, share = thinned(recordings_of(runs, [*names, *heading]), standing_time(runs))
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
        unseen = judge(thinned(other, standing_time(validate))[0], found.models[PLAIN], recordings, excluded=False)
    loop = loop_of(runs, fitted, found.models[PLAIN], torque)
    if loop is Loop.OTHER_GYRO and answer_left(fitted, found.model) < OTHER_GYRO_CORRELATION:
        loop = Loop.OPEN  # what was missing had looked like an answer
    result = _result(Traced(found, recordings, fitted, unseen, inertia, loop), ignored, of_share(share))
    return None if must_find and not result.effects else result


@dataclass(frozen=True)
class Traced:
    """What a result is made of.

    Attributes:
        found: the identification.
        recordings: that it was fitted to.
        fitted, unseen: judges by them, and by data that no fit used.
        inertia: declared [kg], [kg m²].
        loop: how the torque follows the rate.
    """

    found: Identification
    recordings: Recordings
    fitted: Judge
    unseen: Judge
    inertia: float
    loop: Loop

    @property
    def closed(self) -> bool:
        """Whether the torque answers the rate."""
        return self.loop is not Loop.OPEN

    @property
    def words(self) -> AxisWords:
        """The words of the axis."""
        return words_of(of_rate(self.recordings.axis))

    @property
    def sample(self) -> float:
        """The usual time between two samples of the velocity [s]."""
        return period(self.recordings.streams, self.recordings.axis)


def _result(traced: Traced, ignored: Mapping[str, str], of_thinning: tuple[str, ...]) -> Trace:
    found, recordings, fitted, inertia = traced.found, traced.recordings, traced.fitted, traced.inertia
    sought = traced.loop is not Loop.OTHER_GYRO
    added = _findings(traced) if sought else []
    effects = [each for each in added if has_size(each.interval, inertia, traced.sample)]
    unsure = [RejectedEffect(each.effect, each.p_value, NO_SIZE, refused=True) for each in added if each not in effects]
    best, more = _best(traced, bool(effects))
    effects += more
    complete, unexplained = found.found.fit, tuple[UnexplainedChannel, ...]()
    if sought:
        complete, unexplained = smooth_rest(complete, recordings.channels)
    loud = _spells(complete, recordings, fitted.scale)
    proof = prove(found, best, traced.unseen, fitted, traced.closed)
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
        rejected=tuple(sorted([*unsure, *_rejected(traced)], key=lambda one: one.p_value)) if sought else (),
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


def _best(
    traced: Traced,
    has_effects: bool,
    least: float = 0.03,  # of the error of excluded free runs: a reader would not see less
) -> tuple[str, list[Finding]]:
    """The name of the best of our own simulators on excluded recordings, and the inertia where that is an effect of it.

    An inertia that the search did not add is one in open loop alone, where a simulation with it is clearly better and
    the predictor agrees that it is another than the declared.
    """
    found, axis = traced.found, traced.recordings.axis
    errors = {name: float(each[0]) for name, each in found.excluded.items()}
    best = min([PLAIN, *([EFFECTS] if has_effects else [])], key=lambda name: errors[name])
    free = f"{best}, free inertia"
    if traced.closed or free not in found.models or errors[free] > (1.0 - least) * errors[best]:
        return best, []
    model, predictor = found.models[free], found.found.fit
    start = {f"mass:{axis}": model.theta[f"mass:{axis}"], **predictor.theta}
    likewise = fit(predictor.structure.plus(free=[axis]), start, predictor.problem, predictor.starts)
    name = f"inertia@{axis}"
    ((parameters, spans),) = parameters_of(
        model, [name], traced.inertia, traced.recordings.begin, [halved(model), likewise]
    )
    if not has_size(spans, traced.inertia, traced.sample):
        return best, []
    gain = found.models[best].value - model.value
    return free, [_finding(traced, name, parameters, spans, p_value(2.0 * gain, 1, len(found.effects)), 1.0, ())]


def _findings(traced: Traced) -> list[Finding]:
    """The effects in the order in which they were added: by the simulator, in closed loop by the predictor."""
    found, recordings = traced.found, traced.recordings
    added, predictor = found.found.added, found.found.fit
    if not added:
        return []
    source = predictor if traced.closed else found.models[EFFECTS]
    others = [halved(source)] if traced.closed else [halved(source), predictor]
    every = parameters_of(source, [each.name for each in added], traced.inertia, recordings.begin, others)
    total = sum(each.gain for each in added)
    findings = []
    for one, (parameters, spans) in zip(added, every, strict=True):
        alike = [name for name in one.alike if not _contains(found.effects, name, one)]
        p = p_value(2.0 * one.gain, len(one.candidate.start), len(found.effects))
        findings.append(_finding(traced, one.name, parameters, spans, p, one.gain / total, alike))
    return findings


def _finding(
    traced: Traced, name: str, parameters: dict[str, float], spans: dict[str, tuple[float, float]], chance: float,
    share: float, alike: Sequence[str],
) -> Finding:  # fmt: skip
    others, words = tuple(dict.fromkeys(contract_name(each) for each in alike)), traced.words
    return Finding(
        effect=contract_name(name),
        channels=streams(name),
        parameters=parameters,
        interval=spans,
        p_value=chance,
        share=share,
        cannot_tell_from=(*others, *word_of(name).ties),
        next_manoeuvre=next_manoeuvre(name, others, words),
        sentence=sentence(name, parameters, spans, share, words),
        thrust=_thrust(name, parameters, spans, traced.found.models[PLAIN]),
    )


def _contains(effects: Mapping[str, Sequence[Row]], name: str, added: Added) -> bool:
    """Whether an effect is the added one with more rows, which explains the recordings as well in any case."""
    rows = effects.get(name, effects.get(name.partition("@")[0], ()))
    return set(added.candidate.start) <= {row.key for row in rows}


def next_manoeuvre(name: str, others: Sequence[str], words: AxisWords) -> str:
    """What a log must show to distinguish an effect from the others that explain this one as well, or that none can."""
    word = word_of(name)
    if others:
        return f"to distinguish it from {others[0]}, the log must show {words.fill(word.shown_by)}"
    if word.ties:
        return (
            f"no manoeuvre in {words.name} distinguishes it from {word.ties[0]}: both explain every motion alike; "
            f"{word.apart}"
        )
    return ""


def sentence(
    name: str,
    parameters: Mapping[str, float],
    spans: Mapping[str, tuple[float, float]],
    share: float,
    words: AxisWords,
) -> str:
    """The sentence of a finding: its values with 95 % intervals, and its share of the better fit."""
    shown = []
    for key, value in parameters.items():
        label, unit = (words.fill(each) for each in LABELS[key])
        low, high = spans[key]
        spread = f" ({low:.3g} to {high:.3g})" if high > low else ""
        shown.append(f"{label} {value:.3g}{spread}{' ' + unit if unit else ''}")
    meaning = words.fill(AHEAD if parameters.get("delay_s", 0.0) < 0.0 else word_of(name).sentence)
    part = f"It accounts for {100.0 * share:.0f} % of the better fit."
    return f"{contract_name(name)}: {meaning}; {', '.join(shown)}. {part}"


def _thrust(
    name: str, parameters: Mapping[str, float], spans: Mapping[str, tuple[float, float]], source: Fit
) -> tuple[tuple[float, float, float, float], ...]:
    """Of a curve of the command: at the largest command either way, rounded up, the thrust with its interval [N m]."""
    kind, _, axis = name.partition("@")
    if kind not in CURVES:
        return ()
    top = source.problem.windows.largest(effort_of(axis))
    decade = 10.0 ** math.floor(math.log10(top))
    full = next(number * decade for number in ROUND_NUMBERS if number * decade >= top)
    ((key, value),) = parameters.items()
    found = []
    for command in (-full, full):
        made = [
            float(Stage(**{CURVES[kind]: each}).static(np.array([command]), top)[0]) for each in (value, *spans[key])
        ]
        found.append((command, made[0], min(made[1:]), max(made[1:])))
    return tuple(found)


def _rejected(traced: Traced) -> list[RejectedEffect]:
    """Effects that were refused, and those that promise most of what the predictor still lacks."""
    found, result = traced.found, dict[str, RejectedEffect]()
    named = {contract_name(each.name) for each in found.found.added}
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
    return sorted(result.values(), key=lambda each: each.p_value)[:MAX_REJECTED]


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
        notes.append("free runs of excluded data are better without the effects, so the model does not contain them")
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
    middle = times(windows)[last] - 0.5 * fitted.block
    depends = {"time": middle} | {name: _means(fitted, name, middle) for name in _drawn(fitted)}
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
    return {"yaw_rate": own.axis, "torque": effort_of(own.axis)} | {
        name: name for name in own.channels if name not in ("time",)
    }


def _means(fitted: Judge, name: str, at: Array) -> Array:
    """(blocks,) of a stream about the middles of the blocks."""
    own = _drawn(fitted)[name]
    t, v = (np.concatenate([run[own][part] for run in fitted.recordings.streams]) for part in (0, 1))
    return np.asarray(np.interp(at, t, v))
