"""A secured bus as `incsvr keys` makes it, on loopback: each role may do what its row of the table says, and no more.

No test waits for what must not come. Zenoh delivers in order, so once a client's later question has been answered, what
it sent before has been let through or denied; and a question that is denied ends at once, without an answer.
"""

from __future__ import annotations

import json
import queue
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import zenoh
from zenoh.ext import (
    CacheConfig,
    HistoryConfig,
    RecoveryConfig,
    declare_advanced_publisher,
    declare_advanced_subscriber,
)

from incsvr.errors import BadInput
from service import wire
from service.cli import main
from service.crew import Crew
from service.host import Host
from service.session import connecting, free_endpoint, from_file, open_session
from simulator import leng
from simulator.recordings import write
from tests.service.conftest import PATIENCE, configured, teach

KEYS = wire.Keys("rov7/yaw")
UNSERVED = wire.Keys("rov7/pitch")
"""A prefix of the same access control below which no learner answers, so that every answer there is a forgery."""
FORGED = b"forged"

TABLE = """
                            vehicle  viewer  operator
publish the rate              yes      no       no
publish the torque            yes      no       no
publish a channel             yes      no       no
publish a model               no       no       no
publish an iteration          no       no       no
publish the health            no       no       no
publish the effects           no       no       no
publish on every key          no       no       no
hear the rate                 no       yes      yes
hear a channel                no       yes      yes
hear the model                yes      yes      yes
hear the iteration            no       yes      yes
hear the health               yes      yes      yes
hear the effects              no       yes      yes
hear the estimate             yes      yes      yes
hear every key                no       yes      yes
see that it is alive          yes      yes      yes
ask the damping               yes      yes      yes
ask the forecast              yes      yes      yes
ask the model                 yes      yes      yes
ask the health                yes      yes      yes
ask the iteration             no       yes      yes
ask the effects               no       yes      yes
promote an effect             no       no       yes
withdraw an effect            no       no       yes
get the model's history       yes      yes      yes
get the iterations' history   no       yes      yes
answer the damping            no       no       no
answer the health             no       no       no
answer the model              no       no       no
answer for its history        no       no       no
say that it is alive          no       no       no
"""
CELLS = [
    (line[:28].strip(), role, word == "yes")
    for line in TABLE.strip("\n").splitlines()[1:]
    for role, word in zip(("vehicle", "viewer", "operator"), line[28:].split(), strict=True)
]


@dataclass(frozen=True)
class Secured:
    """A learner that has learned, in a session of the learner's role, and a client in every other role."""

    folder: Path
    endpoint: str
    learner: zenoh.Session
    clients: dict[str, zenoh.Session]


@pytest.fixture(scope="module")
def bus(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Secured]:
    folder = tmp_path_factory.mktemp("keys")
    endpoint = free_endpoint().replace("tcp/", "tls/")
    prefixes = ["--prefix", KEYS.prefix, "--prefix", UNSERVED.prefix]
    assert main(["keys", str(folder), *prefixes, "--listen", endpoint]) == 0
    with ExitStack() as stack:
        learner = stack.enter_context(open_session(from_file(folder / "learner.json5")))
        config = configured(prefix=KEYS.prefix, state=tmp_path_factory.mktemp("state"))
        stack.enter_context(Crew([Host(learner, config)]))
        clients = {
            role: stack.enter_context(open_session(from_file(folder / f"{role}.json5"), PATIENCE))
            for role in ("vehicle", "viewer", "operator")
        }
        models: queue.Queue[Any] = queue.Queue()
        clients["viewer"].declare_subscriber(KEYS.model, models.put)
        until_settled(clients["viewer"])
        teach(clients["vehicle"], KEYS, 6, 0.0, 40.0)
        models.get(timeout=PATIENCE)
        yield Secured(folder, endpoint, learner, clients)


def until_settled(client: zenoh.Session) -> None:
    """Returns once all that the client has sent and declared has been let through or denied."""
    until = time.monotonic() + PATIENCE
    # A session that has just been opened may not know yet who answers; its question ends at once then.
    while not list(client.get(KEYS.health, timeout=PATIENCE)):
        assert time.monotonic() < until, "the learner does not answer for its health"


def publishes(bus: Secured, role: str, key: str) -> bool:
    """Whether the learner's session, and so anybody behind it, receives what the role publishes."""
    heard: queue.Queue[bytes] = queue.Queue()
    subscriber: Any = bus.learner.declare_subscriber(
        f"{UNSERVED.prefix}/**", lambda sample: heard.put(sample.payload.to_bytes())
    )
    bus.clients[role].put(key, FORGED)
    until_settled(bus.clients[role])
    subscriber.undeclare()
    return not heard.empty()


def hears(bus: Secured, role: str, key: str, subscribed: str | None = None) -> bool:
    """Whether the role's subscription, to that very key unless another is given, is served with what comes on a key."""
    client, heard = bus.clients[role], queue.Queue[Any]()
    subscriber: Any = client.declare_subscriber(subscribed or key, heard.put)
    until_settled(client)
    bus.learner.put(key, b"{}")
    until_settled(client)
    subscriber.undeclare()
    return not heard.empty()


