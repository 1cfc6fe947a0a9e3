"""The learner and the tracer on ordinary missions: what is served beside the truth, and what is named.

`make missions`. Every figure follows from `simulator/missions`; a seed names a mission, whatever else is tried.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import shlex
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from benchmarks.study import RESULTS, provenance
from benchmarks.tracer import mission_learner, mission_tracer
from benchmarks.tracer.judge import VERDICTS
from benchmarks.tracer.mission_cases import HIDDEN, IDLE, hidden, quiet
from service.wire.json_text import json_text
from simulator.missions import KINDS, VEHICLES, Mission, play

FIRST_SEED = 600_000
"""Seeds from here on are for the published tables alone; whoever improves learner or tracer looks at smaller ones."""
TURNING = "survey"
"""The kind in which every effect is hidden on every vehicle."""
OTHER_VEHICLE = "auv"
"""The vehicle for which the effects are hidden in all other kinds too."""
Group = Literal["learner", "quiet", "surveys", "others"]


@dataclass(frozen=True, slots=True)
class Case:
    """A mission, and what it is played for."""

    group: Group
    mission: Mission


def cases(args: argparse.Namespace) -> Iterator[Case]:
    """All that is asked for; the groups have seeds of their own."""
    seed = args.first_seed
    if args.only != "tracer":
        for mission in quiet(args.runs, seed, args.kinds, args.vehicles):
            yield Case("learner", mission)
    if args.only == "learner":
        return
    for mission in quiet(args.runs, seed, args.kinds, args.vehicles):
        yield Case("quiet", mission)
    if TURNING in args.kinds:
        for number, vehicle in enumerate(args.vehicles):
            for mission in hidden(TURNING, vehicle, args.hidden_runs, seed + 10_000 + 1_000 * number):
                yield Case("surveys", mission)
    if OTHER_VEHICLE in args.vehicles:
        for number, kind in enumerate(KINDS):
            if kind in args.kinds and kind != TURNING and kind not in IDLE:
                for mission in hidden(kind, OTHER_VEHICLE, args.other_runs, seed + 20_000 + 1_000 * number):
                    yield Case("others", mission)


def examine(case: Case) -> list[dict[str, Any]]:
    """Plays the mission and judges what is made of its log."""
    outcome = play(case.mission)
    if case.group == "learner":
        return [record | {"group": case.group} for record in mission_learner.examine(outcome)]
    return [mission_tracer.examine(case.group, outcome)]


def study(work: Sequence[Case], processes: int) -> list[dict[str, Any]]:
    """The records of the cases in their order, with a progress bar on standard error."""
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    # One core a process; the processes that are spawned load NumPy anew and see this.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    with (
        ProcessPoolExecutor(processes, multiprocessing.get_context("spawn")) as pool,
        Progress(*columns, console=Console(stderr=True)) as progress,
    ):
        return [
            record
            for records in progress.track(pool.map(examine, work), total=len(work), description="missions")
            for record in records
        ]


def report(document: dict[str, Any]) -> str:
    """Markdown."""
    by_group: dict[str, list[dict[str, Any]]] = {}
    for record in document["records"]:
        by_group.setdefault(record["group"], []).append(record)
    learned, still = by_group.get("learner", []), by_group.get("quiet", [])
    parts = [
        "# Ordinary missions: what is served, and what is named",
        f"Made by `{document['command']}` on {document['date']}, revision {document['revision']}, seeds from "
        f"{document['first_seed']}, in {document['minutes']} minutes. Missions of half an hour from "
        "`simulator/missions`: the controller in the loop, water that moves the vehicle, commands logged exactly.",
    ]
    if learned:
        parts += [
            "## The learner, nothing hidden",
            f"Served ÷ truth: smallest, median and largest ratio at the driven rates beyond "
            f"{mission_learner.OUTER:g} of the largest one. Near: share of the driven rates at which the served moment "
            f"is off by at most {100 * mission_learner.RELATIVE:g} % of the truth or {mission_learner.OF_THE_WATER:g} "
            "times the water's own deviation. Covered: share of the trained range where the curve's band of 95 % holds "
            "the truth. Drives: share of it where the served moment drives the vehicle by more than this band.",
            mission_learner.report(learned),
            "Least often near:",
            mission_learner.worst(learned),
        ]
    if still:
        parts += [
            "## The tracer, nothing hidden",
            mission_tracer.report_quiet(still),
            "Refusals:\n\n" + mission_tracer.sentences(still, "refused"),
            "Tracebacks:\n\n" + mission_tracer.sentences(still, "failed"),
        ]
    for group, title, by in (
        ("surveys", "The tracer, one effect of full size hidden in a survey", "vehicle"),
        ("others", f"The tracer, one effect of full size hidden in other missions (vehicle {OTHER_VEHICLE})", "kind"),
    ):
        if group in by_group:
            parts += [f"## {title}", mission_tracer.report_hidden(by_group[group], by)]
    if by_group.keys() & {"surveys", "others"}:
        said = {name: meaning for name, meaning in VERDICTS.items() if name in ("right", "class", "missed")}
        said |= {"false beside": VERDICTS["false"], "another named": VERDICTS["both"]}
        parts.append("\n".join(f"- {name}: {meaning}." for name, meaning in said.items()))
        parts.append("A drag that grows at once (`drag_step`) or by and by (`drag_drift`) counts as one effect.")
    return "\n\n".join(parts) + "\n"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of the study."""
    parser.add_argument("--first-seed", type=int, default=FIRST_SEED)
    parser.add_argument("--runs", type=int, default=3, help="of each kind and vehicle, nothing hidden")
    parser.add_argument("--hidden-runs", type=int, default=3, help=f"of each effect and vehicle, in a {TURNING}")
    parser.add_argument("--other-runs", type=int, default=1, help="of each effect and other kind of mission")
    parser.add_argument("--only", choices=("learner", "tracer"), help="one alone, into files of its own")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS)
    parser.add_argument("--vehicles", nargs="+", choices=tuple(VEHICLES), default=tuple(VEHICLES))
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--out", type=Path, default=RESULTS, help="folder of the results (default: %(default)s)")


def run(args: argparse.Namespace) -> int:
    """Writes missions.json and missions.md; for the learner or the tracer alone missions_learner or missions_tracer."""
    name = "missions" if args.only is None else f"missions_{args.only}"
    began = time.perf_counter()
    records = study(list(cases(args)), args.processes)
    document = provenance(shlex.join(["python", "-m", "benchmarks.tracer.missions", *sys.argv[1:]])) | {
        "revision": revision(),
        "first_seed": args.first_seed,
        "minutes": round((time.perf_counter() - began) / 60.0, 1),
        "effects": list(HIDDEN),
        "records": records,
    }
    text = report(document)
    lines = ",\n".join(json_text(record) for record in records)
    head = json_text({key: value for key, value in document.items() if key != "records"})[:-1]
    args.out.mkdir(parents=True, exist_ok=True)
    (args.out / f"{name}.json").write_text(f'{head}, "records": [\n{lines}\n]}}\n', encoding="utf-8")
    (args.out / f"{name}.md").write_text(text, encoding="utf-8")
    print(text)
    return 0


def revision() -> str:
    """The commit that was measured, with a mark where files differ from it."""
    said = subprocess.run(
        ["git", "describe", "--always", "--dirty"], cwd=RESULTS.parent, capture_output=True, text=True, check=False
    )
    return said.stdout.strip() or "unknown"


def main() -> int:
    """The command line of the study."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.tracer.missions", description=__doc__)
    add_arguments(parser)
    return run(parser.parse_args())


if __name__ == "__main__":
    sys.exit(main())
