"""The path of one learner's measurements to batches of samples.

The streams go through the synchroniser; its samples wait here until they fill a batch. Everything is bounded: under
overload the oldest samples go and are counted.

The streams' stamps alone say which values belong together. Where one clock is an hour ahead, they say so, an hour
later, of values that are an hour apart. So while the clocks of two streams that come by turns differ by more than
JUMP_S, no sample is taken, but counted as `clocks_apart`. This follows from the order of arrival, not from a clock
on the wall.
"""

from __future__ import annotations

import math
import threading
from collections import Counter, deque
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from incsvr.compensation.freeing import takes_torque
from incsvr.errors import BadInput
from incsvr.numerics import Array
from incsvr.numerics.plain import from_plain, to_plain
from incsvr.signals import REQUIRED, TORQUE, YAW_RATE, SignalSettings, Synchroniser, play
from incsvr.signals.samples import Samples
from incsvr.signals.streams import JUMP_S, Reading

if TYPE_CHECKING:
    from incsvr.compensation.effects_in_force import Compensation
    from incsvr.plant.body import Coupled
    from incsvr.signals.torque_takers import TakesTorque
    from service.learner.window import Window

MAX_WAITING_BATCHES = 200
"""Batches that may wait for training; beyond, the oldest samples go and are counted."""
CLOCKS_APART_TURNS = 40
"""The turns of yaw rate and torque, never at the same time, after which their clocks are apart."""


