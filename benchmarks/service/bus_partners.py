"""Processes beside a learner: an echo to compare with, a router, and vehicles that send.

python -m benchmarks.service.bus_partners echo|router|feed|many ENDPOINT …
"""

from __future__ import annotations

import itertools
import sys
import threading
import time

import numpy as np
import zenoh

from benchmarks.service.bus import BLOCK, KEYS, PATIENCE_S
from service.bus.ingest import places
from service.bus.session import client_config_at, listener_config_at, open_session
from service.wire import Keys, measurement
from simulator import leng


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
