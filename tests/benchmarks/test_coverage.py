"""The study of the bands: its judge, and a small one made with the real learner."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.learner.coverage import Run, judged, main, voyages
from incsvr.learning.learner import Settings
from simulator import leng
from tests.incsvr.learning import run


@pytest.fixture(scope="module")
def first() -> Run:
    return next(iter(voyages(3)))[0]


def test_the_judge_tells_a_wide_band_from_a_narrow_one_and_a_wrong_curve_from_a_right_one(first: Run) -> None:
    model = run(Settings(), first.training)[0].model
    samples, curve = judged(model, first)
    assert samples.min() > 0.85
    assert curve.min() > 0.7
    narrow, _ = judged(replace(model, sigma=0.1 * model.sigma), first)
    assert narrow.max() < 0.5
    _, wrong = judged(model, replace(first, truth=lambda rate: 3.0 * leng.damping(rate)))
    assert wrong[1:].max() < 0.2


def test_a_small_study_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--seeds", "2", "--first-seed", "5", "--out", str(tmp_path)]) == 0
    document = json.loads((tmp_path / "coverage.json").read_text(encoding="utf-8"))
    assert len(document["records"]) == 2 * 2 * 3
    assert all(np.nanmean(record["samples"]) > 0.8 for record in document["records"])
    text = (tmp_path / "coverage.md").read_text(encoding="utf-8")
    assert text == capsys.readouterr().out
    assert "| Leng, T1 | weighted |" in text
    assert document["command"] in text
