"""The clocks of a vehicle's streams beside each other: which are gone on with, where some of them began anew.

What is right where clocks are not (`incsvr.signals.streams` says what one stream does by itself):

- The stamps of yaw rate and torque do not overlap (seconds since 1970 beside seconds since start, one clock an hour
  ahead): there is no sample, because nothing but the stamps says which values belong together. `readings` says so.
- One clock begins anew while the other goes on: the samples up to there are completed, what comes after is held, and no
  sample is made until both clocks show the same time again, within JUMP_S. Old values are never paired with new ones.
- Both begin anew (the vehicle was switched off and on), or the one goes back to where the other is: all is taken up
  anew from the stamp since which both clocks run. After a clock was set, and only then, the order in which the
  messages of different streams arrive has a say: stamps alone do not tell of which time they are.
"""

from __future__ import annotations

from math import inf

from incsvr.signals.settings import MAX_CHANNELS, REQUIRED, TORQUE, YAW_RATE, SignalSettings
from incsvr.signals.streams import FIRST_BELIEVED_STAMPS, JUMP_S, Stream


class Clocks:
    """The streams of a vehicle, by name, each with its clock."""

    def __init__(self, settings: SignalSettings) -> None:
        self._settings = settings
        self.streams = empty_streams(settings)
        self._compared: tuple[list[Stream], float] = ([], 0.0)  # the clocks that were looked at last, and the lead

    def of(self, name: str) -> Stream | None:
        """The stream of that name; of a channel that was not declared a new one, as long as there is room."""
        stream = self.streams.get(name)
        if stream is not None or len(self.streams) >= MAX_CHANNELS + len(REQUIRED):
            return stream
        return self.streams.setdefault(name, channel(self._settings))

    def take_up(self, looked_at: float) -> float | None:
        """Goes on with the clocks that began anew, where yaw rate and torque agree.

        Args:
            looked_at: the samples made so far saw the streams up to here [s].

        Returns:
            since when all clocks run that are gone on with [s]; None where there are none.
        """
        clocks = [self.streams[name].latest for name in REQUIRED]
        newest = [clock.newest for clock in clocks]
        (before, led), lead = self._compared, newest[0] - newest[1]
        self._compared = (clocks, lead)
        # Played faster than they are taken in, two clocks that agree overtake each other.
        if abs(lead) > JUMP_S and not (before == clocks and lead * led < 0.0):
            return None
        if not any(self.streams[name].next for name in REQUIRED):
            for name, stream in self.streams.items():
                if stream.next is not None and abs(stream.next.newest - min(newest)) <= JUMP_S:
                    self.streams[name] = stream.next
            return None
        begin = max(clock.since for clock in clocks)
        for name, stream in self.streams.items():
            clock = stream.latest
            if name not in REQUIRED and abs(clock.newest - min(newest)) > JUMP_S:
                clock = stream.anew()  # it has still to come
            # What a clock showed that was left alone is told; the seconds between two clocks are a pause like others.
            if clock is not stream:
                clock.refuse("clock_jump", stream.count(looked_at + JUMP_S, inf) + clock.count(-inf, clock.since))
            clock.cut(clock.since)
            clock.refuse("clocks_apart", clock.count(looked_at if clock is stream else -inf, begin - JUMP_S))
            self.streams[name] = clock
        return begin


def empty_streams(settings: SignalSettings) -> dict[str, Stream]:
    """Empty streams of what samples wait for, by name."""
    return {
        YAW_RATE: Stream(settings.rate_limit, settings.lateness),
        TORQUE: Stream(settings.torque_limit, settings.lateness),
        **{name: channel(settings) for name in settings.channels},
    }


def channel(settings: SignalSettings) -> Stream:
    """The stream of a channel, which may come slowly."""
    return Stream(inf, settings.lateness, FIRST_BELIEVED_STAMPS)
