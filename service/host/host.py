"""A learner on the bus: its subscriptions, its answers, its publications and its durable state, held together.

    measurements → Feed → LearnerNode → disk → bus
                               ↑ Answers

It has no threads but the one that answers for damping: `worker_threads` does the work for all learners of a
process. The liveliness token is declared last: who sees it can ask.
"""

from __future__ import annotations

import logging
import time
import uuid
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

import zenoh

from incsvr.checks.verdict import CHANGE_MEMORY_S
from incsvr.errors import BadInput
from incsvr.forecasting.thrust_watch import NORMAL_95_DEVIATIONS, ThrustChange
from incsvr.plant.mass_and_coriolis import inertia_in_force
from incsvr.plant.words import AxisWords
from service import wire
from service.bus.ingest import Feed, Ingest
from service.bus.publishers import HealthPublisher, Publishers
from service.bus.session import DuplicateLearner, certificates, finish_in_time, from_file
from service.config.configuration import Config
from service.config.traced_effects import OperatorVerb, TracedEffects, configured_effects
from service.health.health_watch import HealthConditions, HealthWatch
from service.host.answers import Answers
from service.host.effect_switch import EffectSwitch
from service.host.persist_then_publish import PARAMETERS_KEY, PersistThenPublish
from service.inputs.settings import Axis
from service.learner.node import LearnerNode
from service.learner.stand_in import estimate
from service.recordings.archive import archive_of
from service.recordings.validation import read_validation
from service.state.history import IN_MEMORY_BYTES, History
from service.state.store import Store

if TYPE_CHECKING:
    from service.bus.mapped_ingest import MappedIngest
    from service.live.live_tracing import LiveTracing


def thrust_event(node: LearnerNode, history: History, change: ThrustChange) -> wire.ThrustEvent:
    """A change of the thrust as it is published."""
    level, doubt = change.level
    half = NORMAL_95_DEVIATIONS * doubt
    try:
        revision = history.at(change.since).revision
    except BadInput:
        revision = None
    return wire.ThrustEvent(
        boot=node.boot,
        event="thrust back" if change.is_back else "thrust lost",
        axis=node.words.name,
        since=change.since,
        t=change.seen,
        size=1.0 - level,
        size_low=1.0 - level - half,
        size_high=1.0 - level + half,
        thrust=level,
        inertia=inertia_in_force(node.config.vehicle.inertia, node.served.effects),
        revision=revision,
        cannot_tell_from=change.cannot_tell_from,
        why=sentence(change, node.words),
    )


def sentence(change: ThrustChange, words: AxisWords) -> str:
    """A change of the thrust for people."""
    level, doubt = change.level
    half = NORMAL_95_DEVIATIONS * doubt
    within = f"{100.0 * level:.0f} % (± {100.0 * half:.0f} %)"
    if change.is_back:
        return f"since {change.since:.1f} s the {words.name} thrust is back: {within} of the usual {words.effort} acts"
    return (
        f"since {change.since:.1f} s {words.name} thrust is lost: {within} of the commanded {words.effort} acts; "
        "look at the thrusters for a rope, a fault of a drive or an empty battery"
    )


def thrust_notice(node: LearnerNode, change: ThrustChange | None) -> tuple[str, ...]:
    """What health says of the last change: while thrust is lost, and for some minutes after it is back.

    Args:
        node: the learner.
        change: the last change since the start; None where there is none.
    """
    if change is not None and not change.is_back:
        return (sentence(change, node.words),)
    if change is not None:
        newest = node.served.t
        return (sentence(change, node.words),) if newest is None or newest - change.seen < CHANGE_MEMORY_S else ()
    lost = 0.0 if node.thrust is None else 1.0 - node.thrust.state.level
    if lost <= 0.0:
        return ()
    return (f"before the restart {100.0 * lost:.0f} % of the {node.words.name} thrust was lost",)


def pause_words(paused: str | None, change: ThrustChange | None) -> str | None:
    """Why learning is paused, with the thrust that is lost meanwhile: the checks of the sensors do not know of it."""
    if paused is None or change is None or change.is_back:
        return paused
    return f"{paused}; the thrust that is lost may be the cause"


log = logging.getLogger(__name__)


