"""Training: the SVR of the damping, over several velocities of what the textbook's drag leaves over."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from incsvr.learning import dual
from incsvr.learning.iteration import Settings
from incsvr.learning.model import Model
from incsvr.learning.policies.noise import Noise
from incsvr.learning.several_velocities.drag import Drag, fitted, share_left
from incsvr.learning.several_velocities.surface import Several
from incsvr.learning.velocities import points
from incsvr.numerics import Array
from incsvr.signals.samples import Samples

MIN_FASTEST = 1e-6
"""Fastest value of a velocity that never moved [m/s] or [rad/s]: no scale is divided by zero."""
FASTEST_QUANTILE = 0.98
"""Quantile of a batch's |velocity| that counts as its fastest: one outlier must not be the scale."""


@dataclass(frozen=True, slots=True)
class Problem:
    """Samples to train on.

    Attributes:
        samples: (n,) with their further velocities as channels.
        fastest: (d,) by which each velocity is scaled.
        noise: of the samples.
        count: (n,) how many samples each stands for; None where each is one.
        tube: (n,) half height of the tube of each [N m]; None where it is the configured one.
        terms: (n, p) of the drag, where a sample is the mean of several; None where its velocities say them.
        warm: (n,) θ that warms the passes of Eq. 8 [N m]; the exact solver needs none.
    """

    samples: Samples
    fastest: Array
    noise: Noise
    count: Array | None = None
    tube: Array | None = None
    terms: Array | None = None
    warm: Array | None = None


@dataclass(frozen=True, slots=True)
class Trained:
    """A solution of Eq. 7.

    Attributes:
        solution: θ; over several velocities of what the drag leaves over.
        drag: (p,) coefficients of the drag [N m]; none over one velocity.
        fitted: (n,) the damping at the samples [N m], drag and kernels together.
    """

    solution: dual.Solution
    drag: Array
    fitted: Array


def fastest_of(settings: Settings, before: Array, batch: Samples) -> Array:
    """(d,) the fastest of every velocity, by which it is scaled, after a batch: the own one's by the rate range, each
    other one's as configured, or the fastest that was driven so far.

    Args:
        before: (d − 1,) of the others before the batch.
        batch: n ≥ 1 samples.
    """
    own = max(abs(end) for end in settings.rate_range)
    if not settings.others:
        return np.array([own])
    driven = np.quantile(np.abs(points(batch, settings.others)[:, 1:]), FASTEST_QUANTILE, axis=0)
    grown = np.maximum(np.maximum(before, driven), MIN_FASTEST).tolist()
    return np.array([own, *(settings.fastest.get(*each) for each in zip(settings.others, grown, strict=True))])


def train(settings: Settings, problem: Problem) -> Trained:
    """Solves Eq. 7 by the configured solver; over several velocities exactly, after the drag."""
    if settings.others:
        return _over_several(settings, problem)
    samples = problem.samples
    bound = settings.C if problem.count is None else settings.C * problem.count
    tube = settings.epsilon if problem.tube is None else problem.tube
    if settings.solver == "passes":
        solution = dual.coordinate_descent(
            samples.yaw_rate, samples.damping, gamma=settings.gamma, C=bound, epsilon=tube, start=problem.warm
        )
    else:
        solution = dual.solve(samples.yaw_rate, samples.damping, gamma=settings.gamma, C=bound, epsilon=tube)
    return Trained(solution, np.empty(0), solution.fitted)


def model_of(settings: Settings, problem: Problem) -> Model:
    """The model on the samples of a problem alone."""
    trained, samples = train(settings, problem), problem.samples
    several = None
    if settings.others:
        velocity = points(samples, settings.others)
        several = Several(settings.own, settings.others, velocity, problem.fastest, trained.drag)
    return Model(
        settings.gamma,
        settings.C,
        settings.epsilon,
        support_rate=samples.yaw_rate,
        support_damping=samples.damping,
        weight=trained.solution.weight,
        count=np.ones(len(samples)) if problem.count is None else problem.count,
        sigma=problem.noise.sigma,
        certified_error=trained.solution.certified_error,
        several=several,
    )


def independent(noise: Noise) -> float:
    """Noise of one sample as independent ones would have to have it, of which each tells as little [N m]."""
    return float(noise.sigma / np.sqrt(noise.worth))


def _over_several(settings: Settings, problem: Problem) -> Trained:
    """The drag by Huber's regression, and the kernels that vanish at rest for what it leaves over."""
    samples, fastest, noise = problem.samples, problem.fastest, problem.noise
    count = np.ones(len(samples)) if problem.count is None else problem.count
    u = points(samples, settings.others) / fastest
    drag = Drag.of(settings.own, settings.others)
    phi = drag.terms(u) if problem.terms is None else problem.terms / drag.terms(fastest[None, :])
    coefficients = fitted(phi, samples.damping, count, independent(noise))
    base = phi @ coefficients
    share = share_left(samples.damping, samples.damping - base, count, noise.sigma)
    solution = dual.solve(
        u * fastest[0],
        samples.damping - base,
        gamma=settings.gamma,
        C=settings.C * share * count,
        epsilon=settings.epsilon if problem.tube is None else problem.tube,
        vanishing=True,
    )
    return Trained(solution, coefficients, base + solution.fitted)
