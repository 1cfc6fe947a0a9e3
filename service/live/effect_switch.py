"""A learner that changes over from the effects in force to others, as live tracing finds or an operator decides."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from incsvr.errors import BadInput
from incsvr.signals.samples import Samples
from service import wire
from service.config.configuration import Config
from service.learner.answers import Verb
from service.learner.node import LearnerNode
from service.live.effects import TracedEffects
from service.live.ledger import findings
from service.recordings.validation import read_validation
from service.state.persist_then_publish import PersistThenPublish

if TYPE_CHECKING:
    from service.live.live_tracing import LiveTracing
    from service.live.tracing_state import TracingState

log = logging.getLogger(__name__)

_DONE = {"promote": "promoted", "withdraw": "withdrawn"}


@dataclass(frozen=True, slots=True)
class EffectSwitch:
    """Live tracing of one learner on the bus; `watch_over` is told which effects are in force."""

    config: Config
    node: LearnerNode
    live: LiveTracing
    disk_first: PersistThenPublish
    watch_over: Callable[[TracedEffects | None], None]

    def after_batch(self) -> None:
        """What live tracing has to do after a batch, or when its process has ended."""
        live = self.live
        try:
            # Also while learning is paused: what the checks take for a clock that jumped may be an effect.
            said = live.after(self.node)
            if live.waits:
                instead = live.conclude(self.node)
                if instead is not None:
                    self._change_over(instead)
                self._tell()
                said = live.after(self.node)  # the data for what comes next may be there already
            if said:
                self._tell()
        except Exception:  # what is traced must not end the learning
            log.exception("%s: a fault of this program", self.config.prefix)

    def decided(self, verb: Verb, name: str) -> bytes:
        """What an operator decides, in force and on the disk before it is answered: the ledger then.

        Raises:
            BadInput: it cannot be; all is as it was, or what is in force is not on the disk yet.
        """
        instead = self.live.decide(self.node, verb, name)
        if instead is not None:
            problem = self._change_over(instead)
            self._tell()
            if problem is not None:
                raise BadInput(f"{name} could not be {_DONE[verb]}: {problem}")
        if self.disk_first.problem is not None:
            raise BadInput(f"{name} is {_DONE[verb]}, but that is not on the disk yet: {self.disk_first.problem}")
        return wire.encode(self.node.ledger)

    def _change_over(self, instead: TracingState) -> str | None:
        """From the effects before to those that are in force now, in one revision; where that fails, all stays.

        Returns:
            why it failed.
        """
        live = self.live
        try:
            outcome = self.node.relearn(live.effects, self._validation(live.effects), live.since)
        except Exception as error:  # whatever effects do to the samples, learning goes on
            why = str(error) if isinstance(error, BadInput) else f"{type(error).__name__}: {error}"
            if not isinstance(error, BadInput):
                log.exception("%s: a fault of this program", self.config.prefix)
            live.put_back(self.node, instead, why)
            return why
        self.watch_over(live.effects)
        self.say()
        if outcome is not None:  # else nothing was ever learned; the ledger, which follows, brings it to the disk
            self.disk_first.iteration(outcome)
        return None

    def say(self) -> None:
        """Where live tracing stands, to the node's ledger."""
        live = self.live
        self.node.tell(findings(live.standing), live.standing.history, live.work)

    def _tell(self) -> None:
        self.say()
        self.disk_first.ledger()

    def _validation(self, effects: TracedEffects | None) -> dict[str, Samples]:
        """The validation data freed of these effects; a recording that cannot be is left out aloud."""
        found = {}
        for name, path in self.config.validation.items():
            try:
                found[name] = read_validation(path, self.config, effects)
            except BadInput as error:
                log.warning("%s: %s", self.config.prefix, error)
        return found
