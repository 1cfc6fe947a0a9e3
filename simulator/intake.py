"""What a learner takes of what is played to it, by its own counters: whether it receives, is at work, or lost some."""

from __future__ import annotations

import threading
import time
from collections.abc import Collection, Mapping

import zenoh

from incsvr.errors import Failed
from incsvr.signals import REQUIRED
from service.bus.session import answer
from service.recordings.archive_reader import ArchiveReader
from service.wire import EffectsLedger, Health, Keys
from simulator.messages import Messages

LOOK_PERIOD_S = 0.04
"""Between two looks at the learner [s]; it takes its measurements in twenty times a second."""
QUIET_S = 0.2
"""For so long no counter changes once all is taken in, or a whole batch learned [s]: four takes, or four iterations."""
COUNT_TIMEOUT_S = 2.0
"""How long the learner may take to count a message that was sent [s]; it needs a tenth."""
SETTLE_TIMEOUT_S, TRACE_TIMEOUT_S = 5.0, 120.0
"""How long the counters may go on changing after the last message, and a learner be at work [s]; a trace takes some."""
SPEED_SAFETY = 0.5
"""The speed that is proposed, as a part of that at which the learner took values in: machines are busy at times."""


class Unheard(Failed):
    """The learner does not receive what is sent; the message is one sentence."""


class Intake:
    """Watches from now on what one learner takes in; its iterations learn `batch` samples each."""

    def __init__(self, session: zenoh.Session, keys: Keys, stop: threading.Event, batch: int = 1) -> None:
        self._session, self._keys, self._stop, self._batch = session, keys, stop, batch
        self._before, self._pending = self.health(), 0

    def health(self) -> Health | None:
        """The learner's health now; None where none answers."""
        return answer(self._session, self._keys.health, Health)

    def check(self, names: Collection[str]) -> None:
        """Returns once the learner has received something of each of these streams, or does not answer.

        Raises:
            Unheard: it answers and receives nothing. Zenoh drops without a word what a client may not publish.
        """
        until = time.monotonic() + COUNT_TIMEOUT_S
        while self._before is not None and not self._stop.is_set() and (now := self.health()) is not None:
            refused = now.counters.get("rejected", 0) - self._before.counters.get("rejected", 0)
            missing = sorted(self._keys.stream(name) for name in names if not self._came(now).get(name, 0) + refused)
            if not missing:
                return
            if time.monotonic() > until:
                raise Unheard(
                    f"the learner answers but receives nothing on {' and '.join(missing)}: this client may not publish "
                    "there; play in the role of the vehicle, with the vehicle.json5 of `incsvr keys` as bus.zenoh_file"
                )
            self._stop.wait(LOOK_PERIOD_S)

    def settled(self, sent: Mapping[str, int] | None = None) -> Health | None:
        """The learner's health once its counters no longer change; None where none answers.

        Args:
            sent: values by stream, all of which must be taken in, with no trace at work. While a learner traces, a
                player that goes on brings data that a slower machine has not seen when the next trace begins.
        """
        began, before = time.monotonic(), None
        until, since = began + (SETTLE_TIMEOUT_S if sent is None else TRACE_TIMEOUT_S), began
        while (now := self.health()) is not None:
            came = self._came(now)
            whole = sent is None or (all(came.get(n, 0) >= sent.get(n, 0) for n in REQUIRED) and not self._traces())
            pending = 0 if sent is None else now.counters.get("samples", 0) // self._batch - now.iteration
            streams = {name: (each.received, each.lost) for name, each in now.streams.items()}
            state = whole, now.counters.get("rejected"), streams, pending
            if state != before:
                before, since = state, time.monotonic()
            quiet = QUIET_S if sent is None or pending != self._pending else LOOK_PERIOD_S
            over = whole and time.monotonic() - since >= quiet
            if over or time.monotonic() > until or self._stop.wait(LOOK_PERIOD_S):
                self._pending = pending
                return now
        return None

    def loss(self, what: Messages | ArchiveReader, pace: float) -> str | None:
        """How much was lost at so many times the vehicle's pace, and what to do; None where nothing is, where nobody
        answers, or where the learner was started anew.

        The learner knows only of gaps in the numbers of messages; what it received and what was sent show the rest.
        """
        before, now = self._before, self.settled()
        if before is None or now is None or before.boot != now.boot:
            return None
        places = [what.key(stream, self._keys)[0] for stream in range(len(what.names))]
        sent = {name: what.values(places.index(self._keys.stream(name)))
                for name in REQUIRED if self._keys.stream(name) in places}  # fmt: skip
        missing = sum(max(sent[name] - came, 0) for name, came in self._came(now).items() if name in sent)
        values = max(missing, _more(before, now, "lost", "queue_full", "overflow"))
        samples = _more(before, now, "overload")
        lost = [f"{values:,} of {len(what):,} values"] if values else []
        lost += [f"{samples:,} samples that waited for training"] if samples else []
        if not lost:
            return None
        slower = float(f"{SPEED_SAFETY * pace * max(1.0 - values / len(what), 0.1):.1g}")
        return (
            f"at {pace:.4g} times the vehicle's pace the learner of {self._keys.prefix} lost {' and '.join(lost)}; it "
            f"has not learned all that was played: play it slower, such as --speed {slower:.10g}"
        )

    def _came(self, now: Health) -> dict[str, int]:
        """Values received of yaw rate and torque since the beginning."""
        before = {} if self._before is None else self._before.streams
        return {
            name: now.streams[name].received - (before[name].received if name in before else 0)
            for name in REQUIRED
            if name in now.streams
        }

    def _traces(self) -> bool:
        ledger = answer(self._session, self._keys.effects, EffectsLedger)
        return ledger is not None and ledger.work is not None


def _more(before: Health, now: Health, *reasons: str) -> int:
    """How many more were rejected for these reasons."""
    names = [f"rejected:{reason}" for reason in reasons]
    return sum(now.counters.get(name, 0) - before.counters.get(name, 0) for name in names)