class Host:
    """One learner on a session, from its construction until `close`; `learners` are in this process altogether, and the
    thrusters of its inputs make the efforts of `further` axes as well."""

    def __init__(
        self, session: zenoh.Session, config: Config, learners: int = 1, further: tuple[Axis, ...] = ()
    ) -> None:
        self.keys = wire.Keys(config.prefix)
        self._session, self._config, self.further = session, config, further
        self._effects = configured_effects(config)
        known_by = None if self._effects is None else self._effects.identity
        changing = config.tracing.on
        self._store = None if config.state is None else Store(config.state, config, known_by, changing)
        self._history = History(0, IN_MEMORY_BYTES) if self._store is None else self._store.history
        self.node, self._live = self._restore()
        askable = config.inputs.preset == "blueos"
        self.watch = HealthWatch(config.health, time.monotonic(), time.monotonic, config.coupled(), askable)
        effects = self._effects if self._live is None else self._live.effects
        self.node.validate_on(
            {name: read_validation(path, config, effects) for name, path in config.validation.items()}
        )
        self._duplicate = DuplicateLearner(session, self.keys, self.node.boot, time.monotonic)
        zenoh_file = config.bus.zenoh_file
        self._certificates = () if zenoh_file is None else certificates(from_file(zenoh_file))
        self._archive = archive_of(config, self.node.boot, learners)
        self._publishers = Publishers(session, self.keys, self._archive)
        self.mapped = self._mapping(learners)
        self.led_by: MappedIngest | None = None  # reads for it in another learner of its vehicle
        self._persist_then_publish = PersistThenPublish(
            config, self.node, self._store, self._history, self._publishers, self._live, self.mapped
        )
        self._thrust_change: ThrustChange | None = None  # the last one
        self._switch: EffectSwitch | None = None
        if self._live is not None:
            self._switch = EffectSwitch(config, self.node, self._live, self._persist_then_publish)
            self._switch.tell_node()
        self._health_publisher = HealthPublisher(session, config, self._publishers)
        latest = self.node.latest()
        if latest is not None:
            log.info("%s: resumes after revision %d", config.prefix, latest.revision)
            for remark in self.node.remarks:
                log.info("%s: %s", config.prefix, remark)
            self._publishers.publish(self.keys.model, wire.encode(latest))
        self.answers = Answers(session, self.keys, self.node, self.watch, self._history)
        # Further channels come on our own keys, whoever brings yaw rate and torque.
        own = Ingest(session, self.keys, self.watch, learners, required=self.mapped is None, archive=self._archive)
        self.feed = Feed(self.node, self.watch, (own,) if self.mapped is None else (own, self.mapped))
        self.tick()
        self._publishers.publish(self.keys.effects, wire.encode(self.node.ledger))
        self._token: Any = session.liveliness().declare_token(self.keys.alive)

    @property
    def _stored(self) -> dict[str, Any]:
        """The memory that was restored; empty where it begins anew."""
        return (None if self._store is None else self._store.memory) or {}

    def _mapping(self, learners: int) -> MappedIngest | None:
        """The mapper of other forms; None if all inputs have our own form."""
        if self._config.inputs.own:
            return None
        # Loaded where it is needed alone, like the other parts that not every learner has.
        from service.bus.mapped_ingest import MappedIngest

        known = self._stored.get(PARAMETERS_KEY) or {}
        return MappedIngest(
            self._session, self.watch, self._config, known, learners, self._archive, further=self.further
        )

    def _restore(self) -> tuple[LearnerNode, LiveTracing | None]:
        """The learner as it was; a memory that cannot be taken up, for whatever reason, is set aside."""
        while True:
            memory = None if self._store is None else self._store.memory
            try:
                return self._build(memory)
            except Exception as error:
                if self._store is None or memory is None:
                    raise
                kind = "" if isinstance(error, BadInput) else f"it cannot be restored: {type(error).__name__}: "
                self._store.refuse(f"{kind}{error}")

    def _build(self, memory: dict[str, Any] | None) -> tuple[LearnerNode, LiveTracing | None]:
        effects, live = self._effects, None
        if self._config.tracing.on:
            # Loaded where it is needed alone: most learners do without.
            from service.live.live_tracing import LiveTracing

            live = LiveTracing(self._config, (memory or {}).get("live"))
            effects = live.effects
        node = LearnerNode(
            self._config,
            boot=uuid.uuid4().hex[:12],
            memory=memory,
            published=0 if self._store is None else self._store.published,
            effects=effects,
        )
        return node, live

    def tick(self) -> bool:
        """Publishes health when it is due or has changed, and says in the log what was rejected.

        Returns:
            whether `learn` is to be called though no batch may wait.
        """
        now = time.monotonic()
        store, mapped = self._store, self.mapped
        self.watch.observe(self._conditions())
        health = self.watch.report(self.node)
        ros = mapped is not None and self._config.inputs.preset == "ros2"
        self._health_publisher.publish(health, now, mapped.rate_key() if ros and mapped is not None else None)
        return (self._live is not None and self._live.waits) or (store is not None and store.due)

    def _conditions(self) -> HealthConditions:
        """The reports of the parts beside the streams; publishes the estimate if it is due."""
        store, mapped, effects = self._store, self.mapped, self._effects_in_force
        arming = mapped or self.led_by
        dated = (each.sentence_now() for each in self._certificates)
        notices = (
            *(sentence for sentence in dated if sentence is not None),
            *(() if store is None else store.notices),
            *self._duplicate.notice(),
            *(() if effects is None else effects.warnings),
            *(() if mapped is None else mapped.notices()),
            *(() if self._archive is None else self._archive.notices()),
            *self._estimate(),
            *thrust_notice(self.node, self._thrust_change),
        )
        channels = self._config.signals.channels
        return HealthConditions(
            notices,
            unsaved=None if store is None else store.problem,
            paused=(
                pause_words(self.node.current_warnings.paused, self._thrust_change),
                None if arming is None else arming.why_not,
            ),
            effect_channels=() if effects is None else effects.compensation.reads(channels),
        )

    @property
    def _effects_in_force(self) -> TracedEffects | None:
        """The traced effects that samples are freed of."""
        return self._effects if self._switch is None else self._switch.in_force

    def _estimate(self) -> tuple[str, ...]:
        """While the gyro is silent or not believed and the torque comes, the model's own rate goes out.

        Returns:
            what health says of it.
        """
        if self.watch.silence_s("torque") is not None:
            return ()
        found = estimate(self.node, self.watch.silence_s("yaw_rate"))
        if found is None:
            return ()
        self._publishers.publish(self.keys.estimate, wire.encode(found))
        return (f"{self.keys.estimate} comes from the model: {found.why}",)

    def learn(self) -> bool:
        """One iteration, where a batch waits, kept and published; False where none does. From one thread alone."""
        try:
            outcome = self.node.learn()
        except Exception as error:  # one bad batch must not end the learning
            log.exception("%s: an iteration failed; its batch is lost", self.keys.prefix)
            self.watch.add_failure(f"an iteration failed and its batch is lost: {error}")
            return True
        self._publish_thrust_changes()
        if outcome is not None:
            self._persist_then_publish.iteration(outcome)
        elif self._store is not None:
            self._store.save_again()
        if self._switch is not None:
            self._switch.after_batch()
        self.answers.decide(self._decide)
        return outcome is not None

    def _publish_thrust_changes(self) -> None:
        """Publishes what was found of the thrust, from the thread that learns."""
        for change in () if self.node.thrust is None else self.node.thrust.take():
            event = thrust_event(self.node, self._history, change)
            log.warning("%s: %s", self.keys.prefix, event.why)
            self._thrust_change = change
            self._publishers.publish(self.keys.event, wire.encode(event))

    def goodbye(self) -> None:
        """Says that this learner is no longer to be asked."""
        self._token.undeclare()

    def close(self) -> None:
        """Takes what has come and saves; the threads that call the other methods have ended before."""
        with ExitStack() as last:  # the last is done first, and each whatever the others raise
            last.callback(finish_in_time, self._undeclare)
            if self._archive is not None:
                last.callback(self._archive.close)
            if self._live is not None:
                last.callback(self._live.close)
            if self._store is not None:
                last.callback(self._store.close)
            last.callback(self._persist_then_publish.last_samples)
            self.feed.drain()

    def _undeclare(self) -> None:
        """Undeclares all but the publishers: theirs may take ten seconds, and ends with the session."""
        self.feed.close()
        self.answers.close()
        self._health_publisher.close()
        self._duplicate.close()

    def _decide(self, verb: OperatorVerb, name: str) -> bytes:
        """Carries out the decision of an operator (`EffectSwitch.decide`)."""
        if self._switch is None:
            raise BadInput("tracing.live is off here, so no effect is sought; set it to advise or adopt")
        return self._switch.decide(verb, name)
