"""The page of a vehicle whose axes are learned together shows the axis that a browser asks for."""

from __future__ import annotations

import re
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from service import wire
from service.bus.session import client_config_at
from service.config.vehicle_file import learners_in, write_vehicle
from simulator.vehicles import BODIES
from tests.service.conftest import benches
from tests.vehicle_of_body import vehicle_of
from tests.viewer.test_page import drawn
from viewer.page.learner import Learner
from viewer.page.server import ours, server

BOAT = vehicle_of(BODIES["boat"](np.random.default_rng(82)), (1.0, 0.4, 0.0, 0.0, 0.0, 0.5))


@pytest.fixture
def learner(tmp_path: Path) -> Iterator[Learner]:
    """The page's view of the yaw of a boat, of which two streams came in."""
    write_vehicle(tmp_path / "boat.yaml", BOAT)
    with benches() as begin:
        bench = begin(learners=learners_in(tmp_path / "boat.yaml"), prefix="boat")
        bench.session.put("boat/surge/rate", wire.measurement((1.0, 1.1), (0.5, 0.6)))
        bench.session.put("boat/yaw/channel/heading", wire.measurement(1.0, 0.3))
        bench.health_when(lambda health: {"surge", "heading"} <= health.streams.keys())
        learner = Learner(client_config_at(bench.endpoint), bench.endpoint, "boat/yaw")
        yield learner
        learner.close()


def test_an_axis_is_answered_where_it_is_asked_for(learner: Learner) -> None:
    first, surge = learner.of_axis(None), learner.of_axis("surge")
    assert (first["prefix"], surge["prefix"]) == ("boat/yaw", "boat/surge")
    assert (first["units"]["surge"], first["units"]["heading"]) == ("m/s", "rad")
    assert surge["words"]["title"] == "Surge"
    assert list(first["health"]["axes"]) == ["yaw", "surge"]
    assert surge["health"]["streams"]["yaw_rate"]["value"] == 0.6
    assert learner.of_axis("heave")["prefix"] == "boat/yaw", "no such axis is learned"


@pytest.mark.slow
def test_a_browser_shows_the_axis_of_its_address(learner: Learner, tmp_path: Path) -> None:
    with server("127.0.0.1", 0, learner, ours("127.0.0.1", [])) as served:
        threading.Thread(target=served.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True).start()
        document = drawn(f"http://127.0.0.1:{served.server_address[1]}/?axis=surge", tmp_path / "browser")
        served.shutdown()
    assert re.search(r"Surge damping</span> of <span[^>]*>boat/surge<", document)
    assert [re.sub(".*axis=", "", link) for link in re.findall(r'href="\?axis=\w+', document)] == ["yaw", "surge"]
