"""What the sensors of many missions sample while they are played, and what their controllers have seen of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from incsvr.numerics import Array
from simulator.physics import STEP
from simulator.sensors import HEADING, QUANTITIES, Samples


class Log:
    """The log of missions.

    Args:
        samples: of each mission by quantity: when it is sampled, and how wrongly.

    Attributes:
        values: of each mission by quantity (n,), as sampled.
        seen: (missions, quantities) what has come last.
    """

    def __init__(self, samples: Sequence[dict[str, Samples]]) -> None:
        streams = [(k, name, each) for k, own in enumerate(samples) for name, each in own.items()]
        sizes = [each.at.size for *_, each in streams]
        self._mission = np.repeat([k for k, *_ in streams], sizes).astype(np.intp)
        self._quantity = np.repeat([QUANTITIES.index(name) for _, name, _ in streams], sizes).astype(np.intp)
        self._at, self._stamp, self._error = (
            np.concatenate([getattr(each, name) for *_, each in streams]) for name in ("at", "stamps", "error")
        )
        self._taken, self._arrived = np.argsort(self._at, kind="stable"), np.argsort(self._stamp, kind="stable")
        self._sorted_at, self._sorted_stamp = self._at[self._taken], self._stamp[self._arrived]
        self._value = np.zeros(self._at.size)
        self._next = self._next_stamp = 0
        parts = np.split(self._value, np.cumsum(sizes)[:-1])
        self.values = [
            {name: part for (of, name, _), part in zip(streams, parts, strict=True) if of == k}
            for k in range(len(samples))
        ]
        self.seen = np.zeros((len(samples), len(QUANTITIES)))

    def take(self, now: float, length: float, chunk: Array) -> None:
        """Samples until now [s] of the chunk (steps + 1, missions, quantities) that ends now and is so long [s]."""
        end = int(np.searchsorted(self._sorted_at, now + 1e-9, side="right"))
        if end > self._next:
            which = self._taken[self._next : end]
            place = np.clip((self._at[which] - (now - length)) / STEP, 0.0, chunk.shape[0] - 1)
            below = np.minimum(place.astype(np.intp), chunk.shape[0] - 2)
            mission, quantity = self._mission[which], self._quantity[which]
            before, after = chunk[below, mission, quantity], chunk[below + 1, mission, quantity]
            self._value[which] = before + (place - below) * (after - before) + self._error[which]
            self._next = end
        if self._next_stamp == 0:
            self.seen[:, HEADING] = chunk[-1, :, HEADING]
        arrived = int(np.searchsorted(self._sorted_stamp, now + 1e-9, side="right"))
        if arrived > self._next_stamp:
            which = self._arrived[self._next_stamp : arrived]
            self.seen[self._mission[which], self._quantity[which]] = self._value[which]
            self._next_stamp = arrived
