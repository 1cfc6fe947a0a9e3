"""The learner and the tracer on ordinary missions: what is served beside the truth, and what is named.

`make missions`. Every figure follows from `simulator/missions`; a seed names a mission, whatever else is tried.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Literal

from benchmarks.study import Record, begin, in_processes, options, publish, revision
from benchmarks.tables import grouped, page
from benchmarks.tracer import mission_learner, mission_tracer
from benchmarks.tracer.judge import VERDICTS
from benchmarks.tracer.mission_cases import IDLE_KINDS, hidden, quiet
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
            if kind in args.kinds and kind != TURNING and kind not in IDLE_KINDS:
                for mission in hidden(kind, OTHER_VEHICLE, args.other_runs, seed + 20_000 + 1_000 * number):
                    yield Case("others", mission)


def examine(case: Case) -> list[Record]:
    """Plays the mission and judges what is made of its log."""
    outcome = play(case.mission)
    if case.group == "learner":
        return [record | {"group": case.group} for record in mission_learner.examine(outcome)]
    return [mission_tracer.examine(case.group, outcome)]


def report(document: Record) -> str:
    """Markdown."""
    by_group = grouped(document["records"], "group")
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
            f"{mission_learner.OUTER_RATE_SHARE:g} of the largest one. Near: share of the driven rates at which the "
            f"served moment is off by at most {100 * mission_learner.NEAR_SHARE:g} % of the truth or "
            f"{mission_learner.NEAR_WATER_RATIO:g} times the water's own deviation. Covered: share of the trained "
            "range where the curve's band of 95 % holds the truth. Drives: share of it where the served moment "
            "drives the vehicle by more than this band.",
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
    return page(*parts)


def main(words: Sequence[str] | None = None) -> None:
    """Writes the page missions.md; for the learner or the tracer alone missions_learner.md or missions_tracer.md."""
    parser = options(
        "benchmarks.tracer.missions",
        __doc__,
        first_seed=(FIRST_SEED, "of the missions"),
        runs=(3, "of each kind and vehicle, nothing hidden"),
        hidden_runs=(3, f"of each effect and vehicle, in a {TURNING}"),
        other_runs=(1, "of each effect and other kind of mission"),
        processes=(2, "missions at once"),
    )
    parser.add_argument("--only", choices=("learner", "tracer"), help="one alone, into files of its own")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS)
    parser.add_argument("--vehicles", nargs="+", choices=tuple(VEHICLES), default=tuple(VEHICLES))
    args, measured = begin(parser, words)
    commit, began = revision(), time.perf_counter()
    records = chain.from_iterable(in_processes(examine, list(cases(args)), "missions", args.processes))
    document = measured | {
        "records": list(records),
        "revision": commit,
        "first_seed": args.first_seed,
        "minutes": round((time.perf_counter() - began) / 60.0, 1),
    }
    publish(args.out, "missions" if args.only is None else f"missions_{args.only}", document, report(document))


if __name__ == "__main__":
    main()
