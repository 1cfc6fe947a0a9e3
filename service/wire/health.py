"""The incoming message, and the messages of a learner's health and of a fault that begins or ends."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Literal

from incsvr.numerics.plain import UNLESS_EMPTY, to_plain
from service.wire.form import Form, Numbers
from service.wire.json_text import json_text


@dataclass(frozen=True)
class Measurement(Form):
    """One measured value, or arrays of equal length, of one stream: the vehicle's time [s] and SI units.

    `seq` numbers the messages of a stream; where it is given, what was lost on the way is counted.
    """

    t: float | Numbers
    value: float | Numbers
    seq: int | None = None


def measurement(t: float | Numbers, value: float | Numbers, seq: int | None = None) -> bytes:
    """The payload of a measurement."""
    message = to_plain(Measurement(t, value, seq))
    return json_text({name: each for name, each in message.items() if each is not None}, compact=True).encode()


@dataclass(frozen=True)
class StreamHealth(Form):
    """The health of one input stream."""

    received: int = 0  # samples
    lost: int = 0  # messages, by their `seq`
    age_s: float | None = None  # since the last message, wall time
    t: float | None = None  # newest stamp, the vehicle's time [s]
    value: float | None = None  # newest value
    period_s: float | None = None  # between its stamps, in the median of the latest
    held: int = 0  # values that wait for the other streams, or for their clock to be believed


LearningState = Literal["learning", "starved", "paused"]
Reason = tuple[LearningState, str | None, float]
"""A state of learning, the sentence on why it is so, None where it is not, and since when in the vehicle's time [s]."""


@dataclass(frozen=True)
class Learning(Form):
    """Whether samples are made and learned, since when in the vehicle's time [s], and why not in one sentence.

    starved: measurements come, and no sample can be made of them, or none that is evidence about damping. paused:
    samples are made, and a check keeps them from being learned. The served model stays the last one that was learned.
    """

    state: LearningState = "learning"
    since: float = 0.0
    why: str = ""

    def now(self, reasons: Iterable[Reason]) -> Learning:
        """The state now, by the first reason why nothing is learned that there is; `since` moves with the state."""
        state, why, t = next(((state, why, t) for state, why, t in reasons if why or state == "learning"))
        return Learning(state=state, since=self.since if state == self.state else t, why=why or "")


Level = Literal["OK", "WARN", "ERROR", "STALE"]


@dataclass(frozen=True, kw_only=True)
class Health(Form):
    """`…/health`. Counters begin with the start of the process; `rejected:<reason>` counts samples, by reason, and
    `spikes:<stream>` the values that were left out before the filter."""

    level: Level
    reasons: tuple[str, ...] = ()  # sentences, the gravest first
    counters: dict[str, int] = field(default_factory=dict)
    learned: float = 0.0  # part, 0 to 1, of the rate range covered by fresh data
    boot: str
    revision: int = 0
    iteration: int = 0
    t: float | None = None  # newest synchronised sample, the vehicle's time [s]
    uptime_s: float = 0.0
    streams: dict[str, StreamHealth] = field(default_factory=dict)
    learning: Learning = Learning()
    # whose axes a process learns together, if it does; and these axes, with the prefixes of their keys
    vehicle: str = field(default="", metadata=UNLESS_EMPTY)
    axes: dict[str, str] = field(default_factory=dict, metadata=UNLESS_EMPTY)


@dataclass(frozen=True, kw_only=True)
class ThrustEvent(Form):
    """`…/event`: thrust is lost, or back, with the model that holds from then on: I ṙ + d(r) = `thrust` τ, d(r) as the
    `revision` has it."""

    boot: str
    event: Literal["thrust lost", "thrust back"]
    axis: str  # such as yaw
    since: float  # its onset, the vehicle's time [s]
    t: float  # the end of the data that showed it [s]
    size: float  # part of the usual thrust that is lacking; about 0 where it is back
    size_low: float  # interval of 95 %
    size_high: float
    thrust: float  # part of the usual thrust that there is
    inertia: float  # kg m²
    revision: int | None  # of the model that was served at the onset; None where no history reaches so far back
    cannot_tell_from: tuple[str, ...]  # of "damping", "moment", "inertia"
    why: str  # a sentence for people
