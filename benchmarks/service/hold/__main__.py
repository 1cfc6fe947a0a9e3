"""What a learner survives: the table of benchmarks/results/hold.md.

`make hold`, or `python -m benchmarks.service.hold --part 0.1` for a tenth of it.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence

from benchmarks.service.hold.damages import damages
from benchmarks.service.hold.day import day
from benchmarks.service.hold.kills import kills
from benchmarks.service.hold.restarts import restarts
from benchmarks.service.hold.row import Row
from benchmarks.service.hold.strangers import flood, junk, stopped_client
from benchmarks.service.hold.tracing_kills import tracing_kills
from benchmarks.study import begin, options

HEAD = """\
# What a learner survives, notices and says

`{command}`, {date}, {processor}, {cores} cores, load {load_before:.1f} before; Python {python}, {versions}.
Each learner is `incsvr serve` in a process of its own, on a real bus and a real disk. *Silently wrong* is an
answer that is not what was published, or a loss that health does not tell.

| what | tried | lost, and said | silently wrong | seconds until it was over or said: median | what is counted |
|---|---|---|---|---|---|
"""


def _studies(part: float, seed: int) -> dict[str, Callable[[], list[Row]]]:
    def of(count: int) -> int:
        return max(round(part * count), 1)

    return {
        "kills": lambda: [kills(of(200), seed)],
        "tracing": lambda: [tracing_kills(of(50), 3_700_000 + seed)],
        "damages": lambda: damages(of(200), seed),
        "restarts": lambda: restarts(of(50)),
        "junk": lambda: [junk(of(10_000), seed)],
        "flood": lambda: [flood(max(30.0 * part, 3.0))],
        "stopped": lambda: stopped_client(of(10)),
        "day": lambda: [day(max(24.0 * part, 0.5))],
    }


def _lines(studies: dict[str, Callable[[], list[Row]]]) -> Iterator[str]:
    for name, study in studies.items():
        print(f"{name} …", file=sys.stderr, flush=True)
        for row in study():
            yield row.as_text()


def main(words: Sequence[str] | None = None) -> None:
    parser = options("benchmarks.service.hold", __doc__, part=(1.0, "of the tries"), seed=(0, "of moments and places"))
    parser.add_argument("--only", nargs="+", metavar="STUDY", help="some of them alone; the result is only printed")
    args, measured = begin(parser, words, "eclipse-zenoh")
    measured["versions"] = ", ".join(f"{name} {version}" for name, version in measured["versions"].items())
    studies = _studies(args.part, args.seed)
    chosen = {name: study for name, study in studies.items() if not args.only or name in args.only}
    text = HEAD.format(**measured)
    print(text, end="")
    for line in _lines(chosen):
        print(line, flush=True)
        text += line + "\n"
    if not args.only:
        (args.out / "hold.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
