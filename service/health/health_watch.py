"""The health of a learner: one level, and sentences with the reasons.

ERROR: what was learned cannot be kept, or an iteration failed. STALE: a stream is silent for longer than its limit.
WARN: samples were rejected or lost, the torque hardly moves the vehicle, it moves where the model only extrapolates,
the yaw rate is constant, an earlier state was set aside, a traced effect had to be left out, learning is starved or
paused. OK may come with a note: what is taken for zero. Ages are wall time; the clock is injected.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from incsvr.checks import implausible
from incsvr.numerics import Array
from incsvr.plant.body import Coupled
from incsvr.plant.words import AxisWords
from incsvr.signals import MAX_CHANNELS, REQUIRED
from incsvr.signals.streams import JUMP_S, Reading
from service import wire
from service.config.sections import HealthLimits
from service.health import sentences
from service.health.starvation import Starvation, slow_stream
from service.health.stream_monitor import RecentRejections, SampleRateWatch, StreamMonitor
from service.learner.node import LearnerNode

WARN_S = 10.0
"""How long health shows a rejected sample [s], wall time."""
STUCK_S = 2.0
"""A yaw rate that is constant for longer is a fault [s]."""
MIN_SILENCE_S = 1.0
"""The silence after which a stream is one to stand in for [s]: streams come at 2 Hz and more."""
UNIT_CHECK_VALUES = 1000
"""Values of a stream by which is judged whether it is in another unit."""


@dataclass(frozen=True, slots=True)
class HealthConditions:
    """The reports of a learner's parts other than its streams; each is valid until the next.

    Attributes:
        notices: sentences, to be told as warnings.
        unsaved: why what was learned is not on the disk, in a few words; None where it is.
        paused: why learning is paused, each in one sentence or None, the gravest first.
        effect_channels: channels without which no sample can be freed of the traced effects.
    """

    notices: tuple[str, ...] = ()
    unsaved: str | None = None
    paused: tuple[str | None, ...] = ()
    effect_channels: tuple[str, ...] = ()


class HealthWatch:
    """Follows one learner; every method may be called from any thread.

    Args:
        limits: when to warn.
        started: of `clock`, when the process began [s].
        clock: a monotonic clock [s].
        coupled: the body in which the axis is learned: what samples need of it, and what is taken for zero.
        askable: whether the vehicle can be asked for more from here.
    """

    def __init__(
        self,
        limits: HealthLimits,
        started: float,
        clock: Callable[[], float],
        coupled: Coupled | None = None,
        askable: bool = False,
    ) -> None:
        self._limits, self._started, self._clock, self._askable = limits, started, clock, askable
        self._lock = threading.Lock()
        self._streams: dict[str, StreamMonitor] = {
            name: StreamMonitor(watches_stillness=name == "yaw_rate") for name in REQUIRED
        }
        self._refused: dict[str, int] = {}
        self._rejections = RecentRejections()
        self._failure: tuple[float, str] | None = None
        self._beyond: tuple[float, str] | None = None
        self._conditions = HealthConditions()
        self._learning = wire.Learning()
        self._starvation: Starvation | None = None
        self._rate_watch = SampleRateWatch()
        self._plausible: dict[str, tuple[int, int, str | None]] = {}  # received and refused until then, what was said
        self._body: tuple[str, ...] = () if coupled is None else coupled.streams
        self._notes: tuple[str, ...] = () if coupled is None else sentences.taken_for_zero(coupled)
        self._queries = 0
        self._vehicle: str = ""
        self._axes: dict[str, str] = {}

    def belongs_to(self, vehicle: str, axes: Mapping[str, str]) -> None:
        """From now on health names the vehicle, and its axes that this process learns, with the prefixes of their
        keys."""
        self._vehicle, self._axes = vehicle, dict(axes)

    def observe(self, conditions: HealthConditions) -> None:
        """Takes new reports of the parts other than the streams."""
        self._conditions = conditions

    def add_values(self, name: str, t: Array, value: Array) -> None:
        """Values of a stream came: (n,) stamps [s] and values, n at least 1."""
        with self._lock:
            self._stream(name).add(self._clock(), t, value)

    def add_number(self, name: str, sequence: int) -> None:
        """A message with this number came."""
        with self._lock:
            self._stream(name).sequence.add(sequence)

    def _stream(self, name: str) -> StreamMonitor:
        """The stream of that name; what comes after too many names is kept under one."""
        if name not in self._streams and len(self._streams) >= MAX_CHANNELS:
            name = "(further)"
        return self._streams.setdefault(name, StreamMonitor())

    def add_refusal(self, reason: str, count: int = 1) -> None:
        """A message was no measurement."""
        with self._lock:
            self._refused[reason] = self._refused.get(reason, 0) + count

    def add_failure(self, sentence: str) -> None:
        """An iteration failed; its batch is lost."""
        self.add_refusal("failed_iteration")
        with self._lock:
            self._failure = (self._clock(), sentence)

    def count_query(self) -> None:
        """A question is answered."""
        with self._lock:
            self._queries += 1

    def silence_s(self, name: str) -> float | None:
        """The silence of a stream that had arrived [s], if longer than SILENT; by the clock on the wall."""
        with self._lock:
            at = self._streams[name].at
        age = None if at is None else self._clock() - at
        return age if age is not None and age > MIN_SILENCE_S else None

    def rejections(self, node: LearnerNode) -> dict[str, int]:
        """The counts of rejected values since this start, by reason."""
        with self._lock:
            total = dict(self._refused)
            lost = sum(stream.sequence.lost for stream in self._streams.values())
        for reason, count in node.batches.rejected.items():
            total[reason] = total.get(reason, 0) + count
        return total | {"lost": lost} if lost else total

    def report(self, node: LearnerNode) -> wire.Health:
        """The state of health now."""
        now = self._clock()
        rejected = self.rejections(node)
        readings = node.batches.readings
        learning = self._learning_now(now, node, readings)
        stale, warnings = self._stale(now, node.words), self._warnings(now, node, rejected, readings)
        if learning.state == "paused" or (learning.state == "starved" and not stale):  # else the silence says it all
            warnings.insert(0, f"learning is {learning.state}: {learning.why}")
        by_level: dict[wire.Level, Sequence[str]] = {
            "ERROR": self._errors(now),
            "STALE": stale,
            "WARN": warnings,
            "OK": (*self._notes, *node.remarks),
        }
        served = node.served
        with self._lock:
            streams = {name: stream.health(now, readings.get(name)) for name, stream in self._streams.items()}
        return wire.Health(
            level=next((level for level, said in by_level.items() if said), "OK"),
            reasons=tuple(sentence for said in by_level.values() for sentence in said),
            counters={
                "samples": node.batches.samples_seen,
                "iterations": served.iteration,
                "queries": self._queries,
                "held": sum(reading.held for reading in readings.values()),
                "rejected": sum(rejected.values()),
                **{f"rejected:{reason}": count for reason, count in sorted(rejected.items())},
                **{f"spikes:{name}": count for name, count in sorted(node.batches.spikes.items())},
            },
            learned=node.fresh_coverage,
            boot=node.boot,
            revision=served.revision,
            iteration=served.iteration,
            t=served.t,
            uptime_s=round(now - self._started, 3),
            streams=streams,
            learning=learning,
            vehicle=self._vehicle,
            axes=self._axes,
        )

    def _learning_now(self, now: float, node: LearnerNode, readings: Mapping[str, Reading]) -> wire.Learning:
        """The state of learning. All reasons why nothing is learned, in the order in which they are told: what somebody
        decided, what the data are not, what they lack."""
        with self._lock:
            if self._starvation is None:
                self._starvation = Starvation(node.config.signal_settings(), self._started, node.words)
            starved, since = self._starvation.why(now, self._streams, readings, node.batches), self._starvation.since
            without_evidence = node.recent_batches.without_evidence_since
            reasons: list[wire.Reason] = [
                ("paused", why, since) for why in (*self._conditions.paused, self._units(node))
            ]
            reasons.append(("starved", starved, since))
            if without_evidence is not None:
                reasons.append(("starved", sentences.evidence_sentence(node), without_evidence))
            self._learning = self._learning.now((*reasons, ("learning", None, since)))
            return self._learning

    def _units(self, node: LearnerNode) -> str | None:
        """The sentence on a stream that seems to have another unit, by its newest values; None if none does."""
        refused = {name: each.get("implausible", 0) for name, each in node.batches.rejected_by_stream.items()}
        limits = {"yaw_rate": node.config.vehicle.rate_limit, "torque": node.config.vehicle.torque_limit}
        for name, limit in limits.items():
            count, received = refused.get(name, 0), self._streams[name].received
            before, then, _ = self._plausible.get(name, (0, 0, None))
            if received - before >= UNIT_CHECK_VALUES or name not in self._plausible:
                found = implausible(name, max(count - then, 0), received - before, limit, node.words)
                self._plausible[name] = received, count, None if found is None else found.sentence
        sentences = (sentence for _, _, sentence in self._plausible.values())
        return next((sentence for sentence in sentences if sentence is not None), None)

    def _errors(self, now: float) -> list[str]:
        unsaved = self._conditions.unsaved
        errors = [] if unsaved is None else [f"the state cannot be saved: {unsaved}"]
        with self._lock:
            if self._failure is not None and now - self._failure[0] <= WARN_S:
                errors.append(self._failure[1])
        return errors

    def _stale(self, now: float, words: AxisWords) -> list[str]:
        stale = []
        with self._lock:
            for name in REQUIRED:
                called = words.stream(name)
                at = self._streams[name].at
                if at is None:
                    if now - self._started > self._limits.stale_after:
                        stale.append(f"no {called} has arrived yet")
                elif now - at > self._limits.stale_after:
                    stale.append(f"the last {called} arrived {now - at:.1f} s ago")
            needed = dict.fromkeys(self._conditions.effect_channels, "the traced effects")
            needed = dict.fromkeys(self._body, "its terms of the mass matrix") | needed
            for name, what in needed.items():
                at = self._stream(name).at
                if now - (self._started if at is None else at) > max(self._limits.stale_after, JUMP_S):
                    stale.append(f"{name} does not arrive, and without it {what} cannot be subtracted")
        return stale

    def _warnings(
        self, now: float, node: LearnerNode, rejected: dict[str, int], readings: Mapping[str, Reading]
    ) -> list[str]:
        words, warnings = node.words, [*self._conditions.notices, *node.current_warnings.warnings]
        with self._lock:
            warnings += sentences.rejection_sentences(self._rejections.look(now, rejected, WARN_S), words)
            warnings += sentences.stillness_sentences(self._streams["yaw_rate"], STUCK_S, words)
        slow = slow_stream(node.config.signal_settings(), node.batches.smoothing, readings, words)
        warnings += [slow] if slow else []
        with self._lock:
            seldom = self._rate_watch.look(node.raw)
        warnings += [seldom.on_a_bus(self._askable, words)] if seldom is not None else []
        return [*warnings, *sentences.motion_sentences(node), *self._where_it_extrapolates(now, node)]

    def _where_it_extrapolates(self, now: float, node: LearnerNode) -> tuple[str, ...]:
        """Remembered for a while: a vehicle that goes to and fro would have health go to and fro with it."""
        found = sentences.extrapolation_sentence(node)
        if found is not None:
            self._beyond = (now, found)
        if self._beyond is None or now - self._beyond[0] > WARN_S:
            return ()
        return (self._beyond[1],)
