"""Training: the SVR of the damping, over several velocities of what the textbook's drag leaves over."""

from __future__ import annotations

import numpy as np

from incsvr.learning import dual
from incsvr.learning.drag import Drag, Several, fitted, points, share_left
from incsvr.learning.iteration import Settings
from incsvr.learning.kernel import columns
from incsvr.learning.model import Model
from incsvr.learning.noise import Noise
from incsvr.numerics import Array
from incsvr.signals.samples import Samples


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
    # one outlier must not be the scale, and a velocity that never moved divides by no zero
    driven = np.quantile(np.abs(points(batch, settings.others)[:, 1:]), 0.98, axis=0)
    grown = np.maximum(np.maximum(before, driven), 1e-6).tolist()
    return np.array([own, *(settings.fastest.get(*each) for each in zip(settings.others, grown, strict=True))])


def trained(
    settings: Settings,
    samples: Samples,
    fastest: Array,
    noise: Noise,
    *,
    count: Array | None = None,
    tube: Array | None = None,
    terms: Array | None = None,
    warm: Array | None = None,
    phi: Array | None = None,
) -> tuple[Model, Array]:
    """The model on (n,) samples, and what it says of them (n,) [N m], over several velocities drag and kernels.

    Args:
        fastest: (d,) by which each velocity is scaled.
        noise: of the samples.
        count: (n,) how many samples each stands for; None where each is one.
        tube: (n,) half height of the tube of each [N m]; None where it is the configured one.
        terms: (n, p) of the drag, where a sample is the mean of several; None where its velocities say them.
        warm: (n,) θ that warms the passes of Eq. 8 [N m]; the exact solver needs none.
        phi: (rank, n) columns of the kernel, where they are known.
    """
    count = np.ones(len(samples)) if count is None else count
    tube = np.full(len(samples), settings.epsilon) if tube is None else tube
    x, y, bound, several = samples.yaw_rate, samples.damping, settings.C * count, None
    base: Array | float = 0.0
    if settings.others:
        velocity, drag = points(samples, settings.others), Drag.of(settings.own, settings.others)
        u = velocity / fastest
        psi = drag.terms(u) if terms is None else terms / drag.terms(fastest[None, :])
        coefficients = fitted(psi, y, count, independent(noise))
        base = psi @ coefficients
        x, bound = u * fastest[0], bound * share_left(y, y - base, count, noise.sigma)
        several = Several(settings.own, settings.others, velocity, fastest, coefficients)
    if settings.solver == "passes" and several is None:
        solution = dual.coordinate_descent(x, y, gamma=settings.gamma, C=bound, epsilon=tube, start=warm)
    else:
        phi = columns(x, settings.gamma, vanishing=several is not None) if phi is None else phi
        solution = dual.solve_columns(phi, y - base, bound, tube)
    model = Model(
        settings.gamma,
        settings.C,
        settings.epsilon,
        support_rate=samples.yaw_rate,
        support_damping=y,
        weight=solution.weight,
        count=count,
        sigma=noise.sigma,
        certified_error=solution.certified_error,
        several=several,
    )
    return model, base + solution.fitted


def independent(noise: Noise) -> float:
    """Noise of one sample as independent ones would have to have it, of which each tells as little [N m]."""
    return float(noise.sigma / np.sqrt(noise.worth))
