"""Writes each iteration to the disk first, then publishes it: after a crash every published revision is known."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from incsvr.plant.axes import AXES
from service import wire
from service.bus.publishers import Publishers
from service.cli.output import iteration_line
from service.config.configuration import Config
from service.learner.next_iteration import NextIteration
from service.learner.node import LearnerNode
from service.state.history import History
from service.state.store import Store

if TYPE_CHECKING:
    from service.bus.mapped_ingest import MappedIngest
    from service.live.live_tracing import LiveTracing

log = logging.getLogger(__name__)

PARAMETERS_KEY = "parameters"
"""The key of the vehicle's parameters in the learner's memory: it may not tell them again after a restart."""


@dataclass(frozen=True, slots=True)
class PersistThenPublish:
    """The way out of one learner: without a `store` its newest revisions are kept in the `history` alone."""

    config: Config
    node: LearnerNode
    store: Store | None
    history: History
    publishers: Publishers
    live: LiveTracing | None
    mapped: MappedIngest | None

    def iteration(self, outcome: NextIteration) -> None:
        """An iteration that was adopted."""
        keys = wire.Keys(self.config.prefix)
        served, snapshot, report = outcome.served, wire.encode(outcome.served), wire.encode(outcome.report)
        row = (served.revision, served.t or 0.0, snapshot, report)
        if self.store is None:
            self.history.add(*row)
        else:
            self.store.save(self._memory(self.node.memory()), *row)
        self.publishers.publish(keys.model, snapshot)
        self.publishers.publish(keys.iteration, report)
        self.publishers.publish(keys.coefficients, wire.encode(self.node.coefficients()))
        log.info("%s: %s", keys.prefix, iteration_line(outcome.report, AXES[self.config.vehicle.axis]))

    def ledger(self) -> None:
        """The ledger of effects as the node has it."""
        if self.store is not None:
            self.store.save_memory(self._memory(self.node.memory()))
        self.publishers.publish(wire.Keys(self.config.prefix).effects, wire.encode(self.node.ledger))

    @property
    def problem(self) -> str | None:
        """The reason why the newest revisions are not on the disk; None if they are, or nothing is kept."""
        return None if self.store is None else self.store.problem

    def last_samples(self) -> None:
        """Saves the samples of the unfinished batch."""
        if self.store is None:
            return
        self.store.save_memory(self._memory(self.node.memory(whole=True)))
        if self.store.problem is not None:
            log.error("%s: the last samples were not saved: %s", self.config.prefix, self.store.problem)

    def _memory(self, memory: dict[str, Any]) -> dict[str, Any]:
        """The learner's memory, what the vehicle said of itself, and where live tracing stands."""
        if self.mapped is not None:
            memory = memory | {PARAMETERS_KEY: self.mapped.parameters()}
        if self.live is None:
            return memory
        effects = self.live.effects
        return memory | {"live": self.live.to_dict(), "effects": None if effects is None else effects.identity}
