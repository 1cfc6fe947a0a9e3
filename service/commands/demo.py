"""`incsvr demo`: simulator, learner and viewer as processes of their own; one recording, one report.

The learner starts empty on a free port. The simulator plays both of Leng's experiments, first without and then with the
hull; the validation runs V1 and V2 are never learned from. In a third act something comes on that nobody is told of
(`service.commands.demo_underway`). Whatever happens, no process is left behind.
"""

from __future__ import annotations

import argparse
import importlib
import json
import math
import queue
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import zenoh

from incsvr.errors import BadInput, Failed
from incsvr.signals import RUN_PAUSE_S
from service.bus.session import answer, client_config_at, free_endpoint, open_session
from service.cli.output import add_json_argument, destination, emit, writing
from service.commands import demo_underway
from service.commands.demo_report import HEAD, line, played, summary
from service.config.sections import Simulation
from service.wire import EffectsLedger, FormType, Health, IterationHistory, IterationReport, Keys, decode
from service.wire.json_text import write_json

DEFAULT_SPEED = 25.0
"""The experiment's 757 s of the vehicle's time then take half a minute, the third act's 800 s as long."""
COMPARE_FLAGS = ("--compare", "14", "25")
"""The last iterations without and with the hull, for the viewer's page Before and after (Fig. 8)."""
DEFAULT_SEED = 1
LOG_WRITER = "simulator.steered"
"""Loaded for a log alone: else the simulator runs as a process of its own."""
KEYS = Keys("leng/yaw")
_START_TIMEOUT_S = 30.0
_STOP_TIMEOUT_S = 10.0
_TABLE_TIMEOUT_S = 120.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--out", metavar="DIR", type=Path, default=Path("out"), help="where the recording goes (out)")
    parser.add_argument(
        "--speed", type=float, default=DEFAULT_SPEED, help=f"times the vehicle's own pace (default {DEFAULT_SPEED:g})"
    )
    parser.add_argument(
        "--seed",
        type=int,
        default=DEFAULT_SEED,
        help=f"draws what comes on in the third act, of which the learner is not told (default {DEFAULT_SEED})",
    )
    parser.add_argument(
        "--log",
        metavar="FILE.csv",
        type=destination,
        help="write there a log of five minutes of the simulated vehicle, to try fit and trace on, and play nothing",
    )
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    if not (math.isfinite(args.speed) and args.speed > 0.0):
        raise BadInput(f"--speed {args.speed}: give a positive number, 1 for the vehicle's own pace")
    if not 0 <= args.seed < 2**32:
        raise BadInput(f"--seed {args.seed}: give a whole number from 0 to {2**32 - 1}")
    if args.log is not None:
        return _write_log(args)
    began = time.monotonic()
    for number in (signal.SIGINT, signal.SIGTERM):  # in the background of a script SIGINT begins as ignored
        signal.signal(number, _interrupt)
    people = sys.stderr if args.json == "-" else sys.stdout
    try:
        result = _demo(args.out, args.speed, args.seed, people)
    except KeyboardInterrupt:
        print("incsvr demo: interrupted; nothing is left running", file=sys.stderr)
        return 1
    result["seconds"] = round(time.monotonic() - began, 1)
    write_json(args.out / "report.json", result, indent=2)
    emit(args, result, summary(result, args.out))
    return 0


def _write_log(args: argparse.Namespace) -> int:
    """A log for those who have none yet."""
    with writing(args.log, "--log"):
        inertia = float(importlib.import_module(LOG_WRITER).write_log(args.log, args.seed))
    text = (
        f"{args.log} is a log of five minutes of the simulated vehicle Leng. Go on with:\n"
        f"  incsvr inspect {args.log}\n"
        f"  incsvr fit {args.log} --inertia {inertia:g}\n"
        f"  incsvr trace {args.log} --inertia {inertia:g}"
    )
    emit(args, {"log": str(args.log), "inertia": inertia, "seed": args.seed}, text)
    return 0


def _interrupt(*_: object) -> None:
    raise KeyboardInterrupt


