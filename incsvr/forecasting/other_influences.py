"""The influences on an axis beside its own torque, on a grid: other velocities, channels, the rest of a body."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array, Streams
from incsvr.plant.body import Coupled
from incsvr.signals.coupled import motion_at

HEADING = "heading"
"""The channel that counts on over whole turns [rad]."""


@dataclass(frozen=True, slots=True)
class OtherInfluences:
    """The influences at (n,) points.

    Attributes:
        channels: name → (n,) values, on lines between those that came.
        outside, linear: (n,) a [N m] and b [N m s] of what the rest of the body takes of the torque, a + b r; None of
            an axis by itself.
    """

    channels: Mapping[str, Array] = field(default_factory=dict)
    outside: Array | None = None
    linear: Array | None = None

    @staticmethod
    def at(
        time: Array, streams: Streams, names: Sequence[str], body: Coupled | None, smoothing: float
    ) -> OtherInfluences:
        """The influences at the instants `time` (n,) [s]; a stream is constant before and after its values.

        Args:
            streams: name → (stamps [s], values), at least one value of each of `names` and of the body's.
            names: of the channels.
            body: the axis in its body; None takes it by itself.
            smoothing: width of the filter of the body's velocities [s].
        """
        channels = {name: _on_lines(time, *streams[name], name == HEADING) for name in names}
        if body is None or time.size < 2:
            return OtherInfluences(channels)
        outside, linear = body.driving(*motion_at(body, streams, time, smoothing), time.size)
        return OtherInfluences(channels, outside, linear)

    def take(self, kept: NDArray[np.bool_] | slice) -> OtherInfluences:
        """The points that are kept."""
        outside, linear = (None if each is None else each[kept] for each in (self.outside, self.linear))
        return OtherInfluences({name: values[kept] for name, values in self.channels.items()}, outside, linear)


BY_ITSELF = OtherInfluences()
"""Nothing."""


def _on_lines(time: Array, stamps: Array, values: Array, turning: bool) -> Array:
    return np.interp(time, stamps, np.unwrap(values) if turning else values)
