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
import signal
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from incsvr.errors import BadInput, Failed
from incsvr.plant.axes import AXES
from incsvr.signals import RUN_PAUSE_S
from service.bus.session import client_config_at, free_endpoint, open_session
from service.cli.output import add_json_argument, destination, emit, writing
from service.commands import demo_underway
from service.commands.demo_bus import KEYS, arriving, iterations, learner_answer, wait_until_alive
from service.commands.demo_processes import START_TIMEOUT_S, command, end, process_of, verify, wait_until_ready
from service.commands.demo_report import HEAD, line, played, summary
from service.config.sections import Simulation
from service.wire import EffectsLedger, Health, IterationReport
from service.wire.json_text import write_json

DEFAULT_SPEED = 25.0
"""The experiment's 757 s of the vehicle's time then take half a minute, the third act's 800 s as long."""
COMPARE_FLAGS = ("--compare", "14", "25")
"""The last iterations without and with the hull, for the viewer's page Before and after (Fig. 8)."""
DEFAULT_SEED = 1
LOG_WRITER, DIVE_WRITER = "simulator.steered", "simulator.dive_log"
"""Loaded for a log alone: else the simulator runs as a process of its own."""
WHOLE_VEHICLES = ("rov", "torpedo", "boat")
"""Simulated vehicles that move along several axes."""
TABLE_TIMEOUT_S = 120.0
"""Table I, which is made beside the rest, is there so long after it [s]."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--out", metavar="DIR", type=Path, default=Path("out"), help="folder of the recording (default out)"
    )
    parser.add_argument(
        "--speed", type=float, default=DEFAULT_SPEED, help=f"speed over the vehicle's own (default {DEFAULT_SPEED:g})"
    )
    parser.add_argument(
        "--seed",
        type=int,
        default=DEFAULT_SEED,
        help=f"selects the effect of the third act, which the learner does not know (default {DEFAULT_SEED})",
    )
    parser.add_argument(
        "--log",
        metavar="FILE.csv",
        type=destination,
        help="write a log of five minutes of the simulated vehicle, to try fit and trace on, and run no experiment",
    )
    parser.add_argument(
        "--vehicle",
        choices=("leng", *WHOLE_VEHICLES),
        default="leng",
        help="vehicle of --log: leng turns about yaw, the others move along several axes, to try identify on "
        "(default leng)",
    )
    add_json_argument(parser)


def run(args: argparse.Namespace) -> int:
    if not (math.isfinite(args.speed) and args.speed > 0.0):
        raise BadInput(f"--speed {args.speed}: give a positive number, 1 for the vehicle's own pace")
    if not 0 <= args.seed < 2**32:
        raise BadInput(f"--seed {args.seed}: give a whole number from 0 to {2**32 - 1}")
    if args.log is not None:
        return _write_log(args)
    if args.vehicle != "leng":
        raise BadInput(f"--vehicle {args.vehicle} is the vehicle of a log: name its file with --log FILE.csv")
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
    if args.vehicle in WHOLE_VEHICLES:
        return _write_dive(args)
    with writing(args.log, "--log"):
        inertia = float(importlib.import_module(LOG_WRITER).write_log(args.log, args.seed))
    text = (
        f"{args.log} is a log of five minutes of the simulated vehicle Leng. Next:\n"
        f"  incsvr inspect {args.log}\n"
        f"  incsvr fit {args.log} --inertia {inertia:g}\n"
        f"  incsvr trace {args.log} --inertia {inertia:g}"
    )
    emit(args, {"log": str(args.log), "inertia": inertia, "seed": args.seed}, text)
    return 0


def _write_dive(args: argparse.Namespace) -> int:
    """A log of all axes of a vehicle."""
    with writing(args.log, "--log"):
        body = importlib.import_module(DIVE_WRITER).write_dive(args.log, args.vehicle, args.seed)
    inertia = dict(zip(AXES, body.mass.diagonal().tolist(), strict=True))
    inertia = {axis: inertia[axis] for axis in body.moves}
    named = ", ".join(f"{axis} {value:.3g}" for axis, value in inertia.items())
    text = (
        f"{args.log} is a log of five minutes of a simulated {args.vehicle}.\n"
        f"Its inertia with the water's [kg, kg m²]: {named}.\n"
        f"Go on with incsvr identify {args.log} --write vehicle.yaml"
    )
    emit(args, {"log": str(args.log), "vehicle": args.vehicle, "inertia": inertia, "seed": args.seed}, text)
    return 0


def _interrupt(*_: object) -> None:
    raise KeyboardInterrupt


@dataclass(frozen=True, slots=True)
class _Acts:
    """The times of the hull and of the third act, by the vehicle's clock [s]."""

    hull_comes: float
    third: float


@dataclass(frozen=True, slots=True)
class _Course:
    """The learner's results: the iterations before the third act, the ledger at its end, its counters.

    Attributes:
        viewed: whether a viewer was there to record it.
        table: Table I of the same experiment; None where that is not installed.
    """

    history: list[IterationReport]
    ledger: EffectsLedger
    counters: Mapping[str, int]
    viewed: bool
    table: dict[str, Any] | None