def _demo(out: Path, speed: float, seed: int, people: Any) -> dict[str, Any]:
    endpoint, recording, truth = free_endpoint(), out / "leng.rrd", out / "truth.json"
    try:
        out.mkdir(parents=True, exist_ok=True)
        for file in (recording, truth):
            file.unlink(missing_ok=True)
    except OSError as error:
        raise BadInput(f"nothing can be written to {out} ({error}); name another folder with --out") from error
    runs = ["simulate", "--set", "simulation.runs=[V1, T1, V2, T2]", "--write", str(out)]
    if subprocess.run(_command(*runs), check=False).returncode:
        raise Failed("the simulator could not write the experiment")
    hull_comes = _last_time(out / "T1.csv")
    third_act = hull_comes + RUN_PAUSE_S + _last_time(out / "T2.csv") - _first_time(out / "T2.csv")
    validation = [f"validation.{name}={out / name}.csv" for name in ("V1", "V2")]
    with ExitStack() as stack:
        # A state of its own, gone afterwards: the demo begins with nothing learned and touches no other's.
        state = stack.enter_context(TemporaryDirectory())
        settings = [f"state={state}", f"bus.listen={endpoint}", *validation, *demo_underway.SETTINGS]
        learner = stack.enter_context(_process(out, "serve", *(word for each in settings for word in ("--set", each))))
        session = stack.enter_context(open_session(client_config_at(endpoint), _START_TIMEOUT_S))
        reports: queue.Queue[IterationReport] = queue.Queue()
        session.declare_subscriber(
            KEYS.iteration, lambda sample: reports.put(decode(IterationReport, sample.payload.to_bytes()))
        )
        ledgers: queue.Queue[EffectsLedger] = queue.Queue()
        session.declare_subscriber(
            KEYS.effects, lambda sample: ledgers.put(decode(EffectsLedger, sample.payload.to_bytes()))
        )
        _wait_until_alive(session, learner)
        viewer = None
        if find_spec("viewer.view") is not None and find_spec("rerun") is not None:
            viewer = stack.enter_context(
                _process(out, "view", "--headless", "--save", str(recording), "--connect", endpoint, *COMPARE_FLAGS)
            )
            _wait_until_ready(viewer, out / "view.log")
        hides = ("--set", f"simulation.underway={seed}", "--truth", str(truth))
        player = stack.enter_context(
            _process(out, "simulate", "--connect", endpoint, "--speed", str(speed), "--patient", *hides)
        )
        table = _table_of_this_run(stack, out)
        print(f"learner at {endpoint}; playing T1 and T2, {speed:g} times as fast", file=people)
        print(HEAD, file=people, flush=True)
        history: list[IterationReport] = []
        steps = demo_underway.Steps(third_act, people)
        for report in _iterations(session, reports, player, learner):
            if report.t > third_act:
                steps.begin()
                while not ledgers.empty():
                    steps.tell(ledgers.get())
                continue
            if report.t > hull_comes and all(each.t <= hull_comes for each in history):
                print(f"— the hull is mounted at {hull_comes:.0f} s —", file=people)
            history.append(report)
            print(line(report), file=people, flush=True)
        ledger = demo_underway.awaited(
            lambda: _asked(session, KEYS.effects, EffectsLedger), ledgers, lambda: learner.poll() is None, steps.tell
        )
        counters = _asked(session, KEYS.health, Health).counters
        if viewer is not None:
            _end(viewer)
        if table is not None and table.wait(_TABLE_TIMEOUT_S):
            raise Failed("the table could not be made; see table1.log")
    result = played(history, hull_comes)
    result["table1"] = None if table is None else json.loads((out / "table1.json").read_text(encoding="utf-8"))
    if not truth.exists():
        raise Failed("the simulator does not tell what came on; see simulate.log")
    told = json.loads(truth.read_text(encoding="utf-8"))
    result["underway"] = demo_underway.outcome(ledger, third_act, seed, told)
    result["rejected"] = {name: count for name, count in counters.items() if name.startswith("rejected:")}
    if recording.exists():
        size, verified = recording.stat().st_size, _verify(recording, people)
        result["recording"] = {"file": str(recording), "bytes": size, "verified": verified}
    elif viewer is not None:
        raise Failed("the viewer recorded nothing; see view.log")
    return result


