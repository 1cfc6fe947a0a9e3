"""Under which names the page is served: a web site that has its name resolve to the vehicle must not read it.

A browser says in `Host` by which name it called. An address cannot be made to point elsewhere, and a name that only the
local network resolves (`.local`) belongs to no web site; any other name must be one of ours (DNS rebinding).
"""

from __future__ import annotations

import ipaddress
import re
import socket
from collections.abc import Iterable, Sequence

_HOST = re.compile(r"(\[[0-9A-Fa-f:.]+\]|[^\s:/?#@\[\]\\]+)(:\d{1,5})?")


def ours(served_at: str, named: Iterable[str]) -> frozenset[str]:
    """The names that are ours: of this machine, where it is served, and what somebody named."""
    own = socket.gethostname()
    return frozenset(_plain(name) for name in ("localhost", own, served_at, *named))


def foreign(hosts: Sequence[str], names: frozenset[str]) -> str | None:
    """The first of the `Host` headers that is not one of ours; None where all are, or none was sent: by no browser."""
    return next((host for host in hosts if not _is_ours(host, names)), None)


def _is_ours(host: str, names: frozenset[str]) -> bool:
    found = _HOST.fullmatch(host.strip())
    if found is None:
        return False
    name = _plain(found[1])
    return name in names or name.endswith((".local", ".localhost")) or _is_address(name.strip("[]"))


def _is_address(text: str) -> bool:
    try:
        ipaddress.ip_address(text)
    except ValueError:
        return False
    return True


def _plain(name: str) -> str:
    return name.lower().removesuffix(".")
