"""Publishes health on the bus, and logs what changed in it."""

from __future__ import annotations

import logging
from typing import Any

from service import wire
from service.bus.publishers import Publishers
from service.cli.log_lines import learning_line
from service.config.configuration import Config

log = logging.getLogger(__name__)

HEALTH_PERIOD_S = 1.0
"""The time after which health is published again [s], if its level and its reasons do not change."""


class HealthPublisher:
    """Publishes and logs the health of one learner; from one thread alone."""

    def __init__(self, config: Config, publishers: Publishers) -> None:
        self._config, self._publishers = config, publishers
        self._key = wire.Keys(config.prefix).health
        self._last_state: tuple[Any, ...] = ()
        self._learning = "learning"
        self._next_health = self._next_log = 0.0
        self._rejected = 0

    def publish(self, health: wire.Health, now: float) -> None:
        """Publishes health when it is due or has changed, and logs what became of the learning and what was rejected;
        `now` is of a monotonic clock [s]."""
        # The reasons tell figures that change all the time: what counts as a change is their number and the level.
        says = (health.level, len(health.reasons), health.learning.state)
        if now >= self._next_health or says != self._last_state:
            self._publishers.publish(self._key, wire.encode(health))
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