def is_answered(bus: Secured, role: str, key: str) -> bool:
    """Whether the role's question reaches who answers in the learner's session."""
    queryable: Any = bus.learner.declare_queryable(key, lambda query: query.reply(key, b"{}"))
    until_settled(bus.clients[role])
    replies = list(bus.clients[role].get(key, timeout=PATIENCE))
    queryable.undeclare()
    return bool(replies)


def gets_history(bus: Secured, role: str, key: str) -> bool:
    """Whether the role gets what Zenoh keeps for those who come late, by the question that its library asks."""
    replies = list(bus.clients[role].get(f"{key}/@adv/**?_anyke;_max=1", timeout=PATIENCE))
    return any(reply.ok is not None and str(reply.ok.key_expr) == key for reply in replies)


def answers(bus: Secured, role: str, key: str) -> bool:
    """Whether another client or the learner itself gets an answer of this role; there is no other answer."""
    other = bus.clients["viewer" if role == "operator" else "operator"]
    queryable: Any = bus.clients[role].declare_queryable(key, lambda query: query.reply(key, FORGED), complete=True)
    until_settled(bus.clients[role])
    found = [reply for asker in (other, bus.learner) for reply in asker.get(key, timeout=PATIENCE)]
    queryable.undeclare()
    return bool(found)


def keeps_history(bus: Secured, role: str, key: str) -> bool:
    """Whether those who come late get a model of this role's."""
    client = bus.clients[role]
    publisher: Any = declare_advanced_publisher(
        client,
        key,
        cache=CacheConfig(max_samples=1),
        publisher_detection=True,
    )
    publisher.put(FORGED)
    until_settled(client)
    selector = f"{key}/@adv/**?_anyke;_max=1"
    other = bus.clients["viewer" if role == "operator" else "operator"]
    asked = [reply for asker in (other, bus.learner) for reply in asker.get(selector, timeout=PATIENCE)]
    tokens = list(bus.learner.liveliness().get(f"{key}/@adv/**", timeout=PATIENCE))
    publisher.undeclare()
    return bool(asked or tokens)


def says_alive(bus: Secured, role: str) -> bool:
    token: Any = bus.clients[role].liveliness().declare_token(UNSERVED.alive)
    until_settled(bus.clients[role])
    found = list(bus.learner.liveliness().get(UNSERVED.alive, timeout=PATIENCE))
    token.undeclare()
    return bool(found)


def sees_alive(bus: Secured, role: str) -> bool:
    return bool(list(bus.clients[role].liveliness().get(KEYS.alive, timeout=PATIENCE)))


ACTIONS: dict[str, Callable[[Secured, str], bool]] = {
    "publish the rate": lambda bus, role: publishes(bus, role, UNSERVED.rate),
    "publish the torque": lambda bus, role: publishes(bus, role, UNSERVED.torque),
    "publish a channel": lambda bus, role: publishes(bus, role, UNSERVED.stream("depth")),
    "publish a model": lambda bus, role: publishes(bus, role, UNSERVED.model),
    "publish an iteration": lambda bus, role: publishes(bus, role, UNSERVED.iteration),
    "publish the health": lambda bus, role: publishes(bus, role, UNSERVED.health),
    "publish the effects": lambda bus, role: publishes(bus, role, UNSERVED.effects),
    "publish on every key": lambda bus, role: publishes(bus, role, f"{UNSERVED.prefix}/**"),
    "hear the rate": lambda bus, role: hears(bus, role, UNSERVED.rate),
    "hear a channel": lambda bus, role: hears(bus, role, UNSERVED.stream("depth")),
    "hear the effects": lambda bus, role: hears(bus, role, UNSERVED.effects),
    "hear the estimate": lambda bus, role: hears(bus, role, f"{UNSERVED.prefix}/estimate"),
    "hear every key": lambda bus, role: hears(bus, role, UNSERVED.model, subscribed=f"{UNSERVED.prefix}/**"),
    "hear the model": lambda bus, role: hears(bus, role, UNSERVED.model),
    "hear the iteration": lambda bus, role: hears(bus, role, UNSERVED.iteration),
    "hear the health": lambda bus, role: hears(bus, role, UNSERVED.health),
    "see that it is alive": sees_alive,
    "ask the damping": lambda bus, role: is_answered(bus, role, UNSERVED.damping),
    "ask the forecast": lambda bus, role: is_answered(bus, role, f"{UNSERVED.prefix}/forecast"),
    "ask the model": lambda bus, role: is_answered(bus, role, UNSERVED.model),
    "ask the health": lambda bus, role: is_answered(bus, role, UNSERVED.health),
    "ask the iteration": lambda bus, role: is_answered(bus, role, UNSERVED.iteration),
    "ask the effects": lambda bus, role: is_answered(bus, role, UNSERVED.effects),
    "promote an effect": lambda bus, role: is_answered(bus, role, f"{UNSERVED.effects}/promote"),
    "withdraw an effect": lambda bus, role: is_answered(bus, role, f"{UNSERVED.effects}/withdraw"),
    "get the model's history": lambda bus, role: gets_history(bus, role, KEYS.model),
    "get the iterations' history": lambda bus, role: gets_history(bus, role, KEYS.iteration),
    "answer the damping": lambda bus, role: answers(bus, role, UNSERVED.damping),
    "answer the health": lambda bus, role: answers(bus, role, UNSERVED.health),
    "answer the model": lambda bus, role: answers(bus, role, UNSERVED.model),
    "answer for its history": lambda bus, role: keeps_history(bus, role, UNSERVED.model),
    "say that it is alive": says_alive,
}


