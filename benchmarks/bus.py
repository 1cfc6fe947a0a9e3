"""The learner on the bus, measured from outside on loopback: latency, throughput, cost at rest, cost of many.

Every figure comes from processes of their own, as on a vehicle: the learner is `incsvr serve`. The echo beside which
the damping query is measured is a bare Zenoh queryable in a process of its own, asked in turn with the learner, so that
both see the same machine at the same moment. These processes are this module's, too:

    python -m benchmarks.bus echo|router|feed|many ENDPOINT …
"""

from __future__ import annotations

import itertools
import sys
import threading
import time
from typing import Any

import numpy as np
import zenoh

from benchmarks.learner_process import BLOCK, KEYS, PATIENCE_S, Learner, ask, learner, partner
from incsvr.numerics import Array
from service.bus.ingest import RING_PLACES, places
from service.bus.session import client_config_at, free_endpoint, listener_config_at, open_session
from service.wire import Keys, measurement
from simulator import leng
from simulator.messages import messages
from simulator.player import play

QUESTIONS = 1500
"""Asked of each, in turn."""


def send(subject: Learner) -> None:
    """Leng's first training run as fast as the learner takes it."""
    for name, (t, value) in leng.recording("T1", seed=1).streams().items():
        for part in np.array_split(np.arange(t.size), 20):
            payload = measurement(tuple(t[part].tolist()), tuple(value[part].tolist()))
            subject.session.put(KEYS.stream(name), payload, congestion_control=BLOCK)


def measure() -> dict[str, Any]:
    """All figures of the bus; takes about two minutes."""
    rest = {"at_50_hz": at_50_hz(), "learners_in_one_process": cost_of_many(), "start_and_end": start_and_end()}
    return latency() | throughput() | rest


def latency() -> dict[str, Any]:
    """The damping query beside a bare echo [µs]: the learner idle, and while it trains without pause."""
    echo_endpoint = free_endpoint()
    with (
        learner() as subject,
        partner("echo", echo_endpoint),
        open_session(client_config_at(echo_endpoint), PATIENCE_S) as echo,
    ):
        _teach(subject)
        idle = _ask_in_turn(subject.session, echo)
        with partner("feed", subject.endpoint):
            before, began = subject.health().iteration, time.perf_counter()
            training = _ask_in_turn(subject.session, echo)
            pace = (subject.health().iteration - before) / (time.perf_counter() - began)
    return {
        "query_ratio_to_echo": idle["p50"]["ratio"],
        "query_us": {"idle": idle, "training": training, "iterations_per_second_while_training": pace},
    }


def _teach(subject: Learner) -> None:
    """Leng's first training run, learned to its end."""
    send(subject)
    while subject.health().iteration < 14:
        time.sleep(0.1)


def _ask_in_turn(session: zenoh.Session, echo: zenoh.Session) -> dict[str, Any]:
    """p50 and p99 of both [µs] and their ratios."""
    taken: dict[str, list[float]] = {"damping": [], "echo": []}
    asked = (("echo", echo, "echo"), ("damping", session, f"{KEYS.damping}?rate=0.1"))
    for number in range(QUESTIONS + 50):
        for name, through, selector in asked:
            took = ask(through, selector)
            if number >= 50:
                taken[name].append(1e6 * took)
    found: dict[str, Any] = {}
    for label, percentile in (("p50", 50), ("p99", 99)):
        both = {name: float(np.percentile(times, percentile)) for name, times in taken.items()}
        found[label] = {name: round(value, 1) for name, value in both.items()}
        found[label]["ratio"] = round(both["damping"] / both["echo"], 3)
    return found


def start_and_end(times: int = 5) -> dict[str, Any]:
    """From the start of the process to its liveliness token, and from SIGTERM to its end [s]: the median."""
    ready, ended = [], []
    for _ in range(times):
        began = time.perf_counter()
        with learner() as subject:
            ready.append(time.perf_counter() - began)
            _teach(subject)
            ended.append(subject.stop())
    return {"ready_s": round(float(np.median(ready)), 2), "ended_s": round(float(np.median(ended)), 2)}


