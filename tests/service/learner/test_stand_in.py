"""The model in the gyro's place: on the bus while the gyro is silent, by a question, and while its checks pause it."""

from __future__ import annotations

import json
import queue
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zenoh
from numpy.typing import NDArray

from incsvr.errors import BadInput
from incsvr.numerics import Array
from service import wire
from service.cli.command_line import main
from service.config.configuration import Config
from service.config.traced_effects import configured_effects
from service.learner.node import LearnerNode
from service.learner.stand_in import estimate, forecast_reply
from service.recordings.recording import Recording, from_table
from simulator import leng
from tests import worlds
from tests.hidden import recording as hidden
from tests.hidden import write_trace
from tests.planar import planar
from tests.service.conftest import PATIENCE, StartBench, Taught, configured, teach
from tests.whole_vehicle import MASS, whole_vehicle

SEED = 9
BLOCK = zenoh.CongestionControl.BLOCK
LOST = 120.0
"""The gyro's last stamp [s]."""


@cache
def run() -> Recording:
    return leng.recording("T1", SEED)


def part(stream: str, first: float, last: float) -> tuple[Array, Array]:
    t, value = run().streams()[stream]
    kept = (t >= first) & (t < last)
    return t[kept], value[kept]


def message(stream: str, first: float, last: float) -> bytes:
    t, value = part(stream, first, last)
    return wire.measurement(tuple(t.tolist()), tuple(value.tolist()))


def truth(at: float) -> float:
    return float(np.interp(at, *part("yaw_rate", 0.0, 400.0)))


def learner_of(until: float = 150.0) -> LearnerNode:
    """A learner without a bus that has heard all until then."""
    node = LearnerNode(configured(), boot="")
    for name in ("yaw_rate", "torque"):
        node.push(name, *part(name, 0.0, until))
    while node.learn() is not None:
        pass
    return node


def test_while_the_gyro_is_silent_the_models_own_rate_goes_out_until_it_is_back(start: StartBench) -> None:
    bench = start(health__stale_after=60.0)
    found = bench.follow(bench.keys.estimate, wire.Estimate)
    teach(bench.session, bench.keys, SEED, 0.0, LOST)
    bench.health_when(lambda health: health.iteration >= 3)
    said, until = None, time.monotonic() + PATIENCE
    bench.session.put(bench.keys.torque, message("torque", LOST, LOST + 14.9), congestion_control=BLOCK)
    while said is None or said.t < LOST + 14.0:
        assert time.monotonic() < until
        # The torque still comes; it is the gyro that does not.
        bench.session.put(bench.keys.torque, message("torque", LOST + 14.9, LOST + 15.0), congestion_control=BLOCK)
        with suppress(queue.Empty):
            said = found.get(timeout=0.2)
    assert said.since == pytest.approx(LOST, abs=0.2)
    assert said.age_s == pytest.approx(said.t - said.since)
    assert said.rate_low < truth(said.t) < said.rate_high
    assert said.rate_high - said.rate_low < 0.2
    assert said.worth
    assert "the yaw rate is silent" in said.why
    # Asked without anything: since the last measurement.
    payload, refusal = bench.get(bench.keys.forecast)
    assert refusal is None
    reply = wire.decode(wire.ForecastReply, payload or b"")
    assert (reply.since, reply.rate[0]) == pytest.approx((said.since, reply.measured))
    held = [low < truth(t) < high for t, low, high in zip(reply.t, reply.rate_low, reply.rate_high, strict=True)]
    assert np.mean(held[1:]) > 0.8
    # The gyro is back: nothing is said of an estimate any more.
    bench.session.put(bench.keys.torque, message("torque", LOST + 14.9, LOST + 15.0), congestion_control=BLOCK)
    bench.session.put(bench.keys.rate, message("yaw_rate", LOST, LOST + 15.0), congestion_control=BLOCK)
    bench.health_when(lambda health: not any("comes from the model" in reason for reason in health.reasons))


