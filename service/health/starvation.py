"""The reason why arriving measurements give no sample: one sentence with the cause and the cure.

The cause is read from what the streams' clocks show (`incsvr.signals.streams.Reading`) and from what came since the
last sample. A sample is due after so much data, however quickly they are played, or after as long by the clock on the
wall, which is injected; it decides nothing but what health says.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from incsvr.plant.words import YAW_WORDS, AxisWords
from incsvr.signals import REQUIRED, TORQUE, SignalSettings
from incsvr.signals.bursts import in_bursts
from incsvr.signals.settings import COMMANDED, SETTLING_S
from incsvr.signals.streams import JUMP_S, Reading
from service.health.stream_monitor import StreamMonitor

if TYPE_CHECKING:
    from service.learner.batches import Batches

STARVED_AFTER_S = 4.0
"""The time without a sample, while both streams come, after which the learner is starved [s], of the data or by the
wall's clock: five are promised, and health is looked at twice a second."""
SILENT_AFTER_S = 2.0
"""The silence after which a stream is the cause [s], by the clock on the wall."""
_UNITS = {1e3: "milliseconds", 1e6: "microseconds"}


@dataclass(frozen=True, slots=True)
class LastSample:
    """The counts of values at the last sample, made at this time of the wall's clock [s] and of the vehicle's."""

    at: float
    t: float = 0.0
    samples: int = 0
    received: Mapping[str, int] = field(default_factory=dict)
    rejected: Mapping[str, Mapping[str, int]] = field(default_factory=dict)


class Starvation:
    """Follows whether one learner gets samples.

    Args:
        settings: how streams become samples.
        started: of the wall's clock [s].
        words: what sentences call the quantities of the axis.
    """

    def __init__(self, settings: SignalSettings, started: float, words: AxisWords = YAW_WORDS) -> None:
        self._settings, self._words = settings, words
        self._since = LastSample(started)
        self._why: str | None = None
        self._last_look: tuple[float, Mapping[str, float]] = (started, {})
        self._pace: dict[str, float] = {}  # of the streams' clocks [s/s]

    @property
    def since(self) -> float:
        """The vehicle's time of the last sample, or of what came first [s]."""
        return self._since.t

    def why(
        self, now: float, streams: Mapping[str, StreamMonitor], readings: Mapping[str, Reading], fed: Batches
    ) -> str | None:
        """The sentence, at a time of the wall's clock [s]; None while samples are made, or none is due yet.

        Args:
            streams: what came of each stream.
            readings: what is to be said of each stream now.
            fed: the learner's batches.
        """
        since, received = self._since, {name: stream.received for name, stream in streams.items()}
        self._follow_pace(now, readings)
        missing = [name for name in REQUIRED if not received.get(name, 0)]
        if missing:
            self._why = (
                f"no {self._words.stream(missing[0])} has arrived yet" if now - since.at >= STARVED_AFTER_S else None
            )
        elif fed.samples_seen != since.samples or not all(since.received.get(name, 0) for name in REQUIRED):
            newest = _newest(readings)
            t = min((newest[name] for name in REQUIRED if name in newest), default=0.0)
            self._since = LastSample(now, t, fed.samples_seen, dict(received), fed.rejected_by_stream)
            self._why = None
        elif max(now - since.at, data_s := self._data_s(received, readings)) >= STARVED_AFTER_S:
            self._why = self._cause(now, data_s, streams, readings, fed.rejected_by_stream) or self._why
        return self._why

    def _data_s(self, received: Mapping[str, int], readings: Mapping[str, Reading]) -> float:
        """The length of both streams since the last sample [s].

        The shorter by their stamps, which may jump, and by their counts, of which some may wait to be taken.
        """
        before, newest = self._since.received, _newest(readings)
        by_count = (((received[name] - before[name]) * (readings[name].period or 0.0)) for name in REQUIRED)
        return min(*by_count, *(newest.get(name, 0.0) - self._since.t for name in REQUIRED))

    def _cause(
        self,
        now: float,
        data_s: float,
        streams: Mapping[str, StreamMonitor],
        readings: Mapping[str, Reading],
        rejected: Mapping[str, Mapping[str, int]],
    ) -> str | None:
        settings, words = self._settings, self._words
        for name in REQUIRED:
            silent = now - (streams[name].at or 0.0)
            if silent >= SILENT_AFTER_S:
                return f"the last {words.stream(name)} arrived {silent:.0f} s ago"
        for name in REQUIRED:
            if readings[name].newest is None or self._pace.get(name) == 0.0:
                return self._refusal_sentence(name, readings[name], rejected.get(name, {}))
        rate, torque = (readings[name] for name in REQUIRED)
        hint = "".join(_unit_hint(words.stream(name), self._pace.get(name, 1.0)) for name in REQUIRED)
        assert rate.newest is not None
        assert torque.newest is not None
        if abs(rate.newest - torque.newest) > JUMP_S:
            return _apart_sentence(rate, torque, words) + hint
        for name in REQUIRED:
            longest, period = readings[name].longest or 0.0, readings[name].period or 0.0
            if name == TORQUE and settings.torque == COMMANDED:
                continue  # it holds meanwhile
            apart = readings[name].bursts
            if apart is not None and apart > settings.longest_pause:
                return in_bursts(words.stream(name), apart)
            if longest > settings.longest_pause:
                return _slow_sentence(words.stream(name), period, longest, settings) + hint
        late = [name for name in settings.channels if not (readings[name].newest or 0.0) > torque.newest - JUMP_S]
        if late:
            return (
                f"samples wait {JUMP_S:g} s for {', '.join(late)}, which signals.channels lists and which does not "
                "arrive"
            )
        advanced = (now - self._since.at) * min(self._pace.get(name, 1.0) for name in REQUIRED)
        if max(advanced, data_s) < settings.sample_period + 2.0 * settings.reach + settings.lateness:
            return None  # played slowly
        if settings.torque == COMMANDED:
            needed = 2.0 * settings.reach + SETTLING_S + (torque.period or 0.0)
            return (
                f"no command is constant for the {needed:.2g} s that a sample needs; set signals.smoothing below "
                f"{settings.smoothing:g}, keep commands constant for longer, or set signals.torque to measured"
            )
        return f"{words.rate} and {words.effort} arrive, but no stretch without a pause is as long as a sample needs"

    def _follow_pace(self, now: float, readings: Mapping[str, Reading]) -> None:
        """Notes the speed of each stream's clock, once a second."""
        at, before = self._last_look
        if now - at >= 1.0:
            newest = _newest(readings)
            self._pace = {name: (newest[name] - before[name]) / (now - at) for name in before if name in newest}
            self._last_look = (now, newest)

    def _refusal_sentence(self, name: str, reading: Reading, rejected: Mapping[str, int]) -> str:
        """The reason why every value of a stream is refused."""
        before, called = self._since.rejected.get(name, {}), self._words.stream(name)
        grown = {reason: count - before.get(reason, 0) for reason, count in rejected.items()}
        reason = max(grown, key=lambda reason: grown[reason], default="")
        if not reason or grown[reason] <= 0:
            return f"the stamps of {called} do not increase; stamp it with a clock that runs forward"
        shown = "" if reading.newest is None else f", and its clock stopped at {reading.newest:.1f} s"
        return f"every {called} is refused ({reason.replace('_', ' ')}){shown}"


