"""Validation data of the learner: any log that it can be told of, read once at the start."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from incsvr.errors import BadInput
from service.config.configuration import Config
from service.recordings.recording_csv import write
from service.recordings.validation import read_validation
from simulator import leng
from tests.service.conftest import cut

SOURCES = {"yaw_rate": {"topic": "rows", "field": "r", "unit": "deg/s"}, "torque": {"topic": "rows", "field": "tau"}}


def test_a_log_of_others_gives_the_same_samples(tmp_path: Path) -> None:
    """Semicolons, degrees and other names, which the configured inputs describe; our own needs no description."""
    run, config = cut(leng.recording("V1", seed=7), 60.0), Config.model_validate({"inputs": SOURCES})
    write(tmp_path / "V1.csv", run)
    degrees, torque = np.degrees(run.columns["yaw_rate"]), run.columns["torque"]
    rows = zip(run.time.tolist(), degrees.tolist(), torque.tolist(), strict=True)
    lines = (";".join("" if np.isnan(value) else f"{value:.17g}" for value in row) for row in rows)
    (tmp_path / "dive.csv").write_text("\n".join(("Time (s);r;tau", *lines)), encoding="utf-8")
    own, others = (read_validation(tmp_path / name, config) for name in ("V1.csv", "dive.csv"))
    assert len(own) == len(others) > 50
    np.testing.assert_allclose(others.damping, own.damping, rtol=1e-9)
    np.testing.assert_array_equal(own.damping, leng.samples(run).damping)


def test_what_is_no_log_or_lacks_a_channel_is_one_sentence(tmp_path: Path) -> None:
    run = cut(leng.recording("V1", seed=7), 60.0)
    write(tmp_path / "V1.csv", run)
    config = Config.model_validate({"learner": {"inputs": ["yaw_rate", "surge"]}})
    with pytest.raises(BadInput, match="no channel surge, which every sample needs"):
        read_validation(tmp_path / "V1.csv", config)
    with pytest.raises(BadInput, match="nowhere"):
        read_validation(tmp_path / "nowhere.csv", Config())
