"""What a learner lost of what was played to it: by its own counters, before and after."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import zenoh

from incsvr.signals import REQUIRED
from service.bus.session import answer
from service.wire import Health, Keys
from simulator.messages import MessageSource

LOOK_PERIOD_S = 0.2
"""Between two looks at the counters [s]: a learner takes its measurements in twenty times a second."""
SETTLE_TIMEOUT_S = 5.0
"""How long the counters may go on changing after the last message [s]."""
SPEED_SAFETY = 0.5
"""The speed that is proposed, as a part of that at which the learner took values in: machines are busy at times."""
_MESSAGES = ("lost", "queue_full", "overflow")
_SAMPLES = "overload"


@dataclass(frozen=True, slots=True)
class Loss:
    """What one learner did not learn from because it came too quickly.

    Attributes:
        values: that it never took.
        samples: that waited for training, and went.
    """

    prefix: str
    values: int
    samples: int

    def sentence(self, sent: int, pace: float) -> str | None:
        """How many of those sent at so many times the vehicle's pace, and what to do; None where nothing is lost."""
        lost = [f"{self.values:,} of {sent:,} values"] if self.values else []
        lost += [f"{self.samples:,} samples that waited for training"] if self.samples else []
        if not lost:
            return None
        slower = float(f"{SPEED_SAFETY * pace * max(1.0 - self.values / max(sent, 1), 0.1):.1g}")
        return (
            f"at {pace:.4g} times the vehicle's pace the learner of {self.prefix} lost {' and '.join(lost)}; it has "
            f"not learned all that was played: play it slower, such as --speed {slower:.10g}"
        )


def health(session: zenoh.Session, keys: Keys) -> Health | None:
    """The learner's health now; None where none answers."""
    return answer(session, keys.health, Health)


def settled(session: zenoh.Session, keys: Keys, stop: threading.Event) -> Health | None:
    """The learner's health once it has taken in all that was sent: when its counters no longer change."""
    until, before = time.monotonic() + SETTLE_TIMEOUT_S, None
    while (now := health(session, keys)) is not None:
        if (figures := _figures(now)) == before or time.monotonic() > until or stop.wait(LOOK_PERIOD_S):
            return now
        before = figures
    return None


def sent_to(keys: Keys, what: MessageSource) -> dict[str, int]:
    """How many values of yaw rate and torque were sent to a learner, where they were in our own form."""
    places = [what.key(stream, keys)[0] for stream in range(len(what.names))]
    return {name: what.values(places.index(keys.stream(name))) for name in REQUIRED if keys.stream(name) in places}


def loss(keys: Keys, sent: Mapping[str, int], before: Health | None, after: Health | None) -> Loss | None:
    """What was lost between two looks; None where nobody answered, or the learner was started anew between them.

    The learner knows only of gaps in the numbers of messages; what it received and what was sent show the rest.
    """
    if before is None or after is None or before.boot != after.boot:
        return None
    values = sum(_count(after.counters, name) - _count(before.counters, name) for name in _MESSAGES)
    received = {
        name: after.streams[name].received - (before.streams[name].received if name in before.streams else 0)
        for name in sent
        if name in after.streams
    }
    missing = sum(max(sent[name] - count, 0) for name, count in received.items())
    samples = _count(after.counters, _SAMPLES) - _count(before.counters, _SAMPLES)
    return Loss(keys.prefix, max(values, missing), samples)


def _figures(now: Health) -> Any:
    return now.counters.get("rejected"), {name: (each.received, each.lost) for name, each in now.streams.items()}


def _count(counters: Mapping[str, int], reason: str) -> int:
    return counters.get(f"rejected:{reason}", 0)
