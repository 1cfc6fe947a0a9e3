"""From measurements to batches: what one learner holds before it learns.

The streams go through the synchroniser; its samples wait here until they fill a batch. Everything is bounded: under
overload the oldest samples go and are counted. Where the vehicle's clock begins anew, so does the synchroniser.
"""

from __future__ import annotations

import math
import threading
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from incsvr.errors import BadInput
from incsvr.samples import Array, Samples
from incsvr.signals import REQUIRED, SignalSettings, Synchroniser, play

if TYPE_CHECKING:
    from incsvr.compensation import Compensation
    from service.window import Window

#: Batches that may wait for training; beyond, the oldest samples go and are counted.
WAITING_BATCHES = 200
#: Two streams that stay this far behind their own past [s] for so many values belong to a clock that began anew.
RESTART_S, RESTART_VALUES = 10.0, 20
#: Values that may wait for that to be known.
HELD_VALUES = 20_000


@dataclass(slots=True)
class _Held:
    """Values that are far behind their stream, and wait."""

    parts: list[tuple[Array, Array]] = field(default_factory=list)
    count: int = 0

    def take(self) -> tuple[Array, Array]:
        """All of them, and none are left."""
        nothing = np.empty(0)
        t = np.concatenate([nothing, *(part[0] for part in self.parts)])
        value = np.concatenate([nothing, *(part[1] for part in self.parts)])
        self.parts, self.count = [], 0
        return t, value


