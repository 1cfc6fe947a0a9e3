"""The endpoints and the TLS section of a Zenoh configuration."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import zenoh

_FILES = (
    "root_ca_certificate",
    "listen_certificate",
    "listen_private_key",
    "connect_certificate",
    "connect_private_key",
)


def section(config: zenoh.Config, name: str) -> Any:
    """A part of it, such as access_control; None where it is not given."""
    return json.loads(config.get_json(name))


def endpoints(config: zenoh.Config, side: Literal["listen", "connect"]) -> list[str]:
    """The endpoints to listen at or to connect to; a file may give them for each mode."""
    found = section(config, f"{side}/endpoints") or []
    return [endpoint for part in found.values() for endpoint in part] if isinstance(found, dict) else list(found)


def tls_section(config: zenoh.Config) -> Mapping[str, Any]:
    """The TLS section of the file; empty if there is none."""
    found = section(config, "transport/link/tls") or {}
    return {name: value for name, value in found.items() if value is not None}


def tls_files(config: zenoh.Config) -> dict[str, Path]:
    """The certificates and keys that it names."""
    tls = tls_section(config)
    return {name: Path(tls[name]) for name in _FILES if name in tls}