def _demo(out: Path, speed: float, seed: int, people: Any) -> dict[str, Any]:
    """Plays all acts and returns their results in the form of the report."""
    recording, truth = out / "leng.rrd", out / "truth.json"
    try:
        out.mkdir(parents=True, exist_ok=True)
        for file in (recording, truth):
            file.unlink(missing_ok=True)
    except OSError as error:
        raise BadInput(f"nothing can be written to {out} ({error}); name another folder with --out") from error
    acts = _acts(out)
    course = _course(out, acts, speed, ("--set", f"simulation.underway={seed}", "--truth", str(truth)), people)
    result = played(course.history, acts.hull_comes) | {"table1": course.table}
    if not truth.exists():
        raise Failed("the simulator reported no effect; see simulate.log")
    hidden = json.loads(truth.read_text(encoding="utf-8"))
    result["underway"] = demo_underway.outcome(course.ledger, acts.third, seed, hidden)
    result["rejected"] = {name: count for name, count in course.counters.items() if name.startswith("rejected:")}
    if recording.exists():
        size, verified = recording.stat().st_size, verify(recording, people)
        result["recording"] = {"file": str(recording), "bytes": size, "verified": verified}
    elif course.viewed:
        raise Failed("the viewer recorded nothing; see view.log")
    return result


def _acts(out: Path) -> _Acts:
    """Writes the experiment's runs; when its acts begin."""
    runs = ["simulate", "--set", "simulation.runs=[V1, T1, V2, T2]", "--write", str(out)]
    if subprocess.run(command(*runs), check=False).returncode:
        raise Failed("the simulator could not write the experiment")
    hull_comes = _last_time(out / "T1.csv")
    return _Acts(hull_comes, hull_comes + RUN_PAUSE_S + _last_time(out / "T2.csv") - _first_time(out / "T2.csv"))


def _course(out: Path, acts: _Acts, speed: float, hides: Sequence[str], people: Any) -> _Course:
    """Plays the acts to a learner and a viewer, and prints what is learned as it comes."""
    endpoint, validation = free_endpoint(), [f"validation.{name}={out / name}.csv" for name in ("V1", "V2")]
    with ExitStack() as stack:
        # A state of its own, gone afterwards: the demo begins with nothing learned and touches no other's.
        state = stack.enter_context(TemporaryDirectory())
        settings = [
            f"state={state}",
            f"bus.listen={endpoint}",
            "learner.policy=paper",
            *validation,
            *demo_underway.SETTINGS,
        ]
        learner = stack.enter_context(
            process_of(out, "serve", *(word for each in settings for word in ("--set", each)))
        )
        session = stack.enter_context(open_session(client_config_at(endpoint), START_TIMEOUT_S))
        reports = arriving(session, KEYS.iteration, IterationReport)
        ledgers = arriving(session, KEYS.effects, EffectsLedger)
        wait_until_alive(session, learner)
        viewer = _viewer(stack, out, endpoint)
        player = stack.enter_context(
            process_of(out, "simulate", "--connect", endpoint, "--speed", str(speed), "--patient", *hides)
        )
        table = _table_of_this_run(stack, out)
        print(f"learner at {endpoint}; playing T1 and T2, {speed:g} times as fast", file=people)
        print(HEAD, file=people, flush=True)
        history: list[IterationReport] = []
        steps = demo_underway.Steps(acts.third, people)
        for report in iterations(session, reports, player, learner):
            if report.t > acts.third:
                steps.begin()
                while not ledgers.empty():
                    steps.tell(ledgers.get())
                continue
            if report.t > acts.hull_comes and all(each.t <= acts.hull_comes for each in history):
                print(f"— the hull is mounted at {acts.hull_comes:.0f} s —", file=people)
            history.append(report)
            print(line(report), file=people, flush=True)
        ledger = demo_underway.awaited(
            lambda: learner_answer(session, KEYS.effects, EffectsLedger),
            ledgers,
            lambda: learner.poll() is None,
            steps.tell,
        )
        counters = learner_answer(session, KEYS.health, Health).counters
        if viewer is not None:
            end(viewer)
        if table is not None and table.wait(TABLE_TIMEOUT_S):
            raise Failed("the table could not be made; see table1.log")
    rows = None if table is None else json.loads((out / "table1.json").read_text(encoding="utf-8"))
    return _Course(history, ledger, counters, viewer is not None, rows)


def _viewer(stack: ExitStack, out: Path, endpoint: str) -> subprocess.Popen[bytes] | None:
    """The viewer, which records; None where it is not installed."""
    if find_spec("viewer.view") is None or find_spec("rerun") is None:
        return None
    flags = ("--headless", "--save", str(out / "leng.rrd"), "--connect", endpoint, *COMPARE_FLAGS)
    viewer = stack.enter_context(process_of(out, "view", *flags))
    wait_until_ready(viewer, out / "view.log")
    return viewer


def _table_of_this_run(stack: ExitStack, out: Path) -> subprocess.Popen[bytes] | None:
    """Table I of the same experiment, made beside the rest; None where that is not installed."""
    if find_spec("benchmarks") is None or find_spec("sklearn") is None:
        return None
    words = ("--seeds", "1", "--first-seed", str(Simulation().seed), "--quick", "--json", str(out / "table1.json"))
    return stack.enter_context(process_of(out, "table1", *words))


def _last_time(path: Path) -> float:
    return float(path.read_text(encoding="utf-8").rstrip().rpartition("\n")[2].partition(",")[0])


def _first_time(path: Path) -> float:
    return float(path.read_text(encoding="utf-8").split("\n", 2)[1].partition(",")[0])
