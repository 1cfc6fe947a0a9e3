"""The torque for a planned yaw rate, asked on the bus: of a plain learner, with effects, and what is refused."""

from __future__ import annotations

import json
import threading
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from incsvr.errors import BadInput
from service import wire
from service.host import answers
from service.learner.feedforward_reply import feedforward_reply
from service.learner.node import LearnerNode
from tests.hidden import BIAS, LAG, recording, write_trace
from tests.service.conftest import PATIENCE, Bench, StartBench, Taught, configured
from tests.whole_vehicle import MASS as BODY_MASS
from tests.whole_vehicle import whole_vehicle

PLAN = {"t": [0.0, 10.0, 20.0], "rate": [0.0, 0.1, 0.1]}


def asked(bench: Bench, plan: object) -> wire.FeedforwardReply:
    payload, refusal = bench.get(bench.keys.feedforward, json.dumps(plan).encode())
    assert refusal is None
    return wire.decode(wire.FeedforwardReply, payload or b"")


def test_it_is_inertia_and_damping_of_the_served_model(taught: Taught) -> None:
    served = taught.models[-1]
    said = served.model.predict(np.array(PLAN["rate"]))
    found = asked(taught.bench, PLAN | {"acceleration": [0.01, 0.01, 0.0]})
    assert found.t == tuple(PLAN["t"])
    np.testing.assert_allclose(found.torque, 350.0 * np.array([0.01, 0.01, 0.0]) + said.damping)
    np.testing.assert_allclose(np.subtract(found.high, found.torque), 1.96 * said.sigma, rtol=1e-4)
    assert (found.revision, found.lead_s, found.told, found.effects) == (served.revision, 0.0, (), {})
    fast = asked(taught.bench, {"t": [0.0, 10.0], "rate": [0.0, 0.4]})
    assert any("not learned but extrapolated" in sentence for sentence in fast.told)


def test_a_plan_that_takes_long_keeps_nobody_waiting(taught: Taught, monkeypatch: pytest.MonkeyPatch) -> None:
    begun, ended = threading.Event(), threading.Event()

    def slow(*arguments: Any) -> wire.FeedforwardReply:
        begun.set()
        assert ended.wait(PATIENCE)
        return feedforward_reply(*arguments)

    monkeypatch.setattr(answers, "feedforward_reply", slow)
    found: list[wire.FeedforwardReply] = []
    asker = threading.Thread(target=lambda: found.append(asked(taught.bench, PLAN)))
    asker.start()
    try:
        assert begun.wait(PATIENCE)
        taught.bench.health()
        payload, _ = taught.bench.get(f"{taught.bench.keys.damping}?rate=0.1")
        assert payload is not None
        assert not found
    finally:
        ended.set()
        asker.join()
    assert found[0].t == tuple(PLAN["t"])


def test_effects_in_force_are_in_it(start: StartBench, tmp_path: Path) -> None:
    write_trace(tmp_path / "trace.json")
    bench = start(effects=tmp_path / "trace.json")
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    bench.play(recording(3, 200.0))
    model = [models.get(timeout=PATIENCE) for _ in range(6)][-1].model
    found = asked(bench, PLAN)
    assert set(found.effects) >= {"torque_lag", "bias_torque"}
    np.testing.assert_allclose(found.effects["bias_torque"], -BIAS, atol=0.5)
    assert found.torque[2] == pytest.approx(float(model.predict(0.1).damping[0]) - BIAS, abs=1.0)
    rising = (350.0 + LAG * float(model.predict(0.05).derivative[0])) * 0.01  # while the rate rises the rotors lead
    halfway = asked(bench, {"t": [0.0, 5.0, 10.0], "rate": [0.0, 0.05, 0.1]})
    steady = float(model.predict(0.05).damping[0]) - BIAS
    assert halfway.torque[1] == pytest.approx(rising + steady, abs=1.0)
    parts = np.array(halfway.inertia_part) + halfway.body_part + halfway.damping_part + halfway.effects_part
    np.testing.assert_allclose(parts, halfway.torque, atol=1e-9)


def test_in_a_body_the_torque_of_a_measured_motion_is_the_measured_one() -> None:
    run, last = whole_vehicle(910_001, 2400), 2000
    config = configured(
        vehicle__name="rov", vehicle__mass_matrix=BODY_MASS.tolist(), vehicle__rate_limit=5.0,
        vehicle__rate_range=(-1.0, 1.0), learner__batch=20, learner__epsilon=0.5, signals__torque="measured",
        signals__channels=("surge", "sway"),
    )  # fmt: skip
    node = LearnerNode(config, boot="")
    for name, (t, value) in run.streams().items():
        node.push(name, t[:last], value[:last])
    while node.learn() is not None:
        pass
    at, unseen = tuple(run.time[last:].tolist()), {name: values[last:] for name, values in run.columns.items()}
    others = {name: tuple(unseen[name].tolist()) for name in ("surge", "sway")}
    plan = wire.FeedforwardQuery(t=at, rate=tuple(unseen["yaw_rate"].tolist()), channels=others)
    found = feedforward_reply(node, plan, {})
    error = np.array(found.torque) - unseen["torque"]
    assert np.std(error) < 0.4 * np.std(error - found.body_part)
    assert not any("held" in sentence for sentence in found.told)
    # What is not planned is held as it was measured last, and refused once it is no more measured.
    held = feedforward_reply(node, replace(plan, channels={"sway": others["sway"]}), {})
    assert f"surge is not planned: it is held at {run.columns['surge'][last - 1]:.3g}, as last measured" in held.told
    node.push("torque", run.time[last - 1 :][:1] + 11.0, np.zeros(1))
    with pytest.raises(BadInput, match="surge is neither planned nor has it arrived for 10 s"):
        feedforward_reply(node, wire.FeedforwardQuery(t=at[:2], rate=(0.0, 0.1)), {})


@pytest.mark.parametrize(
    ("plan", "names"),
    [
        (None, "plan the yaw rate in the payload"),
        ({"t": [0.0, 1.0]}, "rate"),
        ({"t": [1.0, 0.0], "rate": [0.0, 0.1]}, "must increase"),
        ({"t": [0.0, 1.0], "rate": [0.0]}, "give one for each"),
        ({"t": [0.0, 1.0], "rate": [0.0, 1e6]}, "beyond 1000 rad/s"),
        ({"t": [0.0, 5e-324], "rate": [0.0, 0.1]}, "0.0 and 5e-324 s are less than a nanosecond apart"),
        ({"t": [0.0, 1e-9], "rate": [0.0, 0.1]}, "a torque of 3.5e+10 N m is planned; plan within the plausible ±500"),
        ({"t": [0.0, 10.0], "rate": [0.0, 2.0]}, "plan within the plausible ±500 N m (vehicle.torque_limit)"),
    ],
)
def test_what_is_no_plan_is_refused(taught: Taught, plan: object, names: str) -> None:
    payload = None if plan is None else json.dumps(plan).encode()
    _, refusal = taught.bench.get(taught.bench.keys.feedforward, payload)
    assert refusal is not None
    assert refusal.error_type == "BadInput"
    assert names in refusal.error