@pytest.mark.parametrize(
    ("plan", "sentence"),
    [
        ({"t": [0.0, 1.0], "torque": [1.0]}, "give one for each"),
        ({"t": [1.0, 0.0], "torque": [1.0, 1.0]}, "begin at zero"),
        ({"t": [0.0, 1e6], "torque": [1.0, 1.0]}, "is longer than 3600 s"),
        ({"t": []}, "ForecastQuery"),
        ({"t": [0.0, 5e-324], "torque": [20.0, 20.0]}, "less than a nanosecond apart"),
        ({"t": [0.0, 5.0], "torque": [20.0, 20.0], "at": [1.0, 1.0 + 3e-16]}, "less than a nanosecond apart"),
        ({"t": [0.0, 5.0], "torque": [20.0, 501.0]}, "a torque of 501 N m is planned; plan within the plausible ±500"),
        ({"t": [0.0, 5.0], "torque": [20.0, 1e308]}, "within the plausible ±500 N m (vehicle.torque_limit)"),
    ],
)
def test_what_is_no_plan_is_refused(taught: Taught, plan: object, sentence: str) -> None:
    _, refusal = taught.bench.get(taught.bench.keys.forecast, json.dumps(plan).encode())
    assert refusal is not None
    assert refusal.error_type == "BadInput"
    assert sentence in refusal.error


def test_while_the_checks_pause_learning_it_goes_on_from_what_they_believed() -> None:
    whole = run()
    columns = {name: values.copy() for name, values in whole.columns.items()}
    columns["yaw_rate"][(whole.time >= LOST) & ~np.isnan(columns["yaw_rate"])] = 0.2  # it is stuck
    streams = from_table("stuck", whole.time, columns).streams()
    node, until = LearnerNode(configured(), boot=""), 0.0
    while node.current_warnings.paused is None:
        assert until < 400.0
        until += 5.0
        for name, (t, value) in streams.items():
            now = (t >= until - 5.0) & (t < until)
            node.push(name, t[now], value[now])
        while node.learn() is not None:
            pass
    said = estimate(node, None)
    assert said is not None
    assert said.since < LOST + 1.0
    assert said.t > LOST + 5.0
    assert said.rate_low < truth(said.t) < said.rate_high
    assert "learning is paused" in said.why
    assert forecast_reply(node, None).since == said.since


def test_an_estimate_says_when_it_is_no_longer_worth_having() -> None:
    node = learner_of(60.0)
    assert node.stand_in is not None
    assert estimate(node, None) is None  # neither silent nor paused
    said = estimate(node, 3.0)
    assert said is not None
    assert said.worth
    # A vehicle that as a rule hardly turns: its usual rates say more.
    node.stand_in.experience = replace(node.stand_in.experience, square=1e-8)
    said = estimate(node, 3.0)
    assert said is not None
    assert not said.worth
    assert "too uncertain to be useful" in said.why


def test_experience_survives_an_orderly_end_and_a_broken_one_costs_nothing_else() -> None:
    node = learner_of()
    memory = json.loads(json.dumps(node.memory(whole=True)))
    again = LearnerNode(configured(), boot="", memory=memory)
    assert node.stand_in is not None
    assert again.stand_in is not None
    ahead = np.array([1.0, 5.0, 20.0])
    assert np.array_equal(again.stand_in.experience.widening(ahead), node.stand_in.experience.widening(ahead))
    broken = LearnerNode(configured(), boot="", memory=memory | {"forecast": {"scores": "none"}})
    assert broken.stand_in is not None
    assert not np.array_equal(broken.stand_in.experience.widening(ahead), node.stand_in.experience.widening(ahead))
    assert broken.served.revision == node.served.revision


@pytest.mark.slow
def test_while_the_gyro_is_heard_the_command_says_so_and_draws_what_was_asked(
    start: StartBench, capsys: pytest.CaptureFixture[str]
) -> None:
    bench = start()
    teach(bench.session, bench.keys, SEED, 0.0, LOST)
    bench.health_when(lambda health: health.iteration >= 3)

    newest = {name: part(name, 0.0, LOST + 0.02)[0][-1] for name in ("yaw_rate", "torque")}

    def forecast(*words: str, heard: bool = True) -> list[str]:
        for stream in ("yaw_rate", "torque") if heard else ():
            payload = message(stream, LOST - 1.0, LOST + 0.02)  # twice is no harm, and what counts is that it comes
            bench.session.put(bench.keys.stream(stream), payload, congestion_control=BLOCK)
        bench.health_when(lambda health: all(health.streams[name].t == newest[name] for name in newest))
        assert main(["forecast", "--connect", bench.endpoint, *words]) == 0
        return capsys.readouterr().out.splitlines()

    now = forecast()
    assert now[0] == "the gyro works: give --torque for a plan, such as --torque 20 --seconds 10"
    assert len(now) == 7, "the last measurement and now, not twenty rows of a tenth of a second"
    planned = forecast("--torque", "20", "--seconds", "10")
    assert planned[0].startswith("last measurement:")
    assert (planned[-2].split()[0], len(planned)) == ("10.00", 24)
    held = forecast("--seconds", "30")
    assert held[0] == f"under the present torque, {part('torque', 0.0, LOST + 0.02)[1][-1]:.4g} N m, constant for 30 s"
    assert held[-2].split()[0] == "30.00"
    bench.health_when(lambda health: (health.streams["yaw_rate"].age_s or 0.0) > 1.0)
    assert forecast(heard=False)[0].startswith("last measurement:")


