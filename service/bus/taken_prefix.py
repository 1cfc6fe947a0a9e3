"""Whether another learner has the same prefix on the same bus: its models would be mixed with ours."""

from __future__ import annotations

import threading
import time
import uuid
from typing import Any

import zenoh

from incsvr.errors import BadInput
from service import wire

DEAD_TOKEN_S = 3.0
"""The time for which the token of a learner that died is seen [s]: a lease of two seconds, and one of grace."""
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
                f"another learner has the prefix {prefix} on this bus; end it, or give this one another --prefix"
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
