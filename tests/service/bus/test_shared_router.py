"""A router that two vehicles and a shore share, made by `incsvr keys --router`: each vehicle has its own keys alone."""

from __future__ import annotations

import queue
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import pytest
import zenoh

from incsvr.errors import BadInput
from service import wire
from service.bus.session import free_endpoint, from_file, open_session
from service.cli.command_line import main
from service.commands.keys import Place, make
from service.host.host import Host
from service.host.worker_threads import WorkerThreads
from tests.service.conftest import PATIENCE, configured, teach

FIRST, SECOND = wire.Keys("crab/yaw"), wire.Keys("eel/yaw")


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, zenoh.Session]]:
    """Sessions by role; a learner that has learned speaks in each vehicle's."""
    folder = tmp_path_factory.mktemp("keys")
    endpoint = free_endpoint().replace("tcp/", "tls/")
    prefixes = ["--prefix", FIRST.prefix, "--prefix", SECOND.prefix]
    assert main(["keys", str(folder), "--router", *prefixes, "--listen", endpoint]) == 0
    with ExitStack() as stack:
        names = ("router", "crab", "eel", "viewer", "operator")
        sessions = {
            name: stack.enter_context(open_session(from_file(folder / f"{name}.json5"), PATIENCE)) for name in names
        }
        for name, keys in (("crab", FIRST), ("eel", SECOND)):
            config = configured(prefix=keys.prefix, state=tmp_path_factory.mktemp(name))
            stack.enter_context(WorkerThreads([Host(sessions[name], config)]))
            models: queue.Queue[Any] = queue.Queue()
            sessions["viewer"].declare_subscriber(keys.model, models.put)
            sensors = stack.enter_context(open_session(from_file(folder / f"{name}.json5"), PATIENCE))
            settled(sensors, keys)
            settled(sessions["viewer"], keys)
            teach(sensors, keys, 6, 0.0, 40.0)
            models.get(timeout=PATIENCE)
        yield sessions


def settled(session: zenoh.Session, keys: wire.Keys) -> None:
    """Returns once what the session has declared and sent has been let through or denied."""
    for _ in range(1000):
        if answered(session, keys.health):
            return
    raise AssertionError(f"{keys.health} is not answered")


def answered(session: zenoh.Session, key: str) -> bool:
    return any(reply.ok is not None for reply in session.get(key, timeout=PATIENCE))


@pytest.mark.parametrize("keys", [FIRST, SECOND])
@pytest.mark.parametrize("role", ["viewer", "operator"])
def test_the_shore_asks_every_vehicle(shared: dict[str, zenoh.Session], role: str, keys: wire.Keys) -> None:
    settled(shared[role], keys)
    assert answered(shared[role], f"{keys.damping}?rate=0.1")
    assert answered(shared[role], keys.iteration)


def test_a_vehicle_asks_itself_and_no_other(shared: dict[str, zenoh.Session]) -> None:
    assert answered(shared["crab"], f"{FIRST.damping}?rate=0.1")
    assert not answered(shared["crab"], f"{SECOND.damping}?rate=0.1")
    assert not answered(shared["crab"], SECOND.health)


def test_a_vehicle_measures_for_itself_and_for_no_other(shared: dict[str, zenoh.Session]) -> None:
    """Zenoh delivers in order: the router has judged what was put before it answers the later question."""
    before = received(shared, SECOND)
    teach(shared["crab"], SECOND, 1, 100.0, 105.0)
    assert answered(shared["crab"], FIRST.health)
    assert received(shared, SECOND) == before
    own = received(shared, FIRST)
    teach(shared["crab"], FIRST, 1, 100.0, 105.0)
    while received(shared, FIRST) == own:
        pass


def received(shared: dict[str, zenoh.Session], keys: wire.Keys) -> int:
    """How many yaw rates a learner has heard."""
    reply = next(iter(shared["viewer"].get(keys.health, timeout=PATIENCE)))
    assert reply.ok is not None
    return wire.decode(wire.Health, reply.ok.payload.to_bytes()).streams["yaw_rate"].received


def test_a_vehicle_answers_for_no_other(shared: dict[str, zenoh.Session]) -> None:
    with shared["crab"].declare_queryable(SECOND.damping, lambda query: query.reply(SECOND.damping, b"forged")):
        settled(shared["crab"], FIRST)
        replies = shared["viewer"].get(
            f"{SECOND.damping}?rate=0.1",
            target=zenoh.QueryTarget.ALL,
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=PATIENCE,
        )
        answers = [reply.ok for reply in replies]
    assert [answer.payload.to_bytes() != b"forged" for answer in answers if answer is not None] == [True]


def test_viewers_promote_nothing(shared: dict[str, zenoh.Session]) -> None:
    settled(shared["operator"], FIRST)
    assert not answered(shared["viewer"], f"{FIRST.prefix}/effects/promote?effect=inertia")
    assert list(shared["operator"].get(f"{FIRST.prefix}/effects/promote?effect=inertia", timeout=PATIENCE))


def test_a_vehicle_is_called_as_nothing_else_is(capsys: pytest.CaptureFixture[str], tmp_path: Any) -> None:
    assert main(["keys", str(tmp_path), "--router", "--prefix", "viewer/yaw"]) != 0
    assert "no vehicle may be called viewer" in capsys.readouterr().err


def test_a_vehicle_that_joins_later_gets_keys_of_the_same_authority(tmp_path: Any) -> None:
    place = Place(tmp_path, tmp_path, "tls/127.0.0.1:7447", ("crab/yaw",), shared=True)
    make(place, ("127.0.0.1",), owner=None, replace=False)
    authority = (tmp_path / "ca.pem").read_bytes()
    larger = Place(tmp_path, tmp_path, "tls/127.0.0.1:7447", ("crab/yaw", "eel/yaw"), shared=True)
    assert make(larger, ("127.0.0.1",), ["eel"], owner=None, replace=False) == ("eel",)
    assert (tmp_path / "ca.pem").read_bytes() == authority
    with pytest.raises(BadInput, match="already contains a key of the router"):
        make(larger, ("127.0.0.1",), ["router"], owner=None, replace=False)
