"""The tracer's confusion matrix and its false alarms.

`make trace-table`, or `python -m benchmarks.tracer.trace_table --only one:10007` for one case again. `--noise` says
what the torque is and where the noise is (simulator/trial.py); each of the two has a table of its own.
"""

from __future__ import annotations

import random
import time
from collections.abc import Sequence
from dataclasses import asdict, replace

from benchmarks.study import Record, begin, in_processes, options, publish
from benchmarks.tracer.answer import answer
from benchmarks.tracer.judge import judge
from benchmarks.tracer.trace_cases import GROUPS, case
from benchmarks.tracer.trace_report import NOISE, report
from service.wire.json_text import json_text
from simulator.trial import Trial, play

FIRST_SEED = 2_000_000
"""Seeds from here on are for the published table alone; whoever improves the tracer tries it on smaller ones."""


def examine(work: tuple[str, Trial]) -> Record:
    """Plays a trial of a group, has it traced, and judges the answer; a plain record, for JSON."""
    group, trial = work
    outcome = play(trial)
    # The weaker of two decides whether both can be found.
    evidence = min([play(replace(trial, effects=(name,))).evidence for name in trial.effects], default=0.0)
    found = answer(outcome.recording, outcome.inertia)
    failure = found["failed"] or found["refused"]
    return {
        "group": group,
        **asdict(trial),
        "truth": outcome.truth,
        "evidence": evidence,
        **found,
        "failure": failure,
        "judged": "failed" if failure else judge(trial.effects, found["named"]),
    }


def main(words: Sequence[str] | None = None) -> None:
    parser = options(
        "benchmarks.tracer.trace_table",
        __doc__,
        first_seed=(FIRST_SEED, "of the trials"),
        one=(120, "trials with one effect"),
        half=(120, "the same at half the size"),
        two=(60, "trials with two effects"),
        quiet=(200, "trials with nothing hidden"),
        minutes=(12.0, "length of a recording"),
        processes=(2, "trials at once"),
        at_most=(180.0, "minutes after which no trial is begun"),
    )
    parser.add_argument("--noise", choices=list(NOISE), default="commanded", help="what the torque is (%(default)s)")
    parser.add_argument("--only", metavar="GROUP:SEED", help="one case again, printed instead of written")
    args, measured = begin(parser, words)

    def drawn(group: str, index: int) -> Trial:
        return replace(case(group, index, args.first_seed, 60 * args.minutes), noise=args.noise)

    if args.only:
        group, _, seed = args.only.partition(":")
        print(json_text(examine((group, drawn(group, int(seed) - args.first_seed))), indent=2))
        return
    work = [(group, drawn(group, index)) for group in GROUPS for index in range(getattr(args, group))]
    # In random order, so that a study that stops early is a smaller study of the same kind.
    random.Random(args.first_seed).shuffle(work)
    began = time.perf_counter()
    records = in_processes(examine, work, "trials", args.processes, args.at_most)
    document = measured | {
        "first_seed": args.first_seed,
        "minutes": round((time.perf_counter() - began) / 60, 1),
        "planned": len(work),
        "records": sorted(records, key=lambda record: (record["group"], record["seed"])),
    }
    name = "trace_table" + "_measured" * (args.noise == "measured")
    publish(args.out, name, document, report(document))


if __name__ == "__main__":
    main()
