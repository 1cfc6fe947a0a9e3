"""The learner of `serve` without a bus: measurements are pushed, and the model is asked."""

from __future__ import annotations

import uuid
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from incsvr.errors import BadInput
from incsvr.learning.iteration import scaled_to
from incsvr.learning.model import Model
from incsvr.learning.prediction import Prediction
from incsvr.numerics import Array
from incsvr.numerics.plain import to_plain
from service.config.configuration import Config, check_inertia
from service.config.traced_effects import configured_effects
from service.config.vehicle_learners import MAX_RATE_LIMIT, RATE_LIMIT_FACTOR, SCALED
from service.learner.node import LearnerNode
from service.learner.published import check_trained

DECAY_S = 0.9
"""A vehicle of which the inertia alone is known slows down at its fastest as Leng does, within this time [s]."""
CHUNK = 64
"""Values of a stream that are pushed before those of the next: whole logs come as they would on a bus."""


def of_range(inertia: float, span: tuple[float, float]) -> dict[str, float | list[float]]:
    """Values of the configuration that suit a vehicle of which no log is known, by their names.

    Args:
        inertia: [kg m²], [kg].
        span: the lowest and the highest velocity [rad/s], [m/s].
    """
    fastest = max(abs(each) for each in span)
    settings = scaled_to(fastest, inertia * fastest / DECAY_S)
    return {
        "vehicle.rate_range": list(span),
        "vehicle.rate_limit": min(RATE_LIMIT_FACTOR * fastest, MAX_RATE_LIMIT),
        **{f"learner.{name}": float(f"{getattr(settings, name):.3g}") for name in SCALED},
    }


class Live:
    """A learner whose measurements come by call.

    Args:
        config: of this learner.

    Raises:
        BadInput: nobody said the inertia, or its traced effects cannot be used.
    """

    def __init__(self, config: Config) -> None:
        check_inertia(config)
        self._node = LearnerNode(config, uuid.uuid4().hex[:12], effects=configured_effects(config))
        self._channels = config.signal_settings().channels

    def push(self, t: ArrayLike, streams: Mapping[str, ArrayLike]) -> bool:
        """Takes (n,) stamps [s] and values of each stream, or one, nan where it was not sampled; True where the model
        changed.

        Raises:
            BadInput: they are not of equal length, or a channel is none that samples wait for.
        """
        time, revision = _values("t", t), self._node.served.revision
        values = {name: _values(name, each) for name, each in streams.items()}
        for name, each in values.items():
            if each.size != time.size:
                raise BadInput(f"t has {time.size} values and {name} has {each.size}; give one for each stamp")
            if name not in ("yaw_rate", "torque", *self._channels):
                known = ", ".join(self._channels) or "none"
                raise BadInput(f"{name} is no channel of this learner; list it in signals.channels (now {known})")
        for first in range(0, time.size, CHUNK):
            for name, each in values.items():
                stamps, part = time[first : first + CHUNK], each[first : first + CHUNK]
                sampled = np.isfinite(stamps) & ~np.isnan(part)
                if sampled.any() and self._node.push(name, stamps[sampled], part[sampled]):
                    while self._node.learn() is not None:
                        pass
        return self._node.served.revision != revision

    @property
    def model(self) -> Model:
        """What is learned now."""
        return self._node.served.model

    @property
    def paused(self) -> str | None:
        """Why a batch is not believed and nothing is learned now; None while it learns."""
        return self._node.current_warnings.paused

    def damping(self, rate: ArrayLike) -> Prediction:
        """The damping at (n,) velocities, or one.

        Raises:
            BadInput: nothing has been learned yet, or a velocity is not finite.
        """
        check_trained(self.model)
        return self.model.predict(rate)

    def to_dict(self) -> dict[str, Any]:
        """The snapshot that `serve` would publish; empty before anything is learned."""
        latest = self._node.latest()
        return {} if latest is None else to_plain(latest)


def _values(name: str, given: ArrayLike) -> Array:
    try:
        values = np.array(given, dtype=np.float64, ndmin=1)
    except (TypeError, ValueError):
        raise BadInput(f"{name} is no number, and no array of them") from None
    if values.ndim > 1:
        raise BadInput(f"{name} has {values.ndim} dimensions; give one value for each stamp")
    return values
