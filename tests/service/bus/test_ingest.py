"""What comes in: bounded by the ring, and nothing that is no number goes on, on a channel neither."""

from __future__ import annotations

import time

import numpy as np
import pytest

from service import wire
from service.bus.ingest import MIN_RING_PLACES, QUEUE_BYTES, RING_PLACES, Feed, Ingest
from service.bus.session import free_endpoint, listener_config_at, open_session
from service.health.health_watch import HealthWatch
from service.host.worker_threads import MANY_WAITING
from service.learner.node import LearnerNode
from tests.service.conftest import PATIENCE, StartBench, configured, teach

KEYS = wire.Keys("leng/yaw")


def test_of_what_is_not_taken_in_time_the_newest_is_kept() -> None:
    config = configured()
    node, watch = LearnerNode(config, boot=""), HealthWatch(config.health, time.monotonic(), time.monotonic)
    with open_session(listener_config_at(free_endpoint())) as session:
        feed = Feed(node, watch, [Ingest(session, KEYS, watch, learners=RING_PLACES)])
        for number in range(MIN_RING_PLACES + 136):  # within a session a put is with its subscriber when it returns
            session.put(KEYS.rate, wire.measurement(0.02 * number, 0.0, number))
        feed.drain()
        feed.close()
    stream = watch.report(node).streams["yaw_rate"]
    assert stream.received == MIN_RING_PLACES
    assert stream.t == pytest.approx(0.02 * (MIN_RING_PLACES + 135))


def test_what_waits_is_bounded_by_its_bytes_and_what_goes_for_it_is_counted() -> None:
    config = configured()
    node, watch = LearnerNode(config, boot=""), HealthWatch(config.health, time.monotonic(), time.monotonic)
    large = wire.measurement(tuple(np.arange(40_000) / 50.0), (0.1,) * 40_000)
    sent = QUEUE_BYTES // len(large) + 10
    with open_session(listener_config_at(free_endpoint())) as session:
        feed = Feed(node, watch, [Ingest(session, KEYS, watch)])
        for _ in range(sent):
            session.put(KEYS.torque, large)
        session.put(KEYS.rate, wire.measurement(1.0, 0.1))
        feed.drain()
        counters = watch.report(node).counters
        assert counters["rejected:queue_full"] >= 10
        assert watch.report(node).streams["yaw_rate"].received == 1  # a flood of the other stream does not hold it up
        while watch.report(node).streams["torque"].received < 40_000 * (sent - counters["rejected:queue_full"]):
            feed.drain()
        feed.close()
    assert "values rejected: queue full" in " ".join(watch.report(node).reasons)


def test_few_large_messages_are_read_as_early_as_many_small_ones() -> None:
    """A turn of reading takes a megabyte: 400,000 values a second in arrays were lost when messages alone counted."""
    config = configured()
    node, watch = LearnerNode(config, boot=""), HealthWatch(config.health, time.monotonic(), time.monotonic)
    large = wire.measurement(tuple(np.arange(40_000) / 50.0), (0.1,) * 40_000)
    with open_session(listener_config_at(free_endpoint())) as session:
        feed = Feed(node, watch, [Ingest(session, KEYS, watch)])
        session.put(KEYS.rate, wire.measurement(1.0, 0.1))
        assert 0.0 < feed.waiting() < 0.01
        session.put(KEYS.torque, large)
        session.put(KEYS.torque, large)
        assert feed.waiting() > MANY_WAITING
        feed.close()


@pytest.mark.parametrize("declared", [[], ["depth"]])
def test_an_infinite_value_of_a_channel_costs_no_batch(start: StartBench, declared: list[str]) -> None:
    bench = start(signals__channels=declared)
    reports = bench.follow(bench.keys.iteration, wire.IterationReport)
    for t, value in ((0.0, "1.0"), (5.0, "2.0"), (10.0, "1e999"), (15.0, "Infinity"), (40.0, "3.0"), (45.0, "3.0")):
        bench.session.put(bench.keys.stream("depth"), f'{{"t": {t}, "value": {value}}}')
    teach(bench.session, bench.keys, 1, 0.0, 40.0)
    report = reports.get(timeout=PATIENCE)
    assert report.revision == 1
    assert set(report.batch.channels["depth"]) <= {1.0, 2.0, None}
    assert bench.health_when(lambda health: health.counters.get("rejected:not_finite", 0) == 2)
