"""Each pair of features in a real learner on a real session: it learns and answers, or `config check` says why not.

docs/live.md names the features, and the pairs that do not work together.
"""

from __future__ import annotations

import json
import re
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations_with_replacement
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zenoh

from incsvr.effects import Term
from incsvr.errors import BadInput
from incsvr.plant.body import CORIOLIS
from incsvr.tracing.model import TracedModel
from service import wire
from service.bus.session import free_endpoint, listener_config_at, open_session
from service.config.configuration import Config
from service.export.command import in_format
from service.export.learned import of_snapshot
from service.host.host import Host
from service.learner.estimates import estimate, forecast_reply
from service.learner.feedforward_reply import feedforward_reply
from service.recordings.recording import Recording
from service.recordings.recording_csv import write
from tests.service.conftest import PATIENCE, configured, cut
from tests.whole_vehicle import LINEAR, QUADRATIC, whole_vehicle
from tests.whole_vehicle import MASS as COUPLED_MASS

PAGE = Path(__file__).resolve().parents[3] / "docs" / "live.md"
MASS = np.array([60.0, 64.0, 0.0, 0.0, 0.0, 12.0])
"""M, diagonal, surge to yaw [kg], [kg m²]."""
BIAS = 0.5
"""The moment of the effect in the file [N m]."""
BASE: dict[str, Any] = {
    "vehicle__name": "rov",
    "vehicle__rate_limit": 5.0,
    "vehicle__rate_range": (-1.0, 1.0),
    "vehicle__inertia": float(MASS[5]),
    "learner__batch": 20,
    "learner__epsilon": 0.5,
    "signals__torque": "measured",
    "signals__channels": ("surge", "sway"),
}
SHORT_S, LONG_S, CHANGED_S = 100.0, 340.0, 220.0
"""Lengths of a run, and when the damping of the long one doubles [s]."""


@dataclass(frozen=True)
class Outcome:
    """What a learner with two features came to."""

    host: Host
    reports: list[wire.IterationReport]
    folder: Path


def traced(folder: Path, mass: bool) -> Path:
    """A trace of the vehicle with a constant moment, of the axis in its body or by itself."""
    rate = np.linspace(-1.0, 1.0, 61)
    damping = LINEAR[2] * rate + QUADRATIC[2] * rate * np.abs(rate)
    model = TracedModel(float(MASS[5]), rate, damping, (Term("bias_torque", "", (BIAS,)),), 1.0, 0.3, 2.0, (0.0, 100.0))
    content: dict[str, Any] = {
        "effects": [{"effect": "bias_torque", "parameters": {"moment_nm": BIAS}}],
        "model": model.to_dict(),
    }
    if mass:
        content["coupled"] = {"mass_matrix": np.diag(MASS).ravel().tolist()}
    path = folder / "trace.json"
    path.write_text(json.dumps(content), encoding="utf-8")
    return path


@cache
def run(duration: float) -> Recording:
    """A vehicle whose sway mass is little above its surge mass, so that the axis may also be taken by itself; in the
    long run its damping in yaw is doubled from CHANGED_S on."""
    recording = whole_vehicle(910_000, round(duration / 0.05))
    columns, late = dict(recording.columns), recording.time >= CHANGED_S
    rate = columns["yaw_rate"]
    more = np.where(late, LINEAR[2] * rate + QUADRATIC[2] * rate * np.abs(rate), 0.0)
    coriolis = (COUPLED_MASS[1] - MASS[1]) * columns["surge"] * columns["sway"]
    columns["torque"] = columns["torque"] + more - coriolis
    return replace(recording, columns=columns)


def tracing_began(outcome: Outcome) -> bool:
    return outcome.host.node.ledger.work == "trace" or bool(outcome.host.node.ledger.history)


def effects_are_in_force(outcome: Outcome) -> bool:
    (model,) = {effect["effect"] for effect in outcome.host.node.served.effects}
    return model == "bias_torque" and np.allclose(np.abs(outcome.reports[-1].batch.parts["bias_torque"]), BIAS)


