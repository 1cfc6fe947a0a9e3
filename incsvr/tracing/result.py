"""The conversion of a search into the result of a trace."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from incsvr.effects import Effect, Signals, Term
from incsvr.effects.torque_saturation import HIGHEST_COMMAND_QUANTILE
from incsvr.model_trace import spells
from incsvr.model_trace.disturbance import disturbance
from incsvr.model_trace.findings import Finding, Pictures, RejectedEffect, Trace
from incsvr.model_trace.held_out import is_proven
from incsvr.model_trace.result import ROUND_NUMBERS
from incsvr.model_trace.sentences import of_loop, of_share
from incsvr.model_trace.statistics import p_value
from incsvr.model_trace.thresholds import MAX_REJECTED
from incsvr.model_trace.torque_nature import Loop
from incsvr.plant.axes import of_rate
from incsvr.tracing.adequacy import loud_spells, smooth_terms
from incsvr.tracing.candidates import leads, residual
from incsvr.tracing.cells import Cells
from incsvr.tracing.confidence import intervals
from incsvr.tracing.effect_sentences import next_manoeuvre, of_clocks, sentence, streams
from incsvr.tracing.equivalence import alternatives
from incsvr.tracing.of_model import model_of, parts_of
from incsvr.tracing.search import FittedHypothesis, Search
from incsvr.tracing.validation import block_means, block_size, validate


def result_of(
    search: Search,
    nothing: FittedHypothesis,
    best: FittedHypothesis,
    other: Cells | None,
    ignored: Mapping[str, str],
    loop: Loop,
) -> Trace:
    """The findings with their errors on unseen data.

    Args:
        search: what was asked and tried.
        nothing, best: nothing added, and the best that was found.
        other: recordings that were not fitted; without them pieces are held out.
        ignored: why some channels were no candidates.
        loop: how the torque follows the rate.
    """
    problem = search.problem
    cells, s = problem.cells, problem.cells.signals
    channels = [name for name in s.channels if name not in ignored]
    complete, unexplained = smooth_terms(search, best, channels)
    validation = validate(problem, nothing.fitted, best.fitted, other)
    size = block_size(cells)
    left, before = (residual(each.fitted.response.dynamics) for each in (best, nothing))
    loud = loud_spells(cells, residual(complete.fitted.response.dynamics))
    model = model_of(problem, best.fitted, float(np.std(block_means(left, size))))
    declared = model_of(problem, nothing.fitted, float(np.std(block_means(before, size))))
    error = validation.to_dict(model.sigma) | {
        "disturbance": disturbance(block_means(left, size), size * cells.step, s.torque)
    }
    closed, unsought = loop is not Loop.OPEN, loop is Loop.OTHER_GYRO
    depends = {"yaw_rate": s.rate, "torque": s.torque, "heading": s.heading, "time": s.time, **s.channels}
    return Trace(
        inertia=s.inertia,
        verdict="effects" if best.names else "unexplained" if unsought or unexplained or loud else "none",
        effects=tuple(_findings(search, nothing, best)),
        rejected=tuple(_rejected(search, best)),
        unexplained=unexplained,
        error=error,
        ignored_channels=dict(ignored),
        notes=(
            *of_clocks(s),
            *of_loop(loop, s.words),
            *of_share(problem.share),
            *([spells.sentence(loud)] if loud else []),
        ),
        loop="closed" if closed else "open",
        proven=bool(best.names) and is_proven(error, closed),
        spans=loud,
        one_clock=s.one_clock,
        sought=not unsought,
        axis=of_rate(s.rate_name),
        declared_model=declared,
        model=model,
        pictures=Pictures(
            before=validation.before,
            after=validation.after,
            ledger_time=s.time,
            ledger=parts_of(model, _moving(cells)),
            residual_before=block_means(before, size),
            residual_after=block_means(left, size),
            depends={name: block_means(values, size) for name, values in depends.items()},
        ),
    )


def _moving(cells: Cells) -> Signals:
    """The signals with the measured acceleration of each cell."""
    return replace(cells.signals, acceleration=(cells.end - cells.signals.rate) / cells.step)


def _findings(search: Search, nothing: FittedHypothesis, best: FittedHypothesis) -> list[Finding]:
    problem, declared = search.problem, search.problem.cells.signals.inertia
    words = problem.cells.signals.words

    def values(effect: Effect, term: Term) -> dict[str, float]:
        thrust = _thrust(effect, term, problem.cells.signals)
        return effect.parameters(term, declared) | {f"{command}": made for command, made in thrust.items()}

    spans = intervals(problem, best.fitted, search.blocks, values)
    without = [search.tried(best.hypothesis.without(k), best.fitted) for k in range(len(best.names))]
    losses = [max(search.better(best, rest).total, 0.0) for rest in without]
    total, looked_at = max(sum(losses), 1e-300), len({effect.name for effect in search.effects})
    findings = []
    for k, part in enumerate(best.hypothesis.parts):
        parameters = part.effect.parameters(part.term, declared)
        thrust = _thrust(part.effect, part.term, problem.cells.signals)
        gain = float(np.sum(best.fitted.score - without[k].fitted.score)) / best.inflation
        others = tuple(other.names[-1] for other in alternatives(search, best, k))
        share = losses[k] / total
        findings.append(
            Finding(
                effect=part.name,
                channels=streams(part.effect),
                parameters=parameters,
                interval={name: spans[k][name] for name in parameters},
                p_value=p_value(2.0 * gain, max(part.vector.size, 1), looked_at * part.effect.multiplicity),
                share=share,
                cannot_tell_from=(*others, *part.effect.ties),
                next_manoeuvre=next_manoeuvre(part.effect, others, words),
                sentence=sentence(part.effect, parameters, spans[k], share, words),
                thrust=tuple((command, made, *spans[k][f"{command}"]) for command, made in thrust.items()),
            )
        )
    return findings


def _thrust(effect: Effect, term: Term, s: Signals) -> dict[float, float]:
    """The largest command either way, rounded up → thrust [N m]; of an effect of the command alone, else empty."""
    largest = float(np.quantile(np.abs(s.torque), HIGHEST_COMMAND_QUANTILE))
    if effect.acts != "thrust" or effect.lingers or effect.needs_clock or effect.channels or largest <= 0.0:
        return {}
    decade = 10.0 ** math.floor(math.log10(largest))
    full = next(round_number * decade for round_number in ROUND_NUMBERS if round_number * decade >= largest)
    commands = np.array([-full, full])
    return dict(zip(commands.tolist(), effect.thrust(commands, s, term).tolist(), strict=True))


def _rejected(search: Search, best: FittedHypothesis) -> list[RejectedEffect]:
    """The effects that were tried and not added, the most telling first."""
    found, looked_at = dict[str, RejectedEffect](), len(search.effects)
    for lead in leads(search.problem, best.fitted, search.effects, MAX_REJECTED, 0):
        name = lead.part.name
        if name not in found:
            p = p_value(
                2.0 * lead.gain / best.inflation, lead.part.vector.size, looked_at * lead.part.effect.multiplicity
            )
            found[name] = RejectedEffect(
                name, p, search.refused.get(name, "it improves too little beside the effects found")
            )
    for name, why in search.refused.items():
        if name not in found and name not in best.names:
            found[name] = RejectedEffect(name, 1.0, why)
    rejected = (replace(each, taken_back=each.effect in search.taken_back) for each in found.values())
    return sorted(rejected, key=lambda each: each.p_value)
