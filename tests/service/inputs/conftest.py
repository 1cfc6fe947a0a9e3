"""A vessel's bus: a router that is no learner, the learner as a client of it, and somebody who publishes there."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zenoh

from service.bus import mapped_ingest
from service.bus.session import client_config_at, free_endpoint, listener_config_at, open_session
from service.config.configuration import Config
from service.config.sources import read
from service.host.host import Host
from service.host.worker_threads import WorkerThreads
from service.wire import Health
from tests.service.conftest import PATIENCE, Bench

BURST = 4000
"""Messages that are sent before it is waited for them: half of what a queue of the learner holds."""
VEHICLE = {"inertia": 0.6, "rate_range": (-2.8, 2.8), "rate_limit": 6.0, "torque_limit": 40.0}
"""What tests.service.logs.dive turns."""
SIGNALS = {"sample_period": 0.4, "smoothing": 0.1}
LEARNER = {"gamma": 0.2, "C": 60.0, "epsilon": 0.006, "near_rate": 0.07, "near_damping": 0.3, "batch": 25}


@dataclass(frozen=True)
class Vessel(Bench):
    """A learner that listens to the vehicle's bus, and the bus: `session` publishes."""

    endpoint: str

    def put(self, key: str, payload: bytes, encoding: str = "application/json") -> None:
        self.session.put(key, payload, encoding=encoding, congestion_control=zenoh.CongestionControl.BLOCK)

    def rates(self) -> int:
        return self.health().streams["yaw_rate"].received

    def send(self, messages: list[tuple[str, bytes]], rates: int, encoding: str = "application/json") -> Health:
        """Puts messages of which so many hold a yaw rate, as fast as they are taken; returns the health after them."""
        wanted = self.rates() + rates
        for first in range(0, len(messages), BURST):
            sent = messages[first : first + BURST]
            for key, payload in sent:
                self.put(key, payload, encoding)
            part = min(first + BURST, len(messages)) / len(messages)
            self._come(wanted - rates + round(rates * part) - 20)
        self._come(wanted)
        counts = list[dict[str, int]]()

        def rests(health: Health) -> bool:
            counts.append({name: stream.received for name, stream in health.streams.items()})
            return len(counts) > 1 and counts[-1] == counts[-2]

        return self.health_when(rests)  # a message's streams are counted one after the other

    def _come(self, rates: int) -> Health:
        return self.health_when(lambda health: health.streams["yaw_rate"].received >= rates)

    def off(self) -> float:
        """Mean error of the served curve against the dive's drag over the rates it was learned on [N m]."""
        model = self.host.node.served.model
        low, high = model.trained_range or (0.0, 0.0)
        rate = np.linspace(low, high, 50)
        return float(np.abs(model.predict(rate).damping - 0.6 * rate - 1.6 * rate * np.abs(rate)).mean())


Board = Callable[..., Vessel]


@pytest.fixture
def board(monkeypatch: pytest.MonkeyPatch) -> Iterator[Board]:
    """Starts a learner on a vessel's bus; `inputs` is the section of that name, `state` where it is kept."""
    monkeypatch.setattr(mapped_ingest, "GRACE_S", 0.3)  # what is missing is said at once
    with ExitStack() as outer, ExitStack() as stack:

        def begin(inputs: dict[str, Any], state: Path | None = None, **more: Any) -> Vessel:
            endpoint = free_endpoint()
            outer.enter_context(open_session(listener_config_at(endpoint)))
            session = stack.enter_context(open_session(client_config_at(endpoint), PATIENCE))
            host = Host(session, configured(inputs, state, **more))
            crew = stack.enter_context(ExitStack())
            crew.enter_context(WorkerThreads([host]))
            client = outer.enter_context(open_session(client_config_at(endpoint), PATIENCE))
            return Vessel(host, [host], client, host.keys, crew.close, endpoint)

        yield begin


def configured(inputs: dict[str, Any], state: Path | None = None, **more: Any) -> Config:
    said = {
        "state": None if state is None else str(state),
        "inputs": inputs,
        "vehicle": VEHICLE,
        "signals": SIGNALS,
        "learner": LEARNER,
    }
    return read(None, {**said, **more})
