"""How the torque runs between its stamps: held, as a command is, or linear, as a measured moment."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from incsvr.effects import Signals, candidates
from incsvr.tracing.run import Array, Run, sample_period
from incsvr.tracing.weak.acceptance import against_physics
from incsvr.tracing.weak.command import Command
from incsvr.tracing.weak.disturbance_response import PARTS
from incsvr.tracing.weak.excitation import demand
from incsvr.tracing.weak.hypothesis import Hypothesis, below_sampling, left_over, nothing, resettled
from incsvr.tracing.weak.noise import MOST_GYRO, gyro_noise, noise_fraction, white_noise
from incsvr.tracing.weak.posing import pose, pose_like
from incsvr.tracing.weak.problem import Problem
from incsvr.tracing.weak.required_gain import penalised_criterion
from incsvr.tracing.weak.scan import best_leads, with_lead
from incsvr.tracing.weak.weak_form import Blocks
from incsvr.tracing.weak.whitening import whiten

MOST_MISSED = 0.9
"""Most of a disturbance that its belated answer may hide."""

LEADS = 5
"""How many effects are tried with either torque before the two are compared."""

SAME_FRACTION = 0.05
"""A change of the noise's fraction below this changes no choice."""

BUT_NOISE = 0.7
"""Part of the late torque's second differences that is in the residual where they hold noise alone."""

MARGIN = 40.0
"""By how much the held torque must explain more."""

UNCERTAINTY = 0.2
"""Of what it explains without having earned it: that is known no better."""


def aligned(runs: Sequence[Run], inertia: float, channels: Sequence[str], holds: bool | None) -> Problem:
    """The equations with the held torque where it is told that it `holds`, with the linear one where it is told that it
    does not; else with the linear one, unless the held one explains more, or as much without any effect.

    Half a sample of false delay looks like a small inertia, memory or lag. Beside one effect alone the held torque
    explains part of a second, of a delay half a sample: where it seems to hold, a second is added to either.
    """
    if holds is not None:
        return settled(runs, pose(runs, inertia, channels, zero_order_hold=holds), channels)[0]
    linear, beside_linear = settled(runs, pose(runs, inertia, channels, zero_order_hold=False), channels)
    if linear.resolution <= linear.blocks.period / 40.0:
        return linear
    # in the same blocks: likelihoods of different data do not compare
    zero_order = pose(runs, inertia, channels, zero_order_hold=True, period=linear.blocks.period)
    zero_order, beside_zero_order = settled(runs, zero_order, channels)
    at_one, at_two = _at_one_noise_fraction(linear, zero_order)
    one = _best_again(at_one, linear, beside_linear, channels)
    two = _best_again(at_two, zero_order, beside_zero_order, channels)
    unearned = _unearned(runs, at_one, at_two, one, two)
    nothing_one, nothing_two = penalised_criterion(nothing(at_one)), penalised_criterion(nothing(at_two)) + unearned
    # where the linear one needs no effect, none that goes with the held one is believed
    explains_more = penalised_criterion(two) + unearned > penalised_criterion(one) + MARGIN and bool(
        one.terms or not two.terms
    )
    needs_nothing = nothing_two > nothing_one + MARGIN and nothing_two > penalised_criterion(one) - MARGIN
    if not (explains_more or needs_nothing):
        return linear
    one, two = _best(at_one, channels, one), _best(at_two, channels, two)
    return zero_order if _holds(runs, at_one, at_two, one, two) else linear


def _holds(runs: Sequence[Run], linear: Problem, zero_order: Problem, one: Hypothesis, two: Hypothesis) -> bool:
    """Whether the held torque explains more with `two` than the linear one with `one`."""
    unearned = _unearned(runs, linear, zero_order, one, two)
    return penalised_criterion(two) + unearned > penalised_criterion(one) + MARGIN + UNCERTAINTY * abs(unearned)


def _at_one_noise_fraction(linear: Problem, zero_order: Problem) -> tuple[Problem, Problem]:
    """Both with one fraction of the noise in the torque and one answer to it: their likelihoods compare at that alone.

    What the wrong of the two leaves does not follow the torque, so that its fraction is too small; but a controller's
    answer, seen at another time, does. Where either refutes a controller there is none.
    """
    feedback = min(linear.feedback, zero_order.feedback)
    fraction = (min if feedback > 0.0 else max)(
        linear.signals.torque_noise_fraction, zero_order.signals.torque_noise_fraction
    )
    at_one, at_two = (
        replace(with_noise_fraction(problem, fraction), feedback=feedback) for problem in (linear, zero_order)
    )
    return at_one.answering(linear.drag, linear.noise_ar), at_two.answering(linear.drag, linear.noise_ar)


