"""What an effect gains against noise that is coloured, and the intervals of its parameters."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from incsvr.effects import Effect, Term
from incsvr.tracing.run import Array
from incsvr.tracing.statistics import NORMAL_95
from incsvr.tracing.weak.damping import SPLINE
from incsvr.tracing.weak.hypothesis import Hypothesis, views
from incsvr.tracing.weak.noise_autocorrelation import DEGREES
from incsvr.tracing.weak.problem import Problem
from incsvr.tracing.weak.whitening import Fit, fit, jump_noise_factor, whiten

NEIGHBOURS = 12
"""Bins of the spectrum to either side over which the noise near a frequency is averaged."""


def gain_of(problem: Problem, hypothesis: Hypothesis, k: int) -> float:
    """2 Δℓ of the k-th effect's core columns: everything else refitted without them, its offset kept, the AR anew."""
    return 2.0 * (hypothesis.fit.log_likelihood - _fitted(problem, hypothesis, k).log_likelihood)


def _fitted(problem: Problem, hypothesis: Hypothesis, out: int) -> Fit:
    """A fit from the start, without the core columns of the effect `out`."""
    core = hypothesis.position[out] + np.arange(hypothesis.effects[out].core)
    columns, jacobian = np.delete(hypothesis.columns, core, axis=1), np.delete(hypothesis.jacobian, core, axis=2)
    gyro_noise_correction = np.delete(hypothesis.gyro_noise_correction, core)
    y = problem.y - sum((x for j, x in enumerate(hypothesis.offsets) if j != out), np.zeros(len(problem.blocks)))
    return fit(
        y,
        columns,
        problem.blocks,
        rounds=5,
        jacobian=jacobian,
        gyro_noise_correction=gyro_noise_correction,
        spline=SPLINE,
    )


def evidence(problem: Problem, hypothesis: Hypothesis, k: int) -> float:
    """`gain_of`, judged against the noise at the effect's own frequencies.

    The AR(3) whitens the noise but roughly. Where the innovations' spectrum, smoothed over its neighbourhood, is higher
    at the frequencies of the effect than in the mean, the gain is divided by as much: the sandwich estimator of W. K.
    Newey and K. D. West, Econometrica 55 (1987), in the frequency domain.
    """
    core = hypothesis.position[k] + np.arange(hypothesis.effects[k].core)
    root = np.sqrt(hypothesis.fit.weight)[:, None]
    columns = root * whiten(hypothesis.columns, hypothesis.fit.ar, problem.blocks)
    part = columns[:, core] @ hypothesis.fit.theta[core]
    rest = np.delete(columns, core, axis=1)
    part = part - rest @ np.linalg.lstsq(rest, part, rcond=1e-10)[0]
    power = np.abs(np.fft.rfft(part)) ** 2
    noise = np.abs(np.fft.rfft(root[:, 0] * hypothesis.fit.innovation)) ** 2
    # the bin itself is left out: the effect was fitted there, and took the noise with it
    window = np.concatenate([np.ones(NEIGHBOURS), np.zeros(3), np.ones(NEIGHBOURS)])
    near = np.convolve(noise, window, "same") / np.convolve(np.ones_like(noise), window, "same")
    inflation = float(power @ near / max(power.sum() * np.mean(noise), 1e-300))
    return gain_of(problem, hypothesis, k) / max(inflation, 1.0)


def intervals(problem: Problem, hypothesis: Hypothesis) -> list[dict[str, tuple[float, float]]]:
    """95 % intervals of every parameter of every term, by the delta method from the `covariance` of the whole fit."""
    covered, at, out = covariance(problem, hypothesis), problem.coarse.shape[1], []
    for effect, term in zip(hypothesis.effects, hypothesis.terms, strict=True):
        count = len(term.coefficients) + len(effect.sought)
        out.append(_delta(effect, term, covered[at : at + count, at : at + count], problem.signals.inertia))
        at += count
    return out


def covariance(problem: Problem, hypothesis: Hypothesis) -> Array:
    """(q, q) of the damping's coefficients and of each term's, its searched inner parameters after them.

    From the Fisher information of the whole regression: inner parameters and the bend of curved columns enter by
    numerical derivatives. Student-t innovations carry (ν + 1)/(ν + 3) of the Gaussian information.
    """
    base = problem.coarse.shape[1]
    seen = views(problem, hypothesis)
    design = [hypothesis.columns[:, :base]]
    for effect, term in zip(hypothesis.effects, hypothesis.terms, strict=True):
        s = seen.of(effect)
        values = [*term.coefficients, *(term.inner[place] for place in effect.sought)]
        for j, value in enumerate(values):
            sides = []
            nudge = 1e-3 * abs(value) + 1e-9
            for sign in (1.0, -1.0):
                moved = list(values)
                moved[j] += sign * nudge
                coefficients = tuple(moved[: len(term.coefficients)])
                inner = effect.moved(term.inner, moved[len(term.coefficients) :])
                columns = effect.columns(s, inner, coefficients)
                offset = effect.offset(s, coefficients, columns)
                loss = columns @ np.array(coefficients)
                sides.append(problem.blocks.mean(loss if offset is None else loss + offset))
            design.append(((sides[0] - sides[1]) / (2.0 * nudge))[:, None])
    factor = jump_noise_factor(hypothesis.fit, problem.blocks)[:, None]
    white = whiten(np.column_stack(design), hypothesis.fit.ar, problem.blocks) / factor
    scale = np.sqrt(np.mean(white**2, axis=0)) + 1e-100
    information = (white / scale).T @ (white / scale) / hypothesis.fit.scale**2 * (DEGREES + 1.0) / (DEGREES + 3.0)
    covered: Array = np.linalg.pinv(information, rcond=1e-12, hermitian=True) / np.outer(scale, scale)
    return covered


def _delta(effect: Effect, term: Term, covered: Array, inertia: float) -> dict[str, tuple[float, float]]:
    centre = effect.parameters(term, inertia)
    gradient: dict[str, list[float]] = {name: [] for name in centre}
    values = [*term.coefficients, *(term.inner[place] for place in effect.sought)]
    for j, value in enumerate(values):
        nudge = 1e-4 * abs(value) + 1e-9
        moved = list(values)
        moved[j] += nudge
        inner = effect.moved(term.inner, moved[len(term.coefficients) :])
        there = effect.parameters(
            replace(term, coefficients=tuple(moved[: len(term.coefficients)]), inner=inner), inertia
        )
        for name in centre:
            gradient[name].append((there[name] - centre[name]) / nudge)
    out = {}
    for name, slope in gradient.items():
        deviation = float(np.sqrt(max(np.array(slope) @ covered @ np.array(slope), 0.0)))
        out[name] = (centre[name] - NORMAL_95 * deviation, centre[name] + NORMAL_95 * deviation)
    return out
