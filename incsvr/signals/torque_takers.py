"""The interface for torques other than damping and the axis's own inertia, subtracted from each sample."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from incsvr.numerics import Array, Streams
from incsvr.signals.smoothing import Smoothed


@dataclass(frozen=True, slots=True)
class TorqueSplit:
    """The torque at (n,) instants, part by part; NaN where a part is not known.

    Attributes:
        torque: the stream, less what the body's other velocities and its attitude take.
        damping: (n,) d [N m].
        parts: what the declared inertia and everything else takes, (n,) each [N m]; with the damping they add up to the
            torque that was measured.
    """

    torque: Smoothed
    damping: Array
    parts: Mapping[str, Array]


class TakesTorque(Protocol):
    """Torques that are subtracted from samples, along a vehicle's streams; their memory is as long as the streams'.

    The synchroniser hands it the streams as far as they are settled, and asks it at the samples. What it says follows
    from stamps and values alone.
    """

    @property
    def on_a_line(self) -> bool:
        """Whether it knows no torque but one on a line between two stamps."""

    @property
    def needed(self) -> float:
        """Stamps from here on are still needed [s]."""

    @property
    def ahead(self) -> float:
        """The time by which the torque must be ahead of the yaw rate [s]."""

    def advance(self, streams: Streams, until: float) -> None:
        """Takes the streams up to and with a time [s] before which all are settled."""

    def split(
        self, at: Array, streams: Streams, torque: Smoothed, yaw_rate: Smoothed, smoothing: float, gap: float
    ) -> TorqueSplit:
        """The torque at (n,) instants [s]; `smoothing` and `gap` [s] are those of the two smoothed streams."""

    def anew(self) -> TakesTorque:
        """A taker that has seen nothing, for clocks that began anew."""

    def to_dict(self) -> dict[str, Any] | None:
        """The whole state as plain data; None where it has none. `restore` goes on from it."""

    def restore(self, data: Any) -> None:
        """Takes up what `to_dict` of the same gave."""