class Batches:
    """The samples on their way to the next iteration; every method may be called from any thread.

    Args:
        settings: how streams become samples.
        size: samples of a batch.
        memory: what an earlier `to_dict` gave, to go on from there.
        compensation: the traced effects that samples are freed of.
        window: keeps the newest raw data, so that the samples can begin anew with other effects.
    """

    def __init__(
        self,
        settings: SignalSettings,
        size: int,
        memory: Mapping[str, Any] | None = None,
        compensation: Compensation | None = None,
        window: Window | None = None,
    ) -> None:
        self._settings, self._size, self._compensation = settings, size, compensation
        self._window = window
        self._lock = threading.Lock()
        self._synchroniser = Synchroniser(settings, compensation)
        self._waiting: deque[Samples] = deque()
        self._waiting_count = 0
        self._behind = {stream: _Held() for stream in REQUIRED}
        self._refused: dict[str, int] = {}
        self._recent_rates: deque[float] = deque(maxlen=10)
        self.clock_restarts = 0
        self.samples_seen = 0
        if memory is not None:
            # Under other settings the streams begin anew: what they held was cut to the old ones.
            if memory["synchroniser"]["settings"] == self._synchroniser.to_dict()["settings"]:
                self._synchroniser = Synchroniser.from_dict(memory["synchroniser"], compensation)
            self._refused = {reason: -count for reason, count in self._synchroniser.rejected.items()}
            self._take(_samples(memory["waiting"]))

    def push(self, stream: str, t: Array, value: Array) -> bool:
        """Takes (n,) stamps [s] and values of a stream, n ≥ 1; True where a batch waits to be learned."""
        with self._lock:
            if stream in self._behind:
                t, value = self._hold_back(stream, t, value)
            if self._window is not None:
                self._window.push(stream, t, value)
            if t.size == 1:  # three times as quick, and the most frequent case by far
                self._synchroniser.push_one(stream, float(t[0]), float(value[0]))
            else:
                self._synchroniser.push(stream, t, value)
            if all(held.count >= RESTART_VALUES for held in self._behind.values()):
                self._restart_clock()
            self._take(self._synchroniser.ready())
            return self._waiting_count >= self._size

    def next_batch(self) -> Samples | None:
        """The samples of the next iteration, where so many wait."""
        size = self._size
        with self._lock:
            if self._waiting_count < size:
                return None
            parts, count = [], 0
            while count < size:
                parts.append(self._waiting.popleft())
                count += len(parts[-1])
            joined = Samples.concatenate(parts)
            if count > size:
                self._waiting.appendleft(joined.take(slice(size, None)))
            self._waiting_count -= size
        return joined.take(slice(0, size))

    def recent(self) -> dict[str, tuple[Array, Array]]:
        """The raw data of the window, name → (stamps [s], values); nothing without one."""
        with self._lock:
            return {} if self._window is None else self._window.streams()

    def covers(self) -> float | None:
        """The newest stamp of the window [s], where it is full."""
        with self._lock:
            return self._window.newest if self._window is not None and self._window.full else None

    def freed(self, compensation: Compensation | None, until: float) -> Samples:
        """The window's samples up to and with the time `until` [s], as they are with these effects; nothing changes."""
        samples = play(Synchroniser(self._settings, compensation), self.recent())
        return samples.take(samples.time <= until)

    def begin_anew(self, compensation: Compensation | None, after: float, clock_restarts: int) -> None:
        """From now on samples are freed of these effects; those after the time `after` [s] wait for the next batch.

        Raises:
            BadInput: the clock that `after` is of began anew. Whatever is raised, nothing has changed.
        """
        with self._lock:
            if self.clock_restarts != clock_restarts:
                raise BadInput("the vehicle's clock began anew meanwhile")
            streams = {} if self._window is None else self._window.streams()
            synchroniser = Synchroniser(self._settings, compensation)
            samples = play(synchroniser, streams)
            samples = samples.take(samples.time > after)
            self._count_refused()
            self._synchroniser, self._compensation = synchroniser, compensation
            self._waiting.clear()
            seen, self._waiting_count = self.samples_seen, 0
            self._take(samples)
            self.samples_seen = seen

    @property
    def rejected(self) -> dict[str, int]:
        """Values that were not learned from since this start, by reason."""
        with self._lock:
            total = dict(self._refused)
            for reason, count in self._synchroniser.rejected.items():
                total[reason] = total.get(reason, 0) + count
        return {reason: count for reason, count in total.items() if count}

    @property
    def recent_rates(self) -> tuple[float, ...]:
        """Yaw rates of the newest few samples [rad/s]."""
        with self._lock:
            return tuple(self._recent_rates)

    def to_dict(self) -> dict[str, Any]:
        """All that is on its way, as plain data."""
        with self._lock:
            return {
                "synchroniser": self._synchroniser.to_dict(),
                "waiting": _plain(Samples.concatenate(self._waiting)),
            }

    def _hold_back(self, stream: str, t: Array, value: Array) -> tuple[Array, Array]:
        """What may go on now. Stamps far behind wait until it is known whether the vehicle's clock began anew.

        They are late where their own stream goes on ahead of them.
        """
        held, newest = self._behind[stream], self._synchroniser.newest(stream)
        if newest is None or (not held.count and t.min() >= newest - RESTART_S):
            return t, value
        ahead = np.flatnonzero(~((t >= 0.0) & (t < newest - RESTART_S)))
        end = int(ahead[-1]) + 1 if ahead.size else 0
        if not end and held.count + t.size <= HELD_VALUES:
            held.parts.append((t, value))
            held.count += t.size
            return t[:0], value[:0]
        before = held.take()
        if end < t.size:
            held.parts.append((t[end:], value[end:]))
            held.count = t.size - end
        return np.concatenate((before[0], t[:end])), np.concatenate((before[1], value[:end]))

    def _restart_clock(self) -> None:
        """Begins anew where both streams show that the vehicle's clock did (it was switched off and on)."""
        self._count_refused()
        self._refused["clock_restarted"] = self._refused.get("clock_restarted", 0) + 1
        self._synchroniser = Synchroniser(self._settings, self._compensation)
        if self._window is not None:
            self._window.clear()
        for stream, held in self._behind.items():
            t, value = held.take()
            self._synchroniser.push(stream, t, value)
            if self._window is not None:
                self._window.push(stream, t, value)
        self.clock_restarts += 1

    def _count_refused(self) -> None:
        """Keeps the counts of a synchroniser that goes."""
        for reason, count in self._synchroniser.rejected.items():
            self._refused[reason] = self._refused.get(reason, 0) + count

    def _take(self, samples: Samples) -> None:
        if not len(samples):
            return
        self._waiting.append(samples)
        self._waiting_count += len(samples)
        self.samples_seen += len(samples)
        self._recent_rates.extend(samples.yaw_rate[-10:].tolist())
        excess = self._waiting_count - WAITING_BATCHES * self._size
        if excess > 0:
            self._refused["overload"] = self._refused.get("overload", 0) + excess
            kept = Samples.concatenate(self._waiting).take(slice(excess, None))
            self._waiting = deque([kept])
            self._waiting_count = len(kept)


def _plain(samples: Samples) -> dict[str, Any]:
    return {
        "time": samples.time.tolist(),
        "yaw_rate": samples.yaw_rate.tolist(),
        "damping": samples.damping.tolist(),
        "channels": {name: sampled(values) for name, values in samples.channels.items()},
        "parts": {name: values.tolist() for name, values in samples.parts.items()},
    }


def sampled(values: Array) -> tuple[float | None, ...]:
    """A channel's values as JSON knows them: None where it was not sampled, or filtered beyond all floats."""
    return tuple(value if math.isfinite(value) else None for value in values.tolist())


def _samples(plain: Mapping[str, Any]) -> Samples:
    return Samples(
        np.array(plain["time"], dtype=np.float64),
        np.array(plain["yaw_rate"], dtype=np.float64),
        np.array(plain["damping"], dtype=np.float64),
        *(
            {name: np.array(values, dtype=np.float64) for name, values in plain.get(kind, {}).items()}
            for kind in ("channels", "parts")
        ),
    )
