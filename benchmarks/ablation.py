"""What each rule of the tracer earns: the tables again without it, on seeds that no rule was made for.

    python -m benchmarks.ablation [--first-seed N] [--every K] [--rules NAME…] [--processes N]

The same recordings every time: the trial simulator with a torque that is the command, that is measured, and with all
noise in the torque's sensor, and the second simulator, which shares no line with the first. A rule is taken out by
putting what it does where it finds nothing in its place. Writes results/ablation.json and .md.
"""

from __future__ import annotations

import argparse
import importlib
import json
import multiprocessing
import os
import random
import shlex
import sys
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from functools import reduce
from pathlib import Path
from statistics import mean
from typing import Any

from benchmarks import second_cases, trace_cases
from benchmarks.provenance import provenance
from benchmarks.tables import table
from benchmarks.trace_judge import GOOD, judge
from incsvr.errors import BadInput
from incsvr.tracing import trace
from incsvr.tracing.run import Run
from incsvr.tracing.weak import alignment
from incsvr.tracing.weak.evidence import gain_of
from incsvr.tracing.weak.posing import pose
from service.progress import progress
from simulator import trial
from simulator.recordings import Recording
from simulator.trial import TorqueNoise

RESULTS = Path(__file__).parent / "results"
FIRST_SEED = 820_000
"""Seeds from here on are for the published table alone."""
OWN = {"one": 40, "half": 20, "two": 20, "quiet": 24}
SECOND = {"one": 36, "quiet": 14}
"""Cases of each group, drawn from every cell."""
NOISES: tuple[TorqueNoise, ...] = ("commanded", "measured", "torque")
AS_IT_IS = "as it is"

Patch = tuple[str, str, Any]
"""Module, name in it (of a class's function with the class), and what stands there instead."""


def _linear(runs: Sequence[Run], inertia: float, channels: Sequence[str]) -> Any:
    return alignment.settled(runs, pose(runs, inertia, channels, held=False), channels)[0]


RULES: Mapping[str, Sequence[Patch]] = {
    "alignment: whether the torque holds": [("incsvr.tracing.weak.pipeline", "aligned", _linear)],
    "feedback: what a controller answers": [("incsvr.tracing.weak.problem", "Problem.feedback_beside", lambda *_: 0.0)],
    "known command": [("incsvr.tracing.weak.problem", "Problem.knows_command", lambda *_: False)],
    "faint beside the others": [("incsvr.tracing.weak.acceptance", "_faint", lambda *_: None)],
    "several on one sine": [("incsvr.tracing.weak.acceptance", "given_away", lambda *_: 0.0)],
    "swapping and climbing": [
        ("incsvr.tracing.weak.search", "Search._swapped", lambda _, base: base),
        ("incsvr.tracing.weak.search", "Search.climbed", lambda _, base: base),
    ],
    "noise at the effect's own frequencies, slip": [
        ("incsvr.tracing.weak.acceptance", "evidence", gain_of),
        ("incsvr.tracing.weak.pipeline", "evidence", gain_of),
    ],
    "residual that rises, command that but jumps": [
        ("incsvr.tracing.weak.acceptance", "rose", lambda *_: False),
        ("incsvr.tracing.weak.acceptance", "in_passing", lambda *_: 0.0),
    ],
    "free run as a judge": [("incsvr.tracing.weak.acceptance", "pays", lambda *_: True)],
    "forward form: leads in closed loop, judges commands": [
        ("incsvr.tracing.forward.loop", "Loop.closed", property(lambda _: False)),
        ("incsvr.tracing.trace", "_unpaid", lambda *_: {}),
    ],
}
"""Of each rule, or group, what takes it out."""


@dataclass(frozen=True, slots=True)
class Case:
    """One recording of one simulator."""

    simulator: str  # one of NOISES, or "second"
    group: str
    seed: int
    index: int


def cases(first_seed: int, every: int) -> list[Case]:
    """The cases, of which every so-many-th is taken: drawn over all cells of the two simulators."""
    drawn: list[Case] = []
    for simulator in (*NOISES, "second"):
        counts = SECOND if simulator == "second" else OWN
        for group, count in counts.items():
            cells = random.Random(f"{first_seed} {simulator} {group}").sample(range(1260), count)
            drawn += [Case(simulator, group, first_seed, index) for index in cells[::every]]
    return drawn


def examine(case: Case, rule: str) -> dict[str, Any]:
    """What the tracer names without this rule, judged."""
    for module, name, instead in RULES.get(rule, ()):
        *path, last = name.split(".")
        setattr(reduce(getattr, path, importlib.import_module(module)), last, instead)
    recording, inertia, hidden, torque = _played(case)
    columns = dict(recording.columns)
    run = Run(recording.name, recording.time, columns.pop("yaw_rate"), columns.pop("torque"), columns)
    began, failure, named = time.process_time(), None, dict[str, list[str]]()
    refused = False
    try:
        answer = trace([run], inertia=inertia, torque="commanded" if torque == "commanded" else "measured").to_dict()
        named = {effect["effect"]: list(effect["cannot_tell_from"]) for effect in answer["effects"]}
    except BadInput as error:
        refused, failure = True, str(error)
    except Exception as error:  # a crash is a result too, and the other cases go on
        failure = f"{type(error).__name__}: {error}"
    return {
        "rule": rule,
        "simulator": case.simulator,
        "group": case.group,
        "index": case.index,
        "hidden": hidden,
        "named": named,
        "failure": failure,
        "judged": "refused" if refused else "failed" if failure else judge(hidden, named),
        "seconds": time.process_time() - began,
    }


