"""What each rule of the tracer earns: the tables again without it, on seeds that no rule was made for.

    python -m benchmarks.ablation [--first-seed N] [--every K] [--rules NAME…] [--together] [--processes N]

The same recordings every time: the trial simulator with a torque that is the command, and with one that is measured,
and the second simulator, which shares no line with the first. The first row watches every rule (ablation_rules.py):
a recording is traced again only without those that did something in it, for without the others the answer is the same.
Writes results/ablation.json and .md.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import random
import shlex
import sys
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from statistics import mean
from typing import Any

import numpy as np

from benchmarks import second_cases, trace_cases
from benchmarks.ablation_rules import RULES, Patch
from benchmarks.provenance import provenance
from benchmarks.tables import table
from benchmarks.trace_judge import GOOD, judge
from incsvr.errors import BadInput
from incsvr.tracing import trace
from incsvr.tracing.run import Run
from service.progress import progress
from service.wire.json_text import json_text
from simulator import trial
from simulator.recordings import Recording
from simulator.trial import TorqueNoise

RESULTS = Path(__file__).parent / "results"
FIRST_SEED = 820_000
"""Seeds from here on are for the published table alone."""
OWN = {"one": 40, "half": 20, "two": 20, "quiet": 24}
SECOND = {"one": 36, "quiet": 14}
"""Cases of each group, drawn from every cell."""
NOISES: tuple[TorqueNoise, ...] = ("commanded", "measured")
AS_IT_IS, TOGETHER = "as it is", " + "


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
    """What the tracer names without this rule, judged; of the first row, which rules did something."""
    acted = set[str]()
    with ExitStack() as stack:
        for patch in _patches(rule):
            patch.apply()
        for name, patches in RULES.items() if not _patches(rule) else ():
            for patch in patches:
                stack.enter_context(patch.observed(partial(acted.add, name)))
        return _traced(case, rule) | {"acted": sorted(acted)}


def _patches(rule: str) -> list[Patch]:
    """What takes a rule out, or several; nothing of the first row."""
    return [patch for name in rule.split(TOGETHER) for patch in RULES.get(name, ())]


def _traced(case: Case, rule: str) -> dict[str, Any]:
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
    base = {_key(record): record for record in records if record["rule"] == document["call"]}
    groups = list(dict.fromkeys(_group(record) for record in base.values()))
    whole = [[each for each in base.values() if _group(each) == group] for group in groups]
    rows = []
    for rule in dict.fromkeys(record["rule"] for record in records if record["rule"] != document["call"]):
        own = [(record, base[_key(record)]) for record in records if record["rule"] == rule]
        gained = sum(right(new) and not right(old) for new, old in own)
        lost = sum(right(old) and not right(new) for new, old in own)
        false = [sum(bool(not each["hidden"] and not right(each)) for each in side) for side in zip(*own, strict=True)]
        spent = [sum(each["seconds"] for each in side) for side in zip(*own, strict=True)]
        rows.append(
            [rule.replace(TOGETHER, "; "), len(own), gained, lost, false[0] - false[1], f"{spent[0] / spent[1]:.2f}"]
        )
    idle = [rule for rule in document["rules"] if rule not in {record["rule"] for record in records}]
    rows += [[rule, 0, 0, 0, 0, "–"] for rule in idle]
    return "\n".join(
        [
            "# What each rule of the tracer earns",
            "",
            f"Made by `{document['command']}`, {document['date']}, seeds {document['first_seed']}… "
            f"({document['cores']} cores, load {document['load_before']:.1f} before)"
            + (f"; {document['not_run']} tracings were not run for want of time" if document["not_run"] else "")
            + ". A recording lasts 12 minutes.",
            "",
            "As it is; right or in the class, of the recordings of each kind (with nothing hidden: nothing named), and "
            "the mean processor time:",
            "",
            table(
                ["", *(f"{simulator}: {group}" for simulator, group in groups), "all", "s"],
                [[document["call"], *map(_of, whole), _of([*base.values()]), f"{_seconds(base.values()):.1f}"]],
            ),
            "",
            "Without one rule; *acts in*: recordings in which it does something, the others come out the same without "
            "it; gained, lost and falsely named where nothing is hidden, against the row above; *time*: over that of "
            "the row above on the recordings in which it acts. Where gained and lost differ by less than twice the "
            "square root of their sum, the difference is chance.",
            "",
            table(["without", "acts in", "gained", "lost", "false", "time"], [[*map(str, row)] for row in rows]),
        ]
    )


def _group(record: Mapping[str, Any]) -> tuple[str, str]:
    return record["simulator"], record["group"]


def _key(record: Mapping[str, Any]) -> tuple[str, str, int]:
    return record["simulator"], record["group"], record["index"]


def _seconds(records: Iterable[Mapping[str, Any]]) -> float:
    return float(mean(record["seconds"] for record in records))


def _of(records: Sequence[Mapping[str, Any]]) -> str:
    return f"{sum(map(right, records))}/{len(records)}"


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.ablation", description=__doc__)
    parser.add_argument("--first-seed", type=int, default=FIRST_SEED)
    parser.add_argument("--every", type=int, default=1, help="take every so-many-th case (default: all)")
    parser.add_argument("--rules", nargs="*", default=list(RULES), help="to take out, each alone (default: all)")
    parser.add_argument("--together", action="store_true", help="all of these rules at once")
    parser.add_argument("--call", default=AS_IT_IS, help="name of the first row (default: %(default)s)")
    parser.add_argument("--minutes", type=float, default=np.inf, help="after which none is begun (default: no limit)")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--out", type=Path, default=RESULTS)
    args = parser.parse_args()
    where = provenance(shlex.join(["python", "-m", "benchmarks.ablation", *sys.argv[1:]]))
    ends = time.monotonic() + 60.0 * args.minutes
    rules = [TOGETHER.join(args.rules)] if args.together else args.rules
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    work = [(case, args.call) for case in cases(args.first_seed, args.every)]
    later: list[tuple[Case, str]] = []
    records: list[dict[str, Any]] = []
    # a process for each case: what takes a rule out must not reach the next
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(args.processes, context, max_tasks_per_child=1) as pool:
        for done in _run(pool, work, np.inf, args.processes):
            records.append(done)
            case = Case(done["simulator"], done["group"], args.first_seed, done["index"])
            later += [(case, rule) for rule in rules if {*rule.split(TOGETHER)} & {*done["acted"]}]
        # in random order: where the time ends, each rule has been tried on a part of its recordings that chance chose
        random.Random(args.first_seed).shuffle(later)
        records += _run(pool, later, ends, args.processes)
    records.sort(key=lambda each: [args.call, *rules].index(each["rule"]))
    document = {
        **where,
        "first_seed": args.first_seed,
        "call": args.call,
        "rules": rules,
        "not_run": len(work) + len(later) - len(records),
        "records": records,
    }
    text = report(document)
    args.out.mkdir(parents=True, exist_ok=True)
    lines = ",\n".join(json_text(record) for record in records)
    head = json_text({key: value for key, value in document.items() if key != "records"})[:-1]
    (args.out / "ablation.json").write_text(f'{head}, "records": [\n{lines}\n]}}\n', encoding="utf-8")
    (args.out / "ablation.md").write_text(text + "\n", encoding="utf-8")
    print(text)
    return 0


def _run(
    pool: ProcessPoolExecutor, work: Sequence[tuple[Case, str]], ends: float, processes: int
) -> Iterator[dict[str, Any]]:
    """The records as they come; none is begun after it `ends`."""
    waiting = iter(work)
    running = {pool.submit(examine, *item) for _, item in zip(range(processes), waiting, strict=False)}
    with progress("tracing", len(work)) as advance:
        while running:
            done = next(as_completed(running))
            running.remove(done)
            if time.monotonic() < ends and (item := next(waiting, None)) is not None:
                running.add(pool.submit(examine, *item))
            yield done.result()
            advance()


if __name__ == "__main__":
    sys.exit(main())
