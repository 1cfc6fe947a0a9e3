"""The forms on the bus: exact, finite, and told apart from what they are not."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from incsvr.errors import BadInput
from service import wire
from service.learner.node import LearnerNode
from service.wire.json_text import json_text
from simulator import leng
from tests.service.conftest import configured

finite = st.floats(allow_nan=False, allow_infinity=False)


@pytest.fixture(scope="module")
def snapshot() -> wire.ModelSnapshot:
    node = LearnerNode(configured(), boot="b")
    for name, (t, value) in leng.recording("T1", seed=5).streams().items():
        node.push(name, t[t < 60.0], value[t < 60.0])
    outcome = node.learn()
    assert outcome is not None
    return outcome.served


@given(rate=st.lists(finite, max_size=20))
def test_numbers_travel_to_the_last_bit(rate: list[float]) -> None:
    points = wire.Points(rate=tuple(rate), damping=tuple(rate))
    assert wire.decode(wire.Points, wire.encode(points)) == points


def test_a_snapshot_has_the_contracts_names_and_predicts(snapshot: wire.ModelSnapshot) -> None:
    payload = json.loads(wire.encode(snapshot))
    promised = {
        "boot",
        "revision",
        "iteration",
        "t",
        "kernel",
        "epsilon",
        "C",
        "support",
        "inertia",
        "effects",
        "noise",
        "sigma",
    }
    assert promised | {"trained_range", "certified_error", "correlation", "water", "spread"} == set(payload)
    assert payload["kernel"] == {"name": "rbf", "gamma": 10.0}
    assert {"rate", "damping", "weight"} <= set(payload["support"])
    low, high = payload["trained_range"]
    rate = np.linspace(low, high, 7)
    kernel = np.exp(-10.0 * np.subtract.outer(rate, payload["support"]["rate"]) ** 2)
    np.testing.assert_allclose(kernel @ payload["support"]["weight"], snapshot.model.predict(rate).damping, atol=1e-6)


def test_a_newer_learner_may_say_more(snapshot: wire.ModelSnapshot) -> None:
    payload = json.loads(wire.encode(snapshot)) | {"mood": "good"}
    assert wire.decode(wire.ModelSnapshot, json.dumps(payload).encode()) == snapshot


@pytest.mark.parametrize(
    ("payload", "names"),
    [
        (b"", "Expecting value"),
        (b"[]", "write an object"),
        (b'{"rate": [1.0], "damping": []}', "rate has 1 and damping 0 values"),
        (b'{"rate": ["fast"]}', r"rate\.0"),
        (b'{"rate": [1e999], "damping": [1.0]}', "finite"),
    ],
)
def test_what_is_no_such_form_is_named(payload: bytes, names: str) -> None:
    with pytest.raises(BadInput, match=names):
        wire.decode(wire.Points, payload)


def test_measurements_have_the_contracts_form() -> None:
    assert json.loads(wire.measurement(12.34, 0.083)) == {"t": 12.34, "value": 0.083}
    assert json.loads(wire.measurement((1.0, 2.0), (3.0, 4.0), 5)) == {"t": [1.0, 2.0], "value": [3.0, 4.0], "seq": 5}


def test_keys_are_those_of_the_contract() -> None:
    keys = wire.Keys("leng/yaw")
    assert [
        keys.rate,
        keys.torque,
        keys.model,
        keys.iteration,
        keys.damping,
        keys.health,
        keys.effects,
        keys.alive,
    ] == [
        f"leng/yaw/{name}" for name in ("rate", "torque", "model", "iteration", "damping", "health", "effects", "alive")
    ]
    assert [keys.stream(name) for name in ("yaw_rate", "torque", "depth")] == [
        "leng/yaw/rate",
        "leng/yaw/torque",
        "leng/yaw/channel/depth",
    ]


NO_NUMBERS = (math.nan, math.inf, -math.inf)


def strict(text: str | bytes) -> Any:
    """The value as a reader takes it that goes by RFC 8259."""

    def refuse(word: str) -> float:
        raise AssertionError(f"{word} is no JSON")

    return json.loads(text, parse_constant=refuse)


@pytest.mark.parametrize("number", NO_NUMBERS)
def test_what_is_no_number_in_a_payload_is_null(number: float) -> None:
    points = wire.Points((1.0, number), (number, 2.0), {"sway": (number, 0.0)})
    assert strict(wire.encode(points)) == {"rate": [1.0, None], "damping": [None, 2.0], "others": {"sway": [None, 0.0]}}
    ledger = wire.EffectsLedger(found=({"effect": "tether", "proof": {"p_value": number}},))
    assert strict(wire.encode(ledger))["found"] == [{"effect": "tether", "proof": {"p_value": None}}]


def test_numbers_of_numpy_are_numbers() -> None:
    held = {"a": np.float32(0.5), "b": np.arange(2), "c": np.array([1.0, np.nan]), "d": [{"e": (math.inf, -math.inf)}]}
    assert strict(json_text(held)) == {"a": 0.5, "b": [0, 1], "c": [1.0, None], "d": [{"e": [None, None]}]}
