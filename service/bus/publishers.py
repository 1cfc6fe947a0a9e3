"""The publishers of a learner's messages, which are archived as well."""

from __future__ import annotations

from typing import Any

import zenoh
from zenoh.ext import CacheConfig, MissDetectionConfig, declare_advanced_publisher

from service import wire
from service.recordings.archive import Archive

JSON = zenoh.Encoding.APPLICATION_JSON
"""The encoding of all that a learner says."""


class Publishers:
    """The publications of one learner; from one thread at a time for each key."""

    def __init__(self, session: zenoh.Session, keys: wire.Keys, archive: Archive | None) -> None:
        self._session, self._archive = session, archive
        self._publishers = {key: _publisher_with_cache(session, key) for key in (keys.model, keys.iteration)}
        self._publishers[keys.health] = session.declare_publisher(keys.health, encoding=JSON)

    def publish(self, key: str, payload: bytes) -> None:
        """Says it on the bus, and keeps what was said."""
        publisher = self._publishers.get(key)
        if publisher is None:
            self._session.put(key, payload, encoding=JSON)
        else:
            publisher.put(payload)
        if self._archive is not None:
            self._archive.went(key, payload)


def _publisher_with_cache(session: zenoh.Session, key: str) -> Any:
    """A publisher whose latest publication reaches those who subscribe later (with an advanced subscriber)."""
    return declare_advanced_publisher(
        session,
        key,
        encoding=JSON,
        cache=CacheConfig(max_samples=1),
        sample_miss_detection=MissDetectionConfig(heartbeat=None, sporadic_heartbeat=1.0),
        publisher_detection=True,
    )
