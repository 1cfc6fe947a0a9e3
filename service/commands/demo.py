"""`incsvr demo`: simulator, learner and viewer as processes of their own; one recording, one report.

The simulator plays both of Leng's experiments to an empty learner, first without and then with the hull; in a third act
it switches on an effect that the learner does not know. The validation runs V1 and V2 are never learned from.
"""

from __future__ import annotations

import argparse
import importlib
import json
import math
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TextIO

from incsvr.errors import BadInput, Failed
from incsvr.plant.axes import AXES
from service.bus.client import Client, bus_client
from service.bus.session import free_endpoint
from service.cli.output import add_json_argument, destination, emit, iteration_line, writing
from service.commands.demo_verdict import outcome, verdict
from service.config.configuration import Config
from service.config.sections import Bus
from service.recordings.reading import read
from service.recordings.recording import sequence
from service.wire import EffectsLedger, Health, IterationHistory, IterationReport, decode
from service.wire.json_text import write_json

TIMEOUT_S = 40.0
"""A process is ready, and the learner's last trace ends, within this time [s], wall time; most take ten."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("--out", metavar="DIR", type=Path, default=Path("out"), help="folder of the recording (default out)")
    add("--speed", type=float, default=60.0, help="speed over the vehicle's own (default 60)")
    add("--seed", type=int, default=1, help="selects the effect of the third act (default 1)")
    log = "only write a log of five minutes of a simulated vehicle, to try fit and trace on"
    add("--log", metavar="FILE.csv", type=destination, help=log)
    of = "vehicle of --log: leng turns about yaw, the others move along several axes (default leng)"
    add("--log-of", choices=("leng", "rov", "torpedo", "boat"), help=of)
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    if not (math.isfinite(args.speed) and args.speed > 0.0):
        raise BadInput(f"--speed {args.speed}: give a positive number, 1 for the vehicle's own pace")
    if not 0 <= args.seed < 2**32:
        raise BadInput(f"--seed {args.seed}: give a whole number from 0 to {2**32 - 1}")
    if args.log is not None:
        return _write_log(args, args.log_of or "leng")
    if args.log_of is not None:
        raise BadInput(f"--log-of {args.log_of} is the vehicle of a log: name its file with --log FILE.csv")
    began = time.monotonic()
    for number in (signal.SIGINT, signal.SIGTERM):  # in the background of a script SIGINT begins as ignored
        signal.signal(number, signal.default_int_handler)
    try:
        result = _demo(args.out, args.speed, args.seed, sys.stderr if args.json == "-" else sys.stdout)
    except KeyboardInterrupt:
        print("incsvr demo: interrupted; nothing is left running", file=sys.stderr)
        return 1
    result["seconds"] = round(time.monotonic() - began, 1)
    write_json(args.out / "report.json", result, indent=2)
    emit(args, result, _summary(result, args.out))
    return 0


def _write_log(args: argparse.Namespace, vehicle: str) -> int:
    """A log for those who have none yet. The simulator is loaded here alone: else it is a process of its own."""
    text = f"{args.log} is a log of five minutes of "
    with writing(args.log, "--log"):
        if vehicle == "leng":
            inertia = {"yaw": float(importlib.import_module("simulator.leng_at_sea").write_log(args.log, args.seed))}
            known = f"{args.log} --inertia {inertia['yaw']:g}"
            text += f"the simulated vehicle Leng.\nNext:\n  incsvr inspect {args.log}\n"
            text += f"  incsvr fit {known}\n  incsvr trace {known}"
        else:
            body = importlib.import_module("simulator.dive_log").write_dive(args.log, vehicle, args.seed)
            inertia = {axis: float(body.mass[k, k]) for k, axis in enumerate(AXES) if axis in body.moves}
            named = ", ".join(f"{axis} {value:.3g}" for axis, value in inertia.items())
            text += f"a simulated {vehicle}.\nIts inertia with the water's [kg, kg m²]: {named}.\n"
            text += f"Go on with incsvr identify {args.log} --write vehicle.yaml"
    emit(args, {"log": str(args.log), "vehicle": vehicle, "inertia": inertia, "seed": args.seed}, text)
    return 0


def _demo(out: Path, speed: float, seed: int, people: TextIO) -> dict[str, Any]:
    """Plays all acts, prints each iteration as it comes, and returns the report."""
    recording, truth = out / "leng.rrd", out / "truth.json"
    try:
        out.mkdir(parents=True, exist_ok=True)
        recording.unlink(missing_ok=True)
    except OSError as error:
        raise BadInput(f"nothing can be written to {out} ({error}); name another folder with --out") from error
    with ExitStack() as stack:
        writer = _start(stack, out, "simulate", "--runs", "V1", "T1", "V2", "T2", "--write", str(out))
        _wait(lambda: writer.poll() == 0, out, simulate=writer)
        runs = [read(out / f"{name}.csv") for name in ("T1", "T2")]
        hull, third, endpoint = float(runs[0].time[-1]), float(sequence(runs).time[-1]), free_endpoint()
        values = {"bus.listen": endpoint, "state": stack.enter_context(TemporaryDirectory()), "learner.policy": "paper"}
        values |= {f"validation.{name}": str(out / f"{name}.csv") for name in ("V1", "V2")}
        values |= {"tracing.live": "advise", "tracing.window": "400", "tracing.proof": "60"}  # of 800 s
        settings = (word for name, value in values.items() for word in ("--set", f"{name}={value}"))
        learner = _start(stack, out, "serve", *settings)
        if viewed := find_spec("viewer.view") is not None and find_spec("rerun") is not None:
            compared = ("--compare", "14", "25")  # the last iterations without and with the hull, as in Fig. 8
            viewer = _start(stack, out, "view", "--headless", f"--save={recording}", "--connect", endpoint, *compared)
        _wait(lambda: "ready: " in (out / "serve.log").read_text(encoding="utf-8"), out, serve=learner)
        said = f"Leng is played {speed:g} times as fast. The cover is mounted at {hull:.0f} s; after {third:.0f} s\n"
        said += "the simulator switches on an effect that its seed selects, at a hidden instant.\n"
        say = partial(print, file=people, flush=True)
        say(said)
        bus = stack.enter_context(bus_client(Config(bus=Bus(connect=endpoint)), TIMEOUT_S))
        listen = bus.session.declare_subscriber
        listen(bus.keys.iteration, lambda put: say(iteration_line(decode(IterationReport, put.payload.to_bytes()))))
        if viewed:
            _wait(lambda: "viewer ready" in (out / "view.log").read_text(encoding="utf-8"), out, view=viewer)
        act = ("--underway", str(seed), "--truth", str(truth))
        player = _start(stack, out, "simulate", "--connect", endpoint, "--speed", str(speed), "--patient", *act)
        _wait(lambda: player.poll() == 0, out, math.inf, simulate=player, serve=learner)
        history, ledger, health = _answers(replace(bus, until=time.monotonic() + TIMEOUT_S))
    result = _learned([each for each in history if each.t <= third], hull)
    result["underway"] = outcome(ledger, third, seed, json.loads(truth.read_text(encoding="utf-8")))
    result["rejected"] = {name: count for name, count in health.counters.items() if name.startswith("rejected:")}
    if viewed and not recording.exists():
        raise Failed(f"the viewer recorded nothing; see {out / 'view.log'}")
    return result | {"recording": _checked(recording) if viewed else None}


def _start(stack: ExitStack, out: Path, *words: str) -> subprocess.Popen[bytes]:
    """A command as a process that ends with the stack; it prints to a log of its name."""
    command = [sys.executable, "-m", "service.cli.command_line", *words]
    with (out / f"{words[0]}.log").open("wb") as log:
        # In a session of its own Ctrl-C reaches us alone, and we end the others in their order.
        process = subprocess.Popen(command, stdout=log, stderr=log, start_new_session=True)
    stack.callback(_end, process)
    return process


def _end(process: subprocess.Popen[bytes]) -> None:
    process.terminate()
    try:
        process.wait(TIMEOUT_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _wait(done: Callable[[], bool], out: Path, timeout_s: float = TIMEOUT_S, **alive: subprocess.Popen[bytes]) -> None:
    """Returns once it is done; Failed where one of the processes ended before, or the time is over."""
    until = time.monotonic() + timeout_s
    while not done():
        ended = [name for name, process in alive.items() if process.poll() is not None]
        if (ended and not done()) or time.monotonic() > until:
            raise Failed(f"the demo cannot go on; see {out / (ended or [*alive])[0]}.log")
        time.sleep(0.05)


def _answers(client: Client) -> tuple[Sequence[IterationReport], EffectsLedger, Health]:
    """The learner's iterations, its ledger once it has nothing more to trace, and its health."""
    idle = 0
    while idle < 2 and time.monotonic() < client.until:
        time.sleep(0.5)  # the next trace begins within a fifth of it
        ledger = client.ask(client.keys.effects, EffectsLedger)
        idle = idle + 1 if ledger.work is None else 0
    history = client.ask(f"{client.keys.iteration}?after=0", IterationHistory).iterations
    return history, ledger, client.ask(client.keys.health, Health)


