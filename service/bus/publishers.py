"""The publishers of a learner's messages, which are archived as well."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any

import zenoh
from zenoh.ext import CacheConfig, MissDetectionConfig, declare_advanced_publisher

from service import wire
from service.cli.output import learning_line
from service.config.configuration import Config
from service.recordings.archive import Archive

if TYPE_CHECKING:
    from service.health.diagnostics import Diagnostics

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


log = logging.getLogger(__name__)

HEALTH_PERIOD_S = 1.0
"""The time after which health is published again [s], if its level and its reasons do not change."""


class HealthPublisher:
    """Publishes and logs the health of one learner; from one thread alone."""

    def __init__(self, session: zenoh.Session, config: Config, publishers: Publishers) -> None:
        self._session, self._config, self._publishers = session, config, publishers
        self._key = wire.Keys(config.prefix).health
        self._diagnostics: Diagnostics | None = None
        self._last_state: tuple[Any, ...] = ()
        self._learning = "learning"
        self._next_health = self._next_log = 0.0
        self._rejected = 0

    def publish(self, health: wire.Health, now: float, ros_rate: str | None) -> None:
        """Publishes health when it is due or has changed, and logs what became of the learning and what was rejected.

        Args:
            now: of a monotonic clock [s].
            ros_rate: where the yaw rate comes on a bus of ROS 2; None where it does not.
        """
        # The reasons tell figures that change all the time: what counts as a change is their number and the level.
        says = (health.level, len(health.reasons), health.learning.state)
        if now >= self._next_health or says != self._last_state:
            self._publishers.publish(self._key, wire.encode(health))
            self._tell_ros(health, ros_rate)
            self._next_health, self._last_state = now + HEALTH_PERIOD_S, says
        if health.learning.state != self._learning:
            level = logging.INFO if health.learning.state == "learning" else logging.WARNING
            log.log(level, "%s: %s", self._config.prefix, learning_line(health.learning))
            self._learning = health.learning.state
        rejected = health.counters["rejected"]
        if rejected > self._rejected and now >= self._next_log:
            reasons = {name: count for name, count in health.counters.items() if name.startswith("rejected:")}
            log.warning("%s: %d values rejected so far: %s", self._config.prefix, rejected, reasons)
            self._rejected, self._next_log = rejected, now + HEALTH_PERIOD_S

    def close(self) -> None:
        if self._diagnostics is not None:
            self._diagnostics.close()

    def _tell_ros(self, health: wire.Health, ros_rate: str | None) -> None:
        """Health for the tools of ROS 2, where that is on the bus or was asked for."""
        if self._diagnostics is None:
            key = self._config.health.diagnostics
            if key is None and ros_rate is None:
                return
            from service.health.diagnostics import Diagnostics, diagnostics_key

            key = key or diagnostics_key(ros_rate or "")
            log.info("%s: health is also published as diagnostics on %s", self._config.prefix, key)
            self._diagnostics = Diagnostics(self._session, key, self._config.prefix, self._config.vehicle.name)
        self._diagnostics.tell(health)