def reread(runs: Sequence[Run], problem: Problem, found: Hypothesis) -> Problem:
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
    aside, of_gyro = left(with_noise_fraction(problem, 1.0))
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


def with_noise_fraction(problem: Problem, fraction: float) -> Problem:
    """The equations with another fraction of the noise in the torque."""
    there = replace(problem, signals=replace(problem.signals, torque_noise_fraction=fraction))
    return there.answering(problem.drag, problem.noise_ar)


def misread(before: Problem, after: Problem, change: float) -> bool:
    """Whether the noise is another on second reading: its fraction by more than `change`, feedback or none, or a
    command known or none."""
    moved = abs(after.signals.torque_noise_fraction - before.signals.torque_noise_fraction) > change
    known = after.signals.known != before.signals.known
    return moved or known or (after.feedback > 0.0) != (before.feedback > 0.0)


def settled(runs: Sequence[Run], problem: Problem, channels: Sequence[str]) -> tuple[Problem, Hypothesis]:
    """The equations with the noise as it is beside the best single effect, and that effect."""
    best = _best(problem, channels)
    for _ in range(2):
        before, problem = problem, reread(runs, problem, best)
        if not misread(before, problem, SAME_FRACTION):
            break
        best = _best(problem, channels)
    return problem, best


def _best_again(problem: Problem, before: Problem, best: Hypothesis, channels: Sequence[str]) -> Hypothesis:
    """The best single effect; where the noise is read as `before`, the one that was best then."""
    return _best(problem, channels) if misread(before, problem, SAME_FRACTION) else resettled(problem, best)


def _best(problem: Problem, channels: Sequence[str], beside: Hypothesis | None = None) -> Hypothesis:
    """What explains most: one effect more than `beside`, that, or nothing."""
    base = nothing(problem) if beside is None else beside
    every = candidates(channels, problem.signals.rate_name, problem.signals.one_clock)
    effects = [effect for effect in demand(problem, every) if effect.name not in base.names()]
    leads = best_leads(problem, base, effects, LEADS)
    settled = [with_lead(problem, base, lead) for lead in leads]
    # a delay within a sample, or a rotor ahead of its command, is the other of the two torques in disguise
    real = [h for h in settled if not (below_sampling(h.terms[-1], problem) or against_physics(problem, h))]
    return max((base, *real), key=penalised_criterion)


def _unearned(runs: Sequence[Run], linear: Problem, zero_order: Problem, one: Hypothesis, two: Hypothesis) -> float:
    """What the held torque wins or loses in 2 ℓ that is no sign of how the torque runs."""
    return _smoother(runs, linear, zero_order, one, two) + _belated(runs, zero_order)


def _smoother(runs: Sequence[Run], linear: Problem, zero_order: Problem, one: Hypothesis, two: Hypothesis) -> float:
    """What the held torque loses in 2 ℓ where its interpolation averages the sensor's noise less than the linear one.

    White noise at the torque's stamps, brought to the blocks in the same two ways, says by how much.
    """
    deviation = white_noise(runs)
    draw = np.random.default_rng(0)
    noise = [
        replace(run, torque=np.where(np.isnan(run.torque), np.nan, draw.normal(size=run.torque.size))) for run in runs
    ]
    left = []
    for problem, best in ((linear, one), (zero_order, two)):
        unit = pose_like(problem, noise, _commanded(problem))
        torque = unit.blocks.mean(unit.signals.torque)
        left.append(deviation**2 * float(np.mean(whiten(torque, best.fit.ar, unit.blocks) ** 2)))
    square = two.fit.scale**2
    # the differences hold a controller's answers, too, which are no noise of the torque
    most = (
        min(1.0, zero_order.signals.torque_noise_fraction * square / max(left[1], 1e-300))
        if zero_order.closed_loop
        else 1.0
    )
    reduced = square - most * (left[1] - left[0])
    return -float(two.fit.innovation.size * np.log(max(reduced, 0.1 * square) / square))


def _belated(runs: Sequence[Run], zero_order: Problem) -> float:
    """What the held torque wins in 2 ℓ where a controller's answer is seen half a sample too late, 0 or negative.

    With less of the own block's answer in the torque, less of the disturbance is in the residual; so is its density.
    """
    response, late = zero_order.disturbance_response, 0.5 * sample_period(runs, "torque") / zero_order.blocks.period
    part = np.arange(response.path.size)
    missed = response.left(response.path - np.interp(part - late * PARTS, part, response.path, left=0.0))
    hidden = min(zero_order.feedback * zero_order.signals.turning * missed, MOST_MISSED)
    return 2.0 * len(zero_order.blocks) * float(np.log1p(-hidden))