def _learned(history: Sequence[IterationReport], hull: float) -> dict[str, Any]:
    """The iterations without and with the hull, which comes at a time [s], and the errors of what was served last."""
    bare = sum(report.t <= hull for report in history)
    if not 0 < bare < len(history):
        raise Failed("an experiment ended before its first iteration; see serve.log")
    errors = {name: [next(e for e in each.validation if e.name == name) for each in history] for name in ("V1", "V2")}
    served = [("V1", errors["V1"][bare - 1], history[bare - 1]), ("V2", errors["V2"][-1], history[-1])]
    return {
        "iterations": len(history),
        "iterations_without_hull": bare,
        "served": [
            {"validation": name, "mae": error.mae, "rmse": error.rmse, "support_vectors": last.counts["support"]}
            for name, error, last in served
        ],
        "mae_per_iteration": {name: [error.mae for error in each] for name, each in errors.items()},
        "vehicle_seconds": history[-1].t,
    }


def _checked(recording: Path) -> dict[str, Any]:
    """The recording, and whether Rerun's own check finds it whole."""
    check = [str(Path(sys.executable).with_name("rerun")), "rrd", "verify", str(recording)]
    whole = subprocess.run(check, capture_output=True, check=False).returncode == 0
    return {"file": str(recording), "bytes": recording.stat().st_size, "verified": whole}


def _summary(result: Mapping[str, Any], out: Path) -> str:
    lines = ["", *verdict(result["underway"]), ""]
    errors = [f"{each['mae']:.2f} N m on {each['validation']}" for each in result["served"]]
    lines.append(f"mean absolute error without and with the cover: {', '.join(errors)}")
    refused = ", ".join(f"{count} {name.removeprefix('rejected:')}" for name, count in result["rejected"].items())
    lines.append(f"rejected: {refused or 'nothing'}")
    if file := result["recording"]:
        state = "verified" if file["verified"] else "NOT whole"
        lines.append(f"recording: {file['bytes'] / 1e6:.1f} MB, {state}; `incsvr view {file['file']}` opens it")
    else:
        lines.append("no recording: the viewer is not installed (pip install '.[viewer]')")
    return "\n".join([*lines, f"{result['seconds']} s in all; the report is {out / 'report.json'}"])