def forecasts(outcome: Outcome) -> bool:
    reply = forecast_reply(outcome.host.node, wire.ForecastQuery(t=(0.0, 10.0), torque=(4.0, 4.0)))
    return bool(np.isfinite(reply.rate).all()) and estimate(outcome.host.node, 3.0) is not None


def is_over_several(outcome: Outcome) -> bool:
    snapshot = outcome.host.node.latest()
    over = None if snapshot is None else snapshot.over
    return over is not None and over.inputs == ("yaw_rate", "surge", "sway")


def has_coriolis(outcome: Outcome) -> bool:
    return float(np.std(outcome.reports[-1].batch.parts[CORIOLIS])) > 0.1


def drives_a_plan(outcome: Outcome) -> bool:
    """Whether the parts of the answer add up to its torque, with what planned velocities of the body take of it, and it
    says at which values it holds those that are not planned."""
    config, plan = outcome.host.node.config, wire.FeedforwardQuery(t=(0.0, 5.0), rate=(0.0, 0.2))
    body = config.coupled()
    needs = {*config.further_inputs, *(() if body is None else body.streams)}
    held = feedforward_reply(outcome.host.node, plan, {})
    planned = plan.model_copy(update={"channels": {"surge": (0.5, 0.5), "sway": (0.4, 0.4)}})
    reply = feedforward_reply(outcome.host.node, planned, {})
    parts = np.sum([reply.inertia_part, reply.body_part, reply.damping_part, reply.effects_part], axis=0)
    taken = 0.0 if body is None else (MASS[1] - MASS[0]) * 0.5 * 0.4
    return (
        np.allclose(reply.torque, parts)
        and np.allclose(reply.body_part, taken)
        and {said.split()[0] for said in held.told if "held at" in said} == needs
        and (held.torque == reply.torque) == (not needs)
    )


def is_exported(outcome: Outcome) -> bool:
    """Whether the exported curve is the served one, with the effects in force."""
    snapshot = outcome.host.node.latest()
    assert snapshot is not None
    exported = json.loads(in_format(of_snapshot(snapshot, "a test"), "json")[0])
    curve = np.array(snapshot.model().predict(exported["curve"]["rate"]).damping)
    effects = [str(effect["effect"]) for effect in snapshot.effects]
    return np.allclose(exported["curve"]["damping"], curve) and [e["effect"] for e in exported["effects"]] == effects


def is_archived(outcome: Outcome) -> bool:
    return sum(path.stat().st_size for path in (outcome.folder / "archive").glob("*.mcap")) > 10_000


def is_validated(outcome: Outcome) -> bool:
    return all(each.name == "V" and np.isfinite(each.rmse) for each in outcome.reports[-1].validation)


def change_is_noticed(outcome: Outcome) -> bool:
    """Whether the policy says it, or, over several velocities, the checks do while learning goes on."""
    if outcome.host.node.served.model.several is not None:
        warned = outcome.host.node.current_warnings
        return warned.change is not None and "changed by +" in warned.change[1] and warned.paused is None
    return any("the damping has changed" in str(report.change) for report in outcome.reports if report.t > CHANGED_S)


Settings = Callable[[Path], dict[str, Any]]
FEATURES: dict[str, tuple[Settings, Callable[[Outcome], bool]]] = {
    "live tracing": (
        lambda folder: {"tracing__live": "advise", "tracing__window": 60.0, "tracing__proof": 20.0},
        tracing_began,
    ),
    "effects from a file": (lambda folder: {"effects": folder / "trace.json"}, effects_are_in_force),
    "forecast": (lambda folder: {}, forecasts),
    "several velocities": (lambda folder: {"learner__inputs": ("yaw_rate", "surge", "sway")}, is_over_several),
    "mass matrix": (lambda folder: {"vehicle__mass_matrix": MASS.tolist()}, has_coriolis),
    "validation": (lambda folder: {"validation": {"V": str(folder / "V.csv")}}, is_validated),
    "changes": (lambda folder: {"learner__policy": "weighted"}, change_is_noticed),
    "feed-forward": (lambda folder: {}, drives_a_plan),
    "export": (lambda folder: {}, is_exported),
    "archive": (lambda folder: {"archive__directory": folder / "archive"}, is_archived),
}
"""Name → its settings, and whether it worked."""
PAIRS = [
    pytest.param(pair, id=" and ".join(dict.fromkeys(pair)), marks=[pytest.mark.slow] if "changes" in pair else [])
    for pair in combinations_with_replacement(FEATURES, 2)
]


