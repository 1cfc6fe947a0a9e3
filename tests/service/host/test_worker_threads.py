"""The threads of a process with several learners: what goes wrong with one is said and costs the others nothing."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from service import wire
from service.bus.session import client_config_at, free_endpoint, listener_config_at, open_session
from service.config.configuration import Config
from service.host.host import Host
from service.host.worker_threads import WorkerThreads
from service.state.store import Store
from simulator import leng
from tests.service.conftest import PATIENCE, Bench, configured, teach


def test_a_learner_that_lost_its_bus_ends_neither_the_learning_of_others_nor_its_own_samples(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    first, second = (configured(prefix=f"{name}/yaw", state=tmp_path) for name in ("one", "two"))
    endpoint = free_endpoint()
    with ExitStack() as stack:
        lost: Any = stack.enter_context(open_session(listener_config_at(free_endpoint())))
        session = stack.enter_context(open_session(listener_config_at(endpoint)))
        hosts = [Host(lost, first), Host(session, second)]
        with WorkerThreads(hosts):
            client = stack.enter_context(open_session(client_config_at(endpoint), PATIENCE))
            bench = Bench(hosts[1], hosts, client, hosts[1].keys, lambda: None)
            reports = bench.follow(bench.keys.iteration, wire.IterationReport)
            lost.close()
            for name, (t, value) in leng.recording("T1", 1).streams().items():
                hosts[0].node.push(name, t[t < 50.0], value[t < 50.0])
            for last in (40.0, 80.0):
                teach(client, bench.keys, 1, last - 40.0, last)
                assert reports.get(timeout=PATIENCE).trained
            reasons = hosts[0].watch.report(hosts[0].node).reasons
            assert "what was learned could not be published: session closed" in reasons
    assert _kept(first) == (1, 50.0)
    assert _kept(second)[0] == 2
    assert "a fault of this program" in caplog.text


def _kept(config: Config) -> tuple[int, float]:
    """The revision that a state holds, and up to when it has samples [s]."""
    assert config.state is not None
    store = Store(config.state, config)
    memory = store.memory
    store.close()
    assert memory is not None
    return memory["revision"], round(memory["on_the_way"]["waiting"]["time"][-1], -1)
