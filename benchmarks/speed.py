"""What a fleet on one router and six axes in one process cost.

Ten learners and ten players, clients of one router, and this process ashore: what goes over the wire, and whether
history comes through. Then `incsvr serve --vehicle` learns all axes of a small ROV that `incsvr simulate --vehicle`
plays beside it: six velocities, six efforts, roll and pitch, each value a message of its own. The learner's step and
the bus are measured by `incsvr bench`.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import psutil
import zenoh

from benchmarks.learner_process import PATIENCE_S, partner, process
from benchmarks.study import Record, run, table
from incsvr.plant.axes import AXES
from service.bus.session import answer, client_config_at, free_endpoint, open_session
from service.wire import Health, IterationHistory, Keys
from simulator.player import wait_for_learner

ITERATIONS = 14
"""Whole batches of Leng's first training run; one comes after 30 s of data."""
MAX_RUN_S = 300.0
"""So long the vehicles may take for their run [s]."""
SETTLE_S = 10.0
"""Six axes are measured so long after the first message [s]: what is allocated once has been then."""
CLI = "service.cli.command_line"
STORED = ("model", "iteration", "coefficients")
"""What an iteration publishes; health comes each second, the streams as often as the sensors do."""


def cases(asked: argparse.Namespace) -> list[tuple[str, tuple[float, ...]]]:
    both = [("fleet", (asked.vehicles, asked.pace)), ("six axes", (asked.seconds,))]
    return [case for case in both if asked.only in case[0]]


def examine(case: tuple[str, tuple[float, ...]]) -> Record:
    name, asked = case
    return {"case": name, "asked": asked} | (fleet(int(asked[0]), asked[1]) if name == "fleet" else six_axes(*asked))


def fleet(vehicles: int, pace: float) -> Record:
    """Everything of one fleet whose vehicles play Leng's run so many times faster than life."""
    endpoint, prefixes = free_endpoint(), [f"vehicle{number}/yaw" for number in range(vehicles)]
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        relay = stack.enter_context(partner("router", endpoint))
        shared = (CLI, "serve", "--set", f"bus.connect={endpoint}", "--set", f"state={folder}")
        learners = [stack.enter_context(process(*shared, "--set", f"prefix={each}")) for each in prefixes]
        shore = stack.enter_context(open_session(client_config_at(endpoint), PATIENCE_S))
        for each in prefixes:
            wait_for_learner(shore, Keys(each), PATIENCE_S, threading.Event())
        sizes, count, done, lock = Counter[str](), Counter[str](), threading.Event(), threading.Lock()

        def receive(sample: zenoh.Sample) -> None:
            prefix, _, kind = str(sample.key_expr).rpartition("/")
            with lock:
                sizes[kind] += len(sample.payload)
                count.update((kind, prefix) if kind == "iteration" else (kind,))
                if min(count[each] for each in prefixes) >= ITERATIONS:
                    done.set()

        shore.declare_subscriber("*/yaw/*", receive)
        pids = [[relay.pid], [each.pid for each in learners]]
        began, before = time.perf_counter(), [_processor(each) for each in pids]
        play = ("simulate", "--set", f"bus.connect={endpoint}", "--runs", "T1", "--speed", str(pace))
        for each in prefixes:
            stack.enter_context(process(CLI, *play, "--set", f"prefix={each}"))
        waits, number = [], 0
        while not done.wait(0.02):
            if time.perf_counter() - began > MAX_RUN_S:
                raise RuntimeError("the vehicles did not end their run; play with a smaller --pace")
            at = time.perf_counter()
            replies = list(shore.get(f"{prefixes[number % vehicles]}/damping?rate=0.1", timeout=PATIENCE_S))
            waits += [1e3 * (time.perf_counter() - at)] if replies and replies[0].ok is not None else []
            number += 1
        took, used = time.perf_counter() - began, [_processor(each) for each in pids]
        at = time.perf_counter()
        stored = [answer(shore, f"{each}/iteration?after=0;limit=100", IterationHistory) for each in prefixes]
        fetched = time.perf_counter() - at
        kilobytes = {kind: sizes[kind] / count[kind] / 1e3 for kind in sorted(sizes)}
        hour = sum(kilobytes[kind] for kind in STORED) * 120 / 1e3
        streams = (kilobytes["rate"] * 50 + kilobytes["torque"] * 25) * 3.6
        memory = [max(psutil.Process(pid).memory_info().rss / 1e6 for pid in each) for each in pids]
    p50, p99 = np.percentile(waits, [50, 99]).tolist()
    load = [100.0 * (used[k] - before[k]) / took / len(pids[k]) for k in (0, 1)]
    return {"rows": [
        (f"{vehicles} learners, {ITERATIONS} iterations each: received ashore", f"{sum(count[e] for e in prefixes)}"),
        ("an iteration's model / report / coefficients", " / ".join(f"{kilobytes[kind]:.1f} kB" for kind in STORED)),
        ("health, once a second", f"{kilobytes['health']:.1f} kB"),
        ("a vehicle's hour: model, report, coefficients / health", f"{hour:.1f} / {kilobytes['health'] * 3.6:.1f} MB"),
        ("a vehicle's hour: both streams at 50 and 25 Hz, if somebody ashore subscribes", f"{streams:.1f} MB"),
        ("a damping question through the router, p50 / p99", f"{p50:.1f} / {p99:.1f} ms"),
        ("history fetched through the router",
         f"{sum(len(each.iterations) for each in stored if each)} iterations in {fetched:.2f} s"),
        (f"the router, {pace:g} times as fast as life", f"{load[0]:.0f} % of a core, {memory[0]:.0f} MB"),
        ("a learner, likewise", f"{load[1]:.1f} % of a core, at most {memory[1]:.0f} MB"),
    ]}  # fmt: skip


