"""Samples: what the learner learns from, one row for each instant."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from incsvr.numerics import Array

Indices = NDArray[np.intp] | NDArray[np.bool_] | slice

_NONE: Mapping[str, Array] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Samples:
    """Damping samples y = d(r) (Eq. 5 for one degree of freedom), in the order of their time.

    Attributes:
        time: (n,) the vehicle's time [s].
        yaw_rate: (n,) r [rad/s].
        damping: (n,) d = τ − I ṙ [N m].
        channels: further channels by name, each (n,), NaN where a channel was not sampled.
        parts: where effects are in force, what the declared inertia and each effect take of the torque, (n,) each
            [N m]; with the damping they add up to it.
        raw: what the streams showed around each sample, (n,) each (incsvr.signals.raw); empty where nobody looked.
    """

    time: Array
    yaw_rate: Array
    damping: Array
    channels: Mapping[str, Array] = field(default_factory=lambda: _NONE)
    parts: Mapping[str, Array] = field(default_factory=lambda: _NONE)
    raw: Mapping[str, Array] = field(default_factory=lambda: _NONE)

    def __len__(self) -> int:
        return self.time.size

    def take(self, index: Indices) -> Samples:
        """The samples at `index`: an array of positions, a mask or a slice."""
        return Samples(
            self.time[index],
            self.yaw_rate[index],
            self.damping[index],
            {name: values[index] for name, values in self.channels.items()},
            {name: values[index] for name, values in self.parts.items()},
            {name: values[index] for name, values in self.raw.items()},
        )

    def known(self, names: Sequence[str]) -> NDArray[np.bool_]:
        """(n,) where every one of these channels was sampled."""
        there = np.ones(len(self), dtype=bool)
        for name in names:
            there &= np.isfinite(self.channels.get(name, np.full(len(self), np.nan)))
        return there

    @staticmethod
    def empty() -> Samples:
        nothing = np.empty(0)
        return Samples(nothing, nothing, nothing)

    @staticmethod
    def concatenate(parts: Iterable[Samples]) -> Samples:
        """All samples of `parts`, in their order; a channel that a part lacks is NaN there."""
        kept = [part for part in parts if len(part)]
        if not kept:
            return Samples.empty()
        if len(kept) == 1:
            return kept[0]
        return Samples(
            np.concatenate([part.time for part in kept]),
            np.concatenate([part.yaw_rate for part in kept]),
            np.concatenate([part.damping for part in kept]),
            _joined([part.channels for part in kept], kept),
            _joined([part.parts for part in kept], kept),
            _joined([part.raw for part in kept], kept),
        )


def _joined(columns: Sequence[Mapping[str, Array]], samples: Sequence[Samples]) -> dict[str, Array]:
    names = sorted({name for each in columns for name in each})
    pairs = list(zip(columns, samples, strict=True))
    return {
        name: np.concatenate([each.get(name, np.full(len(part), np.nan)) for each, part in pairs]) for name in names
    }