def _table_of_this_run(stack: ExitStack, out: Path) -> subprocess.Popen[bytes] | None:
    """Table I of the same experiment, made beside the rest; None where that is not installed."""
    if find_spec("benchmarks") is None or find_spec("sklearn") is None:
        return None
    words = ("--seeds", "1", "--first-seed", str(Simulation().seed), "--quick", "--json", str(out / "table1.json"))
    return stack.enter_context(_process(out, "table1", *words))


def _iterations(
    session: zenoh.Session,
    reports: queue.Queue[IterationReport],
    player: subprocess.Popen[bytes],
    learner: subprocess.Popen[bytes],
) -> Iterator[IterationReport]:
    """The reports as they come, until the simulator has played everything and all that was learned has come."""
    revision = 0
    while True:
        try:
            report = reports.get(timeout=0.2)
            if report.revision > revision:
                revision = report.revision
                yield report
        except queue.Empty:
            if learner.poll() is not None:
                raise Failed("the learner ended; see serve.log") from None
            if player.poll() not in (None, 0):
                raise Failed("the simulator failed; see simulate.log") from None
            if player.poll() == 0:
                # All that was played has arrived; every whole batch of it becomes an iteration.
                health = _asked(session, KEYS.health, Health)
                if health.iteration >= health.counters["samples"] // 50:
                    # This answer may have overtaken the last report: each has a thread of its own in Zenoh's binding.
                    yield from _asked(session, f"{KEYS.iteration}?after={revision}", IterationHistory).iterations
                    return


def _asked(session: zenoh.Session, selector: str, form: type[FormType]) -> FormType:
    found = answer(session, selector, form)
    if found is None:
        raise Failed(f"the learner does not answer for {selector}; see serve.log")
    return found


def _wait_until_alive(session: zenoh.Session, learner: subprocess.Popen[bytes]) -> None:
    alive: queue.Queue[bool] = queue.Queue()
    session.liveliness().declare_subscriber(KEYS.alive, lambda _: alive.put(True), history=True)
    until = time.monotonic() + _START_TIMEOUT_S
    while time.monotonic() < until and learner.poll() is None:
        try:
            alive.get(timeout=0.2)
            return
        except queue.Empty:
            continue
    raise Failed("the learner did not start; see serve.log")


def _command(*words: str) -> list[str]:
    return [sys.executable, "-m", "service.cli.command_line", *words]


@contextmanager
def _process(out: Path, *words: str) -> Iterator[subprocess.Popen[bytes]]:
    """A command as a process that ends with the block; what it says goes to a log."""
    with (out / f"{words[0]}.log").open("wb") as log:
        # In a session of its own Ctrl-C reaches us alone, and we end the others in their order.
        process = subprocess.Popen(_command(*words), stdout=log, stderr=log, start_new_session=True)
        try:
            yield process
        finally:
            _end(process)


def _wait_until_ready(viewer: subprocess.Popen[bytes], log: Path) -> None:
    """Returns once the viewer hears the bus, so that the recording begins with the first measurement."""
    until = time.monotonic() + _START_TIMEOUT_S
    while "viewer ready" not in log.read_text(encoding="utf-8", errors="replace"):
        if viewer.poll() is not None or time.monotonic() > until:
            raise Failed(f"the viewer did not start; see {log}")
        time.sleep(0.05)


def _end(process: subprocess.Popen[bytes]) -> None:
    process.terminate()
    try:
        process.wait(_STOP_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _last_time(path: Path) -> float:
    return float(path.read_text(encoding="utf-8").rstrip().rpartition("\n")[2].partition(",")[0])


def _first_time(path: Path) -> float:
    return float(path.read_text(encoding="utf-8").split("\n", 2)[1].partition(",")[0])


def _verify(recording: Path, people: Any) -> bool:
    """Whether Rerun's own check finds the recording whole."""
    tool = Path(sys.executable).with_name("rerun")
    done = subprocess.run([tool, "rrd", "verify", recording], capture_output=True, text=True, check=False)
    if done.returncode:
        print(done.stdout + done.stderr, file=people)
    return done.returncode == 0