class Batches:
    """The samples on their way to the next iteration; every method may be called from any thread.

    Args:
        settings: how streams become samples.
        size: samples of a batch.
        memory: what an earlier `to_dict` gave, to go on from there.
        compensation: the traced effects that samples are freed of.
        window: keeps the newest raw data, so that the samples can begin anew with other effects.
        coupled: the axis in its body, of whose other velocities samples are freed.
        inputs: channels that damping is learned over: samples without one of them are left out and counted.
    """

    def __init__(
        self,
        settings: SignalSettings,
        size: int,
        memory: Mapping[str, Any] | None = None,
        compensation: Compensation | None = None,
        window: Window | None = None,
        coupled: Coupled | None = None,
        inputs: tuple[str, ...] = (),
    ) -> None:
        self._inputs = inputs
        self._settings, self._size, self._compensation, self._coupled = settings, size, compensation, coupled
        self._window = window
        self._lock = threading.Lock()
        self._synchroniser = Synchroniser(settings, self._takes(compensation))
        self._waiting: deque[Samples] = deque()
        self._waiting_count = 0
        self._refused: dict[str, int] = {}
        self._spikes: Counter[str] = Counter()
        self._turns, self._turn, self._leads = 0, "", 0.0
        self._recent_rates: deque[float] = deque(maxlen=10)
        self._newest = Samples.empty()
        self._clock_restarts = 0
        self.samples_seen = 0
        if memory is not None:
            # Under other settings the streams begin anew: what they held was cut to the old ones.
            if memory["synchroniser"]["settings"] == self._synchroniser.to_dict()["settings"]:
                self._synchroniser = Synchroniser.from_dict(memory["synchroniser"], self._takes(compensation))
                self._turns = int(memory["turns"])
            self._refused = {reason: -count for reason, count in self._synchroniser.rejected.items()}
            self._take(from_plain(Samples, memory["waiting"]))

    def _takes(self, compensation: Compensation | None) -> TakesTorque | None:
        """The torques that are subtracted from samples with these effects in force."""
        return takes_torque(self._settings, compensation, self._coupled)

    def push(self, stream: str, t: Array, value: Array) -> bool:
        """Takes (n,) stamps [s] and values of a stream, n ≥ 1; True where a batch waits to be learned."""
        with self._lock:
            if self._window is not None:
                self._window.push(stream, t, value)
            if t.size == 1:  # three times as quick, and the most frequent case by far
                self._synchroniser.push_one(stream, float(t[0]), float(value[0]))
            else:
                self._synchroniser.push(stream, t, value)
            self._count_turns(stream)
            restarts = self._synchroniser.clock_restarts
            samples = self._synchroniser.ready()
            if self._window is not None and self._synchroniser.clock_restarts > restarts:
                self._window.start_over()
            if not self.clocks_apart:
                self._take(samples)
            elif len(samples):
                self._refused["clocks_apart"] = self._refused.get("clocks_apart", 0) + len(samples)
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

    def recent(self, until: float | None = None) -> dict[str, tuple[Array, Array]]:
        """The raw data of the window that ends at `until` [s], None for the newest stamp: name → (stamps [s], values);
        nothing without a window."""
        with self._lock:
            return {} if self._window is None else self._window.streams(until)

    def window_end(self, until: float | None = None) -> float | None:
        """The end of the window [s], where it is full: `until`, or the newest stamp where that is earlier or None."""
        with self._lock:
            if self._window is None or self.clocks_apart:
                return None
            end = self._window.newest if until is None else min(until, self._window.newest)
            return end if self._window.is_full(end) else None

    def samples_under(self, compensation: Compensation | None, until: float, since: float = -math.inf) -> Samples:
        """The window's samples from `since` to `until` [s], as they are with these effects; nothing changes."""
        samples = play(Synchroniser(self._settings, self._takes(compensation)), self.recent())
        return samples.take((samples.time >= since) & (samples.time <= until) & samples.known(self._inputs))

    def restart(self, compensation: Compensation | None, after: float, clock_restarts: int) -> None:
        """Subtracts these effects from samples from now on; those after `after` [s] wait for the next batch.

        Raises:
            BadInput: the clock that `after` is of began anew. Whatever is raised, nothing has changed.
        """
        with self._lock:
            if self._restarts != clock_restarts:
                raise BadInput("the vehicle's clock restarted meanwhile")
            streams = {} if self._window is None else self._window.streams()
            synchroniser = Synchroniser(self._settings, self._takes(compensation))
            samples = play(synchroniser, streams)
            samples = samples.take(samples.time > after)
            for reason, count in self._synchroniser.rejected.items():
                self._refused[reason] = self._refused.get(reason, 0) + count
            self._spikes.update(self._synchroniser.spikes)
            self._spikes.subtract(synchroniser.spikes)  # the window's, which are counted already
            self._clock_restarts = self._restarts
            self._synchroniser, self._compensation = synchroniser, compensation
            self._waiting.clear()
            seen, self._waiting_count = self.samples_seen, 0
            self._take(samples)
            self.samples_seen = seen

    @property
    def compensation(self) -> Compensation | None:
        """The traced effects that samples are freed of now."""
        with self._lock:
            return self._compensation

    @property
    def rejected(self) -> dict[str, int]:
        """Values that were not learned from since this start, by reason."""
        with self._lock:
            total = dict(self._refused)
            for reason, count in self._synchroniser.rejected.items():
                total[reason] = total.get(reason, 0) + count
        return {reason: count for reason, count in total.items() if count}

    @property
    def spikes(self) -> dict[str, int]:
        """Values that were left out before the filter since this start, by stream."""
        with self._lock:
            return dict(self._spikes + Counter(self._synchroniser.spikes))

    @property
    def clock_restarts(self) -> int:
        """The number of restarts of the vehicle's clock since this start."""
        with self._lock:
            return self._restarts

    @property
    def clocks_apart(self) -> bool:
        """Whether yaw rate and torque come, and their clocks never show the same time."""
        return self._turns >= CLOCKS_APART_TURNS

    @property
    def readings(self) -> dict[str, Reading]:
        """The present readings of every stream's clock."""
        with self._lock:
            return dict(self._synchroniser.readings)

    @property
    def rejected_by_stream(self) -> Mapping[str, Mapping[str, int]]:
        """Values that the streams refused, by stream and reason."""
        with self._lock:
            return self._synchroniser.rejected_by_stream

    @property
    def smoothing(self) -> float:
        """The width of the filter now [s]."""
        with self._lock:
            return self._synchroniser.smoothing

    @property
    def recent_rates(self) -> tuple[float, ...]:
        """Yaw rates of the newest few samples [rad/s]."""
        with self._lock:
            return tuple(self._recent_rates)

    @property
    def newest(self) -> Samples:
        """The newest few samples with their further velocities; empty where damping is learned over one."""
        with self._lock:
            return self._newest

    def to_dict(self) -> dict[str, Any]:
        """The streams and samples on their way to the next batch, as plain data."""
        with self._lock:
            return {
                "synchroniser": self._synchroniser.to_dict(),
                "waiting": to_plain(Samples.concatenate(self._waiting)),
                "turns": self._turns,
            }

    @property
    def _restarts(self) -> int:
        return self._clock_restarts + self._synchroniser.clock_restarts

    def _count_turns(self, stream: str) -> None:
        """Counts how often yaw rate and torque came by turns since their clocks showed the same time."""
        if stream not in REQUIRED or stream == self._turn:
            return
        self._turn = stream
        rate, torque = (self._synchroniser.newest(name) for name in (YAW_RATE, TORQUE))
        lead = 0.0 if rate is None or torque is None else rate - torque
        # Played faster than they are taken in, each is ahead in its turn.
        together = abs(lead) <= JUMP_S or lead * self._leads < 0.0
        self._turns = 0 if together else self._turns + 1
        self._leads = lead

    def _take(self, samples: Samples) -> None:
        for name in self._inputs if len(samples) else ():
            known = samples.known((name,))
            missing = int(np.count_nonzero(~known))
            if missing:
                self._refused[f"no_{name}"] = self._refused.get(f"no_{name}", 0) + missing
                samples = samples.take(known)
        if not len(samples):
            return
        self._waiting.append(samples)
        self._waiting_count += len(samples)
        self.samples_seen += len(samples)
        self._recent_rates.extend(samples.yaw_rate[-10:].tolist())
        if self._inputs:
            self._newest = Samples.concatenate((self._newest, samples)).take(slice(-10, None))
        excess = self._waiting_count - MAX_WAITING_BATCHES * self._size
        if excess > 0:
            self._refused["overload"] = self._refused.get("overload", 0) + excess
            kept = Samples.concatenate(self._waiting).take(slice(excess, None))
            self._waiting = deque([kept])
            self._waiting_count = len(kept)
