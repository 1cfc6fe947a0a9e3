"""The study of troubles: its judge, its logs, and one kind made with the real command."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.tracer.trouble import KINDS, examine, judged, played, report


@pytest.mark.parametrize(
    ("truth", "record", "verdict"),
    [
        ("gyro_bias", {"named": {"gyro_bias": []}, "verdict": "effects", "said": []}, "right"),
        ("gyro_bias", {"named": {"bias_torque": ["gyro_bias"]}, "verdict": "effects", "said": []}, "class"),
        ("gyro_bias", {"named": {"gyro_bias": [], "inertia": []}, "verdict": "effects", "said": []}, "false"),
        ("", {"named": {"inertia": []}, "verdict": "effects", "said": ["the gyro is stuck"]}, "said"),
        ("", {"named": {}, "verdict": "unexplained", "said": []}, "said"),
        ("", {"named": {}, "verdict": "none", "said": []}, "none"),
    ],
)
def test_the_judge(truth: str, record: dict[str, object], verdict: str) -> None:
    assert judged(truth, record) == verdict


def test_a_seed_gives_the_same_log_and_a_fault_shows_in_it() -> None:
    kind = "A4 a gyro that stands still for 30 s"
    log, again, other = played(kind, 1), played(kind, 1), played("clean", 1)
    np.testing.assert_array_equal(log.columns["yaw_rate"], again.columns["yaw_rate"])
    still = np.diff(log.columns["yaw_rate"]) == 0.0
    assert 590 <= np.count_nonzero(still) <= 610
    assert np.count_nonzero(np.diff(other.columns["yaw_rate"]) == 0.0) == 0
    assert len(KINDS) == 10


def test_what_the_command_says_of_a_log_is_judged() -> None:
    record = examine(("A4 a gyro that stands still for 30 s", 1))
    assert record["judged"] == "said"
    assert "stands still" in record["said"][0]
    document = {"command": "x", "date": "today", "processor": "y", "first_seed": 1, "seeds": 1, "records": [record]}
    assert "| A4 a gyro that stands still for 30 s | 0 | 0 | 1 | 0 | 0 | – |" in report(document)
