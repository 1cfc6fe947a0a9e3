"""A tracing process that is killed at any moment, beside a learner that goes on."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import psutil

from benchmarks.service.bus import BLOCK, KEYS, PATIENCE_S, Learner, learner
from benchmarks.service.hold.row import Row
from service.recordings.recording import Recording
from service.wire import EffectsLedger, ModelSnapshot, decode, encode, measurement
from simulator.mission import Mission
from simulator.vehicles import TURNING
from simulator.world import play

WINDOW_S, PROOF_S = 240.0, 60.0
"""Window and proof of the tracing [s of data]."""
PART_S = 60.0
"""Length of a part of the data that is sent at once [s of data]: with most parts a trace or a proof is due."""
SPARED_SHARE = 0.1
"""The share of the processes that are not killed, so that traces end and proofs begin, which are killed as well."""
MAX_KILL_DELAY_S = 3.0
"""Longest time from the sight of a process to its kill [s]; a process that has ended by then counts as not killed."""

Moment = Callable[[], float | None]
"""How long after it was seen the next process is killed [s]; None lets it be."""


@dataclass
class Record:
    """What became of a learner.

    Attributes:
        models: each published model, as the learner answers it at the end.
        sent: the end of the data that were sent [s].
        counters: samples and what was rejected, as health counts them.
        ends: the vehicle's time at which a process was begun [s].
        kills: of them those that were killed.
        told: seconds until health told of each kill; those that it did not tell of are not in it.
        left: folders that killed processes left behind.
    """

    models: dict[int, bytes] = field(default_factory=dict)
    sent: float = 0.0
    counters: tuple[int, ...] = ()
    ends: list[float] = field(default_factory=list)
    kills: list[float] = field(default_factory=list)
    told: list[float] = field(default_factory=list)
    left: int = 0


def tracing_kills(times: int, seed: int) -> Row:
    """Kills processes beside a learner of a vehicle with a hidden lag, and plays the same data without tracing."""
    random = np.random.default_rng(seed)
    trial = play(Mission(TURNING["leng"], "telegraph", seed, ("torque_lag",), duration=WINDOW_S + PART_S * (3 * times + 2)))

    def some() -> float | None:
        return None if random.random() < SPARED_SHARE else float(random.uniform(0.0, MAX_KILL_DELAY_S))

    killed = _record(trial.recording, trial.inertia, "advise", some, times)
    calm = _record(trial.recording, trial.inertia, "off", lambda: None, times, until=killed.sent)
    revisions = killed.models.keys() | calm.models.keys()
    lost = sum(killed.models.get(each) != calm.models.get(each) for each in revisions)
    lost += sum(abs(one - other) for one, other in zip(killed.counters, calm.counters, strict=True))
    after = [min(end for end in killed.ends if end > kill) - kill for kill in killed.kills]
    return Row(
        "the tracing process killed at a random moment",
        len(killed.kills),
        lost,
        len(killed.kills) - len(killed.told) + killed.left,
        killed.told,
        f"of {len(calm.models)} models and {calm.counters[0]} samples those that differ without tracing; the next of "
        f"{len(killed.ends)} traces and proofs began within {max(after):.0f} s of data; time until health says it",
    )


def _record(whole: Recording, inertia: float, live: str, moment: Moment, times: int, until: float = np.inf) -> Record:
    """A learner that is sent a recording part by part, until so many processes were killed and one more begun."""
    record, seen, streak = Record(), set[int](), 0
    settings = {"vehicle.inertia": inertia, "vehicle.rate_range": [-0.35, 0.35], "tracing.live": live}
    with learner(**settings, **{"tracing.window": WINDOW_S, "tracing.proof": PROOF_S}) as subject:
        for begin in np.arange(0.0, min(until, float(whole.time[-1])), PART_S).tolist():
            _send(subject, whole, begin)
            record.sent = begin + PART_S
            while (process := _next(subject, seen)) is not None:
                record.ends.append(record.sent)
                seen.add(process.pid)
                wait = moment() if len(record.kills) < times else None
                if wait is None or not (folder := _killed(process, wait)):
                    streak = 0
                    continue
                streak += 1
                record.kills.append(record.sent)
                record.told += _told(subject, streak)
                record.left += folder.exists()
            if len(record.kills) == times and record.ends[-1] > record.kills[-1]:
                break
        health = subject.health()
        record.counters = health.counters["samples"], health.counters["rejected"]
        record.models = {revision: _model(subject, revision) for revision in range(1, health.revision + 1)}
    return record


def _model(subject: Learner, revision: int) -> bytes:
    """A published model as the learner answers it, but for the boot; empty where it has none."""
    (reply,) = list(subject.session.get(f"{KEYS.model}?revision={revision}", timeout=PATIENCE_S))
    if reply.ok is None:
        return b""
    return encode(decode(ModelSnapshot, reply.ok.payload.to_bytes()).model_copy(update={"boot": ""}))


def _send(subject: Learner, whole: Recording, begin: float) -> None:
    """Sends a part of a recording, and waits until it has arrived."""
    count = 0
    for name, (t, value) in whole.streams().items():
        for first in np.arange(begin, begin + PART_S, 5.0).tolist():
            inside = (t >= first) & (t < first + 5.0)
            payload = measurement(tuple(t[inside].tolist()), tuple(value[inside].tolist()))
            subject.session.put(KEYS.stream(name), payload, congestion_control=BLOCK)
        count = int(np.count_nonzero(t < begin + PART_S)) if name == "torque" else count
    until = time.monotonic() + PATIENCE_S
    while subject.health().streams["torque"].received < count:
        if time.monotonic() > until:
            raise RuntimeError(f"of {count} torques some never arrived: {subject.health().counters}")
        time.sleep(0.05)


def _next(subject: Learner, seen: set[int]) -> psutil.Process | None:
    """The next process beside the learner; None once it has learned all that came, and none is at work."""
    calm, samples = 0, -1
    while calm < 5:
        for process in subject.process.children():
            if process.pid not in seen:
                return process
        (reply,) = [each.ok for each in subject.session.get(KEYS.effects, timeout=PATIENCE_S)]
        at_work = reply is None or decode(EffectsLedger, reply.payload.to_bytes()).work is not None
        before, samples = samples, subject.health().counters["samples"]
        calm = 0 if at_work or samples != before else calm + 1
        time.sleep(0.05)
    return None


def _killed(process: psutil.Process, wait: float) -> Path | None:
    """Kills a process so much later [s]; its folder, or None where it had ended."""
    with suppress(psutil.NoSuchProcess, psutil.TimeoutExpired, IndexError):
        folder = Path(process.cmdline()[-1])
        with suppress(psutil.TimeoutExpired):
            process.wait(wait)
            return None
        process.suspend()  # what stands still has not ended at the same moment
        while process.status() not in (psutil.STATUS_STOPPED, psutil.STATUS_ZOMBIE):
            time.sleep(0.001)
        if process.status() == psutil.STATUS_STOPPED:
            process.kill()
            return folder
    return None


def _told(subject: Learner, streak: int) -> list[float]:
    """The time until health tells of the last of so many kills one after the other [s]; empty where it does not."""
    began, often = time.monotonic(), "(once)" if streak == 1 else f"({streak} times one after the other)"
    while (took := time.monotonic() - began) < PATIENCE_S:
        if any(f"killed by signal 9 {often}" in reason for reason in subject.health().reasons):
            return [took]
        time.sleep(0.02)
    return []
