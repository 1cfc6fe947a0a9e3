"""A secured bus as `incsvr keys` makes it, on loopback: each role may do what its row of the table says, and no more.

No test waits for what must not come. Zenoh delivers in order, so once a client's later question has been answered, what
it sent before has been let through or denied; and a question that is denied ends at once, without an answer.
"""

from __future__ import annotations

import queue
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from zenoh import CongestionControl
from zenoh.ext import CacheConfig, declare_advanced_publisher

from tests.service.conftest import PATIENCE
from tests.service.security.secured import FORGED, KEYS, UNSERVED, Secured, secured, until_settled

BLOCK = CongestionControl.BLOCK
"""On a busy machine a message that may be dropped is, and says nothing of the roles."""

TABLE = """
                            vehicle  viewer  operator
publish rate                  yes      no       no
publish torque                yes      no       no
publish channel/depth         yes      no       no
publish model                 no       no       no
publish iteration             no       no       no
publish health                no       no       no
publish effects               no       no       no
publish **                    no       no       no
hear rate                     no       yes      yes
hear channel/depth            no       yes      yes
hear model                    yes      yes      yes
hear iteration                no       yes      yes
hear health                   yes      yes      yes
hear effects                  no       yes      yes
hear estimate                 yes      yes      yes
hear event                    yes      yes      yes
hear-all **                   no       yes      yes
see alive                     yes      yes      yes
ask damping                   yes      yes      yes
ask forecast                  yes      yes      yes
ask feedforward               yes      yes      yes
ask model                     yes      yes      yes
ask health                    yes      yes      yes
ask iteration                 no       yes      yes
ask effects                   no       yes      yes
ask effects/promote           no       no       yes
ask effects/withdraw          no       no       yes
history-of model              yes      yes      yes
history-of iteration          no       yes      yes
answer damping                no       no       no
answer health                 no       no       no
answer model                  no       no       no
keep model                    no       no       no
say alive                     no       no       no
"""
ATTEMPTS = 10
"""Messages that are sent before a role counts as not hearing them: one that may hear them needs one, seldom two."""
CELLS = [
    (line[:28].strip(), role, word == "yes")
    for line in TABLE.strip("\n").splitlines()[1:]
    for role, word in zip(("vehicle", "viewer", "operator"), line[28:].split(), strict=True)
]


@pytest.fixture(scope="module")
def bus(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Secured]:
    with secured(tmp_path_factory.mktemp("keys"), tmp_path_factory.mktemp("state")) as found:
        yield found


def publishes(bus: Secured, role: str, key: str) -> bool:
    """Whether the learner's session, and so anybody behind it, receives what the role publishes."""
    heard: queue.Queue[bytes] = queue.Queue()
    subscriber: Any = bus.learner.declare_subscriber(
        f"{UNSERVED.prefix}/**", lambda sample: heard.put(sample.payload.to_bytes())
    )
    for _ in range(ATTEMPTS):
        bus.clients[role].put(key, FORGED, congestion_control=BLOCK)
        until_settled(bus.clients[role])
        if not heard.empty():
            break
    subscriber.undeclare()
    return not heard.empty()


def hears(bus: Secured, role: str, key: str, subscribed: str | None = None) -> bool:
    """Whether the role's subscription, to that very key unless another is given, is served with what comes on a key."""
    client, heard = bus.clients[role], queue.Queue[Any]()
    subscriber: Any = client.declare_subscriber(subscribed or key, heard.put)
    for _ in range(ATTEMPTS):  # a route may be known only after the answer that came behind its declaration
        until_settled(client)
        bus.learner.put(key, b"{}", congestion_control=BLOCK)
        until_settled(client)
        if not heard.empty():
            break
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


VERBS: dict[str, Callable[[Secured, str, str], bool]] = {
    "publish": lambda bus, role, key: publishes(bus, role, f"{UNSERVED.prefix}/{key}"),
    "hear": lambda bus, role, key: hears(bus, role, f"{UNSERVED.prefix}/{key}"),
    "hear-all": lambda bus, role, key: hears(bus, role, UNSERVED.model, subscribed=f"{UNSERVED.prefix}/{key}"),
    "see": lambda bus, role, _: sees_alive(bus, role),
    "ask": lambda bus, role, key: is_answered(bus, role, f"{UNSERVED.prefix}/{key}"),
    "history-of": lambda bus, role, key: gets_history(bus, role, f"{KEYS.prefix}/{key}"),
    "answer": lambda bus, role, key: answers(bus, role, f"{UNSERVED.prefix}/{key}"),
    "keep": lambda bus, role, key: keeps_history(bus, role, f"{UNSERVED.prefix}/{key}"),
    "say": lambda bus, role, _: says_alive(bus, role),
}


@pytest.mark.parametrize(("action", "role", "may"), CELLS, ids=lambda value: str(value).replace(" ", "-"))
def test_a_role_may_do_what_the_table_says(bus: Secured, action: str, role: str, may: bool) -> None:
    verb, key = action.split()
    assert VERBS[verb](bus, role, key) is may