def _played(case: Case) -> tuple[Recording, float, Sequence[str], str]:
    """Recording, declared inertia [kg m²], what is hidden, and what the torque is."""
    if case.simulator == "second":
        other = second_cases.case(case.group, case.index, case.seed)
        played = second_cases.play(other)
        return played.recording, played.inertia, other.effects, other.torque
    own = trace_cases.case(case.group, case.index, case.seed)
    noise = next(noise for noise in NOISES if noise == case.simulator)
    outcome = trial.play(replace(own, noise=noise))
    return outcome.recording, outcome.inertia, own.effects, "commanded" if noise == "commanded" else "measured"


def right(record: Mapping[str, Any]) -> bool:
    """Whether nothing was named where nothing is hidden (a refusal names nothing), else whether the effect or its class
    was."""
    return record["judged"] in GOOD or (not record["hidden"] and record["judged"] == "refused")


def report(document: Mapping[str, Any]) -> str:
    """The tables, as Markdown."""
    records: list[dict[str, Any]] = document["records"]
    rules = list(dict.fromkeys(record["rule"] for record in records))
    base = {_key(record): record for record in records if record["rule"] == rules[0]}
    head = ["without", "right, of", *(f"{s}: {g}" for s, g in _groups(records)), "gained", "lost", "false", "s"]
    rows = []
    for rule in rules:
        own = [record for record in records if record["rule"] == rule]
        beside = [(record, base[_key(record)]) for record in own if _key(record) in base]
        parts = [[x for x in own if (x["simulator"], x["group"]) == part] for part in _groups(records)]
        rows.append(
            [
                rule,
                _of(own),
                *(_of(part) for part in parts),
                str(sum(right(new) and not right(old) for new, old in beside)),
                str(sum(right(old) and not right(new) for new, old in beside)),
                str(sum(x["group"] == "quiet" and not right(x) for x in own)),
                f"{mean(x['seconds'] for x in own):.1f}",
            ]
        )
    return "\n".join(
        [
            "# What each rule of the tracer earns",
            "",
            f"Made by `{document['command']}`, {document['date']}, seeds {document['first_seed']}… "
            f"({document['cores']} cores, load {document['load_before']:.1f} before). Right or in the class, of the "
            "recordings of each kind (with nothing hidden: nothing named); gained and lost against the first row on "
            "the same recordings; mean processor time of a recording of 12 minutes. Where gained and lost differ by "
            "less than twice the square root of their sum, the difference is chance.",
            "",
            table(head, rows),
        ]
    )


def _groups(records: Sequence[Mapping[str, Any]]) -> list[tuple[str, str]]:
    return list(dict.fromkeys((record["simulator"], record["group"]) for record in records))


def _key(record: Mapping[str, Any]) -> tuple[str, str, int]:
    return record["simulator"], record["group"], record["index"]


def _of(records: Sequence[Mapping[str, Any]]) -> str:
    return f"{sum(map(right, records))}/{len(records)}"


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.ablation", description=__doc__)
    parser.add_argument("--first-seed", type=int, default=FIRST_SEED)
    parser.add_argument("--every", type=int, default=1, help="take every so-many-th case (default: all)")
    parser.add_argument("--rules", nargs="*", default=list(RULES), help="to take out, each alone (default: all)")
    parser.add_argument("--call", default=AS_IT_IS, help="name of the first row (default: %(default)s)")
    parser.add_argument("--beside", type=Path, metavar="JSON", help="results of another commit, as further rows")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--out", type=Path, default=RESULTS)
    args = parser.parse_args()
    where = provenance(shlex.join(["python", "-m", "benchmarks.ablation", *sys.argv[1:]]))
    work = [(case, rule) for rule in (args.call, *args.rules) for case in cases(args.first_seed, args.every)]
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    records: dict[int, dict[str, Any]] = {}
    # a process for each case: what takes a rule out must not reach the next
    context = multiprocessing.get_context("spawn")
    with (
        ProcessPoolExecutor(args.processes, context, max_tasks_per_child=1) as pool,
        progress("tracing", len(work)) as advance,
    ):
        futures = {pool.submit(examine, *item): place for place, item in enumerate(work)}
        for future in as_completed(futures):
            records[futures[future]] = future.result()
            advance()
    found = [records[place] for place in sorted(records)]
    if args.beside:
        found = [*json.loads(args.beside.read_text(encoding="utf-8"))["records"], *found]
    document = {**where, "first_seed": args.first_seed, "records": found}
    text = report(document)
    args.out.mkdir(parents=True, exist_ok=True)
    lines = ",\n".join(json.dumps(record, ensure_ascii=False) for record in found)
    head = json.dumps({key: value for key, value in document.items() if key != "records"})[:-1]
    (args.out / "ablation.json").write_text(f'{head}, "records": [\n{lines}\n]}}\n', encoding="utf-8")
    (args.out / "ablation.md").write_text(text + "\n", encoding="utf-8")
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
