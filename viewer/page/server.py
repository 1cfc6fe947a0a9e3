"""The page's HTTP server: GET of a few paths; nothing of the vehicle can be changed through it.

Each client has a thread of its own, so that one that is slow or silent holds up no other. A browser keeps one answer
open, on which it is sent what is new (server-sent events).
"""

from __future__ import annotations

import argparse
import ipaddress
import logging
import re
import socket
import sys
import threading
from collections.abc import Iterable, Sequence
from functools import partial
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.metadata import version
from importlib.resources import files
from typing import Any
from urllib.parse import parse_qs, urlsplit

from incsvr.errors import BadInput
from service.bus.session import client_config, stop_event
from service.config.sources import add_config_arguments, from_arguments
from service.wire.json_text import json_text
from viewer.page.learner import Learner

log = logging.getLogger(__name__)

MAX_CLIENTS = 400
"""Connections at a time: a thread each, of some 50 kB. Twice the clients that a page was asked to bear."""
SERVICE = {
    "description": "Learns the vehicle's damping while it moves, and what its model lacks",
    "icon": "mdi-chart-bell-curve-cumulative",
    "company": "incsvr",
    "version": version("incsvr"),
    "new_page": False,
    "webpage": "",
    "api": "",
    "works_in_relative_paths": True,
}
"""What BlueOS asks every web server for, at /register_service, before it shows it in its menu."""


class Handler(BaseHTTPRequestHandler):
    """Answers one request."""

    server_version = "incsvr"
    sys_version = ""
    timeout = 10.0  # a client that sends or takes nothing for so long [s] is cut off

    def __init__(self, *args: Any, learner: Learner, names: frozenset[str], **more: Any) -> None:
        self._learner, self._names = learner, names
        super().__init__(*args, **more)

    def do_GET(self) -> None:
        if foreign(self.headers.get_all("Host", []), self._names) is not None:
            why_not = "the page is not served under this name; call it by its address, or start it with --name NAME"
            self.send_error(HTTPStatus.FORBIDDEN, explain=why_not)
            return
        path, axis = urlsplit(self.path).path, parse_qs(urlsplit(self.path).query).get("axis", [None])[0]
        match path:
            case "/" | "/index.html":
                template, state = files("viewer.page").joinpath("page.html").read_text("utf-8"), self._state(axis)
                # In a script a text that closes it would be read as its end.
                self._send("text/html; charset=utf-8", template.replace("{{ state }}", state.replace("<", "\\u003c")))
            case "/state.json":
                self._send("application/json", self._state(axis))
            case "/events":
                self._events(axis)
            case "/register_service":
                service = SERVICE | {"name": f"{self._learner.words.title} damping"}
                self._send("application/json", json_text(service))
            case _:
                self.send_error(HTTPStatus.NOT_FOUND, "there is no such page")

    def log_message(self, format: str, *args: Any) -> None:
        """Nobody wants to read that all is well."""

    def _events(self, axis: str | None, period_s: float = 1.0) -> None:
        """What the learner says, once and whenever it says something else, until the browser goes."""
        self._head("text/event-stream")
        told = ""
        while True:
            state = self._state(axis)
            self.wfile.write(b":\n\n" if state == told else f"data: {state}\n\n".encode())
            told = state
            self._learner.closed.wait(period_s)
            if self._learner.closed.is_set():
                return

    def _state(self, axis: str | None) -> str:
        return json_text(self._learner.of_axis(axis))

    def _send(self, kind: str, text: str) -> None:
        body = text.encode()
        self._head(kind, ("Content-Length", str(len(body))))
        self.wfile.write(body)

    def _head(self, kind: str, *more: tuple[str, str]) -> None:
        self.send_response(HTTPStatus.OK)
        for name, value in (("Content-Type", kind), ("Cache-Control", "no-store"), *more):
            self.send_header(name, value)
        self.end_headers()


class Server(ThreadingHTTPServer):
    """A bounded number of clients at a time; whoever comes beyond is turned away until one goes."""

    daemon_threads = True
    request_queue_size = MAX_CLIENTS  # that connect in the same moment

    def __init__(self, *args: Any) -> None:
        self.clients = 0
        self._lock = threading.Lock()
        super().__init__(*args)

    def verify_request(self, request: Any, client_address: Any) -> bool:
        """Whether there is room."""
        return self.clients <= MAX_CLIENTS

    def get_request(self) -> tuple[socket.socket, Any]:
        """The next client."""
        accepted = super().get_request()
        with self._lock:
            self.clients += 1
        return accepted

    def shutdown_request(self, request: Any) -> None:
        """A client has gone."""
        with self._lock:
            self.clients -= 1
        super().shutdown_request(request)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A client that breaks off is no error; what is one takes one line."""
        error = sys.exception()
        if not isinstance(error, OSError):
            log.error("the page: a fault of this program: %s: %s", type(error).__name__, error)


def server(host: str, port: int, learner: Learner, names: frozenset[str]) -> Server:
    """A server that listens; `serve_forever` answers.

    Args:
        names: under which browsers may call it, beside addresses (`ours`).

    Raises:
        OSError: the port is taken.
    """
    return Server((host, port), partial(Handler, learner=learner, names=names))


_HOST = re.compile(r"(\[[0-9A-Fa-f:.]+\]|[^\s:/?#@\[\]\\]+)(:\d{1,5})?")


def ours(served_at: str, named: Iterable[str]) -> frozenset[str]:
    """The names that are ours: of this machine, where it is served, and what somebody named."""
    return frozenset(map(_plain, ("localhost", socket.gethostname(), served_at, *named)))


def foreign(hosts: Sequence[str], names: frozenset[str]) -> str | None:
    """The first of the `Host` headers that is not one of ours; None where all are, or none was sent: by no browser."""
    return next((host for host in hosts if not _is_ours(host, names)), None)


def _is_ours(host: str, names: frozenset[str]) -> bool:
    found = _HOST.fullmatch(host.strip())
    if found is None:
        return False
    name = _plain(found[1])
    try:
        ipaddress.ip_address(name.strip("[]"))
    except ValueError:
        return name in names or name.endswith((".local", ".localhost"))
    return True


def _plain(name: str) -> str:
    return name.lower().removesuffix(".")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_config_arguments(parser)
    parser.add_argument("--host", default="127.0.0.1", help="address of the page (default 127.0.0.1)")
    parser.add_argument("--port", type=int, default=9110, help="port of the page; 0 for any (default 9110)")
    parser.add_argument(
        "--name",
        action="append",
        default=[],
        help="further host name of the page, such as rov.example.org; addresses, this machine's name and names in "
        ".local are always served",
    )


def run(args: argparse.Namespace) -> int:
    stop = stop_event()
    config = from_arguments(args)
    where = config.bus.connect or config.bus.listen
    learner = Learner(client_config(config.bus), where, config.prefix, config.axis_asked)
    try:
        served = server(args.host, args.port, learner, ours(args.host, args.name))
    except (OSError, OverflowError) as error:
        raise BadInput(
            f"{args.host}:{args.port} cannot be served at ({error}); name another one with --host and --port"
        ) from None
    host, port = served.server_address[:2]
    print(f"incsvr page: http://{host!s}:{port}/ shows {config.prefix} of {where}", file=sys.stderr, flush=True)
    threading.Thread(target=served.serve_forever, daemon=True).start()
    while not stop.wait(1.0):
        pass
    served.shutdown()
    learner.close()
    served.server_close()
    return 0
