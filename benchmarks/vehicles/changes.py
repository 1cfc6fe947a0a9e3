"""Dives of a simulated vehicle compared: how often a changed drag is found, and how often one is told falsely."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.study import begin, in_processes, options
from benchmarks.tables import page, share, table
from incsvr.vehicle import compare, on_grid
from simulator.dive_log import dives
from simulator.vehicles import BODIES, NAMES

DIVES = 4
"""Dives of each vehicle; in half of the vehicles the drag of one axis changes after the second."""


def compared(case: tuple[str, int, float, float]) -> dict[str, Any]:
    """One vehicle: the changes that were told, as (dive, axis, quantity)."""
    kind, seed, seconds, factor = case
    rng = np.random.default_rng(seed)
    body = BODIES[kind](rng)
    axis = str(rng.choice(list(body.effort)))
    more = np.where(np.array(NAMES) == axis, factor, 1.0)
    later = replace(body, linear=body.linear * more, quadratic=body.quadratic * more)
    logs = dives([body if k < DIVES // 2 else later for k in range(DIVES)], seconds, seed)
    step = on_grid(logs).step
    found = compare([on_grid([log], step) for log in logs], [str(k) for k in range(DIVES)])
    told = [(int(dive), quantity.axis, quantity.kind) for dive, quantity, _ in found.changes]
    return {"kind": kind, "axis": axis if factor != 1.0 else None, "told": told}


def main(words: Sequence[str] | None = None) -> int:
    parser = options(
        "benchmarks.vehicles.changes", __doc__ or "", first_seed=(3_100_000, "first seed"),
        each=(10, "vehicles of each kind that change"), quiet=(50, "vehicles of each kind that do not"),
        seconds=(120.0, "length of a dive [s]"),
        factor=(1.15, "of the drag that changes"), processes=(2, "processes"),
    )  # fmt: skip
    args, when = begin(parser, words)
    kinds = ("torpedo", "boat")
    cases = [
        (kind, args.first_seed + 1000 * column + k, args.seconds, factor)
        for kind in kinds for column, (factor, count) in enumerate(((args.factor, args.each), (1.0, args.quiet)))
        for k in range(count)
    ]  # fmt: skip
    drawn = in_processes(compared, cases, "vehicles", args.processes)
    rows = []
    for kind in kinds:
        changed = [each for each in drawn if each["kind"] == kind and each["axis"]]
        quiet = [each for each in drawn if each["kind"] == kind and not each["axis"]]
        right = sum((DIVES // 2, each["axis"], "drag") in each["told"] for each in changed)
        beside = sum(any(told[1:] != (each["axis"], "drag") for told in each["told"]) for each in changed)
        false = sum(bool(each["told"]) for each in quiet)
        rows.append([kind, f"{share(right, len(changed))} of {len(changed)}", f"{beside} of {len(changed)}",
                     f"{share(false, len(quiet))} of {len(quiet)}"])  # fmt: skip
    text = page(
        "# Dives compared",
        f"Made by `{when['command']}` on {when['date']}, {when['processor']}.",
        f"{DIVES} dives of {args.seconds:g} s; from the third on a changed drag is {args.factor:g} times as large.",
        table(["vehicle", "changed drag told in its dive", "something else told beside it", "unchanged: told"], rows),
    )
    (args.out / "dives_compared.md").write_text(text, encoding="utf-8")
    print(text, end="")
    return 0


if __name__ == "__main__":
    sys.exit(main())
