"""What every study does: options, cases in processes, where and when it was measured, its page for people and programs.

A study is a module with three functions and one call:

    def cases(asked): ...      # the cases that the options ask for
    def examine(case): ...     # one case, in a process of its own; gives what JSON can hold
    def report(results): ...   # the parts of the page: sentences and tables

    if __name__ == "__main__":
        run("name", __doc__, cases, examine, report, seeds=(20, "voyages"), first_seed=(0, "of them"))
"""

from __future__ import annotations

import argparse
import importlib.metadata
import math
import multiprocessing
import os
import platform
import shlex
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from incsvr.numerics import Array
from service.cli.progress import progress
from service.wire.json_text import json_text

RESULTS = Path(__file__).parent / "results"
"""Where the pages of the published results are."""
MEASURED = Path(__file__).parents[2] / "shared" / "measured"
"""The recordings of measured vehicles carry no licence, so they are beside the project and not in it."""
HALVES = {
    "dagon": (["run_01", "run_03", "run_05", "run_07"], ["run_04"]),
    "blueboat": (["run_220", "run_221", "run_224", "run_225"], ["run_230", "run_233", "run_234"]),
    "kvlcc2": (["Z_05_01", "Z_10_10_P", "Z_20_10_S", "Z_35_05"], ["Z_10_05", "Z_15_05", "Z_25_05"]),
}
"""Their recordings in halves, stated before any figure was seen: each is fitted once, and judged on once."""
SIGMAS_OF_95 = 1.96
"""Half width of a band of 95 %, in standard deviations."""

Record = dict[str, Any]
Case = TypeVar("Case")
Result = TypeVar("Result")


def run(
    name: str,
    about: str | None,
    cases: Callable[[argparse.Namespace], Sequence[Case]],
    examine: Callable[[Case], Result],
    report: Callable[[Sequence[Result]], Iterable[str]],
    words: Sequence[str] | None = None,
    packages: Sequence[str] = (),
    **numbers: tuple[int | float | str, str],
) -> None:
    """Runs a study, prints its page and writes it as `name.md` and `name.json`.

    Args:
        name: of the study's module in this folder and of its results.
        about: what it measures; the module's docstring, whose first line is the page's title.
        cases: the cases that the options ask for.
        examine: examines one of them; importable, because it runs in processes of its own.
        report: the parts of the page.
        words: of the command line; None for the process's own.
        packages: whose versions are recorded beside those of NumPy and SciPy.
        numbers: the study's options, by name the default and its meaning.
    """
    title, _, _ = (about or name).partition("\n")
    command = f"python -m benchmarks.{name}"
    parser = argparse.ArgumentParser(command, description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    for option, (default, meaning) in {**numbers, "processes": (1, "cases examined at once")}.items():
        flag, text = f"--{option.replace('_', '-')}", f"{meaning} (default: %(default)s)"
        parser.add_argument(flag, type=type(default), default=default, help=text)
    parser.add_argument("--out", type=Path, default=RESULTS, metavar="FOLDER", help="where its page is written")
    given = sys.argv[1:] if words is None else list(words)
    asked = parser.parse_args(given)
    measured = provenance(shlex.join([*command.split(), *given]), *packages)
    chosen = cases(asked)
    if not chosen:
        print("there is nothing to examine: no case fits the options, or its recordings are missing", file=sys.stderr)
        sys.exit(2)
    results = in_processes(examine, chosen, "cases", asked.processes)
    versions = ", ".join(f"{package} {version}" for package, version in measured["versions"].items())
    made = f"`{measured['command']}`, {measured['date']}, {measured['processor']}, {measured['cores']} cores, load "
    made += f"{measured['load_before']:.1f} before; Python {measured['python']}, {versions}."
    text = "\n\n".join(part for part in (f"# {title.rstrip('.')}", made, *report(results)) if part) + "\n"
    asked.out.mkdir(parents=True, exist_ok=True)
    document = json_text(measured | {"results": results}, indent=1) + "\n"
    (asked.out / f"{name}.json").write_text(document, encoding="utf-8")
    (asked.out / f"{name}.md").write_text(text, encoding="utf-8")
    print(text, end="")


def seeds(asked: argparse.Namespace) -> range:
    """The seeds of the options `--first-seed` and `--seeds`."""
    return range(asked.first_seed, asked.first_seed + asked.seeds)


def provenance(command: str, *packages: str) -> Record:
    """Command, date, machine and versions of what is measured: no figure is published without it."""
    return {
        "command": command,
        "date": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "processor": _processor(),
        "cores": os.cpu_count(),
        "load_before": os.getloadavg()[0],
        "python": platform.python_version(),
        "versions": {name: importlib.metadata.version(name) for name in ("numpy", "scipy", *packages)},
    }


def in_processes(examine: Callable[[Case], Result], cases: Sequence[Case], what: str, processes: int) -> list[Result]:
    """What `examine` makes of each case, in their order, with a progress bar on standard error.

    Args:
        examine: importable, because it runs in processes of its own; in this one where one is enough.
        cases: to examine.
        what: the cases are, for the bar.
        processes: at most so many at once.
    """
    results: list[Result] = []
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the processes are the parallel ones
    with progress(what, len(cases)) as advance:
        if processes == 1:
            for case in cases:
                results.append(examine(case))
                advance()
            return results
        with ProcessPoolExecutor(processes, multiprocessing.get_context("spawn")) as pool:
            for result in pool.map(examine, cases):
                results.append(result)
                advance()
    return results


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)


def grouped(records: Iterable[Mapping[str, Any]], *keys: str) -> dict[Any, list[Any]]:
    """The records by their values of one key, or of several as a tuple, in the order in which they come."""
    groups: dict[Any, list[Any]] = {}
    for record in records:
        values = tuple(record[key] for key in keys)
        groups.setdefault(values if len(keys) > 1 else values[0], []).append(record)
    return groups


def share(hits: int, count: int) -> str:
    """A share as a count, and Wilson's 95 % interval of it."""
    low, high = interval(hits, count)
    return f"{hits} of {count} ({100 * low:.0f}–{100 * high:.0f} %)" if count else "–"


def interval(hits: int, count: int) -> tuple[float, float]:
    """Wilson's 95 % interval of a share."""
    if count == 0:
        return 0.0, 1.0
    z, part = SIGMAS_OF_95, hits / count
    middle = (part + z * z / (2 * count)) / (1 + z * z / count)
    half = z / (1 + z * z / count) * math.sqrt(part * (1 - part) / count + z * z / (4 * count * count))
    return max(middle - half, 0.0), min(middle + half, 1.0)


def spread(values: Sequence[float] | Array, digits: int = 2) -> str:
    """The mean of several seeds with their standard deviation; of one seed its value."""
    mean = f"{np.mean(values):.{digits}f}" if len(values) else "–"
    return f"{mean} ± {np.std(values, ddof=1):.{digits}f}" if len(values) > 1 else mean


def median(values: Sequence[float] | Array, digits: int = 2) -> str:
    """The median of several seeds with the least and the greatest."""
    if not len(values):
        return "–"
    return f"{np.median(values):.{digits}f} ({min(values):.{digits}f} to {max(values):.{digits}f})"


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine())
