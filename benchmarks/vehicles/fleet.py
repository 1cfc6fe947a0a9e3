"""A fleet's history compared from its stored coefficients: `incsvr compare` on one table of all dives of all vehicles.

The table is simulated: each coefficient scatters about its truth by its standard error; in some of the vehicles a drag
grows after half of the dives. Time and memory are those of the command, a process of its own.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.study import begin, options
from benchmarks.tables import page, share, table

QUANTITIES = tuple((axis, quantity) for axis in ("surge", "sway", "yaw") for quantity in ("inertia", "drag"))
CHANGED_SHARE = 0.1
"""Part of the vehicles whose yaw drag grows."""
ERROR_SHARE = 0.01
"""Usual standard error, in the coefficient: what drags of simulated dives of two to four minutes have."""
FREEDOM = 12.0
"""Degrees of freedom of the standard errors."""


def write_fleet(path: Path, vehicles: int, dives: int, factor: float, seed: int) -> None:
    """Writes the table of a fleet, one vehicle after the other."""
    import pyarrow as arrow
    from pyarrow import parquet

    rng, size = np.random.default_rng(seed), len(QUANTITIES)
    each = dives * size
    dive = arrow.array([f"dive {k:04d}" for k in range(dives)])
    named = arrow.array(np.repeat(np.arange(dives), size).astype(np.int32))
    axes, kinds = (arrow.array([pair[k] for pair in QUANTITIES] * dives) for k in (0, 1))
    writer = None
    for vehicle in range(vehicles):
        truth = np.tile(rng.uniform(5.0, 50.0, size), (dives, 1))
        if vehicle < CHANGED_SHARE * vehicles:
            truth[dives // 2 :, -1] *= factor
        error = truth * ERROR_SHARE * rng.uniform(0.5, 2.0, truth.shape)
        estimate = truth + error * rng.standard_normal(truth.shape)
        shown = error * np.sqrt(rng.chisquare(FREEDOM, truth.shape) / FREEDOM)
        columns: dict[str, Any] = {
            "vehicle": arrow.array([f"vehicle {vehicle:04d}"] * each), "dive": dive.take(named), "axis": axes,
            "quantity": kinds, "at_speed": np.tile([0.0, 1.0], each // 2), "estimate": estimate.ravel(),
            "standard_error": shown.ravel(), "degrees_of_freedom": np.full(each, FREEDOM),
        }  # fmt: skip
        part = arrow.table(columns)
        writer = parquet.ParquetWriter(path, part.schema) if writer is None else writer
        writer.write_table(part)
    if writer is not None:
        writer.close()


def main(words: Sequence[str] | None = None) -> int:
    parser = options(
        "benchmarks.vehicles.fleet", __doc__ or "", seed=(3_460_000, "seed"), vehicles=(1000, "vehicles"),
        dives=(1000, "dives of each"), factor=(1.15, "by which a drag grows"),
    )  # fmt: skip
    args, when = begin(parser, words, "pyarrow")
    with tempfile.TemporaryDirectory() as folder:
        history, found, told = Path(folder) / "fleet.parquet", Path(folder) / "out.parquet", Path(folder) / "out.json"
        write_fleet(history, args.vehicles, args.dives, args.factor, args.seed)
        megabytes = history.stat().st_size / 1e6
        command = [sys.executable, "-m", "service.cli.command_line", "compare", str(history)]
        begun = time.monotonic()
        subprocess.run([*command, "--table", str(found), "--json", str(told)], check=True, stdout=subprocess.DEVNULL)
        seconds, used = time.monotonic() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
        changes = json.loads(told.read_text(encoding="utf-8"))["changes"]
    grown = {f"vehicle {k:04d}" for k in range(args.vehicles) if k < CHANGED_SHARE * args.vehicles}
    true = {each["vehicle"] for each in changes if (each["axis"], each["quantity"]) == ("yaw", "drag")} & grown
    at_once = {each["vehicle"] for each in changes if each["dive"] == f"dive {args.dives // 2:04d}"} & true
    false = {each["vehicle"] for each in changes if each["vehicle"] not in grown}
    quiet = args.vehicles - len(grown)
    text = page(
        "# A fleet compared from its table",
        f"Made by `{when['command']}` on {when['date']}, {when['processor']}, load {when['load_before']:.1f}.",
        f"{args.vehicles} vehicles of {args.dives} dives and {len(QUANTITIES)} coefficients: {megabytes:.0f} MB; in "
        f"{len(grown)} vehicles the yaw drag is {args.factor:g} times as large in the second half.",
        table(
            ["what", "measured"],
            [
                ["time of the command [s]", f"{seconds:.1f}"],
                ["of which processor [s]", f"{used.ru_utime + used.ru_stime:.1f}"],
                ["most memory [MB]", f"{used.ru_maxrss / 1024:.0f}"],
                ["changed drags found", f"{share(len(true), len(grown))} of {len(grown)}"],
                ["of which in the dive of the change", str(len(at_once))],
                ["unchanged vehicles with a change reported", f"{share(len(false), quiet)} of {quiet}"],
            ],
        ),
    )
    (args.out / "fleet_compared.md").write_text(text, encoding="utf-8")
    print(text, end="")
    return 0


if __name__ == "__main__":
    sys.exit(main())