def six_axes(seconds: float) -> Record:
    """Processor time and memory of the learner of six axes over so many seconds."""
    endpoint = free_endpoint()
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        file, log = f"{folder}/rov.yaml", f"{folder}/dive.csv"
        for words in (("demo", "--log", log, "--log-of", "rov"), ("identify", log, "--write", file)):
            subprocess.run([sys.executable, "-m", CLI, *words], check=True, capture_output=True)
        shared, words = ("--vehicle", file), ("--set", f"state={folder}/state", "--listen", endpoint)
        served = stack.enter_context(process(CLI, "serve", *shared, *words))
        session = stack.enter_context(open_session(client_config_at(endpoint), PATIENCE_S))
        keys = [Keys(f"leng/{name}") for name in AXES]
        wait_for_learner(session, keys[0], PATIENCE_S, threading.Event())
        played = ("simulate", *shared, "--commands", log, "--connect", endpoint)
        stack.enter_context(process(CLI, *played))
        while not (health := answer(session, keys[-1].health, Health)) or not health.counters["samples"]:
            time.sleep(0.5)
        time.sleep(SETTLE_S)
        before, began = _processor([served.pid]), time.perf_counter()
        time.sleep(seconds)
        percent = 100.0 * (_processor([served.pid]) - before) / (time.perf_counter() - began)
        healths = [health for each in keys if (health := answer(session, each.health, Health))]
        peak = Path(f"/proc/{served.pid}/status").read_text(encoding="utf-8").partition("VmHWM:")[2].split()[0]
    lost = sum(stream.lost for health in healths for stream in health.streams.values())
    return {"rows": [
        (f"six axes, fourteen streams at 50 Hz for {seconds:g} s: the learner", f"{percent:.1f} % of a core"),
        ("its memory at most", f"{int(peak) * 1024 / 1e6:.0f} MB"),
        ("iterations of the six learners", ", ".join(str(health.iteration) for health in healths)),
        ("messages lost / values rejected", f"{lost} / {sum(health.counters['rejected'] for health in healths)}"),
    ]}  # fmt: skip


def _processor(pids: Sequence[int]) -> float:
    """Processor time so far [s]."""
    return float(sum(sum(psutil.Process(pid).cpu_times()[:2]) for pid in pids))


def report(results: Sequence[Record]) -> Iterator[str]:
    for result in results:
        yield f"## {result['case'].capitalize()}"
        yield table(["", "measured"], result["rows"])


def main(words: Sequence[str] | None = None) -> None:
    run("speed", __doc__, cases, examine, report, words, ("eclipse-zenoh",), vehicles=(10, "learners of the fleet"),
        pace=(8.0, "times the fleet's own pace"), seconds=(60.0, "so long six axes are measured [s]"),
        only=("", "part of the case's name"))  # fmt: skip


if __name__ == "__main__":
    main()
