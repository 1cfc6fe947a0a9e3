"""The learner on a real bus: what it publishes, and to whom."""

from __future__ import annotations

import queue
import time
from pathlib import Path

import numpy as np
import pytest
import zenoh
from zenoh.ext import HistoryConfig, RecoveryConfig, declare_advanced_subscriber

from incsvr.learning.model import Model
from service import wire
from simulator import leng
from simulator.player import Faults, messages
from simulator.recordings import Recording, sequence, write
from tests.service.conftest import PATIENCE, StartBench


@pytest.fixture(scope="module")
def run() -> Recording:
    """The first two minutes of Leng's first training run: three whole batches of 50 samples."""
    return cut(leng.recording("T1", seed=7), 100.0)


def cut(recording: Recording, end: float) -> Recording:
    early = recording.time < end
    return Recording(recording.name, recording.time[early], {n: v[early] for n, v in recording.columns.items()})


def test_every_iteration_is_published_with_its_sets_and_its_model(start: StartBench, run: Recording) -> None:
    bench = start()
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    reports = bench.follow(bench.keys.iteration, wire.IterationReport)
    bench.play(run)
    for number in (1, 2, 3):
        model, report = models.get(timeout=PATIENCE), reports.get(timeout=PATIENCE)
        assert (model.revision, model.iteration) == (report.revision, report.iteration) == (number, number)
        assert model.boot == report.boot == bench.host.node.boot
        assert model.t == report.t == report.time_span[1]
        assert report.counts["batch"] == len(report.batch.time) == 50
        for name in wire.SETS:
            assert len(getattr(report, name)) == report.counts[name]
        gone = report.counts["new"] + report.counts["discarded_tube"] + report.counts["discarded_near"]
        assert gone + report.counts["undriven"] == 50
        assert 0 < report.counts["support"] <= 60
        assert report.support.rate == model.support.rate
        assert model.certified_error is not None
        assert model.certified_error <= 0.01
        assert report.training_ms > 0.0
        assert (report.progressive_mae is None) == (number == 1)
    assert {name for name in bench.health().counters if name.startswith("rejected")} == {"rejected"}


def test_the_textbooks_coefficients_are_a_key_of_their_own(start: StartBench, run: Recording) -> None:
    bench = start()
    said = bench.follow(bench.keys.coefficients, wire.Coefficients)
    _, error = bench.get(bench.keys.coefficients)
    assert error is not None
    assert error.error_type == "NothingLearned"
    bench.play(run)
    newest = [said.get(timeout=PATIENCE) for _ in range(3)][-1]
    assert newest.revision == 3
    payload, _ = bench.get(bench.keys.coefficients)
    assert payload is not None
    assert wire.decode(wire.Coefficients, payload) == newest
    linear, quadratic = (newest.coefficients[name] for name in ("N_r", "N_r|r|"))
    rate = np.linspace(-0.1, 0.1, 9)
    curve = bench.host.node.served.model.predict(rate).damping
    together = linear.estimate * rate + quadratic.estimate * rate * np.abs(rate)
    assert np.abs(together - curve).mean() < 0.1 * np.abs(curve).max()
    assert linear.low < linear.estimate < linear.high


def test_the_damping_query_answers_what_the_snapshot_says(start: StartBench, run: Recording) -> None:
    bench = start()
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    bench.play(run)
    for _ in range(3):
        snapshot = models.get(timeout=PATIENCE)
    rates = [-0.2, 0.0, 0.1, 3.0]
    expected = snapshot.model().predict(np.array(rates))
    asked = f"{bench.keys.damping}?rate={','.join(map(str, rates))}"
    for selector, payload in ((asked, None), (bench.keys.damping, b'{"rate": [-0.2, 0, 0.1, 3.0]}')):
        answer, _ = bench.get(selector, payload)
        assert answer is not None
        reply = wire.decode(wire.DampingReply, answer)
        assert reply.damping == tuple(expected.damping)
        assert reply.sigma == tuple(expected.sigma)
        assert reply.extrapolated == tuple(expected.extrapolated) == (False, False, False, True)
        assert (reply.iteration, reply.revision, reply.rate) == (3, 3, tuple(rates))
    kernel = np.exp(-snapshot.kernel.gamma * np.subtract.outer(rates[:3], snapshot.support.rate) ** 2)
    np.testing.assert_allclose(kernel @ snapshot.support.weight, expected.damping[:3], atol=1e-6)


def test_before_anything_is_learned_there_is_an_error_reply(start: StartBench) -> None:
    bench = start()
    for selector in (f"{bench.keys.damping}?rate=0.1", bench.keys.model):
        payload, error = bench.get(selector)
        assert payload is None
        assert error is not None
        assert error.error_type == "NothingLearned"
        assert "nothing has been learned yet" in error.error


