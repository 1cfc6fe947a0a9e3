"""The learner on a real bus: what it publishes, and to whom."""

from __future__ import annotations

import queue
from pathlib import Path

import numpy as np
import pytest

from incsvr.learning.model import Model
from service import wire
from service.recordings.recording import Recording, from_table
from service.recordings.recording_csv import write
from simulator import leng
from tests.service.conftest import PATIENCE, StartBench, Taught, cut


def test_every_iteration_is_published_with_its_sets_and_its_model(taught: Taught) -> None:
    bench = taught.bench
    for number, model, report in zip((1, 2, 3), taught.models, taught.reports, strict=True):
        assert (model.revision, model.iteration) == (report.revision, report.iteration) == (number, number)
        assert model.boot == report.boot == bench.host.node.boot
        assert model.t == report.t == report.time_span[1]
        assert report.counts["batch"] == len(report.batch.time) == 50
        for name in wire.SETS:
            assert len(getattr(report, name)) == report.counts[name]
        gone = report.counts["new"] + report.counts["discarded_tube"] + report.counts["discarded_near"]
        assert gone + report.counts["undriven"] == 50
        assert 0 < report.counts["support"] <= 60
        assert report.support.rate == model.support.rate
        assert model.model.certified_error <= 0.01
        assert report.training_ms > 0.0
        assert (report.progressive_mae is None) == (number == 1)
    assert {name for name in bench.health().counters if name.startswith("rejected")} == {"rejected"}


def test_the_textbooks_coefficients_are_a_key_of_their_own(taught: Taught) -> None:
    bench, newest = taught.bench, taught.coefficients[-1]
    assert newest.revision == 3
    payload, _ = bench.get(bench.keys.coefficients)
    assert payload is not None
    assert wire.decode(wire.Coefficients, payload) == newest
    linear, quadratic = (newest.coefficients[name] for name in ("N_r", "N_r|r|"))
    rate = np.linspace(-0.1, 0.1, 9)
    curve = bench.host.node.served.model.predict(rate).damping
    together = linear.estimate * rate + quadratic.estimate * rate * np.abs(rate)
    assert np.abs(together - curve).mean() < 0.1 * np.abs(curve).max()
    assert linear.low < linear.estimate < linear.high


def test_further_channels_are_kept_with_the_samples(start: StartBench, run: Recording) -> None:
    bench = start(signals__channels=["depth"])
    reports = bench.follow(bench.keys.iteration, wire.IterationReport)
    with_depth = from_table(run.name, run.time, {**run.columns, "depth": 5.0 + 0.01 * run.time})
    bench.play(with_depth)
    report = reports.get(timeout=PATIENCE)
    depth = np.array(report.batch.channels["depth"], dtype=float)
    np.testing.assert_allclose(depth, 5.0 + 0.01 * np.array(report.batch.time), atol=1e-6)
    assert bench.health_when(lambda health: health.streams["depth"].received > 0)


def test_validation_errors_come_with_every_iteration(start: StartBench, run: Recording, tmp_path: Path) -> None:
    write(tmp_path / "V1.csv", cut(leng.recording("V1", seed=7), 60.0))
    bench = start(validation={"V1": str(tmp_path / "V1.csv")})
    reports = bench.follow(bench.keys.iteration, wire.IterationReport)
    bench.play(run)
    for _ in range(3):
        report = reports.get(timeout=PATIENCE)
    (error,) = report.validation
    samples = leng.samples(cut(leng.recording("V1", seed=7), 60.0))
    model: Model = bench.host.node.served.model
    residual = model.predict(samples.yaw_rate).damping - samples.damping
    assert (error.name, error.samples) == ("V1", len(samples))
    assert error.mae == pytest.approx(np.mean(np.abs(residual)))
    assert error.rmse == pytest.approx(np.sqrt(np.mean(residual**2)))


def test_the_learner_says_goodbye(start: StartBench) -> None:
    bench = start()
    seen: queue.Queue[str] = queue.Queue()
    bench.session.liveliness().declare_subscriber(
        bench.keys.alive, lambda sample: seen.put(str(sample.kind)), history=True
    )
    assert "PUT" in seen.get(timeout=PATIENCE)
    bench.stop()
    assert "DELETE" in seen.get(timeout=PATIENCE)