def _newest(readings: Mapping[str, Reading]) -> dict[str, float]:
    return {name: reading.newest for name, reading in readings.items() if reading.newest is not None}


def slow_stream(
    settings: SignalSettings, smoothing: float, readings: Mapping[str, Reading], words: AxisWords
) -> str | None:
    """A sentence where the filter is wider [s] than configured because a stream is slow; None where it is not."""
    if smoothing <= settings.smoothing:
        return None
    name = max(REQUIRED, key=lambda name: readings[name].period or 0.0)
    return (
        f"{words.stream(name)} arrives every {readings[name].period or 0.0:.2g} s, so that samples are smoothed over "
        f"{smoothing:.2g} s instead of {settings.smoothing:g} s and faster motion is lost; send it more often, or set "
        f"signals.smoothing to {smoothing:.2g} to accept that"
    )


def _apart_sentence(rate: Reading, torque: Reading, words: AxisWords) -> str:
    """Two clocks that do not show the same time."""
    assert rate.newest is not None
    assert torque.newest is not None
    named = [(words.rate, rate.newest, rate.began_anew), (words.effort, torque.newest, torque.began_anew)]
    (late, behind, restarted), (early, ahead, set_back) = sorted(named, key=lambda one: one[1])
    cure = "stamp both with one clock"
    if restarted and not set_back:
        return (
            f"the clock of {late} restarted and shows {behind:.1f} s while that of {early} shows {ahead:.1f} s, so "
            f"that their values cannot be matched; {cure}, or restart both"
        )
    return (
        f"{early} waits for {late}, whose stamps are {ahead - behind:.1f} s behind ({behind:.1f} s and "
        f"{ahead:.1f} s); {cure}"
    )


def _slow_sentence(called: str, period: float, longest: float, settings: SignalSettings) -> str:
    """A stream whose pauses are longer than what is bridged."""
    pauses = f"arrives every {period:.3g} s" if period > 0.8 * longest else f"pauses for {longest:.3g} s"
    cure = f"signals.smoothing to {longest:.2g}"
    if settings.gap is not None:
        cure = f"signals.gap to {1.5 * longest:.2g} and {cure}"
    return (
        f"{called} {pauses}, longer than the {settings.longest_pause:.3g} s that are bridged; send it more "
        f"often, or set {cure}"
    )


def _unit_hint(called: str, pace: float) -> str:
    """A hint where stamps run as fast as another unit would."""
    for factor, unit in _UNITS.items():
        if 0.7 < pace / factor < 1.4:
            return f"; the stamps of {called} look like {unit}, and must be seconds"
    return ""
