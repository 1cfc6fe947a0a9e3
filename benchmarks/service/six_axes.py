"""All six axes of a vehicle file in one process at the vehicle's own pace: processor time and memory of the learner.

`incsvr serve --vehicle` learns a small ROV that `incsvr simulate --vehicle` plays beside it: six velocities, six
efforts, roll and pitch, each value a message of its own, as the quickest vehicles send them.
"""

from __future__ import annotations

import tempfile
import threading
import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import psutil

from benchmarks.service.bus import PATIENCE_S, process
from benchmarks.study import Record, begin, options, publish
from benchmarks.tables import page, table
from incsvr.numerics import Array
from incsvr.plant.axes import AXES
from incsvr.vehicle import Parameter, Vehicle
from incsvr.vehicle.terms import own_damping, restoring
from service.bus.session import answer, client_config_at, free_endpoint, open_session
from service.config.vehicle_file import write_vehicle
from service.recordings.recording import Recording
from service.recordings.recording_csv import write
from service.wire import Health, Keys
from simulator.player import wait_for_learner
from simulator.vehicles import NAMES, rov
from simulator.vehicles import Vehicle as Body

SETTLE_S = 10.0
"""The measurement begins so long after the first message [s]: what is allocated once has been then."""
FASTEST = (1.0, 0.85, 0.85, 2.1, 3.2, 2.7)
"""How fast the small ROV goes under its largest efforts [m/s], [rad/s]."""


def vehicle_of(body: Body, fastest: Sequence[float] = FASTEST) -> Vehicle:
    """A vehicle file's model of a simulated body that goes so fast [m/s], [rad/s], its numbers as they are."""

    def known(value: float) -> Parameter:
        return Parameter(value, value, value)

    places = {name: NAMES.index(name) for name in body.moves}
    mass = {(a, b): known(float(body.mass[i, j])) for a, i in places.items() for b, j in places.items()
            if i <= j and body.mass[i, j] != 0.0}  # fmt: skip
    own = {"linear": body.linear, "quadratic": body.quadratic, "righting": np.full(6, body.righting)}
    terms = (*own_damping(body.moves), *restoring(body.moves, ("roll", "pitch") if body.righting else ()))
    found = {term: known(float(own[term.kind][places[term.axis]])) for term in terms if term.kind in own}
    return Vehicle("rov", body.moves, tuple(body.effort), mass, found, {}, np.array(fastest))


def commands(body: Body, seconds: float, hz: float, rng: np.random.Generator) -> Recording:
    """Efforts that hold for random times; the yaw rate of a log that was not sailed is zero."""
    time: Array = np.arange(int(seconds * hz), dtype=np.float64) / hz
    columns = {"yaw_rate": np.zeros(time.size)}
    for name, largest in body.effort.items():
        hold = rng.uniform(*body.hold_s, int(seconds / body.hold_s[0]) + 1)
        level = rng.uniform(-1.0, 1.0, hold.size) * largest
        columns[AXES[name].effort] = level[np.searchsorted(np.cumsum(hold), time, side="right")]
    return Recording("commands", time, columns)


def measure(seconds: float, hz: float, seed: int) -> Record:
    """Processor time and memory of the learner while the vehicle is played for so long."""
    rng = np.random.default_rng(seed)
    body, endpoint = rov(rng), free_endpoint()
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        file, log = Path(folder) / "rov.yaml", Path(folder) / "commands.csv"
        write_vehicle(file, vehicle_of(body))
        write(log, commands(body, seconds + 2.0 * SETTLE_S, hz, rng))
        shared, words = ("--vehicle", str(file)), ("--set", f"state={folder}/state", "--listen", endpoint)
        served = stack.enter_context(process("service.cli.command_line", "serve", *shared, *words))
        session = stack.enter_context(open_session(client_config_at(endpoint), PATIENCE_S))
        keys = [Keys(f"leng/{name}") for name in NAMES]
        wait_for_learner(session, keys[0], PATIENCE_S, threading.Event())
        played = ("simulate", *shared, "--commands", str(log), "--connect", endpoint)
        stack.enter_context(process("service.cli.command_line", *played))
        learner = psutil.Process(served.pid)
        while not _received(answer(session, keys[-1].health, Health)):
            time.sleep(0.5)
        time.sleep(SETTLE_S)
        before, began = sum(learner.cpu_times()[:2]), time.perf_counter()
        time.sleep(seconds)
        used, took = sum(learner.cpu_times()[:2]) - before, time.perf_counter() - began
        healths = {each.prefix: answer(session, each.health, Health) for each in keys}
        peak = Path(f"/proc/{served.pid}/status").read_text(encoding="utf-8").partition("VmHWM:")[2].split()[0]
    return {
        "seconds": seconds,
        "hz": hz,
        "percent_of_a_core": 100.0 * used / took,
        "peak_mb": int(peak) * 1024 / 1e6,
        "iterations": {prefix: health.iteration for prefix, health in healths.items() if health is not None},
        "lost": sum(stream.lost for health in healths.values() if health for stream in health.streams.values()),
        "rejected": sum(health.counters["rejected"] for health in healths.values() if health is not None),
    }


def _received(health: Health | None) -> int:
    return 0 if health is None or "yaw_rate" not in health.streams else health.streams["yaw_rate"].received


def report(result: Record) -> str:
    """Markdown."""
    rows = [
        ("processor of the learner", f"{result['percent_of_a_core']:.1f} % of a core", "15 %"),
        ("its memory at most", f"{result['peak_mb']:.0f} MB", "130 MB"),
        ("iterations of the six learners", ", ".join(str(n) for n in result["iterations"].values()), ""),
        ("messages lost / values rejected", f"{result['lost']} / {result['rejected']}", "0 / 0"),
    ]
    return page(
        "# Six axes in one process",
        f"Made by `{result['command']}` on {result['date']}, {result['processor']}, {result['cores']} cores, load "
        f"{result['load_before']:.1f} before: {result['seconds']:g} s, each of fourteen streams at {result['hz']:g} "
        "values a second.",
        table(["", "measured", "aim"], rows),
    )


def main(words: Sequence[str] | None = None) -> None:
    parser = options(
        "benchmarks.service.six_axes",
        __doc__,
        seconds=(60.0, "so long the learner is looked at [s]"),
        hz=(100.0, "values of each stream in a second"),
        seed=(53_001, "draws the vehicle and its commands"),
    )
    args, measured = begin(parser, words, "eclipse-zenoh")
    result = measured | measure(args.seconds, args.hz, args.seed)
    publish(args.out, "six_axes", result, report(result))


if __name__ == "__main__":
    main()