def throughput() -> dict[str, Any]:
    """What arrives of what is sent at a steady pace: single values on both streams, and arrays of a thousand."""
    singles = [_stream_at(pace, 1) for pace in (20_000, 40_000)]
    batched = [_stream_at(pace, 1000) for pace in (200_000, 400_000)]
    whole = [each["samples_per_second_and_stream"] for each in singles + batched if not each["lost"]]
    return {"samples_per_second": max(whole, default=0), "single_messages": singles, "batched": batched}


def _stream_at(pace: int, size: int, seconds: float = 4.0) -> dict[str, Any]:
    """Sends `pace` values a second on each of both streams, `size` in a message, stamped at that pace."""
    total = int(pace * seconds)
    t = (np.arange(total) / pace).round(7)
    value = 0.1 * np.sin(0.3 * t)
    with learner() as subject:
        publishers = [
            subject.session.declare_publisher(key, congestion_control=BLOCK) for key in (KEYS.rate, KEYS.torque)
        ]
        chunks = [
            measurement(tuple(t[at : at + size].tolist()), tuple(value[at : at + size].tolist()), number)
            if size > 1
            else measurement(float(t[at]), float(value[at]), number)
            for number, at in enumerate(range(0, total, size))
        ]
        began, cpu = time.perf_counter(), subject.processor_s()
        for number, payload in enumerate(chunks):
            for publisher in publishers:
                publisher.put(payload)
            ahead = began + number * size / pace - time.perf_counter()
            if ahead > 0.002:
                time.sleep(ahead)
        took = time.perf_counter() - began
        before, counts = -1, [0]
        while min(counts) < total and sum(counts) != before:  # or nothing more comes
            time.sleep(2.0 if before >= 0 else 0.0)
            before, health = sum(counts), subject.health()
            counts = [health.streams[name].received for name in ("yaw_rate", "torque")]
        used, resident = subject.processor_s() - cpu, subject.resident_mb()
    return {
        "samples_per_second_and_stream": round(total / took),
        "values_in_a_message": size,
        "lost": 2 * total - sum(counts),
        "lost_as_health_says": health.counters.get("rejected:lost", 0),
        "percent_of_a_core": round(100 * used / took),
        "resident_mb": round(resident),
    }


def at_50_hz(seconds: float = 12.0) -> dict[str, Any]:
    """Cost with both streams at 50 Hz, one value in a message, after Leng's first training run."""
    with learner() as subject:
        _teach(subject)
        for _ in range(RING_PLACES):  # a ring is resident once each of its places was used, here after three minutes
            for key in (KEYS.rate, KEYS.torque):
                subject.session.put(key, b"", congestion_control=BLOCK)
        stop = threading.Event()
        t: Array = np.arange(1000.0, 1010.0 + seconds, 0.02, dtype=np.float64)
        what = messages(
            {"yaw_rate": (t, np.array(0.2 * np.sin(0.1 * t))), "torque": (t, np.array(40.0 * np.sin(0.1 * t)))}
        )
        feeder = threading.Thread(
            target=play, args=(subject.session, KEYS, what), kwargs={"speed": 1.0, "stop": stop}, daemon=True
        )
        feeder.start()
        time.sleep(2.0)
        cpu, resident = _cost(subject, seconds)
        stop.set()
        feeder.join()
    return {"percent_of_a_core": round(cpu, 2), "resident_mb": round(resident, 1)}


def _cost(subject: Learner, seconds: float) -> tuple[float, float]:
    """Percent of one core over the time, and resident memory [MB]."""
    before, began = subject.processor_s(), time.perf_counter()
    time.sleep(seconds)
    return 100.0 * (subject.processor_s() - before) / (time.perf_counter() - began), subject.resident_mb()


