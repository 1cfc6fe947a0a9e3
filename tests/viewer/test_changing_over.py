"""A learner that changes over to traced effects says its last batch again: it is drawn once, in one recording."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from rerun.chunk import RrdReader

from incsvr.tracing.model import TracedModel
from service.bus.session import free_endpoint, listener_config_at, open_session
from service.config.traced_effects import effects_from_trace
from service.learner.node import LearnerNode
from service.wire import IterationReport
from simulator import leng
from tests.hidden import recording, stage, write_trace
from tests.service.conftest import configured
from tests.viewer.conftest import KEYS
from tests.viewer.readback import verify
from viewer.bus import Questions, Streams
from viewer.compare import Choice
from viewer.follow import Follower, Recordings
from viewer.frame import Frame
from viewer.pages import blueprint
from viewer.recorder import Recorder
from viewer.recording import Recording


@pytest.fixture(scope="module")
def reports(tmp_path_factory: pytest.TempPathFactory) -> list[IterationReport]:
    """Three batches, two change-overs to effects, one after the other, and one batch more.

    The second looks ahead: the last of the newest samples are not complete yet when they are learned again.
    """
    path = tmp_path_factory.mktemp("traced") / "trace.json"
    write_trace(path)
    found = json.loads(path.read_text(encoding="utf-8"))
    model = TracedModel.from_dict(found["model"])
    effects = (*model.effects, stage("torque_delay", "shift", -0.8))
    late = found | {"model": replace(model, effects=effects).to_dict()}
    node = LearnerNode(configured(tracing__live=True), boot="a test")
    streams = recording(3, 130.0).streams()
    for name, (t, value) in streams.items():
        node.push(name, t[t < 90.7], value[t < 90.7])
    told = []
    while (outcome := node.learn()) is not None:
        told.append(outcome.report)
    for each in (found, late):
        again = node.relearn(effects_from_trace(each["model"], each["effects"], leng.INERTIA, (), "a test"), {})
        assert again is not None
        told.append(again.report)
    for name, (t, value) in streams.items():
        node.push(name, t[t >= 90.7], value[t >= 90.7])
    last = node.learn()
    assert last is not None
    return [*told, last.report]


def test_the_learner_says_it_again_and_ends_earlier(reports: list[IterationReport]) -> None:
    assert [report.iteration for report in reports] == [1, 2, 3, 4, 5, 6]
    assert reports[3].batch.time == reports[2].batch.time
    assert reports[4].t < reports[3].t
    assert set(reports[4].batch.time) & set(reports[3].batch.time)


def test_every_sample_is_drawn_once_and_the_recording_goes_on(reports: list[IterationReport], tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    recordings = Recordings(path, lambda each: Recording(Recorder(blueprint(), path=each), Choice(), rate=0.25))
    with open_session(listener_config_at(free_endpoint())) as session:
        follower = Follower(Questions(session, KEYS), Streams(session, KEYS), recordings)
        for report in reports:
            follower.show(Frame(report, None, None))
    assert recordings.close()
    assert [each.name for each in tmp_path.glob("*.rrd")] == ["run.rrd"]
    verify(path)
    (entry,) = RrdReader(str(path)).recordings()
    drawn: dict[str, Counter[int]] = {}  # entity → how often each instant [ms]
    for chunk in RrdReader(str(path)).stream(store=entry).filter(has_timeline="vehicle_time"):
        if chunk.entity_path.startswith(("/signals/damping", "/signals/residual", "/signals/yaw_rate", "/effects")):
            times = chunk.to_record_batch().column("vehicle_time").cast("int64").to_pylist()
            drawn.setdefault(chunk.entity_path, Counter()).update(round(at / 1e6) for at in times)
    known = {round(1e3 * t) for report in reports for t in report.batch.time}
    assert set(drawn["/signals/damping/synchronised"]) == known
    split = {round(1e3 * t) for report in (reports[3], reports[5]) for t in report.batch.time}
    assert set(drawn["/effects/torque/measured"]) == set(drawn["/effects/parts/torque_lag"]) == split
    assert {path: max(times.values()) for path, times in drawn.items() if path != "/effects/ledger"} == dict.fromkeys(
        drawn.keys() - {"/effects/ledger"}, 1
    )
