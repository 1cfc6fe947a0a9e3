"""The torque for a planned yaw rate, asked on the bus: of a plain learner, with effects, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from service import wire
from tests.hidden import BIAS, LAG, recording, write_trace
from tests.service.conftest import PATIENCE, Bench, StartBench, Taught

PLAN = {"t": [0.0, 10.0, 20.0], "rate": [0.0, 0.1, 0.1]}


def asked(bench: Bench, plan: object) -> wire.FeedforwardReply:
    payload, refusal = bench.get(bench.keys.feedforward, json.dumps(plan).encode())
    assert refusal is None
    return wire.decode(wire.FeedforwardReply, payload or b"")


def test_it_is_inertia_and_damping_of_the_served_model(taught: Taught) -> None:
    served = taught.models[-1]
    said = served.model().predict(np.array(PLAN["rate"]))
    found = asked(taught.bench, PLAN | {"acceleration": [0.01, 0.01, 0.0]})
    assert found.t == tuple(PLAN["t"])
    np.testing.assert_allclose(found.torque, 350.0 * np.array([0.01, 0.01, 0.0]) + said.damping)
    np.testing.assert_allclose(np.subtract(found.high, found.torque), 1.96 * said.sigma, rtol=1e-4)
    assert (found.revision, found.lead_s, found.told, found.effects) == (served.revision, 0.0, (), {})
    fast = asked(taught.bench, {"t": [0.0, 10.0], "rate": [0.0, 2.0]})
    assert any("not learned but extrapolated" in sentence for sentence in fast.told)


def test_effects_in_force_are_in_it(start: StartBench, tmp_path: Path) -> None:
    write_trace(tmp_path / "trace.json")
    bench = start(effects=tmp_path / "trace.json")
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    bench.play(recording(3, 200.0))
    model = [models.get(timeout=PATIENCE) for _ in range(6)][-1].model()
    found = asked(bench, PLAN)
    assert set(found.effects) >= {"torque_lag", "bias_torque"}
    np.testing.assert_allclose(found.effects["bias_torque"], -BIAS, atol=0.5)
    assert found.torque[2] == pytest.approx(float(model.predict(0.1).damping[0]) - BIAS, abs=1.0)
    rising = (350.0 + LAG * float(model.predict(0.05).derivative[0])) * 0.01  # while the rate rises the rotors lead
    halfway = asked(bench, {"t": [0.0, 5.0, 10.0], "rate": [0.0, 0.05, 0.1]})
    steady = float(model.predict(0.05).damping[0]) - BIAS
    assert halfway.torque[1] == pytest.approx(rising + steady, abs=1.0)
    parts = np.array(halfway.inertia_part) + halfway.damping_part + halfway.effects_part
    np.testing.assert_allclose(parts, halfway.torque, atol=1e-9)


@pytest.mark.parametrize(
    ("plan", "names"),
    [
        (None, "plan the yaw rate in the payload"),
        ({"t": [0.0, 1.0]}, "rate"),
        ({"t": [1.0, 0.0], "rate": [0.0, 0.1]}, "must increase"),
        ({"t": [0.0, 1.0], "rate": [0.0]}, "give one for each"),
        ({"t": [0.0, 1.0], "rate": [0.0, 1e6]}, "beyond 1000 rad/s"),
    ],
)
def test_what_is_no_plan_is_refused(taught: Taught, plan: object, names: str) -> None:
    payload = None if plan is None else json.dumps(plan).encode()
    _, refusal = taught.bench.get(taught.bench.keys.feedforward, payload)
    assert refusal is not None
    assert refusal.error_type == "BadInput"
    assert names in refusal.error