def cost_of_many(numbers: tuple[int, ...] = (1, 10, 50, 100), seconds: float = 10.0) -> list[dict[str, Any]]:
    """Learners (vehicles × axes) in one process, both streams of each at 10 Hz."""
    table = []
    for number in numbers:
        prefixes = [KEYS.prefix, *(f"vehicle{index}/yaw" for index in range(1, number))]
        own = {f"vehicle{index}": {"prefix": prefix} for index, prefix in enumerate(prefixes)}
        quick = {"sample_period": 0.2, "smoothing": 0.12, "gap": 0.2, "lateness": 0.2}
        with (
            learner(signals=quick, learners=own) as subject,
            partner("many", subject.endpoint, *prefixes),
        ):
            time.sleep(3.0)
            before = [subject.health(Keys(prefix)).iteration for prefix in prefixes]
            cpu, resident = _cost(subject, seconds)
            after = [subject.health(Keys(prefix)).iteration for prefix in prefixes]
        table.append(
            {
                "learners": number,
                "percent_of_a_core": round(cpu, 1),
                "resident_mb": round(resident, 1),
                "iterations_per_second": round((sum(after) - sum(before)) / seconds, 2),
            }
        )
    return table


def echo(endpoint: str) -> None:
    """A bare echo: nothing but the bus."""
    with open_session(listener_config_at(endpoint)) as session:
        queryable = session.declare_queryable("echo", zenoh.handlers.RingChannel(256), complete=True)
        print("ready", flush=True)
        while True:
            with queryable.recv() as query:
                query.reply("echo", b"0123456789")


def router(endpoint: str) -> None:
    """Nothing but a router, as a vehicle may have one."""
    with open_session(listener_config_at(endpoint)):
        print("ready", flush=True)
        threading.Event().wait()


def feed(endpoint: str, often: str = "50", messages_each: str = "1") -> None:
    """Sends Leng's run again and again: `often` batches of samples a second, each in so many messages of a stream."""
    streams, pace = leng.recording("T1", seed=1).streams(), float(often)
    span, length = 50 * leng.SIGNALS.sample_period, 425.0
    with open_session(client_config_at(endpoint), PATIENCE_S) as session:
        began = time.perf_counter()
        for number in itertools.count():
            lap, at = divmod(number * span, length)
            for name, (t, value) in streams.items():
                inside = np.flatnonzero((t >= at) & (t < min(at + span, length)))
                for part in np.array_split(inside, int(messages_each)) if inside.size else ():
                    stamps = t[part] + 500.0 + lap * length
                    session.put(KEYS.stream(name), measurement(tuple(stamps.tolist()), tuple(value[part].tolist())))
            if number == 50:
                print("ready", flush=True)
            time.sleep(max(0.0, began + number / pace - time.perf_counter()))


def many(endpoint: str, *prefixes: str) -> None:
    """Both streams of many learners at 10 Hz, until the process is ended; first what has used every place of a ring."""
    with open_session(client_config_at(endpoint), PATIENCE_S) as session:
        keys = [Keys(prefix) for prefix in prefixes]
        for _ in range(places(len(keys))):
            for each in keys:
                session.put(each.rate, b"", congestion_control=BLOCK)
                session.put(each.torque, b"", congestion_control=BLOCK)
        print("ready", flush=True)
        began = time.perf_counter()
        for number in itertools.count():
            t = 0.1 * number
            rate = float(0.2 * np.sin(0.5 * t))
            for each in keys:
                session.put(each.rate, measurement(t, rate))
                session.put(each.torque, measurement(t, 400.0 * rate))
            time.sleep(max(0.0, began + t - time.perf_counter()))


if __name__ == "__main__":
    role, *words = sys.argv[1:]
    {"echo": echo, "feed": feed, "many": many, "router": router}[role](*words)
