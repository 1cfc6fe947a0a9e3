"""Whether another learner has the same prefix on the same bus: its models would be mixed with ours."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from typing import Any

import zenoh
from zenoh.handlers import RingChannel

from incsvr.errors import BadInput
from service import wire

log = logging.getLogger(__name__)

LEAVING = 3.0
"""How long the token of a learner that has just died may be seen [s]: a lease of two seconds, and one of grace."""
REMEMBERED = 5.0
"""How long another learner counts as there after its last health [s]; it comes once a second."""


def refuse_company(session: zenoh.Session, prefix: str, stop: threading.Event) -> None:
    """Waits until nobody is alive under this prefix.

    Raises:
        BadInput: somebody stays.
    """
    until = time.monotonic() + LEAVING
    while list(session.liveliness().get(wire.Keys(prefix).alive, timeout=LEAVING)):
        if time.monotonic() >= until:
            raise BadInput(
                f"another learner has the prefix {prefix} on this bus; end it, give this one another --prefix, or "
                "set bus.allow_second to run both"
            )
        if stop.wait(0.2):
            return


class Company:
    """Listens whether somebody else publishes health under our prefix.

    Args:
        boot: identifies this start of ours.
        clock: a monotonic clock [s].
    """

    def __init__(self, session: zenoh.Session, keys: wire.Keys, boot: str, clock: Callable[[], float]) -> None:
        self._boot, self._clock = boot, clock
        self._ring: Any = session.declare_subscriber(keys.health, RingChannel(8), allowed_origin=zenoh.Locality.REMOTE)
        self._seen: tuple[str, float] | None = None

    def notice(self) -> tuple[str, ...]:
        """What health says of it, as a sentence; nothing where we are alone."""
        while (sample := self._ring.try_recv()) is not None:
            try:
                other = wire.decode(wire.Health, sample.payload.to_bytes()).boot
            except BadInput:
                continue
            if other != self._boot:
                self._seen = (other[:40], self._clock())
        if self._seen is None or self._clock() - self._seen[1] > REMEMBERED:
            return ()
        return (f"another learner, of boot {self._seen[0]}, publishes under the same prefix; end one of them",)

    def close(self) -> None:
        self._ring.undeclare()
