"""Whether another learner has the same prefix on the same bus: its models would be mixed with ours."""

from __future__ import annotations

import logging
import threading
import time
import uuid
from collections.abc import Callable
from typing import Any

import zenoh
from zenoh.handlers import RingChannel

from incsvr.errors import BadInput
from service import wire

log = logging.getLogger(__name__)

DEAD_TOKEN_S = 3.0
"""The time for which the token of a learner that died is seen [s]: a lease of two seconds, and one of grace."""
HEALTH_MEMORY_S = 5.0
"""The time for which another learner counts as there after its last health [s]; it comes once a second."""
START_WAIT_S = 0.5
"""The time for which a client of a hub waits for others that start in the same moment [s]; their tokens are seen in
milliseconds, over a slow link in tenths of a second."""
CANDIDATE_MARK, OWNER_MARK = "1", "0"
"""The first letter of a name on `…/coming/*`: who stays comes before all who are coming."""


def take_prefix(session: zenoh.Session, prefix: str, stop: threading.Event, hub: bool) -> Any:
    """Waits until nobody else is alive under this prefix, and returns a token that is to be held as long as we are.

    Of several that start in the same moment, each has said so before it looks, and looks for START_WAIT_S: so all
    see each other, and the one with the smallest name stays.

    Args:
        hub: other learners may be clients of the same hub; who listens itself has its port alone.

    Raises:
        BadInput: somebody else stays.
    """
    keys, name = wire.Keys(prefix), uuid.uuid4().hex
    liveliness = session.liveliness()
    coming: Any = liveliness.declare_token(keys.coming(CANDIDATE_MARK + name))
    began = time.monotonic()
    while (taken := _is_taken(session, keys, name)) or (hub and time.monotonic() < began + START_WAIT_S):
        if taken and time.monotonic() >= began + DEAD_TOKEN_S:
            coming.undeclare()
            raise BadInput(
                f"another learner has the prefix {prefix} on this bus; end it, give this one another --prefix, or "
                "set bus.allow_second to run both"
            )
        if stop.wait(0.1):
            break
    token = liveliness.declare_token(keys.coming(OWNER_MARK + name))
    coming.undeclare()
    return token


def _is_taken(session: zenoh.Session, keys: wire.Keys, name: str) -> bool:
    """Whether a learner is alive, or one that comes is to stay rather than we."""
    if any(reply.ok is not None for reply in session.liveliness().get(keys.alive, timeout=DEAD_TOKEN_S)):
        return True
    replies = session.liveliness().get(keys.coming("*"), timeout=DEAD_TOKEN_S)
    names = {str(reply.ok.key_expr).rpartition("/")[2] for reply in replies if reply.ok is not None}
    return any(other < CANDIDATE_MARK + name for other in names)


class DuplicateLearner:
    """Listens whether somebody else publishes health under our prefix.

    Args:
        boot: identifies this start of ours.
        clock: a monotonic clock [s].
    """

    def __init__(self, session: zenoh.Session, keys: wire.Keys, boot: str, clock: Callable[[], float]) -> None:
        self._boot, self._clock = boot, clock
        self._ring: Any = session.declare_subscriber(keys.health, RingChannel(8), allowed_origin=zenoh.Locality.REMOTE)
        self._last_other: tuple[str, float] | None = None

    def notice(self) -> tuple[str, ...]:
        """The sentence of health on another learner of the same prefix; nothing without one."""
        while (sample := self._ring.try_recv()) is not None:
            try:
                other = wire.decode(wire.Health, sample.payload.to_bytes()).boot
            except BadInput:
                continue
            if other != self._boot:
                self._last_other = (other[:40], self._clock())
        if self._last_other is None or self._clock() - self._last_other[1] > HEALTH_MEMORY_S:
            return ()
        return (f"another learner, of boot {self._last_other[0]}, publishes under the same prefix; end one of them",)

    def close(self) -> None:
        self._ring.undeclare()
