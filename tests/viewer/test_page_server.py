"""The page's server among clients that break off, are silent, are many, or come from a foreign site."""

from __future__ import annotations

import json
import socket
import struct
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from http.client import HTTPConnection

import pytest

from service.bus.session import client_config_at, free_endpoint
from viewer.page.learner import Learner
from viewer.page.server import MAX_CLIENTS, Server, foreign, ours, server

PATIENCE = 20.0
AT_ONCE = 200


@pytest.fixture
def page() -> Iterator[Server]:
    """The page of a bus at which nobody listens."""
    endpoint = free_endpoint()
    learner = Learner(client_config_at(endpoint), endpoint, "leng/yaw")
    with server("127.0.0.1", 0, learner, ours("127.0.0.1", ["rov.example.org"])) as served:
        threading.Thread(target=served.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True).start()
        yield served
        served.shutdown()
    learner.close()


def place(page: Server) -> tuple[str, int]:
    return str(page.server_address[0]), int(page.server_address[1])


def answer(page: Server, path: str, **headers: str) -> tuple[int, bytes]:
    connection = HTTPConnection(*place(page), timeout=PATIENCE)
    connection.request("GET", path, headers=headers)
    with connection.getresponse() as found:
        return found.status, found.read()


@pytest.mark.parametrize(
    ("host", "is_ours"),
    [
        ("127.0.0.1:9110", True), ("192.168.2.2", True), ("[::1]:9110", True), ("localhost:9110", True),
        ("LOCALHOST.", True), ("blueos.local:9110", True), ("rov.example.org", True),
        (f"{socket.gethostname()}:1", True),
        ("evil.example.org", False), ("rov.example.org.evil.com", False), ("127.0.0.1.evil.com:9110", False),
        ("evil.com@127.0.0.1", False), ("127.0.0.1@evil.com", False), ("evil.com#.local", False),
        ("evil.com/.local", False),
        ("2130706433", False), ("localhost:9110:80", False), ("", False), ("local", False), ("[::1", False),
    ],
)  # fmt: skip
def test_only_a_browser_that_calls_it_by_its_own_name_is_answered(page: Server, host: str, is_ours: bool) -> None:
    assert (foreign([host], ours("127.0.0.1", ["rov.example.org"])) is None) == is_ours
    for path in ("/", "/state.json"):
        status, said = answer(page, path, Host=host)
        assert status == (200 if is_ours else 403)
        assert is_ours or b"start it with --name NAME" in said


def test_of_two_hosts_none_may_be_foreign() -> None:
    assert foreign(["localhost", "evil.com"], ours("127.0.0.1", [])) == "evil.com"
    assert foreign([], ours("127.0.0.1", [])) is None


def test_a_client_that_breaks_off_leaves_no_trace(page: Server, capfd: pytest.CaptureFixture[str]) -> None:
    requests = (b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n", b"GET /state.json", b"")
    for request in requests:
        with socket.create_connection(place(page)) as client:
            client.sendall(request)
            if request.endswith(b"\r\n\r\n"):
                assert client.recv(100)
            client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # ends with a reset
    emptied(page)
    assert answer(page, "/")[0] == 200
    assert capfd.readouterr().err == ""


def emptied(page: Server) -> None:
    """Returns once the page has no clients."""
    until = time.monotonic() + PATIENCE
    while page.clients:
        assert time.monotonic() < until
        threading.Event().wait(0.01)


def test_many_at_once_beside_many_that_are_silent_are_all_answered(page: Server) -> None:
    with ExitStack() as stack:
        for _ in range(AT_ONCE):
            stack.enter_context(socket.create_connection(place(page), timeout=PATIENCE))
        began = time.monotonic()
        with ThreadPoolExecutor(AT_ONCE) as pool:
            found = list(pool.map(lambda _: answer(page, "/state.json"), range(AT_ONCE)))
        assert [status for status, _ in found] == [200] * AT_ONCE
        assert time.monotonic() - began < PATIENCE / 2


def test_beyond_its_bound_a_client_is_turned_away_until_another_goes(page: Server) -> None:
    with ExitStack() as stack:
        silent = [stack.enter_context(socket.create_connection(place(page), PATIENCE)) for _ in range(MAX_CLIENTS + 1)]
        assert silent[-1].recv(1) == b""
        assert page.clients <= MAX_CLIENTS
    emptied(page)
    assert answer(page, "/")[0] == 200


def test_a_browser_is_told_with_the_page_and_whenever_something_is_new(page: Server) -> None:
    assert b'show({"' in answer(page, "/")[1]
    connection = HTTPConnection(*place(page), timeout=PATIENCE)
    connection.request("GET", "/events")
    with connection.getresponse() as told:
        assert told.headers["Content-Type"] == "text/event-stream"
        state = json.loads(told.readline().removeprefix(b"data: "))
        assert state["away"].startswith("the bus cannot be opened")
        assert told.readline() == b"\n"
        assert told.readline() == b":\n", "nothing is new"
