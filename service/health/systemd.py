"""Notifications of systemd by sd_notify(3): ready, watchdog, stopping.

Where systemd did not start it nothing is told. What cannot be told must not end the learning: systemd acts on silence.
"""

from __future__ import annotations

import logging
import os
import socket

log = logging.getLogger(__name__)

READY, ALIVE, STOPPING = "READY=1", "WATCHDOG=1", "STOPPING=1"

STROKES_PER_TIMEOUT = 3
"""Strokes within the watchdog's time: one that comes late does not end the process."""


def tell(state: str) -> None:
    """Sends one state to $NOTIFY_SOCKET, which is a path or, with a leading @, a name in the abstract namespace."""
    address = os.environ.get("NOTIFY_SOCKET", "")
    if not address:
        return
    if address.startswith("@"):
        address = "\0" + address[1:]
    try:
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as channel:
            channel.setblocking(False)
            channel.sendto(state.encode(), address)
    except OSError as error:
        log.warning("systemd could not be notified of %s: %s", state, error)


def stroke_period() -> float | None:
    """The period of the watchdog's notification [s]; None without a watchdog."""
    watched = os.environ.get("WATCHDOG_PID", str(os.getpid()))
    microseconds = os.environ.get("WATCHDOG_USEC", "")
    if watched != str(os.getpid()) or not microseconds.isdecimal() or int(microseconds) == 0:
        return None
    return int(microseconds) / 1e6 / STROKES_PER_TIMEOUT
