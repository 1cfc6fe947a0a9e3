"""Samples of the axis as if it were by itself: what the other velocities take of them is told and taken out.

Two things are asked of one axis at a time. Whether the torque made a motion (driven.py) is told by the work of damping,
and what sway makes of the yaw moment does work of either sign. And what the checks of the streams know is one curve.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from incsvr.learning.iteration import Settings
from incsvr.learning.model import Model
from incsvr.learning.policies.noise import Noise
from incsvr.learning.several_velocities.drag import Drag, fitted
from incsvr.learning.several_velocities.training import fastest_of, independent
from incsvr.learning.several_velocities.velocities import points
from incsvr.numerics import Array
from incsvr.signals.raw import TORQUE
from incsvr.signals.samples import Samples


def by_itself(settings: Settings, fastest: Array, known: Samples, batch: Samples, noise: Noise) -> Samples:
    """A batch of n ≥ 1 samples without the terms of the drag that do not damp the own velocity.

    The drag is told by the batch and what is known, so that the first batch is freed as well.

    Args:
        fastest: (d − 1,) of the other velocities before the batch.
        known: vectors that are learned.
        noise: of the samples so far.
    """
    together = Samples.concatenate((known, batch))
    whole = fastest_of(settings, fastest, batch)
    drag = Drag.of(settings.own, settings.others)
    phi = drag.terms(points(together, settings.others) / whole)
    best = fitted(phi, together.damping, np.ones(len(together)), independent(noise))
    taken = phi[len(known) :] @ np.where(drag.damps > 0.0, 0.0, best)
    return replace(batch, damping=batch.damping - taken)


def as_one_curve(model: Model, batch: Samples) -> Samples:
    """A batch as it would be were the other velocities as usual, by a trained model over several.

    What a sample is off counts in its own doubt, and where nothing was driven it says nothing: one curve that is sure
    of itself would hold it against the sensors that the surface has still to learn.
    """
    there, usual = model.at(batch), model.predict(batch.yaw_rate)
    share = np.where(there.extrapolated, 0.0, np.minimum(usual.sigma / there.sigma, 1.0))
    damping = usual.damping + share * (batch.damping - there.damping)
    raw = dict(batch.raw)
    if TORQUE in raw:  # some checks look at what the torque itself does
        raw[TORQUE] = raw[TORQUE] - (batch.damping - damping)
    return replace(batch, damping=damping, raw=raw)