def promised() -> tuple[set[str], set[tuple[str, ...]]]:
    """The features that work together in pairs by the page, and the pairs that it says are refused."""
    section = PAGE.read_text(encoding="utf-8").split("## Which features work together")[1]
    text = " ".join(section.split())
    (names,) = re.findall(r"Each pair of these works: (.+?)\.", text)
    refused = re.findall(r"Only (.+?) (?:is|are) refused", text)
    return set(names.split(", ")), {tuple(pair.split(" with ")) for each in refused for pair in each.split(" and ")}


def settings_of(pair: tuple[str, str], folder: Path) -> dict[str, Any]:
    traced(folder, "mass matrix" in pair)
    write(folder / "V.csv", cut(run(SHORT_S), 40.0))
    found = {"prefix": f"pair/{folder.name}", **BASE}
    for name in pair:
        own = FEATURES[name][0](folder)
        found |= {key: str(value) if isinstance(value, Path) else value for key, value in own.items()}
    if "mass matrix" in pair:
        del found["vehicle__inertia"]
    return found


@pytest.fixture(scope="module")
def session() -> Iterator[zenoh.Session]:
    with open_session(listener_config_at(free_endpoint())) as opened:
        yield opened


def played(session: zenoh.Session, config: Config, recording: Recording, folder: Path) -> Outcome:
    """The learner after all that was put on its keys, ten seconds of each stream in a message."""
    host, reports = Host(session, config), list[wire.IterationReport]()

    def heard(sample: zenoh.Sample) -> None:
        reports.append(wire.decode(wire.IterationReport, sample.payload.to_bytes()))

    subscriber = session.declare_subscriber(host.keys.iteration, heard)
    for start in np.arange(0.0, float(recording.time[-1]), 10.0).tolist():
        for name, (t, value) in recording.streams().items():
            if name in ("yaw_rate", "torque", "surge", "sway"):
                part = (t >= start) & (t < start + 10.0)
                payload = wire.measurement(tuple(t[part].tolist()), tuple(value[part].tolist()))
                session.put(host.keys.stream(name), payload, congestion_control=zenoh.CongestionControl.BLOCK)
        count, until = int(np.count_nonzero(recording.time < start + 10.0)), time.monotonic() + PATIENCE
        while min(stream.received for stream in host.watch.report(host.node).streams.values()) < count:
            host.feed.drain()
            assert time.monotonic() < until
        while host.learn():
            pass
    host.tick()
    subscriber.undeclare()  # type: ignore[no-untyped-call]
    return Outcome(host, reports, folder)


@pytest.mark.parametrize("pair", PAIRS)
def test_a_pair(pair: tuple[str, str], session: zenoh.Session, tmp_path: Path) -> None:
    settings, (names, refused) = settings_of(pair, tmp_path), promised()
    assert {*pair} <= names
    if pair in refused:
        with pytest.raises(BadInput, match="leave out either"):
            configured(**settings)
        return
    outcome = played(session, configured(**settings), run(LONG_S if "changes" in pair else SHORT_S), tmp_path)
    try:
        assert outcome.reports
        (reply,) = list(session.get(f"{outcome.host.keys.damping}?rate=0.1", timeout=PATIENCE))
        assert reply.ok is not None
        assert np.isfinite(wire.decode(wire.DampingReply, reply.ok.payload.to_bytes()).damping).all()
        worked = [FEATURES[name][1](outcome) for name in pair if name != "archive"]
    finally:
        outcome.host.close()
    worked += [FEATURES[name][1](outcome) for name in pair if name == "archive"]
    assert all(worked)


def test_the_page_names_every_feature() -> None:
    assert promised()[0] == set(FEATURES)
