"""One learner: measurements in, iterations out. No bus and no files, so that a hundred fit in one process.

A vehicle's axis is one `LearnerNode`. Measurements are pushed from any thread; one thread calls `learn` and gets the
next iteration whenever a batch is complete; anybody may ask `served` at any time. All that it publishes follows from
the measurements and their stamps alone, but the training time.
"""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from incsvr import learner
from incsvr.errors import BadInput
from incsvr.learner import Iteration, State
from incsvr.model import Model
from incsvr.samples import Array, Samples
from incsvr.signals import REQUIRED, Synchroniser
from service import wire
from service.config import Config

#: Batches that may wait for training; beyond, the oldest samples go and are counted.
WAITING_BATCHES = 200
#: Two streams that stay this far behind their own past [s] for so many values belong to a clock that began anew.
RESTART_S, RESTART_VALUES = 10.0, 20
#: Values that may wait for that to be known.
HELD_VALUES = 20_000


class NothingLearned(BadInput):
    """There is no model yet."""


@dataclass(frozen=True, slots=True)
class Served:
    """What queries are answered from; replaced as a whole."""

    model: Model
    revision: int
    iteration: int
    t: float | None  # the vehicle's time of the newest sample in it [s]


@dataclass(frozen=True, slots=True)
class Outcome:
    """One iteration as it is stored and published, and the learner's whole memory after it as plain data."""

    snapshot: wire.ModelSnapshot
    report: wire.IterationReport
    memory: dict[str, Any]


@dataclass(slots=True)
class _Held:
    """Values that are far behind their stream, and wait."""

    parts: list[tuple[Array, Array]] = field(default_factory=list)
    count: int = 0

    def take(self) -> tuple[Array, Array]:
        """All of them, and none are left."""
        nothing = np.empty(0)
        t = np.concatenate([nothing, *(part[0] for part in self.parts)])
        value = np.concatenate([nothing, *(part[1] for part in self.parts)])
        self.parts, self.count = [], 0
        return t, value