@pytest.mark.parametrize(("action", "role", "may"), CELLS, ids=lambda value: str(value).replace(" ", "-"))
def test_a_role_may_do_what_the_table_says(bus: Secured, action: str, role: str, may: bool) -> None:
    assert ACTIONS[action](bus, role) is may


@pytest.mark.parametrize("mode", ["client", "peer", "router"])
def test_beside_the_learner_a_forger_is_not_heard(bus: Secured, mode: str) -> None:
    """It answers, publishes and keeps models where the learner does, also where it says that it is a router itself."""
    config = from_file(bus.folder / "viewer.json5")
    config.insert_json5("mode", json.dumps(mode))
    config.insert_json5("listen/endpoints", "[]")
    asker = bus.clients["operator"]
    heard: queue.Queue[bytes] = queue.Queue()
    with open_session(config, PATIENCE) as forger:
        forger.declare_queryable(KEYS.damping, lambda query: query.reply(KEYS.damping, FORGED), complete=True)
        publisher: Any = declare_advanced_publisher(
            forger, KEYS.model, cache=CacheConfig(max_samples=1), publisher_detection=True
        )
        publisher.put(FORGED)
        until_settled(forger)
        late: Any = declare_advanced_subscriber(
            asker,
            KEYS.model,
            lambda sample: heard.put(sample.payload.to_bytes()),
            history=HistoryConfig(detect_late_publishers=True, max_samples=1),
            recovery=RecoveryConfig(periodic_queries=None, heartbeat=True),
        )
        assert wire.decode(wire.ModelSnapshot, heard.get(timeout=PATIENCE)).revision == 1
        for key in (f"{KEYS.damping}?rate=0.1", f"{KEYS.model}/@adv/**?_anyke;_max=1"):
            replies = list(asker.get(key, target=zenoh.QueryTarget.ALL, timeout=PATIENCE))
            assert [reply.ok is not None and reply.ok.payload.to_bytes() != FORGED for reply in replies] == [True]
        publisher.put(FORGED)
        until_settled(forger)
        until_settled(asker)
        late.undeclare()
    assert heard.empty()


def test_a_clients_certificate_cannot_play_the_learner(bus: Secured, tmp_path: Path) -> None:
    """Where the learner is away and its port is free, its clients refuse who listens there."""
    endpoint = free_endpoint().replace("tcp/", "tls/")
    for role in ("learner", "vehicle"):
        text = (bus.folder / f"{role}.json5").read_text(encoding="utf-8").replace(bus.endpoint, endpoint)
        text = text.replace("learner.pem", "viewer.pem").replace("learner.key", "viewer.key")
        (tmp_path / f"{role}.json5").write_text(text, encoding="utf-8")
    with open_session(from_file(tmp_path / "learner.json5")), pytest.raises(BadInput, match="cannot be opened"):
        open_session(from_file(tmp_path / "vehicle.json5"))


def test_without_a_certificate_of_the_authority_nobody_comes_in(bus: Secured, tmp_path: Path) -> None:
    assert main(["keys", str(tmp_path), "--role", "vehicle", "--listen", bus.endpoint]) == 0
    (tmp_path / "ca.pem").write_bytes((bus.folder / "ca.pem").read_bytes())
    stranger = from_file(tmp_path / "vehicle.json5")
    for config in (connecting(bus.endpoint.replace("tls/", "tcp/")), connecting(bus.endpoint), stranger):
        with pytest.raises(BadInput, match="the bus cannot be opened"):
            open_session(config)


@pytest.mark.parametrize(("role", "status"), [("viewer", 1), ("vehicle", 0)])
def test_a_player_that_is_not_heard_says_so_at_once(bus: Secured, tmp_path: Path, role: str, status: int) -> None:
    run = leng.recording("V1", seed=1)
    write(tmp_path / "run.csv", run)
    words = ["--prefix", KEYS.prefix, "--set", f"bus.zenoh_file={bus.folder / f'{role}.json5'}", "--speed", "200"]
    done = subprocess.run(
        [sys.executable, "-m", "service.cli", "replay", str(tmp_path / "run.csv"), *words],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == status, done.stderr
    refusal = f"receives nothing on {KEYS.rate} and {KEYS.torque}: this client may not publish there"
    assert (refusal in done.stderr) is (role == "viewer")
    assert "Traceback" not in done.stderr
