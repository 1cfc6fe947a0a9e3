"""The learner with traced effects: its damping is free of them, its torque splits into parts, what is wrong is said."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from incsvr.errors import BadInput
from incsvr.model.rows import Factor
from service import wire
from service.cli.command_line import main
from service.config.traced_effects import configured_effects as effects_of
from service.config.traced_effects import read_effects
from service.learner.node import LearnerNode
from service.recordings.recording import Recording, from_table
from service.recordings.recording_csv import write
from tests.hidden import BIAS, LAG, TRUTH, acting, recording, write_trace
from tests.service.conftest import PATIENCE, Bench, StartBench, configured

ITERATIONS = 6
Content = dict[str, Any]
NAMES = ("torque_lag", "bias_torque")


@pytest.fixture(scope="module")
def traced(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The trace of a vehicle with a hidden lag and a bent fin, by who knows all about it."""
    path = tmp_path_factory.mktemp("traced") / "trace.json"
    write_trace(path)
    trace: Content = json.loads(path.read_text(encoding="utf-8"))
    path.write_text(json.dumps(trace | {"effects": [{"effect": name} for name in NAMES]}), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def run() -> Recording:
    """A run of the same vehicle that the tracer never saw."""
    return recording(3, 200.0)


@pytest.fixture
def changed(traced: Path, tmp_path: Path) -> Callable[..., Path]:
    """The trace with its content changed, as a file of its own."""

    def write_changed(change: Callable[[Content], object]) -> Path:
        content = json.loads(traced.read_text(encoding="utf-8"))
        change(content)
        path = tmp_path / "changed.json"
        path.write_text(json.dumps(content), encoding="utf-8")
        return path

    return write_changed


def learned(bench: Bench, run: Recording, iterations: int = ITERATIONS) -> wire.ModelSnapshot:
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    bench.play(run)
    return [models.get(timeout=PATIENCE) for _ in range(iterations)][-1]


def ledger(bench: Bench) -> wire.EffectsLedger:
    payload, _ = bench.get(bench.keys.effects)
    assert payload is not None
    return wire.decode(wire.EffectsLedger, payload)


def off(snapshot: wire.ModelSnapshot) -> float:
    """RMS distance of the learned damping from the vehicle's own where it was trained [N m]."""
    assert snapshot.model.trained_range is not None
    rate = np.linspace(*snapshot.model.trained_range, 101)
    return float(np.sqrt(np.mean((snapshot.model.predict(rate).damping - TRUTH(rate)) ** 2)))


@pytest.mark.slow
def test_what_the_tracer_writes_is_taken_up(tmp_path: Path) -> None:
    paths = [tmp_path / f"run_{seed}.csv" for seed in (1, 2)]
    for seed, path in zip((1, 2), paths, strict=True):
        write(path, recording(seed, 280.0))
    assert main(["trace", *map(str, paths), "--inertia", "350", "--json", str(tmp_path / "trace.json")]) == 0
    model = read_effects(tmp_path / "trace.json", 350.0, ()).compensation.model
    assert {effect.name for effect in model.effects} == {"torque_lag", "bias_torque"}
    assert np.exp(model.theta["lag:yaw_rate"]) == pytest.approx(LAG, rel=0.2)
    assert -model.theta["bias_torque@yaw_rate"] == pytest.approx(BIAS, rel=0.1)


def test_the_learned_damping_is_closer_to_the_truth(start: StartBench, run: Recording, traced: Path) -> None:
    with_effects, without = learned(start(effects=traced), run), learned(start(), run)
    assert off(with_effects) < 1.5 < 10.0 < off(without)
    assert {effect["effect"] for effect in with_effects.effects} == {"torque_lag", "bias_torque"}
    assert without.effects == ()


def test_the_torque_splits_into_its_parts_over_the_bus(start: StartBench, run: Recording, traced: Path) -> None:
    bench = start(effects=traced)
    reports = bench.follow(bench.keys.iteration, wire.IterationReport)
    learned(bench, run)
    batch = [reports.get(timeout=PATIENCE).batch for _ in range(ITERATIONS)][-1]
    assert {"declared inertia", "torque_lag", "bias_torque"} <= set(batch.parts)
    np.testing.assert_allclose(batch.parts["bias_torque"], -12.0, atol=0.5)
    (t, torque), calm = run.streams()["torque"], []
    assert batch.predicted is not None
    parts = np.sum(list(batch.parts.values()), axis=0)
    for at, measured, predicted in zip(batch.time, parts + batch.damping, parts + batch.predicted, strict=True):
        near = torque[np.abs(t - at) < 0.36]
        if np.ptp(near) < 8.0:  # the command does not jump within the filter
            calm.append((measured - near.mean(), predicted - near.mean()))
    assert len(calm) > 30
    assert np.abs(np.array(calm)[:, 0]).max() < 2.0
    assert np.sqrt(np.mean(np.array(calm)[:, 1] ** 2)) < 5.0
    said = ledger(bench)
    assert said.batch == batch
    assert {effect["effect"] for effect in said.effects} == {"torque_lag", "bias_torque"}
    assert {(step["effect"], step["step"]) for step in said.history} >= {("torque_lag", "in force")}


def test_live_and_from_a_file_it_is_the_same_to_the_byte(start: StartBench, run: Recording, traced: Path) -> None:
    config = configured(effects=traced)
    node = LearnerNode(config, boot="", effects=effects_of(config))
    for name, (t, value) in run.streams().items():
        node.push(name, t, value)
    whole = [node.learn() for _ in range(ITERATIONS)]
    bench = start(effects=traced)
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    bench.play(run)
    for outcome in whole:
        assert outcome is not None
        played = models.get(timeout=PATIENCE)
        assert wire.encode(replace(played, boot="")) == wire.encode(outcome.served)


def test_stopped_and_started_in_between_it_learns_the_same(
    start: StartBench, run: Recording, traced: Path, tmp_path: Path
) -> None:
    whole = learned(start(effects=traced), run)
    first = start(effects=traced, state=tmp_path)
    learned(first, part(run, 0.0, 101.3), 3)
    first.stop()
    second = start(effects=traced, state=tmp_path)
    models = second.follow(second.keys.model, wire.ModelSnapshot)
    second.play(part(run, 101.3, 200.0))
    again = [models.get(timeout=PATIENCE) for _ in range(ITERATIONS - 3)][-1]
    assert replace(again, boot="") == replace(whole, boot="")


def part(run: Recording, first: float, last: float) -> Recording:
    inside = (run.time >= first) & (run.time < last)
    return from_table(run.name, run.time[inside], {name: values[inside] for name, values in run.columns.items()})


@pytest.mark.slow
def test_a_state_learned_with_other_effects_is_refused_aloud(
    start: StartBench, run: Recording, traced: Path, tmp_path: Path
) -> None:
    first = start(state=tmp_path)
    learned(first, run)
    first.stop()
    health = start(state=tmp_path, effects=traced).health()
    assert health.revision == 0
    assert "it was learned with effects None, and now effects is" in health.reasons[0]
    assert "bias_torque" in health.reasons[0]


def test_the_ledger_answers_before_anything_is_learned(start: StartBench, traced: Path) -> None:
    said = ledger(start(effects=traced))
    assert len(said.effects) == 2
    assert said.batch is None


def test_what_refers_to_the_clock_of_its_recording_is_left_out_aloud(
    start: StartBench, changed: Callable[..., Path]
) -> None:
    wave = acting("wave", Factor("wave", "time", 0.9), value=1.0).to_dict()
    step = acting("drag_step", Factor("after", "time", 70.0), Factor("drag", "yaw_rate"), value=0.1).to_dict()
    bench = start(effects=changed(lambda trace: trace["model"]["effects"].extend([wave, step])))
    assert bench.health().level == "WARN"
    assert [reason for reason in bench.health().reasons if "wave is left out: it refers to the clock" in reason]
    assert not [reason for reason in bench.health().reasons if "drag_step" in reason]
    left_out = {step["effect"]: step["why"] for step in ledger(bench).history if step["step"] == "left out"}
    assert left_out["drag_step"] == "the learned damping follows the vehicle by itself"
    assert set(left_out) == {"wave", "drag_step"}


def sway(trace: Content) -> None:
    trace["model"]["effects"].append(acting("coupling:sway", Factor("value", "sway"), value=8.0).to_dict())


@pytest.mark.parametrize(
    ("change", "cure"),
    [
        (lambda trace: trace["model"].update(inertia=340.0), "set vehicle.inertia to 340"),
        (sway, "add sway to signals.channels"),
        (lambda trace: trace.pop("model"), "this is no trace, it contains no model"),
        (lambda trace: trace["model"].pop("effects"), "no trace of this version"),
        (lambda trace: trace["model"]["effects"][0]["theta"].update(magic=1.0), "no trace of this version"),
        (lambda trace: trace["model"]["effects"][1]["rows"][0].update(name="magic"), "no trace of this version"),
        (lambda trace: trace["model"]["effects"][1]["rows"][0]["parts"][0][1].insert(0, "magic"), "of this version"),
    ],
)
def test_a_wrong_trace_is_refused_with_its_cure(
    changed: Callable[..., Path], change: Callable[[Content], object], cure: str
) -> None:
    with pytest.raises(BadInput, match=cure):
        read_effects(changed(change), 350.0, ())


def test_an_effect_on_a_channel_that_comes_is_taken_up(changed: Callable[..., Path]) -> None:
    found = read_effects(changed(sway), 350.0, ("depth", "sway"))
    assert found.compensation.channels == ("sway",)


@pytest.mark.parametrize(("content", "says"), [(None, "there is no such file"), ("t,yaw_rate", "this is no JSON")])
def test_serve_says_in_one_sentence_what_is_wrong(
    tmp_path: Path, content: str | None, says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "trace.json"
    if content is not None:
        path.write_text(content, encoding="utf-8")
    assert main(["serve", "--listen", "tcp/127.0.0.1:0", "--set", "state=null", "--set", f"effects={path}"]) == 2
    said = capsys.readouterr().err
    assert says in said
    assert "incsvr trace RECORDING… --json FILE" in said
    assert said.count("\n") == 1


def test_config_check_reads_the_trace_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "config.yaml"
    path.write_text(f"effects: {tmp_path / 'none.json'}\n", encoding="utf-8")
    assert main(["config", "check", str(path)]) == 2
    assert "there is no such file" in capsys.readouterr().err