class LearnerNode:
    """The learner of one axis of one vehicle.

    Args:
        config: what is configured for it.
        boot: identifies this start of the process.
        memory: what an earlier `memory()` gave, to go on from there.
        validation: samples that the served model's error is measured on after each iteration, by name.
        effects: traced effects that the published model carries (CONTRACT, Section 5).
        clock: a monotonic clock [s]; only the training time is measured with it.
    """

    def __init__(
        self,
        config: Config,
        boot: str,
        *,
        memory: Mapping[str, Any] | None = None,
        validation: Mapping[str, Samples] | None = None,
        effects: tuple[dict[str, Any], ...] = (),
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        self.config, self.boot, self.effects = config, boot, effects
        self._settings = config.learner_settings()
        self._validation = dict(validation or {})
        self._clock = clock
        self._lock = threading.Lock()
        self._synchroniser = Synchroniser(config.signal_settings())
        self._waiting: deque[Samples] = deque()
        self._waiting_count = 0
        self._behind = {stream: _Held() for stream in REQUIRED}
        self._refused: dict[str, int] = {}
        self._samples_seen = 0
        self._recent_rates: deque[float] = deque(maxlen=10)
        self._state = learner.start(self._settings)
        self._covered = np.full(self._settings.bins, -math.inf)
        revision, newest = 0, None
        if memory is not None:
            self._state = State.from_dict(memory["learner"])
            self._covered = np.array([-math.inf if t is None else t for t in memory["covered"]])
            revision, newest = memory["revision"], memory["t"]
            if "synchroniser" in memory:
                self._synchroniser = Synchroniser.from_dict(memory["synchroniser"])
                self._refused = {reason: -count for reason, count in self._synchroniser.rejected.items()}
                self._take(_samples(memory["waiting"]))
        self.served = Served(self._state.model, revision, self._state.iterations, newest)

    def push(self, stream: str, t: Array, value: Array) -> bool:
        """Takes (n,) stamps [s] and values of a stream, n ≥ 1; True where a batch waits to be learned."""
        with self._lock:
            if stream in self._behind:
                t, value = self._hold_back(stream, t, value)
            if t.size == 1:  # three times as quick, and the most frequent case by far
                self._synchroniser.push_one(stream, float(t[0]), float(value[0]))
            else:
                self._synchroniser.push(stream, t, value)
            if all(held.count >= RESTART_VALUES for held in self._behind.values()):
                self._restart_clock()
            self._take(self._synchroniser.ready())
            return self._waiting_count >= self._settings.batch

    def learn(self) -> Outcome | None:
        """The next iteration, where a whole batch waits; call it from one thread alone."""
        batch = self._next_batch()
        if batch is None:
            return None
        before = self.served
        predicted = before.model.predict(batch.yaw_rate).damping if before.model.is_trained else None
        began = self._clock()
        self._state, iteration = learner.step(self._settings, self._state, batch)
        if iteration.model.is_trained:
            iteration.model.predict(0.0)  # makes it ready for questions, here and not when the first one waits
        took = self._clock() - began
        self._cover(batch)
        self.served = Served(iteration.model, before.revision + 1, iteration.number, float(batch.time[-1]))
        return Outcome(self._snapshot(), self._report(iteration, batch, predicted, took), self.memory())

    def predict(self, rates: Array) -> wire.DampingReply:
        """The damping at (n,) finite rates [rad/s].

        Raises:
            NothingLearned: ask again later.
        """
        served = self.served
        if not served.model.is_trained:
            raise NothingLearned("nothing has been learned yet; ask again once a first batch of samples is complete")
        prediction = served.model.predict(rates)
        return wire.DampingReply(
            rate=tuple(rates.tolist()),
            damping=tuple(prediction.damping.tolist()),
            sigma=tuple(prediction.sigma.tolist()),
            extrapolated=tuple(prediction.extrapolated.tolist()),
            iteration=served.iteration,
            revision=served.revision,
        )

    @property
    def learned(self) -> float:
        """The part of the configured rate range that fresh samples cover, 0 to 1."""
        newest = self.served.t
        if newest is None:
            return 0.0
        return float(np.mean(self._covered >= newest - self.config.health.fresh_for))

    @property
    def rejected(self) -> dict[str, int]:
        """Values that were not learned from since this start, by reason."""
        with self._lock:
            total = dict(self._refused)
            for reason, count in self._synchroniser.rejected.items():
                total[reason] = total.get(reason, 0) + count
        return {reason: count for reason, count in total.items() if count}

    @property
    def samples_seen(self) -> int:
        """Synchronised samples since this start."""
        return self._samples_seen

    @property
    def recent_rates(self) -> tuple[float, ...]:
        """Yaw rates of the newest few samples [rad/s]."""
        return tuple(self._recent_rates)

    def memory(self, whole: bool = False) -> dict[str, Any]:
        """All that must survive a restart, as plain data; `whole` adds the samples on their way to the next batch."""
        known: dict[str, Any] = {
            "learner": self._state.to_dict(),
            "revision": self.served.revision,
            "covered": [None if math.isinf(t) else t for t in self._covered.tolist()],
            "t": self.served.t,
        }
        if whole:
            with self._lock:
                known["synchroniser"] = self._synchroniser.to_dict()
                known["waiting"] = _plain(Samples.concatenate(self._waiting))
        return known

    def latest(self) -> wire.ModelSnapshot | None:
        """The snapshot of what is served; None before anything was learned."""
        return self._snapshot() if self.served.revision else None

    def _hold_back(self, stream: str, t: Array, value: Array) -> tuple[Array, Array]:
        """What may go on now. Stamps far behind wait until it is known whether the vehicle's clock began anew.

        They are late where their own stream goes on ahead of them.
        """
        held, newest = self._behind[stream], self._synchroniser.newest(stream)
        if newest is None or (not held.count and t.min() >= newest - RESTART_S):
            return t, value
        ahead = np.flatnonzero(~((t >= 0.0) & (t < newest - RESTART_S)))
        end = int(ahead[-1]) + 1 if ahead.size else 0
        if not end and held.count + t.size <= HELD_VALUES:
            held.parts.append((t, value))
            held.count += t.size
            return t[:0], value[:0]
        before = held.take()
        if end < t.size:
            held.parts.append((t[end:], value[end:]))
            held.count = t.size - end
        return np.concatenate((before[0], t[:end])), np.concatenate((before[1], value[:end]))

    def _restart_clock(self) -> None:
        """Begins anew where both streams show that the vehicle's clock did (it was switched off and on)."""
        for reason, count in self._synchroniser.rejected.items():
            self._refused[reason] = self._refused.get(reason, 0) + count
        self._refused["clock_restarted"] = self._refused.get("clock_restarted", 0) + 1
        self._synchroniser = Synchroniser(self.config.signal_settings())
        for stream, held in self._behind.items():
            self._synchroniser.push(stream, *held.take())
        self._covered[:] = np.where(np.isfinite(self._covered), 0.0, -math.inf)

    def _take(self, samples: Samples) -> None:
        if not len(samples):
            return
        self._waiting.append(samples)
        self._waiting_count += len(samples)
        self._samples_seen += len(samples)
        self._recent_rates.extend(samples.yaw_rate[-10:].tolist())
        excess = self._waiting_count - WAITING_BATCHES * self._settings.batch
        if excess > 0:
            self._refused["overload"] = self._refused.get("overload", 0) + excess
            kept = Samples.concatenate(self._waiting).take(slice(excess, None))
            self._waiting = deque([kept])
            self._waiting_count = len(kept)

    def _next_batch(self) -> Samples | None:
        size = self._settings.batch
        with self._lock:
            if self._waiting_count < size:
                return None
            parts, count = [], 0
            while count < size:
                parts.append(self._waiting.popleft())
                count += len(parts[-1])
            joined = Samples.concatenate(parts)
            if count > size:
                self._waiting.appendleft(joined.take(slice(size, None)))
            self._waiting_count -= size
        return joined.take(slice(0, size))

    def _cover(self, batch: Samples) -> None:
        low, high = self._settings.rate_range
        bins = np.floor((batch.yaw_rate - low) / (high - low) * self._covered.size)
        inside = (bins >= 0) & (bins < self._covered.size)
        self._covered[bins[inside].astype(int)] = batch.time[inside]

    def _snapshot(self) -> wire.ModelSnapshot:
        served, model = self.served, self.served.model
        return wire.ModelSnapshot(
            boot=self.boot,
            revision=served.revision,
            iteration=served.iteration,
            t=served.t or 0.0,
            kernel=wire.Kernel(gamma=model.gamma),
            epsilon=model.epsilon,
            C=model.C,
            support=wire.Support(
                rate=tuple(model.support_rate.tolist()),
                damping=tuple(model.support_damping.tolist()),
                weight=tuple(model.weight.tolist()),
                count=tuple(model.count.tolist()),
            ),
            inertia=self.config.vehicle.inertia,
            effects=self.effects,
            sigma=_finite(model.sigma),
            trained_range=model.trained_range,
            certified_error=_finite(model.certified_error),
        )

    def _report(
        self, iteration: Iteration, batch: Samples, predicted: Array | None, took_s: float
    ) -> wire.IterationReport:
        sets: dict[str, Samples] = {name: getattr(iteration, name) for name in wire.SETS}
        return wire.IterationReport(
            boot=self.boot,
            revision=self.served.revision,
            iteration=iteration.number,
            t=float(batch.time[-1]),
            time_span=iteration.time_span,
            trained=iteration.trained,
            training_ms=1e3 * took_s,
            counts={name: len(samples) for name, samples in sets.items()} | {"batch": len(batch)},
            **{name: _points(samples) for name, samples in sets.items()},
            batch=wire.Batch(
                time=tuple(batch.time.tolist()),
                rate=tuple(batch.yaw_rate.tolist()),
                damping=tuple(batch.damping.tolist()),
                predicted=None if predicted is None else tuple(predicted.tolist()),
                channels={name: _sampled(values) for name, values in batch.channels.items()},
            ),
            certified_error=_finite(iteration.model.certified_error),
            progressive_mae=iteration.progressive_mae,
            sigma=_finite(iteration.model.sigma),
            validation=tuple(self._error_on(name, samples) for name, samples in self._validation.items()),
            learned=self.learned,
            change=iteration.change,
        )

    def _error_on(self, name: str, samples: Samples) -> wire.Validation:
        residual = self.served.model.predict(samples.yaw_rate).damping - samples.damping
        return wire.Validation(
            name=name,
            mae=float(np.mean(np.abs(residual))),
            rmse=math.sqrt(float(np.mean(residual**2))),
            samples=len(samples),
        )


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _sampled(values: Array) -> tuple[float | None, ...]:
    return tuple(None if math.isnan(value) else value for value in values.tolist())


def _points(samples: Samples) -> wire.Points:
    return wire.Points(rate=tuple(samples.yaw_rate.tolist()), damping=tuple(samples.damping.tolist()))


def _plain(samples: Samples) -> dict[str, Any]:
    return {
        "time": samples.time.tolist(),
        "yaw_rate": samples.yaw_rate.tolist(),
        "damping": samples.damping.tolist(),
        "channels": {name: _sampled(values) for name, values in samples.channels.items()},
    }


def _samples(plain: Mapping[str, Any]) -> Samples:
    return Samples(
        np.array(plain["time"], dtype=np.float64),
        np.array(plain["yaw_rate"], dtype=np.float64),
        np.array(plain["damping"], dtype=np.float64),
        {name: np.array(values, dtype=np.float64) for name, values in plain["channels"].items()},
    )
