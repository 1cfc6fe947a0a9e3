"""The page Slices of a learner over several velocities; and that a closed recording opens with its newest pages."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader

from service.config.sources import read
from service.learner.node import LearnerNode
from service.wire import IterationReport, Measurement, ModelSnapshot
from tests.viewer.conftest import Run
from tests.viewer.readback import points, rows, shown
from tests.viewer.test_recording import record
from tests.worlds import planar
from viewer import archive
from viewer.compare import Choice
from viewer.frame import Frame
from viewer.newest_pages import superseded
from viewer.pages import PAGES, blueprint
from viewer.palette import DARK
from viewer.recorder import Recorder, new_recording
from viewer.recording_pages import RecordingPages
from viewer.slices import SLICE_QUANTILES

Iterations = list[tuple[IterationReport, ModelSnapshot]]


@pytest.fixture(scope="module")
def iterations() -> Iterations:
    """A simulated vehicle whose damping couples yaw with surge and sway, through the learner's own node."""
    inputs = ["yaw_rate", "surge", "sway"]
    node = LearnerNode(read(None, {"state": None, "learner": {"inputs": inputs, "policy": "weighted"}}), "a test")
    for name, (t, value) in planar(910110, 100.0, usual=True).streams().items():
        node.push(name, t, value)
    found = []
    while (outcome := node.learn()) is not None:
        found.append((outcome.report, outcome.snapshot))
    assert len(found) == 3
    return found


@pytest.fixture(scope="module")
def recorded(iterations: Iterations, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Closed as a set of recordings closes it: laid out three times, and joined."""
    path = tmp_path_factory.mktemp("slices") / "planar.rrd"
    recorder = Recorder(new_recording(), blueprint(DARK, Choice()), path=path)
    pages = RecordingPages(recorder, DARK, Choice(), rate=0.25)
    for name in ("depth", "voltage"):
        pages.measured(name, Measurement(t=(0.0, 1.0), value=(1.0, 2.0)), time.time())
        assert pages.flush()
    for report, snapshot in iterations:
        pages.iteration(Frame(report, snapshot, time.time()))
        assert pages.flush()
    recorder.close()
    assert len(superseded([path])) >= 3
    archive.optimise([path], path)
    archive.verify(path)
    return path


def test_where_it_was_driven_is_there_with_the_learners_numbers(iterations: Iterations, recorded: Path) -> None:
    logged = rows(recorded, "Points2D:positions")
    for report, snapshot in iterations:
        for number, name in enumerate(("surge", "sway")):
            vectors = points(shown(logged[f"/learning/slices/{number}/vectors"], report.iteration))
            expected = np.column_stack((snapshot.support.rate, snapshot.support.others[name]))
            assert np.array_equal(vectors, expected.astype(np.float32))
            batch = points(shown(logged[f"/learning/slices/{number}/batch"], report.iteration))
            assert np.array_equal(batch[:, 1], np.array(report.batch.channels[name], dtype=np.float32))


def test_the_slices_are_the_served_model(iterations: Iterations, recorded: Path) -> None:
    report, snapshot = iterations[-1]
    model, logged = snapshot.model(), rows(recorded, "LineStrips2D:strips")
    assert model.several is not None
    seen = 0
    for number, name in enumerate(("surge", "sway")):
        for k, share in enumerate(SLICE_QUANTILES):
            strips = shown(logged[f"/learning/slices/{number}/curve_{k}"], report.iteration)
            for strip in map(np.array, strips):
                velocity = model.several.beside(strip[:, 0].astype(np.float64))
                at = float(np.quantile(snapshot.support.others[name], share))
                velocity[:, 1 + number] = at
                said = model.over(velocity)
                largest = np.abs(np.array(snapshot.support.damping)).max()
                assert np.abs(said.damping - strip[:, 1]).max() < 0.06 * largest  # the legend's value is rounded
                seen += len(strip)
    assert seen > 100


def test_a_closed_recording_has_its_newest_pages_alone(recorded: Path) -> None:
    reader = RrdReader(str(recorded))
    (pages,) = reader.blueprints()
    assert not superseded([recorded])
    named = {
        name
        for chunk in reader.stream(store=pages)
        for column in chunk.to_record_batch().schema.names
        if column.endswith(":display_name")
        for row in chunk.to_record_batch().column(column).to_pylist()
        for name in row or ()
    }
    assert {*PAGES, "Where it was driven: Surge [m/s]", "Voltage [V]"} <= named


def test_a_recording_that_was_cut_off_is_joined_with_the_next(recorded: Path, run: Run, tmp_path: Path) -> None:
    cut, whole, out = tmp_path / "cut.rrd", tmp_path / "whole.rrd", tmp_path / "out.rrd"
    record(run, whole, Choice())
    cut.write_bytes(recorded.read_bytes()[:-7000])
    archive.optimise([cut, whole], out)
    reader = RrdReader(str(out))
    assert len(reader.blueprints()) == 1
    assert len(reader.recordings()) == 2
    assert sorted(path.name for path in tmp_path.iterdir()) == ["cut.rrd", "out.rrd", "whole.rrd"]


def test_of_one_velocity_there_is_no_such_page(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "one.rrd"
    record(run, path, Choice())
    assert not any(entity.startswith("/learning/slices") for entity in rows(path, "Points2D:positions"))
    assert PAGES[-1] == "Slices"
