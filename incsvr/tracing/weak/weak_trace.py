"""From the residual of a declared model to the effects that it lacks, in the weak form, with the proof on unseen data.

The declared model is I₀ ṙ + d(r) = τ with its learned damping. `weak_trace` finds which effects of the catalogue it
lacks, adds them, and reports torque and free-run errors before and after on data that was not used for the fit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from incsvr.tracing.disturbance import disturbance
from incsvr.tracing.findings import Pictures, Trace
from incsvr.tracing.held_out import Errors
from incsvr.tracing.local_gain import sentence as sentence_of_gain
from incsvr.tracing.local_gain import uneven
from incsvr.tracing.run import Array, Run
from incsvr.tracing.sentences import of_clocks
from incsvr.tracing.skill import horizons, proven, trivial
from incsvr.tracing.spells import sentence as sentence_of_spells
from incsvr.tracing.spells import spans, spells
from incsvr.tracing.statistics import Change, change_of_rms
from incsvr.tracing.weak.declaration import remarks
from incsvr.tracing.weak.excitation import answered
from incsvr.tracing.weak.hypothesis import Hypothesis, nothing
from incsvr.tracing.weak.modelled import model_of
from incsvr.tracing.weak.noise import torque_scatter
from incsvr.tracing.weak.pipeline import Case, chosen_effects
from incsvr.tracing.weak.problem import Problem
from incsvr.tracing.weak.reporting import findings_of, rejected_of
from incsvr.tracing.weak.unexplained import smooth_terms
from incsvr.tracing.weak.validation_errors import sample_errors, torque_errors
from incsvr.tracing.weak.whitening import jump_noise_factor, whiten


def weak_trace(
    runs: Sequence[Run],
    inertia: float,
    validate: Sequence[Run] | None,
    names: Sequence[str],
    ignored: dict[str, str],
    excluded: Mapping[str, str],
    holds: bool | None,
) -> Trace:
    """What the declared model lacks, by the weak form.

    Args:
        runs: the recordings to fit.
        inertia: I₀, declared [kg m²].
        validate: recordings for the proof alone; without them pieces of `runs` are held out.
        names: of the channels that may be candidates.
        ignored: why others may not.
        excluded: effects that are not asked for, and why.
        holds: whether the torque is a command, which stands until the next; None where that is not told.

    Raises:
        BadInput: where the recordings cannot answer.
    """
    case, found, alternatives, refused = chosen_effects(runs, inertia, validate, names, excluded, holds)
    problem = case.problem
    complete, smooth = smooth_terms(problem, found, names, case.pieces)
    base = nothing(problem)
    findings, notes = findings_of(case, base, found, complete, alternatives)
    in_spell, unlike = _spells(problem, complete)
    begins = problem.signals.time[problem.blocks.first]
    louder, gained, both = (
        spans(begins, each, problem.blocks.period) for each in (in_spell, unlike, in_spell | unlike)
    )
    verdict = "effects" if findings else "unexplained" if smooth or both else "none"
    answered(problem, verdict, runs)
    before, after = case.proof.errors(base), case.proof.errors(complete)
    error = _errors(problem, complete, before, after, torque_scatter(runs, problem.blocks.period))
    error["validated_on"] = case.proof.validated_on
    error["disturbance"] = disturbance(complete.fit.residual, problem.blocks.period, problem.signals.torque)
    model = model_of(problem, complete)
    s = problem.signals
    depends = {"yaw_rate": s.rate, "torque": s.torque, "heading": s.heading, "time": s.time, **s.channels}
    return Trace(
        inertia=inertia,
        verdict=verdict,
        effects=tuple(findings),
        rejected=tuple(rejected_of(case, found, refused)),
        unexplained=smooth,
        error=error,
        ignored_channels=ignored,
        notes=(
            *notes,
            *([sentence_of_spells(louder)] if louder else []),
            *([sentence_of_gain(gained)] if gained else []),
            *_timing(case, base, complete),
            *remarks(problem),
            *of_clocks(problem.signals),
            *_loop(problem),
            *_command(case.proof.validation or problem),
        ),
        declared_model=model_of(problem, base),
        model=model,
        pictures=Pictures(
            before=before,
            after=after,
            ledger_time=s.time,
            ledger=model.parts(s),
            residual_before=base.fit.residual,
            residual_after=complete.fit.residual,
            depends={name: problem.blocks.mean(values) for name, values in depends.items()},
        ),
        loop="closed" if problem.closed_loop else "open",
        proven=bool(findings) and proven(error, problem.closed_loop),
        spans=both,
        one_clock=problem.signals.one_clock,
    )


def _spells(problem: Problem, complete: Hypothesis) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """(n_b,) each: where what the effects leave is louder than elsewhere, and where the thrust answers its command with
    another gain, which is not asked in closed loop."""
    s, blocks = problem.signals, problem.blocks
    # the acceleration and the jumps of the torque: what goes on within a block makes its equation less exact
    moves = np.column_stack([np.gradient(blocks.mean(values)) for values in (s.torque, s.rate)])[blocks.with_history]
    factor, per_scale = jump_noise_factor(complete.fit, blocks), s.scale / blocks.period
    innovation = complete.fit.innovation / factor
    in_spell, unlike = np.zeros(len(blocks), dtype=bool), np.zeros(len(blocks), dtype=bool)
    in_spell[blocks.with_history] = spells(innovation, moves, per_scale)
    if not problem.closed_loop:
        torque = whiten(blocks.mean(s.torque), complete.fit.ar, blocks) / factor
        unlike[blocks.with_history] = uneven(innovation, torque, per_scale)
    return in_spell, unlike


def _loop(problem: Problem) -> tuple[str, ...]:
    """The note that a controller was at work; empty in open loop."""
    if not problem.closed_loop:
        return ()
    return (
        f"the torque answers the yaw rate with {problem.feedback:.3g} N m s/rad: a controller closed the loop, and the "
        "evidence allows for it",
    )


def _timing(case: Case, base: Hypothesis, complete: Hypothesis) -> tuple[str, ...]:
    """The note that free runs are no better as they are, but put on time; else empty."""
    before, after = (case.proof.errors(each).free_run_rmse() for each in (base, complete))
    best, better = case.proof(base), case.proof(complete)
    if after < before or better >= best:
        return ()
    late = case.proof.late(complete)
    return (
        f"free runs with the effects come {abs(late):.2g} s {'late' if late > 0.0 else 'early'}, less than a sample "
        f"period; put on time their error is {better:.3g} rad/s, of {best:.3g} without the effects",
    )


def _command(problem: Problem) -> tuple[str, ...]:
    """The note that something else than the recorded torque drove the free runs of these recordings; else empty."""
    if not problem.signals.known:
        return ()
    return (
        "the torque is a command of levels with noise on it that no turn is seen to follow: free runs are driven "
        "by the command",
    )


def _errors(problem: Problem, complete: Hypothesis, before: Errors, after: Errors, scatter: float) -> dict[str, Any]:
    def of(errors: Errors) -> dict[str, float]:
        mae, rmse = sample_errors(errors.torque, scatter)
        return {"torque_mae": mae, "torque_rmse": rmse, "free_run_rmse": errors.free_run_rmse()}

    def length(times: tuple[Array, ...]) -> int:
        """Four time scales, in samples: well above the errors' correlation time."""
        step = np.median(np.concatenate([np.diff(t) for t in times]))
        return max(round(4.0 * problem.signals.scale / float(step)), 4)

    torque: Change = change_of_rms(before.torque, after.torque, length(after.block_time))
    free: Change = change_of_rms(before.free_run, after.free_run, length(after.time))
    n, p = complete.columns.shape
    # the same residual as `after`, on the fitted blocks, made up for the parameters
    left = torque_errors(problem, problem, complete)
    variance = float(np.mean(left**2)) * n / max(n - p, 1)
    return {
        "before": of(before),
        "after": of(after),
        "change": {"torque_rmse": torque.to_dict(), "free_run_rmse": free.to_dict()},
        "floor": {"torque_rmse": float(np.sqrt(variance + scatter**2))},
        "trivial": trivial(after.measured),
        "horizons": horizons(before.ahead, after.ahead),
    }
