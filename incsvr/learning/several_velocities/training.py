"""Training over several velocities: the textbook's drag, and the SVR of what it leaves over."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from incsvr.learning import dual
from incsvr.learning.iteration import Settings
from incsvr.learning.model import Model
from incsvr.learning.policies.noise import Noise
from incsvr.learning.several_velocities.drag import Drag, fitted, share_left
from incsvr.learning.several_velocities.surface import Several
from incsvr.learning.several_velocities.velocities import fastest_seen, points
from incsvr.numerics import Array
from incsvr.signals.samples import Samples


@dataclass(frozen=True, slots=True)
class Trained:
    """A solution of Eq. 7 over the drag.

    Attributes:
        solution: of what the drag leaves over.
        drag: (p,) coefficients [N m].
        fitted: (n,) both together at the samples [N m].
    """

    solution: dual.Solution
    drag: Array
    fitted: Array


def fastest_of(settings: Settings, before: Array, batch: Samples) -> Array:
    """(d,) the fastest of every velocity, by which it is scaled, after a batch.

    Args:
        before: (d − 1,) of the others before it.
    """
    own = max(abs(end) for end in settings.rate_range)
    others = fastest_seen(before, points(batch, settings.others), settings.fastest, settings.others)
    return np.concatenate(([own], others))


def train(
    settings: Settings,
    samples: Samples,
    fastest: Array,
    noise: Noise,
    count: Array | None = None,
    tube: Array | None = None,
    terms: Array | None = None,
) -> Trained:
    """Drag and kernels on (n,) samples.

    Args:
        fastest: (d,) by which each velocity is scaled.
        noise: of the samples.
        count: (n,) how many samples each stands for; one where not given.
        tube: (n,) half height of the tube of each [N m]; as configured where not given.
        terms: (n, p) of the drag, where a sample is the mean of several; those of its velocities where not given.
    """
    weights = np.ones(len(samples)) if count is None else count
    u = points(samples, settings.others) / fastest
    drag = Drag.of(settings.own, settings.others)
    phi = drag.terms(u) if terms is None else terms / drag.terms(fastest[None, :])
    coefficients = fitted(phi, samples.damping, weights, independent(noise))
    base = phi @ coefficients
    share = share_left(samples.damping, samples.damping - base, weights, noise.sigma)
    solution = dual.solve(
        u * fastest[0],
        samples.damping - base,
        gamma=settings.gamma,
        C=settings.C * share * weights,
        epsilon=settings.epsilon if tube is None else tube,
        vanishing=True,
    )
    return Trained(solution, coefficients, base + solution.fitted)


def independent(noise: Noise) -> float:
    """Noise of one sample as independent ones would have to have it, of which each tells as little [N m]."""
    return float(noise.sigma / np.sqrt(noise.worth))


def model_of(
    settings: Settings,
    vectors: Samples,
    fastest: Array,
    noise: Noise,
    count: Array | None = None,
    tube: Array | None = None,
    terms: Array | None = None,
) -> Model:
    """The model on these vectors alone; arguments as of `train`."""
    trained = train(settings, vectors, fastest, noise, count, tube, terms)
    return Model(
        settings.gamma,
        settings.C,
        settings.epsilon,
        support_rate=vectors.yaw_rate,
        support_damping=vectors.damping,
        weight=trained.solution.weight,
        count=np.ones(len(vectors)) if count is None else count,
        sigma=noise.sigma,
        certified_error=trained.solution.certified_error,
        several=Several(settings.own, settings.others, points(vectors, settings.others), fastest, trained.drag),
    )
