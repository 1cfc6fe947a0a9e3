"""The logs that come along are what their script makes, and sound."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest

import incsvr
from incsvr.plant.axes import YAW
from service.recordings.reading import read
from tests.conftest import ROOT

LOGS = ROOT / "docs" / "logs"


@pytest.mark.parametrize("path", sorted(LOGS.glob("*.csv")), ids=lambda path: path.name)
def test_a_log_is_what_its_script_makes(path: Path) -> None:
    made = runpy.run_path(str(LOGS / "make.py"))["log"](path.name)
    kept = read(path)
    assert kept.time == pytest.approx(made.time, abs=1e-9)
    assert float(np.ptp(kept.time)) == pytest.approx(60.0, abs=0.1)
    for name in (YAW.rate, YAW.effort):
        assert kept.columns[name] == pytest.approx(made.columns[name], abs=2e-5)


@pytest.mark.parametrize("path", sorted(LOGS.glob("*.csv")), ids=lambda path: path.name)
def test_no_sensor_of_a_log_is_blamed(path: Path) -> None:
    """Its reverse thrust is weak; neither stream is wrong, nor a clock."""
    remarks = incsvr.fit(path, inertia=0.6).to_dict()["remarks"]
    assert [each for each in remarks if "late" in each or "put aside" in each or "check" in each] == []
