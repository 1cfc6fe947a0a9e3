"""Ten vehicles, one router, a shore station: what goes over the wire, what it costs, and whether history comes through.

Each vehicle is a learner and a player in processes of their own, clients of one router; the shore station is this
process, one more client. Leng's run is played faster than life, so that every learner does its iterations; what goes
over the wire is stated per message and, at the vehicle's own pace, per vehicle and hour.
"""

from __future__ import annotations

import tempfile
import threading
import time
from collections import Counter
from collections.abc import Sequence
from contextlib import ExitStack

import numpy as np
import psutil
import zenoh

from benchmarks.service.bus import PATIENCE_S, partner, process
from benchmarks.study import Record, begin, options, publish
from benchmarks.tables import page, table
from service.bus.session import client_config_at, free_endpoint, open_session
from service.wire import IterationHistory, Keys, decode
from simulator.player import wait_for_learner

ITERATIONS = 14
"""Whole batches of Leng's first training run; one comes after 30 s of data."""
ITERATIONS_PER_DAY = 2880
"""Iterations of a day at that pace."""
QUESTION_PERIOD_S = 0.02
"""The shore station asks one vehicle after the other for its damping, once in so long [s]."""
MAX_RUN_S = 300.0
"""So long the vehicles may take for their run [s]."""
STORED = ("model", "iteration", "coefficients")
"""What an iteration publishes; health comes each second, the streams as often as the sensors do."""


def measure(vehicles: int, speed: float) -> Record:
    """Everything of one fleet."""
    endpoint, prefixes = free_endpoint(), [f"vehicle{number}/yaw" for number in range(vehicles)]
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        relay = stack.enter_context(partner("router", endpoint))
        connect = ("--set", f"bus.connect={endpoint}")
        learners = [
            stack.enter_context(
                process(
                    "service.cli.command_line", "serve", *connect, "--set", f"prefix={each}", "--set", f"state={folder}"
                )
            )
            for each in prefixes
        ]
        shore = stack.enter_context(open_session(client_config_at(endpoint), PATIENCE_S))
        for each in prefixes:
            wait_for_learner(shore, Keys(each), PATIENCE_S, threading.Event())
        wire = Wire(shore, prefixes)
        began = time.perf_counter()
        before = [_processor([relay.pid]), _processor([each.pid for each in learners])]
        for each in prefixes:
            play = ("simulate", *connect, "--set", f"prefix={each}", "--set", "simulation.runs=[T1]")
            stack.enter_context(process("service.cli.command_line", *play, "--speed", str(speed)))
        asked = _ask(shore, prefixes, wire.done)
        took = time.perf_counter() - began
        used = [_processor([relay.pid]) - before[0], _processor([each.pid for each in learners]) - before[1]]
        return {
            "vehicles": vehicles,
            "speed": speed,
            "played_s": took,
            "router": {"percent_of_a_core": 100.0 * used[0] / took, "resident_mb": _resident(relay.pid)},
            "learner": {
                "percent_of_a_core": 100.0 * used[1] / took / vehicles,
                "resident_mb": float(np.mean([_resident(each.pid) for each in learners])),
            },
            "bytes_of_a_message": wire.mean_bytes(),
            "iterations": wire.iterations(),
            "damping_ms": asked,
            "history": _history(shore, prefixes),
        }


class Wire:
    """What the shore station hears, counted."""

    def __init__(self, session: zenoh.Session, prefixes: Sequence[str]) -> None:
        self.done = threading.Event()
        self._prefixes, self._lock = prefixes, threading.Lock()
        self._count, self._size, self._done_by = Counter[str](), Counter[str](), Counter[str]()
        session.declare_subscriber("*/yaw/*", self._heard)

    def mean_bytes(self) -> dict[str, float]:
        """Of a message of each kind."""
        return {kind: self._size[kind] / count for kind, count in sorted(self._count.items())}

    def iterations(self) -> list[int]:
        """Those of each vehicle that were heard."""
        return [self._done_by[each] for each in self._prefixes]

    def _heard(self, sample: zenoh.Sample) -> None:
        prefix, _, kind = str(sample.key_expr).rpartition("/")
        with self._lock:
            self._count[kind] += 1
            self._size[kind] += len(sample.payload)
            if kind == "iteration":
                self._done_by[prefix] += 1
                if min(self.iterations()) >= ITERATIONS:
                    self.done.set()


