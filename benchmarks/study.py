"""What every study does: its options, its processes, where and when it was measured, its page."""

from __future__ import annotations

import argparse
import importlib.metadata
import multiprocessing
import os
import platform
import shlex
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TypeVar

from service.cli.progress import progress
from service.wire.json_text import json_text

RESULTS = Path(__file__).parent / "results"
"""Where the pages of the published results are."""
MEASURED = Path(__file__).parents[2] / "shared" / "measured"
"""The recordings of measured vehicles carry no licence, so that they stand beside the project and not in it."""
CORES = os.cpu_count() or 1

Record = dict[str, Any]
Case = TypeVar("Case")
Result = TypeVar("Result")


def options(module: str, about: str, /, **numbers: tuple[int | float, str]) -> argparse.ArgumentParser:
    """The options of a study: numbers of its own, and the folder of its page.

    Args:
        module: by which it is started, `python -m`.
        about: what it measures; the module's docstring.
        numbers: by name the default and its meaning.
    """
    parser = argparse.ArgumentParser(
        prog=f"python -m {module}", description=about, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    for name, (default, meaning) in numbers.items():
        flag, text = f"--{name.replace('_', '-')}", f"{meaning} (default: %(default)s)"
        parser.add_argument(flag, type=type(default), default=default, help=text)
    parser.add_argument("--out", type=Path, default=RESULTS, metavar="FOLDER", help="where its page is written")
    return parser


def begin(
    parser: argparse.ArgumentParser, words: Sequence[str] | None, *packages: str
) -> tuple[argparse.Namespace, Record]:
    """The options that were given, and where and when the study was begun with them.

    Args:
        words: of the command line; None for the process's own.
        packages: which versions are told beside those of NumPy and SciPy.
    """
    given = sys.argv[1:] if words is None else list(words)
    return parser.parse_args(given), provenance(shlex.join([*parser.prog.split(), *given]), *packages)


def provenance(command: str, *packages: str) -> Record:
    """Command, date, machine and the versions of what was measured: no figure is published without it."""
    return {
        "command": command,
        "date": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "processor": _processor(),
        "cores": os.cpu_count(),
        "load_before": os.getloadavg()[0],
        "python": platform.python_version(),
        "versions": {name: importlib.metadata.version(name) for name in ("numpy", "scipy", *packages)},
    }


def revision() -> str:
    """The commit that was measured, with a mark where files differ from it."""
    said = subprocess.run(
        ["git", "describe", "--always", "--dirty"], cwd=RESULTS.parent, capture_output=True, text=True, check=False
    )
    return said.stdout.strip() or "unknown"


def in_processes(
    examine: Callable[[Case], Result],
    cases: Sequence[Case],
    what: str,
    processes: int,
    minutes: float = float("inf"),
) -> list[Result]:
    """What is made of each case, in their order, with a progress bar on standard error.

    Args:
        examine: makes it; importable, for it runs in processes of its own, but in this one where one is enough.
        what: the cases are, for the bar.
        minutes: after which no further case is begun; those are left out.
    """
    ends, waiting = time.monotonic() + 60.0 * minutes, iter(enumerate(cases))
    results, running = dict[int, Result](), dict[Future[Result], int]()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the processes are the parallel ones; those to come see this
    with progress(what, len(cases)) as advance:
        if processes == 1:
            for place, case in waiting:
                if time.monotonic() < ends:
                    results[place] = examine(case)
                    advance()
            return list(results.values())
        with ProcessPoolExecutor(processes, multiprocessing.get_context("spawn")) as pool:
            while True:
                while len(running) < processes and time.monotonic() < ends and (following := next(waiting, None)):
                    running[pool.submit(examine, following[1])] = following[0]
                if not running:
                    break
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    results[running.pop(future)] = future.result()
                    advance()
    return [results[place] for place in sorted(results)]


def write(folder: Path, name: str, document: Mapping[str, Any]) -> str:
    """Writes a study for programs (`name.json`); gives what was written."""
    folder.mkdir(parents=True, exist_ok=True)
    text = json_text(document, indent=1) + "\n"
    (folder / f"{name}.json").write_text(text, encoding="utf-8")
    return text


def publish(folder: Path, name: str, document: Mapping[str, Any], text: str) -> None:
    """Writes a study for programs (`name.json`) and for people (`name.md`), and prints the latter."""
    write(folder, name, document)
    (folder / f"{name}.md").write_text(text, encoding="utf-8")
    print(text, end="")


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine())
