"""A learner that changes over from the effects in force to others, as live tracing finds or an operator decides."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from incsvr.errors import BadInput
from incsvr.signals.samples import Samples
from service import wire
from service.config.configuration import Config
from service.config.traced_effects import OperatorVerb, TracedEffects
from service.host.persist_then_publish import PersistThenPublish
from service.learner.node import LearnerNode
from service.live.ledger import findings
from service.recordings.validation import read_validation

if TYPE_CHECKING:
    from service.live.live_tracing import LiveTracing
    from service.live.tracing_state import TracingState

log = logging.getLogger(__name__)

_PARTICIPLES = {"promote": "promoted", "withdraw": "withdrawn"}


class EffectSwitch:
    """Live tracing of one learner on the bus; called by the thread that learns.

    Attributes:
        in_force: the effects that the learner's samples are freed of. From any thread.
    """

    def __init__(
        self, config: Config, node: LearnerNode, live: LiveTracing, persist_then_publish: PersistThenPublish
    ) -> None:
        self._config, self._node, self._live = config, node, live
        self._persist_then_publish = persist_then_publish
        self.in_force = live.effects

    def after_batch(self) -> None:
        """Runs live tracing after a batch, or when its process has ended."""
        live = self._live
        try:
            # Also while learning is paused: what the checks take for a clock that jumped may be an effect.
            said = live.after(self._node)
            if live.waits:
                instead = live.conclude(self._node)
                if instead is not None:
                    self._change_over(instead)
                self._tell()
                said = live.after(self._node)  # the data for what comes next may be there already
            if said:
                self._tell()
        except Exception:  # what is traced must not end the learning
            log.exception("%s: a fault of this program", self._config.prefix)

    def decide(self, verb: OperatorVerb, name: str) -> bytes:
        """Carries out an operator's decision, on the disk before the answer; returns the ledger.

        Raises:
            BadInput: it cannot be; all is as it was, or what is in force is not on the disk yet.
        """
        instead = self._live.decide(self._node, verb, name)
        if instead is not None:
            problem = self._change_over(instead)
            self._tell()
            if problem is not None:
                raise BadInput(f"{name} could not be {_PARTICIPLES[verb]}: {problem}")
        if self._persist_then_publish.problem is not None:
            raise BadInput(
                f"{name} is {_PARTICIPLES[verb]}, but that is not on the disk yet: {self._persist_then_publish.problem}"
            )
        return wire.encode(self._node.ledger)

    def _change_over(self, instead: TracingState) -> str | None:
        """Switches from the effects before to those in force now, in one revision; a failure changes nothing.

        Returns:
            why it failed.
        """
        live = self._live
        try:
            outcome = self._node.relearn(live.effects, self._validation(live.effects), live.since)
        except Exception as error:  # whatever effects do to the samples, learning goes on
            why = str(error) if isinstance(error, BadInput) else f"{type(error).__name__}: {error}"
            if not isinstance(error, BadInput):
                log.exception("%s: a fault of this program", self._config.prefix)
            live.put_back(self._node, instead, why)
            return why
        self.in_force = live.effects
        self.tell_node()
        if outcome is not None:  # else nothing was ever learned; the ledger, which follows, brings it to the disk
            self._persist_then_publish.iteration(outcome)
        return None

    def tell_node(self) -> None:
        """Writes the state of live tracing to the node's ledger."""
        live = self._live
        self._node.update_ledger(findings(live.state), live.state.history, live.work)

    def _tell(self) -> None:
        self.tell_node()
        self._persist_then_publish.ledger()

    def _validation(self, effects: TracedEffects | None) -> dict[str, Samples]:
        """The validation data freed of these effects; a recording that cannot be is left out aloud."""
        found = {}
        for name, path in self._config.validation.items():
            try:
                found[name] = read_validation(path, self._config, effects)
            except BadInput as error:
                log.warning("%s: %s", self._config.prefix, error)
        return found
