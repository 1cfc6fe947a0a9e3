"""The features that docs/configuration.md lets work together, all at once in one learner on a real session."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zenoh

from incsvr.errors import BadInput
from incsvr.plant.body import CORIOLIS
from incsvr.tracing.model import TracedModel
from service import wire
from service.bus.session import free_endpoint, listener_config_at, open_session
from service.export.command import in_format
from service.export.learned import of_snapshot
from service.host.host import Host
from service.learner.feedforward_reply import feedforward_reply
from service.learner.stand_in import forecast_reply
from service.recordings.recording import Recording, from_table
from service.recordings.recording_csv import write
from tests.hidden import trim
from tests.service.conftest import PATIENCE, configured, cut
from tests.whole_vehicle import LINEAR, QUADRATIC, whole_vehicle
from tests.whole_vehicle import MASS as COUPLED_MASS

MASS = np.array([60.0, 64.0, 0.0, 0.0, 0.0, 12.0])
"""M, diagonal, surge to yaw [kg], [kg m²]."""
BIAS = 0.5
"""The moment of the effect in the file [N m]."""


def traced(folder: Path) -> Path:
    """A trace of the vehicle in its body, with a constant moment."""
    rate = np.linspace(-1.0, 1.0, 61)
    damping = LINEAR[2] * rate + QUADRATIC[2] * rate * np.abs(rate)
    model = TracedModel(float(MASS[5]), rate, damping, (trim(BIAS),), 1.0, 0.3, 2.0, (0.0, 100.0))
    content = {
        "effects": [{"effect": "bias_torque", "parameters": {"moment_nm": BIAS}}],
        "model": model.to_dict(),
        "coupled": {"mass_matrix": np.diag(MASS).ravel().tolist()},
    }
    path = folder / "trace.json"
    path.write_text(json.dumps(content), encoding="utf-8")
    return path


def run() -> Recording:
    """A hundred seconds of a vehicle whose sway mass is little above its surge mass."""
    recording = whole_vehicle(910_000, 2000)
    columns = dict(recording.columns)
    coriolis = (COUPLED_MASS[1] - MASS[1]) * columns["surge"] * columns["sway"]
    return from_table(recording.name, recording.time, {**columns, "torque": columns["torque"] - coriolis})


def played(session: zenoh.Session, host: Host, recording: Recording) -> list[wire.IterationReport]:
    """What is published of all that was put on the learner's keys, ten seconds of each stream in a message."""
    reports: list[wire.IterationReport] = []

    def take(sample: zenoh.Sample) -> None:
        reports.append(wire.decode(wire.IterationReport, sample.payload.to_bytes()))

    session.declare_subscriber(host.keys.iteration, take)
    for start in np.arange(0.0, float(recording.time[-1]), 10.0).tolist():
        for name in ("yaw_rate", "torque", "surge", "sway"):
            t, value = recording.streams()[name]
            part = (t >= start) & (t < start + 10.0)
            payload = wire.measurement(tuple(t[part].tolist()), tuple(value[part].tolist()))
            session.put(host.keys.stream(name), payload, congestion_control=zenoh.CongestionControl.BLOCK)
        count, until = int(np.count_nonzero(recording.time < start + 10.0)), time.monotonic() + PATIENCE
        while min(stream.received for stream in host.watch.report(host.node).streams.values()) < count:
            host.feed.drain()
            assert time.monotonic() < until
        while host.learn():
            pass
    return reports


def test_all_that_work_together_at_once(tmp_path: Path) -> None:
    write(tmp_path / "V.csv", cut(run(), 40.0))
    settings: dict[str, Any] = {
        "vehicle__name": "rov", "vehicle__rate_limit": 5.0, "vehicle__rate_range": (-1.0, 1.0),
        "vehicle__mass_matrix": MASS.tolist(), "learner__batch": 20, "learner__epsilon": 0.5,
        "learner__policy": "weighted", "learner__inputs": ("yaw_rate", "surge", "sway"),
        "signals__torque": "measured", "signals__channels": ("surge", "sway"),
        "effects": str(traced(tmp_path)), "validation": {"V": str(tmp_path / "V.csv")},
        "archive__directory": str(tmp_path / "archive"),
    }  # fmt: skip
    with pytest.raises(BadInput, match="leave out either"):
        configured(**settings, tracing__live="advise")
    with open_session(listener_config_at(free_endpoint())) as session:
        host = Host(session, configured(**settings))
        reports, node = played(session, host, run()), host.node
        (reply,) = list(session.get(f"{host.keys.damping}?rate=0.1", timeout=PATIENCE))
        assert reply.ok is not None
        parts = reports[-1].batch.parts
        assert np.allclose(np.abs(parts["bias_torque"]), BIAS)
        assert float(np.std(parts[CORIOLIS])) > 0.1
        assert all(each.name == "V" and np.isfinite(each.rmse) for each in reports[-1].validation)
        snapshot = node.latest()
        assert snapshot is not None
        assert snapshot.to_dict()["over"]["inputs"] == ["yaw_rate", "surge", "sway"]
        exported = json.loads(in_format(of_snapshot(snapshot, "a test"), "json")[0])
        assert [each["effect"] for each in exported["effects"]] == ["bias_torque"]
        curve = snapshot.model.predict(exported["curve"]["rate"]).damping
        np.testing.assert_allclose(exported["curve"]["damping"], curve)
        forecast = forecast_reply(node, wire.ForecastQuery(t=(0.0, 10.0), torque=(4.0, 4.0)))
        assert np.isfinite(forecast.rate).all()
        planned: dict[str, tuple[float, ...]] = {"surge": (0.5, 0.5), "sway": (0.4, 0.4)}
        plan = feedforward_reply(node, wire.FeedforwardQuery(t=(0.0, 5.0), rate=(0.0, 0.2), channels=planned), {})
        shares = [plan.inertia_part, plan.body_part, plan.damping_part, plan.effects_part]
        np.testing.assert_allclose(plan.torque, np.sum(shares, axis=0))
        np.testing.assert_allclose(plan.body_part, (MASS[1] - MASS[0]) * 0.5 * 0.4)
        host.close()
    assert sum(path.stat().st_size for path in (tmp_path / "archive").glob("*.mcap")) > 10_000