@pytest.mark.parametrize(
    ("question", "names"),
    [
        ("", "name the yaw rates"),
        ("?rate=", "no list of numbers"),
        ("?rate=1,,2", "no list of numbers"),
        ("?rate=fast", "no list of numbers"),
        ("?rate=nan", "finite"),
        ("?rate=0.1,inf", "finite"),
        ("?rate=" + "1," * 100_000, "several queries"),
    ],
)
def test_a_bad_question_is_told_what_is_wrong(start: StartBench, question: str, names: str) -> None:
    bench = start()
    payload, error = bench.get(bench.keys.damping + question)
    assert payload is None
    assert error is not None
    assert error.error_type == "BadInput"
    assert names in error.error


def test_late_joiners_and_a_plain_get_have_the_latest_snapshot(start: StartBench, run: Recording) -> None:
    bench = start()
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    bench.play(run)
    for _ in range(3):
        latest = models.get(timeout=PATIENCE)
    late: queue.Queue[bytes] = queue.Queue()
    _follower = declare_advanced_subscriber(
        bench.session,
        bench.keys.model,
        lambda sample: late.put(sample.payload.to_bytes()),
        history=HistoryConfig(detect_late_publishers=True, max_samples=1),
        recovery=RecoveryConfig(periodic_queries=None, heartbeat=True),
    )
    assert wire.decode(wire.ModelSnapshot, late.get(timeout=PATIENCE)) == latest
    payload, _ = bench.get(bench.keys.model)
    assert payload is not None
    assert wire.decode(wire.ModelSnapshot, payload) == latest


def test_history_answers_by_time_and_by_revision(start: StartBench, run: Recording, tmp_path: Path) -> None:
    bench = start(state=tmp_path)
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    bench.play(run)
    published = [models.get(timeout=PATIENCE) for _ in range(3)]

    def ask(selector: str) -> wire.ModelSnapshot:
        payload, error = bench.get(bench.keys.model + selector)
        assert payload is not None, error
        return wire.decode(wire.ModelSnapshot, payload)

    assert ask("?revision=2") == published[1]
    assert ask(f"?at={published[1].t}") == published[1]
    assert ask(f"?at={published[2].t - 1e-3}") == published[1]
    assert ask("?at=1e9") == published[2]
    for selector, kind in (
        ("?at=0", "NotKept"),
        ("?revision=9", "NotKept"),
        ("?at=x", "BadInput"),
        ("?revision=-1", "BadInput"),
    ):
        _, error = bench.get(bench.keys.model + selector)
        assert error is not None
        assert error.error_type == kind
    payload, _ = bench.get(f"{bench.keys.iteration}?after=1")
    assert payload is not None
    history = wire.decode(wire.IterationHistory, payload)
    assert [report.iteration for report in history.iterations] == [2, 3]
    assert history.latest_revision == 3


def test_a_learner_without_a_state_answers_for_its_newest_revisions(start: StartBench, run: Recording) -> None:
    bench = start(state=None)
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    bench.play(run)
    published = [models.get(timeout=PATIENCE) for _ in range(3)]
    payload, _ = bench.get(f"{bench.keys.model}?revision=1")
    assert payload is not None
    assert wire.decode(wire.ModelSnapshot, payload) == published[0]
    payload, _ = bench.get(f"{bench.keys.iteration}?after=1")
    assert payload is not None
    assert [report.iteration for report in wire.decode(wire.IterationHistory, payload).iterations] == [2, 3]


def test_further_channels_are_kept_with_the_samples(start: StartBench, run: Recording) -> None:
    bench = start(signals__channels=["depth"])
    reports = bench.follow(bench.keys.iteration, wire.IterationReport)
    with_depth = Recording(run.name, run.time, {**run.columns, "depth": 5.0 + 0.01 * run.time})
    bench.play(with_depth, speed=50.0)
    report = reports.get(timeout=PATIENCE)
    depth = np.array(report.batch.channels["depth"], dtype=float)
    np.testing.assert_allclose(depth, 5.0 + 0.01 * np.array(report.batch.time), atol=1e-6)
    assert bench.health_when(lambda health: health.streams["depth"].received > 0)


def test_validation_errors_come_with_every_iteration(start: StartBench, run: Recording, tmp_path: Path) -> None:
    write(tmp_path / "V1.csv", cut(leng.recording("V1", seed=7), 60.0))
    bench = start(validation={"V1": str(tmp_path / "V1.csv")})
    reports = bench.follow(bench.keys.iteration, wire.IterationReport)
    bench.play(run)
    for _ in range(3):
        report = reports.get(timeout=PATIENCE)
    (error,) = report.validation
    samples = leng.samples(cut(leng.recording("V1", seed=7), 60.0))
    model: Model = bench.host.node.served.model
    residual = model.predict(samples.yaw_rate).damping - samples.damping
    assert (error.name, error.samples) == ("V1", len(samples))
    assert error.mae == pytest.approx(np.mean(np.abs(residual)))
    assert error.rmse == pytest.approx(np.sqrt(np.mean(residual**2)))


def test_the_ledger_of_effects_answers_a_get(start: StartBench) -> None:
    bench = start()
    payload, _ = bench.get(bench.keys.effects)
    assert payload is not None
    assert wire.decode(wire.EffectsLedger, payload).effects == ()


