"""Which samples to keep: the paper's policy and the weighted one, row by row.

`make policy`. Every figure is lower the better. The weighted policy learns with its own kernel width, as it is
recommended.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.learner import policy_measured as measured_runs
from benchmarks.learner.policies import GAMMA, POLICIES
from benchmarks.learner.policy_cases import ADAPTIVE, CASES, EXPERIMENT, FITTED, FITTED_SAMPLES, examine
from benchmarks.study import Record, begin, in_processes, options, publish
from benchmarks.tables import grouped, page, table

TUNED_ON = (
    "the weighted policy's constants were set on simulated seeds from 1,000 on. How it works was also shaped by "
    "looking at the BlueROV's runs: its measured rows are no independent test."
)
FIRST_SEED = 650_000
"""Seeds from here on are for the published table alone."""
NAMES = (*FITTED, ADAPTIVE)


def rows(records: Sequence[Record]) -> Iterator[Record]:
    """Each simulated figure with a value a seed under each policy."""
    for own in grouped(records, "case").values():
        for same in zip(*(record["figures"] for record in own), strict=True):
            about = {key: same[0][key] for key in ("name", "figure")} | {"kind": "seed"}
            yield about | {policy: [each[policy] for each in same] for policy in POLICIES}


def report(document: Record) -> str:
    """Markdown."""
    found = document["rows"]
    worse = sum(0.0 < np.mean(row["paper"]) < np.mean(row["weighted"]) for row in found)
    head = ["what", "figure", *POLICIES, "ratio", "weighted better in"]
    return page(
        "# Which samples to keep: the paper's policy and the weighted one",
        f"`{document['command']}`, {document['date']}. Seeds {document['seeds']}; {TUNED_ON}\n"
        f"Kernel width at ±0.25 rad/s: γ = {GAMMA['paper']:g} s²/rad² for the paper's policy and the offline SVR, "
        f"{GAMMA['weighted']:g} for the weighted one.\n"
        "Mean ± standard deviation over the seeds or runs; every figure is lower the better.",
        table(head, [_line(row) for row in found]),
        f"The weighted policy is worse in {worse} of {len(found)} rows.",
        "## The baselines that the paper cites",
        "RMS to the truth at the end [N m] (the policies: mean of the last four batches), and of missions over the "
        f"water's deviation; mean over the seeds. The baselines are fitted to the last {FITTED_SAMPLES} "
        "samples, the adaptive identifier to all of a mission's streams.",
        table(["what", *POLICIES, *NAMES], list(_baselines(document))),
    )


def _line(row: Record) -> list[str]:
    paper, weighted = (np.array(row[policy]) for policy in POLICIES)
    spread = min(1, paper.size - 1)
    return [
        row["name"],
        row["figure"],
        *(f"{values.mean():.3f} ± {values.std(ddof=spread):.3f}" for values in (paper, weighted)),
        f"{weighted.mean() / paper.mean():.2f}" if paper.mean() else "–",
        f"{np.count_nonzero(weighted < paper)} of {paper.size} {row['kind']}s",
    ]


def _baselines(document: Record) -> Iterator[list[str]]:
    """Both policies beside the baselines that the paper cites."""
    for name, own in grouped(document["records"], "case").items():
        if own[0]["baselines"]:
            mine = [row for row in document["rows"] if row["name"] == name]
            row = next((row for row in mine if "last four" in row["figure"]), mine[0])
            means = {each: np.mean([one["baselines"][each] for one in own]) for each in own[0]["baselines"]}
            cells = [*(np.mean(row[policy]) for policy in POLICIES), *(means.get(each) for each in NAMES)]
            yield [name, *("–" if each is None else f"{each:.2f}" for each in cells)]


def main(words: Sequence[str] | None = None) -> None:
    parser = options(
        "benchmarks.learner.policy",
        __doc__,
        seeds=(20, "of each case"),
        first_seed=(FIRST_SEED, "of them"),
        processes=(1, "cases at once"),
    )
    parser.add_argument("--only", nargs="+", choices=CASES, metavar="NAME", help="these scenarios and missions (all)")
    args, measured = begin(parser, words)
    if not measured_runs.FOLDER.is_dir():
        print(f"no measured recordings in {measured_runs.FOLDER}: their rows are left out", file=sys.stderr)
    seeds = range(args.first_seed, args.first_seed + args.seeds)
    chosen = [name for name in CASES if not args.only or name in (EXPERIMENT, *args.only)]
    records = in_processes(examine, [(name, seed) for name in chosen for seed in seeds], "cases", args.processes)
    found = list(rows(records))
    for inertia in measured_runs.INERTIAS if measured_runs.FOLDER.is_dir() else ():
        found += measured_runs.rows(inertia)
    document = measured | {"seeds": f"{seeds[0]}–{seeds[-1]}", "rows": found, "records": records}
    publish(args.out, "policy", document, report(document))


if __name__ == "__main__":
    main()
