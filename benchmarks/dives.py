"""Dives compared: how often a changed drag is found, and how often a change is reported that is not there.

Simulated vehicles dive four times; in some the drag of one axis grows after the second dive. A fleet's history is
compared by `incsvr compare` from one table of all dives of all vehicles, whose coefficients scatter about their truth
by their standard errors; in a tenth of these vehicles the yaw drag grows after half of the dives.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.study import Record, grouped, run, share, table
from incsvr.vehicle import compare
from simulator.dive_log import dives
from simulator.vehicles import BODIES, NAMES

DIVES = 4
"""Dives of each simulated vehicle."""
QUANTITIES = tuple((axis, quantity) for axis in ("surge", "sway", "yaw") for quantity in ("inertia", "drag"))
CHANGED_PART, ERROR_PART, FREEDOM = 0.1, 0.01, 12.0
"""Of the fleet: the part of the vehicles that change; the usual standard error, in the coefficient, as drags of dives
of two to four minutes have it; and its degrees of freedom."""
Case = tuple[str, int, float, float]
"""Kind of vehicle, seed, length of a dive [s], factor of the drag; or "fleet", vehicles, dives, factor."""


def cases(asked: argparse.Namespace) -> list[Case]:
    found = [(kind, asked.first_seed + 1000 * column + k, asked.seconds, factor)
             for kind in ("torpedo", "boat") for column, (factor, count) in enumerate(
                 ((asked.factor, asked.changed), (1.0, asked.quiet))) for k in range(count)]  # fmt: skip
    return found + [("fleet", asked.fleet, float(asked.history), asked.factor)] * bool(asked.fleet)


def examine(case: Case) -> Record:
    """One vehicle: the changes that are reported, as (dive, axis, quantity); or the fleet."""
    kind, seed, seconds, factor = case
    if kind == "fleet":
        return _fleet(seed, int(seconds), factor)
    rng = np.random.default_rng(seed)
    vehicle = BODIES[kind](rng)
    axis = str(rng.choice(list(vehicle.effort)))
    more = np.where(np.array(NAMES) == axis, factor, 1.0)
    later = replace(vehicle, linear=vehicle.linear * more, quadratic=vehicle.quadratic * more)
    logs = dives([vehicle if k < DIVES // 2 else later for k in range(DIVES)], seconds, seed)
    found = compare(logs, [str(k) for k in range(DIVES)])
    reported = [[int(dive), quantity.axis, quantity.kind] for dive, quantity, _ in found.changes]
    return {"kind": kind, "axis": axis if factor != 1.0 else None, "seconds": seconds, "reported": reported}


def _fleet(vehicles: int, history: int, factor: float) -> Record:
    """`incsvr compare` of a table, a process of its own."""
    import pyarrow as arrow
    from pyarrow import parquet

    rng, size = np.random.default_rng(3_460_000), len(QUANTITIES)
    shape, grown = (history, size), {f"vehicle {k:04d}" for k in range(round(CHANGED_PART * vehicles))}
    with tempfile.TemporaryDirectory() as folder:
        path, found = Path(folder) / "fleet.parquet", Path(folder) / "found.json"
        writer = None
        for name in (f"vehicle {k:04d}" for k in range(vehicles)):
            truth = np.tile(rng.uniform(5.0, 50.0, size), (history, 1))
            truth[history // 2 :, -1] *= factor if name in grown else 1.0
            error = truth * ERROR_PART * rng.uniform(0.5, 2.0, shape)
            part = arrow.table({
                "vehicle": [name] * (history * size),
                "dive": np.repeat([f"dive {k:04d}" for k in range(history)], size),
                "axis": [axis for axis, _ in QUANTITIES] * history,
                "quantity": [quantity for _, quantity in QUANTITIES] * history,
                "at_speed": np.tile([0.0, 1.0], history * size // 2),
                "estimate": (truth + error * rng.standard_normal(shape)).ravel(),
                "standard_error": (error * np.sqrt(rng.chisquare(FREEDOM, shape) / FREEDOM)).ravel(),
                "degrees_of_freedom": np.full(history * size, FREEDOM),
            })  # fmt: skip
            writer = writer or parquet.ParquetWriter(path, part.schema)
            writer.write_table(part)
        assert writer is not None
        writer.close()
        command = [sys.executable, "-m", "service.cli.command_line", "compare", str(path), "--json", str(found)]
        began = time.monotonic()
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        seconds, used = time.monotonic() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
        changes = json.loads(found.read_text(encoding="utf-8"))["changes"]
        megabytes = path.stat().st_size / 1e6
    true = {each["vehicle"] for each in changes if (each["axis"], each["quantity"]) == ("yaw", "drag")} & grown
    false = {each["vehicle"] for each in changes} - grown
    rows = [
        ("vehicles, dives, coefficients, size of the table", f"{vehicles}, {history}, {size}, {megabytes:.0f} MB"),
        ("time of the command, of which processor [s]", f"{seconds:.1f}, {used.ru_utime + used.ru_stime:.1f}"),
        ("most memory [MB]", f"{used.ru_maxrss / 1024:.0f}"),
        ("changed drags found", share(len(true), len(grown))),
        ("unchanged vehicles with a change reported", share(len(false), vehicles - len(grown))),
    ]
    return {"kind": "fleet", "rows": rows}


def report(results: Sequence[Record]) -> Iterator[str]:
    rows = []
    for kind, own in grouped(results, "kind").items():
        if kind == "fleet":
            continue
        changed, quiet = ([each for each in own if bool(each["axis"]) == grows] for grows in (True, False))
        right = sum([DIVES // 2, each["axis"], "drag"] in each["reported"] for each in changed)
        beside = sum(any(one[1:] != [each["axis"], "drag"] for one in each["reported"]) for each in changed)
        false = sum(bool(each["reported"]) for each in quiet)
        rows.append([kind, share(right, len(changed)), share(beside, len(changed)), share(false, len(quiet))])
    if rows:
        yield table(["vehicle", "changed drag found in its dive", "something else reported beside it",
                     "unchanged: a change reported"], rows)  # fmt: skip
    for each in results:
        if each["kind"] == "fleet":
            yield table(["a fleet from its table", "measured"], each["rows"])


def main(words: Sequence[str] | None = None) -> None:
    run("dives", __doc__, cases, examine, report, words, ("pyarrow",), first_seed=(3_100_000, "of the vehicles"),
        changed=(10, "vehicles of each kind whose drag grows"), quiet=(50, "vehicles of each kind that do not change"),
        seconds=(120.0, "length of a dive"), factor=(1.15, "of the drag that grows"),
        fleet=(1000, "vehicles of the fleet; 0 for none"), history=(1000, "dives of each of them"))  # fmt: skip


if __name__ == "__main__":
    main()
