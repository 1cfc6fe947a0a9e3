"""`inspect` prints what the log holds in the log's unit, and beside it what is used in SI: for every kind of field."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from service.cli.command_line import main
from service.inputs.units import FACTORS, SI_UNITS

PLACES = {
    "yaw_rate": ("spin [deg/s]", "deg/s", -np.pi / 180.0, "rad/s"),
    "torque": ("tau", "fraction", 12.0, "N m"),
    "heading": ("hdg", "deg", np.pi / 180.0, "rad"),
    "depth": ("raw", "", 0.01, "m"),
    **{f"field_{k}": (f"c{k}", unit, FACTORS[unit], SI_UNITS[unit]) for k, unit in enumerate(FACTORS)},
}
"""Quantity → column, the unit of its numbers (empty: not known), SI over these numbers, the SI unit."""
COLUMNS = (
    "yaw_rate=-spin [deg/s]:deg/s", "torque=tau*12:fraction", "heading=hdg:deg", "depth=raw*0.01",
    *(f"field_{k}=c{k}{f':{unit}' if unit else ''}" for k, unit in enumerate(FACTORS)),
)  # fmt: skip
QUANTITY = re.compile(
    r"^  (\S+) +(?:rows\.)?.*?(?: \[([^]]*)\])?  [\d.]+ Hz, (\S+) to (\S+)(?:\n +× (\S+) = (\S+) to (\S+) ?(.*))?$",
    re.MULTILINE,
)


def test_value_unit_and_label_are_of_one_stage(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log, time, random = tmp_path / "log.csv", 0.05 * np.arange(200), np.random.default_rng(1)
    held = {column: 90.0 * random.random(time.size) + 1.0 for column, *_ in PLACES.values()}
    rows = zip(time, *held.values(), strict=True)
    log.write_text("\n".join([",".join(("t", *held)), *(",".join(map(str, row)) for row in rows)]), encoding="utf-8")
    flags = [word for column in COLUMNS for word in ("--column", column)]
    assert main(["inspect", str(log), *flags, "--json", "-"]) == 0
    measured = json.loads(capsys.readouterr().out)["measured"]
    assert main(["inspect", str(log), *flags]) == 0
    printed = {name: rest for name, *rest in QUANTITY.findall(capsys.readouterr().out)}
    assert printed.keys() == measured.keys() == PLACES.keys()
    for name, (column, unit, factor, si) in PLACES.items():
        ends = np.array([held[column].min(), held[column].max()])
        used = np.sort(factor * ends)
        said_unit, low, high, said_factor, used_low, used_high, used_unit = printed[name]
        assert said_unit == unit
        assert [float(low), float(high)] == pytest.approx(ends, rel=1e-4)
        assert [measured[name][end] for end in ("low", "high")] == pytest.approx(used)
        assert measured[name]["unit"] == si
        if factor != 1.0:
            assert float(said_factor) == pytest.approx(factor, rel=1e-4)
            assert [float(used_low), float(used_high)] == pytest.approx(used, rel=1e-4)
            assert used_unit == si