def test_bad_words_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "plan.csv").write_text("time,torque\n0,1\n")
    for words, sentence in (
        (["--torque", "1", "--profile", "x.csv"], "not both"),
        (["--torque", "nan"], "give finite numbers"),
        (["--seconds", "5", "--profile", "x.csv"], "the column t of --profile"),
        (["--profile", str(tmp_path / "plan.csv")], "with the columns t and torque"),
        (["--profile", str(tmp_path / "none.csv")], "cannot be read"),
    ):
        assert main(["forecast", *words]) == 2
        assert sentence in capsys.readouterr().err


def forecast_errors(config: Config, run: Recording, lost: float, until: float) -> tuple[Array, NDArray[np.bool_]]:
    """(n,) errors of the yaw rate [rad/s], and whether the interval holds it, from when the gyro is lost on [s]."""
    node = LearnerNode(config, boot="", effects=configured_effects(config))
    for end in np.arange(5.0, until + 5.0, 5.0).tolist():
        for name, (t, value) in run.streams().items():
            kept = (t >= end - 5.0) & (t < min(end, lost if name == "yaw_rate" else until))
            if kept.any():
                node.push(name, t[kept], value[kept])
        while node.learn() is not None:
            pass
    said = forecast_reply(node, None)
    assert said.since == pytest.approx(lost, abs=0.3)
    assert said.t[-1] == pytest.approx(until, abs=0.3)
    true = np.interp(said.t, *run.streams()["yaw_rate"])
    held = (np.array(said.rate_low) <= true) & (true <= np.array(said.rate_high))
    return np.array(said.rate) - true, held


PLANAR = {"vehicle__inertia": planar(910108).inertia, "learner__policy": "weighted"}
BODY = {
    "vehicle__name": "rov", "vehicle__rate_limit": 5.0, "vehicle__rate_range": (-1.0, 1.0),
    "vehicle__mass_matrix": MASS.tolist(), "learner__batch": 40, "learner__epsilon": 0.5,
    "signals__torque": "measured", "signals__channels": ("surge", "sway"),
}  # fmt: skip
TAKEN: dict[str, tuple[Callable[[], Recording], dict[str, Any], float, float]] = {
    "effects in force": (lambda: hidden(3, 260.0), {}, 240.0, 258.0),
    "further velocities": (
        lambda: worlds.planar(910108, 160.0), {**PLANAR, "learner__inputs": ("yaw_rate", "surge", "sway")}, 140.0, 158.0
    ),
    "the body": (lambda: whole_vehicle(910_000, 4000), BODY, 179.95, 199.45),
}  # fmt: skip
"""What a forecast takes into account → the run, its learner, when the gyro is lost, and until when it is asked [s]."""


@pytest.mark.parametrize("what", TAKEN)
def test_a_forecast_takes_into_account(what: str, tmp_path: Path) -> None:
    make, settings, lost, until = TAKEN[what]
    run = make()
    usual = float(np.std(run.streams()["yaw_rate"][1]))
    most = (0.1 if what == "the body" else 0.25) * usual
    if what == "effects in force":
        write_trace(tmp_path / "trace.json")
        bare, _ = forecast_errors(configured(), run, lost, until)
        settings, most = {"effects": tmp_path / "trace.json"}, 0.25 * float(np.sqrt(np.mean(bare**2)))
    off, held = forecast_errors(configured(**settings), run, lost, until)
    assert np.sqrt(np.mean(off**2)) < most
    assert np.mean(held) > 0.8


def test_a_forecast_asks_for_what_it_needs(tmp_path: Path) -> None:
    run = worlds.planar(910108, 120.0)
    node = LearnerNode(configured(**PLANAR, learner__inputs=("yaw_rate", "surge")), boot="")
    for name, (t, value) in run.streams().items():
        node.push(name, t[t < 90.0], value[t < 90.0])
    while node.learn() is not None:
        pass
    t, value = run.streams()["torque"]
    node.push("torque", t[t >= 90.0], value[t >= 90.0])
    with pytest.raises(BadInput, match="a forecast needs surge"):
        forecast_reply(node, None)
    assert estimate(node, 30.0) is None
