"""Streams with their own clocks, rates, jitter and faults become damping samples on one grid (Section IV-A).

The grid is the multiples of the sample period in the vehicle's own time. A sample stands there as soon as every stream
has passed it by half the smoothing window and the lateness, so that nothing that still may come could change it. Its
yaw rate and its damping moment d = τ − I ṙ (Eq. 5) are computed from the stamps and values around it alone.

Deterministic: the samples depend on each stream's own messages, in that stream's order, and on their stamps. How the
messages are bundled, how the streams are interleaved and when `ready` is called make no difference, to the last bit.
Only a stream that falls further behind than the bounds below (JUMP_S for a channel, MAX_WAITING_VALUES for yaw rate and
torque) is not waited for. The same code serves recordings, the simulator and the service.

Where the clock of yaw rate or torque goes back (`incsvr.signals.streams`), no sample is made until both clocks show the
same time again, within JUMP_S; then samples start over at the stamp since which both clocks run. The last seconds
before are lost, and old values are never paired with new ones. Stamps that never overlap give no sample.
`incsvr.signals.filter_width` says how the filter follows slow streams. A channel that was not configured is waited for
while it comes: once it is JUMP_S behind, it delays nothing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict
from math import ceil, inf, isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from incsvr.errors import BadInput
from incsvr.signals.holding import filters
from incsvr.signals.samples import Samples
from incsvr.signals.sampling import samples_at
from incsvr.signals.settings import (
    MAX_CHANNELS,
    MAX_PAUSE_S,
    REQUIRED,
    TORQUE,
    WIDENING_FACTOR,
    YAW_RATE,
    SignalSettings,
)
from incsvr.signals.spikes import SpikeCount
from incsvr.signals.streams import JUMP_S, Reading, Stream, channel, empty_streams
from incsvr.signals.torque_takers import TakesTorque

STATE_FORM = 3
"""Number of the form of what `to_dict` gives."""
_BLOCK_SAMPLES = 4096
"""Samples that are made at once, at most: the memory stays bounded."""
_STAMP_ROUNDING_S = 1e-3
"""Time by which stamps of any clock are rounded, at most [s]."""
_NOTHING = Samples.empty()


class Synchroniser:
    """Takes messages of all streams and yields the samples that are complete; its memory is bounded.

    The samples are free of what `takes` of the torque beside damping and inertia, and say what each part of it took;
    None frees them of nothing. The streams that it reads are among the channels of the settings, so that samples wait.
    """

    def __init__(self, settings: SignalSettings, takes: TakesTorque | None = None) -> None:
        self.settings, self._takes = settings, takes
        self._streams = empty_streams(settings)
        self._compared = (0.0, 0.0, 0.0)  # since when the clocks looked at last were set, and the yaw rate's lead [s]
        self._refused: Counter[str] = Counter()
        self._go_on(0)
        self._widening = 0
        self.clock_restarts = 0
        """The number of times at which samples started over because a clock went back."""
        self._spikes = SpikeCount()

    @property
    def rejected(self) -> Mapping[str, int]:
        """The number of refused messages, by reason."""
        total = Counter(self._refused)
        for stream in self._streams.values():
            total.update(stream.rejected)
        return dict(total)

    @property
    def rejected_by_stream(self) -> Mapping[str, Mapping[str, int]]:
        """The number of refused messages, by stream and reason."""
        return {name: dict(stream.rejected) for name, stream in self._streams.items() if stream.rejected}

    @property
    def spikes(self) -> Mapping[str, int]:
        """The number of values left out before the filter because they do not fit their neighbours."""
        return self._spikes.counts

    @property
    def readings(self) -> Mapping[str, Reading]:
        """The present readings of all streams, by name."""
        return {name: stream.reading() for name, stream in self._streams.items()}

    @property
    def smoothing(self) -> float:
        """The width of the filter at the newest samples [s]: as configured, or wider for a slow stream."""
        return float(self.settings.smoothing * WIDENING_FACTOR**self._widening)

    def newest(self, name: str) -> float | None:
        """The newest stamp of a stream's clock [s]; None before its first two messages."""
        stream = self._streams.get(name)
        return None if stream is None or not isfinite(stream.newest) else stream.newest

    def push_one(self, name: str, time: float, value: float) -> None:
        """Takes one message: its stamp [s] and value ([rad/s] of "yaw_rate", [N m] of "torque", or a channel's)."""
        stream = self._stream(name)
        if stream is not None:
            stream.push(time, value)
        else:
            self._refused["too_many_channels"] += 1

    def push(self, name: str, time: ArrayLike, value: ArrayLike) -> None:
        """Takes many messages of one stream: (n,) stamps [s] and values, the same as n times push_one.

        Raises:
            BadInput: where the lengths differ.
        """
        stamps, values = (np.atleast_1d(np.asarray(part, dtype=np.float64)) for part in (time, value))
        if stamps.shape != values.shape or stamps.ndim != 1:
            raise BadInput(f"{name}: {stamps.size} time stamps and {values.size} values; give one stamp for each value")
        stream = self._stream(name)
        if stream is not None:
            stream.push_many(stamps, values)
        else:
            self._refused["too_many_channels"] += stamps.size

    def ready(self) -> Samples:
        """All samples that became complete since the last call, in the order of their time."""
        rate, torque = self._streams[YAW_RATE], self._streams[TORQUE]
        if (rate.began_anew or torque.began_anew) and not self._start_over(rate, torque):
            return _NOTHING
        return self._completed()

    def _completed(self) -> Samples:
        """The samples that became complete since the last call."""
        rate, torque = self._streams[YAW_RATE].newest, self._streams[TORQUE].newest
        if (rate if rate < torque else torque) < self._due:
            return _NOTHING
        ahead = 0.0 if self._takes is None else self._takes.ahead
        moving = min(self._streams[YAW_RATE].settled, self._streams[TORQUE].settled - ahead)
        if self._next * self.settings.sample_period >= moving - self.settings.reach:
            return _NOTHING
        channels = [
            stream.settled
            for name, stream in self._streams.items()
            if name not in REQUIRED and (name in self.settings.channels or moving - stream.settled <= JUMP_S)
        ]
        settled = max(min([moving, *channels]), moving - JUMP_S) if channels else moving
        end = ceil((settled - self.settings.reach) / self.settings.sample_period)
        return self._samples(end, settled) if end > self._next else _NOTHING

    def _stream(self, name: str) -> Stream | None:
        """The stream of that name; of a channel that was not declared a new one, as long as there is room."""
        stream = self._streams.get(name)
        if stream is not None or len(self._streams) >= MAX_CHANNELS + len(REQUIRED):
            return stream
        return self._streams.setdefault(name, channel(self.settings))

    def _start_over(self, rate: Stream, torque: Stream) -> bool:
        """Starts over where both clocks show the same time again; False where they do not yet."""
        (*sinces, led), lead = self._compared, rate.newest - torque.newest
        self._compared = (rate.since, torque.since, lead)
        # Played faster than they are taken in, two clocks that agree overtake each other.
        if abs(lead) > JUMP_S and not (sinces == [rate.since, torque.since] and lead * led < 0.0):
            return False
        begin = max(rate.since, torque.since)
        for stream in self._streams.values():
            if abs(stream.newest - min(rate.newest, torque.newest)) > JUMP_S and stream not in (rate, torque):
                stream.clear()  # a channel that has still to come
            stream.cut(begin - JUMP_S, "clocks_apart")
            stream.began_anew = False
        self.clock_restarts += 1
        self._refused["clock_restarted"] += 1
        self._spikes.clock_began_anew()
        self._go_on(ceil((begin - self.settings.reach) / self.settings.sample_period))
        if self._takes is not None:
            self._takes = self._takes.anew()
        return True

    def to_dict(self) -> dict[str, Any]:
        """The whole state as plain data, exact to the bit in JSON; `restore` continues from it."""
        return {
            "settings": asdict(self.settings) | {"channels": list(self.settings.channels), "form": STATE_FORM},
            "next": self._next,
            "refused": dict(self._refused),
            "streams": {name: stream.to_dict() for name, stream in self._streams.items()},
            "ledger": None if self._takes is None else self._takes.to_dict(),
        }

    @staticmethod
    def from_dict(data: Mapping[str, Any], takes: TakesTorque | None = None) -> Synchroniser:
        """The synchroniser whose to_dict gave `data`; `takes` is the same as then, and has seen nothing."""
        given = {name: value for name, value in data["settings"].items() if name != "form"}
        settings = SignalSettings(**{**given, "channels": tuple(given["channels"])})
        synchroniser = Synchroniser(settings, takes)
        if takes is not None:
            takes.restore(data["ledger"])
        synchroniser._go_on(int(data["next"]))
        synchroniser._refused = Counter(data["refused"])
        for name, stream in data["streams"].items():
            synchroniser._streams.setdefault(name, channel(settings)).restore(stream)
        return synchroniser

    def _go_on(self, following: int) -> None:
        """The next sample on the grid; it is not complete before `_due` [s] on both clocks, which is quick to see."""
        self._next = following
        settings = self.settings
        self._due = following * settings.sample_period + settings.reach + settings.lateness - _STAMP_ROUNDING_S

    def _samples(self, end: int, settled: float) -> Samples:
        """The samples on the grid from where the last call ended up to `end`, without those across a gap.

        It ends before the first whose filter, where it is wider, reaches beyond what is settled [s].
        """
        period, reach = self.settings.sample_period, self.settings.reach
        widest = self.settings.widest_reach
        far = widest + MAX_PAUSE_S
        held = {name: stream.arrays() for name, stream in self._streams.items()}
        takes = self._takes
        if takes is not None:
            takes.advance(held, max((end - 1) * period + reach, min((end - 1) * period + widest, settled)))
        parts: list[Samples] = []
        start = self._next
        while start < end:
            # A pause of hours must cost nothing: go on where all streams have values again.
            for name in REQUIRED:
                time = held[name][0]
                following = int(np.searchsorted(time, start * period - far))
                upcoming = min(time[following] if following < time.size else inf, self._streams[name].settled)
                start = max(start, min(end, ceil((upcoming - far) / period)))
            stop = min(end, start + _BLOCK_SAMPLES)
            if start < stop:
                at = np.arange(start, stop, dtype=np.float64) * period
                holding, widening, known = filters(
                    self.settings, held, at, settled, takes is not None and takes.on_a_line
                )
                if known < at.size:
                    at, stop, end = at[:known], start + known, start + known
                if at.size:
                    samples, left_out = samples_at(
                        at, widening[: at.size], holding[: at.size], held, self.settings, takes
                    )
                    parts.append(samples)
                    self._spikes.saw(left_out)
                    self._widening = int(widening[at.size - 1])
            start = stop
        self._go_on(end)
        for name, stream in self._streams.items():
            needed = min(
                end * period - self.settings.looks_back, stream.settled, inf if takes is None else takes.needed
            )
            if name not in REQUIRED:
                needed = min(needed - JUMP_S, stream.settled)
            stream.forget(needed)
            stream.seen = (end - 1) * period + reach
        return Samples.concatenate(parts)