def _ask(shore: zenoh.Session, prefixes: Sequence[str], done: threading.Event) -> dict[str, float]:
    """How long an answer for damping takes through the router [ms], asked in turn until all vehicles are done."""
    took, until, number = [], time.monotonic() + MAX_RUN_S, 0
    while not done.wait(QUESTION_PERIOD_S):
        if time.monotonic() > until:
            raise RuntimeError("the vehicles did not end their run; play with a smaller --speed")
        began = time.perf_counter()
        replies = list(shore.get(f"{prefixes[number % len(prefixes)]}/damping?rate=0.1", timeout=PATIENCE_S))
        if replies and replies[0].ok is not None:
            took.append(1e3 * (time.perf_counter() - began))
        number += 1
    return {"asked": float(len(took)), "p50": float(np.median(took)), "p99": float(np.quantile(took, 0.99))}


def _history(shore: zenoh.Session, prefixes: Sequence[str]) -> dict[str, float]:
    """All iterations of all vehicles, asked for through the router one vehicle after the other."""
    began, iterations, size = time.perf_counter(), 0, 0
    for each in prefixes:
        for reply in shore.get(f"{each}/iteration?after=0;limit=100", timeout=PATIENCE_S):
            if reply.ok is not None:
                payload = reply.ok.payload.to_bytes()
                size += len(payload)
                iterations += len(decode(IterationHistory, payload).iterations)
    return {"iterations": float(iterations), "bytes": float(size), "seconds": time.perf_counter() - began}


def _processor(pids: Sequence[int]) -> float:
    """Processor time so far [s]."""
    return float(sum(sum(psutil.Process(pid).cpu_times()[:2]) for pid in pids))


def _resident(pid: int) -> float:
    return float(psutil.Process(pid).memory_info().rss / 1e6)


def report(result: Record) -> str:
    """Markdown."""
    size, hour = result["bytes_of_a_message"], ITERATIONS_PER_DAY / 24
    asked, history, router, each = (result[key] for key in ("damping_ms", "history", "router", "learner"))
    snapshots = sum(size.get(kind, 0.0) for kind in STORED)
    streams = (size["rate"] * 50 + size["torque"] * 25) * 3600
    rows = [
        (f"{result['vehicles']} learners, {ITERATIONS} iterations each: heard ashore", f"{sum(result['iterations'])}"),
        ("an iteration's model / report / coefficients", " / ".join(f"{size[k] / 1e3:.1f} kB" for k in STORED)),
        ("health, once a second", f"{size['health'] / 1e3:.1f} kB"),
        ("a vehicle's hour: model, report, coefficients", f"{snapshots * hour / 1e6:.1f} MB"),
        ("a vehicle's hour: health", f"{size['health'] * 3600 / 1e6:.1f} MB"),
        ("a vehicle's hour: both streams at 50 and 25 Hz, where somebody ashore subscribes to them",
         f"{streams / 1e6:.1f} MB"),
        ("damping asked through the router, p50 / p99", f"{asked['p50']:.1f} / {asked['p99']:.1f} ms"),
        ("history fetched through the router",
         f"{history['iterations']:.0f} iterations, {history['bytes'] / 1e6:.2f} MB in {history['seconds']:.2f} s"),
        (f"the router, {result['speed']:g} times as fast as life",
         f"{router['percent_of_a_core']:.0f} % of a core, {router['resident_mb']:.0f} MB"),
        ("a learner, likewise", f"{each['percent_of_a_core']:.1f} % of a core, {each['resident_mb']:.0f} MB"),
    ]  # fmt: skip
    return page(
        "# A fleet on one router",
        f"Made by `{result['command']}` on {result['date']}, {result['processor']}, {result['cores']} cores, load "
        f"{result['load_before']:.1f} before.",
        table(["", "measured"], rows),
    )


def main(words: Sequence[str] | None = None) -> None:
    parser = options(
        "benchmarks.service.fleet",
        __doc__,
        vehicles=(10, "learner processes"),
        speed=(8.0, "times the vehicles' own pace"),
    )
    args, measured = begin(parser, words, "eclipse-zenoh")
    result = measured | measure(args.vehicles, args.speed)
    publish(args.out, "fleet", result, report(result))


if __name__ == "__main__":
    main()
