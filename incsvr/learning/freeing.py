"""The axis as if it were by itself: what the other velocities take of samples, or of streams, is told and taken out.

Three things are asked of one axis at a time. Whether the torque made a motion (driven_motion.py) is told by the work of
damping, and what sway makes of the yaw moment does work of either sign. What the checks of the streams know is one
curve. And what the tracer fits beside its effects is one curve as well.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from incsvr.errors import BadInput
from incsvr.learning.drag import Drag, fitted, points
from incsvr.learning.iteration import Settings
from incsvr.learning.model import Model
from incsvr.learning.noise import Noise
from incsvr.learning.training import fastest_of, independent
from incsvr.numerics import Array, Streams
from incsvr.signals import TORQUE, YAW_RATE, raw
from incsvr.signals.known_instants import known_at
from incsvr.signals.samples import Samples

MAX_SURFACE_DEVIATIONS = 2.0
"""The error of the surface at a sample, in its standard deviations beyond those of the usual curve, that counts as the
surface's own and not as a fault of a sensor or a change of the vehicle."""


def by_itself(settings: Settings, fastest: Array, known: Samples, batch: Samples, noise: Noise) -> Samples:
    """A batch of n ≥ 1 samples without the terms of the drag that do not damp the own velocity; as it is over one.

    The drag is told by the batch and what is known, so that the first batch is freed as well.

    Args:
        fastest: (d − 1,) of the other velocities before the batch.
        known: vectors that are learned.
        noise: of the samples so far.
    """
    if not settings.others:
        return batch
    together = Samples.concatenate((known, batch))
    whole = fastest_of(settings, fastest, batch)
    drag = Drag.of(settings.own, settings.others)
    phi = drag.terms(points(together, settings.others) / whole)
    best = fitted(phi, together.damping, np.ones(len(together)), independent(noise))
    taken = phi[len(known) :] @ np.where(drag.damps > 0.0, 0.0, best)
    return replace(batch, damping=batch.damping - taken)


def as_one_curve(model: Model, batch: Samples) -> Samples:
    """A batch as it would be were the other velocities as usual, by a trained model over several.

    Of what a sample is off, that counts which the surface's own doubt there does not make, and where nothing was driven
    it says nothing: one curve that is sure of itself would hold it against the sensors that the surface has still to
    learn. What is far beyond the doubt stays whole, so that damping which has doubled is seen as such at every rate.
    """
    there, usual = model.at(batch), model.predict(batch.yaw_rate)
    off, more_doubt = batch.damping - there.damping, np.maximum(there.sigma**2 - usual.sigma**2, 0.0)
    beyond = np.sqrt(np.maximum(off**2 - MAX_SURFACE_DEVIATIONS**2 * more_doubt, 0.0))
    damping = usual.damping + np.where(there.extrapolated, 0.0, np.copysign(beyond, off))
    kept = dict(batch.raw)
    if raw.TORQUE in kept:  # some checks look at what the torque itself does
        kept[raw.TORQUE] = kept[raw.TORQUE] - (batch.damping - damping)
    return replace(batch, damping=damping, raw=kept)


def streams_by_itself(model: Model, streams: Streams) -> Streams:
    """The streams of a vehicle, with what a model over several velocities says of the others taken from the torque.

    Of the damping at the measured velocities that at the usual ones stays. Values of the torque at which a velocity is
    not known are left out.

    Args:
        model: trained over several velocities.
        streams: name → (stamps [s], values).

    Raises:
        BadInput: the others are never known while the torque is.
    """
    several = model.several
    if several is None:
        return streams
    time, torque = streams[TORQUE]
    known = known_at(time, streams, several.others)
    if known.sum() < 2:
        raise BadInput(
            f"the velocities {', '.join(several.others)} that damping is learned over do not come while the torque does"
        )
    at = time[known]
    rate, *others = (np.interp(at, *streams[name]) for name in (YAW_RATE, *several.others))
    there, usual = (
        several.value(velocity, model.gamma, model.weight)
        for velocity in (np.column_stack((rate, *others)), several.beside(rate))
    )
    return {**streams, TORQUE: (at, torque[known] - (there - usual))}