def test_the_learner_says_goodbye(start: StartBench) -> None:
    bench = start()
    seen: queue.Queue[str] = queue.Queue()
    bench.session.liveliness().declare_subscriber(
        bench.keys.alive, lambda sample: seen.put(str(sample.kind)), history=True
    )
    assert "PUT" in seen.get(timeout=PATIENCE)
    bench.stop()
    assert "DELETE" in seen.get(timeout=PATIENCE)


def test_lost_messages_are_counted_by_their_numbers(start: StartBench) -> None:
    bench = start()
    for number in (0, 1, 4, 5):
        bench.session.put(bench.keys.rate, wire.measurement(0.1 * number, 0.0, number))
    health = bench.health_when(lambda health: health.streams["yaw_rate"].received == 4)
    assert health.streams["yaw_rate"].lost == 2
    assert health.counters["rejected:lost"] == 2


def test_messages_that_overtake_each_other_are_not_lost(start: StartBench) -> None:
    bench = start()
    for pair in range(50):
        for number in (2 * pair + 1, 2 * pair):
            bench.session.put(bench.keys.rate, wire.measurement(0.02 * number, 0.1 * (number % 2), number))
    health = bench.health_when(lambda health: health.streams["yaw_rate"].received == 100)
    assert health.streams["yaw_rate"].lost == 0
    assert health.counters["rejected"] == 0


def test_drop_outs_and_disorder_teach_nothing_wrong(start: StartBench) -> None:
    """The same samples where the streams are whole, none across a drop-out, duplicates refused."""
    run = leng.recording("T1", seed=3)
    streams = cut(run, 200.0).streams()
    bench = start(learner__batch=20)
    reports = bench.follow(bench.keys.iteration, wire.IterationReport)
    what = messages(streams, Faults(drop_outs=6.0, drop_out_length=2.0, jitter=0.15, duplicates=0.05), seed=5)
    bench.play(what)
    whole = leng.samples(run)
    true = dict(zip(whole.time.tolist(), whole.damping.tolist(), strict=True))
    health = bench.health_when(lambda health: health.iteration >= 5)
    assert health.iteration < 200 / 0.6 / 20
    assert health.counters["rejected:duplicate"] > 0
    differences = []
    for _ in range(health.iteration):
        batch = reports.get(timeout=PATIENCE).batch
        differences += [abs(damping - true[t]) for t, damping in zip(batch.time, batch.damping, strict=True)]
    # Only a pause within the configured gap is bridged; beside one a sample has fewer values to go by.
    assert np.mean(np.array(differences) == 0.0) > 0.85
    assert max(differences) < 4.0  # the noise of a sample


def test_several_learners_share_one_process(start: StartBench, run: Recording) -> None:
    bench = start(also=[{"prefix": "leng/pitch", "vehicle": {"inertia": 300.0}}])
    first, second = bench.host.node.config.each()
    assert (first.prefix, second.prefix, second.vehicle.inertia) == ("leng/yaw", "leng/pitch", 300.0)
    assert second.learner == first.learner


def test_two_recordings_in_a_row_are_one_stream_of_batches(start: StartBench, run: Recording) -> None:
    bench = start()
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    bench.play(sequence([run, run]))
    for number in range(1, 7):
        assert models.get(timeout=PATIENCE).iteration == number


def test_a_vehicle_whose_clock_begins_anew_is_followed(start: StartBench, run: Recording) -> None:
    bench = start()
    models = bench.follow(bench.keys.model, wire.ModelSnapshot)
    bench.play(run)
    bench.play(run)
    for number in range(1, 7):
        assert models.get(timeout=PATIENCE).iteration == number
    assert bench.health().counters["rejected:clock_restarted"] == 1


def test_a_state_of_another_vehicle_is_refused_aloud(start: StartBench, run: Recording, tmp_path: Path) -> None:
    first = start(state=tmp_path)
    models = first.follow(first.keys.model, wire.ModelSnapshot)
    first.play(run)
    for _ in range(3):
        models.get(timeout=PATIENCE)
    first.stop()
    other = start(state=tmp_path, vehicle__name="other")
    _, error = other.get(other.keys.model)
    assert error is not None
    assert error.error_type == "NothingLearned"
    health = other.health()
    assert health.level == "WARN"
    assert "was learned with vehicle leng, and now vehicle is other" in health.reasons[0]


def test_what_is_rejected_is_said_once_a_second_at_most(start: StartBench, caplog: pytest.LogCaptureFixture) -> None:
    bench = start()
    changes = bench.follow(bench.keys.health, wire.Health)
    began = time.monotonic()
    sent = 0
    while sent < 300:
        bench.session.put(bench.keys.rate, b"no json", congestion_control=zenoh.CongestionControl.BLOCK)
        sent += 1
        if sent % 100 == 0:  # three waves, each seen by health before the next
            while changes.get(timeout=PATIENCE).counters.get("rejected:not_json", 0) < sent:
                pass
    said = [record.getMessage() for record in caplog.records if "values rejected so far" in record.getMessage()]
    assert 1 <= len(said) <= 1 + (time.monotonic() - began)
    assert "'rejected:not_json': " in said[-1]
