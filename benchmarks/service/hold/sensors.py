"""Sensors that fail: the faults of benchmarks/learner/sensor_faults.py, as rows of this table."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from benchmarks.learner import sensor_scenarios as scenarios
from benchmarks.learner.sensor_cases import judged
from benchmarks.learner.sensor_faults import FIRST_SEED, cases
from benchmarks.service.hold.row import Row
from incsvr.learning.learner import Settings

REMARK = (
    "with and without a heading, outliers and a hull; what is served was beyond 1.5 times the error without a fault; "
    "never named counts as wrong; time of the data until it is named"
)


def sensors(seeds: int, seed: int) -> list[Row]:
    """A row for each fault, of voyages with seeds of the published table's kind."""
    policy, first = Settings().policy, FIRST_SEED + seed
    return list(rows([judged(case, policy) for case in cases(range(first, first + seeds))]))


def rows(records: Sequence[dict[str, Any]]) -> Iterator[Row]:
    """The rows of what `judged` gave."""
    for fault in scenarios.FAULTS:
        mine = [record for record in records if record["fault"] == fault]
        named = [record["named_after"] for record in mine if record["named_after"] is not None]
        harmed = sum(not record["right"] for record in mine)
        yield Row(f"a sensor: {fault}", len(mine), harmed, len(mine) - len(named), named, REMARK)
