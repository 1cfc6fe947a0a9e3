"""From the residual of a declared model to the effects that it lacks, with the proof on unseen data.

The declared model is I₀ ṙ + d(r) = τ with its learned damping. `trace` finds which effects of the catalogue it lacks,
adds them, and reports torque and free-run errors before and after on data that was not used for the fit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from incsvr.channels import usable
from incsvr.effects import Effect, candidates
from incsvr.evidence import Change, change_of_rms, gain_of, intervals, p_value
from incsvr.excitation import demand
from incsvr.forward import TracedModel, model_of
from incsvr.hypothesis import Hypothesis, nothing, settle
from incsvr.problem import Problem, pose, pose_like, torque_scatter
from incsvr.proof import Court, Errors, sample_errors
from incsvr.run import Array, Run, check
from incsvr.search import Outcome, scan, search, without
from incsvr.unexplained import Unexplained, smooth_terms


@dataclass(frozen=True, slots=True)
class Finding:
    """An effect that the model lacked.

    Attributes:
        effect: name in the vocabulary.
        channels: the streams that it reads.
        parameters: physical values; units in the names.
        interval: 95 % interval of each.
        p_value: corrected for the search.
        share: of the residual's explainable variance.
        cannot_tell_from: rivals that explain these recordings as well.
        next_manoeuvre: what to drive to tell them apart; empty where nothing is to be told apart.
        sentence: for people.
    """

    effect: str
    channels: tuple[str, ...]
    parameters: dict[str, float]
    interval: dict[str, tuple[float, float]]
    p_value: float
    share: float
    cannot_tell_from: tuple[str, ...]
    next_manoeuvre: str
    sentence: str


@dataclass(frozen=True, slots=True)
class Rejected:
    """A candidate that was looked at and not added."""

    effect: str
    p_value: float
    reason: str


@dataclass(frozen=True, slots=True)
class Pictures:
    """What a report draws, all on unseen data.

    Attributes:
        before: errors of the declared model with its learned damping.
        after: errors of the model with the effects.
        ledger_time: (n,) stamps of the ledger [s], on the fitted recordings.
        ledger: part → (n,) torque that it takes [N m].
        residual_before: (n_b,) block residuals on the fitted recordings [N m].
        residual_after: likewise.
        depends: name → (n_b,) block means of what the residual may depend on: rate, torque, heading, time, channels.
    """

    before: Errors
    after: Errors
    ledger_time: Array
    ledger: dict[str, Array]
    residual_before: Array
    residual_after: Array
    depends: dict[str, Array]


@dataclass(frozen=True, slots=True)
class Trace:
    """What was found, and its proof; `to_dict` is CONTRACT Section 5."""

    inertia: float
    verdict: str
    effects: tuple[Finding, ...]
    rejected: tuple[Rejected, ...]
    unexplained: tuple[Unexplained, ...]
    error: dict[str, Any]
    ignored_channels: dict[str, str]
    notes: tuple[str, ...]
    declared_model: TracedModel
    model: TracedModel
    pictures: Pictures

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "declared": {"inertia": self.inertia},
            "verdict": self.verdict,
            "effects": [
                {
                    "effect": f.effect,
                    "channels": list(f.channels),
                    "parameters": f.parameters,
                    "interval": {name: list(ends) for name, ends in f.interval.items()},
                    "p_value": f.p_value,
                    "share": f.share,
                    "cannot_tell_from": list(f.cannot_tell_from),
                    "next_manoeuvre": f.next_manoeuvre,
                    "sentence": f.sentence,
                }
                for f in self.effects
            ],
            "rejected": [{"effect": r.effect, "p_value": r.p_value, "reason": r.reason} for r in self.rejected],
            "unexplained": [{"channel": u.channel, "p_value": u.p_value} for u in self.unexplained],
            "error": self.error,
            "ignored_channels": self.ignored_channels,
            "notes": list(self.notes),
            "model": self.model.to_dict(),
        }


def trace(runs: Sequence[Run], *, inertia: float, validate: Sequence[Run] | None = None) -> Trace:
    """Find what the declared model lacks.

    Args:
        runs: the recordings to fit.
        inertia: I₀, declared [kg m²].
        validate: recordings for the proof alone; without them pieces of `runs` are held out.

    Raises:
        BadInput: where the recordings cannot answer.
    """
    check(runs)
    if validate:
        check(validate)
    names, ignored = usable([*runs, *(validate or [])])
    problem = pose(runs, inertia, names)
    effects = demand(problem, candidates(names))
    validation = pose_like(problem, validate) if validate else None
    court = Court.of(problem, validation)
    outcome, failed = _proven(problem, effects, court)
    hypothesis, smooth = smooth_terms(problem, outcome.hypothesis, names)
    return _report(
        problem, court, effects, outcome, hypothesis, smooth, failed, names, ignored, torque_scatter(runs, problem)
    )


def _proven(problem: Problem, effects: Sequence[Effect], court: Court) -> tuple[Outcome, dict[str, str]]:
    """Search, and search again without whatever did not help the free run on unseen data."""
    failed: dict[str, str] = {}
    while True:
        outcome = search(problem, [e for e in effects if e.name not in failed])
        hypothesis = outcome.hypothesis
        if not hypothesis.terms or len(failed) >= 4:
            return outcome, failed
        whole = court.try_(hypothesis)
        worst, excess = "", 0.0
        for k, term in enumerate(hypothesis.terms):
            less = court.try_(without(problem, hypothesis, k))
            loss = whole.free_run_rmse() - less.free_run_rmse()
            if loss >= excess:
                worst, excess = term.effect, loss
                reason = (
                    "it improves the torque equation, but the free run on unseen data gets no better: "
                    f"{less.free_run_rmse():.3g} rad/s without it, {whole.free_run_rmse():.3g} rad/s with it"
                )
        if not worst:
            return outcome, failed
        failed[worst] = reason


def _report(
    problem: Problem,
    court: Court,
    effects: Sequence[Effect],
    outcome: Outcome,
    hypothesis: Hypothesis,
    smooth: tuple[Unexplained, ...],
    failed: dict[str, str],
    names: Sequence[str],
    ignored: dict[str, str],
    scatter: float,
) -> Trace:
    base = nothing(problem)
    before, after = court.try_(base), court.try_(hypothesis)
    found = outcome.hypothesis
    spans = intervals(problem, found)
    notes, findings = [], []
    total = _mean_square(base.fit.residual) - _mean_square(hypothesis.fit.residual)
    last = _mean_square(base.fit.residual)
    for k, (effect, term) in enumerate(zip(found.effects, found.terms, strict=True)):
        part = Hypothesis(found.terms[: k + 1], found.effects[: k + 1], base.fit, base.columns, (), 0.0, (), ())
        now = _mean_square(_refitted(problem, part)) if k + 1 < len(found.terms) else _mean_square(found.fit.residual)
        share = float(np.clip((last - now) / max(total, 1e-300), 0.0, 1.0))
        last = now
        parameters = effect.parameters(term, problem.signals.inertia)
        if effect.acts == "thrust" and _below_sampling(parameters, problem.resolution):
            notes.append(
                f"torque and yaw rate are aligned by {next(iter(parameters.values())):.3g} s, less than a sample "
                "period: part of the sampling, not an effect"
            )
            continue
        gain = gain_of(problem, found, k)
        p = p_value(gain, effect.core + (1 if effect.searched else 0), effect.looks * len(names) * 3 + 20)
        findings.append(
            Finding(
                term.effect, effect.channels or _streams(effect), parameters, spans[k], p, share, (), "",
                _sentence(effect, parameters, spans[k], share),
            )
        )  # fmt: skip
    rejected = [Rejected(name, 1.0, reason) for name, reason in failed.items()]
    taken = {f.effect for f in findings} | set(failed)
    for lead in scan(problem, found, effects):
        if lead.effect.name not in taken:
            taken.add(lead.effect.name)
            rejected.append(
                Rejected(
                    lead.effect.name,
                    p_value(lead.gain, lead.effect.core, lead.effect.looks),
                    "no evidence beside the effects found",
                )
            )
    verdict = "effects" if findings else "unexplained" if smooth else "none"
    s = problem.signals
    error: dict[str, Any] = _errors(before, after, hypothesis, scatter, s.scale)
    error["validated_on"] = court.validated_on
    model = model_of(problem, hypothesis)
    depends = {"yaw_rate": s.rate, "torque": s.torque, "heading": s.heading, "time": s.time, **s.channels}
    pictures = Pictures(
        before, after, s.time, model.parts(s), base.fit.residual, hypothesis.fit.residual,
        {name: problem.blocks.mean(values) for name, values in depends.items()},
    )  # fmt: skip
    return Trace(
        s.inertia, verdict, tuple(findings), tuple(rejected), smooth, error, ignored, tuple(notes),
        model_of(problem, base), model, pictures,
    )  # fmt: skip


def _refitted(problem: Problem, part: Hypothesis) -> Array:
    terms = [(e, t.inner, t.coefficients) for e, t in zip(part.effects, part.terms, strict=True)]
    return settle(problem, terms, nothing(problem)).fit.residual


def _mean_square(residual: Array) -> float:
    """Robust against outliers: of the residual drawn in to four deviations."""
    limit = 4.0 * 1.4826 * float(np.median(np.abs(residual)))
    return float(np.mean(np.clip(residual, -limit, limit) ** 2))


def _below_sampling(parameters: dict[str, float], resolution: float) -> bool:
    value = parameters.get("delay_s", parameters.get("time_constant_s"))
    return value is not None and abs(value) < resolution


def _streams(effect: Effect) -> tuple[str, ...]:
    if effect.acts == "thrust":
        return ("torque",)
    return {"heading_current": ("heading",), "tether": ("heading",), "inflow": ("yaw_rate", "torque")}.get(
        effect.name, ("t",) if effect.needs_clock else ("yaw_rate",) if effect.acts != "outside" else ()
    )


def _sentence(
    effect: Effect, parameters: dict[str, float], interval: dict[str, tuple[float, float]], share: float
) -> str:
    values = ", ".join(
        f"{name} {value:.3g} ({interval[name][0]:.3g} to {interval[name][1]:.3g})" for name, value in parameters.items()
    )
    return f"{effect.name}: {effect.sentence}. {values}. It explains {share:.0%} of what can be explained."


def _errors(before: Errors, after: Errors, hypothesis: Hypothesis, scatter: float, scale: float) -> dict[str, Any]:
    def of(errors: Errors) -> dict[str, float]:
        mae, rmse = sample_errors(errors.torque, scatter)
        return {"torque_mae": mae, "torque_rmse": rmse, "free_run_rmse": errors.free_run_rmse()}

    block = float(np.median(np.diff(after.block_time[0]))) if after.block_time[0].size > 1 else scale
    step = float(np.median(np.diff(after.time[0]))) if after.time[0].size > 1 else scale
    torque: Change = change_of_rms(before.torque, after.torque, max(round(4.0 * scale / block), 4))
    free: Change = change_of_rms(before.free_run, after.free_run, max(round(4.0 * scale / step), 4))
    n, p = hypothesis.columns.shape
    floor = float(np.sqrt(np.mean(hypothesis.fit.residual**2) * n / max(n - p, 1) + scatter**2))
    return {
        "before": of(before),
        "after": of(after),
        "change": {"torque_rmse": torque.to_dict(), "free_run_rmse": free.to_dict()},
        "floor": {"torque_rmse": floor},
    }
