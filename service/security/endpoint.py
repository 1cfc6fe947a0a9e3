"""The interface at which an endpoint listens, judged by the address that its host resolves to."""

from __future__ import annotations

import ipaddress
import socket


def listens_everywhere(endpoint: str) -> bool:
    """Whether a listener at this Zenoh endpoint, such as tcp/127.0.0.1:7447, is met on all interfaces."""
    protocol, _, place = endpoint.partition("/")
    if protocol.startswith("unixsock"):
        return False
    address = place.partition("?")[0].partition("#")[0]
    host = address.rpartition(":")[0].removeprefix("[").removesuffix("]")
    if not host or host == "*":
        return True
    try:
        found = {entry[4][0] for entry in socket.getaddrinfo(host.partition("%")[0], None)}
    except (OSError, UnicodeError):
        return False  # nothing can listen there; opening the bus will say so
    return any(_unspecified(str(each)) for each in found)


def _unspecified(address: str) -> bool:
    found = ipaddress.ip_address(address)
    mapped = found.ipv4_mapped if isinstance(found, ipaddress.IPv6Address) else None
    return found.is_unspecified or (mapped is not None and mapped.is_unspecified)
