"""The page's HTTP server: GET of a few paths; nothing of the vehicle can be changed through it.

Each client has a thread of its own, so that one that is slow or silent holds up no other. Beyond MAX_CLIENTS the one
that has been silent longest is cut off.
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
from urllib.parse import parse_qs, unquote, urlsplit

from incsvr.errors import BadInput
from service.bus.session import client_config, stop_event
from service.config.sources import add_config_arguments, from_arguments
from service.wire.json_text import json_text
from viewer.page.learner import Learner

log = logging.getLogger(__name__)

MAX_CLIENTS = 400
"""Connections at a time: a thread each, of some 50 kB. Twice the clients that a page was asked to bear."""
MAX_SILENCE_S = 30.0
"""A client that sends or takes nothing for so long [s] is cut off."""
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
    timeout = MAX_SILENCE_S

    def __init__(self, *args: Any, learner: Learner, names: frozenset[str], **more: Any) -> None:
        self._learner, self._names = learner, names
        super().__init__(*args, **more)

    def do_GET(self) -> None:
        if not self._is_for_us():
            return
        path = unquote(urlsplit(self.path).path)
        if path in ("/", "/index.html"):
            self._send("text/html; charset=utf-8", files("viewer.page").joinpath("page.html").read_bytes())
        elif path == "/state.json":
            axis = parse_qs(urlsplit(self.path).query).get("axis", [None])[0]
            self._send("application/json", json_text(self._learner.of_axis(axis)).encode())
        elif path == "/register_service":
            self._send("application/json", json_text(SERVICE | {"name": self._learner.words["title"]}).encode())
        else:
            self.send_error(HTTPStatus.NOT_FOUND, "there is no such page")

    def _is_for_us(self) -> bool:
        """Whether the request calls us by a name of ours; else it is refused."""
        if isinstance(self.server, Server):
            self.server.asked(self.connection)
        host = foreign(self.headers.get_all("Host", []), self._names)
        if host is not None:
            why_not = "the page is not served under this name; call it by its address, or start it with --name NAME"
            self.send_error(HTTPStatus.FORBIDDEN, explain=why_not)
        return host is None

    def log_message(self, format: str, *args: Any) -> None:
        """Once a second and browser nobody wants to read that all is well."""

    def _send(self, kind: str, body: bytes) -> None:
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(body)


class Server(ThreadingHTTPServer):
    """A bounded number of clients at a time."""

    daemon_threads = True
    request_queue_size = MAX_CLIENTS  # that connect in the same moment

    def __init__(self, *args: Any) -> None:
        self._clients: dict[socket.socket, bool] = {}  # in the order in which they came; whether each has asked
        self._lock = threading.Lock()
        super().__init__(*args)

    @property
    def clients(self) -> int:
        """How many are connected."""
        with self._lock:
            return len(self._clients)

    def asked(self, client: socket.socket) -> None:
        """This client has sent its request."""
        with self._lock:
            self._clients[client] = True

    def process_request(self, request: Any, client_address: Any) -> None:
        with self._lock:
            if len(self._clients) >= MAX_CLIENTS:
                silent = (client for client, asked in self._clients.items() if not asked)
                oldest = next(silent, next(iter(self._clients)))
                del self._clients[oldest]
                _cut_off(oldest)
            self._clients[request] = False
        super().process_request(request, client_address)

    def shutdown_request(self, request: Any) -> None:
        with self._lock:
            self._clients.pop(request, None)
        super().shutdown_request(request)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A client that breaks off is no error; what is one takes one line."""
        error = sys.exception()
        if not isinstance(error, OSError):
            log.error("the page: a fault of this program: %s: %s", type(error).__name__, error)


def server(host: str, port: int, learner: Learner, names: frozenset[str]) -> Server:
    """A server that listens; `serve_forever` answers.

    Args:
        names: under which browsers may call it, beside addresses (`hosts.ours`).

    Raises:
        OSError: the port is taken.
    """
    return Server((host, port), partial(Handler, learner=learner, names=names))


def _cut_off(client: socket.socket) -> None:
    """Ends a connection under the thread that waits for it, which then closes it."""
    try:
        client.shutdown(socket.SHUT_RDWR)
    except OSError:
        return  # it has ended by itself


_HOST = re.compile(r"(\[[0-9A-Fa-f:.]+\]|[^\s:/?#@\[\]\\]+)(:\d{1,5})?")


def ours(served_at: str, named: Iterable[str]) -> frozenset[str]:
    """The names that are ours: of this machine, where it is served, and what somebody named."""
    own = socket.gethostname()
    return frozenset(_plain(name) for name in ("localhost", own, served_at, *named))


def foreign(hosts: Sequence[str], names: frozenset[str]) -> str | None:
    """The first of the `Host` headers that is not one of ours; None where all are, or none was sent: by no browser."""
    return next((host for host in hosts if not _is_ours(host, names)), None)


def _is_ours(host: str, names: frozenset[str]) -> bool:
    found = _HOST.fullmatch(host.strip())
    if found is None:
        return False
    name = _plain(found[1])
    return name in names or name.endswith((".local", ".localhost")) or _is_address(name.strip("[]"))


def _is_address(text: str) -> bool:
    try:
        ipaddress.ip_address(text)
    except ValueError:
        return False
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
    answering = threading.Thread(target=served.serve_forever, daemon=True)
    answering.start()
    while not stop.wait(1.0):
        pass
    served.shutdown()
    served.server_close()
    learner.close()
    return 0
