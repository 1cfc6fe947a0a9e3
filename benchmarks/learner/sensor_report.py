"""The tables of the sensors that fail, for people."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from benchmarks.learner import sensor_scenarios as scenarios
from benchmarks.tables import table

Record = dict[str, Any]
HEAD = ["fault", "right", "named after s: median, worst", "as", "paused", "error / control: worst", "at the end"]
DAYS = ["", "false pauses", "of the time", "said, in pieces of 5 s", "mean error N m", "processor s"]


class Limits(NamedTuple):
    """By what a case is right: how long a fault lasts and is watched afterwards [s], until when it is to be named [s],
    and how many times the control's error is allowed."""

    lasts: float
    after: float
    soon: float
    allowed: float


def markdown(found: Record, limits: Limits) -> str:
    """Of all that was tried."""
    control = np.mean([record["control"] for record in found["faults"]])
    parts = [
        "# Sensors that fail",
        f"`{found['command']}`, {found['date']}, {found['processor']}. Fresh seeds from {found['first_seed']} on.",
        f"Each fault lasts {limits.lasts:.0f} s from within a batch; with and without a heading, alone and with 2 % "
        f"outliers and the hull in the middle of it. Right: named within {limits.soon:.0f} s, and at every look either "
        f"paused or of at most {limits.allowed:g} times the control's largest error ({control:.2f} N m over "
        f"±0.22 rad/s), at the end of {limits.after:.0f} s after it as well. What no two streams tell from a changed "
        "vehicle is to be named alone.",
    ]
    for policy in found["policies"]:
        mine = [record for record in found["faults"] if record["policy"] == policy]
        right = sum(record["right"] for record in mine)
        parts += [f"## Policy {policy}: {right} of {len(mine)} right", table(HEAD, _by_fault(mine))]
    pauses = sum(record["paused_batches"] for record in found["paper"])
    parts += [
        "## Nothing fails",
        "Hull on and off every two hours, drop-outs, 2 % outliers, swell, 40 minutes of straight driving:",
        table(DAYS, [_day(record) for record in found["days"]]),
        f"The paper's experiment, {len(found['paper'])} runs of both policies: {pauses} batches put aside.",
    ]
    return "\n\n".join(parts) + "\n"


def _by_fault(all_of_them: Sequence[Record]) -> list[list[str]]:
    rows = []
    for fault in dict.fromkeys(record["fault"] for record in all_of_them):
        records = [record for record in all_of_them if record["fault"] == fault]
        named = [record["named_after"] for record in records]
        changes = scenarios.FAULTS[fault].changes_vehicle
        rows.append(
            [
                fault,
                f"{sum(record['right'] for record in records)} of {len(records)}",
                "never" if None in named else f"{np.median(named):.0f}, {max(named):.0f}",
                ", ".join(sorted({kind for record in records for kind in record["kinds"]})),
                f"{100 * np.mean([record['paused'] for record in records]):.0f} %",
                "learned" if changes else f"{max(record['worst_while_learning'] for record in records):.2f}",
                f"{max(record['at_end'] or 0.0 for record in records):.2f}",
            ]
        )
    return rows


def _day(record: Record) -> list[str]:
    return [
        f"{record['policy']}, {record['hours']:g} h, seed {record['seed']}{', heading' * record['heading']}",
        str(record["false_pauses"]),
        f"{100 * record['paused']:.1f} %",
        ", ".join(f"{kind} {count}" for kind, count in record["said"].items()),
        f"{record['error']:.2f}",
        f"{record['processor_s']:.0f}",
    ]
