"""The picture of a log before anything is learned from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from incsvr.numerics import Array
from incsvr.plant.axes import Axis
from incsvr.signals.samples import Samples


@dataclass(frozen=True, slots=True)
class LogPicture:
    """A log's streams and what the learner would make of them.

    Attributes:
        name: of the log.
        axis: which is meant.
        streams: stamps (n,) [s] and values (n,) by name: yaw_rate and torque of the axis, then the channels.
        units: SI units of the channels that came with a unit.
        samples: the damping samples; None where there are none.
        batch: samples that a batch holds.
        remarks: what is to be known of them, or why there are no samples, one sentence each.
    """

    name: str
    axis: Axis
    streams: Mapping[str, tuple[Array, Array]]
    units: Mapping[str, str]
    samples: Samples | None
    batch: int
    remarks: tuple[str, ...]
