"""`incsvr.Learner`: the learner of `serve` for a program without a bus."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import incsvr
from incsvr.learning.model import Model
from incsvr.numerics import Array
from service.config.configuration import Config
from service.config.sources import read as read_config
from service.learner.node import LearnerNode
from service.recordings.recording import Recording
from simulator import leng
from tests.worlds import ROV, slow


def columns(recording: Recording) -> tuple[Array, Array, Array]:
    """Stamps, velocity and effort in common rows, nan where one was not sampled."""
    return recording.time, recording.columns["yaw_rate"], recording.columns["torque"]


def on_a_bus(config: Config, recording: Recording) -> Model:
    """What `serve` learns of messages of a second each."""
    node, streams = LearnerNode(config, "boot"), recording.streams()
    for second in range(int(recording.time[-1]) + 1):
        for name in ("yaw_rate", "torque"):
            time, values = streams[name]
            inside = (time >= second) & (time < second + 1)
            if inside.any() and node.push(name, time[inside], values[inside]):
                while node.learn() is not None:
                    pass
    return node.served.model


def test_it_learns_what_fit_and_serve_learn(tmp_path: Path) -> None:
    """Pushed one by one, or at once, the measurements give the model of `fit` and of `serve` to the bit."""
    recording, path = leng.recording("T1", 0), tmp_path / "c.yaml"
    path.write_text("vehicle: {name: leng}\n", encoding="utf-8")
    at_once, one_by_one = incsvr.Learner(config=path), incsvr.Learner(config=path)
    assert not at_once.model.is_trained
    assert at_once.to_dict() == {}
    assert at_once.push(*columns(recording))
    assert sum(one_by_one.push(*row) for row in zip(*columns(recording), strict=True)) > 5
    fitted = incsvr.fit(dict(zip(("t", "yaw_rate", "torque"), columns(recording), strict=True)), config=path)
    for model in (one_by_one.model, on_a_bus(read_config(path), recording), fitted.model):
        assert np.array_equal(model.weight, at_once.model.weight)
        assert np.array_equal(model.support_rate, at_once.model.support_rate)
    assert np.array_equal(at_once.damping([0.05, 0.1]).damping, fitted.predict([0.05, 0.1]).damping)
    assert at_once.to_dict()["support"]["rate"] == at_once.model.support_rate.tolist()


def test_an_inertia_and_a_range_are_enough() -> None:
    """A small vehicle, of which nothing else is said: its curve is the true one within a fifth."""
    recording, at = slow(3, 0.05, (0.8, 2.4), 300.0), np.array([-1.0, -0.5, 0.5, 1.0])
    learner = incsvr.Learner(inertia=ROV.inertia, rate_range=2.0, set={"signals.smoothing": 0.1})
    learner.push(*columns(recording))
    assert learner.damping(at).damping == pytest.approx(ROV.damping(at), rel=0.2)
    assert learner.paused is None


def test_a_fault_of_a_sensor_pauses_it() -> None:
    time, rate, torque = columns(leng.recording("T1", 0))
    learner = incsvr.Learner(inertia=350.0, rate_range=0.25)
    learner.push(time, np.where(time < 0.5 * time[-1], rate, -rate), torque)
    assert learner.paused is not None


@pytest.mark.parametrize(
    ("keywords", "reason"),
    [
        ({}, "inertia"),
        ({"inertia": 1.0, "axis": "z"}, "axis is z"),
        ({"rate_range": 2.0}, "give inertia=I as well"),
        ({"inertia": 1.0, "rate_range": (2.0, 1.0)}, "lower end first"),
        ({"inertia": -1.0}, "vehicle.inertia"),
        ({"config": "none.yaml"}, "there is no such file"),
    ],
)
def test_a_wrong_keyword_is_one_sentence(keywords: dict[str, object], reason: str) -> None:
    if not keywords:
        keywords = {"set": {"vehicle.name": "rov"}}
    with pytest.raises(incsvr.BadInput, match=reason) as refused:
        incsvr.Learner(**keywords)  # type: ignore[arg-type]
    assert "\n" not in str(refused.value)


def test_what_cannot_be_pushed_is_refused() -> None:
    learner = incsvr.Learner(inertia=350.0, rate_range=0.25)
    with pytest.raises(incsvr.BadInput, match="t has 2 values and torque has 1"):
        learner.push([0.0, 0.1], [0.0, 0.0], 1.0)
    with pytest.raises(incsvr.BadInput, match="depth is no channel of this learner"):
        learner.push(0.0, 0.0, 1.0, depth=3.0)
    with pytest.raises(incsvr.BadInput, match="nothing has been learned yet"):
        learner.damping(0.1)
