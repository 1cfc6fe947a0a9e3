"""Streams with their own clocks, rates, jitter and faults become damping samples on one grid (Section IV-A).

The grid is the multiples of the sample period in the vehicle's own time. A sample stands there as soon as every stream
has passed it by half the smoothing window and the lateness, so that nothing that still may come could change it. Its
yaw rate and its damping moment d = τ − I ṙ (Eq. 5) are computed from the stamps and values around it alone.

Deterministic: the samples depend on each stream's own messages, in that stream's order, and on their stamps. How the
messages are bundled, how the streams are interleaved and when `ready` is called make no difference, to the last bit.
Only a stream that falls further behind than the bounds below (JUMP for a channel, CAPACITY for yaw rate and torque) is
not waited for. The same code serves recordings, the simulator and the service.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from math import ceil, inf, isfinite
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from incsvr.errors import BadInput
from incsvr.plant import damping_moment
from incsvr.samples import Array, Samples
from incsvr.signals.smoothing import WIDTHS, smooth
from incsvr.signals.streams import JUMP, Stream

if TYPE_CHECKING:
    from incsvr.compensation import Compensation
    from incsvr.torque_ledger import TorqueLedger

YAW_RATE, TORQUE = "yaw_rate", "torque"
REQUIRED = (YAW_RATE, TORQUE)
MAX_CHANNELS = 64
RUN_PAUSE = 5.0
"""Time between two recordings that are joined to one [s]: longer than any gap that a window may hold."""
_BLOCK = 4096


@dataclass(frozen=True, slots=True)
class SignalSettings:
    """How streams become samples.

    Attributes:
        inertia: moment of inertia with added mass about yaw, I [kg m²].
        sample_period: time between two samples [s]; from 5 · smoothing on their noise is nearly white.
        smoothing: standard deviation of the Gaussian low-pass filter [s].
        lateness: how far behind the newest of its stream a message may come and still count [s].
        gap: longest pause between two messages of a stream across which it still counts as continuous [s].
        rate_limit: largest plausible magnitude of the yaw rate [rad/s].
        torque_limit: largest plausible magnitude of the torque [N m].
        channels: further channels that samples wait for from the beginning; others join with their first message.
    """

    inertia: float = 350.0
    sample_period: float = 0.6
    smoothing: float = 0.12
    lateness: float = 0.2
    gap: float = 0.2
    rate_limit: float = 1.0
    torque_limit: float = 500.0
    channels: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in ("inertia", "sample_period", "smoothing", "gap", "rate_limit", "torque_limit"):
            value = getattr(self, name)
            if not (isfinite(value) and value > 0.0):
                raise BadInput(f"{name} is {value}: give a positive, finite number")
        if not (isfinite(self.lateness) and self.lateness >= 0.0):
            raise BadInput(f"lateness is {self.lateness}: give zero or a positive, finite number of seconds")
        if self.gap > 2.0 * self.smoothing:
            raise BadInput(
                f"a gap of {self.gap} s is longer than twice the smoothing of {self.smoothing} s, and the filter would "
                "bridge what it has not seen: raise the smoothing or lower the gap"
            )
        if self.gap >= RUN_PAUSE:
            raise BadInput(f"a gap of {self.gap} s would join recordings that are apart: keep it below {RUN_PAUSE} s")
        if len(self.channels) > MAX_CHANNELS:
            raise BadInput(f"{len(self.channels)} channels are declared: at most {MAX_CHANNELS} are kept")

    @property
    def reach(self) -> float:
        """Half the smoothing window [s]."""
        return WIDTHS * self.smoothing


class Synchroniser:
    """Takes messages of all streams and yields the samples that are complete; its memory is bounded.

    With a `compensation` the samples are free of the traced effects, and say what each took of the torque.
    """

    def __init__(self, settings: SignalSettings, compensation: Compensation | None = None) -> None:
        self.settings = settings
        self._ledger: TorqueLedger | None = None
        if compensation is not None:
            # Loaded where it is needed alone: it brings the catalogue of effects with it.
            from incsvr.torque_ledger import TorqueLedger

            self._ledger = TorqueLedger(compensation, settings)
        self._streams = {
            YAW_RATE: Stream(settings.rate_limit, settings.lateness),
            TORQUE: Stream(settings.torque_limit, settings.lateness),
            **{name: Stream(inf, settings.lateness) for name in settings.channels},
        }
        self._refused: Counter[str] = Counter()
        self._next = 0

    @property
    def rejected(self) -> Mapping[str, int]:
        """How many messages were refused, by reason."""
        total = Counter(self._refused)
        for stream in self._streams.values():
            total.update(stream.rejected)
        return dict(total)

    @property
    def rejected_by_stream(self) -> Mapping[str, Mapping[str, int]]:
        """How many messages were refused, by stream and reason."""
        return {name: dict(stream.rejected) for name, stream in self._streams.items() if stream.rejected}

    def newest(self, name: str) -> float | None:
        """The newest stamp of a stream [s]; None before its first two messages."""
        stream = self._streams.get(name)
        return None if stream is None or not isfinite(stream.newest) else stream.newest

    def push_one(self, name: str, time: float, value: float) -> None:
        """Takes one message: its stamp [s] and value ([rad/s] of "yaw_rate", [N m] of "torque", or a channel's)."""
        stream = self._streams.get(name)
        if stream is None:
            stream = self._join(name)
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
        stream = self._streams.get(name)
        if stream is None:
            stream = self._join(name)
        if stream is not None:
            stream.push_many(stamps, values)
        else:
            self._refused["too_many_channels"] += stamps.size

    def ready(self) -> Samples:
        """All samples that became complete since the last call, in the order of their time."""
        ahead = 0.0 if self._ledger is None else self._ledger.ahead
        moving = min(self._streams[YAW_RATE].settled, self._streams[TORQUE].settled - ahead)
        if self._next * self.settings.sample_period >= moving - self.settings.reach:
            return Samples.empty()
        channels = [stream.settled for name, stream in self._streams.items() if name not in REQUIRED]
        settled = max(min([moving, *channels]), moving - JUMP) if channels else moving
        end = ceil((settled - self.settings.reach) / self.settings.sample_period)
        return self._samples(end) if end > self._next else Samples.empty()

    def to_dict(self) -> dict[str, Any]:
        """The whole state as plain data, exact to the bit in JSON; `restore` continues from it."""
        return {
            "settings": asdict(self.settings) | {"channels": list(self.settings.channels)},
            "next": self._next,
            "refused": dict(self._refused),
            "streams": {name: stream.to_dict() for name, stream in self._streams.items()},
            "ledger": None if self._ledger is None else self._ledger.to_dict(),
        }

    @staticmethod
    def from_dict(data: Mapping[str, Any], compensation: Compensation | None = None) -> Synchroniser:
        """The synchroniser whose to_dict gave `data`, with the same compensation."""
        settings = SignalSettings(**{**data["settings"], "channels": tuple(data["settings"]["channels"])})
        synchroniser = Synchroniser(settings, compensation)
        if synchroniser._ledger is not None:
            synchroniser._ledger.restore(data["ledger"])
        synchroniser._next = int(data["next"])
        synchroniser._refused = Counter(data["refused"])
        for name, stream in data["streams"].items():
            synchroniser._streams.setdefault(name, Stream(inf, settings.lateness)).restore(stream)
        return synchroniser

    def _join(self, name: str) -> Stream | None:
        """A stream for a channel that was not declared, as long as there is room."""
        if len(self._streams) >= MAX_CHANNELS + len(REQUIRED):
            return None
        return self._streams.setdefault(name, Stream(inf, self.settings.lateness))

    def _samples(self, end: int) -> Samples:
        """The samples on the grid from where the last call ended up to `end`, without those across a gap."""
        period, reach = self.settings.sample_period, self.settings.reach
        held = {name: stream.arrays() for name, stream in self._streams.items()}
        ledger = self._ledger
        if ledger is not None:
            ledger.advance(held, (end - 1) * period + reach)
        parts: list[Samples] = []
        start = self._next
        while start < end:
            # A pause of hours must cost nothing: go on where all streams have values again.
            for name in REQUIRED:
                time = held[name][0]
                following = int(np.searchsorted(time, start * period - reach))
                upcoming = time[following] if following < time.size else inf
                upcoming = min(upcoming, self._streams[name].settled)
                start = max(start, min(end, ceil((upcoming - reach) / period)))
            stop = min(end, start + _BLOCK)
            if start < stop:
                parts.append(self._block(np.arange(start, stop, dtype=np.float64) * period, held))
            start = stop
        self._next = end
        for name, stream in self._streams.items():
            needed = min(end * period - reach, stream.settled, inf if ledger is None else ledger.needed)
            if name not in REQUIRED:
                needed = min(needed - JUMP, stream.settled)
            stream.forget(needed)
        if ledger is not None:
            ledger.forget(end * period - reach)
        return Samples.concatenate(parts)

    def _block(self, at: Array, held: Mapping[str, tuple[Array, Array]]) -> Samples:
        """The complete samples among the instants `at` [s]."""
        smoothing, gap = self.settings.smoothing, self.settings.gap
        torque = smooth(*held[TORQUE], at, smoothing=smoothing, gap=gap)
        yaw_rate = smooth(*held[YAW_RATE], at, smoothing=smoothing, gap=gap)
        damping, parts = damping_moment(torque.value, yaw_rate.slope, self.settings.inertia), dict[str, Array]()
        if self._ledger is not None:
            damping, parts = self._ledger.split(at, torque, yaw_rate)
        complete = np.flatnonzero(torque.complete & yaw_rate.complete & np.isfinite(damping))
        at = at[complete]
        channels = {}
        for name in sorted(held.keys() - set(REQUIRED)):
            filtered = smooth(*held[name], at, smoothing=smoothing, gap=gap)
            channels[name] = np.where(filtered.complete, filtered.value, _last(*held[name], at))
        return Samples(
            at,
            yaw_rate.value[complete],
            damping[complete],
            channels,
            {name: values[complete] for name, values in parts.items()},
        )


def synchronise(
    settings: SignalSettings, streams: Mapping[str, tuple[Array, Array]], compensation: Compensation | None = None
) -> tuple[Samples, Mapping[str, int]]:
    """All samples of whole streams, name → (stamps [s], values), and what was refused by reason.

    The same samples as when the streams are played live.
    """
    synchroniser = Synchroniser(settings, compensation)
    return play(synchroniser, streams), synchroniser.rejected


def play(synchroniser: Synchroniser, streams: Mapping[str, tuple[Array, Array]]) -> Samples:
    """All samples of whole streams, name → (stamps [s], values), that are complete; the synchroniser goes on after."""
    parts = []
    for chunks in _interleaved(streams):
        for name, time, value in chunks:
            synchroniser.push(name, time, value)
        parts.append(synchroniser.ready())
    return Samples.concatenate(parts)


def _interleaved(streams: Mapping[str, tuple[Array, Array]]) -> Iterator[list[tuple[str, Array, Array]]]:
    """The streams cut into slices at the same times, so that none runs far ahead of the others."""
    clocks = {name: np.fmax.accumulate(time) for name, (time, _) in streams.items()}
    longest = max(clocks.values(), key=len, default=np.empty(0))
    cuts = longest[_BLOCK::_BLOCK]
    edges = {name: [0, *np.searchsorted(clock, cuts).tolist(), clock.size] for name, clock in clocks.items()}
    for part in range(cuts.size + 1):
        chunks: list[tuple[str, Array, Array]] = []
        for name, (time, value) in streams.items():
            share = slice(edges[name][part], edges[name][part + 1])
            chunks.append((name, time[share], value[share]))
        yield chunks


def _last(time: Array, value: Array, at: Array) -> Array:
    """A slow channel's last value at each instant, NaN where it is older than JUMP."""
    if time.size == 0:
        return np.full(at.size, np.nan)
    position = np.searchsorted(time, at, side="right") - 1
    age = at - time[np.maximum(position, 0)]
    return np.where((position >= 0) & (age <= JUMP), value[position], np.nan)
