"""The noise of the equations, read beside the best single effect: what that would leave passes for noise, too."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from incsvr.effects import Signals, candidates
from incsvr.tracing.run import Array, Run
from incsvr.tracing.weak.acceptance import against_physics
from incsvr.tracing.weak.command import Command
from incsvr.tracing.weak.excitation import demand
from incsvr.tracing.weak.hypothesis import Hypothesis, below_sampling, left_over, nothing
from incsvr.tracing.weak.noise import MOST_GYRO, gyro_noise, noise_fraction
from incsvr.tracing.weak.posing import pose_like
from incsvr.tracing.weak.problem import Problem
from incsvr.tracing.weak.required_gain import penalised_criterion
from incsvr.tracing.weak.scan import best_leads, with_lead
from incsvr.tracing.weak.weak_form import Blocks
from incsvr.tracing.weak.whitening import whiten

LEADS = 5
"""How many effects are tried before the noise is read beside the best."""

READINGS = 2
"""At most: the effect that is best beside the noise of the first may be another."""

SAME_FRACTION = 0.05
"""A change of the noise's fraction below this changes no choice."""

BUT_NOISE = 0.7
"""Part of the late torque's second differences that is in the residual where they hold noise alone."""


def with_noise_read(runs: Sequence[Run], problem: Problem, channels: Sequence[str]) -> Problem:
    """The equations with the noise as it is beside the best single effect."""
    best = _best(problem, channels)
    for _ in range(READINGS):
        before, problem = problem, _reread(runs, problem, best)
        if not _misread(before, problem):
            break
        best = _best(problem, channels)
    return problem


def _reread(runs: Sequence[Run], problem: Problem, found: Hypothesis) -> Problem:
    """The equations with the noise as it is read beside these effects: its fraction in the torque, the gyro's,
    feedback.

    All three are read from how the residual goes with torque and rate, and what an effect leaves in it does so, too.
    """
    deviation = gyro_noise(runs)
    draw = np.random.default_rng(0)
    perturbed = [replace(run, yaw_rate=run.yaw_rate + deviation * draw.normal(size=run.yaw_rate.size)) for run in runs]

    def left(problem: Problem) -> tuple[Array, Array]:
        """What is left, and what the gyro's noise does to that."""
        residual = left_over(problem, found)[0]
        return residual, left_over(pose_like(problem, perturbed, _commanded(problem)), found)[0] - residual

    residual, gyro = left(problem)
    square = whiten(gyro, found.fit.ar, problem.blocks) ** 2
    part = float(np.mean(found.fit.weight * square)) / found.fit.scale**2
    problem = replace(problem, feedback=problem.feedback_beside(found.fit.residual))
    # seen from the rate side no effect filters the torque's noise, but the gyro's is larger there; what is in the
    # residual beside both lowers either reading
    aside, of_gyro = left(_with_noise_fraction(problem, 1.0))
    fraction = max(problem.noise_fraction_beside(residual, gyro), problem.noise_fraction_beside(aside, of_gyro))
    late = _late_noise_fraction(problem, found, residual, gyro, BUT_NOISE if fraction > 0.0 else 0.0)
    # beside a delay there is none in the torque of the same instant: where the late one is not told either, none is
    fraction = problem.signals.torque_noise_fraction if fraction == 0.0 and late is None else max(fraction, late or 0.0)
    known = problem.knows_command(aside)
    signals = replace(problem.signals, torque_noise_fraction=fraction, gyro=min(part, MOST_GYRO), known=known)
    return replace(problem, signals=signals).answering(found.fit.theta[: problem.coarse.shape[1]], found.fit.ar)


def _commanded(problem: Problem) -> Callable[[Signals, Blocks], Command]:
    """The command of the same recordings with other noise on them: what was told of it already."""
    return lambda signals, blocks: problem.command


def _late_noise_fraction(
    problem: Problem, found: Hypothesis, residual: Array, gyro: Array, least_part: float
) -> float | None:
    """Part of the noise that sits in the torque where a delay brings it late into the residual; 0 where none does, and
    None where that is not told.

    It does where the delay is told from the torque as it was recorded. Of a command that moves fast, what another
    effect leaves of it there would pass for that noise, too: its first differences must be noise alone, or the second,
    of which a part `least_part` must be in the residual.
    """
    torque, rate = problem.signals.torque, problem.signals.rate
    moves = [(effect, term) for effect, term in zip(found.effects, found.terms, strict=True) if effect.shifts]
    if not moves or problem.signals.known:
        return 0.0
    for effect, term in moves:
        torque, rate = (effect.thrust(values, problem.signals, term) for values in (torque, rate))
    answer = -problem.feedback * problem.blocks.mean(rate)
    first = noise_fraction(problem.blocks, torque, residual, gyro, answer, (1,))
    second = noise_fraction(problem.blocks, torque, residual, gyro, answer, (2,), least_part)
    return max((fraction for fraction in (first, second) if fraction is not None), default=None)


def _with_noise_fraction(problem: Problem, fraction: float) -> Problem:
    """The equations with another fraction of the noise in the torque."""
    there = replace(problem, signals=replace(problem.signals, torque_noise_fraction=fraction))
    return there.answering(problem.drag, problem.noise_ar)


def _misread(before: Problem, after: Problem) -> bool:
    """Whether the noise is another on second reading: its fraction, feedback or none, or a command known or none."""
    moved = abs(after.signals.torque_noise_fraction - before.signals.torque_noise_fraction) > SAME_FRACTION
    known = after.signals.known != before.signals.known
    return moved or known or (after.feedback > 0.0) != (before.feedback > 0.0)


def _best(problem: Problem, channels: Sequence[str]) -> Hypothesis:
    """The effect that explains most, or nothing."""
    base = nothing(problem)
    every = candidates(channels, problem.signals.rate_name, problem.signals.one_clock)
    found = [with_lead(problem, base, lead) for lead in best_leads(problem, base, demand(problem, every), LEADS)]
    # a delay within a sample is how the streams were sampled, and a rotor ahead of its command is none
    real = [h for h in found if not (below_sampling(h.terms[-1], problem) or against_physics(problem, h))]
    return max((base, *real), key=penalised_criterion)
